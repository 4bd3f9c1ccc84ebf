"""Slides from any speed: the first zero of the speed, beside a fine mesh and high precision."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import mpmath
import numpy as np
import pytest
from vibro.core.contact.coast import Pull, coast, pull_of
from vibro.core.groups import Loads, take

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

TURN = 2.0 * math.pi


def _pulls(count: int, seed: int) -> tuple[Pull, Floats, Floats]:
    """Draw slides either way, with drags from negative to beyond the pull, and their starts."""
    random = np.random.default_rng(seed)
    alpha = random.uniform(0.0, 1.4, count)
    normal, tangential = random.uniform(0.02, 3.0, count), random.uniform(-0.6, 0.6, count)
    scene = Loads(
        np.cos(alpha),
        np.sin(alpha),
        normal,
        tangential,
        normal,
        np.ones(count),
        random.uniform(0.0, 1.5, count),
    )
    at = pull_of(scene, 1)
    back = pull_of(scene, -1)
    backward = random.random(count) < 0.5
    pull = Pull(*(np.where(backward, b, f) for f, b in zip(at, back, strict=True)))
    speed = np.exp(random.uniform(math.log(1e-4), math.log(20.0), count))
    return pull, random.uniform(0.0, TURN, count), speed


def _speed(at: Pull, phase: Floats, speed: Floats, s: Floats) -> Floats:
    p0 = phase + at.shift
    now: Floats = speed + at.pull * (np.cos(p0) - np.cos(p0 + s)) - at.drag * s
    return now


def test_the_end_is_the_first_zero_of_the_speed() -> None:
    at, phase, speed = _pulls(400, 1)
    end = coast(at, phase, speed, np.full(400, np.inf))
    assert end.settled.all()
    ends = np.isfinite(end.length)
    assert 300 < ends.sum() < 400
    for i in np.flatnonzero(ends):
        one = take(at, np.array([i]))
        mesh = np.linspace(0.0, end.length[i], 2000)[:-1]
        assert (_speed(one, phase[i], speed[i], mesh) > -1e-12 * (1.0 + mesh)).all()
    left = _speed(take(at, np.flatnonzero(ends)), phase[ends], speed[ends], end.length[ends])
    assert np.abs(left / (1.0 + speed[ends] + at.drag[ends] * end.length[ends])).max() < 1e-13


def test_a_slide_that_never_ends_gains_speed_every_turn() -> None:
    at, phase, speed = _pulls(400, 2)
    end = coast(at, phase, speed, np.full(400, np.inf))
    endless = np.flatnonzero(np.isinf(end.length))
    assert endless.size > 5
    assert not end.stopped[endless].any()
    for i in endless:
        one = take(at, np.array([i]))
        assert one.drag <= 0.0
        assert (_speed(one, phase[i], speed[i], np.linspace(0.0, 3.0 * TURN, 3001)) > 0.0).all()


def test_a_contact_that_ends_first_cuts_the_slide() -> None:
    at, phase, speed = _pulls(400, 3)
    whole = coast(at, phase, speed, np.full(400, np.inf))
    limit = np.random.default_rng(4).uniform(0.0, 8.0, 400)
    cut = coast(at, phase, speed, limit)
    stops = whole.length < limit
    assert np.array_equal(cut.stopped, stops)
    assert 50 < stops.sum() < 350
    assert cut.length == pytest.approx(np.minimum(whole.length, limit), rel=1e-13)
    left = np.flatnonzero(~stops)
    expected = _speed(take(at, left), phase[left], speed[left], limit[left])
    assert cut.speed[left] == pytest.approx(expected, abs=1e-12)
    assert (cut.speed[stops] == 0.0).all()


def test_the_top_speed_is_the_largest_on_the_way() -> None:
    at, phase, speed = _pulls(300, 5)
    limit = np.random.default_rng(6).uniform(0.1, 15.0, 300)
    end = coast(at, phase, speed, limit)
    for i in range(300):
        s = np.linspace(0.0, end.length[i], 20_001)
        seen = _speed(take(at, np.array([i])), phase[i], speed[i], s).max()
        assert seen <= end.top[i] + 1e-12
        assert end.top[i] == pytest.approx(seen, abs=1e-6)


def test_the_end_has_all_digits_unless_the_speed_only_grazes_zero() -> None:
    at, phase, speed = _pulls(40, 7)
    end = coast(at, phase, speed, np.full(40, np.inf))
    with mpmath.workdps(40):
        for i in np.flatnonzero(np.isfinite(end.length)):
            p0, v0 = mpmath.mpf(phase[i]) + mpmath.mpf(at.shift[i]), mpmath.mpf(speed[i])
            pull, drag = mpmath.mpf(at.pull[i]), mpmath.mpf(at.drag[i])

            def left(s: mpmath.mpf, p0: mpmath.mpf = p0, v0: mpmath.mpf = v0) -> mpmath.mpf:
                return v0 + pull * (mpmath.cos(p0) - mpmath.cos(p0 + s)) - drag * s  # noqa: B023

            exact = mpmath.findroot(left, mpmath.mpf(end.length[i]))
            slope = abs(pull * mpmath.sin(p0 + exact) - drag)
            scale = (v0 + pull + abs(drag) * exact) / slope + exact + TURN
            assert abs(end.length[i] - exact) < 8 * 2.0**-52 * scale


def test_an_onset_a_rounding_before_the_minimum_starts_a_slide() -> None:
    # mu_s = mu_d: the slide starts just where its speed has its minimum
    at = Pull(*(np.array([x]) for x in (0.0, 1.0, 0.5, math.asin(0.5), math.sqrt(0.75), 0.0)))
    for rounding in (-1e-15, 0.0, 1e-15):
        end = coast(at, at.kappa + rounding, np.zeros(1), np.full(1, np.inf))
        assert 3.0 < end.length[0] < 4.0


def test_slides_that_just_reach_zero_speed_at_a_minimum_stop_there_or_go_on() -> None:
    # start speeds within rounding of those at which a later minimum of the speed is zero
    count = 20_000
    random = np.random.default_rng(9)
    pull, phase = 10.0 ** random.uniform(-1.0, 0.5, count), random.uniform(0.0, TURN, count)
    ratio = np.where(
        np.arange(count) % 2,
        10.0 ** random.uniform(-8.0, 0.0, count),
        1.0 - 10.0 ** random.uniform(-9.0, 0.0, count),
    )
    bend, zero = pull * np.sqrt((1.0 - ratio) * (1.0 + ratio)), np.zeros(count)
    at = Pull(zero, pull, pull * ratio, np.arcsin(ratio), bend, zero)
    minimum = at.kappa + TURN * random.integers(1, 4, count)
    start = np.mod(phase + at.shift - at.kappa, TURN) + at.kappa
    speed = at.pull * (np.cos(minimum) - np.cos(start)) + at.drag * (minimum - start)
    speed *= 1.0 + random.integers(-3, 4, count) * 2.0**-52
    end = coast(at, phase, speed, np.full(count, np.inf))
    assert end.settled.all()
    left = at.pull * (np.cos(start) - np.cos(start + end.length)) + speed - at.drag * end.length
    assert np.abs(left / (speed + at.pull + at.drag * end.length)).max() < 1e-14
    at_once = np.abs(start + end.length - minimum) < 1e-5
    assert 0.2 < at_once.mean() < 0.9
    # ... and the mesh before it has no earlier zero
    for i in range(0, count, 40):
        mesh = np.linspace(0.0, end.length[i], 2000)[:-1]
        assert (_speed(take(at, np.array([i])), phase[i], speed[i], mesh) > -1e-12 * (1.0 + speed[i])).all()


def test_a_contact_that_ends_within_rounding_of_the_stop_leaves_no_negative_speed() -> None:
    at, phase, speed = _pulls(2000, 10)
    whole = coast(at, phase, speed, np.full(2000, np.inf))
    ends = np.flatnonzero(whole.stopped)
    for ulps in range(-2, 6):
        limit = whole.length[ends] * (1.0 - ulps * 2.0**-53)
        cut = coast(take(at, ends), phase[ends], speed[ends], limit)
        assert (cut.speed >= 0.0).all()
        assert (cut.speed < 1e-13 * (1.0 + speed[ends] + np.abs(at.drag[ends]) * limit)).all()
