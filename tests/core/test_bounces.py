"""Bounces: the law of impact, errors from flight to flight, and the cycles that flights make."""

from __future__ import annotations

import math
import random

import mpmath
import numpy as np
import pytest
from helpers.cases import each

from vibro.core.bounces import (
    ACCUMULATED,
    BOUNCE,
    LOST,
    MOST_FLIGHTS,
    SHARP,
    Bounces,
    Covariance,
    Flights,
    _close,
    after_landing,
    bounces,
    propagate,
    single_bounce,
    tangent_map,
    within,
)
from vibro.core.flight import Flight, flight, lift_off_flight, sinusoidal
from vibro.core.numbers import LONGEST_CYCLE, MOST_BOUNCES

TURN = 2.0 * math.pi
EPS = 2.0**-52
EXACT = Covariance(0.0, 0.0, 0.0)


def _flight(throw: float, phase: float, speed: float) -> Flight:
    return flight(sinusoidal(throw), phase, speed)


# ------------------------------------------------------------------------------- flights from rest


def test_an_impact_reverses_the_normal_speed_and_shrinks_it() -> None:
    assert after_landing(sinusoidal(2.0), 0.5 * math.pi, 1.5, 0.4, ACCUMULATED) == pytest.approx(
        (0.6, 0.0, 2.1, False)
    )
    # a plastic body stays where the trough presses, and is thrown again where it falls away
    assert after_landing(sinusoidal(2.0), 3.0, 1.5, 0.0, ACCUMULATED) == (0.0, 0.0, 1.5, True)
    assert after_landing(sinusoidal(2.0), 1.0, 1.5, 0.0, ACCUMULATED) == (0.0, 0.0, 1.5, False)


@pytest.mark.parametrize("restitution", [0.1, 0.5, 0.9, 0.9999])
def test_accumulated_bounces_are_summed_as_if_one_flew_them_all(restitution: float) -> None:
    load = 1.0 - 1.5 * math.sin(3.0)
    speed = 0.4e-8 * load * (1.0 - restitution)  # of the first bounce; they last 0.8e-8 altogether
    after = after_landing(sinusoidal(1.5), 3.0, speed / restitution, restitution, ACCUMULATED)
    assert after.contact
    assert after.take_off == 0.0
    # geometric sums of 2 v / N and of (1 + e) v, the impulse of the impact before them too
    assert after.length == pytest.approx(0.8e-8, rel=1e-10)
    impulse = (1.0 + restitution) * speed * (1.0 / restitution + 1.0 / (1.0 - restitution))
    assert after.impulse == pytest.approx(impulse, rel=1e-10)


@pytest.mark.parametrize(("factor", "contact"), [(1.0 - 1e-9, True), (1.0 + 1e-9, False)])
@pytest.mark.parametrize("accumulated", [ACCUMULATED, 5e-2])
def test_bounces_are_summed_once_they_are_short_enough(
    factor: float, contact: bool, accumulated: float
) -> None:
    load = 1.0 - 1.5 * math.sin(3.0)
    impact = 0.5 * accumulated * factor * load * (1.0 - 0.3) / 0.3
    after = after_landing(sinusoidal(1.5), 3.0, impact, 0.3, accumulated)
    assert after.contact is contact
    assert after.take_off == (0.0 if contact else pytest.approx(0.3 * impact))
    assert after.length == (pytest.approx(accumulated) if contact else 0.0)


def test_bounces_are_not_summed_where_the_trough_falls_away_before_they_end() -> None:
    # ahead of the lift-off the load is positive, but vanishes there
    throw, restitution, length, seen = 1.5, 0.5, 1e-9, set()
    for before in np.geomspace(1e-12, 1e-2, 41).tolist():
        phase = math.asin(1.0 / throw) - before
        load = 1.0 - throw * math.sin(phase)
        impact = 0.5 * length * load * (1.0 - restitution) / restitution
        after = after_landing(sinusoidal(throw), phase, impact, restitution, ACCUMULATED)
        fall = throw * math.cos(phase) * length  # of the load, until the bounces end
        if abs(load / fall - 1.0) > 1e-3:
            assert after.contact is (load > fall)
        seen.add(after.contact)
    assert seen == {True, False}
    # where the load grows it does not matter how small it is
    assert after_landing(
        sinusoidal(throw), math.pi - math.asin(1.0 / throw) + 1e-6, 1e-16, 0.5, ACCUMULATED
    ).contact


