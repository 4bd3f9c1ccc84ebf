"""Pictures that show cells of the table where these are dear to solve."""

from __future__ import annotations

from typing import Any

import numpy as np
from helpers.cases import each

from vibro.core.codes import Output
from vibro.plots.view import choose_view
from vibro.sweeps.grid import Grid
from vibro.sweeps.run import DrawnCells, solved_picture, sweep_blocks
from vibro.sweeps.whole import request_of_call

NUT: dict[str, Any] = {"drive_angle_deg": 20, "static_friction": 0.74, "kinetic_friction": 0.57}
MAP: dict[str, Any] = {"amplitude_mm": "0.1:3:35", "frequency_hz": "5:60:45:log", **NUT, "restitution": 0.5}


def grid_of(*, starts: int | None = None, flight: bool = True, **given: Any) -> Grid:
    return request_of_call(None, given).grid(Output.EXACT, flight=flight, starts=starts)


@each(
    ("changes", "takes_some"),
    [
        ({"restitution": 0}, False),  # nothing bounces: a picture costs milliseconds
        ({"amplitude_mm": "0.1:3:24"}, False),  # too coarse
        ({"frequency_hz": 20}, False),  # a line
        ({"flight": False}, False),
        ({"amplitude_mm": "0.1:3:20", "restitution": [0.2, 0.5]}, True),  # facets are smaller
        ({"amplitude_mm": "0.1:3:19", "restitution": [0.2, 0.5]}, False),
        ({"amplitude_mm": "1:3:25", "frequency_hz": "20:22:25", "restitution": 0, "starts": 16}, True),
    ],
)
def test_the_grid_alone_decides_whether_cells_of_the_table_are_fine_enough(
    changes: dict[str, Any], takes_some: bool
) -> None:
    grid = grid_of(**{**MAP, **changes})
    cells = DrawnCells.of(grid, choose_view(grid.axes, fixed=grid.fixed).drawn)
    assert (cells is not None) == takes_some


def test_a_picture_shows_the_cells_of_the_table() -> None:
    changes = {"amplitude_mm": "1:3:20", "frequency_hz": "25:60:20:log", "restitution": [0.4, 0.7]}
    grid = grid_of(**{**MAP, **changes})
    drawn = choose_view(grid.axes, fixed=grid.fixed).drawn
    cells = DrawnCells.of(grid, drawn)
    assert cells is not None
    for block in sweep_blocks(grid):
        cells.add(block)
    result = solved_picture(grid, drawn, None, "", ["speed"], cells.results)
    whole = grid.solve(grid.values())
    for name in ("regime", "mean_velocity", "mean_velocity_error", "status"):
        np.testing.assert_array_equal(getattr(result.cycle, name), getattr(whole, name), err_msg=name)
