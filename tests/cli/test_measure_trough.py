"""``vibro measure`` of sensors on a trough: its motion, a scene file of it, and a part on that motion."""

from __future__ import annotations

import json
import re
import runpy
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.commands import Run, rows_of
from helpers.feeders import Feeder, feeder
from helpers.made_records import EXAMPLES, trough_record

import vibro
from vibro.records.reading import read_sensitivities
from vibro.records.trough import Speeds, speeds_of

SCENE = EXAMPLES / "safety_nut.toml"
NUT = EXAMPLES / "data" / "nut_trough_mv.csv"
MADE: dict[str, Any] = runpy.run_path(str(EXAMPLES / "data" / "make_nut_trough_mv.py"))
ALONG, NORMAL = ("--trough-along", "Trog längs"), ("--trough-normal", "Trog normal")
SENSORS = (*ALONG, *NORMAL, "--sensitivity", "100mV/g")
EXACT = "tilt=0,gain=0,cross=0,delay=0,angle=0"  # sensors whose noise alone counts
NOISE_ALONE = ("--sensor", EXACT)
FRICTION = ("--mu-s", "0.74", "--mu-d", "0.57")
BOTH = ("--trough-along", "x [m/s^2]", "--trough-normal", "y [g]")
TRUE = {"amplitude_mm": 1.02, "frequency_hz": 15.003, "drive_angle_deg": 20.5}
GUIDE = (EXAMPLES.parent / "docs" / "guide" / "measure.md").read_text(encoding="utf-8")


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


@pytest.fixture
def parted(made: tuple[Path, Feeder], tmp_path: Path) -> Path:
    """The same record with a displacement of a part, which only has to be there."""
    path, _ = made
    table = np.loadtxt(path, delimiter=",", skiprows=1)
    header = "t [s],x [m/s^2],y [g],way [mm]"
    target = tmp_path / "part.csv"
    np.savetxt(target, np.hstack([table, 20.0 * table[:, :1]]), "%.8g", ",", header=header, comments="")
    return target


def scene(path: str) -> dict[str, Any]:
    content = tomllib.loads(Path(path).read_text(encoding="utf-8"))
    assert content.keys() == {"scene"}
    return dict(content["scene"])


def told(result: Any) -> Any:
    assert result.exit_code == 0, result.stderr
    return json.loads(result.stdout)


def test_the_committed_record_is_what_its_script_makes() -> None:
    header, *lines = NUT.read_text(encoding="utf-8").splitlines()
    made = MADE["table"]()
    assert header == ";".join(made)
    rows = [[float(cell.replace(",", ".") or "nan") for cell in line.split(";")] for line in lines]
    for values, column in zip(made.values(), np.array(rows).T, strict=True):
        np.testing.assert_allclose(column, values, atol=2e-2)


# --- the trough alone -----------------------------------------------------------------------------------


def test_a_motion_whose_speed_is_unresolved_is_exit_code_3(
    run: Run, made: tuple[Path, Feeder], monkeypatch: pytest.MonkeyPatch
) -> None:
    def doubtful(*args: Any) -> Speeds:
        return replace(speeds_of(*args), status=vibro.Status.UNRESOLVED)

    monkeypatch.setattr("vibro.records.measurement.speeds_of", doubtful)
    assert run("measure", made[0], *BOTH, *FRICTION).exit_code == 3


def test_a_record_of_the_trough_and_a_part_becomes_a_scene_that_is_solved(run: Run) -> None:
    """Both are measured, and compared; the scene file moves along a line, as the facts say."""
    content = told(
        run("measure", NUT, *SENSORS, *NOISE_ALONE, *FRICTION, "-L", "600", "-o", "drive.toml", "--json")
    )
    written = scene("drive.toml")
    assert written == content["scene"]
    for column, true in TRUE.items():
        found = content["trough"][column]
        assert abs(found["measured"] - true) < 3.0 * found["standard_error"] < 0.02 * true
        assert written[column] == pytest.approx(found["measured"], abs=0.01 * found["standard_error"])
    speed = told(run("solve", "drive.toml", "--json"))["mean_velocity_mm_s"]
    assert speed == pytest.approx(content["speed"]["mean_velocity_mm_s"], abs=0.006)
    # The record's truth: 17.63 mm/s by the closed form of its slide.
    assert speed == pytest.approx(17.63, abs=0.25)
    assert content["figures"]["mean_speed"]["computed"] == pytest.approx(speed, rel=1e-9)
    assert content["figures"]["mean_speed"]["measured"] == pytest.approx(17.633, abs=1e-3)
    assert content["trough_time_at_zero_s"] == pytest.approx(MADE["TRIGGER_TIME"], abs=1e-4)
    assert content["warnings"] == []
    assert run("traverse-time", "drive.toml").exit_code == 0


