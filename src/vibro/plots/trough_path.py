"""The path of a trough that moves along an ellipse, and where on it the body slides, rests and flies."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from vibro.plots.bands import TINT
from vibro.plots.phases import PHASE_STYLES, events_of
from vibro.plots.style import INK

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from vibro.results.history import Phase, Sample

    Floats = NDArray[np.float64]

_BAND: Final = 9.0  # [pt] width of the band in the colour of a phase
_MARGIN: Final = 0.12  # margin around the path, as a share of its span
_AHEAD: Final = 0.01  # [1] share of the turn between the tail of the arrow and its head
_TICKS: Final = 4


def draw_path(axes: Axes, phases: Sequence[Phase], trace: Sample, period: float) -> None:
    """Draw the last turn of a trough.

    Parameters
    ----------
    axes : Axes
        Receives the drawing.
    phases : sequence of Phase
        Phases of the motion: their colours lie under the path, their events are marked on it.
    trace : Sample
        Motion over time, with both sides of every event.
    period : float
        Of the drive [s].
    """
    last = float(trace.time[-1])
    first = max(float(trace.time[0]), last - period)
    seen = trace.time >= first
    time, x, y = trace.time[seen], 1e3 * trace.trough_along[seen], 1e3 * trace.trough_normal[seen]
    for phase in phases:
        part = (time >= phase.start) & (time <= phase.end)
        if part.any():
            (band,) = axes.plot(x[part], y[part], linewidth=_BAND, solid_capstyle="butt", zorder=1)
            band.set(color=PHASE_STYLES[phase.kind].colour, alpha=TINT)
    axes.plot(x, y, color=INK, linewidth=1.2)
    marked = np.zeros((0, 2))
    for event in events_of(phases):
        inside = [t for t in event.instants if first < t < last]
        if inside:
            at = np.column_stack((np.interp(inside, time, x), np.interp(inside, time, y)))
            axes.plot(at[:, 0], at[:, 1], zorder=5, **event.mark)
            marked = np.concatenate((marked, at))
    _point(axes, x, y, marked)
    axes.margins(_MARGIN)
    axes.set_aspect("equal")
    axes.locator_params(nbins=_TICKS)
    axes.set_xlabel("trough along itself [mm]")
    axes.set_ylabel("normal to itself [mm]")
    axes.set_title("path of the trough, last cycle", fontsize=9)


def _point(axes: Axes, x: Floats, y: Floats, marked: NDArray[np.float64]) -> None:
    """Show the direction by an arrow where the path is straight, far from all marks."""
    path = np.column_stack((x, y))
    ahead = max(1, round(_AHEAD * x.size))
    pace = np.linalg.norm(path[ahead:] - path[:-ahead], axis=1)
    apart = np.linalg.norm(path[:-ahead, None] - marked[None], axis=2)
    tail = int(np.argmax(pace * apart.min(axis=1, initial=np.ptp(path))))
    if pace.any():
        arrow = {"arrowstyle": "-|>", "color": INK, "mutation_scale": 14}
        axes.annotate("", path[tail + ahead], path[tail], arrowprops=arrow)
