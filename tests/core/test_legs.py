"""Slides of one harmonic and of waves beside meshes and 40 digits."""

from __future__ import annotations

import math
import random
from typing import Any

import mpmath
import numpy as np
import pytest
from helpers.waves import (
    coefficients_of,
    drawn_harmonics,
    drawn_pieces,
    harmonic_value,
    harmonic_waves,
    piecewise_value,
    piecewise_waves,
)

from vibro.core.cells import forget_nodes, largest
from vibro.core.codes import Mode
from vibro.core.drive import Loads, wave_loads
from vibro.core.legs import (
    Forcing,
    WaveSlide,
    forcing,
    mode_of,
    slide_from_speed,
    slide_over_waves,
    track_of,
)
from vibro.core.waves import KINETIC_BACK, KINETIC_FORWARD, Mix

TURN = 2.0 * math.pi
EPS = 2.0**-52


# ---------------------------------------------------------------------------------- slides from any speed


def _slides(count: int, seed: int) -> list[tuple[Forcing, float, float]]:
    """Draw slides either way, with drags from negative to beyond the amplitude, and their starts."""
    draw = random.Random(seed)
    slides = []
    for _ in range(count):
        alpha, weight = draw.uniform(0.0, 1.4), draw.uniform(0.02, 3.0)
        kinetic, weight_down = draw.uniform(0.0, 1.5), draw.uniform(-0.6, 0.6)
        loads = Loads(
            math.cos(alpha), math.sin(alpha), weight, weight_down, weight, 2.0, kinetic, 0.0, 1.0, True
        )
        speed = math.exp(draw.uniform(math.log(1e-4), math.log(20.0)))
        slides.append((forcing(loads, draw.choice([1.0, -1.0])), draw.uniform(0.0, TURN), speed))
    return slides


def _speed(at: Forcing, phase: float, speed: float, s: np.ndarray) -> np.ndarray:
    p0 = phase + at.shift
    now: np.ndarray = speed + at.amplitude * (math.cos(p0) - np.cos(p0 + s)) - at.drag * s
    return now


def test_a_slide_ends_at_the_first_zero_of_its_speed_or_gains_speed_every_turn() -> None:
    endless = 0
    for at, phase, speed in _slides(400, 1):
        end = slide_from_speed(at, phase, speed, math.inf)
        assert end.settled
        if math.isinf(end.length):
            endless += 1
            assert not end.stopped
            assert math.isnan(end.speed)
            assert math.isnan(end.top)
            assert at.drag <= 0.0
            assert (_speed(at, phase, speed, np.linspace(0.0, 3.0 * TURN, 2001)) > 0.0).all()
            continue
        assert end.stopped
        assert end.speed == 0.0
        mesh = np.linspace(0.0, end.length, 1000)[:-1]
        assert (_speed(at, phase, speed, mesh) > -1e-12 * (1.0 + mesh)).all()
        left = _speed(at, phase, speed, np.array([end.length]))[0]
        assert abs(left) < 1e-13 * (1.0 + speed + abs(at.drag) * end.length)
    assert 5 < endless < 100


def test_the_top_speed_is_the_largest_on_the_way() -> None:
    draw = random.Random(6)
    for at, phase, speed in _slides(200, 5):
        end = slide_from_speed(at, phase, speed, draw.uniform(0.1, 15.0))
        seen = _speed(at, phase, speed, np.linspace(0.0, end.length, 10_001)).max()
        assert seen <= end.top + 1e-12
        assert end.top == pytest.approx(seen, abs=4e-6)


def test_the_end_has_all_digits_unless_the_speed_only_grazes_zero() -> None:
    with mpmath.workdps(40):
        for at, phase, speed in _slides(40, 7):
            length = slide_from_speed(at, phase, speed, math.inf).length
            if math.isinf(length):
                continue
            p0, v0 = mpmath.mpf(phase) + mpmath.mpf(at.shift), mpmath.mpf(speed)
            amplitude, drag = mpmath.mpf(at.amplitude), mpmath.mpf(at.drag)

            def left(
                s: mpmath.mpf,
                p0: mpmath.mpf = p0,
                v0: mpmath.mpf = v0,
                amplitude: mpmath.mpf = amplitude,
                drag: mpmath.mpf = drag,
            ) -> mpmath.mpf:
                return v0 + amplitude * (mpmath.cos(p0) - mpmath.cos(p0 + s)) - drag * s

            exact = mpmath.findroot(left, mpmath.mpf(length))
            slope = abs(amplitude * mpmath.sin(p0 + exact) - drag)
            scale = (v0 + amplitude + abs(drag) * exact) / slope + exact + TURN
            assert abs(length - exact) < 8 * EPS * scale