@pytest.mark.parametrize("impact", [0.0, 1e-320])
def test_a_landing_without_impact_or_load_divides_by_nothing(impact: float) -> None:
    for phase in (0.5 * math.pi, math.pi / 6.0, 3.0):
        for throw in (1.0, 2.0):
            after = after_landing(sinusoidal(throw), phase, impact, 0.5, ACCUMULATED)
            assert all(math.isfinite(x) for x in after)
            assert after.take_off in (0.0, 0.5 * impact)


# ------------------------------------------------------------------------------- errors


def _bounce(throw: float, restitution: float, phase: float, speed: float) -> tuple[float, float]:
    flown = _flight(throw, phase, speed)
    return phase + flown.length, restitution * flown.impact


def _bouncing(count: int) -> list[tuple[float, float, float, float]]:
    draw = random.Random(7)
    return [
        (draw.uniform(1.2, 6.0), draw.uniform(0.2, 0.9), draw.uniform(0.0, TURN), draw.uniform(1.0, 8.0))
        for _ in range(count)
    ]


def test_the_tangent_map_is_the_derivative_of_a_flight_and_its_impact() -> None:
    checked, h = 0, 1e-6
    for throw, restitution, phase, speed in _bouncing(100):
        flown = _flight(throw, phase, speed)
        if flown.impact < 0.5:  # grazing landings bend within the difference
            continue
        got = tangent_map(sinusoidal(throw), restitution, phase, flown)
        for column, (p, v) in enumerate(((h, 0.0), (0.0, h))):
            after = _bounce(throw, restitution, phase + p, speed + v)
            before = _bounce(throw, restitution, phase - p, speed - v)
            for row in (0, 1):
                slope = (after[row] - before[row]) / (2.0 * h)
                assert got[2 * row + column] == pytest.approx(slope, rel=1e-5, abs=1e-5)
        # the flux v dp dv through the trough's surface is conserved in flight
        a, b, c, d = got
        assert a * d - b * c == pytest.approx(restitution * speed / flown.impact, rel=1e-9)
        checked += 1
    assert checked > 90


def test_the_covariance_of_many_bodies_is_what_is_propagated() -> None:
    noise, error, checked = np.random.default_rng(8).standard_normal((40, 2, 200)), 1e-8, 0
    for (throw, restitution, phase, speed), (phases, speeds) in zip(_bouncing(40), noise, strict=True):
        bodies = [
            (phase + error * p, speed + error * (0.6 * p + 0.8 * v))
            for p, v in zip(phases.tolist(), speeds.tolist(), strict=True)
        ]
        errors = Covariance(error**2, 0.6 * error**2, error**2)
        for _ in range(2):
            flown = _flight(throw, phase, speed)
            errors = propagate(sinusoidal(throw), restitution, phase, speed, flown, 0.0, errors)
            phase, speed = _bounce(throw, restitution, phase, speed)
            bodies = [_bounce(throw, restitution, *body) for body in bodies]
            if flown.impact < 0.3 or errors.phase > 1e-12:
                break
            off = np.array(bodies) - (phase, speed)
            drawn = off.T @ off / len(bodies)
            assert 0.6 < errors.phase / drawn[0, 0] < 1.7
            assert 0.6 < errors.speed / drawn[1, 1] < 1.7
            scale = math.sqrt(errors.phase * errors.speed)
            assert errors.both / scale == pytest.approx(drawn[0, 1] / scale, abs=0.35)
            checked += 1
    assert checked > 60


def test_summed_bounces_add_the_scatter_of_their_duration() -> None:
    throw, restitution, phase, speed = 1.5, 0.5, 4.0, 0.3
    flown, errors = _flight(throw, phase, speed), Covariance(0.0, 0.0, 1.0)
    without = propagate(sinusoidal(throw), restitution, phase, speed, flown, 0.0, errors)
    tail = 0.7
    got = propagate(sinusoidal(throw), restitution, phase, speed, flown, tail, errors)
    # they last in proportion to the speed of the first, e u
    lever = tail / (restitution * flown.impact)
    assert got.phase - without.phase == pytest.approx(lever**2 * without.speed, rel=1e-9)
    assert (got.both, got.speed) == (without.both, without.speed)


