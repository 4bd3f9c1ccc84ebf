"""The steady motion of a body that hops: a cycle of flights and slides, or means over long samples.

Friction has no part in the normal motion, so that one unknown is left: the relative velocity at the first
take-off of the cycle, a fixed point of the return map. Lengths in A, speeds in A w, phases in radians.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from vibro.core.bounces import (
    BOUNCE,
    LOST,
    MOST_FLIGHTS,
    Bounces,
    Covariance,
    Flights,
    after_landing,
    bounces,
    normal_multiplier,
    propagate,
    rests_as_from_rest,
    within,
)
from vibro.core.codes import IRREGULAR, Status
from vibro.core.drive import Loads, free_along, trough_along
from vibro.core.flight import Bed, Flight, bed_of, fly, next_take_off
from vibro.core.legs import Track, track_of
from vibro.core.numbers import (
    BODIES,
    INF,
    MOST_HOPS,
    MOST_THROW,
    NAN,
    TURN,
    Bytes,
    Doubles,
    Integers,
    braked,
    doubles,
    integers,
)
from vibro.core.return_map import (
    HoppingCycle,
    Hops,
    Release,
    has_stop,
    hopping_cycle,
    in_contact,
    orbit_from,
    release,
    return_map,
    with_same_ground_speed,
    write_hop,
    write_hops,
    write_letters,
)
from vibro.core.slides import is_held_at_limit
from vibro.core.wave_cycle import canonical
from vibro.core.waves import SINE, at_break

# ------------------------------------------------------------------------------
# Long samples of the normal motion of a body that is kicked a little.
#
# Every excursion from the trough begins at the same phase, so that rounding would repeat one for ever. So a
# body that leaves the trough after a contact gets a small normal speed. Phases in radians, normal speeds over
# n = cos(beta)/G [A w n].

_PATIENCE: Final = 3  # [1] factor by which a part is prolonged to end with a contact
# [A w n] Normal speed with which the first body of a scene leaves the trough after a contact, at most. Each
# other is kicked by a tenth of what the one before it gets, down to what rounding does.
_KICK: Final = 1e-4
_SHOVE: Final = 1e-2  # [1] relative change of speed that parts bodies which do not come to contact
# [rad] Bounces summed too early bring a body to rest that the trough would throw again. At this duration the
# error, of the order of its square, is that of the largest kicks squared.
_ACCUMULATED: Final = 1e-4
_GOLDEN: Final = 0.6180339887498949  # [1] multiples of it are spread evenly over [0, 1), modulo 1


class BodySample(NamedTuple):
    """Hops of a body: those of its transient, and those of both halves of the sample.

    Attributes
    ----------
    first, middle, last : int
        Rows of ``Hops`` at which the halves begin, and the one behind the last hop.
    first_time, second_time : float
        Durations of the halves [rad].
    first_swing, second_swing : float
        Velocity relative to the trough, over ``drive_tangential``, that the drive adds in each half.
    trough : float
        Velocity of the trough, over ``drive_tangential``, at the start of the sample.
    aloft : float
        Time of flight in both halves [rad].
    impact : float
        Largest landing speed, that of the transient included [A w n].
    lands : bool
        Whether there is a contact, in the transient or later.
    ends : bool
        Whether the body got to the end of the sample; if not, nothing of it is of use.
    """

    first: int
    middle: int
    last: int
    first_time: float
    second_time: float
    first_swing: float
    second_swing: float
    trough: float
    aloft: float
    impact: float
    lands: bool
    ends: bool


def fly_sample(loads: Loads, restitution: float, body: int, length: int, hops: Hops, row: int) -> BodySample:
    """Fly a body that starts from rest through its transient and its sample.

    Parameters
    ----------
    loads : Loads
        Groups of its scene.
    restitution : float
        e.
    body : int
        Which of the ``BODIES`` of the scene it is.
    length : int
        Events in each half of the sample: flights, of which a chain of short bounces counts as one. A part
        ends with a contact, if there is any: whole excursions have no end effects.
    hops : Hops
        Its hops are written here.
    row : int
        Where the first one goes; up to ``MOST_HOPS`` rows are filled.
    """
    bed = bed_of(loads)
    phase, speed = bed.lift_off, kick(0, body)
    # parts 0 and 1 are the transient, 2 and 3 the halves of the sample
    part, events, has_landed = 0, 0, False
    quota = length // 2 + body  # so that what repeats all the same is met at different moments
    first, middle, trough, trough_between = row, row, 0.0, 0.0
    first_time, second_time, aloft, impact, lands = 0.0, 0.0, 0.0, 0.0, False
    for last in range(row + 1, row + MOST_HOPS + 1):
        flown = fly(bed, phase, speed, False)
        touch = phase + flown.length
        after = after_landing(bed, touch, flown.impact, restitution, _ACCUMULATED)
        hop, landing = flown.length + after.length, at_break(bed.waves, touch + after.length)
        again = next_take_off(bed, landing)
        rest = again.wait if after.contact else 0.0
        write_hop(loads, phase, hop, after.impulse, hops, last - 1)
        hops.landing[last - 1] = landing
        hops.rest[last - 1] = rest
        impact, lands, has_landed = (
            max(impact, flown.impact),
            lands or rest > 0.0,
            has_landed or after.contact,
        )
        if part == 2:
            first_time += hop + rest
        elif part == 3:
            second_time += hop + rest
        if part >= 2:
            aloft += hop
        if hop > BOUNCE or after.contact:
            events += 1
        # a shove before the first contact would hide what soft kicks do not change
        ready = after.contact or not (has_landed or (part == 0 and body >= BODIES // 2))
        phase, speed = landing, after.take_off
        if after.contact:
            phase, speed = again.phase, kick(last - row, body)
        if events < quota or not (ready or events >= _PATIENCE * quota):
            continue
        events, part = 0, part + 1
        if part == 1 and has_landed:
            part = 2
        if part == 1:
            # a body that has not come to contact is shoved, and gets another transient
            speed *= 1.0 + _SHOVE * _spread(last - row, body)
        elif part == 2:
            quota, first, trough = length, last, trough_along(loads, phase).velocity
        elif part == 3:
            middle, trough_between = last, trough_along(loads, phase).velocity
        else:
            second_swing = trough_between - trough_along(loads, phase).velocity
            return BodySample(
                first, middle, last, first_time, second_time, trough - trough_between, second_swing, trough,
                aloft, impact, lands, True,
            )  # fmt: skip
    return BodySample(first, middle, row + MOST_HOPS, 0.0, 0.0, 0.0, 0.0, trough, aloft, impact, lands, False)


def _spread(count: int, body: int) -> float:
    """Return numbers in [0, 1), spread evenly over bodies and times, and the same in every run."""
    x = _GOLDEN * (BODIES * count + body + 1)
    return x - math.floor(x)


def kick(count: int, body: int) -> float:
    """Return the speed with which a body leaves the trough after a contact."""
    kick = _KICK
    for _ in range(body):
        kick /= 10.0
    return kick * _spread(count, body)


# ------------------------------------------------------------------------------
# Bodies from any start, followed until their flights repeat.
#
# Chaos may be a transient: a mean over its first flights is not that of the cycle in which the body ends.
# Where rounding has chosen the flights before a contact, the body is kicked at the lift-off after it, so that
# nothing repeats which the least disturbance would end. Lengths in A, speeds in A w, phases in radians.

_FLIGHTS: Final = 1024  # flights of each body, of which a chain of short bounces counts as one
_HALF: Final = 512  # flights after which the sample of a motion that does not repeat begins
_LAST_QUARTER: Final = 768
_NUDGE: Final = 1e-12  # [A w n] largest kick: far above rounding, and far below what a real trough does
_LEAST_NUDGE: Final = 1e-18  # [A w n] leaves the lift-off, and changes no flight after it
# [1] Contacts one after the other to which kicked bodies come by the same flights: they make a cycle.
_HOLDS: Final = 3
_ALIKE: Final = 1e-3  # [1] relative difference of the sums of landing speeds of such flights


class Settled(NamedTuple):
    """Where a body has got to.

    Attributes
    ----------
    motion : Bounces
        The cycle of its normal motion, whose flights are in ``Flights`` and, in the same rows, in ``Hops``;
        it does not repeat where none was found.
    velocity : float
        Along the trough, relative to it, where the cycle begins, else at the end.
    flown : int
        Flights until then, of a body without a cycle.
    impact : float
        The largest of their landing speeds [A w n].
    third_time, third_path, fourth_time, fourth_path : float
        Durations of their last two quarters [rad], and displacements in them.
    """

    motion: Bounces
    velocity: float
    flown: int
    impact: float
    third_time: float
    third_path: float
    fourth_time: float
    fourth_path: float


def settle(
    track: Track, restitution: float, start: Release, speed: float, seed: int, flights: Flights, hops: Hops
) -> Settled:
    """Follow a body until its flights repeat.

    Parameters
    ----------
    track : Track
        Scene that hops.
    restitution : float
        e.
    start : Release
        Its first take-off.
    speed : float
        Normal speed there, 0 from contact [A w n].
    seed : int
        Bodies of other seeds are kicked otherwise.
    flights, hops : Flights, Hops
        Scratch memory.
    """
    bed = bed_of(track.loads)
    phase, lifted, kicks = start.phase, not start.aloft and speed == 0.0, 0
    now, alike, impacts = unsettled(start.velocity), 0, 0.0
    before = now.motion
    for _ in range(2 * _FLIGHTS):
        motion = bounces(bed, restitution, flights, _FLIGHTS - now.flown, phase, speed, lifted)
        # a contact of a trough with one lift-off closes no cycle, unless the body has begun there
        comes = motion.repeats and not lifted and rests_as_from_rest(bed, motion)
        if motion.repeats and not comes:
            entry = entered(track, motion, now.velocity, flights, hops)
            return now._replace(motion=motion, velocity=entry.velocity)
        if lifted:  # rounding chooses what follows a rest
            lifted, kicks, speed = False, 1, _nudge(0, seed)
            continue
        rows = motion.count if comes else motion.approach
        lands = rows > 0 and not math.isnan(motion.approach_end)
        landing, rest, last = 0.0, 0.0, rows - 1
        if lands:
            landing = at_break(bed.waves, flights.phase[last] + flights.length[last])
            rest = next_take_off(bed, landing).wait
        if rows > 0:
            now = _sampled(track, now, rows, landing, rest, flights)
        if not lands or now.flown >= _FLIGHTS:
            break
        elapsed = flights.before[last] + flights.length[last] + rest
        cycles, sum_of_impacts = int(math.floor(elapsed / TURN + 0.5)), 0.0
        for row in range(rows):
            sum_of_impacts += flights.impact[row]
        begins = kicks > 0 and motion.approach_end == phase and rest > 0.0
        same = rows == before.count and cycles == before.cycles
        near = abs(sum_of_impacts - impacts) <= _ALIKE * sum_of_impacts
        alike = alike + 1 if begins and same and near else 0
        before = Bounces(True, 0, rows, 0, cycles, landing, rest, motion.approach_end)
        if alike > _HOLDS:
            flights.speed[0] = 0.0
            write_hops(track.loads, flights, hops, 0, rows)
            hops.rest[last] = 0.0  # it is that of the cycle's end
            return now._replace(motion=before)
        impacts, phase = sum_of_impacts, motion.approach_end
        lifted = kicks == 0
        speed = 0.0
        if not lifted:
            speed, kicks = _nudge(kicks, seed) if alike < _HOLDS else _LEAST_NUDGE, kicks + 1
    return now


def unsettled(velocity: float) -> Settled:
    """Begin with a body that has not flown yet."""
    return Settled(Bounces(False, 0, 0, 0, 0, 0.0, 0.0, 0.0), velocity, 0, 0.0, 0.0, 0.0, 0.0, 0.0)


def _nudge(count: int, seed: int) -> float:
    return _NUDGE * _spread(count, 97 * seed)


def _sampled(track: Track, now: Settled, rows: int, landing: float, rest: float, flights: Flights) -> Settled:
    """Follow a body along the trough over flights, and the contact after them, and add up what it does."""
    loads, velocity, flown, impact = track.loads, now.velocity, now.flown, now.impact
    friction = loads.kinetic_friction * loads.weight_normal
    times, paths = doubles(3), doubles(3)
    for i in range(3):
        times[i], paths[i] = 0.0, 0.0
    for row in range(rows):
        part = 0 if flown < _HALF else (1 if flown < _LAST_QUARTER else 2)
        at = free_along(loads, flights.phase[row], velocity, flights.length[row])
        velocity = braked(at.velocity, friction * flights.impulse[row])
        times[part], paths[part] = times[part] + flights.length[row], paths[part] + at.path
        impact = max(impact, flights.impact[row])
        ends = row == rows - 1
        waits = rest if ends else flights.rest[row]
        if waits > 0.0:
            begin = landing if ends else flights.landing[row]
            slid = in_contact(track, begin, waits, velocity, track.landed_friction)
            velocity = slid.velocity
            times[part], paths[part] = times[part] + waits, paths[part] + slid.displacement
        flown += 1 if flights.length[row] > BOUNCE or waits > 0.0 else 0
    return Settled(
        now.motion, velocity, flown, impact, now.third_time + times[1], now.third_path + paths[1],
        now.fourth_time + times[2], now.fourth_path + paths[2],
    )  # fmt: skip


# ------------------------------------------------------------------------------
# Stable cycles that capture a body after long irregular motion.

_BODIES: Final = 4  # followed of each scene


class Captures(NamedTuple):
    """Cycles in which bodies have ended.

    Attributes
    ----------
    number : int
        Bodies that were captured.
    displacement, squares : float
        Sum of what their mean displacements per drive cycle differ from that of irregular motion, and sum of
        the squares [A, A^2].
    aloft : float
        Sum of their flight fractions.
    impact, peak : float
        Largest normal speed of a landing, and largest relative speed along the trough [A w].
    """

    number: int
    displacement: float
    squares: float
    aloft: float
    impact: float
    peak: float


def captures(
    track: Track, restitution: float, irregular: float, start: float, flights: Flights, hops: Hops
) -> Captures:
    """Follow the bodies of a scene until cycles capture them.

    Parameters
    ----------
    track : Track
        Scene.
    restitution : float
        e.
    irregular : float
        Mean displacement per drive cycle of irregular motion [A].
    start : float
        Velocity along the trough at the first lift-off [A w].
    flights, hops : Flights, Hops
        Scratch memory.
    """
    loads, begin = track.loads, Release(False, track.lift_off, start)
    number, total, squares, aloft, impact, peak = 0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(_BODIES):
        settled = settle(track, restitution, begin, 0.0, i, flights, hops)
        motion = settled.motion
        if not motion.repeats:
            if i == 0:
                break  # others would take as long, to end nowhere too in nearly all scenes
            continue
        last, turns = motion.first + motion.count, float(motion.cycles)
        orbit = orbit_from(cycle_of(track, motion), hops, settled.velocity)
        if orbit.status > Status.BOUNDARY:
            continue
        number += 1
        off = orbit.cycle.displacement / turns - irregular
        total, squares, peak = total + off, squares + off * off, max(peak, orbit.cycle.peak)
        for row in range(motion.first, last):
            aloft += flights.length[row] / (TURN * turns)
            impact = max(impact, loads.weight_normal * flights.impact[row])
    return Captures(number, total, squares, aloft, impact, peak)


# ------------------------------------------------------------------------------
# Mean motion of a body whose hopping does not repeat: long samples, with the standard error of their mean.
#
# Irregular flights amplify every disturbance until nothing is left of the start, so that rounding, and on a
# real trough its noise, chooses the flights. What stays is their statistics. Several bodies are followed,
# each kicked a little whenever it leaves the trough after a contact; the scatter of their means gives the
# error. Lengths in A, speeds in A w, phases in radians.

# [1] Ratio of the variance of a body's mean to that expected from its two halves: above which the sample is
# shorter than the memory of the motion, and above which bodies have gone different ways. For halves without
# memory it is F-distributed about 1.
_DRIFTS: Final = 3.0
_PARTED: Final = 8.0
# [1] Square of Student's t, of first halves against second ones: above it bodies drift or run side by side.
_TOGETHER: Final = 5.0
_STUDENT: Final = (BODIES - 1) / (BODIES - 3)  # variance of Student's t for a scatter of so many bodies

_FIRST_REACH: Final = 0.25  # [A w cos alpha] first step in search of the velocity of balance
_BALANCED: Final = 0.1  # [1] imbalance left, over its statistical error
_MOST_STEPS: Final = 24


class Means(NamedTuple):
    """Means over samples.

    Attributes
    ----------
    status : int
        ``AVERAGED``; ``RUNAWAY`` where a body does not stop again; ``UNRESOLVED`` where a longer sample is
        needed, or bounces are too many. NaN for numbers but with the first.
    displacement, deviation : float
        Mean displacement per drive cycle and its standard error [A].
    flight_fraction : float
        Share of the time spent off the trough.
    impact, peak : float
        Largest normal speed of a landing, and largest relative speed along the trough [A w].
    """

    status: int
    displacement: float
    deviation: float
    flight_fraction: float
    impact: float
    peak: float


class Bodies(NamedTuple):
    """What is known of ``BODIES`` bodies of a scene; of their halves in rows 2 i and 2 i + 1 of body i.

    Attributes
    ----------
    time, path, gain : Doubles
        Duration of each half [rad], displacement in it, and change of the velocity over the ground.
    swing : Doubles
        Velocity relative to the trough, over a, that the drive adds in each half.
    start : Doubles
        In row 2 i the relative velocity of a body at the start of its sample, in row 2 i + 1 the velocity of
        the trough there, over a.
    row : Integers
        Rows of ``Hops``, from 3 i on: the first of each half, and the one behind the last.
    """

    time: Doubles
    path: Doubles
    gain: Doubles
    swing: Doubles
    start: Doubles
    row: Integers


class _Slid(NamedTuple):
    """All bodies followed along the trough through their samples.

    Attributes
    ----------
    peak : float
        Largest speed.
    fastest : float
        Largest velocity downhill at the end.
    always_forgets, forgets : bool
        Whether each body stops in each half of its sample, and in the second half.
    """

    peak: float
    fastest: float
    always_forgets: bool
    forgets: bool


def averages(
    track: Track, restitution: float, length: int, longest: bool, flights: Flights, hops: Hops,
    bodies: Bodies,
) -> Means:  # fmt: skip
    """Average the motion of a scene in which no cycle can be found.

    Parameters
    ----------
    track : Track
        Scene.
    restitution : float
        e.
    length : int
        Events (flights, of which a chain of short bounces counts as one) in each half of the samples.
    longest : bool
        Whether no longer samples are to follow.
    flights, hops : Flights, Hops
        Scratch memory; ``BODIES * MOST_HOPS`` rows of ``hops``.
    bodies : Bodies
        Written.

    Returns
    -------
    Means
        The averages.

    Notes
    -----
    A longer sample is needed where the means of bodies differ by more than the halves of their samples
    explain, and where they remember their velocities for longer than it lasts. Where they differ for good, as
    they have gone different ways or as the size of the kicks decides, the standard error is the scatter of
    the bodies.
    """
    loads = track.loads
    unresolved = Means(Status.UNRESOLVED, NAN, NAN, NAN, NAN, NAN)
    start = start_of(track)
    total, aloft, impact, lands = 0.0, 0.0, 0.0, False
    row = 0
    for i in range(BODIES):
        sample = fly_sample(loads, restitution, i, length, hops, row)
        if not sample.ends:
            return unresolved
        before = return_map(track, hops, row, sample.first, 0.0, 0.0, start)
        row = sample.last
        bodies.start[2 * i], bodies.start[2 * i + 1] = before.velocity, sample.trough
        bodies.row[3 * i], bodies.row[3 * i + 1], bodies.row[3 * i + 2] = sample.first, sample.middle, row
        bodies.time[2 * i], bodies.time[2 * i + 1] = sample.first_time, sample.second_time
        bodies.swing[2 * i], bodies.swing[2 * i + 1] = sample.first_swing, sample.second_swing
        total += sample.first_time + sample.second_time
        aloft += sample.aloft
        impact = max(impact, sample.impact)
        lands = lands or sample.lands
    slid = _slide(track, hops, bodies)
    slope, friction = abs(loads.weight_tangential), loads.kinetic_friction * loads.weight_normal
    bounded = hopping_cycle(track, 0, 0, 0.0, 0.0, TURN).bounded
    remembers = bounded and not slid.always_forgets
    if remembers and longest:
        slid = _balance(track, hops, bodies)
        # Friction holds gravity, so that bodies turn round at times, and are no faster than drive, gravity
        # and friction make them. Where it holds it by less than samples can tell, they seem to balance far
        # beyond.
        ground = bodies.start[0] + loads.drive_tangential * bodies.start[1]
        if abs(ground) > 2.0 * loads.drive_tangential + (slope + friction) * total / BODIES:
            return unresolved

    mean = 0.0
    for i in range(2 * BODIES):
        mean += bodies.path[i]
    mean /= total
    spread = spread_of(bodies, mean, total, lands)

    # Where friction is too weak to hold gravity every flight without a stop adds speed downhill. The drive
    # takes no more than twice its own speed from that, and one landing no more than its friction.
    loose = slope > friction
    runs = loose and slid.fastest > 2.0 * (loads.drive_tangential + friction * impact)
    undecided = loose and not runs and not slid.forgets
    if runs or (undecided and longest):
        return unresolved._replace(status=Status.RUNAWAY)
    if not longest and (
        remembers or undecided or spread.drift > 0.0 or (not lands and spread.ratio > _DRIFTS)
    ):
        return unresolved
    means = Means(
        status=Status.AVERAGED,
        displacement=TURN * mean,
        deviation=TURN * math.sqrt(spread.variance),
        flight_fraction=min(aloft / total, 1.0),
        impact=loads.weight_normal * impact,
        peak=slid.peak,
    )
    return _with_captures(track, restitution, means, start, flights, hops)


def start_of(track: Track) -> float:
    """Return the relative velocity of a body from rest at the first lift-off."""
    released = release(track)
    return with_same_ground_speed(track.loads, released.velocity, released.phase, track.lift_off)


class _Spread(NamedTuple):
    """How far a mean over the bodies may be off.

    Attributes
    ----------
    variance : float
        Square of its standard error.
    ratio : float
        Variance of a body's mean over that expected from its halves.
    drift : float
        Part of the variance by which first halves of all bodies differ from second ones.
    """

    variance: float
    ratio: float
    drift: float


def spread_of(bodies: Bodies, mean: float, total: float, lands: bool) -> _Spread:
    """Tell how far the mean of ``bodies.path`` per radian may be off.

    ``total`` is the duration of all samples [rad]; ``lands`` says whether there are contacts.
    """
    own, halves, drift = _variances(bodies, mean, total)
    ratio = own / halves if halves > 0.0 else (INF if own > 0.0 else 1.0)
    # Without memory both are the variance of a body's mean.
    variance = (own if ratio > _DRIFTS else 0.5 * (own + halves)) / BODIES
    if lands or ratio > _PARTED:
        variance += _STUDENT * max(own - halves, 0.0)
    return _Spread(variance + drift, ratio, drift)


def _variances(bodies: Bodies, mean: float, total: float) -> tuple[float, float, float]:
    """Return the variance of a body's mean, from the scatter of the bodies and from their halves.

    The third number is the square of what first halves of all bodies differ by from second ones; 0 where
    independent bodies without memory may differ as much. The sum of all deviations from the mean is 0.
    """
    own, halves, drift, scale = 0.0, 0.0, 0.0, BODIES / total
    for i in range(BODIES):
        first = (bodies.path[2 * i] - mean * bodies.time[2 * i]) * scale
        second = (bodies.path[2 * i + 1] - mean * bodies.time[2 * i + 1]) * scale
        own += (first + second) * (first + second)
        halves += (first - second) * (first - second)
        drift += (first - second) / BODIES
    drift *= drift
    halves /= BODIES
    if drift * (BODIES - 1) <= _TOGETHER * (halves - drift):
        drift = 0.0
    return own / (BODIES - 1), halves, drift


def _slide(track: Track, hops: Hops, bodies: Bodies) -> _Slid:
    """Follow the bodies from their velocities at the start of the samples; write paths and gains."""
    loads = track.loads
    downhill = -math.copysign(1.0, loads.weight_tangential) if loads.weight_tangential != 0.0 else 0.0
    peak, fastest, always_forgets, forgets = 0.0, -INF, True, True
    for i in range(BODIES):
        velocity = bodies.start[2 * i]
        for half in range(2):
            row, here = 3 * i + half, 2 * i + half
            first, last = bodies.row[row], bodies.row[row + 1]
            leg = return_map(track, hops, first, last, 0.0, 0.0, velocity)
            # without a stop gravity and friction alone act
            gain = leg.friction - loads.weight_tangential * bodies.time[here]
            if has_stop(leg):
                gain = leg.velocity - velocity - loads.drive_tangential * bodies.swing[here]
            elif half == 0:
                always_forgets = False
            else:
                always_forgets, forgets = False, False
            bodies.path[here], bodies.gain[here] = leg.displacement, gain
            peak, velocity = max(peak, leg.peak), leg.velocity
        fastest = max(fastest, downhill * velocity)
    return _Slid(peak, fastest, always_forgets, forgets)


class _Imbalance(NamedTuple):
    """A velocity over the ground, and the gain and the path of all bodies from there; NaN if unknown."""

    ground: float
    gain: float
    path: float


def _balance(track: Track, hops: Hops, bodies: Bodies) -> _Slid:
    """Give all bodies the same velocity over the ground, that at which gravity and friction balance.

    Where a body never stops in its sample it is off, the longer the less friction there is, by the error of
    its velocity at the start. The sum of what all bodies gain falls with the velocity. Bracket the zero, and
    go on by false position and halving in turn until less than a tenth of its statistical error is left. What
    the balance of each is off by moves that velocity, and with it the mean: each path is corrected for that,
    and the sum of the corrections is 0.
    """
    a = track.loads.drive_tangential
    ground, reach = 0.0, _FIRST_REACH * a
    for i in range(BODIES):
        ground += bodies.start[2 * i] + a * bodies.start[2 * i + 1]
    ground /= BODIES
    low, high = _Imbalance(NAN, NAN, NAN), _Imbalance(NAN, NAN, NAN)
    slid = _Slid(0.0, 0.0, True, True)
    effect = 0.0
    for step in range(_MOST_STEPS):
        for i in range(BODIES):
            bodies.start[2 * i] = ground - a * bodies.start[2 * i + 1]
        slid = _slide(track, hops, bodies)
        gain, path, scatter = 0.0, 0.0, 0.0
        for i in range(BODIES):
            own = bodies.gain[2 * i] + bodies.gain[2 * i + 1]
            gain += own
            scatter += own * own
            path += bodies.path[2 * i] + bodies.path[2 * i + 1]
        rises = gain > 0.0
        if rises:
            low = _Imbalance(ground, gain, path)
        else:
            high = _Imbalance(ground, gain, path)
        if math.isnan(low.ground) or math.isnan(high.ground):
            ground += reach if rises else -reach
            reach *= 2.0
            continue
        effect = (high.path - low.path) / (high.gain - low.gain)
        if abs(gain) <= _BALANCED * math.sqrt(scatter):
            break
        share = 0.5 if step % 3 == 2 else low.gain / (low.gain - high.gain)
        ground = low.ground + share * (high.ground - low.ground)
    for i in range(2 * BODIES):
        bodies.path[i] -= effect * bodies.gain[i]
    return slid


def _with_captures(
    track: Track, restitution: float, means: Means, start: float, flights: Flights, hops: Hops
) -> Means:
    """Average over the cycles in which bodies have ended, and the irregular motion unless all have.

    Nobody knows which of them it will be, so that the error is the scatter of these motions. Bodies that have
    not ended yet count as one: most will be captured later.
    """
    found = captures(track, restitution, means.displacement, start, flights, hops)
    if found.number == 0:
        return means
    rest = 0.0 if found.number == _BODIES else 1.0
    motions = found.number + rest
    shift = found.displacement / motions
    own = means.deviation / (found.number + 1)  # where all have ended, one body more may not
    variance = max(found.squares - found.displacement * shift, 0.0) / (motions - 1)
    return Means(
        status=Status.AVERAGED,
        displacement=means.displacement + shift,
        deviation=math.sqrt(own * own + variance),
        flight_fraction=(rest * means.flight_fraction + found.aloft) / motions,
        impact=max(means.impact, found.impact),
        peak=max(means.peak, found.peak),
    )


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
    out = repeating(loads, restitution, flights, hops)
    if out.status == Status.UNRESOLVED:
        track = track_of(loads, restitution)
        time, path, gain = doubles(2 * BODIES), doubles(2 * BODIES), doubles(2 * BODIES)
        swing, start, row = doubles(2 * BODIES), doubles(2 * BODIES), integers(3 * BODIES)
        bodies = Bodies(time, path, gain, swing, start, row)
        out = _irregular(means_of(track, restitution, flights, hops, bodies))
    if out.status == Status.OK and is_held_at_limit(loads):
        out = out._replace(status=int(Status.BOUNDARY))
    if out.status <= Status.BOUNDARY or out.status == Status.AVERAGED:
        runs_on = abs(loads.weight_tangential) > loads.kinetic_friction * loads.weight_normal
        return out._replace(coexists=1 if runs_on else -1)
    return out


def repeating(loads: Loads, restitution: float, flights: Flights, hops: Hops) -> Hopping:
    """Find it if it repeats; ``UNRESOLVED`` where no cycle was found before rounding could choose it."""
    weight = loads.weight_normal
    if loads.drive_normal > MOST_THROW * weight:
        return _unanswered(Status.FLIGHT_NOT_MODELLED)
    if loads.static_friction == 0.0 and loads.weight_tangential == 0.0:
        return _unanswered(Status.INDETERMINATE)
    if abs(loads.weight_tangential) >= loads.static_friction * weight:
        return _unanswered(Status.RUNAWAY)
    return _cycle(track_of(loads, restitution), restitution, flights, hops)


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
    """Write the legs of a steady cycle that ``hopping`` has found; return their number."""
    track = track_of(loads, restitution)
    entry = enter(track, restitution, flights, hops)
    cycle = cycle_of(track, entry.motion)
    return write_letters(cycle, hops, orbit_from(cycle, hops, entry.velocity).velocity, out, room)


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


class _Entry(NamedTuple):
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


def enter(track: Track, restitution: float, flights: Flights, hops: Hops) -> _Entry:
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
        return _Entry(motion._replace(repeats=False), velocity)
    return entered(track, motion, velocity, flights, hops)


def entered(track: Track, motion: Bounces, velocity: float, flights: Flights, hops: Hops) -> _Entry:
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
    return _Entry(motion, velocity)


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
