"""Designs of lines and ellipses as they are printed: they hold, and neither choice nor rounding loses one."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from helpers.questions import LOOSE, UNIT, answered, asked, one_drive

import vibro
from vibro.core.codes import Regime
from vibro.designs.design import chosen_of
from vibro.designs.guarantees import guarantee_of
from vibro.designs.optima import EllipseOptimiser, LineOptimiser
from vibro.designs.pictured import setting_fields, speed_band
from vibro.designs.questions import Question
from vibro.designs.reading import read_spec
from vibro.designs.rows import DIGITS, Finder, Rounded, find
from vibro.designs.spaces import SPACES, Setting
from vibro.designs.windows import Family, window_of
from vibro.drives import Line
from vibro.results.designs import Design, DesignResult


def rows(question: dict[str, Any], digits: int = DIGITS) -> dict[tuple[str, str], Design]:
    """Designs of the only drive within the goal's regime, by regime and kind."""
    found = vibro.design(question, digits=digits, only="goal").designs
    return {(d.highest_regime, d.design): d for d in found}


def optimiser(question: dict[str, Any], highest: Regime = Regime.BACK_SLIP) -> LineOptimiser:
    return LineOptimiser(asked(question, highest))


def test_another_frequency_never_makes_a_goal_impossible() -> None:
    scene = {"static_friction": 0.2809, "friction_ratio": 0.845}
    drive = {"amplitude_mm": "0.04158:0.1326", "drive_angle_deg": 29.09}
    for frequencies in (41.9, [41.9, 59.86], [41.9, 59.86, 80.0]):
        question = one_drive(scene, {**drive, "frequency_hz": frequencies}, 0.8)
        best = optimiser(question, Regime.FORWARD_SLIP).fastest()
        assert best is not None
        assert best.speed == pytest.approx(1.4566775e-3, rel=1e-7)
        assert best.setting.frequency == 41.9


def test_on_a_decline_the_least_load_may_have_no_peak_before_it() -> None:
    scene = {"static_friction": "0.44:0.54", "friction_ratio": "0.53:0.73", "trough_angle_deg": -4}
    drive = {"amplitude_mm": 40, "frequency_hz": 40, "drive_angle_deg": 42}
    finder = find(asked(one_drive(scene, drive, 15)), {}, until="gentlest")
    designs = finder.row("gentlest"), finder.row("fastest")
    assert [design.amplitude_mm for design in designs] == [0.154, 0.2315]
    assert all((design.speed_min_mm_s or 0.0) >= 15.0 for design in designs)


def test_more_drive_angles_never_lose_the_one_that_does_it() -> None:
    scene = {"static_friction": 0.2336, "kinetic_friction": "0.20764:0.22736", "trough_angle_deg": 3.496}
    for angles in ("50:56.81", "30:56.81", "11.81:56.81"):
        drive = {"amplitude_mm": 0.6002, "frequency_hz": 35.57, "drive_angle_deg": angles}
        best = optimiser(one_drive(scene, drive, 0.5, drift={"trough_angle_deg": 1.42426})).fastest()
        assert best is not None
        assert best.speed == pytest.approx(0.75956e-3, rel=1e-5)


@pytest.mark.parametrize(("frequency", "angle"), [("1450rpm", "0.5rad"), ("19.333333333333333", 30)])
def test_a_value_that_is_given_is_kept_to_its_last_digit(frequency: Any, angle: Any) -> None:
    drive = {
        "amplitude_mm": 2,
        "frequency_hz": frequency,
        "drive_angle_deg": angle,
        "acceleration_g": 1.5,
    }
    found = rows(one_drive({"static_friction": 0.5, "friction_ratio": 0.8}, drive, 5))
    for design in found.values():
        assert design.speed_min_mm_s is not None
        assert design.speed_min_mm_s >= 5.0
    given = {"1450rpm": 145 / 6, "19.333333333333333": 58 / 3}[frequency]
    assert found["back-slip", "fastest"].frequency_hz == pytest.approx(given, rel=1e-14)


# The gentlest setting reaches the goal just where back slip enters: no rounding of it holds.
VERTEX = one_drive(
    {"static_friction": 0.3841, "kinetic_friction": 0.3111, "trough_angle_deg": 9.795},
    {
        "amplitude_mm": 0.194,
        "frequency_hz": "27.28:54.56",
        "drive_angle_deg": "5:80",
        "acceleration_g": 1.421,
    },
    2.2135830290521503,
    drift={"frequency_percent": 0.8539},
    part={"half_base_mm": 7.485, "centre_height_mm": 8},
)


