"""Where words fit on a map: inside regions, and on lines, which they interrupt.

Points on paper are complex numbers here, x + iy, in pixels from the lower left corner of the map.
"""

from __future__ import annotations

import cmath
import itertools
import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.plots.frame import renderer_of
from vibro.plots.style import halo

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from vibro.reals import Floats

    Points = NDArray[np.complex128]
    Integers = NDArray[np.int32]

_CELL: Final = 4.0  # [px] side of the cells into which the map is divided, each taken or free
_OFF: Final = 1000  # more than the things on a map
_MARGIN: Final = 3.0  # [px] kept free around a label, as part of it
_APART: Final = 6.0  # [px] between the margin of a label and that of the next
_BESIDE: Final = 6.0  # [px] between the margin of a label and the line that it stands beside
_ROOMIER: Final = 1.2  # from one size of free rectangles to the next
_PLACES: Final = 45  # tried along a line
_REACHES: Final = (3, 6, 10, 15, 21, 28, 36, 46, 58)  # [pt] from a point to its label, tried in turn
_LEADER: Final = {"arrowstyle": "-", "color": "#999999", "linewidth": 0.6, "shrinkB": 4.0}
_DIRECTIONS: Final = (*itertools.product((1, -1), (0.7, -0.7)), (1, 0), (-1, 0), (0, 1), (0, -1))
# A label hides the stretch of the line under it: that must be nearly straight, and not the whole line.
_LEAST_LENGTH: Final = 1.3  # of the line, over that of the label
_LEAST_REACH: Final = 0.9  # from end to end of the stretch, over the label's length: it may not wind
_MOST_BEND: Final = 0.6  # of the stretch, across its chord, over the label's height


