"""Bounces: what follows the landings of a hopping body, and the cycles that its flights make.

Friction has no part in the normal motion, which depends on the trough and the restitution e alone. Normal
speeds are over n = cos(beta)/G [A w n], phases in radians; equation numbers are those of docs/theory.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from vibro.core.flight import Bed, Flight, bed_load, fly, next_take_off
from vibro.core.numbers import (
    EPS,
    INF,
    LONGEST_CYCLE,
    MOST_BOUNCES,
    NAN,
    PI,
    PIECES,
    TURN,
    Doubles,
    bisected,
    free_motion,
    wrap,
    wrap_around,
)
from vibro.core.waves import SINE, at_break, depart, moved, trough_at

# ------------------------------------------------------------------------------
# What follows a landing: the law of impact, and how errors of a take-off go on in the next one.

#: [rad] Bounces whose remaining total length is below this are summed as if the load were constant; the error
#: is of the order of its square.
ACCUMULATED: Final = 1e-8
#: [rad] A bounce shorter than this is one of a chain, and a chain that accumulates is one event.
BOUNCE: Final = 0.1
#: [rad, A w n] Standard errors up to which a contact closes a cycle, and above which rounding may choose what
#: comes next.
SHARP: Final = 1e-9
LOST: Final = 1e-5

# [A w n] A grazing landing multiplies errors by a factor without bound: no impact counts as slower than this,
# which is far below those of the shortest flights at K = 1 + 1e-15.
_GRAZING: Final = 1e-30


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
        Whether a cycle was found before rounding could choose it. If not, all else is 0 but the approach: the
        flights until a contact that came too late, and the take-off after it, else all flights and NaN.
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
    events, look_back, rows = 0, _LOOK_BACK, 0
    for row in range(MOST_BOUNCES):
        flown = fly(bed, phase, speed, lifted)
        if math.isnan(flown.length):
            rows = 0
            break
        touch = phase + flown.length
        after = after_landing(bed, touch, flown.impact, restitution, ACCUMULATED)
        length = flown.length + after.length
        end = at_break(bed.waves, touch + after.length)
        _write(flights, row, phase, speed, Flight(length, flown.impact), after.impulse, before)
        rows = row + 1
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
    return Bounces(False, 0, 0, rows, 0, 0.0, 0.0, NAN)


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
    and attracts the body from the lift-off then (tests/core/test_bounces.py).
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
