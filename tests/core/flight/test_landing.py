"""How errors grow from take-off to take-off: first order beside differences, variances beside many bodies."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import mpmath
import numpy as np
import pytest

from vibro.core.flight.landing import LOST, SHARP, Blur, after_landing, carried, spread
from vibro.core.flight.trajectory import flight

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

TURN = 2.0 * math.pi
STATES = 100
BODIES = 400


def _take_offs() -> tuple[Floats, Floats, Floats, Floats]:
    """Draw throw numbers, restitutions, phases and speeds."""
    random = np.random.default_rng(7)
    throw, restitution = random.uniform(1.2, 6.0, STATES), random.uniform(0.2, 0.9, STATES)
    return throw, restitution, random.uniform(0.0, TURN, STATES), random.uniform(1.0, 8.0, STATES)


def _onward(throw: Floats, restitution: Floats, phase: Floats, speed: Floats) -> tuple[Floats, Floats]:
    step = flight(throw, phase, speed)
    return phase + step.length, restitution * step.impact


def test_changes_of_a_take_off_are_carried_to_the_next() -> None:
    throw, restitution, phase, speed = _take_offs()
    step = flight(throw, phase, speed)
    smooth = step.impact > 0.5  # grazing landings bend within the difference
    assert smooth.mean() > 0.9
    h = 1e-6
    for d_phase, d_speed in ((1.0, 0.0), (0.0, 1.0), (0.6, -0.8)):
        change = np.full(STATES, d_phase), np.full(STATES, d_speed)
        got = carried(throw, restitution, phase, step, change)
        after, before = (
            _onward(throw, restitution, phase + way * h * d_phase, speed + way * h * d_speed)
            for way in (1.0, -1.0)
        )
        for value, high, low in zip(got, after, before, strict=True):
            difference = (high - low) / (2.0 * h)
            assert value[smooth] == pytest.approx(difference[smooth], rel=1e-5, abs=1e-5)


def test_the_spread_of_many_bodies_is_what_the_variances_say() -> None:
    throw, restitution, phase, speed = _take_offs()
    random = np.random.default_rng(8)
    error = 1e-8
    throws, restitutions = np.repeat(throw, BODIES), np.repeat(restitution, BODIES)
    phases = np.repeat(phase, BODIES) + error * random.standard_normal(STATES * BODIES)
    speeds = np.repeat(speed, BODIES) + error * random.standard_normal(STATES * BODIES)
    none = np.zeros(STATES)
    blur = Blur(none + error**2, none, none + error**2)
    left = np.ones(STATES, np.bool_)
    for _ in range(4):
        step = flight(throw, phase, speed)
        blur = spread(throw, restitution, (phase, speed), step, none, blur)
        left &= (step.impact > 0.3) & (blur.phase < 1e-8)
        phase, speed = _onward(throw, restitution, phase, speed)
        phases, speeds = _onward(throws, restitutions, phases, speeds)
        off = (phases.reshape(STATES, BODIES) - phase[:, None])[left]
        fast = (speeds.reshape(STATES, BODIES) - speed[:, None])[left]
        assert left.sum() > 60
        for got, drawn in ((blur.phase[left], off), (blur.speed[left], fast)):
            ratio = got / (drawn * drawn).mean(axis=1)
            assert ratio.min() > 0.5
            assert ratio.max() < 2.0


def test_variances_grow_with_the_motion_and_not_with_the_number_of_bounces() -> None:
    # a chain of bounces that accumulates under the load 1.9: 600 of them, each rounded
    throw, restitution = np.array([1.5]), np.array([0.95])
    phase, speed, none = np.array([4.0]), np.array([0.02]), np.zeros(1)
    blur = Blur(none, none, none)
    for _ in range(600):
        step = flight(throw, phase, speed)
        blur = spread(throw, restitution, (phase, speed), step, none, blur)
        phase, speed = _onward(throw, restitution, phase, speed)
    assert blur.within(1e-11).all()
    assert not blur.within(1e-16).any()


def test_the_rounding_of_a_flight_is_covered() -> None:
    throw, restitution, phase, speed = (x[:50] for x in _take_offs())
    step = flight(throw, phase, speed)
    none = np.zeros(50)
    blur = spread(throw, restitution, (phase, speed), step, none, Blur(none, none, none))
    rows = zip(*(x.tolist() for x in (throw, phase, speed, step.length, blur.phase)), strict=True)
    with mpmath.workdps(40):
        for k, p, v, length, variance in rows:

            def height(s: mpmath.mpf, k: float = k, p: float = p, v: float = v) -> mpmath.mpf:
                end = mpmath.mpf(p) + s
                return v * s + k * (s * mpmath.cos(p) + mpmath.sin(p) - mpmath.sin(end)) - s * s / 2

            error = abs(float(mpmath.findroot(height, length) - length))
            assert error <= 4.0 * math.sqrt(variance)


def test_a_grazing_landing_loses_digits() -> None:
    throw, phase, speed, none = np.full(3, 2.0), np.full(3, 2.0), np.full(3, 1.0), np.zeros(3)
    grazing = flight(throw, phase, speed)._replace(impact=np.array([1.0, 1e-4, 1e-12]))
    blur = spread(throw, np.full(3, 0.5), (phase, speed), grazing, none, Blur(none, none, none))
    assert blur.within(SHARP).tolist() == [True, True, False]
    assert blur.within(LOST).tolist() == [True, True, False]


def test_bounces_are_not_summed_where_the_trough_falls_away_before_they_end() -> None:
    # ahead of the lift-off the load is positive, but vanishes there
    throw, restitution = 1.5, 0.5
    before = np.geomspace(1e-12, 1e-2, 41)
    phase = math.asin(1.0 / throw) - before
    load = 1.0 - throw * np.sin(phase)
    length = np.full(41, 1e-9)
    impact = 0.5 * length * load * (1.0 - restitution) / restitution
    after = after_landing(np.full(41, throw), phase, impact, np.full(41, restitution))
    fall = throw * np.cos(phase) * length  # of the load, until the bounces end
    assert after.contact[load >= 1.001 * fall].all()
    assert not after.contact[load <= 0.999 * fall].any()
    assert (before[after.contact] >= 0.999 * length[after.contact]).all()
    bounced = ~after.contact
    assert after.take_off[bounced] == pytest.approx(restitution * impact[bounced])
    assert (after.length[bounced] == 0.0).all()
