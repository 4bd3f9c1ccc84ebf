"""Marks of the fastest forwards and backwards in pictures of speeds."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.plots.style import INK, number_text, values_text
from vibro.results.sweep import peaks

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from vibro.axes import Axis
    from vibro.plots.view import Panel
    from vibro.results.sweep import Peak

    Floats = NDArray[np.float64]
    Legend = dict[str, dict[str, Any]]

__all__ = ["draw_peaks"]

_MARKERS: Final = {"fastest": "^", "fastest_backwards": "v"}
_MARKER: Final[dict[str, Any]] = {
    "linestyle": "none",
    "markersize": 9.0,
    "markerfacecolor": "none",
    "markeredgecolor": INK,
    "markeredgewidth": 1.8,
}
_HALO: Final = 4.0  # [pt] width of the white around a marker, over any colours and hatches


def draw_peaks(
    axes: Sequence[Axes], panels: Sequence[Panel], varying: Iterable[Axis | None], legend: Legend
) -> list[Floats]:
    """Mark the fastest of all panels, forwards and backwards.

    Parameters
    ----------
    axes : sequence of Axes
        Where each panel is drawn, some maybe on the same axes.
    panels : sequence of Panel
        With their speeds.
    varying : iterable of Axis or None
        The axes whose values the legend shows.
    legend : dict of str to dict
        Receives the speed and its place, with the style of the mark.

    Returns
    -------
    list of (n, 2) array
        The points marked on each panel; of lines, their height is the speed [mm/s].
    """
    from matplotlib.patheffects import withStroke

    found = [_peaks(panel) for panel in panels]
    points: list[list[tuple[float, float]]] = [[] for _ in panels]
    for name, marker in _MARKERS.items():
        with_one = [i for i, of_panel in enumerate(found) if name in of_panel]
        if not with_one:
            continue
        i = max(with_one, key=lambda i: abs(found[i][name].speed))
        peak, x, y = found[i][name], panels[i].x, panels[i].y
        point = peak.values[x.name], peak.values[y.name] if y else peak.speed
        names = [axis.name for axis in varying if axis is not None]
        place = values_text({key: peak.values[key] for key in names}, all_of_them=True)
        label = f"{name.replace('_', ' ')}: {number_text(peak.speed)} mm/s at {place}"
        halo = withStroke(linewidth=_HALO, foreground="#FFFFFF")
        legend[label] = {**_MARKER, "marker": marker, "path_effects": [halo]}
        axes[i].plot(
            *zip(point, strict=True), zorder=6, gid=name, label=label, clip_on=False, **legend[label]
        )
        points[i].append(point)
    return [np.reshape(marked, (-1, 2)) for marked in points]


def _peaks(panel: Panel) -> dict[str, Peak]:
    values: dict[str, Any] = {**panel.values, panel.x.name: panel.x.values}
    if panel.y is not None:
        values[panel.y.name] = panel.y.values[:, np.newaxis]
    return peaks(panel.cycle["mean_velocity"], panel.cycle["mean_velocity_error"], values)
