"""When bodies first reach a position: all of them walked at once, and settled ones moved on by cycles.

Lengths in A, speeds in A w, normal speeds over n = cos(beta)/G [A w n], phases in radians.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.codes import Mode
from vibro.core.flight.landing import SHARP, Blur, spread
from vibro.core.flight.trajectory import Flight
from vibro.core.free import free_motion
from vibro.core.groups import put, take
from vibro.core.roots import OpenCells, bisect
from vibro.core.walk.histories import is_section, sections_of
from vibro.core.walk.steps import starting, step, tangential_motion

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.core.contact.slide import Floats
    from vibro.core.walk.histories import Sections
    from vibro.core.walk.steps import Course, State, Step

    Bools = NDArray[np.bool_]

__all__ = ["MOST_CYCLES", "arrival_cycles"]

#: [1] Of so many cycles doubles hold the phase.
MOST_CYCLES: Final = 1e15

_TURN: Final = 2.0 * np.pi

#: [1] Legs after which the search gives up; a transient that long needs mu_d below 1e-5 mu_s.
_MOST_LEGS: Final = 2_000_000

_SETTLED: Final = 1e-13  # [rad, A w] change per cycle that is left to rounding
# [rad, A w] Within this distance of the steady cycle changes shrink by a constant factor, Eq. (41); what that
# neglects is of the square of the distance.
_LINEAR: Final = 1e-7
_SAME: Final = 1e-9  # [A] rounding of a cycle's displacement, generously
_SLACK: Final = 100.0  # [1] factor between a difference of states and of the positions they lead to


class _Memory(NamedTuple):
    """Bodies at the last start at which they were compared, and what happened since.

    ``mode`` is 0 before the first one; ``gain`` is the change of the state now per change of it then,
    ``top`` a position that was not passed.
    """

    mode: NDArray[np.int8]
    cycle: NDArray[np.int64]
    phase: Floats
    velocity: Floats
    rate: Floats
    position: Floats
    starts: NDArray[np.intp]
    gain: Floats
    top: Floats


class _Walk(NamedTuple):
    """Bodies still under way; ``blur`` is the rounding of their flights since the last contact."""

    course: Course
    sections: Sections
    length: Floats
    steady: Floats
    at: State
    memory: _Memory
    blur: Blur


def arrival_cycles(course: Course, length: Floats, phase: Floats, velocity: Floats, steady: Floats) -> Floats:
    """Drive cycles until bodies have moved by a length.

    Parameters
    ----------
    course : Course
        Their scenes.
    length : array
        Displacement to be reached, > 0; 1-D.
    phase, velocity : array
        Drive phase, and how fast they slide, at the start; 1-D.
    steady : array
        Displacement per drive cycle of the steady cycle, NaN where it is unknown; 1-D.

    Returns
    -------
    array
        inf where they never arrive; NaN where that is unknown, or takes more than ``MOST_CYCLES``.

    Notes
    -----
    A body that has rested repeats its cycle exactly, and whole cycles are added at once. One that never rests
    approaches its cycle geometrically, by the product of the ratios of its accelerations at each turn: within
    1e-7 of it the rest of the transient is summed in closed form. Only the way there is walked. In a
    steady cycle without net advance no later cycle gets farther than the last: it never arrives.
    """
    n = length.size
    out = np.full(n, np.nan)
    at = starting(course, phase, velocity)
    origin = at.phase.copy()
    zero = np.zeros(n)
    memory = _Memory(
        np.zeros(n, np.int8), at.cycle.copy(), zero.copy(), zero.copy(), zero.copy(), zero.copy(),
        np.zeros(n, np.intp), np.ones(n), zero.copy(),
    )  # fmt: skip
    walk = _Walk(course, sections_of(course), length, steady, at, memory, Blur(zero, zero, zero))
    under_way = OpenCells(np.arange(n), walk, _MOST_LEGS)
    for cells, walk in under_way:
        never = _move_on(walk)
        out[cells[never]] = np.inf
        leg = step(walk.course, walk.at)
        reach = _reach(walk, leg)
        now = walk.at
        lost = now.cycle >= MOST_CYCLES
        there = np.isfinite(reach) & ~lost
        out[cells[there]] = (
            now.cycle[there] + (now.phase[there] - origin[cells[there]] + reach[there]) / _TURN
        )
        ended = ~there & ~np.isfinite(leg.length)
        out[cells[ended]] = np.inf
        blur = _blur(walk, leg)
        walk.memory.gain[:] *= leg.gain
        walk.memory.top[:] = np.maximum(walk.memory.top, _bound(walk, leg))
        goes_on = ~(never | there | ended | lost) & blur.within(SHARP)
        under_way.keep(goes_on, walk._replace(at=leg.after, blur=blur))
    return out


def _move_on(walk: _Walk) -> Bools:
    """Add whole cycles to bodies that have settled, in place; return which never arrive."""
    at, memory = walk.at, walk.memory
    never = np.zeros(at.phase.shape, np.bool_)
    here = is_section(walk.course, walk.sections, at)
    # a start after which there was none of its kind for two cycles belongs to the transient: take a newer one
    stale = (memory.mode == 0) | (at.cycle - memory.cycle > 2 * (walk.sections.lag + 1))
    same = here & (memory.mode == at.mode)
    memory.starts[same] += 1
    due = same & (memory.starts >= walk.sections.lag)
    cells = np.flatnonzero(due)
    if cells.size:
        never[cells] = _compare(take(walk, cells), walk.at, cells)
    fresh = np.flatnonzero(due | (here & ~same & stale))
    if fresh.size:
        state = (memory.mode, memory.cycle, memory.phase, memory.velocity, memory.rate, memory.position)
        put(state, fresh, take((at.mode, at.cycle, at.phase, at.velocity, at.rate, at.position), fresh))
        memory.starts[fresh] = 0
        memory.gain[fresh] = 1.0
        memory.top[fresh] = at.position[fresh]
    return never


def _compare(walk: _Walk, whole: State, cells: NDArray[np.intp]) -> Bools:
    """Compare bodies with themselves one cycle ago; add cycles to ``whole`` in place.

    With the gain g per cycle the change of the state from now to m cycles later is its last change times
    g (1 - g^m) / (1 - g), and so is the change of the displacement per cycle, Eq. (41).
    """
    at, then = walk.at, walk.memory
    turn = np.mod(at.phase - then.phase + np.pi, _TURN) - np.pi
    period = at.cycle - then.cycle + np.rint((at.phase - then.phase - turn) / _TURN).astype(np.int64)
    push = at.velocity - then.velocity
    other = np.abs(at.rate - then.rate)
    slides = np.isinf(walk.course.track.lift_off)
    change = np.where(slides, turn, push)
    other = np.maximum(other, np.where(slides, np.abs(push), np.abs(turn)))
    scale = 1.0 + np.abs(at.velocity)
    walked = at.position - then.position
    advance = walk.steady * period
    left = 1.0 - then.gain
    with np.errstate(divide="ignore", invalid="ignore"):
        series = np.where(then.gain > 0.0, then.gain / left, 0.0)
        distance = np.where(change == 0.0, 0.0, np.abs(change) * series)
        ours = np.abs(walked - advance) <= _SLACK * distance + _SAME * (1.0 + np.abs(advance))
        linear = ours & (other <= _SETTLED) & (distance <= _LINEAR * scale * np.sqrt(left))
        settled = np.maximum(np.abs(change), other) <= _SETTLED * scale
        advance = np.where(ours, advance, walked)
        tail = np.where(linear, (walked - advance) * series, 0.0)
    series, distance = np.where(linear, (series, distance), 0.0)
    # later cycles get farther than the last by _SLACK times the difference of their states at most
    top = then.top + np.abs(tail) + _SLACK * (distance + np.abs(change))
    never = (advance <= 0.0) & (settled | (linear & (top < walk.length)))
    # A hopping body that got no farther in its last cycle, and is no faster than before it, never will: with
    # trajectories that do not cross each later cycle gets no farther than the one before it, Eq. (36).
    never |= ~slides & (other <= _SETTLED) & (walked <= 0.0) & (change <= 0.0)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        count = np.floor((walk.length - top - walked) / advance) - 1.0
    jumps = np.flatnonzero((settled | linear) & (advance > 0.0) & (count >= 1.0))
    if jumps.size:
        m = np.minimum(count[jumps], MOST_CYCLES)
        faded = 1.0 - then.gain[jumps] ** m
        moved = change[jumps] * series[jumps] * faded
        phase = at.phase[jumps] + np.where(slides[jumps], moved, 0.0)
        turns = np.floor(phase / _TURN)
        target = cells[jumps]
        whole.cycle[target] += (m * period[jumps] + turns).astype(np.int64)
        whole.phase[target] = phase - _TURN * turns
        whole.velocity[target] += np.where(slides[jumps], 0.0, moved)
        whole.position[target] += m * advance[jumps] + tail[jumps] * faded
    return np.asarray(never)


def _bound(walk: _Walk, leg: Step) -> Floats:
    """Return a position that is not passed during a leg."""
    now, scene = walk.at, walk.course.track.scene
    end = leg.after.position
    with np.errstate(invalid="ignore"):
        highest = now.velocity + scene.along * (1.0 + scene.along_cosine(now.phase))
        highest += np.maximum(-scene.tangential, 0.0) * leg.length
        aloft = now.position + np.maximum(highest, 0.0) * leg.length
    return np.where(now.mode == Mode.FLIGHT, aloft, np.maximum(now.position, end))


def _blur(walk: _Walk, leg: Step) -> Blur:
    """Carry the rounding of flights along; a contact ends at the lift-off, whenever it began."""
    now = walk.at
    flies = now.mode == Mode.FLIGHT
    if not flies.any():
        return Blur(*np.zeros((3, flies.size)))
    step = Flight(leg.length, leg.impact)
    course = walk.course
    blur = spread(course.throw, course.restitution, (now.phase, now.rate), step, np.zeros(()), walk.blur)
    return Blur(*(np.where(flies, x, 0.0) for x in blur))


def _reach(walk: _Walk, leg: Step) -> Floats:
    """Phase from the start of a leg to the arrival; NaN where that does not come in it."""
    out = np.full(walk.length.shape, np.nan)
    now = walk.at
    endless = np.isinf(leg.length)
    ahead = (now.mode == Mode.FORWARD) & (endless | (leg.after.position >= walk.length))
    aloft = (now.mode == Mode.FLIGHT) & (_bound(walk, leg) >= walk.length)
    for which, search in ((ahead, _reach_sliding), (aloft, _reach_flying)):
        cells = np.flatnonzero(which)
        if cells.size:
            at = take(now, cells)
            pull, drag, shift = tangential_motion(take(walk.course.track.scene, cells), at.mode)
            own = at.phase + shift
            motion = _Motion(
                own,
                pull,
                drag,
                np.sin(own),
                np.cos(own),
                at.velocity,
                walk.length[cells] - at.position,
            )
            out[cells] = search(motion, leg.length[cells])
    return out


class _Motion(NamedTuple):
    """Free motion towards a target, from a phase of its own on; see ``free_motion``."""

    phase: Floats
    pull: Floats
    drag: Floats
    sine: Floats
    cosine: Floats
    velocity: Floats
    target: Floats

    def missing(self, s: Floats) -> Floats:
        """Return how far the target is after a phase ``s``."""
        return self.target - free_motion(*self[1:6], s)[0]

    def speed(self, s: Floats) -> Floats:
        """Return the velocity after a phase ``s``."""
        return free_motion(*self[1:6], s)[1]


def _reach_sliding(motion: _Motion, length: Floats) -> Floats:
    """Arrival in forward slides that pass the target, or never end."""
    high = np.where(np.isinf(length), _TURN, length)
    while (short := np.isinf(length) & (motion.missing(high) > 0.0)).any():
        high = np.where(short, 2.0 * high, high)
    return bisect(motion.missing, np.zeros(length.shape), high)


def _reach_flying(motion: _Motion, length: Floats) -> Floats:
    """Arrival in flights: the velocity is monotone between the zeros of the acceleration."""
    out = np.full(length.shape, np.nan)
    with np.errstate(divide="ignore", invalid="ignore"):
        kappa = np.arcsin(motion.drag / motion.pull)  # NaN: no zeros
    low = np.zeros(length.shape)
    while (open_ := np.isnan(out) & (low < length)).any():
        high = length.copy()
        for zero in (kappa, np.pi - kappa):
            nearest = low + np.mod(zero - motion.phase - low, _TURN)
            nearest = np.where(nearest > low + _SETTLED * (1.0 + low), nearest, nearest + _TURN)
            high = np.fmin(high, nearest)
        rises, rises_on = motion.speed(low) > 0.0, motion.speed(high) >= 0.0
        start, end = low.copy(), np.where(rises | rises_on, high, low)
        turns = np.flatnonzero(open_ & (rises != rises_on))
        if turns.size:
            ahead = rises[turns]
            still = bisect(take(motion, turns).speed, low[turns], high[turns], rises=~ahead)
            start[turns] = np.where(ahead, low[turns], still)
            end[turns] = np.where(ahead, still, high[turns])
        there = np.flatnonzero(open_ & (motion.missing(end) <= 0.0))
        if there.size:
            out[there] = bisect(take(motion, there).missing, start[there], end[there])
        low = high
    return out
