"""``vibro compare`` with elliptical drives: given, measured by accelerometers on the trough, and fitted."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.commands import Run
from helpers.made_records import FREQUENCY, Walked, bowl, trough_record

from vibro.plots.comparison import comparison_figure

GIVEN = ("along=1", "normal=.5", "phase=-60", "-f", "15")
FRICTION = ("--mu-s", ".4", "--mu-d", ".3")
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
    """A record of a part on a bowl, with two accelerometers on this."""
    scene = bowl()
    x, y, lead = 1e-3, 5e-4, math.radians(-60.0)
    trough = trough_record(
        math.hypot(x, y), FREQUENCY, math.atan2(y, x), ellipse=lead, noise=0.3, trigger=TRIGGER, seed=5
    )
    walked, random = Walked(scene), np.random.default_rng(3)
    columns = {
        "t [s]": trough.time,
        "x [mm]": 1e3 * walked.displacement(trough.time + TRIGGER),
        "v [mm/s]": 1e3 * walked.velocity(trough.time + TRIGGER)
        + 0.4 * random.standard_normal(trough.time.size),
        "along [m/s^2]": trough.trough["trough_along"],
        "normal [m/s^2]": trough.trough["trough_normal"],
    }
    path = tmp_path / "bowl.csv"
    table = np.stack(list(columns.values()), axis=1)
    np.savetxt(path, table, "%.7g", ",", header=",".join(columns), comments="")
    return path


@pytest.fixture
def ellipse(tmp_path: Path) -> Path:
    path = tmp_path / "bowl.toml"
    path.write_text(FILE, encoding="utf-8")
    return path


def test_an_elliptical_scene_is_compared_and_drawn(
    run: Run, data: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    labels: list[str] = []

    def drawn(*args: Any) -> Any:
        figure = comparison_figure(*args)
        labels.extend(axes.get_xlabel() for axes in figure.axes)
        return figure

    monkeypatch.setattr("vibro.plots.comparison.comparison_figure", drawn)
    result = run("compare", data, *GIVEN, *FRICTION, *BODY, "-o", "out")
    assert result.exit_code == 0, result.stderr
    assert "time after the trough's middle, forwards [ms]" in labels
    content = json.loads(Path("out.json").read_text(encoding="utf-8"))
    assert content["scene"]["normal_phase_deg"] == -60
    assert content["pattern"] == "FB_"
    assert content["figures"]["stroke_advance"]["measured"] == pytest.approx(
        content["figures"]["stroke_advance"]["computed"], rel=1e-4
    )
    assert abs(content["trough_time_at_zero_s"] - TRIGGER) < 4.0 * content["trough_time_error_s"]


def test_the_measured_ellipse_replaces_that_of_the_scene(run: Run, data: Path, ellipse: Path) -> None:
    result = run("compare", ellipse, data, *BODY, *TROUGH, "--json")
    assert result.exit_code == 0, result.stderr
    content = json.loads(result.stdout)
    true = {
        "along_amplitude_mm": 1.0,
        "normal_amplitude_mm": 0.5,
        "normal_phase_deg": -60.0,
        "frequency_hz": 15.0,
    }
    for column, value in true.items():
        found = content["trough"][column]
        assert abs(found["measured"] - value) < 4.0 * found["standard_error"] < 0.05 * abs(value)
        assert content["scene"][column] == pytest.approx(
            found["measured"], abs=0.01 * found["standard_error"]
        )
    assert abs(content["trough_time_at_zero_s"] - TRIGGER) < 4.0 * content["trough_time_error_s"]


def test_the_unknowns_of_an_ellipse_are_fitted(run: Run, data: Path, ellipse: Path) -> None:
    result = run("compare", ellipse, data, *BODY, *GIVEN[:4], "--fit", "mu_d,phi", "--json", "-q")
    assert result.exit_code == 0, result.stderr
    fit = json.loads(result.stdout)["fit"]
    for name, true in (("kinetic_friction", 0.3), ("normal_phase", -60.0)):
        assert fit[name]["low"] - 0.01 * abs(true) < true < fit[name]["high"] + 0.01 * abs(true)
        assert fit[name]["estimate"] == pytest.approx(true, rel=0.02)
    assert fit["normal_phase"]["unit"] == "deg"
