"""Whether a pushed body can settle into another cycle: the highest and the lowest cycle are reached from outside."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from vibro.core.harmonic.cycle import Bodies, Start, Track, follow, no_cycles, read, signs
from vibro.core.harmonic.settling import settle
from vibro.core.harmonic.slides import slides
from vibro.core.harmonic.waves import TURN

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.core.harmonic.cycle import Cycles
    from vibro.core.harmonic.slides import Lanes

    Bools = NDArray[np.bool_]
    Indices = NDArray[np.intp]
    Codes = NDArray[np.int8]

__all__ = ["coexisting"]


def coexisting(at: Lanes, cycles: Cycles) -> Codes:
    """Look for other cycles than given ones, in scenes where friction holds gravity.

    Parameters
    ----------
    at : Lanes
        Scenes.
    cycles : Cycles
        One of each scene.

    Returns
    -------
    int8 array
        1 where there is another one, 0 where not, -1 where that was not decided.

    Notes
    -----
    Every cycle with a slide forward is passed by, or is below, a body that slides forward from where kinetic friction
    is just overcome: the highest of these bodies stays above all cycles. If no jump of the return map lies
    between it and a cycle after a turn, it tends to that cycle, and there is no higher one. The same holds below.
    """
    n = at.noise.size // 2
    out = np.zeros(n, np.int8)
    for way in (1, -1):
        shift = 0 if way > 0 else n
        cell = ((cycles.count > 0) & ~np.isnan(at.jump[0, shift:][:n]) & (out == 0)).nonzero()[0]
        if cell.size:
            found = _beyond(at, cell, cell + shift, read(cycles, cell), way)
            out[cell] = found
    return out


def _beyond(at: Lanes, cell: Indices, lane: Indices, cycles: Cycles, way: int) -> Codes:
    """Look for other cycles on one side of given ones."""
    h = at.onset.shape[0]
    still = np.zeros(cell.size, np.intp)
    bodies = Bodies(np.arange(cell.size), cell, _outermost(at, lane), 0.0 * still, still)
    track, ignored = Track(cell.size, h), no_cycles(cell.size, 2 * h)
    out = np.zeros(cell.size, np.int8)
    for k in range(2 * h + 1):
        bodies = follow(at, bodies, track, ignored, range(k, k + 1))
        bodies = bodies.some((~_joins(cycles, bodies)).nonzero()[0])
        if not bodies.number.size:
            break
    out[ignored.count > 0] = 1
    out[track.endless >= 0] = 1
    if not bodies.number.size:
        return out
    last = np.full(bodies.number.size, 2 * h)
    orbit = track.cut(bodies.number, last * 0 + 1, last)
    known = read(cycles, bodies.number)
    whole = bodies.travelled - track.when[1, bodies.number] >= TURN
    open_ = (~whole | _jump_between(at, bodies.cell, orbit, known, way)).nonzero()[0]
    if open_.size:
        left = bodies.some(open_)
        found = settle(at, left.cell, left.now)
        here = read(cycles, left.number)
        out[left.number] = np.where(_same(found.cycles, here), 0, 1)
        out[left.number[found.cycles.count == 0]] = -1
        out[left.number[found.endless >= 0]] = 1
    return out


def _outermost(at: Lanes, lane: Indices) -> Start:
    """Slides from where kinetic friction is just overcome that pass by all others."""
    h = at.opening.shape[0]
    phase, zero = at.opening[0, lane], np.zeros(lane.size)
    for i in range(1, h):
        more = (~np.isnan(at.opening[i, lane])).nonzero()[0]
        other = at.opening[i, lane[more]]
        slid = slides(at, lane[more], phase[more], zero[more])
        passed = np.mod(other - phase[more], TURN) < slid.length
        phase[more] = np.where(passed, phase[more], other)
    no = np.zeros(lane.size, np.bool_)
    return Start(lane, phase, zero, np.full(lane.size, -1), zero, no)


def _joins(cycles: Cycles, bodies: Bodies) -> Bools:
    """Whether bodies start from an onset that their scene's cycle starts from, too."""
    rows = np.arange(cycles.row.shape[0])[:, np.newaxis]
    own = (cycles.row[:, bodies.number] == bodies.now.row) & (rows < cycles.count[bodies.number])
    return np.asarray((own & (bodies.now.row >= 0)).any(axis=0))


def _jump_between(at: Lanes, cell: Indices, orbit: Cycles, cycles: Cycles, way: int) -> Bools:
    """Whether a jump of the return map lies between cycles and bodies on one side of them."""
    n, rows = at.noise.size // 2, at.jump.shape[0]
    jumps = np.concatenate([at.jump[:, cell], at.jump[:, cell + n]])
    outer, inner = way * signs(orbit, 2 * n, jumps), way * signs(cycles, 2 * n, jumps)
    outward = (np.arange(2 * rows) < rows)[:, np.newaxis] == (way > 0)
    # a body at rest is on the inner side of a jump towards faster slides outwards, else on the outer one
    between = np.where(outward, (inner <= 0) & (outer > 0), (inner < 0) & (outer >= 0))
    return np.asarray((between & ~np.isnan(jumps)).any(axis=0))


def _same(found: Cycles, known: Cycles) -> Bools:
    """Whether cycles are the same: there is but one without rest, and one that rests until an onset."""
    rows = np.arange(known.row.shape[0])[:, np.newaxis]
    shared = np.zeros(known.count.size, np.bool_)
    for j in range(known.row.shape[0]):
        of_j = (known.row == found.row[j]) & (rows < known.count) & (known.row >= 0)
        shared |= of_j.any(axis=0) & (j < found.count)
    return np.where(found.at_rest & known.at_rest, shared, ~found.at_rest & ~known.at_rest)
