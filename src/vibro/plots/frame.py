"""The frame of a picture: figure, axes with names and units, titles, operating point, legend."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.plots.style import INK, axis_label, broken_lines, figure_text, values_text
from vibro.quantities import DRIVES

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from vibro.axes import Axis
    from vibro.plots.view import Panel
    from vibro.results.sweep import SweepResult

__all__ = [
    "below",
    "facet_frame",
    "headline",
    "legend_height",
    "make_logarithmic",
    "map_frame",
    "mark_operating_point",
    "operating_points",
    "renderer_of",
    "scale_axis",
    "set_heading",
    "settle",
    "single_frame",
]

_SINGLE_SIZE: Final = (7.4, 5.6)  # [in]
_FACET_SIZE: Final = (3.1, 2.7)  # [in]
_EXTRA_SIZE: Final = (1.2, 1.3)  # [in] for the colour bar beside facets, and the heading and legend
_FACET_COLUMNS: Final = {1: 1, 2: 2, 3: 3, 4: 2, 5: 3, 6: 3, 7: 4, 8: 4, 9: 3, 10: 4, 11: 4, 12: 4}
_HEADING_SIZE: Final = 10.5  # [pt]
_HEADING_SHARE: Final = 0.94  # largest share of a figure's width for a headline
_POINTS: Final = 72.0  # [pt/in]
_DECADES_FOR_TENS: Final = 3.0  # a longer logarithmic scale has ticks at powers of ten alone
_SHORT: Final = 2.0  # a logarithmic scale that does not end above this multiple of its start has even ticks
_FEW_TICKS: Final = 4  # a scale with room for these has numbers with enough digits to be distinct
_MOST_TICKS: Final = 9
_TICK_STEPS: Final = (1, 2, 2.5, 5, 10)
_PHASES: Final = tuple(name for name in DRIVES if "phase" in name)
_PHASE_STEPS: Final = (1, 1.5, 3, 4.5, 9, 10)  # to divide turns
_DIGIT_WIDTH: Final = 0.115  # [in] of a digit on an axis, with its share of the gap between numbers
_HANDLE_WIDTH: Final = 0.62  # [in] of a handle in a legend, with the gap between columns
_LETTER_WIDTH: Final = 0.065  # [in] of a letter in a legend
_ROW_HEIGHT: Final = 0.17  # [in] of a row of a legend
_USUAL_ROWS: Final = 3  # for which figures have room
_MARKER: Final[dict[str, Any]] = {
    "marker": "o",
    "markersize": 8.0,
    "markerfacecolor": "#FFFFFF",
    "markeredgecolor": "#000000",
    "markeredgewidth": 2.0,
    "linestyle": "none",
}


def renderer_of(figure: Figure) -> Any:
    """Return the renderer with which a figure is laid out, its words are placed, and its PNG is drawn.

    One for all of them: each renderer has to set every formula anew.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    canvas: Any = figure.canvas
    if not isinstance(canvas, FigureCanvasAgg):
        canvas = FigureCanvasAgg(figure)  # becomes the figure's own
    return canvas.get_renderer()


def facet_frame(n: int) -> tuple[Figure, list[Axes], int]:
    """Make a figure with so many empty panels; return also how many are in a row."""
    from vibro.plots.picture import Picture

    columns = _FACET_COLUMNS[n]
    rows = math.ceil(n / columns)
    size = _SINGLE_SIZE
    if n > 1:
        size = (columns * _FACET_SIZE[0] + _EXTRA_SIZE[0], rows * _FACET_SIZE[1] + _EXTRA_SIZE[1])
    figure = Picture(figsize=size)
    grid = figure.subplots(rows, columns, squeeze=False, sharex=n > 1, sharey=n > 1)
    for unused in list(grid.flat)[n:]:
        unused.remove()
    return figure, list(grid.flat)[:n], columns


