"""Sweeps whose amplitude follows from a machine: against reference rows, in memory and in files."""

from __future__ import annotations

import csv
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.machine_files import SCENE, feeder, written

import vibro
from vibro.core.codes import Regime, Status
from vibro.errors import InputError
from vibro.plots.fields import Fields
from vibro.plots.view import choose_view, panels
from vibro.results.operating import FIELDS, MACHINE_RESULTS, OPERATING
from vibro.sweeps.grid import Grid, scene_of
from vibro.sweeps.run import sweep_picture
from vibro.sweeps.whole import request_of_call

TABLE = Path(__file__).parents[1] / "data" / "machines" / "operating.csv"
ROWS = [*csv.DictReader(TABLE.read_text(encoding="utf-8").splitlines())]
PACKS = """
[[machine.pack]]
name = "soft"
natural_hz = 47.6
[[machine.pack]]
name = "stiff"
natural_hz = 55.6
"""


def grid_of(path: Path, **quantities: Any) -> Grid:
    from vibro.core.codes import Output

    return request_of_call(path, quantities).grid(Output.EXACT)


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row["id"])
def test_a_full_feeder_is_that_of_the_reference(tmp_path: Path, row: dict[str, str]) -> None:
    """tests/data/machines: 34 digits, an event walk and phasors that share nothing with vibro.

    They are those under a sine: the amplitude with the second harmonic is that of Python.
    """
    text = f"""
[scene]
frequency_hz = {row["frequency_hz"]}
drive_angle_deg = {row["drive_angle_deg"]}
static_friction = {row["static_friction"]}
kinetic_friction = {row["kinetic_friction"]}
[machine]
kind = "magnet"
trough_mass_kg = {row["m1_kg"]}
counter_mass_kg = {row["m2_kg"]}
natural_hz = {row["natural_hz"]}
damping_ratio = {row["damping_ratio"]}
force_n = {row["force_n"]}
filling_kg = {row["filling_kg"]}
"""
    frame = vibro.sweep(written(tmp_path, text), trough_angle_deg=[0, 1]).to_frame()
    x = {name: float(cell) for name, cell in row.items() if name not in ("id", "pattern")}
    machine = vibro.Machine.magnet(
        trough_mass=x["m1_kg"], counter_mass=x["m2_kg"], natural_frequency=x["natural_hz"],
        damping_ratio=x["damping_ratio"], force=x["force_n"],
    )  # fmt: skip
    point = vibro.operate(
        machine,
        frequency=x["frequency_hz"], drive_angle=math.radians(x["drive_angle_deg"]), filling=x["filling_kg"],
        static_friction=x["static_friction"], kinetic_friction=x["kinetic_friction"],
    )  # fmt: skip
    assert 1e3 * point.amplitude_sine == pytest.approx(x["amplitude_mm"], rel=1e-8)
    assert frame["amplitude_empty_mm"][0] == pytest.approx(x["amplitude_empty_mm"], rel=1e-8)
    assert frame["amplitude_mm"][0] == pytest.approx(1e3 * point.amplitude, rel=1e-8)
    for column in ("added_mass_share", "added_damping_share"):
        assert frame[column][0] == pytest.approx(getattr(point, column), rel=1e-8), column
    assert frame["uncertain"][0] == point.uncertain
    assert frame["frequency_ratio"][0] == float(row["frequency_hz"]) / float(row["natural_hz"])
    amplitude = vibro.read_scene(tmp_path / "feeder.toml").amplitude
    assert amplitude == pytest.approx(point.amplitude, rel=1e-8)


def test_every_axis_of_a_machine_has_its_column_and_its_effect(tmp_path: Path) -> None:
    path = feeder(tmp_path)
    axes: dict[str, Any] = {
        "setting_percent": [50, 100],
        "voltage_percent": [90, 100],
        "filling_kg": [0, "500g"],
        "natural_hz": [47.6, 55.6],
    }
    t = vibro.sweep(path, **axes)
    assert [*t.axes] == [*axes]
    frame = t.to_frame()
    assert [*frame.columns[:5]] == [*axes, "amplitude_mm"]
    names = [*frame.columns]
    results = [result.column for result in MACHINE_RESULTS]
    assert names[names.index("model") - len(results) : names.index("model")] == results
    empty = frame["amplitude_empty_mm"].to_numpy().reshape(2, 2, 2, 2)
    np.testing.assert_allclose(empty[1], 2.0 * empty[0], rtol=1e-14)  # the force is the setting
    np.testing.assert_allclose(
        empty[:, 0], 0.81 * empty[:, 1], rtol=1e-14
    )  # and goes with the voltage squared
    np.testing.assert_array_equal(empty[:, :, 0], empty[:, :, 1])
    assert empty[1, 1, 0, 1] == pytest.approx(0.35, rel=1e-14)
    full = frame["amplitude_mm"].to_numpy().reshape(2, 2, 2, 2)
    np.testing.assert_array_equal(full[:, :, 0], empty[:, :, 0])
    assert (full[:, :, 1, 1] > empty[:, :, 1, 1]).all()  # below resonance
    assert (full[:, :, 1, 0] < empty[:, :, 1, 0]).all()  # above it


