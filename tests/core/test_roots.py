"""Bisection, and the loop over the cells that are still open."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray
from vibro.core.roots import OpenCells, bisect

Floats = NDArray[np.float64]


def test_bisection_ends_an_ulp_from_the_root_whichever_way_the_function_goes() -> None:
    low, high = np.zeros(3), np.array([4.0, 20.0, 7.0])
    roots = np.array([math.pi, 13.0, 0.25])
    falling = bisect(lambda x: roots - x, low, high)
    assert falling == pytest.approx(roots, rel=2.0**-52)
    rises = np.array([True, False, True])
    either = bisect(lambda x: np.where(rises, x - roots, roots - x), low, high, rises=rises)
    assert either == pytest.approx(roots, rel=2.0**-52)


class Pair(NamedTuple):
    one: Floats
    two: Floats


def test_each_pass_sees_the_open_cells_and_what_belongs_to_them() -> None:
    pair = Pair(np.array([10.0, 20.0, 30.0]), np.array(5.0))
    cells = OpenCells(np.array([7, 8, 9]), (pair, np.array([3.0, 1.0, 2.0])), most=10)
    seen = []
    for open_, (numbers, left) in cells:
        seen.append((open_.tolist(), numbers.one.tolist(), float(numbers.two)))
        cells.keep(left > 1.0, (numbers, left - 1.0))
    assert seen == [([7, 8, 9], [10.0, 20.0, 30.0], 5.0), ([7, 9], [10.0, 30.0], 5.0), ([7], [10.0], 5.0)]
    assert cells.cells.size == 0


def test_cells_that_are_open_after_the_last_pass_are_left() -> None:
    cells = OpenCells(np.arange(4), (np.zeros(4),), most=3)
    passes = 0
    for open_, _ in cells:
        passes += 1
        cells.keep(open_ % 2 == 1)
    assert passes == 3
    assert cells.cells.tolist() == [1, 3]


def test_nothing_is_copied_as_long_as_no_cell_is_closed() -> None:
    numbers = np.arange(3.0)
    cells = OpenCells(np.arange(3), (numbers,), most=2)
    for _, (same,) in cells:
        assert same is numbers
        cells.keep(np.ones(3, np.bool_))


def test_no_pass_is_made_without_cells() -> None:
    for _ in OpenCells(np.arange(0), (np.zeros(0),), most=5):
        pytest.fail("nothing is open")
