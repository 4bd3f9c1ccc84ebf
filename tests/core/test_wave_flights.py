"""Flights over any periodic trough: first landings beside a dense mesh, and how few pieces they take."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import pytest
from helpers.waves import coefficients_of, drawn_harmonics, drawn_pieces, harmonic_waves, piecewise_waves

from vibro.core import flight
from vibro.core.cells import behind, find_nodes, largest, number_of_nodes
from vibro.core.flight import fly_over_waves
from vibro.core.legs import ahead
from vibro.core.numbers import TURN
from vibro.core.waves import NORMAL, Mix, Waves, load_at, nodes_of

EPS = 2.0**-52
LIFT = Mix(0.0, 0.0, 1.0)


class Trough(NamedTuple):
    """A trough's normal motion, N/n = 1 - K B / max B, and how steep a body on it rises and falls."""

    waves: Waves
    lift: Mix
    breaks: Any
    pieces: Any  # of -N/n; the coefficients of harmonics where there are no breaks

    def fallen(self, phase: float, speed: float, s: Any) -> tuple[Any, Any]:
        """Height and rate over the trough, a phase after a take-off, by sums of their own."""
        s = np.asarray(s)
        if self.breaks is None:
            k = np.arange(1, len(self.pieces) + 1)
            c = self.pieces * np.exp(1j * k * phase)
            turned = np.exp(1j * np.multiply.outer(s, k))
            rate = (((turned - 1.0) / (1j * k)) @ c).imag
            path = ((-(turned - 1.0) / k**2 - np.multiply.outer(s, 1.0 / (1j * k))) @ c).imag
            return speed * s + path - 0.5 * s * s, speed + rate - s
        ends = TURN * self.breaks
        width = np.diff(ends)
        c = self.pieces
        whole_rate = width * (c @ (1.0, 1 / 2, 1 / 3, 1 / 4))
        whole_path = width**2 * (c @ (1 / 2, 1 / 6, 1 / 12, 1 / 20))
        starts_rate = np.concatenate(([0.0], np.cumsum(whole_rate)))
        starts_path = np.zeros(len(c) + 1)
        for j in range(len(c)):
            starts_path[j + 1] = starts_path[j] + starts_rate[j] * width[j] + whole_path[j]

        def integrals(p: Any) -> tuple[Any, Any]:
            turns = np.floor(p / TURN)
            here = p - TURN * turns
            j = np.clip(np.searchsorted(ends, here, side="right") - 1, 0, len(c) - 1)
            step = here - ends[j]
            u = step / width[j]
            a0, a1, a2, a3 = c[j].T
            rate = starts_rate[j] + step * (a0 + u * (a1 / 2 + u * (a2 / 3 + u * a3 / 4)))
            path = starts_path[j] + starts_rate[j] * step
            path += step**2 * (a0 / 2 + u * (a1 / 6 + u * (a2 / 12 + u * a3 / 20)))
            drift, whole = starts_rate[-1], starts_path[-1]
            path = path + turns * whole + drift * (TURN * turns * (turns - 1) / 2 + turns * here)
            return rate + turns * drift, path

        rate0, path0 = integrals(np.asarray([phase]))
        rate1, path1 = integrals(phase + s)
        return speed * s + path1 - path0 - rate0 * s, speed + rate1 - rate0


def _over_harmonics(rng: np.random.Generator, count: int, throw: float) -> Trough:
    waves = harmonic_waves(np.zeros(count, complex), drawn_harmonics(rng, count))
    share = throw / largest(waves, LIFT)
    lift = Mix(-1.0, 0.0, share)
    find_nodes(waves, NORMAL, Mix(-1.0, 0.0, share))
    return Trough(waves, lift, None, share * coefficients_of(waves, normal=True))


def _over_pieces(rng: np.random.Generator, count: int, throw: float) -> Trough:
    breaks, pieces = drawn_pieces(rng, count)
    waves = piecewise_waves(breaks, pieces)
    share = throw / largest(waves, LIFT)
    find_nodes(waves, NORMAL, Mix(-1.0, 0.0, share))
    lift = -share * pieces[1]
    lift[:, 0] -= 1.0
    return Trough(waves, Mix(-1.0, 0.0, share), breaks, lift)


