"""Pictures that show cells of the table where motion is irregular: which, and that all others are solved."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import vibro
from vibro.core.codes import Output
from vibro.plots import choose_view, map_figures
from vibro.sweeps.grid import Grid
from vibro.sweeps.run import DrawnCells, sweep_blocks, sweep_picture
from vibro.sweeps.whole import request_of_call

NUT: dict[str, Any] = {"drive_angle_deg": 20, "static_friction": 0.74, "kinetic_friction": 0.57}
MAP: dict[str, Any] = {"amplitude_mm": "0.1:3:35", "frequency_hz": "5:60:45:log", **NUT, "restitution": 0.5}


def grid_of(*, coexistence: bool = False, flight: bool = True, **given: Any) -> Grid:
    return request_of_call(None, given).grid(Output.EXACT, flight=flight, coexistence=coexistence)


def cells_of(grid: Grid) -> DrawnCells | None:
    cells = DrawnCells.of(grid, choose_view(grid.axes, fixed=grid.fixed).drawn)
    for block in sweep_blocks(grid) if cells else ():
        assert cells is not None
        cells.add(block)
    return cells


@pytest.mark.parametrize(
    ("changes", "takes_some"),
    [
        ({}, True),
        ({"restitution": 0}, False),  # nothing bounces: a picture costs milliseconds
        ({"amplitude_mm": "0.1:3:24"}, False),  # too coarse
        ({"frequency_hz": 20}, False),  # a line
        ({"flight": False}, False),
        ({"amplitude_mm": "0.1:3:20", "restitution": [0.2, 0.5]}, True),  # facets are smaller
        ({"amplitude_mm": "0.1:3:19", "restitution": [0.2, 0.5]}, False),
        ({"amplitude_mm": "1:3:25", "frequency_hz": "20:22:25", "restitution": 0, "coexistence": True}, True),
    ],
)
def test_the_grid_alone_decides_whether_cells_of_the_table_are_fine_enough(
    changes: dict[str, Any], takes_some: bool
) -> None:
    grid = grid_of(**{**MAP, **changes})
    cells = DrawnCells.of(grid, choose_view(grid.axes, fixed=grid.fixed).drawn)
    assert (cells is not None) == takes_some


def test_a_picture_shows_the_table_amid_irregular_motion_and_is_exact_elsewhere(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("vibro.sweeps.run._RESOLVED", {2: 81})
    grid = grid_of(**MAP)
    (block,) = sweep_blocks(grid)
    result = sweep_picture(grid, {}, None, "", cells_of(grid))
    anew = sweep_picture(grid, {}, None, "")
    assert result.shape == anew.shape > grid.shape
    own = {
        name: axis.values.reshape([-1, 1][:: 1 - 2 * i]) for i, (name, axis) in enumerate(anew.axes.items())
    }
    taken = np.logical_or.reduce([result.places[name] != own[name] for name in own])
    assert 0.2 < taken.mean() < 0.6
    for name, values in result.cycle.arrays().items():
        np.testing.assert_array_equal(values[~taken], getattr(anew.cycle, name)[~taken], err_msg=name)
    # Regimes and loads of the taken are still their own; the rest is that of the cell of the table.
    for name in ("regime", "throw_number", "forward_ratio", "back_ratio"):
        np.testing.assert_array_equal(getattr(result.cycle, name), getattr(anew.cycle, name))
    row, column = (
        np.searchsorted(axis.values, result.places[name][taken]) for name, axis in grid.axes.items()
    )
    for name in ("mean_velocity", "mean_velocity_error", "flight_fraction", "status", "period_cycles"):
        np.testing.assert_array_equal(
            getattr(result.cycle, name)[taken], getattr(block.cycle, name)[row, column], err_msg=name
        )
    # The nearest on paper, of axes of which one is logarithmic.
    for name, axis in grid.axes.items():
        on_paper = np.log if axis.spacing == "log" else np.asarray
        off = np.abs(on_paper(result.places[name]) - on_paper(own[name]))
        assert off.max() <= 0.5001 * np.diff(axis.on_paper).max()


def test_the_fastest_is_marked_where_it_was_solved(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vibro.sweeps.run._RESOLVED", {2: 201})
    grid = grid_of(**MAP)
    figure = map_figures(sweep_picture(grid, {}, None, "", cells_of(grid)), ["speed"])["speed"]
    marks = {line.get_gid(): line for line in figure.axes[0].lines}
    for name in ("fastest", "fastest_backwards"):
        ((frequency, amplitude),) = np.column_stack(marks[name].get_data())
        cycle = vibro.solve(
            vibro.Scene(
                amplitude=1e-3 * amplitude, frequency=frequency, drive_angle=np.radians(20),
                static_friction=0.74, kinetic_friction=0.57, restitution=0.5,
            )
        )  # fmt: skip
        assert f"{1e3 * abs(cycle.mean_velocity):.5g} mm/s" in str(marks[name].get_label())


def test_other_motions_are_searched_for_in_the_table_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    changes = {"amplitude_mm": "0.5:3:25", "frequency_hz": "15:40:25", "restitution": 0}
    monkeypatch.setattr("vibro.sweeps.run._RESOLVED", {2: 81})
    grid = grid_of(**{**MAP, **changes}, coexistence=True)
    (block,) = sweep_blocks(grid)
    cells = cells_of(grid)
    solved: list[bool] = []
    solve = Grid.solve

    def watched(self: Grid, *args: Any, **more: Any) -> vibro.SteadyCycle:
        solved.append(self.coexistence)
        return solve(self, *args, **more)

    monkeypatch.setattr(Grid, "solve", watched)
    result = sweep_picture(grid, {}, None, "", cells)
    assert solved
    assert not any(solved)
    hops = result.cycle.regime == vibro.Regime.HOPPING
    assert (result.cycle.coexists[hops] >= 0).mean() > 0.95  # all but a margin of the hop limit
    for corner in ((0, -1), (-1, 0), (-1, -1)):
        assert result.cycle.coexists[corner] == block.cycle.coexists[corner]


def test_facets_take_cells_of_their_own_value(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vibro.sweeps.run._RESOLVED", {3: 41})
    grid = grid_of(**{**MAP, "amplitude_mm": "1:3:20", "frequency_hz": "25:60:20", "restitution": [0.4, 0.7]})
    drawn = choose_view(grid.axes).drawn
    result = sweep_picture(grid, drawn, None, "", cells_of(grid))
    (block,) = sweep_blocks(grid)
    corner = result.cycle.mean_velocity[-1, -1]
    np.testing.assert_array_equal(corner, block.cycle.mean_velocity[-1, -1])
    for facet in range(2):
        seen = result.cycle.mean_velocity[..., facet]
        means = seen[result.cycle.status[..., facet] == vibro.Status.AVERAGED]
        assert np.isin(means, block.cycle.mean_velocity[..., facet]).mean() > 0.7
        assert not np.isin(means, block.cycle.mean_velocity[..., 1 - facet]).any()


def test_progress_is_told_up_to_the_end() -> None:
    grid = grid_of(**{**MAP, "amplitude_mm": "0.1:3:5", "restitution": 0})
    told: list[tuple[int, int]] = []
    sweep_picture(grid, {}, None, "", progress=lambda done, size: told.append((done, size)))
    assert told[-1][0] == told[-1][1]
    assert len(told) > 2
