"""``vibro measure`` of a table of times or speeds: how it is told from a record, its files, its JSON."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from helpers.commands import NUT_FILE, Run, rows_of
from helpers.made_records import EXAMPLES

TABLE = EXAMPLES / "data" / "nut_times.csv"
NUT = ("-f", "15", "-a", "20", "-L", "600")


def test_every_file_is_written(run: Run) -> None:
    result = run("measure", TABLE, *NUT, "-o", "out/nut.csv", "-o", "out/nut.html")
    assert result.exit_code == 0, result.stderr
    assert {path.name for path in Path("out").iterdir()} == {"nut.csv", "nut.html", "nut.json"}
    content = json.loads(Path("out/nut.json").read_text(encoding="utf-8"))
    assert content["scene"] == {
        "frequency_hz": 15, "drive_angle_deg": 20, "trough_angle_deg": 0, "gravity_m_s2": 9.81,
        "restitution": 0, "trough_length_mm": 600,
    }  # fmt: skip
    assert content["error_is"] == "scatter"
    assert content["left_out"] == []
    for name, true in (("kinetic_friction", 0.57), ("static_friction", 0.74)):
        fit = content["fit"][name]
        ((low, high),) = fit["intervals"]
        assert low < true < high
        assert low < fit["estimate"] < high
    point = content["next_point"]
    assert 0.6 <= point["amplitude_mm"] <= 2.4
    assert point["mean_velocity_low_mm_s"] < point["mean_velocity_high_mm_s"]
    rows = rows_of(Path("out/nut.csv").read_text(encoding="utf-8"))
    assert [row["row"] for row in rows] == ["2", "3", "4", "5", "6", "7"]
    assert [row["traverse_time_s"] for row in rows] == ["", "36.1", "17", "10.5", "10.3", "7"]
    assert float(rows[3]["computed_traverse_time_s"]) == pytest.approx(10.4, abs=0.2)
    page = Path("out/nut.html").read_text(encoding="utf-8")
    assert "kinetic friction" in page
    assert "measure next" in page


def test_frictions_of_a_scene_file_are_given(run: Run) -> None:
    text = NUT_FILE.replace("kinetic_friction = 0.57", "trough_length_mm = 600")
    Path("nut.toml").write_text(text, encoding="utf-8")
    content = json.loads(run("measure", "nut.toml", TABLE, "--json").stdout)
    assert [*content["fit"]] == ["kinetic_friction"]
    assert content["scene"]["static_friction"] == 0.74


@pytest.mark.parametrize(
    ("header", "rows", "is_table"),
    [
        ("amplitude_mm,traverse_time_s", "1,30\n2,9\n", True),
        ("traverse_time_s", "30\n31\n", True),
        ("stroke [mm];time [s]", "2;30\n4;9,1\n", True),
        ("frequency_hz,speed_m_min", "15,1\n20,2\n", True),
        ("Amplitude [mm];Zeit [s]", "1;30\n2;9,1\n", True),
        ("Hub [mm];Fördergeschwindigkeit [m/min]", "1;3\n2;9,1\n", True),
        ("Zeit [s];Geschwindigkeit [mm/s]", "0;1\n0,01;2\n", False),
        ("time_s,velocity_mm_s", "0,1\n0.01,2\n", False),
        ("time_s,acceleration_g", "0,1\n0.01,2\n", False),
        ("Time [s],X [mm]", "0,1\n0.01,2\n", False),
        ("time_s,frequency_hz,velocity_mm_s", "".join(f"{i / 100},15,{i}\n" for i in range(60)), False),
    ],
)
def test_a_table_is_told_from_a_record_by_its_columns(
    run: Run, header: str, rows: str, *, is_table: bool
) -> None:
    Path("some.csv").write_text(f"{header}\n{rows}", encoding="utf-8")
    result = run("measure", "some.csv", *NUT, *(() if "frequency" in header else ("-A", "1")), "--absolute")
    assert ("is a table of times or speeds" in result.stderr) is is_table, result.stderr
