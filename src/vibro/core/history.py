"""The exact motion of one body from any start: a list of legs, and one steady cycle with a count.

The walk from leg to leg is compared with itself at the starts of slides, or of flights where the body hops.
Once it repeats, the legs between are a cycle, which is stored once, with a count, so that rounding does not
grow with the number of cycles. Lengths in A, speeds in A w, phases of the normal motion in radians.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from vibro.core.bounces import (
    ACCUMULATED,
    MOST_FLIGHTS,
    SHARP,
    Bounces,
    Covariance,
    Flights,
    after_landing,
    bounces,
    lands_at_jump,
    propagate,
    within,
)
from vibro.core.cells import find_nodes, number_of_nodes
from vibro.core.codes import Mode
from vibro.core.contact import continuous_sliding, middle_phase
from vibro.core.drive import Loads, free_along, free_normal, mix_of, phase_difference, trough_along
from vibro.core.flight import Bed, Flight, bed_load, bed_of, fly, lift_offs, next_take_off, no_bed
from vibro.core.legs import Leg, Track, contact_leg, mode_of, next_lift_off, next_onset, track_of
from vibro.core.numbers import (
    INF,
    LONGEST_CYCLE,
    MOST_CYCLES,
    NAN,
    PI,
    QUARTER,
    TURN,
    Bytes,
    Doubles,
    Integers,
    PathPoint,
    bisected,
    braked,
    positive_part,
    wrap,
    wrap_around,
)
from vibro.core.slides import Start, no_start, own_phase, resting_start, slide, start_inside, thresholds
from vibro.core.waves import (
    FORCE,
    NORMAL,
    SINE,
    at_break,
    nodes_of,
    normal_size,
)

# ------------------------------------------------------------------------------
# One body from leg to leg: rest, slide, flight, each with the state that it hands over.
#
# The state keeps the drive cycles completed and a phase in [0, 2 pi), so that no phase grows with time, and
# says what the body does from there on: a rest ends at the onset itself, so that rounding cannot send the
# body back to rest. Equation numbers are those of docs/theory. Lengths in A, speeds in A w, normal speeds
# over n = cos(beta)/G [A w n], phases of the normal motion in radians.

_MOST_FALLS: Final = (
    100_000  # of the search for a landing; each step is as far as the body cannot have landed
)

_SAME_ONSET: Final = 1e-6  # [rad] more than an arc sine next to 1 loses


class Course(NamedTuple):
    """A scene with what following a body through it needs.

    Attributes
    ----------
    track : Track
        Onsets, forcings and lift-off phase; the latter is inf where the body never hops.
    forward, back : Start
        Slides from rest; NaN where a body at rest never slips that way.
    rests : bool
        Whether friction can hold a body on the trough at all.
    bed : Bed
        The trough's normal motion; its lift-off phase is inf where the body never hops.
    restitution : float
        e.
    """

    track: Track
    forward: Start
    back: Start
    rests: bool
    bed: Bed
    restitution: float


class State(NamedTuple):
    """A body at the start of a leg.

    Attributes
    ----------
    cycle : int
        Drive cycles completed.
    phase : float
        Phase of the trough's motion normal to itself, in [0, 2 pi) [rad].
    mode : int
        ``Mode`` of the leg that begins.
    position, velocity : float
        Relative to the trough.
    rate : float
        Normal speed of a take-off [A w n], 0 in contact.
    """

    cycle: int
    phase: float
    mode: int
    position: float
    velocity: float
    rate: float


class Step(NamedTuple):
    """One leg, and what follows it.

    Attributes
    ----------
    length : float
        Phase from its start to its end [rad]; inf for a leg without end, and for a slide all else is NaN.
    displacement : float
        Displacement during it.
    velocity : float
        Relative velocity at its end, before an impact.
    impact : float
        Speed towards the trough at its end, 0 in contact [A w n].
    gain : float
        Change of the velocity after the leg per change of it before, in [0, 1].
    after : State
        The start of the next leg.
    """

    length: float
    displacement: float
    velocity: float
    impact: float
    gain: float
    after: State


def course_of(loads: Loads, restitution: float) -> Course:
    """Prepare a scene for following a body."""
    at = thresholds(loads)
    track = track_of(loads, restitution)
    rests = abs(loads.weight_tangential) < loads.static_friction * loads.weight_normal
    if loads.waves.kind != SINE:
        if not at.hops:  # bodies may be thrown onto it
            find_nodes(loads.waves, NORMAL, mix_of(loads, NORMAL))
            find_nodes(loads.waves, FORCE, mix_of(loads, FORCE))
        bed = bed_of(loads) if at.hops else no_bed(loads)
        track = track._replace(lift_off=bed.lift_off)
        return Course(track, no_start(), no_start(), rests, bed, restitution)
    # a line that presses the body down more than it pushes has a window both ways, but one is not in contact
    slips_forward = rests and at.forward and not math.isnan(track.forward_onset)
    slips_back = rests and at.back and not math.isnan(track.back_onset)
    forward = resting_start(loads, at, 1.0) if slips_forward else no_start()
    back = resting_start(loads, at, -1.0) if slips_back else no_start()
    if rests:
        track = track._replace(
            forward_onset=_onset(loads, 1.0, forward, track.forward_onset),
            back_onset=_onset(loads, -1.0, back, track.back_onset),
        )
    if not at.hops:
        track = track._replace(lift_off=INF)
    return Course(track, forward, back, rests, bed_of(loads) if at.hops else no_bed(loads), restitution)


def _crest(loads: Loads, way: float) -> float:
    """Phase at which the load of slides in a direction is largest."""
    return QUARTER - own_phase(loads, way, loads.kinetic_friction)


def _onset(loads: Loads, way: float, start: Start, coarse: float) -> float:
    """Phase at which slides from rest begin, to rounding; NaN if they never do.

    ``coarse`` is that phase by an arc sine, which loses half of its digits where a window is short. The start
    of the slide loses more where kinetic friction is negligible beside static friction, and the load beside
    both.
    """
    if math.isnan(start.onset.c):
        return NAN
    sharp = wrap(_crest(loads, way) - start.onset.c)
    return sharp if abs(math.remainder(sharp - coarse, TURN)) <= _SAME_ONSET else coarse


def starting(course: Course, phase: float, velocity: float) -> State:
    """Place a body on the trough with a velocity, at a phase of the trough's motion along itself.

    Where the trough cannot bear it, N < 0, it leaves at once.
    """
    loads = course.track.loads
    phase = at_break(loads.waves, phase + phase_difference(loads))
    mode = mode_of(loads, phase, velocity, loads.static_friction)
    if math.isfinite(course.track.lift_off) and bed_load(course.bed, phase) < 0.0:
        mode = Mode.FLIGHT
    return State(0, phase, mode, 0.0, velocity, 0.0)


class Launch(NamedTuple):
    """How a body starts.

    Attributes
    ----------
    phase : float
        Of the trough's motion along itself [rad].
    velocity : float
        Along the trough, relative to it.
    height : float
        Above the trough, >= 0.
    rate : float
        Normal speed away from it [A w n].
    """

    phase: float
    velocity: float
    height: float
    rate: float


def launched(course: Course, start: Launch) -> State:
    """Place a body at its start: in flight, or on the trough as ``starting`` does."""
    if start.height == 0.0 and start.rate == 0.0:
        return starting(course, start.phase, start.velocity)
    loads = course.track.loads
    phase = at_break(loads.waves, start.phase + phase_difference(loads))
    return State(0, phase, Mode.FLIGHT, 0.0, start.velocity, start.rate)


def first_step(course: Course, start: Launch, now: State) -> Step:
    """Follow a body through its first leg: from a height, or with an impact where it starts downwards."""
    if start.height > 0.0:
        return _landed(course, now, _fall(course, now, start.height))
    if start.rate < 0.0:
        return _landed(course, now, Flight(0.0, -start.rate))
    return step(course, now)


def _fall(course: Course, now: State, height: float) -> Flight:
    """Fly from a height to the first landing.

    The body never accelerates downwards by more than the largest load that it would have on the trough. So it
    cannot land before a phase that this bounds from below; the bounds tend to the first landing, as Newton's
    iteration does.
    """
    loads = course.track.loads
    n, most = loads.weight_normal, loads.weight_normal + _largest_push(loads)
    s = 0.0
    for _ in range(_MOST_FALLS):
        off = free_normal(loads, now.phase, now.rate * n, s)
        left = height + off.path
        if left <= 0.0 < s:
            break
        rate = off.velocity
        root = math.sqrt(rate * rate + 2.0 * most * left)
        onward = 2.0 * left / (root - rate) if rate < 0.0 else (rate + root) / most
        if not s + onward > s:
            break
        s += onward
    return Flight(s, max(-free_normal(loads, now.phase, now.rate * n, s).velocity / n, 0.0))


def _largest_push(loads: Loads) -> float:
    """Return a bound of -B, by which the trough presses a body beyond its weight."""
    return loads.drive_normal if loads.waves.kind == SINE else normal_size(loads.waves)


def nearest_turn(phase: float) -> int:
    """Round a phase to whole turns."""
    return int(math.floor(phase / TURN + 0.5))


def step(course: Course, now: State) -> Step:
    """Follow a body through one leg."""
    if now.mode == Mode.FLIGHT:
        return _landed(course, now, _flight(course, now))
    return _in_contact(course, now)


def _in_contact(course: Course, now: State) -> Step:
    """Rest or slide until the next onset, the end of the slide or the lift-off."""
    track = course.track
    hops = math.isfinite(track.lift_off)
    leaving = next_lift_off(track, now.phase)
    limit = leaving.wait if hops else INF
    leg = _sharpened(course, now, contact_leg(track, now.mode, now.phase, now.velocity, limit))
    position = now.position + leg.displacement
    if not math.isfinite(leg.length):
        endless = State(now.cycle, NAN, leg.next_mode, position, leg.velocity, 0.0)
        return Step(leg.length, leg.displacement, leg.velocity, 0.0, leg.gain, endless)
    leaves = hops and leg.length >= limit
    mode = Mode.FLIGHT if leaves else leg.next_mode
    end = now.phase + leg.length
    # a rest ends at the onset itself, a contact at the lift-off itself
    phase = at_break(track.loads.waves, end)
    if leaves:
        phase = leaving.phase
    elif now.mode == Mode.REST:
        phase = next_onset(track, 1.0 if mode == Mode.FORWARD else -1.0, now.phase).phase
    after = State(now.cycle + nearest_turn(end - phase), phase, mode, position, leg.velocity, 0.0)
    return Step(leg.length, leg.displacement, leg.velocity, 0.0, leg.gain, after)


def _sharpened(course: Course, now: State, leg: Leg) -> Leg:
    """Solve a slide from rest in a contact scene by the form that does not cancel for short ones."""
    track = course.track
    if now.mode == Mode.REST or now.velocity != 0.0 or math.isfinite(track.lift_off):
        return leg
    way = 1.0 if now.mode == Mode.FORWARD else -1.0
    start = course.forward if way > 0.0 else course.back
    begins = track.forward_onset if way > 0.0 else track.back_onset
    onset = start.onset
    if math.isnan(onset.k):
        return leg
    if now.phase != begins:
        onset = start_inside(wrap_around(_crest(track.loads, way) - now.phase), onset.k, onset.load)
    end = slide(onset)
    if not (end.settled and math.isfinite(end.half_length)):
        return leg
    return leg._replace(length=2.0 * end.half_length, displacement=way * end.displacement)


def _landed(course: Course, now: State, hop: Flight) -> Step:
    """Land, and go through the bounces after it where they accumulate."""
    loads = course.track.loads
    touch = now.phase + hop.length
    landed = after_landing(course.bed, touch, hop.impact, course.restitution, ACCUMULATED)
    length = hop.length + landed.length
    path, velocity = free_along(loads, now.phase, now.velocity, length)
    # the impact takes as much speed as friction has impulse for, Eq. (31)
    slowed = braked(velocity, loads.kinetic_friction * loads.weight_normal * landed.impulse)
    end = touch + landed.length
    phase = at_break(loads.waves, end)
    held = course.track.landed_friction
    mode = mode_of(loads, phase, slowed, held) if landed.contact else Mode.FLIGHT
    if landed.contact and lands_at_jump(course.bed, phase):
        mode = Mode.FLIGHT
    after = State(
        now.cycle + nearest_turn(end - phase), phase, mode, now.position + path, slowed, landed.take_off
    )
    return Step(length, path, velocity, hop.impact, 1.0 if slowed != 0.0 else 0.0, after)


def _flight(course: Course, now: State) -> Flight:
    """Fly; a take-off from contact at the lift-off phase has the sharper solution."""
    if not math.isfinite(course.track.lift_off):
        return _fall(course, now, 0.0)
    lifted = now.rate == 0.0 and now.phase == next_take_off(course.bed, now.phase).phase
    return fly(course.bed, now.phase, now.rate, lifted)


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
    return max(max(sections.lag, _KINDS), min(lift_offs(course.bed), LONGEST_CYCLE))


def _lift_off_index(course: Course, phase: float) -> int:
    """Return which zero of the normal load a lift-off is, modulo the number of places."""
    waves = course.bed.waves
    for i in range(lift_offs(course.bed)):
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


# ------------------------------------------------------------------------------
# When a body first reaches a position: it is followed, and whole cycles are added once it has settled.
#
# Equation numbers are those of docs/theory. Lengths in A, speeds in A w, normal speeds over n = cos(beta)/G
# [A w n], phases of the normal motion in radians.

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


class _Memory(NamedTuple):
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


class _Comparison(NamedTuple):
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
    memory = _Memory(at._replace(mode=0), 0, 1.0, 0.0)
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
                memory = _Memory(at, 0, 1.0, at.position)
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


def _compare(course: Course, length: float, steady: float, at: State, memory: _Memory) -> _Comparison:
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
        return _Comparison(at, never)
    ahead = min((length - top - walked) / advance, 2.0 * MOST_CYCLES)
    if not ahead >= 2.0:
        return _Comparison(at, never)
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
    return _Comparison(later, never)


def _highest(course: Course, now: State, leg: Step) -> float:
    """Return a position that is not passed during a leg."""
    if now.mode != Mode.FLIGHT:
        return max(now.position, leg.after.position)
    return now.position + _fastest(course.track.loads, now, leg) * leg.length


def _fastest(loads: Loads, now: State, leg: Step) -> float:
    """Return a velocity that is not exceeded during a flight, >= 0."""
    fastest = now.velocity + loads.drive_tangential * (1.0 + trough_along(loads, now.phase).velocity)
    return positive_part(fastest + positive_part(-loads.weight_tangential) * leg.length)


def _propagated(course: Course, now: State, leg: Step, errors: Covariance) -> Covariance:
    """Propagate the rounding of flights; a contact ends at the lift-off, whenever it began."""
    if now.mode != Mode.FLIGHT:
        return Covariance(0.0, 0.0, 0.0)
    flown = Flight(leg.length, leg.impact)
    return propagate(course.bed, course.restitution, now.phase, now.rate, flown, 0.0, errors)


class _Approach(NamedTuple):
    """A leg on which the body may arrive: its loads, the state at its start, and how far the target is."""

    loads: Loads
    now: State
    target: float


def _moved(path: _Approach, s: float) -> PathPoint:
    """Return the path after a phase ``s`` of a flight or a forward slide, and the velocity there.

    Friction moves a body by mu_d times what the normal motion of a body without support would, N = -eta''.
    """
    loads, now = path.loads, path.now
    along = free_along(loads, now.phase, now.velocity, s)
    if now.mode == Mode.FLIGHT:
        return along
    off, mu_d = free_normal(loads, now.phase, 0.0, s), loads.kinetic_friction
    return PathPoint(along.path + mu_d * off.path, along.velocity + mu_d * off.velocity)


def _missing(path: _Approach, s: float) -> float:
    """Return how far the target is after a phase ``s``."""
    return path.target - _moved(path, s).path


def _speed(path: _Approach, s: float) -> float:
    """Return the velocity after a phase ``s``."""
    return _moved(path, s).velocity


def _reach(course: Course, length: float, now: State, leg: Step) -> float:
    """Return the phase from the start of a leg to the arrival; NaN if it does not arrive during it."""
    path = _Approach(course.track.loads, now, length - now.position)
    if now.mode == Mode.FORWARD and not (math.isfinite(leg.length) and leg.after.position < length):
        return _reach_sliding(path, leg.length)
    if now.mode == Mode.FLIGHT and _highest(course, now, leg) >= length:
        return _reach_flying(path, leg.length, _fastest(course.track.loads, now, leg))
    return NAN


def _reach_sliding(path: _Approach, length: float) -> float:
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


def _reach_flying(path: _Approach, length: float, fastest: float) -> float:
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


def _next_zero(path: _Approach, low: float) -> float:
    """Return where the acceleration next changes its sign; inf where it never does."""
    found, loads, waves, phase = INF, path.loads, path.loads.waves, path.now.phase
    if waves.kind != SINE:
        for i in range(number_of_nodes(waves, FORCE)):
            found = min(found, _next(waves.number[nodes_of(waves, FORCE) + i] - phase, low))
    elif abs(loads.weight_tangential) <= loads.drive_tangential and loads.drive_tangential > 0.0:
        kappa = math.asin(loads.weight_tangential / loads.drive_tangential)
        own = phase - phase_difference(loads)
        found = min(_next(kappa - own, low), _next(PI - kappa - own, low))
    return found


def _next(zero: float, low: float) -> float:
    """Return where a zero of the acceleration, which comes once a turn, comes next."""
    nearest = low + wrap(zero - low)
    return nearest if nearest > low + _SETTLED * (1.0 + low) else nearest + TURN
