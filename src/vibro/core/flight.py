"""One flight, from take-off to the first return to the trough.

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
    FEW_ULP,
    HARMONICS,
    INF,
    NAN,
    PI,
    PIECES,
    QUARTER,
    TURN,
    PathPoint,
    Value,
    free_motion,
    newton,
    sine_gap,
    until,
    wrap,
)
from vibro.core.waves import NORMAL, SINE, Mix, Moved, Waves, depart, load_at, one_harmonic, trough_at

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


_SETTLED: Final = 1e-8  # [1] a last Newton step below this fraction of the length leaves rounding errors only

# [1] Newton's iteration from the far end of a turn needs many steps to the landing of a short bounce, which
# lasts 2 v / N. Start it this much of v / N after the take-off, if that is after the landing: half the steps.
_SHORT_BOUNCE: Final = 2.2


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
