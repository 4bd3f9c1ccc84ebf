"""Sweeps whose amplitude follows from a machine: in memory and in files."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from helpers.machine_files import SCENE, feeder

import vibro
from vibro.core.codes import Output, Regime, Status
from vibro.plots.fields import Fields
from vibro.plots.view import choose_view, panels
from vibro.results.operating import MACHINE_RESULTS, OPERATING
from vibro.sweeps.grid import scene_of
from vibro.sweeps.run import sweep_picture
from vibro.sweeps.whole import request_of_call

if TYPE_CHECKING:
    from pathlib import Path

    from vibro.sweeps.grid import Grid

PACKS = """
[[machine.pack]]
name = "soft"
natural_hz = 47.6
[[machine.pack]]
name = "stiff"
natural_hz = 55.6
"""


def grid_of(path: Path, **quantities: Any) -> Grid:
    return request_of_call(path, quantities).grid(Output.EXACT)


def test_every_axis_of_a_machine_has_its_column_and_its_effect(tmp_path: Path) -> None:
    path = feeder(tmp_path, PACKS)
    axes: dict[str, Any] = {
        "setting_percent": [50, 100],
        "voltage_percent": [90, 100],
        "filling_kg": [0, "500g"],
        "natural_hz": [47.6, 55.6],
    }
    t = vibro.sweep(path, **axes)
    frame = t.to_frame()
    assert [*frame.columns[:5]] == [*t.axes, "amplitude_mm"] == [*axes, "amplitude_mm"]
    names, results = [*frame.columns], [result.column for result in MACHINE_RESULTS]
    assert names[names.index("model") - len(results) : names.index("model")] == results
    empty = frame["amplitude_empty_mm"].to_numpy().reshape(2, 2, 2, 2)
    np.testing.assert_allclose(empty[1], 2.0 * empty[0], rtol=1e-14)  # the force is the setting
    np.testing.assert_allclose(
        empty[:, 0], 0.81 * empty[:, 1], rtol=1e-14
    )  # and goes with the voltage squared
    full = frame["amplitude_mm"].to_numpy().reshape(2, 2, 2, 2)
    np.testing.assert_array_equal(full[:, :, 0], empty[:, :, 0])
    assert (full[:, :, 1, 1] > empty[:, :, 1, 1]).all()  # below resonance
    assert (full[:, :, 1, 0] < empty[:, :, 1, 0]).all()  # above it
    machine = vibro.Machine.magnet(
        trough_mass=6.0, counter_mass=12.0, damping_ratio=0.015, natural_frequency=55.6,
        calibration=vibro.Calibration(0.35e-3, 50.0),
    )  # fmt: skip
    scene = vibro.read_scene(path)
    body = {name: getattr(scene, name) for name in ("drive_angle", "static_friction", "kinetic_friction")}
    point = vibro.operate(machine, frequency=50.0, filling=0.5, **body)
    assert full[1, 1, 1, 1] == pytest.approx(1e3 * point.amplitude, rel=1e-14)
    assert frame["added_mass_share"][15] == pytest.approx(point.added_mass_share, rel=1e-14)
    by_name = vibro.sweep(path, pack="soft", filling_kg="500g", setting_percent=[50, 100]).to_frame()
    assert by_name["amplitude_mm"].tolist() == full[:, 1, 1, 0].tolist()
    data = t.to_xarray()
    assert data["amplitude_mm"].dims == (*axes,)
    assert '"kind": "magnet"' in data.attrs["machine"]


def test_files_and_ranges_of_cells_hold_what_memory_holds(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever box a cell is taken from, to the last bit."""
    monkeypatch.setattr("vibro.tables.plan._DEAR_SHARD_CELLS", 10)
    path = feeder(tmp_path, PACKS)
    axes: dict[str, Any] = {"filling_kg": "0:3:9", "natural_hz": [47.6, 55.6], "setting_percent": "50:90:3"}
    held = vibro.sweep(path, **axes)
    for sweep in (vibro.write_sweep(tmp_path / "one", path, **axes), vibro.open_sweep(tmp_path / "one")):
        assert sweep.to_frame().equals(held.to_frame())
        assert sweep.fixed["voltage_percent"] == 100.0
    assert len([*(tmp_path / "one").glob("*.parquet")]) == 6
    cells, grid = np.array([5, 44, 53]), held._grid
    picked, whole = grid.picked(cells)["amplitude"], grid.values()["amplitude"]
    np.testing.assert_array_equal(picked, whole.ravel()[cells])


def test_the_speed_with_the_second_harmonic_is_told_where_it_is_named(tmp_path: Path) -> None:
    t = vibro.sweep(feeder(tmp_path, "gap_mm = 0.6\n"), filling_kg=[0, 2], setting_percent=[50, 80, 200])
    names = ["status", "mean_velocity_mm_s", "mean_velocity_with_second_harmonic_mm_s"]
    status, sine, bent = (t.to_frame(names)[name].to_numpy() for name in names)
    assert status.tolist() == ["ok", "ok"] * 2 + ["infeasible"] * 2
    np.testing.assert_allclose(bent[[0, 2]], sine[[0, 2]], rtol=1e-9)  # of an empty trough
    assert ((bent / sine)[[1, 3]] > 1.001).all()
    assert np.isnan(bent[4:]).all()
    assert names[2] not in t.to_frame()


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
