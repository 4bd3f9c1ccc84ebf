"""What notebooks show: numbers in the units of tables, escaped, and of anything that can be made."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from helpers.plans import store, swept
from helpers.read_pages import ReadPage

import vibro
from vibro.html_tables import counts, html_table, span

NUT = Path(__file__).parents[1] / "examples" / "safety_nut.toml"
LINE: dict[str, Any] = {
    "frequency": 15,
    "drive_angle": math.radians(20),
    "static_friction": 0.74,
    "kinetic_friction": 0.57,
}
QUESTION = {
    "scene": {"static_friction": "0.7:0.78", "kinetic_friction": 0.57},
    "drive": [{"amplitude_mm": "2:3", "frequency_hz": 12, "drive_angle_deg": 30, "name": "<b>&"}],
    "goal": {"speed_mm_s": 30, "highest_regime": "forward-slip"},
}


def shown(value: Any) -> tuple[str, dict[str, list[str]]]:
    """Return the caption of what a notebook shows, and its cells by the first of their row."""
    page = ReadPage(value if isinstance(value, str) else value._repr_html_())
    assert {*page.tags} <= {"table", "caption", "thead", "tbody", "tr", "th", "td"}
    return page.text.partition("\n")[0], {row[0]: row[1:] for row in page.rows}


def test_texts_are_escaped_and_rows_without_any_left_out() -> None:
    text = html_table("<i>", [("a&b", "<script>"), ("empty", "", ""), ("wide", "x")], ["", "1", "2"])
    assert "<script>" not in text
    assert shown(text) == ("<i>", {"": ["1", "2"], "a&b": ["<script>"], "wide": ["x"]})
    assert 'colspan="2"' in text


def test_numbers_and_codes_are_summarised() -> None:
    assert span(-0.0, "mm") == "0 mm"
    assert span([math.nan] * 2, "mm") == span([], "mm") == "none"
    assert span([3.0, 1.23456789], "mm") == "1.23457 ... 3 mm"
    assert span([1.0, math.nan, 2.0, math.inf], "mm") == "1 ... 2 mm (2 of 4 without)"
    texts = {0: "rest", 1: "slip", -1: ""}
    assert counts(np.array([1, 1, 0, -1, 1, 7, 0]), texts) == "slip: 3, rest: 2, none: 1, 7: 1"
    assert counts(np.arange(9), {}) == "0: 1, 1: 1, 2: 1, 3: 1, 4: 1, 5: 1, 3 more"


def test_scenes_and_their_results_are_shown_in_the_units_of_files() -> None:
    scene = vibro.Scene(amplitude=np.linspace(1e-3, 2e-3, 6).reshape(2, 3), **LINE)
    caption, rows = shown(scene)
    assert (caption, rows["amplitude"], rows["drive angle"]) == ("2 x 3 scenes", ["1 ... 2 mm"], ["20 deg"])
    friction = {"frequency": 2, "static_friction": 0.4, "kinetic_friction": 0.3}
    pairs = {"along_harmonics": [(1e-3, 0), (2e-4, 0.5)], "normal_harmonics": [(3e-4, math.pi / 2)]}
    _, rows = shown(vibro.Scene(**pairs, **friction))
    assert (rows["along amplitude 2"], rows["normal phase 1"]) == (["0.2 mm"], ["90 deg"])
    _, rows = shown(vibro.Scene(motion=vibro.Motion.steps([(0.8, 2.4), (0.2, -9.6)]), **friction))
    assert rows["motion"] == ["2 pieces, at most 9.6 m/s^2"]
    cycle = vibro.solve(vibro.Scene(amplitude=1e-3, **LINE))
    caption, rows = shown(cycle)
    assert caption == "steady cycle"
    assert rows["mean velocity"] == [f"{1e3 * cycle.mean_velocity:.6g} mm/s"]
    assert (rows["regime"], rows["pattern"], rows["coexists"]) == (["forward-slip"], ["F_"], ["no"])
    amplitudes = np.array([1e-4, 1e-3, 1e-3, 2e-3, 6e-3])
    caption, rows = shown(vibro.solve(vibro.Scene(amplitude=amplitudes, **LINE), flight=False))
    assert caption == "5 steady cycles"
    assert rows["regime"] == ["forward-slip: 2, no-slip: 1, back-slip: 1, hopping: 1"]
    assert rows["mean velocity"][0].endswith("mm/s (1 of 5 without)")


def test_sweeps_are_shown_with_their_cells(tmp_path: Path) -> None:
    held = swept(amplitude_mm=[0.1, 1, 1.5], frequency_hz=[10, 15], trough_length_mm=600)
    caption, rows = shown(held)
    assert caption == "Sweep of amplitude_mm (3 values) x frequency_hz (2 values)"
    assert rows["amplitude"] == ["3 values, 0.1, 1, 1.5 mm"]
    assert rows["trough length"] == ["600 mm"]
    assert rows["regime"] == ["no-slip: 4, forward-slip: 1, back-slip: 1"]
    caption, rows = shown(vibro.open_sweep(store(held, tmp_path / "<&>")))
    assert caption.startswith("StoredSweep of amplitude_mm")
    assert rows["folder"] == [f"{tmp_path / '<&>'}: 1 files, {held.to_frame().shape[1]} columns"]
    fastest = held.to_frame()["mean_velocity_mm_s"].max()
    assert rows["fastest"] == [f"{fastest:.6g} mm/s at amplitude 1.5 mm, frequency 15 Hz"]


def test_histories_are_shown_in_short() -> None:
    history = vibro.simulate(vibro.Scene(amplitude=1e-3, **LINE), cycles=10)
    assert repr(history) == "<History of 0.666667 s: 21 phases, of which F_ repeat>"
    caption, rows = shown(history)
    assert (caption, rows["duration"], rows["phases"]) == ("history", ["0.666667 s"], ["21"])
    assert (rows["pattern"], rows["period"]) == (["F_"], ["1 drive cycle"])
    assert rows["repeats from"] == [f"{history.settles_at:.6g} s"]
    assert rows["displacement per cycle"] == [f"{1e3 * history.cycle_displacement:.6g} mm"]
    rest = vibro.simulate(vibro.Scene(amplitude=1e-4, **LINE), cycles=2)
    assert shown(rest)[1] == {"duration": ["0.133333 s"], "phases": ["1"], "pattern": ["none repeats"]}


def test_guarantees_and_designs_are_shown() -> None:
    found = vibro.guarantee(vibro.Scene(amplitude=1e-3, **LINE), static_friction=(0.7, 0.78))
    _, rows = shown(found)
    least, most = (float(text.removesuffix(" mm/s")) for text in rows["guaranteed"])
    assert 0.0 <= 1e3 * found.speed_min - least < 1e-3
    assert 0.0 <= most - 1e3 * found.speed_max < 1e-3
    assert rows["found"] == [f"{1e3 * x:.6g} mm/s" for x in (found.found_min, found.found_max)]
    assert (rows["static friction"], rows["amplitude"]) == (["0.78", "0.7"], ["1 mm", "1 mm"])
    assert (rows["regimes"], rows["proof"]) == (["forward-slip"], ["corners", "corners"])
    _, rows = shown(
        replace(found, regimes=frozenset(), proof_min="searched", speed_max=math.inf, min_at={"x": 1.0})
    )
    assert rows["guaranteed"] == ["", "inf mm/s"]
    result = vibro.design(QUESTION, only="goal")
    text = result._repr_html_()
    assert "&lt;b&gt;&amp;" in text
    assert "speed min [mm/s]" in text
    assert "stroke" not in text
    assert f">{result.designs[0].amplitude_mm:.15g}</td>" in text


def test_a_comparison_shows_what_was_measured_beside_what_is_computed() -> None:
    found = vibro.compare(vibro.read_scene(NUT), NUT.parent / "data" / "nut_smoothed_600hz.csv")
    caption, rows = shown(found)
    assert f"<{caption}>" == repr(found) == "<Comparison of 801 samples, computed pattern F_>"
    assert rows["mean_speed"] == ["14.3314 mm/s", "0.000186991 mm/s", "16.2635 mm/s"]
    assert rows["rms_velocity"] == ["2.89688 mm/s", "", ""]
