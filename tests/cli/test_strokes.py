"""A stroke that is given is what people are told; tables keep the amplitude."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import openpyxl
import pytest

if TYPE_CHECKING:
    from helpers.commands import Run

pytestmark = pytest.mark.usefixtures("unsaved")

SCENE = """
[scene]
stroke_mm = 1.7
frequency_hz = 16
drive_angle_deg = 20
static_friction = 0.74
kinetic_friction = 0.57
trough_length_mm = 600
"""


@pytest.fixture
def scene() -> Path:
    path = Path("feeder.toml")
    path.write_text(SCENE)
    return path


def test_the_strokes_that_reach_a_speed(run: Run, scene: Path) -> None:
    strokes = run("solve", scene, "--speed", "20mm/s").stdout
    assert "stroke from [mm]" in strokes
    assert "amplitude" not in strokes
    found = json.loads(run("solve", scene, "--speed", "20mm/s", "--json").stdout)["amplitudes"][0]
    _, row, *_ = strokes.partition("stroke from [mm]")[2].splitlines()
    low = float(row.split()[0])
    assert low == pytest.approx(2 * found["amplitude_low_mm"], rel=1e-5)


def test_workbooks_are_in_strokes(run: Run, scene: Path, no_pictures: None) -> None:
    args = ("map", scene, "--stroke", "1:3:5", "-f", "10:30:5")
    result = run(*args, "-o", "book.xlsx")
    assert result.exit_code == 0, result.stderr
    sheets = openpyxl.load_workbook("book.xlsx")
    cells = [cell for sheet in sheets for row in sheet.iter_rows(values_only=True) for cell in row if cell]
    assert "amplitude" not in cells
    assert "stroke_mm down" in "".join(map(str, cells))
    down = [row[0] for row in sheets["Speed"].iter_rows(min_row=3, max_row=7, values_only=True)]
    assert down == [1, 1.5, 2, 2.5, 3]
    assert "stroke_mm = 3, frequency_hz" in "".join(map(str, cells))


def test_a_stored_sweep_remembers_in_what_it_was_asked(run: Run, scene: Path) -> None:
    run("map", scene, "--stroke", "1:3:5", "-f", "10:30:5", "-o", "cells.parquet")
    result = run("map", "cells.parquet", "-o", "again")
    assert result.exit_code == 0, result.stderr
    assert result.stderr.startswith("stroke: 5 values, 1 ... 3 mm")
    assert "at stroke 3 mm" in result.stderr
    # The cells are the same ones in amplitudes: such a run has nothing left to solve.
    amplitudes = ("-A", "0.5:1.5:5", "-f", "10:30:5", "-o", "cells.parquet")
    assert run("map", scene, *amplitudes).exit_code == 0