def map_frame(result: SweepResult, panels: list[Panel], heading: str) -> tuple[Figure, list[Axes]]:
    """Make a figure with empty maps, their axes named and scaled."""
    n = len(panels)
    figure, axes, columns = facet_frame(n)
    common = dict(panels[0].values)
    for number, (panel, a) in enumerate(zip(panels, axes, strict=True)):
        assert panel.y is not None
        scale_axis(a.xaxis, panel.x)
        scale_axis(a.yaxis, panel.y)
        if number % columns == 0:
            a.set_ylabel(axis_label(panel.y))
        if number + columns >= n:
            a.set_xlabel(axis_label(panel.x))
            a.tick_params(labelbottom=True)
        if panel.facet is not None:
            common.pop(panel.facet, None)
            a.set_title(values_text({panel.facet: panel.values[panel.facet]}, all_of_them=True))
    set_heading(figure, headline(heading, result), below(result, common))
    return figure, axes


def single_frame(x: Axis, y: Axis, headline: str, below: str) -> tuple[Figure, Axes]:
    """Make a figure with one empty map, its axes named and scaled."""
    from vibro.plots.picture import Picture

    figure = Picture(figsize=_SINGLE_SIZE)
    axes = figure.subplots()
    for axis, of in ((axes.xaxis, x), (axes.yaxis, y)):
        scale_axis(axis, of)
        axis.set_label_text(axis_label(of))
    set_heading(figure, headline, below)
    return figure, axes


def headline(heading: str, result: SweepResult) -> str:
    """Write the headline: the content of the picture, and the title of the sweep."""
    return f"{heading} – {result.title}" if result.title else heading


def below(result: SweepResult, values: Mapping[str, float]) -> str:
    """Return the line under a headline: given quantities and, if all rests, where motion begins."""
    return "\n".join(filter(None, [values_text(values, hops=result.hops), result.rest_text]))


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
    room = _HEADING_SHARE * _POINTS * float(figure.get_figwidth())
    told = [broken_lines(line, _HEADING_SIZE, room) for line in below.splitlines()]
    lines = [figure_text(headline, _HEADING_SIZE, room), *told]
    figure.suptitle("\n".join(line for line in lines if line), fontsize=_HEADING_SIZE, linespacing=1.5)


def scale_axis(axis: Any, of: Axis) -> None:
    """Give an axis of a plot the range and the spacing of an axis of the sweep."""
    low, high = float(of.values[0]), float(of.values[-1])
    axis.axes.set(**{f"{axis.axis_name}lim": (low, high)})
    if of.spacing == "log":
        make_logarithmic(axis, low, high)
    else:
        _spread_ticks(axis, _PHASE_STEPS if of.name in _PHASES else _TICK_STEPS)


def _spread_ticks(axis: Any, steps: Sequence[float] = _TICK_STEPS) -> None:
    """Thin out the ticks of a horizontal axis until their numbers, written in full, do not overlap."""
    from matplotlib.ticker import MaxNLocator

    if steps is not _TICK_STEPS:
        axis.set_major_locator(MaxNLocator(nbins=_MOST_TICKS, steps=steps))
    if axis.axis_name == "x":
        # By default there is room for four digits each.
        low, high = axis.get_view_interval()
        decimals = max(0, math.ceil(math.log10(_FEW_TICKS / (high - low))))
        longest = _DIGIT_WIDTH * len(f"{max(abs(low), abs(high)):.{decimals}f}")
        most = int(axis.axes.bbox.width / axis.axes.figure.dpi / longest)
        axis.set_major_locator(MaxNLocator(nbins=min(max(most, 1), _MOST_TICKS), steps=steps))


