"""Flights: beside meshes and 50 digits, over sines and waves."""

from __future__ import annotations

import math
import random
from typing import Any, NamedTuple

import mpmath
import numpy as np
import pytest
from helpers.waves import coefficients_of, drawn_harmonics, drawn_pieces, harmonic_waves, piecewise_waves

from vibro.core.cells import behind, find_nodes, largest, number_of_nodes
from vibro.core.flight import Flight, flight, fly_over_waves, lift_off_flight, sinusoidal
from vibro.core.waves import NORMAL, Mix, Waves, load_at, nodes_of

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


# ------------------------------------------------------------------------------- impacts

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
def test_the_landing_is_the_first_return_to_the_trough_of_waves(seed: int, pieces: bool) -> None:
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
