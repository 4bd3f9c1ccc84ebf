"""Sweeps: rows in the order of the axes, whatever the blocks; the part that pictures show."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from helpers.scenes import NUT_POINT

import vibro.sweeps.run
from vibro.axes import parse_axis
from vibro.quantities import QUANTITIES
from vibro.sweeps.grid import Grid
from vibro.sweeps.run import sweep_blocks, sweep_picture


def grid_of(**texts: str) -> Grid:
    axes = {name: parse_axis(text, QUANTITIES[name]).axis(5) for name, text in texts.items()}
    fixed = {name: value for name, value in NUT_POINT.items() if name not in axes}
    if "friction_ratio" in axes:
        del fixed["kinetic_friction"]
    return Grid(axes, fixed, None)


def cells_of(grid: Grid, name: str) -> np.ndarray:
    return np.concatenate(
        [np.broadcast_to(block.values[name], block.shape).ravel() for block in sweep_blocks(grid)]
    )


@pytest.mark.parametrize("cells", [1, 7, 10**6])
def test_rows_come_in_the_order_of_the_axes_whatever_the_blocks(
    monkeypatch: pytest.MonkeyPatch, cells: int
) -> None:
    monkeypatch.setattr(vibro.sweeps.run, "_BLOCK", cells)
    grid = grid_of(amplitude="0.5:1.5:3", frequency="10:16:4", static_friction="0.6:0.9:5")
    expected = list(itertools.product(*(axis.values for axis in grid.axes.values())))
    found = list(zip(*(cells_of(grid, name) for name in grid.axes), strict=True))
    assert found == expected
    speeds = [block.cycle.mean_velocity.ravel() for block in sweep_blocks(grid)]
    assert max(map(len, speeds)) <= cells
    monkeypatch.undo()
    (whole,) = sweep_blocks(grid)
    np.testing.assert_array_equal(np.concatenate(speeds), whole.cycle.mean_velocity.ravel())


def test_a_picture_shows_the_chosen_slice_of_the_same_numbers() -> None:
    grid = grid_of(
        amplitude="0.5:1.5:3", frequency="10:16:4", drive_angle="10,20,30", static_friction="0.6,0.9"
    )
    result = sweep_picture(grid, {"drive_angle": (0, 2), "static_friction": (1,)}, None, "title")
    assert list(result.axes) == ["amplitude", "frequency", "drive_angle"]
    assert result.fixed["static_friction"] == 0.9
    assert list(result.axes["drive_angle"].values) == [10, 30]
    (block,) = sweep_blocks(grid)
    corners = np.ix_([0, -1], [0, -1])
    np.testing.assert_array_equal(
        result.cycle.mean_velocity[corners], block.cycle.mean_velocity[:, :, ::2, 1][corners]
    )
    assert result.limits is not None
    assert result.limits.hop.shape == (1, 1, 2)
    assert result.operating_point is None


@pytest.mark.parametrize(
    "axes", [("amplitude",), ("amplitude", "frequency"), ("amplitude", "frequency", "drive_angle")]
)
def test_a_picture_has_a_resolution_of_its_own(axes: tuple[str, ...]) -> None:
    texts = {"amplitude": "0.5:1.5:9001", "frequency": "10:16:4:log", "drive_angle": "10, 20"}
    grid = grid_of(**{name: texts[name] for name in axes})
    drawn = {"drive_angle": (0, 1)} if "drive_angle" in axes else {}
    result = sweep_picture(grid, drawn, NUT_POINT, "")
    assert 10_000 > result.shape[0] > 100
    for name, axis in result.axes.items():
        ends, known = (a.values[[0, -1]].tolist() for a in (axis, grid.axes[name]))
        assert ends == pytest.approx(known, rel=1e-15)
    if "frequency" in axes:  # a logarithmic axis has even steps on it
        assert np.ptp(np.diff(np.log(result.axes["frequency"].values))) < 1e-12
    assert result.operating_point == {name: NUT_POINT[name] for name in axes}
    assert sweep_picture(grid, drawn, {"frequency": 1.0}, "").operating_point is None


def test_a_picture_of_curves_keeps_the_values_of_the_list() -> None:
    grid = grid_of(amplitude="0.5:1.5:3", frequency="10,12.5,16", drive_angle="10, 20")
    result = sweep_picture(grid, {"frequency": (0, 1, 2), "drive_angle": (1,)}, None, "")
    assert result.axes["frequency"].values.tolist() == [10, 12.5, 16]
    assert 2_000 > result.shape[0] > 500
