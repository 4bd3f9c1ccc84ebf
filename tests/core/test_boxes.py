"""Boxes of operating points: the frequencies that stand for a load, and the speed of a single body."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from helpers.cases import each
from helpers.solver_boxes import GRAVITY, bodies, box_of, solver_boxes
from hypothesis import given
from hypothesis import strategies as st

import vibro
from vibro import Regime
from vibro.core.boxes import AXES, Box, frequency_at, mean_speed, speed_at

NUT = [1.4, 0.35, 0.0, 0.0, 0.0, 0.74, 0.57]
WIDE = [1.5, 0.36, 0.0, 0.0, 0.0, 0.74, 0.57]


def test_loads_have_the_frequencies_of_the_ends_of_their_factors() -> None:
    """Of the least factor the highest frequency, within the band."""
    box = box_of(NUT, WIDE, frequency=(10.0, 20.0), factor_low=1e-3, factor_high=3e-3)
    for load in (1.4, 1.45):
        high, low = frequency_at(box, load, True), frequency_at(box, load, False)
        assert 1e-3 * (2.0 * math.pi * high) ** 2 / GRAVITY == pytest.approx(load)
        assert 3e-3 * (2.0 * math.pi * low) ** 2 / GRAVITY == pytest.approx(load)
    assert frequency_at(box, 100.0, True) == 20.0
    assert frequency_at(box, 1e-3, False) == 10.0


@pytest.mark.parametrize("path", [0.7, -0.7])
def test_the_least_speed_of_a_load_is_at_the_frequency_of_its_sign(path: float) -> None:
    box = box_of(NUT, WIDE, frequency=(10.0, 20.0), factor_low=1e-3, factor_high=3e-3)
    w = 2.0 * math.pi * frequency_at(box, 1.45, path > 0.0)
    expected = path * 1.45 * GRAVITY / (2.0 * math.pi * w)
    assert mean_speed(box, 1.45, path) == pytest.approx(expected, rel=1e-14)
    other = 2.0 * math.pi * frequency_at(box, 1.45, path < 0.0)
    assert expected < path * 1.45 * GRAVITY / (2.0 * math.pi * other)
    assert mean_speed(box, 1.4, path) * path < mean_speed(box, 1.5, path) * path  # it grows in size


@given(solver_boxes(), st.lists(st.floats(0.0, 1.0), min_size=AXES, max_size=AXES))
def test_the_speed_of_a_body_is_that_of_its_scene(box: Box, shares: list[float]) -> None:
    """At either end of the frequencies of its load, the slower one."""
    box = box._replace(frequency_low=15.0, frequency_high=15.0, factor_low=1e-12, factor_high=1e12)
    x: Any = [low + share * (high - low) for low, high, share in zip(box.low, box.high, shares, strict=True)]
    x[6] = min(max(x[6], box.ratio_low * x[5]), box.ratio_high * x[5])
    cycle = bodies(box._replace(low=x, high=x, ratio_low=0.0, ratio_high=1.0), np.zeros((AXES + 1, 1)))
    row: Any = [math.nan, *x]
    found = speed_at(box, row, 1)
    if cycle.regime[0] == Regime.HOPPING:
        assert math.isnan(found)
    elif not math.isfinite(cycle.mean_velocity[0]):
        assert found == -math.inf
    else:
        assert found == pytest.approx(box.way * float(cycle.mean_velocity[0]), rel=1e-9, abs=1e-12)


@each("way", [1.0, -1.0])
@each(
    ("changed", "highest", "expected"),
    [
        ({}, Regime.HOPPING, "speed"), ({}, Regime.BACK_SLIP, "speed"), ({}, Regime.FORWARD_SLIP, "least"),
        ({0: 3.0}, Regime.HOPPING, "unknown"), ({0: 3.0}, Regime.BACK_SLIP, "least"),
        ({4: -0.6}, Regime.HOPPING, "least"), ({4: -0.7}, Regime.HOPPING, "least"),
    ],
)  # fmt: skip
def test_bodies_without_a_speed_count_as_the_slowest(
    changed: dict[int, float], highest: Regime, expected: str, way: float
) -> None:
    """As do those of a regime too high; of bodies that hop the speed is unknown."""
    x: Any = [changed.get(i, value) for i, value in enumerate(NUT)]
    found = speed_at(box_of(x, way=way, highest=int(highest)), x, 0)
    scene: dict[str, Any] = {"drive_angle": 0.35, "static_friction": 0.74, "kinetic_friction": 0.57}
    amplitude = NUT[0] * GRAVITY / (2.0 * math.pi * 15.0) ** 2
    if expected == "speed":
        speed = float(vibro.solve(vibro.Scene(amplitude=amplitude, frequency=15.0, **scene)).mean_velocity)
        assert found == pytest.approx(way * speed, rel=1e-12)
    else:
        assert found == -math.inf if expected == "least" else math.isnan(found)


def test_friction_beyond_its_ratios_is_that_at_the_cut() -> None:
    box = box_of(NUT, ratio_low=0.7, ratio_high=0.75)
    for kinetic, cut in ((0.2, 0.7 * 0.74), (0.7, 0.75 * 0.74), (0.53, 0.53)):
        given: Any = [*NUT[:6], kinetic, *NUT[:6], cut]
        assert speed_at(box, given, 0) == speed_at(box, given, AXES)
