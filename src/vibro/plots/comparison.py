"""A record beside the computed motion: over time, and with all its cycles on top of each other."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.plots.frame import Picture, draw_zero, set_heading, settle, shade
from vibro.plots.history import phase_bands
from vibro.plots.style import BLUE, INK, RED, SECOND, house_style, values_text

if TYPE_CHECKING:
    from collections.abc import Mapping

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from vibro.reals import Floats
    from vibro.records.comparison import Comparison

    Look = Mapping[str, Any]
    Models = list[tuple[Comparison, Look]]

_MEASURED: Final[Look] = {
    "label": "measured", "color": BLUE, "marker": ".", "linestyle": "none", "alpha": 0.75,
}  # fmt: skip
_COMPUTED: Final[Look] = {"label": "computed", "color": RED, "linewidth": 1.6}
_FITTED: Final[Look] = {"label": "computed, fitted", "color": INK, "linewidth": 1.2, "linestyle": SECOND}
_POINTS: Final = 1001  # of a computed curve, in each cycle
# A record's displacement has no known zero. Over this first part of the cycle its mean is made the model's.
_EARLY: Final = 0.08
_SHOWN: Final = 3  # cycles in the panels over time
_ROW: Final = 2.1  # [in]
# name -> label, unit, size of the unit in SI units
_SIGNALS: Final = {
    "displacement": ("relative displacement", "mm", 1e-3),
    "velocity": ("relative velocity", "mm/s", 1e-3),
    "acceleration": ("relative acceleration", "m/s²", 1.0),
    "friction": ("friction per unit mass", "m/s²", 1.0),
}


@house_style()
def comparison_figure(
    comparison: Comparison, title: str, given: Mapping[str, float], fitted: Comparison | None = None
) -> Figure:
    """Draw a comparison.

    Parameters
    ----------
    comparison : Comparison
        Record and model.
    title : str
        Names of the record and the scene.
    given : mapping of str to float
        Quantities of the scene, in the user's units, written under the title.
    fitted : Comparison, optional
        The same record beside a scene that was fitted to it.

    Returns
    -------
    Figure
        One row for each signal: the first cycles over time, and all cycles on top of each other.
    """
    models = [(comparison, _COMPUTED)] + ([(fitted, _FITTED)] if fitted else [])
    if fitted and fitted.recorded.absolute:
        # The trough's motion was subtracted at each scene's place in the cycle: that of the fit is better.
        comparison = fitted
    signals = comparison.observation.signals
    figure = Picture(figsize=(10.0, 1.4 + _ROW * len(signals)))
    grid = figure.subplots(len(signals), 2, squeeze=False, sharex="col", width_ratios=(1.6, 1.0))
    for row, name in zip(grid, signals, strict=True):
        row[0].set_ylabel("{}\n[{}]".format(*_SIGNALS[name]))
        _draw_over_time(row[0], comparison, models, name)
        _draw_on_one_cycle(row[1], comparison, models, name)
    grid[0][0].set_title(f"first {_SHOWN} cycles of the record")
    grid[0][1].set_title("all cycles on one")
    grid[-1][0].set_xlabel("time of the record [ms]")
    zero = f"the trough's middle, {comparison.passing}" if comparison.passing else "phase 0 of the drive"
    grid[-1][1].set_xlabel(f"time after {zero} [ms]")
    figure.align_ylabels(grid[:, 0])
    set_heading(figure, title, values_text(given))
    settle(figure)
    return figure


def _draw_over_time(axes: Axes, comparison: Comparison, models: Models, name: str) -> None:
    """Draw the first cycles of the record."""
    time, values = comparison.observation.time, comparison.observation.signals[name]
    start, period = float(time[0]), comparison.motion.period
    shown = time <= start + _SHOWN * period
    whole = start + period * np.linspace(0.0, _SHOWN, _SHOWN * _POINTS)
    later = start - float(comparison.trough_time[0])
    axes.plot(1e3 * time[shown], values[shown] / _SIGNALS[name][2], **_MEASURED)
    _draw_computed(axes, comparison, models, name, whole, later, float(values[0]))


def _draw_on_one_cycle(axes: Axes, comparison: Comparison, models: Models, name: str) -> None:
    """Draw every sample at its time within its cycle; displacements start from 0 in each."""
    period, values = comparison.motion.period, comparison.observation.signals[name]
    turns = np.floor(comparison.trough_time / period)
    time = comparison.trough_time - turns * period
    if name == "displacement":
        advance = next(row.measured.value for row in comparison.rows if row.key == "stroke_advance")
        values = values - turns * advance
        early = time < _EARLY * period
        values = values - float((values[early] - _at(comparison, name, time[early])).mean())
    axes.plot(1e3 * time, values / _SIGNALS[name][2], **{**_MEASURED, "markersize": 3.0})
    _draw_computed(axes, comparison, models, name, np.linspace(0.0, period, _POINTS), 0.0, 0.0)


def _draw_computed(
    axes: Axes, comparison: Comparison, models: Models, name: str, time: Floats, later: float, start: float
) -> None:
    """Draw computed curves, and shade the computed slides, over times that are later than the trough's."""
    first, period = comparison.trough_time[0], comparison.motion.period
    for model, look in models:
        computed = _at(model, name, time - later + float(model.trough_time[0] - first))
        if name == "displacement":
            computed = computed - computed[0] + start
        axes.plot(1e3 * time, computed / _SIGNALS[name][2], **look)
    slides = [phase for phase in comparison.motion.phases if phase.kind != "_"]
    turns = np.floor((time[[0, -1]] - later) / period)
    for turn in np.arange(turns[0] - 1.0, turns[1] + 2.0).tolist():
        shade(axes, phase_bands(slides, later=turn * period + later), named=True)
    draw_zero(axes)
    axes.set_xlim(1e3 * time[0], 1e3 * time[-1])


def _at(model: Comparison, name: str, trough_time: Floats) -> Floats:
    """Take a signal at any time from its curve over one cycle."""
    turns = np.floor(trough_time / model.motion.period)
    values = np.interp(trough_time - turns * model.motion.period, model.curve_time, model.curves[name])
    return values + turns * model.motion.advance if name == "displacement" else values
