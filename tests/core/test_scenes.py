"""Scenes read cell by cell: broadcast fields and places."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from helpers.scenes import loads_of
from helpers.solver_doors import plain

from vibro import Scene
from vibro.core.compiled import Doors, doors
from vibro.core.drive import ellipse_scale
from vibro.core.numbers import HARMONICS
from vibro.core.scenes import Place, Scenes, advance, point_at, seek, unit_point_at, visit
from vibro.drives import Harmonics
from vibro.threads import Grid, Scratch, over_cells

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


@SCENES
def test_advancing_leads_to_the_next_cell(scene: Scene) -> None:
    grid = Grid(scene.arrays())
    scenes, place = scenes_of(grid)
    sought = place_of(grid)
    for begin in (0, 1, 5):
        seek(scenes, place, begin)
        for i in range(begin + 1, grid.size):
            advance(scenes, place)
            seek(scenes, sought, i)
            assert place.index.tolist() == sought.index.tolist()


def test_one_axis_and_no_axis() -> None:
    line = Scene(amplitude=[1e-3, 2e-3, 4e-3], frequency=20.0, drive_angle=0.3, static_friction=0.5,
                 kinetic_friction=0.4)  # fmt: skip
    for scene in (line, Scene(**{f: getattr(line, f) for f in line.arrays()._fields} | {"amplitude": 2e-3})):
        grid = Grid(scene.arrays())
        scenes, place = scenes_of(grid)
        assert grid.shape == scene.shape
        assert grid.size == math.prod(scene.shape)
        seek(scenes, place, 0)
        for i, loads in enumerate(loads_of(scene)):
            if i:
                advance(scenes, place)
            assert point_at(scenes, place).loads == loads


def test_a_grid_without_cells() -> None:
    scene = Scene(amplitude=np.zeros((0, 3)) + 1.0, frequency=20.0, drive_angle=[0.3, 0.4, 0.5],
                  static_friction=0.5, kinetic_friction=0.4)  # fmt: skip
    assert (Grid(scene.arrays()).shape, Grid(scene.arrays()).size) == ((0, 3), 0)


def test_cells_of_harmonics_have_the_waves_of_their_scenes() -> None:
    sizes, phases = np.array([1e-3, 2e-3, 5e-4])[:, None], np.array([0.3, -2.0])
    along: Any = [(sizes, 0.1), (2e-4, phases)]
    normal: Any = [(0.0, 0.0), (3e-4, -phases)]
    scene = Scene(
        along_harmonics=along, normal_harmonics=normal,
        frequency=20.0, static_friction=0.5, kinetic_friction=[0.4, 0.3],
    )  # fmt: skip
    fields = scene.arrays()
    assert isinstance(fields, Harmonics)
    scenes, place = scenes_of(Grid(fields))
    sought = place_of(Grid(fields))
    assert (scenes.kind, scenes.size) == (HARMONICS, 2)
    for i, (row, column) in enumerate(np.ndindex(3, 2)):
        visit(scenes, place, i, 0)
        seek(scenes, sought, i)
        assert place.index.tolist() == sought.index.tolist()
        point = point_at(scenes, place)
        scale, xi = float(sizes[row, 0]), float(phases[column])
        assert (point.scale, point.loads.kinetic_friction) == (scale, (0.4, 0.3)[column])
        parts = [
            math.cos(0.1), 8e-4 / scale * math.cos(xi), math.sin(0.1), 8e-4 / scale * math.sin(xi),
            0.0, 12e-4 / scale * math.cos(xi), 0.0, -12e-4 / scale * math.sin(xi),
        ]  # fmt: skip
        assert point.loads.waves.number[:8].tolist() == pytest.approx(parts, rel=1e-15, abs=1e-18)
        assert point.loads.drive_normal == pytest.approx(12e-4 / scale, rel=1e-14)


def test_ellipses_at_unit_load_have_a_largest_acceleration_of_gravity() -> None:
    grid = Grid(ELLIPSES.arrays())
    scenes, place = scenes_of(grid)
    phase = np.linspace(0.0, 2.0 * np.pi, 20_001)
    for i, loads in enumerate(loads_of(ELLIPSES)):
        seek(scenes, place, i)
        unit = unit_point_at(scenes, place)
        lead = math.atan2(loads.phase_sine, loads.phase_cosine)
        x = unit.loads.drive_tangential * np.sin(phase)
        y = unit.loads.drive_normal * np.sin(phase + lead)
        assert np.max(np.hypot(x, y)) == pytest.approx(1.0, rel=1e-7)
        n, t = unit.loads.weight_normal, unit.loads.weight_tangential
        assert math.hypot(n, t) == pytest.approx(1.0, rel=1e-15)
        assert t / n == pytest.approx(math.tan(ELLIPSES.trough_angle[i // 3, 0]))
        share = loads.drive_normal / loads.drive_tangential
        assert unit.loads.drive_normal / unit.loads.drive_tangential == pytest.approx(share)
        assert unit.loads[5:] == loads[5:]
        assert unit.scale == ellipse_scale(ELLIPSES.along_amplitude[i // 3, 0], [0.0, 3e-4, 5e-3][i % 3])  # type: ignore[index]
    still = Scene(along_amplitude=0.0, normal_amplitude=0.0, frequency=20.0, static_friction=0.5,
                  kinetic_friction=0.4)  # fmt: skip
    scenes, place = scenes_of(Grid(still.arrays()))
    seek(scenes, place, 0)
    unit = unit_point_at(scenes, place)
    assert (unit.loads.drive_tangential, unit.loads.drive_normal, unit.loads.weight_normal) == (0.0, 0.0, 1.0)


def test_lines_at_unit_load() -> None:
    scenes, place = scenes_of(Grid(LINES.arrays()))
    for i, loads in enumerate(loads_of(LINES)):
        seek(scenes, place, i)
        unit = unit_point_at(scenes, place)
        weight = math.hypot(loads.weight_normal, loads.weight_tangential)
        assert unit.loads[:2] == loads[:2]
        assert unit.loads[2:5] == pytest.approx([x / weight for x in loads[2:5]], rel=1e-14)
        assert unit.loads[5:] == loads[5:]
        assert unit[1:4] == (1.0, 1.0, 0.0)


# ------------------------------------------------------------------------------------------- ranges


def test_cells_are_run_in_ranges_with_their_progress() -> None:
    ranges, told = [], []
    over_cells(lambda i, j: ranges.append((i, j)), 10, 4, 1, lambda done, size: told.append((done, size)))
    assert ranges == [(0, 4), (4, 8), (8, 10)]
    assert told == [(4, 10), (8, 10), (10, 10)]
    ranges.clear()
    over_cells(lambda i, j: ranges.append((i, j)), 4, 4, None)
    assert ranges == [(0, 4)]
    ranges.clear()
    over_cells(lambda i, j: ranges.append((i, j)), 0, 4, None)
    assert ranges == []
    over_cells(lambda i, j: ranges.append((i, j)), 9, 4, None)
    assert ranges == [(0, 4), (4, 8), (8, 9)]


def test_the_plain_solver_runs_in_one_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    threads: list[int | None] = []
    monkeypatch.setattr(
        "vibro.threads.in_parallel", lambda run, parts, number, tell, lasting: threads.append(number)
    )
    over_cells(lambda i, j: None, 9, 4, 3)
    found = Doors(None)
    found.compiled = True
    monkeypatch.setattr("vibro.threads.doors", lambda: found)
    over_cells(lambda i, j: None, 9, 4, 3)
    assert threads == [1, 3]


def test_scratch_memory_has_room_for_all_flights_and_bodies() -> None:
    scratch = Scratch()
    assert len(scratch.flights) == 8
    assert len(scratch.hops) == 8
    assert len({len(row) for row in scratch.flights}) == 1
    assert not doors().compiled