def test_designs_at_a_vertex_and_what_is_printed_of_them() -> None:
    finder = find(asked(VERTEX), {}, 4, until="gentlest")
    least, found = {}, [finder.row("gentlest"), finder.row("fastest")]
    finer = find(asked(VERTEX), {}, 9, until="gentlest").row("gentlest")
    for digits, spread, gentlest in ((9, 1e-5, finer), (4, 2e-3, found[0])):
        assert (gentlest.highest_regime, gentlest.design) == ("back-slip", "gentlest")
        assert gentlest.acceleration_g == pytest.approx(0.846747, rel=spread)
        least[digits] = gentlest.acceleration_g or math.nan
        settings = (gentlest.amplitude_mm, gentlest.frequency_hz, gentlest.drive_angle_deg)
        assert all(x is not None and float(f"{x:.{digits}g}") == x for x in settings)
    assert least[9] < least[4]
    for design in found:
        assert design.amplitude_mm is not None
        assert design.frequency_hz is not None
        assert design.drive_angle_deg is not None
        assert design.amplitude_low_mm is not None
        assert design.amplitude_high_mm is not None
        assert design.amplitude_low_mm <= design.amplitude_mm <= design.amplitude_high_mm
        scene = vibro.Scene(
            amplitude=design.amplitude_mm / 1e3,
            frequency=design.frequency_hz,
            drive_angle=math.radians(design.drive_angle_deg),
            static_friction=0.3841,
            kinetic_friction=0.3111,
            trough_angle=math.radians(9.795),
        )
        drift = (design.frequency_hz * (1 - 0.008539), design.frequency_hz * (1 + 0.008539))
        holds = vibro.guarantee(scene, frequency=drift)
        assert holds.speed_min * 1e3 == pytest.approx(design.speed_min_mm_s, rel=1e-6)
        assert design.proof == "sampled" or holds.speed_min >= 2.2135830290521503e-3 * (1 - 1e-9)


def test_a_margin_counts_the_dip_of_the_speed_within_a_drift() -> None:
    drive = {
        "amplitude_mm": "0.05116:0.4045",
        "frequency_hz": "26.1:52.19",
        "drive_angle_deg": 33.256,
        "acceleration_g": 2.302,
    }
    scene = {"static_friction": 0.72, "kinetic_friction": 0.3717}
    drift = {"amplitude_percent": 4.924, "frequency_percent": 1.04}
    search = optimiser(one_drive(scene, drive, 32.3006, drift=drift))
    safest = search.safest(0.0323006)
    assert safest is not None
    margin = search.margin(safest.setting, 0.0323006)
    assert margin is not None
    assert margin > 2.249  # 2.057 by a grid of settings


@pytest.mark.parametrize(("throw", "holds"), [(0.999, True), (1.001, False)])
def test_parts_that_must_stay_upright_do_not_hop(throw: float, holds: bool) -> None:
    """They never tip while they touch the trough, and nothing is known of how they land."""
    drive = {"amplitude_mm": 5, "frequency_hz": 25, "drive_angle_deg": 30}
    part = {"half_base_mm": 8, "centre_height_mm": 8}
    scene = {"static_friction": 0.5, "friction_ratio": 0.9}
    angle, weight = math.radians(30.0), 9.81 / (2.0 * math.pi * 25.0) ** 2
    amplitude = throw * weight / math.sin(angle)
    setting = SPACES[Line].setting(amplitude=amplitude, frequency=25.0, drive_angle=angle)
    assert optimiser(one_drive(scene, drive, 5.0), Regime.HOPPING).holds(setting, 0.0)
    assert optimiser(one_drive(scene, drive, 5.0, part=part), Regime.HOPPING).holds(setting, 0.0) is holds


@pytest.mark.parametrize(("amplitude", "limit"), [(1e-3, "speed"), (2e-3, "limit")])
def test_the_stroke_limits_a_setting_at_its_upper_end_alone(amplitude: float, limit: str) -> None:
    drive = {"amplitude_mm": "0.5:2", "frequency_hz": 15, "drive_angle_deg": 20}
    question = one_drive({"static_friction": 0.74, "kinetic_friction": 0.57}, drive, 5.0)
    search = optimiser(question)
    setting = SPACES[Line].setting(amplitude=amplitude, frequency=15.0, drive_angle=math.radians(20.0))
    assert search.limit(setting, 1.0) == limit


