"""The cycle that a body settles into: followed slide by slide, and chosen among few where that takes long."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.harmonic.arrays import until
from vibro.core.harmonic.restless import restless_cycles
from vibro.core.harmonic.slides import slides
from vibro.core.harmonic.waves import TURN, values, wrapped

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.core.harmonic.slides import Lanes

    Floats = NDArray[np.float64]
    Bools = NDArray[np.bool_]
    Indices = NDArray[np.intp]
    Signs = NDArray[np.int8]

__all__ = [
    "Bodies",
    "Cycles",
    "Start",
    "Track",
    "follow",
    "from_onsets",
    "near_cycles",
    "no_cycles",
    "onsets_of",
    "put_in",
    "read",
    "signs",
    "stopped",
    "without_rest",
    "write",
]

# [rad] Slides this close to where they were a cycle before are near enough to try the cycle without rest.
_NEAR: Final = 1.0

# [rad] A cycle of another length than a turn is no cycle.
_CLOSED: Final = 1e-6


class Start(NamedTuple):
    """Bodies at zero speed that begin to slide, 1-D.

    Attributes
    ----------
    lane : int array
        Column of ``Lanes``.
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
    """Steady cycles of bodies, 1-D, with their slides in 2 H + 1 rows, in the order of time.

    Attributes
    ----------
    size : int array
        Number of slides; 0 without a cycle.
    lane, row : int arrays
        Columns of ``Lanes``; onsets that slides start from, or -1.
    start, length, path, peak : array
        Phase at the start and until the end, distance and largest speed.
    rests : bool array
        Whether a rest follows.
    """

    size: Indices
    lane: Indices
    row: Indices
    start: Floats
    length: Floats
    path: Floats
    peak: Floats
    rests: Bools

    @property
    def at_rest(self) -> Bools:
        """Whether the body rests in its cycle."""
        return np.asarray(self.rests.any(axis=0))


def no_cycles(bodies: int, h: int) -> Cycles:
    """Make cycles to be filled."""
    shape = (2 * h + 1, bodies)
    numbers = np.zeros((4, *shape))
    none = np.full(shape, -1, np.intp)
    rests = np.zeros(shape, np.bool_)
    return Cycles._make((np.zeros(bodies, np.intp), none + 1, none, *numbers, rests))


def write(out: Cycles, bodies: Indices, cycles: Cycles) -> None:
    """Put cycles where they belong."""
    for target, values_ in zip(out, cycles, strict=True):
        target[..., bodies] = values_


def read(cycles: Cycles, bodies: Indices) -> Cycles:
    """Take cycles of some bodies."""
    return Cycles._make(x.take(bodies, axis=-1) for x in cycles)


def from_onsets(at: Lanes, cell: Indices, row: Indices, waited: Floats | float = 0.0) -> Start:
    """Start of slides from onsets."""
    n, h = at.noise.size // 2, at.onset.shape[0]
    lane = np.where(row < h, cell, cell + n)
    return Start(
        lane,
        at.onset[row % h, lane],
        at.excess[row % h, lane],
        row,
        np.broadcast_to(waited, cell.shape).copy(),
        np.zeros(cell.size, np.bool_),
    )