def test_the_rounding_of_a_flight_is_covered_and_not_exaggerated() -> None:
    worst = 0.0
    with mpmath.workdps(40):
        for throw, restitution, phase, speed in _bouncing(40):
            flown = _flight(throw, phase, speed)
            errors = propagate(sinusoidal(throw), restitution, phase, speed, flown, 0.0, EXACT)
            p, v = mpmath.mpf(phase), mpmath.mpf(speed)

            def height(s: mpmath.mpf, k: float = throw, p: mpmath.mpf = p, v: mpmath.mpf = v) -> mpmath.mpf:
                return v * s + k * (s * mpmath.cos(p) + mpmath.sin(p) - mpmath.sin(p + s)) - s * s / 2

            exact = mpmath.findroot(height, flown.length)
            rate = v + throw * (mpmath.cos(p) - mpmath.cos(p + exact)) - exact
            late = abs(float(exact - flown.length)) / math.sqrt(errors.phase)
            fast = restitution * abs(float(flown.impact + rate)) / math.sqrt(errors.speed)
            assert max(late, fast) <= 4.0
            worst = max(worst, late)
    assert worst > 0.02


def test_a_flight_from_rest_on_the_trough_has_all_digits() -> None:
    # its terms do not cancel, however short it is: only the phase of its landing is rounded
    throw = 1.0 + 1e-10
    lift_off = math.asin(1.0 / throw)
    flown = lift_off_flight(sinusoidal(throw), lift_off)
    errors = propagate(sinusoidal(throw), 0.0, lift_off, 0.0, flown, 0.0, EXACT)
    assert math.sqrt(errors.phase) == pytest.approx(EPS * (1.0 + flown.length))
    kicked = propagate(sinusoidal(throw), 0.0, lift_off, 1e-300, flown, 0.0, EXACT)
    later = propagate(sinusoidal(throw), 0.0, lift_off + 1e-5, 0.0, flown, 0.0, EXACT)
    longer = propagate(sinusoidal(throw), 0.0, lift_off, 0.0, flown._replace(length=TURN * 1.01), 0.0, EXACT)
    for other in (kicked, later, longer):
        assert other.phase > 1e4 * errors.phase


def test_a_grazing_landing_loses_digits() -> None:
    flown = _flight(2.0, 2.0, 1.0)
    known = [
        propagate(sinusoidal(2.0), 0.5, 2.0, 1.0, flown._replace(impact=impact), 0.0, EXACT)
        for impact in (1.0, 1e-4, 1e-12, 0.0)
    ]
    assert [within(errors, SHARP) for errors in known] == [True, True, False, False]
    assert [within(errors, LOST) for errors in known] == [True, True, False, False]


# ------------------------------------------------------------------------------
# Flights over any periodic trough: first landings beside a dense mesh, and how few pieces they take.
BYTES = 8 * (MOST_BOUNCES + LONGEST_CYCLE)
FLIGHTS = Flights(*(memoryview(bytearray(BYTES)).cast("d") for _ in Flights._fields))


def _from_rest(throw: float, restitution: float, most: int = MOST_FLIGHTS) -> Bounces:
    return bounces(sinusoidal(throw), restitution, FLIGHTS, most, math.asin(1.0 / throw), 0.0, True)


def _column(column: memoryview[float], motion: Bounces) -> list[float]:
    """List what the flights of a cycle have in a column."""
    return [column[row] for row in range(motion.first, motion.first + motion.count)]


def _onward(throw: float, restitution: float, phase: float, speed: float) -> tuple[float, float]:
    """Fly once and bounce."""
    flown = flight(sinusoidal(throw), phase, speed)
    return (phase + flown.length) % TURN, restitution * flown.impact


def _apart(one: float, other: float) -> float:
    return abs(math.remainder(one - other, TURN))


