"""The steady motion of a body that hops: a cycle of flights and slides, or means over long samples.

Friction has no part in the normal motion, so that one unknown is left: the relative velocity at the first
take-off of the cycle, a fixed point of the return map. Lengths in A, speeds in A w, phases in radians.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from vibro.core.averages import Bodies, Means, averages
from vibro.core.bounces import MOST_FLIGHTS, Bounces, Flights, bounces, normal_multiplier
from vibro.core.buffers import BODIES, MOST_THROW, Bytes, doubles, integers
from vibro.core.codes import IRREGULAR, Status
from vibro.core.drives import Loads
from vibro.core.elementary import NAN, TURN
from vibro.core.flight import LOST, Bed, Covariance, Flight, bed_of, propagate, within
from vibro.core.legs import Track, track_of
from vibro.core.orbits import HoppingCycle, hopping_cycle, orbit_from
from vibro.core.return_map import Hops, release, return_map, with_same_ground_speed, write_hops
from vibro.core.spelling import spell
from vibro.core.wave_cycle import canonical
from vibro.core.waves import SINE
from vibro.core.windows import is_held_at_limit

__all__ = [
    "Entry",
    "Hopping",
    "cycle_of",
    "enter",
    "entered",
    "hopping",
    "means_of",
    "write_hopping_letters",
]

# Events (flights, of which a chain of short bounces counts as one) in each half of a sample: more of them
# where few do not suffice.
_SHORT_SAMPLE: Final = 12
_MIDDLE_SAMPLE: Final = 48
_LONG_SAMPLE: Final = 240


class Hopping(NamedTuple):
    """Steady motion of a body that hops, from rest.

    Attributes
    ----------
    status : int
        ``OK``; ``BOUNDARY`` where the motion depends on rounding, or on how the body was released;
        ``AVERAGED`` where no cycle was found before rounding could choose it, and the numbers are means over
        many cycles; ``RUNAWAY``, ``INDETERMINATE``, ``FLIGHT_NOT_MODELLED`` or ``UNRESOLVED``, with NaN for
        numbers.
    pattern : int
        Legs of the cycle, as ``Return`` has them; ``IRREGULAR`` where it does not repeat, 0 where there are
        no numbers.
    displacement : float
        Mean displacement per drive cycle [A].
    deviation : float
        Standard error of that mean [A]; 0 where the cycle repeats.
    period : float
        Drive cycles until the motion repeats; NaN where it does not.
    flight_fraction : float
        Share of the time spent off the trough; bounces that accumulate count as flight.
    impact : float
        Largest normal speed of a landing [A w].
    peak : float
        Largest relative speed along the trough, either way [A w].
    coexists : int
        1 where a body that is pushed hard enough downhill never stops; -1 elsewhere, as other cycles are not
        looked for here.
    multiplier : float
        Largest of the cycle, by modulus, Eq. (71); NaN where it does not repeat.
    """

    status: int
    pattern: int
    displacement: float
    deviation: float
    period: float
    flight_fraction: float
    impact: float
    peak: float
    coexists: int
    multiplier: float


def hopping(loads: Loads, restitution: float, flights: Flights, hops: Hops) -> Hopping:
    """Find the steady motion, from rest, of a body whose throw number exceeds 1.

    Parameters
    ----------
    loads : Loads
        Groups of the scene.
    restitution : float
        Normal coefficient of restitution, 0 <= e < 1.
    flights, hops : Flights, Hops
        Scratch memory; ``BODIES * MOST_HOPS`` rows of ``hops``.

    Returns
    -------
    Hopping
        Its motion.

    Notes
    -----
    Over a cycle the normal impulse is that of the weight; where gravity along the trough exceeds static
    friction under it, every cycle adds speed: ``RUNAWAY``.
    """
    slope, weight = abs(loads.weight_tangential), loads.weight_normal
    if loads.drive_normal > MOST_THROW * weight:
        return _unanswered(Status.FLIGHT_NOT_MODELLED)
    if loads.static_friction == 0.0:
        return _unanswered(Status.INDETERMINATE)
    if slope >= loads.static_friction * weight:
        return _unanswered(Status.RUNAWAY)
    track = track_of(loads, restitution)
    out = _cycle(track, restitution, flights, hops)
    if out.status == Status.UNRESOLVED:
        time, path, gain = doubles(2 * BODIES), doubles(2 * BODIES), doubles(2 * BODIES)
        swing, start, row = doubles(2 * BODIES), doubles(2 * BODIES), integers(3 * BODIES)
        bodies = Bodies(time, path, gain, swing, start, row)
        out = _irregular(means_of(track, restitution, flights, hops, bodies))
    if out.status == Status.OK and is_held_at_limit(loads):
        out = out._replace(status=int(Status.BOUNDARY))
    if out.status <= Status.BOUNDARY or out.status == Status.AVERAGED:
        return out._replace(coexists=1 if slope > loads.kinetic_friction * weight else -1)
    return out


def _unanswered(status: int) -> Hopping:
    return Hopping(status, 0, NAN, NAN, NAN, NAN, NAN, NAN, -1, NAN)


def _cycle(track: Track, restitution: float, flights: Flights, hops: Hops) -> Hopping:
    """Find the steady cycle; ``UNRESOLVED`` where none was found before rounding could choose it."""
    entry = enter(track, restitution, flights, hops)
    motion = entry.motion
    if not motion.repeats:
        return _unanswered(Status.UNRESOLVED)
    turns, cycle = float(motion.cycles), cycle_of(track, motion)
    orbit = orbit_from(cycle, hops, entry.velocity)
    if orbit.status != Status.OK and orbit.status != Status.BOUNDARY:
        return _unanswered(orbit.status)
    aloft, impact = 0.0, 0.0
    normal = normal_multiplier(bed_of(track.loads), restitution, flights, motion)
    for row in range(cycle.first, cycle.last):
        aloft += flights.length[row]
        impact = max(impact, flights.impact[row])
    return Hopping(
        status=orbit.status,
        pattern=canonical(orbit.cycle.pattern) if track.loads.waves.kind != SINE else orbit.cycle.pattern,
        displacement=orbit.cycle.displacement / turns,
        deviation=0.0,
        period=turns,
        flight_fraction=min(aloft / (TURN * turns), 1.0),
        impact=track.loads.weight_normal * impact,
        peak=orbit.cycle.peak,
        coexists=-1,
        multiplier=max(orbit.cycle.slope, normal),
    )


def cycle_of(track: Track, motion: Bounces) -> HoppingCycle:
    """Measure the cycle of a normal motion that repeats."""
    last = motion.first + motion.count
    return hopping_cycle(track, motion.first, last, motion.landing, motion.rest, TURN * motion.cycles)


def write_hopping_letters(
    loads: Loads, restitution: float, flights: Flights, hops: Hops, out: Bytes, room: int
) -> int:
    """Write the legs of a steady cycle that ``hopping`` has found, as ``spell``; return their number."""
    track = track_of(loads, restitution)
    entry = enter(track, restitution, flights, hops)
    cycle = cycle_of(track, entry.motion)
    return spell(cycle, hops, orbit_from(cycle, hops, entry.velocity).velocity, out, room).number


def means_of(track: Track, restitution: float, flights: Flights, hops: Hops, bodies: Bodies) -> Means:
    """Average over samples, over longer ones where shorter ones do not suffice, and write the bodies."""
    means = averages(track, restitution, _SHORT_SAMPLE, False, flights, hops, bodies)
    if means.status == Status.UNRESOLVED:
        means = averages(track, restitution, _MIDDLE_SAMPLE, False, flights, hops, bodies)
    if means.status == Status.UNRESOLVED:
        means = averages(track, restitution, _LONG_SAMPLE, True, flights, hops, bodies)
    return means


def _irregular(means: Means) -> Hopping:
    """Form the answer of a scene that does not repeat."""
    if means.status != Status.AVERAGED:
        return _unanswered(means.status)
    if math.isnan(means.displacement + means.deviation):  # friction is beyond what doubles can add up
        return _unanswered(Status.UNRESOLVED)
    return Hopping(
        status=Status.AVERAGED,
        pattern=IRREGULAR,
        displacement=means.displacement,
        deviation=means.deviation,
        period=NAN,
        flight_fraction=means.flight_fraction,
        impact=means.impact,
        peak=means.peak,
        coexists=-1,
        multiplier=NAN,
    )


class Entry(NamedTuple):
    """The cycle of the normal motion, and how a body from rest enters it.

    Attributes
    ----------
    motion : Bounces
        The cycle, whose flights are in ``Flights`` and, in the same rows, in ``Hops``.
    velocity : float
        Relative velocity along the trough at its first take-off.
    """

    motion: Bounces
    velocity: float


def enter(track: Track, restitution: float, flights: Flights, hops: Hops) -> Entry:
    """Fly a body from its release until its normal motion repeats, and follow it along the trough.

    A contact forgets the normal motion before it: a body that takes off at its release and comes to contact
    goes on like one that has rested there. So it does where rounding chooses the flights between, provided
    that the motion of such a body has contacts; it is taken to keep its velocity over the ground until then.
    The velocity is arbitrary where the motion does not repeat.
    """
    loads, bed = track.loads, bed_of(track.loads)
    start, known = release(track), True
    begin = track.lift_off if start.aloft else start.phase
    velocity = with_same_ground_speed(loads, start.velocity, start.phase, begin)
    if start.aloft:
        motion = bounces(bed, restitution, flights, MOST_FLIGHTS, start.phase, 0.0, False)
        known = motion.repeats and motion.approach == 0 and loads.waves.kind == SINE
        if known:
            last = motion.first + motion.count
            write_hops(loads, flights, hops, motion.first, last)
            # the contact at the end is among the hops
            velocity = return_map(track, hops, motion.first, last, 0.0, 0.0, start.velocity).velocity
        elif motion.repeats and _is_sharp(bed, restitution, flights, motion.approach):
            return entered(track, motion, start.velocity, flights, hops)
    motion = bounces(bed, restitution, flights, MOST_FLIGHTS, begin, 0.0, True)
    if not known and motion.rest == 0.0:
        return Entry(motion._replace(repeats=False), velocity)
    return entered(track, motion, velocity, flights, hops)


def entered(track: Track, motion: Bounces, velocity: float, flights: Flights, hops: Hops) -> Entry:
    """Follow a body along the trough from its first take-off until the cycle begins, and write its hops."""
    loads = track.loads
    if motion.repeats and (motion.rest == 0.0 or motion.approach > 0):
        write_hops(loads, flights, hops, 0, motion.approach)
        velocity = return_map(track, hops, 0, motion.approach, 0.0, 0.0, velocity).velocity
        # a cycle without rest begins at another phase than the approach ends
        begin = flights.phase[motion.first]
        if motion.rest == 0.0:
            velocity = with_same_ground_speed(loads, velocity, motion.approach_end, begin)
    last = motion.first + motion.count
    write_hops(loads, flights, hops, motion.first, last)
    if motion.rest > 0.0:  # it is that of the cycle's end
        hops.rest[last - 1] = 0.0
    return Entry(motion, velocity)


def _is_sharp(bed: Bed, restitution: float, flights: Flights, count: int) -> bool:
    """Return whether rounding has not chosen what follows some flights, Eq. (34); a contact forgets it."""
    errors = Covariance(0.0, 0.0, 0.0)
    for row in range(count):
        flown = Flight(flights.length[row], flights.impact[row])
        errors = propagate(bed, restitution, flights.phase[row], flights.speed[row], flown, 0.0, errors)
        if not within(errors, LOST):
            return False
        if flights.rest[row] > 0.0:
            errors = Covariance(0.0, 0.0, 0.0)
    return True
