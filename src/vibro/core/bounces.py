"""The normal motion of a hopping body: flights and impacts, in which friction has no part.

It depends on the throw number K and the restitution e alone, and a contact that ends at the lift-off phase
forgets everything before it. So the flights from one such lift-off to the next make the cycle. Flights
without contact that nearly repeat are closed by Newton's iteration. Phases in radians, normal speeds over
n = cos(beta)/G [A w n].
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from vibro.core.buffers import Doubles
from vibro.core.elementary import NAN, PI, TURN, wrap, wrap_around
from vibro.core.flight import (
    ACCUMULATED,
    BOUNCE,
    LOST,
    SHARP,
    Covariance,
    Flight,
    after_landing,
    flight,
    lift_off_flight,
    propagate,
    tangent_map,
    within,
)
from vibro.core.legs import until

__all__ = [
    "LONGEST_CYCLE", "MOST_BOUNCES", "MOST_FLIGHTS", "Bounces", "Flights", "SingleBounce", "bounces",
    "single_bounce",
]  # fmt: skip

#: Flights, short bounces not counted, after which the search for a cycle ends.
MOST_FLIGHTS: Final = 256
#: Flights of one scene, short bounces included; restitutions above 0.995 may need more.
MOST_BOUNCES: Final = 8192
#: Flights in a cycle that never rests on the trough.
LONGEST_CYCLE: Final = 64

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
    """

    phase: Doubles
    speed: Doubles
    length: Doubles
    impact: Doubles
    impulse: Doubles
    before: Doubles


