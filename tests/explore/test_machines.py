"""The page of a scene whose amplitude follows from a machine and its filling."""

from __future__ import annotations

import re
from html import unescape
from pathlib import Path

import numpy as np
import pytest
from helpers.cases import each
from helpers.explorers import application, guest
from helpers.packed import FEEDER, unpacked

import vibro
from vibro.errors import InputError
from vibro.explore.answers import Answers
from vibro.explore.controls import CONTROLS
from vibro.explore.form import form_html
from vibro.explore.levels import MapCells
from vibro.explore.state import State, initial_state, read_state
from vibro.quantities import MACHINE, QUANTITIES
from vibro.sweeps.whole import request_of_call

KNOBS = {"setting_percent": "100", "voltage_percent": "100", "filling_kg": "2", "natural_hz": "55.6"}
EMPTY = {"filling_kg": "0", "x": "setting_percent", "y": "voltage_percent"}
FULL = {"x": "frequency_hz", "y": "filling_kg"}


def state_from(folder: Path, text: str) -> State:
    file = folder / "feeder.toml"
    file.write_text(text, encoding="utf-8")
    return initial_state(request_of_call(file, {}))


@pytest.fixture
def feeder(tmp_path: Path) -> State:
    return state_from(tmp_path, FEEDER)


def test_it_begins_with_what_the_machine_has(feeder: State) -> None:
    assert feeder.texts["drive"] == "machine"
    assert KNOBS.items() <= feeder.texts.items()
    assert (feeder.texts["x"], feeder.texts["x_range"]) == ("voltage_percent", "90:110")  # its band
    assert (feeder.texts["y"], feeder.texts["y_range"]) == ("filling_kg", "0:6")
    assert "amplitude_mm" not in feeder.texts
    assert read_state(feeder.texts, feeder) == feeder
    assert read_state({}, feeder) == feeder


def test_knobs_move_the_amplitude(feeder: State) -> None:
    """The worked feeder of docs/theory: below resonance a filling raises the amplitude."""

    def amplitude(**query: str) -> float:
        found = read_state(query, feeder).point.scene().amplitude
        assert found is not None
        return 1e3 * float(found)

    assert amplitude(filling_kg="0") == pytest.approx(0.35, rel=1e-9)
    assert amplitude(filling_kg="0", setting_percent="50") == pytest.approx(0.175, rel=1e-9)
    assert amplitude(filling_kg="0kg", voltage_percent="90 %") == pytest.approx(0.35 * 0.81, rel=1e-9)
    assert amplitude(filling_kg="2000g") == amplitude() > 1.02 * 0.35
    assert amplitude(natural_hz="47.6") < amplitude(natural_hz="47.6", filling_kg="0")


def test_texts_say_all_of_a_state(feeder: State) -> None:
    query = {"setting_percent": "80", "natural_hz": "47.6", "x": "setting_percent", "y": "natural_hz"}
    state = read_state({**query, "x_range": "10:100:log", "target": "12"}, feeder)
    assert read_state(state.texts, feeder) == state
    assert {axis.name for axis in state.grid().axes.values()} == {"setting", "natural"}
    assert {*state.grid().fixed} >= {"voltage", "filling", "frequency"}


@each(
    ("query", "field", "said"),
    [
        ({"setting_percent": "-1"}, "setting_percent", "setting = -1 %: must be in "),
        ({"voltage_percent": "230V"}, "voltage_percent", "no unit of voltage"),
        ({"natural_hz": "stiff"}, "natural_hz", "not a number"),
        ({"x": "amplitude_mm"}, "x", "no axis of this drive"),
        ({"static_friction_band": "0.3:0.4"}, "static_friction_band", "with a filling"),
    ],
)
def test_what_is_wrong_is_told_beside_its_field(
    query: dict[str, str], field: str, said: str, feeder: State
) -> None:
    client = guest(application(Answers(feeder), read=lambda query: read_state(query, feeder)))
    response = client.get("/point", params=query)
    assert response.status_code == 400
    (problem,) = response.json()["problems"]
    assert problem["field"] == field
    assert said in problem["text"]


def test_a_link_to_another_machine_is_refused(feeder: State, tmp_path: Path) -> None:
    other = state_from(tmp_path, FEEDER.replace("counter_mass_kg = 12", "counter_mass_kg = 18"))
    with pytest.raises(InputError, match="the link is of another machine than that of the scene"):
        read_state(feeder.texts, other)
    full = state_from(tmp_path, FEEDER.replace("filling_kg = 2", "filling_kg = 1"))  # a knob
    assert read_state(feeder.texts, full).texts == feeder.texts


def test_other_drives_have_nothing_of_it(feeder: State) -> None:
    line = read_state({"drive": "line"}, feeder)
    assert not KNOBS.keys() & line.texts.keys()
    assert (line.point.machine, line.grid().machine) == (None, None)
    assert line.grid().fixed.keys().isdisjoint(("setting", "voltage", "filling", "natural"))
    axes = {key: feeder.texts[key] for key in ("x", "y", "x_range", "y_range")}
    back = {**line.texts, "drive": "machine", **axes}
    assert read_state(back, feeder).texts == feeder.texts
    assert "machine" not in initial_state().drives