def test_harmonics_are_written_with_the_digits_that_the_record_tells(
    run: Run, made: tuple[Path, Feeder]
) -> None:
    path, true = made
    frictions = ("--mu-s", ".4", "--mu-d", ".3")
    args = (*BOTH, *NOISE_ALONE, *frictions)
    content = told(run("measure", path, *args, "-o", "feeder.toml", "-o", "h.csv", "--json"))
    assert content["harmonics_found"] == 3
    assert content["scene"] == scene("feeder.toml")
    measured = vibro.measured_motion(path, trough_along="x", trough_normal="y", sensor=EXACT)
    read = vibro.read_scene("feeder.toml")
    assert read.along_harmonics is not None
    got = [float(size) * np.exp(1j * float(phase)) for size, phase in read.along_harmonics]
    assert np.count_nonzero(got - measured.along) >= 2
    assert (abs(got - measured.along) < 0.01 * measured.standard_errors[:, 0]).all()
    assert max(len(f"{x}".replace(".", "").lstrip("-0")) for x in content["scene"]["along_amplitudes_mm"]) < 9
    rows = rows_of(Path("h.csv").read_text(encoding="utf-8"))
    for k, one in enumerate(content["harmonics"]):
        assert {key: float(cell) for key, cell in rows[k].items()} == one
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
    solved = told(run("solve", "feeder.toml", "--json"))
    off = solved["mean_velocity_mm_s"] - speed["mean_velocity_mm_s"]
    assert abs(off) < 0.02 * speed["mean_velocity_error_mm_s"]
    onset = content["hop_onset"]
    assert onset["times_todays_amplitude"] == pytest.approx(1.0 / content["throw_number"])
    assert 0.0 < onset["times_todays_amplitude_error"] < 0.01


def test_without_friction_neither_speed_nor_part_is_computed(run: Run) -> None:
    content = told(run("measure", NUT, *SENSORS, "-o", "drive.toml", "--json"))
    assert content["speed"] is None
    assert "figures" not in content
    assert not {"static_friction", "kinetic_friction"} & scene("drive.toml").keys()
    assert run("solve", "drive.toml", *FRICTION).exit_code == 0


def test_a_scene_file_gives_the_rest_of_the_scene(run: Run, made: tuple[Path, Feeder]) -> None:
    """Its own motion, of whatever kind, is not the trough's."""
    own = "[scene]\nfrequency_hz = 30\nstatic_friction = 0.74\nfriction_ratio = 0.75\ntrough_angle_deg = 2\n"
    for drive in (
        "along_amplitudes_mm = [9, 1, 1, 1]\nalong_phases_deg = [0, 0, 0, 5]\n",
        "[motion]\nalong_steps = [[0.8, 2.4], [0.2, -9.6]]\n",
        "drive_angle_deg = 20\n"
        '[machine]\nkind = "magnet"\ntrough_mass_kg = 6\ncounter_mass_kg = 12\nnatural_hz = 55\n'
        "damping_ratio = 0.02\ncalibration = { amplitude_mm = 0.3, frequency_hz = 50 }\n",
    ):
        Path("own.toml").write_text(own + drive, encoding="utf-8")
        result = run("measure", "own.toml", made[0], *BOTH, "-o", "drive.toml", "--force")
        assert result.exit_code == 0, result.stderr
        written = scene("drive.toml")
        assert written["frequency_hz"] == pytest.approx(made[1].frequency, rel=1e-4)
        assert (written["trough_angle_deg"], written["friction_ratio"]) == (2, 0.75)
        assert len(written["along_amplitudes_mm"]) == 3
        assert not {"amplitude_mm", "stroke_mm", "drive_angle_deg"} & written.keys()


def test_a_part_of_a_record_is_chosen_by_its_times(run: Run) -> None:
    args = ("measure", NUT, *SENSORS, "--json")
    whole, part = told(run(*args)), told(run(*args, "--from", "0.1", "--to", "0.7"))
    assert part["rows"] == pytest.approx(360, abs=5)
    assert whole["rows"] > 450
    for wrong, text in (("50", "0 rows lie from 50 to"), ("x", "'x'")):
        refused = run(*args, "--from", wrong)
        assert (refused.exit_code, text in refused.stderr) == (2, True)


