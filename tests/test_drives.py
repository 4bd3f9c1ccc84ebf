"""What holds for every kind of drive, along a line, along an ellipse and with harmonics: one test of each."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from helpers.harmonics import random_harmonics
from helpers.scenes import FIELDS, assert_same, random_scenes
from helpers.two_axis_scenes import random_drives

from vibro import Regime, Scene, Status, solve
from vibro.waveforms import HarmonicMotion

if TYPE_CHECKING:
    from collections.abc import Callable

RANDOM: dict[str, Callable[[int, int], Scene]] = {
    "line": lambda count, seed: random_scenes(count, seed, most_trough_deg=12.0, least_ratio=0.1),
    "ellipse": lambda count, seed: random_drives(count, seed, steepest=0.9, least_ratio=0.1).scene(),
    "harmonics": lambda count, seed: random_harmonics(count, seed, ratio=(0.1, 1.0), load=(0.1, 3.0)),
}
"""Draw so many scenes with a seed."""

MOVES = (("displacement_per_cycle", 2), ("mean_velocity", 1), ("peak_velocity", 1))
"""Results, and the powers of a scale of time that they change with where lengths change with its square."""


@pytest.fixture(params=RANDOM)
def drawn(request: pytest.FixtureRequest) -> Callable[[int, int], Scene]:
    return RANDOM[request.param]


def changed(scene: Scene, change: Callable[[str, Any], Any]) -> Scene:
    """Change the fields of scenes; those of harmonics one by one, as an amplitude and a phase."""
    values: dict[str, Any] = {}
    for name in (f.name for f in dataclasses.fields(Scene)):
        x = getattr(scene, name)
        if isinstance(x, HarmonicMotion):
            for of, pairs in (("along_harmonics", x.along), ("normal_harmonics", x.normal)):
                values[of] = [(change("amplitude", size), change("phase", phase)) for size, phase in pairs]
        elif x is not None:
            values[name] = change(name, x)
    return Scene(**values)


def similar(scene: Scene, scale: float) -> Scene:
    """Make scenes with the same loads, whose motion takes a scale of time less."""

    def scaled(name: str, x: Any) -> Any:
        return x / scale**2 if "amplitude" in name else x * scale if name == "frequency" else x

    return changed(scene, scaled)


@pytest.mark.parametrize("scale", [0.25, 2.0, 1024.0])
def test_similar_scenes_move_alike_to_the_last_bit(drawn: Callable[[int, int], Scene], scale: float) -> None:
    scene = drawn(2000, 8)
    here, there = solve(scene), solve(similar(scene, scale))
    names = ["regime", "status", "pattern_code", "throw_number", "coexists", "period_cycles"]
    assert_same(here, there, names=names)
    assert len(np.unique(here.pattern)) >= 7
    for name, power in MOVES:
        moved = getattr(there, name) * scale**power
        assert np.array_equal(getattr(here, name), moved, equal_nan=True), name


def assert_each_alone(scene: Scene, names: list[str]) -> None:
    """Compare the answer to several scenes with those to each of them."""
    several = solve(scene)
    for i in range(scene.shape[0]):

        def at(_: str, x: Any, i: int = i) -> Any:
            return x[i] if x.ndim else x

        one = solve(changed(scene, at))
        assert one.regime.shape == ()
        for name in names:
            left, right = getattr(one, name), getattr(several, name)[i]
            assert np.array_equal(left, right, equal_nan=np.asarray(left).dtype.kind == "f"), name


def test_scenes_of_a_grid_are_solved_as_each_alone(drawn: Callable[[int, int], Scene]) -> None:
    assert_each_alone(drawn(60, 9), FIELDS)


def test_hopping_scenes_of_a_grid_are_solved_as_each_alone() -> None:
    scene = random_drives(40, 30, steepest=0.9, throw=(0.05, 1.6)).scene()
    assert_each_alone(scene, [name for name in FIELDS if name != "mean_velocity_error"])


def test_regimes_alone_are_those_of_the_whole_solution(drawn: Callable[[int, int], Scene]) -> None:
    scene = drawn(20_000, 6)
    whole, classes = solve(scene, flight=False), solve(scene, output="regimes")
    assert_same(whole, classes, names=["regime", "throw_number", "forward_ratio", "back_ratio"])
    known = classes.regime != Regime.HOPPING
    assert np.array_equal(whole.status[known], classes.status[known])
    rests = whole.pattern == "_"
    slips = (whole.pattern != "") & ~rests
    assert rests.sum() > 500
    for name, _ in MOVES:
        all_of, some_of = getattr(whole, name), getattr(classes, name)
        assert (some_of[rests] == 0.0).all()
        left_out = np.isnan(some_of)
        assert (left_out & slips).sum() > 5000
        # where the class itself takes a slide, on a trough steeper than kinetic friction, the answer stays
        assert np.array_equal(some_of[~left_out], all_of[~left_out])
    assert set(classes.model[slips & np.isnan(classes.mean_velocity)]) == {""}
    assert set(classes.coexists[slips & np.isnan(classes.mean_velocity)]) == {-1}


def test_without_static_friction_the_motion_depends_on_its_start(drawn: Callable[[int, int], Scene]) -> None:
    def slippery(name: str, x: Any) -> Any:
        return 0.0 * x if name in ("static_friction", "kinetic_friction", "trough_angle") else x

    cycle = solve(changed(drawn(30, 10), slippery), flight=False)
    assert (cycle.status[cycle.regime != Regime.HOPPING] == Status.INDETERMINATE).all()
    assert np.count_nonzero(cycle.regime != Regime.HOPPING) > 15
    assert np.isnan(cycle.mean_velocity).all()


@pytest.mark.parametrize("harmonics", [0, 1, 2, 3, 8])
def test_the_load_is_the_largest_acceleration_and_the_reach_the_farthest_point(harmonics: int) -> None:
    """Without harmonics it is an ellipse."""
    random = np.random.default_rng(harmonics)
    n = np.arange(1, max(harmonics, 1) + 1)[:, np.newaxis, np.newaxis]
    size, phase = random.uniform(0.0, 2e-3, (2, n.size, 60)), random.uniform(-7.0, 7.0, (2, n.size, 60))
    size /= n[:, 0] ** 2  # so that all count in the acceleration
    frequency = random.uniform(5.0, 60.0, 60)
    if harmonics:
        along, normal = (list(zip(*part, strict=True)) for part in zip(size, phase, strict=True))
        drive: dict[str, Any] = {"along_harmonics": along, "normal_harmonics": normal}
    else:
        phase[0] = 0.0
        (x,), (y,) = size
        drive = {"along_amplitude": x, "normal_amplitude": y, "normal_phase": phase[1, 0]}
    scene = Scene(frequency=frequency, static_friction=0.4, kinetic_friction=0.3, **drive)
    waves = np.sin(n * np.linspace(0.0, 2.0 * np.pi, 20_001)[:, np.newaxis] + phase[:, :, np.newaxis])
    for power, got in ((0, scene.reach), (2, scene.load * 9.81 / (2.0 * np.pi * frequency) ** 2)):
        along, normal = (n**power * size[:, :, np.newaxis] * waves).sum(axis=1)
        farthest = np.hypot(along, normal).max(axis=0)
        assert (got >= farthest * (1.0 - (1e-14 if harmonics else 1e-15))).all()
        np.testing.assert_allclose(got, farthest, rtol=1e-5 if harmonics > 1 else 1e-7)
    np.testing.assert_array_equal(scene.scale, size.max(axis=(0, 1)))


def test_many_paths_are_measured_as_each_alone() -> None:
    """More than are searched at a time, of a shape that amplitudes and phases give together; and none."""
    random = np.random.default_rng(5)
    size, phase = random.uniform(0.1e-3, 1e-3, (3, 40, 1)), random.uniform(-4.0, 4.0, (3, 30))
    common = {"frequency": 20.0, "static_friction": 0.4, "kinetic_friction": 0.3}
    scene = Scene(along_harmonics=list(zip(size, phase, strict=True)), **common)
    assert scene.shape == (40, 30)
    for i, j in ((0, 0), (11, 11), (20, 7), (39, 29)):
        one = Scene(along_harmonics=list(zip(size[:, i, 0], phase[:, j], strict=True)), **common)
        assert (float(one.load), float(one.reach)) == (scene.load[i, j], scene.reach[i, j])
    none = Scene(along_harmonics=list(zip(size[:, :0], phase, strict=True)), **common)
    assert none.load.shape == none.reach.shape == (0, 30)


@pytest.mark.parametrize(
    "drive",
    [
        {"along_amplitude": 0.0, "normal_amplitude": 0.0, "normal_phase": -1.0},
        {"along_harmonics": [(0.0, 0.0), (0.0, 1.0)]},
    ],
    ids=["ellipse", "harmonics"],
)
def test_a_trough_that_stands_still_has_no_load(drive: dict[str, Any]) -> None:
    scene = Scene(frequency=10.0, static_friction=0.4, kinetic_friction=0.3, **drive)
    assert [float(scene.load), float(scene.reach), float(scene.scale)] == [0.0, 0.0, 1.0]
    assert solve(scene).pattern == "_"
