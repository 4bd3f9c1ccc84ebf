"""Pictures of machines: amplitude and speed over frequency, and points with a fitted curve."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from vibro.plots.frame import draw_zero, set_heading, settle, stack
from vibro.plots.style import BLUE, CURVES, INK, RED, SECOND, house_style
from vibro.units import LENGTH

if TYPE_CHECKING:
    from collections.abc import Mapping

    from matplotlib.figure import Figure

    from vibro.machines.fitting import ResponseFit
    from vibro.reals import Floats


_SIZE: Final = (7.4, 5.2)  # [in]
_CURVE: Final[Mapping[str, Any]] = {"color": BLUE, "linewidth": 1.6}
_POINTS: Final[dict[str, Any]] = {"color": RED, "marker": "o", "markersize": 6.0, "linestyle": "none"}
_BAND: Final = "#DDDDDD"


@house_style()
def fit_figure(fit: ResponseFit, x: Floats, headline: str, below: str) -> Figure:
    """Draw measured amplitudes over frequency with the fitted curve and the natural frequency.

    Parameters
    ----------
    fit : ResponseFit
        What is drawn.
    x : array
        Frequencies of the curve [Hz].
    headline, below : str
        The first line of the title, and the estimates.

    Returns
    -------
    Figure
        One panel.
    """
    figure, (axes,) = stack(_SIZE, [1.0])
    amplitude, curve = (LENGTH.from_si(values) for values in (fit.amplitude, fit.amplitudes(x)))
    axes.set_xlim(float(x[0]), float(x[-1]))
    low, high = np.clip(fit.natural_frequency_interval, x[0], x[-1]).tolist()
    if low < high:  # never of NaN
        label = "95 % interval of the natural frequency"
        axes.axvspan(low, high, facecolor=_BAND, edgecolor="none", zorder=0, label=label)
    axes.axvline(fit.natural_frequency, color=INK, linewidth=0.8, label="natural frequency")
    axes.plot(x, curve, label="fitted", **_CURVE)
    label = "measured"
    if np.isfinite(fit.amplitude_error).all():
        label += ", with standard error"
        bars: dict[str, Any] = {"fmt": "none", "ecolor": INK, "elinewidth": 0.8, "capsize": 2}
        axes.errorbar(fit.frequency, amplitude, yerr=amplitude * fit.amplitude_error, **bars)
    axes.plot(fit.frequency, amplitude, zorder=5, label=label, **_POINTS)
    # From 0 to above the largest; where the curve is infinite, above the points.
    axes.set_ylim(0.0, 1.08 * float(min(curve[np.isfinite(curve)].max(), 3.0 * amplitude.max())))
    axes.set(xlabel="frequency $f$ [Hz]", ylabel="amplitude $A$ [mm]")
    set_heading(figure, headline, below)
    settle(figure)
    return figure


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


_EMPTY: Final[Mapping[str, Any]] = {"color": BLUE}
_FULL: Final[Mapping[str, Any]] = {"color": RED, "linestyle": SECOND}
_MARKERS: Final = "os"
_POINT: Final[Mapping[str, Any]] = {"ms": 7.0, "mew": 2.0, "mfc": "#FFFFFF", "linestyle": "none"}
_DRIVE: Final[Mapping[str, Any]] = {"color": INK, "linewidth": 0.8, "zorder": 1}
_BAND_ALPHA: Final = 0.22
_TALL: Final = (7.4, 7.4)  # [in]
_MOST_ABOVE: Final = 3.5  # of the largest amplitude at the drive: the peak at resonance would hide the rest


@house_style()
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
    figure, (above, beneath) = stack(_TALL, (1.25, 1.0))
    x, here = drive.frequency, drive.drive
    above.set_xlim(float(x[0]), float(x[-1]))
    states = ("empty", _EMPTY), (f"with {drive.full:g} kg", _FULL)
    for i, ((name, style), curve) in enumerate(zip(states, drive.curves, strict=False)):
        point: Any = {**_POINT, "marker": _MARKERS[i], "color": style["color"]}
        for axes, values, value in zip((above, beneath), curve, drive.points[i], strict=True):
            axes.plot(x, values, label=name, linewidth=1.8, **style)
            for resonance in drive.resonances[i : i + 1]:
                axes.axvline(resonance, label=f"natural frequency {name}", linewidth=0.8, **style)
            axes.plot(here, value, zorder=6, label=f"operating point {name}", **point)
        for ends in drive.voltage[i : i + 1]:
            face: Any = {"facecolor": style["color"], "alpha": _BAND_ALPHA, "linewidth": 0.0}
            above.fill_between(x, *ends, label=f"band of voltage, {name}", **face)
    for which, axes in enumerate((above, beneath)):
        axes.axvline(here, label="frequency of the drive", **_DRIVE)
        # Up to above the operating points, but not far above.
        highest = max(float(np.nanmax(pair[which], initial=0.0)) for pair in drive.curves)
        at_drive = max((pair[which] for pair in drive.points if pair[which] > 0.0), default=math.inf)
        least = min(float(np.nanmin(pair[which], initial=0.0)) for pair in drive.curves)
        axes.set_ylim(least, 1.05 * min(highest, _MOST_ABOVE * at_drive) or 1.0)
    if drive.others:
        label = f"other operating points {states[len(drive.curves) - 1][0]}"
        other: Any = {**_POINT, "marker": "x", "color": _FULL["color"]}
        above.plot([here] * len(drive.others), drive.others, zorder=5, label=label, **other)
    for critical, name, label in (
        (drive.hop, "hop", "bodies hop above"),
        (drive.slip, "forward_onset", "bodies slip above"),
    ):
        above.plot(x, np.where(np.isfinite(critical), critical, np.nan), label=label, **CURVES[name].look)
    draw_zero(beneath)
    above.set_ylabel("amplitude $A$ [mm]")
    beneath.set(xlabel="frequency of the drive $f$ [Hz]", ylabel="mean speed [mm/s]")
    figure.align_ylabels([above, beneath])
    set_heading(figure, headline, below)
    settle(figure)
    return figure
