"""Tables as people ask for them: columns by name, digits."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest
from commands import NUT, NUT_ANGLE_AND_FRICTION, Run, rows_of

from vibro.files import tables

MAP = ("map", "-A", "0.1,1,1.15,4", "-f", "14.9876,15", *NUT_ANGLE_AND_FRICTION)
TRAVERSE = ("traverse-time", *MAP[1:], "-L", "600")
NAMES = "mean_velocity_mm_s,amplitude_mm,regime,acceleration_g,frequency_hz"


def test_columns_in_the_order_asked_for(run: Run) -> None:
    usual, asked = run(*MAP, "-o", "-"), run(*MAP, "-o", "-", "--columns", NAMES)
    assert asked.stdout.splitlines()[0] == NAMES
    for row, whole in zip(rows_of(asked.stdout), rows_of(usual.stdout), strict=True):
        for name in set(NAMES.split(",")) - {"acceleration_g"}:
            assert row[name] == whole[name]
        w = 2.0 * math.pi * float(row["frequency_hz"])
        assert float(row["acceleration_g"]) == pytest.approx(1e-3 * float(row["amplitude_mm"]) * w**2 / 9.81)
    cells = json.loads(run(*TRAVERSE, "--json", "--columns", "strokes,regime", "--digits", "2").stdout)
    assert cells[3] == {"strokes": 550, "regime": "forward-slip"}


@pytest.mark.parametrize("fast", [False, True])
@pytest.mark.parametrize("command", [MAP, TRAVERSE])
def test_digits_are_significant_ones(
    run: Run, command: tuple[str, ...], fast: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert tables._arrow() is not None
    monkeypatch.setattr("vibro.files.tables._WORTH_ARROW", 1 if fast else 100)
    exact = rows_of(run(*command, "-o", "-").stdout)
    text = run(*command, "-o", "-", "--digits", "4", "--decimal-comma", "--excel").stdout
    header, *lines = text.removeprefix("\ufeff").splitlines()
    shortened = 0
    for line, row in zip(lines, exact, strict=True):
        cells = dict(zip(header.split(";"), line.split(";"), strict=True))
        for name, whole in row.items():
            try:
                expected = f"{float(format(float(whole), '.4g')):.15g}".replace(".", ",")
            except ValueError:
                expected = whole
            assert cells[name] == expected
            shortened += len(expected) < len(whole)
    assert shortened > 30
    assert lines[2].startswith("1;14,99;20;0,74;0,57;0;forward-slip;F_;16,17;")


def test_the_sidecar_tells_what_the_table_holds(run: Run) -> None:
    options = ("--columns", NAMES, "--digits", "6")
    assert run(*MAP, *options, "-o", "few").exit_code == 0
    content = json.loads(Path("few.json").read_text(encoding="utf-8"))
    assert list(content["columns"]) == NAMES.split(",")
    assert (content["columns"]["acceleration_g"], content["digits"]) == ("g", 6)
    assert Path("few.csv").read_text(encoding="utf-8").splitlines()[0] == ",".join(content["columns"])
    assert run(*MAP, "-o", "all", "--accuracy", "regimes").exit_code == 0
    content = json.loads(Path("all.json").read_text(encoding="utf-8"))
    assert content["digits"] is None
    assert "part" not in content


def test_what_solve_writes_is_what_is_asked_for(run: Run) -> None:
    names = "stroke_mm,speed_amplitude_exponent,regime"
    options = ("solve", *NUT, "--columns", names, "--digits", "4")
    assert run(*options, "-o", "-").stdout == f"{names}\n2,3.797,forward-slip\n"
    expected = {"stroke_mm": 2, "speed_amplitude_exponent": 3.797, "regime": "forward-slip"}
    assert json.loads(run(*options, "--json").stdout) == expected
    assert run(*options, "-o", "one").exit_code == 0
    assert Path("one.csv").read_text(encoding="utf-8") == f"{names}\n2,3.797,forward-slip\n"


@pytest.mark.parametrize(
    ("args", "problem", "hint"),
    [
        ((*MAP, "--columns", "speed"), "there is no column 'speed'", "those of inputs are amplitude_mm, "),
        ((*MAP, "--columns", "regime,amplitude"), "there is no column 'amplitude'", "did you mean amp"),
        ((*MAP, "--columns", "regime, regime"), "column regime is named twice", "name it once"),
        ((*MAP, "--columns", ""), "there is no column ''", "those of inputs"),
        (
            (*TRAVERSE, "--columns", "arrival_time_s"),
            "column arrival_time_s: an option that it needs is missing",
            "add --exact",
        ),
        (
            ("solve", *NUT, "--json", "--columns", "upright"),
            "column upright: an option that it needs is missing",
            "add --stand-ratio 0.6",
        ),
        ((*MAP, "--digits", "0"), "--digits 0: must be from 1 to 17", "without it"),
        ((*MAP, "--digits", "18"), "--digits 18: must be from 1 to 17", "without it"),
        (("solve", *NUT, "--digits", "4"), "--digits: the report is no table", "add --json, -o - or -o STEM"),
        (("traverse-time", *NUT, "-L", "9", "--columns", "regime"), "--columns: the report is no", "add"),
    ],
)
def test_what_cannot_be_asked_for(run: Run, args: tuple[str, ...], problem: str, hint: str | None) -> None:
    result = run(*args)
    assert (result.exit_code, result.stdout) == (2, "")
    lines = result.stderr.splitlines()
    assert any(line.startswith(f"error: {problem}") for line in lines)
    assert hint is None or any(line.startswith(f"hint: {hint}") for line in lines)
    assert list(Path().iterdir()) == []
