"""Scenes read cell by cell, and the ranges of cells that are run."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
from helpers.scenes import loads_of
from helpers.solver_doors import plain

from vibro import Scene
from vibro.core.compiled import Doors, doors
from vibro.core.scenes import Place, Scenes, point_at, seek
from vibro.threads import Grid, over_cells

if TYPE_CHECKING:
    from collections.abc import Iterator

ANGLES = np.array([[0.1], [0.4], [0.4]])
FRICTIONS = np.linspace(0.3, 0.9, 4)
LINES = Scene(
    amplitude=np.linspace(1e-3, 3e-3, 2)[:, None, None],
    frequency=np.linspace(10.0, 30.0, 3)[:, None],
    drive_angle=ANGLES,
    static_friction=FRICTIONS,
    kinetic_friction=0.5 * FRICTIONS,
    trough_angle=np.array([0.0, 0.1, 0.1, -0.2]),
    gravity=np.full((2, 1, 1), 9.0),
    restitution=np.array([[0.1], [0.2], [0.3]]),
)
ELLIPSES = Scene(
    along_amplitude=np.array([1e-3, 2e-3])[:, None],
    normal_amplitude=np.array([0.0, 3e-4, 5e-3]),
    normal_phase=np.array([[-1.0, -1.0, 2.0]]),
    frequency=25.0,
    static_friction=0.5,
    kinetic_friction=np.array([0.1, 0.2, 0.3]),
    trough_angle=np.array([[0.1], [-0.1]]),
    restitution=0.4,
)
SCENES = pytest.mark.parametrize("scene", [LINES, ELLIPSES], ids=["lines", "ellipses"])


@pytest.fixture(autouse=True)
def _uncompiled() -> Iterator[None]:
    with plain():
        yield


def place_of(grid: Grid) -> Place:
    return Place(*map(doors().row, grid.place()))


def scenes_of(grid: Grid) -> tuple[Scenes, Place]:
    return Scenes(*grid.scenes), place_of(grid)


@SCENES
def test_each_cell_is_the_scene_that_broadcasting_gives(scene: Scene) -> None:
    scenes, place = scenes_of(Grid(scene.arrays()))
    fields = scene.flat()
    scale = np.broadcast_to(scene.scale, scene.shape).ravel()
    for i, loads in enumerate(loads_of(scene)):
        seek(scenes, place, i)
        assert tuple(place.index[: scenes.axes]) == np.unravel_index(i, scene.shape)
        point = point_at(scenes, place)
        assert point.loads == loads
        assert point.scale == scale[i]
        assert point.frequency == fields.frequency[i]
        assert point.restitution == fields.restitution[i]


# ------------------------------------------------------------------------------------------- ranges


@pytest.mark.parametrize(
    ("size", "step", "expected"),
    [(10, 4, [(0, 4), (4, 8), (8, 10)]), (4, 4, [(0, 4)]), (0, 4, []), (9, 4, [(0, 4), (4, 8), (8, 9)])],
)
def test_cells_are_run_in_ranges_with_their_progress(
    size: int, step: int, expected: list[tuple[int, int]]
) -> None:
    ranges, told = [], []
    over_cells(lambda i, j: ranges.append((i, j)), size, step, 1, lambda *now: told.append(now))
    assert ranges == expected
    assert told == [(end, size) for _, end in expected]


def test_the_plain_solver_runs_in_one_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    threads: list[int | None] = []
    monkeypatch.setattr("vibro.threads.in_parallel", lambda run, parts, number, tell: threads.append(number))
    over_cells(lambda i, j: None, 9, 4, 3)
    found = Doors(None)
    found.compiled = True
    monkeypatch.setattr("vibro.threads.doors", lambda: found)
    over_cells(lambda i, j: None, 9, 4, 3)
    assert threads == [1, 3]