@pytest.mark.parametrize("unit", ["g", "mV", "um"])
def test_a_record_in_any_unit_gives_the_same(run: Run, unit: str) -> None:
    true = feeder(2)
    kind = "displacement" if unit == "um" else "acceleration"
    record = true.record(2, seconds=1.0, density=0.0, kind=kind)
    sizes = {"g": 9.80665, "mV": 9.80665 / 98.7, "um": 1e-6}
    table = np.stack([1e3 * record.time, *record.trough.values()], axis=1)
    table[:, 1:] /= sizes[unit]
    header = f"t [ms];x [{unit}];y [{unit}]"
    np.savetxt("r.csv", table, "%.12g", ";", header=header, comments="")
    sensitivity = ("--sensitivity", "98.7mV/g") if unit == "mV" else ()
    content = told(
        run("motion", "r.csv", "--trough-along", "x", "--trough-normal", "y", *sensitivity, "--json")
    )
    exact = true.on_its_clock
    assert content["scene"]["frequency_hz"] == pytest.approx(true.frequency, rel=1e-6)
    for k, one in enumerate(content["harmonics"]):
        assert one["along_amplitude_mm"] == pytest.approx(1e3 * abs(exact.along[k]), rel=1e-5)
        assert one["normal_amplitude_mm"] == pytest.approx(1e3 * abs(exact.normal[k]), rel=1e-5)
        assert one["normal_phase_deg"] == pytest.approx(np.degrees(np.angle(exact.normal[k])), abs=1e-3)


# --- a part on it ---------------------------------------------------------------------------------------


def test_a_part_is_computed_on_the_harmonics_that_change_its_speed(run: Run, parted: Path) -> None:
    args = ("--displacement", "way", *BOTH, *NOISE_ALONE, "--mu-s", ".4", "--mu-d", ".3", "--json")
    result = run("compare", parted, *args)
    content = told(result)
    assert re.search(
        r"the trough moves with 3 harmonics, which change the computed speed by [+-]\d", result.stderr
    )
    assert "pure sine" not in result.stderr
    measured = vibro.measured_motion(parted, trough_along="x", trough_normal="y")
    solved = vibro.solve(vibro.Scene(**measured.drive(), static_friction=0.4, kinetic_friction=0.3))
    advance = 1e3 * float(solved.displacement_per_cycle)
    assert content["figures"]["stroke_advance"]["computed"] == pytest.approx(advance, rel=1e-5)
    found = content["trough"]["along_amplitude_3_mm"]["measured"]
    assert found == pytest.approx(1e3 * abs(measured.along[2]))


def test_reverse_leaves_a_sensor_normal_to_the_trough_as_it_is(run: Run) -> None:
    """It turns the axis along the trough; upwards stays upwards."""
    args = ("measure", SCENE, NUT, *NORMAL, "--sensitivity", "100mV/g", "--json", "-q")
    plain, turned = told(run(*args)), told(run(*args, "--reverse"))
    for key in ("trough", "trough_time_at_zero_s", "scene"):
        assert plain[key] == turned[key]
    advances = [content["figures"]["stroke_advance"]["measured"] for content in (plain, turned)]
    assert advances[0] == pytest.approx(-advances[1])


def feeder_file(harmonic: float, *, cycles: float = 12.0, ellipse: float = 0.0) -> Path:
    """Write accelerations of a trough, and the displacement of a body that rests: the drive alone counts."""
    made = trough_record(cycles=cycles, noise=0.05, harmonic=harmonic, ellipse=ellipse)
    still = np.random.default_rng(1).standard_normal(made.time.size)
    columns = {"t [s]": made.time, "x [mm]": 1e-3 * still} | {
        f"{name} [m/s^2]": values for name, values in made.trough.items()
    }
    rows = np.stack(list(columns.values()), axis=1)
    np.savetxt("feeder.csv", rows, "%.9g", ",", header=",".join(columns), comments="")
    return Path("feeder.csv")


PAIR = ("--trough-along", "trough_along", "--trough-normal", "trough_normal")


def test_a_fit_without_the_harmonics_is_refused(run: Run) -> None:
    """Where a record does not tell them, an estimate would take their effect for its own."""
    short = feeder_file(0.0, cycles=5.0)
    assert run("measure", short, *FRICTION, *PAIR).exit_code == 0
    result = run("measure", short, *FRICTION, *PAIR, "--fit", "mu_d")
    assert (result.exit_code, result.stdout) == (2, "")

    ellipse = ("along=1mm", "normal=0.3mm", "phase=-60deg", *FRICTION)
    data = feeder_file(0.2, ellipse=-1.0)
    for sensor, own in ((PAIR[:2], ellipse[1:]), (PAIR[2:], (ellipse[0], *ellipse[2:]))):
        assert run("measure", data, *sensor, *own).exit_code == 0
        result = run("measure", data, *sensor, *own, "--fit", "mu_d")
        assert result.exit_code == 2
        assert "harmonics: one sensor measures one direction alone" in result.stderr


# --- the guide ------------------------------------------------------------------------------------------


def test_the_sensitivities_of_the_guide_are_understood() -> None:
    texts = re.findall(r"`([\w-]*=?[\d.]+\S*V[^\s`]*)`", GUIDE)
    assert len(texts) > 5
    for text in texts:
        assert read_sensitivities([text])
