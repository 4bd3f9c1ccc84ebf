"""One flight and its landing: first return beside a fine mesh and 50 digits, impact law, growth of errors."""

from __future__ import annotations

import math
import random

import mpmath
import numpy as np
import pytest
from helpers.cases import each

from vibro.core.flight import (
    ACCUMULATED,
    LOST,
    SHARP,
    Covariance,
    Flight,
    after_landing,
    flight,
    lift_off_flight,
    propagate,
    sinusoidal,
    tangent_map,
    within,
)

TURN = 2.0 * math.pi
EPS = 2.0**-52
ONE_TURN = math.sqrt(1.0 + math.pi**2)  # throw number at which a flight from rest lasts one turn
EXACT = Covariance(0.0, 0.0, 0.0)


def _flight(throw: float, phase: float, speed: float) -> Flight:
    return flight(sinusoidal(throw), phase, speed)


def _released(throw: float) -> Flight:
    return lift_off_flight(sinusoidal(throw), math.asin(1.0 / throw))


# ------------------------------------------------------------------------------- flights from rest


@each("cycles", np.linspace(0.05, 1.0, 20).tolist())
def test_flight_time_and_throw_number_are_related_as_published(cycles: float) -> None:
    x = TURN * cycles
    throw = math.sqrt(((math.cos(x) + 0.5 * x * x - 1.0) / (x - math.sin(x))) ** 2 + 1.0)
    assert _released(throw).length / TURN == pytest.approx(cycles, rel=1e-11)


@each(
    ("throw", "cycles"),
    [
        (1.1, "0.27711"),
        (1.5, "0.56758"),
        (2.0, "0.74148"),
        (2.5, "0.85731"),
        (3.0, "0.94977"),
        (ONE_TURN, "1.00000"),
    ],
)
def test_flight_times_to_all_printed_digits(throw: float, cycles: str) -> None:
    assert f"{_released(throw).length / TURN:.5f}" == cycles


def test_a_lift_off_flight_has_all_digits_however_short() -> None:
    """Compare with 50 digits: the docstring of ``lift_off_flight`` states this bound."""
    throws = np.concatenate((1.0 + np.logspace(-15, -1, 29), np.linspace(1.1, ONE_TURN, 60)))
    throws[-1] = math.nextafter(ONE_TURN, 0.0)
    with mpmath.workdps(60):
        for throw in throws.tolist():
            got = _released(throw)
            c = mpmath.mpf(math.sqrt((throw - 1.0) * (throw + 1.0)))

            def height(s: mpmath.mpf, c: mpmath.mpf = c) -> mpmath.mpf:
                return (c * (s - mpmath.sin(s)) + 1 - mpmath.cos(s) - s * s / 2) / s**3

            exact = mpmath.findroot(height, mpmath.mpf(got.length))
            landing = exact - mpmath.sin(exact) - c * (1 - mpmath.cos(exact))
            assert abs(got.length / exact - 1) < 4 * EPS
            assert abs(got.impact / landing - 1) < 20 * EPS


@pytest.mark.parametrize("throw", [1.01, 1.3, 2.0, 3.0, 3.29])
def test_a_flight_from_the_lift_off_agrees_with_the_general_one(throw: float) -> None:
    # near the lift-off the height grows with the cube of time only, so the general one has fewer digits
    general = _flight(throw, math.asin(1.0 / throw), 0.0)
    assert general == pytest.approx(_released(throw), rel=1e-10)


@pytest.mark.parametrize("throw", [math.nextafter(ONE_TURN, 9.0), 3.4, 12.0, 1e6])
def test_a_flight_from_rest_longer_than_a_turn_is_the_general_one(throw: float) -> None:
    lift_off = math.asin(1.0 / throw)
    assert lift_off_flight(sinusoidal(throw), lift_off) == flight(sinusoidal(throw), lift_off, 0.0)
    assert lift_off_flight(sinusoidal(throw), lift_off).length > TURN * (1.0 - 1e-12)


# ------------------------------------------------------------------------------- any take-off


def _take_offs(count: int, seed: int, most_throw: float) -> list[tuple[float, float, float]]:
    """Draw take-offs: from rest where the trough falls away, and with a speed anywhere."""
    draw, states = random.Random(seed), []
    for i in range(count):
        throw = math.exp(draw.uniform(math.log(1.001), math.log(most_throw)))
        lift_off = math.asin(1.0 / throw)
        released = lift_off + (math.pi - 2.0 * lift_off) * draw.random()
        speed = throw * math.exp(draw.uniform(-12.0, 1.0))
        states.append((throw, released, 0.0) if i % 2 else (throw, draw.uniform(0.0, TURN), speed))
    return states