# ------------------------------------------------------------------------------- cycles with contact


def test_the_momentum_of_a_cycle_is_that_of_the_weight() -> None:
    draw, closed = random.Random(1), 0
    for i in range(200):
        throw, restitution = draw.uniform(1.01, 6.0), (0.0, 0.1, 0.25)[i % 3]
        motion = _from_rest(throw, restitution)
        if not motion.repeats:
            continue
        closed += 1
        # Eq. (29); in contact the load is 1 - K sin p
        end = motion.landing + motion.rest
        impulse = sum(_column(FLIGHTS.impulse, motion)) + motion.rest
        impulse += throw * (math.cos(end) - math.cos(motion.landing))
        # bounces that accumulate are summed as if the load were constant over their last 1e-8 rad
        assert impulse == pytest.approx(TURN * motion.cycles, abs=1e-7)
        assert sum(_column(FLIGHTS.length, motion)) + motion.rest == pytest.approx(TURN * motion.cycles)
    assert closed > 170


@pytest.mark.parametrize(("throw", "restitution"), [(1.3, 0.3), (1.05, 0.9), (3.9, 0.0), (5.0, 0.1)])
def test_each_flight_begins_where_the_one_before_it_ends(throw: float, restitution: float) -> None:
    motion = _from_rest(throw, restitution)
    assert motion.repeats
    assert motion.rest > 0.0
    assert (motion.first, motion.approach) == (0, 0)
    lift_off = math.asin(1.0 / throw)
    assert motion.approach_end == lift_off
    phase, speed, before = lift_off, 0.0, 0.0
    for row in range(motion.count):
        assert _apart(FLIGHTS.phase[row], phase) < 1e-9
        assert 0.0 <= FLIGHTS.phase[row] < TURN
        assert FLIGHTS.speed[row] == pytest.approx(speed, abs=1e-9)
        assert FLIGHTS.before[row] == pytest.approx(before, rel=1e-12)
        phase, speed = FLIGHTS.phase[row] + FLIGHTS.length[row], restitution * FLIGHTS.impact[row]
        before += FLIGHTS.length[row]
    assert _apart(motion.landing, phase) < 1e-9
    assert 0.0 <= motion.landing < TURN
    assert _apart(motion.landing + motion.rest, lift_off) < 1e-9
    assert (before + motion.rest) / TURN == pytest.approx(motion.cycles, rel=1e-12)


def test_plastic_bodies_fill_whole_drive_cycles_at_any_throw_number() -> None:
    for throw in np.linspace(1.001, 8.0, 100).tolist():
        motion = _from_rest(throw, 0.0)
        assert motion.repeats
        time = sum(_column(FLIGHTS.length, motion)) + motion.rest
        assert time == pytest.approx(TURN * motion.cycles, rel=1e-12)


@pytest.mark.parametrize("throw", [1.0001, 1.5, 3.0, math.sqrt(1.0 + math.pi**2) - 1e-9])
def test_up_to_one_cycle_of_flight_a_plastic_impact_makes_one_flight_a_cycle(throw: float) -> None:
    motion = _from_rest(throw, 0.0)
    assert motion.repeats
    assert (motion.count, motion.cycles) == (1, 1)
    assert motion.rest > 0.0
    assert _column(FLIGHTS.impulse, motion) == _column(FLIGHTS.impact, motion)


@pytest.mark.parametrize("restitution", [0.0, 0.3, 0.9])
def test_hops_near_the_threshold_are_the_same_but_for_their_scale(restitution: float) -> None:
    # while K sin p - 1 is a parabola in time, times are in proportion to sqrt(K^2 - 1)
    scaled = []
    for excess in np.geomspace(1e-15, 1e-7, 17).tolist():
        motion = _from_rest(1.0 + excess, restitution)
        assert motion.repeats
        scaled.append(sum(_column(FLIGHTS.length, motion)) / math.sqrt((1.0 + excess) ** 2 - 1.0))
    assert scaled[5:] == pytest.approx([scaled[-1]] * 12, rel=1e-2)
    assert max(scaled) < 2.0 * scaled[-1]


