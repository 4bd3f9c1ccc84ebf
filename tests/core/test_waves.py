"""Values and integrals of loads beside 40 digits, over short phases and many turns, of both kinds."""

from __future__ import annotations

import math
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

from vibro.core.numbers import TURN
from vibro.core.waves import (
    Mix,
    Waves,
    depart,
    load_at,
    moved,
    ride,
    trough_at,
)

EPS = 2.0**-52
MP = mpmath.mp.clone()
MP.dps = 40


def _exact_harmonics(waves: Waves, mix: Mix, phase: float, value: float, s: float) -> tuple[Any, Any, Any]:
    """Return the change of a mix since a phase, added to a value, and its integrals, with 40 digits."""
    p, s = MP.mpf(phase), MP.mpf(s)
    load, velocity, path = MP.mpf(value), value * s, value * s * s / 2
    for k in range(1, waves.size + 1):
        u, w = (
            MP.mpf(mix.along) * waves.number[i] + MP.mpf(mix.normal) * waves.number[2 * waves.size + i]
            for i in (k - 1, waves.size + k - 1)
        )
        (c0, s0), (c1, s1) = MP.cos_sin(k * p), MP.cos_sin(k * (p + s))
        load += u * (s1 - s0) + w * (c1 - c0)
        velocity += (u * (c0 - c1) + w * (s1 - s0)) / k - (u * s0 + w * c0) * s
        first = u * (k * s * c0 - (s1 - s0)) - w * (k * s * s0 + (c1 - c0))
        path += first / k**2 - (u * s0 + w * c0) * s * s / 2
    return load, velocity, path


@pytest.mark.parametrize("harmonics", [1, 2, 3, 5, 8, 16])
def test_integrals_of_harmonics_have_all_digits_however_short(harmonics: int) -> None:
    rng = np.random.default_rng(harmonics)
    worst = 0.0
    for i in range(50):
        waves = harmonic_waves(drawn_harmonics(rng, harmonics), drawn_harmonics(rng, harmonics))
        mix = Mix(*rng.normal(size=3))
        phase, s = rng.uniform(0.0, TURN), 10.0 ** rng.uniform(-9.0, 2.0)
        value = depart(waves, mix, phase).load
        assert value == pytest.approx(load_at(waves, mix, phase), rel=0.0, abs=1e-14 * harmonics)
        if i % 2:
            value = 0.0  # as at a lift-off
        found = moved(waves, mix, phase, value, s)
        exact = _exact_harmonics(waves, mix, phase, value, s)
        sizes = abs(mix.along) * np.abs(coefficients_of(waves, normal=False))
        sizes += abs(mix.normal) * np.abs(coefficients_of(waves, normal=True))
        k = np.arange(1, harmonics + 1)
        # of what is added up: changes of the load, in which k s is rounded where that is many turns
        change = float((sizes * np.minimum(k * s, 2.0) * np.maximum(1.0, k * s)).sum()) + abs(value)
        for power, (got, true) in enumerate(zip(found[:3], exact, strict=True)):
            worst = max(worst, abs(float(got - true)) / (EPS * change * s**power))
        c = mix.along * coefficients_of(waves, normal=False) + mix.normal * coefficients_of(
            waves, normal=True
        )
        slope = float(harmonic_value(1j * k * c, phase + s))
        assert found.slope == pytest.approx(slope, rel=0.0, abs=1e-15 * (8.0 + s) * float((k * k) @ sizes))
    assert worst < 8.0


@pytest.mark.parametrize("harmonics", [1, 3, 16])
def test_what_acts_on_a_carried_body_is_the_loads_and_the_trough_s_velocity(harmonics: int) -> None:
    rng = np.random.default_rng(50 + harmonics)
    for i in range(40):
        waves = harmonic_waves(drawn_harmonics(rng, harmonics), drawn_harmonics(rng, harmonics))
        if i % 2:
            waves = piecewise_waves(*drawn_pieces(rng, harmonics))
        phase, s = rng.uniform(0.0, TURN), (0.0, rng.uniform(0.0, 12.0))[i % 3 > 0]
        found = ride(waves, phase, s)
        assert found.along == pytest.approx(load_at(waves, Mix(0.0, 1.0, 0.0), phase + s), abs=1e-12)
        assert found.normal == pytest.approx(load_at(waves, Mix(0.0, 0.0, 1.0), phase + s), abs=1e-12)
        assert found.velocity == pytest.approx(trough_at(waves, True, phase + s).slope, abs=1e-12)


