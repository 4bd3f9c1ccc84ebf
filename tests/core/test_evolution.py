"""Differential evolution: the slowest body of a box among known ones; compiled and plain."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from helpers.solver_boxes import box_of
from helpers.solver_doors import compiled, plain

from vibro.core.boxes import AXES, Box, Population, evolve, speed_at

SIZE = 32
LOW = [1.0, 0.33, 0.0, 0.0, 0.0, 0.6, 0.45]
HIGH = [1.5, 0.37, 0.0, 0.0, 0.03, 0.8, 0.6]
LINE = box_of(LOW, HIGH, ratio_low=0.7, ratio_high=0.8)
OVAL = box_of(
    [1250.0, 1e-3, 3e-4, -0.6, 0.0, 0.35, 0.3], [1300.0, 1e-3, 4e-4, -0.4, 0.0, 0.4, 0.3], ellipse=True
)


def first(box: Box, size: int = SIZE) -> Any:
    """A population within a box, and room for one more."""
    shares = np.random.default_rng(0).random((size + 1, AXES))
    return np.array(box.low) + shares * (np.array(box.high) - np.array(box.low))


def evolved(box: Box, points: Any, generations: int, seed: int = 1) -> tuple[int, Any, Any]:
    rows: Any = points.ravel().tolist()
    speeds: Any = [0.0] * len(points)
    population = Population(rows, speeds)
    best = evolve(box, population, len(points) - 1, generations, seed)
    return best, np.array(population.points).reshape(-1, AXES)[:-1], np.array(population.speeds)[:-1]


@pytest.mark.parametrize(("box", "way"), [(LINE, 1.0), (OVAL, -1.0)])
def test_the_slowest_of_a_dense_grid_is_found(box: Box, way: float) -> None:
    box = box._replace(way=way)
    best, points, speeds = evolved(box, first(box), 150)
    assert speeds[best] == speeds.min()
    assert speeds[best] == speed_at(box, points[best], 0)
    shares = np.random.default_rng(1).random((2000, AXES))
    shares = np.clip(1.5 * shares - 0.25, 0.0, 1.0)
    grid = np.array(box.low) + shares * (np.array(box.high) - np.array(box.low))
    assert speeds[best] <= min(speed_at(box, x, 0) for x in grid) + 1e-9


@pytest.mark.parametrize("generations", [0, 1, 5, 40])
def test_bodies_stay_within_their_bands_and_only_get_slower(generations: int) -> None:
    points = first(LINE)
    best, after, speeds = evolved(LINE, points, generations)
    assert np.all((after >= np.array(LINE.low)) & (after <= np.array(LINE.high)))
    begun = np.array([speed_at(LINE, x, 0) for x in points[:-1]])
    assert np.all(speeds <= begun)
    assert speeds[best] == speeds.min()
    assert np.array_equal(speeds, [speed_at(LINE, x, 0) for x in after])
    assert np.array_equal(after, points[:-1]) is (generations == 0)


def test_coordinates_without_a_width_are_kept() -> None:
    _, after, _ = evolved(OVAL, first(OVAL), 20)
    fixed = np.array(OVAL.low) == np.array(OVAL.high)
    assert np.all(after[:, fixed] == np.array(OVAL.low)[fixed])


def test_a_search_ends_where_all_are_the_slowest() -> None:
    """Bodies at rest: none is tried."""
    box = box_of([0.1, *LOW[1:]], [0.2, *HIGH[1:]])
    points = first(box)
    best, after, speeds = evolved(box, points, 10**9)
    assert (best, speeds.max()) == (0, 0.0)
    assert np.array_equal(after, points[:-1])


def test_bodies_that_hop_are_passed_over() -> None:
    box = box_of(LOW, [4.0, *HIGH[1:]])
    points = first(box)
    points[0, 0] = 4.0
    assert math.isnan(speed_at(box, points[0], 0))
    best, after, speeds = evolved(box, points, 60)
    assert math.isfinite(speeds[best])
    assert not math.isnan(speeds.sum())
    best, _, speeds = evolved(box_of([3.5, *LOW[1:]], [4.0, *HIGH[1:]]), first(box) + 2.5, 3)
    assert np.all(np.isinf(speeds))
    assert len(after) == SIZE


def test_the_same_seed_finds_the_same_and_another_one_others() -> None:
    once, again, other = (evolved(LINE, first(LINE), 10, seed) for seed in (1, 1, 2))
    assert np.array_equal(once[1], again[1])
    assert not np.array_equal(once[1], other[1])


@pytest.mark.parametrize("box", [LINE, OVAL, LINE._replace(way=-1.0)])
def test_compiled_and_plain_searches_have_the_same_bits(box: Box) -> None:
    found = []
    for kind in (compiled, plain):
        with kind() as solver:
            low, high, points, speeds = (
                np.array(box.low), np.array(box.high), first(box), np.zeros(SIZE + 1),
            )  # fmt: skip
            scene = solver.row(low), solver.row(high), *box[2:]
            best = solver.evolve(scene, (solver.row(points), solver.row(speeds)), SIZE, 40, 1)
            found.append((best, points.tobytes(), speeds.tobytes()))
    assert found[0] == found[1]