def test_rounding_decides_longer_hops_and_they_have_no_cycle() -> None:
    # past 1.8e-3 rad after the lift-off the landing must be known to 1e-9 rad
    throw, restitution = 1.0 + 1e-5, 0.3
    motion = _from_rest(throw, restitution)
    errors = Covariance(0.0, 0.0, 0.0)
    for row in range(motion.count):
        phase, speed = FLIGHTS.phase[row], FLIGHTS.speed[row]
        flown = flight(sinusoidal(throw), phase, speed)
        errors = propagate(sinusoidal(throw), restitution, phase, speed, flown, 0.0, errors)
    assert sum(_column(FLIGHTS.length, motion)) > 1.8e-3
    assert motion.repeats is (math.sqrt(errors.phase) < 1e-9)


# ------------------------------------------------------------------------------- cycles without contact

LOWEST, HIGHEST = math.sqrt(math.pi**2 + 1.0), math.sqrt(math.pi**2 + 4.0)


@pytest.mark.parametrize(
    ("throw", "count"),
    [(LOWEST - 1e-3, 1), (LOWEST + 1e-9, 1), (3.5, 1), (HIGHEST - 1e-9, 1), (HIGHEST + 1e-3, 2)],
)
def test_above_one_cycle_of_flight_the_body_is_thrown_again_where_it_lands(throw: float, count: int) -> None:
    motion = _from_rest(throw, 0.0)
    assert motion.repeats
    assert (motion.count, motion.cycles) == (count, count)
    assert (motion.rest > 0.0) is (throw < LOWEST)
    if LOWEST < throw < HIGHEST:
        # Eq. (32) for a turn: K cos p = pi; nothing bounces, so that the impulse is that of the impact alone
        assert motion == Bounces(True, 0, 1, 0, 1, 0.0, 0.0, math.asin(1.0 / throw))
        assert throw * math.cos(FLIGHTS.phase[0]) == pytest.approx(math.pi)
        row = (FLIGHTS.speed[0], FLIGHTS.length[0], FLIGHTS.impact[0], FLIGHTS.impulse[0], FLIGHTS.before[0])
        assert row == (0.0, TURN, TURN, TURN, 0.0)


@pytest.mark.parametrize("throw", [3.35, 3.5, 3.7])
def test_flight_after_flight_leads_to_the_closed_form_of_one_turn(throw: float) -> None:
    phase = math.asin(1.0 / throw)
    for _ in range(400):
        phase, _ = _onward(throw, 0.0, phase, 0.0)
        assert throw * math.sin(phase) >= 1.0
    _from_rest(throw, 0.0)
    assert FLIGHTS.phase[0] == pytest.approx(phase, abs=1e-9)


@pytest.mark.parametrize(
    ("throw", "restitution", "count", "cycles", "approach"),
    [
        (3.76, 0.0, 2, 2, 7),
        (6.4, 0.0, 1, 2, 7),
        (2.54, 0.1, 2, 1, 7),
        (2.24, 0.3, 2, 2, 15),
        (2.3, 0.3, 4, 4, 15),
        (2.4, 0.2, 1, 1, 31),
    ],
)
def test_a_cycle_that_never_rests_is_one_of_the_flight_map(
    throw: float, restitution: float, count: int, cycles: int, approach: int
) -> None:
    motion = _from_rest(throw, restitution)
    assert motion.repeats
    # it is looked for after 8, 16, 32 ... flights
    assert (motion.count, motion.cycles, motion.approach) == (count, cycles, approach)
    assert (motion.landing, motion.rest) == (0.0, 0.0)
    # its flights stand behind those of the approach, and behind the one that it was started from
    assert motion.first == motion.approach + 1
    assert FLIGHTS.phase[motion.approach] == motion.approach_end
    rows = range(motion.first, motion.first + count)
    jacobian = np.eye(2)
    for row, following in zip(rows, [*rows[1:], rows[0]], strict=True):
        phase, speed = FLIGHTS.phase[row], FLIGHTS.speed[row]
        flown = flight(sinusoidal(throw), phase, speed)
        assert (FLIGHTS.length[row], FLIGHTS.impact[row]) == pytest.approx(flown, rel=1e-12)
        assert FLIGHTS.impulse[row] == pytest.approx((1.0 + restitution) * flown.impact)
        assert not after_landing(
            sinusoidal(throw), phase + flown.length, flown.impact, restitution, 1e-8
        ).contact
        assert _apart(phase + flown.length, FLIGHTS.phase[following]) < 1e-11
        assert restitution * flown.impact == pytest.approx(FLIGHTS.speed[following], abs=1e-11)
        jacobian = (
            np.array(tangent_map(sinusoidal(throw), restitution, phase, flown)).reshape(2, 2) @ jacobian
        )
    assert abs(np.linalg.eigvals(jacobian)).max() < 1.0
    assert sum(_column(FLIGHTS.length, motion)) == pytest.approx(TURN * cycles, rel=1e-12)
    # the approach ends near it
    near = [_apart(motion.approach_end, p) for p in _column(FLIGHTS.phase, motion)]
    assert min(near) < 0.1


