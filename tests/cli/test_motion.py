"""``vibro motion``: a measured trough becomes a scene file that the other commands read."""

from __future__ import annotations

import json
import re
import shlex
import shutil
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.cases import each
from helpers.commands import Run
from helpers.feeders import Feeder, feeder
from helpers.made_records import EXAMPLES

import vibro
from vibro.cli.motion_report import _told
from vibro.records.measured_speeds import Speeds, speeds_of

NUT = EXAMPLES / "data" / "nut_trough_mv.csv"
SENSORS = ("--trough-along", "Trog längs", "--trough-normal", "Trog normal", "--sensitivity", "100mV/g")
FRICTION = ("--mu-s", "0.74", "--mu-d", "0.57")
BOTH = ("--trough-along", "x [m/s^2]", "--trough-normal", "y [g]")
GUIDE = (EXAMPLES.parent / "docs" / "guide" / "motion.md").read_text(encoding="utf-8")


@pytest.fixture
def made(tmp_path: Path) -> tuple[Path, Feeder]:
    """A record of a feeder with three harmonics, and what it moves like."""
    true = feeder(2)
    record = true.record(2)
    x, y = record.trough.values()
    path = tmp_path / "feeder.csv"
    table = np.stack([record.time, x, y / 9.80665], axis=1)
    np.savetxt(path, table, "%.8g", ",", header="t [s],x [m/s^2],y [g]", comments="")
    return path, true


def scene(path: str) -> dict[str, Any]:
    content = tomllib.loads(Path(path).read_text(encoding="utf-8"))
    assert content.keys() == {"scene"}
    return dict(content["scene"])


