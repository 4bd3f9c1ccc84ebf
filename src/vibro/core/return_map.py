"""Return map of hopping bodies: from the velocity at a lift-off to that at the next one like it, Eq. (36).

The normal motion does not depend on sliding, so that the flights of a cycle are known before
(``bounces.py``). Trajectories cannot cross, only merge: the map never decreases. It is piecewise smooth
with a slope of at most 1, as a turn under friction, a rest and an impact all bring velocities closer, and
jumps upwards only, where static friction holds one body and not its neighbour. Lengths in A, speeds in A w,
phases in radians.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from vibro.core.bounces import BOUNCE, Flights
from vibro.core.cells import behind, number_of_nodes
from vibro.core.codes import MOST_LETTERS, Mode, Status
from vibro.core.drive import Loads, mix_of, normal_load, phase_difference, trough_along
from vibro.core.legs import Track, contact_leg, mode_of, next_lift_off
from vibro.core.numbers import (
    EPS,
    FEW_ULP,
    INF,
    NAN,
    PI,
    TURN,
    Bytes,
    Doubles,
    braked,
    free_motion,
    until,
    wrap,
)
from vibro.core.waves import FORCE, SINE, STATIC_BACK, STATIC_FORWARD, at_break, depart, moved, nodes_of

#: [1] Legs of one contact, which lasts less than a drive cycle: four and more for each harmonic, or piece.
MOST_LEGS: Final = 20_000
#: [rad] An onset this close to the lift-off is at it: where a load jumps both are at the same phase.
CLOSE: Final = 1e-14
# Of marks: two numbers without a common divisor, whose product an int64 has room for; the second is prime.
_RADIX: Final = 131
_MARKS: Final = 2**55 - 55
_FULL: Final = 5 ** (MOST_LETTERS - 1)  # [1] a pattern from here on has no room for another digit


_NONE: Doubles = memoryview(b"").cast("d")
_NO_LETTERS: Bytes = memoryview(b"").cast("b")


class Hops(NamedTuple):
    """What each flight and the impact after it do to the relative velocity, whatever that is.

    Scratch memory of one scene; one row per flight.

    Attributes
    ----------
    gain, length, shift : Doubles
        Velocity added in flight, duration [rad], and displacement that this velocity adds.
    brake : Doubles
        Largest change of velocity by friction in the impact, Eq. (31).
    high, low : Doubles
        Extremes of the velocity added on the way, 0 at take-off included.
    landing, rest : Doubles
        Phase at which a contact amid the flights begins, and its duration; 0 where the body takes off at
        once. The contact at the end of a cycle is an argument of ``return_map``.
    """

    gain: Doubles
    length: Doubles
    shift: Doubles
    brake: Doubles
    high: Doubles
    low: Doubles
    landing: Doubles
    rest: Doubles


def no_hops() -> Hops:
    """Stand for the flights of a cycle without any."""
    return Hops(_NONE, _NONE, _NONE, _NONE, _NONE, _NONE, _NONE, _NONE)


class Return(NamedTuple):
    """One cycle from a given velocity at its first lift-off.

    Attributes
    ----------
    velocity : float
        Relative velocity at the next such lift-off.
    slope : float
        Its derivative, in [0, 1]; 0 where the body stops on the way and so forgets its velocity.
    friction : float
        Change of the velocity by friction, as long as the body does not stop.
    displacement, peak : float
        Displacement, and largest speed.
    delay : float
        Derivative of the displacement with respect to the velocity at the start.
    pattern : int
        Legs of the cycle, as digits of ``Mode`` to base 5; of more than ``MOST_LETTERS`` legs a negative mark
        of all of them.
    number : int
        How many legs there are.
    forward, back, rest : bool
        Whether there are slides forward, slides back, and rests among them.
    settled : bool
        Whether every slide was solved.
    spare : float
        The least of its legs in contact.
    """

    velocity: float
    slope: float
    friction: float
    displacement: float
    peak: float
    delay: float
    pattern: int
    number: int
    forward: bool
    back: bool
    rest: bool
    settled: bool
    spare: float


def _begun(velocity: float) -> Return:
    """Begin a cycle."""
    return Return(velocity, 1.0, 0.0, 0.0, abs(velocity), 0.0, 0, 0, False, False, False, True, INF)


def write_hop(loads: Loads, phase: float, length: float, impulse: float, hops: Hops, row: int) -> None:
    """Integrate the free motion along the trough over one flight, Eq. (30), into a row of ``hops``.

    Parameters
    ----------
    loads : Loads
        Groups of the scene.
    phase, length : float
        Take-off phase and duration of the flight [rad].
    impulse : float
        Normal impulse of its landing [A w n].
    hops : Hops
        Written at ``row``, without a contact after the landing.
    row : int
        Where.
    """
    if loads.waves.kind != SINE:
        _write_over_waves(loads, phase, length, impulse, hops, row)
        return
    a, t = loads.drive_tangential, loads.weight_tangential
    p = phase - phase_difference(loads)
    sine, cosine = math.sin(p), math.cos(p)
    flown = free_motion(a, t, sine, cosine, 0.0, length)
    high, low = max(flown.velocity, 0.0), min(flown.velocity, 0.0)
    # Inside the flight the velocity is extreme where the load along the trough changes sign. Minima, and
    # maxima, change monotonically from one turn to the next: the first and the last of each suffice.
    if abs(t) < a:
        kappa = math.asin(t / a)
        for i in range(2):
            first = wrap((PI - kappa if i == 0 else kappa) - p)
            if first <= length:
                v = free_motion(a, t, sine, cosine, 0.0, first).velocity
                high, low = max(high, v), min(low, v)
                last = first + TURN * math.floor((length - first) / TURN)
                if last > first:
                    v = free_motion(a, t, sine, cosine, 0.0, last).velocity
                    high, low = max(high, v), min(low, v)
    _write(loads, flown.velocity, length, flown.path, impulse, hops, row)
    hops.high[row] = high
    hops.low[row] = low


def write_hops(loads: Loads, flights: Flights, hops: Hops, first: int, last: int) -> None:
    """Integrate the motion along the trough over flights and the contacts after them, into the same rows."""
    for row in range(first, last):
        write_hop(loads, flights.phase[row], flights.length[row], flights.impulse[row], hops, row)
        hops.landing[row], hops.rest[row] = flights.landing[row], flights.rest[row]


def _write_over_waves(
    loads: Loads, phase: float, length: float, impulse: float, hops: Hops, row: int
) -> None:
    """Do the same for a drive beyond one harmonic; extremes lie where the load along changes its sign."""
    waves, mix = loads.waves, mix_of(loads, FORCE)
    phase = wrap(phase)
    value = depart(waves, mix, phase).load
    flown = moved(waves, mix, phase, value, length)
    high, low = max(flown.velocity, 0.0), min(flown.velocity, 0.0)
    for i in range(number_of_nodes(waves, FORCE)):
        first = wrap(waves.number[nodes_of(waves, FORCE) + i] - phase)
        last = first + TURN * math.floor((length - first) / TURN)
        for k in range(2):
            s = first if k == 0 else last
            if s <= length and (k == 0 or last > first):
                v = moved(waves, mix, phase, value, s).velocity
                high, low = max(high, v), min(low, v)
    _write(loads, flown.velocity, length, flown.path, impulse, hops, row)
    hops.high[row] = high
    hops.low[row] = low


def _write(
    loads: Loads, gain: float, length: float, shift: float, impulse: float, hops: Hops, row: int
) -> None:
    """Put what a flight does into a row, without a contact after the landing."""
    hops.gain[row] = gain
    hops.length[row] = length
    hops.shift[row] = shift
    hops.brake[row] = loads.kinetic_friction * loads.weight_normal * impulse
    hops.landing[row] = 0.0
    hops.rest[row] = 0.0


def return_map(
    track: Track, hops: Hops, first: int, last: int, landing: float, rest: float, velocity: float
) -> Return:
    """Follow a body through one cycle of its normal motion, without writing its legs, as ``spell``."""
    return spell(track, hops, first, last, landing, rest, velocity, _NO_LETTERS, 0)


def spell(
    track: Track, hops: Hops, first: int, last: int, landing: float, rest: float, velocity: float,
    letters: Bytes, room: int,
) -> Return:  # fmt: skip
    """Follow a body through one cycle of its normal motion, and write its legs.

    Parameters
    ----------
    track : Track
        Scene.
    hops : Hops
        Its flights.
    first, last : int
        Rows of the flights of the cycle: from ``first`` to before ``last``.
    landing, rest : float
        Phase at which the contact after the last flight begins, and its duration, 0 without one [rad].
    velocity : float
        Relative velocity at the first take-off.
    letters, room : Bytes, int
        The first ``room`` legs are written there, each as a ``Mode``.

    Returns
    -------
    Return
        The cycle; it counts legs beyond the room too.
    """
    out = _begun(velocity)
    for row in range(first, last):
        v = out.velocity
        top = max(abs(v + hops.high[row]), abs(v + hops.low[row]))
        path = v * hops.length[row] + hops.shift[row]
        v = landed(hops, row, v)
        pattern, number = out.pattern, out.number
        if not _is_chained(track, hops, first, row):
            if number < room:
                letters[number] = Mode.FLIGHT
            pattern, number = _append(pattern, Mode.FLIGHT), number + 1
        out = Return(
            v,
            out.slope if abs(v) > 0.0 else 0.0,
            out.friction - math.copysign(hops.brake[row], v),
            out.displacement + path,
            max(out.peak, top),
            out.delay + out.slope * hops.length[row],
            pattern,
            number,
            out.forward,
            out.back,
            out.rest,
            out.settled,
            out.spare,
        )
        if hops.rest[row] > 0.0:
            out = _contact(
                track, out, hops.landing[row], hops.rest[row], track.landed_friction, letters, room
            )
    if rest > 0.0:
        out = _contact(track, out, landing, rest, track.landed_friction, letters, room)
    return out


def landed(hops: Hops, row: int, velocity: float) -> float:
    """Return the velocity after a flight and its impact; one that the impact stops keeps its sign."""
    return braked(velocity + hops.gain[row], hops.brake[row])


def _contact(
    track: Track, out: Return, landing: float, rest: float, friction: float, letters: Bytes, room: int
) -> Return:
    """Slide and rest from a landing until the lift-off; ``friction`` holds a body that stands there."""
    phase, left = landing, rest
    mode = mode_of(track.loads, landing, out.velocity, friction)
    for _ in range(MOST_LEGS):
        leg = contact_leg(track, mode, phase, out.velocity, left)
        if out.number < room:
            letters[out.number] = mode
        out = Return(
            leg.velocity,
            out.slope * leg.gain,
            out.friction - track.loads.kinetic_friction * leg.impulse,
            out.displacement + leg.displacement,
            max(out.peak, leg.top),
            out.delay + out.slope * leg.length,
            _append(out.pattern, mode),
            out.number + 1,
            out.forward or mode == Mode.FORWARD,
            out.back or mode == Mode.BACK,
            out.rest or mode == Mode.REST,
            out.settled and leg.settled,
            min(out.spare, leg.spare),
        )
        if not leg.length < left - CLOSE:
            return out
        phase, left, mode = at_break(track.loads.waves, phase + leg.length), left - leg.length, leg.next_mode
    return out._replace(settled=False)


def _is_chained(track: Track, hops: Hops, first: int, row: int) -> bool:
    """Return whether a flight is one with that before it, as a chain of short ones is one flight.

    A trough that moves along a sine has no such chains.
    """
    if track.loads.waves.kind == SINE or row == first:
        return False
    return hops.length[row] < BOUNCE and not hops.rest[row - 1] > 0.0


def _append(pattern: int, digit: int) -> int:
    """Append a leg to a pattern; one that is full turns into a mark."""
    if 0 <= pattern < _FULL:
        return 5 * pattern + digit
    return -(5 * (1 + _RADIX * (abs(pattern) % _MARKS) % _MARKS) + digit)


class Release(NamedTuple):
    """How a body that was put on the trough first takes off.

    Attributes
    ----------
    aloft : bool
        Whether the trough cannot bear it there, so that it takes off at once.
    phase : float
        Phase of the take-off: that of the release if ``aloft``, else the lift-off [rad].
    velocity : float
        Relative velocity along the trough at the take-off.
    """

    aloft: bool
    phase: float
    velocity: float


def release(track: Track) -> Release:
    """Follow a body at rest, at phase 0 of the trough's motion along itself, until it takes off; K > 1.

    Along a line phase 0 is followed by a rest until the forward onset, and by the slide of Eq. (35).
    """
    loads, at = track.loads, track.forward
    if loads.line:
        start, end = track.forward_onset, track.lift_off
        velocity = 0.0
        if start < end:
            # from the rates at the start, as the slide of a steep drive is short: nothing of order 1 cancels
            sine, cosine = math.sin(start), math.cos(start)
            velocity = free_motion(at.amplitude, at.drag, sine, cosine, 0.0, end - start).velocity
        return Release(False, end, velocity)
    return laid(track, phase_difference(loads), 0.0, loads.static_friction)


def laid(track: Track, phase: float, velocity: float, friction: float) -> Release:
    """Follow a body in contact, from a phase of the normal motion, until it takes off; K > 1.

    It may slide either way, and more than once; ``friction`` holds it where it stands at first. Where the
    trough cannot bear it, it takes off at once, with the trough's velocity; the flight of one at the lift-off
    phase itself begins there.
    """
    begins = next_lift_off(track, phase)
    if begins.wait == 0.0:
        return Release(False, begins.phase, velocity)
    if normal_load(track.loads, phase) < 0.0:
        return Release(True, wrap(phase), velocity)
    slid = in_contact(track, phase, begins.wait, velocity, friction)
    return Release(False, begins.phase, slid.velocity)


def in_contact(track: Track, phase: float, length: float, velocity: float, friction: float) -> Return:
    """Follow a body in contact for a phase ``length``; ``friction`` holds it where it stands at first."""
    return _contact(track, _begun(velocity), phase, length, friction, _NO_LETTERS, 0)


def with_same_ground_speed(loads: Loads, velocity: float, phase: float, other: float) -> float:
    """Return the velocity relative to the trough of the same velocity over the ground, at another phase."""
    if phase == other:
        return velocity
    here, there = trough_along(loads, phase), trough_along(loads, other)
    return velocity + loads.drive_tangential * (here.velocity - there.velocity)


# ------------------------------------------------------------------------------
# Fixed points of the return map, to which the orbits of hopping bodies lead.
#
# The map never decreases, Eq. (36), so that its orbits are monotone and end at the first fixed point on their
# way. A cycle either has a stop, a rest or an impact that takes all of the velocity, or it has none.
#
# * After its last stop a cycle is the same whatever was before: the few velocities that can repeat are known
#   beforehand.
# * Without a stop the drive adds nothing over a cycle. What friction takes off grows with the velocity, as
#   faster bodies are ahead at every phase, so that there is one fixed point at most; and none where gravity
#   along the trough exceeds kinetic friction. Where there is neither, every such velocity repeats.
#
# Lengths in A, speeds in A w, phases in radians.

#: [1] Rounding of one evaluation of the return map, relative to the velocities in it.
ROUNDING: Final = 16.0 * EPS

# [1] Distance from the fixed point at which a cycle is closed, over the velocities in it.
_CLOSED: Final = 1e-13
_DISTURBED: Final = 4.0 * _CLOSED  # [1] distance of another body from a cycle, over the velocities in it

_MOST_EVALUATIONS: Final = 200  # [1] of the return map; the slowest orbits need the most
_NEWTONS: Final = 8  # steps of Newton's that are not judged

# [1] Where an onset lies close to the lift-off, its phase is known to the root of an ulp only, and so is the
# velocity at the lift-off after it. A velocity that returns within this distance is replaced by its image and
# checked again.
_NEAR: Final = 1e-6

_SEPARATE: Final = 1e-9  # [A w] fixed points farther apart than this are two
# [1] mu_d over mu_s from which on a search has found no second fixed point of drives of one harmonic.
_MOST_COEXISTENCE: Final = 0.75


class HoppingCycle(NamedTuple):
    """One cycle of the normal motion: its flights and contact, and the sizes of velocities in it.

    Attributes
    ----------
    track : Track
        Scene.
    first, last : int
        Rows of its flights in ``Hops``: from ``first`` to before ``last``.
    landing, rest : float
        Phase at which the contact after them begins, and its duration, 0 without one [rad].
    bounded, edge : bool
        Whether kinetic friction holds gravity along the trough, and whether rounding decides that.
    neutral : bool
        Whether there is neither of them.
    bound : float
        Limit of the velocity at the first take-off at any fixed point.
    fall : float
        Velocity that gravity along the trough adds in a cycle.
    drive : float
        Velocity of the trough.
    forces : float
        Largest change of the velocity by gravity and friction in a cycle.
    """

    track: Track
    first: int
    last: int
    landing: float
    rest: float
    bounded: bool
    edge: bool
    neutral: bool
    bound: float
    fall: float
    drive: float
    forces: float


def hopping_cycle(
    track: Track, first: int, last: int, landing: float, rest: float, duration: float
) -> HoppingCycle:
    """Measure a cycle that lasts a phase of ``duration``, whole drive cycles [rad].

    The body stops, or turns round, once in a cycle; only the drive and gravity can add velocity after that.
    Over a cycle the normal impulse is that of the weight, Eq. (29), so that friction adds 2 pi mu_d n at most
    in every drive cycle.
    """
    loads = track.loads
    slope, friction = abs(loads.weight_tangential), loads.kinetic_friction * loads.weight_normal
    edge = friction > 0.0 and abs(slope - friction) <= FEW_ULP * friction
    return HoppingCycle(
        track=track,
        first=first,
        last=last,
        landing=landing,
        rest=rest,
        bounded=edge or slope < friction,
        edge=edge,
        neutral=friction == 0.0 and slope == 0.0,
        bound=2.0 * loads.drive_tangential + duration * slope,
        fall=-loads.weight_tangential * duration,
        drive=loads.drive_tangential,
        forces=duration * (friction + slope),
    )


def cycle_from(cycle: HoppingCycle, hops: Hops, velocity: float) -> Return:
    """Follow a body through the cycle, from its velocity at the first take-off."""
    return return_map(cycle.track, hops, cycle.first, cycle.last, cycle.landing, cycle.rest, velocity)


def write_letters(cycle: HoppingCycle, hops: Hops, velocity: float, out: Bytes, room: int) -> int:
    """Write the legs of the cycle, as ``spell``, also where they are more than ``out`` has room for.

    Returns their number. The pattern of a ``Return`` has room for few.
    """
    landing, rest = cycle.landing, cycle.rest
    return spell(cycle.track, hops, cycle.first, cycle.last, landing, rest, velocity, out, room).number


def has_stop(now: Return) -> bool:
    """Return whether the body stops in a cycle, and so forgets its velocity."""
    return now.slope == 0.0


def _size(cycle: HoppingCycle, velocity: float) -> float:
    """Return the size of the numbers whose sum is the velocity after a cycle."""
    return cycle.drive + cycle.forces + abs(velocity)


def _apart(cycle: HoppingCycle, velocity: float) -> float:
    """Return the distance below which two velocities at the first take-off are one."""
    return ROUNDING * (cycle.drive + abs(velocity))


def _downhill(cycle: HoppingCycle) -> float:
    """Return the direction of gravity along the trough, 0 on a level one."""
    t = cycle.track.loads.weight_tangential
    return -math.copysign(1.0, t) if t != 0.0 else 0.0


class Orbit(NamedTuple):
    """Where an orbit leads.

    Attributes
    ----------
    velocity : float
        At the first take-off of the cycle.
    cycle : Return
        The cycle from there.
    status : int
        ``OK``, ``BOUNDARY``, ``RUNAWAY`` or ``UNRESOLVED``.
    """

    velocity: float
    cycle: Return
    status: int


def _settled(cycle: HoppingCycle, hops: Hops, velocity: float, now: Return, status: int) -> Orbit:
    """Form the end of an orbit, which is unresolved where a slide of its cycle is.

    What follows a stop has the digits of the drive's small velocities, which friction does not drown: where
    they are fewer in the velocity than in its image, take the image.
    """
    if has_stop(now) and abs(now.velocity - velocity) > _apart(cycle, velocity):
        image = cycle_from(cycle, hops, now.velocity)
        if has_stop(image):
            velocity, now = now.velocity, image
    return Orbit(velocity, now, status if now.settled else Status.UNRESOLVED)


class _Change(NamedTuple):
    """Which way an orbit goes on, by how much Newton's iteration would, and whether the cycle is closed."""

    rises: bool
    newton: float
    closed: bool


