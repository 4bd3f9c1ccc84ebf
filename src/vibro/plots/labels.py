"""Where words fit on a map: inside regions, and along lines without hiding anything that matters."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.plots.frame import renderer_of
from vibro.plots.neighbours import room

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

__all__ = ["Labeller", "outline"]

_MARGIN: Final = 2.0  # [px] kept free around a label, as part of it
_LEAST_CLEARANCE: Final = 3.0  # [px] between a label and what it must not touch
# Lines, labels and regions are avoided as points. These distances between them are fine enough that nothing
# passes between two points unnoticed.
_GRAIN: Final = 4.0  # [px] along lines, within labels, and where room is measured
_MESH: Final = 20.0  # [px] within regions, less than the height of a label
_CANDIDATES: Final = 50  # places tried along a line
# A label on a line hides the stretch under it, and is easier to read where the line is straight.
_LEAST_LENGTH: Final = 1.3  # of the line, over that of the label: some of it stays visible
_LEAST_REACH: Final = 0.9  # from end to end of the stretch, over the label's length: it may not wind
_MOST_BEND: Final = 0.6  # of the stretch off its chord, over the label's height
# Distances within a region are measured in widths of the label across and heights up, where the corner of
# the label lies 0.71 from its middle.
_CORNER: Final = 0.72
# A region may have as much room in many places, or a little more in a remote one. Of the places that have
# nearly as much as the best, the one in the middle of them is taken.
_AS_GOOD: Final = 0.97
_HALO: Final = 2.4  # [pt]


class Labeller:
    """Places words on one map, each clear of what is already there.

    Parameters
    ----------
    axes : Axes
        With final size and limits.

    Attributes
    ----------
    words : list of Text
        What was written.
    """

    def __init__(self, axes: Axes) -> None:
        figure: Any = axes.figure
        self._axes = axes
        self._renderer = renderer_of(figure)
        self._box = axes.get_window_extent(self._renderer)
        self._pixels_per_point = figure.dpi / 72.0
        self._taken: list[Floats] = []  # points in pixels
        self.words: list[Any] = []

    def avoid(self, points: Floats, radius: float = 0.0) -> None:
        """Keep labels off points in the user's units, by a radius [pt]."""
        if not len(points):
            return
        places = self._pixels(points)
        if radius:
            around = np.linspace(0.0, 2.0 * math.pi, 12, endpoint=False)
            ring = radius * self._pixels_per_point * np.column_stack([np.cos(around), np.sin(around)])
            places = np.vstack([places, *(places + offset for offset in ring)])
        self._taken.append(places)

    def avoid_line(self, line: Floats) -> None:
        """Keep labels off a line in the user's units."""
        if len(line) > 1:
            self._taken.append(_evenly(self._pixels(line), _GRAIN)[0])

    def avoid_region(self, member: NDArray[np.bool_]) -> None:
        """Keep labels out of a region, given as for ``in_region``."""
        box = self._box
        rows, columns = (max(2, round(side / _MESH)) for side in (box.height, box.width))
        row, column = np.nonzero(_resampled(member, rows, columns))
        x, y = box.x0 + column / (columns - 1) * box.width, box.y0 + row / (rows - 1) * box.height
        self._taken.append(np.column_stack([x, y]))

    def in_region(self, text: str, member: NDArray[np.bool_], halo: Any = None, **style: Any) -> bool:
        """Write a region's name where there is most room for it.

        Parameters
        ----------
        text : str
            In one line; it is broken at its hyphen or first blank if only that makes it fit.
        member : bool array
            Whether each point of a grid, evenly spaced over the whole map, belongs to the region.
        halo : color, optional
            Outline of the words, to make them stand out.
        **style
            Properties of the text.

        Returns
        -------
        bool
            False if it fits nowhere; nothing is written then.
        """
        box = self._box
        rows, columns = (max(2, round(side / _GRAIN)) for side in (box.height, box.width))
        step_x, step_y = box.width / (columns - 1), box.height / (rows - 1)
        free = _resampled(member, rows, columns) & ~self._taken_cells((rows, columns))
        if not free.any():
            return False
        for words in dict.fromkeys((text, _broken(text))):
            artist = self._axes.text(
                0, 0, words, ha="center", va="center", zorder=6, transform=self._axes.transAxes, **style
            )
            extent = artist.get_window_extent(self._renderer)
            width, height = extent.width + 2 * _MARGIN, extent.height + 2 * _MARGIN
            space = room(free, step_y / height, step_x / width)
            best = np.argwhere(space > _AS_GOOD * space.max())
            row, column = best[np.argmin(np.hypot(*(best - best.mean(axis=0)).T))]
            if space[row, column] > _CORNER:
                place = (column / (columns - 1), row / (rows - 1))
                artist.set_position(place)
                outline(artist, halo)
                self.words.append(artist)
                centre = np.array([box.x0 + place[0] * box.width, box.y0 + place[1] * box.height])
                self._taken.append(_rectangle(centre, 0.0, width, height))
                return True
            artist.remove()
        return False

    def along(
        self, text: str, lines: Sequence[Floats], *, beside: bool = False, halo: Any = None, **style: Any
    ) -> bool:
        """Write a line's name along it, where it is straight and clear.

        Parameters
        ----------
        text : str
            The name.
        lines : sequence of (n, 2) float array
            Pieces of the line, in the user's units.
        beside : bool, optional
            Whether the name stands next to the line rather than on it.
        halo : color, optional
            Outline of the words, to make them stand out.
        **style
            Properties of the text.

        Returns
        -------
        bool
            False if it fits nowhere; nothing is written then.
        """
        artist = self._axes.text(
            0, 0, text, ha="center", va="center", zorder=5, transform=self._axes.transAxes, **style
        )
        extent = artist.get_window_extent(self._renderer)
        width, height = extent.width + 2 * _MARGIN, extent.height + 2 * _MARGIN
        pieces = [self._pixels(line) for line in lines if len(line) > 1]
        places = [place for piece in pieces for place in self._places(piece, width, height, beside)]
        if not places:
            artist.remove()
            return False
        _, centre, angle = max(places, key=lambda place: place[0])
        self._taken.append(_rectangle(centre, angle, width, height))
        artist.set_transform(self._axes.transData)
        artist.set_position(tuple(self._axes.transData.inverted().transform(centre)))
        artist.set(rotation=math.degrees(angle), rotation_mode="anchor")
        outline(artist, halo)
        self.words.append(artist)
        return True

    def _places(
        self, line: Floats, width: float, height: float, beside: bool
    ) -> list[tuple[float, Floats, float]]:
        """Return places for a label along a line in pixels: (merit, centre, angle)."""
        points, length = _evenly(line, _GRAIN)
        if length < _LEAST_LENGTH * width:
            return []
        # All candidates cover stretches of the line with the same number of points.
        under = max(2, round(width / length * (len(points) - 1)))
        first = np.round(np.linspace(0, len(points) - 1 - under, _CANDIDATES)).astype(int)
        start, chord = points[first], points[first + under] - points[first]
        reach = np.hypot(*chord.T)
        straight = reach >= _LEAST_REACH * width
        first, start, chord, reach = (part[straight] for part in (first, start, chord, reach))
        normal = np.column_stack([-chord[:, 1], chord[:, 0]]) / reach[:, np.newaxis]
        stretch = points[first[:, np.newaxis] + np.arange(under + 1)] - start[:, np.newaxis]
        offsets = np.einsum("ijk,ik->ij", stretch, normal)
        low, high = offsets.min(axis=1), offsets.max(axis=1)
        angle = np.arctan2(chord[:, 1], chord[:, 0])
        angle -= math.pi * np.round(angle / math.pi)  # never upside down
        off_middle = np.abs(2.0 * (first + 0.5 * under) / (len(points) - 1) - 1.0)
        merit = -2.0 * (high - low) / height - 0.6 * (off_middle + np.abs(angle))
        away = 0.5 * height + _LEAST_CLEARANCE + 0.5
        middle = offsets.mean(axis=1)
        # Beside a bend the outer side is better: there the line runs away from both ends of the word.
        sides = [(low - away, high - middle), (high + away, middle - low)]
        if not beside:
            sides = [(0.5 * (low + high), np.zeros(len(low)))]
        x, y = np.vstack([np.empty((0, 2)), *self._taken]).T
        found = []
        for offset, air in sides:
            centre = start + 0.5 * chord + offset[:, np.newaxis] * normal
            possible = (high - low <= _MOST_BEND * height) & self._contains(centre, angle, width, height)
            for i in np.flatnonzero(possible):
                clear = _clearance(x - centre[i, 0], y - centre[i, 1], angle[i], width, height)
                if clear >= _LEAST_CLEARANCE:
                    found.append((merit[i] + min((clear + air[i]) / height, 4.0), centre[i], angle[i]))
        return found

    def _pixels(self, points: Floats) -> Floats:
        return np.asarray(self._axes.transData.transform(points), np.float64)

    def _contains(self, centre: Floats, angle: Floats, width: float, height: float) -> NDArray[np.bool_]:
        """Whether each of many rotated rectangles in pixels lies on the map."""
        box = self._box
        cos, sin = np.abs(np.cos(angle)), np.abs(np.sin(angle))
        reach = 0.5 * np.column_stack([width * cos + height * sin, width * sin + height * cos]) + _MARGIN
        inside = (centre - reach > [box.x0, box.y0]) & (centre + reach < [box.x1, box.y1])
        return np.asarray(inside.all(axis=1))

    def _taken_cells(self, shape: tuple[int, ...]) -> NDArray[np.bool_]:
        cells = np.zeros(shape, np.bool_)
        if self._taken:
            points = np.vstack(self._taken)
            column = np.round((points[:, 0] - self._box.x0) / self._box.width * (shape[1] - 1))
            row = np.round((points[:, 1] - self._box.y0) / self._box.height * (shape[0] - 1))
            inside = (column >= 0) & (column < shape[1]) & (row >= 0) & (row < shape[0])
            cells[row[inside].astype(int), column[inside].astype(int)] = True
        return cells


