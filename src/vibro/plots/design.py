"""Pictures of a design: guarantees of a drive's settings, and all parts' speeds over the amplitude."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.core.codes import Regime, Status
from vibro.plots.bands import settle_bands
from vibro.plots.curves import draw_wanted
from vibro.plots.fields import BEGINS_AT, zero_lines
from vibro.plots.frame import facets, mark_point, set_heading, stack
from vibro.plots.layers import MapLayers
from vibro.plots.maps import colour_bar, place_words
from vibro.plots.scales import Scale, even_levels
from vibro.plots.settings import LAST, LIVELIER, Settings, below
from vibro.plots.style import (
    CURVES,
    INK,
    LAST_PART,
    LIMITS,
    NO_ANSWER_HATCH,
    REGIME_COLOURS,
    TIPPING,
    CurveStyle,
    axis_label,
    figure_text,
    house_style,
    number_text,
    spans_text,
)
from vibro.quantities import QUANTITIES, SPEED

if TYPE_CHECKING:
    from collections.abc import Mapping

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from vibro.inverse.designs import Chosen
    from vibro.inverse.specs import Spec
    from vibro.results.designs import Design, SettingFields, SpeedBand

    Floats = NDArray[np.float64]

#: Names of the pictures.
DESIGN_PICTURES: Final = ("regime", "speed", "band")

_BEGINS_TO: Final[Mapping[Regime, str]] = {
    Regime.FORWARD_SLIP: "starts",
    Regime.BACK_SLIP: "slips back",
    Regime.HOPPING: "hops",
}
_TIPS: Final = CurveStyle("first part lifts an edge", TIPPING, 1.6)
_FORBIDDEN_HATCH: Final = "\\\\"
_VEIL: Final = "#FFFFFF", 0.55  # over settings beyond the drive's limits: colour, opacity
_DRIVE: Final[Mapping[str, Any]] = {"color": "#000000", "linestyle": LIMITS, "linewidth": 1.5}
_MEETS: Final[Mapping[str, Any]] = {"color": "#000000", "linestyle": "-", "linewidth": 3.0}
_NOTHING: Final = "no speed guaranteed"
_BAND: Final = "#A9C4E4"
_WINDOW: Final = "#E4E4E4"
_SIZE: Final = (7.4, 5.2)  # [in]
_NAME_SIZE: Final = 8.5  # [pt] of a drive's name
_NAME_ROOM: Final = 160.0  # [pt]


def design_figures(spec: Spec, chosen: Chosen, fields: SettingFields, band: SpeedBand) -> dict[str, Figure]:
    """Draw the guarantees around a design.

    Parameters
    ----------
    spec : Spec
        The question; headings repeat it.
    chosen : Chosen
        The design that is marked.
    fields : SettingFields
        Of its drive and drive angle.
    band : SpeedBand
        At its frequency and drive angle.

    Returns
    -------
    dict of str to Figure
        ``regime``: guaranteed regimes over amplitude and frequency, hatched where they depend on the part;
        ``speed``: the guaranteed speed, and the settings that meet the goal; ``band``: speeds over the
        amplitude.
    """
    settings = Settings(spec, chosen, fields)
    with house_style():
        return {
            "regime": _regime_map(settings),
            "speed": _speed_map(settings),
            "band": _speed_band(settings, band),
        }


class _Layers(MapLayers):
    """The layers of a map of settings."""

    def __init__(self, axes: Axes, settings: Settings) -> None:
        super().__init__(axes, settings.fields, single=True)
        self._settings = settings

    def fill_stretches(self) -> None:
        """Fill the regimes that are guaranteed, hatched where they depend on the part, and name them."""
        load = self._settings.load(self.fields.y[:, np.newaxis], self.fields.x)
        reach = self._settings.over(self._settings.strong)
        for band in self._settings.stretches:
            field = np.minimum(-below(band.low, load), below(band.high, load))
            filled = self._fill(field, gid=band.name, zorder=1, **band.style)
            if filled is not None:
                # Names go to settings within the drive's limits, if any.
                inside = np.minimum(field, reach)
                self._name_region(band.name, inside if (inside > 0.0).any() else field, filled)

    def draw_boundaries(self) -> None:
        """Draw where the first and the last part reach regimes; names of areas explain the lines."""
        for curve in BEGINS_AT.values():
            for name in (curve, LAST + curve):
                if pieces := zero_lines(self.fields, self.fields.log_ratio[name]):
                    look = {"color": INK, "linestyle": _dashes(name), "linewidth": CURVES[curve].width}
                    self._line(pieces, gid=name, zorder=3, **look)
                    self._clear += pieces
        self._draw_tips()

    def cover_forbidden(self) -> None:
        """Cover settings that the goal forbids: the first part is in too high a regime."""
        regime = self._settings.forbidden
        if regime is not None:
            field = self.fields.log_ratio[BEGINS_AT[regime]]
            self.hatch(field, f"some part {_BEGINS_TO[regime]}", _FORBIDDEN_HATCH)
        self._draw_tips()

    def cover_nothing(self, speed: Floats) -> None:
        """Cover settings without a guaranteed speed: below the last part's start, and others."""
        rest = -self.fields.log_ratio[LAST + "forward_onset"]
        self._cover(rest, f"{_NOTHING}: the last part rests", facecolor=REGIME_COLOURS[Regime.NO_SLIP])
        others = np.where(np.nan_to_num(speed) > 0.0, -0.5, 0.5)
        self.hatch(np.minimum(others, -rest), _NOTHING, NO_ANSWER_HATCH[Status.RUNAWAY])

    def draw_drive(self) -> None:
        """Draw the drive's limits, and veil settings beyond them."""
        from matplotlib.colors import to_rgba

        settings = self._settings
        outside = -settings.over(settings.strong)
        if outside.min() < 0.0:
            self._fill(outside, gid="beyond the drive", zorder=2.5, facecolor=to_rgba(*_VEIL))
        pieces = settings.pieces(settings.strong)
        self._outline("drive", f"limits of {_name(settings.chosen)}", pieces, _DRIVE)
        self._clear += pieces

    def draw_meets(self) -> None:
        """Outline the settings that meet the goal."""
        pieces = self._settings.pieces(self._settings.meets)
        self._outline("meets", "meets the goal", pieces, _MEETS)
        self._outlines += pieces  # partly along the contour of the goal, whose label may lie on both

    def _draw_tips(self) -> None:
        self.draw_curve("tips", _TIPS, zero_lines(self.fields, self.fields.log_ratio["tips"]))

    def _outline(self, name: str, label: str, pieces: list[Floats], look: Mapping[str, Any]) -> None:
        from matplotlib.patheffects import withStroke

        if pieces:
            halo = withStroke(linewidth=look["linewidth"] + 2.0, foreground="#FFFFFF")
            self._line(pieces, label=label, gid=name, zorder=4, path_effects=[halo], **look)


