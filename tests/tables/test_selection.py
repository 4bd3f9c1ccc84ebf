"""Cells at some values of every axis, as numbers of a grid."""

from __future__ import annotations

import numpy as np

from vibro.tables.selection import Selection


def test_cells_are_counted_as_they_are_numbered() -> None:
    indices = [np.array([0, 2]), np.array([1]), np.array([0, 3, 4])]
    cells = Selection((3, 2, 5), indices)
    numbers = np.arange(30).reshape(3, 2, 5)[np.ix_(*indices)].ravel()
    assert (cells.shape, cells.size) == ((2, 1, 3), 6)
    for start in range(31):
        assert cells.before(start) == np.count_nonzero(numbers < start)
        for stop in range(start, 31):
            within = numbers[(numbers >= start) & (numbers < stop)]
            assert cells.within(start, stop).tolist() == (within - start).tolist()
    one = Selection((), [])
    assert (one.before(0), one.before(1), one.within(0, 1).tolist()) == (0, 1, [0])
