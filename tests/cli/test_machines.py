"""Machines on the command line: what solve, map and the others say of them, or why they refuse them."""

from __future__ import annotations

import csv
import io
import json
import subprocess
import sys
from pathlib import Path

import pytest
from helpers.cases import each
from helpers.commands import FRICTION, NUT, Run, rows_of
from helpers.machine_files import FEEDER, KINDS, UNBALANCE, feeder

import vibro

PACKS = '[[machine.pack]]\nname = "6 leaves"\nnatural_hz = 47.6\n'
BANDS = 'voltage_percent = "90:110"\nsetting_percent = "40:100"\nfilling_kg = "0:2"\n'
LINES = ("machine", "resonance", "filling", "amplitude", "springs bend", "second harmonic")


def lines_of(text: str) -> dict[str, str]:
    """Read the facts of a report."""
    rows = (line.split("  ", 1) for line in text.split("\n\n")[0].splitlines())
    return {name: told.strip() for name, told in rows}


def test_a_report_tells_the_machine_and_what_its_filling_does(run: Run, tmp_path: Path) -> None:
    result = run("solve", feeder(tmp_path, BANDS), "--filling", "2kg")
    told = lines_of(result.stdout)
    assert [name for name in told if name in LINES] == [*LINES]
    assert told["machine"] == (
        "magnet, trough 6 kg, counter mass 12 kg, setting 100 % (of 40...100 %),"
        " voltage 100 % (of 90...110 %), natural frequency 55.6 Hz"
    )
    assert told["resonance"].startswith("f/f0 = 0.8993 empty, 0.9097 with the filling: below resonance")
    assert told["filling"] == "2 kg: 10.6 % of it acts as mass, 9.22 % as damping (computed)"
    assert told["amplitude"] == "0.35 mm empty, 0.3763 mm with 2 kg (+7.52 %)"
    assert told["second harmonic"].startswith("0.749 % of the amplitude, from the filling; with it the mean")
    bent = float(told["second harmonic"].split()[-2])
    assert 27.5443 < bent < 1.1 * 27.5443  # faster than under the sine, as two-way stepping is
    assert told["springs bend"] == "0.5712 mm to each side"
    assert "a second harmonic of" in result.stderr  # above 0.1 % of the amplitude
    assert told["scene"].endswith("amplitude 0.376305 mm (stroke 0.75261 mm peak to peak)")
    assert told["mean speed"] == "27.5443 mm/s"
    assert told["sensitivity"].startswith("+10 % amplitude: +")


def test_without_a_filling_the_trough_is_empty_and_that_is_said(run: Run, tmp_path: Path) -> None:
    result = run("solve", feeder(tmp_path, BANDS))
    told = lines_of(result.stdout)
    assert told["filling"] == "none: the trough is empty (the file's band ends at 2 kg)"
    assert told["amplitude"] == "0.35 mm empty"
    assert not result.stderr
    assert "(the file's band" not in run("solve", feeder(tmp_path)).stdout


def test_the_side_of_resonance_is_told(run: Run, tmp_path: Path) -> None:
    path = feeder(tmp_path, PACKS)
    soft = lines_of(run("solve", path, "--pack", "6 leaves", "--filling", 2).stdout)
    assert "natural frequency 47.6 Hz (6 leaves)" in soft["machine"]
    assert "above resonance, where more mass means less amplitude" in soft["resonance"]
    assert "-12.1 %" in soft["amplitude"]
    assert soft == lines_of(run("solve", path, "--natural", "47.6", "--filling", "2000g").stdout)
    near = run("solve", path, "--natural", "50.2")
    assert "within 2 zeta = 3 % of resonance: the amplitude depends much on damping" in near.stderr


def test_soft_mounts_are_said_to_be_assumed(run: Run, tmp_path: Path) -> None:
    told = lines_of(run("solve", feeder(tmp_path, table=UNBALANCE)).stdout)
    assert told["machine"] == (
        "unbalance, vibrating mass 120 kg, setting 100 %, infinitely soft mounts, as no mount_hz is given"
        " (at f/f0 = 3 they add 12.5 %)"
    )
    stiff = lines_of(run("solve", feeder(tmp_path, "mount_hz = 12.5\n", table=UNBALANCE)).stdout)
    assert stiff["machine"].endswith("mounts 12.5 Hz")
    assert stiff["resonance"].startswith("f/f0 = 4 empty: above resonance")
    soft, more = (float(one["amplitude"].split()[0]) for one in (told, stiff))
    assert more / soft == pytest.approx(16 / 15, rel=1e-3)