def _dashes(name: str) -> Any:
    """Return the dashes of a curve, other ones for the last part than for the first."""
    return LAST_PART if name.startswith(LAST) else CURVES[name].dashes


def _name(chosen: Chosen) -> str:
    return figure_text(chosen.drive.name, _NAME_SIZE, _NAME_ROOM)


def _marked(settings: Settings) -> str:
    """Name the chosen setting."""
    return f"{settings.chosen.design.design} design"


def _headline(settings: Settings, heading: str) -> str:
    return " – ".join(filter(None, (heading, settings.spec.name, settings.chosen.drive.name)))


def _question(settings: Settings, *, frequency: bool = False) -> str:
    """Describe parts, trough, goal and drifts in a few lines."""
    spec, design = settings.spec, settings.chosen.design
    spans = dict(spec.bands)
    shape = "drive_angle" if design.drive_angle_deg is not None else "normal_phase"
    angle = math.radians(design.drive_angle_deg or design.normal_phase_deg or 0.0)
    if design.motion_scale is None:
        spans[shape] = (angle, angle)
    if frequency:
        spans["frequency"] = (float(settings.point[0, 0]),) * 2
    goal = f"goal: at least {number_text(settings.goal)} mm/s"
    if spec.goal.highest_regime is not Regime.HOPPING:
        goal += f", {spec.goal.highest_regime.label} at most"
    else:
        goal += ", hopping allowed"
    if math.isfinite(spec.goal.impact_speed):
        goal += f", impacts up to {number_text(float(SPEED.from_si(spec.goal.impact_speed)))} mm/s"
    if math.isfinite(spec.goal.flight_fraction):
        goal += f", in flight up to {number_text(100.0 * spec.goal.flight_fraction)} %"
    if float(design.speed_min_mm_s or 0.0) < settings.goal:
        goal += " (not met)"
    return f"{spans_text(spans)}{_ratio(design)}\n{goal}"


def _ratio(design: Design) -> str:
    """Describe the ratio of an ellipse's amplitudes."""
    if not design.along_amplitude_mm:
        return "" if design.along_amplitude_mm is None else ", $X$ = 0"
    return f", $Y/X$ = {number_text((design.normal_amplitude_mm or 0.0) / design.along_amplitude_mm)}"


def _regime_map(settings: Settings) -> Figure:
    """Map of the regimes that are guaranteed for every part."""
    figure, layers = _start(settings, "Guaranteed regimes")
    layers.fill_stretches()
    layers.draw_boundaries()
    layers.draw_drive()
    return _finish(figure, layers, settings)


