"""Machines of scene files: read exactly, or refused with the key, the value and the remedy."""

from __future__ import annotations

import json
import math
import tomllib
from pathlib import Path

import pytest
from helpers.cases import each
from helpers.machine_files import FEEDER, KINDS, SCENE, UNBALANCE, feeder, written
from jsonschema import Draft202012Validator

from vibro.errors import FileError, InputError
from vibro.files.descriptions import MACHINE_KEYS, SCENE_FILE
from vibro.files.json_schema import schema_of
from vibro.files.machines import GivenMachine, machine_of
from vibro.files.scene_files import read_scene_file

PACKS = """
[[machine.pack]]
name = "6 leaves"
natural_hz = 47.6
[[machine.pack]]
name = "8 leaves"
natural_hz = 55.6
"""
WITHOUT = FEEDER.replace("natural_hz = 55.6\n", "")


def machine(folder: Path, text: str) -> GivenMachine:
    found = read_scene_file(written(folder, SCENE + text)).machine
    assert found is not None
    return found


def test_a_machine_is_read_exactly(tmp_path: Path) -> None:
    more = 'voltage_percent = "90:110"\nsetting_percent = "40:80"\nfilling_kg = "0:2kg"\n' + PACKS
    given = machine(tmp_path, FEEDER + more)
    assert given.table == tomllib.loads(FEEDER + more)["machine"]
    assert given.packs == {"6 leaves": 47.6, "8 leaves": 55.6}
    assert given.bands == {"setting": (40.0, 80.0), "voltage": (90.0, 110.0), "filling": (0.0, 2.0)}
    # the upper end of the setting's band, the nominal voltage, an empty trough
    assert given.own == {"setting": 80.0, "voltage": 100.0, "filling": 0.0, "natural": 55.6}
    made = given.machine
    assert (made.kind, made.trough_mass, made.counter_mass) == ("magnet", 6.0, 12.0)
    assert (made.natural_frequency, made.damping_ratio, made.voltage_exponent) == (55.6, 0.015, 2.0)
    assert made.response(50.0).amplitude == pytest.approx(0.35e-3, rel=1e-14)


def test_a_band_of_voltage_without_the_nominal_one_stands_for_its_middle(tmp_path: Path) -> None:
    assert machine(tmp_path, FEEDER + 'voltage_percent = "80:90"\n').own["voltage"] == 85.0


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_makes_a_machine_and_is_valid(tmp_path: Path, kind: str) -> None:
    given = machine(tmp_path, KINDS[kind])
    assert (given.kind, given.machine.kind) == (kind, kind)
    assert float(given.machine.response(50.0).amplitude) > 0.0
    content = tomllib.loads(SCENE + KINDS[kind])
    assert not [*Draft202012Validator(schema_of(SCENE_FILE)).iter_errors(content)]


@pytest.mark.parametrize("kind", KINDS)
def test_a_table_that_is_written_back_makes_the_same_machine(tmp_path: Path, kind: str) -> None:
    given = machine(tmp_path, KINDS[kind])
    again = machine_of(json.loads(json.dumps(given.table)))
    assert (again.arguments, again.own, again.packs) == (given.arguments, given.own, given.packs)


@each(
    ("lines", "moment"),
    [
        ("motors = 2\nstatic_moment_kg_mm = 95", 0.19),
        ('working_moment_kg_cm = 19\nworking_moment_is = "amplitude"', 0.19),
        ('working_moment_kg_cm = 38\nworking_moment_is = "stroke"', 0.19),
        (f"motors = 2\ncentrifugal_force_n = {0.095 * (50 * math.pi) ** 2!r}\nat_rpm = 1500", 0.19),
        (f"motors = 2\ncentrifugal_force_n = {0.095 * (50 * math.pi) ** 2!r}\nat_hz = 25", 0.19),
        (
            'motors = 2\nstatic_moment_kg_mm = 95\nworking_moment_kg_cm = 38.1\nworking_moment_is = "stroke"',
            0.19,
        ),
    ],
)
def test_a_moment_is_that_of_all_motors(tmp_path: Path, lines: str, moment: float) -> None:
    text = f'[machine]\nkind = "unbalance"\nvibrating_mass_kg = 120\n{lines}\n'
    assert machine(tmp_path, text).arguments["static_moment"] == pytest.approx(moment, rel=1e-14)


