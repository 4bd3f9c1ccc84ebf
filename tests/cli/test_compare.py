"""``vibro compare``: its report, files, JSON, and everything that can be wrong with data and options."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from helpers.cases import each
from helpers.commands import NUT, Run, rows_of
from helpers.made_records import EXAMPLES, STUDY, STUDY_FILE, Walked, nut
from matplotlib.figure import Figure

SCENE = EXAMPLES / "safety_nut.toml"
NAMED = ("--time", "Time [s]", "--displacement", "X [mm]", "--velocity", "V [mm/s]")


def short_study(folder: Path, changes: Mapping[str, str] | None = None, cycles: int = 4) -> Path:
    """Write the first cycles of the study to a file, some headers changed."""
    header, *rows = STUDY_FILE.read_text(encoding="utf-8").splitlines()
    for old, new in (changes or {}).items():
        header = header.replace(old, new)
    path = folder / "short.csv"
    path.write_text("\n".join([header, *rows[: 40 * cycles + 1]]) + "\n", encoding="utf-8")
    return path


@pytest.fixture
def empty_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    """Draw nothing into the picture, which takes most of a run's time."""
    monkeypatch.setattr("vibro.plots.comparison.comparison_figure", lambda *_: Figure())


def test_an_exact_record_gives_narrow_intervals(run: Run, tmp_path: Path) -> None:
    clock = np.arange(161) / 600.0
    path = tmp_path / "exact.csv"
    rows = zip(clock.tolist(), (1e3 * Walked(nut()).velocity(clock + 0.0137)).tolist(), strict=True)
    path.write_text(
        "t [s],v [mm/s]\n" + "\n".join(f"{t!r},{v:.4f}" for t, v in rows) + "\n", encoding="utf-8"
    )
    fit = json.loads(run("compare", SCENE, path, "--fit", "mu_s,mu_d", "--json").stdout)["fit"]
    for parameter, true in zip(fit.values(), (0.74, 0.57), strict=True):
        pieces = parameter["intervals"]
        assert [parameter["low"], parameter["high"]] == [pieces[0][0], pieces[-1][1]]
        assert all(low < high for low, high in pieces)
        assert parameter["low"] < parameter["estimate"] < parameter["high"] < parameter["low"] + 1e-3
        assert parameter["low"] <= true <= parameter["high"]


def test_what_cannot_be_identified_is_said(run: Run, tmp_path: Path) -> None:
    path = short_study(tmp_path)
    result = run("compare", SCENE, path, "-A", "0.3", "--fit", "mu_s", "--mu-d", "0.72", "--json")
    assert result.exit_code == 0, result.stderr
    fit = json.loads(result.stdout)["fit"]
    assert fit["static_friction"]["low"] is None
    assert fit["static_friction"]["intervals"] == []


@pytest.mark.usefixtures("empty_picture")
def test_every_file_is_written(run: Run) -> None:
    result = run("compare", SCENE, STUDY_FILE, "-o", "out/cmp", "-o", "out/cmp.svg", "--mass", "20g")
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


@pytest.mark.usefixtures("empty_picture")
def test_headers_that_a_spreadsheet_would_run_are_quoted(run: Run, tmp_path: Path) -> None:
    """A header is text from somewhere else, also the first one of the cell that echoes it."""
    for sign in "=+-@":
        path = short_study(tmp_path, {"Time": f"{sign}cmd|calc!A0"})
        result = run("compare", SCENE, path, "--velocity", "V [mm/s]", "-o", "out", "--force", "-q")
        assert result.exit_code == 0, result.stderr
        rows = rows_of(Path("out-summary.csv").read_text(encoding="utf-8"))
        assert {row["data_columns"][:2] for row in rows} == {f"'{sign}"}


@pytest.mark.usefixtures("empty_picture")
def test_force_replaces_and_names_no_column(run: Run, tmp_path: Path) -> None:
    path = short_study(tmp_path)
    friction = ("--friction", "F [N]", "--mass", "0.02kg")
    assert run("compare", SCENE, path, *friction, "-o", "out").exit_code == 0
    again = run("compare", SCENE, path, *friction, "-o", "out")
    assert again.exit_code == 1
    assert "--force" in again.stderr
    for replacing in (
        ("compare", SCENE, path, "--force", *friction, "-o", "out"),
        ("compare", "--force", SCENE, path, *friction, "-o", "out"),
    ):
        result = run(*replacing)
        assert result.exit_code == 0, result.stderr
        assert json.loads(Path("out.json").read_text(encoding="utf-8"))["columns"]["friction"] == "F [N]"


