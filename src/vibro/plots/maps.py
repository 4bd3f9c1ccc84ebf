"""Maps of two axes, alone or as facets: regimes, conveying speed, traverse time."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.plots.frame import map_frame, mark_operating_point, operating_points, settle
from vibro.plots.layers import MapLayers
from vibro.plots.style import CURVES, number_text

if TYPE_CHECKING:
    from collections.abc import Iterable

    from matplotlib.colors import Colormap, Normalize
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from vibro.plots.fields import Fields
    from vibro.results.sweep import SweepResult

    Floats = NDArray[np.float64]

__all__ = [
    "colour_bar",
    "flight_map",
    "impact_map",
    "levels_from_zero",
    "levels_of_times",
    "place_words",
    "regime_map",
    "scale_from_zero",
    "speed_map",
    "traverse_map",
]

_NICE: Final = (1, 2, 2.5, 5, 10)  # steps between contours, in powers of ten
_BELOW_TOP: Final = 1.0 - 1e-6  # of the largest number: a contour there would trace its rounding errors
# Irregular motion reaches far higher speeds than the motion that most troughs are built for. Where the
# numbers of regular motion stay below this share of the largest, an even scale would hardly tell them apart.
_UNEVEN: Final = 0.5
# A scale diverges about zero if regular motion goes backwards, or if any motion does at more than this share
# of the largest speed.
_REVERSES: Final = 0.1
_WIDE: Final = 5.0  # ratio of the longest to the shortest time above which contours are at 1, 2, 5, 10 ...
# Traverse times grow without bound near rest. Up to this multiple of the shortest, colours tell them apart.
_LONGEST_OVER_SHORTEST: Final = 100.0
# [m/s] Keeps times finite where the body moves backwards or rests; both are covered.
_LEAST_VELOCITY: Final = 1e-12
_MILLIMETRE: Final = 1e3  # [1/m]


def regime_map(result: SweepResult, fields: list[Fields]) -> Figure:
    """Map of the regimes, one colour each, bounded by the critical curves."""
    figure, maps = _start(result, fields, "Steady regimes")
    for layers in maps:
        layers.fill_regimes()
        layers.hatch_unanswered(regimes_show=True)
        layers.name_regimes()
    return _finish(figure, result, maps)


def speed_map(result: SweepResult, fields: list[Fields], level: float | None = None) -> Figure:
    """Map of the mean conveying speed, diverging about zero where transport reverses.

    A level is a speed whose contour stands out [mm/s].
    """
    figure, maps = _start(result, fields, "Mean conveying speed")
    for layers in maps:
        layers.hatch_unanswered(regimes_show=False)
        layers.cover_rest()
    speeds = [_MILLIMETRE * f.velocity for f in fields]
    _draw_from_zero(figure, maps, speeds, "mean conveying speed [mm/s]")
    if level is not None:
        for layers, numbers in zip(maps, speeds, strict=True):
            layers.draw_level(numbers, level, f"{number_text(level)} mm/s")
    return _finish(figure, result, maps)


def impact_map(result: SweepResult, fields: list[Fields]) -> Figure:
    """Map of the largest normal speed with which the body lands."""
    speeds = [_MILLIMETRE * f.in_flight("impact_velocity") for f in fields]
    return _flight_map(result, fields, "Impact speed", speeds, "impact speed, normal to the trough [mm/s]")


def flight_map(result: SweepResult, fields: list[Fields]) -> Figure:
    """Map of the share of the time that the body is off the trough."""
    shares = [f.in_flight("flight_fraction") for f in fields]
    return _flight_map(result, fields, "Time in flight", shares, "share of time in flight")


def _flight_map(
    result: SweepResult, fields: list[Fields], heading: str, values: list[Floats], label: str
) -> Figure:
    figure, maps = _start(result, fields, heading)
    for layers in maps:
        layers.hatch_unanswered(regimes_show=False)
        layers.cover_contact()
    _draw_from_zero(figure, maps, values, label)
    return _finish(figure, result, maps, ("hop",))


def _draw_from_zero(figure: Figure, maps: list[MapLayers], values: list[Floats], label: str) -> None:
    """Draw numbers and their contours, in a scale that rises from zero or diverges about it."""
    from matplotlib import colormaps
    from matplotlib.colors import CenteredNorm

    low, high = seen = _range(maps, values)
    smooth = _range(maps, values, smooth=True)
    norm = scale_from_zero(seen, smooth)
    reverses = isinstance(norm, CenteredNorm)
    colours = colormaps["RdBu" if reverses else "cividis"]
    levels = levels_from_zero(*smooth, zero=reverses)
    for layers, numbers in zip(maps, values, strict=True):
        layers.draw_numbers(numbers, norm, colours, levels)
    if (low, high) != (0.0, 0.0):
        colour_bar(figure, maps, norm, colours, label, "min" if low < 0.0 and not reverses else "neither")


def scale_from_zero(seen: tuple[float, float], smooth: tuple[float, float]) -> Normalize:
    """Choose how numbers become colours.

    Parameters
    ----------
    seen : (float, float)
        Least and largest number on the maps.
    smooth : (float, float)
        The same of motion that repeats with the drive.

    Returns
    -------
    Normalize
        Diverging about zero where motion reverses, else from zero up: evenly, or by square roots.
    """
    from matplotlib.colors import CenteredNorm, Normalize, PowerNorm

    low, high = seen
    # A few bounces backwards in irregular motion do not make a map of reversals.
    if smooth[0] < 0.0 or low < -_REVERSES * high:
        return CenteredNorm(0.0, max(-low, high))
    if 0.0 < smooth[1] < _UNEVEN * high:
        return PowerNorm(0.5, 0.0, high)
    return Normalize(0.0, high or 1.0)


def levels_from_zero(least: float, most: float, *, zero: bool) -> Floats:
    """Return the round numbers within a range at which contours are drawn; zero only if it is wanted."""
    from matplotlib.ticker import MaxNLocator

    levels = np.asarray(MaxNLocator(nbins=8, steps=_NICE).tick_values(min(least, 0.0), most))
    return np.asarray(levels[(levels > least) & (levels < _BELOW_TOP * most) & (zero | (levels != 0.0))])


def levels_of_times(shortest: float, longest: float) -> Floats:
    """Return the round times within a range at which contours are drawn: 1, 2, 5, 10 ... if it is wide."""
    from matplotlib.ticker import LogLocator, MaxNLocator

    wide = longest > _WIDE * shortest
    locator = LogLocator(subs=(1.0, 2.0, 5.0)) if wide else MaxNLocator(nbins=7, steps=_NICE)
    levels = np.asarray(locator.tick_values(shortest, longest))
    return np.asarray(levels[(levels > shortest) & (levels < longest)])


def traverse_map(result: SweepResult, fields: list[Fields]) -> Figure:
    """Map of the time to convey over the trough's length at the mean speed, in a logarithmic scale."""
    from matplotlib import colormaps
    from matplotlib.colors import LogNorm

    length = result.length or math.nan
    figure, maps = _start(result, fields, f"Traverse time over {length:.6g} mm")
    times = []
    for layers, f in zip(maps, fields, strict=True):
        layers.hatch_unanswered(regimes_show=False)
        layers.cover_rest()
        layers.hatch(np.nan_to_num(-f.velocity, nan=-1.0), "moves backwards", "||")
        times.append(length / (_MILLIMETRE * np.maximum(f.velocity, _LEAST_VELOCITY)))
    shortest, longest = _range(maps, times)
    moves = shortest > 0.0
    shortest = shortest or 1.0
    top = max(1.01 * shortest, min(longest, _LONGEST_OVER_SHORTEST * shortest))
    levels = levels_of_times(shortest, top)
    norm, colours = LogNorm(shortest, top), colormaps["cividis_r"]
    for layers, time in zip(maps, times, strict=True):
        layers.draw_numbers(time, norm, colours, levels)
    if moves:
        extend = "max" if longest > top else "neither"
        colour_bar(figure, maps, norm, colours, "traverse time [s]", extend, levels)
    return _finish(figure, result, maps)


