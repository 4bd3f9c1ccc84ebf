"""Branch and bound: boxes that cover a box, in the order of a heap, within a budget; compiled and plain."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import pytest
from helpers.cases import each
from helpers.solver_boxes import box_of, largest_speed, solver_boxes
from helpers.solver_doors import compiled, plain
from hypothesis import given

from vibro.core.boxes import AXES, Box, Cover, cover, least_speed, speed_at

LOW = [1.3, 0.33, 0.0, 0.0, 0.0, 0.6, 0.45]
HIGH = [1.5, 0.37, 0.0, 0.0, 0.03, 0.8, 0.6]
BOXES = {
    "line": box_of(LOW, HIGH, ratio_low=0.7, ratio_high=0.8),
    "fastest": box_of(LOW, HIGH, ratio_low=0.7, ratio_high=0.8, way=-1.0),
    "ellipse": box_of(
        [1250.0, 1e-3, 3e-4, -0.6, 0.0, 0.35, 0.3], [1300.0, 1e-3, 4e-4, -0.4, 0.0, 0.4, 0.3], ellipse=True
    ),
    "continuous sliding": box_of([2.7, 0.2, 0, 0, 0, 0.18, 0.15], [2.7, 0.2, 0, 0, 0, 0.2, 0.16]),
}


def room(most: int, speed: float = math.inf) -> Cover:
    ends: Any = [0.0] * AXES * most
    others: Any = [0.0] * most, [0] * most, [0.0] * 2 * AXES, [speed]
    return Cover(ends, ends.copy(), *others)


class Covered(NamedTuple):
    low: Any
    high: Any
    bound: Any
    heap: Any
    point: Any
    speed: float


def covered(box: Box, most: int, gap: float = 1e-3, least: float = 0.0, speed: float = math.inf) -> Covered:
    out = room(most, speed)
    count = cover(box, out, gap, least, most)
    low, high = (np.array(x[: AXES * count]).reshape(count, AXES) for x in (out.low, out.high))
    return Covered(low, high, np.array(out.bound[:count]), out.heap[:count], out.point[:AXES], out.speed[0])


def volume(low: Any, high: Any, box: Box) -> Any:
    width = np.array(box.high) - np.array(box.low)
    return np.prod(((high - low) / np.where(width > 0.0, width, 1.0))[:, width > 0.0], axis=1)


@each("name", BOXES)
@each("most", [1, 2, 3, 60])
def test_boxes_fill_the_box(name: str, most: int) -> None:
    """Disjoint, of the whole volume; each with a bound that is its own, or that of a box around it."""
    box = BOXES[name]
    found = covered(box, most)
    count = len(found.bound)
    assert count == most or found.bound.min() >= found.speed * (1.0 - 1e-3)
    assert volume(found.low, found.high, box).sum() == pytest.approx(1.0, rel=1e-12)
    apart = (found.low[:, None] >= found.high) | (found.high[:, None] <= found.low)
    apart &= np.array(box.high) > np.array(box.low)
    assert np.all(apart.any(axis=2) | np.eye(count, dtype=bool))
    own = [least_speed(box, found.low.ravel(), found.high.ravel(), row) for row in range(count)]
    assert np.all(found.bound >= np.array(own))
    assert np.all(found.bound <= np.maximum(own, found.bound.min()) + 2e-5 * largest_speed(box))
    assert found.bound.min() >= least_speed(box, box.low, box.high, 0)


@pytest.mark.parametrize("name", BOXES)
def test_the_first_of_the_heap_has_the_least_bound(name: str) -> None:
    for most in (1, 2, 3, 60):
        found = covered(BOXES[name], most, gap=0.0)
        assert sorted(found.heap) == list(range(len(found.bound)))
        assert found.bound[found.heap[0]] == found.bound.min()
        for i in range(1, len(found.heap)):
            assert found.bound[found.heap[(i - 1) // 2]] <= found.bound[found.heap[i]]


@pytest.mark.parametrize("name", BOXES)
def test_the_slowest_body_that_is_met_is_one_of_the_box(name: str) -> None:
    box = BOXES[name]
    found = covered(box, 60)
    assert found.speed == speed_at(box, found.point, 0)
    assert np.all((np.array(box.low) <= found.point) & (found.point <= np.array(box.high)))
    middles = [speed_at(box, 0.5 * (low + high), 0) for low, high in zip(found.low, found.high, strict=True)]
    assert found.speed <= np.nanmin(middles)
    assert covered(box, 20, speed=-9.0).speed == -9.0  # a slower one that is known stays


@pytest.mark.parametrize(("gap", "least"), [(1e-1, 0.0), (3e-2, 0.0), (2e-2, 1.0)])
def test_boxes_are_divided_until_the_gap_is_closed(gap: float, least: float) -> None:
    found = covered(BOXES["line"], 8000, gap, least)
    closed = found.speed - gap * max(abs(found.speed), least)
    assert found.bound.min() >= closed
    if len(found.bound) > 1:  # the last step was needed
        before = covered(BOXES["line"], len(found.bound) - 1, gap, least)
        assert before.bound.min() < before.speed - gap * max(abs(before.speed), least)


def test_narrower_gaps_take_more_boxes() -> None:
    counts = [len(covered(BOXES["line"], 8000, gap).bound) for gap in (1e-1, 6e-2, 3e-2)]
    assert 1 <= counts[0] < counts[1] < counts[2] < 8000


def test_a_box_without_width_is_not_divided() -> None:
    box = box_of([2.7, 0.2, 0.0, 0.0, 0.0, 0.2, 0.15])
    assert len(covered(box, 50, gap=0.0, speed=1.0).bound) == 1


def test_the_axis_whose_width_costs_most_is_divided() -> None:
    """A body that never rests does not know its static friction."""
    box = box_of([2.7, 0.2, 0.0, 0.0, 0.0, 0.18, 0.15], [2.7, 0.2, 0.0, 0.0, 0.0, 0.2, 0.16])
    found = covered(box, 2, gap=0.0)
    assert found.high[0, 5] == found.high[1, 5] == 0.2
    assert found.high[0, 6] == found.low[1, 6] == pytest.approx(0.155)


@given(solver_boxes())
def test_no_body_that_is_met_is_slower_than_the_bounds(box: Box) -> None:
    found = covered(box, 12)
    if math.isfinite(found.speed):
        assert found.bound.min() <= found.speed + 1e-14 * largest_speed(box)


@pytest.mark.parametrize("name", BOXES)
def test_compiled_and_plain_bounds_have_the_same_bits(name: str) -> None:
    box, most, found = BOXES[name], 60, []
    for kind in (compiled, plain):
        with kind() as solver:
            low, high, lows, highs, bounds, heap, met, speed = arrays = [
                np.array(box.low), np.array(box.high), *np.zeros((2, most, AXES)), *np.zeros((2, most)),
                np.zeros(2 * AXES), np.array([math.inf]),
            ]  # fmt: skip
            rows = [solver.row(x) for x in (low, high)]
            room = tuple(map(solver.row, (lows, highs, bounds, heap.view(np.int64), met, speed)))
            count = solver.cover((*rows, *box[2:]), room, 1e-3, 0.0, most)
            found.append([count, *(x.tobytes() for x in arrays)])
    assert found[0] == found[1]