def test_a_margin_is_found_again_for_every_slower_body(monkeypatch: pytest.MonkeyPatch) -> None:
    drive = {"amplitude_mm": 2, "frequency_hz": 15, "drive_angle_deg": 20}
    search = optimiser(one_drive({"static_friction": "0.7:0.78", "kinetic_friction": 0.57}, drive, 5.0))
    margins, slower = iter([3.0, 2.0, 1.5]), iter([True, True, False])
    monkeypatch.setattr(search, "_margin", lambda *_: next(margins))
    monkeypatch.setattr(search, "confirmed", lambda optimum, _: (optimum, next(slower)))
    setting = SPACES[Line].setting(amplitude=1e-3, frequency=15.0, drive_angle=math.radians(20.0))
    assert search.margin(setting, 5e-3) == 1.5


def test_no_drive_drifts_beyond_the_vertical_on_the_steepest_trough() -> None:
    drive = {"amplitude_mm": 2, "frequency_hz": 15, "drive_angle_deg": 79}
    scene = {"static_friction": 0.7, "friction_ratio": 0.8, "trough_angle_deg": "7:8"}
    spec = read_spec(one_drive(scene, drive, 5.0, drift={"drive_angle_deg": 1}))
    setting = SPACES[Line].setting(amplitude=1e-3, frequency=15.0, drive_angle=math.radians(79.0))
    box = Question(spec, spec.drives[0], Regime.BACK_SLIP).box(setting, 3.0)  # 6 to 9 deg, 76 to 82 deg
    steepest = math.degrees(box.shape["drive_angle"][1] + box.trough_angle[1])
    assert steepest == pytest.approx(90.0, abs=1e-3)
    assert steepest < 90.0


def test_the_nearest_drive_meets_the_goal() -> None:
    scene = {"static_friction": "0.3:0.5", "friction_ratio": "0.7:0.9", "trough_angle_deg": 3}
    drive = {"amplitude_mm": 0.8, "frequency_hz": 50, "drive_angle_deg": "5:60", "acceleration_g": 1.2}
    goal = {"speed_mm_s": 80, "highest_regime": "forward-slip"}
    question = {"scene": scene, "drive": [drive], "goal": goal}
    for digits, spread in ((9, 1e-6), (4, 1e-3)):
        result = vibro.design(question, digits=digits, only="goal")
        assert not result.met
        nearest = result.designs[1]
        assert nearest.set_by == "back slip"
        assert nearest.frequency_needed_hz == pytest.approx(2.90252154972701, rel=spread)
        needed = {"amplitude_mm": nearest.amplitude_needed_mm, "frequency_hz": nearest.frequency_needed_hz}
        best = optimiser({**question, "drive": [drive | needed]}, Regime.FORWARD_SLIP).fastest()
        assert best is not None
        assert best.speed >= 0.08


@pytest.mark.parametrize(
    ("margins", "speeds", "name"),
    [((2.0, 3.0), (50.0, 40.0), "b"), ((3.0, 2.0), (40.0, 50.0), "a"), ((2.0, 2.0), (40.0, 50.0), "b")],
)
def test_the_drive_of_the_largest_margin_is_shown(
    margins: tuple[float, float], speeds: tuple[float, float], name: str
) -> None:
    drive = {"amplitude_mm": 2, "frequency_hz": 20, "drive_angle_deg": 25}
    scene = {"static_friction": "0.4:0.5", "friction_ratio": 0.8}
    spec = read_spec(
        {"scene": scene, "drive": [{**drive, "name": n} for n in "ab"], "goal": {"speed_mm_s": 30}}
    )
    rows = [
        Design(
            drive=n, highest_regime="back-slip", design="safest", amplitude_mm=1.0, frequency_hz=20.0,
            drive_angle_deg=25.0, margin=margin, speed_min_mm_s=speed,
        )
        for n, margin, speed in zip("ab", margins, speeds, strict=True)
    ]  # fmt: skip
    chosen = chosen_of(spec, answered(True, *rows))
    assert chosen is not None
    assert chosen.design.drive == chosen.drive.name == name


