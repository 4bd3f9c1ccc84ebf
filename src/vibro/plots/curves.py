"""Pictures of short lists: a curve for every value over a range, or single points over another list."""

from __future__ import annotations

from itertools import cycle, groupby, pairwise
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from vibro.core.codes import Regime, Status
from vibro.plots.fields import hiding_fields, zero_points
from vibro.plots.frame import (
    below,
    facet_frame,
    headline,
    mark_operating_point,
    operating_points,
    renderer_of,
    scale_axis,
    set_heading,
    settle,
)
from vibro.plots.lines import (
    UNCERTAIN,
    Stretch,
    draw_numbers,
    finish_numbers,
    numbers_of,
    overlays,
    stretches,
    write_name,
)
from vibro.plots.peaks import draw_peaks
from vibro.plots.style import (
    CURVES,
    INK,
    NO_ANSWER_HATCH,
    axis_label,
    number_text,
    values_text,
)
from vibro.plots.view import is_discrete

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from vibro.plots.fields import Fields
    from vibro.plots.view import View
    from vibro.results.sweep import SweepResult

    Floats = NDArray[np.float64]
    Legend = dict[str, dict[str, Any]]

__all__ = ["curve_figure"]

_WIDTH: Final = 7.4  # [in] of a figure
_AROUND: Final = 1.7  # [in] heading, name of the axis, and legend
_PANEL: Final = 2.1  # [in] height of a panel of numbers
_THIN, _THICK = 0.16, 0.36  # [in] from one value's bar to the next, above numbers and on their own
_FILLED: Final = 0.8  # of that: the bar
_SQUARE: Final = 8.0  # [pt] side of the square of a single point, in place of a bar
_MARGIN: Final = 0.06  # of an axis of single points, beyond the outer ones
_TICK: Final = 0.5  # [in] from one number below such an axis to the next
# From dark to light, and legible on white: in this order for the colour-blind and in grey, too.
_COLOURS, _LIGHTEST = "plasma", 0.75
_DASHES: Final[tuple[Any, ...]] = ("-", (0, (6, 2)), (0, (1.2, 1.2)), (0, (6, 1.5, 1.2, 1.5)))
# Points may lie upon each other: of different shapes, and hollow. Means are filled.
_MARKERS: Final = "os^Dv"
_POINT: Final[Mapping[str, Any]] = {"linestyle": "none", "marker": "o", "markersize": 6.0, "color": INK}
_HOLLOW: Final[Mapping[str, Any]] = {"markerfacecolor": "none", "markeredgewidth": 1.4}


class _Curve(NamedTuple):
    """One of the curves of a panel: its numbers, its value in words, and how it is drawn."""

    fields: Fields
    label: str
    look: Mapping[str, Any]


class _Bar(NamedTuple):
    """A part of a bar, and how it is filled."""

    axes: Axes
    row: int
    fields: Fields
    ends: tuple[float, float]
    name: str
    style: dict[str, Any]


def curve_figure(
    picture: str,
    result: SweepResult,
    view: View,
    groups: Sequence[Sequence[Fields]],
    target_speed: float | None = None,
) -> Figure:
    """Draw numbers, or regimes, for each value of short lists.

    Parameters
    ----------
    picture : str
        ``regime``, or as for ``numbers_of``.
    result : SweepResult
        The sweep.
    view : View
        Part of the sweep, not a map.
    groups : sequence of sequence of Fields
        For every facet its curves.
    target_speed : float, optional
        A speed that stands out where speeds are drawn [mm/s].

    Returns
    -------
    Figure
        Of regimes: a bar for each value, cut at the critical loads. Of numbers: a curve for each value,
        below such bars; facets have no room for bars, and show the first of two numbers. Where x is a list
        too, there are points instead of curves, and squares instead of bars.
    """
    looks = _looks(view)
    facets = [[_Curve(f, *look) for f, look in zip(fields, looks, strict=True)] for fields in groups]
    if picture == "regime":
        return _regimes(result, view, facets)
    heading, rows = numbers_of(picture, result.length)
    first = next(iter(rows))
    legend: Legend = {}
    if view.facet is not None:
        figure, axes, columns = _facets(view)
        panels = [(a, first, curves) for a, curves in zip(axes, facets, strict=True)]
        named, key = axes[::columns], axes[columns - 1]
    else:
        figure, (strip, *axes) = _stack(view, [_THIN * len(looks), *[_PANEL] * len(rows)])
        strip.tick_params(axis="x", which="both", bottom=False, labelbottom=False)
        strip.spines[:].set_visible(False)
        hatched: Legend = {}
        bars = _draw_bars(strip, view, facets[0], hatched)
        legend = {bar.name: bar.style for bar in bars} | hatched
        panels = [(a, label, facets[0]) for a, label in zip(axes, rows, strict=True)]
        named, key = axes, axes[0]
    for a, label, curves in panels:
        for curve in curves:
            values = rows[label](curve.fields)
            means = {"means": {**_POINT, "marker": curve.look["marker"]}} if is_discrete(view.x) else {}
            look = {**means, **curve.look, "label": curve.label, "uncertain": picture in UNCERTAIN}
            draw_numbers(a, curve.fields, values, legend, gid="numbers", **look)
            for x in _own_x(result, view, curve.fields):
                height = float(np.interp(x, curve.fields.x, values))
                mark_operating_point(a, np.array([[x, height]]), legend)
        shown = np.concatenate([rows[label](f) for fields in groups for f in fields])
        finish_numbers(a, picture, shown, target_speed if label == first else None)
        if not any(np.isfinite(rows[label](curve.fields)).any() for curve in curves):
            _say_why_empty(a, curves)
        if a in named:
            a.set_ylabel(label)
    if picture == "speed":
        drawn = [(a, curve.fields.panel) for a, label, curves in panels if label == first for curve in curves]
        varying = (view.x, view.curves, view.facet)
        draw_peaks([a for a, _ in drawn], [panel for _, panel in drawn], varying, legend)
    figure.align_ylabels(named)
    if view.curves is not None:
        _add_key(key, facets[0])
    set_heading(figure, headline(heading, result), _below(result, view, facets))
    settle(figure, legend)
    return figure


