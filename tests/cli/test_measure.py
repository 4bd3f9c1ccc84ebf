"""``vibro measure`` of a part: its answer, files, JSON, and what can be wrong with data and options."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.commands import NUT, Run, rows_of
from helpers.made_records import EXAMPLES, FREQUENCY, STUDY, STUDY_FILE, Walked, bowl, trough_record
from matplotlib.figure import Figure

from vibro.plots.comparison import comparison_figure

SCENE = EXAMPLES / "safety_nut.toml"
NAMED = ("--time", "Time [s]", "--displacement", "X [mm]", "--velocity", "V [mm/s]")
UNITS = {"displacement": "mm", "velocity": "mm_s", "acceleration": "m_s2", "friction": "N"}


def short_study(folder: Path, changes: Mapping[str, str] | None = None, cycles: int = 4) -> Path:
    """Write the first cycles of the study to a file, some headers changed."""
    header, *rows = STUDY_FILE.read_text(encoding="utf-8").splitlines()
    for old, new in (changes or {}).items():
        header = header.replace(old, new)
    path = folder / "short.csv"
    path.write_text("\n".join([header, *rows[: 40 * cycles + 1]]) + "\n", encoding="utf-8")
    return path


@pytest.fixture
def headings(monkeypatch: pytest.MonkeyPatch) -> list[tuple[str, str]]:
    """Draw an empty picture, and return what stands above and below that which was to be drawn."""
    said: list[tuple[str, str]] = []

    def drawn(*args: Any) -> Figure:
        figure = comparison_figure(*args)
        said.append((str(figure.get_label()), figure.get_suptitle()))
        return Figure()

    monkeypatch.setattr("vibro.plots.comparison.comparison_figure", drawn)
    return said


def test_every_file_is_written(run: Run, headings: list[tuple[str, str]]) -> None:
    result = run(
        "measure", SCENE, STUDY_FILE, "-o", "out/cmp", "-o", "out/cmp.svg", "-o", "out/cmp.html",
        "--mass", "20g",
    )  # fmt: skip
    assert result.exit_code == 0, result.stderr
    written = {path.name for path in Path("out").iterdir()}
    assert written == {"cmp.csv", "cmp-summary.csv", "cmp.png", "cmp.svg", "cmp.html", "cmp.json"}
    assert headings[0][0] == "nut_smoothed_600hz.csv – safety_nut, computed pattern F_"
    content = json.loads(Path("out/cmp.json").read_text(encoding="utf-8"))
    assert set(content["files"]) == written
    assert content["scene"]["amplitude_mm"] == 1
    assert content["columns"]["friction"] == "F [N]"
    assert content["figures"]["stroke_advance"]["computed"] == pytest.approx(1.0842304, rel=1e-7)
    assert content["trough_time_at_zero_s"] == pytest.approx(STUDY["TRIGGER_TIME"], abs=2e-4)

    rows = rows_of(Path("out/cmp.csv").read_text(encoding="utf-8"))
    assert len(rows) == 801
    signals = [f"{name}_{kind}_{unit}" for name, unit in UNITS.items() for kind in ("measured", "computed")]
    assert list(rows[0]) == ["time_s", "trough_time_s", *signals]
    time, trough_time, measured, computed = (
        np.array([float(row[key]) for row in rows])
        for key in ("time_s", "trough_time_s", "friction_measured_N", "friction_computed_N")
    )
    # Where the nut rests, friction is the trough's inertial force alone.
    resting = (trough_time > 0.045) & (trough_time < 0.060)
    np.testing.assert_allclose(measured[resting], computed[resting], atol=6e-3)
    turns = 15.0 * (time + content["trough_time_at_zero_s"] - trough_time)
    np.testing.assert_allclose(turns, np.round(turns), atol=1e-9)
    assert ((trough_time >= 0.0) & (trough_time < 1.0 / 15.0)).all()

    summary = rows_of(Path("out/cmp-summary.csv").read_text(encoding="utf-8"))
    assert [row["quantity"] for row in summary] == list(content["figures"])
    for row in summary:
        figure = content["figures"][row["quantity"]]
        assert row["unit"] == figure["unit"]
        for key in ("measured", "standard_error", "computed"):
            assert (float(row[key]) if row[key] else None) == figure[key]
    assert float(summary[0]["measured"]) == pytest.approx(0.955427, rel=1e-5)
    assert float(summary[0]["difference_percent"]) == pytest.approx(-11.88, abs=0.01)
    page = Path("out/cmp.html").read_text(encoding="utf-8")
    assert "stroke advance" in page
    assert "<svg" in page


def test_the_scene_may_come_from_options_alone(
    run: Run, tmp_path: Path, headings: list[tuple[str, str]]
) -> None:
    result = run("measure", short_study(tmp_path), *NUT, *NAMED, "-o", "out.png")
    assert result.exit_code == 0, result.stderr
    above, below = headings[0]
    assert above == "short.csv, computed pattern F_"
    assert re.sub(r"[${}\\]", "", below).splitlines()[1].startswith("A = 1 mm, f = 15 Hz, alpha = 20°")


def written(folder: Path, header: str, values: np.ndarray[tuple[int], np.dtype[np.float64]]) -> Path:
    """Write a record of four cycles, 40 samples a cycle."""
    path = folder / "made.csv"
    rows = "\n".join(f"{i / 600.0!r},{x!r}" for i, x in enumerate(values.tolist()))
    path.write_text(f"t [s],{header}\n{rows}\n", encoding="utf-8")
    return path


# --- ellipses -------------------------------------------------------------------------------------------

GIVEN = ("along=1", "normal=.5", "phase=-60", "-f", "15")
BODY = ("--displacement", "x [mm]", "--velocity", "v [mm/s]")
TROUGH = ("--trough-along", "along [m/s^2]", "--trough-normal", "normal [m/s^2]")
TRIGGER = 0.0137
FILE = """\
[scene]
along_amplitude_mm = 1.1
normal_amplitude_mm = 0.45
normal_phase_deg = -50
frequency_hz = 15
static_friction = 0.4
kinetic_friction = 0.3
"""


@pytest.fixture
def data(tmp_path: Path) -> Path:
    """A record of a part on a bowl, with two accelerometers on this; and ``bowl.toml``."""
    (tmp_path / "bowl.toml").write_text(FILE, encoding="utf-8")
    lead, walked, random = math.radians(-60.0), Walked(bowl()), np.random.default_rng(3)
    trough = trough_record(
        math.hypot(1e-3, 5e-4), FREQUENCY, math.atan2(0.5, 1.0), ellipse=lead, noise=0.3, trigger=TRIGGER,
        seed=5,
    )  # fmt: skip
    clock = trough.time + TRIGGER
    velocity = 1e3 * walked.velocity(clock) + 0.4 * random.standard_normal(clock.size)
    table = [trough.time, 1e3 * walked.displacement(clock), velocity, *trough.trough.values()]
    header = "t [s],x [mm],v [mm/s],along [m/s^2],normal [m/s^2]"
    np.savetxt(tmp_path / "bowl.csv", np.stack(table, axis=1), "%.7g", ",", header=header, comments="")
    return tmp_path / "bowl.csv"


def test_an_elliptical_scene_is_compared_and_drawn(
    run: Run, data: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    labels: list[str] = []

    def drawn(*args: Any) -> Any:
        figure = comparison_figure(*args)
        labels.extend(axes.get_xlabel() for axes in figure.axes)
        return figure

    monkeypatch.setattr("vibro.plots.comparison.comparison_figure", drawn)
    result = run("measure", data, *GIVEN, "--mu-s", ".4", "--mu-d", ".3", *BODY, "-o", "out")
    assert result.exit_code == 0, result.stderr
    assert "time after the trough's middle, forwards [ms]" in labels
    content = json.loads(Path("out.json").read_text(encoding="utf-8"))
    assert content["scene"]["normal_phase_deg"] == -60
    assert content["pattern"] == "FB_"
    advance = content["figures"]["stroke_advance"]
    assert advance["measured"] == pytest.approx(advance["computed"], rel=1e-4)
    assert abs(content["trough_time_at_zero_s"] - TRIGGER) < 4.0 * content["trough_time_error_s"]


def test_the_measured_ellipse_replaces_that_of_the_scene(run: Run, data: Path) -> None:
    exact = "tilt=0,gain=0,cross=0,delay=0"
    result = run("measure", "bowl.toml", data, *BODY, *TROUGH, "--sensor", exact, "--json")
    assert result.exit_code == 0, result.stderr
    content = json.loads(result.stdout)
    true = {"along_amplitude": 1.0, "normal_amplitude": 0.5, "normal_phase": -60.0, "frequency": 15.0}
    for name, value in true.items():
        (column,) = (key for key in content["trough"] if key.startswith(f"{name}_"))
        found = content["trough"][column]
        assert abs(found["measured"] - value) < 4.0 * found["standard_error"] < 0.05 * abs(value)
        off = abs(content["scene"][column] - found["measured"])
        assert off <= 0.01 * found["standard_error"]
    assert abs(content["trough_time_at_zero_s"] - TRIGGER) < 4.0 * content["trough_time_error_s"]
