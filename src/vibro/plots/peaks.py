"""Marks of the fastest forwards and backwards in pictures of speeds."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.plots.frame import place_on
from vibro.plots.style import INK, number_text, values_text

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from vibro.plots.view import Panel
    from vibro.results.sweep import SweepResult

    Floats = NDArray[np.float64]

_MARKERS: Final = {"fastest": "^", "fastest_backwards": "v"}
_MARKER: Final[dict[str, Any]] = {
    "linestyle": "none",
    "markersize": 9.5,
    "markerfacecolor": "none",
    "markeredgecolor": INK,
    "markeredgewidth": 1.8,
}
_HALO: Final = 4.0  # [pt] width of the white around a marker, over any colours and hatches


def draw_peaks(result: SweepResult, axes: Sequence[Axes], panels: Sequence[Panel]) -> list[Floats]:
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
    from matplotlib.patheffects import withStroke

    marked = [np.empty((0, 2)) for _ in panels]
    for name, marker in _MARKERS.items():
        peak = result.fastest.get(name)
        if peak is None:
            continue
        label = f"{name.replace('_', ' ')}: {number_text(peak.speed)} mm/s at "
        label += values_text({axis: peak.values[axis] for axis in result.axes}, all_of_them=True)
        look = {
            **_MARKER,
            "marker": marker,
            "path_effects": [withStroke(linewidth=_HALO, foreground="#FFFFFF")],
        }
        for i, panel in enumerate(panels):
            point = place_on(panel, {k: v for k, v in peak.values.items() if np.isfinite(v)})
            if len(point):
                point[:, 1] = point[:, 1] if panel.y else peak.speed
                axes[i].plot(*point.T, zorder=6, gid=name, label=label, clip_on=False, **look)
                marked[i] = np.concatenate([marked[i], point])
    return marked
