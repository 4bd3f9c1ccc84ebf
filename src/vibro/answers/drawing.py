"""Pictures of results: those of their methods ``draw``, which the commands write too."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

from vibro.errors import InputError, shown
from vibro.plots import DESIGN_PICTURES, saver
from vibro.reals import NotRealError, real_number
from vibro.scene import values_of

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from os import PathLike

    from matplotlib.figure import Figure

    from vibro.designs.design import Chosen
    from vibro.designs.questions import Spec
    from vibro.records.comparison import Comparison
    from vibro.results.designs import Design, DesignResult
    from vibro.results.drawing import Drawing
    from vibro.results.history import History

_SAMPLES: Final = 200  # a cycle
_DRAWN: Final = 6.0  # cycles at the end of a history, drawn by default
_MOST_DRAWN: Final = 100.0  # cycles of a picture: of more nobody sees one
_ROUNDING: Final = 1e-12  # share of a history by which its end, as typed, may lie behind it


def drawn_window(
    start: float | None, end: float | None, last: float, frequency: float, given: str
) -> tuple[float, float]:
    """Return when the picture of a history begins and ends; by default it has the last six cycles [s].

    Parameters
    ----------
    start, end : float or None
        As they are asked for [s].
    last : float
        End of the history [s].
    frequency : float
        Of the drive [Hz].
    given : str
        What was asked for, for messages.
    """
    if start is None and end is None:
        return max(0.0, last - _DRAWN / frequency), last
    since, until = start or 0.0, last if end is None else end
    if not 0.0 <= since < until <= last * (1.0 + _ROUNDING):
        raise InputError(f"{given}: must ascend within the history, 0 to {last:.6g} s")
    if (until - since) * frequency > _MOST_DRAWN:
        raise InputError(
            f"{given}: {(until - since) * frequency:.6g} drive cycles are too many for a picture",
            hint=f"draw at most {_MOST_DRAWN:g} of them: {_MOST_DRAWN / frequency:.4g} s",
        )
    return since, min(until, last)


def history_picture(
    history: History,
    window: tuple[float, float],
    title: str,
    given: Mapping[str, float],
    panels: str | None = None,
    *,
    samples: int = _SAMPLES,
    part: str | None = None,
) -> Figure:
    """Draw a part of a history.

    Parameters
    ----------
    history : History
        What is drawn.
    window : pair of float
        When the picture begins and ends [s].
    title, given : str, mapping of str to float
        As of ``history_figure``.
    panels : str, optional
        As of ``choose_panels``.
    samples : int, optional
        A cycle, at least.
    part : str, optional
        Which part it is, in words; by default in drive cycles.
    """
    from vibro.motion.histories import trace
    from vibro.plots.history import choose_panels, history_figure

    since, until = window
    phases = [p for p in history.phases if p.end > since and p.start < until]
    seen = choose_panels(panels, flies=any(p.kind == "H" for p in phases))
    rows = trace(history, since=since, until=until, samples_per_cycle=max(samples, _SAMPLES), both_sides=True)
    part = drawn_part(since, until, history) if part is None else part
    period = 1.0 / float(history.scene.frequency)
    return history_figure(phases, rows, seen, title, given, part, period=period)


def drawn_part(since: float, until: float, history: History) -> str:
    """Say which part of a history is drawn; an empty text for all of it."""
    frequency = float(history.scene.frequency)
    first, last, whole = (f"{time * frequency:.4g}" for time in (since, until, history.end))
    if until < history.end:
        return f"from {first} to {last} of {whole} drive cycles"
    return f"the last {(until - since) * frequency:.4g} of {whole} drive cycles" if since else ""


def design_pictures(spec: Spec, chosen: Chosen, names: Sequence[str] = DESIGN_PICTURES) -> dict[str, Figure]:
    """Draw what the settings around a design do to all parts, by the names of the pictures."""
    from vibro.answers.design import goal_text
    from vibro.designs.pictured import setting_fields, speed_band
    from vibro.plots.design import design_figures

    fields, band = setting_fields(spec, chosen), speed_band(spec, chosen)
    return design_figures(spec, chosen, fields, band, goal_text(spec, chosen), names)


def comparison_picture(
    comparison: Comparison, title: str, given: Mapping[str, float], fitted: Comparison | None = None
) -> Figure:
    """Draw a record beside the model, and beside one that is fitted to it."""
    from vibro.plots.comparison import comparison_figure

    return comparison_figure(
        comparison, f"{title}, computed pattern {comparison.motion.pattern}", given, fitted
    )


def _draw_history(
    history: History,
    path: str | PathLike[str] | None,
    *,
    start: float | None,
    end: float | None,
    panels: str | None,
) -> Figure:
    write = saver(path)
    asked = {name: x for name, x in (("start", start), ("end", end)) if x is not None}
    times = {name: _time(name, x) for name, x in asked.items()}
    text = ", ".join(f"{name} = {x:.15g} s" for name, x in times.items())
    limits = times.get("start"), times.get("end")
    window = drawn_window(*limits, history.end, float(history.scene.frequency), text)
    return write(history_picture(history, window, "Motion", values_of(history.scene), panels))


def _time(name: str, value: Any) -> float:
    try:
        time = real_number(value)
    except NotRealError as exc:
        raise InputError(f"{name} = {exc.value}: must be {exc.allowed} [s]") from None
    if not math.isfinite(time):
        raise InputError(f"{name} = {shown(value)}: must be finite [s]")
    return time


def _draw_design(
    result: DesignResult, name: str, path: str | PathLike[str] | None, *, design: Design | None
) -> Figure:
    from vibro.designs.design import chosen_of

    write = saver(path)
    if name not in DESIGN_PICTURES:
        hint = f"there are {', '.join(DESIGN_PICTURES)}"
        raise InputError(f"draw({shown(name)}): no such picture of a design", hint=hint)
    if result.spec is None:
        raise InputError("this result has no question to draw", hint="vibro.design returns one that has")
    chosen = chosen_of(result.spec, result, design)
    if chosen is None and design is not None:
        raise InputError(f"design = {shown(design)}: must be one of designs, and guarantee a speed")
    if chosen is None:
        raise InputError(f"draw({shown(name)}): no setting of any drive guarantees a speed")
    return write(design_pictures(result.spec, chosen, [name])[name])


def _draw_comparison(comparison: Comparison, path: str | PathLike[str] | None) -> Figure:
    write = saver(path)
    return write(comparison_picture(comparison, "Record and model", values_of(comparison.scene)))


#: Draws a result, by its class.
DRAWINGS: Final[Mapping[str, Drawing]] = {
    "Comparison": _draw_comparison,
    "DesignResult": _draw_design,
    "History": _draw_history,
}
