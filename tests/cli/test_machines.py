"""Machines on the command line: what solve, map and the others say of them, or why they refuse them."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import pytest
from helpers.cases import each
from helpers.commands import Run, rows_of
from helpers.machine_files import FEEDER, KINDS, feeder

if TYPE_CHECKING:
    from pathlib import Path

pytestmark = pytest.mark.usefixtures("unsaved")

BANDS = 'voltage_percent = "90:110"\nsetting_percent = "40:100"\nfilling_kg = "0:2"\n'


def test_a_map_over_bands_is_written_and_described(run: Run, tmp_path: Path) -> None:
    path = feeder(tmp_path, BANDS.replace("setting", "# setting"))
    result = run("map", path, "-o", tmp_path / "m", "voltage=90:110:5", "filling=0:2:5")
    assert result.exit_code == 0, result.stderr
    assert {p.name for p in tmp_path.iterdir()} == {
        "feeder.toml", "m.csv", "m.json", "m-regime.png", "m-speed.png",
    }  # fmt: skip
    record = json.loads((tmp_path / "m.json").read_text())
    assert record["machine"]["voltage_percent"] == "90:110"  # as given
    assert record["scene"]["setting_percent"] == 100.0
    assert [*record["axes"]] == ["voltage_percent", "filling_kg"]
    rows = rows_of((tmp_path / "m.csv").read_text())
    assert [*rows[0]][:3] == ["voltage_percent", "filling_kg", "amplitude_mm"]
    assert len(rows) == 25
    single = json.loads(run("solve", path, "voltage=95", "filling=1.5", "--json").stdout)
    (row,) = (r for r in rows if (r["voltage_percent"], r["filling_kg"]) == ("95", "1.5"))
    assert float(row["mean_velocity_mm_s"]) == single["mean_velocity_mm_s"]
    assert float(row["amplitude_mm"]) == single["amplitude_mm"]


def test_a_stored_map_is_drawn_again(run: Run, tmp_path: Path) -> None:
    args = ("map", feeder(tmp_path), "setting=30:100:4", "filling=0:2:4")
    stored = tmp_path / "stored.parquet"
    assert run(*args, "-o", stored).exit_code == 0
    assert "complete already" in run(*args, "-o", stored).stderr
    result = run("map", stored, "-o", tmp_path / "again")
    assert result.exit_code == 0, result.stderr
    assert (tmp_path / "again-regime.png").exists()
    other = run(*args[:1], feeder(tmp_path, table=FEEDER.replace("0.015", "0.02")), *args[2:],
                "-o", stored)  # fmt: skip
    assert "damping_ratio: 0.015 there, 0.02 here" in other.stderr


def test_a_body_is_followed_in_a_full_trough(run: Run, tmp_path: Path) -> None:
    path = feeder(tmp_path)
    result = run("simulate", path, "filling=2", "--cycles", "2", "--json")
    content = json.loads(result.stdout)
    assert content["scene"]["machine"]["kind"] == "magnet"
    assert content["scene"]["filling_kg"] == 2.0
    assert "second harmonic" in result.stderr
    amplitude = json.loads(run("solve", path, "filling=2", "--json").stdout)["amplitude_mm"]
    same = run("simulate", "-A", f"{amplitude!r}", "-f", "50", "-a", "20", "--mu-s", "0.35", "--mu-d", "0.28",
               "--cycles", "2", "--json")  # fmt: skip
    assert json.loads(same.stdout)["phases"] == content["phases"]


OF_CELLS = ("-f", "49, 50", "filling=1, 2", "--columns", "amplitude_mm,natural_hz")


@each("kind", KINDS)
def test_answers_and_maps_of_every_kind_are_written(run: Run, tmp_path: Path, kind: str) -> None:
    file = feeder(tmp_path, table=KINDS[kind])
    result = run("map", file, *OF_CELLS, "-o", f"{kind}.png")
    assert result.exit_code == 0, result.stderr
    result = run("solve", file, "-o", f"{kind}.json")
    assert result.exit_code == 0, result.stderr
    assert json.loads((tmp_path / f"{kind}.json").read_text(encoding="utf-8"))["status"] == "ok"
