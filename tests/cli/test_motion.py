"""``vibro motion``: a measured trough becomes a scene file that the other commands read."""

from __future__ import annotations

import json
import re
import shlex
import shutil
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.commands import Run
from helpers.feeders import Feeder, feeder
from helpers.made_records import EXAMPLES

import vibro
from vibro.cli.motion_report import _told

NUT = EXAMPLES / "data" / "nut_trough_mv.csv"
SENSORS = ("--trough-along", "Trog längs", "--trough-normal", "Trog normal", "--sensitivity", "100mV/g")
FRICTION = ("--mu-s", "0.74", "--mu-d", "0.57")
BOTH = ("--trough-along", "x [m/s^2]", "--trough-normal", "y [g]")
GUIDE = (EXAMPLES.parent / "docs" / "motion.md").read_text(encoding="utf-8")


@pytest.fixture
def made(tmp_path: Path) -> tuple[Path, Feeder]:
    """A record of a feeder with three harmonics, and what it moves like."""
    true = feeder(2)
    record = true.record(2, seconds=2.0, rate=1600.0)
    x, y = record.trough.values()
    path = tmp_path / "feeder.csv"
    table = np.stack([record.time, x, y / 9.80665], axis=1)
    np.savetxt(path, table, "%.8g", ",", header="t [s],x [m/s^2],y [g]", comments="")
    return path, true


def scene(path: str) -> dict[str, Any]:
    content = tomllib.loads(Path(path).read_text(encoding="utf-8"))
    assert content.keys() == {"scene"}
    return dict(content["scene"])


def test_the_nut_s_record_becomes_a_scene_that_is_solved(run: Run) -> None:
    result = run("motion", NUT, *SENSORS, *FRICTION, "-L", "600", "-o", "drive.toml")
    assert result.exit_code == 0, result.stderr
    assert "wrote drive.toml" in result.stderr
    assert "warning" not in result.stderr
    for said in (
        r"^record +\S*nut_trough_mv\.csv: 479 rows, 12 cycles, 39\.83 samples a cycle$",
        r"^fundamental +a line: amplitude 1\.0218 ± 0\.001\d mm, frequency 15\.00\d+ ± 0\.0006\d Hz, drive",
        r"^harmonics +1 of 16 stand out of the noise \(each by chance in one record of 1000\)$",
        r"^throw number +0\.323\d ± 0\.001\d$",
        r"^mean speed +17\.7\d+ ± 0\.0\d+ mm/s, forward-slip$",
        r"^ +noise alone, in 200 draws: 100 % forward-slip$",
        r"^calibration +errors would change it by: 2 % of gain \d.* %, 1 deg of tilt .* %, 50 us between",
        r"^1 +0\.9573 ± 0\.001\d +0 +0\.3571 ± 0\.001\d +-0\.1\d ± 0\.2\d +100$",
    ):
        assert re.search(said, result.stdout, re.MULTILINE), said
    assert "last harmonic" not in result.stdout
    written = scene("drive.toml")
    assert list(written) == [
        "along_amplitude_mm", "normal_amplitude_mm", "normal_phase_deg", "frequency_hz", "static_friction",
        "kinetic_friction", "trough_length_mm",
    ]  # fmt: skip
    solved = run("solve", "drive.toml", "--json")
    assert solved.exit_code == 0, solved.stderr
    speed = json.loads(solved.stdout)["mean_velocity_mm_s"]
    told = float(re.findall(r"^mean speed +([\d.]+)", result.stdout, re.MULTILINE)[0])
    assert speed == pytest.approx(told, abs=0.006)
    # The record's truth: 17.63 mm/s by the closed form of its slide.
    assert speed == pytest.approx(17.63, abs=0.25)


def test_every_command_reads_what_it_writes(run: Run) -> None:
    assert run("motion", NUT, *SENSORS, *FRICTION, "-L", "600", "-o", "drive.toml").exit_code == 0
    for args in (
        ("simulate", "drive.toml"),
        ("traverse-time", "drive.toml"),
        ("map", "drive.toml", "-f", "10:20:5", "-o", "map"),
    ):
        result = run(*args)
        assert result.exit_code == 0, result.stderr


