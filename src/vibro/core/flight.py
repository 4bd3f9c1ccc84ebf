"""One flight, from take-off to the first return to the trough, and what follows its landing.

The normal motion is free of friction: a flight depends on the load N/n of a body on the trough, its take-off
phase and its take-off speed alone, eta'' / n = -N/n, which is K sin p - 1 of one harmonic, Eq. (28) of
docs/theory. Normal speeds are over n = cos(beta)/G [A w n], phases in radians.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from vibro.core.cells import Event, behind, next_event, number_of_nodes
from vibro.core.drive import Loads
from vibro.core.legs import Crossing, Fall, Left, ahead, crossing, first_ahead, left_after
from vibro.core.numbers import (
    EPS,
    FEW_ULP,
    HARMONICS,
    INF,
    LONGEST_CYCLE,
    MOST_BOUNCES,
    NAN,
    PI,
    PIECES,
    QUARTER,
    TURN,
    Doubles,
    PathPoint,
    Value,
    bisected,
    free_motion,
    newton,
    sine_gap,
    until,
    wrap,
    wrap_around,
)
from vibro.core.waves import (
    NORMAL,
    SINE,
    Mix,
    Moved,
    Waves,
    at_break,
    depart,
    load_at,
    moved,
    one_harmonic,
    trough_at,
)

# ------------------------------------------------------------------------------
# Flights over any periodic normal motion: from zero to zero of the load of a body on the trough.
#
# Between two zeros the height over the trough is concave, where the trough would bear a body, or convex,
# where it falls away under one. So each piece has a known number of landings. Seen from the ground the body
# flies along a parabola: while that is above the highest point that the trough reaches it cannot land. Normal
# speeds are over n [A w n], phases in radians.

_MOST_PIECES: Final = 1_000_000  # [1] of a flight near the highest point of the trough, in a tiny gravity


def fly_over_waves(waves: Waves, lift: Mix, phase: float, speed: float, lifted: bool) -> tuple[float, float]:
    """Fly to the first landing: return the phase until then [rad] and the speed there [A w n].

    Parameters
    ----------
    waves : Waves
        Whose row ``NORMAL`` is known.
    lift : Mix
        -N/n.
    phase, speed : float
        Of the take-off, speed >= 0.
    lifted : bool
        Whether it is at a zero of N: then N is 0 there exactly, unless it jumps.
    """
    phase = wrap(phase)
    load = depart(waves, lift, phase).load
    if lifted and waves.kind == HARMONICS:
        load = 0.0
    fall = Fall(waves, lift, phase, load, True, 0.0, speed)
    up, down = _above_all(waves, lift, phase, speed)
    count, index = number_of_nodes(waves, NORMAL), first_ahead(waves, NORMAL, phase)
    low = Left(0.0, 0.0, speed, load)
    for _ in range(_MOST_PIECES):
        far = ahead(waves, NORMAL, phase, index)
        concave = behind(waves, NORMAL, index % count)
        rises_away = low.phase < up <= far
        if rises_away:
            far = up
        if far > low.phase:
            high, landing = left_after(fall, far), _none()
            if concave and high.value <= 0.0 and not (rises_away and high.rate >= 0.0):
                landing = _over_crest(fall, low, high)
            elif not concave and low.rate < 0.0:
                landing = _through_hollow(fall, low, high)
            if not math.isnan(landing.phase):
                return landing.phase, max(-(speed + landing.moved.velocity), 0.0)
            low = high
        index += 1
        if rises_away:
            low = left_after(fall, down)
            turns = float(math.floor((phase + down) / TURN))
            index = first_ahead(waves, NORMAL, phase + down - TURN * turns) + count * int(turns)
    return NAN, NAN


def _none() -> Crossing:
    """Stand for no landing."""
    return Crossing(NAN, Moved(NAN, NAN, NAN, NAN))


def _above_all(waves: Waves, lift: Mix, phase: float, speed: float) -> tuple[float, float]:
    """Return when the body rises above the highest point of the trough, and when it falls through it again.

    Where it never does, the first is infinite.
    """
    height, velocity = trough_at(waves, True, phase)
    rise = speed + lift.normal * velocity
    clearance = rise * rise - 2.0 * lift.normal * (waves.height - height)
    if not (rise > 0.0 and clearance > 0.0):
        return INF, INF
    root = math.sqrt(clearance)
    return lift.normal * 2.0 * (waves.height - height) / (rise + root), rise + root


def _over_crest(fall: Fall, low: Left, high: Left) -> Crossing:
    """Return the landing in a concave piece at whose end the body would be below the trough."""
    if low.rate > 0.0:  # the take-off is a zero too: begin at the top
        low = _turn(fall, low, high)
    return crossing(fall, low, high)


def _through_hollow(fall: Fall, low: Left, high: Left) -> Crossing:
    """Return the landing in a convex piece that begins downwards; NaN if there is none.

    Tangents at both ends bound the height from below. Where the load jumps, a body may land without speed as
    the trough ceases to fall away: rounding would make it miss the jump by the root of an ulp.
    """
    noise = FEW_ULP * (1.0 + fall.mix.normal) * (1.0 + high.phase * high.phase)
    if fall.waves.kind == PIECES and max(abs(high.value), abs(high.rate)) <= noise:
        return Crossing(high.phase, Moved(0.0, -fall.rate, -fall.rate * high.phase, 0.0))
    if high.value > 0.0:
        if high.rate <= 0.0:
            return _none()
        meets = (high.value - low.value - high.rate * (high.phase - low.phase)) / (low.rate - high.rate)
        if low.value + low.rate * meets > 0.0:
            return _none()
        high = _turn(fall, low, high)
        if high.value > 0.0:
            return _none()
    return crossing(fall, low, high)


def _turn(fall: Fall, low: Left, high: Left) -> Left:
    """Return the top, or the bottom, between phases at which the body rises and falls."""
    rate = fall._replace(height=False, value=fall.rate)
    return left_after(fall, crossing(rate, left_after(rate, low.phase), left_after(rate, high.phase)).phase)


#: [rad] Bounces whose remaining total length is below this are summed as if the load were constant; the error
#: is of the order of its square.
ACCUMULATED: Final = 1e-8
#: [rad] A bounce shorter than this is one of a chain, and a chain that accumulates is one event.
BOUNCE: Final = 0.1
#: [rad, A w n] Standard errors up to which a contact closes a cycle, and above which rounding may choose what
#: comes next.
SHARP: Final = 1e-9
LOST: Final = 1e-5

_SETTLED: Final = 1e-8  # [1] a last Newton step below this fraction of the length leaves rounding errors only

# [1] Newton's iteration from the far end of a turn needs many steps to the landing of a short bounce, which
# lasts 2 v / N. Start it this much of v / N after the take-off, if that is after the landing: half the steps.
_SHORT_BOUNCE: Final = 2.2

# [A w n] A grazing landing multiplies errors by a factor without bound: no impact counts as slower than this,
# which is far below those of the shortest flights at K = 1 + 1e-15.
_GRAZING: Final = 1e-30


class Bed(NamedTuple):
    """The trough's normal motion under a hopping body.

    Attributes
    ----------
    throw : float
        Throw number K > 1.
    lift_off : float
        Phase asin(1/K) at which it falls away under a resting body; the first of several [rad].
    lift : Mix
        -N/n, of a drive beyond one harmonic.
    waves : Waves
        Whose row ``NORMAL`` of zeros is known.
    """

    throw: float
    lift_off: float
    lift: Mix
    waves: Waves


def sinusoidal(throw: float) -> Bed:
    """Move the trough along a sine."""
    return Bed(throw, math.asin(1.0 / throw), Mix(-1.0, 0.0, 0.0), one_harmonic())


def bed_of(loads: Loads) -> Bed:
    """Take the normal motion of a scene that hops, whose zeros are known."""
    throw = loads.drive_normal / loads.weight_normal
    if loads.waves.kind == SINE:
        # to the last bit the lift-off of ``track_of``, by which flights from rest are known
        return sinusoidal(throw)._replace(lift_off=math.asin(loads.weight_normal / loads.drive_normal))
    lift = Mix(-1.0, 0.0, 1.0 / loads.weight_normal)
    return Bed(throw, next_event(loads.waves, NORMAL, True, 0.0).phase, lift, loads.waves)


def no_bed(loads: Loads) -> Bed:
    """Stand for the normal motion of a scene that does not hop."""
    lift = Mix(-1.0, 0.0, 1.0 / loads.weight_normal)
    return Bed(loads.drive_normal / loads.weight_normal, INF, lift, loads.waves)


def bed_load(bed: Bed, phase: float) -> float:
    """Return N/n, the load of a body on the trough; the trough falls away under it where that is negative."""
    if bed.waves.kind != SINE:
        return -load_at(bed.waves, bed.lift, phase)
    return 1.0 - bed.throw * math.sin(phase)


def lift_offs(bed: Bed) -> int:
    """Return how many zeros N has beyond one harmonic; 0 of one harmonic, which has but one lift-off."""
    return number_of_nodes(bed.waves, NORMAL) if bed.waves.kind != SINE else 0


def next_take_off(bed: Bed, phase: float) -> Event:
    """Return where the trough next falls away under a body that rests on it."""
    if bed.waves.kind != SINE:
        return next_event(bed.waves, NORMAL, True, phase)
    return Event(bed.lift_off, until(bed.lift_off, phase))


class Flight(NamedTuple):
    """End of a flight.

    Attributes
    ----------
    length : float
        Phase from take-off to landing [rad].
    impact : float
        Speed towards the trough at landing, >= 0 [A w n].
    """

    length: float
    impact: float


def fly(bed: Bed, phase: float, speed: float, lifted: bool) -> Flight:
    """Fly from a take-off to the first landing; ``lifted``: from a rest, at a lift-off."""
    if bed.waves.kind != SINE:
        length, impact = fly_over_waves(bed.waves, bed.lift, phase, speed, lifted)
        return Flight(length, impact)
    return lift_off_flight(bed, phase) if lifted else flight(bed, phase, speed)


def lift_off_flight(bed: Bed, phase: float) -> Flight:
    """Fly over a sine from the lift-off of a resting body, sin p = 1/K, at any K > 1.

    Within a drive cycle, c = sqrt(K^2 - 1) <= pi, Eq. (32) for c is a monotone function of the flight's
    length s. A rational approximation of s(c), within 2.8e-6, and one step of Halley's iteration, in terms
    that do not cancel for short flights, find s within 4 eps (tests/core/test_flight.py).
    """
    throw = bed.throw
    c = math.sqrt((throw - 1.0) * (throw + 1.0))
    if c > PI:
        return flight(bed, phase, 0.0)
    y = c * c
    s = c * (
        (((0.000197220998197 * y - 0.00184998921613) * y + 0.374302421072) * y + 3.11355343814) * y
        + 3.99998941774
    ) / (((0.00296138121658 * y + 0.220525684131) * y + 1.04494873987) * y + 1.0)  # fmt: skip
    h, sine, versine, gap = _half_angle(s)
    level = c * (gap + sine * versine) - gap * (h + sine)  # eta / 2
    slope = c * sine * sine - gap - sine * versine  # eta' / 2
    bend = 2.0 * (c * sine * (1.0 - versine) - sine * sine)  # eta''
    s -= level * slope / (slope * slope - 0.25 * level * bend)
    h, sine, versine, gap = _half_angle(s)
    return Flight(s, max(2.0 * (gap + sine * versine - c * sine * sine), 0.0))


def _half_angle(s: float) -> tuple[float, float, float, float]:
    """Return h = s/2, sin h, 1 - cos h and h - sin h, for 0 <= s <= 2 pi."""
    h = 0.5 * s
    half_sine = math.sin(0.5 * h)
    return h, 2.0 * half_sine * math.cos(0.5 * h), 2.0 * half_sine * half_sine, sine_gap(h)


class _TakeOff(NamedTuple):
    """What decides a flight: K, its lift-off phase, sine and cosine of the take-off phase, and the speed."""

    throw: float
    lift_off: float
    sine: float
    cosine: float
    speed: float


def _height(at: _TakeOff, s: float) -> PathPoint:
    """Return height and rate of climb over n, a phase s after take-off, Eq. (30)."""
    return free_motion(at.throw, 1.0, at.sine, at.cosine, at.speed, s)


def flight(bed: Bed, phase: float, speed: float) -> Flight:
    """Fly over a sine from any take-off to the first landing.

    Seen from the ground the body flies along a parabola, and every crest of the trough that the parabola
    does not clear ends the flight. So the landing lies in the turn before the first crest, or, if that is
    cleared, in the turn before the first crest after the parabola's way down. Within such a turn the height
    is convex, concave and convex again, and in each piece Newton's iteration from the proper end meets the
    first zero monotonically, or proves that there is none.

    Parameters
    ----------
    bed : Bed
        The trough.
    phase : float
        Phase of take-off; where the speed is 0 it lies where N <= 0 [rad].
    speed : float
        Speed of take-off, >= 0 [A w n].
    """
    throw, lift_off = bed.throw, bed.lift_off
    sine, cosine = math.sin(phase), math.cos(phase)
    at = _TakeOff(throw, lift_off, sine, cosine, speed)
    crest = wrap(QUARTER - phase)
    rise = speed + throw * cosine
    clearance = rise * rise - 2.0 * throw * (1.0 - sine)  # of the parabola's apex over the crests, doubled
    down = rise + math.sqrt(clearance) if rise > 0.0 and clearance >= 0.0 else 0.0
    cleared = down > crest
    length = NAN
    if not (cleared and speed == 0.0):  # else it is accelerated off the trough up to the crest
        length = _landing(at, 0.0, crest)
    if math.isnan(length):
        start = down if cleared else crest
        end = start + wrap(QUARTER - phase - start)
        length = _landing(at, start, end)
        if math.isnan(length):
            length = end
    return Flight(length, max(-_height(at, length).velocity, 0.0))


def _landing(at: _TakeOff, start: float, crest: float) -> float:
    """Return the first zero of the height after ``start`` and up to the next crest; NaN if there is none."""
    second = max(start, crest - QUARTER + at.lift_off)
    first = max(start, crest - 3.0 * QUARTER - at.lift_off)
    if start > 0.0 and first > start:
        # where the height at the end of the first piece is positive and still falling, the piece has no zero
        height, rate = _height(at, first)
        if height < 0.0 or rate > 0.0:
            found = _first_zero(at, start, first)
            if not math.isnan(found):
                return found
    sinks = _height(at, second).path < 0.0
    load = 1.0 - at.throw * at.sine
    if sinks and first == 0.0 and at.speed > 0.0 and load > 0.0:
        near = _SHORT_BOUNCE * at.speed / load
        if near < second and _height(at, near).path < 0.0:
            second = near
    return _first_zero(at, second, INF if sinks else crest)


def _falling(at: _TakeOff, s: float) -> Value:
    """Return height and rate of climb as a function and its slope."""
    height = _height(at, s)
    return Value(height.path, height.velocity)


def _first_zero(at: _TakeOff, start: float, end: float) -> float:
    """Return a zero of the height by Newton's iteration; NaN if it turns round or passes ``end`` first."""
    landing = newton(_falling, at, start, end, _SETTLED, 0.0)
    return landing.at if landing.found else NAN