def _change(cycle: HoppingCycle, here: float, now: Return) -> _Change:
    """Compare a velocity with its image.

    Without a stop gravity and friction alone change the velocity, and they are known without the cancellation
    in the difference of two velocities.
    """
    if has_stop(now):
        change, noise = now.velocity - here, ROUNDING * _size(cycle, here)
    else:
        change, noise = cycle.fall + now.friction, ROUNDING * cycle.forces
    newton = abs(change) / (1.0 - now.slope) if now.slope < 1.0 else INF
    closed = abs(change) <= noise or newton <= _CLOSED * (cycle.drive + abs(here))
    return _Change(change > 0.0, newton, closed)


def orbit_from(cycle: HoppingCycle, hops: Hops, start: float) -> Orbit:
    """Find the fixed point that a body reaches which enters the cycle with the velocity ``start``.

    Returns
    -------
    Orbit
        ``BOUNDARY`` where kinetic friction just holds gravity along the trough and the body keeps sliding,
        or neither of them acts and it never stops; ``RUNAWAY`` where it gains speed for ever.
    """
    end = _orbit_held(cycle, hops, start) if cycle.bounded else _orbit_until_stop(cycle, hops, start)
    if end.status == Status.OK and (cycle.edge or cycle.neutral):
        # Where friction just holds gravity, or neither acts, a body may stop in its cycle by rounding alone.
        # It does not if a body that slides a little faster stops too, downhill or either way.
        beside = _DISTURBED * _size(cycle, end.velocity)
        for i in range(2):
            way = _downhill(cycle) if cycle.edge else 2.0 * i - 1.0
            if not has_stop(cycle_from(cycle, hops, end.velocity + way * beside)):
                return end._replace(status=Status.BOUNDARY)
    return end


