"""Flights: beside meshes and 50 digits."""

from __future__ import annotations

import math
import random

import mpmath
import numpy as np
import pytest

from vibro.core.flight import Flight, flight, lift_off_flight, sinusoidal

TURN = 2.0 * math.pi
EPS = 2.0**-52
ONE_TURN = math.sqrt(1.0 + math.pi**2)  # throw number at which a flight from rest lasts one turn


def _flight(throw: float, phase: float, speed: float) -> Flight:
    return flight(sinusoidal(throw), phase, speed)


def _released(throw: float) -> Flight:
    return lift_off_flight(sinusoidal(throw), math.asin(1.0 / throw))


# ------------------------------------------------------------------------------- flights from rest


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