def test_points_are_those_of_a_file_beside_the_scene(tmp_path: Path) -> None:
    points = KINDS["measured"].split("points = ")[1].split("\n")[0]
    rows = "\n".join(f"{f},{2.0 * a}" for f, a in json.loads(points))
    written(tmp_path, f"frequency_hz,stroke_mm\n{rows}\n", "points.csv")
    of_file = machine(tmp_path, KINDS["measured"].replace(points, '"points.csv"'))
    assert of_file.arguments == machine(tmp_path, KINDS["measured"]).arguments
    assert of_file.table["points"] == [tuple(point) for point in json.loads(points)]


def test_packs_alone_make_a_machine_whose_force_is_known(tmp_path: Path) -> None:
    text = WITHOUT.replace(WITHOUT.split("\n")[-2], "force_n = 50") + PACKS
    given = machine(tmp_path, text)
    assert "natural" not in given.own
    assert given.pack("8 leaves") == 55.6
    with pytest.raises(InputError, match="no spring pack '9 leaves'") as caught:
        given.pack("9 leaves")
    assert "did you mean" in caught.value.hint


@each(
    ("text", "problem", "hint"),
    [
        ("[machine]\n", "kind is missing", 'kind = "magnet"'),
        ('[machine]\nkind = "magnetic"\n', "kind = 'magnetic'", "did you mean 'magnet'?"),
        (WITHOUT, "natural_hz is missing", "which side of resonance it runs on is never assumed"),
        (WITHOUT + PACKS, "calibration was measured with one of the packs", "give natural_hz of that one"),
        (FEEDER + "force_n = 20\n", "force_n and calibration are both given", "give one of them"),
        (FEEDER.replace("calibration", "#"), "force_n or calibration is missing", "calibration = {"),
        (
            FEEDER.replace("amplitude_mm = 0.35, ", ""),
            "calibration: amplitude_mm is missing",
            "amplitude_mm = 0.35",
        ),
        (FEEDER.replace("frequency_hz = 50, s", "s"), "calibration: frequency_hz is missing", "= 50"),
        (FEEDER.replace("setting_percent", "settings"), "unknown key 'settings'", "setting_percent"),
        (FEEDER.replace("trough_mass_kg = 6\n", ""), "trough_mass_kg is missing", "trough_mass_kg = 6"),
        (FEEDER.replace("damping_ratio = 0.015\n", ""), "damping_ratio is missing", "damping_ratio = 0.015"),
        (FEEDER + "motors = 2\n", "motors = 2: does not belong to a machine of kind magnet", "unbalance"),
        (UNBALANCE + "natural_hz = 3\n", "natural_hz = 3: does not belong", "mount_hz"),
        (UNBALANCE + "voltage_percent = 90\n", "voltage_percent = 90: does not belong", "magnet"),
        (KINDS["crank"] + "setting_percent = 50\n", "setting_percent = 50: does not belong", "magnet"),
        (UNBALANCE.replace("motors = 2\n", ""), "that of one motor, and motors is missing", "motors = 2"),
        (UNBALANCE.replace("static_moment_kg_mm = 95", ""), "the moment is missing", "working_moment_kg_cm"),
        (
            UNBALANCE.replace("motors = 2\nstatic_moment_kg_mm = 95", "working_moment_kg_cm = 19"),
            "working_moment_kg_cm = 19: makers print",
            'working_moment_is = "amplitude" or working_moment_is = "stroke"',
        ),
        (
            UNBALANCE + 'working_moment_kg_cm = 38\nworking_moment_is = "amplitude"\n',
            "moments of 190 kg mm and 380 kg mm of all motors: 2 times as much",
            "of one motor or of all, of amplitude or of stroke",
        ),
        (
            UNBALANCE + 'working_moment_kg_cm = 23\nworking_moment_is = "amplitude"\n',
            "1.211 times as much",
            "give the one that you are sure of",
        ),
        (UNBALANCE + "centrifugal_force_n = 2344\n", "at_hz or at_rpm is missing", "at_rpm = 1500"),
        (UNBALANCE + "at_rpm = 1500\n", "given without centrifugal_force_n", "leave it out"),
        (UNBALANCE + 'working_moment_is = "stroke"\n', "without working_moment_kg_cm", "leave it out"),
        (UNBALANCE.replace("motors = 2", "motors = 1.5"), "motors = 1.5: must be a whole number", ""),
        (FEEDER + "added_damping_share = 0.2\n", "added_damping_share is given alone", "added_mass_share"),
        (
            FEEDER + '[[machine.pack]]\nname = "a"\nnatural_hz = 50\n' * 2,
            "pack 'a' is given twice",
            "differently",
        ),
        (FEEDER + 'voltage_percent = "110:90"\n', "must be lo:hi with lo at most hi", "lower end first"),
        (FEEDER.replace("= 12", '= "ground"'), "counter_mass_kg = 'ground'", ""),
        (KINDS["measured"].replace('law = "constant"', ""), "law is missing", 'law = "constant"'),
    ],
)  # fmt: skip
def test_what_is_wrong_in_a_machine_is_named(tmp_path: Path, text: str, problem: str, hint: str) -> None:
    with pytest.raises(InputError) as caught:
        _ = machine(tmp_path, text).machine
    assert problem in str(caught.value)
    assert hint in caught.value.hint


