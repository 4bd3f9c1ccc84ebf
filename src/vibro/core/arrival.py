"""When a body first reaches a position: it is followed, and whole cycles are added once it has settled.

Equation numbers are those of docs/theory. Lengths in A, speeds in A w, normal speeds over
n = cos(beta)/G [A w n], phases of the normal motion in radians.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from vibro.core.buffers import MOST_CYCLES
from vibro.core.cells import number_of_nodes
from vibro.core.codes import Mode
from vibro.core.drives import Loads, along_cosine, mix_of, phase_difference
from vibro.core.elementary import (
    INF,
    NAN,
    PI,
    TURN,
    PathPoint,
    free_motion,
    positive_part,
    wrap,
    wrap_around,
)
from vibro.core.flight import SHARP, Covariance, Flight, propagate, within
from vibro.core.history import Sections, is_section
from vibro.core.roots import bisected
from vibro.core.steps import Course, Launch, State, Step, first_step, launched, nearest_turn, step
from vibro.core.waves import FORCE, KINETIC_FORWARD, SINE, Mix, Waves, depart, moved, nodes_of

__all__ = ["arrival_cycles"]

#: [1] Legs after which the search gives up; a transient that long needs mu_d below 1e-5 mu_s.
_MOST_LEGS: Final = 2_000_000

_MOST_UNCOMPARED: Final = 100_000  # [1] of those that never repeat

_SETTLED: Final = 1e-13  # [rad, A w] change per cycle that is left to rounding
# [rad, A w] Within this distance of the steady cycle changes shrink by a constant factor, Eq. (41); what that
# neglects is of the square of the distance.
_LINEAR: Final = 1e-7
_SAME: Final = 1e-9  # [A] rounding of a cycle's displacement, generously
_SLACK: Final = 100.0  # [1] factor between a difference of states and of the positions they lead to
_DOUBLINGS: Final = 990  # of a turn, up to 1e299 rad, where the search along a slide without end gives up
# [1] Stretches of a flight between zeros of the acceleration: the longest flights last some 1e6 turns.
_MOST_STRETCHES: Final = 2_000_000


class Memory(NamedTuple):
    """The last start at which the body was compared, and what happened since.

    Attributes
    ----------
    then : State
        The body there; its mode is 0 before the first comparison.
    starts : int
        Starts of that kind since.
    gain : float
        Change of the state now per change of it then.
    top : float
        A position that was not passed since.
    """

    then: State
    starts: int
    gain: float
    top: float


class Comparison(NamedTuple):
    """A body compared with itself a cycle ago.

    Attributes
    ----------
    at : State
        The body, moved on by whole cycles if it has settled.
    never : bool
        Whether it never arrives.
    """

    at: State
    never: bool


def arrival_cycles(course: Course, sections: Sections, length: float, start: Launch, steady: float) -> float:
    """Count the drive cycles until a body has moved by a length.

    Parameters
    ----------
    course, sections : Course, Sections
        The scene.
    length : float
        Displacement to be reached, > 0.
    start : Launch
        Where the body is at the start.
    steady : float
        Displacement per drive cycle of the steady cycle, NaN if it is unknown.

    Returns
    -------
    float
        inf if it never arrives; NaN if that is unknown, or takes more than ``MOST_CYCLES``.

    Notes
    -----
    A body that has rested repeats its cycle exactly, and whole cycles are added at once. One that never rests
    approaches its cycle geometrically, by the product of the ratios of its accelerations at each turn: within
    1e-7 of it the rest of the transient is summed in closed form. Only the way there is followed. In a
    steady cycle without net advance no later cycle gets farther than the last: it never arrives.
    """
    at = launched(course, start)
    origin, thrown = at.phase, start.height > 0.0 or start.rate < 0.0
    memory = Memory(at._replace(mode=0), 0, 1.0, 0.0)
    errors, last = Covariance(0.0, 0.0, 0.0), -1
    most = _MOST_LEGS
    if sections.lag == 0 and course.bed.waves.kind != SINE:  # never compared with itself
        most = _MOST_UNCOMPARED
    for _ in range(most):
        never = False
        if not thrown and is_section(course, sections, at, last):
            then, last = memory.then, at.cycle
            same = then.mode == at.mode and (not sections.lands or _same_lift_off(course, then, at))
            # a start after which there was none of its kind for two cycles belongs to the transient: take a
            # newer one
            stale = then.mode == 0 or at.cycle - then.cycle > 2 * (sections.cycles + 1)
            memory = memory._replace(starts=memory.starts + (1 if same else 0))
            due = same and memory.starts >= sections.lag
            if due:
                at, never = _compare(course, length, steady, at, memory)
            if due or (stale and not same):
                memory = Memory(at, 0, 1.0, at.position)
        leg = first_step(course, start, at) if thrown else step(course, at)
        thrown = False
        reach = _reach(course, length, at, leg)
        if at.cycle >= MOST_CYCLES:
            return NAN
        if math.isfinite(reach):
            return at.cycle + (at.phase - origin + reach) / TURN
        if never or not math.isfinite(leg.length):
            return INF
        errors = _propagated(course, at, leg, errors)
        if not within(errors, SHARP):
            return NAN
        memory = memory._replace(gain=memory.gain * leg.gain, top=max(memory.top, _highest(course, at, leg)))
        at = leg.after
    return NAN


def _same_lift_off(course: Course, then: State, at: State) -> bool:
    """Whether two lift-offs, or starts of slides in contact, may be compared."""
    return not math.isfinite(course.track.lift_off) or then.phase == at.phase


def _compare(course: Course, length: float, steady: float, at: State, memory: Memory) -> Comparison:
    """Compare a body with itself one cycle ago; add cycles if it has settled.

    With the gain g per cycle the change of the state from now to m cycles later is its last change times
    g (1 - g^m) / (1 - g), and so is the change of the displacement per cycle, Eq. (41).
    """
    then, gain = memory.then, memory.gain
    slides = not math.isfinite(course.track.lift_off)
    turn = wrap_around(at.phase - then.phase)
    period = at.cycle - then.cycle + nearest_turn(at.phase - then.phase)
    push = at.velocity - then.velocity
    change, other = push, max(abs(at.rate - then.rate), abs(turn))
    if slides:
        change, other = turn, max(abs(at.rate - then.rate), abs(push))
    scale = 1.0 + abs(at.velocity)
    walked = at.position - then.position
    advance = steady * period
    left = 1.0 - gain
    series = gain / left if left > 0.0 else INF
    distance = abs(change) * series if change != 0.0 and series != 0.0 else 0.0
    ours = abs(walked - advance) <= _SLACK * distance + _SAME * (1.0 + abs(advance))
    linear = ours and other <= _SETTLED and distance <= _LINEAR * scale * math.sqrt(max(left, 0.0))
    settled = max(abs(change), other) <= _SETTLED * scale
    if not ours:
        advance = walked
    if not linear or change == 0.0:
        series, distance = 0.0, 0.0
    tail = (walked - advance) * series
    # later cycles get farther than the last by _SLACK times the difference of their states at most
    top = memory.top + abs(tail) + _SLACK * (distance + abs(change))
    never = advance <= 0.0 and (settled or (linear and top < length))
    # A hopping body that got no farther in its last cycle, and is no faster than before it, never will: with
    # trajectories that do not cross each later cycle gets no farther than the one before it, Eq. (36).
    never = never or (not slides and other <= _SETTLED and walked <= 0.0 and change <= 0.0)
    if not (settled or linear) or not advance > 0.0:
        return Comparison(at, never)
    ahead = min((length - top - walked) / advance, 2.0 * MOST_CYCLES)
    if not ahead >= 2.0:
        return Comparison(at, never)
    cycles = min(math.floor(ahead) - 1.0, MOST_CYCLES)
    faded = 1.0 - math.exp(cycles * math.log(gain)) if gain > 0.0 else 1.0
    moved = change * series * faded
    phase = at.phase + (moved if slides else 0.0)
    turns = float(math.floor(phase / TURN))
    later = State(
        at.cycle + int(cycles * period + turns),
        phase - TURN * turns,
        at.mode,
        at.position + (cycles * advance + tail * faded),
        at.velocity + (0.0 if slides else moved),
        at.rate,
    )
    return Comparison(later, never)


def _highest(course: Course, now: State, leg: Step) -> float:
    """Return a position that is not passed during a leg."""
    if now.mode != Mode.FLIGHT:
        return max(now.position, leg.after.position)
    return now.position + _fastest(course.track.loads, now, leg) * leg.length


def _fastest(loads: Loads, now: State, leg: Step) -> float:
    """Return a velocity that is not exceeded during a flight, >= 0."""
    fastest = now.velocity + loads.drive_tangential * (1.0 + along_cosine(loads, now.phase))
    return positive_part(fastest + positive_part(-loads.weight_tangential) * leg.length)


def _propagated(course: Course, now: State, leg: Step, errors: Covariance) -> Covariance:
    """Propagate the rounding of flights; a contact ends at the lift-off, whenever it began."""
    if now.mode != Mode.FLIGHT:
        return Covariance(0.0, 0.0, 0.0)
    flown = Flight(leg.length, leg.impact)
    return propagate(course.bed, course.restitution, now.phase, now.rate, flown, 0.0, errors)


class Path(NamedTuple):
    """Motion towards a target: free, ``free_motion``, or under a mix of loads, ``depart``."""

    amplitude: float
    drag: float
    phase: float
    velocity: float
    target: float
    waves: Waves
    mix: Mix
    load: float


def _moved(path: Path, s: float) -> PathPoint:
    """Return the path after a phase ``s``, and the velocity there."""
    if path.waves.kind != SINE:
        since = moved(path.waves, path.mix, path.phase, path.load, s)
        return PathPoint(path.velocity * s + since.path, path.velocity + since.velocity)
    sine, cosine = math.sin(path.phase), math.cos(path.phase)
    return free_motion(path.amplitude, path.drag, sine, cosine, path.velocity, s)


def _missing(path: Path, s: float) -> float:
    """Return how far the target is after a phase ``s``."""
    return path.target - _moved(path, s).path


def _speed(path: Path, s: float) -> float:
    """Return the velocity after a phase ``s``."""
    return _moved(path, s).velocity


def _reach(course: Course, length: float, now: State, leg: Step) -> float:
    """Return the phase from the start of a leg to the arrival; NaN if it does not arrive during it."""
    loads, target = course.track.loads, length - now.position
    if now.mode == Mode.FORWARD:
        if math.isfinite(leg.length) and leg.after.position < length:
            return NAN
        at = course.track.forward
        path = _path(loads, KINETIC_FORWARD, at.amplitude, at.drag, now.phase + at.shift, now, target)
        return _reach_sliding(path, leg.length)
    if now.mode == Mode.FLIGHT and _highest(course, now, leg) >= length:
        own = now.phase - phase_difference(loads)
        path = _path(loads, FORCE, loads.drive_tangential, loads.weight_tangential, own, now, target)
        return _reach_flying(path, leg.length, _fastest(loads, now, leg))
    return NAN


def _path(
    loads: Loads, row: int, amplitude: float, drag: float, phase: float, now: State, target: float
) -> Path:
    """Set out towards a target under the loads of a row, which are a sine less a drag for one harmonic."""
    waves, mix = loads.waves, mix_of(loads, row)
    load = depart(waves, mix, phase).load if waves.kind != SINE else 0.0
    return Path(amplitude, drag, phase, now.velocity, target, waves, mix, load)


def _reach_sliding(path: Path, length: float) -> float:
    """Return the arrival in a forward slide that passes the target, or never ends."""
    high = length
    if not math.isfinite(length):
        high = TURN
        for _ in range(_DOUBLINGS):
            if not _missing(path, high) > 0.0:
                return bisected(_missing, path, 0.0, high, True)
            high *= 2.0
        return NAN
    return bisected(_missing, path, 0.0, high, True)


def _reach_flying(path: Path, length: float, fastest: float) -> float:
    """Return the arrival in a flight: the velocity is monotone between the zeros of the acceleration."""
    low = 0.0
    for _ in range(_MOST_STRETCHES):
        if not low < length:
            break
        missing = _missing(path, low)
        if missing > TURN * fastest:  # it cannot arrive in this turn
            low += missing / fastest
            continue
        high = min(length, _next_zero(path, low))
        start, end = low, high
        rises, rises_on = _speed(path, low) > 0.0, _speed(path, high) >= 0.0
        if rises != rises_on:
            still = bisected(_speed, path, low, high, rises)
            if rises:
                end = still
            else:
                start = still
        elif not rises:
            end = low
        if _missing(path, end) <= 0.0:
            return bisected(_missing, path, start, end, True)
        low = high
    return NAN


def _next_zero(path: Path, low: float) -> float:
    """Return where the acceleration next changes its sign; inf where it never does."""
    found, waves = INF, path.waves
    if waves.kind != SINE:
        for i in range(number_of_nodes(waves, FORCE)):
            found = min(found, _next(waves.number[nodes_of(waves, FORCE) + i] - path.phase, low))
    elif abs(path.drag) <= path.amplitude and path.amplitude > 0.0:
        kappa = math.asin(path.drag / path.amplitude)
        found = min(_next(kappa - path.phase, low), _next(PI - kappa - path.phase, low))
    return found


def _next(zero: float, low: float) -> float:
    """Return where a zero of the acceleration, which comes once a turn, comes next."""
    nearest = low + wrap(zero - low)
    return nearest if nearest > low + _SETTLED * (1.0 + low) else nearest + TURN