class Impact(NamedTuple):
    """What follows a landing.

    Attributes
    ----------
    take_off : float
        Normal speed of the next take-off [A w n].
    length : float
        Phase until then: 0, or that of all bounces still to come where they accumulate [rad].
    impulse : float
        Normal impulse of the impact and of those bounces [A w n].
    contact : bool
        Whether the body stays on the trough.
    """

    take_off: float
    length: float
    impulse: float
    contact: bool


def after_landing(bed: Bed, phase: float, impact: float, restitution: float, accumulated: float) -> Impact:
    """Apply the impact law, Eq. (31), and sum the bounces that accumulate, Eq. (33).

    Bounces of take-off speed v, e v, e^2 v, ... under the load N last 2 v / (N (1 - e)) altogether and bring
    the impulse (1 + e) v / (1 - e), the one that starts them not counted. They are summed once they last no
    longer than ``accumulated`` [rad], and end before the trough can fall away.
    """
    load, speed = bed_load(bed, phase), restitution * impact
    impulse = impact + speed
    if speed == 0.0 and (load >= 0.0 or lands_at_jump(bed, phase)):
        return Impact(0.0, 0.0, impulse, True)
    if load > 0.0:
        length = 2.0 * speed / (load * (1.0 - restitution))
        if length <= accumulated and _lasts(bed, phase, load, length):
            return Impact(0.0, length, impulse + speed * (1.0 + restitution) / (1.0 - restitution), True)
    return Impact(speed, 0.0, impulse, False)