def test_the_scene_may_come_from_options_alone(run: Run, tmp_path: Path) -> None:
    result = run("compare", short_study(tmp_path), *NUT, *NAMED)
    assert result.exit_code == 0, result.stderr


def test_the_signals_go_to_stdout(run: Run, tmp_path: Path) -> None:
    path = short_study(tmp_path)
    result = run("compare", SCENE, path, "-o", "-", "-q", "--decimal-comma")
    assert result.exit_code == 0
    assert result.stdout.startswith("time_s;trough_time_s;displacement_measured_mm;")
    assert len(result.stdout.splitlines()) == 162


def test_the_data_are_never_replaced(run: Run, tmp_path: Path) -> None:
    data = short_study(tmp_path)
    before = data.read_bytes()
    result = run("compare", SCENE, data, "-o", "short", "--force")
    assert result.exit_code == 1
    assert data.read_bytes() == before


def test_data_by_any_name_may_follow_the_flag(run: Run, tmp_path: Path) -> None:
    data = short_study(tmp_path).rename(tmp_path / "short.dat")
    assert run("compare", SCENE, "--force", data).exit_code == 0


def written(folder: Path, header: str, values: np.ndarray[tuple[int], np.dtype[np.float64]]) -> Path:
    """Write a record of four cycles, 40 samples a cycle."""
    path = folder / "made.csv"
    rows = "\n".join(f"{i / 600.0!r},{x!r}" for i, x in enumerate(values.tolist()))
    path.write_text(f"t [s],{header}\n{rows}\n", encoding="utf-8")
    return path


TURNS = np.arange(161) / 40.0
SHAPES = {
    "zeros": np.zeros(161),
    "ramp": TURNS,
    "sine": np.sin(2.0 * np.pi * TURNS),
    "alternating": (-1.0) ** np.arange(161),
}


@pytest.mark.parametrize(
    ("header", "shape"),
    [
        ("x [mm]", "zeros"),
        ("v [mm/s]", "ramp"),
        ("a [m/s^2]", "alternating"),
        *((header, "sine") for header in ("x [mm]", "F [N]")),
    ],
)
def test_records_of_any_size_are_compared(run: Run, tmp_path: Path, shape: str, header: str) -> None:
    for size in (1e-320, 2e19):
        path = written(tmp_path, header, SHAPES[shape] * size)
        result = run("compare", SCENE, path, "--mass", "1kg")
        assert (result.exit_code, "Warning" in result.stderr) == (0, False), result.stderr


@pytest.mark.parametrize(("header", "size"), [("v [mm/s]", 9e19), ("F [N]", 1e-320)])
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


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (("--mass", "9" * 5000), "mass = '99999"),
        (("--fit", "9" * 5000), "--fit 99999"),
    ],
)
def test_values_of_thousands_of_digits_are_cut(run: Run, args: tuple[str, ...], said: str) -> None:
    result = run("compare", SCENE, STUDY_FILE, *args, "-q")
    assert result.exit_code == 2, result.stderr
    assert said in result.stderr
    assert len(result.stderr) < 600


def test_a_track_of_a_camera_on_a_tripod(run: Run, tmp_path: Path) -> None:
    """With --absolute it gives the figures of a relative one."""
    walked = Walked(nut())
    seen, relative = (walked.observe("displacement", cycles=8, over_ground=on) for on in (True, False))
    table = np.stack([seen.time, *(1e3 * x.signals["displacement"] for x in (seen, relative))], axis=1)
    np.savetxt("track.csv", table, "%.8g", ",", header="t [s],camera [mm],sensor [mm]", comments="")
    given = ("compare", SCENE, "track.csv", "--displacement")
    right, plain = (run(*given, *one, "--json") for one in (("camera", "--absolute"), ("sensor",)))
    assert "warning" not in right.stderr + plain.stderr
    content, other = json.loads(right.stdout), json.loads(plain.stdout)
    assert (content["absolute"], other["absolute"]) == (True, False)
    for key in ("mean_speed", "peak_speed"):
        figure = content["figures"][key]
        assert figure["measured"] == pytest.approx(other["figures"][key]["measured"], rel=0.02)
