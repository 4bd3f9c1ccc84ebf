"""Tables as people ask for them: columns by name, digits, parts in a row."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import pytest
from helpers.cases import each
from helpers.commands import NUT, NUT_ANGLE_AND_FRICTION, Run, rows_of

from vibro.files import csv_tables

MAP = ("map", "-A", "0.1,1,1.15,4", "-f", "14.9876,15", *NUT_ANGLE_AND_FRICTION)
TRAVERSE = ("traverse-time", *MAP[1:], "-L", "600")
TO_AND_FRO = ("-A", "1", "-f", "15", "--mu-s", ".3", "--mu-d", ".25", "--trough-angle", "3")
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
    assert csv_tables._arrow() is not None
    monkeypatch.setattr("vibro.files.csv_tables._WORTH_ARROW", 1 if fast else 100)
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
    options = ("--columns", f"{NAMES},parts_per_min", "--digits", "6", "--pitch", "1in", "--mass", "12g")
    assert run(*MAP, *options, "-o", "few").exit_code == 0
    content = json.loads(Path("few.json").read_text(encoding="utf-8"))
    assert list(content["columns"]) == [*NAMES.split(","), "parts_per_min"]
    assert (content["columns"]["acceleration_g"], content["columns"]["parts_per_min"]) == ("g", "1/min")
    assert (content["digits"], content["part"]) == (6, {"pitch_mm": 25.4, "mass_kg": 0.012})
    assert Path("few.csv").read_text(encoding="utf-8").splitlines()[0] == ",".join(content["columns"])
    assert run(*MAP, "-o", "all", "--regimes-only").exit_code == 0
    content = json.loads(Path("all.json").read_text(encoding="utf-8"))
    assert content["digits"] is None
    assert "part" not in content


BOUNCING = ("--restitution", "0.5")
LONG = ("-L", "600")


@pytest.mark.parametrize(
    ("args", "told"),
    [
        (("solve", *NUT), {"restitution": 0}),
        (("solve", *NUT, *BOUNCING, *LONG), {"restitution": 0.5, "trough_length_mm": 600}),
        (("solve", *NUT, *BOUNCING, *LONG, "--flight", "off"), {"trough_length_mm": 600}),
        (("solve", *NUT, *BOUNCING, "--regimes-only"), {}),
        ((*MAP, *BOUNCING, *LONG), {"restitution": 0.5, "trough_length_mm": 600}),
        ((*MAP, *BOUNCING, "--flight", "off"), {}),
        ((*MAP, *LONG, "--regimes-only"), {"trough_length_mm": 600}),
        ((*TRAVERSE, *BOUNCING), {"restitution": 0.5, "trough_length_mm": 600}),
        ((*TRAVERSE, "--flight", "off"), {"trough_length_mm": 600}),
        (("traverse-time", *NUT, *LONG), {"restitution": 0, "trough_length_mm": 600}),
    ],
)
def test_a_table_tells_what_it_was_made_with(run: Run, args: tuple[str, ...], told: dict[str, float]) -> None:
    rows = rows_of(run(*args, "-o", "-").stdout)
    names = list(rows[0])
    assert names[names.index("back_ratio") + 1 : names.index("flight_fraction")] == list(told)
    for row in rows:
        assert {name: float(row[name]) for name in told} == told
    if args[0] != "map":
        answer = json.loads(run(*args, "--json").stdout)
        for cell in answer if isinstance(answer, list) else [answer]:
            assert [name for name in cell if name in names] == names
            assert cell.items() >= told.items()


def test_what_it_was_made_with_is_told_on_request(run: Run) -> None:
    names = "trough_length_mm,amplitude_mm,restitution"
    asked = (*MAP, *LONG, "--flight", "off", "--columns", names, "-o", "-")
    assert run(*asked).stdout.splitlines()[:2] == [names, "600,0.1,0"]


def test_parts_pass_at_the_rate_of_speed_over_pitch(run: Run) -> None:
    rows = rows_of(run(*MAP, "--pitch", "25", "--mass", "12g", "--flight", "off", "-o", "-").stdout)
    assert list(rows[0])[-4:] == ["parts_per_min", "mass_flow_kg_h", "model", "status"]
    for row in rows:
        if row["mean_velocity_mm_s"]:
            parts = 60.0 * float(row["mean_velocity_mm_s"]) / 25.0
            assert float(row["parts_per_min"]) == pytest.approx(parts, rel=1e-14)
            assert float(row["mass_flow_kg_h"]) == pytest.approx(60.0 * 0.012 * parts, rel=1e-14)
        else:
            assert row["parts_per_min"] == row["mass_flow_kg_h"] == ""
    assert {row["parts_per_min"] for row in rows} > {"", "0"}


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (NUT, "39.0323 parts/min, 28.1033 kg/h at most, one part every 25 mm"),
        ((*NUT, "-A", "0.1"), "0 parts/min, 0 kg/h at most, one part every 25 mm"),
        ((*NUT, "-A", "4", "--flight", "off"), "unknown"),
    ],
)
def test_the_report_tells_the_throughput(run: Run, args: tuple[str, ...], said: str) -> None:
    options = ("--pitch", "25mm", "--mass", "12g")
    lines = dict(
        line.split("  ", 1) for line in run("solve", *args, *options).stdout.splitlines() if "  " in line
    )
    assert lines["throughput"].strip() == said
    answer = json.loads(run("solve", *args, *options, "--json").stdout)
    expected = None if said == "unknown" else pytest.approx(float(said.split()[0]), rel=1e-5)
    assert answer["parts_per_min"] == expected


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (NUT, "+10 % amplitude: +39.8 % speed (d ln speed / d ln amplitude = 3.79727)"),
        ((*NUT, "-A", "0.1"), "+10 % amplitude: 0 mm/s"),
        ((*NUT, "-A", "0.65"), "+10 % amplitude: 2.00514 mm/s, forward-slip"),
        ((*NUT, "-A", "1.1"), "+10 % amplitude: +20.4 % speed, back-slip (d ln"),
        ((*NUT, "-A", "4"), "+10 % amplitude: +12.1 % speed"),
        ((*NUT, "-A", "3", "--flight", "off"), "+10 % amplitude: speed unknown (the body leaves the trough"),
        ((*NUT, "-a", "0", "--mu-s", ".2", "--mu-d", ".2"), "+10 % amplitude: 0 mm/s"),
        ((*NUT, "-A", "0.9", "--mu-s", ".3", "--mu-d", ".29", "--trough-angle", "15"), "+10 % amplitude: +"),
        ((*TO_AND_FRO, "-a", "31.0109"), "+10 % amplitude: +13.2 % speed (d ln"),
        ((*TO_AND_FRO, "-a", "31.010843891"), "+10 % amplitude: -4.595"),  # 1e-10 mm/s
        ((*NUT, "--regimes-only"), None),
    ],
)
def test_the_report_tells_what_more_amplitude_does(run: Run, args: tuple[str, ...], said: str | None) -> None:
    lines = [line for line in run("solve", *args).stdout.splitlines() if line.startswith("sensitivity")]
    if said is None:
        assert lines == []
        return
    (line,) = lines
    told = line.removeprefix("sensitivity").strip()
    assert told.startswith(said)
    answer = json.loads(run("solve", *args, "--json").stdout)
    larger = ("-A", repr(1.1 * answer["amplitude_mm"]))
    then = json.loads(run("solve", *args, *larger, "--json").stdout)
    assert then["regime"] == answer["regime"] or then["regime"] in told
    if "% speed" in told:
        percent = 100.0 * (then["mean_velocity_mm_s"] / answer["mean_velocity_mm_s"] - 1.0)
        assert float(told.split()[3]) == pytest.approx(percent, rel=1e-2)
    exponent = answer["speed_amplitude_exponent"]
    assert (exponent is not None) == ("d ln" in told)
    if exponent is not None:
        assert f"{exponent:.6g}" in told


def test_the_report_tells_the_stroke_and_no_minus_zero(run: Run) -> None:
    text = run("solve", *NUT, "-A", "1.5e-6", "-f", "15000").stdout
    assert " amplitude 1.5e-06 mm (stroke 3e-06 mm peak to peak), frequency 15000 Hz, " in text
    assert re.search(r"^back slide +\S+ +\S+ +0\.00000$", text, flags=re.MULTILINE)


def test_the_error_of_a_mean_is_that_of_both(run: Run) -> None:
    """Bodies that bounce without a period have means: the change of one has an error too."""
    args = ("solve", *NUT, "-A", "8", "--restitution", "0.6")
    answer = json.loads(run(*args, "--json").stdout)
    assert answer["status"] == "averaged"
    assert answer["speed_amplitude_exponent"] is None
    (line,) = [x for x in run(*args).stdout.splitlines() if x.startswith("sensitivity")]
    assert " +- " in line
    assert line.endswith(" % (standard error)")


def test_what_solve_writes_is_what_is_asked_for(run: Run) -> None:
    names = "stroke_mm,speed_amplitude_exponent,regime"
    options = ("solve", *NUT, "--columns", names, "--digits", "4")
    assert run(*options, "-o", "-").stdout == f"{names}\n2,3.797,forward-slip\n"
    expected = {"stroke_mm": 2, "speed_amplitude_exponent": 3.797, "regime": "forward-slip"}
    assert json.loads(run(*options, "--json").stdout) == expected
    assert run(*options, "-o", "one").exit_code == 0
    assert Path("one.csv").read_text(encoding="utf-8") == f"{names}\n2,3.797,forward-slip\n"


@each(
    ("args", "problem", "hint"),
    [
        ((*MAP, "--columns", "speed"), "there is no column 'speed'", "those of inputs are amplitude_mm, "),
        ((*MAP, "--columns", "regime,amplitude"), "there is no column 'amplitude'", "did you mean 'amp"),
        ((*MAP, "--columns", "regime, regime"), "column regime is named twice", "name it once"),
        ((*MAP, "--columns", ""), "there is no column ''", "those of inputs"),
        (
            (*MAP, "--columns", "mass_flow_kg_h", "--pitch", "9"),
            "column mass_flow_kg_h: an option that it needs is missing",
            "add --pitch 25mm --mass 12g",
        ),
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
        (
            (*MAP, "--columns", "regime,trough_length_mm"),
            "column trough_length_mm: an option that it needs is missing",
            "add -L 600mm",
        ),
        ((*MAP, "--digits", "0"), "--digits 0: must be from 1 to 17", "without it"),
        ((*MAP, "--digits", "18"), "--digits 18: must be from 1 to 17", "without it"),
        (("solve", *NUT, "--digits", "4"), "--digits: the report is no table", "add --json, -o - or -o STEM"),
        (("traverse-time", *NUT, "-L", "9", "--columns", "regime"), "--columns: the report is no", "add"),
        ((*MAP, "--mass", "12g"), "--mass: kg an hour need the distance from", "add --pitch"),
        ((*MAP, "--pitch", "0"), "pitch = 0: must be finite and > 0 mm", None),
        ((*MAP, "--pitch", "25g"), "pitch = '25g': 'g' is no unit of pitch", "its units are mm, "),
        ((*MAP, "--pitch", "25", "--mass", "-1"), "mass = -1: must be finite and > 0 kg", None),
        ((*MAP, "--pitch", "25", "--mass", "nan"), "mass = nan: must be a finite number", None),
        (("solve", *NUT[2:], "--speed", "9", "--pitch", "9"), "--speed lists amplitudes: --pitch", None),
    ],
)
def test_what_cannot_be_asked_for(run: Run, args: tuple[str, ...], problem: str, hint: str | None) -> None:
    result = run(*args)
    assert (result.exit_code, result.stdout) == (2, "")
    lines = result.stderr.splitlines()
    assert any(line.startswith(f"error: {problem}") for line in lines)
    assert hint is None or any(line.startswith(f"hint: {hint}") for line in lines)
    assert list(Path().iterdir()) == []
