"""The motion between two events: under a pull that swings with the drive and a constant drag."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from vibro.core.series import polynomial

if TYPE_CHECKING:
    from vibro.core.series import Floats

__all__ = ["GAP", "free_motion"]

# s - sin s loses digits where s is small. Up to s = 1 it is s^3 times this polynomial in s^2, highest power
# first (error below 6e-18 of the value, tests/core/test_series.py); beyond, the difference is good to 4 ulp.
GAP: Final = (
    7.54937170418124304e-13, -1.60577019225797864e-10, 2.50520992449141141e-08,
    -2.75573191920112204e-06, 0.000198412698412165663, -0.00833333333333330026, 0.166666666666666657,
)  # fmt: skip


def free_motion(
    pull: Floats, drag: Floats, sine: Floats, cosine: Floats, velocity: Floats, s: Floats
) -> tuple[Floats, Floats]:
    """Path and velocity under x'' = pull sin p - drag, a phase s after the start, Eq. (40).

    Slides, flights along the trough and flights off it differ in pull and drag alone.

    Parameters
    ----------
    pull, drag : array
        Amplitude of the load along the motion, and constant load against it.
    sine, cosine : array
        Of the phase at the start.
    velocity : array
        At the start.
    s : array
        Phase since then, >= 0 [rad].

    Returns
    -------
    path, velocity : array
        To rounding of their terms, however short the motion is.
    """
    t = np.tan(0.5 * s)
    rise = 2.0 * t / (1.0 + t * t)  # sin s
    versine = rise * t
    gap = s - rise
    short = s < 1.0
    if np.count_nonzero(short):
        y = np.minimum(s * s, 1.0)
        np.copyto(gap, polynomial(y, GAP) * y * s, where=short)
    fall = drag * s
    path = s * (velocity - 0.5 * fall) + pull * (sine * versine + cosine * gap)
    return path, velocity + pull * (cosine * versine + sine * rise) - fall