def onsets_of(at: Lanes, cell: Indices) -> Floats:
    """Phases of all onsets, forward ones first, in rows."""
    return np.concatenate([at.onset.take(x, axis=1) for x in (cell, cell + at.noise.size // 2)])


def stopped(at: Lanes, cell: Indices, phase: Floats, lanes: tuple[Indices, ...]) -> Start:
    """Start of the next slide of bodies that stop, or are put, at phases.

    Parameters
    ----------
    at : Lanes
        Scenes, each with an onset.
    cell : int array
        That of each body.
    phase : array
        In [0, 2 pi).
    lanes : tuple of int arrays
        In which a slide may begin at once.
    """
    waits = until(onsets_of(at, cell), phase)
    waits[np.isnan(waits)] = np.inf
    row = np.argmin(waits, axis=0)
    start = from_onsets(at, cell, row, waits[row, np.arange(cell.size)])
    for lane in lanes:
        load = values(at.static.take(lane, axis=1), phase)
        noise = at.noise[lane]
        np.logical_or(start.edge, np.abs(load) <= noise, out=start.edge)
        inside = load > noise
        put_in(start, inside, lane, phase, np.nan)
    return start


def put_in(start: Start, which: Bools, lane: Indices, phase: Floats, excess: Floats | float) -> None:
    """Let some bodies start from inside a window instead."""
    np.copyto(start.lane, lane, where=which)
    np.copyto(start.phase, phase, where=which)
    np.copyto(start.excess, excess, where=which)
    np.copyto(start.row, -1, where=which)
    np.copyto(start.waited, 0.0, where=which)


class Bodies(NamedTuple):
    """Bodies under way.

    Attributes
    ----------
    number, cell : int arrays
        Their own numbers and those of their scenes.
    now : Start
        Next slides.
    travelled : array
        Phase since they were started.
    chained : int array
        Slides since the last rest.
    """

    number: Indices
    cell: Indices
    now: Start
    travelled: Floats
    chained: Indices

    def some(self, which: Indices) -> Bodies:
        """Take some of them."""
        return Bodies(
            self.number[which],
            self.cell[which],
            Start._make(x[which] for x in self.now),
            self.travelled[which],
            self.chained[which],
        )


class Track:
    """The last 2 H + 1 slides of bodies, in slots, and when they last started from each onset.

    Attributes
    ----------
    slides : Cycles
        Those slides; a slide's slot is its number modulo 2 H + 1.
    when : array
        Phase travelled before each slide.
    first : int array
        Number of the first slide from an onset, -1 before it.
    endless : int array
        Lane of the slide that never ends; -1 where all end.
    edge, settled : bool array
        Whether rounding decided something on the way, and whether all ends were found.
    """

    def __init__(self, bodies: int, h: int) -> None:
        self.rows = 2 * h + 1
        self.slides = no_cycles(bodies, h)
        self.when = np.zeros((self.rows, bodies))
        self.first = np.full((self.rows, bodies), -1, np.intp)
        self.endless = np.full(bodies, -1, np.intp)
        self.edge = np.zeros(bodies, np.bool_)
        self.settled = np.ones(bodies, np.bool_)

    def cut(self, bodies: Indices, first: Indices, count: Indices) -> Cycles:
        """Slides of bodies from a number on, as cycles."""
        rows = np.arange(self.rows)[:, np.newaxis]
        slots = (first + rows) % self.rows
        members = (np.where(rows < count, x[slots, bodies], 0) for x in self.slides[1:])
        return Cycles._make((count, *members))


def follow(at: Lanes, bodies: Bodies, track: Track, out: Cycles, numbers: range) -> Bodies:
    """Follow bodies through slides with these numbers, or until they start from the same onset again.

    Their cycles are written; those that have none yet are returned. What a body does after an onset depends
    on nothing before: it repeats itself.
    """
    n = at.noise.size // 2
    rows = track.rows
    for k in numbers:
        number, cell, now, travelled, chained = bodies
        slot = k % rows
        slid = slides(at, now.lane, now.phase, now.excess)
        for target, source in zip(
            track.slides[1:7], (now.lane, now.row, now.phase, slid.length, slid.path, slid.peak), strict=True
        ):
            target[slot, number] = source
        track.when[slot, number] = travelled
        held = (now.row >= 0).nonzero()[0]
        track.first[now.row[held], number[held]] = k
        track.edge[number] |= now.edge | slid.edge
        ends = np.isfinite(slid.length)
        track.endless[number[~ends]] = now.lane[~ends]
        track.settled[number] &= slid.settled
        going = (ends & slid.settled).nonzero()[0]
        if going.size < number.size:
            number, cell, now, travelled, chained = bodies.some(going)
        length = slid.length[going]
        lane = now.lane
        now = stopped(at, cell, wrapped(now.phase + length), (np.where(lane < n, lane + n, lane - n),))
        travelled = travelled + length + now.waited
        rests = now.row >= 0
        track.slides.rests[slot, number] = rests
        bodies = Bodies(number, cell, now, travelled, np.where(rests, 0, chained + 1))
        first = np.where(rests, track.first[now.row, number], -1)
        closed = first >= 0
        again = closed.nonzero()[0]
        if again.size:
            first, count = first[again], k + 1 - first[again]
            period = travelled[again] - track.when[first % rows, number[again]]
            good = (count < rows) & (np.abs(period - TURN) < _CLOSED)
            track.settled[number[again]] &= good
            write(out, number[again], track.cut(number[again], first, count))
            out.size[number[again[~good]]] = 0
            bodies = bodies.some((~closed).nonzero()[0])
        if not bodies.number.size:
            break
    return bodies


def near_cycles(bodies: Bodies, track: Track, k: int) -> Indices:
    """Count the last of k slides that nearly make a turn without rest; 0 where none do."""
    best = np.full(bodies.number.size, _NEAR)
    count = np.zeros(bodies.number.size, np.intp)
    for m in range(2, min(track.rows, k) + 1, 2):
        shift = np.abs(bodies.travelled - track.when[(k - m) % track.rows, bodies.number] - TURN)
        better = (bodies.chained >= m) & (shift < best)
        best[better], count[better] = shift[better], m
    return count


def without_rest(at: Lanes, cycles: Cycles) -> tuple[Cycles, Bools, Bools]:
    """Cycles without rest by those that are nearly such; whether they are valid, and decided by rounding."""
    rows, n = cycles.start.shape
    out, valid, edge = no_cycles(n, rows // 2), np.zeros(n, np.bool_), np.zeros(n, np.bool_)
    for m in range(2, rows + 1, 2):
        own = (cycles.size == m).nonzero()[0]
        if own.size:
            lane = cycles.lane[:m, own]
            found = restless_cycles(at, lane, cycles.start[:m, own])
            valid[own], edge[own] = found.valid, found.edge
            out.size[own] = m
            out.lane[:m, own] = lane
            for target, source in zip(out[3:7], found[:4], strict=True):
                target[:m, own] = source
    return out, valid, edge


def signs(cycles: Cycles, lanes: int, phases: Floats) -> Signs:
    """Directions in which bodies move at phases, in rows: +1, -1, or 0 at rest.

    Slides that nearly make a turn without rest may leave a gap, in which the first one has begun again.
    """
    filler = np.where(cycles.at_rest, 0, np.where(cycles.lane[0] < lanes // 2, 1, -1)).astype(np.int8)
    out = np.broadcast_to(filler, phases.shape).copy()
    for j in range(cycles.start.shape[0] - 1, -1, -1):
        after = wrapped(phases - cycles.start[j])
        covered = (after > 0.0) & (after < cycles.length[j]) & (j < cycles.size)
        np.copyto(out, np.where(cycles.lane[j] < lanes // 2, np.int8(1), np.int8(-1)), where=covered)
    return out