def test_a_motion_whose_speed_is_unresolved_is_exit_code_3(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    def doubtful(*args: Any) -> Speeds:
        return replace(speeds_of(*args), status=vibro.Status.UNRESOLVED)

    monkeypatch.setattr("vibro.records.measured_speeds.speeds_of", doubtful)
    assert run("motion", NUT, *SENSORS, *FRICTION).exit_code == 3


def test_the_nut_s_record_becomes_a_scene_that_is_solved(run: Run) -> None:
    result = run("motion", NUT, *SENSORS, *FRICTION, "-L", "600", "-o", "drive.toml")
    assert result.exit_code == 0, result.stderr
    assert "wrote drive.toml" in result.stderr
    assert "warning" not in result.stderr
    written = scene("drive.toml")
    # The options that are printed give the same.
    told = re.findall(r"^solve with +vibro (solve .*)$", result.stdout, re.MULTILINE)[0]
    options = run(*shlex.split(told), "-L", "600", "--json")
    assert options.exit_code == 0, options.stderr
    assert json.loads(options.stdout) == json.loads(run("solve", "drive.toml", "--json").stdout)
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


def test_its_trough_length_is_read(run: Run) -> None:
    assert run("motion", NUT, *SENSORS, *FRICTION, "-L", "600", "-o", "drive.toml").exit_code == 0
    assert run("traverse-time", "drive.toml").exit_code == 0


def test_harmonics_are_written_with_the_digits_that_the_record_tells(
    run: Run, made: tuple[Path, Feeder]
) -> None:
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
    assert np.count_nonzero(got - measured.along) >= 2
    assert (abs(got - measured.along) < 0.01 * measured.standard_errors[:, 0]).all()
    assert max(len(f"{x}".replace(".", "").lstrip("-0")) for x in content["scene"]["along_amplitudes_mm"]) < 9
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
    off = solved["mean_velocity_mm_s"] - speed["mean_velocity_mm_s"]
    assert abs(off) < 0.02 * speed["mean_velocity_error_mm_s"]
    onset = content["hop_onset"]
    assert onset["times_todays_amplitude"] == pytest.approx(1.0 / content["throw_number"])
    assert 0.0 < onset["times_todays_amplitude_error"] < 0.01


def test_without_friction_the_speed_is_told_how_to_get(run: Run) -> None:
    result = run("motion", NUT, *SENSORS, "-o", "drive")
    assert result.exit_code == 0, result.stderr
    assert not {"static_friction", "kinetic_friction"} & scene("drive.toml").keys()
    assert json.loads(run("motion", NUT, *SENSORS, "--json").stdout)["speed"] is None
    assert run("solve", "drive.toml", *FRICTION).exit_code == 0


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


def test_one_sensor_needs_the_drive_angle(run: Run) -> None:
    one = (SENSORS[0], SENSORS[1], *SENSORS[4:])
    result = run("motion", NUT, *one, "-a", "20.5", *FRICTION, "-o", "drive")
    assert result.exit_code == 0, result.stderr
    written = scene("drive.toml")
    assert written["drive_angle_deg"] == 20.5  # as given
    assert written["amplitude_mm"] == pytest.approx(1.02, abs=5e-3)


def test_files_are_not_replaced_without_force(run: Run) -> None:
    Path("drive.toml").write_text("mine", encoding="utf-8")
    Path("drive-speed.png").write_bytes(b"mine")
    result = run("motion", NUT, *SENSORS, "-o", "drive.toml")
    assert (result.exit_code, result.stdout) == (1, "")
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


@each(
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


@pytest.mark.parametrize("unit", ["g", "mV", "mm/s", "um"])
def test_a_record_in_any_unit_gives_the_same(run: Run, unit: str) -> None:
    true = feeder(2)
    kind = {"mm/s": "velocity", "mm": "displacement", "um": "displacement"}.get(unit, "acceleration")
    record = true.record(2, seconds=1.0, density=0.0, kind=kind)
    sizes = {"g": 9.80665, "m/s^2": 1.0, "mV": 9.80665 / 98.7, "mm": 1e-3, "um": 1e-6}
    table = np.stack([1e3 * record.time, *record.trough.values()], axis=1)
    table[:, 1:] /= sizes.get(unit, 1e-3)
    header = f"t [ms];x [{unit}];y [{unit}]"
    np.savetxt("r.csv", table, "%.12g", ";", header=header, comments="")
    sensitivity = ("--sensitivity", "98.7mV/g") if unit == "mV" else ()
    result = run("motion", "r.csv", "--trough-along", "x", "--trough-normal", "y", *sensitivity, "--json")
    assert result.exit_code == 0, result.stderr
    content, exact = json.loads(result.stdout), true.on_its_clock
    assert content["scene"]["frequency_hz"] == pytest.approx(true.frequency, rel=1e-6)
    for k, one in enumerate(content["harmonics"]):
        assert one["along_amplitude_mm"] == pytest.approx(1e3 * abs(exact.along[k]), rel=1e-5)
        assert one["normal_amplitude_mm"] == pytest.approx(1e3 * abs(exact.normal[k]), rel=1e-5)
        assert one["normal_phase_deg"] == pytest.approx(np.degrees(np.angle(exact.normal[k])), abs=1e-3)


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


def test_compare_keeps_to_the_fundamental_where_harmonics_do_not_matter_or_are_not_known(
    run: Run, parted: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    args = ("compare", parted, "--displacement", "way", *BOTH, "--mu-s", ".4", "--mu-d", ".3", "--json")
    for change, said in ((1e-3, False), (float("nan"), True)):
        monkeypatch.setattr("vibro.records.measured_speeds.change_by_harmonics", lambda *_, x=change: x)
        result = run(*args)
        assert result.exit_code == 0, result.stderr
        assert ("the first is taken alone" in result.stderr) == said
        assert "along_amplitude_2_mm" not in json.loads(result.stdout)["scene"]


def test_compare_takes_harmonics_of_one_sensor_along_the_line_of_the_scene(run: Run, parted: Path) -> None:
    args = ("compare", parted, "--displacement", "way", *BOTH[:2], "--mu-s", ".4", "--mu-d", ".3", "--json")
    result = run(*args, "-a", "25")
    assert result.exit_code == 0, result.stderr
    scene = json.loads(result.stdout)["scene"]
    assert scene["normal_amplitude_3_mm"] == pytest.approx(
        np.tan(np.radians(25.0)) * scene["along_amplitude_3_mm"]
    )
    ellipse = run(*args, "normal=0.2")
    assert ellipse.exit_code == 0, ellipse.stderr
    assert "along_amplitude_2_mm" not in json.loads(ellipse.stdout)["scene"]


# --- the guide ----------------------------------------------------------------------------------------


@pytest.mark.usefixtures("unsaved")
def test_the_commands_of_the_guide_run(run: Run) -> None:
    shutil.copytree(EXAMPLES, "examples")
    made = re.findall(r"^\$ (vibro .*?)$", GUIDE, re.MULTILINE)[0]
    assert run(*shlex.split(made)[1:]).exit_code == 0
    lines = re.findall(r"^vibro .*$", "".join(re.findall(r"```bash\n(.*?)```", GUIDE, re.DOTALL)), re.M)
    assert len(lines) > 2
    for line in lines:
        result = run(*shlex.split(line, comments=True)[1:])
        assert result.exit_code == 0, result.stderr
        assert "warning" not in result.stderr


def test_the_guide_shows_what_is_printed(run: Run) -> None:
    shutil.copytree(EXAMPLES, "examples")
    line, shown = re.findall(r"```console\n\$ (vibro .*?)\n(.*?)```", GUIDE, re.DOTALL)[0]
    assert len(shown.splitlines()) > 8
    assert run(*shlex.split(line)[1:], "-q").stdout == shown
