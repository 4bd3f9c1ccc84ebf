"""What iterations over many cells share: bisection, and the loop over the cells that are still open."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final, Generic, TypeVar

import numpy as np

from vibro.core.groups import take

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Bools = NDArray[np.bool_]
    Indices = NDArray[np.intp]

__all__ = ["OpenCells", "bisect"]

_HALVINGS: Final = 60  # from an interval of several turns down to an ulp

Group = TypeVar("Group", bound=tuple[Any, ...])


def bisect(
    function: Callable[[Floats], Floats], low: Floats, high: Floats, rises: Bools | bool = False
) -> Floats:
    """Find where a function changes its sign, by halving.

    Parameters
    ----------
    function : callable
        Of points, one per cell; positive before its zero and not after it.
    low, high : array
        Intervals that contain the zeros.
    rises : bool array, optional
        Where the function is positive after its zero instead.

    Returns
    -------
    array
        The far ends of the last intervals.
    """
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        before = (function(middle) > 0.0) ^ rises
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    return high


class OpenCells(Generic[Group]):
    """The cells that an iteration has not closed yet, and the arrays that belong to them.

    Iterate over it to get both, at most ``most`` times and as long as a cell is open; call ``keep`` with the
    cells that stay open. Arrays are copied only when a cell is closed. What is open after the last time is
    left in ``cells``.

    Parameters
    ----------
    cells : int array
        Indices of the cells.
    group : tuple
        What belongs to them: arrays, or tuples of arrays, one element per cell; 0-d arrays serve every cell.
    most : int
        Number of iterations.

    Examples
    --------
    >>> import numpy as np
    >>> root = np.array([2.0, 9.0, 1.0])
    >>> cells = OpenCells(np.arange(3), (root.copy(),), most=60)
    >>> for open_, (square,) in cells:  # Heron's method
    ...     better = 0.5 * (root[open_] + square / root[open_])
    ...     apart = np.abs(better - root[open_])
    ...     root[open_] = better
    ...     cells.keep(apart > 1e-9 * better)
    >>> root[1]
    3.0
    """

    def __init__(self, cells: Indices, group: Group, most: int) -> None:
        self.cells, self.group, self._most = cells, group, most

    def __iter__(self) -> Iterator[tuple[Indices, Group]]:
        for _ in range(self._most):
            if not self.cells.size:
                return
            yield self.cells, self.group

    def keep(self, stays: Bools, group: Group | None = None) -> None:
        """Close all cells but some, and replace what belongs to the cells that were open by ``group``."""
        if group is not None:
            self.group = group
        going = stays.nonzero()[0]
        if going.size < self.cells.size:
            self.cells, self.group = self.cells[going], take(self.group, going)