class Labeller:
    """Places words on one map, each clear of everything placed before.

    Parameters
    ----------
    axes : Axes
        With final size and limits.
    """

    def __init__(self, axes: Axes) -> None:
        figure: Any = axes.figure
        self._axes = axes
        self._renderer = renderer_of(figure)
        self._pixels_per_point = figure.dpi / 72.0
        self._box = axes.get_window_extent(self._renderer)
        shape = [int(side / _CELL) for side in (self._box.height, self._box.width)]
        # Number of things in each cell. An extra border of one cell represents everything off the map.
        self._crowd = np.pad(np.zeros(shape, np.int32), 1, constant_values=_OFF)

    def avoid(self, points: Floats, radius: float) -> None:
        """Keep labels off points in the user's units, by a radius [pt]."""
        row, column = np.indices(self._crowd.shape) - 0.5
        for point in self._on_paper(points):
            away = np.abs(_CELL * (column + 1j * row) - point)
            self._crowd += away <= radius * self._pixels_per_point

    def avoid_lines(self, lines: Sequence[Floats]) -> None:
        """Keep labels off lines in the user's units, all but those that are written on them."""
        self._crowd += self._under(lines)

    def in_region(self, text: str, member: NDArray[np.bool_], **style: Any) -> bool:
        """Write a region's name in the middle of its roomiest part.

        Parameters
        ----------
        text : str
            In one line; it is broken at its hyphen or first blank if only that makes it fit.
        member : bool array
            Whether each point of a grid, evenly spaced over the whole map, belongs to the region.
        **style
            Properties of the text.

        Returns
        -------
        bool
            False if it fits nowhere and is not written.
        """
        nearest = [
            np.round(np.linspace(0, n - 1, count)).astype(int)
            for n, count in zip(member.shape, self._crowd.shape, strict=True)
        ]
        free = (member[np.ix_(*nearest)] & (self._crowd == 0))[1:-1, 1:-1]
        broken = text.replace("-", "-\n", 1) if "-" in text else text.replace(" ", "\n", 1)
        for words in dict.fromkeys((text, broken)):
            artist, width, height = self._text(words, style)
            middle = _roomiest(free, math.ceil(height / _CELL), math.ceil(width / _CELL))
            if middle is not None:
                self._put(artist, width, height, middle)
                return True
            artist.remove()
        return False

    def along(self, text: str, lines: Sequence[Floats], *, beside: bool = False, **style: Any) -> bool:
        """Write a line's name along it, where it is straight and clear.

        Parameters
        ----------
        text : str
            The name.
        lines : sequence of (n, 2) float array
            Pieces of the line, in the user's units; the longest is preferred.
        beside : bool, optional
            Whether the words lie beside the line, and cover no part of it.
        **style
            Properties of the text.

        Returns
        -------
        bool
            False if it fits nowhere and is not written.
        """
        artist, width, height = self._text(text, style)
        others = self._crowd if beside else self._crowd - self._under(lines)
        for piece in map(self._on_paper, sorted(lines, key=len, reverse=True)):
            sides = (1, -1) if beside else (0,)
            places = [self._place_on(piece, others, width, height, side) for side in sides]
            room, middle, direction = max(places, key=lambda place: place[0])
            if room:
                self._put(artist, width, height, middle, direction)
                return True
        artist.remove()
        return False

    def beside(self, text: str, point: Floats, **style: Any) -> None:
        """Write the name of a point, in the user's units, where it is nearest and covers least."""
        artist, width, height = self._text(text, style)
        (centre,) = self._on_paper(np.array([point]))
        middles = [
            centre + right * (off + 0.5 * width) + 1j * up * (off + 0.5 * height)
            for off in self._pixels_per_point * np.array(_REACHES)
            for right, up in _DIRECTIONS
        ]
        shape = _rectangle(width, height)
        middle = min(middles, key=lambda m: int(self._crowd[self._cells(shape + m)].sum()))
        self._put(artist, width, height, middle)
        artist.remove()
        style |= {"ha": "center", "va": "center", "arrowprops": _LEADER, "path_effects": halo("#FFFFFF")}
        style |= {"xytext": (middle.real, middle.imag), "textcoords": "axes pixels"}
        self._axes.annotate(text, (point[0], point[1]), **style)

    def _place_on(
        self, line: Points, others: Integers, width: float, height: float, side: int
    ) -> tuple[int, complex, complex]:
        """Return how many places a label has on a line, or on a side of it; a middle, and its direction.

        Of the places on the longest free stretch, take the one next to the middle of the line.
        """
        arc = _arc(line)
        if arc[-1] < _LEAST_LENGTH * width:
            return 0, 0j, 1
        at = np.linspace(0.5 * width, arc[-1] - 0.5 * width, _PLACES)[:, np.newaxis]
        under = np.interp(at + np.linspace(-0.5, 0.5, 2 + int(width / _CELL)) * width, arc, line)
        start, chord = under[:, 0], under[:, -1] - under[:, 0]
        direction = chord / np.maximum(np.abs(chord), _CELL)
        across = ((under - start[:, np.newaxis]) * direction.conj()[:, np.newaxis]).imag
        bend, shift = np.ptp(across, axis=1), 0.5 * (across.min(axis=1) + across.max(axis=1))
        off = shift + side * (0.5 * (height + bend) + _BESIDE)
        middle = start + 0.5 * chord + 1j * off * direction
        ground = _rectangle(width, height) * direction[:, np.newaxis] + middle[:, np.newaxis]
        fits = (np.abs(chord) > _LEAST_REACH * width) & (bend < _MOST_BEND * height)
        fits &= (others[self._cells(ground)] <= 0).all(axis=1)
        runs = np.split(np.arange(_PLACES), np.flatnonzero(np.diff(fits)) + 1)
        longest = max(runs, key=lambda run: len(run) * fits[run[0]])
        best = longest[np.argmin(np.abs(longest - _PLACES // 2))]
        return len(longest) * int(fits[best]), middle[best], direction[best]

    def _text(self, words: str, style: dict[str, Any]) -> tuple[Any, float, float]:
        """Return words without a position yet, and their width and height with margins."""
        style = {"ha": "center", "va": "center", "rotation_mode": "anchor", "zorder": 6, **style}
        artist = self._axes.text(0, 0, words, transform=self._axes.transAxes, **style)
        extent = artist.get_window_extent(self._renderer)
        return artist, extent.width + 2.0 * _MARGIN, extent.height + 2.0 * _MARGIN

    def _put(self, artist: Any, width: float, height: float, middle: complex, direction: complex = 1) -> None:
        """Place words, turned into a direction but never upside down, and keep other words off them."""
        artist.set_position((middle.real / self._box.width, middle.imag / self._box.height))
        angle = math.degrees(cmath.phase(direction))
        artist.set_rotation(angle - 180.0 * round(angle / 180.0))
        self._crowd[
            self._cells(_rectangle(width + 2 * _APART, height + 2 * _APART) * direction + middle)
        ] += 1

    def _on_paper(self, points: Floats) -> Points:
        x, y = (self._axes.transData.transform(points) - self._box.min).T
        return np.asarray(x + 1j * y)

    def _under(self, lines: Sequence[Floats]) -> Integers:
        """Count how many lines in the user's units pass through each cell."""
        under = np.zeros_like(self._crowd)
        for line in map(self._on_paper, lines):
            arc = _arc(line)
            at = np.linspace(0.0, arc[-1], 2 + int(2.0 * arc[-1] / _CELL))
            passed = np.zeros(under.shape, np.bool_)
            passed[self._cells(np.interp(at, arc, line))] = True
            under += passed
        return under

    def _cells(self, points: Points) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Rows and columns of the cells with points in them."""
        row, column = (
            np.floor(part / _CELL).astype(np.intp).clip(-1, n - 2) + 1
            for part, n in zip((points.imag, points.real), self._crowd.shape, strict=True)
        )
        return row, column


def _roomiest(free: NDArray[np.bool_], high: int, wide: int) -> complex | None:
    """Return the middle of the largest free rectangle of a label's shape; None if none has the label's size.

    Parameters
    ----------
    free : bool array
        Whether each cell is free.
    high, wide : int
        Size of the label [cells].
    """
    taken = np.pad(~free, ((1, 0), (1, 0))).cumsum(axis=0, dtype=np.int32).cumsum(axis=1)
    middle = None
    while high <= free.shape[0] and wide <= free.shape[1]:
        within = taken[high:, wide:] - taken[:-high, wide:] - taken[high:, :-wide] + taken[:-high, :-wide]
        corners = np.argwhere(within == 0)
        if not corners.size:
            break
        # Of equally large ones, take the one in their middle.
        row, column = corners[np.argmin(np.hypot(*(corners - corners.mean(axis=0)).T))]
        middle = _CELL * complex(column + 0.5 * wide, row + 0.5 * high)
        high, wide = math.ceil(_ROOMIER * high), math.ceil(_ROOMIER * wide)
    return middle


def _arc(line: Points) -> Floats:
    """Length of a line up to each of its points."""
    return np.concatenate([[0.0], np.cumsum(np.abs(np.diff(line)))])


def _rectangle(width: float, height: float) -> Points:
    """Return points all over a rectangle about 0: however it is turned, they meet every cell under it."""
    across, up = (np.linspace(-0.5, 0.5, 2 + int(1.5 * side / _CELL)) * side for side in (width, height))
    return np.asarray((across + 1j * up[:, np.newaxis]).ravel())