def lands_at_jump(bed: Bed, phase: float) -> bool:
    """Return whether a plastic body has landed where the load jumps below 0, but for rounding.

    It comes to contact there and leaves at once, from the jump itself: rounding may not choose another start.
    """
    return bed.waves.kind == PIECES and next_take_off(bed, phase).phase == at_break(bed.waves, phase)


def _lasts(bed: Bed, phase: float, load: float, length: float) -> bool:
    """Return whether the trough bears bodies for a short time, as far as its rate tells; else it may jump."""
    if bed.waves.kind == SINE:
        return load >= bed.throw * max(math.cos(phase), 0.0) * length
    if bed.waves.steep < INF:
        return load >= bed.waves.steep * bed.lift.normal * length
    return next_take_off(bed, phase).wait > length


class _TangentMap(NamedTuple):
    """Derivatives of a take-off's phase and speed with respect to those of the take-off before it."""

    phase_phase: float
    phase_speed: float
    speed_phase: float
    speed_speed: float


def tangent_map(bed: Bed, restitution: float, phase: float, flown: Flight) -> _TangentMap:
    """Form the derivatives of Eq. (34) for a flight that took off at a phase."""
    if bed.waves.kind != SINE:
        climb, lever = _changed(bed, phase, flown.length)
    else:
        cosine, sine = math.cos(phase), -math.sin(phase)
        lever, climb = free_motion(bed.throw, 0.0, cosine, sine, 0.0, flown.length)
    impact = max(flown.impact, _GRAZING)
    late, late_by_speed = lever / impact, flown.length / impact
    acceleration = -bed_load(bed, phase + flown.length)
    return _TangentMap(
        1.0 + late,
        late_by_speed,
        -restitution * (climb + acceleration * late),
        -restitution * (1.0 + acceleration * late_by_speed),
    )


