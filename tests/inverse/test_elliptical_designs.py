"""Designs of elliptical drives: the best phase, settings that no grid beats, and what is told of them."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.questions import answered

import vibro
from vibro import InputError, Regime
from vibro.inverse.designs import chosen_of
from vibro.inverse.ellipses import EllipseOptimiser
from vibro.inverse.exchange import Found
from vibro.inverse.guarantees import guarantee_of
from vibro.inverse.pictured import setting_fields, speed_band
from vibro.inverse.questions import Question
from vibro.inverse.reading import read_spec
from vibro.inverse.rows import Finder, Rounded, find
from vibro.inverse.spaces import Setting
from vibro.inverse.windows import Family, window_of
from vibro.results.designs import Design, DesignResult

FREQUENCY, FRICTION, GRAVITY = 25.0, 0.3, 9.81
UNIT = GRAVITY / (2.0 * math.pi * FREQUENCY) ** 2
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


def asked(question: dict[str, Any], highest: Regime = Regime.BACK_SLIP) -> Question:
    spec = read_spec(question)
    return Question(spec, spec.drives[0], highest)


def one_drive(
    scene: dict[str, Any], drive: dict[str, Any], speed: float = 1.0, **more: Any
) -> dict[str, Any]:
    return {"scene": scene, "drive": [drive], "goal": {"speed_mm_s": speed}, **more}


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


LOOSE = one_drive(
    {"static_friction": "0.35:0.45", "friction_ratio": "0.85:0.95"},
    {
        "along_amplitude_mm": "0.1:1",
        "normal_amplitude_mm": "0.05:0.5",
        "normal_phase_deg": "-180:180",
        "frequency_hz": 25,
        "acceleration_g": 1.5,
    },
    speed=20.0,
    drift={"amplitude_percent": 2, "normal_phase_deg": 3},
)


@pytest.mark.parametrize("highest", [Regime.FORWARD_SLIP, Regime.BACK_SLIP])
def test_no_setting_is_faster_or_gentler(highest: Regime) -> None:
    question = asked(LOOSE, highest)
    optimiser = EllipseOptimiser(question)
    fastest = optimiser.fastest()
    assert fastest is not None
    setting = fastest.setting
    assert question.load(setting) <= 1.5
    guarantee = guarantee_of(question.box(setting))
    assert max(guarantee.regimes) <= highest
    assert guarantee.speed_min == pytest.approx(fastest.speed, rel=1e-6)
    target = 0.7 * fastest.speed
    gentlest = optimiser.least_acceleration(target)
    assert gentlest is not None
    assert gentlest.speed >= target
    rng = np.random.default_rng(1)
    knobs = ("along_amplitude", "normal_amplitude", "normal_phase")
    along, normal, phase = (rng.uniform(*question.drive.span(knob), 20000) for knob in knobs)
    drawn = Setting(along, normal, phase, np.full(20000, 25.0))
    allowed = question.load(drawn) <= 1.5
    drawn = Setting(*(x[allowed] for x in drawn))
    speed = optimiser.least(drawn, 1.0)
    assert speed.max() <= fastest.speed * (1 + 1e-6)
    assert speed.max() >= 0.85 * fastest.speed  # the sample comes close
    load = question.load(drawn)[speed >= target]
    assert load.size > 5
    assert load.min() >= float(question.load(gentlest.setting)) * (1 - 1e-6)


@cache
def fixed_amplitudes() -> dict[tuple[str, str], Design]:
    drive = {
        "along_amplitude_mm": 0.6,
        "normal_amplitude_mm": "0.1:0.25",
        "normal_phase_deg": -50,
        "frequency_hz": 25,
    }
    result = vibro.design(one_drive({"static_friction": "0.35:0.45", "friction_ratio": 0.9}, drive, 30.0))
    assert result.met
    assert [c.name for c in result.columns if "along" in c.name or "angle" in c.name] == [
        "along_amplitude_mm"
    ]
    return {(d.highest_regime, d.design): d for d in result.designs}


def test_designs_hold_as_they_are_printed() -> None:
    found = fixed_amplitudes()
    for (regime, _), design in found.items():
        if design.along_amplitude_mm is None or design.normal_amplitude_mm is None:
            assert regime == "forward-slip"
            continue
        assert (design.along_amplitude_mm, design.normal_phase_deg, design.frequency_hz) == (0.6, -50.0, 25.0)
        scene = vibro.Scene(
            along_amplitude=0.6e-3,
            normal_amplitude=1e-3 * design.normal_amplitude_mm,
            normal_phase=math.radians(-50.0),
            frequency=25.0,
            static_friction=0.4,
            kinetic_friction=0.3,
        )
        holds = vibro.guarantee(scene, static_friction=(0.35, 0.45), friction_ratio=(0.9, 0.9))
        assert 1e3 * holds.speed_min == pytest.approx(design.speed_min_mm_s, rel=1e-9)
        assert 1e3 * holds.speed_min >= 30.0
        assert design.throw_number_max == pytest.approx(1e-3 * design.normal_amplitude_mm / UNIT, rel=1e-9)
        assert design.proof == "proved"
        assert design.margin is not None
        assert design.margin >= 1.0


def test_designs_within_a_regime_are_designs_within_the_next() -> None:
    found = fixed_amplitudes()
    for kind, merit in (("fastest", "speed_min_mm_s"), ("safest", "margin")):
        assert getattr(found["hopping", kind], merit) >= getattr(found["back-slip", kind], merit)
    # it cannot hop, even if all is ten times as uncertain
    assert (
        found["hopping", "gentlest"].normal_amplitude_mm == found["back-slip", "gentlest"].normal_amplitude_mm
    )


def test_a_window_is_of_both_amplitudes() -> None:
    drive = {"along_amplitude_mm": "0.3:1", "normal_amplitude_mm": "0.1:0.3", "frequency_hz": 25}
    drive |= {"normal_phase_deg": -50}
    question = asked(one_drive({"static_friction": "0.35:0.45", "friction_ratio": 0.9}, drive, 30.0))
    row = find(question, {}).row("fastest")
    assert (row.high_set_by, row.low_set_by, row.set_by) == ("limit", "speed", "limit")
    assert row.amplitude_high_mm == pytest.approx(row.along_amplitude_mm, rel=1e-9)
    assert row.amplitude_low_mm is not None
    assert row.along_amplitude_mm is not None
    assert row.normal_amplitude_mm is not None
    for factor, holds in ((1 + 1e-7, True), (1 - 1e-7, False)):
        share = factor * row.amplitude_low_mm / row.along_amplitude_mm
        setting = Setting(
            share * row.along_amplitude_mm / 1e3,
            share * row.normal_amplitude_mm / 1e3,
            math.radians(-50.0),
            25.0,
        )
        assert (guarantee_of(question.box(setting)).speed_min >= 0.03) is holds


def test_a_trough_that_moves_along_its_normal_alone_has_a_window_and_pictures() -> None:
    drive = {"along_amplitude_mm": 0, "normal_amplitude_mm": "0.1:0.35", "frequency_hz": 25}
    scene = {"static_friction": "0.2:0.25", "friction_ratio": 0.9, "trough_angle_deg": -8}
    spec = read_spec(one_drive(scene, drive, 2.0))
    finder = find(asked(one_drive(scene, drive, 2.0)), {})
    row = finder.row("fastest")
    assert row.amplitude_low_mm is not None
    assert row.amplitude_high_mm is not None
    assert 0.1 <= row.amplitude_low_mm < row.amplitude_high_mm == pytest.approx(0.35, rel=1e-9)
    chosen = chosen_of(spec, DesignResult(False, (row,), (finder.found["fastest"].setting,)))
    assert chosen is not None
    fields = setting_fields(spec, chosen)
    assert fields.amplitude == "normal_amplitude"
    assert fields.limits == pytest.approx((0.1, 0.35))


def test_a_trough_that_does_not_move_along_its_normal_has_pictures_of_parts_that_never_tip() -> None:
    drive = {
        "along_amplitude_mm": "0.1:1",
        "normal_amplitude_mm": 0,
        "normal_phase_deg": 0,
        "frequency_hz": 25,
    }
    upright = {"half_base_mm": 6, "centre_height_mm": 8}
    scene = {"static_friction": "0.35:0.45", "friction_ratio": 0.9, "trough_angle_deg": -3}
    spec = read_spec(one_drive(scene, drive, 1.0, part=upright))
    finder = find(Question(spec, spec.drives[0], Regime.BACK_SLIP), {})
    row = finder.row("fastest")
    assert row.throw_number_max == 0.0
    chosen = chosen_of(spec, answered(True, row, replace(row, design="safest")))
    assert chosen is not None
    fields = setting_fields(spec, chosen)
    assert math.isinf(fields.tips)
    assert math.isinf(fields.begins[Regime.HOPPING][0])


@pytest.mark.parametrize("speed", [0.0, -1e-3])
def test_a_design_that_conveys_nothing_has_no_traverse_time_and_no_nearest_drive(speed: float) -> None:
    question = asked(one_drive({**LOOSE["scene"], "trough_length_mm": 600}, LOOSE["drive"][0], 20.0))
    setting = Setting(5e-4, 2e-4, math.radians(-50.0), 25.0)
    resting = replace(guarantee_of(question.box(setting)), speed_min=speed)
    found = Rounded(setting, (0.5, 0.2, -50.0, 25.0), resting)
    row = Finder(question, EllipseOptimiser(question), {"fastest": found}).row("fastest")
    assert row.speed_min_mm_s == 1e3 * speed
    assert row.traverse_time_max_s is None
    assert row.frequency_needed_hz is None
    assert row.amplitude_needed_mm is None


def test_a_window_that_no_search_confirmed_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    question = asked(one_drive(LOOSE["scene"], LOOSE["drive"][0], 20.0))
    setting = Setting(6e-4, 2.5e-4, math.radians(-50.0), 25.0)
    guarantee = guarantee_of(question.box(setting))
    assert guarantee.speed_min > 0.02  # so that the goal does not end it on either side
    monkeypatch.setattr(Family, "intervals", lambda *_, **__: [])
    window = window_of(question, Found(setting, (), guarantee))
    assert window is not None
    assert (window.low, window.high) == (6e-4, 6e-4)
    assert (window.low_set_by, window.high_set_by) == ("unconfirmed", "unconfirmed")


def test_pictures_show_what_bodies_do() -> None:
    known = {**LOOSE, "drift": {}}
    spec = read_spec(known)
    design = Design(
        drive="drive 1", highest_regime="back-slip", design="fastest", along_amplitude_mm=0.5,
        normal_amplitude_mm=0.2, normal_phase_deg=-50.0, frequency_hz=25.0,
    )  # fmt: skip
    chosen = chosen_of(spec, answered(False, design))
    assert chosen is not None
    fields, band = setting_fields(spec, chosen), speed_band(spec, chosen)
    assert fields.amplitude == "along_amplitude"
    assert fields.limits == pytest.approx((0.125, 1.0))
    static, ratio = (x.ravel() for x in np.meshgrid([0.35, 0.4, 0.45], [0.85, 0.9, 0.95]))
    shown = set()
    for share in (0.1, 0.2, 0.3, 0.6, 1.0, 1.6):
        x = share * 0.5e-3
        scene = vibro.Scene(
            along_amplitude=x,
            normal_amplitude=0.4 * x,
            normal_phase=math.radians(-50.0),
            frequency=25.0,
            static_friction=static,
            kinetic_friction=ratio * static,
        )
        cycle = vibro.solve(scene, flight=False)
        load = x / UNIT  # of the motion along the trough
        for which, regime in ((0, cycle.regime.max()), (1, cycle.regime.min())):
            begun = [r for r, pair in fields.begins.items() if pair[which] <= load]
            assert max(begun, default=Regime.NO_SLIP) == regime
            shown.add((which, regime))
        slow, fast = 1e3 * cycle.mean_velocity.min(), 1e3 * cycle.mean_velocity.max()
        assert np.interp(load, fields.load, fields.speed_min) / 25.0 == pytest.approx(
            slow, rel=2e-3, abs=1e-2
        )
        if share >= 0.6:  # within the picture
            lowest = np.interp(1e3 * x, band.amplitude, band.speed_min)
            highest = np.interp(1e3 * x, band.amplitude, band.speed_max)
            assert (lowest, highest) == pytest.approx((slow, fast), rel=2e-3)
    assert len(shown) >= 4
    # the largest acceleration, which is more than that along the trough
    limit = fields.most_load * UNIT
    edge = Setting(limit, 0.4 * limit, math.radians(-50.0), 25.0)
    assert float(asked(known).load(edge)) == pytest.approx(1.5, rel=1e-12)


def test_the_nearest_drive_meets_the_goal() -> None:
    drive = {
        "along_amplitude_mm": 0.2,
        "normal_amplitude_mm": 0.08,
        "normal_phase_deg": -60,
        "frequency_hz": 50,
    }
    question = asked(one_drive({"static_friction": "0.35:0.45", "friction_ratio": 0.9}, drive, 80.0))
    for digits, most in ((9, 0.08 * (1 + 1e-6)), (4, 0.08 * (1 + 2e-3))):
        row = find(question, {}, digits).row("fastest")
        assert row.frequency_needed_hz is not None
        assert row.amplitude_needed_mm is not None
        x, y = row.amplitude_needed_mm / 1e3, 0.4 * row.amplitude_needed_mm / 1e3
        setting = Setting(x, y, math.radians(-60.0), row.frequency_needed_hz)
        assert 0.08 <= guarantee_of(question.box(setting)).speed_min <= most


def test_largest_amplitudes_keep_to_the_acceleration() -> None:
    question = asked(LOOSE)
    phase = np.radians(np.linspace(-180.0, 180.0, 181))
    frequency = np.full(phase.shape, 25.0)
    for share in (0.0, 0.3, 0.9, 0.999):
        y = np.full(phase.shape, share * 1.5 * UNIT)
        x = EllipseOptimiser(question)._most_along(frequency, y, phase)
        load = question.load(Setting(x, y, phase, frequency))
        assert np.all(load <= 1.5 * (1 + 1e-15))
        np.testing.assert_allclose(load, 1.5, rtol=1e-11)
    assert np.all(
        EllipseOptimiser(question)._most_along(frequency, np.full(phase.shape, 1.6 * UNIT), phase) == 0.0
    )


def test_the_highest_of_all_frequencies_tells_whether_parts_may_hop() -> None:
    """0.2 mm normal to the trough throw parts at 50 Hz alone."""
    drive = {"along_amplitude_mm": 0.5, "normal_amplitude_mm": 0.2}
    scene = {"static_friction": 0.4, "friction_ratio": 0.9}
    for frequency, more in (("10,50", True), (10, False)):
        question = one_drive(scene, {**drive, "frequency_hz": frequency})
        assert EllipseOptimiser(asked(question, Regime.HOPPING)).has_more() is more


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


@pytest.mark.parametrize(
    ("drive", "texts"),
    [
        ({"amplitude_mm": 1, "along_amplitude_mm": 1, "normal_amplitude_mm": 1},
         ("amplitude_mm = 1: not beside along_amplitude_mm and normal_amplitude_mm", "give either")),
        ({"drive_angle_deg": 20, "normal_phase_deg": 5},
         ("drive_angle_deg = 20: not beside normal_phase_deg", "along_amplitude_mm is missing")),
        ({"stroke_mm": 1, "along_amplitude_mm": "1:2"},
         ("stroke_mm = 1: not beside along_amplitude_mm", "normal_amplitude_mm is missing")),
        ({"along_amplitude_mm": -1, "normal_amplitude_mm": "2:1"},
         ("along_amplitude_mm = -1: must be", "normal_amplitude_mm = '2:1': must be")),
        ({"along_amplitude_mm": 1, "normal_amplitude_mm": [1, 2]}, ("normal_amplitude_mm = [1, 2]: must",)),
        ({"along_amplitude_mm": 1, "normal_amplitude_mm": 1, "acceleration_g": 0.1},
         ("acceleration_g = 0.1: amplitude and frequency are such that it is at least 2.515",)),
    ],
)  # fmt: skip
def test_what_cannot_be_is_told(drive: dict[str, Any], texts: tuple[str, ...]) -> None:
    with pytest.raises(InputError) as told:
        read_spec(one_drive({"static_friction": 0.4, "friction_ratio": 0.9}, {"frequency_hz": 25, **drive}))
    said = f"{told.value} {told.value.hint}"
    for text in texts:
        assert text in said


@pytest.mark.parametrize(
    ("key", "drive"),
    [
        ("normal_phase_deg", {"amplitude_mm": 1, "drive_angle_deg": 20}),
        ("drive_angle_deg", {"along_amplitude_mm": 1, "normal_amplitude_mm": 0.3}),
    ],
)
def test_a_drift_of_what_no_drive_has_is_refused(key: str, drive: dict[str, Any]) -> None:
    question = one_drive(
        {"static_friction": 0.4, "friction_ratio": 0.9}, {"frequency_hz": 25, **drive}, drift={key: 1}
    )
    with pytest.raises(InputError, match=rf"\[drift\] {key} = 1: no drive has {key}"):
        read_spec(question)
