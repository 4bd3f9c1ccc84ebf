"""Maps of two axes, alone or as facets: regimes, conveying speed, traverse time, flight."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.cm import ScalarMappable

from vibro.core.codes import Regime
from vibro.plots.frame import draw_peaks, facets, head_sweep, mark_point, place_on, settle
from vibro.plots.layers import WHITE, MapLayers
from vibro.plots.scales import Scale, colours_of, scale_of, time_scale
from vibro.plots.style import BACKWARDS_FACE, BACKWARDS_LABEL, CURVES, OVER, number_text
from vibro.plots.subjects import SUBJECTS, heading_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from vibro.plots.fields import Fields
    from vibro.reals import Floats
    from vibro.results.sweep import SweepResult


def map_figure(
    picture: str, result: SweepResult, fields: list[Fields], target_speed: float | None = None
) -> Figure:
    """Draw a map for every value of a facet, or one.

    Parameters
    ----------
    picture : str
        ``regime``: one colour each, bounded by the critical curves; or one of ``SUBJECTS``.
    result : SweepResult
        The sweep.
    fields : list of Fields
        Of every facet.
    target_speed : float, optional
        A speed whose contour stands out [mm/s].
    """
    figure, axes = facets([f.panel for f in fields])
    head_sweep(figure, heading_of(picture, result.length), result, [f.panel for f in fields])
    maps = [MapLayers(a, f, single=len(fields) == 1) for a, f in zip(axes, fields, strict=True)]
    for layers, f in zip(maps, fields, strict=True):
        layers.hatch_unanswered(regimes_show=picture == "regime")
        if picture == "regime":
            layers.fill_regimes()
        elif SUBJECTS[picture].in_flight:
            layers.cover(-f.log_ratio["hop"], "no flight", WHITE)
        else:
            layers.cover(f.rest, Regime.NO_SLIP.label, WHITE)
        if picture == "traverse":
            backwards = np.nan_to_num(-f.velocity, nan=-1.0)
            layers.cover(backwards, BACKWARDS_LABEL, {**OVER[BACKWARDS_LABEL], "facecolor": BACKWARDS_FACE})
    if picture != "regime":
        _draw_numbers(figure, maps, picture, result.length, target_speed)
    points = [place_on(f.panel, result.operating_point) for f in fields]
    for layers, point in zip(maps, points, strict=True):
        if picture in ("regime", "speed"):
            layers.draw_reversal()
        layers.hatch_doubtful()
        layers.draw_curves(("hop",) if picture in ("impact", "flight") else CURVES)
        mark_point(layers.axes, point)
    if picture == "speed":
        found = draw_peaks(result, axes, [f.panel for f in fields])
        points = [np.concatenate(pair) for pair in zip(points, found, strict=True)]
    place_words(figure, maps, points)
    return figure


def _draw_numbers(
    figure: Figure, maps: list[MapLayers], picture: str, length: float | None, target_speed: float | None
) -> None:
    """Draw numbers and their contours, in a scale that resolves the numbers of most bodies."""
    subject, values = SUBJECTS[picture], []
    # Of the numbers that are seen: all, those of regular motion, and those of bodies in contact.
    seen: tuple[list[Floats], ...] = ([], [], [])
    for layers in maps:
        f = layers.fields
        hops = f.panel.cycle["regime"] == Regime.HOPPING
        numbers = f.reaching(subject.result, hops) if subject.in_flight else f.velocity
        values.append(subject.in_unit(numbers, length))
        known = layers.open & np.isfinite(values[-1])
        kinds = known, known & (f.regular > 0.0), known & (f.log_ratio["hop"] <= 0.0)
        for numbers_of, among in zip(seen, kinds, strict=True):
            numbers_of.append(values[-1][among])
    every, regular, calm = map(np.concatenate, seen)
    reverses = any(layers.fields.reverses for layers in maps)
    scale = time_scale(every) if picture == "traverse" else scale_of(every, regular, calm, reverses=reverses)
    for layers, numbers in zip(maps, values, strict=True):
        layers.draw_numbers(numbers, scale)
        if picture == "speed" and target_speed is not None:
            layers.draw_level(numbers, target_speed, f"{number_text(target_speed)} mm/s")
    if every.any():
        colour_bar(figure, maps, scale, subject.label)


def colour_bar(figure: Figure, maps: list[MapLayers], scale: Scale, label: str) -> None:
    """Draw the scale of the numbers beside the maps, its numbers in full."""
    place: Any = {"ax": [layers.axes for layers in maps], "pad": 0.02, "aspect": 28}
    numbers = ScalarMappable(scale.norm, colours_of(scale.colours))
    bar = figure.colorbar(numbers, label=label, extend=scale.extend, **place)
    if scale.ticks is not None:
        bar.set_ticks(list(scale.ticks), labels=[number_text(tick) for tick in scale.ticks])
        bar.minorticks_off()


def place_words(figure: Figure, maps: list[MapLayers], points: list[Floats]) -> None:
    """Fix the layout, and write the words, clear of points.

    Words are placed in the final layout. But the legend lists those that do not fit, and is part of the
    layout: repeat both until the legend no longer changes.
    """
    changes = [True]
    while any(changes):
        settle(figure)
        changes = [layers.write(avoid=point) for layers, point in zip(maps, points, strict=True)]
