"""One body from leg to leg: rest, slide, flight, each with the state that it hands over.

The state keeps the drive cycles completed and a phase in [0, 2 pi), so that no phase grows with time, and
says what the body does from there on: a rest ends at the onset itself, so that rounding cannot send the body
back to rest. Equation numbers are those of docs/theory. Lengths in A, speeds in A w, normal speeds over
n = cos(beta)/G [A w n], phases of the normal motion in radians.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from vibro.core.cells import find_nodes
from vibro.core.codes import Mode
from vibro.core.drives import Loads, free_along, free_normal, mix_of, phase_difference
from vibro.core.elementary import INF, NAN, QUARTER, TURN, braked, wrap, wrap_around
from vibro.core.flight import (
    ACCUMULATED,
    Bed,
    Flight,
    after_landing,
    bed_load,
    bed_of,
    flight,
    lands_at_jump,
    lift_off_flight,
    next_take_off,
    no_bed,
)
from vibro.core.legs import Leg, Track, contact_leg, mode_of, next_lift_off, next_onset, track_of
from vibro.core.slide import Onset, slide, start_inside
from vibro.core.waves import FORCE, NORMAL, SINE, at_break, normal_size
from vibro.core.windows import Start, own_phase, resting_start, thresholds

__all__ = [
    "Course",
    "Launch",
    "State",
    "Step",
    "course_of",
    "first_step",
    "launched",
    "nearest_turn",
    "starting",
    "step",
]

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
        return Course(track, _no_start(), _no_start(), rests, bed, restitution)
    # a line that presses the body down more than it pushes has a window both ways, but one is not in contact
    slips_forward = rests and at.forward and not math.isnan(track.forward_onset)
    slips_back = rests and at.back and not math.isnan(track.back_onset)
    forward = resting_start(loads, at, 1.0) if slips_forward else _no_start()
    back = resting_start(loads, at, -1.0) if slips_back else _no_start()
    if rests:
        track = track._replace(
            forward_onset=_onset(loads, 1.0, forward, track.forward_onset),
            back_onset=_onset(loads, -1.0, back, track.back_onset),
        )
    if not at.hops:
        track = track._replace(lift_off=INF)
    return Course(track, forward, back, rests, bed_of(loads) if at.hops else no_bed(loads), restitution)


def _no_start() -> Start:
    """Stand for the slide of a body that never slips in a direction."""
    return Start(Onset(NAN, NAN, NAN, NAN, NAN, NAN, NAN), NAN, NAN, NAN)


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
        return _in_flight(course, now)
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


def _in_flight(course: Course, now: State) -> Step:
    """Fly to the next landing."""
    return _landed(course, now, _flight(course, now))


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
    if now.rate == 0.0 and now.phase == next_take_off(course.bed, now.phase).phase:
        return lift_off_flight(course.bed, now.phase)
    return flight(course.bed, now.phase, now.rate)
