"""Shares of parts: by hand where a threshold lies in a band, and frictions drawn from a trapezoid."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from helpers.scenes import replaced, scene_with

import vibro
from vibro import Regime
from vibro.designs.spaces import uncertainty_set
from vibro.designs.windows import _cut, _share
from vibro.limits import critical_loads


def share(scene: vibro.Scene, speed: float, highest: Regime = Regime.HOPPING, **bands: Any) -> float:
    return _share(uncertainty_set(scene, bands), speed, highest, 14, 0)


@pytest.mark.parametrize("name", ["amplitude", "frequency", "drive_angle"])
def test_a_band_of_the_drive_is_uniform(name: str) -> None:
    """The speed rises along the band, so that the share is what lies above the crossing."""
    low, high = {"amplitude": (0.7e-3, 1.1e-3), "frequency": (13.0, 15.0), "drive_angle": (0.2, 0.3)}[name]
    crossing = low + 0.3 * (high - low)
    speeds = vibro.solve(replaced(scene_with(), **{name: np.linspace(low, high, 101)})).mean_velocity
    assert np.all(np.diff(speeds) > 0.0)
    target = float(vibro.solve(replaced(scene_with(), **{name: crossing})).mean_velocity)
    bands: dict[str, Any] = {name: (low, high)}
    assert share(scene_with(), target, **bands) == pytest.approx(0.7, abs=1e-3)


@pytest.mark.parametrize("ratio", [(0.77, 0.77), (0.6, 0.9)])
def test_a_ratio_is_of_each_static_friction(ratio: tuple[float, float]) -> None:
    """Beside draws of pseudo-random numbers."""
    scene, static = scene_with(), (0.6, 0.8)
    rng = np.random.default_rng(5)
    mu_s, r = rng.uniform(*static, 40000), rng.uniform(*ratio, 40000)
    speeds = vibro.solve(replaced(scene, static_friction=mu_s, kinetic_friction=r * mu_s)).mean_velocity
    target = float(np.quantile(speeds, 0.35))
    found = share(scene, target, static_friction=static, friction_ratio=ratio)
    assert found == pytest.approx(0.65, abs=0.01)


def test_parts_that_slip_back_are_those_of_low_static_friction() -> None:
    """Above the load of back slip of the middle of the band half of the parts slip back."""
    band = (0.7, 0.8)
    middle = scene_with(amplitude=1.0, static_friction=0.75)
    amplitude = float(critical_loads(middle).back_slip / middle.load)
    found = share(scene_with(amplitude=amplitude), 1e-9, Regime.FORWARD_SLIP, static_friction=band)
    assert found == pytest.approx(0.5, abs=1e-3)


@pytest.mark.parametrize("name", ["normal_phase", "along_amplitude", "normal_amplitude", "static_friction"])
def test_bands_of_an_ellipse_are_uniform(name: str) -> None:
    """Beside a fine grid of the band."""
    fields: dict[str, Any] = {
        "along_amplitude": 9e-4, "normal_amplitude": 3e-4, "normal_phase": -1.05, "frequency": 25.0,
        "static_friction": 0.4, "kinetic_friction": 0.3,
    }  # fmt: skip
    low, high = {"normal_phase": (-2.5, 1.0), "static_friction": (0.3, 0.6)}.get(name, (1e-4, 9e-4))
    grid = vibro.Scene(**{**fields, name: np.linspace(low, high, 20001)})
    cycle = vibro.solve(grid)
    target = float(np.nanquantile(cycle.mean_velocity, 0.6))
    assert target > 0.0
    for highest in (Regime.BACK_SLIP, Regime.HOPPING):
        counts = (cycle.mean_velocity >= target) & (cycle.regime <= highest)
        found = share(vibro.Scene(**fields), target, highest, **{name: (low, high)})
        assert found == pytest.approx(float(np.mean(counts)), abs=1e-3)


U, V = np.array([0.0, 0.25, 0.5, 1.0]), np.array([0.0, 0.5, 1.0, 0.5])


@pytest.mark.parametrize(
    ("static", "kinetic", "mu_s", "mu_d"),
    [
        # no cut: uniform in a rectangle
        ((0.6, 0.8), (0.3, 0.5), [0.6, 0.65, 0.7, 0.8], [0.3, 0.4, 0.5, 0.4]),
        # cut everywhere: a triangle, whose area grows with the square
        ((0.3, 0.7), (0.3, 0.9), [0.3, 0.5, 0.3 + 0.4 * math.sqrt(0.5), 0.7],
         [0.3, 0.4, 0.3 + 0.4 * math.sqrt(0.5), 0.5]),
        # cut up to 0.5: areas of 0.02 and 0.04
        ((0.3, 0.7), (0.3, 0.5), [0.3, 0.3 + math.sqrt(0.03), 0.55, 0.7],
         [0.3, 0.3 + 0.5 * math.sqrt(0.03), 0.5, 0.4]),
        # bands without a width
        ((0.6, 0.8), (0.4, 0.4), [0.6, 0.65, 0.7, 0.8], [0.4] * 4),
        ((0.6, 0.6), (0.4, 0.8), [0.6] * 4, [0.4, 0.5, 0.6, 0.5]),
        ((0.6, 0.6), (0.4, 0.4), [0.6] * 4, [0.4] * 4),
        # static friction below the least kinetic one is left out
        ((0.2, 0.5), (0.4, 0.4), [0.4, 0.425, 0.45, 0.5], [0.4] * 4),
    ],
)  # fmt: skip
def test_frictions_are_uniform_in_the_cut_rectangle(
    static: Any, kinetic: Any, mu_s: list[float], mu_d: list[float]
) -> None:
    scene = scene_with(static_friction=static[1], kinetic_friction=kinetic[0])
    box = uncertainty_set(scene, {"static_friction": static, "kinetic_friction": kinetic})
    drawn = _cut(box, U, V)
    assert drawn[0] == pytest.approx(mu_s, rel=1e-12)
    assert drawn[1] == pytest.approx(mu_d, rel=1e-12)
