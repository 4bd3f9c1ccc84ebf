"""The cycle that a body settles into: followed slide by slide, and solved at once where it never rests."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.contact.legs import until
from vibro.core.harmonic.restless import restless_cycles
from vibro.core.harmonic.slides import slides
from vibro.core.harmonic.waves import TURN, values

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.core.harmonic.slides import Lanes

    Floats = NDArray[np.float64]
    Bools = NDArray[np.bool_]
    Indices = NDArray[np.intp]

__all__ = ["Cycles", "Start", "resting", "settle"]

# A body that has not settled after so many slides is given up. Those that take long approach a cycle that
# breaks off just before they reach it.
_MOST_SLIDES: Final = 400

# [rad] Slides this close to where they were a cycle before are near enough to try the cycle without rest.
_NEAR: Final = 1.0

# [rad] A cycle of another length than a turn is no cycle.
_CLOSED: Final = 1e-6


class Start(NamedTuple):
    """Bodies at zero speed that begin to slide, 1-D.

    Attributes
    ----------
    lane : int array
        Column of ``Lanes``; -1 where a body rests for ever.
    phase : array
        In [0, 2 pi).
    excess : array
        Acceleration, where it is known better than from the phase; else NaN.
    row : int array
        Which of the 2 H onsets it is, forward ones first; -1 inside a window.
    waited : array
        Phase spent at rest before.
    edge : bool array
        Whether rounding decides whether it slides.
    """

    lane: Indices
    phase: Floats
    excess: Floats
    row: Indices
    waited: Floats
    edge: Bools


class Cycles(NamedTuple):
    """Steady cycles of bodies, 1-D, and their slides in 2 H rows, in the order of time.

    Attributes
    ----------
    count : int array
        Number of slides; 0 without a cycle.
    lane : int array
        Columns of ``Lanes``, rows of slides.
    start, length, path, peak : array
        Phase at the start and until the end, distance and largest speed, rows of slides.
    rests : bool array
        Whether a rest follows, rows of slides.
    endless : int array
        Lane of the slide that never ends; -1 where all end.
    edge : bool array
        Whether rounding decided something on the way.
    """

    count: Indices
    lane: Indices
    start: Floats
    length: Floats
    path: Floats
    peak: Floats
    rests: Bools
    endless: Indices
    edge: Bools


def resting(at: Lanes, cell: Indices, phase: Floats) -> Start:
    """Start of the next slide of bodies that rest."""
    n = at.noise.size // 2
    onsets = np.concatenate([at.onset[:, cell], at.onset[:, cell + n]])
    waits = until(onsets, phase)
    waits[np.isnan(waits)] = np.inf
    row = np.argmin(waits, axis=0)
    columns = np.arange(cell.size)
    waited = waits[row, columns]
    h = at.onset.shape[0]
    lane = np.where(row < h, cell, cell + n)
    lane[np.isinf(waited)] = -1
    return Start(
        lane, onsets[row, columns], at.excess[row % h, lane], row, waited, np.zeros(cell.size, np.bool_)
    )


def stopped(at: Lanes, cell: Indices, phase: Floats, lanes: tuple[Indices, ...]) -> Start:
    """Start of the next slide of bodies that stop at phases, or that were put there.

    Parameters
    ----------
    at : Lanes
        Scenes.
    cell : int array
        Theirs.
    phase : array
        In [0, 2 pi).
    lanes : tuple of int arrays
        In which a slide may begin at once.
    """
    n = cell.size
    start = resting(at, cell, phase)
    for lane in lanes:
        load = values(at.static[:, lane], phase)
        noise = at.noise[lane]
        start.edge[:] |= np.abs(load) <= noise
        inside = (load > noise).nonzero()[0]
        start.lane[inside] = lane[inside]
        start.phase[inside] = phase[inside]
        start.excess[inside] = np.nan
        start.row[inside] = -1
        start.waited[inside] = 0.0
    assert start.lane.size == n
    return start


class _Track:
    """The last 2 H slides of bodies, and when they first started from each onset."""

    def __init__(self, bodies: int, h: int) -> None:
        self.rows = 2 * h
        shape = (self.rows, bodies)
        self.lane = np.zeros(shape, np.intp)
        self.start, self.length, self.path, self.peak = np.zeros((4, *shape))
        self.rests = np.zeros(shape, np.bool_)
        self.row = np.full(shape, -1, np.intp)
        self.when = np.zeros(shape)  # phase travelled before the slide
        self.first = np.full(shape, -1, np.intp)  # number of the first slide from an onset


def settle(at: Lanes, cell: Indices, begun: Start) -> Cycles:
    """Follow bodies until their motion repeats.

    Parameters
    ----------
    at : Lanes
        Scenes.
    cell : int array
        That of each body.
    begun : Start
        Their first slides.

    Returns
    -------
    Cycles
        One element per body; without a slide where it has not settled, or where a slide never ends.

    Notes
    -----
    A body that starts twice from the same onset repeats itself: what it does depends on nothing before. Its
    velocity at a given phase rises, or falls, from cycle to cycle, because trajectories do not cross, and tends to
    the next fixed point on that side. So a body that is not at rest for a whole cycle tends to the cycle without
    rest if that exists on that side and no cycle with a rest lies between: none does if no onset lies between the
    phases at which the one and the other turn.
    """
    n, h = at.noise.size // 2, at.onset.shape[0]
    bodies = cell.size
    track = _Track(bodies, h)
    rows = track.rows
    out = Cycles(
        np.zeros(bodies, np.intp),
        np.zeros((rows, bodies), np.intp),
        *np.zeros((4, rows, bodies)),
        np.zeros((rows, bodies), np.bool_),
        np.full(bodies, -1, np.intp),
        begun.edge.copy(),
    )
    body = np.arange(bodies)
    now = begun
    travelled = np.zeros(bodies)
    chained = np.zeros(bodies, np.intp)  # slides since the last start from rest, that one included
    for k in range(_MOST_SLIDES):
        slot = k % rows
        track.lane[slot, body], track.start[slot, body] = now.lane, now.phase
        track.row[slot, body], track.when[slot, body] = now.row, travelled
        held = (now.row >= 0).nonzero()[0]
        track.first[now.row[held], body[held]] = k
        slid = slides(at, now.lane, now.phase, now.excess)
        track.length[slot, body], track.path[slot, body] = slid.length, slid.path
        track.peak[slot, body] = slid.peak
        ends = np.isfinite(slid.length)
        out.edge[body] |= slid.edge
        out.endless[body[~ends]] = now.lane[~ends]
        going = (ends & slid.settled).nonzero()[0]
        body, travelled, chained = body[going], travelled[going], chained[going]
        lane, phase, length = now.lane[going], now.phase[going], slid.length[going]
        stop = np.mod(phase + length, TURN)
        now = stopped(at, cell[body], stop, (np.where(lane < n, lane + n, lane - n),))
        out.edge[body] |= now.edge
        travelled = travelled + length + now.waited
        rests = now.row >= 0
        track.rests[slot, body] = rests
        chained = np.where(rests, 0, chained + 1)

        # cycles with a rest
        first = np.where(rests, track.first[now.row, body], -1)
        count = np.where(first >= 0, k + 1 - first, 0)
        closed = first >= 0
        period = travelled - track.when[first % rows, body]
        good = closed & (count <= rows) & (np.abs(period - TURN) < _CLOSED)
        _close(out, track, body[good], first[good], count[good])

        # cycles without
        pick = (~rests).nonzero()[0]
        if k and pick.size:
            done = _try_restless(at, out, track, body[pick], cell[body[pick]], k, chained[pick], travelled[pick], now.phase[pick])
            closed[pick[done]] = True
        going = (~closed).nonzero()[0]
        if not going.size:
            break
        body, travelled, chained = body[going], travelled[going], chained[going]
        now = Start(*(x[going] for x in now))
    return out


def _close(out: Cycles, track: _Track, body: Indices, first: Indices, count: Indices) -> None:
    """Write cycles that repeat from a slide on."""
    rows = np.arange(track.rows)[:, np.newaxis]
    slots = (first + rows) % track.rows
    out.count[body] = count
    for target, source in zip(
        (out.lane, out.start, out.length, out.path, out.peak, out.rests),
        (track.lane, track.start, track.length, track.path, track.peak, track.rests),
        strict=True,
    ):
        target[:, body] = np.where(rows < count, source[slots, body], 0)


def _try_restless(
    at: Lanes,
    out: Cycles,
    track: _Track,
    body: Indices,
    cell: Indices,
    k: int,
    chained: Indices,
    travelled: Floats,
    phase: Floats,
) -> Indices:
    """Solve the cycle without rest where the last slides nearly repeat; return the bodies that tend to it."""
    best = np.full(body.size, np.inf)
    slides_of = np.zeros(body.size, np.intp)
    for m in range(2, min(track.rows, k + 1) + 1, 2):
        shift = travelled - track.when[(k + 1 - m) % track.rows, body] - TURN
        better = (chained >= m) & (np.abs(shift) < np.minimum(np.abs(best), _NEAR))
        best[better], slides_of[better] = shift[better], m
    done = np.zeros(body.size, np.bool_)
    n = at.noise.size // 2
    for m in range(2, track.rows + 1, 2):
        tried = (slides_of == m).nonzero()[0]
        if not tried.size:
            continue
        slots = (k + 1 - m + np.arange(m)) % track.rows
        own = body[tried]
        begun = track.start[slots][:, own]
        found = restless_cycles(at, track.lane[slots][:, own], begun)
        # nothing lies between, and the body moves towards it
        onsets = np.concatenate([at.onset[:, cell[tried]], at.onset[:, cell[tried] + n]])
        way = np.mod(found.start - begun + np.pi, TURN) - np.pi
        low = np.where(way > 0.0, begun, found.start)
        clear = found.valid
        for j in range(m):
            after = np.mod(onsets - low[j], TURN)
            clear &= ~((after > 0.0) & (after < np.abs(way[j]))).any(axis=0)
        clear &= (best[tried] * way[0] >= 0.0) | (np.abs(way[0]) < _CLOSED)
        good = clear.nonzero()[0]
        rows = slice(0, m)
        own = own[good]
        out.count[own] = m
        out.lane[rows, own] = track.lane[slots][:, own]
        out.start[rows, own] = np.mod(found.start[:, good], TURN)
        out.length[rows, own], out.path[rows, own] = found.length[:, good], found.path[:, good]
        out.peak[rows, own] = found.peak[:, good]
        out.edge[own] |= found.edge[good]
        done[tried[good]] = True
    return done.nonzero()[0]