def test_cells_are_those_of_one_scene_each(tmp_path: Path) -> None:
    """Whatever box they are taken from, to the last bit."""
    grid = grid_of(
        feeder(tmp_path), setting_percent="40:100:5", filling_kg="0:2:7", static_friction=[0.3, 0.4]
    )
    whole = grid.values()
    cycle = grid.solve(whole)
    amplitude, found = whole["amplitude"].reshape(-1), whole[OPERATING].reshape(-1)
    for start, stop in ((0, 1), (3, 20), (17, 70)):
        part = grid.cells(start, stop)
        operating: Any = part[OPERATING]
        expected: Any = found[start:stop]
        np.testing.assert_array_equal(part["amplitude"], amplitude[start:stop])
        for name in FIELDS.names or ():
            np.testing.assert_array_equal(operating[name], expected[name])
        _, solved = grid.solve_cells(start, stop)
        for name, x in solved.arrays().items():
            np.testing.assert_array_equal(x, cycle.arrays()[name].reshape(-1)[start:stop])
    picked = grid.picked(np.array([5, 44, 69]))
    np.testing.assert_array_equal(picked["amplitude"], amplitude[[5, 44, 69]])


def test_files_hold_what_memory_holds(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vibro.tables.plan._DEAR_SHARD_CELLS", 10)
    path = feeder(tmp_path, PACKS)
    axes: dict[str, Any] = {
        "filling_kg": "0:3:9",
        "natural_hz": [47.6, 55.6],
        "setting_percent": "50:90:3",
    }
    frame = vibro.sweep(path, **axes).to_frame()
    written = vibro.write_sweep(tmp_path / "one", path, **axes)
    for sweep in (written, vibro.open_sweep(tmp_path / "one")):
        assert sweep.to_frame().equals(frame)
        assert sweep.fixed["voltage_percent"] == 100.0
    assert len([*(tmp_path / "one").glob("*.parquet")]) == 6


def test_a_spring_pack_is_called_by_its_name(tmp_path: Path) -> None:
    path = feeder(tmp_path, PACKS)
    frame = vibro.sweep(path, pack="soft", setting_percent=[50, 100]).to_frame()
    assert frame["natural_hz"].tolist() == [47.6, 47.6]
    assert frame.equals(vibro.sweep(path, natural_hz=47.6, setting_percent=[50, 100]).to_frame())


def test_labelled_arrays_have_the_amplitude_as_a_result(tmp_path: Path) -> None:
    pytest.importorskip("xarray")
    t = vibro.sweep(feeder(tmp_path), setting_percent=[50, 100], filling_kg=[0, 1])
    data = t.to_xarray()
    assert data["amplitude_mm"].dims == ("setting_percent", "filling_kg")
    assert {"amplitude_mm", "added_mass_share", "relative_amplitude_mm"} <= {*data.data_vars}
    assert data.coords["natural_hz"].item() == 55.6
    assert '"kind": "magnet"' in data.attrs["machine"]


def test_the_speed_with_the_second_harmonic_is_told_where_it_is_named(tmp_path: Path) -> None:
    t = vibro.sweep(feeder(tmp_path, "gap_mm = 0.6\n"), filling_kg=[0, 2], setting_percent=[50, 80, 200])
    names = ["status", "mean_velocity_mm_s", "mean_velocity_with_second_harmonic_mm_s"]
    status, sine, bent = (t.to_frame(names)[name].to_numpy() for name in names)
    assert status.tolist() == ["ok", "ok"] * 2 + ["infeasible"] * 2
    np.testing.assert_allclose(bent[[0, 2]], sine[[0, 2]], rtol=1e-9)  # of an empty trough
    assert ((bent / sine)[[1, 3]] > 1.001).all()
    assert np.isnan(bent[4:]).all()
    assert names[2] not in t.to_frame()
    with pytest.raises(InputError, match="no column"):
        vibro.sweep(amplitude_mm=[1, 2], frequency_hz=15, drive_angle_deg=20, static_friction=0.4,
                    kinetic_friction=0.3).to_frame(names)  # fmt: skip


def test_masses_that_strike_leave_a_cell_without_numbers(tmp_path: Path) -> None:
    path = feeder(tmp_path, "gap_mm = 0.4\n")
    t = vibro.sweep(path, setting_percent=[50, 70, 90], static_friction=[0.2, 0.35])
    frame = t.to_frame()
    # the springs bend by 1.5 times the amplitude: 0.26, 0.37 and 0.47 mm; and 0.28 is above 0.2
    assert frame["status"].tolist() == ["infeasible", "ok", "infeasible", "ok", "infeasible", "infeasible"]
    lost = frame.iloc[5]
    assert np.isnan(lost[["amplitude_mm", "mean_velocity_mm_s", "throw_number"]].to_numpy(float)).all()
    assert lost["regime"] == ""
    assert lost["relative_amplitude_mm"] == pytest.approx(0.4725)
    assert t.cycle.regime[2, 1] == Regime.UNDEFINED


def test_pictures_have_the_critical_loads_of_the_amplitudes_found(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("vibro.sweeps.run._RESOLVED", {1: 41, 2: 31, 3: 21})
    path = feeder(tmp_path)
    grid = grid_of(path, setting_percent="10:100", filling_kg="0:2")
    result = sweep_picture(grid, {}, {"setting": 100.0, "filling": 0.0}, "")
    assert result.amplitude is not None
    assert result.shape == result.amplitude.shape == (16, 16)  # half as fine as without a filling
    empty = grid_of(path, setting_percent="10:100", voltage_percent="90:110")
    assert sweep_picture(empty, {}, None, "").shape == (31, 31)
    ((panel,),) = panels(result, choose_view(result.axes))
    fields = Fields(panel)
    hops = panel.cycle["regime"] == Regime.HOPPING
    assert 0.1 < hops.mean() < 0.9
    np.testing.assert_array_equal(fields.log_ratio["hop"] > 0.0, hops)
    np.testing.assert_allclose(np.exp(fields.log_ratio["hop"]), panel.cycle["throw_number"], rtol=1e-12)


def test_shares_that_are_given_replace_the_computed_ones(tmp_path: Path) -> None:
    path = feeder(tmp_path, 'filling_kg = 2\nadded_mass_share = "0.1:0.3"\nadded_damping_share = 0.05\n')
    frame = vibro.sweep(path, setting_percent=[50, 100]).to_frame()
    assert frame["added_mass_share"].tolist() == [0.2, 0.2]
    ratio = frame["amplitude_mm"] / frame["amplitude_empty_mm"]
    made = vibro.Machine.magnet(
        trough_mass=6, counter_mass=12, natural_frequency=55.6, damping_ratio=0.015, force=1.0
    )
    expected = made.response(50.0, added_mass=2 * (0.2 - 0.05j)).amplitude / made.response(50.0).amplitude
    np.testing.assert_allclose(ratio, float(expected), rtol=1e-14)


def test_bands_are_the_axes_of_a_map_where_nothing_else_varies(tmp_path: Path) -> None:
    path = feeder(tmp_path, 'voltage_percent = "90:110"\nfilling_kg = "0:2"\n')
    grid = grid_of(path)
    assert [*grid.axes] == ["voltage", "filling"]
    assert [axis.values[[0, -1]].tolist() for axis in grid.axes.values()] == [[90.0, 110.0], [0.0, 2.0]]
    assert grid_of(path, setting_percent="50:100").fixed["filling"] == 0.0


def test_irregular_motion_says_so(tmp_path: Path) -> None:
    """The amplitude is known to an interval: no cell is exact there."""
    path = feeder(tmp_path, "filling_kg = 1\n", scene=f"{SCENE}restitution = 0.3\n")
    t = vibro.sweep(path, setting_percent="200:400:9")
    grid = t._grid
    values = grid.values()
    found: Any = values[OPERATING]
    averaged = found["status"] == Status.AVERAGED
    assert averaged.any()
    assert (t.cycle.status[averaged] == Status.AVERAGED).all()
    alone = vibro.solve(scene_of(values))
    exact = alone.status == Status.OK
    assert np.isnan(t.cycle.mean_velocity_error[averaged & exact]).all()
    np.testing.assert_array_equal(t.cycle.mean_velocity_error[~exact], alone.mean_velocity_error[~exact])
    np.testing.assert_array_equal(t.cycle.mean_velocity, alone.mean_velocity)