def _regimes(result: SweepResult, view: View, facets: list[list[_Curve]]) -> Figure:
    """Draw a bar for each value, in the colours of its regimes and with their names."""
    if view.facet is not None:
        figure, axes, _ = _facets(view)
    else:
        figure, axes = _stack(view, [_THICK * len(facets[0])])
    legend: Legend = {}
    bars: list[_Bar] = []
    for a, curves in zip(axes, facets, strict=True):
        bars += _draw_bars(a, view, curves, legend)
        for row, curve in enumerate(curves):
            points = [(x, row) for x in _own_x(result, view, curve.fields)]
            mark_operating_point(a, np.array(points), legend)
            if not is_discrete(view.x):
                _draw_critical(a, row, curve.fields, legend)
        if not is_discrete(view.x):
            a.spines[["left", "top", "right"]].set_visible(False)
    set_heading(figure, headline("Steady regimes", result), _below(result, view, facets))
    settle(figure, legend)
    renderer = renderer_of(figure)
    named = {
        bar.name
        for bar in bars
        if write_name(bar.axes, renderer, _room(result, view, bar), bar.row, bar.name, bar.style)
    }
    if unnamed := {bar.name: bar.style for bar in bars if bar.name not in named}:
        settle(figure, unnamed | legend)
    return figure


def _looks(view: View) -> list[tuple[str, Mapping[str, Any]]]:
    """Return the name and the style of each curve."""
    from matplotlib import colormaps
    from matplotlib.colors import to_hex

    if view.curves is None:
        return [("", {**_POINT, **_HOLLOW})]
    name, values = view.curves.name, view.curves.values.tolist()
    colours = [to_hex(c) for c in colormaps[_COLOURS](np.linspace(0.0, _LIGHTEST, len(values)))]
    points = is_discrete(view.x)
    looks: list[tuple[str, Mapping[str, Any]]] = []
    for value, colour, dashes, marker in zip(values, colours, cycle(_DASHES), cycle(_MARKERS), strict=False):
        line = {"linestyle": dashes, "linewidth": 1.8}
        look = {**_POINT, **_HOLLOW, "marker": marker} if points else line
        looks.append((values_text({name: value}, all_of_them=True), {**look, "color": colour}))
    return looks


def _below(result: SweepResult, view: View, facets: list[list[_Curve]]) -> str:
    """Return the line under the headline: quantities that are fixed all over a picture."""
    several = [axis.name for axis in (view.curves, view.facet) if axis is not None]
    values = facets[0][0].fields.panel.values
    return below(result, {name: value for name, value in values.items() if name not in several})


def _stack(view: View, heights: list[float]) -> tuple[Figure, list[Axes]]:
    """Make a figure of panels one above the other, over the same x."""
    from vibro.plots.picture import Picture

    figure = Picture(figsize=(_WIDTH, _AROUND + sum(heights)))
    grid = figure.subplots(len(heights), 1, sharex=True, squeeze=False, height_ratios=heights)
    axes = list(grid.flat)
    _scale_x(axes[-1], view, _WIDTH)
    axes[-1].set_xlabel(axis_label(view.x))
    return figure, axes


def _facets(view: View) -> tuple[Figure, list[Axes], int]:
    """Make a figure of panels beside each other; return also how many are in a row."""
    assert view.facet is not None
    n = len(view.facet_indices)
    figure, axes, columns = facet_frame(n)
    for number, (a, index) in enumerate(zip(axes, view.facet_indices, strict=True)):
        a.set_title(values_text({view.facet.name: float(view.facet.values[index])}, all_of_them=True))
        _scale_x(a, view, float(figure.get_figwidth()) / columns)
        if number + columns >= n:
            a.set_xlabel(axis_label(view.x))
            a.tick_params(labelbottom=True)
    return figure, axes, columns


