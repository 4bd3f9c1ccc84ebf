"""What one percent of each input costs, beside the speeds of scenes that differ by a little."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers.scenes import replaced, scene_with

import vibro
from vibro.inverse.costs import speed_costs

NAMES = ["amplitude", "frequency", "drive_angle", "static_friction", "kinetic_friction", "trough_angle_deg"]
STEP = 1e-5


def differences(scene: vibro.Scene) -> dict[str, float]:
    """Differences of ``solve`` over a small step to each side."""
    speed = float(vibro.solve(scene).mean_velocity)
    costs = {}
    for name in NAMES:
        field = name.removesuffix("_deg")
        value = float(getattr(scene, field))
        step = math.radians(STEP) if name.endswith("_deg") else value * STEP
        more, less = (
            float(vibro.solve(replaced(scene, **{field: value + way * step})).mean_velocity)
            for way in (1, -1)
        )
        costs[name] = (more - less) / (2 * STEP * speed) * (100.0 if name.endswith("_deg") else 1.0)
    return costs


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"amplitude": 1.25e-3, "trough_angle": math.radians(3)},
        {"amplitude": 1.5e-3, "trough_angle": math.radians(-2)},
        {"amplitude": 2e-3},
        {"amplitude": 0.9e-3, "trough_angle": math.radians(27)},  # conveyed backwards
    ],
    ids=["F_", "F_B_", "FB_", "FB", "B_"],
)
def test_costs_are_those_of_small_changes(changes: dict[str, float], request: pytest.FixtureRequest) -> None:
    scene = scene_with(**changes)
    assert vibro.solve(scene).pattern in request.node.name
    costs = speed_costs(scene)
    assert list(costs) == NAMES
    size = max(map(abs, costs.values()))
    assert costs == pytest.approx(differences(scene), rel=1e-6, abs=1e-7 * size)


def test_faster_has_one_sign_both_ways() -> None:
    backwards = scene_with(amplitude=0.9e-3, trough_angle=math.radians(27))
    assert vibro.solve(backwards).mean_velocity < 0
    assert speed_costs(backwards)["trough_angle_deg"] > 0 > speed_costs(scene_with())["trough_angle_deg"]
    assert speed_costs(scene_with())["amplitude"] > 1


def test_nothing_of_an_angle_of_zero_costs_nothing() -> None:
    assert speed_costs(scene_with(drive_angle=0.0, trough_angle=-0.1))["drive_angle"] == 0.0


@pytest.mark.parametrize(
    "changes",
    [
        {"amplitude": 0.5e-3},
        {"amplitude": 4e-3},
        {"drive_angle": 0.0, "amplitude": 2e-3},
        {"static_friction": 0.0, "kinetic_friction": 0.0},
        {"trough_angle": math.radians(40)},
    ],
    ids=["rests", "hops", "to and fro", "no friction", "runs away"],
)
def test_where_there_is_no_speed_there_is_no_cost(changes: dict[str, float]) -> None:
    assert np.isnan(list(speed_costs(scene_with(**changes)).values())).all()


def test_more_than_one_operating_point_is_refused() -> None:
    with pytest.raises(vibro.SceneError, match=r"scene = shape \(2,\): must be one operating point"):
        speed_costs(scene_with(frequency=[10.0, 20.0]))


def test_an_ellipse_at_a_jump_has_no_costs() -> None:
    """One step further back slip has entered and the speed is another: a difference across it is no slope."""
    ellipse = {"along_amplitude": 1.1e-3, "normal_amplitude": 4e-4, "normal_phase": 0.0, "frequency": 15.0}
    scene = vibro.Scene(**ellipse, static_friction=0.74, kinetic_friction=0.57)
    jump = float(vibro.critical_loads(scene).back_slip / scene.load)
    below, at, above = (
        vibro.Scene(
            **{**ellipse, "along_amplitude": 1.1e-3 * jump * s, "normal_amplitude": 4e-4 * jump * s},
            static_friction=0.74,
            kinetic_friction=0.57,
        )
        for s in (1 - 1e-3, 1 - 1e-6, 1 + 1e-3)
    )
    assert [str(vibro.solve(s).pattern) for s in (below, at, above)] == ["F_", "F_", "F_B_"]
    for smooth in (below, above):
        assert all(math.isfinite(cost) for cost in speed_costs(smooth).values())
    costs = speed_costs(at)
    assert all(math.isnan(costs[name]) for name in ("along_amplitude", "frequency", "static_friction"))
