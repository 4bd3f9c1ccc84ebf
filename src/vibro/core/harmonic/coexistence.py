"""Whether a pushed body can settle into another cycle, higher or lower than the one from rest."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from vibro.core.harmonic.cycle import Bodies, Cycles, Start, Track, follow, no_cycles, read, signs
from vibro.core.harmonic.jumps import direction_after_turn, jumps_of, leads
from vibro.core.harmonic.slides import slides
from vibro.core.harmonic.waves import TURN, wrapped

if TYPE_CHECKING:
    from numpy.typing import NDArray

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
        1 where there is another one, 0 where not.

    Notes
    -----
    Every cycle with a slide forward is passed by, or is below, a body that slides forward from where kinetic
    friction is just overcome: the highest of these bodies stays above all cycles. Between two cycles the
    return map jumps, since all of them attract, and on the far side of the jump bodies tend to the far one.
    So the jumps between a cycle and where that body is after a turn tell whether there is a higher one. The
    same holds below.
    """
    n = at.noise.size // 2
    out = np.zeros(n, np.int8)
    some = np.nonzero((cycles.size > 0) & ~np.isnan(at.jump[0].reshape(2, n)))
    out[some[1][_beyond(at, some[1], some[1] + n * some[0], cycles)]] = 1
    return out


def _beyond(at: Lanes, cell: Indices, lane: Indices, cycles: Cycles) -> Bools:
    """Whether there are other cycles on the sides of given ones to which lanes lead."""
    h, lanes = at.onset.shape[0], at.noise.size
    still = np.zeros(cell.size, np.intp)
    bodies = Bodies(np.arange(cell.size), cell, _outermost(at, lane), np.zeros(cell.size), still)
    track, found = Track(cell.size, h), no_cycles(cell.size, h)
    alone = []
    for k in range(2 * h + 1):  # 2 H in a turn, and one at its end
        bodies = follow(at, bodies, track, found, range(k, k + 1))
        joins, turned = _joins(read(cycles, bodies.cell), bodies), bodies.travelled >= TURN
        alone.append(bodies.number[turned & ~joins])
        bodies = bodies.some((~turned & ~joins).nonzero()[0])
    out = (found.size > 0) | (track.endless >= 0)
    turned = np.concatenate([*alone, bodies.number])
    # latest first: where slides a turn apart overlap, the later one counts
    order = np.argsort(-track.when[:, turned], axis=0)
    slid = (np.take_along_axis(x[:, turned], order, axis=0) for x in track.slides[1:])
    last = Cycles._make((np.full(turned.size, 2 * h + 1), *slid))
    cell = cell[turned]
    way = np.where(lane < lanes // 2, 1, -1)[turned]
    jumps = jumps_of(at, cell)
    outer, inner = (way * signs(x, lanes, jumps) for x in (last, read(cycles, cell)))
    # a body at rest is on the inner side of a jump towards faster slides outwards, else on the outer one
    outward = leads(at, np.arange(jumps.shape[0]))[:, np.newaxis] == way
    between = np.where(outward, (inner <= 0) & (outer > 0), (inner < 0) & (outer >= 0)) & ~np.isnan(jumps)
    row, column = np.nonzero(between)
    slides_on = outward[row, column]
    moved = direction_after_turn(at, cell[column], row, slides_on) * way[column]
    out[turned[column[np.where(slides_on, moved > 0, moved >= 0)]]] = True
    return np.asarray(out)


def _outermost(at: Lanes, lane: Indices) -> Start:
    """Slides from where kinetic friction is just overcome that pass by all others."""
    h = at.opening.shape[0]
    phase, zero = at.opening[0, lane], np.zeros(lane.size)
    for i in range(1, h):
        more = (~np.isnan(at.opening[i, lane])).nonzero()[0]
        other = at.opening[i, lane[more]]
        slid = slides(at, lane[more], phase[more], zero[more])
        passed = wrapped(other - phase[more]) < slid.length
        phase[more] = np.where(passed, phase[more], other)
    no = np.zeros(lane.size, np.bool_)
    return Start(lane, phase, zero, np.full(lane.size, -1), zero, no)


def _joins(cycles: Cycles, bodies: Bodies) -> Bools:
    """Whether bodies start from an onset that their scene's cycle starts from, too."""
    rows = np.arange(cycles.row.shape[0])[:, np.newaxis]
    own = (cycles.row == bodies.now.row) & (rows < cycles.size)
    return np.asarray((own & (bodies.now.row >= 0)).any(axis=0))
