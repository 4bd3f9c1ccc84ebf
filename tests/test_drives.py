"""What holds for every kind of drive: one test for lines, ellipses and harmonics; and what relates these."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from helpers.harmonics import random_harmonics
from helpers.scenes import FIELDS, assert_same, random_scenes
from helpers.two_axis_scenes import (
    FREQUENCY,
    GRAVITY,
    UNIT,
    Drives,
    displacement,
    random_drives,
    rounding,
)

from vibro import Regime, Scene, Status, solve
from vibro.drives import HarmonicMotion

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
    for slope, status in ((0.0, Status.INDETERMINATE), (1e-9, Status.RUNAWAY), (-0.1, Status.RUNAWAY)):
        without = {"static_friction": 0.0, "kinetic_friction": 0.0, "trough_angle": slope}

        def slippery(name: str, x: Any, of: dict[str, float] = without) -> Any:
            return of[name] + 0.0 * x if name in of else x

        cycle = solve(changed(drawn(30, 10), slippery), flight=False)
        assert (cycle.status[cycle.regime != Regime.HOPPING] == status).all()
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
    waves = np.sin(n * np.linspace(0.0, 2.0 * np.pi, 8_001)[:, np.newaxis] + phase[:, :, np.newaxis])
    for power, got in ((0, scene.reach), (2, scene.load * 9.81 / (2.0 * np.pi * frequency) ** 2)):
        along, normal = (n**power * size[:, :, np.newaxis] * waves).sum(axis=1)
        farthest = np.hypot(along, normal).max(axis=0)
        assert (got >= farthest * (1.0 - (1e-14 if harmonics else 1e-15))).all()
        np.testing.assert_allclose(got, farthest, rtol=1e-5 if harmonics > 1 else 1e-7)
    np.testing.assert_array_equal(scene.scale, size.max(axis=(0, 1)))


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


# --- ellipses: seen from the other end, scaled, beside lines, with growing load ------------------------

MIRRORED = {"": "", "_": "_", "F_": "B_", "B_": "F_", "F_B_": "F_B_", "FB_": "F_B", "F_B": "FB_", "FB": "FB"}


def _clear_of_boundaries(some: Drives) -> np.ndarray:
    """Whether a rounding of the inputs changes no pattern."""
    near = [some.changed(**{name: getattr(some, name) * (1.0 + h)}).scaled(1.0 + h).solve()
            for name in ("lead", "trough") for h in (-1e-11, 1e-11)]  # fmt: skip
    same = np.all([cycle.pattern == near[0].pattern for cycle in near], axis=0)
    return np.asarray(same & np.all([cycle.status == near[0].status for cycle in near], axis=0))


def _assert_mirrored(some: Drives) -> set[str]:
    """Compare both views of scenes where one motion alone is stable: one view starts half a turn later."""
    here, there = some.solve(), some.mirrored().solve()
    single = (here.coexists != 1) & (there.coexists != 1) & _clear_of_boundaries(some)
    expected = np.array([MIRRORED[text] for text in here.pattern.tolist()])
    assert there.pattern[single].tolist() == expected[single].tolist()
    assert there.status[single].tolist() == here.status[single].tolist()
    apart = np.abs(displacement(here) + displacement(there))
    assert not (apart > 16.0 * rounding(some, here))[single].any()
    moves = single & (here.peak_velocity > 0.0)
    np.testing.assert_allclose(there.peak_velocity[moves], here.peak_velocity[moves], rtol=1e-9)
    return set(here.pattern[single].tolist())


def test_a_trough_seen_from_its_other_end_conveys_as_much() -> None:
    assert _assert_mirrored(random_drives(2000, 26, steepest=0.95, least_ratio=0.1)) == set(MIRRORED)
    assert len(_assert_mirrored(random_drives(2000, 27, least_ratio=0.1))) == len(MIRRORED) - 1


def _assert_line(some: Drives) -> None:
    """Compare drives without a lead with the same ones given by amplitude and drive angle."""
    some = some.changed(lead=0.0)
    angle = np.arctan2(some.normal, some.along)
    # the cosine of an angle that is rounded near 90 deg is no longer that of the pair
    some = Drives(*(x[(angle < 1.4) & (angle + some.trough < 1.57)] for x in some))
    ellipse, clear = some.solve(), _clear_of_boundaries(some)
    line = solve(
        Scene(
            amplitude=np.hypot(some.along, some.normal) * UNIT,
            drive_angle=np.arctan2(some.normal, some.along),
            frequency=FREQUENCY,
            static_friction=some.mu_s,
            kinetic_friction=some.mu_d,
            trough_angle=some.trough,
            gravity=GRAVITY,
        )
    )
    assert_same(ellipse, line, names=["regime"])
    for name in ("pattern_code", "status", "coexists"):
        np.testing.assert_array_equal(getattr(ellipse, name)[clear], getattr(line, name)[clear], name)
    apart = np.abs(displacement(ellipse) - displacement(line))
    assert not (apart > 32.0 * rounding(some, ellipse))[clear].any()
    pushed_back = some.along > 1.001 * some.mu_s * some.normal  # else the ratio is no one's onset
    for name in ("throw_number", "forward_ratio", "back_ratio", "peak_velocity"):
        told = clear & (pushed_back | (name != "back_ratio"))
        left, right = getattr(ellipse, name)[told], getattr(line, name)[told]
        np.testing.assert_allclose(left, right, rtol=1e-9, atol=1e-300, err_msg=name)


def test_without_a_lead_drives_are_those_along_a_line() -> None:
    _assert_line(random_drives(2000, 29, steepest=0.9, least_ratio=0.1))


def test_classes_come_in_one_order_with_growing_load() -> None:
    """In ellipses and, as every other one, along lines."""
    some = random_drives(300, 22, steepest=0.35, throw=(1e-3, 1e-2))
    some = some.changed(lead=np.where(np.arange(300) % 2, some.lead, 0.0))
    factors = np.geomspace(0.3, 1.1 / some.normal.min(), 120)
    order = np.array(
        [solve(some.scaled(f).scene(), output="regimes").regime for f in factors], dtype=np.int64
    )
    assert (np.diff(order, axis=0) >= 0).all()
    assert set(np.unique(order)) >= set(Regime) - {Regime.UNDEFINED}
    exact = solve(some.scaled(factors[60]).scene(), flight=False)
    told = (exact.status == Status.OK) & (exact.regime != Regime.HOPPING)
    np.testing.assert_array_equal(exact.regime[told], order[60][told])
