"""Optimal settings: beaten by no grid of settings, true to their word, with margins that hold just so."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import pytest
from helpers.boxed import ROWS, question_of

from vibro import Regime, Scene, solve
from vibro.drives import Line
from vibro.inverse.exchange import MOST_MARGIN
from vibro.inverse.guarantees import guarantee_of
from vibro.inverse.lines import LineOptimiser
from vibro.inverse.questions import Question
from vibro.inverse.spaces import Setting
from vibro.inverse.specs import Drift, Drive, Goal, Spec

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.inverse.exchange import Optimum

    Floats = NDArray[np.float64]

IDS = ("fastest-01", "fastest-02", "fastest-05", "fastest-27")
FRICTIONS = 5  # of each kind in a grid


def row_question(name: str, **drift: float) -> Question:
    (row,) = (row for row in ROWS if row["id"] == name)
    question = question_of(row)
    return replace(question, spec=replace(question.spec, drift=Drift(**drift)))


class Grid(NamedTuple):
    """Settings of a drive, each with the least speed of some bodies; -inf where one exceeds the regime."""

    setting: Setting
    load: Floats
    speed: Floats


def grid_of(question: Question, count: int) -> Grid:
    """Solve settings at random, a third of them at the limits of the drive, with frictions on a grid.

    Bodies are taken from the middle of the drifts: others are left out, so that a grid promises too much.
    """
    rng = np.random.default_rng(0)
    drive, bands = question.drive, question.spec.bands
    angle, frequency = (rng.uniform(*drive.span(knob), count) for knob in ("drive_angle", "frequency"))
    weight = np.minimum(drive.acceleration, 1.0 / np.sin(angle)) * question.spec.gravity  # hop, level
    most = np.minimum(drive.span("amplitude")[1], weight / (2.0 * np.pi * frequency) ** 2)
    amplitude = most * np.where(rng.random(count) < 0.3, 1.0, rng.random(count))
    mu_s, second = (
        x.ravel()
        for x in np.meshgrid(
            np.linspace(*bands["static_friction"], FRICTIONS),
            np.linspace(
                *bands["friction_ratio" if "friction_ratio" in bands else "kinetic_friction"], FRICTIONS
            ),
        )
    )
    mu_d = second * mu_s if "friction_ratio" in bands else np.minimum(second, mu_s)
    turned = {"amplitude": amplitude, "frequency": frequency, "drive_angle": angle}
    setting = question.space.setting(**turned)
    cycle = solve(
        Scene(
            **{name: values[:, None] for name, values in turned.items()},
            static_friction=mu_s,
            kinetic_friction=mu_d,
            trough_angle=bands["trough_angle"][0],
        ),
        flight=False,
    )
    allowed = np.all(np.asarray(cycle.regime) <= question.highest, axis=1)
    speed = np.where(allowed, np.asarray(cycle.mean_velocity).min(axis=1), -np.inf)
    return Grid(setting, question.load(setting), speed)


def one(setting: Setting, index: int) -> Setting:
    return Setting(*(float(x[index]) for x in setting))


def guaranteed(question: Question, setting: Setting, scale: float = 1.0) -> float:
    """Guarantee of a setting; -inf where a body exceeds the regime."""
    found = guarantee_of(question.box(setting, scale))
    return found.speed_min if max(found.regimes) <= question.highest else -math.inf


def assert_allowed(question: Question, found: Optimum) -> None:
    """A setting is within the limits of its drive, and does what is said of it."""
    drive, setting = question.drive, found.setting
    for knob, value in question.space.turned(setting).items():
        assert any(low * (1 - 1e-12) <= value <= high * (1 + 1e-12) for low, high in drive.choices[knob])
    assert question.load(setting) <= drive.acceleration * (1 + 1e-12)
    assert guaranteed(question, setting) == pytest.approx(found.speed, rel=1e-6)


@pytest.mark.parametrize("name", IDS)
def test_no_setting_is_faster(name: str) -> None:
    question = row_question(name)
    found = LineOptimiser(question).fastest()
    assert found is not None
    assert_allowed(question, found)
    grid = grid_of(question, 8000)
    better = np.flatnonzero(grid.speed > found.speed * (1 + 1e-6))
    for index in better[np.argsort(-grid.speed[better])][:3]:  # of few frictions, which may promise too much
        assert guaranteed(question, one(grid.setting, index)) <= found.speed * (1 + 1e-6)
    assert better.size < 0.002 * grid.speed.size
    assert np.max(grid.speed) > 0.8 * found.speed  # the grid comes close


@pytest.mark.parametrize("name", IDS[2:])
def test_no_setting_is_gentler(name: str) -> None:
    question = row_question(name)
    fastest = LineOptimiser(question).fastest()
    assert fastest is not None
    target = 0.7 * fastest.speed
    found = LineOptimiser(question).least_acceleration(target)
    assert found is not None
    assert_allowed(question, found)
    assert found.speed >= target * (1 - 1e-12)
    load = float(question.load(found.setting))
    grid = grid_of(question, 6000)
    enough = np.flatnonzero(grid.speed >= target)
    better = enough[grid.load[enough] < load * (1 - 1e-6)]
    for index in better[np.argsort(grid.load[better])][:3]:
        assert guaranteed(question, one(grid.setting, index)) < target
    assert better.size < 0.002 * grid.speed.size
    assert np.min(grid.load[enough]) < 1.2 * load  # the grid comes close


@pytest.mark.parametrize(
    ("name", "drifts"), [("fastest-01", False), ("fastest-05", True), ("fastest-27", False)]
)
def test_no_setting_is_safer(name: str, drifts: bool) -> None:
    question = row_question(name, **({"amplitude": 0.01, "drive_angle": math.radians(0.5)} if drifts else {}))
    optimiser = LineOptimiser(question)
    fastest = optimiser.fastest()
    assert fastest is not None
    target = 0.7 * fastest.speed
    found = optimiser.safest(target)
    assert found is not None
    margin = optimiser.margin(found.setting, target)
    assert margin is not None
    assert 1.0 <= margin <= MOST_MARGIN
    assert guaranteed(question, found.setting, 1 + (margin - 1) * (1 - 1e-5)) >= target * (1 - 1e-9)
    if margin < MOST_MARGIN:
        assert guaranteed(question, found.setting, margin * (1 + 1e-5)) < target
    grid = grid_of(question, 4000)
    enough = np.flatnonzero(grid.speed >= target)
    assert enough.size
    for index in enough[:: max(enough.size // 10, 1)]:
        other = optimiser.margin(one(grid.setting, index), target)
        assert other is None or other <= margin * (1 + 1e-4)


def test_a_margin_is_of_the_setting_alone() -> None:
    question = row_question("fastest-05")
    optimiser = LineOptimiser(question)
    fastest = optimiser.fastest()
    assert fastest is not None
    assert optimiser.margin(fastest.setting, fastest.speed * (1 - 1e-9)) == pytest.approx(1.0, abs=1e-6)
    assert optimiser.margin(fastest.setting, 10 * fastest.speed) is None
    without = replace(
        question, spec=replace(question.spec, bands={k: (b[1],) * 2 for k, b in question.spec.bands.items()})
    )
    best = LineOptimiser(without).fastest()
    assert LineOptimiser(without).safest(1e-3) == best
    assert LineOptimiser(without).safest(10.0) is None


def test_what_cannot_be_is_told() -> None:
    question = row_question("fastest-02")
    optimiser = LineOptimiser(question)
    assert optimiser.least_acceleration(0.08) is None
    assert optimiser.safest(0.08) is None
    tiny = replace(
        question,
        drive=replace(question.drive, choices={**question.drive.choices, "amplitude": ((0.0, 1e-6),)}),
    )
    assert LineOptimiser(tiny).fastest() is None


def test_a_slowest_body_that_moves_along_a_jump_is_not_lost() -> None:
    """At the optimum the slowest static friction is where back slip begins, which depends on the setting."""
    bands = {
        "static_friction": (0.69, 1.0),
        "friction_ratio": (0.45, 0.5),
        "trough_angle": (math.radians(-6.7),) * 2,
    }
    angles = math.radians(15), math.radians(57)
    choices = {"amplitude": ((0.0, 0.85e-3),), "frequency": ((10.0, 25.5),), "drive_angle": (angles,)}
    drive = Drive("drive", Line, choices)
    question = Question(Spec(bands, (drive,), Goal(0.02, Regime.BACK_SLIP)), drive, Regime.BACK_SLIP)
    found = LineOptimiser(question).fastest()
    assert found is not None
    assert_allowed(question, found)


@pytest.mark.parametrize("name", IDS)
@pytest.mark.parametrize("share", [0.3, 0.7, 0.95])
def test_loads_near_those_of_neighbours_are_those_of_all_loads(name: str, share: float) -> None:
    """Also where no neighbour reaches the speed, or one reaches it past a jump only."""
    question = row_question(name)
    optimiser = LineOptimiser(question)
    fastest = optimiser.fastest()
    assert fastest is not None
    target, choice = share * fastest.speed, optimiser._ranges[0]
    low, high = choice.drive_angle
    known, between = np.linspace(low, high, 17), np.linspace(low, high, 34)[1:-1]
    loads = optimiser._first_load(known, target, choice)
    found = optimiser._first_loads(between, target, choice, known, loads)
    every = optimiser._first_load(between, target, choice)
    np.testing.assert_array_equal(np.isfinite(found), np.isfinite(every))
    np.testing.assert_allclose(found[np.isfinite(every)], every[np.isfinite(every)], rtol=1e-9)


def test_a_load_below_those_of_both_neighbours_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    question = row_question(IDS[2])
    optimiser = LineOptimiser(question)
    choice = optimiser._ranges[0]
    asked: list[bool] = []

    def first(angles: Floats, target: float, choice: object, window: object = None) -> Floats:
        asked.append(window is not None)
        low = np.full(angles.size, 0.2)
        return low if window is None else np.asarray(window)[0]  # reached at the lower end already

    monkeypatch.setattr(optimiser, "_first_load", first)
    angles = np.array([0.3])
    found = optimiser._first_loads(angles, 0.01, choice, np.array([0.2, 0.4]), np.array([0.5, 0.6]))
    assert found.tolist() == [0.2]
    assert asked == [True, False]


def test_the_gentlest_setting_beside_a_jump_over_the_drive_angle_is_found() -> None:
    """The speed is reached on a narrow peak of loads, at angles just above one at which it is not."""
    bands = {
        "static_friction": (0.398919,) * 2,
        "friction_ratio": (0.664022,) * 2,
        "trough_angle": (math.radians(0.851246), math.radians(0.996247)),
    }
    choices = {
        "amplitude": ((0.0, 0.21257e-3),),
        "frequency": ((58.1994,) * 2,),
        "drive_angle": ((math.radians(28.5226), math.radians(58.817)),),
    }
    drive = Drive("drive", Line, choices, acceleration=1.44403)
    drift = Drift(amplitude=0.0205392, drive_angle=math.radians(0.967289))
    spec = Spec(bands, (drive,), Goal(4.72476e-3, Regime.BACK_SLIP), drift)
    found = LineOptimiser(Question(spec, drive, Regime.BACK_SLIP)).least_acceleration(4.72476e-3)
    assert found is not None
    load = float(Question(spec, drive, Regime.BACK_SLIP).load(found.setting))
    assert load <= 0.736003376 * (1 + 1e-9)  # a setting that another search has found
