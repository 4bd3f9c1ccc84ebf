"""Maps of two axes, alone or as facets: regimes, conveying speed, traverse time."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.plots.frame import legend_height, map_frame, mark_operating_point, operating_points, settle
from vibro.plots.layers import MapLayers
from vibro.plots.peaks import draw_peaks
from vibro.plots.scales import Scale, colours_of, scale_of, time_scale
from vibro.plots.style import BACKWARDS_FACE, BACKWARDS_HATCH, BACKWARDS_LABEL, CURVES, number_text

if TYPE_CHECKING:
    from collections.abc import Iterable

    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from vibro.plots.fields import Fields
    from vibro.results.sweep import SweepResult

    Floats = NDArray[np.float64]

__all__ = [
    "colour_bar",
    "flight_map",
    "impact_map",
    "place_words",
    "regime_map",
    "speed_map",
    "traverse_map",
]

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
        layers.draw_reversal()
    return _finish(figure, result, maps)


def speed_map(result: SweepResult, fields: list[Fields], target_speed: float | None = None) -> Figure:
    """Map of the mean conveying speed, diverging about zero where transport reverses.

    The contour of a target speed stands out [mm/s].
    """
    figure, maps = _start(result, fields, "Mean conveying speed")
    for layers in maps:
        layers.hatch_unanswered(regimes_show=False)
        layers.cover_rest()
    speeds = [_MILLIMETRE * f.velocity for f in fields]
    _draw_numbers(figure, maps, speeds, "mean conveying speed [mm/s]")
    for layers in maps:
        layers.draw_reversal()
    if target_speed is not None:
        for layers, numbers in zip(maps, speeds, strict=True):
            layers.draw_level(numbers, target_speed, f"{number_text(target_speed)} mm/s")
    return _finish(figure, result, maps, peaks=True)


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
    _draw_numbers(figure, maps, values, label)
    return _finish(figure, result, maps, ("hop",))


def _draw_numbers(figure: Figure, maps: list[MapLayers], values: list[Floats], label: str) -> None:
    """Draw numbers and their contours, in a scale that resolves the numbers of most bodies."""
    seen = _seen(maps, values)
    regular = _seen(maps, values, [layers.fields.smooth > 0.0 for layers in maps])
    calm = _seen(maps, values, [layers.fields.log_ratio["hop"] <= 0.0 for layers in maps])
    scale = scale_of(seen, regular, calm, reverses=any(layers.fields.reverses for layers in maps))
    for layers, numbers in zip(maps, values, strict=True):
        layers.draw_numbers(numbers, scale)
    if seen.any():
        colour_bar(figure, maps, scale, label)


def traverse_map(result: SweepResult, fields: list[Fields]) -> Figure:
    """Map of the time to convey over the trough's length at the mean speed, in a logarithmic scale."""
    length = result.length or math.nan
    figure, maps = _start(result, fields, f"Traverse time over {length:.6g} mm")
    times = []
    for layers, f in zip(maps, fields, strict=True):
        layers.hatch_unanswered(regimes_show=False)
        layers.cover_rest()
        backwards = np.nan_to_num(-f.velocity, nan=-1.0)
        layers.hatch(backwards, BACKWARDS_LABEL, BACKWARDS_HATCH, BACKWARDS_FACE)
        times.append(length / (_MILLIMETRE * np.maximum(f.velocity, _LEAST_VELOCITY)))
    seen = _seen(maps, times)
    scale = time_scale(seen)
    for layers, time in zip(maps, times, strict=True):
        layers.draw_numbers(time, scale)
    if seen.size:
        colour_bar(figure, maps, scale, "traverse time [s]")
    return _finish(figure, result, maps)


def _start(result: SweepResult, fields: list[Fields], heading: str) -> tuple[Figure, list[MapLayers]]:
    figure, axes = map_frame(result, [f.panel for f in fields], heading)
    return figure, [MapLayers(a, f, single=len(fields) == 1) for a, f in zip(axes, fields, strict=True)]


def _seen(
    maps: list[MapLayers], values: list[Floats], among: list[NDArray[np.bool_]] | None = None
) -> Floats:
    """Return the finite values that are visible, of those among certain points."""
    return np.concatenate(
        [
            v[m.open & np.isfinite(v) & (True if among is None else among[i])]
            for i, (m, v) in enumerate(zip(maps, values, strict=True))
        ]
    )


def colour_bar(figure: Figure, maps: list[MapLayers], scale: Scale, label: str) -> None:
    """Draw the scale of the numbers beside the maps, its numbers in full."""
    from matplotlib.cm import ScalarMappable

    axes = [layers.axes for layers in maps]
    numbers = ScalarMappable(scale.norm, colours_of(scale))
    bar = figure.colorbar(numbers, ax=axes, label=label, extend=scale.extend, pad=0.02, aspect=28)
    if scale.ticks is not None:
        bar.set_ticks(list(scale.ticks), labels=[number_text(tick) for tick in scale.ticks])
        bar.minorticks_off()


def _finish(
    figure: Figure,
    result: SweepResult,
    maps: list[MapLayers],
    curves: Iterable[str] = CURVES,
    *,
    peaks: bool = False,
) -> Figure:
    """Draw the common top layers of maps, fix the layout, and write the words."""
    marked: dict[str, dict[str, Any]] = {}
    points = [operating_points(result, layers.fields.panel) for layers in maps]
    for layers, point in zip(maps, points, strict=True):
        layers.hatch_doubtful()
        layers.draw_curves(curves)
        mark_operating_point(layers.axes, point, marked)
    if peaks:
        panels = [layers.fields.panel for layers in maps]
        facet = result.axes.get(panels[0].facet or "")
        found = draw_peaks([m.axes for m in maps], panels, (panels[0].x, panels[0].y, facet), marked)
        points = [np.concatenate(pair) for pair in zip(points, found, strict=True)]
    place_words(figure, maps, points, marked)
    return figure


def place_words(
    figure: Figure, maps: list[MapLayers], points: list[Floats], marked: dict[str, dict[str, Any]]
) -> None:
    """Fix the layout, and write the words.

    Parameters
    ----------
    figure : Figure
        Fully drawn.
    maps : list of MapLayers
        Its maps.
    points : list of (n, 2) array
        Points to be kept clear of words, on every map.
    marked : dict of str to dict
        Entries of the legend beside those of the maps.
    """
    # Words are placed in the final layout. But the legend lists those that do not fit, and is part of the
    # layout: repeat both until the legend no longer changes.
    legend = _legend(maps) | marked
    width, height = figure.get_size_inches()
    while True:
        figure.set_figheight(height + legend_height([*legend], width))
        settle(figure, legend)
        for layers, point in zip(maps, points, strict=True):
            layers.write(avoid=point)
        needed = _legend(maps) | marked
        if needed.keys() == legend.keys():
            return
        legend = needed


def _legend(maps: list[MapLayers]) -> dict[str, dict[str, Any]]:
    return {text: style for layers in maps for text, style in layers.legend.items()}
