"""A time history: the trough, the forces, and the motion relative to the trough, with its phases shaded."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from vibro.core.codes import PHASE_NAMES, Regime
from vibro.errors import InputError
from vibro.plots.frame import TINT, Band, draw_zero, set_heading, settle_bands, shade, stack
from vibro.plots.style import BLUE, INK, LIMITS, RED, REGIME_COLOURS, SECOND, house_style, values_text

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from vibro.reals import Floats
    from vibro.results.history import Phase, Sample


_START_MARK: Final[Mapping[str, Any]] = {"marker": "s", "markersize": 5, "color": INK, "linestyle": "none"}
_STOP_MARK: Final[Mapping[str, Any]] = {**_START_MARK, "marker": "o", "markerfacecolor": "#FFFFFF"}
_IMPACT_MARK: Final[Mapping[str, Any]] = {**_START_MARK, "marker": "v", "color": "#994455"}


# Keys are the letters of a pattern. Each phase has the colour of the regime in which it is typical.
PHASE_COLOURS: Final[Mapping[str, str]] = {
    "F": REGIME_COLOURS[Regime.FORWARD_SLIP],
    "B": REGIME_COLOURS[Regime.BACK_SLIP],
    "H": REGIME_COLOURS[Regime.HOPPING],
    "_": REGIME_COLOURS[Regime.NO_SLIP],
}


def events_of(phases: Sequence[Phase]) -> list[tuple[str, Mapping[str, Any], list[float], bool]]:
    """List the starts and the stops of slides, and the impacts.

    Each is a name, a style, times [s], and whether its mark stands at the values before a jump or after it.
    """
    slides = [p for p in phases if p.kind in "FB"]
    return [
        ("slide starts", _START_MARK, [p.start for p in slides if p.start_velocity == 0.0], True),
        ("slide stops", _STOP_MARK, [p.end for p in slides if p.end_velocity == 0.0], False),
        ("impact", _IMPACT_MARK, [p.end for p in phases if p.kind == "H"], False),
    ]


def phase_bands(phases: Iterable[Phase], *, later: float = 0.0) -> list[Band]:
    """Return the bands of phases over time [ms], so much later [s]."""
    return [
        Band(1e3 * (p.start + later), 1e3 * (p.end + later), PHASE_NAMES[p.kind], {"facecolor": colour})
        for p in phases
        for colour in [PHASE_COLOURS[p.kind]]
    ]


class Curve(NamedTuple):
    """A line of a panel: which field of a ``Sample`` it shows, whether in contact alone, and how."""

    field: str
    label: str
    colour: str
    dashes: Any = "-"
    width: float = 1.5
    in_contact: bool = False


class Panel(NamedTuple):
    """Content of a panel, the size of its unit in SI units, and its height relative to the others."""

    label: str
    unit: str
    size: float
    curves: tuple[Curve, ...]
    height: float = 1.0


_GREEN, _PURPLE, _ORANGE = "#117733", "#882255", "#997700"

PANELS: Final[Mapping[str, Panel]] = {
    "trough": Panel(
        "trough along\nthe drive", "mm", 1e-3, (Curve("trough_displacement", "trough", INK),), height=0.8
    ),
    "forces": Panel(
        "force\nper unit mass", "m/s²", 1.0,
        (
            Curve("static_limit", "limits of static friction", _GREEN, LIMITS, 1.0, True),
            Curve("inertial", "inertial and gravity, along the trough", RED, "-", 1.2, True),
            Curve("friction", "friction on the body", BLUE, width=2.0),
        ),
        1.8,
    ),
    "acceleration": Panel("relative\nacceleration", "m/s²", 1.0, (Curve("acceleration", "", _PURPLE),)),
    "velocity": Panel("relative\nvelocity", "mm/s", 1e-3, (Curve("velocity", "", _ORANGE),)),
    "position": Panel("relative\nposition", "mm", 1e-3, (Curve("position", "", BLUE),)),
    "gap": Panel("height above\nthe trough", "mm", 1e-3, (Curve("gap", "", RED),)),
}  # fmt: skip

# Replaces the trough's panel for elliptical drives.
ELLIPSE: Final = Panel(
    "motion of\nthe trough", "mm", 1e-3,
    (
        Curve("trough_normal", "trough, normal to itself", _GREEN, SECOND, 1.2),
        Curve("trough_along", "trough, along itself", INK),
    ),
    0.8,
)  # fmt: skip

_ROW: Final = 1.35  # [in] of a panel of height 1
_STRIP: Final = 0.18  # height of the names of phases
_PATH: Final = 2.0  # height of the path below the panels
_MARGIN: Final = 0.12  # margin above and below the curves, as a share of their span
# The load along the trough may stretch the panel of forces to so many times what friction needs.
_STRETCH: Final = 1.5
_BAND: Final = 9.0  # [pt] width of a path in the colour of a phase
_EDGE: Final = 1e-9  # share of the drawn time by which a phase must reach into it: rounding
# Panels in which events are marked: the first of them that is shown.
_MARKED: Final = ("forces", "velocity", "acceleration", "position", "trough", "gap")


def choose_panels(text: str | None, *, flies: bool) -> list[str]:
    """Read a choice of panels, such as ``forces,velocity``.

    Parameters
    ----------
    text : str or None
        None for all of them; the gap only if the body leaves the trough.
    flies : bool
        Whether the body leaves the trough.

    Raises
    ------
    InputError
        If a panel is unknown or named twice.
    """
    if text is None:
        return [name for name in PANELS if name != "gap" or flies]
    names = [part.strip().casefold() for part in text.split(",")]
    for name in names:
        if name not in PANELS or names.count(name) > 1:
            wrong = "is no panel" if name not in PANELS else "is named twice"
            raise InputError(f'panels="{text}": {name!r} {wrong}', hint=f"choose from {', '.join(PANELS)}")
    return names


def panels_of(names: Sequence[str], trace: Sample) -> dict[str, Panel]:
    """Return panels by their names; that of the trough shows a line, or both ways of an ellipse."""
    elliptical = _is_elliptical(trace)
    return {name: ELLIPSE if name == "trough" and elliptical else PANELS[name] for name in names}


def _is_elliptical(trace: Sample) -> bool:
    return bool(np.isnan(trace.trough_displacement).all())


def values_of(curve: Curve, panel: Panel, trace: Sample) -> Floats:
    """Return the values of a curve, in the unit of its panel; NaN interrupts it."""
    values: Floats = getattr(trace, curve.field) / panel.size
    return np.where(trace.normal > 0.0, values, np.nan) if curve.in_contact else values


@house_style()
def history_figure(
    phases: Sequence[Phase],
    trace: Sample,
    panels: Sequence[str],
    title: str,
    given: Mapping[str, float],
    part: str = "",
    *,
    period: float = math.inf,
) -> Figure:
    """Draw a time history.

    Parameters
    ----------
    phases : sequence of Phase
        Phases of the motion; only those within the trace are drawn and named.
    trace : Sample
        Its motion and forces over time, with both sides of every event.
    panels : sequence of str
        Of ``PANELS``, from top to bottom.
    title : str
        Name of the scene.
    given : mapping of str to float
        Quantities of the scene, in the user's units, written under the title.
    part : str, optional
        Which part of the history the trace is, if not all of it.
    period : float, optional
        Of the drive; the path of an elliptical one is that of the last period [s].

    Returns
    -------
    Figure
        Panels above each other over one time axis; below them the path of an elliptical drive.
    """
    elliptical = _is_elliptical(trace)
    shown = panels_of(panels, trace)
    first, last = float(trace.time[0]), float(trace.time[-1])
    edge = _EDGE * (last - first)
    phases = [phase for phase in phases if phase.end > first + edge and phase.start < last - edge]
    heights = [_STRIP, *(panel.height for panel in shown.values()), *[_PATH] * elliptical]
    figure, (strip, *grid) = stack((9.0, 1.5 + _ROW * sum(heights)), heights)
    if elliptical:  # on a scale of its own
        place: Any = grid.pop()
        place.remove()
        grid[-1].tick_params(labelbottom=True)
        _draw_path(figure.add_subplot(place.get_subplotspec()), phases, trace, period)
    bands = phase_bands(phases)
    for axes, panel in zip(grid, shown.values(), strict=True):
        _draw(axes, panel, trace)
        shade(axes, bands)
    strip.set_xlim(1e3 * first, 1e3 * last)
    grid[-1].set_xlabel(f"time [ms], {part}" if part else "time [ms]")
    figure.align_ylabels(grid)
    _mark_events(shown, dict(zip(panels, grid, strict=True)), phases, trace)
    set_heading(figure, title, values_text(given, hops=any(phase.kind == "H" for phase in phases)))
    settle_bands(figure, strip, bands)
    return figure


def _draw(axes: Axes, panel: Panel, trace: Sample) -> None:
    """Draw the curves of a panel; the legend names several."""
    most = most_force(trace) if panel is PANELS["forces"] else math.inf
    milliseconds = 1e3 * trace.time
    axes.margins(y=_MARGIN)
    for curve in panel.curves:
        values = values_of(curve, panel, trace)
        is_cut = bool((np.abs(values) > most).any())
        label = f"{curve.label} (cut off)" if is_cut else curve.label
        style = {"color": curve.colour, "linestyle": curve.dashes, "linewidth": curve.width}
        axes.plot(milliseconds, values, label=label if len(panel.curves) > 1 else "", **style)
        if curve.field == "static_limit":
            axes.plot(milliseconds, -values, **style)
        if is_cut:
            axes.set_ylim(-most, most)
    draw_zero(axes)
    axes.set_ylabel(f"{panel.label} [{panel.unit}]")


def most_force(trace: Sample) -> float:
    """Force per unit mass that the panel of forces shows at most [m/s^2].

    Where a body hops the load along the trough is often ten times as large as any friction: its scale would
    flatten the curve of friction.
    """
    friction = max(float(trace.static_limit.max()), float(np.abs(trace.friction).max()))
    return _STRETCH * friction or math.inf


def _mark_events(
    shown: Mapping[str, Panel], panels: Mapping[str, Axes], phases: Sequence[Phase], trace: Sample
) -> None:
    """Mark starts and stops of slides, and impacts, on one curve."""
    name = next(name for name in _MARKED if name in panels)
    panel = shown[name]
    values = getattr(trace, panel.curves[-1].field) / panel.size
    for label, mark, instants, before in events_of(phases):
        if seen := [t for t in instants if trace.time[0] < t < trace.time[-1]]:
            places = np.searchsorted(trace.time, seen, side="left" if before else "right") - (not before)
            panels[name].plot(1e3 * np.array(seen), values[places], label=label, zorder=5, **mark)


def _draw_path(axes: Axes, phases: Sequence[Phase], trace: Sample, period: float) -> None:
    """Draw the last turn of a trough.

    Parameters
    ----------
    axes : Axes
        Receives the drawing.
    phases : sequence of Phase
        Phases of the motion: their colours lie under the path, their events are marked on it.
    trace : Sample
        Motion over time, with both sides of every event.
    period : float
        Of the drive [s].
    """
    last = float(trace.time[-1])
    first = max(float(trace.time[0]), last - period)
    seen = trace.time >= first
    time, x, y = trace.time[seen], 1e3 * trace.trough_along[seen], 1e3 * trace.trough_normal[seen]
    for phase in phases:
        part = (time >= phase.start) & (time <= phase.end)
        if part.any():
            (band,) = axes.plot(x[part], y[part], linewidth=_BAND, solid_capstyle="butt", zorder=1)
            band.set(color=PHASE_COLOURS[phase.kind], alpha=TINT)
    axes.plot(x, y, color=INK, linewidth=1.2)
    for _, mark, instants, _ in events_of(phases):
        inside = [t for t in instants if first < t < last]
        axes.plot(np.interp(inside, time, x), np.interp(inside, time, y), zorder=5, **mark)
    if np.ptp(x):  # the way round, where the path is straight
        tail, ahead = x.size // 4, max(1, x.size // 100)
        arrow = {"arrowstyle": "-|>", "color": INK, "mutation_scale": 14}
        axes.annotate("", (x[tail + ahead], y[tail + ahead]), (x[tail], y[tail]), arrowprops=arrow)
    axes.margins(_MARGIN)
    axes.set_aspect("equal")
    axes.locator_params(nbins=4)
    axes.set(xlabel="trough along itself [mm]", ylabel="normal to itself [mm]")
    axes.set_title("path of the trough, last cycle")