def test_slides_that_just_reach_zero_speed_at_a_minimum_stop_there_or_go_on() -> None:
    # start speeds within rounding of those at which a later minimum of the speed is zero
    draw, count, at_once = random.Random(9), 3000, 0
    for i in range(count):
        amplitude, phase = 10.0 ** draw.uniform(-1.0, 0.5), draw.uniform(0.0, TURN)
        ratio = 10.0 ** draw.uniform(-8.0, 0.0) if i % 2 else 1.0 - 10.0 ** draw.uniform(-9.0, 0.0)
        bend = amplitude * math.sqrt((1.0 - ratio) * (1.0 + ratio))
        at = Forcing(0.0, amplitude, amplitude * ratio, math.asin(ratio), bend, 0.0)
        minimum = at.kappa + TURN * draw.randint(1, 3)
        start = (phase - at.kappa) % TURN + at.kappa
        speed = amplitude * (math.cos(minimum) - math.cos(start)) + at.drag * (minimum - start)
        speed *= 1.0 + draw.randint(-3, 3) * EPS
        end = slide_from_speed(at, phase, speed, math.inf)
        assert end.settled
        left = speed + amplitude * (math.cos(start) - math.cos(start + end.length)) - at.drag * end.length
        assert abs(left) < 1e-14 * (speed + amplitude + at.drag * end.length)
        at_once += abs(start + end.length - minimum) < 1e-5
        if i % 40 == 0:
            mesh = np.linspace(0.0, end.length, 1000)[:-1]
            assert (_speed(at, phase, speed, mesh) > -1e-12 * (1.0 + speed)).all()
    assert 0.2 < at_once / count < 0.9


def test_a_contact_that_ends_within_rounding_of_the_stop_leaves_no_negative_speed() -> None:
    for at, phase, speed in _slides(300, 10):
        whole = slide_from_speed(at, phase, speed, math.inf)
        for ulps in range(-2, 6) if whole.stopped else ():
            limit = whole.length * (1.0 - ulps * 2.0**-53)
            cut = slide_from_speed(at, phase, speed, limit)
            assert 0.0 <= cut.speed < 1e-13 * (1.0 + speed + abs(at.drag) * limit)
            assert cut.length <= limit


# ---------------------------------------------------------------------------------------------- legs


def test_at_zero_velocity_the_loads_decide_and_equality_is_rest() -> None:
    # alpha = 0, level trough: load sin p, friction holds mu_s n = 1/2
    loads = Loads(1.0, 0.0, 1.0, 0.0, 1.0, 0.5, 0.4, 0.0, 1.0, True)
    half = math.asin(0.5)
    assert mode_of(loads, 1.0, 0.0, math.sin(1.0)) == Mode.REST
    for phase, mode in ((half - 1e-12, Mode.REST), (half + 1e-12, Mode.FORWARD)):
        assert mode_of(loads, phase, 0.0, loads.static_friction) == mode
        opposite = Mode.BACK if mode == Mode.FORWARD else Mode.REST
        assert mode_of(loads, -phase, 0.0, loads.static_friction) == opposite
    # after bounces kinetic friction alone holds
    assert [track_of(loads, e).landed_friction for e in (0.0, 1e-300, 0.5)] == [0.5, 0.4, 0.4]
    assert mode_of(loads, half - 1e-12, 0.0, 0.4) == Mode.FORWARD
    assert mode_of(loads, 0.5 * math.pi, -1e-300, loads.static_friction) == Mode.BACK
    assert mode_of(loads, -0.5 * math.pi, 1e-300, loads.static_friction) == Mode.FORWARD


# ------------------------------------------------------------------------------
# Slides under any periodic load: stops beside a dense mesh, limits, endless ones.


INF = math.inf
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(8)


