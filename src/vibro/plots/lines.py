"""Pictures of one axis: numbers over bands that show the regimes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import groupby, pairwise
from typing import TYPE_CHECKING, Any, Final, Protocol

import numpy as np

from vibro.core.codes import Regime, Status
from vibro.plots.fields import zero_points
from vibro.plots.frame import (
    headline,
    make_logarithmic,
    mark_operating_point,
    operating_points,
    renderer_of,
    scale_axis,
    set_heading,
    settle,
)
from vibro.plots.labels import outline
from vibro.plots.layers import BEGINS_AT, hiding_fields
from vibro.plots.style import (
    AVERAGED_LABEL,
    COEXISTS_HATCH,
    COEXISTS_LABEL,
    CURVES,
    INK,
    NO_ANSWER_FACE,
    NO_ANSWER_HATCH,
    NO_ANSWER_INK,
    REGIME_COLOURS,
    axis_label,
    ink_on,
    number_text,
    value_text,
    values_text,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from vibro.plots.fields import Fields
    from vibro.results.sweep import SweepResult

    Floats = NDArray[np.float64]

__all__ = ["Band", "flight_line", "impact_line", "name_bands", "speed_lines", "traverse_line"]

_TINT: Final = 0.35  # opacity of bands behind lines
_MARKED: Final = 60  # values on the axis, up to which each is marked
_WIDE: Final = 20.0  # ratio of the largest to the least number above which a scale is logarithmic
_HEADROOM: Final = 0.15  # above a level, for its name
_MILLIMETRE: Final = 1e3  # [1/m]


def speed_lines(result: SweepResult, fields: Fields, level: float | None = None) -> Figure:
    """Mean conveying speed and displacement per cycle over the axis; a level of speed is marked [mm/s]."""
    cycle = fields.panel.cycle
    rows = {
        "mean conveying speed [mm/s]": _MILLIMETRE * cycle["mean_velocity"][0],
        "displacement per cycle [mm]": _MILLIMETRE * cycle["displacement_per_cycle"][0],
    }
    figure = _figure(result, fields, "Mean conveying speed", rows)
    if level is not None:
        _, speeds, _ = figure.axes
        low, high = speeds.get_ylim()
        speeds.axhline(level, color=INK, linewidth=2.2, linestyle=(0, (1, 1)), zorder=2.5, gid="level")
        speeds.set_ylim(low, max(high, level + _HEADROOM * (level - low)))
        place = (0.005, level), (0, 3), ("axes fraction", "data"), "offset points"
        outline(speeds.annotate(f"{number_text(level)} mm/s", *place), "#FFFFFF")
    return figure


def impact_line(result: SweepResult, fields: Fields) -> Figure:
    """Largest normal speed of a landing over the axis."""
    speed = _MILLIMETRE * fields.panel.cycle["impact_velocity"][0]
    return _figure(result, fields, "Impact speed", {"impact speed [mm/s]": speed})


def flight_line(result: SweepResult, fields: Fields) -> Figure:
    """Share of the time in flight over the axis."""
    share = fields.panel.cycle["flight_fraction"][0]
    return _figure(result, fields, "Time in flight", {"share of time in flight": share})


def traverse_line(result: SweepResult, fields: Fields) -> Figure:
    """Time to convey over the trough's length at the mean speed."""
    length = result.length or math.nan
    velocity = fields.panel.cycle["mean_velocity"][0]
    with np.errstate(divide="ignore", invalid="ignore"):
        time = np.where(velocity > 0.0, length / (_MILLIMETRE * velocity), np.nan)
    figure = _figure(result, fields, f"Traverse time over {length:.6g} mm", {"traverse time [s]": time})
    known = time[np.isfinite(time)]
    if known.size and known.max() > _WIDE * known.min():
        make_logarithmic(figure.axes[1].yaxis, known.min(), known.max())
    return figure


class Band(Protocol):
    """A stretch of the axis with a name and a look of its own."""

    @property
    def low(self) -> float:
        """Where it begins."""

    @property
    def high(self) -> float:
        """Where it ends."""

    @property
    def name(self) -> str:
        """What it is called."""

    @property
    def style(self) -> dict[str, Any]:
        """How it is filled."""


@dataclass(frozen=True)
class _Band:
    """A stretch of the axis over which regime and status stay the same."""

    low: float
    high: float
    regime: Regime
    unanswered: Status | None
    coexists: bool

    @property
    def style(self) -> dict[str, Any]:
        """How the band is filled."""
        if self.unanswered is not None and self.unanswered is not Status.FLIGHT_NOT_MODELLED:
            hatch = NO_ANSWER_HATCH[self.unanswered]
            return {"facecolor": NO_ANSWER_FACE, "edgecolor": NO_ANSWER_INK, "hatch": hatch}
        return {"facecolor": REGIME_COLOURS[self.regime]}

    @property
    def name(self) -> str:
        """What the band is called."""
        if self.unanswered is not None and self.unanswered is not Status.FLIGHT_NOT_MODELLED:
            return self.unanswered.label.replace("-", " ")
        return self.regime.label


def _figure(result: SweepResult, fields: Fields, heading: str, rows: dict[str, Floats]) -> Figure:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.4, 2.2 + 2.1 * len(rows)))
    strip, *axes = figure.subplots(1 + len(rows), 1, sharex=True, height_ratios=[0.13, *[1.0] * len(rows)])
    set_heading(figure, headline(heading, result), values_text(fields.panel.values))
    bands = _bands(fields)
    legend: dict[str, dict[str, Any]] = {}
    for a, (label, values) in zip(axes, rows.items(), strict=True):
        _shade(a, bands, legend)
        _line(a, fields, values, legend)
        a.set_ylabel(label)
        _critical_lines(a, fields, legend)
        for point in operating_points(result, fields.panel):
            height = np.interp(point[0], fields.panel.x.values, values)
            mark_operating_point(a, np.array([[point[0], height]]), legend)
    scale_axis(strip.xaxis, fields.panel.x)
    axes[-1].set_xlabel(axis_label(fields.panel.x))
    figure.align_ylabels(axes)
    settle(figure, legend)
    if unnamed := name_bands(figure, strip, bands):
        settle(figure, unnamed | legend)
    return figure


