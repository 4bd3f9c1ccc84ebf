"""A record beside the computed motion: over time, and with all its cycles on top of each other."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.plots.bands import shade
from vibro.plots.frame import set_heading, settle
from vibro.plots.phases import phase_bands
from vibro.plots.style import INK, SECOND, house_style, values_text

if TYPE_CHECKING:
    from collections.abc import Mapping

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from vibro.records.comparison import Comparison

    Floats = NDArray[np.float64]

_MEASURED: Final[Mapping[str, Any]] = {
    "label": "measured",
    "color": "#004488",
    "marker": ".",
    "linestyle": "none",
    "alpha": 0.75,
}
_COMPUTED: Final[Mapping[str, Any]] = {"label": "computed", "color": "#BB5566", "linewidth": 1.6}
_FITTED: Final[Mapping[str, Any]] = {
    "label": "computed, fitted",
    "color": INK,
    "linewidth": 1.2,
    "linestyle": SECOND,
}
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
    names = list(comparison.observation.signals)
    models = [(comparison, _COMPUTED)] + ([(fitted, _FITTED)] if fitted else [])
    if fitted and fitted.recorded.absolute:
        # The trough's motion was subtracted at each scene's place in the cycle: that of the fit is better.
        comparison = fitted
    with house_style():
        from vibro.plots.picture import Picture

        figure = Picture(figsize=(10.0, 1.4 + _ROW * len(names)))
        grid = figure.subplots(len(names), 2, squeeze=False, sharex="col", width_ratios=(1.6, 1.0))
        for row, name in zip(grid, names, strict=True):
            label, unit, size = _SIGNALS[name]
            row[0].set_ylabel(f"{label}\n[{unit}]")
            _over_time(row[0], comparison, name, size)
            _on_one_cycle(row[1], comparison, name, size)
            for model, style in models:
                _draw_model(row, comparison, model, name, size, style)
            for axes in row:
                _draw_zero(axes)
        grid[0][0].set_title(f"first {_SHOWN} cycles of the record")
        grid[0][1].set_title("all cycles on one")
        grid[-1][0].set_xlabel("time of the record [ms]")
        zero = f"the trough's middle, {comparison.passing}" if comparison.passing else "phase 0 of the drive"
        grid[-1][1].set_xlabel(f"time after {zero} [ms]")
        figure.align_ylabels(grid[:, 0])
        set_heading(figure, title, values_text(given))
        settle(figure)
        return figure


def _over_time(axes: Axes, comparison: Comparison, name: str, size: float) -> None:
    """Draw the first cycles of the record, and shade the computed slides."""
    time = comparison.observation.time
    period = comparison.motion.period
    end = float(time[0]) + _SHOWN * period
    shown = time <= end
    axes.plot(1e3 * time[shown], comparison.observation.signals[name][shown] / size, **_MEASURED)
    shift = float(comparison.trough_time[0] - time[0])
    first = math.floor(float(comparison.trough_time[0]) / period)
    _shade(axes, comparison, range(first - 1, first + _SHOWN + 2), shift)
    axes.set_xlim(1e3 * float(time[0]), 1e3 * end)


def _on_one_cycle(axes: Axes, comparison: Comparison, name: str, size: float) -> None:
    """Draw every sample at its time within its cycle; displacements start from 0 in each."""
    period = comparison.motion.period
    turns = np.floor(comparison.trough_time / period)
    time = comparison.trough_time - turns * period
    values = comparison.observation.signals[name]
    if name == "displacement":
        advance = next(row.measured.value for row in comparison.rows if row.key == "stroke_advance")
        values = values - turns * advance
        early = time < _EARLY * period
        values = values - float((values[early] - _at(comparison, name, time[early])).mean())
    axes.plot(1e3 * time, values / size, markersize=3, **_MEASURED)
    _shade(axes, comparison, range(-1, 2), 0.0)
    axes.set_xlim(0.0, 1e3 * period)


def _draw_model(
    row: NDArray[Any], comparison: Comparison, model: Comparison, name: str, size: float, style: Any
) -> None:
    """Draw a computed signal in both panels, shifted from the clock of the model to that of the record."""
    observation, period = comparison.observation, comparison.motion.period
    start = float(observation.time[0])
    shift = float(model.trough_time[0]) - start
    time = start + period * np.linspace(0.0, _SHOWN, _SHOWN * _POINTS)
    values = _at(model, name, time + shift)
    if name == "displacement":
        values = values - values[0] + observation.signals[name][0]
    row[0].plot(1e3 * time, values / size, **style)
    cycle = np.linspace(0.0, period, _POINTS)
    values = _at(model, name, cycle + float(model.trough_time[0] - comparison.trough_time[0]))
    if name == "displacement":
        values = values - values[0]
    row[1].plot(1e3 * cycle, values / size, **style)


def _draw_zero(axes: Axes) -> None:
    """Draw a line at zero where the curves reach it: of a record far from zero it would squeeze them."""
    low, high = axes.get_ylim()
    if low < 0.0 < high:
        axes.axhline(0.0, color=INK, linewidth=0.5)
        axes.set_ylim(low, high)


def _at(model: Comparison, name: str, trough_time: Floats) -> Floats:
    """Take a signal at any time from its curve over one cycle."""
    period = model.motion.period
    turns = np.floor(trough_time / period)
    values = np.interp(trough_time - turns * period, model.curve_time, model.curves[name])
    return values + turns * model.motion.advance if name == "displacement" else values


def _shade(axes: Axes, comparison: Comparison, turns: range, shift: float) -> None:
    for turn in turns:
        later = turn * comparison.motion.period - shift
        slides = [phase for phase in comparison.motion.phases if phase.kind != "_"]
        shade(axes, phase_bands(slides, later=later), named=True)