def test_a_file_of_points_that_is_missing_is_named(tmp_path: Path) -> None:
    written(tmp_path, "40,0.5\n", "point.csv")
    with pytest.raises(FileError, match=r"cannot read .*points.csv") as caught:
        machine(
            tmp_path, KINDS["measured"].replace(KINDS["measured"].split("\n")[3], 'points = "points.csv"')
        )
    assert "did you mean" in caught.value.hint


def test_every_key_belongs_to_a_kind(tmp_path: Path) -> None:
    """None is described that every kind refuses."""
    for entry in MACHINE_KEYS:
        if entry.key == "kind":
            continue
        refused = 0
        for kind in KINDS:
            with pytest.raises(InputError) as caught:
                machine_of({"kind": kind, entry.key: entry.example or 0.5, "xyzzy": 1})
            assert "xyzzy" in str(caught.value)
            try:
                machine_of({"kind": kind, entry.key: _value(entry.key)})
            except InputError as exc:
                refused += "does not belong" in str(exc)
        assert refused < len(KINDS), entry.key


def _value(key: str) -> object:
    words = {"working_moment_is": "stroke", "law": "square", "points": [[40, 1]], "motors": 1}
    tables = {
        "calibration": {"amplitude_mm": 1, "frequency_hz": 50},
        "pack": [{"name": "a", "natural_hz": 50}],
    }
    return (words | tables).get(key, 0.5)


def test_a_machine_lies_beside_its_scene(tmp_path: Path) -> None:
    assert read_scene_file(feeder(tmp_path)).scene.keys() == {
        "frequency", "drive_angle", "static_friction", "kinetic_friction",
    }  # fmt: skip
    assert read_scene_file(written(tmp_path, SCENE)).machine is None


def test_the_docs_show_a_machine_that_is_read(tmp_path: Path) -> None:
    page = (Path(__file__).parents[2] / "docs" / "guide" / "files.md").read_text(encoding="utf-8")
    text = next(block for block in page.split("```toml\n") if block.startswith("[machine]")).split("```")[0]
    given = machine(tmp_path, text)
    assert (given.packs, given.bands["filling"]) == ({"4 leaves": 47.6}, (0.0, 2.0))
    assert given.machine.response(50.0).amplitude == pytest.approx(0.35e-3)