def test_json_has_the_columns_of_a_machine(run: Run, tmp_path: Path) -> None:
    answer = json.loads(run("solve", feeder(tmp_path), "--filling", "2", "--json").stdout)
    assert (answer["setting_percent"], answer["filling_kg"], answer["natural_hz"]) == (100.0, 2.0, 55.6)
    assert answer["amplitude_empty_mm"] == pytest.approx(0.35)
    assert answer["amplitude_mm"] == pytest.approx(0.3763, rel=1e-4)
    assert answer["frequency_ratio"] == 50 / 55.6
    assert answer["second_harmonic_percent"] > 0.1
    assert "added_mass_share" not in json.loads(run("solve", *NUT, "--json").stdout)


def test_masses_that_strike_are_an_error(run: Run, tmp_path: Path) -> None:
    result = run("solve", feeder(tmp_path, "gap_mm = 0.5\n"))
    assert result.exit_code == 2
    assert (
        "the masses strike: the relative amplitude would be 0.525 mm, and gap_mm allows 0.5" in result.stderr
    )
    assert "lower the setting" in result.stderr


def test_a_map_over_bands_is_written_and_described(run: Run, tmp_path: Path) -> None:
    path = feeder(tmp_path, BANDS.replace("setting", "# setting"))
    result = run("map", path, "-o", tmp_path / "m", "--voltage", "90:110:5", "--filling", "0:2:5")
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
    single = json.loads(run("solve", path, "--voltage", "95", "--filling", "1.5", "--json").stdout)
    (row,) = (r for r in rows if (r["voltage_percent"], r["filling_kg"]) == ("95", "1.5"))
    assert float(row["mean_velocity_mm_s"]) == single["mean_velocity_mm_s"]
    assert float(row["amplitude_mm"]) == single["amplitude_mm"]


def test_axes_of_a_machine_stand_in_the_table_of_a_map(run: Run, tmp_path: Path) -> None:
    path = feeder(tmp_path, '[map]\nfilling_kg = [0, 1]\nsetting_percent = "50:100:3"\nnatural_hz = 57\n')
    result = run("map", path, "-o", "-")
    rows = [*csv.DictReader(io.StringIO(result.stdout))]
    assert [(r["setting_percent"], r["filling_kg"]) for r in rows] == [
        (s, m) for s in ("50", "75", "100") for m in ("0", "1")
    ]
    assert {r["natural_hz"] for r in rows} == {"57"}


def test_a_stored_map_is_drawn_again(run: Run, tmp_path: Path) -> None:
    args = ("map", feeder(tmp_path), "--setting", "30:100:12", "--filling", "0:2:12", "--table", "parquet")
    assert run(*args, "-o", tmp_path / "stored").exit_code == 0
    again = run(*args, "-o", tmp_path / "stored", "--resume")
    assert again.exit_code == 0, again.stderr
    result = run("map", tmp_path / "stored", "-o", tmp_path / "again")
    assert result.exit_code == 0, result.stderr
    assert (tmp_path / "again-regime.png").exists()
    other = run(*args[:1], feeder(tmp_path, table=FEEDER.replace("0.015", "0.02")), *args[2:],
                "-o", tmp_path / "stored", "--resume")  # fmt: skip
    assert "damping_ratio: 0.015 there, 0.02 here" in other.stderr


def test_a_traverse_time_follows_the_filling(run: Run, tmp_path: Path) -> None:
    path = feeder(tmp_path)
    told = lines_of(run("traverse-time", path, "--filling", "2", "-L", "600").stdout)
    assert told["traverse time"].startswith("21.783")
    assert told["amplitude"].startswith("0.35 mm empty, 0.3763 mm")
    table = run("traverse-time", path, "-L", "600", "--filling", "0:2:3").stdout
    assert [*rows_of(table)[0]][:2] == ["filling_kg", "amplitude_mm"]


def test_a_body_is_followed_in_a_full_trough(run: Run, tmp_path: Path) -> None:
    path = feeder(tmp_path)
    result = run("simulate", path, "--filling", "2", "--cycles", "2", "--json")
    content = json.loads(result.stdout)
    assert content["scene"]["machine"]["kind"] == "magnet"
    assert content["scene"]["filling_kg"] == 2.0
    assert "second harmonic" in result.stderr
    amplitude = json.loads(run("solve", path, "--filling", "2", "--json").stdout)["amplitude_mm"]
    same = run("simulate", "-A", f"{amplitude!r}", "-f", "50", "-a", "20", "--mu-s", "0.35", "--mu-d", "0.28",
               "--cycles", "2", "--json")  # fmt: skip
    assert json.loads(same.stdout)["phases"] == content["phases"]


