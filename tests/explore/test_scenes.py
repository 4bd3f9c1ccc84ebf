"""What the page begins with: the scene of a file, its sliders, its axes, its motion or machine."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.cases import each
from helpers.explored_scenes import FEEDER, GIVEN_DRIVES

import vibro
from vibro.explore.controls import CONTROLS
from vibro.explore.scenes import USUAL, request_of_scene, scene_data, typed_number
from vibro.files.machines import machine_of
from vibro.quantities import MACHINE, QUANTITIES, SWEPT, scene_fields
from vibro.sweeps.whole import read_scene, request_of_call

EXAMPLES = Path(__file__).parents[2] / "examples"
SCENES = sorted(path for path in EXAMPLES.glob("*.toml") if not path.stem.startswith("design"))
BODY = ("frequency", "static_friction", "kinetic_friction")
FRICTIONS = {"static_friction": 0.4, "friction_ratio": 0.8}


def data_of(folder: Path, text: str) -> dict[str, Any]:
    file = folder / "given.toml"
    file.write_text(text, encoding="utf-8")
    return scene_data(request_of_call(file, {}))


def test_it_begins_with_the_nut_of_the_example() -> None:
    nut = scene_data(request_of_call(EXAMPLES / "safety_nut.toml", {}))
    named = {
        "x": "frequency_hz",
        "y": "amplitude_mm",
        "x_range": "5:60",
        "y_range": "0.1:3",
    }  # as in pictures
    assert named.items() <= nut["state"].items()
    own = {"amplitude": 1.0, "frequency": 15.0, "drive_angle": 20.0, "static_friction": 0.74}
    assert {name: float(nut["state"][QUANTITIES[name].column]) for name in own} == own
    assert {name: USUAL[name] for name in own} == own
    assert (nut["name"], nut["given"], nut["machine"]) == ("safety_nut", None, None)


@each("value", [0.1, 1 / 3, 1e-300, 5e-324, 1.7976931348623157e308, 123456789.123456789])
def test_a_number_is_read_as_it_was(value: float) -> None:
    assert float(typed_number(value)) == value
    assert len(typed_number(0.1 + 0.2)) > len(typed_number(0.3))


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_every_scene_of_the_examples_can_be_explored(path: Path) -> None:
    request = request_of_call(path, {})
    data = scene_data(request)
    state = data["state"]
    assert data["name"] == path.stem
    for name in (*request.fixed, *request.varying):
        if name in ("friction_ratio", "along_phase") or name in (data["given"] or {"values": ()})["values"]:
            continue
        value = float(state[QUANTITIES[name].column])
        slider = data["controls"].get(name) or CONTROLS[name]._asdict()
        assert slider["low"] <= value <= slider["high"]
        assert value == request.fixed.get(name, request.own.get(name, value))
    assert all(state[key] in {QUANTITIES[n].column for n in SWEPT} for key in "xy" if state[key])


def test_one_axis_of_a_scene_gets_another_beside_it() -> None:
    drive = {"amplitude_mm": "0.5:2:9", "frequency_hz": 20, "drive_angle_deg": 20}
    state = scene_data(request_of_call(None, {**drive, **FRICTIONS}))["state"]
    assert [state[key] for key in ("x", "x_range", "y", "y_range")] == [
        "amplitude_mm", "0.5:2", "frequency_hz", "",
    ]  # fmt: skip
    assert float(state["amplitude_mm"]) == 1.25
    assert state["kinetic_friction"] == "0.32"
    assert state["trough_length_mm"] == ""


def test_sliders_reach_what_a_scene_has() -> None:
    far = {"amplitude_mm": 12, "frequency_hz": 0.5, "drive_angle_deg": 20, "trough_angle_deg": -60}
    controls = scene_data(request_of_call(None, {**far, **FRICTIONS}))["controls"]
    assert {name: (one["low"], one["high"]) for name, one in controls.items()} == {
        "amplitude": (0.01, 24.0),
        "frequency": (0.5, 120.0),
        "trough_angle": (-90.0, 20.0),
    }


@pytest.mark.parametrize("name", GIVEN_DRIVES)
def test_a_motion_stays_as_the_scene_gives_it(name: str, tmp_path: Path) -> None:
    data = data_of(tmp_path, GIVEN_DRIVES[name])
    given, state = data["given"], data["state"]
    assert (state["drive"], given["x"], given["y"]) == ("given", "frequency", "motion_scale")
    assert given["values"].keys().isdisjoint(given["quantities"])
    table = tomllib.loads("\n".join(given["table"]))
    written = tomllib.loads(GIVEN_DRIVES[name])
    assert table == written.get("motion", {})
    columns = read_scene(tmp_path / "given.toml").arrays().columns()
    if given["kind"] == "pieces":
        assert given["motion"]["breaks"] == columns.breaks.tolist()
        assert given["motion"]["pieces"] == columns.pieces.ravel().tolist()
        assert given["motion"]["unit"] == columns.unit
        return
    moved = {n: float(state.get(QUANTITIES[n].column, USUAL.get(n, 1.0))) for n in given["quantities"]}
    values = {**given["values"], **moved}
    again = vibro.Scene(**scene_fields({**values, **dict.fromkeys(BODY, 0.1)}))
    theirs = read_scene(tmp_path / "given.toml")
    assert again.along_harmonics is None or np.allclose(again.along_harmonics, theirs.along_harmonics or [])
    for field in ("along_amplitude", "normal_amplitude", "normal_acceleration"):
        assert getattr(again, field) == getattr(theirs, field)


def test_motions_are_told_apart_and_so_are_machines(tmp_path: Path) -> None:
    """The address does not hold the motion: it must not show that of another scene file."""
    told = {data_of(tmp_path, text)["state"]["motion"] for text in GIVEN_DRIVES.values()}
    assert len(told) == len(GIVEN_DRIVES)

    def motion(text: str) -> str:
        return str(data_of(tmp_path, text)["state"]["motion"])

    own = motion(FEEDER)
    assert motion(FEEDER.replace("filling_kg = 2", "filling_kg = 1")) == own  # a knob
    assert motion(FEEDER.replace("mass_kg = 12", "mass_kg = 18")) not in (own, "")
    assert scene_data()["state"]["motion"] == ""


def test_a_machine_comes_with_all_that_its_operating_point_needs(tmp_path: Path) -> None:
    data = data_of(tmp_path, FEEDER)
    state, machine = data["state"], data["machine"]
    assert state["drive"] == "machine"
    assert {"setting_percent": "100", "filling_kg": "2", "natural_hz": "55.6"}.items() <= state.items()
    assert (state["x"], state["x_range"]) == ("voltage_percent", "90:110")  # its band
    assert (machine["knobs"], machine["packs"]) == ([*MACHINE], {"6 leaves": 55.6, "4 & a half": 47.6})
    fields = {key: value for key, value in machine["fields"].items() if key != "share"}
    assert vibro.Machine(**fields) == machine_of(tomllib.loads(FEEDER)["machine"]).machine
    assert (
        tomllib.loads("\n".join(f"{k} = {v}" for k, v in machine["table"].items()))
        == tomllib.loads(FEEDER)["machine"]
    )
    controls = data["controls"]
    assert controls["filling"] == {"low": 0.0, "high": 6.0, "step": 0.006, "axis": "0:6"}
    for name in ("frequency", "natural"):  # to both sides of resonance
        assert controls[name]["low"] < min(50.0, 55.6) < max(50.0, 55.6) < controls[name]["high"]


@pytest.mark.parametrize(
    "drive",
    [
        {"amplitude": 1e-3, "drive_angle": 0.35},
        {"motion": vibro.Motion.steps([(0.8, 2.4), (0.2, -9.6)])},
        {"motion": vibro.Motion.samples([0, 3, 4, 3, 0, -3, -4, -3], [0, 1, 0, -1, 0, 1, 0, -1])},
        {"along_harmonics": [(1e-3, 0.1), (2e-4, 0.3), (1e-4, 0.5)]},
    ],
    ids=["line", "steps", "samples", "harmonics"],
)
def test_a_scene_of_python_is_one_of_a_file(drive: dict[str, Any], tmp_path: Path) -> None:
    scene = vibro.Scene(**drive, frequency=5, static_friction=0.4, kinetic_friction=0.3)
    request = request_of_scene(scene)
    again = request.scene()
    assert float(vibro.solve(again).mean_velocity) == pytest.approx(float(vibro.solve(scene).mean_velocity))
    data = scene_data(request)
    if data["given"] and data["given"]["table"]:
        (file := tmp_path / "again.toml").write_text(
            "[scene]\nfrequency_hz = 5\nstatic_friction = 0.4\nkinetic_friction = 0.3\n[motion]\n"
            + "\n".join(data["given"]["table"]),
            encoding="utf-8",
        )
        ours, theirs = (one.arrays().columns().pieces for one in (read_scene(file), scene))
        assert np.allclose(ours, theirs, rtol=1e-12, atol=1e-12)


def test_several_scenes_of_python_are_refused() -> None:
    body = {"drive_angle": 0.35, "static_friction": 0.7, "kinetic_friction": 0.5}
    with pytest.raises(vibro.SceneError, match="one operating point"):
        vibro.page(vibro.Scene(amplitude=[1e-3, 2e-3], frequency=15, **body))
    with pytest.raises(vibro.InputError, match=r"scene = 3: must be a vibro\.Scene"):
        vibro.page(3)  # type: ignore[arg-type]