def test_harmonics_are_written_with_all_digits_and_solved(run: Run, made: tuple[Path, Feeder]) -> None:
    path, true = made
    result = run("motion", path, *BOTH, "--mu-s", ".4", "--mu-d", ".3", "-o", "feeder.toml", "--json")
    assert result.exit_code == 0, result.stderr
    content = json.loads(result.stdout)
    assert content["harmonics_found"] == 3
    assert content["scene"] == scene("feeder.toml")
    measured = vibro.measured_motion(path, trough_along="x", trough_normal="y")
    read = vibro.read_scene("feeder.toml")
    assert read.along_harmonics is not None
    got = [float(size) * np.exp(1j * float(phase)) for size, phase in read.along_harmonics]
    np.testing.assert_allclose(got, measured.along, rtol=4e-15)
    for k, one in enumerate(content["harmonics"]):
        exact = true.on_its_clock
        for way, motion in (("along", exact.along[k]), ("normal", exact.normal[k])):
            off = one[f"{way}_amplitude_mm"] - 1e3 * abs(motion)
            assert abs(off) < 4.0 * one[f"{way}_amplitude_error_mm"] < 0.05 * abs(1e3 * motion)
    speed = content["speed"]
    exact_speed = 1e3 * float(
        vibro.solve(vibro.Scene(**true.drive(), static_friction=0.4, kinetic_friction=0.3)).mean_velocity
    )
    assert abs(speed["mean_velocity_mm_s"] - exact_speed) < 4.0 * speed["mean_velocity_error_mm_s"]
    assert speed["shares"] == {speed["regime"]: 1.0}
    solved = json.loads(run("solve", "feeder.toml", "--json").stdout)
    assert solved["mean_velocity_mm_s"] == pytest.approx(speed["mean_velocity_mm_s"], rel=1e-12)
    printed = run("motion", path, *BOTH, "--mu-s", ".4", "--mu-d", ".3", "-q").stdout
    assert re.search(r"^last harmonic +changes it by [+-]\d[\d.]* %$", printed, re.MULTILINE)
    assert len(re.findall(r"^[123] +0\.\d", printed, re.MULTILINE)) == 3


def test_without_friction_the_speed_is_told_how_to_get(run: Run) -> None:
    result = run("motion", NUT, *SENSORS, "-o", "drive")
    assert result.exit_code == 0, result.stderr
    assert "mean speed    unknown without friction: add --mu-s and --mu-d, or a scene file" in result.stdout
    assert not {"static_friction", "kinetic_friction"} & scene("drive.toml").keys()
    assert json.loads(run("motion", NUT, *SENSORS, "--json").stdout)["speed"] is None
    assert run("solve", "drive.toml", *FRICTION).exit_code == 0
    # One of two frictions is a slip.
    result = run("motion", NUT, *SENSORS, "--mu-s", "0.74")
    assert (result.exit_code, result.stdout) == (2, "")
    assert "error: missing: kinetic friction (--mu-d or --mu-ratio)" in result.stderr


def test_a_scene_file_gives_the_rest_of_the_scene(run: Run) -> None:
    Path("own.toml").write_text(
        "[scene]\namplitude_mm = 5\nfrequency_hz = 50\ndrive_angle_deg = 3\nstatic_friction = 0.74\n"
        "friction_ratio = 0.75\ntrough_angle_deg = 2\n",
        encoding="utf-8",
    )
    result = run("motion", "own.toml", NUT, *SENSORS, "-o", "drive.toml")
    assert result.exit_code == 0, result.stderr
    written = scene("drive.toml")
    assert written["frequency_hz"] == pytest.approx(15.003, abs=2e-3)
    assert written["trough_angle_deg"] == 2
    assert written["friction_ratio"] == 0.75
    assert not {"amplitude_mm", "drive_angle_deg"} & written.keys()
    refused = run("motion", "own.toml", NUT, *SENSORS, "-o", "own.toml", "--force")
    assert (refused.exit_code, refused.stdout) == (1, "")
    assert "it is what this run reads" in refused.stderr


def test_one_sensor_needs_the_drive_angle(run: Run) -> None:
    one = (SENSORS[0], SENSORS[1], *SENSORS[4:])
    result = run("motion", NUT, *one)
    assert (result.exit_code, result.stdout) == (2, "")
    assert "hint: name --trough-normal too, or give the angle of the line" in result.stderr
    result = run("motion", NUT, *one, "-a", "20.5", *FRICTION, "-o", "drive")
    assert result.exit_code == 0, result.stderr
    assert "Hz, drive angle 20.5 deg as given" in result.stdout
    assert "normal" not in result.stdout.replace("normal_trough", "")
    written = scene("drive.toml")
    slope = written["normal_amplitude_mm"] / written["along_amplitude_mm"]
    assert np.degrees(np.arctan(slope)) == pytest.approx(20.5)
    for angle in ("90", "-1", "x"):
        assert run("motion", NUT, *one, f"--drive-angle={angle}").exit_code == 2
    assert run("motion", NUT, *SENSORS, "-a", "20").exit_code == 2