def _chained(before: _TangentMap, one: _TangentMap) -> _TangentMap:
    """Multiply two maps: ``before`` leads to the take-off at which ``one`` begins."""
    return _TangentMap(
        one.phase_phase * before.phase_phase + one.phase_speed * before.speed_phase,
        one.phase_phase * before.phase_speed + one.phase_speed * before.speed_speed,
        one.speed_phase * before.phase_phase + one.speed_speed * before.speed_phase,
        one.speed_phase * before.phase_speed + one.speed_speed * before.speed_speed,
    )


def _changed(bed: Bed, phase: float, s: float) -> tuple[float, float]:
    """Return by how much -N/n has changed since a phase, and the integral of that."""
    value = depart(bed.waves, bed.lift, phase).load
    if bed.waves.kind == PIECES:
        since = moved(bed.waves, bed.lift, phase, value, s)
        return since.load - value, since.velocity - value * s
    # as if it had begun at 0: nothing cancels however short the flight is
    since = moved(bed.waves, bed.lift, phase, 0.0, s)
    return since.load, since.velocity


class Covariance(NamedTuple):
    """Variances of the rounding in a take-off's phase and speed, and their covariance."""

    phase: float
    both: float
    speed: float


def within(errors: Covariance, limit: float) -> bool:
    """Return whether both standard errors are below a limit."""
    return errors.phase <= limit * limit and errors.speed <= limit * limit


