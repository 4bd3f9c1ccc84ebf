"""What one percent of each input costs, beside the speeds of scenes that differ by a little."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from helpers.scenes import replaced, scene_with

import vibro
from vibro.designs.sensitivities import speed_costs
from vibro.steady import speed_exponent

NAMES = ["amplitude", "frequency", "drive_angle", "static_friction", "kinetic_friction", "trough_angle_deg"]
STEP = 1e-5


def numbers(scene: vibro.Scene) -> dict[str, float]:
    """What each input costs, where all cost something that is known."""
    costs = {name: cost for name, cost in speed_costs(scene).items() if not isinstance(cost, str)}
    assert list(costs) == list(speed_costs(scene))
    return costs


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
    costs = numbers(scene)
    assert list(costs) == NAMES
    size = max(map(abs, costs.values()))
    assert costs == pytest.approx(differences(scene), rel=1e-6, abs=1e-7 * size)


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({"amplitude": 0.5e-3}, "rests: no speed to change"),
        ({"drive_angle": 0.0, "amplitude": 2e-3}, "slides to and fro: no speed to change"),
        ({"static_friction": 0.0, "kinetic_friction": 0.0}, "no speed: indeterminate"),
        ({"trough_angle": math.radians(40)}, "runs away"),
    ],
)
def test_where_there_is_no_speed_the_reason_is_told(changes: dict[str, float], why: str) -> None:
    assert speed_costs(scene_with(**changes)) == dict.fromkeys(NAMES, why)


@pytest.mark.parametrize(
    ("pattern", "changes"),
    [
        ("HFB", {"amplitude": 4e-3}),
        ("HBF", {"amplitude": 8e-3}),
        ("H", {"amplitude": 12e-3}),
        ("H_F", {"amplitude": 4e-3, "drive_angle": 0.9}),
        ("HFB", {"amplitude": 4e-3, "trough_angle": math.radians(3), "kinetic_friction": 0.4}),
    ],
)
def test_bodies_that_hop_smoothly_have_costs(pattern: str, changes: dict[str, float]) -> None:
    """Differences over a step that is ten times as large agree, as the motion is smooth."""
    scene = scene_with(**changes)
    assert vibro.solve(scene).pattern == pattern
    costs = numbers(scene)
    assert list(costs) == [*NAMES, "restitution"]
    speed = float(vibro.solve(scene).mean_velocity)
    bounces = [scene_speed(scene, restitution=1e-4 * k) for k in range(5)]
    slope = np.array([-25.0, 48.0, -36.0, 16.0, -3.0]) @ bounces / 12e-4
    assert costs.pop("restitution") == pytest.approx(slope / speed, rel=1e-3, abs=1e-5)
    for name, cost in costs.items():
        field = name.removesuffix("_deg")
        value = float(getattr(scene, field))
        step = math.radians(1e-2) if name.endswith("_deg") else 1e-4 * value
        more, less = (
            float(vibro.solve(replaced(scene, **{field: value + way * step})).mean_velocity)
            for way in (1, -1)
        )
        unit = 1e-2 if name.endswith("_deg") else 1e-4
        scaled = 100.0 if name.endswith("_deg") else 1.0
        assert cost == pytest.approx(scaled * (more - less) / (2 * unit * speed), rel=1e-3, abs=1e-5)


def test_irregular_hops_have_no_costs() -> None:
    irregular = scene_with(amplitude=10.7e-3, restitution=0.5)
    assert vibro.solve(irregular).status == vibro.Status.AVERAGED
    assert speed_costs(irregular) == dict.fromkeys([*NAMES, "restitution"], "hops: irregular")


def hops_at(amplitude: Any, restitution: float = 0.0) -> vibro.Scene:
    return scene_with(amplitude=amplitude, restitution=restitution)


@pytest.mark.parametrize("motion", ["forward_onset", "back_slip", "continuous_sliding"])
def test_beside_an_onset_a_cost_is_right_or_there_is_none(motion: str) -> None:
    """The speed grows as a power of the distance from an onset: far more than 1e-6 of a slope may be lost."""
    base = scene_with()
    onset = 1e-3 * float(getattr(vibro.critical_loads(base), motion) / base.load)
    found = 0
    for distance in np.logspace(-7.0, -0.7, 30):
        scene = scene_with(amplitude=onset * (1.0 + distance))
        cost = speed_costs(scene)["amplitude"]
        exact = float(speed_exponent(scene, vibro.solve(scene)))
        assert isinstance(cost, str) or cost == pytest.approx(exact, rel=1e-6)
        found += not isinstance(cost, str)
    assert found >= 10


def test_at_equal_frictions_the_cost_of_the_kinetic_one_is_that_of_less() -> None:
    scene = scene_with(static_friction=0.5, kinetic_friction=0.5, amplitude=1.5e-3)
    less = np.array([scene_speed(scene, kinetic_friction=0.5 * (1.0 - 1e-3 * k)) for k in range(5)])
    fourth_order = np.array([25.0, -48.0, 36.0, -16.0, 3.0]) @ less / 12.0 / (1e-3 * less[0])
    assert numbers(scene)["kinetic_friction"] == pytest.approx(fourth_order, rel=1e-6)


def scene_speed(scene: vibro.Scene, **changes: float) -> float:
    return float(vibro.solve(replaced(scene, **changes)).mean_velocity)


def test_where_hops_change_speed_has_a_bend() -> None:
    """Every other flight gets longer, and the speed rises with it; on either side there are numbers."""
    low, high = 12.0e-3, 12.2e-3
    for _ in range(50):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if vibro.solve(hops_at(middle)).pattern == "H" else (low, middle)
    assert speed_costs(hops_at(low))["amplitude"] == "bends here"
    for side in (1 - 1e-3, 1 + 1e-3):
        assert not isinstance(speed_costs(hops_at(low * side))["amplitude"], str)


def test_where_hops_change_to_others_speed_jumps() -> None:
    low, high = 5.41e-3, 5.62e-3
    for _ in range(40):
        x = np.array([low, 0.5 * (low + high), high])
        change = np.abs(np.diff(vibro.solve(hops_at(x, 0.2)).mean_velocity))
        low, high = x[[0, 1]] if change[0] > change[1] else x[[1, 2]]
    assert change.max() > 0.01
    assert speed_costs(hops_at(low, 0.2))["amplitude"] == "jumps here"


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
        assert all(map(math.isfinite, numbers(smooth).values()))
    costs = speed_costs(at)
    assert {costs[name] for name in ("along_amplitude", "frequency", "static_friction")} == {"jumps here"}