def test_files_are_not_replaced_without_force(run: Run) -> None:
    Path("drive.toml").write_text("mine", encoding="utf-8")
    Path("drive-speed.png").write_bytes(b"mine")
    result = run("motion", NUT, *SENSORS, "-o", "drive.toml")
    assert (result.exit_code, result.stdout) == (1, "")
    assert "error: drive.toml exists already" in result.stderr
    assert Path("drive.toml").read_text(encoding="utf-8") == "mine"
    assert run("motion", NUT, *SENSORS, "-o", "drive.toml", "--force").exit_code == 0
    assert "along_amplitude_mm" in scene("drive.toml")
    assert Path("drive-speed.png").read_bytes() == b"mine"
    assert {path.name for path in Path().iterdir()} == {"drive.toml", "drive-speed.png"}


@pytest.mark.parametrize(
    ("output", "written"),
    [("a/b", "a/b.toml"), ("a/", "a/nut_trough_mv-drive.toml"), ("c.toml", "c.toml"), ("d.1", "d.1.toml")],
)
def test_the_file_goes_where_it_is_wanted(run: Run, output: str, written: str) -> None:
    result = run("motion", NUT, *SENSORS, "-o", output)
    assert result.exit_code == 0, result.stderr
    assert "along_amplitude_mm" in scene(written)


def test_the_scene_file_may_go_to_stdout(run: Run) -> None:
    result = run("motion", NUT, *SENSORS, "-o", "-")
    assert result.exit_code == 0, result.stderr
    assert tomllib.loads(result.stdout)["scene"]["frequency_hz"] == pytest.approx(15.003, abs=2e-3)
    result = run("motion", NUT, *SENSORS, "-o", "-", "--json")
    assert (result.exit_code, result.stdout) == (2, "")
    assert "--json and -o - both want stdout" in result.stderr


@pytest.mark.parametrize(
    ("value", "error", "told"),
    [
        (1.23456, 0.012, "1.235 ± 0.012"),
        (1.0, 1.1e-6, "1.0000000 ± 0.0000011"),
        (1.23456789, 0.9e-6, "1.23457 ± 9e-07"),
        (1.1e-6, 2e-7, "0.00000110 ± 0.00000020"),
        (0.9e-6, 2e-7, "9e-07 ± 2e-07"),
        (-0.3, 63.0, "0 ± 63"),
    ],
)
def test_numbers_are_written_to_their_errors(value: float, error: float, told: str) -> None:
    assert _told(value, error) == told


@pytest.mark.parametrize(
    ("args", "said"),
    [
        ((), "error: missing: RECORD.csv"),
        (("x.csv",), "error: cannot read x.csv"),
        ((NUT,), "no acceleration of the trough named among 'Zeit in s', 'Weg in mm'"),
        ((NUT, *SENSORS, "-A", "1"), "No such option: -A"),
        ((NUT, *SENSORS, "-f", "15"), "No such option: -f"),
        ((NUT, "own.toml", *SENSORS), "own.toml is a scene file: the scene comes before the data"),
    ],
)
def test_what_is_wrong_is_told(run: Run, args: tuple[Any, ...], said: str) -> None:
    result = run("motion", *args)
    assert result.exit_code == (1 if "x.csv" in args else 2)
    assert result.stdout == ""
    assert said in result.stderr


def test_compare_says_which_command_measures_a_trough_alone(run: Run) -> None:
    Path("r.csv").write_text("t [s],x [g]\n" + "".join(f"{i},{i % 7}\n" for i in range(30)), encoding="utf-8")
    result = run("compare", "r.csv", *FRICTION, "-a", "20", "--trough-along", "x")
    assert result.exit_code == 2
    assert "no signal of the body found among 't [s]', 'x [g]'" in result.stderr
    assert "hint: vibro motion measures the trough alone" in result.stderr


# --- compare ------------------------------------------------------------------------------------------


