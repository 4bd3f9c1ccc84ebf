"""Pictures of one range: numbers over bands that show the regimes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import groupby, pairwise
from typing import TYPE_CHECKING, Any, Final, Protocol

import numpy as np

from vibro.core.codes import Regime, Status
from vibro.plots.fields import BEGINS_AT, hiding_fields, zero_points
from vibro.plots.frame import (
    below,
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
from vibro.plots.peaks import draw_peaks
from vibro.plots.style import (
    AVERAGED_LABEL,
    BACKWARDS_HATCH,
    BACKWARDS_LABEL,
    COEXISTS_HATCH,
    COEXISTS_LABEL,
    CURVES,
    ERROR_LABEL,
    INK,
    NO_ANSWER_FACE,
    NO_ANSWER_HATCH,
    NO_ANSWER_INK,
    REGIME_COLOURS,
    axis_label,
    ink_on,
    number_text,
    value_text,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from vibro.plots.fields import Fields
    from vibro.results.sweep import SweepResult

    Floats = NDArray[np.float64]

__all__ = [
    "UNCERTAIN",
    "Band",
    "Stretch",
    "draw_numbers",
    "finish_numbers",
    "line_figure",
    "name_bands",
    "numbers_of",
    "overlays",
    "stretches",
    "write_name",
]

#: Pictures of quantities that follow from the mean speed.
UNCERTAIN: Final = ("speed", "traverse")
_TINT: Final = 0.35  # opacity of bands behind lines
_MARKED: Final = 60  # most values on the axis that are marked each
_WIDE: Final = 20.0  # ratio of the largest to the least number above which a scale is logarithmic
_HEADROOM: Final = 0.15  # above a target speed, for its name
_MILLIMETRE: Final = 1e3  # [1/m]
_DOTS: Final[Mapping[str, Any]] = {"linestyle": "none", "marker": ".", "markersize": 3.0}


def numbers_of(picture: str, length: float | None) -> tuple[str, Mapping[str, Callable[[Fields], Floats]]]:
    """Return the numbers of a line picture.

    Parameters
    ----------
    picture : str
        ``speed``, ``traverse``, ``impact`` or ``flight``.
    length : float or None
        Length of the trough [mm]; needed for ``traverse``.

    Returns
    -------
    str
        Title of the picture.
    mapping of str to callable
        The numbers over the axis, by the labels of their scales.
    """

    def of(name: str, scale: float = 1.0) -> Callable[[Fields], Floats]:
        return lambda fields: scale * fields.panel.cycle[name][0]

    if picture == "speed":
        return "Mean conveying speed", {
            "mean conveying speed [mm/s]": of("mean_velocity", _MILLIMETRE),
            "displacement per cycle [mm]": of("displacement_per_cycle", _MILLIMETRE),
        }
    if picture == "impact":
        return "Impact speed", {"impact speed [mm/s]": of("impact_velocity", _MILLIMETRE)}
    if picture == "flight":
        return "Time in flight", {"share of time in flight": of("flight_fraction")}
    travelled = length or math.nan

    def time(fields: Fields) -> Floats:
        speed = _MILLIMETRE * fields.panel.cycle["mean_velocity"][0]
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(speed > 0.0, travelled / speed, np.nan)

    return f"Traverse time over {travelled:.6g} mm", {"traverse time [s]": time}


def line_figure(
    picture: str, result: SweepResult, fields: Fields, target_speed: float | None = None
) -> Figure:
    """Draw numbers over a range, as ``numbers_of`` names them; a target speed is marked [mm/s]."""
    from vibro.plots.picture import Picture

    heading, rows = numbers_of(picture, result.length)
    figure = Picture(figsize=(7.4, 2.2 + 2.1 * len(rows)))
    strip, *axes = figure.subplots(1 + len(rows), 1, sharex=True, height_ratios=[0.13, *[1.0] * len(rows)])
    set_heading(figure, headline(heading, result), below(result, fields.panel.values))
    bands = stretches(fields)
    legend: dict[str, dict[str, Any]] = {}
    for a, (label, numbers) in zip(axes, rows.items(), strict=True):
        values = numbers(fields)
        _shade(a, bands, legend)
        # A single value in its regime makes no line: with few values, mark each.
        mark: dict[str, Any] = {"marker": "o", "markersize": 4.0} if values.size <= _MARKED else {}
        look = {"uncertain": picture in UNCERTAIN, "color": INK, "linewidth": 1.8, **mark}
        draw_numbers(a, fields, values, legend, gid="numbers", **look)
        a.set_ylabel(label)
        _critical_lines(a, fields, legend)
        for point in operating_points(result, fields.panel):
            height = np.interp(point[0], fields.panel.x.values, values)
            mark_operating_point(a, np.array([[point[0], height]]), legend)
        if picture == "speed" and a is axes[0]:
            draw_peaks([a], [fields.panel], [fields.panel.x], legend)
        finish_numbers(a, picture, values, target_speed if a is axes[0] else None)
    scale_axis(strip.xaxis, fields.panel.x)
    axes[-1].set_xlabel(axis_label(fields.panel.x))
    figure.align_ylabels(axes)
    settle(figure, legend)
    if unnamed := name_bands(figure, strip, bands):
        settle(figure, unnamed | legend)
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
        """Name of the stretch."""

    @property
    def style(self) -> dict[str, Any]:
        """Style of its fill."""


@dataclass(frozen=True)
class Stretch:
    """A stretch of the axis over which regime and status stay the same."""

    low: float
    high: float
    regime: Regime
    unanswered: Status | None
    coexists: bool
    backwards: bool

    @property
    def style(self) -> dict[str, Any]:
        """Style of the band."""
        if self.unanswered is not None and self.unanswered is not Status.FLIGHT_NOT_MODELLED:
            hatch = NO_ANSWER_HATCH[self.unanswered]
            return {"facecolor": NO_ANSWER_FACE, "edgecolor": NO_ANSWER_INK, "hatch": hatch}
        return {"facecolor": REGIME_COLOURS[self.regime]}

    @property
    def name(self) -> str:
        """Name of the band."""
        if self.unanswered is not None and self.unanswered is not Status.FLIGHT_NOT_MODELLED:
            return self.unanswered.label.replace("-", " ")
        return self.regime.label


def stretches(fields: Fields) -> list[Stretch]:
    """Cut a range at each change of regime or status."""
    unanswered = {s: fields.unanswered(s) for s in NO_ANSWER_HATCH if s in fields.statuses}
    cuts = [zero_points(fields, fields.log_ratio[c], hiding_fields(fields, c)) for c in BEGINS_AT.values()]
    over = (*unanswered.values(), fields.coexists, fields.backwards)
    cuts += [zero_points(fields, field) for field in over]
    edges = np.unique(np.concatenate([fields.x[[0, -1]], *cuts]))
    found: list[Stretch] = []
    for low, high in pairwise(edges.tolist()):
        middle = 0.5 * (low + high)
        nearest = int(np.argmin(np.abs(fields.x - middle)))
        status = next((s for s, field in unanswered.items() if field[0, nearest] > 0.0), None)
        marks = (bool(field[0, nearest] > 0.0) for field in (fields.coexists, fields.backwards))
        found.append(Stretch(low, high, _regime_at(fields, middle), status, *marks))
    return found


def _regime_at(fields: Fields, x: float) -> Regime:
    """Return the regime at a place that may be between points, in a stretch that no point lies in."""
    regime = Regime.NO_SLIP
    for later, curve in BEGINS_AT.items():
        ratio = fields.log_ratio[curve]
        passed = int(np.searchsorted(zero_points(fields, ratio), x))
        if (ratio[0, 0] > 0.0) != bool(passed % 2):
            regime = later
    return regime


def overlays(part: Stretch) -> dict[str, dict[str, Any]]:
    """Return the hatches over the colour of a stretch: styles by name."""
    hatches = {COEXISTS_LABEL: COEXISTS_HATCH} if part.coexists else {}
    if part.unanswered is Status.FLIGHT_NOT_MODELLED:
        hatches[part.unanswered.label.replace("-", " ")] = NO_ANSWER_HATCH[part.unanswered]
    common = {"facecolor": "none", "edgecolor": NO_ANSWER_INK}
    styles = {label: {**common, "hatch": hatch} for label, hatch in hatches.items()}
    if part.backwards and "hatch" not in part.style:
        styles[BACKWARDS_LABEL] = {**common, "edgecolor": INK, "hatch": BACKWARDS_HATCH}
    return styles


def _shade(axes: Axes, bands: list[Stretch], legend: dict[str, dict[str, Any]]) -> None:
    for band in bands:
        style = band.style
        if "hatch" not in style:
            style = {**style, "alpha": _TINT, "linewidth": 0.0}
        axes.axvspan(band.low, band.high, zorder=0, gid=band.name, **style)
        for label, style in overlays(band).items():
            axes.axvspan(band.low, band.high, zorder=0.5, linewidth=0.0, gid=label, **style)
            legend[label] = style


def _critical_lines(axes: Axes, fields: Fields, legend: dict[str, dict[str, Any]]) -> None:
    for name, style in CURVES.items():
        for x in zero_points(fields, fields.log_ratio[name], hiding_fields(fields, name)):
            look = {"color": INK, "linestyle": style.dashes, "linewidth": style.width}
            label = f"{style.label}: {value_text(fields.panel.x.name, x)}"
            axes.axvline(x, zorder=2, gid=name, label=label, **look)
            legend[label] = look


def draw_numbers(
    axes: Axes,
    fields: Fields,
    values: Floats,
    legend: dict[str, dict[str, Any]],
    means: Mapping[str, Any] = _DOTS,
    *,
    uncertain: bool,
    **look: Any,
) -> None:
    """Draw numbers as a line, broken where regimes meet, since the numbers jump there; means as dots.

    Means of what follows from the mean speed are uncertain, and have bars of their standard error.
    """
    x = fields.panel.x.values
    averaged = fields.panel.cycle["status"][0] == Status.AVERAGED
    if averaged.any():
        place = {"gid": AVERAGED_LABEL, "zorder": 3}
        axes.plot(x[averaged], values[averaged], **{**means, "color": look["color"], **place})
        if uncertain:
            cycle = fields.panel.cycle
            error, speed = (cycle[name][0, averaged] for name in ("mean_velocity_error", "mean_velocity"))
            off = np.abs(values[averaged] * error / speed)
            ends = values[averaged] - off, values[averaged] + off
            axes.vlines(x[averaged], *ends, color=look["color"], linewidth=0.6, alpha=0.3, gid=ERROR_LABEL)
            legend[ERROR_LABEL] = {"color": INK, "linewidth": 0.6, "alpha": 0.3}
        legend[AVERAGED_LABEL] = {**means, "color": INK}
    regime = fields.panel.cycle["regime"][0]
    jumps = np.flatnonzero(regime[1:] != regime[:-1]) + 1
    axes.plot(
        np.insert(x, jumps, np.nan),
        np.insert(np.where(averaged, np.nan, values), jumps, np.nan),
        zorder=3,
        **look,
    )


def finish_numbers(axes: Axes, picture: str, values: Floats, target_speed: float | None = None) -> None:
    """Draw what helps to read a scale, and mark a target speed on it; long times are logarithmic.

    Parameters
    ----------
    axes : Axes
        With everything drawn.
    picture : str
        As for ``numbers_of``.
    values : float array
        The numbers drawn.
    target_speed : float, optional
        In the unit of the values, mm/s.
    """
    finite = values[np.isfinite(values)]
    if finite.size and finite.min() < 0.0:
        axes.axhline(0.0, color=INK, linewidth=0.8, zorder=1)
    axes.grid(axis="y", color="#BBBBBB", linewidth=0.5, zorder=0.8)
    if picture == "traverse" and finite.size and finite.max() > _WIDE * finite.min():
        make_logarithmic(axes.yaxis, finite.min(), finite.max())
    if picture == "speed" and target_speed is not None:
        low, high = axes.get_ylim()
        axes.axhline(target_speed, color=INK, linewidth=2.2, linestyle=(0, (1, 1)), zorder=2.5, gid="level")
        axes.set_ylim(low, max(high, target_speed + _HEADROOM * (target_speed - low)))
        place = (0.005, target_speed), (0, 3), ("axes fraction", "data"), "offset points"
        outline(axes.annotate(f"{number_text(target_speed)} mm/s", *place), "#FFFFFF")


def name_bands(figure: Figure, strip: Axes, bands: Sequence[Band]) -> dict[str, dict[str, Any]]:
    """Write the names of bands into a strip above the axes; return the styles of those that find no room."""
    strip.set_yticks([])
    strip.tick_params(axis="x", which="both", bottom=False, labelbottom=False)
    renderer = renderer_of(figure)
    unnamed: dict[str, dict[str, Any]] = {}
    for name, group in groupby(bands, key=lambda band: band.name):
        run = list(group)
        low, high, style = run[0].low, run[-1].high, run[0].style
        strip.axvspan(low, high, gid=name, **{"linewidth": 0.0, **style})
        if not write_name(strip, renderer, (low, high), 0.5, name, style):
            unnamed[name] = style
    return unnamed


def write_name(
    axes: Axes, renderer: Any, ends: tuple[float, float], height: float, name: str, style: dict[str, Any]
) -> bool:
    """Write a name into a stretch of the axis, at a height; return whether it fitted."""
    to_pixels = axes.transData
    (left, y), (right, _) = to_pixels.transform([(end, height) for end in ends])
    middle = to_pixels.inverted().transform((0.5 * (left + right), y))[0]
    text = axes.text(
        middle,
        height,
        name,
        ha="center",
        va="center_baseline",
        color=ink_on(style["facecolor"]),
        fontsize=9.0,
    )
    if "hatch" in style:
        outline(text, style["facecolor"])
    if text.get_window_extent(renderer).width <= right - left - 4.0:
        return True
    text.remove()
    return False
