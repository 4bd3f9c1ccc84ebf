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
    MOST_FLIGHTS,
    Bounces,
    Covariance,
    Flights,
    after_landing,
    bounces,
    propagate,
    single_bounce,
    tangent_map,
)
from vibro.core.flight import Flight, flight, sinusoidal
from vibro.core.numbers import LONGEST_CYCLE, MOST_BOUNCES

TURN = 2.0 * math.pi
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


# ------------------------------------------------------------------------------- errors


def _bouncing(count: int) -> list[tuple[float, float, float, float]]:
    draw = random.Random(7)
    return [
        (draw.uniform(1.2, 6.0), draw.uniform(0.2, 0.9), draw.uniform(0.0, TURN), draw.uniform(1.0, 8.0))
        for _ in range(count)
    ]


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


# ------------------------------------------------------------------------------
# Cycles that flights make.
BYTES = 8 * (MOST_BOUNCES + LONGEST_CYCLE)
FLIGHTS = Flights(*(memoryview(bytearray(BYTES)).cast("d") for _ in Flights._fields))


def _from_rest(throw: float, restitution: float, most: int = MOST_FLIGHTS) -> Bounces:
    return bounces(sinusoidal(throw), restitution, FLIGHTS, most, math.asin(1.0 / throw), 0.0, True)


def _column(column: memoryview[float], motion: Bounces) -> list[float]:
    """List what the flights of a cycle have in a column."""
    return [column[row] for row in range(motion.first, motion.first + motion.count)]


@each("throw", [1.0 + 1e-12, 1.0001, 10.0, 1e3, 1e6])
@each("restitution", [0.0, 0.5, 0.99])
def test_the_work_is_bounded_for_any_throw_number(throw: float, restitution: float) -> None:
    motion = _from_rest(throw, restitution)
    lengths = _column(FLIGHTS.length, motion)
    assert sum(length > BOUNCE for length in lengths) <= MOST_FLIGHTS
    assert all(math.isfinite(length) and length >= 0.0 for length in lengths)
    assert motion.first + motion.count <= MOST_BOUNCES + LONGEST_CYCLE


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
