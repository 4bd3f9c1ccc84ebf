"""Where functions of many rows first reach a value."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

__all__ = ["first_crossing"]

_CLOSER: Final = 17  # points around a peak between two points of the grid


def first_crossing(
    value: Callable[[NDArray[np.intp], Floats], Floats],
    grid: Floats,
    target: float,
    *,
    climbs: int,
    steps: int,
) -> Floats:
    """Return the least argument at which each function reaches a target.

    Parameters
    ----------
    value : callable
        ``value(rows, x)`` returns the values of the functions ``rows`` at x, 1-D.
    grid : (m, n) array
        Arguments of each of m functions, ascending, close enough together that it has one peak at most
        between two neighbours of one; both sides of its jumps are among them.
    target : float
        What is to be reached.
    climbs : int
        Rounds of looking closer at peaks, each by a factor of 8.
    steps : int
        Of bisection.

    Returns
    -------
    (m,) array
        At the argument the target is reached; inf where it never is.

    Notes
    -----
    A target that is reached on a peak alone is reached between points of a grid that all miss it: every peak
    before the first point that reaches it is climbed.
    """
    rows, columns = np.indices(grid.shape)
    values = value(rows.ravel(), grid.ravel()).reshape(grid.shape)
    holds = values >= target
    first = np.where(holds.any(axis=1), np.argmax(holds, axis=1), grid.shape[1])
    high = np.full(len(grid), np.inf)
    low = grid[:, 0].copy()
    found = np.flatnonzero(first < grid.shape[1])
    high[found] = grid[found, first[found]]
    low[found] = grid[found, np.maximum(first[found] - 1, 0)]

    is_peak = (columns > 0) & (columns < first[:, None]) & (values > 0.0)
    is_peak[:, 1:] &= values[:, 1:] >= values[:, :-1]
    is_peak[:, :-1] &= values[:, :-1] >= values[:, 1:]
    row, column = np.nonzero(is_peak)
    start, end = grid[row, column - 1], grid[row, np.minimum(column + 1, grid.shape[1] - 1)]
    for _ in range(climbs):
        x = np.linspace(start, end, _CLOSER, axis=-1)
        near = value(np.repeat(row, _CLOSER), x.ravel()).reshape(x.shape)
        best = np.argmax(near, axis=1)
        reaches = near.max(axis=1, initial=-np.inf) >= target
        for i in np.flatnonzero(reaches):
            j = int(np.argmax(near[i] >= target))
            if x[i, j] < high[row[i]]:
                high[row[i]], low[row[i]] = x[i, j], x[i, max(j - 1, 0)]
        peaks = np.arange(len(row))
        start = x[peaks, np.maximum(best - 1, 0)]
        end = x[peaks, np.minimum(best + 1, _CLOSER - 1)]

    everywhere, known = np.arange(len(grid)), np.isfinite(high)
    high, found = high[known], everywhere[known]
    low = low[known]
    for _ in range(steps):
        middle = 0.5 * (low + high)
        reaches = value(found, middle) >= target
        low, high = np.where(reaches, low, middle), np.where(reaches, middle, high)
    result = np.full(len(grid), np.inf)
    result[found] = high
    return result
