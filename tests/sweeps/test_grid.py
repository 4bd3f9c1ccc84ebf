"""Grids: the quantities of cells in a row are those of the box, and their solution leaves no seam."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
from helpers.scenes import FIELDS, NUT_POINT
from hypothesis import given
from hypothesis import strategies as st

from vibro.axes import Axis
from vibro.core.codes import Regime, Status
from vibro.sweeps.grid import Grid

if TYPE_CHECKING:
    from numpy.typing import NDArray

# as far apart as the axes of a grid can be, and in another order than theirs
NAMES = ("amplitude", "static_friction", "frequency", "friction_ratio", "trough_angle")


def grid_of(**values: list[float] | NDArray[np.float64]) -> Grid:
    axes = {name: Axis(name, np.asarray(x, float), "list") for name, x in values.items()}
    fixed = {name: value for name, value in NUT_POINT.items() if name not in axes}
    return Grid(axes, fixed, None)


def with_ratio(grid: Grid) -> Grid:
    """Give the kinetic friction by its ratio, as an axis or as one value."""
    fixed = {name: value for name, value in grid.fixed.items() if name != "kinetic_friction"}
    if "friction_ratio" not in grid.axes:
        fixed["friction_ratio"] = 0.77
    return Grid(grid.axes, fixed, None)


def shaped(shape: tuple[int, ...]) -> Grid:
    """Make a grid of a shape, whose axes are of any quantities."""
    first = {"amplitude": 0.5, "static_friction": 0.2, "frequency": 10.0, "friction_ratio": 0.1}
    axes = {
        name: first.get(name, 0.0) + np.arange(length) / 8.0
        for name, length in zip(NAMES, shape, strict=False)
    }
    return with_ratio(grid_of(**axes))


@given(st.lists(st.integers(1, 12), max_size=5), st.data())
def test_every_range_of_cells_is_that_of_the_box(shape: list[int], data: st.DataObject) -> None:
    """Bit by bit."""
    grid = shaped(tuple(shape))
    start = data.draw(st.integers(0, grid.size - 1))
    stop = data.draw(st.integers(start + 1, grid.size))
    cells, whole = grid.cells(start, stop), grid.values()
    assert list(cells) == list(whole)
    for name, x in whole.items():
        expected = np.broadcast_to(x, grid.shape).ravel()[start:stop]
        np.testing.assert_array_equal(np.broadcast_to(cells[name], expected.shape), expected, err_msg=name)


def test_cells_of_a_grid_that_nobody_could_hold() -> None:
    long = np.arange(1.0, 1_000_001.0)
    grid = grid_of(amplitude=long, frequency=long, static_friction=[0.5, 0.7])
    cells = grid.cells(grid.size - 5, grid.size)
    assert cells["amplitude"].tolist() == [1e6] * 5
    assert cells["frequency"].tolist() == [999_998.0, 999_999.0, 999_999.0, 1e6, 1e6]
    assert cells["static_friction"].tolist() == [0.7, 0.5, 0.7, 0.5, 0.7]


@pytest.mark.parametrize("step", [7, 50])
def test_cells_solved_in_ranges_leave_no_seam(step: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vibro.sweeps.grid._LEAST_ROW", 2)
    monkeypatch.setattr("vibro.sweeps.grid._LEAST_ROWS", 3)
    lines = with_ratio(
        grid_of(
            amplitude=np.linspace(0.3, 9.0, 6),
            drive_angle=[20.0, 40.0],
            friction_ratio=[0.6, 0.8, 1.2],
            trough_angle=[-3.0, 5.0],
            restitution=[0.0, 0.3],
        )
    )
    moved = {
        "along_amplitude_2": Axis("along_amplitude_2", np.array([0.0, 0.2]), "list"),
        "normal_amplitude": Axis("normal_amplitude", np.array([0.1, 1.0, 3.0]), "list"),
    }
    axes = {name: lines.axes[name] for name in ("friction_ratio", "trough_angle")} | moved
    one = {"along_amplitude": 1.0, "normal_phase": 40.0, "restitution": 0.0}
    harmonics = Grid(axes, {**lines.fixed, **one}, None)
    seen: set[tuple[int, int]] = set()
    rows = {grid._row(step) for grid in (lines, harmonics)}
    assert rows == {7: {0, 1}, 50: {3}}[step]
    for grid in (lines, harmonics):
        whole = grid.solve(grid.values())
        for start in range(0, grid.size, step):
            stop = min(start + step, grid.size)
            part = grid.solve(grid.cells(start, stop), threads=1)
            _, by_rows = grid.solve_cells(start, stop, threads=1)
            for name in FIELDS:
                expected = getattr(whole, name).ravel()[start:stop]
                found = np.broadcast_to(getattr(part, name), expected.shape)
                np.testing.assert_array_equal(found, expected, err_msg=name, strict=True)
                np.testing.assert_array_equal(getattr(by_rows, name), expected, err_msg=name, strict=True)
        seen |= set(zip(whole.regime.ravel().tolist(), whole.status.ravel().tolist(), strict=True))
    assert {regime for regime, _ in seen} == set(Regime)
    assert {status for _, status in seen} >= {Status.OK, Status.AVERAGED, Status.INFEASIBLE}
