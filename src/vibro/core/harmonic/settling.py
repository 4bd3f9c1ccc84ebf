"""Which cycle a body settles into: the nearest one on the side to which its velocity changes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.harmonic.cycle import (
    Bodies,
    Cycles,
    Start,
    Track,
    follow,
    from_onsets,
    near_cycles,
    no_cycles,
    onsets_of,
    read,
    signs,
    stopped,
    without_rest,
    write,
)
from vibro.core.harmonic.waves import values

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.core.harmonic.slides import Lanes

    Floats = NDArray[np.float64]
    Bools = NDArray[np.bool_]
    Indices = NDArray[np.intp]

__all__ = ["Settled", "settle"]

# Slides a harmonic that are followed before cycles are looked for elsewhere.
_FEW_SLIDES: Final = 5
# A body that has not settled after so many slides is given up.
_MOST_SLIDES: Final = 200
# How often a cycle without rest is looked for further on.
_LEAPS: Final = 4


class Settled(NamedTuple):
    """Steady cycles of bodies.

    Attributes
    ----------
    cycles : Cycles
        Without a slide where there is none.
    endless : int array
        Lane of the slide that never ends; -1 where all end.
    edge : bool array
        Whether rounding decided something on the way.
    """

    cycles: Cycles
    endless: Indices
    edge: Bools


def settle(at: Lanes, cell: Indices, begun: Start) -> Settled:
    """Find the cycles that bodies settle into.

    Parameters
    ----------
    at : Lanes
        Scenes.
    cell : int array
        That of each body.
    begun : Start
        Their first slides.

    Notes
    -----
    Trajectories do not cross. So a body's velocity at a given phase rises, or falls, from cycle to cycle, and tends
    to the nearest fixed point on that side. If it does not rest for a whole cycle, that is either the one cycle
    without rest or a cycle with one. A cycle that rests before an onset, where it has no velocity, lies between two
    others only if these pass the onset in different directions.
    """
    count, h = cell.size, at.onset.shape[0]
    track, out = Track(count, h), no_cycles(count, 2 * h)
    track.edge |= begun.edge
    bodies = Bodies(np.arange(count), cell, begun, np.zeros(count), np.zeros(count, np.intp))
    few = _FEW_SLIDES * h
    for k in range(_MOST_SLIDES):
        bodies = follow(at, bodies, track, out, range(k, k + 1))
        if not bodies.number.size:
            break
        if k < few or k % (2 * h) == 0:
            near = near_cycles(bodies, track, k + 1)
            tried = (near > 0).nonzero()[0]
            if tried.size:
                bodies = _nearest_without_rest(at, bodies, track, out, k + 1, tried, near[tried])
        if k >= few and k % (2 * h) == 0 and bodies.number.size:
            bodies = _nearest(at, bodies, track, out, k + 1)
        if not bodies.number.size:
            break
    return Settled(out, track.endless, track.edge)


def _side(at: Lanes, orbit: Cycles, bodies: Bodies) -> NDArray[np.int8]:
    """Direction in which the velocity of bodies without rest changes: +1 where it rises.

    A forward slide that starts later than a cycle before is slower.
    """
    forward = np.where(orbit.lane[0] < at.noise.size // 2, 1.0, -1.0)
    later = np.mod(bodies.now.phase - orbit.start[0] + np.pi, 2.0 * np.pi) - np.pi
    return np.sign(-forward * later).astype(np.int8)


def _nearest_without_rest(
    at: Lanes, bodies: Bodies, track: Track, out: Cycles, k: int, tried: Indices, near: Indices
) -> Bodies:
    """Settle bodies that tend to the cycle without rest, with nothing in between; return the others."""
    some = bodies.some(tried)
    orbit = track.cut(some.number, k - near, near)
    found, valid, edge = without_rest(at, orbit)
    good = valid & _is_next(at, some, orbit, found)
    done = good.nonzero()[0]
    write(out, some.number[done], read(found, done))
    track.edge[some.number[done]] |= edge[done]
    stays = np.ones(bodies.number.size, np.bool_)
    stays[tried[done]] = False
    return bodies.some(stays.nonzero()[0])


def _is_next(at: Lanes, bodies: Bodies, orbit: Cycles, cycle: Cycles) -> Bools:
    """Whether cycles without rest lie on the side to which bodies tend, and no onset in between."""
    onsets = onsets_of(at, bodies.cell)
    onsets = np.where(np.arange(onsets.shape[0])[:, np.newaxis] == orbit.row[0], np.nan, onsets)
    lanes = at.noise.size
    same = (signs(orbit, lanes, onsets) == signs(cycle, lanes, onsets)) | np.isnan(onsets)
    side = _side(at, orbit, bodies)
    towards = signs(cycle, lanes, orbit.start[:1])[0]
    apart = np.abs(np.mod(cycle.start[0] - orbit.start[0] + np.pi, 2.0 * np.pi) - np.pi)
    return np.asarray(same.all(axis=0) & ((side == towards) | (apart < 1e-9)))


def _nearest(at: Lanes, bodies: Bodies, track: Track, out: Cycles, k: int) -> Bodies:
    """Choose the nearest of all cycles on the right side; return the bodies for which that is not possible."""
    near = near_cycles(bodies, track, k)
    pick = (near > 0).nonzero()[0]
    some = bodies.some(pick)
    orbit = track.cut(some.number, k - near[pick], near[pick])
    side, lanes = _side(at, orbit, some), at.noise.size
    onsets = onsets_of(at, some.cell)
    rows, count = onsets.shape
    # cycles with a rest, by the onset that it ends at
    row, column = np.nonzero(~np.isnan(onsets))
    found = _with_rest(at, some.cell[column], row)
    candidates = [no_cycles(count, rows) for _ in range(rows + 1)]
    for i in range(rows):
        own = (row == i).nonzero()[0]
        write(candidates[i], column[own], read(found, own))
    candidates[rows] = _leap(at, some, orbit)
    # the nearest: all others on this side pass the onset, or the start, of it on the far side
    chosen = np.full(count, -1)
    sides = np.array([signs(x, lanes, orbit.start[:1])[0] == side for x in candidates])
    exists = sides & np.array([x.count > 0 for x in candidates])
    probes = np.concatenate([onsets, candidates[rows].start[:1]])
    order = np.array([signs(x, lanes, probes) for x in candidates])  # [cycle, probe, body]
    for i in range(rows + 1):
        beyond = (order[:, i] * side >= 0) | ~exists
        beyond[i] = True
        np.copyto(chosen, i, where=exists[i] & beyond.all(axis=0))
    # where none without rest was found it may yet exist, unless no jump of the return map lies between
    openings = np.concatenate([at.opening[:, some.cell], at.opening[:, some.cell + lanes // 2]])
    here = signs(orbit, lanes, openings)
    for i in range(rows):
        of_i = (chosen == i) & ~exists[rows]
        if of_i.any():
            between = (here * side < 0) & (signs(candidates[i], lanes, openings) * side >= 0)
            chosen[of_i & (between & ~np.isnan(openings)).any(axis=0)] = -1
    done = np.zeros(bodies.number.size, np.bool_)
    for i, cycles in enumerate(candidates):
        own = (chosen == i).nonzero()[0]
        write(out, some.number[own], read(cycles, own))
        done[pick[own]] = True
    return bodies.some((~done).nonzero()[0])


def _with_rest(at: Lanes, cell: Indices, row: Indices) -> Cycles:
    """Cycles that rest until given onsets, where there are such."""
    h = at.onset.shape[0]
    track, out = Track(cell.size, h), no_cycles(cell.size, 2 * h)
    n = np.arange(cell.size)
    begun = Bodies(n, cell, from_onsets(at, cell, row), np.zeros(n.size), np.zeros(n.size, np.intp))
    follow(at, begun, track, out, range(2 * h))
    other = ~((out.row == row) & (np.arange(2 * h)[:, np.newaxis] < out.count)).any(axis=0)
    out.count[other] = 0
    return out


def _leap(at: Lanes, bodies: Bodies, orbit: Cycles) -> Cycles:
    """Look for cycles without rest far from where bodies are; a cycle without a slide where none is found.

    Slides that link up but do not stop where they should show which slides there are further on.
    """
    h, n = at.onset.shape[0], at.noise.size // 2
    out = no_cycles(bodies.number.size, 2 * h)
    left = np.arange(bodies.number.size)
    for _ in range(_LEAPS):
        found, valid, _ = without_rest(at, orbit)
        good = valid.nonzero()[0]
        write(out, left[good], read(found, good))
        again = (~valid).nonzero()[0]
        left = left[again]
        if not left.size:
            break
        lane, cell = orbit.lane[0, again], bodies.cell[left]
        there = found.start[0, again]
        held = values(at.static[:, lane], there) <= at.noise[lane]
        phase = np.where(held, orbit.start[0, again], there)
        track, ignored = Track(left.size, h), no_cycles(left.size, 2 * h)
        begun = stopped(at, cell, phase, (lane,))
        under_way = Bodies(np.arange(left.size), cell, begun, np.zeros(left.size), np.zeros(left.size, np.intp))
        slides = 4 * h
        under_way = follow(at, under_way, track, ignored, range(slides))
        near = near_cycles(under_way, track, slides)
        going = (near > 0).nonzero()[0]
        left = left[under_way.number[going]]
        orbit = track.cut(under_way.number[going], slides - near[going], near[going])
        if not left.size:
            break
    return out
