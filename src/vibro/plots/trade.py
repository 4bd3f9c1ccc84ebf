"""The trade-off between speed and accuracy as a picture: time per scene against error, for every method."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.plots.frame import renderer_of, set_heading
from vibro.plots.style import INK, house_style

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.transforms import Bbox

    from vibro.accuracy.trade import Row, Trade

__all__ = ["trade_figure"]

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

# Offsets of a label from its point, tried in turn. Beyond the last distance a thin line leads to the label.
_REACHES: Final = (5, 7, 12, 18, 25, 33, 42, 52)  # [pt]
_DIRECTIONS: Final = (
    *itertools.product((1, -1), (1, -1)),
    *((1, 0), (-1, 0), (0, 1), (0, -1)),
    *itertools.product((2, -2), (1, -1)),
    *itertools.product((1, -1), (2, -2)),
)
_LED: Final = 12  # [pt]
_LEADER: Final[dict[str, Any]] = {"arrowstyle": "-", "color": "#888888", "linewidth": 0.5}
_HORIZONTAL: Final = {1: "left", 0: "center", -1: "right"}
_VERTICAL: Final = {1: "bottom", 0: "center", -1: "top"}


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
        from vibro.plots.picture import Picture

        figure = Picture(figsize=_SIZE, layout="constrained")
        axes = figure.subplots()
        axes.set_xscale("log")
        axes.set_yscale("log")
        rows = [row for row in trade.rows if row.error_max == row.error_max]
        names = list(dict.fromkeys(row.method for row in rows))
        looks = {name: _LOOKS[i % len(_LOOKS)] for i, name in enumerate(names)}
        for name in names:
            _draw_method(axes, [row for row in rows if row.method == name], *looks[name])
        line = axes.axhline(trade.tolerance, color=INK, linewidth=0.8, linestyle=(0, (5, 3)))
        axes.set_xlabel("time per scene [µs]")
        axes.set_ylabel("largest error in mean speed [A f]; tick: median where it slips")
        axes.grid(which="major", color="#DDDDDD", linewidth=0.6)
        axes.set_axisbelow(True)
        axes.margins(0.1, 0.08)
        _draw_front(axes, rows)
        scenes = f"{trade.scenes} scenes in contact; errors against {trade.reference}"
        set_heading(figure, "Speed against accuracy", scenes)
        figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=3)
        figure.draw_without_rendering()
        note = f"tolerance {trade.tolerance:g} A f"
        text = axes.annotate(
            note,
            (0.005, trade.tolerance),
            (0, 2),
            ("axes fraction", "data"),
            "offset points",
            fontsize=7.5,
        )
        _place_labels(figure, axes, rows, {name: colour for name, (colour, _) in looks.items()}, [text, line])
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
        linewidth=1.2,
        linestyle=(0, (1, 1.5)),
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


def _place_labels(
    figure: Figure, axes: Axes, rows: Sequence[Row], colours: Mapping[str, str], taken: list[Any]
) -> None:
    """Write each point's setting as near to it as possible without covering another label, point or line."""
    from matplotlib.patheffects import withStroke
    from matplotlib.text import Text
    from matplotlib.transforms import Bbox

    renderer = renderer_of(figure)
    inside = axes.get_window_extent()
    boxes = [text.get_window_extent() for text in taken]
    for row, following in itertools.zip_longest(rows, rows[1:]):
        here = axes.transData.transform(_point(row))
        low = axes.transData.transform((row.time_us, max(row.error_median, _LEAST_ERROR)))
        ends = [low]
        if following is not None and following.method == row.method:
            ends.append(axes.transData.transform(_point(following)))
        boxes.append(_around(here, 8.0))
        boxes += [_around(here + t * (end - here), 2.0) for end in ends for t in np.linspace(0.0, 1.0, 40)]
    for row in sorted(rows, key=lambda row: -row.time_us):
        label = None
        for reach, (right, up) in itertools.product(_REACHES, _DIRECTIONS):
            if label is not None:
                label.remove()
            label = axes.annotate(
                row.setting,
                _point(row),
                (reach * right, reach * up),
                textcoords="offset points",
                ha=_HORIZONTAL[np.sign(right)],
                va=_VERTICAL[np.sign(up)],
                fontsize=7.5,
                color=colours[row.method],
                path_effects=[withStroke(linewidth=2.0, foreground="#FFFFFF")],
                zorder=4,
                arrowprops=_LEADER if reach > _LED else None,
            )
            # The extent of an annotation includes its leader; that of its words alone is needed.
            label.update_positions(renderer)
            box = Bbox.padded(Text.get_window_extent(label, renderer), 1.5)
            if inside.containsx(box.x0) and inside.containsx(box.x1) and not box.count_overlaps(boxes):
                break
        boxes.append(box)


def _around(point: Any, reach: float) -> Bbox:
    from matplotlib.transforms import Bbox

    return Bbox([point - reach, point + reach])