def only_orbit(cycle: HoppingCycle, hops: Hops, begin: Orbit) -> Orbit:
    """Find the fixed point of a cycle that has but one, from some velocity and the cycle that it begins."""
    return _bracketed(cycle, hops, begin.velocity, begin.cycle, -cycle.bound, cycle.bound)


def followed(cycle: HoppingCycle, hops: Hops, start: float, rounds: int) -> Orbit:
    """Follow a body for some cycles: ``UNRESOLVED`` unless one with a stop repeats.

    Nothing is assumed of the map. Where friction just holds gravity, or neither acts, rounding alone decides
    whether a body stops, and ``orbit_from`` has to tell.
    """
    here = start
    now = cycle_from(cycle, hops, here)
    for i in range(rounds):
        if has_stop(now) and not (cycle.edge or cycle.neutral) and is_closed(cycle, here, now):
            return _settled(cycle, hops, here, now, Status.OK)
        if i + 1 < rounds:
            here = now.velocity
            now = cycle_from(cycle, hops, here)
    return Orbit(here, now, Status.UNRESOLVED)


def attracts_all(cycle: HoppingCycle, hops: Hops, home: Orbit, rounds: int) -> bool:
    """Return whether the fastest bodies either way soon move as ``home`` does, and so all between them."""
    for i in range(2):
        here, met = cycle.bound if i == 0 else -cycle.bound, False
        for _ in range(rounds):
            now = cycle_from(cycle, hops, here)
            here = now.velocity
            met = has_stop(now) and is_closed(cycle, home.velocity, now)
            if met:
                break
        if not met:
            return False
    return True


