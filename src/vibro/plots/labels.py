"""Where words fit on a map: inside regions, and along lines without hiding anything that matters."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

__all__ = ["Labeller", "outline"]

_MARGIN: Final = 2.0  # [px] belongs to a label on every side
_GRAIN: Final = 4.0  # [px] between the points that stand for lines and rectangles
_LEAST_CLEARANCE: Final = 3.0  # [px] between such points: anything less could cross
_CANDIDATES: Final = 50  # places tried along a line
_MOST_BEND: Final = 0.6  # a line under its label may leave the chord by this share of the text's height
_CORNER: Final = 0.72  # distance of a rectangle's corner from its middle, in its own sides, with a little air
_AS_GOOD: Final = 0.97  # share of the most room with which a place nearer to the middle is better
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
        from matplotlib.backends.backend_agg import FigureCanvasAgg

        figure: Any = axes.figure
        self._axes = axes
        self._renderer: Any = FigureCanvasAgg(figure).get_renderer()  # type: ignore[no-untyped-call]
        self._box = axes.get_window_extent(self._renderer)
        self._pixels_per_point = figure.dpi / 72.0
        self._taken: list[Floats] = []  # points in pixels
        self.words: list[Any] = []

    def avoid(self, points: Floats, radius: float = 0.0) -> None:
        """Keep labels off points in the user's units, each with a radius in points of type."""
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

    def in_region(self, text: str, member: NDArray[np.bool_], halo: Any = None, **style: Any) -> bool:
        """Write a region's name where it has most room.

        Parameters
        ----------
        text : str
            In one line; it is broken at its hyphen or first blank if only that makes it fit.
        member : bool array
            Whether each point of a grid, evenly spaced over the whole map, belongs to the region.
        halo : color, optional
            Outline that lifts the words off the ground.
        **style
            Properties of the text.

        Returns
        -------
        bool
            False if it fits nowhere; nothing is written then.
        """
        from scipy.ndimage import distance_transform_edt

        rows, columns = member.shape
        step_x, step_y = self._box.width / (columns - 1), self._box.height / (rows - 1)
        free = np.pad(member & ~self._taken_cells(member.shape), 1)
        if not free.any():
            return False
        for words in dict.fromkeys((text, _broken(text))):
            artist = self._axes.text(
                0, 0, words, ha="center", va="center", zorder=6, transform=self._axes.transAxes, **style
            )
            extent = artist.get_window_extent(self._renderer)
            width, height = extent.width + 2 * _MARGIN, extent.height + 2 * _MARGIN
            room = distance_transform_edt(free, sampling=(step_y / height, step_x / width))
            best = np.argwhere(room > _AS_GOOD * room.max())
            row, column = best[np.argmin(np.hypot(*(best - best.mean(axis=0)).T))]
            if room[row, column] > _CORNER:
                place = ((column - 1) / (columns - 1), (row - 1) / (rows - 1))
                artist.set_position(place)
                outline(artist, halo)
                self.words.append(artist)
                centre = np.array(
                    [self._box.x0 + place[0] * self._box.width, self._box.y0 + place[1] * self._box.height]
                )
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
            Outline that lifts the words off the ground.
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
        """Places for a label along a line in pixels: (merit, centre, angle)."""
        from scipy.spatial import cKDTree

        points, length = _evenly(line, 2.0)
        if length < 1.3 * width:
            return []
        half = 0.5 * width
        arc = np.linspace(0.0, length, len(points))
        taken = cKDTree(np.vstack(self._taken)) if self._taken else None
        found = []
        for s in np.linspace(half, length - half, _CANDIDATES):
            under = points[(arc >= s - half) & (arc <= s + half)]
            chord = under[-1] - under[0]
            reach = math.hypot(*chord)
            if reach < 0.9 * width:
                continue
            normal = np.array([-chord[1], chord[0]]) / reach
            offsets = (under - under[0]) @ normal
            low, high = float(offsets.min()), float(offsets.max())
            if high - low > _MOST_BEND * height:
                continue
            angle = math.atan2(chord[1], chord[0])
            angle -= math.pi * round(angle / math.pi)  # never upside down
            middle = 0.5 * (under[0] + under[-1])
            away = 0.5 * height + _LEAST_CLEARANCE + 0.5
            for offset in (low - away, high + away) if beside else (0.5 * (low + high),):
                centre = middle + offset * normal
                rectangle = _rectangle(centre, angle, width, height)
                clear = float(np.min(taken.query(rectangle)[0])) if taken else math.inf
                if clear >= _LEAST_CLEARANCE and self._contains(rectangle):
                    off_middle = abs(2.0 * s / length - 1.0)
                    merit = (
                        min(clear / height, 4.0)
                        - 2.0 * (high - low) / height
                        - 0.6 * (off_middle + abs(angle))
                    )
                    found.append((merit, centre, angle))
        return found

    def _pixels(self, points: Floats) -> Floats:
        return np.asarray(self._axes.transData.transform(points), np.float64)

    def _contains(self, points: Floats) -> bool:
        box = self._box
        return bool(
            (points[:, 0] > box.x0 + _MARGIN).all()
            and (points[:, 0] < box.x1 - _MARGIN).all()
            and (points[:, 1] > box.y0 + _MARGIN).all()
            and (points[:, 1] < box.y1 - _MARGIN).all()
        )

    def _taken_cells(self, shape: tuple[int, ...]) -> NDArray[np.bool_]:
        cells = np.zeros(shape, np.bool_)
        if self._taken:
            points = np.vstack(self._taken)
            column = np.round((points[:, 0] - self._box.x0) / self._box.width * (shape[1] - 1))
            row = np.round((points[:, 1] - self._box.y0) / self._box.height * (shape[0] - 1))
            inside = (column >= 0) & (column < shape[1]) & (row >= 0) & (row < shape[0])
            cells[row[inside].astype(int), column[inside].astype(int)] = True
        return cells


def outline(artist: Any, halo: Any) -> None:
    """Lift words off their ground by an outline of a colour; none without one."""
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


def _rectangle(centre: Floats, angle: float, width: float, height: float) -> Floats:
    """Points that cover a rotated rectangle."""
    columns, rows = (max(2, round(side / _GRAIN) + 1) for side in (width, height))
    across, up = np.meshgrid(np.linspace(-0.5, 0.5, columns) * width, np.linspace(-0.5, 0.5, rows) * height)
    flat = np.column_stack([across.ravel(), up.ravel()])
    turn = np.array([[math.cos(angle), math.sin(angle)], [-math.sin(angle), math.cos(angle)]])
    return np.asarray(centre + flat @ turn)
