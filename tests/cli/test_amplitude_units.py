"""An amplitude that is given by its acceleration or its speed."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from helpers.cases import each
from helpers.commands import NUT_ANGLE_AND_FRICTION, NUT_FILE, rows_of
from hypothesis import given
from hypothesis import strategies as st

import vibro
from vibro.explore.scenes import scene_data
from vibro.files.scene_files import read_scene_file
from vibro.quantities import STANDARD_GRAVITY
from vibro.sweeps.whole import read_scene, request_of_call

if TYPE_CHECKING:
    from helpers.commands import Run

G = 9.80665
UNITS = {
    "g": (G, 2), "m/s^2": (1.0, 2), "m/s²": (1.0, 2), "mm/s": (1e-3, 1), "m/min": (1 / 60, 1),
    "in/s": (0.0254, 1), "mm": (1e-3, 0), "um": (1e-6, 0),
}  # fmt: skip
"""Size in SI units, and the order of the derivative."""
NUT: dict[str, Any] = {"drive_angle_deg": 20, "static_friction": 0.74, "kinetic_friction": 0.57}


@given(
    value=st.floats(1e-3, 1e3),
    frequency=st.floats(1.0, 500.0),
    unit=st.sampled_from([*UNITS]),
    way=st.sampled_from(["", "rms", "peak", "stroke"]),
)
def test_the_amplitude_follows_from_any_unit(value: float, frequency: float, unit: str, way: str) -> None:
    size, order = UNITS[unit]
    factor = {"": 1.0, "peak": 1.0, "rms": math.sqrt(2.0), "stroke": 0.5}[way]
    key, text = ("stroke_mm", unit) if way == "stroke" else ("amplitude_mm", f"{unit} {way}".rstrip())
    request = request_of_call(None, {key: f"{value!r}{text}", "frequency_hz": frequency, **NUT})
    wanted = factor * value * size / (2.0 * math.pi * frequency) ** order
    assert float(vars(request.scene())["amplitude"]) == pytest.approx(wanted, rel=1e-15, abs=0.0)


def test_a_stroke_in_g_is_the_amplitude_of_half_of_it(run: Run) -> None:
    """20 Hz with 4 g from peak to peak: A = 2 g / (2 pi 20 Hz)^2 = 1.24203 mm."""
    amplitude = 1e3 * 2 * G / (2 * math.pi * 20) ** 2
    rest = ("-f", "20", "-a", "30", "--mu-s", ".5", "--mu-d", ".4", "-L", "600")
    result = run("solve", "--stroke", "4g", *rest, "--json")
    assert result.stderr == "amplitude 2 g (1.242 mm at 20 Hz)\n"
    in_g = json.loads(result.stdout)
    in_mm = json.loads(run("solve", "-A", repr(amplitude), *rest, "--json").stdout)
    assert in_g["amplitude_mm"] == pytest.approx(1.24203, abs=5e-6)
    assert in_g["acceleration_g"] == 2.0
    assert in_mm["acceleration_g"] == pytest.approx(2.0 * G / STANDARD_GRAVITY)
    for name in in_mm.keys() - {"acceleration_g", "beginnings", "sensitivities"}:
        assert in_g[name] == in_mm[name], name
    steps = {row["more_of"]: row["speed_mm_s"] for row in in_mm["sensitivities"]}
    assert steps.pop("frequency, 1 %")  # which changes the amplitude of an acceleration
    for row in in_g["sensitivities"]:
        assert row["speed_mm_s"] == steps[row["more_of"].replace("acceleration", "amplitude")]
    for row, other in zip(in_g["beginnings"], in_mm["beginnings"], strict=True):
        assert row["acceleration_g"] == pytest.approx(2.0 / amplitude * other["amplitude_mm"], rel=1e-14)


@each(
    ("text", "column", "power"),
    [("1:5g:3", "acceleration_g", 2), ("100mm/s, 300mm/s", "drive_speed_mm_s", 1)],
)
def test_a_map_is_what_solve_says_of_each_cell(run: Run, text: str, column: str, power: int) -> None:
    args = ("-A", text, "-f", "10:60:4", *NUT_ANGLE_AND_FRICTION)
    result = run("map", *args, "-o", "-")
    rows = rows_of(result.stdout)
    assert [*rows[0]][:3] == ["amplitude_mm", column, "frequency_hz"]
    for row in rows:
        f = 2 * math.pi * float(row["frequency_hz"])
        unit = 1e3 * G if column == "acceleration_g" else 1.0
        assert float(row["amplitude_mm"]) == pytest.approx(unit * float(row[column]) / f**power, rel=1e-15)
        scene = ("-A", row["amplitude_mm"], "-f", row["frequency_hz"], *NUT_ANGLE_AND_FRICTION)
        one = json.loads(run("solve", *scene, "--json", "--columns", "mean_velocity_mm_s,regime").stdout)
        assert (float(row["mean_velocity_mm_s"]), row["regime"]) == tuple(one.values())
    swept = vibro.sweep(amplitude_mm=text, frequency_hz="10:60:4", **NUT)
    frame = swept.to_frame()
    assert frame["amplitude_mm"].tolist() == [float(row["amplitude_mm"]) for row in rows]
    assert [*swept.axes] == [column, "frequency_hz"]
    assert swept.to_xarray().amplitude_mm.dims == (column, "frequency_hz")


def test_files_give_it_and_tables_hold_it(run: Run, no_pictures: None) -> None:
    text = NUT_FILE.replace("= 1\n", '= "4g"\n', 1).replace("frequency_hz = 15", "frequency_hz = 20")
    Path("nut.toml").write_text(
        text + '\n[map]\nstroke_mm = ["2g", "4g"]\nfrequency_hz = "10:60:3"\n', "utf-8"
    )
    amplitude = 4 * G / (2 * math.pi * 20) ** 2
    assert float(vars(read_scene("nut.toml"))["amplitude"]) == pytest.approx(amplitude, rel=1e-15)
    assert read_scene_file(Path("nut.toml")).scene["amplitude"].value == 4.0
    assert run("map", "nut.toml", "-o", "cells.parquet").exit_code == 0
    stored = vibro.open_sweep("cells.parquet")
    assert {name: values.tolist() for name, values in stored.axes.items()} == {
        "acceleration_g": [1.0, 2.0], "frequency_hz": [10.0, 35.0, 60.0]
    }  # fmt: skip
    kept = stored.to_frame({"acceleration": "2g", "f": 10})
    assert kept["amplitude_mm"].tolist() == pytest.approx([2e3 * G / (2 * math.pi * 10) ** 2], rel=1e-15)
    again = run("map", "cells.parquet", "-o", "again")
    assert again.stderr.startswith("acceleration: 2 values, 1, 2 g\n")
    assert run("map", "nut.toml", "-f", "20", "-o", "book.xlsx").exit_code == 0
    record = json.loads(Path("book.json").read_text(encoding="utf-8"))
    assert record["axes"]["acceleration_g"]["values"] == [1.0, 2.0]
    page = scene_data(request_of_call("nut.toml", {}))
    assert float(page["state"]["amplitude_mm"]) == pytest.approx(1e3 * amplitude, rel=1e-15)
