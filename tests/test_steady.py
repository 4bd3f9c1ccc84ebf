"""The public solver: statuses, shapes, scales and extremes."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from helpers.scenes import (
    FIELDS,
    Groups,
    at_load,
    random_scenes,
    replaced,
    scene_with,
    solve_one,
)

from vibro import Motion, Regime, Scene, SceneError, Status, solve, steady
from vibro.core.codes import PATTERNS, Pattern
from vibro.core.compiled import doors

# one scene of every contact pattern, in the order of their codes
ONE_OF_EACH = [
    Groups(0.50, 20.0, 0.74, 0.57),
    Groups(0.90, 20.0, 0.74, 0.57),
    Groups(0.582, 0.43, 0.752, 0.565, 10.62),
    Groups(1.10, 20.0, 0.74, 0.57),
    Groups(1.36, 20.0, 0.74, 0.57),
    Groups(0.781, 57.03, 0.27, 0.155, 3.46),
    Groups(2.00, 20.0, 0.74, 0.57),
]

# --- statuses ---------------------------------------------------------------------------------------


def test_every_status_in_one_array(monkeypatch: pytest.MonkeyPatch) -> None:
    onset = 0.74 * 9.81 / ((30.0 * math.pi) ** 2 * (math.cos(math.pi / 9) + 0.74 * math.sin(math.pi / 9)))
    # status -> amplitude, trough angle [deg], mu_s, mu_d, and whether there is a number
    cells = {
        Status.OK: (1e-3, 0.0, 0.74, 0.57, True),
        Status.BOUNDARY: (onset, 0.0, 0.74, 0.57, True),
        Status.RUNAWAY: (1e-3, -40.0, 0.74, 0.57, False),
        Status.INDETERMINATE: (1e-3, 0.0, 0.0, 0.0, False),
        Status.FLIGHT_NOT_MODELLED: (4e-3, 0.0, 0.74, 0.57, False),
        Status.INFEASIBLE: (1e-3, 0.0, 0.5, 0.57, False),
    }
    amplitude, trough, mu_s, mu_d, answered = (
        np.array(column) for column in zip(*cells.values(), strict=True)
    )
    scene = Scene.allowing_infeasible(
        amplitude=amplitude,
        frequency=15.0,
        drive_angle=math.radians(20.0),
        static_friction=mu_s,
        kinetic_friction=mu_d,
        trough_angle=np.radians(trough),
    )
    cycle = solve(scene, flight=False)
    assert [Status(s) for s in cycle.status] == list(cells)
    for name in ("displacement_per_cycle", "mean_velocity", "peak_velocity"):
        assert np.isfinite(getattr(cycle, name)).tolist() == answered.tolist()
    assert [bool(p) for p in cycle.pattern] == answered.tolist()
    assert [bool(m) for m in cycle.model] == answered.tolist()
    assert [Regime(r).label for r in cycle.regime] == [
        "forward-slip", "no-slip", "forward-slip", "", "hopping", "",
    ]  # fmt: skip
    assert len({Status(s).label for s in Status}) == len({Status(s).message for s in Status}) == len(Status)


def test_a_trough_steeper_than_kinetic_friction_can_run_away_or_not() -> None:
    # k < 0 on the way down: a slide that starts late enough still ends
    cycle = solve(at_load([0.25, 0.5, 0.9], 10.0, 0.5, 0.2, -13.0))
    assert [Status(s) for s in cycle.status] == [Status.OK, Status.RUNAWAY, Status.RUNAWAY]
    assert [Regime(r) for r in cycle.regime[1:]] == [Regime.FORWARD_SLIP] * 2


# --- patterns, models and regimes -------------------------------------------------------------------


def test_every_pattern_has_its_regime_and_its_cheapest_model() -> None:
    columns = [np.array(column) for column in zip(*ONE_OF_EACH, strict=True)]
    cycle = solve(at_load(*columns))
    assert cycle.pattern.tolist() == list(PATTERNS[1:])
    assert cycle.model.tolist() == [
        "rest", "one-slide", "one-slide", "two-slides", "two-slides", "two-slides", "closed-form",
    ]  # fmt: skip
    assert [Regime(r).label for r in cycle.regime] == ["no-slip", "forward-slip", *["back-slip"] * 5]
    assert (cycle.status == Status.OK).all()
    for i, one in enumerate(ONE_OF_EACH):
        assert solve_one(one).mean_velocity == cycle.mean_velocity[i]


def test_the_error_of_a_mean_is_that_of_the_displacement_times_the_frequency() -> None:
    """Twice the frequency at a quarter of the amplitude: the same motion, in half the time.

    A cycle's displacement and its error become a quarter, the mean speed and its error a half.
    """
    amplitude = 3.0 / math.sin(math.radians(30.0)) * 9.81 / (2.0 * math.pi * 15.0) ** 2  # K = 3
    cycle = solve(
        Scene(
            amplitude=[amplitude, amplitude / 4.0],
            frequency=[15.0, 30.0],
            drive_angle=math.radians(30.0),
            static_friction=0.5,
            kinetic_friction=0.4,
            restitution=0.7,
        )
    )
    assert [Status(s) for s in cycle.status] == [Status.AVERAGED] * 2
    slow, fast = cycle.mean_velocity_error
    assert slow > 0.0
    assert fast == 0.5 * slow


# --- shapes -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("shape", [(0,), (3, 0), (0, 4)])
def test_an_empty_scene_gives_empty_arrays(shape: tuple[int, ...]) -> None:
    cycle = solve(scene_with(amplitude=np.empty(shape)))
    for name in FIELDS:
        assert getattr(cycle, name).shape == shape
    assert cycle.pattern.shape == cycle.traverse_time(1.0).shape == shape


@pytest.mark.usefixtures("two_cores")
@pytest.mark.parametrize(
    "shape", [(131_071,), (131_072,), (131_073,), (300_001,), (2, 131_073), (70_001, 3), (7, 1, 40_009)]
)
def test_blocks_leave_no_seam(shape: tuple[int, ...]) -> None:
    size = math.prod(shape)
    few = random_scenes(997, seed=4, most_trough_deg=10.0)
    expected = solve(few)
    order = np.arange(size) % 997
    grid = Scene(
        **{name: x if x.ndim == 0 else x[order].reshape(shape) for name, x in few.arrays()._asdict().items()}
    )
    got = solve(grid)
    for name in FIELDS:
        assert np.array_equal(
            getattr(got, name).reshape(-1), getattr(expected, name)[order], equal_nan=True
        ), name


@pytest.mark.usefixtures("two_cores")
def test_parts_that_hop_leave_no_seam(monkeypatch: pytest.MonkeyPatch) -> None:
    # cycles of few flights and of many, and means
    scene = scene_with(amplitude=np.linspace(3.5e-3, 9e-3, 29), restitution=[[0.0], [0.3]])
    whole = solve(scene)
    assert (whole.regime == Regime.HOPPING).all()
    assert 5 < (whole.status == Status.AVERAGED).sum() < 50
    monkeypatch.setattr(steady, "_HOPPING", 10)
    parts = solve(scene)
    for name in FIELDS:
        assert np.array_equal(getattr(parts, name), getattr(whole, name), equal_nan=True), name


# --- traverse time ----------------------------------------------------------------------------------


def test_traverse_time_is_the_length_over_the_mean_speed() -> None:
    # at rest, forward, backward, and down a trough that no body stops on
    trough = np.radians([0.0, 0.0, 20.0, -40.0])
    cycle = solve(scene_with(amplitude=[0.5e-3, 1e-3, 1e-3, 1e-3], trough_angle=trough))
    assert cycle.mean_velocity[2] < 0.0
    time = cycle.traverse_time(0.6)
    assert time[1] == 0.6 / cycle.mean_velocity[1]
    assert time[[0, 2]].tolist() == [np.inf, np.inf]
    assert np.isnan(time[3])


@pytest.mark.parametrize("length", [0.0, -0.6, np.nan, np.inf])
def test_a_trough_without_length_has_no_traverse_time(length: float) -> None:
    with pytest.raises(SceneError) as caught:
        solve(scene_with()).traverse_time([0.6, length])
    assert [problem.field for problem in caught.value.problems] == ["length"]


def test_traverse_time_broadcasts_lengths_against_the_scene() -> None:
    cycle = solve(scene_with(amplitude=[0.9e-3, 1e-3]))
    time = cycle.traverse_time(np.array([[0.1], [0.2], [0.4]]))
    assert time.shape == (3, 2)
    assert time[2].tolist() == (4.0 * time[0]).tolist()
    assert np.ndim(solve(scene_with()).traverse_time(1.0)) == 0


@pytest.mark.usefixtures("two_cores")
@pytest.mark.parametrize("door", ["solve_contact", "solve_hops", "share_starts"])
@pytest.mark.parametrize("failing", [0, 20])
def test_an_error_in_any_range_reaches_the_caller(
    door: str, failing: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = getattr(doors(), door)

    def fail_there(*values: Any) -> None:
        begin, end = values[3:5] if door == "solve_contact" else values[-2:]
        if begin <= failing < end:
            raise IndexError(failing)
        run(*values)

    for name in ("_IN_CONTACT", "_HOPPING", "_SURVEYED"):
        monkeypatch.setattr(steady, name, 4)
    monkeypatch.setattr(doors(), door, fail_there, raising=False)
    scene = scene_with(amplitude=np.linspace(4e-3, 4.1e-3, 40))
    with pytest.raises(IndexError, match=str(failing)):
        solve(scene, starts=16)


# --- how the displacement follows the load ---------------------------------------------------------

FRICTION = {"static_friction": 0.4, "kinetic_friction": 0.3}


def test_of_one_harmonic_they_are_the_closed_form() -> None:
    """Wherever the difference is kept; it is left out next to onsets and changes of the pattern alone."""
    x, y = 1e-3, np.array([2e-4, 3e-4])[:, np.newaxis]
    frequency, phase = np.linspace(10.0, 25.0, 400), np.radians(-60.0)
    ellipse = Scene(
        along_amplitude=x, normal_amplitude=y, normal_phase=phase, frequency=frequency, **FRICTION
    )
    same = Scene(along_harmonics=[(x, 0.0)], normal_harmonics=[(y, phase)], frequency=frequency, **FRICTION)
    cycle = solve(ellipse, flight=False)
    found = steady.scale_slope(same, solve(same, flight=False))
    with np.errstate(divide="ignore", invalid="ignore"):
        # the unit of length grows with the motion: one more power of it
        expected = 1.0 + steady.load_slope(ellipse, cycle.pattern_code) / (
            cycle.displacement_per_cycle / ellipse.scale
        )
    known = np.isfinite(found)
    moves = np.isfinite(expected) & (cycle.displacement_per_cycle != 0.0)
    assert not known[~moves].any()
    assert known[moves].mean() > 0.95
    error = np.abs(found - expected)[known] / (1.0 + np.abs(expected[known]))
    assert error.max() < 1e-6
    assert np.median(error) < 1e-10


def test_of_steps_they_follow_the_speed() -> None:
    motion = Motion.steps([(0.8, 3.5), (0.2, -14.0)])
    scene = Scene(motion=motion, frequency=5.0, **FRICTION)
    slope = float(steady.scale_slope(scene, solve(scene)))
    up, down = (
        float(solve(Scene(motion=motion, motion_scale=c, frequency=5.0, **FRICTION)).mean_velocity)
        for c in (1.01, 1.0 / 1.01)
    )
    assert slope == pytest.approx(math.log(up / down) / (2.0 * math.log(1.01)), rel=1e-4)


@pytest.mark.parametrize("scale", [0.1, 3.924 / 14.0 * (1.0 + 1e-5), 100.0], ids=["rest", "onset", "hops"])
def test_there_are_none_at_rest_beside_an_onset_and_in_flight(scale: float) -> None:
    normal = [(0.5, 2.0), (0.5, -2.0)] if scale > 50.0 else None
    motion = Motion.steps([(0.8, 3.5), (0.2, -14.0)], normal)
    scene = Scene(motion=motion, motion_scale=scale, frequency=5.0, **FRICTION)
    assert np.isnan(steady.scale_slope(scene, solve(scene)))


def test_the_slope_is_0_at_rest_and_nan_without_a_cycle() -> None:
    scene = at_load(np.array([[0.1], [1.0], [9.0]]), np.array([20.0, 15.0]), 0.74, 0.57)
    pattern = np.array([[Pattern.R] * 2, [Pattern.F_] * 2, [Pattern.NONE] * 2])
    slope, slides = steady.load_slope(scene, pattern), steady.slides_of(scene, pattern)
    np.testing.assert_array_equal(slope == 0.0, pattern == Pattern.R)
    np.testing.assert_array_equal(np.isnan(slope), pattern == Pattern.NONE)
    assert slides.way.tolist() == [[[0, 0], [1, 1], [0, 0]], [[0, 0]] * 3]
    assert slides.begin.shape == (2, 3, 2)
    runs_away = scene_with(trough_angle=-math.radians(35.0), static_friction=0.74, kinetic_friction=0.01)
    assert np.isnan(steady.load_slope(runs_away, np.array(Pattern.F_B_)))


# Sign of the change of the displacement of each pattern with each input, theory, section 13; 0: either.
SIGNS = {  # mu_s, mu_d, A, f, beta
    "F_": (-1, -1, 1, 1, -1),
    "B_": (1, 1, -1, -1, -1),
    "F_B_": (0, 0, 0, 0, -1),
    "FB_": (-1, 0, 1, 1, -1),
    "F_B": (1, 1, 0, 0, -1),
    "FB": (0, 0, 0, 0, -1),
}
MOVED = ("static_friction", "kinetic_friction", "amplitude", "frequency", "trough_angle")


def test_signs_of_the_change_with_each_input() -> None:
    random, count, step = np.random.default_rng(21), 20_000, 1e-5
    mu_s = np.exp(random.uniform(np.log(0.05), np.log(1.5), count))
    mu_d = mu_s * np.exp(random.uniform(np.log(0.02), -1e-3, count))
    trough = random.uniform(-1.0, 1.0, count) * np.minimum(40.0, 0.98 * np.degrees(np.arctan(mu_s)))
    load = np.exp(random.uniform(np.log(0.05), np.log(20.0), count))
    scene = at_load(load, random.uniform(0.5, np.minimum(80.0, 85.0 - trough)), mu_s, mu_d, trough)
    gentle = mu_s * np.tan(np.abs(np.radians(trough))) < 1.0  # what is known of beta
    pattern = solve(scene, flight=False).pattern_code
    for i, name in enumerate(MOVED):
        value = getattr(scene, name)
        by = step * (1.0 if name == "trough_angle" else value)
        less, more = (solve(replaced(scene, **{name: value + way * by}), flight=False) for way in (-1, 1))
        same = (less.pattern_code == pattern) & (more.pattern_code == pattern)
        if name == "trough_angle":
            same &= gentle
        rise = more.mean_velocity - less.mean_velocity
        noise = 1e-11 * (np.abs(more.mean_velocity) + scene.scale * scene.frequency)
        for text, signs in SIGNS.items():
            cells = same & (pattern == PATTERNS.index(text))
            assert cells.sum() > 20, (name, text)
            if signs[i]:
                assert (signs[i] * rise > -noise)[cells].all(), (name, text)
