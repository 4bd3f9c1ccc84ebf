"""The trade-off between speed and accuracy as a picture: time per scene against error, for every method."""

from __future__ import annotations

import itertools
import math
from typing import TYPE_CHECKING, Final

import numpy as np

from vibro.plots.frame import draw_wanted, set_heading, settle, stack
from vibro.plots.labels import Labeller
from vibro.plots.style import house_style

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from vibro.accuracy.trade import Row, Trade

_SIZE: Final = (8.4, 6.0)  # [in]
_LEAST_ERROR: Final = 2.0**-53  # [A f] half an ulp of A f, where exact answers are drawn

# Colours that are dark enough for text and distinct to the colour-blind, each with its marker.
_LOOKS: Final = (
    ("#000000", "*"),
    ("#0072B2", "o"),
    ("#AA3377", "s"),
    ("#117733", "D"),
    ("#C44E00", "^"),
    ("#666666", "v"),
)
_MARKER_SIZE: Final = {"*": 13.0}


def trade_figure(trade: Trade) -> Figure:
    """Draw time per scene against the largest error in mean speed, both on logarithmic scales.

    Parameters
    ----------
    trade : Trade
        Methods with several settings are joined by a line; a thin line reaches down to the median error.

    Returns
    -------
    Figure
        Every point is labelled.
    """
    with house_style():
        figure, (axes,) = stack(_SIZE, [1.0])
        axes.set(xscale="log", yscale="log", xlabel="time per scene [µs]")
        axes.set_ylabel("largest error in mean speed [A f]; tick: median where it slips")
        rows = [row for row in trade.rows if row.error_max == row.error_max]
        methods = {row.method: [r for r in rows if r.method == row.method] for row in rows}
        for name, (colour, marker) in zip(methods, itertools.cycle(_LOOKS), strict=False):
            _draw_method(axes, methods[name], colour, marker)
        axes.grid(which="major", color="#DDDDDD", linewidth=0.6)
        axes.set_axisbelow(True)
        axes.margins(0.1, 0.08)
        _draw_front(axes, rows)
        draw_wanted(axes, trade.tolerance, f"tolerance {trade.tolerance:g} A f")
        scenes = f"{trade.scenes} scenes in contact; errors against {trade.reference}"
        set_heading(figure, "Speed against accuracy", scenes)
        settle(figure)
        labeller = Labeller(axes)
        labeller.avoid(np.array([_point(row) for row in rows]).reshape(-1, 2), radius=4.0)
        lines = [np.array([_point(row) for row in of_one]) for of_one in methods.values()]
        ticks = [
            (row, max(row.error_median, _LEAST_ERROR)) for row in rows if not math.isnan(row.error_median)
        ]
        lines += [np.array([_point(row), (row.time_us, tick)]) for row, tick in ticks]
        lines.append(np.array([[x, trade.tolerance] for x in axes.get_xlim()]))
        labeller.avoid_lines(lines)
        colours = dict(zip(methods, (colour for colour, _ in itertools.cycle(_LOOKS)), strict=False))
        for row in sorted(rows, key=lambda row: -len(row.setting)):
            labeller.beside(row.setting, _point(row), fontsize=7.5, color=colours[row.method])
    return figure


def _point(row: Row) -> tuple[float, float]:
    return row.time_us, max(row.error_max, _LEAST_ERROR)


def _draw_method(axes: Axes, rows: Sequence[Row], colour: str, marker: str) -> None:
    times = [row.time_us for row in rows]
    medians = [max(row.error_median, _LEAST_ERROR) for row in rows]
    worst = [max(row.error_max, _LEAST_ERROR) for row in rows]
    axes.vlines(times, medians, worst, color=colour, linewidth=0.8, alpha=0.6)
    axes.plot(times, medians, color=colour, marker="_", linestyle="none", markersize=6.0)
    axes.plot(
        times,
        worst,
        color=colour,
        marker=marker,
        markersize=_MARKER_SIZE.get(marker, 6.5),
        linewidth=0.8,
        label=rows[0].method,
        zorder=3,
    )


def _draw_front(axes: Axes, rows: Sequence[Row]) -> None:
    """Join the methods that no other beats in both speed and error, by a staircase to the picture's edges."""
    points = sorted(map(_point, rows))
    front: list[tuple[float, float]] = []
    for point in points:
        if not front or point[1] < front[-1][1]:
            front.append(point)
    if not front:
        return
    (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    corners = [(front[0][0], top), *front, (right, front[-1][1])]
    x, y = zip(*corners, strict=True)
    axes.step(
        x,
        y,
        where="post",
        color="#BBBBBB",
        linewidth=3.0,
        zorder=1,
        label="no other is faster and more accurate",
    )
    axes.set(xlim=(left, right), ylim=(bottom, top))