def is_closed(cycle: HoppingCycle, velocity: float, now: Return) -> bool:
    """Return whether a cycle ends with a velocity, but for rounding."""
    return abs(now.velocity - velocity) <= ROUNDING * _size(cycle, velocity)


def _orbit_held(cycle: HoppingCycle, hops: Hops, start: float) -> Orbit:
    """Follow an orbit where friction holds gravity, so that it stays bounded."""
    end = _bracketed(cycle, hops, start, cycle_from(cycle, hops, start), -cycle.bound, cycle.bound)
    loads = cycle.track.loads
    alone = loads.kinetic_friction >= _MOST_COEXISTENCE * loads.static_friction and loads.waves.kind == SINE
    if end.status == Status.OK and not alone:
        return _first_on_way(cycle, hops, start, end)
    return end


def _bracketed(
    cycle: HoppingCycle, hops: Hops, start: float, begin: Return, low: float, high: float
) -> Orbit:
    """Find a fixed point, any where there are several: Newton's iteration in the bracket its steps leave.

    Where kinetic friction just holds gravity, all velocities at which the body slides downhill alone are
    fixed points; the orbit ends at the first of them.
    """
    here, now, before = start, begin, INF
    for i in range(_MOST_EVALUATIONS):
        step = _change(cycle, here, now)
        past = step.closed and cycle.edge and now.slope == 1.0 and here != start
        rises = here < start if past else step.rises
        if rises:
            low = here
        else:
            high = here
        room = high - low
        if (step.closed and not past) or room <= _apart(cycle, here):
            if cycle.track.loads.waves.kind != SINE and not has_stop(now) and step.newton < room:
                return _sharpened(cycle, hops, here, now, step)
            return _settled(cycle, hops, here, now, Status.OK)
        # between bends of the map Newton's steps may go to and fro for ever
        shrinks = i < _NEWTONS or step.newton < 0.5 * before
        before = step.newton
        onward = step.newton if step.newton < room and shrinks else 0.5 * room
        here = here + onward if rises else here - onward
        now = cycle_from(cycle, hops, here)
    return Orbit(here, now, Status.UNRESOLVED)


