"""What all pictures have: figure, axes with names and units, titles, marks, bands, legend."""

from __future__ import annotations

import math
from itertools import groupby
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np
from matplotlib import ticker
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.transforms import Bbox

from vibro.plots import style
from vibro.plots.view import is_discrete
from vibro.quantities import DRIVES

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from vibro.axes import Axis
    from vibro.plots.view import Panel
    from vibro.results.sweep import SweepResult

_SINGLE_SIZE: Final = (7.4, 5.6)  # [in]
_FACET_SIZE: Final = (3.1, 2.7)  # [in]
_EXTRA_SIZE: Final = (1.2, 1.3)  # [in] for the colour bar beside facets, and the heading and legend
_FACET_COLUMNS: Final = {1: 1, 2: 2, 3: 3, 4: 2, 5: 3, 6: 3, 7: 4, 8: 4, 9: 3, 10: 4, 11: 4, 12: 4}
_HEADING_SIZE: Final = 10.5  # [pt]
_LETTERS: Final = 10.0, 12.2  # [1/in] of a headline, and below it
_DECADES_FOR_TENS: Final = 3.0  # a longer logarithmic scale has ticks at powers of ten alone
_SHORT: Final = 2.0  # a logarithmic scale that does not end above this multiple of its start has even ticks
_MOST_TICKS: Final = 9
_TICK_STEPS: Final = (1, 2, 2.5, 5, 10)
_PHASES: Final = tuple(name for name in DRIVES if "phase" in name)
_PHASE_STEPS: Final = (1, 1.5, 3, 4.5, 9, 10)  # to divide turns
_TICK: Final = 0.55  # [in] from one number on a horizontal axis to the next
_HANDLE_WIDTH: Final = 0.62  # [in] of a handle in a legend, with the gap between columns
_LETTER_WIDTH: Final = 0.065  # [in] of a letter in a legend
_ROW_HEIGHT: Final = 0.18  # [in] of a row of a legend
_LEAST_AREA: Final = 2.0  # [px] width and height of an area that a legend names
_LIST_MARGIN: Final = 0.06  # of an axis of single points, beyond the outer ones
_MARKER: Final[dict[str, Any]] = {
    "marker": "o", "ms": 8.0, "mfc": "#FFFFFF", "mec": "#000000", "mew": 2.0, "linestyle": "none"
}  # fmt: skip
_PEAKS: Final = {"fastest": "^", "fastest_backwards": "v"}
_HALO: Final = 4.0  # [pt] width of the white around a marker, over any colours and hatches
#: Opacity of bands behind curves.
TINT: Final = 0.35


class Picture(Figure):
    """A figure that several threads may save at once, while others draw: one does so at a time."""

    #: Rows of the legend for which the figure has room.
    legend_rows = 3

    def savefig(self, *args: Any, **more: Any) -> None:
        """Write the picture to a file, as matplotlib does, in the style in which it was drawn."""
        with style.house_style():
            super().savefig(*args, **more)


def renderer_of(figure: Figure) -> Any:
    """Return the renderer with which a figure is laid out, its words are placed, and its PNG is drawn.

    One for all of them: each renderer has to set every formula anew.
    """
    canvas: Any = figure.canvas
    if not isinstance(canvas, FigureCanvasAgg):
        canvas = FigureCanvasAgg(figure)  # becomes the figure's own
    return canvas.get_renderer()


def facets(panels: Sequence[Panel], label: str = "") -> tuple[Figure, list[Axes]]:
    """Make a figure with an empty panel for every value of a quantity, or with one; name and scale axes.

    Parameters
    ----------
    panels : sequence of Panel
        Of maps, or of curves.
    label : str, optional
        Of the scale of curves.
    """
    n = len(panels)
    columns = _FACET_COLUMNS[n]
    rows = math.ceil(n / columns)
    size = (columns * _FACET_SIZE[0] + _EXTRA_SIZE[0], rows * _FACET_SIZE[1] + _EXTRA_SIZE[1])
    figure = Picture(figsize=size if n > 1 else _SINGLE_SIZE)
    grid = list(figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True).flat)
    for unused in grid[n:]:
        unused.remove()
    for number, (panel, a) in enumerate(zip(panels, grid, strict=False)):
        scale_axis(a.xaxis, panel.x)
        if panel.y is not None:
            scale_axis(a.yaxis, panel.y)
        if number % columns == 0:
            a.set_ylabel(style.axis_label(panel.y) if panel.y else label)
        if number + columns >= n:
            a.set_xlabel(style.axis_label(panel.x))
            a.tick_params(labelbottom=True)
        if panel.facet is not None:
            a.set_title(style.values_text({panel.facet: panel.values[panel.facet]}, all_of_them=True))
    return figure, grid[:n]