@pytest.mark.parametrize(
    ("impact", "amplitude", "frequency"), [(640, 5.0, 5.0), (660, 18.0, 11.0)], ids=["5 %", "18 % and 11 %"]
)
def test_no_drift_lands_harder_than_the_limit(impact: float, amplitude: float, frequency: float) -> None:
    """At one load landings are hardest where the frequency is low and the amplitude high."""
    drive = {"amplitude_mm": "8:12", "frequency_hz": "12:15", "drive_angle_deg": 20}
    question = one_drive(
        {"static_friction": 0.74, "kinetic_friction": 0.57}, drive, 100,
        drift={"amplitude_percent": amplitude, "frequency_percent": frequency},
    )  # fmt: skip
    question["goal"] |= {"highest_regime": "hopping", "impact_speed_mm_s": impact}
    spec = read_spec(question)
    asked = Question(spec, spec.drives[0], Regime.HOPPING)
    best = LineOptimiser(asked).fastest()
    assert best is not None
    turned = asked.space.turned(best.setting)
    shares = np.linspace(-0.01, 0.01, 41)
    cycle = vibro.solve(
        vibro.Scene(
            amplitude=turned["amplitude"] * (1 + amplitude * shares),
            frequency=turned["frequency"] * (1 + frequency * shares[:, None]),
            drive_angle=turned["drive_angle"],
            static_friction=0.74,
            kinetic_friction=0.57,
        )
    )
    assert np.nanmax(cycle.impact_velocity) <= impact / 1e3 * (1 + 1e-3)


def test_a_drive_that_can_do_no_less_is_at_its_limit() -> None:
    scene = {"static_friction": "0.315:0.377", "friction_ratio": "0.7:0.9"}
    drive = {"amplitude_mm": "1.51:1.51", "frequency_hz": 20, "drive_angle_deg": 15}
    assert find(asked(one_drive(scene, drive, 10)), {}, until="gentlest").row("gentlest").set_by == "limit"


KNOWN: dict[str, Any] = {
    "scene": {"static_friction": 0.5, "kinetic_friction": 0.4},
    "drive": [
        {"name": "magnet", "stroke_mm": 1.1, "frequency_hz": 50, "drive_angle_deg": "10:40"},
        {"name": "motor", "amplitude_mm": 3, "frequency_hz": "1160rpm", "drive_angle_deg": 30},
    ],
    "goal": {"speed_mm_s": 5, "highest_regime": "forward-slip"},
}


@cache
def known(digits: int) -> DesignResult:
    return vibro.design(KNOWN, digits=digits, only="goal")


@pytest.mark.parametrize("digits", [DIGITS])
def test_few_digits_hold_as_printed(digits: int) -> None:
    """With no more than were asked for here, and a guarantee that is of the printed setting."""
    result = known(digits)
    assert result.met
    assert len(result.designs) == 6
    for design in result.designs:
        amplitude = design.amplitude_mm if design.stroke_mm is None else design.stroke_mm / 2
        assert amplitude is not None
        assert design.frequency_hz in (50.0, 19.3333333333333)  # as given
        assert design.drive_angle_deg is not None
        for value in (design.nominal, design.drive_angle_deg):
            assert value is not None
            assert float(f"{value:.{digits}g}") == value
        cycle = vibro.solve(
            vibro.Scene(
                amplitude=1e-3 * amplitude,
                frequency=design.frequency_hz,
                drive_angle=math.radians(design.drive_angle_deg),
                static_friction=0.5,
                kinetic_friction=0.4,
            )
        )
        assert cycle.regime == Regime.FORWARD_SLIP
        assert float(cycle.mean_velocity) >= 5e-3
        assert design.speed_min_mm_s == pytest.approx(1e3 * float(cycle.mean_velocity), rel=1e-12)


def test_fewer_digits_lose_little() -> None:
    """Of acceleration and speed about as much as one step of the last digit is worth."""
    fine, coarse = (known(n).designs for n in (9, DIGITS))
    for best, printed in zip(fine, coarse, strict=True):
        assert (best.drive, best.design, best.set_by) == (printed.drive, printed.design, printed.set_by)
        name = "acceleration_g" if best.design == "gentlest" else "speed_min_mm_s"
        sign = 1.0 if best.design == "gentlest" else -1.0
        lost = sign * (getattr(printed, name) / getattr(best, name) - 1.0)
        assert 0.0 <= lost < 3e-3