def propagate(
    bed: Bed,
    restitution: float,
    phase: float,
    speed: float,
    flown: Flight,
    tail: float,
    errors: Covariance,
) -> Covariance:
    """Propagate the covariance of a take-off to the next one, and add the rounding of the flight between.

    Irregular motion multiplies small errors by a factor at every flight, and so do grazing landings. A sum of
    absolute values would grow in every chain of bounces too; variances follow what errors do.

    Parameters
    ----------
    bed : Bed
        The trough.
    restitution : float
        e.
    phase, speed : float
        Of the take-off [rad, A w n].
    flown : Flight
        That followed.
    tail : float
        Length of the bounces summed after its landing [rad].
    errors : Covariance
        Of the take-off.
    """
    if bed.waves.kind == PIECES and flown.impact == 0.0:
        return Covariance(0.0, 0.0, 0.0)  # it lands without speed at a jump of the load
    a, b, c, d = tangent_map(bed, restitution, phase, flown)
    s, climb = flown.length, bed.throw * min(flown.length, 1.0)
    impact = max(flown.impact, _GRAZING)
    # a flight from a lift-off within a turn has all digits, however short: see lift_off_flight
    released = speed == 0.0 and s <= TURN and abs(bed_load(bed, phase)) <= 4.0 * EPS
    terms = 0.0 if released else speed + climb + 0.5 * s
    late = EPS * (1.0 + s + s * terms / impact)
    fast = EPS * restitution * (speed + climb + s)
    of_phase = max(a * (a * errors.phase + 2.0 * b * errors.both) + b * b * errors.speed, 0.0)
    both = a * c * errors.phase + (a * d + b * c) * errors.both + b * d * errors.speed
    of_speed = max(c * (c * errors.phase + 2.0 * d * errors.both) + d * d * errors.speed, 0.0)
    # bounces that accumulate last in proportion to the speed of the first
    lever = tail / (restitution * impact) if tail > 0.0 else 0.0
    return Covariance(of_phase + late * late + lever * lever * of_speed, both, of_speed + fast * fast)


# ------------------------------------------------------------------------------
# The normal motion of a hopping body: flights and impacts, in which friction has no part.
#
# It depends on the trough's normal motion and the restitution e alone, and a contact forgets all but at which
# lift-off it ends. So the flights from one lift-off to the next of the same phase make the cycle. Flights
# without contact that nearly repeat are closed by Newton's iteration. Phases in radians, normal speeds over n
# = cos(beta)/G [A w n].

#: Flights, short bounces not counted, after which the search for a cycle ends.
MOST_FLIGHTS: Final = 256

# [rad] Rounding does not matter in hops that end in contact this soon after their lift-off. The load grows
# with the square of that time s, so that friction would bring a velocity of s^3 / 6 at most in it: ``SHARP``.
_SHORT: Final = 1.8e-3

_LOOK_BACK: Final = 8  # flights after which it looks for a cycle, and again whenever they have doubled
_NEAR: Final = 0.1  # [rad, A w n] distance, over the number of flights between, of states that may be one
_PREFERRED: Final = 4.0  # [1] factor by which more flights must bring a state closer to be preferred
_NEWTON_STEPS: Final = 12
_FIRST_STEP: Final = 0.1  # [rad, A w n] longest first step
_SHRINKS: Final = 0.75  # [1] a longer next step, over the one before, shows that there is no cycle nearby
_CLOSED: Final = 1e-12  # [1] relative distance at which a cycle is closed
_SAME: Final = 1e-8  # [1] relative distance below which a cycle repeats within itself
_PHASES: Final = 256  # at which the speed of a trough that does not move along a sine is looked at