def test_an_unstable_cycle_and_a_start_far_from_any_are_not_closed() -> None:
    throw, restitution = 1.6, 0.7
    at = single_bounce(sinusoidal(throw), restitution, 2, 0)
    assert at.exists
    assert not at.stable
    FLIGHTS.phase[20], FLIGHTS.speed[20] = at.phase + 1e-6, at.speed
    assert _close(sinusoidal(throw), restitution, FLIGHTS, 20, 1) == (0, 0)
    FLIGHTS.phase[20], FLIGHTS.speed[20] = at.phase + 1.0, at.speed
    assert _close(sinusoidal(1.4), restitution, FLIGHTS, 20, 1) == (0, 0)


def test_motion_without_a_cycle_has_no_flights_to_show() -> None:
    for throw in np.linspace(2.4, 2.5, 10).tolist():
        found = _from_rest(throw, 0.3)
        assert found.approach > 0
        assert math.isnan(found.approach_end)
        assert found._replace(approach=0, approach_end=0.0) == Bounces(False, 0, 0, 0, 0, 0.0, 0.0, 0.0)


@each("throw", [1.0 + 1e-12, 1.0001, 10.0, 1e3, 1e6])
@each("restitution", [0.0, 0.5, 0.99])
def test_the_work_is_bounded_for_any_throw_number(throw: float, restitution: float) -> None:
    motion = _from_rest(throw, restitution)
    lengths = _column(FLIGHTS.length, motion)
    assert sum(length > BOUNCE for length in lengths) <= MOST_FLIGHTS
    assert all(math.isfinite(length) and length >= 0.0 for length in lengths)
    assert motion.first + motion.count <= MOST_BOUNCES + LONGEST_CYCLE


def test_the_search_ends_after_so_many_flights_that_are_no_short_bounces() -> None:
    needed = _from_rest(7.0, 0.0)
    assert needed.count == 2
    assert _from_rest(7.0, 0.0, 2) == needed
    assert not _from_rest(7.0, 0.0, 1).repeats
    # a chain of hundreds of short bounces counts as nothing
    chain = _from_rest(1.0001, 0.9)
    assert chain.count > 50
    assert _from_rest(1.0001, 0.9, 1) == chain


# ------------------------------------------------------------------------------- other starts


def test_a_start_amid_the_motion_is_followed_from_there() -> None:
    motion = bounces(sinusoidal(1.3), 0.3, FLIGHTS, 64, 2.5, 4.0, False)
    assert (FLIGHTS.phase[0], FLIGHTS.speed[0], FLIGHTS.before[0]) == (2.5, 4.0, 0.0)
    assert motion.repeats
    expected = flight(sinusoidal(1.3), 2.5, 4.0)
    assert (FLIGHTS.length[0], FLIGHTS.impact[0]) == expected
    last = motion.count - 1
    assert _apart(motion.landing, FLIGHTS.phase[last] + FLIGHTS.length[last]) < 1e-9
    assert _apart(motion.landing + motion.rest, math.asin(1.0 / 1.3)) < 1e-9


