"""Differential evolution: the slowest body of a box, by a population of bodies that moves towards it.

Storn and Price, J. Global Optim. 11 (1997) 341, the scheme best/1/bin with a weight drawn anew for every
generation.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from vibro.core.boxes import AXES, Box, speed_at
from vibro.core.buffers import Doubles
from vibro.core.elementary import INF

__all__ = ["Population", "evolve"]

_OVERHANG: Final = 0.1  # [share of a band] trial points so far outside go to its end, where optima often are
_LEAST_WEIGHT: Final = 0.5
_MORE_WEIGHT: Final = 0.5
_CROSSING: Final = 0.7  # share of the coordinates that a trial takes from the mutant
_SETTLED: Final = 1e-12  # relative spread of the speeds at which the search ends
# The least standard generator of Park and Miller, Comm. ACM 31 (1988) 1192.
_FACTOR: Final = 16807
_MODULUS: Final = 2147483647


class Population(NamedTuple):
    """Bodies of a box.

    Attributes
    ----------
    points : Doubles
        ``AXES`` numbers a body; room for one more.
    speeds : Doubles
        Of each [m/s].
    """

    points: Doubles
    speeds: Doubles


def evolve(box: Box, out: Population, size: int, generations: int, seed: int) -> int:
    """Move a population, whose points are given, to the slowest body; return which of them that is."""
    state, best = seed, 0
    for i in range(size):
        out.speeds[i] = _counted(box, out.points, AXES * i)
        if out.speeds[i] < out.speeds[best]:
            best = i
    for _ in range(generations):
        if _is_settled(out, size, best):
            break
        state = _FACTOR * state % _MODULUS
        weight = _LEAST_WEIGHT + _MORE_WEIGHT * state / _MODULUS
        for i in range(size):
            state = _try(box, out, size, i, best, weight, state)
            if out.speeds[size] <= out.speeds[i]:
                out.speeds[i] = out.speeds[size]
                for axis in range(AXES):
                    out.points[AXES * i + axis] = out.points[AXES * size + axis]
                if out.speeds[i] < out.speeds[best]:
                    best = i
    return best


def _counted(box: Box, points: Doubles, row: int) -> float:
    """Return the speed of a body, inf where it is unknown."""
    speed = speed_at(box, points, row)
    return INF if math.isnan(speed) else speed


def _is_settled(out: Population, size: int, best: int) -> bool:
    """Whether all speeds are those of the slowest body, or none can be lower."""
    if out.speeds[best] == -INF:
        return True
    most = out.speeds[0]
    for i in range(1, size):
        most = max(most, out.speeds[i])
    return most <= out.speeds[best] + _SETTLED * abs(out.speeds[best])


def _try(box: Box, out: Population, size: int, i: int, best: int, weight: float, state: int) -> int:
    """Cross a body with a mutant of the slowest one, behind the last row; return the generator's state."""
    state = _FACTOR * state % _MODULUS
    one = state % size
    state = _FACTOR * state % _MODULUS
    two = (one + 1 + state % (size - 1)) % size  # another one: without a difference all become the slowest
    state = _FACTOR * state % _MODULUS
    sure = state % AXES  # which coordinate is taken in any case
    for axis in range(AXES):
        low, high = box.low[axis], box.high[axis]
        state = _FACTOR * state % _MODULUS
        value = out.points[AXES * i + axis]
        if high > low and (axis == sure or state < _CROSSING * _MODULUS):
            apart = out.points[AXES * one + axis] - out.points[AXES * two + axis]
            value = out.points[AXES * best + axis] + weight * apart
            beyond = _OVERHANG * (high - low)
            if value < low - beyond or value > high + beyond:
                state = _FACTOR * state % _MODULUS
                value = low + (high - low) * state / _MODULUS
            value = min(max(value, low), high)
        out.points[AXES * size + axis] = value
    out.speeds[size] = _counted(box, out.points, AXES * size)
    return state