class Flights(NamedTuple):
    """Flights of one scene, one a row; scratch memory of MOST_BOUNCES + LONGEST_CYCLE rows.

    Attributes
    ----------
    phase, speed : Doubles
        Of the take-off; the phase in [0, 2 pi) [rad, A w n].
    length : Doubles
        Duration, with that of the bounces summed after the landing [rad].
    impact : Doubles
        Landing speed [A w n].
    impulse : Doubles
        Normal impulse of the landing, with those bounces [A w n].
    before : Doubles
        Phase elapsed until the take-off [rad].
    landing, rest : Doubles
        Phase at which a contact after the flight begins, and its duration; 0 without one [rad].
    """

    phase: Doubles
    speed: Doubles
    length: Doubles
    impact: Doubles
    impulse: Doubles
    before: Doubles
    landing: Doubles
    rest: Doubles


class Bounces(NamedTuple):
    """The steady normal motion of a scene.

    Attributes
    ----------
    repeats : bool
        Whether a cycle was found before rounding could choose it. If not, all else is 0 but where a contact
        came too late: then the approach and the take-off after it are those until there.
    first, count : int
        Its flights are the rows first ... first + count - 1 of ``Flights``.
    approach : int
        Flights before the cycle: the rows 0 ... approach - 1.
    cycles : int
        Drive cycles that the flights and the contact after them last, to a whole cycle.
    landing, rest : float
        Phase at which the contact at its end begins, in [0, 2 pi), and its duration; 0 where the body never
        rests on the trough [rad].
    approach_end : float
        Phase at which the approach ends: that of the first take-off where there is none [rad].
    """

    repeats: bool
    first: int
    count: int  # type: ignore[assignment]  # nobody counts the members of this tuple
    approach: int
    cycles: int
    landing: float
    rest: float
    approach_end: float


def bounces(
    bed: Bed,
    restitution: float,
    flights: Flights,
    most: int,
    start_phase: float,
    start_speed: float,
    from_rest: bool,
) -> Bounces:
    """Find the flights of the steady normal motion.

    From the lift-off of a resting body to the next one of the same phase; if there is none, the flights of a
    cycle that never rests. The rounding of the flights is propagated, Eq. (34): where it has grown past 1e-9
    before a contact closes the cycle, or past 1e-5 before Newton's iteration does, the scene does not say
    which cycle it is.

    Parameters
    ----------
    bed, restitution : Bed, float
        The trough, K > 1, and 0 <= e < 1.
    flights : Flights
        Where the flights are written.
    most : int
        Flights after which the search ends, short bounces not counted.
    start_phase, start_speed : float
        First take-off [rad, A w n].
    from_rest : bool
        Whether it is the lift-off of a resting body. If not, only contacts must be free of rounding.
    """
    if from_rest and _is_thrown_once_a_turn(bed, restitution):
        _write(flights, 0, math.acos(PI / bed.throw), 0.0, Flight(TURN, TURN), TURN, 0.0)
        return Bounces(True, 0, 1, 0, 1, 0.0, 0.0, bed.lift_off)
    phase, speed, lifted, rested = start_phase, start_speed, from_rest, from_rest
    before, since, errors = 0.0, 0.0, Covariance(0.0, 0.0, 0.0)
    events, look_back = 0, _LOOK_BACK
    for row in range(MOST_BOUNCES):
        flown = fly(bed, phase, speed, lifted)
        if math.isnan(flown.length):
            break
        touch = phase + flown.length
        after = after_landing(bed, touch, flown.impact, restitution, ACCUMULATED)
        length = flown.length + after.length
        end = at_break(bed.waves, touch + after.length)
        _write(flights, row, phase, speed, Flight(length, flown.impact), after.impulse, before)
        before, since = before + length, since + length
        short = rested and since <= _SHORT
        errors = propagate(bed, restitution, phase, speed, flown, after.length, errors)
        if after.contact:
            again = next_take_off(bed, end)
            if not (short or within(errors, SHARP)):
                return Bounces(False, 0, 0, row + 1, 0, 0.0, 0.0, again.phase)
            flights.landing[row], flights.rest[row] = end, again.wait
            before += again.wait
            first = _take_off_at(flights, row, again.phase)
            if bed.waves.kind == SINE:
                first = 0  # the only lift-off, also of a body that did not begin at it
            if first >= 0:
                cycles = int(math.floor((before - flights.before[first]) / TURN + 0.5))
                count = row + 1 - first
                return Bounces(True, first, count, first, cycles, end, again.wait, again.phase)
            phase, speed, lifted, rested, since = again.phase, 0.0, True, True, 0.0
            errors = Covariance(0.0, 0.0, 0.0)
            events += 1
            if events >= most:
                break
            continue
        if from_rest and not (short or within(errors, LOST)):
            break
        if row + 1 == look_back:
            look_back *= 2
            lag = _near_repeat(flights, row)
            if lag > 0:
                count, period = _close(bed, restitution, flights, row, lag)
                if count > 0:
                    return Bounces(True, row + 1, count, row, period, 0.0, 0.0, phase)
        if length > BOUNCE:
            events += 1
        if events >= most:
            break
        phase, speed, lifted = end, after.take_off, False
    return Bounces(False, 0, 0, 0, 0, 0.0, 0.0, 0.0)


