"""``vibro compare``: its report, files, JSON, and everything that can be wrong with data and options."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from helpers.cases import each
from helpers.commands import NUT, Run, rows_of
from helpers.made_records import EXAMPLES, STUDY, STUDY_FILE, Walked, nut

SCENE = EXAMPLES / "safety_nut.toml"
EXACT_ANGLE = "the drive angle of {} deg is taken as exact: no interval covers its error"
NAMED = ("--time", "Time [s]", "--displacement", "X [mm]", "--velocity", "V [mm/s]")


def lines_of(text: str) -> dict[str, str]:
    """First words of each line of a report, and the line with its blanks folded."""
    return {line.split("  ")[0]: " ".join(line.split()) for line in text.splitlines() if line.strip()}


def short_study(folder: Path, changes: Mapping[str, str] | None = None, cycles: int = 4) -> Path:
    """Write the first cycles of the study to a file, some headers changed."""
    header, *rows = STUDY_FILE.read_text(encoding="utf-8").splitlines()
    for old, new in (changes or {}).items():
        header = header.replace(old, new)
    path = folder / "short.csv"
    path.write_text("\n".join([header, *rows[: 40 * cycles + 1]]) + "\n", encoding="utf-8")
    return path


@pytest.mark.usefixtures("both_frames")
def test_the_report(run: Run) -> None:
    result = run("compare", SCENE, STUDY_FILE)
    assert result.exit_code == 0, result.stderr
    lines = lines_of(result.stdout)
    assert lines["data"].endswith("801 rows, 20 cycles, 40 samples a cycle")
    assert lines["computed"] == "computed pattern F_"
    assert "the data begin 13.7" in lines["alignment"]
    assert lines["stroke advance [mm]"] == "stroke advance [mm] 0.955427 ± 0.000012 1.08423 -11.9 %"
    assert lines["mean speed [mm/s]"].endswith("16.2635 -11.9 %")
    assert lines["peak speed [mm/s]"].endswith("60.1496 -7.3 %")
    assert "forward slip starts (6.01 mm/s) [ms]" in lines
    assert "RMS difference of velocity [mm/s]" in lines
    assert "displacement: column 'X [mm]'" in result.stderr
    assert "warning: column 'F [N]' is left out: a force needs --mass" in result.stderr
    assert list(Path.cwd().iterdir()) == []


def test_the_fit_is_reported_with_its_statement(run: Run, tmp_path: Path) -> None:
    result = run("compare", SCENE, short_study(tmp_path), "--fit", "mu_s,mu_d", "-q")
    assert result.exit_code == 0
    assert result.stderr == ""
    lines = lines_of(result.stdout)
    assert lines["mu_s"].endswith("0.74")
    assert lines["mu_d"].endswith("0.57")
    assert "..." in lines["mu_d"]
    assert "pattern F_: mu_s sets the start of a slide and mu_d its end" in result.stdout
    assert EXACT_ANGLE.format(20) in result.stdout


def test_a_drive_angle_is_exact_unless_it_is_fitted_or_measured(run: Run, tmp_path: Path) -> None:
    path = short_study(tmp_path)
    assert EXACT_ANGLE.format(18) in run("compare", SCENE, path, "-a", "18", "--fit", "mu_d").stdout
    both = ("--trough-along", "Trog längs", "--trough-normal", "Trog normal", "--sensitivity", "100mV/g")
    measured = EXAMPLES / "data" / "nut_trough_mv.csv"
    for given in ((path, "--fit", "mu_d,alpha"), (measured, *both, "--fit", "mu_d"), (path,)):
        result = run("compare", SCENE, *given)
        assert result.exit_code == 0, result.stderr
        assert "taken as exact" not in result.stdout


def test_intervals_have_the_digits_that_their_width_needs(run: Run, tmp_path: Path) -> None:
    """An exact record gives narrow intervals, which four digits would not tell from their estimate."""
    clock = np.arange(161) / 600.0
    path = tmp_path / "exact.csv"
    rows = zip(clock.tolist(), (1e3 * Walked(nut()).velocity(clock + 0.0137)).tolist(), strict=True)
    path.write_text(
        "t [s],v [mm/s]\n" + "\n".join(f"{t!r},{v:.4f}" for t, v in rows) + "\n", encoding="utf-8"
    )
    lines = lines_of(run("compare", SCENE, path, "--fit", "mu_s,mu_d", "-q").stdout)
    for name, true in (("mu_s", 0.74), ("mu_d", 0.57)):
        _, estimate, low, dots, high, scene = lines[name].split()
        assert dots == "..."
        assert float(low) < float(estimate) < float(high)
        assert float(low) <= true <= float(high)
        assert float(high) - float(low) < 1e-3
        assert scene == f"{true}"
    fit = json.loads(run("compare", SCENE, path, "--fit", "mu_s,mu_d", "--json").stdout)["fit"]
    for parameter in fit.values():
        pieces = parameter["intervals"]
        assert [parameter["low"], parameter["high"]] == [pieces[0][0], pieces[-1][1]]
        assert all(low < high for low, high in pieces)


def test_what_cannot_be_identified_is_said(run: Run, tmp_path: Path) -> None:
    path = short_study(tmp_path)
    result = run("compare", SCENE, path, "-A", "0.3", "--fit", "mu_s", "--mu-d", "0.72", "--json")
    assert result.exit_code == 0, result.stderr
    fit = json.loads(result.stdout)["fit"]
    assert fit["static_friction"]["low"] is None
    assert fit["static_friction"]["intervals"] == []
    resting = run("compare", SCENE, path, "-A", "0.3", "--fit", "mu_s", "--mu-d", "0.72")
    assert "not identified" in resting.stdout


def test_every_file_is_written(run: Run) -> None:
    result = run("compare", SCENE, STUDY_FILE, "-o", "out/cmp", "--format", "png,svg", "--mass", "20g")
    assert result.exit_code == 0, result.stderr
    written = {path.name for path in Path("out").iterdir()}
    assert written == {"cmp.csv", "cmp-summary.csv", "cmp.png", "cmp.svg", "cmp.json"}
    content = json.loads(Path("out/cmp.json").read_text(encoding="utf-8"))
    assert set(content["files"]) == written
    assert content["argv"][:2] == ["vibro", "compare"]
    assert content["scene"]["amplitude_mm"] == 1
    assert content["columns"]["friction"] == "F [N]"
    assert content["figures"]["stroke_advance"]["computed"] == pytest.approx(1.0842304, rel=1e-7)
    assert content["trough_time_at_zero_s"] == pytest.approx(STUDY["TRIGGER_TIME"], abs=2e-4)

    rows = rows_of(Path("out/cmp.csv").read_text(encoding="utf-8"))
    assert len(rows) == 801
    assert list(rows[0]) == [
        "time_s",
        "trough_time_s",
        *(
            f"{name}_{kind}_{unit}"
            for name, unit in (
                ("displacement", "mm"),
                ("velocity", "mm_s"),
                ("acceleration", "m_s2"),
                ("friction", "N"),
            )
            for kind in ("measured", "computed")
        ),
    ]
    measured = np.array([float(row["friction_measured_N"]) for row in rows])
    computed = np.array([float(row["friction_computed_N"]) for row in rows])
    # Where the nut rests, friction is the trough's inertial force alone.
    resting = np.array([0.045 < float(row["trough_time_s"]) < 0.060 for row in rows])
    np.testing.assert_allclose(measured[resting], computed[resting], atol=6e-3)

    summary = {
        row["quantity"]: row for row in rows_of(Path("out/cmp-summary.csv").read_text(encoding="utf-8"))
    }
    assert float(summary["stroke_advance"]["measured"]) == pytest.approx(0.955427, rel=1e-5)
    assert summary["rms_friction"]["unit"] == "N"
    assert summary["rms_friction"]["computed"] == ""
    assert summary["rms_friction"]["data_columns"].startswith("Time [s]; X [mm]")


def test_headers_that_a_spreadsheet_would_run_are_quoted(run: Run, tmp_path: Path) -> None:
    """A header is text from somewhere else, also the first one of the cell that echoes it."""
    for sign in "=+-@":
        path = short_study(tmp_path, {"Time": f"{sign}cmd|calc!A0"})
        result = run("compare", SCENE, path, "--velocity", "V [mm/s]", "-o", "out", "--force", "-q")
        assert result.exit_code == 0, result.stderr
        rows = rows_of(Path("out-summary.csv").read_text(encoding="utf-8"))
        assert {row["data_columns"][:2] for row in rows} == {f"'{sign}"}


def test_force_replaces_and_names_no_column(run: Run, tmp_path: Path) -> None:
    path = short_study(tmp_path)
    friction = ("--friction", "F [N]", "--mass", "0.02kg")
    assert run("compare", SCENE, path, *friction, "-o", "out").exit_code == 0
    again = run("compare", SCENE, path, *friction, "-o", "out")
    assert again.exit_code == 1
    assert "--force" in again.stderr
    for replacing in (
        ("compare", SCENE, path, *friction, "-o", "out", "--force"),
        ("compare", SCENE, path, "--force", *friction, "-o", "out"),
        ("compare", "--force", SCENE, path, *friction, "-o", "out"),
    ):
        result = run(*replacing)
        assert result.exit_code == 0, result.stderr
        assert json.loads(Path("out.json").read_text(encoding="utf-8"))["columns"]["friction"] == "F [N]"


def test_the_scene_may_come_from_options_alone(run: Run, tmp_path: Path) -> None:
    result = run("compare", short_study(tmp_path), *NUT, *NAMED)
    assert result.exit_code == 0, result.stderr
    assert "stroke advance" in result.stdout
    assert "RMS difference of acceleration" not in result.stdout


def test_the_signals_go_to_stdout(run: Run, tmp_path: Path) -> None:
    path = short_study(tmp_path)
    result = run("compare", SCENE, path, "-o", "-", "-q", "--decimal-comma")
    assert result.exit_code == 0
    assert result.stdout.startswith("time_s;trough_time_s;displacement_measured_mm;")
    assert len(result.stdout.splitlines()) == 162
    both = run("compare", SCENE, path, "-o", "-", "--json")
    assert both.exit_code == 2


def test_semicolons_and_decimal_commas_are_echoed(run: Run, tmp_path: Path) -> None:
    path = short_study(tmp_path)
    text = path.read_text(encoding="utf-8").replace(",", ";").replace(".", ",")
    path.write_text(text, encoding="utf-8")
    result = run("compare", SCENE, path)
    assert result.exit_code == 0
    assert "short.csv: separated by semicolons, decimal commas" in result.stderr


def test_data_that_run_the_other_way(run: Run, tmp_path: Path) -> None:
    path = short_study(tmp_path)
    header, *rows = path.read_text(encoding="utf-8").splitlines()
    turned = []
    for row in rows:
        time, *values = row.split(",")
        turned.append(",".join([time, *(str(-float(value)) for value in values)]))
    path.write_text("\n".join([header, *turned]) + "\n", encoding="utf-8")
    result = run("compare", SCENE, path)
    assert "warning: the data run against the computed direction: --reverse" in result.stderr
    assert "-11.9 %" in run("compare", SCENE, path, "--reverse").stdout


@each(
    ("args", "said"),
    [
        (("--fit", "mu_k"), "--fit mu_k: 'mu_k' cannot be estimated"),
        (("--fit", "A,A"), "--fit A,A: 'A' is given twice"),
        (("--friction", "F [N]"), "a force needs the mass of the body"),
        (("--force", "F [N]", "--mass", "20g"), "Got unexpected extra argument"),
        (("--mass", "0"), "mass = 0: must be finite and > 0 kg"),
        (("--mass", "20mm"), "'mm' is no unit of mass"),
        (("--displacement", "Y [mm]"), "no column 'Y [mm]' for --displacement"),
        (("--format", "bmp"), "--format bmp"),
        (("-f", "0.5"), "drive cycles of 2000 ms: at least 2 are needed"),
        (("-f", "400"), "samples a drive cycle of 2.5 ms: at least 8 are needed"),
        (("--mu-s", "0", "--mu-d", "0"), "no steady motion to compare with"),
        (("-A", "0.5,1"), "takes one value"),
    ],
)
def test_wrong_input_ends_with_code_2(run: Run, args: tuple[str, ...], said: str) -> None:
    result = run("compare", SCENE, STUDY_FILE, *args)
    assert result.exit_code == 2
    errors = [line for line in result.stderr.splitlines() if line.startswith("error: ")]
    assert len(errors) == 1
    assert said in errors[0]
    assert result.stdout == ""
    assert "Traceback" not in result.stderr


def test_a_single_row_is_too_short(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "one.csv"
    path.write_text("t [s],x [mm]\n0,1\n", encoding="utf-8")
    result = run("compare", SCENE, path)
    assert result.exit_code == 2
    assert "the data cover 0 drive cycles" in result.stderr


def test_the_data_are_never_replaced(run: Run, tmp_path: Path) -> None:
    data = short_study(tmp_path)
    before = data.read_bytes()
    result = run("compare", SCENE, data, "-o", "short", "--force")
    assert result.exit_code == 1
    assert result.stderr.splitlines()[-2:] == [
        "error: cannot write short.csv: this run reads it", "hint: choose another name",
    ]  # fmt: skip
    assert data.read_bytes() == before


def test_the_scene_is_never_replaced(run: Run) -> None:
    scene = Path("scene.json")
    scene.write_bytes(SCENE.read_bytes())
    for args in (("solve",), ("simulate",), ("map", "-A", "1,2", "-f", "15")):
        result = run(args[0], scene, *args[1:], "-o", "scene", "--force")
        assert result.exit_code == 1
        assert "error: cannot write scene.json: this run reads it\n" in result.stderr
        assert scene.read_bytes() == SCENE.read_bytes()


def test_without_arguments_the_data_are_missing(run: Run) -> None:
    result = run("compare")
    assert result.exit_code == 2
    assert result.stderr.startswith("error: missing: DATA.csv\n")


@pytest.mark.parametrize(
    ("new", "signal", "times"),
    [("X [m]", "displacement", 1000), ("X [um]", "displacement", 0.001), ("V [m/s]", "velocity", 1000)],
)
def test_a_wrong_unit_is_doubted(run: Run, tmp_path: Path, new: str, signal: str, times: float) -> None:
    old = {"X": "X [mm]", "V": "V [mm/s]"}[new[0]]
    named = ("--time", "Time [s]", f"--{signal}")
    right = run("compare", SCENE, short_study(tmp_path), *named, old)
    assert "is its unit right?" not in right.stderr
    result = run("compare", SCENE, short_study(tmp_path, {old: new}), *named, new)
    (said,) = re.findall(
        rf"warning: the {signal} is about (\S+) times the computed one: is its unit right\?", result.stderr
    )
    assert float(said) == pytest.approx(times, rel=0.25)


def test_a_wrong_sensitivity_or_mass_is_doubted(run: Run, tmp_path: Path) -> None:
    volts = short_study(tmp_path, {"V [mm/s]": "V [mV]"})
    named = ("--velocity", "V [mV]", "--sensitivity")
    assert "warning" not in run("compare", SCENE, volts, *named, "1mV/mm/s").stderr
    result = run("compare", SCENE, volts, *named, "0.1mV/mm/s")
    assert "times the computed one: is its sensitivity 0.1mV/mm/s right?" in result.stderr
    result = run("compare", SCENE, short_study(tmp_path), "--mass", "20kg")
    assert "about 0.001 times the computed one: is its unit right? Is the mass?" in result.stderr


def test_scene_and_data_in_the_wrong_order_are_told(run: Run) -> None:
    result = run("compare", STUDY_FILE, SCENE)
    assert result.exit_code == 2
    error, hint = result.stderr.splitlines()
    assert error == f"error: {SCENE} is a scene file: the scene comes before the data"
    assert hint == f"hint: vibro compare {SCENE} {STUDY_FILE}"
    assert run(*hint.split()[2:]).exit_code == 0


def test_data_by_any_name_may_follow_the_flag(run: Run, tmp_path: Path) -> None:
    data = short_study(tmp_path).rename(tmp_path / "short.dat")
    assert run("compare", SCENE, "--force", data).exit_code == 0


def test_missing_files(run: Run, tmp_path: Path) -> None:
    assert run("compare", SCENE).exit_code == 2
    result = run("compare", SCENE, tmp_path / "none.csv")
    assert result.exit_code == 1
    assert "cannot read" in result.stderr


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        ((3, 3), "row 5, column 'Time [s]': time repeats"),
        ((5, 3), "time goes back"),
        ((5, 20), "time jumps to"),
    ],
)
def test_bad_rows_are_named(run: Run, tmp_path: Path, rows: tuple[int, int], said: str) -> None:
    path = short_study(tmp_path)
    header, *lines = path.read_text(encoding="utf-8").splitlines()
    first, then = rows
    path.write_text("\n".join([header, *lines[:first], *lines[then - 1 :]]) + "\n", encoding="utf-8")
    result = run("compare", SCENE, path)
    assert result.exit_code == 2
    assert said in result.stderr
    assert "hint:" in result.stderr


def written(folder: Path, header: str, values: np.ndarray[tuple[int], np.dtype[np.float64]]) -> Path:
    """Write a record of four cycles, 40 samples a cycle."""
    path = folder / "made.csv"
    rows = "\n".join(f"{i / 600.0!r},{x!r}" for i, x in enumerate(values.tolist()))
    path.write_text(f"t [s],{header}\n{rows}\n", encoding="utf-8")
    return path


TURNS = np.arange(161) / 40.0
SHAPES = {
    "zeros": np.zeros(161),
    "ones": np.ones(161),
    "ramp": TURNS,
    "sine": np.sin(2.0 * np.pi * TURNS),
    "alternating": (-1.0) ** np.arange(161),
}


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("header", ["x [mm]", "v [mm/s]", "a [m/s^2]", "F [N]"])
@pytest.mark.usefixtures("both_frames")
def test_records_of_any_size_are_compared(run: Run, tmp_path: Path, shape: str, header: str) -> None:
    for size in (1e-320, 1e-200, 1.0, 2e19) if shape == "sine" else (1e-320, 2e19):
        path = written(tmp_path, header, SHAPES[shape] * size)
        result = run("compare", SCENE, path, "--mass", "1kg")
        assert (result.exit_code, "Warning" in result.stderr) == (0, False), result.stderr


@pytest.mark.parametrize(
    ("header", "size"), [("x [mm]", 0.0), ("x [mm]", 1e-320), ("v [mm/s]", 9e19), ("F [N]", 0.0)]
)
def test_records_of_any_size_are_fitted(run: Run, tmp_path: Path, header: str, size: float) -> None:
    path = written(tmp_path, header, SHAPES["sine"] * size)
    result = run("compare", SCENE, path, "--fit", "mu_d", "--mass", "20g", "-q")
    assert (result.exit_code, result.stderr) == (0, "")


@each("cell", ["1e308", "-1e200", "1e24", "9" * 400])
def test_values_whose_squares_overflow_are_refused(run: Run, tmp_path: Path, cell: str) -> None:
    path = written(tmp_path, "x [mm]", SHAPES["sine"])
    lines = path.read_text(encoding="utf-8").splitlines()
    lines[7] = f"0.01,{cell}"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    result = run("compare", SCENE, path, "--fit", "mu_s")
    assert result.exit_code == 2
    assert f"row 8, column 'x [mm]': {cell[:20]}" in result.stderr
    assert "is too large to compute with, at most 1e+23 is allowed" in result.stderr


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (("--mass", "1e-300"), "mass = 1e-300 kg: must be in [1e-20, 1e+20] kg beside a record"),
        (("--mass", "1e300"), "mass = 1e+300 kg: must be in [1e-20, 1e+20] kg beside a record"),
        (("-A", "1e-300"), "amplitude = 1e-303 m: must be in [1e-20, 1e+20] m beside a record"),
        (("-f", "1e300"), "frequency = 1e+300 Hz: must be in [1e-20, 1e+20] Hz beside a record"),
        (("--gravity", "1e200"), "gravity = 1e+200 m/s^2: must be in [1e-20, 1e+20] m/s^2 beside a record"),
        (("--mass", "9" * 5000), "mass = '99999"),
        (("--fit", "9" * 5000), "--fit 99999"),
    ],
)
def test_scenes_and_masses_at_the_ends_of_the_doubles(run: Run, args: tuple[str, ...], said: str) -> None:
    result = run("compare", SCENE, STUDY_FILE, *args, "-q")
    assert result.exit_code == 2, result.stderr
    assert said in result.stderr
    assert len(result.stderr) < 600


@pytest.mark.usefixtures("both_frames")
def test_a_track_of_a_camera_on_a_tripod(run: Run, tmp_path: Path) -> None:
    """It holds the trough's motion, which is said; with --absolute it gives the figures of a relative one."""
    walked = Walked(nut())
    seen, relative = (walked.observe("displacement", over_ground=on) for on in (True, False))
    table = np.stack([seen.time, *(1e3 * x.signals["displacement"] for x in (seen, relative))], axis=1)
    np.savetxt("track.csv", table, "%.8g", ",", header="t [s],camera [mm],sensor [mm]", comments="")
    given = ("compare", SCENE, "track.csv", "--displacement")
    lacking = run(*given, "camera")
    assert lacking.exit_code == 0
    assert re.search(
        r"warning: the displacement fits \d+ times better over the ground: --absolute if", lacking.stderr
    )
    wrong = run(*given, "sensor", "--absolute")
    assert re.search(r"warning: .* better relative to the trough: leave out --absolute if", wrong.stderr)
    right, plain = (run(*given, *one, "--json") for one in (("camera", "--absolute"), ("sensor",)))
    assert "warning" not in right.stderr + plain.stderr
    content, other = json.loads(right.stdout), json.loads(plain.stdout)
    assert (content["absolute"], other["absolute"]) == (True, False)
    for key in ("mean_speed", "peak_speed"):
        figure = content["figures"][key]
        assert figure["measured"] == pytest.approx(other["figures"][key]["measured"], rel=0.02)
    said = "the data are over the ground: the trough's computed motion is taken off them"
    assert said in run(*given, "camera", "--absolute").stdout
    assert said not in lacking.stdout