def _sharpened(cycle: HoppingCycle, hops: Hops, here: float, now: Return, step: _Change) -> Orbit:
    """Take the last step of Newton's to a cycle without a stop, for which there is no closed form.

    Phases are rounded, and with them what friction does in the cycle and the displacement, but both alike: to
    correct the displacement is better than to follow another cycle.
    """
    if step.newton > ROUNDING * (cycle.drive + abs(here)):
        here += step.newton if step.rises else -step.newton
        now = cycle_from(cycle, hops, here)
        step = _change(cycle, here, now)
    onward = step.newton if step.rises else -step.newton
    sharpened = now._replace(displacement=now.displacement + now.delay * onward)
    return _settled(cycle, hops, here + onward, sharpened, Status.OK)


def _orbit_until_stop(cycle: HoppingCycle, hops: Hops, start: float) -> Orbit:
    """Follow an orbit where gravity drives the body on in every cycle without a stop, or nothing acts on it.

    It ends at the first fixed point with a stop on its way, or nowhere. Where nothing acts it also ends at
    any velocity at which the body does not stop: a disturbed body keeps another one, hence ``BOUNDARY``.
    """
    begin = cycle_from(cycle, hops, start)
    way = _downhill(cycle)
    if has_stop(begin):
        change = begin.velocity - start
        way = math.copysign(1.0, change) if abs(change) > ROUNDING * _size(cycle, start) else 0.0
    if way == 0.0:
        return _settled(cycle, hops, start, begin, Status.OK if has_stop(begin) else Status.BOUNDARY)
    end = _first_stopping(cycle, hops, start, begin, way)
    if end.status == Status.UNRESOLVED and way == _downhill(cycle):
        return end._replace(status=Status.RUNAWAY)
    return end