@pytest.fixture
def parted(made: tuple[Path, Feeder], tmp_path: Path) -> Path:
    """The same record with a displacement of a part, which only has to be there."""
    path, _ = made
    table = np.loadtxt(path, delimiter=",", skiprows=1)
    way = 1e3 * 0.02 * table[:, :1]
    header = "t [s],x [m/s^2],y [g],way [mm]"
    target = tmp_path / "part.csv"
    np.savetxt(target, np.hstack([table, way]), "%.8g", ",", header=header, comments="")
    return target


def test_compare_takes_the_harmonics_that_change_the_speed(run: Run, parted: Path) -> None:
    Path("own.toml").write_text(
        "[scene]\nalong_amplitudes_mm = [9, 1, 1, 1]\nalong_phases_deg = [0, 0, 0, 5]\nfrequency_hz = 50\n"
        "static_friction = 0.4\nkinetic_friction = 0.3\n",
        encoding="utf-8",
    )
    args = (parted, "--displacement", "way", *BOTH)
    result = run("compare", "own.toml", *args, "--json")
    assert result.exit_code == 0, result.stderr
    assert re.search(
        r"the trough moves with 3 harmonics, which change the computed speed by [+-]\d", result.stderr
    )
    assert "pure sine" not in result.stderr
    content = json.loads(result.stdout)
    measured = vibro.measured_motion(parted, trough_along="x", trough_normal="y")
    advance = 1e3 * float(
        vibro.solve(
            vibro.Scene(**measured.drive(), static_friction=0.4, kinetic_friction=0.3)
        ).displacement_per_cycle
    )
    assert content["figures"]["stroke_advance"]["computed"] == pytest.approx(advance, rel=1e-9)
    assert content["trough"]["along_amplitude_3_mm"]["measured"] == pytest.approx(
        1e3 * abs(measured.along[2])
    )
    assert content["scene"]["along_amplitude_4_mm"] == 0.0  # the file's own goes
    printed = run("compare", "own.toml", *args, "-q").stdout
    assert "second along amplitude 0.0" in printed


def test_compare_keeps_to_the_fundamental_where_harmonics_do_not_matter_or_are_not_known(
    run: Run, parted: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    args = ("compare", parted, "--displacement", "way", *BOTH, "--mu-s", ".4", "--mu-d", ".3", "--json")
    for change, said, taken in ((1e-3, False, False), (-1.1e-3, False, True), (float("nan"), True, False)):
        monkeypatch.setattr("vibro.records.measured_speeds.change_by_harmonics", lambda *_, x=change: x)
        result = run(*args)
        assert result.exit_code == 0, result.stderr
        assert ("the first is taken alone" in result.stderr) == said
        assert ("along_amplitude_2_mm" in json.loads(result.stdout)["scene"]) == taken


def test_compare_takes_harmonics_of_one_sensor_along_the_line_of_the_scene(run: Run, parted: Path) -> None:
    args = ("compare", parted, "--displacement", "way", *BOTH[:2], "--mu-s", ".4", "--mu-d", ".3", "--json")
    result = run(*args, "-a", "25")
    assert result.exit_code == 0, result.stderr
    scene = json.loads(result.stdout)["scene"]
    assert scene["normal_amplitude_3_mm"] == pytest.approx(
        np.tan(np.radians(25.0)) * scene["along_amplitude_3_mm"]
    )
    ellipse = run(*args, "--normal", "0.2")
    assert ellipse.exit_code == 0, ellipse.stderr
    assert "along_amplitude_2_mm" not in json.loads(ellipse.stdout)["scene"]


# --- the guide ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "line", re.findall(r"^vibro .*$", "".join(re.findall(r"```bash\n(.*?)```", GUIDE, re.DOTALL)), re.M)
)
def test_the_commands_of_the_guide_run(run: Run, line: str) -> None:
    shutil.copytree(EXAMPLES, "examples")
    made = re.findall(r"^\$ (vibro .*?)$", GUIDE, re.MULTILINE)[0]
    assert run(*shlex.split(made)[1:]).exit_code == 0
    result = run(*shlex.split(line, comments=True)[1:])
    assert result.exit_code == 0, result.stderr
    assert "warning" not in result.stderr


def test_the_guide_shows_what_is_printed(run: Run) -> None:
    shutil.copytree(EXAMPLES, "examples")
    line, shown = re.findall(r"```console\n\$ (vibro .*?)\n(.*?)```", GUIDE, re.DOTALL)[0]
    assert len(shown.splitlines()) > 8
    assert run(*shlex.split(line)[1:], "-q").stdout == shown
