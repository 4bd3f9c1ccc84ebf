"""Maps of two axes, alone or as facets: regimes, conveying speed, traverse time, flight."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from vibro.core.codes import Regime
from vibro.plots.frame import (
    draw_peaks,
    facets,
    head_sweep,
    mark_point,
    place_on,
    settle,
)
from vibro.plots.layers import MapLayers
from vibro.plots.scales import Scale, colours_of, scale_of, time_scale
from vibro.plots.style import BACKWARDS_FACE, BACKWARDS_LABEL, CURVES, OVER, number_text
from vibro.plots.subjects import SUBJECTS, heading_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from vibro.plots.fields import Fields
    from vibro.results.sweep import SweepResult

    Floats = NDArray[np.float64]
    Mask = NDArray[np.bool_]


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
    for layers in maps:
        if picture == "regime":
            layers.fill_regimes()
        layers.hatch_unanswered(regimes_show=picture == "regime")
        if picture == "regime":
            layers.name_regimes()
        elif SUBJECTS[picture].in_flight:
            layers.cover_contact()
        else:
            layers.cover_rest()
        if picture == "traverse":
            backwards = np.nan_to_num(-layers.fields.velocity, nan=-1.0)
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
    subject = SUBJECTS[picture]
    values = []
    for f in (layers.fields for layers in maps):
        wanted = f.panel.cycle["regime"] == Regime.HOPPING if subject.in_flight else None
        values.append(
            subject.told(f.velocity if wanted is None else f.reaching(subject.result, wanted), length)
        )
    seen = _seen(maps, values)
    if picture == "traverse":
        scale = time_scale(seen)
    else:
        regular = _seen(maps, values, [layers.fields.regular > 0.0 for layers in maps])
        calm = _seen(maps, values, [layers.fields.log_ratio["hop"] <= 0.0 for layers in maps])
        scale = scale_of(seen, regular, calm, reverses=any(layers.fields.reverses for layers in maps))
    for layers, numbers in zip(maps, values, strict=True):
        layers.draw_numbers(numbers, scale)
        if picture == "speed" and target_speed is not None:
            layers.draw_level(numbers, target_speed, f"{number_text(target_speed)} mm/s")
    if seen.any():
        colour_bar(figure, maps, scale, subject.label)


def _seen(maps: list[MapLayers], values: list[Floats], among: list[Mask] | None = None) -> Floats:
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


def place_words(figure: Figure, maps: list[MapLayers], points: list[Floats]) -> None:
    """Fix the layout, and write the words, clear of points.

    Words are placed in the final layout. But the legend lists those that do not fit, and is part of the
    layout: repeat both until the legend no longer changes.
    """
    changes = True
    while changes:
        settle(figure)
        found = [layers.write(avoid=point) for layers, point in zip(maps, points, strict=True)]
        changes = any(found)