def _resampled(member: NDArray[np.bool_], rows: int, columns: int) -> NDArray[np.bool_]:
    """Take the nearest points of a grid at those of another, spread evenly over the same map."""
    nearest = [
        np.round(np.linspace(0, n - 1, count)).astype(int)
        for n, count in zip(member.shape, (rows, columns), strict=True)
    ]
    return np.asarray(member[np.ix_(*nearest)])


def outline(artist: Any, halo: Any) -> None:
    """Outline words in a colour, so that they stand out from what is behind them; without one do nothing."""
    if halo is not None:
        from matplotlib.patheffects import withStroke

        artist.set_path_effects([withStroke(linewidth=_HALO, foreground=halo)])


def _broken(text: str) -> str:
    return text.replace("-", "-\n", 1) if "-" in text else text.replace(" ", "\n", 1)


def _evenly(line: Floats, spacing: float) -> tuple[Floats, float]:
    """Points at even distances along a line, and its length."""
    steps = np.hypot(*np.diff(line, axis=0).T)
    arc = np.concatenate([[0.0], np.cumsum(steps)])
    length = float(arc[-1])
    at = np.linspace(0.0, length, max(2, int(length / spacing)))
    return np.column_stack([np.interp(at, arc, line[:, 0]), np.interp(at, arc, line[:, 1])]), length


def _clearance(x: Floats, y: Floats, angle: float, width: float, height: float) -> float:
    """Distance from a rotated rectangle about the origin to the nearest point; inf if there is none."""
    cos, sin = math.cos(angle), math.sin(angle)
    beside = np.maximum(np.abs(cos * x + sin * y) - 0.5 * width, 0.0)
    above = np.maximum(np.abs(cos * y - sin * x) - 0.5 * height, 0.0)
    return math.sqrt(np.min(beside**2 + above**2, initial=np.inf))


def _rectangle(centre: Floats, angle: float, width: float, height: float) -> Floats:
    """Points that cover a rotated rectangle."""
    columns, rows = (max(2, round(side / _GRAIN) + 1) for side in (width, height))
    across, up = np.meshgrid(np.linspace(-0.5, 0.5, columns) * width, np.linspace(-0.5, 0.5, rows) * height)
    flat = np.column_stack([across.ravel(), up.ravel()])
    turn = np.array([[math.cos(angle), math.sin(angle)], [-math.sin(angle), math.cos(angle)]])
    return np.asarray(centre + flat @ turn)
