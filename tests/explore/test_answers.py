"""What the page is told of the operating point, its motion and its map, beside what the commands say."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.cases import each
from helpers.commands import rows_of
from helpers.packed import state_of, table_of, unpacked

import vibro
from vibro.core.codes import PHASE_NAMES
from vibro.explore import bands
from vibro.explore.answers import Answers
from vibro.explore.controls import CONTROLS, DRIVES, drives_of
from vibro.explore.state import State, initial_state, read_state
from vibro.quantities import MACHINE, QUANTITIES, SWEPT
from vibro.sweeps.whole import request_of_call


@pytest.fixture
def answers() -> Answers:
    return Answers(initial_state())


def test_what_holds_for_bands_is_told(answers: Answers) -> None:
    point = answers.point(state_of(static_friction_band="0.7:0.75"))
    assert point["guaranteed"].startswith("forward-slip, at least ")
    least = float(point["guaranteed"].split()[-2])
    scene = state_of().point.scene()
    box = vibro.guarantee(scene, static_friction=(0.7, 0.75), friction_ratio=(0.57 / 0.74, 0.57 / 0.74))
    assert least == pytest.approx(1e3 * box.speed_min, rel=1e-5)
    assert "no bands" in point["apart"]
    plain = answers.point(state_of())
    assert (plain["guaranteed"], plain["unproved"], plain["apart"]) == ("", False, "")


def test_where_no_speed_is_proved_one_is_searched_for(answers: Answers) -> None:
    state = state_of(static_friction_band="0.6:0.8", friction_ratio_band="0.7:0.8", frequency_hz="18")
    point = answers.point(state)
    assert (point["guaranteed"], point["unproved"]) == ("back-slip, least speed not proved here", True)
    assert not answers.point(state_of(static_friction_band="0.7:0.75"))["unproved"]
    box = vibro.guarantee(state.point.scene(), static_friction=(0.6, 0.8), friction_ratio=(0.7, 0.8))
    least, most = (f"{1e3 * speed:.6g} mm/s (proved)" for speed in (box.proved_min, box.proved_max))
    assert (box.proof_min, box.proof_max) == ("proved", "proved")
    assert answers.guarantee(state) == {"text": f"back-slip, at least {least}, at most {most}"}


def test_of_a_searched_speed_what_is_proved_is_told_too(
    answers: Answers, monkeypatch: pytest.MonkeyPatch
) -> None:
    def guarantee(scene: vibro.Scene, **of: Any) -> Any:
        found = vibro.guarantee(scene, **of)
        return replace(found, proof_min="searched", proved_min=0.012, excluded=3)

    monkeypatch.setattr(bands, "guarantee", guarantee)
    text = answers.guarantee(state_of(static_friction_band="0.62:0.8", frequency_hz="18"))["text"]
    assert " mm/s (searched; 12 proved), at most " in text
    assert text.endswith(", 3 bodies of unknown speed left out")


def test_a_search_is_kept_for_another_view_and_not_for_another_band(
    answers: Answers, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[dict[str, Any]] = []

    def guarantee(scene: vibro.Scene, **bands_of: Any) -> Any:
        asked.append(bands_of)
        return vibro.guarantee(scene, **bands_of)

    monkeypatch.setattr(bands, "guarantee", guarantee)
    query = {"static_friction_band": "0.61:0.79", "frequency_hz": "18"}
    texts = [answers.guarantee(state_of(**query, **more))["text"] for more in ({}, {"view": "speed"})]
    assert texts[0] == texts[1]
    assert len(asked) == 1
    other = {"follow": "0", "kinetic_friction_band": "0.5:0.6"}
    assert answers.guarantee(state_of(**query, **other))["text"] != texts[0]
    assert asked[1] == {"static_friction": (0.61, 0.79), "kinetic_friction": (0.5, 0.6)}


def test_where_bodies_run_away_the_search_says_so(answers: Answers) -> None:
    state = state_of(static_friction_band="0.3:0.8", trough_angle_deg="-30")
    assert answers.point(state)["unproved"]
    assert answers.guarantee(state)["text"] == "forward-slip, a body runs away or has no steady motion"


@pytest.mark.parametrize(
    ("given", "alone", "following"),
    [
        ({}, ("0.666:0.814", "0.513:0.627", None), ("0.666:0.814", None, None)),
        ({"friction_ratio_band": "0.7:0.9"}, (None, "0.518:0.666", None), (None, None, "0.7:0.9")),
        ({"kinetic_friction_band": "0.37:0.74"}, (None, "0.37:0.74", None), (None, None, "0.5:1")),
        ({"kinetic_friction_band": "0.37:0.9"}, (None, "0.37:0.9", None), (None, None, "0.5:1")),
    ],
)
def test_bands_move_between_kinetic_friction_and_its_ratio(
    answers: Answers, given: dict[str, str], alone: tuple[str | None], following: tuple[str | None]
) -> None:
    keys = ("static_friction_band", "kinetic_friction_band", "friction_ratio_band")
    bands = answers.point(state_of(**given))["bands"]
    assert [tuple(chosen.get(key) for key in keys) for chosen in bands] == [alone, following]
    for chosen in bands:
        state_of(**chosen)


def test_a_table_of_bands_says_what_is_certain(answers: Answers) -> None:
    rows = rows_of(table_of(answers, state_of(static_friction_band="0.6:0.8")))
    assert [*rows[0]] == [
        "amplitude_mm", "frequency_hz", "lowest_regime", "highest_regime", "guaranteed_speed_mm_s",
    ]  # fmt: skip
    assert {row["lowest_regime"] for row in rows} == {"no-slip", "forward-slip", "back-slip", "hopping"}
    fastest = max(rows, key=lambda row: float(row["guaranteed_speed_mm_s"] or 0.0))
    given = {name: fastest[name] for name in ("amplitude_mm", "frequency_hz")}
    box = vibro.guarantee(
        state_of(**given).point.scene(), static_friction=(0.6, 0.8), friction_ratio=(0.57 / 0.74,) * 2
    )
    assert float(fastest["guaranteed_speed_mm_s"]) == pytest.approx(1e3 * box.speed_min, rel=1e-5)


def test_a_table_of_a_map_that_is_not_done_is_exact(answers: Answers) -> None:
    state = state_of(x="drive_angle_deg", y="static_friction", amplitude_mm="1.5", frequency_hz="30")
    before = table_of(answers, state)
    for _ in range(200):
        header, _ = unpacked(answers.map(state, advance=True))
        if header["progress"]["done"]:
            break
    assert header["progress"]["done"]
    assert table_of(answers, state) == before


def test_a_table_may_have_decimal_commas(answers: Answers) -> None:
    state = state_of(trough_length_mm="600.5", x_range="5:14")  # in contact: no pattern has points
    plain = table_of(answers, state)
    commas = b"".join(answers.table(state, decimal_comma=True)).decode()
    assert commas == plain.replace(",", ";").replace(".", ",")
    assert ";600,5;" in commas


def test_a_history_is_what_simulate_gives(answers: Answers) -> None:
    state = state_of(cycles="2", drive_angle_deg="35", amplitude_mm="2.5")
    header, arrays = unpacked(answers.history(state))
    history = vibro.simulate(state.point.scene(), cycles=2)
    assert header["duration_ms"] == 1e3 * history.end
    assert [phase["kind"] for phase in header["phases"]] == [phase.kind for phase in history.phases]
    assert header["phases"][0]["name"] == PHASE_NAMES[history.phases[0].kind]
    assert [panel["name"] for panel in header["panels"]] == [
        "trough",
        "forces",
        "velocity",
        "position",
        "gap",
    ]
    times = np.clip(arrays["time"].astype(float) * 1e-3, 0.0, history.end)
    inside = np.ones(times.shape, np.bool_)
    for phase in history.phases:  # times are single: at an event either side will do
        inside &= np.abs(times - phase.start) > 1e-6
    sample = history.sample(times[inside])
    assert np.allclose(arrays["position"][inside], 1e3 * sample.position, rtol=1e-3, atol=1e-4)
    assert np.allclose(arrays["gap"][inside], 1e3 * sample.gap, rtol=1e-3, atol=1e-4)
    flies = arrays["gap"] > 1e-3
    assert flies.any()
    assert np.isnan(arrays["inertial"][flies]).all()
    assert {curve["array"] for panel in header["panels"] for curve in panel["curves"]} <= {*arrays}


def test_histories_of_other_drives(answers: Answers) -> None:
    header, arrays = unpacked(answers.history(state_of(drive="ellipse")))
    assert [curve["array"] for curve in header["panels"][0]["curves"]] == ["trough_normal", "trough_along"]
    assert "gap" not in arrays
    header, arrays = unpacked(answers.history(state_of(drive="harmonics")))
    assert [curve["array"] for curve in header["panels"][0]["curves"]] == ["trough_normal", "trough_along"]
    assert arrays["time"].size > 100


def test_a_history_of_a_body_without_friction_has_forces_of_any_size(answers: Answers) -> None:
    header, _ = unpacked(answers.history(state_of(static_friction="0", kinetic_friction="0")))
    assert header["panels"][1]["name"] == "forces"
    assert header["panels"][1]["low"] < -8.0  # the inertial load [m/s^2], which nothing bounds here
    assert header["panels"][1]["high"] > 8.0


def test_the_axis_of_forces_is_that_of_friction_where_the_load_is_far_larger(answers: Answers) -> None:
    header, arrays = unpacked(answers.history(state_of(static_friction="0.1", kinetic_friction="0.08")))
    forces = header["panels"][1]
    most = arrays["static_limit"].max()
    assert 5.0 * most < np.abs(arrays["inertial"]).max()
    assert -2.0 * most < forces["low"] < -most
    assert most < forces["high"] < 2.0 * most
    cut = [curve["array"] for curve in forces["curves"] if curve["label"].endswith("(cut off)")]
    assert cut == ["inertial"]


def test_a_schema_tells_what_says_nothing_of_a_drive(answers: Answers) -> None:
    schema = json.loads(json.dumps(answers.schema(), allow_nan=False))
    assert schema["initial"] == initial_state().texts
    columns = {QUANTITIES[n].column for n in CONTROLS if drives_of(n, DRIVES)} - {"friction_ratio"}
    for drive, idle in schema["idle"].items():
        assert columns & {*state_of(drive=drive).texts} == columns - {*idle}
        assert {"motion_scale", "normal_acceleration_m_s2"} <= {*idle}


@pytest.fixture
def clamped(tmp_path: Path) -> State:
    """State of a clamped part under three harmonics."""
    file = tmp_path / "clamped.toml"
    file.write_text(
        "[scene]\nalong_amplitudes_mm = [1, 0.3, 0.1]\nalong_phases_deg = [0, -90, 20]\nfrequency_hz = 25\n"
        "static_friction = 0.4\nkinetic_friction = 0.3\nnormal_acceleration_m_s2 = 20\n",
        encoding="utf-8",
    )
    return initial_state(request_of_call(file, {}))


@each("name", [name for name in CONTROLS if name not in MACHINE])
def test_the_ends_of_sliders_and_axes_are_taken(name: str, clamped: State) -> None:
    def state_of(**query: str) -> State:
        return read_state(query, clamped)

    control, column = CONTROLS[name], QUANTITIES[name].column
    drive = {"drive": drives_of(name, clamped.drives)[0]}
    assert control.low < control.high
    if name not in ("friction_ratio", "kinetic_friction"):  # which is at most the static one
        frictions = {} if name == "static_friction" else {"static_friction": "2"}
        for value in (control.low, control.high):
            state_of(**{"kinetic_friction": "0", **frictions, column: str(value)}, **drive)
    if name in SWEPT:
        other = {"y": "restitution" if name != "restitution" else "frequency_hz"}
        state_of(x=column, x_range=control.axis, **other, **drive)
