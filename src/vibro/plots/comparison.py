"""A record beside the computed motion: over time, and with all its cycles on top of each other."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.plots.frame import Picture, set_heading, settle, shade
from vibro.plots.history import phase_bands
from vibro.plots.style import INK, SECOND, house_style, values_text

if TYPE_CHECKING:
    from collections.abc import Mapping

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from vibro.records.comparison import Comparison

    Floats = NDArray[np.float64]
    Look = Mapping[str, Any]

_MEASURED: Final[Look] = {
    "label": "measured", "color": "#004488", "marker": ".", "linestyle": "none", "alpha": 0.75,
}  # fmt: skip
_COMPUTED: Final[Look] = {"label": "computed", "color": "#BB5566", "linewidth": 1.6}
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
    with house_style():
        figure = Picture(figsize=(10.0, 1.4 + _ROW * len(signals)))
        grid = figure.subplots(len(signals), 2, squeeze=False, sharex="col", width_ratios=(1.6, 1.0))
        for (over_time, on_one), name in zip(grid, signals, strict=True):
            label, unit, size = _SIGNALS[name]
            over_time.set_ylabel(f"{label}\n[{unit}]")
            _draw_over_time(over_time, comparison, models, name, size)
            _draw_on_one_cycle(on_one, comparison, models, name, size)
        grid[0][0].set_title(f"first {_SHOWN} cycles of the record")
        grid[0][1].set_title("all cycles on one")
        grid[-1][0].set_xlabel("time of the record [ms]")
        zero = f"the trough's middle, {comparison.passing}" if comparison.passing else "phase 0 of the drive"
        grid[-1][1].set_xlabel(f"time after {zero} [ms]")
        figure.align_ylabels(grid[:, 0])
        set_heading(figure, title, values_text(given))
        settle(figure)
        return figure


def _draw_over_time(
    axes: Axes, comparison: Comparison, models: list[tuple[Comparison, Look]], name: str, size: float
) -> None:
    """Draw the first cycles of the record, and shade the computed slides."""
    time, values = comparison.observation.time, comparison.observation.signals[name]
    start, period = float(time[0]), comparison.motion.period
    shown = time <= start + _SHOWN * period
    axes.plot(1e3 * time[shown], values[shown] / size, **_MEASURED)
    whole = start + period * np.linspace(0.0, _SHOWN, _SHOWN * _POINTS)
    for model, look in models:
        computed = _at(model, name, whole + float(model.trough_time[0]) - start)
        if name == "displacement":
            computed = computed - computed[0] + values[0]
        axes.plot(1e3 * whole, computed / size, **look)
    first = float(comparison.trough_time[0])
    turn = math.floor(first / period)
    _finish(axes, comparison, range(turn - 1, turn + _SHOWN + 2), start - first, (start, whole[-1]))


def _draw_on_one_cycle(
    axes: Axes, comparison: Comparison, models: list[tuple[Comparison, Look]], name: str, size: float
) -> None:
    """Draw every sample at its time within its cycle; displacements start from 0 in each."""
    period, values = comparison.motion.period, comparison.observation.signals[name]
    turns = np.floor(comparison.trough_time / period)
    time = comparison.trough_time - turns * period
    if name == "displacement":
        advance = next(row.measured.value for row in comparison.rows if row.key == "stroke_advance")
        values = values - turns * advance
        early = time < _EARLY * period
        values = values - float((values[early] - _at(comparison, name, time[early])).mean())
    axes.plot(1e3 * time, values / size, markersize=3, **_MEASURED)
    whole = np.linspace(0.0, period, _POINTS)
    for model, look in models:
        computed = _at(model, name, whole + float(model.trough_time[0] - comparison.trough_time[0]))
        if name == "displacement":
            computed = computed - computed[0]
        axes.plot(1e3 * whole, computed / size, **look)
    _finish(axes, comparison, range(-1, 2), 0.0, (0.0, period))


def _at(model: Comparison, name: str, trough_time: Floats) -> Floats:
    """Take a signal at any time from its curve over one cycle."""
    turns = np.floor(trough_time / model.motion.period)
    values = np.interp(trough_time - turns * model.motion.period, model.curve_time, model.curves[name])
    return values + turns * model.motion.advance if name == "displacement" else values


def _finish(
    axes: Axes, comparison: Comparison, turns: range, later: float, ends: tuple[float, float]
) -> None:
    """Shade the computed slides of some turns, so much later; draw zero where curves reach it."""
    slides = [phase for phase in comparison.motion.phases if phase.kind != "_"]
    for turn in turns:
        shade(axes, phase_bands(slides, later=turn * comparison.motion.period + later), named=True)
    low, high = axes.get_ylim()
    if low < 0.0 < high:  # a record far from zero would be squeezed by it
        axes.axhline(0.0, color=INK, linewidth=0.5)
    axes.set(xlim=(1e3 * ends[0], 1e3 * ends[1]), ylim=(low, high))