def test_a_start_beside_a_single_bounce_is_drawn_to_it_if_that_is_stable() -> None:
    at = single_bounce(sinusoidal(1.4), 0.7, 2, 0)
    assert at.stable
    motion = bounces(sinusoidal(1.4), 0.7, FLIGHTS, 64, at.phase + 1e-3, at.speed, False)
    assert motion.repeats
    assert (motion.count, motion.cycles, motion.rest) == (1, 2, 0.0)
    assert FLIGHTS.phase[motion.first] == pytest.approx(at.phase, abs=1e-10)
    assert FLIGHTS.speed[motion.first] == pytest.approx(at.speed, abs=1e-10)


def test_a_resting_body_at_the_phase_of_one_turn_is_not_taken_for_another_start() -> None:
    # the closed form belongs to bodies from rest alone
    motion = bounces(sinusoidal(3.5), 0.0, FLIGHTS, 64, 0.0, 9.0, False)
    assert FLIGHTS.speed[0] == 9.0
    assert motion.repeats


def test_rounding_ends_the_search_from_rest_alone() -> None:
    # irregular flights: from rest they are known to 1e-5 for some dozens, other starts go on to the limit
    _from_rest(2.45, 0.3)
    FLIGHTS.phase[200] = -1.0
    _from_rest(2.45, 0.3)
    assert FLIGHTS.phase[200] == -1.0
    bounces(sinusoidal(2.45), 0.3, FLIGHTS, 256, math.asin(1.0 / 2.45), 0.0, False)
    assert FLIGHTS.phase[200] >= 0.0


# ------------------------------------------------------------------------------- cycles of one bounce


@pytest.mark.parametrize("turns", [1, 2, 3])
@pytest.mark.parametrize("restitution", [0.5, 0.8, 0.95])
def test_a_single_bounce_repeats_and_is_stable_as_its_tangent_map_says(
    turns: int, restitution: float
) -> None:
    plus, length = 1.0 + restitution, TURN * turns
    level, steep = math.pi * turns * (1.0 - restitution) / plus, 2.0 * (1.0 + restitution**2) / plus**2
    for share, stable in ((1e-3, True), (0.5, True), (0.999, True), (1.001, False), (3.0, False)):
        throw = math.hypot(level, share * steep)
        bed = sinusoidal(max(throw, 1.0))._replace(throw=throw)  # a body may bounce on a trough that bears it
        at = single_bounce(bed, restitution, turns, 0)
        assert at.exists
        assert at.stable is stable
        # it lands with u = 2 pi m / (1 + e) after m turns: Eqs. (30) and (37)
        assert throw * math.cos(at.phase) == pytest.approx(level)
        assert at.speed == pytest.approx(restitution * length / plus)
        height = at.speed * length + throw * length * math.cos(at.phase) - 0.5 * length**2
        assert height == pytest.approx(0.0, abs=1e-12 * length**2)
        slopes = tangent_map(bed, restitution, at.phase, Flight(length, length - at.speed))
        jacobian = np.array(slopes).reshape(2, 2)
        assert np.linalg.det(jacobian) == pytest.approx(restitution**2)
        assert stable is bool(abs(np.linalg.eigvals(jacobian)).max() < 1.0)


def test_a_single_bounce_exists_from_the_throw_number_on_that_can_throw_it_so_far() -> None:
    least = 2.0 * math.pi * (1.0 - 0.2) / (1.0 + 0.2)
    below, above = (single_bounce(sinusoidal(least * x), 0.2, 2, 0) for x in (1.0 - 1e-9, 1.0 + 1e-9))
    assert not below.exists
    assert not below.stable
    assert math.isnan(below.phase)
    assert math.isnan(below.speed)
    assert above.exists
    assert above.phase == pytest.approx(0.0, abs=1e-4)
    assert not single_bounce(sinusoidal(math.pi), 0.0, 1, 0).exists  # equality


def test_a_contact_that_rounding_has_moved_tells_where_the_body_takes_off_again() -> None:
    bed, e = sinusoidal(1.6), 0.7
    motion = bounces(bed, e, FLIGHTS, 512, bed.lift_off, 1e-6, False)
    assert not motion.repeats
    assert motion.count == motion.cycles == 0
    assert motion.approach > 20
    assert motion.landing == motion.rest == 0.0
    assert motion.approach_end == bed.lift_off
