"""Questions, their uncertainty sets and scenarios, beside what a short calculation gives."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from design import RANDOM_DRIVES, random_question
from helpers.questions import answered

import vibro
from vibro import Regime
from vibro.designs.design import chosen_of
from vibro.designs.proofs import corners
from vibro.designs.questions import Question
from vibro.designs.reading import read_spec
from vibro.designs.rows import KINDS
from vibro.designs.spaces import SPACES, Setting
from vibro.results.designs import Design

LINE: dict[str, Any] = {
    "scene": {"static_friction": "0.66:0.82", "friction_ratio": 0.77},
    "drive": [{"amplitude_mm": "0.5:3", "frequency_hz": 15, "drive_angle_deg": "10:40"}],
    "drift": {"amplitude_percent": 2, "frequency_percent": 1, "drive_angle_deg": 0.5},
    "goal": {"speed_mm_s": 5},
}
ELLIPSE: dict[str, Any] = {
    **LINE,
    "drive": [
        {"along_amplitude_mm": "0.1:1", "normal_amplitude_mm": "0.05:0.2", "normal_phase_deg": "-90:0",
         "frequency_hz": 25},
    ],
    "drift": {"amplitude_percent": 2, "frequency_percent": 1, "normal_phase_deg": 3},
}  # fmt: skip


def asked(question: dict[str, Any], highest: Regime = Regime.BACK_SLIP) -> Question:
    spec = read_spec(question)
    return Question(spec, spec.drives[0], highest)


def line(amplitude: float, angle_deg: float = 20.0, frequency: float = 15.0) -> Setting:
    space = SPACES[asked(LINE).drive.kind]
    return space.setting(amplitude=amplitude, frequency=frequency, drive_angle=math.radians(angle_deg))


@pytest.mark.parametrize("scale", [0.0, 0.5, 1.0, 3.0])
def test_every_drift_is_scaled(scale: float) -> None:
    box = asked(LINE).box(line(1e-3), scale)
    for (low, high), value, share in (
        (box.factor, 1e-3, 0.02), (box.frequency, 15.0, 0.01),
        (box.shape["drive_angle"], math.radians(20.0), 0.5 / 20.0), (box.static_friction, 0.74, 0.08 / 0.74),
    ):  # fmt: skip
        assert (low, high) == pytest.approx((value * (1 - share * scale), value * (1 + share * scale)))
    setting = Setting(5e-4, 1e-4, -0.5, 25.0)
    ellipse = asked(ELLIPSE).box(setting, scale)
    assert ellipse.frequency == pytest.approx((25.0 * (1 - 0.01 * scale), 25.0 * (1 + 0.01 * scale)))
    drift = math.radians(3.0) * scale
    assert ellipse.shape["normal_phase"] == pytest.approx((-0.5 - drift, -0.5 + drift))
    assert ellipse.factor == pytest.approx((1 - 0.02 * scale, 1 + 0.02 * scale))


def test_loads_of_the_chosen_design_are_of_the_first_and_the_last_part() -> None:
    spec = read_spec({**LINE, "drive": [{"amplitude_mm": 1, "frequency_hz": 15, "drive_angle_deg": 20}]})
    design = Design(
        drive="drive 1", highest_regime="back-slip", design="fastest", amplitude_mm=0.9, frequency_hz=15.0,
        drive_angle_deg=20.0,
    )  # fmt: skip
    chosen = chosen_of(spec, answered(False, design))
    assert chosen is not None
    box = asked(LINE).box(chosen.setting)
    grid = np.array(np.meshgrid(*[[0.0, 0.5, 1.0]] * 5, [0.0])).reshape(6, -1)
    scene = box.scene(box.points(grid), fast=False)
    loads = vibro.critical_loads(scene)
    ratios = {name: scene.load / load for name, load in loads._asdict().items()}
    assert chosen.loads["the first part slips back"] == pytest.approx(np.max(ratios["back_slip"]), rel=1e-9)
    assert chosen.loads["the first part hops"] == pytest.approx(np.max(ratios["hop"]), rel=1e-9)
    assert chosen.loads["the last part starts"] == pytest.approx(np.min(ratios["forward_onset"]), rel=1e-9)


@pytest.mark.parametrize(
    ("scene", "scale", "field", "ends"),
    [
        ({"friction_ratio": "0.8:1"}, 2.0, "second_friction", (0.7, 1.0)),  # mu_d <= mu_s
        ({"friction_ratio": "0.2:0.8"}, 2.0, "second_friction", (0.0, 1.0)),
        ({"kinetic_friction": "0.8:1.2"}, 2.0, "second_friction", (0.6, 1.4)),
        ({"kinetic_friction": "0.2:1.2"}, 2.0, "second_friction", (0.0, 1.7)),
        ({"static_friction": "0.1:0.5"}, 2.0, "static_friction", (0.0, 0.7)),
        ({"static_friction": "1.1:1.5"}, 2.0, "static_friction", (0.9, 1.7)),
    ],
)
def test_scaled_frictions_are_cut_where_they_cannot_be(
    scene: dict[str, Any], scale: float, field: str, ends: tuple[float, float]
) -> None:
    given = {"static_friction": "1.3:1.5"} | ({} if "kinetic_friction" in scene else {"friction_ratio": 0.77})
    box = asked({**LINE, "scene": given | scene}).box(line(1e-3), scale)
    assert [float(end) for end in getattr(box, field)] == pytest.approx(ends)
    assert box.is_ratio is ("kinetic_friction" not in scene)


def test_constants_of_a_question_are_those_of_its_scenes() -> None:
    moon = asked({**LINE, "scene": {**LINE["scene"], "gravity_m_s2": 1.62, "restitution": "0.2:0.4"}})
    hops = replace(moon, highest=Regime.HOPPING)
    for question, restitution in ((moon, 0.0), (hops, pytest.approx(0.3))):  # contact does not depend on it
        scene = question.nominal_scene(line(1e-3))
        assert (float(scene.gravity), float(scene.restitution)) == (1.62, restitution)
    assert float(moon.load(line(1e-3))) == pytest.approx(1e-3 * (2 * math.pi * 15.0) ** 2 / 1.62)


def test_the_nominal_scene_is_in_the_middle_of_all_bands() -> None:
    content = {
        **LINE,
        "scene": {"static_friction": "0.6:0.8", "friction_ratio": "0.7:0.9", "trough_angle_deg": "1:3"},
    }
    fields = asked(content).nominal_scene(line(1e-3)).arrays()._asdict()
    expected = {
        "amplitude": 1e-3, "frequency": 15.0, "drive_angle": math.radians(20.0), "static_friction": 0.7,
        "kinetic_friction": 0.56, "trough_angle": math.radians(2.0), "gravity": 9.81, "restitution": 0.0,
    }  # fmt: skip
    assert {name: float(value) for name, value in fields.items()} == pytest.approx(expected)
    several = asked(content).nominal_scene(Setting(*(np.array([x, x]) for x in line(1e-3))))
    assert several.shape == (2,)


@pytest.mark.parametrize(
    ("setting", "highest", "part", "allowed"),
    [
        (Setting(2e-4, 2e-4, -0.5, 25.0), Regime.FORWARD_SLIP, None, True),
        (Setting(1.5e-3, 1e-4, -0.5, 25.0), Regime.FORWARD_SLIP, None, False),  # slips back
        (Setting(1.5e-3, 1e-4, -0.5, 25.0), Regime.BACK_SLIP, None, True),
        (Setting(6e-4, 4.5e-4, -0.5, 25.0), Regime.BACK_SLIP, None, False),  # hops
        (Setting(6e-4, 4.5e-4, -0.5, 25.0), Regime.HOPPING, None, True),
        (Setting(6e-4, 4.5e-4, -0.5, 25.0), Regime.HOPPING, 9.0, False),  # may land on an edge
        (Setting(6e-4, 1e-4, -0.5, 25.0), Regime.BACK_SLIP, 9.0, True),
        (Setting(1.5e-3, 1e-4, -0.5, 25.0), Regime.BACK_SLIP, 1.0, False),  # tips
    ],
)
def test_bodies_of_an_ellipse_that_break_a_constraint_are_slowest(
    setting: Setting, highest: Regime, part: float | None, allowed: bool
) -> None:
    upright = {} if part is None else {"part": {"half_base_mm": part, "centre_height_mm": 10}}
    scene = {"static_friction": 0.4, "kinetic_friction": 0.36, "restitution": 0}
    question = asked({**ELLIPSE, "scene": scene, "drift": {}} | upright, highest)
    one = Setting(*(np.array([x]) for x in setting))
    box = question.box(setting)
    speeds = question.speeds(one, corners(box.varies))
    solved = float(vibro.solve(question.nominal_scene(setting)).mean_velocity)
    assert speeds.tolist() == [[solved if allowed else -math.inf]]


TWO = {**LINE, "drive": [{**LINE["drive"][0], "name": name} for name in "ab"]}


@pytest.mark.parametrize(
    ("met", "bands", "kind"),
    [(True, True, "safest"), (True, False, "gentlest"), (False, True, "fastest"), (False, False, "fastest")],
)
def test_what_is_shown_is_the_safest_if_anything_is_uncertain(met: bool, bands: bool, kind: str) -> None:
    """Else the gentlest: the safest would be the drive's limit. The fastest if the goal is not met."""
    spec = read_spec(
        TWO if bands else {**TWO, "scene": {"static_friction": 0.74, "friction_ratio": 0.77}, "drift": {}}
    )
    assert spec.has_bands is bands
    rows = [
        Design(
            drive=name, highest_regime=regime, design=each, amplitude_mm=amplitude, frequency_hz=15.0,
            drive_angle_deg=20.0, speed_min_mm_s=speed, acceleration_g=3.0 - amplitude,
        )
        for name, amplitude in (("a", 1.0), ("b", 2.0))
        for regime, speed in (("forward-slip", 9.0), ("back-slip", amplitude), ("hopping", 9.0))
        for each in KINDS
    ]  # fmt: skip
    chosen = chosen_of(spec, answered(met, *rows))
    assert chosen is not None
    assert (chosen.design.drive, chosen.design.highest_regime, chosen.design.design) == (
        "b",
        "back-slip",
        kind,
    )
    assert chosen.setting == pytest.approx(line(2e-3))
    assert chosen_of(spec, answered(met, *(r for r in rows if r.highest_regime != "back-slip"))) is None
    assert list(chosen.costs)[:2] == ["amplitude", "frequency"]


