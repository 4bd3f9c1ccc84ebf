"""Sweeps from Python: the cells of ``vibro map``, held."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from helpers.cases import each
from helpers.commands import rows_of
from typer.testing import CliRunner

import vibro
from vibro.cli.app import app
from vibro.errors import InputError

NUT_FILE = Path(__file__).parents[2] / "examples" / "safety_nut.toml"
NUT: dict[str, Any] = {"drive_angle_deg": 20, "static_friction": 0.74, "kinetic_friction": 0.57}


def test_a_scene_file_gives_the_cells_of_the_command() -> None:
    t = vibro.sweep(NUT_FILE, frequency_hz="5:60:7", drive_angle_deg=[10, 20.5])
    assert t.shape == t.cycle.status.shape == (20, 7, 2)
    assert list(t.axes) == ["amplitude_mm", "frequency_hz", "drive_angle_deg"]
    np.testing.assert_array_equal(t.axes["drive_angle_deg"], [10, 20.5])
    assert t.fixed == {
        "static_friction": 0.74, "kinetic_friction": 0.57, "trough_angle_deg": 0.0, "gravity_m_s2": 9.81,
        "restitution": 0.0, "trough_length_mm": 600.0,
    }  # fmt: skip
    frame = t.to_frame()
    command = ("map", str(NUT_FILE), "-f", "5:60:7", "-a", "10,20.5", "-o", "-")
    text = CliRunner().invoke(app, command).stdout
    table = rows_of(text)
    assert list(frame.columns) == list(table[0])
    for name in frame.columns:
        written = [row[name] for row in table]
        if pd.api.types.is_numeric_dtype(frame[name].dtype):
            held = frame[name].to_numpy(float, na_value=np.nan)
            np.testing.assert_array_equal(held, [float(cell or "nan") for cell in written], err_msg=name)
        else:
            assert isinstance(frame[name].dtype, pd.CategoricalDtype)
            assert list(frame[name]) == written


@each(
    "given",
    [
        *({"amplitude_mm": values} for values in ([0.5, 1, 1.5], (0.5, 1.0, 1.5), np.linspace(0.5, 1.5, 3))),
        {"amplitude_mm": ["500um", "1mm", np.float64(1.5)], "frequency_hz": "900rpm"},
        {"amplitude_mm": pd.Series([0.5, 1.0, 1.5]), "frequency_hz": np.float64(15)},
        {"stroke_mm": "1:3:3", "frequency_hz": "15"},
        {"stroke_mm": range(1, 4)},
    ],
)
def test_values_are_numbers_sequences_or_axes(given: dict[str, Any]) -> None:
    by_text = vibro.sweep(amplitude_mm="0.5:1.5:3", frequency_hz=15, **NUT)
    t = vibro.sweep(**{"frequency_hz": 15, **given}, **NUT)
    np.testing.assert_array_equal(t.cycle.mean_velocity, by_text.cycle.mean_velocity)


def test_a_swept_ratio_has_its_column_and_frictions_are_spelled_as_typed() -> None:
    given = {**NUT, "static_friction": [0.2, 0.3], "friction_ratio": "0.7:0.9:3", "amplitude_mm": 1}
    del given["kinetic_friction"]
    frame = vibro.sweep(frequency_hz=15, **given).to_frame()
    columns = list(frame.columns)
    assert columns[columns.index("kinetic_friction") - 1] == "friction_ratio"
    spelled = [repr(x) for x in frame["kinetic_friction"].tolist()]
    assert spelled == ["0.14", "0.16", "0.18", "0.21", "0.24", "0.27"]
    fixed = {**given, "friction_ratio": 0.8}
    assert "friction_ratio" not in vibro.sweep(frequency_hz=15, **fixed).to_frame().columns
    few = vibro.sweep(frequency_hz=15, **fixed).to_frame(["regime", "acceleration_g", "restitution"])
    assert list(few) == ["regime", "acceleration_g", "restitution"]
    with pytest.raises(vibro.VibroError, match="'friction_ratio'"):
        vibro.sweep(frequency_hz=15, **fixed).to_frame(["friction_ratio"])


def test_what_is_handed_out_does_not_change_the_sweep() -> None:
    t = vibro.sweep(amplitude_mm="0.5:1.5:3", frequency_hz=15, **NUT)
    t.axes["amplitude_mm"][0] = 99.0
    t.fixed["restitution"] = 0.5
    assert t.to_frame()["amplitude_mm"].tolist() == [0.5, 1.0, 1.5]
    assert t.fixed["restitution"] == 0.0
    one = vibro.sweep(amplitude_mm=1, frequency_hz=15, **NUT)
    assert (one.shape, one.to_frame()["pattern"].tolist()) == ((), ["F_"])


def test_more_cells_than_memory_holds_are_refused_with_their_size() -> None:
    axes = ("amplitude_mm", "frequency_hz", "drive_angle_deg", "trough_angle_deg")
    size = r"3000 x 3000 x 3000 x 3000 = 81000000000000 cells take about 8.91e\+06 GB"
    with pytest.raises(InputError, match=size):
        vibro.sweep(**{**NUT, **dict.fromkeys(axes, "1:2:3000")})


def test_pictures_of_the_cells_held() -> None:
    t = vibro.sweep(NUT_FILE, amplitude_mm="0.1:3:10", frequency_hz="5:60:10", drive_angle_deg="10, 20")
    figure = t.draw("speed", at={"alpha": 20}, x="A", y="frequency_hz")
    axes = figure.axes[0]
    assert axes.get_xlabel().startswith("amplitude")
    assert axes.get_ylabel().startswith("frequency")
    assert len(t.draw("regime").axes) == 2


def test_the_operating_point_is_the_scene_that_the_file_gives() -> None:
    def marked(**changes: Any) -> bool:
        t = vibro.sweep(NUT_FILE, amplitude_mm="0.1:3:9", frequency_hz="5:60:9", **changes)
        return any(line.get_gid() == "operating point" for line in t.draw("regime").axes[0].lines)

    assert marked()
    assert not marked(drive_angle_deg=40)


def test_progress_is_told_as_solve_does() -> None:
    told: list[tuple[int, int]] = []
    vibro.sweep(
        amplitude_mm="0.1:3:30",
        frequency_hz="5:60:30",
        **NUT,
        progress=lambda done, size: told.append((done, size)),
    )
    assert (900, 900) in told
    assert told[-1][0] == told[-1][1]  # of those that hop
