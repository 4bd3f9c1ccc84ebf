"""Cycles without rest: every slide starts where the one before it, in the other direction, ends."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.harmonic.slides import distance, rates, slides
from vibro.core.harmonic.waves import TURN, harmonics, values, wrapped

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.core.harmonic.slides import Lanes

    Floats = NDArray[np.float64]
    Bools = NDArray[np.bool_]
    Indices = NDArray[np.intp]

__all__ = ["Restless", "restless_cycles"]

_MOST_STEPS: Final = 10
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
    Newton's method on the starts p_j. That the slide from p_j has no speed left at p_(j+1) links a start to
    the next alone; once round, the shift of the first is a linear function of itself, whose slope is the
    product of load beyond friction at the starts over that at the ends: below 1. Where friction is small it
    is near 1, and what the drive does to the speed must cancel over a cycle to rounding of the friction: it
    is the difference of one antiderivative between the starts. A last shift, too small for the rounded
    phases, goes into the paths.
    """
    m, n = lane.shape
    scenes = at.noise.size // 2
    ahead, behind = (at.kinetic.take(lane[0] % scenes + x, axis=1) for x in (0, scenes))
    drive, drag = 0.5 * (ahead - behind), 0.5 * (ahead + behind)
    ways = np.where(lane < scenes, 1.0, -1.0)
    phase = start[0] + np.concatenate([np.zeros((1, n)), np.cumsum(wrapped(np.diff(start, axis=0)), axis=0)])
    step = np.full(n, np.inf)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        for _ in range(_MOST_STEPS):
            nodes = harmonics(phase, ahead.shape[0] // 2)
            load, impulse = _load_and_impulse(drive, nodes)
            brake, slowing = _load_and_impulse(drag, nodes)
            length = _next(phase) - phase
            length[-1] += TURN
            left = ways * (_next(impulse) - impulse + drive[0] * length) + (
                _next(slowing) - slowing + drag[0] * length
            )
            pull = ways * load + brake  # at the starts
            push = ways * _next(load) + _next(brake)  # at the ends
            offset, slope = np.zeros(n), np.ones(n)  # shift of a start = offset + slope * shift of the first
            shifts = []
            for j in range(m):
                shifts.append((offset, slope))
                offset = (pull[j] * offset - left[j]) / push[j]
                slope = pull[j] * slope / push[j]
            first = offset / (1.0 - slope)
            moves = np.array([offset + slope * first for offset, slope in shifts])
            step = np.abs(moves).max(axis=0)
            if np.count_nonzero(step > _SETTLED) == 0:
                break
            phase = phase + np.where(np.isfinite(moves) & (step > _SETTLED), moves, 0.0)
        found = wrapped(phase + moves)
        flat = lane.reshape(-1)
        load = values(at.static.take(flat, axis=1), found.reshape(-1)).reshape(m, n)
        noise = at.noise[flat].reshape(m, n)
        right = (step <= _SETTLED) & (load >= -noise).all(axis=0)
        out = Restless._make((found, *np.zeros((3, m, n)), *np.zeros((2, n), np.bool_)))
        own = right.nonzero()[0]
        if not own.size:
            return out
        flat, begun = lane[:, own].reshape(-1), found[:, own].reshape(-1)
        slid = slides(at, flat, begun, np.full(flat.size, np.nan))
        ends = slid.length.reshape(m, own.size)
        miss = wrapped(found[:, own] + ends - _next(found[:, own]) + np.pi) - np.pi
        length, left, pull, moves = (x.take(own, axis=1) for x in (length, left, pull, moves))
        path = distance(length.reshape(-1), rates(at.kinetic.take(flat, axis=1), phase[:, own].reshape(-1)))
        out.length[:, own], out.peak[:, own] = ends, slid.peak.reshape(m, own.size)
        out.path[:, own] = path.reshape(m, own.size) + length * (0.5 * left - pull * moves)
        valid = slid.settled.reshape(m, own.size).all(axis=0) & (load[:, own] > noise[:, own]).all(axis=0)
        valid &= (np.abs(miss) < _CLOSED).all(axis=0) & (np.abs(ends.sum(axis=0) - TURN) < _CLOSED)
    out.valid[own] = valid
    near = (np.abs(load[:, own]) <= noise[:, own]).any(axis=0)
    edge = slid.edge.reshape(m, own.size).any(axis=0) | near
    out.edge[own] = valid & edge
    return out


def _next(of_slides: Floats) -> Floats:
    """Values at the next starts."""
    return np.concatenate([of_slides[1:], of_slides[:1]])


def _load_and_impulse(waves: Floats, nodes: list[tuple[Floats, Floats]]) -> tuple[Floats, Floats]:
    """Waves at phases, and their antiderivatives but for the constant's."""
    h = len(nodes)
    load, impulse = waves[0] + np.zeros(nodes[0][0].shape), np.zeros(nodes[0][0].shape)
    for n, (s, c) in enumerate(nodes, 1):
        load += waves[n] * s + waves[h + n] * c
        impulse += (waves[h + n] * s - waves[n] * c) / n
    return load, impulse
