"""Elliptical drives on the command line: options, scene files, axes, columns, errors, pictures."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.cases import each
from helpers.commands import ELLIPSE, FRICTION, NUT, Run, rows_of

import vibro

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
COLUMNS = (
    "along_amplitude_mm", "normal_amplitude_mm", "frequency_hz", "normal_phase_deg", "static_friction",
    "kinetic_friction", "trough_angle_deg", "regime",
)  # fmt: skip


def lines_of(text: str) -> dict[str, str]:
    """Return the lines of a report by their first word."""
    return {line.split("  ")[0]: " ".join(line.split()) for line in text.splitlines() if line}


def written(folder: Path, text: str, name: str = "drive.toml") -> Path:
    file = folder / name
    file.write_text(text, encoding="utf-8")
    return file


# --- one scene --------------------------------------------------------------------------------------


def test_the_report_of_one_scene(run: Run) -> None:
    result = run("solve", *ELLIPSE)
    assert result.exit_code == 0, result.stderr
    lines, cycle = lines_of(result.stdout), vibro.solve(vibro.Scene(**VALUES))
    assert "along amplitude 1 mm, normal amplitude 0.3 mm" in lines["scene"]
    assert "normal phase -60 deg (stroke 2.02394 mm peak to peak" in lines["scene"]
    assert lines["mean speed"] == f"mean speed {1e3 * cycle.mean_velocity:.6g} mm/s"
    assert lines["throw number"].startswith("throw number 0.754557")
    assert "at most along the path" in lines["acceleration"]
    assert "+10 % both amplitudes" in lines["sensitivity"]
    exponent = float(re.findall(r"d ln speed / d ln amplitude = ([\d.]+)", lines["sensitivity"])[0])
    faster = vibro.solve(
        vibro.Scene(**(VALUES | {"along_amplitude": 1.00001e-3, "normal_amplitude": 0.300003e-3}))
    )
    assert math.log(faster.mean_velocity / cycle.mean_velocity) / 1e-5 == pytest.approx(exponent, rel=1e-4)
    assert lines["begins"] == "begins load now / then both amplitudes frequency [Hz]"


def test_ten_percent_more_of_both_amplitudes_are_solved(run: Run) -> None:
    scene = vibro.Scene(**VALUES)
    raised = vibro.Scene(**(VALUES | {"along_amplitude": 1.1e-3, "normal_amplitude": 0.33e-3}))
    gain = vibro.solve(raised).mean_velocity / vibro.solve(scene).mean_velocity
    said = lines_of(run("solve", *ELLIPSE).stdout)["sensitivity"]
    assert f"{100 * (gain - 1):+.3g} % speed" in said


def test_a_part_tips_above_both_amplitudes(run: Run) -> None:
    said = lines_of(run("solve", *ELLIPSE, "--stand-ratio", "0.05").stdout)["upright"]
    assert "(both amplitudes)" in said


@pytest.mark.parametrize(
    "phase", [("--phase=-60",), ("--phase", "-60"), ("--phase", "-60deg"), ("--phase=300",)]
)
def test_a_negative_phase_needs_no_equals_sign(run: Run, phase: tuple[str, ...]) -> None:
    rest = tuple(text for text in ELLIPSE if not text.startswith("--phase"))
    answer = json.loads(run("solve", *rest, *phase, "--json").stdout)
    expected = 1e3 * vibro.solve(vibro.Scene(**VALUES)).mean_velocity
    assert answer["mean_velocity_mm_s"] == pytest.approx(expected, rel=1e-13)


def test_the_json_of_one_scene_has_the_ellipse_in_place_of_the_line(run: Run) -> None:
    answer = json.loads(run("solve", *ELLIPSE, "--json").stdout)
    assert tuple(answer)[: len(COLUMNS)] == COLUMNS
    assert [answer[name] for name in COLUMNS[:4]] == [1.0, 0.3, 25.0, -60.0]
    scene = vibro.Scene(**VALUES)
    assert answer["stroke_mm"] == pytest.approx(2e3 * scene.arrays().reach, rel=1e-15)
    assert answer["acceleration_g"] == scene.load
    line = json.loads(run("solve", *NUT, "--json").stdout)
    assert not {"along_amplitude_mm", "normal_amplitude_mm", "normal_phase_deg"} & line.keys()


def test_without_a_phase_it_is_0_and_said(run: Run) -> None:
    rest = tuple(text for text in ELLIPSE if not text.startswith("--phase"))
    assert "normal phase 0 deg" in run("solve", *rest).stdout
    assert json.loads(run("solve", *rest, "--json").stdout)["normal_phase_deg"] == 0.0


def test_traverse_time_and_simulate(run: Run, tmp_path: Path) -> None:
    file = written(tmp_path, ELLIPSE_FILE)
    scene = vibro.Scene(**VALUES)
    answer = json.loads(run("traverse-time", file, "--json").stdout)
    assert answer["traverse_time_s"] == pytest.approx(0.6 / vibro.solve(scene).mean_velocity, rel=1e-15)
    assert answer["arrival_time_s"] == pytest.approx(vibro.arrival_time(scene, 0.6), rel=1e-12)
    assert lines_of(run("traverse-time", file).stdout)["mean speed"].endswith("89.0577 mm/s")
    told = run("simulate", file, "--json")
    assert told.exit_code == 0, told.stderr
    assert json.loads(told.stdout)["scene"]["normal_phase_deg"] == -60


def test_a_body_at_rest_says_by_how_much_both_amplitudes_must_grow(run: Run) -> None:
    first = run(
        "traverse-time", *ELLIPSE, "--along", ".1", "--normal", ".03", "-L", "600"
    ).stdout.splitlines()[0]
    assert "begins with both amplitudes above 0.149316 mm and 0.0447948 mm (1.493 x)" in first


# --- what is missing, mixed or refused --------------------------------------------------------------


@pytest.mark.parametrize(
    ("given", "problem", "example"),
    [
        (("--along", "1"), "missing: normal amplitude (--normal)", "--normal 0.3"),
        (("--normal", ".3"), "missing: along amplitude (--along)", "--along 1"),
        (
            ("--phase=-60",),
            "missing: along amplitude (--along), normal amplitude (--normal)",
            "--along 1 --normal",
        ),
    ],
)
def test_what_is_missing_is_named_with_an_example_that_runs(
    run: Run, given: tuple[str, ...], problem: str, example: str
) -> None:
    for command in ("solve", "map"):
        result = run(command, *given, *FRICTION, *(("-f", "25") if command == "solve" else ()))
        assert result.exit_code == 2
        assert f"error: {problem}" in result.stderr
        assert example in result.stderr
    hint = run("solve", *given, *FRICTION, "-f", "25").stderr.split("example: vibro ")[1]
    assert run(*hint.split()).exit_code == 0


EITHER = "for an ellipse give --along, --normal and --phase; for a line -A and -a alone"
HARMONIC = (
    "--along",
    "1",
    "--normal",
    "0",
    "--along-2",
    "0.3",
    "--along-phase-2",
    "90",
    "-f",
    "10",
    *FRICTION,
)


@each(
    ("given", "problem", "hint"),
    [
        (("solve", "-A", "1", "--along", "1"),
         "the command line gives amplitude, along amplitude: a drive moves either", EITHER),
        (("solve", "--stroke", "1", "--along", "1"),
         "the command line gives amplitude, along amplitude", EITHER),
        (("solve", *NUT, "--phase", "3"),
         "amplitude, drive angle, normal phase: a drive along a line has no phase", EITHER),
        (("solve", *ELLIPSE, "-a", "20"),
         "gives along amplitude, normal amplitude, drive angle, normal phase: a drive", EITHER),
        (("solve", "line.toml", "--along", "1"),
         "the command line gives along amplitude and [scene] gives amplitude, drive", ""),
        (("solve", "line.toml", "--phase", "1"),
         "[scene] gives amplitude, drive angle: a drive along a line has no phase", ""),
        (("solve", "ellipse.toml", "-A", "1"),
         "the command line gives amplitude and [scene] gives along amplitude, normal", ""),
        (("accuracy", "ellipse.toml"), "error: vibro accuracy runs methods for a drive along a line", ""),
        (("solve", *NUT, "--along-2", "0.3"), "a drive moves either along a line or along an ellipse", ""),
        (("solve", "--along", "1", "--normal", "0", "--along-phase-2", "9", "-f", "10", *FRICTION),
         "missing: second along amplitude (--along-2)", ""),
    ],
)  # fmt: skip
def test_what_cannot_be_of_a_drive_is_refused_with_what_to_do(
    run: Run, tmp_path: Path, given: tuple[str, ...], problem: str, hint: str
) -> None:
    written(tmp_path, LINE_FILE, "line.toml")
    written(tmp_path, ELLIPSE_FILE, "ellipse.toml")
    result = run(*given)
    assert result.exit_code == 2
    assert problem in result.stderr
    assert f"hint: {hint}" in result.stderr


def test_a_speed_is_found_for_the_line_that_replaces_an_ellipse(run: Run, tmp_path: Path) -> None:
    assert run("solve", written(tmp_path, ELLIPSE_FILE), "--speed", "5", "-a", "20").exit_code == 0


def test_a_drive_given_whole_takes_the_place_of_a_file_s(run: Run, tmp_path: Path) -> None:
    line, ellipse = written(tmp_path, LINE_FILE), tmp_path / "ellipse.toml"
    ellipse.write_text(ELLIPSE_FILE, encoding="utf-8")
    answer = json.loads(run("solve", line, "--along", "1", "--normal", ".3", "--phase=-60", "--json").stdout)
    assert answer["mean_velocity_mm_s"] == pytest.approx(89.0577, rel=1e-6)
    assert "amplitude_mm" not in answer
    answer = json.loads(run("solve", ellipse, "--stroke", "2", "-a", "20", "--json").stdout)
    assert (answer["amplitude_mm"], answer["drive_angle_deg"]) == (1.0, 20.0)
    assert json.loads(run("solve", ellipse, "--phase", "30", "--json").stdout)["normal_phase_deg"] == 30.0


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


def test_all_three_are_axes_and_have_columns(run: Run) -> None:
    result = run("map", "--along", ".5:1:2", "--normal", ".1:.3:3", "--phase=-90:90:5", "-f", "25", *FRICTION,
                 "-o", "-")  # fmt: skip
    rows = rows_of(result.stdout)
    assert tuple(rows[0])[: len(COLUMNS)] == COLUMNS
    assert len(rows) == 30
    assert "normal phase: 5 values, -90 ... 90 deg, step 45" in result.stderr
    scene = vibro.Scene(
        **(VALUES | {
            "along_amplitude": np.array([5e-4, 1e-3])[:, np.newaxis, np.newaxis],
            "normal_amplitude": np.array([1e-4, 2e-4, 3e-4])[:, np.newaxis],
            "normal_phase": np.radians([-90.0, -45.0, 0.0, 45.0, 90.0]),
        })
    )  # fmt: skip
    got = [float(row["mean_velocity_mm_s"]) for row in rows]
    np.testing.assert_allclose(got, 1e3 * vibro.solve(scene).mean_velocity.ravel(), rtol=1e-12, atol=1e-12)


def test_a_line_s_table_keeps_its_columns(run: Run) -> None:
    header = run("map", "-A", ".5:1:2", *NUT[2:], "-o", "-").stdout.splitlines()[0]
    assert header.startswith("amplitude_mm,frequency_hz,drive_angle_deg,static_friction")
    assert not any(name in header for name in ("along", "normal", "phase"))


def test_columns_are_chosen_by_name(run: Run) -> None:
    names = "normal_phase_deg,stroke_mm,acceleration_g"
    rows = rows_of(run("map", *ELLIPSE, "--phase=-90:90:3", "-o", "-", "--columns", names).stdout)
    assert [float(row["normal_phase_deg"]) for row in rows] == [-90, 0, 90]
    assert float(rows[0]["stroke_mm"]) == pytest.approx(2.0, rel=1e-15)  # the axes of the ellipse are X and Y
    assert float(rows[1]["stroke_mm"]) == pytest.approx(2.0 * math.hypot(1.0, 0.3), rel=1e-15)
    wrong = run("map", *ELLIPSE, "--phase=-90:90:3", "-o", "-", "--columns", "drive_angle_deg")
    assert "there is no column 'drive_angle_deg'" in wrong.stderr


def test_nothing_is_invented_of_an_ellipse_but_the_frequency(run: Run, tmp_path: Path) -> None:
    result = run("map", "--along", "1", "--normal", ".3", *FRICTION, "-o", "-")
    assert "frequency: 200 values, 5 ... 60 Hz" in result.stderr
    still = run("map", *ELLIPSE)
    assert "error: nothing varies" in still.stderr
    assert "--along 0.1:3:200" in still.stderr
    file = written(tmp_path, ELLIPSE_FILE)
    assert "--along 0.1:3:200" in run("traverse-time", file, "--sweep").stderr
    assert "frequency: 200 values" in run("map", file, "-o", "-").stderr


def test_the_sidecar_gives_what_was_solved(run: Run, tmp_path: Path) -> None:
    run("map", *ELLIPSE, "--phase=-180:180:9", "-o", "x")
    content = json.loads((tmp_path / "x.json").read_text(encoding="utf-8"))
    assert content["axes"]["normal_phase_deg"] == {
        "count": 9,
        "first": -180,
        "last": 180,
        "spacing": "linear",
    }
    assert content["scene"]["along_amplitude_mm"] == 1
    assert "drive_angle_deg" not in content["scene"]


def test_an_axis_is_held_by_its_letter(run: Run, tmp_path: Path) -> None:
    sweep = ("--along", ".5:1:3", "--normal", ".1:.3:3", "--phase=-90:90:3", "-f", "25", *FRICTION, "-o", "x")
    assert run("map", *sweep, "--at", "phi=-90", "--x", "Y").exit_code == 0
    wrong = run("map", *sweep, "--at", "alpha=20", "--force")
    assert "drive angle does not vary in this sweep" in wrong.stderr


def test_a_map_without_motion_says_where_motion_begins(run: Run) -> None:
    sweep = (
        "--along",
        ".01:.03:3",
        "--normal",
        ".01:.02:3",
        "--phase",
        "30",
        "-f",
        "25",
        *FRICTION,
        "-o",
        "-",
    )
    (line,) = [
        text for text in run("map", *sweep).stderr.splitlines() if text.startswith("at rest everywhere")
    ]
    words = line.split()
    frequency, factor = float(words[words.index("Hz,") - 1]), float(words[words.index("x") - 1])
    for by, regime in ((0.999, "no-slip"), (1.001, "forward-slip")):
        scaled = ("--along", by * factor * 0.03, "--normal", by * factor * 0.02, "-f", 25)
        for given in (scaled, ("--along", 0.03, "--normal", 0.02, "-f", by * frequency)):
            answer = json.loads(run("solve", "--phase", 30, *FRICTION, *given, "--json").stdout)
            assert answer["regime"] == regime


def test_python_sweeps_the_same(run: Run) -> None:
    swept = vibro.sweep(
        along_amplitude_mm=1, normal_amplitude_mm=0.3, normal_phase_deg="-180:180:5", frequency_hz=25,
        static_friction=0.4, kinetic_friction=0.3,
    )  # fmt: skip
    frame = swept.to_frame()
    assert tuple(frame.columns)[: len(COLUMNS)] == COLUMNS
    rows = rows_of(run("map", *ELLIPSE, "--phase=-180:180:5", "-o", "-").stdout)
    assert [float(row["mean_velocity_mm_s"]) for row in rows] == frame["mean_velocity_mm_s"].tolist()
    assert list(swept.axes) == ["normal_phase_deg"]
    with pytest.raises(vibro.VibroError, match=r"the call gives amplitude, along amplitude: a drive moves"):
        vibro.sweep(amplitude_mm=1, along_amplitude_mm=1)
