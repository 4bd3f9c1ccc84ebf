"""Drives with harmonics on the command line: options of the second, lists in scene files, maps."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from helpers.commands import Run, rows_of

import vibro

pytestmark = pytest.mark.usefixtures("unsaved")

FILE = """
[scene]
along_amplitudes_mm = [1, 0.3]
along_phases_deg = [0, 90]
frequency_hz = 10
static_friction = 0.4
kinetic_friction = 0.3
trough_length_mm = 600
"""


def written(folder: Path, text: str) -> Path:
    file = folder / "drive.toml"
    file.write_text(text, encoding="utf-8")
    return file


def test_an_option_replaces_an_entry_of_a_list(run: Run, tmp_path: Path) -> None:
    file = written(tmp_path, FILE)
    forth, back = (
        json.loads(run("solve", file, f"along_phase_2={phase}", "--json").stdout)["mean_velocity_mm_s"]
        for phase in (-90, 90)
    )
    assert forth == pytest.approx(-back, rel=1e-13)
    answer = json.loads(run("solve", file, "normal=0.2", "normal_2=0.1", "--json").stdout)
    expected = {"normal_amplitude_mm": 0.2, "normal_amplitude_2_mm": 0.1, "normal_phase_2_deg": 0}
    assert answer.items() >= expected.items()
    assert json.loads(run("solve", file, "-A", "1", "-a", "20", "--json").stdout)["amplitude_mm"] == 1


def test_patterns_that_are_longer_than_codes_are_whole(run: Run, tmp_path: Path) -> None:
    lists = f"along_amplitudes_mm = [{'0, ' * 7}0.0078125]\n"
    file = written(tmp_path, FILE.replace(FILE[FILE.index("along_amp") : FILE.index("frequency")], lists))
    swept = vibro.sweep(file, frequency_hz="2:24:6")
    expected = swept.cycle.pattern.tolist()
    assert {"_", "F_B_" * 8} <= {*expected}
    assert swept.to_frame()["pattern"].tolist() == expected
    rows = rows_of(run("map", file, "--frequency", "2:24:6", "-o", "-").stdout)
    assert [row["pattern"] for row in rows] == expected
    said = [run("solve", file, "--frequency", "15", how).stdout for how in ("--all", "--json")]
    assert f" {'F_B_' * 8}\n" in said[0]
    assert json.loads(said[1])["pattern"] == "F_B_" * 8


def test_the_second_harmonic_is_an_axis_and_has_columns(run: Run, tmp_path: Path) -> None:
    result = run("map", written(tmp_path, FILE), "along_2=0:.3:4", "along_phase_2=-90:90:3", "-o", "x")
    assert result.exit_code == 0, result.stderr
    rows = rows_of((tmp_path / "x.csv").read_text(encoding="utf-8"))
    assert list(rows[0])[:8] == [
        "along_amplitude_mm", "normal_amplitude_mm", "frequency_hz", "normal_phase_deg", "along_phase_deg",
        "along_amplitude_2_mm", "along_phase_2_deg", "static_friction",
    ]  # fmt: skip
    assert len(rows) == 12
    assert {"x-regime.png", "x-speed.png"} <= {file.name for file in tmp_path.iterdir()}
    assert "normal_phase_2_deg" not in rows[0]