@pytest.mark.parametrize("most_throw", [4.0, 1000.0])
def test_the_landing_is_the_first_return_to_the_trough(most_throw: float) -> None:
    for throw, phase, speed in _take_offs(400, 1, most_throw):
        got = _flight(throw, phase, speed)
        assert got.length > 0.0
        assert got.impact >= 0.0
        s = np.linspace(0.0, got.length, 4001)[1:]
        lever = s * math.cos(phase) + math.sin(phase) - np.sin(phase + s)
        height = speed * s + throw * lever - 0.5 * s * s
        rounding = 1e-14 * (throw * s + s * s) + 1e-15 * throw
        assert (height > -rounding)[:-1].all()
        assert abs(height[-1]) <= 4.0 * rounding[-1]
        rate = speed + throw * (math.cos(phase) - math.cos(phase + got.length)) - got.length
        assert got.impact == pytest.approx(-rate, abs=1e-12 * throw)


def test_a_flight_flown_backwards_is_a_flight() -> None:
    # K sin p is the same at pi - p: a take-off that is barely one becomes a landing that barely touches
    draw, grazing = random.Random(3), 0
    for _ in range(4000):
        throw, speed = math.exp(draw.uniform(0.1, 3.0)), math.exp(draw.uniform(-6.0, 0.0))
        lift_off = math.asin(1.0 / throw)
        phase = draw.uniform(lift_off - 2.0 * math.sqrt(speed / throw), math.pi - lift_off)
        there = _flight(throw, phase, speed)
        if there.length < 0.5:
            continue
        back = _flight(throw, math.pi - phase - there.length, there.impact)
        lost = 64.0 * EPS * (there.impact + throw + there.length) * (1.0 + there.length) / speed
        assert back.length == pytest.approx(there.length, rel=0.0, abs=lost)
        assert back.impact == pytest.approx(speed, rel=0.0, abs=lost * (1.0 + throw))
        grazing += phase < lift_off  # where the trough, seen backwards, does not yet press
    assert grazing > 300


@each("phase", [-1.0, 0.0, 2.9, 4.0])
@each("speed", [1e-3, 1e-6, 1e-9, 1e-12])
def test_a_short_bounce_lasts_twice_its_speed_over_the_load(phase: float, speed: float) -> None:
    got = _flight(2.0, phase, speed)
    assert got.length == pytest.approx(2.0 * speed / (1.0 - 2.0 * math.sin(phase)), rel=10.0 * speed + 1e-4)
    assert got.impact == pytest.approx(speed, rel=10.0 * speed + 1e-3)


def test_short_bounces_keep_their_digits() -> None:
    throw, phase = 1.5, 2.9
    with mpmath.workdps(50):
        p = mpmath.mpf(phase)
        for speed in np.geomspace(1e-2, 1e-11, 40).tolist():
            got = _flight(throw, phase, speed)

            def height(s: mpmath.mpf, v: float = speed, p: mpmath.mpf = p) -> mpmath.mpf:
                turned = mpmath.cos(p) * (s - mpmath.sin(s)) + mpmath.sin(p) * (1 - mpmath.cos(s))
                return (v * s + throw * turned - s * s / 2) / s

            exact = mpmath.findroot(height, 2.0 * speed / (1.0 - throw * math.sin(phase)))
            rate = speed + throw * (mpmath.cos(p) - mpmath.cos(p + exact)) - exact
            assert abs(got.length - exact) < 16 * EPS * exact
            assert abs(got.impact + rate) < 64 * EPS * speed


@pytest.mark.parametrize("phase", [4.7, 5.0, 5.5])
def test_a_landing_grazes_before_a_faster_body_clears_the_trough_there(phase: float) -> None:
    speeds = np.linspace(0.5, 8.0, 200)
    lengths = np.array([_flight(3.0, phase, speed).length for speed in speeds.tolist()])
    jump = int(np.argmax(np.diff(lengths)))
    low, high = float(speeds[jump]), float(speeds[jump + 1])
    for _ in range(60):
        middle = 0.5 * (low + high)
        if _flight(3.0, phase, middle).length < 0.5 * (lengths[jump] + lengths[jump + 1]):
            low = middle
        else:
            high = middle
    below, above = _flight(3.0, phase, low), _flight(3.0, phase, high)
    assert below.length < above.length - 0.5
    assert below.impact < 1e-6
    assert above.impact > 0.1


@pytest.mark.parametrize("throw", [1.0 + 1e-15, 1.5, 1e3, 1e6])
def test_a_body_let_go_at_a_crest_lands_within_the_turns_that_its_fall_takes(throw: float) -> None:
    got = _flight(throw, 0.5 * math.pi, 0.0)
    assert 0.0 <= got.length < 2.0 * math.sqrt(throw) + TURN
    below = throw * (math.sin(0.5 * math.pi + got.length) - 1.0)  # height of the trough below the crest
    assert -0.5 * got.length**2 == pytest.approx(below, abs=1e-9 * throw)


# ------------------------------------------------------------------------------- impacts


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
