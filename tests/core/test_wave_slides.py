"""Slides under any periodic load: stops beside a dense mesh, limits, endless ones; one harmonic as waves."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from helpers.periodic_tables import least_rotation
from helpers.waves import (
    coefficients_of,
    drawn_harmonics,
    drawn_pieces,
    harmonic_value,
    harmonic_waves,
    piecewise_value,
    piecewise_waves,
)

import vibro
from vibro.core.cells import forget_nodes, largest
from vibro.core.drive import wave_loads
from vibro.core.legs import WaveSlide, slide_over_waves
from vibro.core.numbers import TURN
from vibro.core.waves import KINETIC_BACK, KINETIC_FORWARD, Mix

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


def test_slides_from_rest_begin_where_the_load_exceeds_friction() -> None:
    checked = 0
    for seed in range(64):
        body = Body(seed)
        starts = [p for p in body.rng.uniform(0.0, TURN, 200).tolist() if float(body.pull(p)) > 1e-3]
        if not starts:
            continue
        found = body.slide(starts[0], 0.0)
        _, speeds, path = body.speeds(starts[0], 0.0, found.length)
        assert found.stopped
        assert speeds[1:-1].min() > 0.0
        assert abs(speeds[-1]) <= 1e-12 * (1.0 + speeds.max())
        assert found.path == pytest.approx(path, rel=1e-11)
        checked += 1
    assert checked > 32


@pytest.mark.parametrize("pieces", [False, True])
def test_a_contact_ends_a_slide_just_before_but_not_just_behind_its_stop(pieces: bool) -> None:
    for seed in range(40):
        body = Body(seed, pieces=pieces)
        phase, speed = body.rng.uniform(0.0, TURN), 0.7
        free = body.slide(phase, speed)
        for share, stopped in ((0.3, False), (1.0 - 1e-6, False), (1.0 + 1e-6, True), (9.0, True)):
            limit = share * free.length
            found = body.slide(phase, speed, limit)
            assert found.stopped is stopped
            assert found.length == (pytest.approx(free.length, rel=1e-12) if stopped else limit)
            if not stopped:
                _, speeds, path = body.speeds(phase, speed, limit)
                assert found.speed == pytest.approx(speeds[-1], rel=0.0, abs=1e-12 * (1.0 + limit))
                assert found.path == pytest.approx(path, rel=0.0, abs=1e-12 * (1.0 + limit) ** 2)


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


# ------------------------------------------------------------------------------- one harmonic


def _both(
    seed: int, throw: tuple[float, float], restitution: float = 0.0, shape: tuple[int, ...] = (200,)
) -> Any:
    """Draw ellipses, and the same drives as one harmonic; with half of them a second of amplitude 0."""
    rng = np.random.default_rng(seed)
    f = rng.uniform(10.0, 50.0, shape)
    unit = 9.81 / (TURN * f) ** 2
    y: Any = unit * rng.uniform(*throw, shape)
    x: Any = unit * np.exp(rng.uniform(-1.0, 1.5, shape))
    phase: Any = rng.uniform(-np.pi, np.pi, shape)
    mu_s = rng.uniform(0.1, 0.9, shape)
    rest: Any = {
        "frequency": f, "static_friction": mu_s, "kinetic_friction": mu_s * rng.uniform(0.3, 1.0, shape),
        "trough_angle": np.arctan(mu_s * 0.3) * rng.uniform(-0.7, 0.7, shape), "restitution": restitution,
    }  # fmt: skip
    ellipse = vibro.Scene(along_amplitude=x, normal_amplitude=y, normal_phase=phase, **rest)
    more: Any = [(0.0, 0.3)] * (seed % 2)
    waves = vibro.Scene(along_harmonics=[(x, 0.0), *more], normal_harmonics=[(y, phase), *more], **rest)
    return ellipse, waves, np.maximum(x, y), f


@pytest.mark.parametrize(
    ("seed", "throw", "restitution"),
    [(1, (0.1, 0.95), 0.0), (2, (1.05, 3.2), 0.0), (3, (1.05, 1.6), 0.3)],
    ids=["contact", "hopping", "bouncing"],
)
def test_one_harmonic_as_waves_is_an_ellipse(
    seed: int, throw: tuple[float, float], restitution: float
) -> None:
    ellipse, waves, size, f = _both(seed, throw, restitution)
    one, other = vibro.solve(ellipse), vibro.solve(waves)
    assert one.status.tolist() == other.status.tolist()
    assert one.regime.tolist() == other.regime.tolist()
    assert one.coexists.tolist() == other.coexists.tolist()
    known = one.status == vibro.Status.OK
    assert known.sum() > 150
    # of waves a chain of bounces is spelt shorter
    spelt = [[least_rotation(str(x)) for x in cycle.pattern[known]] for cycle in (one, other)]
    assert [x for x in spelt[0] if "." not in x] == [y for x, y in zip(*spelt, strict=True) if "." not in x]
    for name, unit in (
        ("displacement_per_cycle", size + np.abs(one.displacement_per_cycle)),
        ("mean_velocity", size * f),
        ("peak_velocity", size * f * TURN),
        ("impact_velocity", size * f * TURN),
        ("flight_fraction", 1.0 + 0.0 * f),
        ("throw_number", 1.0 + 0.0 * f),
        ("period_cycles", 1.0 + 0.0 * f),
    ):
        off = np.abs(getattr(one, name) - getattr(other, name))[known] / unit[known]
        assert np.nanmax(off) <= 1e-12, name
    for name in ("forward_ratio", "back_ratio"):
        off = np.abs(getattr(one, name) - getattr(other, name))
        assert np.nanmax(off / (1.0 + getattr(one, name))) <= 1e-13


@pytest.mark.parametrize(
    ("seed", "throw", "restitution"),
    [(4, (0.3, 0.95), 0.0), (5, (1.05, 3.0), 0.0), (6, (1.05, 1.5), 0.3)],
    ids=["contact", "hopping", "bouncing"],
)
def test_histories_and_arrivals_of_one_harmonic_as_waves(
    seed: int, throw: tuple[float, float], restitution: float
) -> None:
    checked = 0
    for i in range(16):
        one, other, size, f = _both(seed + 10 * i, throw, restitution, ())
        here, there = (vibro.simulate(scene, cycles=6.3, start_phase=0.4) for scene in (one, other))
        times = np.linspace(0.0, 6.0 / float(f), 50)
        a, b = here.sample(times), there.sample(times)
        assert np.abs(a.position - b.position).max() <= 1e-12 * float(size)
        assert np.abs(a.gap - b.gap).max() <= 1e-12 * float(size)
        advance = float(vibro.solve(one).displacement_per_cycle)
        length = 3.3 * abs(advance) + 1e-3 * float(size)
        first, second = (float(vibro.arrival_time(scene, length)) for scene in (one, other))
        if math.isfinite(first):
            checked += 1
        assert second == pytest.approx(first, rel=1e-12, nan_ok=True)
    assert checked > 5
