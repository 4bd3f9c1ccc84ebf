"""Bodies of a box that stand where the speed drops: just beyond the entry of back slip."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.inverse.boxes import Box, Points

    Floats = NDArray[np.float64]

__all__ = ["with_jumps"]

_BESIDE: Final = 1e-9  # relative distance from a friction at which back slip enters
_STATIC: Final = 3  # of AXES
_KINETIC: Final = 4


def with_jumps(box: Box, shares: Floats) -> Floats:
    """Add bodies that differ from others by their friction alone, and have just begun to slip back.

    Where they are in the box moves with the load, so that no share of a band stands for them.

    Parameters
    ----------
    box : Box
        m boxes, with ends of shape (m, 1).
    shares : (5, n) array
        Bodies, as shares of the bands.

    Returns
    -------
    (5, m, 3 n) array
        The bodies, those with the static friction at which the load reaches back slip, and those with the
        kinetic friction at which the forward slide no longer outlasts the back window; the bodies again
        where these are not in the bands.
    """
    points = box.points(shares[:, None, :])
    whole = np.broadcast_to(shares[:, None, :], (len(shares), *points.load.shape))
    static, kinetic = whole.copy(), whole.copy()
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        entry = _static_entry(points) * (1.0 - _BESIDE)
        _replace(static[_STATIC], entry, *box.static_span)
        entry = _kinetic_entry(points) * (1.0 + _BESIDE)
        _replace(kinetic[_KINETIC], entry, *box.kinetic_span(points.static_friction))
    return np.concatenate([whole, static, kinetic], axis=2)


def _replace(share: Floats, friction: Floats, low: Floats, high: Floats) -> None:
    """Replace shares in place by those of frictions within a band."""
    new = (friction - low) / (high - low)
    np.copyto(share, new, where=(new > 0.0) & (new < 1.0))


def _static_entry(at: Points) -> Floats:
    """Return the static friction at which the load of a body at rest reaches back slip, Eq. (5)."""
    return (at.load * np.cos(at.drive_angle) + np.sin(at.trough_angle)) / (
        np.cos(at.trough_angle) + at.load * np.sin(at.drive_angle)
    )


def _kinetic_entry(at: Points) -> Floats:
    """Return the kinetic friction at which the forward slide ends as the back window closes, Eq. (22)."""
    along, across = np.cos(at.drive_angle), np.sin(at.drive_angle)
    normal, tangential = np.cos(at.trough_angle), np.sin(at.trough_angle)
    hold, lift = at.static_friction * normal, at.static_friction * across
    s_f = (hold + tangential) / (along + lift) / at.load
    s_b = (hold - tangential) / (along - lift) / at.load
    cosines = np.sqrt((1.0 - s_f) * (1.0 + s_f)) + np.sqrt((1.0 - s_b) * (1.0 + s_b))
    k = (s_b - s_f) * (s_b + s_f) / cosines / (np.pi + np.arccos(s_f) + np.arccos(s_b))
    resistance = k * at.load  # (mu_d n + t) / (a + mu_d b)
    return np.asarray((resistance * along - tangential) / (normal - resistance * across))