def _speed_map(settings: Settings) -> Figure:
    """Map of the guaranteed speed, with the settings that meet the goal."""
    from matplotlib.colors import Normalize

    figure, layers = _start(settings, "Guaranteed speed")
    speed = settings.fields.panel.cycle["mean_velocity"]
    layers.cover_forbidden()
    layers.cover_nothing(speed)
    moves = np.nan_to_num(speed) > 0.0
    # Scale colours to speeds within the drive's limits, as those beyond may be far higher. A drive with fixed
    # settings may have no cell within them.
    shown = moves & layers.open
    within = shown & (settings.strong(layers.fields.y[:, np.newaxis], layers.fields.x) > 0.0)
    high = float(speed[within if within.any() else shown].max(initial=0.0)) or 1.0
    extend = "max" if np.any(speed[shown] > high) else "neither"
    scale = Scale(Normalize(0.0, high), "cividis", even_levels(0.0, high), None, extend)
    layers.draw_numbers(speed, scale)
    layers.draw_level(speed, settings.goal, f"goal {number_text(settings.goal)} mm/s")
    layers.draw_drive()
    machine = settings.chosen.drive.machine
    if machine is None or not machine.is_filled:  # other amplitudes are not covered
        layers.draw_meets()
    colour_bar(figure, [layers], scale, "guaranteed speed [mm/s]")
    return _finish(figure, layers, settings)


def _start(settings: Settings, heading: str) -> tuple[Figure, _Layers]:
    figure, (axes,) = facets([settings.fields.panel])
    set_heading(figure, _headline(settings, heading), _question(settings))
    return figure, _Layers(axes, settings)


def _finish(figure: Figure, layers: _Layers, settings: Settings) -> Figure:
    mark_point(layers.axes, settings.point, _marked(settings))
    place_words(figure, [layers], [settings.point])
    return figure


def _speed_band(settings: Settings, band: SpeedBand) -> Figure:
    """Speeds from the slowest to the fastest part over the amplitude, with the goal and what keeps it."""
    figure, (strip, axes) = stack(_SIZE, (0.09, 1.0))
    set_heading(figure, _headline(settings, "Speed of all parts"), _question(settings, frequency=True))
    low, high = float(band.amplitude[0]), float(band.amplitude[-1])
    axes.set_xlim(low, high)
    _draw_band(axes, band)
    draw_wanted(axes, settings.goal, f"goal {number_text(settings.goal)} mm/s")
    bottom, top = axes.get_ylim()
    axes.set_ylim(bottom, max(top, 1.05 * settings.goal))
    if band.window is not None:
        look: dict[str, Any] = {"zorder": 0.5, "linewidth": 0.6, "facecolor": _WINDOW, "edgecolor": INK}
        axes.axvspan(*band.window, gid="window", label="keeps the guarantee", **look)
    _draw_beginnings(axes, settings)
    design = settings.chosen.design
    point = np.array([[design.nominal, design.speed_min_mm_s]], np.float64)
    mark_point(axes, point, _marked(settings))
    assert settings.fields.panel.y is not None
    axes.set(xlabel=axis_label(settings.fields.panel.y), ylabel="mean conveying speed [mm/s]")
    axes.grid(axis="y", color="#BBBBBB", linewidth=0.5, zorder=0.1)
    shown = [
        stretch._replace(low=max(low, begin), high=min(high, end))
        for stretch in settings.stretches
        for begin, end in [(settings.amplitude(stretch.low), settings.amplitude(stretch.high))]
        if begin < high and end > low
    ]
    settle_bands(figure, strip, shown)
    return figure


def _draw_band(axes: Axes, band: SpeedBand) -> None:
    """Draw the slowest, the nominal and the fastest part, with a band if both extremes are known."""
    least, most = (np.where(np.isfinite(v), v, np.nan) for v in (band.speed_min, band.speed_max))
    look: dict[str, Any] = {"facecolor": _BAND, "edgecolor": INK, "linewidth": 0.6, "zorder": 1}
    axes.fill_between(band.amplitude, least, most, gid="band", label="slowest to fastest part", **look)
    for name, values, width in (("guaranteed speed", least, 2.4), ("nominal speed", band.speed_nominal, 1.0)):
        axes.plot(band.amplitude, values, gid=name, label=name, zorder=3, color=INK, linewidth=width)
    known = np.concatenate([least, band.speed_nominal, most])
    top = float(np.nanmax(known, initial=0.0))
    bottom = float(np.nanmin(known, initial=0.0))
    axes.set_ylim(bottom - 0.03 * (top - bottom), top + 0.05 * (top - bottom) or 1.0)


def _draw_beginnings(axes: Axes, settings: Settings) -> None:
    """Draw the amplitudes at which the first part reaches a regime, and the last one starts."""
    loads: dict[str, tuple[Regime, float]] = {}
    for regime in settings.first(LIVELIER):
        first, last = settings.data.begins[regime]
        loads[BEGINS_AT[regime]] = regime, first
        if regime is Regime.FORWARD_SLIP and first < last:
            loads[LAST + BEGINS_AT[regime]] = regime, last
    for name, (regime, load) in loads.items():
        amplitude = settings.amplitude(load)
        if math.isfinite(amplitude):
            unit = QUANTITIES[settings.data.amplitude].unit
            part = "last" if name.startswith(LAST) else "first"
            text = f"{part} part {_BEGINS_TO[regime]}: {number_text(amplitude)} {unit}".rstrip()
            look = {"color": INK, "linestyle": _dashes(name), "linewidth": 1.0}
            axes.axvline(amplitude, zorder=2, gid=name, label=text, **look)