def _exact_pieces(breaks: Any, mixed: Any, phase: float, s: float) -> tuple[Any, Any]:
    """Integrate pieces of a mix, given in shares, from a phase on: velocity and path with 40 digits."""
    count, turn = len(mixed), 2 * MP.pi
    ends = [turn * MP.mpf(float(x)) for x in breaks]
    velocity, path, left = MP.mpf(0), MP.mpf(0), MP.mpf(s)
    j = max(i for i in range(count) if ends[i] <= phase)
    here = phase - ends[j]
    while left > 0:
        width = ends[j + 1] - ends[j]
        step, u = min(left, width - here), here / width
        a = [MP.mpf(float(x)) for x in mixed[j]]
        # powers of the phase since then
        b = [sum(math.comb(n, m) * a[n] * u ** (n - m) for n in range(m, 4)) / width**m for m in range(4)]
        path += velocity * step + sum(b[m] * step ** (m + 2) / ((m + 1) * (m + 2)) for m in range(4))
        velocity += sum(b[m] * step ** (m + 1) / (m + 1) for m in range(4))
        left, j, here = left - step, (j + 1) % count, MP.mpf(0)
    return velocity, path


@pytest.mark.parametrize("count", [1, 2, 5, 12])
def test_integrals_of_pieces(count: int) -> None:
    rng = np.random.default_rng(count)
    for i in range(40):
        breaks, pieces = drawn_pieces(rng, count)
        waves = piecewise_waves(breaks, pieces)
        mix = Mix(float(rng.normal()), (1.0, 0.0, -0.4)[i % 3], (0.0, 1.0, 0.8)[i % 3])
        mixed = -(mix.along * pieces[0] + mix.normal * pieces[1])
        mixed[:, 0] += mix.constant
        phase, s = rng.uniform(0.0, TURN), 10.0 ** rng.uniform(-6.0, 1.5)
        value = depart(waves, mix, phase).load
        size = float(np.abs(mixed).sum(axis=1).max())
        assert value == pytest.approx(
            float(piecewise_value(breaks, mixed, phase)), rel=0.0, abs=64.0 * EPS * size
        )
        assert value == load_at(waves, mix, phase)
        found = moved(waves, mix, phase, value, s)
        velocity, path = _exact_pieces(breaks, mixed, phase, s)
        ahead = float(piecewise_value(breaks, mixed, phase + s))
        # a phase that is rounded moves the load by its rate
        steep = size / float(np.diff(breaks).min())
        assert found.load == pytest.approx(ahead, rel=0.0, abs=64.0 * EPS * steep * (1.0 + s))
        bound = 64.0 * EPS * size * s
        assert float(found.velocity) == pytest.approx(float(velocity), rel=0.0, abs=bound)
        assert float(found.path) == pytest.approx(float(path), rel=0.0, abs=bound * (s + TURN))


@pytest.mark.parametrize("normal", [False, True])
def test_the_trough_moves_about_its_mean(normal: bool) -> None:
    rng = np.random.default_rng(7)
    mesh = (np.arange(2048) + 0.5) * TURN / 2048
    for i in range(8):
        if i % 2:
            count = 1 + i
            waves = harmonic_waves(drawn_harmonics(rng, count), drawn_harmonics(rng, count))
            load = harmonic_value(coefficients_of(waves, normal=normal), mesh)
        else:
            breaks, pieces = drawn_pieces(rng, 1 + i)
            waves = piecewise_waves(breaks, pieces)
            load = -piecewise_value(breaks, pieces[int(normal)], mesh)
        at = np.array([trough_at(waves, normal, float(p)) for p in mesh])
        size = np.abs(load).max()
        step = TURN / 2048
        # positions and velocities have no mean; their rates are the velocities and the load
        assert np.abs(at.mean(axis=0)).max() < 1e-6 * size
        rates = (at[2:] - at[:-2]) / (2.0 * step)
        assert rates[:, 0] == pytest.approx(at[1:-1, 1], abs=2e-3 * size)
        smooth = np.abs(np.diff(load, 2)) < 0.05 * size
        assert rates[smooth, 1] == pytest.approx(-load[1:-1][smooth], abs=0.06 * size)
        bounds = (waves.height if normal else math.inf), math.inf if normal else waves.velocity
        assert np.abs(at[:, 0]).max() <= bounds[0] * (1.0 + 1e-12)
        assert np.abs(at[:, 1]).max() <= bounds[1] * (1.0 + 1e-12)
