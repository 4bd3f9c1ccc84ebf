"""The trade-off between speed and accuracy as a picture: time per scene against error, for every method."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Final

import numpy as np

from vibro.plots.frame import draw_wanted, set_heading, settle, stack
from vibro.plots.labels import Labeller
from vibro.plots.style import house_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from vibro.accuracy.trade import Trade

_SIZE: Final = (8.4, 6.0)  # [in]
_LEAST_ERROR: Final = 2.0**-53  # [A f] half an ulp of A f, where exact answers are drawn
# Colours that are dark enough for text and distinct to the colour-blind, each with its marker.
_LOOKS: Final = (
    *(("#000000", "*"), ("#0072B2", "o"), ("#AA3377", "s")),
    *(("#117733", "D"), ("#C44E00", "^"), ("#666666", "v")),
)


@house_style()
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
    figure, (axes,) = stack(_SIZE, [1.0])
    axes.set(xscale="log", yscale="log", xlabel="time per scene [µs]")
    axes.set_ylabel("largest error in mean speed [A f]; tick: median where it slips")
    rows = [row for row in trade.rows if row.error_max == row.error_max]
    labels, lines = [], []
    for (name, group), (colour, marker) in zip(
        itertools.groupby(rows, lambda row: row.method), itertools.cycle(_LOOKS), strict=False
    ):
        settings = [*group]
        time = np.array([row.time_us for row in settings])
        median, worst = (
            np.maximum([getattr(row, error) for row in settings], _LEAST_ERROR)
            for error in ("error_median", "error_max")
        )
        axes.plot(time, worst, label=name, color=colour, marker=marker, linewidth=0.8)
        axes.plot(time, median, color=colour, marker="_", linestyle="none")
        axes.vlines(time, median, worst, color=colour, linewidth=0.8, alpha=0.6)
        points = np.column_stack([time, worst])
        labels += [(row.setting, point, colour) for row, point in zip(settings, points, strict=True)]
        ticks = np.array([[time, median], [time, worst]]).transpose(2, 0, 1)
        lines += [points, *ticks[np.isfinite(median)]]  # without a median where no scene slips
    axes.grid(which="major", color="#DDDDDD", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.margins(x=0.1)
    draw_wanted(axes, trade.tolerance, f"tolerance {trade.tolerance:g} A f")
    scenes = f"{trade.scenes} scenes in contact; errors against {trade.reference}"
    set_heading(figure, "Speed against accuracy", scenes)
    settle(figure)
    labeller = Labeller(axes)
    labeller.avoid(np.array([point for _, point, _ in labels]), radius=4.0)
    labeller.avoid_lines([*lines, np.array([[x, trade.tolerance] for x in axes.get_xlim()])])
    for text, point, colour in sorted(labels, key=lambda label: -len(label[0])):
        labeller.beside(text, point, fontsize=7.5, color=colour)
    return figure
