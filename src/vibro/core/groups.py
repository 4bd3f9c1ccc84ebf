"""Dimensionless groups of a scene: everything that decides its motion, up to the scales A and A w."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

__all__ = ["Loads", "angle_excess", "cosine_of_sum", "friction_excess", "loads", "put", "take"]

# [1] Range of 1/G in which no product of it overflows or vanishes; the body rests, or leaves, long before.
_LEAST_GRAVITY: Final = 1e-307
_MOST_GRAVITY: Final = 1e307


class Loads(NamedTuple):
    """Loads on the body over its peak inertial load m A w^2; the fields broadcast against each other.

    Attributes
    ----------
    along, across : array
        cos(alpha) and sin(alpha): inertial load along the trough and off it.
    normal, tangential : array
        cos(beta)/G and sin(beta)/G: weight on the trough and down it, G = A w^2 / g.
    contrast : array
        cos(alpha + beta)/G = along * normal - across * tangential, of which it has no cancellation.
    static_friction, kinetic_friction : array
        mu_s and mu_d.
    """

    along: Floats
    across: Floats
    normal: Floats
    tangential: Floats
    contrast: Floats
    static_friction: Floats
    kinetic_friction: Floats

    @property
    def infeasible(self) -> NDArray[np.bool_]:
        """Whether a combination cannot be: mu_d > mu_s, or drive + trough angle of 90 deg or more."""
        friction = friction_excess(self.static_friction, self.kinetic_friction) > 0.0
        return np.asarray(friction | (self.contrast <= 0.0))


def friction_excess(static_friction: Floats, kinetic_friction: Floats) -> Floats:
    """Kinetic over static friction: a combination with more than 0 cannot be."""
    return kinetic_friction - static_friction


def angle_excess(drive_angle: Floats, trough_angle: Floats) -> Floats:
    """Drive + trough angle over 90 deg: a combination with 0 or more cannot be [rad]."""
    return drive_angle + trough_angle - 0.5 * np.pi


def loads(
    amplitude: Floats,
    frequency: Floats,
    drive_angle: Floats,
    static_friction: Floats,
    kinetic_friction: Floats,
    trough_angle: Floats,
    gravity: Floats,
) -> Loads:
    """Form the groups, Eq. (1), in SI units and radians; nothing is broadcast before it must be.

    1/G rather than G is formed, from factors that stay finite when A, f or G are extreme.
    """
    with np.errstate(over="ignore", divide="ignore"):
        w = 2.0 * np.pi * frequency
        weight = (gravity / w / amplitude / w).clip(_LEAST_GRAVITY, _MOST_GRAVITY)  # 1/G
    along, across = np.cos(drive_angle), np.sin(drive_angle)
    if not np.count_nonzero(trough_angle):
        level = np.zeros(())
        return Loads(along, across, weight, level, weight * along, static_friction, kinetic_friction)
    return Loads(
        along=along,
        across=across,
        normal=weight * np.cos(trough_angle),
        tangential=weight * np.sin(trough_angle),
        contrast=weight * cosine_of_sum(drive_angle, trough_angle),
        static_friction=static_friction,
        kinetic_friction=kinetic_friction,
    )


def cosine_of_sum(drive_angle: Floats, trough_angle: Floats) -> Floats:
    """cos(alpha + beta); 0 from 90 deg on, where the double next to it still has a positive cosine."""
    excess = angle_excess(drive_angle, trough_angle)
    return np.where(excess < 0.0, np.cos(drive_angle + trough_angle), 0.0)


def take(group: Any, cells: NDArray[np.intp]) -> Any:
    """Select cells of a nested (named) tuple of arrays by index; 0-d members serve every cell."""
    if not isinstance(group, tuple):
        return group.take(cells) if group.ndim else group
    members = [
        take(member, cells) if isinstance(member, tuple) else member.take(cells) if member.ndim else member
        for member in group
    ]
    return group._make(members) if hasattr(group, "_make") else tuple(members)


def put(group: tuple[Any, ...], cells: NDArray[np.intp], values: tuple[Any, ...]) -> None:
    """Write the selected cells of a tuple of arrays, the inverse of ``take``."""
    for target, source in zip(group, values, strict=True):
        target[cells] = source
