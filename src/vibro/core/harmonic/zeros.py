"""Zeros of smooth functions, one in each bracket, by Halley's method."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Bools = NDArray[np.bool_]
    Indices = NDArray[np.intp]
    #: Values and two derivatives at points, one per column of an array that is handed on.
    Function = Callable[[Floats, Floats], tuple[Floats, Floats, Floats]]

__all__ = ["FINE", "ROUGH", "Tolerance", "level_start", "zeros"]

_MOST_STEPS: Final = 80  # halvings from a turn down to an ulp, and a few more


class Tolerance(NamedTuple):
    """What the last step of Halley's method may be, over the unit.

    Attributes
    ----------
    step : float
        A Newton step below this leaves an error of its square over the distance from the next turning point,
        and that is what is to be reached: the conditioning is one over that distance, too.
    long_step, bend : float
        So does a step below this whose correction for the bend is below that share of it.
    """

    step: float
    long_step: float
    bend: float


FINE: Final = Tolerance(3e-9, 1e-6, 1e-5)
# Where waves or speeds turn need not be known so well: their values there change with the square of an error.
ROUGH: Final = Tolerance(1e-5, 3e-4, 1e-3)


def zeros(
    function: Function,
    group: Floats,
    start: Floats,
    low: Floats,
    high: Floats,
    falls: Bools,
    unit: Floats | float = 1.0,
    tolerance: Tolerance = FINE,
) -> tuple[Floats, Bools]:
    """Find where functions change their sign, by Halley's method inside their brackets.

    Parameters
    ----------
    function : callable
        Of points and of their columns of ``group``.
    group : array
        What belongs to each bracket, one column each.
    start, low, high : array
        First estimates, and brackets.
    falls : bool array
        Whether a function is positive at the low end, not at the high one.
    unit : array or float, optional
        Lengths beside which the last step must be small.
    tolerance : Tolerance, optional
        How small.

    Returns
    -------
    zeros : array
        One each.
    settled : bool array
        Whether the iteration ended.

    Notes
    -----
    A step out of the bracket is replaced by halving it.
    """
    found, settled = np.empty(start.shape), np.zeros(start.shape, np.bool_)
    unit = np.broadcast_to(np.asarray(unit), start.shape)
    open_: Indices = np.arange(start.size)
    x, own = start, group
    for _ in range(_MOST_STEPS):
        if not open_.size:
            break
        value, slope, bend = function(x, own)
        before = (value > 0.0) == falls
        low, high = np.where(before, x, low), np.where(before, high, x)
        with np.errstate(divide="ignore", invalid="ignore"):
            step = value / slope
            bent = 0.5 * step * bend / slope
            step /= 1.0 - bent
        x = x - step
        straight = np.abs(bent) <= tolerance.bend
        close = np.abs(step) <= np.where(straight, tolerance.long_step, tolerance.step) * unit
        outside = (~((x >= low) & (x <= high))).nonzero()[0]
        if outside.size:  # a last step may leave the bracket by rounding
            bottom, top = low[outside], high[outside]
            middle = 0.5 * (bottom + top)
            x[outside] = np.where(close[outside], x[outside].clip(bottom, top), middle)
            close[outside] |= top - bottom <= 4e-16 * np.abs(middle)
        found[open_] = x
        settled[open_] = close
        going = (~close).nonzero()[0]
        if going.size < x.size:
            open_, falls, own = open_[going], falls[going], own.take(going, axis=1)
            x, low, high, unit = x[going], low[going], high[going], unit[going]
    return found, settled


def level_start(low: Floats, high: Floats, at_low: Floats, at_high: Floats) -> Floats:
    """Zeros of the cubics that are level at both ends, where they have opposite values."""
    share = np.clip((at_low + at_high) / (at_low - at_high), -1.0, 1.0)  # 1 - 2 at_low / (at_low - at_high)
    return np.asarray(low + (high - low) * (0.5 + np.sin(np.arcsin(share) / 3.0)))