class Bounces(NamedTuple):
    """The steady normal motion of a scene.

    Attributes
    ----------
    repeats : bool
        Whether a cycle was found before rounding could choose it; all else is 0 if not.
    first, count : int
        Its flights are the rows first ... first + count - 1 of ``Flights``.
    approach : int
        Flights before a cycle that begins amid the motion: the rows 0 ... approach - 1; else 0.
    cycles : int
        Drive cycles that the flights and the contact after them last, to a whole cycle.
    landing, rest : float
        Phase at which the contact begins, in [0, 2 pi), and its duration; 0 where the body never rests on the
        trough [rad].
    approach_end : float
        Phase at which the approach ends: the lift-off where there is none [rad].
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
    throw: float,
    restitution: float,
    flights: Flights,
    most: int,
    start_phase: float,
    start_speed: float,
    from_rest: bool,
) -> Bounces:
    """Find the flights of the steady normal motion.

    From the lift-off of a resting body to the next such lift-off; if there is none, the flights of a cycle
    that never rests. The rounding of the flights is propagated, Eq. (34): where it has grown past 1e-9 before
    a contact closes the cycle, or past 1e-5 before Newton's iteration does, the scene does not say which
    cycle it is.

    Parameters
    ----------
    throw, restitution : float
        K > 1 and 0 <= e < 1.
    flights : Flights
        Where the flights are written.
    most : int
        Flights after which the search ends, short bounces not counted.
    start_phase, start_speed : float
        First take-off of a body that does not start from rest [rad, A w n].
    from_rest : bool
        Whether the first take-off is the lift-off of a resting body. If not, only a contact must be free of
        rounding.
    """
    lift_off = math.asin(1.0 / throw)
    if from_rest and _is_thrown_once_a_turn(throw, restitution):
        _write(flights, 0, math.acos(PI / throw), 0.0, Flight(TURN, TURN), TURN, 0.0)
        return Bounces(True, 0, 1, 0, 1, 0.0, 0.0, lift_off)
    phase = lift_off if from_rest else start_phase
    speed = 0.0 if from_rest else start_speed
    before, errors = 0.0, Covariance(0.0, 0.0, 0.0)
    cycles, events, look_back = 0, 0, _LOOK_BACK
    for row in range(MOST_BOUNCES):
        if from_rest and row == 0:
            flown = lift_off_flight(throw, lift_off)
        else:
            flown = flight(throw, lift_off, phase, speed)
        touch = phase + flown.length
        after = after_landing(throw, touch, flown.impact, restitution, ACCUMULATED)
        length, end = flown.length + after.length, touch + after.length
        _write(flights, row, phase, speed, Flight(length, flown.impact), after.impulse, before)
        turns = int(math.floor(end / TURN))
        cycles += turns
        end -= TURN * turns
        short = from_rest and before + length <= _SHORT
        errors = propagate(throw, restitution, phase, speed, flown, after.length, errors)
        if after.contact:
            if not (short or within(errors, SHARP)):
                break
            rest = until(lift_off, end)
            if end + rest > lift_off + PI:
                cycles += 1
            return Bounces(True, 0, row + 1, 0, cycles, end, rest, lift_off)
        if from_rest and not (short or within(errors, LOST)):
            break
        if row + 1 == look_back:
            look_back *= 2
            lag = _near_repeat(flights, row)
            if lag > 0:
                count, period = _close(throw, lift_off, restitution, flights, row, lag)
                if count > 0:
                    return Bounces(True, row + 1, count, row, period, 0.0, 0.0, phase)
        if length > BOUNCE:
            events += 1
        if events >= most:
            break
        phase, speed, before = end, after.take_off, before + length
    return Bounces(False, 0, 0, 0, 0, 0.0, 0.0, 0.0)


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


def _is_thrown_once_a_turn(throw: float, restitution: float) -> bool:
    """Return whether a plastic body is thrown again, at the same phase, each time it lands.

    A flight of one turn from rest has K cos p = pi. It repeats if its map's slope 1 - K sin p is within +-1,
    and attracts the body from the lift-off then (tests/core/test_bounces.py).
    """
    square = throw * throw - PI * PI  # (K sin p)^2
    return restitution == 0.0 and 1.0 < square < 4.0


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


def _close(
    throw: float, lift_off: float, restitution: float, flights: Flights, last: int, lag: int
) -> tuple[int, int]:
    """Solve a cycle of ``lag`` flights by Newton's iteration, from the last take-off.

    Returns how many flights it has, if it is stable, and how many drive cycles it lasts; 0 and 0 if there is
    none. Its flights are written behind the last one.
    """
    first, least = last + 1, _FIRST_STEP
    start_phase, start_speed = flights.phase[last], flights.speed[last]
    for _ in range(_NEWTON_STEPS):
        phase, speed, elapsed = start_phase, start_speed, 0.0
        a, b, c, d = 1.0, 0.0, 0.0, 1.0  # derivatives of the last take-off with respect to the first
        for i in range(lag):
            if speed <= 0.0 and throw * math.sin(phase) <= 1.0:
                return 0, 0  # the trough would not let go of it
            flown = flight(throw, lift_off, phase, speed)
            after = after_landing(throw, phase + flown.length, flown.impact, restitution, ACCUMULATED)
            if after.contact or flown.impact <= 0.0:
                return 0, 0
            _write(flights, first + i, phase, speed, flown, after.impulse, elapsed)
            one = tangent_map(throw, restitution, phase, flown)
            a, c = one.phase_phase * a + one.phase_speed * c, one.speed_phase * a + one.speed_speed * c
            b, d = one.phase_phase * b + one.phase_speed * d, one.speed_phase * b + one.speed_speed * d
            elapsed += flown.length
            phase, speed = wrap(phase + flown.length), after.take_off
        late, faster = wrap_around(elapsed), speed - start_speed
        determinant = (1.0 - a) * (1.0 - d) - b * c
        if determinant == 0.0:
            return 0, 0
        step_phase = ((1.0 - d) * late + b * faster) / determinant
        step_speed = ((1.0 - a) * faster + c * late) / determinant
        step = abs(step_phase) + abs(step_speed)
        if step <= _CLOSED * (1.0 + throw):
            trace, product = a + d, a * d - b * c
            if not (abs(trace) < 1.0 + product and abs(product) < 1.0):
                return 0, 0
            return _shortest(flights, first, lag, int(math.floor(elapsed / TURN + 0.5)))
        if not step < least:
            return 0, 0
        start_phase, start_speed = wrap(start_phase + step_phase), max(start_speed + step_speed, 0.0)
        least = _SHRINKS * step
    return 0, 0


def _shortest(flights: Flights, first: int, count: int, period: int) -> tuple[int, int]:
    """Cut a cycle that repeats within itself: return its flights and its drive cycles."""
    same = _SAME * (1.0 + flights.impact[first])
    for part in range(1, count):
        if count % part == 0 and _apart(flights, first, first + part) <= same:
            return part, period * part // count
    return count, period


class SingleBounce(NamedTuple):
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


def single_bounce(throw: float, restitution: float, turns: int) -> SingleBounce:
    """Return the cycle of one bounce over so many turns, Eq. (37).

    It lands with the speed 2 pi m / (1 + e), where K cos p = pi m (1 - e) / (1 + e).
    """
    plus = 1.0 + restitution
    cosine = PI * turns * (1.0 - restitution) / (throw * plus)
    if not cosine < 1.0:
        return SingleBounce(NAN, NAN, False, False)
    phase = math.acos(cosine)
    stable = plus * plus * throw * math.sin(phase) < 2.0 * (1.0 + restitution * restitution)
    return SingleBounce(phase, TURN * turns * restitution / plus, True, stable)
