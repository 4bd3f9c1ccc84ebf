"""One flight: the first return to the trough, beside a fine mesh, closed forms and high precision."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import mpmath
import numpy as np
import pytest

from vibro.core.flight.trajectory import ONE_CYCLE, flight, lift_off_flight

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

TURN = 2.0 * math.pi


def _throw_number(cycles: Floats) -> Floats:
    """Throw number at which a resting body's flight lasts that many cycles, a published relation."""
    x = TURN * cycles
    throw: Floats = np.sqrt(((np.cos(x) + 0.5 * x * x - 1.0) / (x - np.sin(x))) ** 2 + 1.0)
    return throw


def test_flight_time_and_throw_number_are_related_as_published() -> None:
    cycles = np.linspace(0.05, 1.0, 20)
    throw = _throw_number(cycles)
    length = lift_off_flight(np.sqrt((throw - 1.0) * (throw + 1.0))).length
    assert length / TURN == pytest.approx(cycles, rel=1e-11)


@pytest.mark.parametrize(
    ("throw", "cycles"),
    [
        (1.1, "0.27711"),
        (1.5, "0.56758"),
        (2.0, "0.74148"),
        (2.5, "0.85731"),
        (3.0, "0.94977"),
        (math.sqrt(1.0 + math.pi**2), "1.00000"),
    ],
)
def test_flight_times_to_all_printed_digits(throw: float, cycles: str) -> None:
    length = lift_off_flight(np.sqrt(np.array([throw * throw - 1.0]))).length
    assert f"{length[0] / TURN:.5f}" == cycles


def test_a_lift_off_flight_has_all_digits_however_short() -> None:
    c = np.concatenate((np.logspace(-9, 0, 25), np.linspace(1.0, ONE_CYCLE, 25)))
    got = lift_off_flight(c)
    with mpmath.workdps(60):
        for ci, length, impact in zip(c.tolist(), got.length.tolist(), got.impact.tolist(), strict=True):
            k = mpmath.mpf(ci)

            def height(s: mpmath.mpf, k: mpmath.mpf = k) -> mpmath.mpf:
                return (k * (s - mpmath.sin(s)) + 1 - mpmath.cos(s) - s * s / 2) / s**3

            exact = mpmath.findroot(height, mpmath.mpf(length))
            landing = exact - mpmath.sin(exact) - k * (1 - mpmath.cos(exact))
            assert abs(length / exact - 1) < 1e-15
            assert abs(impact / landing - 1) < 4e-15


def _take_offs(count: int, seed: int, most_throw: float) -> tuple[Floats, Floats, Floats]:
    """Draw take-offs: from rest where the trough falls away, and with a speed anywhere."""
    random = np.random.default_rng(seed)
    throw = np.exp(random.uniform(math.log(1.001), math.log(most_throw), count))
    lift_off = np.arcsin(1.0 / throw)
    released = random.random(count) < 0.5
    phase = np.where(
        released,
        lift_off + (math.pi - 2.0 * lift_off) * random.random(count),
        random.uniform(0.0, TURN, count),
    )
    return throw, phase, np.where(released, 0.0, throw * np.exp(random.uniform(-12.0, 1.0, count)))


def _height(throw: float, phase: float, speed: float, s: Floats) -> Floats:
    lever = s * math.cos(phase) + math.sin(phase) - np.sin(phase + s)
    height: Floats = speed * s + throw * lever - 0.5 * s * s
    return height


@pytest.mark.parametrize("most_throw", [4.0, 1000.0])
def test_the_landing_is_the_first_return_to_the_trough(most_throw: float) -> None:
    throw, phase, speed = _take_offs(400, 1, most_throw)
    got = flight(throw, phase, speed)
    assert (got.length > 0.0).all()
    for k, p, v, length in zip(*(x.tolist() for x in (throw, phase, speed, got.length)), strict=True):
        s = np.linspace(0.0, length, 20_001)[1:]
        height = _height(k, p, v, s)
        rounding = 1e-14 * (k * s + s * s) + 1e-15 * k
        assert (height > -rounding)[:-1].all()
        assert abs(height[-1]) <= 4.0 * rounding[-1]


def test_the_impact_speed_is_the_rate_of_the_height() -> None:
    throw, phase, speed = _take_offs(300, 2, 50.0)
    got = flight(throw, phase, speed)
    rate = speed + throw * (np.cos(phase) - np.cos(phase + got.length)) - got.length
    assert got.impact == pytest.approx(-rate, abs=1e-10)
    assert (got.impact >= 0.0).all()


def test_a_flight_from_the_lift_off_agrees_with_the_general_one() -> None:
    throw = np.linspace(1.01, 3.29, 50)
    short = lift_off_flight(np.sqrt((throw - 1.0) * (throw + 1.0)))
    general = flight(throw, np.arcsin(1.0 / throw), np.zeros(50))
    # near the lift-off the height grows with the cube of time only, so the general one has fewer digits
    assert general.length == pytest.approx(short.length, rel=1e-10)


def test_a_short_bounce_lasts_twice_its_speed_over_the_load() -> None:
    throw, phase = np.full(4, 2.0), np.array([-1.0, 0.0, 2.9, 4.0])
    load = 1.0 - throw * np.sin(phase)
    for speed in (1e-3, 1e-6, 1e-9, 1e-12):
        got = flight(throw, phase, np.full(4, speed))
        assert got.length == pytest.approx(2.0 * speed / load, rel=10.0 * speed + 1e-4)
        assert got.impact == pytest.approx(speed, rel=10.0 * speed + 1e-3)


def test_short_bounces_keep_their_digits() -> None:
    # of 1e-2 down to 1e-11 of the trough's speed
    speed = np.geomspace(1e-2, 1e-11, 40)
    throw, phase = 1.5, 2.9
    found = flight(np.full(40, throw), np.full(40, phase), speed)
    with mpmath.workdps(50):
        for v, length, impact in zip(speed, found.length, found.impact, strict=True):

            def height(s: mpmath.mpf, v: float = v) -> mpmath.mpf:
                p = mpmath.mpf(phase)
                turned = mpmath.cos(p) * (s - mpmath.sin(s)) + mpmath.sin(p) * (1 - mpmath.cos(s))
                return (v * s + throw * turned - s * s / 2) / s

            load = 1.0 - throw * math.sin(phase)
            exact = mpmath.findroot(height, 2.0 * v / load)
            assert abs(length - exact) < 16 * 2.0**-52 * exact
            p = mpmath.mpf(phase)
            rate = v + throw * (mpmath.cos(p) - mpmath.cos(p + exact)) - exact
            assert abs(impact + rate) < 64 * 2.0**-52 * v
