"""Some of a grid's cells: those at certain values of every axis."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Selection:
    """Cells of a grid, numbered with the last axis fastest, at some of the values of every axis.

    Attributes
    ----------
    grid : tuple of int
        Shape of the whole grid.
    indices : sequence of array
        For every axis the indices of its values, ascending.
    """

    grid: tuple[int, ...]
    indices: Sequence[NDArray[np.intp]]

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values of each axis."""
        return tuple(len(kept) for kept in self.indices)

    @property
    def size(self) -> int:
        """Number of cells."""
        return math.prod(self.shape)

    @property
    def ends(self) -> tuple[int, int]:
        """The first of these cells, and the last one."""
        first, last = (
            int(np.ravel_multi_index([0, *(kept[end] for kept in self.indices)], (1, *self.grid)))
            for end in (0, -1)
        )
        return first, last

    def before(self, cell: int) -> int:
        """Count these cells before one of the grid, or before its end."""
        if cell >= math.prod(self.grid):
            return self.size
        count, block = 0, self.size
        for index, kept in zip(np.unravel_index(cell, self.grid), self.indices, strict=True):
            place = int(np.searchsorted(kept, index))
            block //= len(kept)
            count += place * block
            if place == len(kept) or kept[place] != index:
                break
        return count

    def within(self, start: int, stop: int) -> NDArray[np.intp]:
        """Return these cells among those of the grid from ``start`` to ``stop``, counted from ``start``."""
        # A leading axis of one value, so that there is an axis even if nothing varies.
        places = np.unravel_index(np.arange(self.before(start), self.before(stop)), (1, *self.shape))
        there = (kept[place] for kept, place in zip(self.indices, places[1:], strict=True))
        return np.asarray(np.ravel_multi_index((places[0], *there), (1, *self.grid)) - start)