def _bands(fields: Fields) -> list[_Band]:
    """Cut the axis wherever the regime or the status changes."""
    unanswered = {s: fields.unanswered(s) for s in NO_ANSWER_HATCH if s in fields.statuses}
    cuts = [zero_points(fields, fields.log_ratio[c], hiding_fields(fields, c)) for c in BEGINS_AT.values()]
    cuts += [zero_points(fields, field) for field in (*unanswered.values(), fields.coexists)]
    edges = np.unique(np.concatenate([fields.x[[0, -1]], *cuts]))
    bands: list[_Band] = []
    for low, high in pairwise(edges):
        middle = int(np.argmin(np.abs(fields.x - 0.5 * (low + high))))
        status = next((s for s, field in unanswered.items() if field[0, middle] > 0.0), None)
        regime = Regime(int(fields.panel.cycle["regime"][0, middle]))
        bands.append(_Band(float(low), float(high), regime, status, bool(fields.coexists[0, middle] > 0.0)))
    return bands


def _shade(axes: Axes, bands: list[_Band], legend: dict[str, dict[str, Any]]) -> None:
    for band in bands:
        style = band.style
        if "hatch" not in style:
            style = {**style, "alpha": _TINT, "linewidth": 0.0}
        axes.axvspan(band.low, band.high, zorder=0, gid=band.name, **style)
        extra = [(COEXISTS_LABEL, COEXISTS_HATCH)] if band.coexists else []
        if band.unanswered is Status.FLIGHT_NOT_MODELLED:
            extra.append((band.unanswered.label.replace("-", " "), NO_ANSWER_HATCH[band.unanswered]))
        for label, hatch in extra:
            style = {"facecolor": "none", "edgecolor": NO_ANSWER_INK, "hatch": hatch}
            axes.axvspan(band.low, band.high, zorder=0.5, linewidth=0.0, gid=label, **style)
            legend[label] = style


def _critical_lines(axes: Axes, fields: Fields, legend: dict[str, dict[str, Any]]) -> None:
    for name, style in CURVES.items():
        for x in zero_points(fields, fields.log_ratio[name], hiding_fields(fields, name)):
            look = {"color": INK, "linestyle": style.dashes, "linewidth": style.width}
            label = f"{style.label}: {value_text(fields.panel.x.name, x)}"
            axes.axvline(x, zorder=2, gid=name, label=label, **look)
            legend[label] = look


def _line(axes: Axes, fields: Fields, values: Floats, legend: dict[str, dict[str, Any]]) -> None:
    """Draw numbers as a line, broken where regimes meet, since the numbers jump there; means as dots."""
    x = fields.panel.x.values
    averaged = fields.panel.cycle["status"][0] == Status.AVERAGED
    if averaged.any():
        dots: dict[str, Any] = {"color": INK, "linestyle": "none", "marker": ".", "markersize": 3.0}
        axes.plot(x[averaged], values[averaged], gid=AVERAGED_LABEL, zorder=3, **dots)
        legend[AVERAGED_LABEL] = dots
    regime = fields.panel.cycle["regime"][0]
    jumps = np.flatnonzero(regime[1:] != regime[:-1]) + 1
    # A value alone in its regime makes no line: few values are marked.
    mark: dict[str, Any] = {"marker": "o", "markersize": 4.0} if x.size <= _MARKED else {}
    axes.plot(
        np.insert(x, jumps, np.nan),
        np.insert(np.where(averaged, np.nan, values), jumps, np.nan),
        color=INK,
        linewidth=1.8,
        gid="numbers",
        zorder=3,
        **mark,
    )
    finite = values[np.isfinite(values)]
    if finite.size and finite.min() < 0.0:
        axes.axhline(0.0, color=INK, linewidth=0.8, zorder=1)
    axes.grid(axis="y", color="#BBBBBB", linewidth=0.5, zorder=0.8)


def name_bands(figure: Figure, strip: Axes, bands: Sequence[Band]) -> dict[str, dict[str, Any]]:
    """Write the names of bands into a strip above the axes; return the styles of those that find no room."""
    strip.set_yticks([])
    strip.tick_params(axis="x", which="both", bottom=False, labelbottom=False)
    renderer = renderer_of(figure)
    to_pixels = strip.transData
    unnamed: dict[str, dict[str, Any]] = {}
    for name, group in groupby(bands, key=lambda band: band.name):
        run = list(group)
        low, high, style = run[0].low, run[-1].high, run[0].style
        strip.axvspan(low, high, gid=name, **{"linewidth": 0.0, **style})
        left, right = to_pixels.transform([(low, 0.0), (high, 0.0)])[:, 0]
        middle = to_pixels.inverted().transform((0.5 * (left + right), 0.0))[0]
        text = strip.text(
            middle,
            0.5,
            name,
            transform=strip.get_xaxis_transform(),
            ha="center",
            va="center_baseline",
            color=ink_on(style["facecolor"]),
            fontsize=9.0,
        )
        if "hatch" in style:
            outline(text, style["facecolor"])
        if text.get_window_extent(renderer).width > right - left - 4.0:
            text.remove()
            unnamed[name] = style
    return unnamed
