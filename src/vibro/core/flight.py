"""One flight, from take-off to the first return to the trough, and what follows its landing.

The normal motion is free of friction: a flight depends on the load N/n of a body on the trough, its take-off
phase and its take-off speed alone, eta'' / n = -N/n, which is K sin p - 1 of one harmonic, Eq. (28) of
docs/theory. Normal speeds are over n = cos(beta)/G [A w n], phases in radians.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from vibro.core.buffers import PIECES
from vibro.core.cells import Event, next_event
from vibro.core.drives import Loads
from vibro.core.elementary import (
    EPS,
    INF,
    NAN,
    PI,
    QUARTER,
    TURN,
    PathPoint,
    free_motion,
    sine_gap,
    until,
    wrap,
)
from vibro.core.roots import Value, newton
from vibro.core.wave_flights import fly_over_waves
from vibro.core.waves import NORMAL, SINE, Mix, Waves, at_break, depart, load_at, moved, one_harmonic

__all__ = [
    "ACCUMULATED", "BOUNCE", "LOST", "SHARP", "Bed", "Covariance", "Flight", "Impact", "TangentMap",
    "after_landing", "bed_load", "bed_of", "chained", "flight", "lands_at_jump", "lift_off_flight",
    "next_take_off", "no_bed", "propagate", "sinusoidal", "tangent_map", "within",
]  # fmt: skip

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


def lift_off_flight(bed: Bed, phase: float) -> Flight:
    """Fly from the lift-off of a resting body, at any K > 1: of one harmonic sin p = 1/K.

    Within a drive cycle, c = sqrt(K^2 - 1) <= pi, Eq. (32) for c is a monotone function of the flight's
    length s. A rational approximation of s(c), within 2.8e-6, and one step of Halley's iteration, in terms
    that do not cancel for short flights, find s within 4 eps (tests/core/test_flight.py).
    """
    if bed.waves.kind != SINE:
        length, impact = fly_over_waves(bed.waves, bed.lift, phase, 0.0, True)
        return Flight(length, impact)
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
    """Fly from any take-off to the first landing.

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
    if bed.waves.kind != SINE:
        length, impact = fly_over_waves(bed.waves, bed.lift, phase, speed, False)
        return Flight(length, impact)
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


class TangentMap(NamedTuple):
    """Derivatives of a take-off's phase and speed with respect to those of the take-off before it."""

    phase_phase: float
    phase_speed: float
    speed_phase: float
    speed_speed: float


def tangent_map(bed: Bed, restitution: float, phase: float, flown: Flight) -> TangentMap:
    """Form the derivatives of Eq. (34) for a flight that took off at a phase."""
    if bed.waves.kind != SINE:
        climb, lever = _changed(bed, phase, flown.length)
    else:
        cosine, sine = math.cos(phase), -math.sin(phase)
        lever, climb = free_motion(bed.throw, 0.0, cosine, sine, 0.0, flown.length)
    impact = max(flown.impact, _GRAZING)
    late, late_by_speed = lever / impact, flown.length / impact
    acceleration = -bed_load(bed, phase + flown.length)
    return TangentMap(
        1.0 + late,
        late_by_speed,
        -restitution * (climb + acceleration * late),
        -restitution * (1.0 + acceleration * late_by_speed),
    )


def chained(before: TangentMap, one: TangentMap) -> TangentMap:
    """Multiply two maps: ``before`` leads to the take-off at which ``one`` begins."""
    return TangentMap(
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
