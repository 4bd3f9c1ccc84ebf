"""Pictures of machines: amplitude and speed over frequency, and points with a fitted curve."""

from __future__ import annotations

import math
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

__all__ = ["DrivePicture", "FitPicture", "drive_figure", "fit_figure"]

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


class DrivePicture(NamedTuple):
    """Amplitude and speed of a machine over the frequency of its drive, empty and full.

    Attributes
    ----------
    frequency : (n,) array
        [Hz].
    curves : tuple of pair of (n,) array
        Amplitude [mm] and speed [mm/s], empty, and full if there is a filling; NaN where unknown.
    voltage : tuple of pair of (n,) array
        Amplitudes at the lower and the upper end of the voltage [mm], for each curve; or none.
    drive : float
        Frequency of the drive [Hz].
    points : tuple of pair of float
        Amplitude and speed at the drive, for each curve.
    resonances : tuple of float
        Natural frequencies, empty and full, as far as there are any [Hz].
    hop, slip : (n,) array
        Amplitudes above which bodies hop, and slip [mm]; infinite where they never do.
    full : float
        The filling [kg].
    others : tuple of float
        Amplitudes of further operating points at the drive, with the filling [mm].
    """

    frequency: Floats
    curves: tuple[tuple[Floats, Floats], ...]
    voltage: tuple[tuple[Floats, Floats], ...]
    drive: float
    points: tuple[tuple[float, float], ...]
    resonances: tuple[float, ...]
    hop: Floats
    slip: Floats
    full: float
    others: tuple[float, ...] = ()


_STATES: Final[tuple[Mapping[str, Any], ...]] = (
    {"color": "#004488", "linewidth": 1.8},
    {"color": "#BB5566", "linewidth": 1.8, "linestyle": (0, (5, 1.5))},
)
_STATE_POINTS: Final[tuple[Mapping[str, Any], ...]] = (
    {"marker": "o", "markerfacecolor": "#FFFFFF", "markeredgecolor": "#004488"},
    {"marker": "s", "markerfacecolor": "#FFFFFF", "markeredgecolor": "#BB5566"},
)
_POINT: Final[Mapping[str, Any]] = {
    "markersize": 7.0,
    "markeredgewidth": 2.0,
    "linestyle": "none",
}
_OTHER: Final[Mapping[str, Any]] = {
    "color": "#BB5566", "marker": "x", "markersize": 7.0, "markeredgewidth": 2.0, "linestyle": "none",
}  # fmt: skip
_RESONANCES: Final = (_RESONANCE, {**_RESONANCE, "linestyle": (0, (1, 3))})
_HOP: Final[Mapping[str, Any]] = {"color": INK, "linewidth": 1.1, "linestyle": (0, (7, 2, 1.5, 2))}
_SLIP: Final[Mapping[str, Any]] = {"color": "#8A8A8A", "linewidth": 1.1, "linestyle": (0, (3, 1.5))}
_DRIVE: Final[Mapping[str, Any]] = {"color": INK, "linewidth": 0.8}
_BAND_ALPHA: Final = 0.22
_TALL: Final = (7.4, 7.4)  # [in]
_MOST_ABOVE: Final = 3.5  # of the largest amplitude at the drive: the peak at resonance would hide the rest


def drive_figure(drive: DrivePicture, headline: str, below: str) -> Figure:
    """Draw amplitude above speed, on one axis of frequencies, empty and full.

    Parameters
    ----------
    drive : DrivePicture
        What is drawn.
    headline, below : str
        The first line of the title, and what holds for the whole picture.

    Returns
    -------
    Figure
        Two panels.
    """
    with house_style():
        from vibro.plots.picture import Picture

        figure = Picture(figsize=_TALL)
        above, beneath = figure.subplots(2, 1, sharex=True, height_ratios=(1.25, 1.0))
        legend: dict[str, dict[str, Any]] = {}
        names = ("empty", f"with {drive.full:g} kg")
        x = drive.frequency
        above.set_xlim(float(x[0]), float(x[-1]))
        for i, (amplitude, speed) in enumerate(drive.curves):
            style = dict(_STATES[i])
            above.plot(x, amplitude, **style)
            beneath.plot(x, speed, **style)
            legend[names[i]] = style
        for i, (low, high) in enumerate(drive.voltage):
            face: dict[str, Any] = {"facecolor": _STATES[i]["color"], "alpha": _BAND_ALPHA}
            above.fill_between(x, low, high, linewidth=0.0, **face)
            legend[f"band of voltage, {names[i]}"] = face
        for i, natural in enumerate(drive.resonances):
            for axes in (above, beneath):
                axes.axvline(natural, **_RESONANCES[i])
            legend[f"natural frequency {names[i]}"] = dict(_RESONANCES[i])
        for axes in (above, beneath):
            axes.axvline(drive.drive, zorder=1, **_DRIVE)
        legend["frequency of the drive"] = dict(_DRIVE)
        for i, point in enumerate(drive.points):
            marker: dict[str, Any] = {**_POINT, **_STATE_POINTS[i]}
            for axes, value in zip((above, beneath), point, strict=True):
                axes.plot(drive.drive, value, zorder=6, **marker)
            legend[f"operating point {names[i]}"] = marker
        if drive.others:
            above.plot([drive.drive] * len(drive.others), drive.others, zorder=5, **_OTHER)
            legend[f"other operating points {names[-1]}"] = dict(_OTHER)
        top = _top(drive, 0)
        lines = (drive.hop, _HOP, "bodies hop above"), (drive.slip, _SLIP, "bodies slip above")
        for critical, line, name in lines:
            if (critical < top).any():
                above.plot(x, critical, **line)
                legend[name] = dict(line)
        above.set_ylim(0.0, top)
        beneath.axhline(0.0, color=INK, linewidth=0.5)
        slowest = min(float(np.min(speed, initial=0.0, where=speed < 0.0)) for _, speed in drive.curves)
        beneath.set_ylim(slowest, _top(drive, 1))
        above.set_ylabel("amplitude $A$ [mm]")
        beneath.set_ylabel("mean speed [mm/s]")
        beneath.set_xlabel("frequency of the drive $f$ [Hz]")
        figure.align_ylabels([above, beneath])
        set_heading(figure, headline, below)
        settle(figure, legend)
        return figure


def _top(drive: DrivePicture, which: int) -> float:
    """Return the upper end of amplitudes (0) or speeds (1): above the operating points, not far above."""
    here = max((float(pair[which]) for pair in drive.points if pair[which] > 0.0), default=math.inf)
    highest = max(
        float(np.max(x, initial=0.0, where=x > 0.0)) for x in (pair[which] for pair in drive.curves)
    )
    return 1.05 * min(highest, _MOST_ABOVE * here) or 1.0