class Body:
    """A scene, and the load beyond kinetic friction one way, by NumPy alone."""

    def __init__(self, seed: int, *, pieces: bool = False) -> None:
        rng = self.rng = np.random.default_rng(seed)
        self.way = float(rng.choice([-1.0, 1.0]))
        count = 1 + seed % 16
        if pieces:
            self.breaks, table = drawn_pieces(rng, 1 + seed % 12)
            waves = piecewise_waves(self.breaks, table)
            self.parts: Any = -table
        else:
            self.breaks = np.zeros(0)
            waves = harmonic_waves(drawn_harmonics(rng, count), drawn_harmonics(rng, count))
            self.parts = np.array([coefficients_of(waves, normal=x) for x in (False, True)])
        self.mu_s, ratio = float(rng.uniform(0.1, 1.0)), float(rng.uniform(0.3, 1.0))
        self.mu_d = self.mu_s * ratio
        most = largest(waves, Mix(0.0, 0.0, 1.0))
        self.normal = float(rng.uniform(0.3, 3.0)) * (most if most > 0.0 else 1.0)
        self.lean = self.mu_d * self.normal * float(rng.uniform(-0.9, 0.9))
        self.loads = wave_loads(waves, most, self.normal, self.lean, self.mu_s, self.mu_d)
        self._forget()

    def _forget(self) -> None:
        for row in (KINETIC_FORWARD, KINETIC_BACK):
            forget_nodes(self.loads.waves, row)

    def leaning(self, lean: float) -> Body:
        """Turn the trough: gravity along it."""
        self.lean, loads = lean, self.loads
        self.loads = wave_loads(loads.waves, loads.drive_normal, self.normal, lean, self.mu_s, self.mu_d)
        self._forget()
        return self

    def pull(self, p: Any) -> Any:
        """Load along the way beyond kinetic friction."""
        along, normal = (
            harmonic_value(x, p) if not self.breaks.size else piecewise_value(self.breaks, x, p)
            for x in self.parts
        )
        return self.way * (along - self.lean) - self.mu_d * (self.normal - normal)

    def speeds(self, phase: float, speed: float, length: float) -> tuple[Any, Any, Any]:
        """Speeds on a mesh up to a phase, and the path there, by quadrature."""
        ends = np.linspace(0.0, length, 2 + min(int(12 * self.loads.waves.size * max(length, 0.5)), 20_000))
        if self.breaks.size:
            turns = np.arange(math.floor((phase + length) / TURN) + 1)
            jumps = (TURN * (self.breaks[None, :-1] + turns[:, None])).ravel() - phase
            ends = np.sort(np.concatenate((ends, jumps[(jumps > 0.0) & (jumps < length)])))
        half = 0.5 * np.diff(ends)
        p = phase + ends[:-1, None] + half[:, None] * (1.0 + _NODES)
        pull = self.pull(p)
        gains = (pull @ _WEIGHTS) * half
        speeds = speed + np.concatenate(([0.0], np.cumsum(gains)))
        inner = ((1.0 - _NODES) * _WEIGHTS * pull).sum(axis=1) * half * half
        path = float((speeds[:-1] * 2.0 * half + inner).sum())
        return ends, speeds, path

    def slide(self, phase: float, speed: float, limit: float = INF) -> WaveSlide:
        return slide_over_waves(self.loads, self.way, phase, speed, limit)


@pytest.mark.parametrize("pieces", [False, True])
def test_a_body_stops_where_its_speed_is_first_lost(pieces: bool) -> None:
    several = 0
    for seed in range(130):
        body = Body(seed, pieces=pieces)
        phase, speed = body.rng.uniform(0.0, TURN), 10.0 ** body.rng.uniform(-3.0, 1.0)
        found = body.slide(phase, speed)
        assert found.stopped
        assert found.speed == 0.0
        several += found.length > TURN
        _, speeds, path = body.speeds(phase, speed, found.length)
        size = float(np.abs(body.parts).sum()) + body.normal
        rounding = 1e-13 * size * (1.0 + found.length)
        assert speeds[1:-1].min(initial=INF) >= -rounding
        assert abs(speeds[-1]) <= rounding
        assert found.path == pytest.approx(path, rel=0.0, abs=rounding * (1.0 + found.length))
        assert found.top == pytest.approx(speeds.max(), rel=3e-3)
        assert found.top >= speeds.max() - rounding
        if not pieces:
            assert body.pull(phase + found.length) <= rounding  # it slows down where it stops
    assert several > 13


@pytest.mark.parametrize("pieces", [False, True])
def test_slides_end_if_friction_holds_more_than_gravity_pulls(pieces: bool) -> None:
    for seed in range(20):
        body = Body(seed, pieces=pieces)
        held = body.mu_d * body.normal
        for share, ends in ((1.0 - 1e-3, True), (1.0, False), (1.0 + 1e-3, False)):
            body.leaning(-body.way * held * share)
            speed = 0.5 + float(np.abs(body.parts).sum()) * TURN  # never lost within the first turn
            found = body.slide(1.0, speed)
            assert found.stopped is ends
            assert math.isinf(found.length) is not ends
            if ends:
                assert found.length > 100.0
                _, speeds, _ = body.speeds(1.0, speed, min(found.length, 20.0))
                assert speeds.min() > 0.0
                # each turn takes as much
                turns = math.floor((found.length - TURN) / TURN)
                left = speed - turns * TURN * held * 1e-3
                then = body.slide(1.0, left)
                assert then.stopped
                assert then.length + TURN * turns == pytest.approx(found.length, rel=1e-9)
            else:
                limited = body.slide(1.0, speed, 50.0)
                assert (limited.length, limited.stopped) == (50.0, False)
