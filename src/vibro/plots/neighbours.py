"""Neighbourhoods of the points of a grid: windows, and nearest points.

SciPy's ``ndimage`` has all of this, but importing it takes as much CPU as drawing two pictures.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.reals import Floats

    Integers = NDArray[np.int32]
    Mask = NDArray[np.bool_]

_UNEVEN: Final = 1e-6  # of a step: smaller differences are rounding
_SPREAD: Final = 1000  # points along an uneven axis: about as many as the picture has


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
        steps = np.diff(places)
        if np.ptp(steps) > _UNEVEN * steps.max():
            points = np.linspace(places[0], places[-1], _SPREAD)
            values = values.take(np.searchsorted(0.5 * (places[1:] + places[:-1]), points), axis)
    return values


def dilate(mask: Mask, width: int, *, beyond: bool = False) -> Mask:
    """Find the points with at least one true point in the square window around them.

    Parameters
    ----------
    mask : (y, x) bool array
        Any.
    width : int
        Of the window [points], odd.
    beyond : bool
        What the mask is taken as beyond its edges.
    """
    for axis in (0, 1):
        edges = [(width // 2 * (axis == i),) * 2 for i in (0, 1)]
        padded = np.pad(mask, edges, constant_values=beyond)
        mask = np.asarray(sliding_window_view(padded, width, axis).any(axis=-1))
    return mask


def erode(mask: Mask, width: int, *, beyond: bool) -> Mask:
    """Find the points whose square window, as in ``dilate``, contains only true points."""
    return ~dilate(~mask, width, beyond=not beyond)


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
