"""Pictures of machines: amplitude and speed over frequency, and points with a fitted curve."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from vibro.plots.frame import set_heading, settle
from vibro.plots.style import INK, house_style

if TYPE_CHECKING:
    from collections.abc import Mapping

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

__all__ = ["FitPicture", "fit_figure"]

_SIZE: Final = (7.4, 5.2)  # [in]
_CURVE: Final[Mapping[str, Any]] = {"color": "#004488", "linewidth": 1.6}
_POINTS: Final[Mapping[str, Any]] = {
    "color": "#BB5566",
    "marker": "o",
    "markersize": 5.0,
    "linestyle": "none",
    "markeredgecolor": INK,
    "markeredgewidth": 0.6,
}
_RESONANCE: Final[Mapping[str, Any]] = {"color": INK, "linewidth": 1.0, "linestyle": (0, (1, 1.5))}
_BAND: Final = "#DDDDDD"


class FitPicture(NamedTuple):
    """Points, and the curve that is fitted to them.

    Attributes
    ----------
    frequency, amplitude, error : (n,) array
        The points [Hz, mm], and their standard errors [mm]; NaN where unknown.
    curve_frequency, curve_amplitude : (m,) array
        The fitted curve [Hz, mm].
    natural_frequency : float
        Estimate [Hz]; NaN without one.
    interval : pair of float
        Its confidence interval [Hz]; NaN, 0 or infinite where unknown.
    """

    frequency: Floats
    amplitude: Floats
    error: Floats
    curve_frequency: Floats
    curve_amplitude: Floats
    natural_frequency: float
    interval: tuple[float, float]


def fit_figure(fit: FitPicture, headline: str, below: str) -> Figure:
    """Draw measured amplitudes over frequency with the fitted curve and the natural frequency.

    Parameters
    ----------
    fit : FitPicture
        What is drawn.
    headline, below : str
        The first line of the title, and the estimates.

    Returns
    -------
    Figure
        One panel.
    """
    with house_style():
        from vibro.plots.picture import Picture

        figure = Picture(figsize=_SIZE)
        axes = figure.subplots()
        legend: dict[str, dict[str, Any]] = {}
        x = fit.curve_frequency
        axes.set_xlim(float(x[0]), float(x[-1]))
        low, high = (min(max(end, float(x[0])), float(x[-1])) for end in fit.interval)
        if low < high:  # never of NaN
            axes.axvspan(low, high, facecolor=_BAND, edgecolor="none", zorder=0)
            legend["95 % interval of the natural frequency"] = {"facecolor": _BAND}
        if x[0] <= fit.natural_frequency <= x[-1]:
            axes.axvline(fit.natural_frequency, **_RESONANCE)
            legend["natural frequency"] = dict(_RESONANCE)
        axes.plot(x, fit.curve_amplitude, **_CURVE)
        legend["fitted"] = dict(_CURVE)
        if np.isfinite(fit.error).all():
            axes.errorbar(
                fit.frequency,
                fit.amplitude,
                yerr=fit.error,
                fmt="none",
                ecolor=INK,
                elinewidth=0.8,
                capsize=2,
            )
        axes.plot(fit.frequency, fit.amplitude, zorder=5, **_POINTS)
        legend["measured" + (", with standard error" if np.isfinite(fit.error).all() else "")] = dict(_POINTS)
        _from_zero(axes, fit.curve_amplitude, fit.amplitude)
        axes.set_xlabel("frequency $f$ [Hz]")
        axes.set_ylabel("amplitude $A$ [mm]")
        set_heading(figure, headline, below)
        settle(figure, legend)
        return figure


def _from_zero(axes: Axes, *values: Floats) -> None:
    """Let amplitudes begin at 0, and end above the largest: where a curve is infinite, above the points."""
    finite = np.concatenate([x[np.isfinite(x)] for x in values])
    axes.set_ylim(0.0, 1.08 * float(min(finite.max(), 3.0 * values[-1].max())))