def _distance(start: float, way: float, velocity: float) -> float:
    """Return how far on the way from the start a velocity lies; negative behind it."""
    return abs(velocity - start) if way == 0.0 else way * (velocity - start)


def _first_stopping(cycle: HoppingCycle, hops: Hops, start: float, begin: Return, way: float) -> Orbit:
    """Find the first fixed point on the way from the start that ``stopping`` lists; else ``UNRESOLVED``."""
    best, nearest = Orbit(start, begin, Status.UNRESOLVED), INF
    for index in range(stops_of(cycle)):
        found = stopping(cycle, hops, start, begin, way, index)
        distance = _distance(start, way, found.velocity)
        if found.status != Status.UNRESOLVED and 0.0 <= distance < nearest:
            best, nearest = found, distance
    return best


def stops_of(cycle: HoppingCycle) -> int:
    """Return how many velocities ``stopping`` looks at: after impacts, then after rests in each contact."""
    flights, waves = cycle.last - cycle.first, cycle.track.loads.waves
    if waves.kind == SINE:
        return flights + 3
    onsets = number_of_nodes(waves, STATIC_FORWARD) + number_of_nodes(waves, STATIC_BACK)
    return flights + 1 + (flights + 1) * onsets


def stopping(cycle: HoppingCycle, hops: Hops, start: float, begin: Return, way: float, index: int) -> Orbit:
    """Find one of the fixed points with a stop, or after one where nothing acts on the body.

    Such a body takes off with the velocity that follows the last stop in its cycle: after one of the impacts,
    or after a rest until one of the onsets.

    Parameters
    ----------
    cycle, hops : HoppingCycle, Hops
        The cycle.
    start, begin : float, Return
        The velocity of a body from rest and the cycle from there, which is looked at first. Along a line it
        stands for a rest until the forward onset.
    way : float
        +1.0 or -1.0: skip velocities on the other side of the start; 0.0: skip none.
    index : int
        Which of the ``stops_of(cycle)``.

    Returns
    -------
    Orbit
        ``OK`` where a cycle with a stop repeats, ``BOUNDARY`` where one without does, else ``UNRESOLVED``.
    """
    none = Orbit(start, begin, Status.UNRESOLVED)
    track, row = cycle.track, cycle.first + index
    velocity, now = start, begin
    if index > 0:
        after = begin
        if row <= cycle.last:
            landed = 0.0
            if row < cycle.last and hops.rest[row - 1] > 0.0:
                amid = return_map(track, hops, 0, 0, hops.landing[row - 1], hops.rest[row - 1], 0.0)
                landed = amid.velocity
            after = return_map(track, hops, row, cycle.last, cycle.landing, cycle.rest, landed)
            if has_stop(after):
                return none
        else:
            rested = _after_rest(cycle, hops, row - cycle.last - 1)
            if math.isnan(rested):
                return none
            after = after._replace(velocity=rested)
        velocity = after.velocity
        if way * (velocity - start) < 0.0:
            return none
        now = cycle_from(cycle, hops, velocity)
    size, apart = _size(cycle, velocity), abs(now.velocity - velocity)
    if has_stop(now) and ROUNDING * size < apart <= _NEAR * size:
        velocity = now.velocity
        now = cycle_from(cycle, hops, velocity)
        apart = abs(now.velocity - velocity)
    if has_stop(now):
        return _settled(
            cycle, hops, velocity, now, Status.OK if apart <= ROUNDING * size else Status.UNRESOLVED
        )
    return _settled(cycle, hops, velocity, now, Status.BOUNDARY if cycle.neutral else Status.UNRESOLVED)