@each("command", ["accuracy", "compare", "motion", "speed"])
def test_other_commands_say_that_they_take_none(run: Run, tmp_path: Path, command: str) -> None:
    path = feeder(tmp_path)
    record = tmp_path / "record.csv"
    record.write_text("t [s],x [mm]\n" + "".join(f"{i / 1000},{i % 7}\n" for i in range(200)))
    trough = tmp_path / "trough.csv"
    trough.write_text("t [s],ax [m/s^2]\n" + "".join(f"{i / 1000},{i % 7}\n" for i in range(200)))
    args = {
        "accuracy": ("accuracy", path),
        "compare": ("compare", path, record),
        "motion": ("motion", path, trough, "--trough-along", "ax [m/s^2]"),
        "speed": ("solve", path, "--speed", "60"),
    }[command]
    result = run(*args)
    assert result.exit_code == 2, result.stderr
    assert "[machine]: " in result.stderr
    assert "vibro solve tells the amplitude at its operating point" in result.stderr


@each(
    ("args", "problem", "hint"),
    [
        (("-A", "1"), "the command line gives the amplitude beside [machine]", "leave it out"),
        (("--stroke", "1"), "the command line gives the stroke beside [machine]", "leave it out"),
        (("--filling", "0:2"), "filling = 0 kg...2 kg: vibro solve takes one value", "vibro map"),
        (("--pack", "6 leafs"), "there is no spring pack '6 leafs'", "did you mean '6 leaves'?"),
        (("--pack", "6 leaves", "--natural", "50"), "a spring pack and a natural frequency are given", "one"),
        (("--filling", "2mm"), "'mm' is no unit of filling", "kg, g, mg, lb"),
        (("--setting", "-5"), "setting = -5 %: must be finite and > 0 %", ""),
    ],
)  # fmt: skip
def test_what_cannot_be_is_named(
    run: Run, tmp_path: Path, args: tuple[str, ...], problem: str, hint: str
) -> None:
    result = run("solve", feeder(tmp_path, PACKS), *args)
    assert result.exit_code == 2
    assert problem in result.stderr
    assert hint in result.stderr


def test_a_choice_of_packs_is_asked_for(run: Run, tmp_path: Path) -> None:
    table = FEEDER.replace("natural_hz = 55.6\n", "").replace("calibration", "force_n = 50 #")
    packs = PACKS + PACKS.replace("6 leaves", "8 leaves").replace("47.6", "55.6")
    path = feeder(tmp_path, packs, table=table)
    result = run("solve", path)
    assert "which spring pack is fitted is not given" in result.stderr
    assert 'give --pack "6 leaves" or --pack "8 leaves", or a natural frequency' in result.stderr
    assert run("solve", path, "--pack", "8 leaves").exit_code == 0
    assert run("solve", feeder(tmp_path, PACKS, table=table)).exit_code == 0  # the only one


@each("option", ["--setting", "--voltage", "--filling", "--natural", "--pack"])
def test_without_a_machine_its_options_are_refused(run: Run, option: str) -> None:
    result = run("traverse-time", *NUT, "-L", "600", option, "5")
    assert result.exit_code == 2
    assert "there is no machine" in result.stderr
    assert "[machine]" in result.stderr


def test_slips_of_units_are_questioned(run: Run, tmp_path: Path) -> None:
    path = feeder(tmp_path)
    assert "voltage = 0.9 % is below what is usual" in run("solve", path, "--voltage", "0.9").stderr
    assert "filling = 2000000 kg is above" in run("solve", path, "--filling", "2000000").stderr
    assert "is above what is usual, 20 g" in run("solve", path, "--natural", "49.5").stderr


@each("kind", KINDS)
def test_every_kind_has_a_report(run: Run, tmp_path: Path, kind: str) -> None:
    result = run("solve", feeder(tmp_path, table=KINDS[kind]), "--filling", "1")
    assert result.exit_code == 0, result.stderr
    assert lines_of(result.stdout)["machine"].startswith(kind)