def rests_as_from_rest(bed: Bed, motion: Bounces) -> bool:
    """Return whether a contact leads to the motion from rest: the trough has one lift-off."""
    return motion.rest > 0.0 and bed.waves.kind == SINE


def _take_off_at(flights: Flights, last: int, phase: float) -> int:
    """Return the first flight that began from rest at a lift-off; -1 if there is none."""
    for row in range(last + 1):
        if flights.speed[row] == 0.0 and flights.phase[row] == phase:
            return row
    return -1


def _write(
    flights: Flights, row: int, phase: float, speed: float, flown: Flight, impulse: float, before: float
) -> None:
    """Put one flight into a row."""
    flights.phase[row] = phase
    flights.speed[row] = speed
    flights.length[row] = flown.length
    flights.impact[row] = flown.impact
    flights.impulse[row] = impulse
    flights.before[row] = before
    flights.landing[row] = 0.0
    flights.rest[row] = 0.0


def _is_thrown_once_a_turn(bed: Bed, restitution: float) -> bool:
    """Return whether a plastic body is thrown again, at the same phase, each time it lands.

    A flight of one turn from rest has K cos p = pi. It repeats if its map's slope 1 - K sin p is within +-1,
    and attracts the body from the lift-off then (tests/core/test_flight.py).
    """
    square = bed.throw * bed.throw - PI * PI  # (K sin p)^2
    return bed.waves.kind == SINE and restitution == 0.0 and 1.0 < square < 4.0


def _apart(flights: Flights, one: int, other: int) -> float:
    """Return the distance of two take-offs [rad + A w n]."""
    turn = abs(2.0 * math.sin(0.5 * (flights.phase[one] - flights.phase[other])))
    return turn + abs(flights.speed[one] - flights.speed[other])


