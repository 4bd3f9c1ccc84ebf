"""Extremes: what is refused, and the limits in which the answer is known."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers.scenes import (
    scene_with,
)

from vibro import (
    SceneError,
    VibroError,
    arrival_time,
    critical_loads,
    simulate,
    solve,
    transitions,
)


def test_a_drive_along_a_level_trough_conveys_nothing() -> None:
    scene = scene_with(
        drive_angle=0.0,
        amplitude=np.geomspace(1e-4, 1.0, 200),
        static_friction=[[0.74], [0.74], [0.3]],
        kinetic_friction=[[0.74], [0.57], [0.1]],
    )
    cycle = solve(scene)
    assert set(cycle.pattern.flat) == {"_", "F_B_", "FB"}
    assert (cycle.displacement_per_cycle == 0.0).all()
    assert (cycle.mean_velocity == 0.0).all()
    assert (cycle.peak_velocity[cycle.pattern != "_"] > 0.0).all()


BEYOND: list[tuple[str, float, str]] = [
    ("amplitude", 1e-320, "[1e-15, 1e+06] m"),
    ("amplitude", 1e300, "[1e-15, 1e+06] m"),
    ("frequency", 5e-324, "[1e-12, 1e+12] Hz"),
    ("frequency", 1e160, "[1e-12, 1e+12] Hz"),
    ("gravity", 1e-300, "[1e-12, 1e+12] m/s^2"),
    ("gravity", 1e300, "[1e-12, 1e+12] m/s^2"),
    ("static_friction", 1.7e308, "[0, 1e+12]"),
]


@pytest.mark.parametrize(("name", "value", "allowed"), BEYOND)
def test_what_no_trough_reaches_is_refused(name: str, value: float, allowed: str) -> None:
    """Squares of all that is left are doubles."""
    with pytest.raises(SceneError) as caught:
        scene_with(**{name: value})
    (problem,) = caught.value.problems
    assert (problem.field, problem.allowed) == (name, f"in {allowed}")


def test_friction_that_is_hardly_any_is_known_or_refused() -> None:
    """Solving goes on to the ends; a walk forms products of more groups, and says that it does not know."""
    scene = scene_with(kinetic_friction=5e-324)
    time = float(arrival_time(scene, 0.6))
    assert math.isnan(time) or time > 0.0
    with pytest.raises(VibroError, match="no motion to follow: "):
        simulate(scene, cycles=1)
    assert not any(math.isinf(x) or math.isnan(x) for t in transitions(scene) for x in t[1:])
    assert not np.isnan(critical_loads(scene).hop)


def test_lengths_and_starts_at_the_ends_of_the_doubles() -> None:
    scene = scene_with()
    assert np.isfinite(arrival_time(scene, 1e9))
    for far in (1e-320, 1e300):
        with pytest.raises(SceneError, match="length = "):
            arrival_time(scene, far)
        with pytest.raises(SceneError, match="length = "):
            solve(scene).traverse_time(far)
    for start in (1e300, -1e60):
        with pytest.raises(SceneError, match="start_velocity = "):
            simulate(scene, cycles=1, start_velocity=start)
    for wanted in ({"cycles": 1e16}, {"cycles": 5e-324}, {"duration": 1e300}, {"duration": 1e-300}):
        with pytest.raises(SceneError, match="must be in "):
            simulate(scene, **wanted)
    assert simulate(scene, duration=1e-12).phases[0].kind == "_"
