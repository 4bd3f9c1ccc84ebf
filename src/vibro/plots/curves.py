"""Pictures of one range, or of lists alone: numbers over bands of regimes, or a curve for every value."""

from __future__ import annotations

from itertools import cycle, pairwise
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from matplotlib import colormaps
from matplotlib.colors import to_hex

from vibro.core.codes import Regime, Status
from vibro.plots import frame, style
from vibro.plots.fields import BEGINS_AT, hiding_fields, zero_points
from vibro.plots.subjects import SUBJECTS, heading_of
from vibro.plots.view import is_discrete

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from vibro.plots.fields import Fields
    from vibro.plots.view import View
    from vibro.reals import Floats
    from vibro.results.sweep import SweepResult

    Look = Mapping[str, Any]

_SIZE: Final = (7.4, 4.6)  # [in]
_MARKED: Final = 60  # most values on the axis that are marked each
_WIDE: Final = 20.0  # ratio of the largest to the least number above which a scale is logarithmic
# From dark to light, and legible on white: in this order for the colour-blind and in grey, too.
_COLOURS, _LIGHTEST = "plasma", 0.75
_MARKERS: Final = "os^Dv"
_DOTS: Final[Look] = {"linestyle": "none", "marker": ".", "markersize": 3.0}
_POINT: Final[Look] = {"linestyle": "none", "ms": 7.5, "mew": 1.8, "markerfacecolor": "#FFFFFF"}
_BEGINS: Final[Look] = {"marker": "o", "ms": 6.5}


def curve_figure(
    picture: str, result: SweepResult, view: View, groups: Sequence[Sequence[Fields]], target: float | None
) -> Figure:
    """Draw numbers over a range, or over a list.

    Parameters
    ----------
    picture : str
        One of ``SUBJECTS``.
    result : SweepResult
        The sweep.
    view : View
        Part of the sweep, not a map.
    groups : sequence of sequence of Fields
        For every facet its curves.
    target : float or None
        A speed that stands out where speeds are drawn [mm/s].

    Returns
    -------
    Figure
        A single curve over bands of its regimes. Of several, which a key names, each has a mark where a
        regime begins; of a list, points in the colours of their regimes.
    """
    subject, panels = SUBJECTS[picture], [fields[0].panel for fields in groups]
    bands = [] if view.curves or is_discrete(view.x) else bands_of(groups[0][0])
    if bands:
        figure, (strip, *axes) = frame.stack(_SIZE, (0.1, 1.0))
        frame.scale_axis(strip.xaxis, view.x)
        axes[0].set(xlabel=style.axis_label(view.x), ylabel=subject.label)
        frame.shade(axes[0], bands)
        for name, x in _begins(groups[0][0], style.CURVES):
            label = f"{style.CURVES[name].label}: {style.value_text(view.x.name, x)}"
            axes[0].axvline(x, zorder=2, gid=name, label=label, **style.CURVES[name].look)
    else:
        figure, axes = frame.facets(panels, subject.label)
    frame.head_sweep(figure, heading_of(picture, result.length), result, [f.panel for g in groups for f in g])
    looks = _looks(view)
    for a, fields in zip(axes, groups, strict=True):
        shown = []
        for f, look in zip(fields, looks, strict=True):
            values = f.panel.cycle[subject.result][0]
            values = np.where(values > 0.0, values, np.nan) if picture == "traverse" else values
            values = subject.in_unit(values, result.length)
            _draw_numbers(a, f, values, look, uncertain=subject.result == "mean_velocity")
            shown.append(values)
        for f, look, values in zip(fields, looks, shown, strict=True):
            point = frame.place_on(f.panel, result.operating_point)
            point[:, 1] = np.interp(point[:, 0], f.x, values)
            frame.mark_point(a, point)
            if not bands:
                _mark_regimes(a, f, values, look)
        _tell_unanswered(a, view, fields, shown)
        _finish_scale(a, picture, np.concatenate(shown), target)
    if picture == "speed":
        drawn = [(a, f.panel) for a, fields in zip(axes, groups, strict=True) for f in fields]
        frame.draw_peaks(result, [a for a, _ in drawn], [panel for _, panel in drawn])
    if bands:
        frame.settle_bands(figure, strip, bands)
    else:
        frame.settle(figure)
    return figure


def _looks(view: View) -> list[dict[str, Any]]:
    """Return the style of each curve, and its value as label."""
    points = is_discrete(view.x)
    if view.curves is None:
        marked = points or len(view.x) <= _MARKED  # a single value in its regime makes no line
        mark = {"marker": "o", "ms": 4.0} if marked else {}
        return [{"color": style.INK, "linewidth": 1.8, **mark, **(_POINT if points else {})}]
    values = view.curves.values.tolist()
    colours = map(to_hex, colormaps[_COLOURS](np.linspace(0.0, _LIGHTEST, len(values))))
    kinds = zip(cycle(style.IN_TURN), cycle(_MARKERS), strict=False)
    return [
        {
            **({**_POINT, "marker": marker} if points else {"linestyle": dashes, "linewidth": 1.8}),
            "color": colour,
            "label": style.values_text({view.curves.name: value}, all_of_them=True),
        }
        for value, colour, (dashes, marker) in zip(values, colours, kinds, strict=False)
    ]