def _scale_x(axes: Axes, view: View, width: float) -> None:
    """Give a panel, so many inches wide, the scale of its x: of a list, marked at its values."""
    if not is_discrete(view.x):
        scale_axis(axes.xaxis, view.x)
        return
    values = view.x.values
    span = float(np.ptp(values))
    axes.set_xlim(values[0] - _MARGIN * span, values[-1] + _MARGIN * span)
    labels, last = [], -np.inf
    for value in values.tolist():
        has_room = value - last >= _TICK / width * span
        labels.append(number_text(value) if has_room else "")
        last = value if has_room else last
    axes.set_xticks(values, labels)


def _draw_bars(axes: Axes, view: View, curves: Sequence[_Curve], legend: Legend) -> list[_Bar]:
    """Draw the regimes of every value, the first one lowest; return the parts."""
    bars = []
    for row, curve in enumerate(curves):
        fields = curve.fields
        parts = _points(fields) if is_discrete(view.x) else stretches(fields)
        # A regime goes on where another motion exists; single points are not joined.
        for (name, _), group in groupby(parts, key=lambda p: (p.name, is_discrete(view.x) and p.low)):
            run = list(group)
            low, high, style = run[0].low, run[-1].high, run[0].style
            _fill(axes, row, low, high, name, style)
            bars.append(_Bar(axes, row, fields, (low, high), name, style))
        for part in parts:
            for label, style in overlays(part).items():
                _fill(axes, row, part.low, part.high, label, style)
                legend[label] = style
    axes.set_ylim(-0.5, len(curves) - 0.5)
    axes.set_yticks(range(len(curves)), [curve.label for curve in curves])
    axes.tick_params(axis="y", length=0.0)
    return bars


def _room(result: SweepResult, view: View, bar: _Bar) -> tuple[float, float]:
    """Return where there is most room for the name of a part of a bar, between what is drawn across it."""
    across = [x for _, x in _critical(bar.fields)] + _own_x(result, view, bar.fields)
    cuts = np.unique(np.clip([*bar.ends, *across], *bar.ends)).tolist()
    return max(pairwise(cuts), key=lambda part: part[1] - part[0], default=bar.ends)


def _points(fields: Fields) -> list[Stretch]:
    """Return the regime and the status of single points."""
    found = []
    columns = (fields.panel.cycle[name][0].tolist() for name in ("regime", "status", "coexists"))
    backwards = (fields.backwards[0] > 0.0).tolist()
    for x, regime, code, coexists, back in zip(fields.x.tolist(), *columns, backwards, strict=True):
        status = Status(code)
        unanswered = status if status in NO_ANSWER_HATCH else None
        found.append(Stretch(x, x, Regime(regime), unanswered, coexists > 0, back))
    return found


def _fill(axes: Axes, row: int, low: float, high: float, name: str, style: Mapping[str, Any]) -> None:
    """Draw a part of a bar, or the square of a single point."""
    from matplotlib.patches import Rectangle

    look = {"edgecolor": INK, "linewidth": 0.6, **style}
    if low == high:
        axes.scatter([low], [row], s=_SQUARE**2, marker="s", gid=name, zorder=2, **look)
    else:
        axes.add_patch(Rectangle((low, row - 0.5 * _FILLED), high - low, _FILLED, gid=name, zorder=2, **look))


def _draw_critical(axes: Axes, row: int, fields: Fields, legend: Legend) -> None:
    """Draw the critical loads across a bar."""
    ends = [row - 0.5 * _FILLED, row + 0.5 * _FILLED]
    for name, x in _critical(fields):
        style = CURVES[name]
        look = {"color": INK, "linestyle": style.dashes, "linewidth": style.width}
        axes.plot([x, x], ends, zorder=3, gid=name, solid_capstyle="butt", **look)
        legend[style.label] = look


def _critical(fields: Fields) -> list[tuple[str, float]]:
    """Return the critical loads that bound a regime over a range: their names and places."""
    return [
        (name, x)
        for name in CURVES
        for x in zero_points(fields, fields.log_ratio[name], hiding_fields(fields, name)).tolist()
    ]


def _say_why_empty(axes: Axes, curves: Sequence[_Curve]) -> None:
    """Write the reason into a panel without any number."""
    statuses = set().union(*(curve.fields.statuses for curve in curves))
    why = ", ".join(status.label.replace("-", " ") for status in NO_ANSWER_HATCH if status in statuses)
    axes.text(0.5, 0.5, why or "nothing conveyed", transform=axes.transAxes, ha="center", va="center")


def _own_x(result: SweepResult, view: View, fields: Fields) -> list[float]:
    """Return the position of the scene's own point on a curve; single points may not include it."""
    own = operating_points(result, fields.panel)[:, 0].tolist()
    return [x for x in own if not is_discrete(view.x) or np.isclose(view.x.values, x, rtol=1e-9).any()]


def _add_key(axes: Axes, curves: Sequence[_Curve]) -> None:
    """Label the curves beside a panel, in the order of the bars."""
    from matplotlib.lines import Line2D

    handles = [Line2D([], [], label=curve.label, **curve.look) for curve in reversed(curves)]
    axes.legend(handles=handles, loc="upper left", bbox_to_anchor=(1.0, 1.0), handlelength=3.2)