def _near_repeat(flights: Flights, last: int) -> int:
    """Count back to the flight that began nearly as the last did; 0 if there is none."""
    found, nearest = 0, _NEAR
    for lag in range(1, min(LONGEST_CYCLE, (last + 1) // 2) + 1):
        apart = lag * _apart(flights, last - lag, last)
        # not within one chain of bounces
        if apart < nearest and flights.before[last] - flights.before[last - lag] > PI:
            found, nearest = lag, apart / _PREFERRED
    return found


class _Round(NamedTuple):
    """Some flights one after the other.

    Attributes
    ----------
    flies : bool
        Whether no landing leads to a contact; if not, the other numbers mean nothing.
    speed : float
        Of the take-off after them [A w n].
    elapsed : float
        Phase until then [rad].
    derivatives : TangentMap
        From the first take-off to that one.
    """

    flies: bool
    speed: float
    elapsed: float
    derivatives: _TangentMap


def fly_round(
    bed: Bed, restitution: float, flights: Flights, first: int, count: int, phase: float, speed: float
) -> _Round:
    """Fly ``count`` times from a take-off, into the rows from ``first`` on."""
    whole, elapsed = _TangentMap(1.0, 0.0, 0.0, 1.0), 0.0
    for i in range(count):
        if speed <= 0.0 and bed_load(bed, phase) >= 0.0:
            return _Round(False, 0.0, 0.0, whole)  # the trough would not let go of it
        flown = fly(bed, phase, speed, False)
        after = after_landing(bed, phase + flown.length, flown.impact, restitution, ACCUMULATED)
        if after.contact or not flown.impact > 0.0:
            return _Round(False, 0.0, 0.0, whole)
        _write(flights, first + i, phase, speed, flown, after.impulse, elapsed)
        whole = _chained(whole, tangent_map(bed, restitution, phase, flown))
        elapsed += flown.length
        phase, speed = at_break(bed.waves, phase + flown.length), after.take_off
    return _Round(True, speed, elapsed, whole)


def _close(bed: Bed, restitution: float, flights: Flights, last: int, lag: int) -> tuple[int, int]:
    """Solve a cycle of ``lag`` flights by Newton's iteration, from the last take-off.

    Returns how many flights it has, if it is stable, and how many drive cycles it lasts; 0 and 0 if there is
    none. Its flights are written behind the last one.
    """
    first, least = last + 1, _FIRST_STEP
    start_phase, start_speed = flights.phase[last], flights.speed[last]
    for _ in range(_NEWTON_STEPS):
        flown = fly_round(bed, restitution, flights, first, lag, start_phase, start_speed)
        if not flown.flies:
            return 0, 0
        at, elapsed = flown.derivatives, flown.elapsed
        a, b, c, d = at.phase_phase, at.phase_speed, at.speed_phase, at.speed_speed
        late, faster = wrap_around(elapsed), flown.speed - start_speed
        determinant = (1.0 - a) * (1.0 - d) - b * c
        if determinant == 0.0:
            return 0, 0
        step_phase = ((1.0 - d) * late + b * faster) / determinant
        step_speed = ((1.0 - a) * faster + c * late) / determinant
        step = abs(step_phase) + abs(step_speed)
        if step <= _CLOSED * (1.0 + bed.throw):
            trace, product = a + d, a * d - b * c
            if not (abs(trace) < 1.0 + product and abs(product) < 1.0):
                return 0, 0
            return _shortest(flights, first, lag, int(math.floor(elapsed / TURN + 0.5)))
        if not step < least:
            return 0, 0
        start_phase, start_speed = wrap(start_phase + step_phase), max(start_speed + step_speed, 0.0)
        least = _SHRINKS * step
    return 0, 0


def normal_multiplier(bed: Bed, restitution: float, flights: Flights, motion: Bounces) -> float:
    """Return the largest multiplier, by modulus, of a normal motion that repeats: 0 after a contact."""
    whole, start = _TangentMap(1.0, 0.0, 0.0, 1.0), flights.phase[motion.first]
    if flights.speed[motion.first] == 0.0 and next_take_off(bed, start).phase == start:
        return 0.0
    for row in range(motion.first, motion.first + motion.count):
        if flights.rest[row] > 0.0:
            return 0.0
        flown = Flight(flights.length[row], flights.impact[row])
        whole = _chained(whole, tangent_map(bed, restitution, flights.phase[row], flown))
    return _largest_eigenvalue(whole)


def _largest_eigenvalue(at: _TangentMap) -> float:
    """Return the modulus of the larger eigenvalue."""
    half = 0.5 * (at.phase_phase + at.speed_speed)
    determinant = at.phase_phase * at.speed_speed - at.phase_speed * at.speed_phase
    square = half * half - determinant
    return abs(half) + math.sqrt(square) if square >= 0.0 else math.sqrt(determinant)


def _shortest(flights: Flights, first: int, count: int, period: int) -> tuple[int, int]:
    """Cut a cycle that repeats within itself: return its flights and its drive cycles."""
    same = _SAME * (1.0 + flights.impact[first])
    for part in range(1, count):
        if count % part == 0 and _apart(flights, first, first + part) <= same:
            return part, period * part // count
    return count, period


class _SingleBounce(NamedTuple):
    """A cycle of one bounce.

    Attributes
    ----------
    phase, speed : float
        Of its take-off; NaN where there is no such cycle [rad, A w n].
    exists, stable : bool
        Whether there is one, and whether bodies tend to it.
    """

    phase: float
    speed: float
    exists: bool
    stable: bool


def single_bounce(bed: Bed, restitution: float, turns: int, index: int) -> _SingleBounce:
    """Return one of the cycles of one bounce over so many turns, Eq. (37).

    It lands with the speed 2 pi m / (1 + e), where the trough rises with pi m (1 - e) / (1 + e). Of one
    harmonic there is one, index 0; of others those are left out at which the body would land before.
    """
    plus = 1.0 + restitution
    rise, speed = PI * turns * (1.0 - restitution) / plus, TURN * turns * restitution / plus
    if bed.waves.kind != SINE:
        return _nth_bounce(bed, restitution, turns, index, rise, speed)
    if index > 0 or not rise < bed.throw:
        return _SingleBounce(NAN, NAN, False, False)
    phase = math.acos(rise / bed.throw)
    stable = plus * plus * bed.throw * math.sin(phase) < 2.0 * (1.0 + restitution * restitution)
    return _SingleBounce(phase, speed, True, stable)


class _Rise(NamedTuple):
    """A speed with which the trough shall rise."""

    bed: Bed
    speed: float


def _beyond(at: _Rise, phase: float) -> float:
    """Return how much faster the trough rises at a phase."""
    return at.bed.lift.normal * trough_at(at.bed.waves, True, phase).slope - at.speed


def _nth_bounce(
    bed: Bed, restitution: float, turns: int, index: int, rise: float, speed: float
) -> _SingleBounce:
    """Look for the phases at which the trough rises with a speed, at equidistant phases."""
    count, found, at = _PHASES, 0, _Rise(bed, rise)
    over = _beyond(at, 0.0) > 0.0
    for i in range(count):
        low, high = TURN * i / count, TURN * (i + 1) / count
        now = _beyond(at, high) > 0.0
        # the rise falls there: else the cycle is not stable
        if over and not now:
            if found == index:
                phase = bisected(_beyond, at, low, high, True)
                plus, load = 1.0 + restitution, 1.0 - bed_load(bed, phase)
                returns = abs(fly(bed, phase, speed, False).length - TURN * turns) < _NEAR * TURN * turns
                stable = returns and plus * plus * load < 2.0 * (1.0 + restitution * restitution)
                return _SingleBounce(phase, speed, True, stable)
            found += 1
        over = now
    return _SingleBounce(NAN, NAN, False, False)