def test_all_operating_points_are_listed_where_there_are_several(run: Run, tmp_path: Path) -> None:
    args = ("--setting", "18", "--filling", "4", "--natural", "51")
    result = run("solve", feeder(tmp_path), *args)
    told = lines_of(result.stdout)["all amplitudes"]
    sizes = [float(text) for text in told.partition(" mm;")[0].replace(" mm", "").split(", ")]
    assert len(sizes) == 3
    assert sizes == sorted(sizes)
    assert f"{sizes[0]:.4g} mm with 4 kg" in lines_of(result.stdout)["amplitude"]  # the least is reported
    assert "3 operating points exist" in result.stderr


def test_python_reads_the_operating_point(tmp_path: Path) -> None:
    scene = vibro.read_scene(feeder(tmp_path, "filling_kg = 2\n"))
    assert scene.shape == ()
    assert float(vibro.solve(scene).mean_velocity) == pytest.approx(27.5443e-3, rel=1e-5)


def test_plain_scenes_load_no_machine() -> None:
    program = (
        "import sys; from vibro.cli.app import app\n"
        "try: app(sys.argv[1:])\n"
        "except SystemExit: pass\n"
        "print('LOADED', [name for name in sys.modules if name.startswith('vibro.machines')])"
    )
    args = ["solve", "-A", "1", "-f", "15", "-a", "20", *FRICTION]
    result = subprocess.run(
        [sys.executable, "-c", program, *args], capture_output=True, text=True, check=True
    )
    assert "mean speed" in result.stdout
    assert result.stdout.endswith("LOADED []\n")


def test_what_begins_is_told_by_amplitude_alone(run: Run, tmp_path: Path) -> None:
    """With the frequency the amplitude of a machine changes too."""
    head = next(
        line
        for line in run("solve", feeder(tmp_path, BANDS)).stdout.splitlines()
        if line.startswith("begins")
    )
    assert "amplitude [mm]" in head
    assert "frequency" not in head


@pytest.mark.parametrize(("filling", "cells"), [("0", 0), ("1,2", 4)])
def test_maps_tell_how_many_cells_are_no_sines(run: Run, tmp_path: Path, filling: str, cells: int) -> None:
    of_cells = "--setting", "90,100", "--filling", filling, "-f", "50", "-o", str(tmp_path / "map")
    said = run("map", feeder(tmp_path, ""), *of_cells).stderr
    told = f"warning: {cells} of 4 cells: the filling adds a second harmonic to the trough's motion"
    assert told in said if cells else "bends" not in said


OF_CELLS = ("-f", "49,50", "--filling", "1,2", "--columns", "amplitude_mm,natural_hz")


@each("kind", KINDS)
@each("table", ["csv", "xlsx", "parquet"])
@pytest.mark.usefixtures("no_pictures")
def test_maps_of_every_kind_are_written(run: Run, tmp_path: Path, kind: str, table: str) -> None:
    to = ("--table", table, "-o", f"{kind}-{table}")
    result = run("map", feeder(tmp_path, table=KINDS[kind]), *OF_CELLS, *to)
    assert result.exit_code == 0, result.stderr


@each("kind", KINDS)
def test_maps_of_every_kind_are_drawn(run: Run, tmp_path: Path, kind: str) -> None:
    result = run("map", feeder(tmp_path, table=KINDS[kind]), *OF_CELLS, "-o", kind)
    assert result.exit_code == 0, result.stderr
    assert {f"{kind}-regime.png", f"{kind}-speed.png"} <= {path.name for path in tmp_path.iterdir()}


@each("table", ["csv", "xlsx", "parquet"])
@pytest.mark.usefixtures("no_pictures")
def test_maps_with_masses_that_strike_are_written(run: Run, tmp_path: Path, table: str) -> None:
    of_cells = "-f", "45:55:11", "--setting", "50,150", "--table", table, "-o", table
    result = run("map", feeder(tmp_path, "gap_mm = 0.6\n"), *of_cells)
    assert result.exit_code == 0, result.stderr
    assert "of 22 cells: infeasible" in result.stderr


@each("kind", KINDS)
def test_answers_of_every_kind_are_written(run: Run, tmp_path: Path, kind: str) -> None:
    result = run("solve", feeder(tmp_path, table=KINDS[kind]), "-o", str(tmp_path / kind))
    assert result.exit_code == 0, result.stderr
    assert json.loads((tmp_path / f"{kind}.json").read_text(encoding="utf-8"))["status"] == {"ok": 1}
