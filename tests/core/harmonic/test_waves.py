"""Zeros and turning points of trigonometric polynomials, and slides in their brackets."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from vibro.core.harmonic.chain import zeros_by_derivatives
from vibro.core.harmonic.slides import distance, rates, velocity
from vibro.core.harmonic.waves import TURN, crossings, slopes_of, turning_points, values, wrapped


@pytest.mark.parametrize("harmonics", [1, 2, 3, 5])
def test_no_zero_and_no_maximum_is_missed(harmonics: int) -> None:
    count = 1000
    rng = np.random.default_rng(harmonics)
    waves = rng.normal(size=(2 * harmonics + 1, count))
    waves[0] *= rng.uniform(0.0, 2.0, count)
    points = turning_points(waves)
    at = values(waves, points)
    up, down = crossings(waves, points, at)
    mesh = np.linspace(0.0, TURN, 2001)[:-1]
    seen = values(waves, mesh[:, np.newaxis] + np.zeros(count))
    positive = seen > 0.0
    changes = (positive != np.roll(positive, -1, axis=0)).sum(axis=0)
    found = (~np.isnan(up)).sum(axis=0) + (~np.isnan(down)).sum(axis=0)
    assert (found >= changes).all()
    assert (found > changes).sum() <= 2  # both zeros between two points of the mesh
    assert (at.max(axis=0) - seen.max(axis=0)).min() > -1e-14 * harmonics
    assert np.nanmax(np.abs(values(waves, up))) < 1e-13
    assert (np.diff(points, axis=0) >= 0.0).all()
    assert (points[-1] - points[0]).max() <= TURN


@pytest.mark.parametrize("harmonics", [1, 2, 3])
def test_samples_and_derivatives_find_the_same_turning_points(harmonics: int) -> None:
    rng = np.random.default_rng(harmonics)
    waves = rng.normal(size=(2 * harmonics + 1, 1000))
    slopes = slopes_of(waves)

    def turns(points: np.ndarray) -> np.ndarray:
        level = np.abs(values(slopes, points)) < 1e-7
        return np.sort(np.where(level, wrapped(points), np.nan), axis=0)

    by_samples, by_derivatives = turns(turning_points(waves)), turns(zeros_by_derivatives(slopes))
    for here, there in ((by_samples, by_derivatives), (by_derivatives, by_samples)):
        apart = np.abs(wrapped(here[:, np.newaxis] - there + np.pi) - np.pi)
        nearest = np.nan_to_num(apart, nan=np.inf).min(axis=1)
        assert nearest[~np.isnan(here)].max() < 1e-6


@pytest.mark.parametrize("gap", [1e-3, 1e-6, 1e-9, 1e-12])
def test_nearly_double_zeros_are_two_or_none(gap: float) -> None:
    # (1 - cos(p - a)) (b - cos(p - c)) -+ gap: two zeros about a, or none there
    rng = np.random.default_rng(2)
    count = 200
    a, c = rng.uniform(0.0, TURN, (2, count))
    b = rng.uniform(1.2, 3.0, count)
    for sign, wanted in ((-1.0, 2), (1.0, 0)):
        waves = np.array(
            [
                b + 0.5 * np.cos(a - c) + sign * gap,
                -b * np.sin(a) - np.sin(c),
                0.5 * np.sin(a + c),
                -b * np.cos(a) - np.cos(c),
                0.5 * np.cos(a + c),
            ]
        )
        points = turning_points(waves)
        up, down = crossings(waves, points, values(waves, points))
        assert set((~np.isnan(up)).sum(axis=0) + (~np.isnan(down)).sum(axis=0)) == {wanted}
        if wanted:
            width = np.sqrt(2.0 * gap / (b - np.cos(a - c)))
            off = np.abs(np.mod(up[0] - a + np.pi, TURN) - np.pi)
            assert np.max(np.abs(off / width - 1.0)) < 0.1


def test_speed_and_path_are_the_integrals_of_the_acceleration() -> None:
    rng = np.random.default_rng(4)
    wave = rng.normal(size=(5, 1))
    start = np.array([0.7])
    own = rates(wave, start)
    lengths = np.array([1e-4, 0.02, 0.3, 1.0, 2.5, 6.0])

    def motion(s: float, state: np.ndarray) -> tuple[float, float]:
        return float(state[1]), float(values(wave, start + s)[0])

    for length in lengths:
        end = solve_ivp(motion, (0.0, length), (0.0, 0.0), rtol=1e-11, atol=1e-18).y[:, -1]
        speed, slope, _ = velocity(np.array([length]), own)
        assert abs(speed[0] - end[1]) < 1e-9 * abs(end[1]) + 1e-13
        assert abs(slope[0] - values(wave, start + length)[0]) < 1e-13
        # the path is that of a slide that ends at zero speed: take the constant that brings it there
        stopped = own.copy()
        stopped[0] -= speed / length
        path = end[0] - 0.5 * length * speed[0]
        assert abs(distance(np.array([length]), stopped)[0] - path) < 1e-8 * abs(path) + 1e-12 * length**2