def _start(result: SweepResult, fields: list[Fields], heading: str) -> tuple[Figure, list[MapLayers]]:
    figure, axes = map_frame(result, [f.panel for f in fields], heading)
    return figure, [MapLayers(a, f, single=len(fields) == 1) for a, f in zip(axes, fields, strict=True)]


def _range(maps: list[MapLayers], values: list[Floats], *, smooth: bool = False) -> tuple[float, float]:
    """Least and largest finite value that is visible, or visible and smooth; (0, 0) if there is none."""
    seen = np.concatenate(
        [
            v[m.open & np.isfinite(v) & ((m.fields.smooth > 0.0) | (not smooth))]
            for m, v in zip(maps, values, strict=True)
        ]
    )
    return (float(seen.min()), float(seen.max())) if seen.size else (0.0, 0.0)


def colour_bar(
    figure: Figure,
    maps: list[MapLayers],
    norm: Normalize,
    colours: Colormap,
    label: str,
    extend: str = "neither",
    ticks: Floats | None = None,
) -> None:
    """Draw the scale of the numbers beside the maps."""
    from matplotlib.cm import ScalarMappable

    axes = [layers.axes for layers in maps]
    bar = figure.colorbar(
        ScalarMappable(norm, colours), ax=axes, label=label, extend=extend, pad=0.02, aspect=28
    )
    if ticks is not None:
        bar.set_ticks(list(ticks), labels=[f"{tick:g}" for tick in ticks])
        bar.minorticks_off()


def _finish(
    figure: Figure, result: SweepResult, maps: list[MapLayers], curves: Iterable[str] = CURVES
) -> Figure:
    """Draw what every map has on top, fix the layout, and write the words."""
    marked: dict[str, dict[str, Any]] = {}
    points = [operating_points(result, layers.fields.panel) for layers in maps]
    for layers, point in zip(maps, points, strict=True):
        layers.hatch_doubtful()
        layers.draw_curves(curves)
        mark_operating_point(layers.axes, point, marked)
    place_words(figure, maps, points, marked)
    return figure


def place_words(
    figure: Figure, maps: list[MapLayers], points: list[Floats], marked: dict[str, dict[str, Any]]
) -> None:
    """Fix the layout, and write the words.

    Parameters
    ----------
    figure : Figure
        All of it drawn.
    maps : list of MapLayers
        Its maps.
    points : list of (n, 2) array
        What words keep clear of, on every map.
    marked : dict of str to dict
        Entries of the legend beside those of the maps.
    """
    # Words are placed in the final layout. But the legend, which explains those that find no room, is part of
    # the layout: both are repeated until the legend stays as it is.
    legend = _legend(maps) | marked
    while True:
        settle(figure, legend)
        for layers, point in zip(maps, points, strict=True):
            layers.write(avoid=point)
        needed = _legend(maps) | marked
        if needed.keys() == legend.keys():
            return
        legend = needed


def _legend(maps: list[MapLayers]) -> dict[str, dict[str, Any]]:
    return {text: style for layers in maps for text, style in layers.legend.items()}
