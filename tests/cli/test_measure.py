"""``vibro measure`` of a part: its answer, files, JSON, and what can be wrong with data and options."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.commands import Run, rows_of
from helpers.made_records import EXAMPLES, STUDY, STUDY_FILE
from matplotlib.figure import Figure

from vibro.plots.comparison import comparison_figure

SCENE = EXAMPLES / "safety_nut.toml"
UNITS = {"displacement": "mm", "velocity": "mm_s", "acceleration": "m_s2", "friction": "N"}


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
