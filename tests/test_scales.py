"""Scales and extremes: similarity, and the limits in which the answer is known."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import pytest
from helpers.scenes import (
    Groups,
    at_load,
    contact_groups,
    line_of,
    replaced,
    scene_with,
    solve_one,
)
from hypothesis import assume, given
from hypothesis import strategies as st

from vibro import (
    Regime,
    Scene,
    SceneError,
    Status,
    VibroError,
    arrival_time,
    critical_loads,
    simulate,
    solve,
    transitions,
)

if TYPE_CHECKING:
    from numpy.typing import NDArray


@given(contact_groups(), st.floats(0.01, 100.0))
def test_similarity(one: Groups, scale: float) -> None:
    scene = at_load(*one)
    # between these neighbours nothing happens that a rounding of A or f could reach
    near, beyond = (solve(at_load(one.load * (1.0 + h), *one[1:])) for h in (-1e-11, 1e-11))
    assume(near.status == beyond.status == Status.OK and near.pattern == beyond.pattern)
    here = solve(scene)
    similar = replaced(scene, amplitude=scene.scale / scale**2, frequency=scene.frequency * scale)
    there = solve(similar)
    assert there.pattern == here.pattern
    spread = abs(beyond.displacement_per_cycle - near.displacement_per_cycle)
    tolerance = float(spread + 1e-14 * scene.scale)
    assert float(there.displacement_per_cycle) * scale**2 == pytest.approx(
        float(here.displacement_per_cycle), abs=tolerance
    )
    assert float(there.mean_velocity) * scale == pytest.approx(
        float(here.mean_velocity), abs=tolerance * float(scene.frequency)
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


def test_a_nearly_level_drive_conveys_in_proportion_to_its_angle() -> None:
    angles = np.array([1e-3, 1e-6, 1e-9, 1e-12])
    for amplitude, pattern in ((1e-3, "F_B_"), (2e-3, "FB")):
        cycle = solve(scene_with(amplitude=amplitude, drive_angle=angles))
        assert set(cycle.pattern) == {pattern}
        slope = cycle.displacement_per_cycle / angles
        # second-order terms of the angle; then rounding, eps A / angle
        assert (np.abs(slope / slope[-2] - 1.0) < [1e-2, 1e-5, 1e-6, 2e-3]).all()


def test_without_kinetic_friction_a_slide_lasts_to_the_mirrored_phase() -> None:
    one = Groups(0.9, 20.0, 0.74, 0.0)
    cycle = solve_one(one)
    assert cycle.pattern == "F_"
    start = math.asin(1.0 / float(cycle.forward_ratio))
    # speed a (cos p0 - cos p), from p0 to 2 pi - p0
    path = 2.0 * math.cos(start) * (math.pi - start) + 2.0 * math.sin(start)
    w = 2.0 * math.pi * 15.0
    expected = one.load * math.cos(math.radians(20.0)) * path * 9.81 / w**2
    assert float(cycle.displacement_per_cycle) == pytest.approx(expected, rel=1e-14)


def test_equal_frictions_start_slipping_without_a_jump() -> None:
    onset = 1.0 / float(solve_one(Groups(1.0, 20.0, 0.5, 0.5)).forward_ratio)
    above = onset * (1.0 + np.array([1e-12, 1e-9, 1e-6]))
    equal = solve(at_load(above, 20.0, 0.5, 0.5)).displacement_per_cycle
    assert (equal > 0.0).all()
    # path ~ (length of the slide)^4 ~ (excess load)^2
    assert equal[1:] / equal[:-1] == pytest.approx(1e6, rel=1e-3)


EXTREMES = np.array([1e-12, 1e-8, 1e-4, 1.0, 1e4, 1e8, 1e12])


def spread_out(scene: Scene) -> dict[str, NDArray[np.float64]]:
    """Broadcast every field to the scene's shape."""
    fields = scene.arrays()
    return dict(zip(fields._fields, np.broadcast_arrays(*fields), strict=True))


def test_the_largest_and_smallest_numbers_pass_without_a_warning() -> None:
    # warnings are errors here
    scene = Scene(
        amplitude=np.clip(EXTREMES, 1e-15, 1e6)[:, None, None, None],
        frequency=EXTREMES[:, None, None],
        gravity=EXTREMES[:, None],
        drive_angle=[0.0, 5e-324, 1e-160, 1e-8, 0.3, 1.5, math.nextafter(math.pi / 2, 0.0)],
        static_friction=0.74,
        kinetic_friction=0.57,
    )
    cycle = solve(scene, output="regimes")
    in_contact = cycle.regime != Regime.HOPPING
    exact = solve(Scene(**{name: x[in_contact] for name, x in spread_out(scene).items()}))
    assert np.isin(exact.status, (Status.OK, Status.BOUNDARY)).all()
    assert not np.isnan(exact.displacement_per_cycle).any()
    steep = line_of(scene).drive_angle > 0.1
    load = np.log10(scene.scale) + 2.0 * np.log10(2.0 * np.pi) + 2.0 * np.log10(scene.frequency)
    load = np.broadcast_to(load - np.log10(scene.gravity), scene.shape)
    assert (cycle.regime[steep & (load > 10.0)] == Regime.HOPPING).all()
    assert (cycle.regime[load < -3.0] == Regime.NO_SLIP).all()


@pytest.mark.parametrize("mu_s", [1e-300, 1e-100, 1e-30, 1e-16, 1e-8, 1e8, 1e12])
def test_extreme_friction_passes_without_a_warning(mu_s: float) -> None:
    ratio = np.array([0.0, 1e-300, 1e-100, 1e-30, 1e-16, 1e-8, 0.5, 1.0])[:, None, None]
    angle = np.array([0.0, 1e-300, 1e-30, 1e-16, 1e-8, 0.3])[:, None]
    cycle = solve(
        scene_with(
            amplitude=[1e-6, 1e-4, 1e-3, 1e-2],
            static_friction=mu_s,
            kinetic_friction=mu_s * ratio,
            drive_angle=angle,
        )
    )
    assert (cycle.status != Status.UNRESOLVED).all()


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
