"""Optimal settings of lines and ellipses: no grid beats them, they keep their word, margins hold just so."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import pytest
from helpers.boxed import ROWS, question_of
from helpers.questions import LOOSE, UNIT, asked, one_drive

import vibro
from vibro import Regime, Scene, solve
from vibro.designs.guarantees import guarantee_of
from vibro.designs.optima import MOST_MARGIN, EllipseOptimiser, LineOptimiser, Optimum
from vibro.designs.questions import Drift, Drive, Goal, Question, Spec
from vibro.designs.reading import read_spec
from vibro.designs.spaces import Setting
from vibro.drives import Line

if TYPE_CHECKING:
    from numpy.typing import NDArray

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
    """Speed of the slowest body of a setting; -inf where a body exceeds the regime."""
    found = guarantee_of(question.box(setting, scale))
    return found.found_min if max(found.regimes) <= question.highest else -math.inf


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
    grid = grid_of(question, 4000)
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
    grid = grid_of(question, 3000)
    enough = np.flatnonzero(grid.speed >= target)
    better = enough[grid.load[enough] < load * (1 - 1e-6)]
    for index in better[np.argsort(grid.load[better])][:3]:
        assert guaranteed(question, one(grid.setting, index)) < target
    assert better.size < 0.002 * grid.speed.size
    assert np.min(grid.load[enough]) < 1.2 * load  # the grid comes close


@pytest.mark.parametrize(("name", "drifts"), [("fastest-05", True)])
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
    for index in enough[:: max(enough.size // 6, 1)]:
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


# ------------------------------------------------------------------------------------------ ellipses

FREQUENCY, FRICTION = 25.0, 0.3
BOWL = Path(__file__).parents[2] / "examples" / "design_bowl.toml"
# Phase [deg] and gain over none by X w^2 / (mu_d g), at K = 0.2, 0.5, 0.8 and 1; mu_s = mu_d, level.
BEST = {
    1.5: [(0.0, 1.00), (0.0, 1.00), (0.0, 1.00), (0.0, 1.00)],
    2.0: [(-6.8, 1.01), (-5.7, 1.00), (-1.7, 1.00), (0.0, 1.00)],
    3.0: [(-42.3, 1.36), (-31.7, 1.22), (-17.1, 1.09), (-12.6, 1.03)],
    5.0: [(-62.9, 2.23), (-57.0, 1.98), (-47.1, 1.71), (-39.7, 1.56)],
    8.0: [(-73.3, 3.54), (-69.8, 3.16), (-63.4, 2.72), (-58.0, 2.46)],
    20.0: [(-83.4, 8.83), (-82.0, 7.89), (-79.4, 6.78), (-77.0, 6.11)],
}
THROWS = (0.2, 0.5, 0.8, 1.0)


def best_phase(load: float, throw: float) -> tuple[float, float, float]:
    """Return the best phase [deg] of a pair of amplitudes, its gain over none, and its range within 95 %."""
    amplitudes = 1e3 * load * FRICTION * UNIT, 1e3 * throw * (1.0 - 1e-12) * UNIT
    drive = {
        "along_amplitude_mm": amplitudes[0],
        "normal_amplitude_mm": amplitudes[1],
        "normal_phase_deg": "-180:180",
        "frequency_hz": FREQUENCY,
    }
    question = asked(one_drive({"static_friction": FRICTION, "friction_ratio": 1}, drive))
    best = EllipseOptimiser(question).fastest()
    assert best is not None
    phases = np.radians(np.linspace(-180.0, 180.0, 3601))
    around = Setting(best.setting.along_amplitude, best.setting.normal_amplitude, phases, FREQUENCY)
    speed = vibro.solve(question.nominal_scene(around), flight=False).mean_velocity
    assert best.speed >= speed.max() * (1 - 1e-12)
    return (
        math.degrees(best.setting.normal_phase),
        best.speed / speed[1800],
        0.1 * np.sum(speed > 0.95 * best.speed),
    )


@pytest.mark.parametrize("load", list(BEST))
def test_the_table_of_best_phases(load: float) -> None:
    for throw, (phase, gain) in zip(THROWS, BEST[load], strict=True):
        found, gained, width = best_phase(load, throw)
        assert found == pytest.approx(phase, abs=0.05 + 1e-3)
        assert gained == pytest.approx(gain, abs=5e-3 + 1e-4)
        if load >= 5.0:
            assert 36.0 <= width <= 50.0


@pytest.mark.parametrize("load", [4.0, 6.0, 10.0, 20.0, 40.0])
def test_the_best_phase_of_small_throws_in_closed_form(load: float) -> None:
    found, _, _ = best_phase(load, 1e-4)
    ahead = math.asin(0.5 * math.pi / load) + math.atan(
        2.0 / (math.pi * math.sqrt(load**2 - 0.25 * math.pi**2))
    )
    assert found == pytest.approx(-90.0 + math.degrees(ahead), abs=0.01)


def test_no_ellipse_is_faster_or_gentler() -> None:
    question = asked(LOOSE)
    optimiser = EllipseOptimiser(question)
    fastest = optimiser.fastest()
    assert fastest is not None
    setting = fastest.setting
    assert question.load(setting) <= 1.5
    guarantee = guarantee_of(question.box(setting))
    assert max(guarantee.regimes) <= Regime.BACK_SLIP
    assert guarantee.found_min == pytest.approx(fastest.speed, rel=1e-6)
    target = 0.7 * fastest.speed
    gentlest = optimiser.least_acceleration(target)
    assert gentlest is not None
    assert gentlest.speed >= target
    rng = np.random.default_rng(1)
    knobs = ("along_amplitude", "normal_amplitude", "normal_phase")
    along, normal, phase = (rng.uniform(*question.drive.span(knob), 8000) for knob in knobs)
    drawn = Setting(along, normal, phase, np.full(8000, 25.0))
    allowed = question.load(drawn) <= 1.5
    drawn = Setting(*(x[allowed] for x in drawn))
    speed = optimiser.least(drawn, 1.0)
    assert speed.max() <= fastest.speed * (1 + 1e-6)
    assert speed.max() >= 0.85 * fastest.speed  # the sample comes close
    load = question.load(drawn)[speed >= target]
    assert load.size > 5
    assert load.min() >= float(question.load(gentlest.setting)) * (1 - 1e-6)


def test_the_numbers_of_the_documentation_about_the_bowl() -> None:
    spec = read_spec(BOWL)
    found = []
    for drive in spec.drives:
        question = Question(spec, drive, Regime.BACK_SLIP)
        best = EllipseOptimiser(question).fastest()
        assert best is not None
        nominal = vibro.solve(question.nominal_scene(best.setting)).mean_velocity
        found.append((1e3 * best.speed, 1e3 * float(nominal), math.degrees(best.setting.normal_phase)))
    assert found[0] == pytest.approx((0.553467, 9.26439, 0.0), rel=1e-5, abs=1e-9)
    assert found[1] == pytest.approx((28.1914, 30.8711, -64.21), rel=1e-4)