def stack(size: tuple[float, float], heights: Sequence[float]) -> tuple[Figure, list[Axes]]:
    """Make a figure of panels one above the other, over one scale."""
    figure = Picture(figsize=size)
    grid = figure.subplots(len(heights), 1, squeeze=False, sharex=True, height_ratios=heights)
    return figure, list(grid[:, 0])


def head_sweep(figure: Figure, heading: str, result: SweepResult, panels: Sequence[Panel]) -> None:
    """Write the content of a picture and the title of the sweep; below, what all panels have in common."""
    first = panels[0].values.items()
    common = {name: value for name, value in first if all(p.values[name] == value for p in panels)}
    values = style.values_text(common, hops=result.hops)
    headline = f"{heading} – {result.title}" if result.title else heading
    set_heading(figure, headline, "\n".join(filter(None, [values, result.rest_text])))


def set_heading(figure: Figure, headline: str, below: str = "") -> None:
    """Write the headline of a picture.

    Parameters
    ----------
    figure : Figure
        Its label becomes the headline, for the files' metadata.
    headline : str
        May contain names from users: markup is escaped, and the text is cut to fit.
    below : str, optional
        Further lines, for matplotlib, which are broken after commas to fit.
    """
    figure.set_label(headline)
    above, beneath = (int(letters * figure.get_figwidth()) for letters in _LETTERS)
    lines = [style.figure_text(headline, above)]
    lines += [style.broken_lines(line, beneath) for line in below.splitlines()]
    figure.suptitle("\n".join(lines), fontsize=_HEADING_SIZE, linespacing=1.5)


def scale_axis(axis: Any, of: Axis) -> None:
    """Give an axis of a plot the range and the spacing of an axis of the sweep."""
    low, high = float(of.values[0]), float(of.values[-1])
    axis.axes.set(**{f"{axis.axis_name}lim": (low, high)})
    if is_discrete(of):
        _mark_values(axis, of.values)
    elif of.spacing == "log":
        make_logarithmic(axis, low, high)
    else:
        _spread_ticks(axis, _PHASE_STEPS if of.name in _PHASES else _TICK_STEPS)


def _mark_values(axis: Any, values: NDArray[np.float64]) -> None:
    """Mark the values of a list, with their numbers where there is room."""
    margin = _LIST_MARGIN * float(np.ptp(values))
    axis.axes.set_xlim(values[0] - margin, values[-1] + margin)
    room = _TICK / _inches(axis) * float(np.ptp(values))
    labels, last = [], -np.inf
    for value in values.tolist():
        has_room = value - last >= room
        labels.append(style.number_text(value) if has_room else "")
        last = value if has_room else last
    axis.axes.set_xticks(values, labels)


def _inches(axis: Any) -> float:
    return float(axis.axes.bbox.width / axis.axes.figure.dpi)


def _spread_ticks(axis: Any, steps: Sequence[float] = _TICK_STEPS) -> None:
    """Thin out the ticks of a horizontal axis until their numbers, written in full, do not overlap."""
    most = min(int(_inches(axis) / _TICK), _MOST_TICKS) if axis.axis_name == "x" else _MOST_TICKS
    axis.set_major_locator(ticker.MaxNLocator(nbins=most, steps=steps))


def make_logarithmic(axis: Any, low: float, high: float) -> None:
    """Scale an axis logarithmically, with plain numbers at 1, 2, 5, or at powers of ten on a long one."""
    axis.axes.set(**{f"{axis.axis_name}scale": "log"})
    if high < _SHORT * low:
        axis.set_major_formatter(ticker.ScalarFormatter())
        axis.set_minor_locator(ticker.NullLocator())
        _spread_ticks(axis)
        return
    subs = (1.0,) if math.log10(high / low) > _DECADES_FOR_TENS else (1.0, 2.0, 5.0)
    axis.set_major_locator(ticker.LogLocator(subs=subs))
    axis.set_major_formatter(lambda value, _: np.format_float_positional(float(f"{value:.6g}"), trim="-"))
    axis.set_minor_formatter(ticker.NullFormatter())


