"""Elliptical drives on the command line: options, scene files, axes, columns, errors, pictures."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import pytest
from helpers.commands import ELLIPSE, Run, rows_of

import vibro

pytestmark = pytest.mark.usefixtures("unsaved")

VALUES: dict[str, Any] = {
    "along_amplitude": 1e-3,
    "normal_amplitude": 0.3e-3,
    "normal_phase": math.radians(-60.0),
    "frequency": 25.0,
    "static_friction": 0.4,
    "kinetic_friction": 0.3,
}
ELLIPSE_FILE = """
[scene]
along_amplitude_mm = 1
normal_amplitude_mm = 0.3
normal_phase_deg = -60
frequency_hz = 25
static_friction = 0.4
kinetic_friction = 0.3
trough_length_mm = 600
"""
LINE_FILE = """
[scene]
amplitude_mm = 1
drive_angle_deg = 20
frequency_hz = 25
static_friction = 0.4
kinetic_friction = 0.3
"""


def written(folder: Path, text: str, name: str = "drive.toml") -> Path:
    file = folder / name
    file.write_text(text, encoding="utf-8")
    return file


# --- one scene --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "phase", ["phase=-60deg", "phase=300", "normal_phase_deg=-60", "phi = \N{MINUS SIGN}60"]
)
def test_a_quantity_has_several_names(run: Run, phase: str) -> None:
    rest = [text for text in ELLIPSE if not text.startswith("phase")]
    answer = json.loads(run("solve", *rest, phase, "--json").stdout)
    expected = 1e3 * vibro.solve(vibro.Scene(**VALUES)).mean_velocity
    assert answer["mean_velocity_mm_s"] == pytest.approx(expected, rel=1e-13)


# --- what is missing, mixed or refused --------------------------------------------------------------


def test_a_speed_is_found_for_the_line_that_replaces_an_ellipse(run: Run, tmp_path: Path) -> None:
    assert run("solve", written(tmp_path, ELLIPSE_FILE), "--speed", "5", "-a", "20").exit_code == 0


def test_a_drive_given_whole_takes_the_place_of_a_file_s(run: Run, tmp_path: Path) -> None:
    line, ellipse = written(tmp_path, LINE_FILE), tmp_path / "ellipse.toml"
    ellipse.write_text(ELLIPSE_FILE, encoding="utf-8")
    answer = json.loads(run("solve", line, "along=1", "normal=.3", "phase=-60", "--json").stdout)
    assert answer["mean_velocity_mm_s"] == pytest.approx(89.0577, rel=1e-6)
    assert "amplitude_mm" not in answer
    answer = json.loads(run("solve", ellipse, "--stroke", "2", "-a", "20", "--json").stdout)
    assert (answer["amplitude_mm"], answer["drive_angle_deg"]) == (1.0, 20.0)
    assert json.loads(run("solve", ellipse, "phase=30", "--json").stdout)["normal_phase_deg"] == 30.0


def test_a_file_s_map_may_sweep_another_drive_than_its_scene(run: Run, tmp_path: Path) -> None:
    table = '[map]\nalong_amplitude_mm = "0.5:1.5:3"\nnormal_amplitude_mm = 0.3\n'
    rows = rows_of(run("map", written(tmp_path, LINE_FILE + table), "-o", "-").stdout)
    assert [row["along_amplitude_mm"] for row in rows] == ["0.5", "1", "1.5"]
    assert {row["normal_phase_deg"] for row in rows} == {"0"}
    half = run(
        "map", written(tmp_path, LINE_FILE + table.splitlines(keepends=True)[0] + "normal_phase_deg = 1\n")
    )
    assert half.exit_code == 2


# --- sweeps -----------------------------------------------------------------------------------------