def test_friction_has_bands_where_the_amplitude_does_not_depend_on_it(feeder: State, tmp_path: Path) -> None:
    band = {"static_friction_band": "0.33:0.37"}
    axes = {"x": "setting_percent", "y": "frequency_hz"}
    empty = read_state({**band, **axes, "filling_kg": "0", "setting_percent": "60"}, feeder)
    assert Answers(feeder).point(empty)["guaranteed"].startswith("back-slip, ")
    box = vibro.guarantee(empty.point.scene(), static_friction=(0.33, 0.37), friction_ratio=(0.8, 0.8))
    assert box.speed_min <= float(vibro.solve(empty.point.scene()).mean_velocity) <= box.speed_max
    searched = Answers(feeder).guarantee(empty)["text"]
    assert f"{1e3 * (box.proved_min if box.proof_min == 'proved' else box.speed_min):.6g} mm/s" in searched
    given = state_from(tmp_path, FEEDER.replace("filling_kg = 2", "filling_kg = 2\nadded_mass_share = 0.2"))
    state = read_state({**band, **axes}, given)
    assert unpacked(Answers(given).map(state))[0]["bands"]


@pytest.mark.parametrize("name", MACHINE)
def test_the_ends_of_sliders_and_axes_are_taken(name: str, feeder: State) -> None:
    control = feeder.drives["machine"].controls.get(name, CONTROLS[name])
    column = QUANTITIES[name].column
    assert control.low < float(feeder.texts[column]) <= control.high
    for value in (control.low, control.high):
        read_state({column: str(value)}, feeder)
    read_state({"x": column, "x_range": control.axis, "y": "drive_angle_deg"}, feeder)


def test_the_form_has_knobs_and_packs(feeder: State) -> None:
    page = form_html(feeder)
    for key in KNOBS:
        assert f'<input name="{key}"' in page
    assert '<fieldset data-drives="machine"><legend>Machine</legend>' in page
    assert '<option value="4 &amp; a half" data-patch="natural_hz=47.6">4 &amp; a half</option>' in page
    assert re.search('name="filling_kg"[^>]*type="range" min="0.0" max="6.0" step="0.006"', page)
    assert "Machine" not in form_html(initial_state())


def test_empty_machines_are_as_quick_as_drives_without_one(feeder: State) -> None:
    state = read_state({**EMPTY, "x_range": "20:65"}, feeder)
    shown = MapCells(state.grid()).shown
    assert shown.exact.all()
    wanted = state.grid().solve(state.grid().values())
    assert np.array_equal(shown.cycle.mean_velocity, wanted.mean_velocity, equal_nan=True)


def test_a_map_tells_the_amplitude_of_each_cell(feeder: State) -> None:
    answers = Answers(feeder)
    header, arrays = unpacked(answers.map(read_state({**EMPTY, "view": "speed"}, feeder)))
    setting = np.linspace(header["x"]["from"], header["x"]["to"], header["x"]["count"])
    assert np.allclose(arrays["amplitude"][0], arrays["amplitude"][0, -1] * setting / setting[-1], rtol=1e-6)
    header, arrays = unpacked(answers.map(read_state({**FULL}, feeder)))
    assert "the rest interpolated" in header["progress"]["text"]  # regimes depend on it too
    assert header["curves"]
    assert np.isfinite(arrays["amplitude"]).any()
    assert "amplitude" not in unpacked(answers.map(read_state({"drive": "line"}, feeder)))[1]


def test_warnings_are_those_of_solve(feeder: State) -> None:
    near = read_state({"natural_hz": "50.5", "setting_percent": "20"}, feeder)
    page = unescape(Answers(feeder).point(near)["tables"])
    assert "Warning: the drive is within 2 zeta = 3 % of resonance: the amplitude depends" in page
    far = read_state({"filling_kg": "0", "setting_percent": "50"}, feeder)
    assert "Warning" not in Answers(feeder).point(far)["tables"]


def test_where_springs_strike_the_page_says_so(tmp_path: Path) -> None:
    struck = state_from(tmp_path, FEEDER.replace("filling_kg = 2", "gap_mm = 0.4"))
    client = guest(application(Answers(struck), read=lambda query: read_state(query, struck)))
    for route in ("/point", "/history"):
        response = client.get(route)
        assert response.status_code == 400
        assert "the masses strike: the relative amplitude would be" in response.json()["problems"][0]["text"]
        assert response.json()["hint"].startswith("lower it, such as setting=")
    calm = client.get("/point", params={"setting_percent": "50"})
    assert calm.status_code == 200
    _, arrays = unpacked(client.get("/map", params={"x": "setting_percent", "y": "frequency_hz"}).content)
    assert np.isnan(arrays["amplitude"]).any()
    assert np.isfinite(arrays["amplitude"]).any()


def test_a_history_has_the_amplitude_found(feeder: State) -> None:
    _, arrays = unpacked(Answers(feeder).history(feeder))
    scene = feeder.point.scene()
    assert scene.amplitude is not None
    trough = arrays["trough_displacement"]
    assert np.nanmax(np.abs(trough)) == pytest.approx(1e3 * float(scene.amplitude), rel=1e-3)
    history = vibro.simulate(scene, cycles=feeder.cycles)
    assert np.nanmax(arrays["position"]) == pytest.approx(1e3 * history.phases[-1].end_position, rel=0.05)
