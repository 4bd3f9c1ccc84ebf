"""Sweeps from Python: the cells of ``vibro map``, held."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from helpers.commands import rows_of
from typer.testing import CliRunner

import vibro
from vibro.cli.app import app
from vibro.errors import FileError, InputError

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
        if name in NUMBERS:
            held = frame[name].to_numpy(float, na_value=np.nan)
            np.testing.assert_array_equal(held, [float(cell or "nan") for cell in written], err_msg=name)
        else:
            assert isinstance(frame[name].dtype, pd.CategoricalDtype)
            assert list(frame[name]) == written


NUMBERS = [
    "amplitude_mm", "frequency_hz", "drive_angle_deg", "static_friction", "kinetic_friction",
    "trough_angle_deg", "mean_velocity_mm_s", "displacement_per_cycle_mm", "peak_velocity_mm_s",
    "traverse_time_s", "throw_number", "forward_ratio", "back_ratio", "restitution", "trough_length_mm",
    "flight_fraction", "impact_speed_mm_s", "period_cycles",
    "mean_velocity_error_mm_s", "coexists",
]  # fmt: skip


def test_values_are_numbers_sequences_or_axes() -> None:
    by_text = vibro.sweep(amplitude_mm="0.5:1.5:3", frequency_hz=15, **NUT)
    for values in ([0.5, 1, 1.5], (0.5, 1.0, 1.5), np.linspace(0.5, 1.5, 3)):
        t = vibro.sweep(amplitude_mm=values, frequency_hz=np.float64(15), **NUT)
        np.testing.assert_array_equal(t.cycle.mean_velocity, by_text.cycle.mean_velocity)
    t = vibro.sweep(stroke_mm="1:3:3", frequency_hz="15", **NUT)
    np.testing.assert_array_equal(t.cycle.mean_velocity, by_text.cycle.mean_velocity)


def test_a_swept_ratio_has_its_column_and_frictions_are_spelled_as_typed() -> None:
    given = {**NUT, "static_friction": [0.2, 0.3], "friction_ratio": "0.7:0.9:3", "amplitude_mm": 1}
    del given["kinetic_friction"]
    frame = vibro.sweep(frequency_hz=15, **given).to_frame()
    columns = list(frame.columns)
    assert columns[columns.index("kinetic_friction") - 1] == "friction_ratio"
    assert [repr(x) for x in frame["kinetic_friction"].tolist()] == [
        "0.14",
        "0.16",
        "0.18",
        "0.21",
        "0.24",
        "0.27",
    ]
    fixed = {**given, "friction_ratio": 0.8}
    assert "friction_ratio" not in vibro.sweep(frequency_hz=15, **fixed).to_frame().columns
    few = vibro.sweep(frequency_hz=15, **fixed).to_frame(["regime", "acceleration_g", "restitution"])
    assert list(few) == ["regime", "acceleration_g", "restitution"]
    with pytest.raises(vibro.VibroError, match="'friction_ratio'"):
        vibro.sweep(frequency_hz=15, **fixed).to_frame(["friction_ratio"])


def test_values_may_carry_units_and_come_as_series() -> None:
    by_number = vibro.sweep(amplitude_mm=[0.8, 1.0], frequency_hz=15, **NUT)
    for values in (["800um", "1mm"], "800um,1mm", pd.Series([0.8, 1.0]), [np.float64(0.8), 1]):
        t = vibro.sweep(amplitude_mm=values, frequency_hz="900rpm", **NUT)
        np.testing.assert_array_equal(t.cycle.mean_velocity, by_number.cycle.mean_velocity)
    assert vibro.sweep(amplitude_mm=range(1, 4), frequency_hz=15, **NUT).shape == (3,)


def test_one_operating_point_is_a_sweep_too() -> None:
    t = vibro.sweep(amplitude_mm=1, frequency_hz=15, **NUT)
    assert t.shape == ()
    assert t.to_frame()["pattern"].tolist() == ["F_"]
    assert repr(t) == "<Sweep of one operating point>"
    with pytest.raises(InputError, match="no such picture"):
        t.draw("speed")


def test_what_is_handed_out_does_not_change_the_sweep() -> None:
    t = vibro.sweep(amplitude_mm="0.5:1.5:3", frequency_hz=15, **NUT)
    t.axes["amplitude_mm"][0] = 99.0
    t.fixed["restitution"] = 0.5
    assert t.to_frame()["amplitude_mm"].tolist() == [0.5, 1.0, 1.5]
    assert t.fixed["restitution"] == 0.0
    assert repr(t) == "<Sweep of amplitude_mm (3 values)>"


def test_more_cells_than_memory_holds_are_refused_with_their_size() -> None:
    with pytest.raises(
        InputError, match=r"3000 x 3000 x 3000 x 3000 = 81000000000000 cells take about 8.91e\+06 GB"
    ):
        vibro.sweep(
            amplitude_mm="1:2:3000",
            frequency_hz="1:2:3000",
            drive_angle_deg="10:20:3000",
            trough_angle_deg="0:1:3000",
            static_friction=0.74,
            kinetic_friction=0.57,
        )


def test_regimes_alone_and_contact_alone() -> None:
    t = vibro.sweep(amplitude_mm="0.5:4:3", frequency_hz=15, output="regimes", **NUT)
    assert list(t.to_frame()["regime"]) == ["no-slip", "back-slip", "hopping"]
    assert np.isnan(t.cycle.mean_velocity[1:]).all()
    t = vibro.sweep(amplitude_mm="0.5:4:3", frequency_hz=15, flight=False, **NUT)
    assert list(t.to_frame()["status"]) == ["ok", "ok", "flight-not-modelled"]


def test_what_was_not_looked_at_is_no_number() -> None:
    t = vibro.sweep(amplitude_mm="0.5:4:3", frequency_hz=15, flight=False, **NUT)
    assert t.cycle.coexists.tolist() == [0, 0, -1]
    assert t.to_frame()["coexists"].isna().tolist() == [False, False, True]


def test_other_motions_are_looked_for_on_request() -> None:
    slopes = {**NUT, "drive_angle_deg": 55, "trough_angle_deg": [0.0, 31.0], "amplitude_mm": [0.1, 6]}
    assert vibro.sweep(frequency_hz=15, **slopes).cycle.coexists.tolist() == [[0, 1], [-1, 1]]
    t = vibro.sweep(frequency_hz=15, coexistence=True, **slopes)
    assert t.cycle.coexists.tolist() == [[0, 1], [0, 1]]
    assert t.to_frame()["coexists"].tolist() == [0, 1, 0, 1]


def test_restitution_is_an_axis() -> None:
    t = vibro.sweep(amplitude_mm="1:5:9", frequency_hz=15, restitution="0:0.2:5", **NUT)
    np.testing.assert_array_equal(t.axes["restitution"], [0, 0.05, 0.1, 0.15, 0.2])
    assert t.to_frame()["restitution"].tolist() == t.axes["restitution"].tolist() * 9
    axes = t.draw("regime").axes[0]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("amplitude $A$ [mm]", "restitution $e$")
    (hop,) = [line for line in axes.lines if line.get_gid() == "hop"]
    np.testing.assert_allclose(np.asarray(hop.get_xdata(), float)[:-1], 3.22905, rtol=1e-5)


def test_pictures_of_the_cells_held() -> None:
    t = vibro.sweep(NUT_FILE, amplitude_mm="0.1:3:10", frequency_hz="5:60:10", drive_angle_deg="10,20")
    figure = t.draw("speed", at={"alpha": 20}, x="A", y="frequency_hz")
    axes = figure.axes[0]
    assert axes.get_xlabel().startswith("amplitude")
    assert axes.get_ylabel().startswith("frequency")
    assert len(t.draw("regime").axes) == 2
    assert (
        t.draw("traverse", at={"drive_angle_deg": 10}).get_suptitle().startswith("Traverse time over 600 mm")
    )


def test_a_list_is_drawn_value_by_value() -> None:
    t = vibro.sweep(NUT_FILE, amplitude_mm="0.1:3:30", frequency_hz=[15, 20])
    lines = [line for line in t.draw("speed").axes[1].lines if line.get_gid() == "numbers"]
    for line, speeds in zip(lines, t.cycle.mean_velocity.T, strict=True):
        y = np.asarray(line.get_ydata(), float)
        np.testing.assert_array_equal(y[~np.isnan(y)], 1e3 * speeds)
    assert t.draw("regime").axes[0].get_yticks().tolist() == [0, 1]
    with pytest.raises(InputError, match="no such picture"):
        t.draw("regime", at={"f": 20})
    assert len([a for a in t.draw("speed", at={"f": 20}).axes[1].lines if a.get_gid() == "numbers"]) == 1


def test_axes_that_are_not_drawn_are_held_where_something_can_be() -> None:
    t = vibro.sweep(
        NUT_FILE,
        amplitude_mm="0.5:1:2",
        frequency_hz="10:20:2",
        drive_angle_deg=[10, 20],
        static_friction=[0.5, 0.6, 0.7, 0.8],
    )
    assert r"$\mu_s$ = 0.7" in t.draw("regime").get_suptitle()


def test_pictures_that_there_are_not() -> None:
    line = vibro.sweep(amplitude_mm=[0.5, 1, 1.3], frequency_hz=15, **NUT)
    (numbers,) = [line for line in line.draw("speed").axes[1].lines if line.get_gid() == "numbers"]
    assert np.isfinite(np.asarray(numbers.get_ydata(), float)).sum() == 3
    assert numbers.get_marker() == "o"


def test_names_stand_in_their_regimes_on_uneven_cells() -> None:
    """What a name stands on is what is filled there, however far apart the cells are."""
    t = vibro.sweep(
        NUT_FILE,
        amplitude_mm=[0.1, 0.5, 0.7, *np.linspace(3, 3.1, 10)],
        frequency_hz=[5, 10, 40, *range(45, 61)],
    )
    axes = t.draw("regime").axes[0]
    names = [text for text in axes.texts if text.get_text().replace("\n", "") in LABELS]
    assert names
    for text in names:
        on_screen = text.get_transform().transform(text.get_position())
        x, y = axes.transData.inverted().transform(on_screen).tolist()
        filled = {p.get_gid() for p in axes.patches if p.get_path().contains_point((x, y))}
        uppermost = [name for name in ("no-slip", "forward-slip", "back-slip", "hopping") if name in filled]
        assert text.get_text().replace("\n", "") == ["no-slip", *uppermost][-1]


LABELS = {"no-slip", "forward-slip", "back-slip", "hopping"}


def test_the_operating_point_is_the_scene_that_the_file_gives() -> None:
    def marked(**changes: Any) -> bool:
        figure = vibro.sweep(NUT_FILE, amplitude_mm="0.1:3:9", frequency_hz="5:60:9", **changes).draw(
            "regime"
        )
        return any(line.get_gid() == "operating point" for line in figure.axes[0].lines)

    assert marked()
    assert not marked(drive_angle_deg=40)


def test_one_operating_point_of_a_file(tmp_path: Path) -> None:
    scene = vibro.read_scene(NUT_FILE)
    assert scene.shape == ()
    assert float(scene.scale) == 1e-3
    path = tmp_path / "half.toml"
    path.write_text("[scene]\namplitude_mm = 1\nstatic_friction = 0.5\n", encoding="utf-8")
    with pytest.raises(InputError, match="missing: frequency"):
        vibro.read_scene(path)
    with pytest.raises(FileError, match="cannot read"):
        vibro.read_scene(tmp_path / "none.toml")


def test_examples_and_messages_cut_long_values() -> None:
    wide = np.linspace(1.0, 2.0, 1000)
    with pytest.raises(InputError) as caught:
        vibro.sweep(amplitude_mm=wide, frequency_hz=list(wide), static_friction="0." + "3" * 900)
    assert len(caught.value.hint) < 500


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
