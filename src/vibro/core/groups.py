"""Dimensionless groups of a scene: everything that decides its motion, up to the scales A and A w."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

__all__ = [
    "Lead", "Loads", "angle_excess", "cosine_of_sum", "each", "elliptical_loads", "friction_excess",
    "largest_amplitude", "loads", "mirrored", "put", "take", "unit_loads", "weight_over_load",
]  # fmt: skip

# [1] Range of 1/G in which no product of it overflows or vanishes; the body rests, or leaves, long before.
_LEAST_GRAVITY: Final = 1e-307
_MOST_GRAVITY: Final = 1e307


_NO_CONTRAST: Final = np.full((), np.nan)


class Lead(NamedTuple):
    """Sine and cosine of the phase phi by which the normal motion leads the motion along the trough."""

    sine: Floats
    cosine: Floats

    @property
    def angle(self) -> Floats:
        """Phi, in [-pi, pi]."""
        return np.asarray(np.arctan2(self.sine, self.cosine))


class Loads(NamedTuple):
    """Loads on the body over the inertial load m A w^2; the fields broadcast against each other.

    Phases are those of the trough's motion normal to itself, which leads its motion along itself by phi: the
    inertial load off the trough is ``across * sin(p)``, that along it ``along * sin(p - phi)``. So lift-off
    and flights do not depend on phi.

    Attributes
    ----------
    along, across : array
        Inertial load along the trough and off it: cos(alpha) and sin(alpha) of a drive along a line; of an
        elliptical one X/A and Y/A, where A is the larger of its amplitudes X and Y.
    normal, tangential : array
        cos(beta)/G and sin(beta)/G: weight on the trough and down it, G = A w^2 / g.
    contrast : array
        cos(alpha + beta)/G = along * normal - across * tangential, of which it has no cancellation; NaN of
        elliptical drives, which do not need it.
    static_friction, kinetic_friction : array
        mu_s and mu_d.
    lead : Lead, or None
        phi of elliptical drives; None where all drives move along lines, whose formulas are shorter.
    """

    along: Floats
    across: Floats
    normal: Floats
    tangential: Floats
    contrast: Floats
    static_friction: Floats
    kinetic_friction: Floats
    lead: Lead | None = None

    @property
    def infeasible(self) -> NDArray[np.bool_]:
        """Whether a combination cannot be: mu_d > mu_s, or a line's drive + trough angle >= 90 deg."""
        friction = friction_excess(self.static_friction, self.kinetic_friction) > 0.0
        return np.asarray(friction if self.lead else friction | (self.contrast <= 0.0))

    def flattened(self) -> tuple[Floats, ...]:
        """Return all arrays one after the other."""
        return (
            self.along, self.across, self.normal, self.tangential, self.contrast, self.static_friction,
            self.kinetic_friction, *(self.lead or ()),
        )  # fmt: skip

    def along_sine(self, phase: Floats) -> Floats:
        """Sine of the motion along the trough, at a phase of the normal motion."""
        return np.asarray(np.sin(phase - self.lead.angle if self.lead else phase))

    def along_cosine(self, phase: Floats) -> Floats:
        """Cosine of the motion along the trough, at a phase of the normal motion."""
        return np.asarray(np.cos(phase - self.lead.angle if self.lead else phase))


def mirrored(scene: Loads) -> Loads:
    """Look at elliptical drives from the other side: a half turn more of phase, and the slope turned."""
    assert scene.lead is not None
    turned = Lead(-scene.lead.sine, -scene.lead.cosine)
    return scene._replace(tangential=-scene.tangential, lead=turned)


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
    weight = weight_over_load(amplitude, frequency, gravity)
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


def elliptical_loads(
    along_amplitude: Floats,
    normal_amplitude: Floats,
    normal_phase: Floats,
    frequency: Floats,
    static_friction: Floats,
    kinetic_friction: Floats,
    trough_angle: Floats,
    gravity: Floats,
) -> Loads:
    """Form the groups of elliptical drives, in SI units and radians; their scale is ``largest_amplitude``."""
    scale = largest_amplitude(along_amplitude, normal_amplitude)
    weight = weight_over_load(scale, frequency, gravity)
    along, across = along_amplitude / scale, normal_amplitude / scale
    tangential = weight * np.sin(trough_angle) if np.count_nonzero(trough_angle) else np.zeros(())
    normal = weight * np.cos(trough_angle)
    half = np.tan(0.5 * normal_phase)  # a tenth of the time of a sine and a cosine
    scale = 1.0 / (1.0 + half * half)
    lead = Lead(2.0 * half * scale, (1.0 - half) * (1.0 + half) * scale)
    return Loads(
        along=along,
        across=across,
        normal=normal,
        tangential=tangential,
        contrast=_NO_CONTRAST,
        static_friction=static_friction,
        kinetic_friction=kinetic_friction,
        lead=lead,
    )


def largest_amplitude(first: Floats, *others: Floats) -> Floats:
    """Scale of the lengths of a drive with several amplitudes; 1 where the trough stands still [m]."""
    largest = first
    for amplitude in others:
        largest = np.maximum(largest, amplitude)
    return largest if np.all(largest) else np.where(largest > 0.0, largest, 1.0)


def weight_over_load(amplitude: Floats, frequency: Floats, gravity: Floats) -> Floats:
    """1/G, within the range whose products neither overflow nor vanish."""
    with np.errstate(over="ignore", divide="ignore"):
        w = 2.0 * np.pi * frequency
        return np.asarray((gravity / w / amplitude / w).clip(_LEAST_GRAVITY, _MOST_GRAVITY))


def unit_loads(
    drive_angle: Floats, static_friction: Floats, kinetic_friction: Floats, trough_angle: Floats
) -> Loads:
    """Form the groups of drives along a line at G = 1."""
    return Loads(
        np.cos(drive_angle),
        np.sin(drive_angle),
        np.cos(trough_angle),
        np.sin(trough_angle),
        cosine_of_sum(drive_angle, trough_angle),
        static_friction,
        kinetic_friction,
    )


def cosine_of_sum(drive_angle: Floats, trough_angle: Floats) -> Floats:
    """cos(alpha + beta); 0 from 90 deg on, where the double next to it still has a positive cosine."""
    excess = angle_excess(drive_angle, trough_angle)
    return np.where(excess < 0.0, np.cos(drive_angle + trough_angle), 0.0)


def take(group: Any, cells: NDArray[np.intp]) -> Any:
    """Select cells of a nested (named) tuple of arrays by index; 0-d members serve every cell."""
    if not isinstance(group, tuple):
        return group.take(cells) if group is not None and group.ndim else group
    members = [
        member.take(cells) if isinstance(member, np.ndarray) and member.ndim else take(member, cells)
        for member in group
    ]
    return group._make(members) if hasattr(group, "_make") else tuple(members)


def each(group: Any, change: Callable[[NDArray[Any]], NDArray[Any]]) -> Any:
    """Change every array of a nested (named) tuple of arrays; None stays what it is."""
    if not isinstance(group, tuple):
        return None if group is None else change(group)
    members = [each(member, change) for member in group]
    return group._make(members) if hasattr(group, "_make") else tuple(members)


def put(group: tuple[Any, ...], cells: NDArray[np.intp], values: tuple[Any, ...]) -> None:
    """Write the selected cells of a tuple of arrays, the inverse of ``take``."""
    for target, source in zip(group, values, strict=True):
        target[cells] = source
