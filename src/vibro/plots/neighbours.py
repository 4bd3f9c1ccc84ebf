"""Neighbourhoods of the points of a grid: windows, and nearest points.

SciPy's ``ndimage`` has all of this, but importing it takes as much CPU as drawing two pictures.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Integers = NDArray[np.int32]
    Mask = NDArray[np.bool_]

_UNEVEN: Final = 1e-6  # of a step: smaller differences are rounding
_SPREAD: Final = 1000  # points along an uneven axis: about as many as the picture has


def are_even(places: Floats) -> bool:
    """Whether ascending places are equally far apart."""
    steps = np.diff(places)
    return bool(np.ptp(steps) <= _UNEVEN * steps.max())


def spread_evenly(values: Floats, x: Floats, y: Floats) -> Floats:
    """Return numbers at points that lie evenly between the ends of a grid: of the nearest of its own points.

    Parameters
    ----------
    values : (y, x) array
        On the grid.
    x, y : array
        Where its points are, ascending.

    Returns
    -------
    array
        The same numbers where the grid is even.
    """
    for axis, places in enumerate((y, x)):
        if not are_even(places):
            points = np.linspace(places[0], places[-1], _SPREAD)
            values = values.take(np.searchsorted(0.5 * (places[1:] + places[:-1]), points), axis)
    return values


def dilate(mask: Mask, width: int) -> Mask:
    """Find the points with at least one true point in the square window around them.

    Parameters
    ----------
    mask : (y, x) bool array
        Taken as false beyond its edges.
    width : int
        Of the window [points]; that of the grid where this is smaller.

    Returns
    -------
    (y, x) bool array
        What ``scipy.ndimage.binary_dilation`` returns for a square of ones.
    """
    return np.asarray(_counts(mask, width, reflected=True) > 0)


def erode(mask: Mask, width: int, *, beyond: bool) -> Mask:
    """Find the points whose square window contains only true points.

    Parameters
    ----------
    mask : (y, x) bool array
        Any.
    width : int
        Of the window [points]; that of the grid where this is smaller.
    beyond : bool
        What the mask is taken as beyond its edges.

    Returns
    -------
    (y, x) bool array
        What ``scipy.ndimage.binary_erosion`` returns for a square of ones.
    """
    if beyond:
        return np.asarray(_counts(~mask, width) == 0)
    rows, columns = (min(n, width) for n in mask.shape)
    return np.asarray(_counts(mask, width) == rows * columns)


def _counts(mask: Mask, width: int, *, reflected: bool = False) -> Integers:
    """Count true points in the window around every point.

    Of two middles, a window of even width is placed by the right one, or by the left one if reflected.
    """
    counts = mask.astype(np.int32)
    for axis, n in enumerate(mask.shape):
        size = min(n, width)
        first = np.arange(n) - ((size - 1) // 2 if reflected else size // 2)
        sums = np.zeros([m + (i == axis) for i, m in enumerate(mask.shape)], np.int32)
        np.cumsum(counts, axis, out=sums[1:] if axis == 0 else sums[:, 1:])
        counts = sums.take(np.minimum(first + size, n), axis) - sums.take(np.maximum(first, 0), axis)
    return counts


def fill_unknown(values: Floats, known: Mask) -> Floats:
    """Give unknown points the value of the nearest known one in their row or column.

    If both have none, points take the value of one that has just been filled. If no point is known, every
    value is zero.
    """
    if not known.any():
        return np.zeros(values.shape)
    while not known.all():
        row, column = np.nonzero(~known)
        left_right, across = (part[row, column] for part in _nearest(known))
        up_down, along = (part[column, row] for part in _nearest(known.T))
        same_row = left_right <= up_down
        found = np.minimum(left_right, up_down) < known.size
        source = np.where(same_row, row, along)[found], np.where(same_row, across, column)[found]
        values, known = values.copy(), known.copy()
        values[row[found], column[found]] = values[source]
        known[row[found], column[found]] = True
    return values


def _nearest(mask: Mask) -> tuple[Integers, Integers]:
    """Distance to the nearest true point in the same row, and its column.

    The distance is ``mask.size`` or more where the row has no true point.
    """
    here = np.arange(mask.shape[1], dtype=np.int32)
    left = np.maximum.accumulate(np.where(mask, here, np.int32(-mask.size)), axis=1)
    right = np.minimum.accumulate(np.where(mask, here, np.int32(2 * mask.size))[:, ::-1], axis=1)[:, ::-1]
    column = np.where(here - left <= right - here, left, right)
    return np.abs(column - here), column