def test_with_known_frictions_the_gentlest_of_all_drives_is_shown() -> None:
    result = known(DIGITS)
    chosen = chosen_of(read_spec(KNOWN), result)
    assert chosen is not None
    least = min(d.acceleration_g or math.inf for d in result.designs if d.design == "gentlest")
    assert (chosen.design.design, chosen.design.acceleration_g) == ("gentlest", least)
    assert chosen.design is next(d for d in result.designs if d.drive == "motor")
    assert not any(isinstance(cost, str) for cost in chosen.costs.values())


def test_a_question_in_stroke_is_answered_in_stroke() -> None:
    """The drive that was given an amplitude keeps it; the same question in amplitude has the same answer."""
    result = known(DIGITS)
    magnet, motor = result.designs[0], result.designs[3]
    for design, other in ((magnet, "amplitude"), (motor, "stroke")):
        assert [getattr(design, f"{other}{end}_mm") for end in ("", "_low", "_high", "_needed")] == [None] * 4
    assert magnet.window is not None
    assert magnet.stroke_mm is not None
    assert magnet.window[0] <= magnet.stroke_mm <= magnet.window[1]
    names = [column.name for column in result.columns]
    assert names[3:5] == ["amplitude_mm", "stroke_mm"]
    alone = {**KNOWN, "drive": [KNOWN["drive"][0] | {"drive_angle_deg": 30}]}
    in_stroke = vibro.design(alone, only="goal", digits=9)
    assert not any("amplitude" in column.name for column in in_stroke.columns)
    halved = {"amplitude_mm": 0.55, "frequency_hz": 50, "drive_angle_deg": 30}
    in_amplitude = vibro.design({**KNOWN, "drive": [halved]}, only="goal", digits=9)
    assert not any("stroke" in column.name for column in in_amplitude.columns)
    for one, two in zip(in_stroke.designs, in_amplitude.designs, strict=True):
        assert one.window == pytest.approx([2 * x for x in two.window or ()], rel=1e-8)
        assert one.nominal == pytest.approx(2 * (two.nominal or 0.0), rel=1e-8)


def test_the_goals_regime_alone_has_the_same_answer() -> None:
    motor = {**KNOWN, "drive": KNOWN["drive"][1:]}
    whole, alone = vibro.design(motor), vibro.design(motor, only="goal")
    assert whole.designs[:3] == alone.designs
    assert len(whole.designs) == 9
    assert {d.highest_regime for d in whole.designs[3:]} == {"back-slip", "hopping"}


# ------------------------------------------------------------------------------------------ ellipses


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


def test_designs_of_ellipses_hold_as_they_are_printed() -> None:
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
    row = find(question, {}, until="fastest").row("fastest")
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
        assert (guarantee_of(question.box(setting)).found_min >= 0.03) is holds


def test_a_trough_that_moves_along_its_normal_alone_has_a_window_and_pictures() -> None:
    drive = {"along_amplitude_mm": 0, "normal_amplitude_mm": "0.1:0.35", "frequency_hz": 25}
    scene = {"static_friction": "0.2:0.25", "friction_ratio": 0.9, "trough_angle_deg": -8}
    spec = read_spec(one_drive(scene, drive, 2.0))
    finder = find(asked(one_drive(scene, drive, 2.0)), {}, until="fastest")
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
    finder = find(Question(spec, spec.drives[0], Regime.BACK_SLIP), {}, until="fastest")
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
    window = window_of(question, setting, guarantee)
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


def test_the_nearest_ellipse_meets_the_goal() -> None:
    drive = {
        "along_amplitude_mm": 0.2,
        "normal_amplitude_mm": 0.08,
        "normal_phase_deg": -60,
        "frequency_hz": 50,
    }
    question = asked(one_drive({"static_friction": "0.35:0.45", "friction_ratio": 0.9}, drive, 80.0))
    for digits, most in ((9, 0.08 * (1 + 1e-6)), (4, 0.08 * (1 + 2e-3))):
        row = find(question, {}, digits, until="fastest").row("fastest")
        assert row.frequency_needed_hz is not None
        assert row.amplitude_needed_mm is not None
        x, y = row.amplitude_needed_mm / 1e3, 0.4 * row.amplitude_needed_mm / 1e3
        setting = Setting(x, y, math.radians(-60.0), row.frequency_needed_hz)
        assert 0.08 <= guarantee_of(question.box(setting)).speed_min <= most