def _after_rest(cycle: HoppingCycle, hops: Hops, index: int) -> float:
    """Return the velocity at the end of the cycle of a body that rests until an onset; NaN if it does not.

    Of one harmonic index 0 is the forward onset, 1 the back one, in the only contact. Of other drives indices
    count all zeros of the loads beyond static friction, for one contact after the other.
    """
    track, waves = cycle.track, cycle.track.loads.waves
    landing, rest, next_row, amid = cycle.landing, cycle.rest, cycle.last, False
    onset = track.forward_onset if index == 0 else track.back_onset
    if waves.kind == SINE:
        if math.isnan(onset) or (index == 0 and track.loads.line):
            return NAN
    else:
        forward = number_of_nodes(waves, STATIC_FORWARD)
        onsets = forward + number_of_nodes(waves, STATIC_BACK)
        contact, zero = index // onsets, index % onsets
        row = STATIC_FORWARD if zero < forward else STATIC_BACK
        zero = zero if zero < forward else zero - forward
        if not behind(waves, row, zero):
            return NAN
        onset = waves.number[nodes_of(waves, row) + zero]
        amid = cycle.first + contact < cycle.last
        if amid:
            next_row = cycle.first + contact + 1
            landing, rest = hops.landing[next_row - 1], hops.rest[next_row - 1]
    wait = until(onset, landing)
    if wait >= rest:
        return NAN
    slid = return_map(track, hops, 0, 0, onset, rest - wait, 0.0)
    if amid:
        slid = return_map(track, hops, next_row, cycle.last, cycle.landing, cycle.rest, slid.velocity)
    return slid.velocity


