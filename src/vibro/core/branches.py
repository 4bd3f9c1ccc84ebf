"""Branch and bound: how slow a body of a box can be at most, proved by boxes that cover it."""

from __future__ import annotations

from typing import Final, NamedTuple

from vibro.core.boxes import AXES, Box, speed_at
from vibro.core.buffers import Doubles, Integers
from vibro.core.comparison import least_speed
from vibro.core.elementary import INF

__all__ = ["Cover", "cover"]

_LEAST_WIDTH: Final = 1e-9  # [share of a band] of a box that is divided
_FOUND: Final = 2.0  # [1] what a bound counts where there was none, beside shares of bands


class Cover(NamedTuple):
    """Boxes that cover a box.

    Attributes
    ----------
    low, high : Doubles
        Ends of each, ``AXES`` numbers a row.
    bound : Doubles
        No body of a box is slower [m/s].
    heap : Integers
        Room for as many numbers; the first one is the row of the least bound.
    point : Doubles
        The slowest body that was met, ``AXES`` long, and room for as many numbers.
    speed : Doubles
        Its speed [m/s].
    """

    low: Doubles
    high: Doubles
    bound: Doubles
    heap: Integers
    point: Doubles
    speed: Doubles


def cover(box: Box, out: Cover, gap: float, least: float, most: int) -> int:
    """Divide a box where its bound is least, until that is close to the slowest body that was met.

    Parameters
    ----------
    box : Box
        The box.
    out : Cover
        Room for ``most`` boxes, with a body that is known.
    gap, least : float
        Distance of bound and body that is close: over the speed [1], or over this speed where it is less
        [m/s].
    most : int
        Most boxes.

    Returns
    -------
    int
        Number of boxes.
    """
    for axis in range(AXES):
        out.low[axis], out.high[axis] = box.low[axis], box.high[axis]
    out.bound[0], out.heap[0] = least_speed(box, out.low, out.high, 0), 0
    count = 1
    for _ in range(1, most):
        row, speed = out.heap[0], out.speed[0]
        if out.bound[row] >= speed - gap * max(abs(speed), least):
            break
        axis = _axis(box, out, row)
        if axis < 0:
            break
        for i in range(AXES):
            out.low[AXES * count + i] = out.low[AXES * row + i]
            out.high[AXES * count + i] = out.high[AXES * row + i]
        middle = 0.5 * (out.low[AXES * row + axis] + out.high[AXES * row + axis])
        out.high[AXES * row + axis] = middle
        out.low[AXES * count + axis] = middle
        whole = out.bound[row]  # holds for its parts, whatever rounding makes of theirs
        out.bound[row] = max(least_speed(box, out.low, out.high, row), whole)
        out.bound[count] = max(least_speed(box, out.low, out.high, count), whole)
        _sink(out, count)
        _rise(out, count)
        _look_inside(box, out, row)
        _look_inside(box, out, count)
        count += 1
    return count


def _axis(box: Box, out: Cover, row: int) -> int:
    """Return the axis along which a box is worth dividing, by the bound where it has no width; or -1."""
    best, most, widest, whole = -1, 0.0, 0.0, out.bound[row]
    for axis in range(AXES):
        place = AXES * row + axis
        low, high = out.low[place], out.high[place]
        if not high > low or high - low <= _LEAST_WIDTH * (box.high[axis] - box.low[axis]):
            continue
        out.low[place] = 0.5 * (low + high)
        out.high[place] = out.low[place]
        bound = least_speed(box, out.low, out.high, row)
        out.low[place], out.high[place] = low, high
        width = (high - low) / (box.high[axis] - box.low[axis])
        gain = (_FOUND if bound > -INF else 0.0) if whole == -INF else bound - whole
        if best < 0 or gain > most or (gain == most and width > widest):
            best, most, widest = axis, gain, width
    return best


def _look_inside(box: Box, out: Cover, row: int) -> None:
    """Compare the body in the middle of a box with the slowest one."""
    for axis in range(AXES):
        out.point[AXES + axis] = 0.5 * (out.low[AXES * row + axis] + out.high[AXES * row + axis])
    speed = speed_at(box, out.point, AXES)
    if speed < out.speed[0]:
        out.speed[0] = speed
        for axis in range(AXES):
            out.point[axis] = out.point[AXES + axis]


def _sink(out: Cover, count: int) -> None:
    """Move the first row of the heap down to its place among ``count``."""
    heap, place = out.heap, 0
    row = heap[0]
    for _ in range(count):
        child = 2 * place + 1
        if child >= count:
            break
        if child + 1 < count and out.bound[heap[child + 1]] < out.bound[heap[child]]:
            child += 1
        if out.bound[row] <= out.bound[heap[child]]:
            break
        heap[place] = heap[child]
        place = child
    heap[place] = row


def _rise(out: Cover, row: int) -> None:
    """Put a new row, the last one of the heap, into its place."""
    heap, place = out.heap, row
    for _ in range(row):
        if place == 0 or not out.bound[row] < out.bound[heap[(place - 1) // 2]]:
            break
        heap[place] = heap[(place - 1) // 2]
        place = (place - 1) // 2
    heap[place] = row
