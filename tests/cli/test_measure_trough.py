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
from typer.testing import Result

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
        "stroke_mm = 5\ndrive_angle_deg = 3\n",
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


def test_a_column_of_a_part_with_holes_is_left_out(run: Run, parted: Path) -> None:
    header, *rows = parted.read_text(encoding="utf-8").splitlines()
    Path("holes.csv").write_text(
        "\n".join([header, *(row.rpartition(",")[0] + "," for row in rows)]), "utf-8"
    )
    result = run("measure", "holes.csv", *BOTH, "--mu-s", ".4", "--mu-d", ".3", "--json")
    assert "figures" not in told(result)
    assert "displacement: column 'way [mm]' lacks values" in result.stderr
    assert run("measure", "holes.csv", *BOTH, "--displacement", "way").exit_code == 2


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


def test_it_is_computed_on_the_fundamental_where_harmonics_do_not_matter_or_are_not_known(
    run: Run, parted: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    args = ("measure", parted, "--displacement", "way", *BOTH, "--mu-s", ".4", "--mu-d", ".3", "--json")
    for change, said in ((1e-3, False), (float("nan"), True)):
        monkeypatch.setattr("vibro.records.trough.change_by_harmonics", lambda *_, x=change: x)
        result = run(*args)
        assert "along_amplitudes_mm" not in told(result)["scene"]
        assert ("the first is taken alone" in result.stderr) == said


def test_harmonics_of_one_sensor_go_along_the_line_of_the_scene(run: Run, parted: Path) -> None:
    args = ("--displacement", "way", *BOTH[:2], *NOISE_ALONE, "--mu-s", ".4", "--mu-d", ".3", "--json")
    found = told(run("measure", parted, *args, "-a", "25"))["scene"]
    slope = np.tan(np.radians(25.0))
    assert found["normal_amplitudes_mm"][2] == pytest.approx(
        slope * found["along_amplitudes_mm"][2], rel=1e-4
    )
    assert "along_amplitudes_mm" not in told(run("measure", parted, *args, "normal=0.2"))["scene"]


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


def test_a_fit_takes_harmonics_whatever_the_first_scene_makes_of_them(run: Run) -> None:
    """Frictions with which the body would rest make no difference of speed: they are only a start."""
    rests = ("--mu-s", "2", "--mu-d", "1.5")
    for harmonic, order in ((0.05, 3), (0.0, 1)):
        data = feeder_file(harmonic)
        plain = run("measure", data, *rests, *PAIR, "--json")
        fitted = run("measure", data, *rests, *PAIR, "--fit", "mu_d", "--json")
        assert plain.exit_code == fitted.exit_code == 0
        assert "harmonics" not in plain.stderr
        assert ("moves with 3 harmonics: they are part of the fit" in fitted.stderr) == (order == 3)
        assert ("along_amplitude_3_mm" in told(fitted)["trough"]) == (order == 3)


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


# --- records that are not what they seem: a start, a slow logger, few samples, a sweep -------------------


def written(path: Path, rate: float, seconds: float, accelerations: Any, angle_deg: float) -> str:
    """Write a record of accelerations along a line [m/s^2], with noise of 5 mg and gravity."""
    random = np.random.default_rng(1)
    time = np.arange(int(seconds * rate)) / rate
    along, normal = (np.cos(np.radians(angle_deg)), np.sin(np.radians(angle_deg)))
    own = accelerations(time)
    columns = (time, along * own, normal * own + 9.81)
    noise = [0.0 * time, *(0.05 * random.standard_normal((2, time.size)))]
    table = np.stack(columns, axis=1) + np.stack(noise, axis=1)
    np.savetxt(path, table, "%.6f", ",", header="Time (s),ax (m/s^2),az (m/s^2)", comments="")
    return str(path)


def refusal(result: Result) -> str:
    assert result.exit_code == 2
    return str(result.stderr)


SEEMING = ("--trough-along", "ax", "--trough-normal", "az")


def test_of_a_start_the_steady_part_is_measured(run: Run, tmp_path: Path) -> None:
    """The amplitude grows to 1 mm by 1 - exp(-2 t); parts hop on it."""
    size = 1e-3 * (2.0 * np.pi * 25.0) ** 2
    record = written(
        tmp_path / "start.csv",
        500.0,
        4.0,
        lambda t: -size * (1.0 - np.exp(-2.0 * t)) * np.sin(50.0 * np.pi * t),
        25.0,
    )
    result = run("measure", record, *SEEMING, "--mu-s", "0.5", "--mu-d", "0.4", "--json")
    assert "warning: the amplitude rises from 0.1" in result.stderr
    assert "the steady part from 2." in result.stderr
    trough = json.loads(result.stdout)["trough"]
    assert trough["amplitude_mm"]["measured"] == pytest.approx(1.0, abs=0.005)
    chosen = run("measure", record, *SEEMING, "--from", "3", "--to", "3.9", "--json")
    assert json.loads(chosen.stdout)["rows"] == 451
    assert "steady" not in chosen.stderr
    for wrong, text in (("5", "0 rows lie from 5 to 3.998 s"), ("x", "'x'")):
        assert text in refusal(run("measure", record, *SEEMING, "--from", wrong))


def test_a_feeder_above_half_the_sampling_rate(run: Run, tmp_path: Path) -> None:
    """0.02 mm at 100 Hz, which a telephone of 101 samples a second shows at 1.14 Hz."""
    size = 2e-5 * (200.0 * np.pi) ** 2
    record = written(
        tmp_path / "phone.csv", 101.14, 10.0, lambda t: -size * np.sin(200.0 * np.pi * t + 0.7), 20.0
    )
    drive = ("-f", "100", "-a", "20", "-A", "0.02", "--mu-s", "0.5", "--mu-d", "0.4")
    scene = tmp_path / "feeder.toml"
    scene.write_text(
        "[scene]\namplitude_mm = 0.02\nfrequency_hz = 100\ndrive_angle_deg = 20\n"
        "static_friction = 0.5\nkinetic_friction = 0.4\n"
    )
    result = run("measure", str(scene), record, *SEEMING, "--json")
    found = json.loads(result.stdout)
    assert found["trough"]["amplitude_mm"]["measured"] == pytest.approx(0.02, rel=0.01)
    speed = float(json.loads(run("solve", *drive, "--json").stdout)["mean_velocity_mm_s"])
    assert found["speed"]["mean_velocity_mm_s"] == pytest.approx(speed, rel=0.01)
    assert "(aliasing)" in result.stderr
    refused = refusal(run("measure", record, *SEEMING))
    assert "drives of 100 Hz (0.02 mm), 102.3 Hz (0.019 mm)" in refused
    assert "of 0.14 m at 1.14 Hz is not credible" in refused


def test_four_samples_a_cycle_and_a_sweep(run: Run, tmp_path: Path) -> None:
    size = 5e-5 * (200.0 * np.pi) ** 2
    few = written(tmp_path / "few.csv", 411.57, 4.0, lambda t: -size * np.sin(200.0 * np.pi * t + 0.7), 20.0)
    result = run("measure", few, *SEEMING, "--json")
    assert json.loads(result.stdout)["trough"]["amplitude_mm"]["measured"] == pytest.approx(0.05, rel=0.01)
    assert "4.12 samples a cycle show the first harmonic alone" in result.stderr
    sweep = written(
        tmp_path / "sweep.csv",
        500.0,
        4.0,
        lambda t: -25.0 * np.sin(2.0 * np.pi * (24.0 * t + 0.25 * t**2)),
        25.0,
    )
    for options in ((), ("-f", "25")):
        text = refusal(run("measure", sweep, *SEEMING, *options))
        assert "the frequency changes, from 24 to 26 Hz" in text
