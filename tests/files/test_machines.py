"""Machines of scene files: read exactly, or refused with the key, the value and the remedy."""

from __future__ import annotations

import json
import math
import tomllib
from pathlib import Path

import pytest
from helpers.cases import each
from helpers.machine_files import FEEDER, KINDS, SCENE, written
from jsonschema import Draft202012Validator

from vibro.errors import InputError
from vibro.files.descriptions import SCENE_FILE
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


def test_every_value_may_be_a_text_with_a_unit(tmp_path: Path) -> None:
    texts = FEEDER.replace("= 6\n", '= "6000g"\n').replace("= 55.6\n", '= "3336rpm"\n')
    texts = texts.replace("= 0.35,", '= "350um",')
    with_units, plain = machine(tmp_path, texts), machine(tmp_path, FEEDER)
    assert with_units.own == plain.own
    assert with_units.machine.trough_mass == 6.0
    assert with_units.machine.response(50.0).amplitude == pytest.approx(0.35e-3, rel=1e-14)
    points = KINDS["measured"].replace("[[48.0, ", '[["2880rpm", ')
    assert machine(tmp_path, points).arguments == machine(tmp_path, KINDS["measured"]).arguments


@each("kind", KINDS)
def test_every_kind_makes_a_machine_is_valid_and_the_same_when_written_back(
    tmp_path: Path, kind: str
) -> None:
    given = machine(tmp_path, KINDS[kind])
    assert (given.kind, given.machine.kind) == (kind, kind)
    assert float(given.machine.response(50.0).amplitude) > 0.0
    content = tomllib.loads(SCENE + KINDS[kind])
    assert not [*Draft202012Validator(schema_of(SCENE_FILE)).iter_errors(content)]
    again = machine_of(json.loads(json.dumps(given.table)))
    assert (again.arguments, again.own, again.packs) == (given.arguments, given.own, given.packs)


@each(
    "lines",
    [
        "motors = 2\nstatic_moment_kg_mm = 95",
        'working_moment_kg_cm = 19\nworking_moment_is = "amplitude"',
        f"motors = 2\ncentrifugal_force_n = {0.095 * (50 * math.pi) ** 2!r}\nat_rpm = 1500",
        'motors = 2\nstatic_moment_kg_mm = 95\nworking_moment_kg_cm = 38.1\nworking_moment_is = "stroke"',
    ],
)
def test_a_moment_is_that_of_all_motors(tmp_path: Path, lines: str) -> None:
    text = f'[machine]\nkind = "unbalance"\nvibrating_mass_kg = 120\n{lines}\n'
    assert machine(tmp_path, text).arguments["static_moment"] == pytest.approx(0.19, rel=1e-14)


def test_points_are_those_of_a_file_beside_the_scene(tmp_path: Path) -> None:
    points = KINDS["measured"].split("points = ")[1].split("\n")[0]
    rows = "\n".join(f"{f},{2.0 * a}" for f, a in json.loads(points))
    written(tmp_path, f"frequency_hz,stroke_mm\n{rows}\n", "points.csv")
    of_file = machine(tmp_path, KINDS["measured"].replace(points, '"points.csv"'))
    assert of_file.arguments == machine(tmp_path, KINDS["measured"]).arguments
    assert of_file.table["points"] == json.loads(points)


def test_packs_alone_make_a_machine_whose_force_is_known(tmp_path: Path) -> None:
    text = WITHOUT.replace(WITHOUT.split("\n")[-2], "force_n = 50") + PACKS
    given = machine(tmp_path, text)
    assert "natural" not in given.own
    assert given.pack("8 leaves") == 55.6
    with pytest.raises(InputError, match="'9 leaves'"):
        given.pack("9 leaves")