def make_logarithmic(axis: Any, low: float, high: float) -> None:
    """Scale an axis logarithmically, with plain numbers at 1, 2, 5, or at powers of ten on a long one."""
    from matplotlib.ticker import (
        AutoLocator,
        FuncFormatter,
        LogLocator,
        NullFormatter,
        NullLocator,
        ScalarFormatter,
    )

    axis.axes.set(**{f"{axis.axis_name}scale": "log"})
    if high < _SHORT * low:
        axis.set_major_locator(AutoLocator())
        axis.set_major_formatter(ScalarFormatter())
        axis.set_minor_locator(NullLocator())
        _spread_ticks(axis)
        return
    decades = math.log10(high / low)
    subs = (1.0,) if decades > _DECADES_FOR_TENS else (1.0, 2.0, 5.0)
    axis.set_major_locator(LogLocator(subs=subs))
    axis.set_major_formatter(
        FuncFormatter(lambda value, _: np.format_float_positional(float(f"{value:.6g}"), trim="-"))
    )
    axis.set_minor_formatter(NullFormatter())


def operating_points(result: SweepResult, panel: Panel) -> NDArray[np.float64]:
    """Return the scene's own point on a panel, as an array of shape (0 or 1, 2), in the user's units."""
    point = result.operating_point
    if point is None:
        return np.empty((0, 2))
    elsewhere = any(
        not math.isclose(value, panel.values[name], rel_tol=1e-6, abs_tol=1e-12)
        for name, value in point.items()
        if name in panel.values
    )
    drawn = [axis for axis in (panel.x, panel.y) if axis is not None]
    outside = any(not axis.values[0] <= point[axis.name] <= axis.values[-1] for axis in drawn)
    if elsewhere or outside:
        return np.empty((0, 2))
    return np.array([[point[axis.name] for axis in drawn] + [0.0] * (2 - len(drawn))])


def mark_operating_point(
    axes: Axes,
    points: NDArray[np.float64],
    legend: dict[str, dict[str, Any]],
    label: str = "operating point",
) -> None:
    """Mark the scene's own point, or another single point, on top of everything."""
    if len(points):
        axes.plot(points[:, 0], points[:, 1], zorder=7, gid=label, label=label, clip_on=False, **_MARKER)
        legend[label] = dict(_MARKER)


def settle(figure: Figure, legend: Mapping[str, dict[str, Any]]) -> None:
    """Put the legend under the axes, and fix the layout of the figure.

    Parameters
    ----------
    figure : Figure
        May have a layout from before, with another legend.
    legend : mapping of str to dict
        Entries: their text, and the style of their patch or line.
    """
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    for old in list(figure.legends):
        old.remove()
    if legend:
        _add_legend(figure, legend)
    renderer_of(figure)  # so that the layout uses it, and no other
    # A figure that keeps a layout engine, even a blank one, is drawn twice whenever it is saved.
    ConstrainedLayoutEngine(w_pad=0.08, h_pad=0.04).execute(figure)


def legend_height(texts: list[str], width: float) -> float:
    """Return by how much a figure is to be higher for its legend to leave its maps their size [in]."""
    rows = math.ceil(len(texts) / _columns(texts, width)) if texts else 0
    return _ROW_HEIGHT * max(0, rows - _USUAL_ROWS)


def _add_legend(figure: Figure, styles: Mapping[str, dict[str, Any]]) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    handles: list[Any] = []
    for text, style in styles.items():
        if "facecolor" in style:
            edge = style.get("edgecolor", INK)
            handles.append(Patch(**{**style, "edgecolor": edge, "linewidth": 0.6, "label": text}))
        else:
            handles.append(Line2D([], [], label=text, **style))
    width = float(figure.get_figwidth())
    figure.legend(handles=handles, loc="outside lower center", ncols=_columns(list(styles), width))


def _columns(texts: list[str], room: float) -> int:
    """Into how many columns of a legend texts are divided to take the fewest rows in a width [in]."""
    for rows in range(1, len(texts)):
        columns = math.ceil(len(texts) / rows)
        # As matplotlib divides them: column by column, the first ones longer if they cannot be equal.
        parts = np.array_split([_HANDLE_WIDTH + _LETTER_WIDTH * len(text) for text in texts], columns)
        if sum(part.max() for part in parts) <= room:
            return columns
    return 1