def bands_of(fields: Fields) -> list[frame.Band]:
    """Cut a range at each change of regime or status."""
    unanswered = {s: fields.unanswered(s) for s in style.NO_ANSWER_HATCH if s in fields.statuses}
    begun = {regime: fields.log_ratio[curve] for regime, curve in BEGINS_AT.items()}
    marks = dict([fields.others, (style.BACKWARDS_LABEL, fields.backwards)])
    cuts = [x for _, x in _begins(fields, BEGINS_AT.values())]
    cuts += [x for field in (*unanswered.values(), *marks.values()) for x in zero_points(fields, field)]
    found = []
    for low, high in pairwise(np.unique([*fields.x[[0, -1]], *cuts]).tolist()):
        middle = 0.5 * (low + high)
        status = next((s for s, field in unanswered.items() if fields.along(field, middle) > 0.0), None)
        regimes = [Regime.NO_SLIP, *(r for r, field in begun.items() if fields.along(field, middle) > 0.0)]
        name, face = regimes[-1].label, {"facecolor": style.REGIME_COLOURS[regimes[-1]]}
        over = {label: style.OVER[label] for label, f in marks.items() if fields.along(f, middle) > 0.0}
        if status is Status.FLIGHT_NOT_MODELLED:  # but the regime is known
            label, look = style.no_answer(status)
            over[label] = {**look, "facecolor": "none"}
        elif status is not None:
            name, face = style.no_answer(status)
            over.pop(style.BACKWARDS_LABEL, None)
        found.append(frame.Band(low, high, name, face, over))
    return found


def _begins(fields: Fields, curves: Iterable[str]) -> list[tuple[str, float]]:
    """Return the critical loads that bound a regime over a range: their names and places."""
    return [
        (name, x)
        for name in curves
        for x in zero_points(fields, fields.log_ratio[name], hiding_fields(fields, name)).tolist()
    ]


def _mark_regimes(axes: Axes, fields: Fields, values: Floats, look: Look) -> None:
    """Mark where a regime begins on a curve; give single points the colours of theirs."""
    marks = []
    if is_discrete(fields.panel.x):
        codes = fields.panel.cycle["regime"][0]
        for regime in map(Regime, np.unique(codes[np.isfinite(values)])):
            marks.append((regime, regime.label, regime.label, fields.x[codes == regime], look))
    else:
        for regime, curve in BEGINS_AT.items():
            begins = np.array([x for _, x in _begins(fields, [curve])])
            marks.append(
                (regime, curve, f"{regime.label} begins or ends", begins, {**_BEGINS, "color": style.INK})
            )
    for regime, gid, label, x, own in marks:
        if x.size:
            face = {**own, "label": label, "markerfacecolor": style.REGIME_COLOURS[regime]}
            axes.plot(x, np.interp(x, fields.x, values), zorder=4, gid=gid, **{**face, "linestyle": "none"})


def _draw_numbers(axes: Axes, fields: Fields, values: Floats, look: Look, *, uncertain: bool) -> None:
    """Draw numbers as a line, broken where regimes meet, since the numbers jump there; means as dots.

    Means of what follows from the mean speed are uncertain, and have bars of their standard error.
    """
    x, cycle = fields.x, fields.panel.cycle
    averaged = cycle["status"][0] == Status.AVERAGED
    if averaged.any() and uncertain:
        error, speed = (cycle[name][0, averaged] for name in ("mean_velocity_error", "mean_velocity"))
        off = np.abs(values[averaged] * error / speed)
        ends = values[averaged] - off, values[averaged] + off
        bars = {"color": look["color"], "linewidth": 0.6, "alpha": 0.3, "gid": style.ERROR_LABEL}
        axes.vlines(x[averaged], *ends, label=style.ERROR_LABEL, **bars)
    if averaged.any() and not is_discrete(fields.panel.x):
        dots = {**_DOTS, "color": look["color"], "zorder": 3, "gid": style.AVERAGED_LABEL}
        axes.plot(x[averaged], values[averaged], label=style.AVERAGED_LABEL, **dots)
        values = np.where(averaged, np.nan, values)
    regime = cycle["regime"][0]
    jumps = np.flatnonzero(regime[1:] != regime[:-1]) + 1
    axes.plot(np.insert(x, jumps, np.nan), np.insert(values, jumps, np.nan), zorder=3, gid="numbers", **look)


def _tell_unanswered(axes: Axes, view: View, fields: Sequence[Fields], shown: Sequence[Floats]) -> None:
    """Write into a panel for which values there are no numbers, and why."""
    found: dict[str, list[str]] = {}
    for f, values in zip(fields, shown, strict=True):
        missing, status = ~np.isfinite(values), f.panel.cycle["status"][0]
        labels = [style.no_answer(s)[0] for s in style.NO_ANSWER_HATCH if (status[missing] == s).any()]
        name = view.curves.name if view.curves else ""
        for label in labels or ["nothing conveyed"] * bool(missing.all()):
            values_of = found.setdefault(label + " in part" * (not missing.all()), [])
            values_of.append(style.value_text(name, f.panel.values[name]) if name else "")
    lines = [": ".join(filter(None, [label, ", ".join(values)])) for label, values in found.items()]
    if lines:
        look: Look = {"va": "top", "fontsize": 8.0, "path_effects": style.halo("#FFFFFF")}
        axes.text(0.02, 0.97, "\n".join(lines), transform=axes.transAxes, **look)


def _finish_scale(axes: Axes, picture: str, values: Floats, target_speed: float | None) -> None:
    """Draw what helps to read a scale, and mark a target speed on it; long times are logarithmic."""
    finite = values[np.isfinite(values)]
    if finite.size and finite.min() < 0.0:
        axes.axhline(0.0, color=style.INK, linewidth=0.8, zorder=1)
    axes.grid(axis="y", color="#BBBBBB", linewidth=0.5, zorder=0.8)
    if picture == "traverse" and finite.size and finite.max() > _WIDE * finite.min():
        frame.make_logarithmic(axes.yaxis, finite.min(), finite.max())
    if picture == "speed" and target_speed is not None:
        frame.draw_wanted(axes, target_speed, f"{style.number_text(target_speed)} mm/s")