# --- any number of settings -------------------------------------------------------------------------


@pytest.mark.parametrize("kind", RANDOM_DRIVES)
def test_speeds_of_any_number_of_settings_are_those_of_each(kind: str) -> None:
    """Searches ask for those of none too: of no peak, or of no angle between two neighbouring doubles."""
    rng = np.random.default_rng(5)
    for steepness in (-0.5, 0.5):
        asked = random_question(rng, kind, steepness)
        asked["goal"] = {"speed_mm_s": 1.0, "impact_speed_mm_s": 90.0}
        asked["drive"][0].pop("acceleration_g", None)
        spec = read_spec(asked)
        drive = spec.drives[0]
        question = Question(spec, drive, Regime.HOPPING)
        knobs = {knob: rng.uniform(*drive.choices[knob][0], 2) for knob in drive.space.knobs}
        setting: Any = drive.space.setting(**knobs)
        bodies = rng.random((len(question.box(setting._make(x[:1] for x in setting)).axes), 5))
        for number in (0, 2):
            some = setting._make(x[:number] for x in setting)
            speeds = question.speeds(some, bodies)
            assert speeds.shape == (number, 5)
            for i in range(number):
                alone = question.speeds(setting._make(x[i : i + 1] for x in setting), bodies)[0]
                assert speeds[i] == pytest.approx(alone, rel=1e-6, abs=1e-12, nan_ok=True)
