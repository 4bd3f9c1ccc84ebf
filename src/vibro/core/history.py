"""The exact motion of one body from any start: a list of legs, and one steady cycle with a count.

The walk from leg to leg is compared with itself at the starts of slides, or of flights where the body hops.
Once it repeats, the legs between are a cycle, which is stored once, with a count, so that rounding does not
grow with the number of cycles. Lengths in A, speeds in A w, phases of the normal motion in radians.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from vibro.core.bounces import MOST_FLIGHTS, Bounces, Flights, bounces
from vibro.core.buffers import LONGEST_CYCLE, Bytes, Doubles, Integers
from vibro.core.cells import number_of_nodes
from vibro.core.codes import Mode
from vibro.core.continuous import continuous_sliding, middle_phase
from vibro.core.elementary import INF, NAN, QUARTER, TURN, wrap
from vibro.core.flight import next_take_off
from vibro.core.steps import Course, Launch, State, Step, first_step, launched, nearest_turn, step
from vibro.core.waves import NORMAL, SINE, nodes_of

__all__ = [
    "Followed", "LastStarts", "Legs", "Sections", "follow_legs", "is_section", "places", "sections_from",
    "sections_of",
]  # fmt: skip

# [rad, A w] Change from one cycle to the next that rounding alone brings.
_REPEATS: Final = 2e-15
# [rad, A w] Where cycles converge slowly rounding is amplified, up to this. A change below it that no longer
# shrinks is taken for rounding.
_NOISE: Final = 1e-11
_SHORTEST: Final = 2e-15  # [rad] legs up to this are rounding too
_NEAR: Final = 1e-6  # [rad] distance from a fixed point that rounding cannot bring

# [1] Legs without length, one after the other, after which the body is taken to stay where it is: rounding
# decides at each whether static friction holds it.
_MOST_IDLE: Final = 64

_KINDS: Final = 4  # [1] places of ``LastStarts`` for slides, one for each ``Mode``


class Legs(NamedTuple):
    """Legs of one body, one after the other.

    Attributes
    ----------
    mode : Bytes
        ``Mode`` of each.
    cycle : Integers
        Drive cycles completed at its start.
    phase : Doubles
        Phase at its start, in [0, 2 pi) [rad].
    length : Doubles
        Phase from start to end [rad]; inf for a last one that never ends.
    position, velocity : Doubles
        At its start.
    displacement : Doubles
        Until its end.
    end_velocity : Doubles
        At its end, before an impact.
    rate, impact : Doubles
        Normal speed away from the trough at its start, and towards it at its end [A w].
    """

    mode: Bytes
    cycle: Integers
    phase: Doubles
    length: Doubles
    position: Doubles
    velocity: Doubles
    displacement: Doubles
    end_velocity: Doubles
    rate: Doubles
    impact: Doubles


class LastStarts(NamedTuple):
    """Where a history was last compared with itself: scratch memory with a place for each start of a cycle.

    Attributes
    ----------
    row : Integers
        Leg that begins there; -1 for none.
    change : Doubles
        Change of the state since the cycle before; inf if there was none.
    """

    row: Integers
    change: Doubles


class Sections(NamedTuple):
    """Starts at which the motion of a scene is compared with itself.

    In contact these are the starts of slides, of drives beyond one harmonic the first in each drive cycle; of
    hopping bodies that come to rest on the trough in normal direction, the lift-offs; of others, every
    take-off.

    Attributes
    ----------
    lag : int
        How many such starts of one kind make a cycle; 0 if the motion never repeats.
    lands : bool
        Whether the cycle of a hopping body has a contact that ends with a lift-off.
    cycles : int
        Drive cycles, about, that the motion takes to repeat.
    """

    lag: int
    lands: bool
    cycles: int


class Followed(NamedTuple):
    """What ``follow_legs`` has found.

    Attributes
    ----------
    number : int
        Legs written; -1 if they did not fit.
    first : int
        The first of the steady cycle, which ends with the last; ``number`` if there is none.
    period : int
        Drive cycles of the steady cycle, 0 without one.
    advance : float
        Displacement in it.
    """

    number: int
    first: int
    period: int
    advance: float


def sections_of(course: Course, flights: Flights) -> Sections:
    """Choose where to compare the motion of a scene with itself; ``flights`` is scratch memory."""
    if not math.isfinite(course.track.lift_off):
        return Sections(1, True, 1)
    bed = course.bed
    return _sections(bounces(bed, course.restitution, flights, MOST_FLIGHTS, bed.lift_off, 0.0, True))


def sections_from(course: Course, start: Launch, flights: Flights) -> Sections:
    """Choose where to compare the motion of a body with itself that starts as in ``follow_legs``.

    Several normal motions may coexist. A body that the trough cannot bear at its start leaves at once, and
    may come to another one than from a lift-off; so may one that is thrown.
    """
    at = launched(course, start)
    if start.height > 0.0 or start.rate < 0.0:
        at = first_step(course, start, at).after
    if at.mode == Mode.FLIGHT and math.isfinite(course.track.lift_off):
        cycle = bounces(course.bed, course.restitution, flights, MOST_FLIGHTS, at.phase, at.rate, False)
        if cycle.repeats:
            return _sections(cycle)
    return sections_of(course, flights)


def _sections(cycle: Bounces) -> Sections:
    """Compare bodies that come to rest on the trough at lift-offs, others at every take-off."""
    if cycle.rest > 0.0:
        return Sections(1, True, cycle.cycles)
    lag = cycle.count if cycle.repeats else 0
    return Sections(lag, False, lag)


def places(course: Course, sections: Sections) -> int:
    """Return how many starts ``LastStarts`` has room for."""
    lift_offs = number_of_nodes(course.bed.waves, NORMAL) if course.bed.waves.kind != SINE else 0
    return max(max(sections.lag, _KINDS), min(lift_offs, LONGEST_CYCLE))


def _lift_off_index(course: Course, phase: float) -> int:
    """Return which zero of the normal load a lift-off is, modulo the number of places."""
    waves = course.bed.waves
    if waves.kind != SINE:
        for i in range(number_of_nodes(waves, NORMAL)):
            if waves.number[nodes_of(waves, NORMAL) + i] == phase:
                return i % LONGEST_CYCLE
    return 0


def is_section(course: Course, sections: Sections, at: State, last: int) -> bool:
    """Whether a leg starts where the motion is compared; ``last`` is the cycle of the last start."""
    if sections.lag == 0:
        return False
    if not math.isfinite(course.track.lift_off):
        first = at.cycle != last or course.track.loads.waves.kind == SINE
        return at.mode != Mode.REST and first
    if at.mode != Mode.FLIGHT or not sections.lands:
        return at.mode == Mode.FLIGHT
    return at.rate == 0.0 and at.phase == next_take_off(course.bed, at.phase).phase


def follow_legs(
    course: Course, sections: Sections, start: Launch, cycles: float, legs: Legs, rows: int, last: LastStarts
) -> Followed:  # fmt: skip
    """Follow one body until its motion repeats, ends or has lasted ``cycles`` drive cycles.

    Parameters
    ----------
    course, sections : Course, Sections
        The scene.
    start : Launch
        Where the body is at the start.
    cycles : float
        Drive cycles from the start on; the last leg may end later.
    legs : Legs
        Buffers of ``rows`` elements for the legs found. Positions count from the start.
    rows : int
        Their length.
    last : LastStarts
        Buffers of ``places(course, sections)`` elements.
    """
    at = launched(course, start)
    origin = at.phase
    thrown = start.height > 0.0 or start.rate < 0.0
    _forget(last, places(course, sections))
    starts, count, idle, polished, last_cycle = 0, 0, 0, False, -1
    for _ in range((rows + 1) * (_MOST_IDLE + 1)):
        if not at.cycle + (at.phase - origin) / TURN < cycles:
            break
        if not thrown and is_section(course, sections, at, last_cycle):
            place = _place(course, sections, at, starts)
            starts, last_cycle = starts + 1, at.cycle
            row, change = last.row[place], INF
            if 0 <= row < count:
                change = _change(legs, row, at)
                stalls = change <= _NOISE and (polished or change >= last.change[place])
                if change <= _REPEATS or stalls:
                    exact = NAN if polished or change == 0.0 else _start_without_rest(course, at)
                    if math.isnan(exact):
                        return _repeating(course, legs, row, count, at)
                    at = at._replace(cycle=at.cycle + nearest_turn(at.phase - exact), phase=exact)
                    polished, change = True, INF
                    _forget(last, _KINDS)
            last.row[place] = count
            last.change[place] = change
        leg = first_step(course, start, at) if thrown else step(course, at)
        thrown = False
        idle += 1
        if leg.length > _SHORTEST:
            if count == rows:
                return Followed(-1, 0, 0, 0.0)
            _write(legs, count, at, leg)
            count += 1
            idle = 0
        if not math.isfinite(leg.length) or idle > _MOST_IDLE:
            break
        at = leg.after
    _scale_rates(course, legs, count)
    return Followed(count, count, 0, 0.0)


def _place(course: Course, sections: Sections, at: State, starts: int) -> int:
    """Return the place for a start: one a mode in contact, one a lift-off, or one a flight."""
    if not math.isfinite(course.track.lift_off):
        return at.mode - 1
    if sections.lands:
        return _lift_off_index(course, at.phase)
    return starts % sections.lag


def _forget(last: LastStarts, places: int) -> None:
    """Empty all places."""
    for i in range(places):
        last.row[i] = -1


def _write(legs: Legs, row: int, at: State, leg: Step) -> None:
    """Write down a leg; normal speeds are scaled at the end."""
    legs.mode[row] = at.mode
    legs.cycle[row] = at.cycle
    legs.phase[row] = at.phase
    legs.length[row] = leg.length
    legs.position[row] = at.position
    legs.velocity[row] = at.velocity
    legs.displacement[row] = leg.displacement
    legs.end_velocity[row] = leg.velocity
    legs.rate[row] = at.rate
    legs.impact[row] = leg.impact


def _change(legs: Legs, row: int, now: State) -> float:
    """Return the distance between the states at the start of a leg and now."""
    turn = math.remainder(now.phase - legs.phase[row], TURN)
    return max(abs(turn), abs(now.velocity - legs.velocity[row]), abs(now.rate - legs.rate[row]))


def _start_without_rest(course: Course, at: State) -> float:
    """Return where this slide starts in the cycle without rest, Eqs. (18)-(19) and (59)-(61).

    NaN where the body does not settle there.
    """
    slips_both_ways = not math.isnan(course.forward.onset.k) and not math.isnan(course.back.onset.k)
    if math.isfinite(course.track.lift_off) or not slips_both_ways:
        return NAN
    loads = course.track.loads
    cycle = continuous_sliding(loads, course.forward, course.back)
    if math.isnan(cycle.y):
        return NAN
    half = QUARTER + cycle.y
    middle = middle_phase(loads, cycle)
    start = wrap(middle - half if at.mode == Mode.FORWARD else middle + half)
    return start if abs(math.remainder(start - at.phase, TURN)) < _NEAR else NAN


def _repeating(course: Course, legs: Legs, first: int, count: int, end: State) -> Followed:
    """Close the cycle that begins with a leg and ends where the body is now."""
    _scale_rates(course, legs, count)
    period = end.cycle - legs.cycle[first] + nearest_turn(end.phase - legs.phase[first])
    return Followed(count, first, period, end.position - legs.position[first])


def _scale_rates(course: Course, legs: Legs, count: int) -> None:
    """Bring normal speeds from A w n to A w."""
    n = course.track.loads.weight_normal
    for i in range(count):
        legs.rate[i] *= n
        legs.impact[i] *= n