def _first_on_way(cycle: HoppingCycle, hops: Hops, start: float, home: Orbit) -> Orbit:
    """Find the first fixed point on the way from the start, which the orbit reaches; ``home`` is some other.

    Those with a stop are listed. The one without a stop is either ``home`` or looked for, unless the first
    cycle of the orbit leads to ``home`` by a stop.
    """
    now = home.cycle if start == home.velocity else cycle_from(cycle, hops, start)
    if has_stop(now) and abs(now.velocity - home.velocity) <= ROUNDING * cycle.drive:
        return home
    step = _change(cycle, start, now)
    way = 0.0 if step.closed else (1.0 if step.rises else -1.0)
    first = _first_stopping(cycle, hops, start, now, way)
    nearest = _distance(start, way, first.velocity) if first.status == Status.OK else INF
    if 0.0 <= _distance(start, way, home.velocity) < nearest:
        first, nearest = home, _distance(start, way, home.velocity)
    if has_stop(home.cycle) and way != 0.0:
        # home lies on the way, so that first is home or a fixed point before it
        sliding = between(cycle, hops, start, first.velocity)
        if sliding.status == Status.OK and 0.0 <= _distance(start, way, sliding.velocity) < nearest:
            first = sliding
    return first if first.status == Status.OK else home


def between(cycle: HoppingCycle, hops: Hops, start: float, target: float) -> Orbit:
    """Find the fixed point without a stop between a velocity and a target; no other may lie there.

    As there is one at most, it lies ahead of every velocity without a stop from which the search goes on.
    ``far`` is a velocity beyond which it cannot lie: from there the orbit leads back, or to the target by
    stops alone.

    Returns
    -------
    Orbit
        ``OK`` where it is found, else ``UNRESOLVED``.
    """
    here, far = start, target
    now = cycle_from(cycle, hops, here)
    if target == start:
        return Orbit(here, now, Status.UNRESOLVED)
    way = math.copysign(1.0, target - start)
    for _ in range(_MOST_EVALUATIONS):
        step = _change(cycle, here, now)
        if step.closed and not has_stop(now):
            return _settled(cycle, hops, here, now, Status.OK)
        room = way * (far - here)
        if step.closed or room <= _apart(cycle, here) or step.rises != (way > 0.0):
            break
        if way * (now.velocity - far) >= 0.0:
            break
        trial = here + way * min(step.newton, 0.5 * room)
        image = cycle_from(cycle, hops, trial)
        step = _change(cycle, trial, image)
        if not step.closed and step.rises != (way > 0.0):  # leads back: the fixed point is enclosed
            return _bracketed(cycle, hops, here, now, min(here, trial), max(here, trial))
        if not has_stop(image):
            here, now = trial, image
            continue
        led = Orbit(trial, image, Status.UNRESOLVED)
        if not step.closed and way * (image.velocity - far) < 0.0:
            led = _led_on(cycle, hops, image.velocity, far, way)
        if led.status == Status.OK:
            here, now = led.velocity, led.cycle
        else:
            far = trial
    return Orbit(here, now, Status.UNRESOLVED)


def _led_on(cycle: HoppingCycle, hops: Hops, start: float, far: float, way: float) -> Orbit:
    """Follow an orbit from stop to stop to a cycle without one, ``UNRESOLVED`` if none comes before ``far``.

    It goes on one way, as the map never decreases.
    """
    here = start
    now = cycle_from(cycle, hops, here)
    for _ in range(_MOST_EVALUATIONS):
        if not has_stop(now):
            return Orbit(here, now, Status.OK)
        if way * (now.velocity - far) >= 0.0:
            break
        if way * (now.velocity - here) <= ROUNDING * _size(cycle, here):
            break
        here = now.velocity
        now = cycle_from(cycle, hops, here)
    return Orbit(here, now, Status.UNRESOLVED)


def others_on(cycle: HoppingCycle, hops: Hops, start: float, home: Orbit) -> bool:
    """Return whether other velocities repeat than ``home``, to which a body leads that enters with ``start``.

    The one without a stop is either ``home``, or it is looked for: between the limits of all velocities and
    the outermost fixed points with a stop.
    """
    if cycle.neutral and not has_stop(home.cycle):
        return True
    begin = cycle_from(cycle, hops, start)
    low, high = min(cycle.bound, home.velocity), max(-cycle.bound, home.velocity)
    for index in range(stops_of(cycle)):
        found = stopping(cycle, hops, start, begin, 0.0, index)
        if found.status != Status.UNRESOLVED:
            if differ(cycle, found, home):
                return True
            low, high = min(low, found.velocity), max(high, found.velocity)
    if not has_stop(home.cycle):
        return False
    from_below = between(cycle, hops, -cycle.bound, low)
    if from_below.status == Status.OK and differ(cycle, from_below, home):
        return True
    from_above = between(cycle, hops, cycle.bound, high)
    return from_above.status == Status.OK and differ(cycle, from_above, home)


def differ(cycle: HoppingCycle, found: Orbit, home: Orbit) -> bool:
    """Return whether two fixed points are farther apart than rounding moves them."""
    if found.cycle.slope >= 1.0:
        return False  # of a continuum
    error = ROUNDING * cycle.forces / (1.0 - found.cycle.slope)
    return abs(found.velocity - home.velocity) > max(_SEPARATE, 8.0 * error)