def place_on(panel: Panel, point: Mapping[str, float] | None) -> NDArray[np.float64]:
    """Return where a point, in the user's units, lies on a panel: an array of shape (0 or 1, 2)."""
    drawn = [axis for axis in (panel.x, panel.y) if axis is not None]
    if point is None:
        return np.empty((0, 2))
    held = ((value, panel.values[name]) for name, value in point.items() if name in panel.values)
    fits = [math.isclose(value, other, rel_tol=1e-6, abs_tol=1e-12) for value, other in held]
    for axis in drawn:
        value, values = point[axis.name], axis.values
        fits.append(bool(values[0] <= value <= values[-1]))
        fits.append(not is_discrete(axis) or bool(np.isclose(values, value, rtol=1e-9).any()))
    if not all(fits):
        return np.empty((0, 2))
    return np.array([[point[axis.name] for axis in drawn] + [0.0] * (2 - len(drawn))])


def mark_point(axes: Axes, points: NDArray[np.float64], label: str = "operating point") -> None:
    """Mark the scene's own point, or another single point, on top of everything."""
    if len(points):
        axes.plot(points[:, 0], points[:, 1], zorder=7, gid=label, label=label, clip_on=False, **_MARKER)


def draw_peaks(result: SweepResult, axes: Sequence[Axes], panels: Sequence[Panel]) -> list[Any]:
    """Mark the fastest of a sweep, forwards and backwards, on the panels on which they lie.

    Parameters
    ----------
    result : SweepResult
        The sweep.
    axes : sequence of Axes
        Where each panel is drawn, some maybe on the same axes.
    panels : sequence of Panel
        With their speeds.

    Returns
    -------
    list of (n, 2) array
        The points marked on each panel; of lines, their height is the speed [mm/s].
    """
    marked = [np.empty((0, 2)) for _ in panels]
    for name, marker in _PEAKS.items():
        peak = result.fastest.get(name)
        if peak is None:
            continue
        label = f"{name.replace('_', ' ')}: {style.number_text(peak.speed)} mm/s at "
        label += style.values_text({axis: peak.values[axis] for axis in result.axes}, all_of_them=True)
        look = {**_MARKER, "marker": marker, "path_effects": style.halo("#FFFFFF", _HALO)}
        for i, panel in enumerate(panels):
            point = place_on(panel, {k: v for k, v in peak.values.items() if np.isfinite(v)})
            if len(point):
                point[:, 1] = point[:, 1] if panel.y else peak.speed
                axes[i].plot(*point.T, zorder=6, gid=name, label=label, clip_on=False, **look)
                marked[i] = np.concatenate([marked[i], point])
    return marked


def draw_zero(axes: Axes) -> None:
    """Draw a line at zero where the scale passes it: numbers far from it would be squeezed."""
    low, high = axes.get_ylim()
    if low < 0.0 < high:
        axes.axhline(0.0, color=style.INK, linewidth=0.5)


def draw_wanted(axes: Axes, level: float, text: str) -> None:
    """Draw a line at what is asked for, and name it."""
    axes.axhline(level, zorder=2.5, gid="level", **style.WANTED.look)
    axes.margins(y=0.1)  # room for its name
    place = (0.005, level), (0, 3), ("axes fraction", "data"), "offset points"
    axes.annotate(text, *place, path_effects=style.halo("#FFFFFF"))


def settle(figure: Figure) -> None:
    """Put a legend of all that has a label and is seen under the axes, and fix the layout of the figure.

    The figure may have a layout from before, with another legend.
    """
    for old in list(figure.legends):
        old.remove()
    renderer = renderer_of(figure)  # so that the layout uses it, and no other
    handles = _handles(figure, renderer)
    if handles:
        width, height = figure.get_size_inches()
        columns = _columns([len(handle.get_label()) for handle in handles], width)
        rows = math.ceil(len(handles) / columns)
        known: Any = figure
        if rows > known.legend_rows:  # leave the panels their size
            figure.set_figheight(height + _ROW_HEIGHT * (rows - known.legend_rows))
            known.legend_rows = rows
        figure.legend(handles=handles, loc="outside lower center", ncols=columns, labelspacing=0.6)
    # A figure that keeps a layout engine, even a blank one, is drawn twice whenever it is saved.
    ConstrainedLayoutEngine(w_pad=0.08, h_pad=0.04).execute(figure)


