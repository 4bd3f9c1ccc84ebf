"""Cycles without rest: every slide starts where the one before it, in the other direction, ends."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.harmonic.slides import rates, slides, velocity
from vibro.core.harmonic.waves import TURN, values

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.core.harmonic.slides import Lanes

    Floats = NDArray[np.float64]
    Bools = NDArray[np.bool_]
    Indices = NDArray[np.intp]

__all__ = ["Restless", "restless_cycles"]

_MOST_STEPS: Final = 12
# [rad] The last Newton step leaves rounding errors if it is smaller than this.
_SETTLED: Final = 1e-8
# [rad] Slides that are followed from the starts that were found end where the next ones start.
_CLOSED: Final = 1e-9


class Restless(NamedTuple):
    """Cycles without rest, with their slides in rows in the order of time.

    Attributes
    ----------
    start, length, path, peak : array
        Phase at the start and until the end, distance and largest speed.
    valid : bool array
        Whether each slide stops where the next one starts, and starts where the load exceeds static friction.
    edge : bool array
        Whether rounding decides it.
    """

    start: Floats
    length: Floats
    path: Floats
    peak: Floats
    valid: Bools
    edge: Bools


def restless_cycles(at: Lanes, lane: Indices, start: Floats) -> Restless:
    """Solve cycles without rest.

    Parameters
    ----------
    at : Lanes
        Scenes.
    lane : int array
        Columns of the slides, an even number of rows in the order of time, forward and back in turn.
    start : array
        Estimates of the phases at which they start.

    Notes
    -----
    Newton's method on the starts. That the slide from p_j has no speed left at p_(j+1) links a start to the next
    alone; once round, the shift of the first is a linear function of itself, whose slope is the product of load
    beyond friction at the starts over that at the ends: below 1.
    """
    m, n = lane.shape
    waves = [at.kinetic[:, of_slide] for of_slide in lane]
    phase = np.mod(start, TURN)
    step = np.full(n, np.inf)
    for _ in range(_MOST_STEPS):
        offset, slope = np.zeros(n), np.ones(n)  # shift of a start = offset + slope * shift of the first
        shifts = [(offset, slope)]
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            for j in range(m):
                length = np.mod(phase[(j + 1) % m] - phase[j], TURN)
                own = rates(waves[j], phase[j])
                left, brake = velocity(length, own)
                offset = -(left - own[0] * offset) / brake
                slope = own[0] * slope / brake
                shifts.append((offset, slope))
            first = offset / (1.0 - slope)
            moves = np.array([offset + slope * first for offset, slope in shifts[:-1]])
            step = np.abs(moves).max(axis=0)
            phase = np.mod(phase + np.where(np.isfinite(moves), moves, 0.0), TURN)
        if not np.count_nonzero(step > _SETTLED):
            break
    unknown = np.full(lane.size, np.nan)
    slid = slides(at, lane.reshape(-1), phase.reshape(-1), unknown)
    length, path, peak = (x.reshape(m, n) for x in (slid.length, slid.path, slid.peak))
    with np.errstate(invalid="ignore"):
        miss = np.mod(phase + length - np.roll(phase, -1, axis=0) + np.pi, TURN) - np.pi
        turns = length.sum(axis=0)
    flat = lane.reshape(-1)
    load = values(at.static[:, flat], phase.reshape(-1)).reshape(m, n)
    noise = at.noise[flat].reshape(m, n)
    valid = (step <= _SETTLED) & slid.settled.reshape(m, n).all(axis=0)
    valid &= (np.abs(miss) < _CLOSED).all(axis=0) & (np.abs(turns - TURN) < 1e-6)
    edge = (np.abs(load) <= noise).any(axis=0) & valid
    valid &= (load > noise).all(axis=0)
    return Restless(phase, length, path, peak, valid, (slid.edge.reshape(m, n).any(axis=0) & valid) | edge)