def _drawn(seed: int, count: int, *, pieces: bool = False) -> list[tuple[Trough, float, float, bool]]:
    """Draw troughs, and take-offs: from a lift-off, where the trough falls away, or with a speed."""
    rng = np.random.default_rng(seed)
    drawn = []
    for i in range(count):
        throw = 1.0 + 10.0 ** rng.uniform(-6.0, 1.0)
        size = 2 + i % 12 if pieces else 1 + i % 16
        trough = (_over_pieces if pieces else _over_harmonics)(rng, size, throw)
        waves = trough.waves
        lift_offs = [
            waves.number[nodes_of(waves, NORMAL) + j]
            for j in range(number_of_nodes(waves, NORMAL))
            if behind(waves, NORMAL, j)
        ]
        phase, speed, lifted = lift_offs[i % len(lift_offs)], 0.0, i % 3 == 0
        if i % 3 == 1:
            phase, speed = rng.uniform(0.0, TURN), 10.0 ** rng.uniform(-4.0, 1.5)
        elif i % 3 == 2:
            falls = [p for p in rng.uniform(0.0, TURN, 400).tolist() if load_at(waves, trough.lift, p) > 0.0]
            phase, lifted = (falls[0], False) if falls else (phase, True)
        drawn.append((trough, phase, speed, lifted))
    return drawn


@pytest.mark.parametrize(("seed", "pieces"), [(1, False), (2, False), (3, True), (4, True)])
def test_the_landing_is_the_first_return_to_the_trough(seed: int, pieces: bool) -> None:
    """320 flights, over harmonics to H = 16 and over pieces with jumps."""
    for trough, phase, speed, lifted in _drawn(seed, 80, pieces=pieces):
        length, impact = fly_over_waves(trough.waves, trough.lift, phase, speed, lifted)
        assert 0.0 < length < math.inf
        throw = 1.0 + float(np.abs(trough.pieces).sum())
        mesh = np.linspace(0.0, length, 2 + min(int(30.0 * trough.waves.size * max(length, 0.1)), 6000))
        height, rate = trough.fallen(phase, speed, mesh)
        rounding = 32.0 * EPS * throw * (1.0 + length) ** 2
        # of a flight from rest the height begins like the cube of the phase, or the square
        assert (height[1:-1] >= -rounding).all()
        fall = max(abs(float(rate[-1])), 1e-3)
        assert abs(float(height[-1])) <= rounding + 1e-12 * fall * length
        assert impact == pytest.approx(-float(rate[-1]), abs=1e-12 * throw * (1.0 + length))
        assert impact >= 0.0


def test_a_short_flight_lasts_twice_as_long_as_the_trough_falls_away() -> None:
    """Just above K = 1 the load is a parabola, so that the height is s^3 (u/6 - s/12) times a constant."""
    rng, checked = np.random.default_rng(5), 0
    for i in range(60):
        trough = _over_harmonics(rng, 1 + i % 8, 1.0 + 10.0 ** rng.uniform(-10.0, -8.0))
        waves = trough.waves
        assert number_of_nodes(waves, NORMAL) == 2
        first = 0 if behind(waves, NORMAL, 0) else 1
        begin = waves.number[nodes_of(waves, NORMAL) + first]
        upwards = ahead(waves, NORMAL, begin, first + 1)
        length, impact = fly_over_waves(waves, trough.lift, begin, 0.0, True)
        assert length == pytest.approx(2.0 * upwards, rel=1e-2)
        bend = 8.0 * load_at(waves, trough.lift, begin + 0.5 * upwards) / upwards**2
        assert impact == pytest.approx(bend * upwards**3 / 3.0, rel=2e-2)
        checked += 1
    assert checked == 60


@pytest.mark.parametrize("harmonics", [1, 2, 3, 5, 8, 16])
def test_flights_take_few_pieces_however_long_they_are(
    harmonics: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls = 0

    def counted(waves: Waves, row: int, phase: float, index: int) -> float:
        nonlocal calls
        calls += 1
        return ahead(waves, row, phase, index)

    monkeypatch.setattr(flight, "ahead", counted)
    rng = np.random.default_rng(harmonics)
    worst, longest = 0, 0.0
    for i in range(60):
        throw = 10.0 ** rng.uniform(0.001, 5.0)
        trough = _over_harmonics(rng, harmonics, throw)
        speed = throw * 10.0 ** rng.uniform(-6.0, 1.0) if i % 2 else 0.0
        phase, waves = rng.uniform(0.0, TURN), trough.waves
        if speed == 0.0:
            first = 0 if behind(waves, NORMAL, 0) else 1
            phase = waves.number[nodes_of(waves, NORMAL) + first]
        calls = 0
        length, _ = fly_over_waves(waves, trough.lift, phase, speed, speed == 0.0)
        worst, longest = max(worst, calls), max(longest, length)
        assert calls <= 4 * harmonics + 2
    assert longest > 1000.0 * TURN
    assert worst > 2