def _handles(figure: Figure, renderer: Any) -> list[Any]:
    """Return what a legend shows: lines, then areas, each label once."""
    for axes in figure.axes:
        axes.get_xlim()  # the limits of what is drawn are found when they are asked for
    found: dict[str, Any] = {}
    lines = [artist for axes in figure.axes for artist in (*axes.lines, *axes.collections)]
    for artist in (*lines, *(patch for axes in figure.axes for patch in axes.patches)):
        label = str(artist.get_label())
        if not label or label.startswith("_") or label in found or not _is_seen(artist, renderer):
            continue
        found[label] = artist
        if not isinstance(artist, (Line2D, LineCollection)):
            drawn: Any = artist
            face, edge = (np.reshape(c, (-1, 4)) for c in (drawn.get_facecolor(), drawn.get_edgecolor()))
            look = {"hatch": drawn.get_hatch(), "edgecolor": edge[0] if edge.any() else style.INK}
            found[label] = Patch(facecolor=face[0], linewidth=0.6, label=label, **look)
    return list(found.values())


def _columns(letters: list[int], room: float) -> int:
    """Into how many columns of a legend labels of so many letters are divided to fit in a width [in]."""
    for columns in range(len(letters), 1, -1):
        parts = np.array_split(letters, columns)  # as matplotlib divides them
        if sum(_HANDLE_WIDTH + _LETTER_WIDTH * part.max() for part in parts) <= room:
            return columns
    return 1


def _is_seen(artist: Any, renderer: Any) -> bool:
    """Whether an artist is within its axes, and an area is no mere line."""
    if isinstance(artist, LineCollection):  # which finds no extent of its own on the paper
        return True
    extent = artist.get_window_extent(renderer)
    if not np.isfinite(extent.get_points()).all():  # of numbers that are all unknown
        return False
    seen = Bbox.intersection(extent, artist.axes.bbox.padded(1.0))
    least = _LEAST_AREA if isinstance(artist, Patch) else 0.0
    return seen is not None and min(seen.width, seen.height) >= least


class Band(NamedTuple):
    """A stretch of a scale: ends, name, style of its fill, and the hatches over it by their names."""

    low: float
    high: float
    name: str
    look: Mapping[str, Any]
    over: Mapping[str, Mapping[str, Any]] = {}


def shade(axes: Axes, bands: Iterable[Band], *, named: bool = False) -> None:
    """Fill bands behind the curves of a panel; the legend names them where no strip does."""
    for band in bands:
        look = band.look if "hatch" in band.look else {**band.look, "alpha": TINT, "linewidth": 0.0}
        label = band.name if named else ""
        axes.axvspan(band.low, band.high, zorder=0, gid=band.name, label=label, **look)
        for name, look in band.over.items():
            axes.axvspan(band.low, band.high, zorder=0.5, linewidth=0.0, gid=name, label=name, **look)


def settle_bands(figure: Figure, strip: Axes, bands: Iterable[Band]) -> None:
    """Fix the layout, and write the names of bands into a strip above the panels, or else into the legend."""
    strip.set_yticks([])
    strip.tick_params(axis="x", which="both", bottom=False, labelbottom=False)
    settle(figure)
    renderer, (first, last), named = renderer_of(figure), strip.get_xlim(), set()
    others: dict[str, Any] = {}
    for name, group in groupby(bands, key=lambda band: band.name):
        run = list(group)
        low, high, look = max(run[0].low, first), min(run[-1].high, last), run[0].look
        if low >= high:
            continue
        area = strip.axvspan(low, high, gid=name, **{"linewidth": 0.0, **look})
        place: Any = {"xy": (0.5, 0.5), "xycoords": area, "ha": "center", "va": "center_baseline"}
        effects = style.halo(look["facecolor"]) if "hatch" in look else None
        text = strip.annotate(name, **place, color=style.ink_on(look["facecolor"]), path_effects=effects)
        if text.get_window_extent(renderer).width <= area.get_window_extent(renderer).width - 4.0:
            named.add(name)
        else:
            text.remove()
            others[name] = area
    for name in others.keys() - named:
        others[name].set_label(name)
    if others.keys() - named:
        settle(figure)
