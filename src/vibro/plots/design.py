"""Pictures of a design: guarantees of a drive's settings, and all parts' speeds over the amplitude."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.core.codes import Regime, Status
from vibro.plots.fields import zero_lines
from vibro.plots.frame import mark_operating_point, set_heading, settle, single_frame
from vibro.plots.layers import MapLayers
from vibro.plots.lines import name_bands
from vibro.plots.maps import colour_bar, place_words
from vibro.plots.scales import Scale, even_levels
from vibro.plots.settings import BEGINS, LAST, LIVELIER, Settings, below
from vibro.plots.style import (
    CURVES,
    INK,
    NO_ANSWER_HATCH,
    REGIME_COLOURS,
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

__all__ = ["DESIGN_PICTURES", "design_figures"]

#: Names of the pictures.
DESIGN_PICTURES: Final = ("regime", "speed", "band")

_BEGINS_TO: Final[Mapping[Regime, str]] = {
    Regime.FORWARD_SLIP: "starts",
    Regime.BACK_SLIP: "slips back",
    Regime.HOPPING: "hops",
}
_LAST_BEGINS: Final = (0, (1.5, 3.0))  # dashes where the last part does what a curve says
_TIPS: Final = CurveStyle("first part lifts an edge", (0, (3, 1, 1, 1, 1, 1)), 1.6)
_FORBIDDEN_HATCH: Final = "\\\\"
_VEIL: Final = "#FFFFFF", 0.55  # over settings beyond the drive's limits: colour, opacity
_DRIVE: Final[Mapping[str, Any]] = {"color": "#000000", "linestyle": (0, (8, 2.5)), "linewidth": 1.5}
_MEETS: Final[Mapping[str, Any]] = {"color": "#000000", "linestyle": "-", "linewidth": 3.0}
_NOTHING: Final = "no speed guaranteed"
_BAND: Final = "#A9C4E4"
_WINDOW: Final = "#E4E4E4"
_GOAL: Final = "#994455"
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


def _veiled(colour: str) -> tuple[float, float, float]:
    """Return a colour as it looks under the veil."""
    from matplotlib.colors import to_rgb

    veil, share = to_rgb(_VEIL[0]), _VEIL[1]
    red, green, blue = (
        share * over + (1.0 - share) * under for over, under in zip(veil, to_rgb(colour), strict=True)
    )
    return red, green, blue


class _Layers(MapLayers):
    """The layers of a map of settings."""

    def __init__(self, axes: Axes, settings: Settings) -> None:
        super().__init__(axes, settings.fields, single=True)
        self._settings = settings

    def fill_stretches(self) -> None:
        """Fill the regimes that are guaranteed, hatched where they depend on the part, and name them."""
        load = self._settings.load(self.fields.y[:, np.newaxis], self.fields.x)
        reach = self._settings.over(self._settings.strong)
        is_veiled = (reach > 0.0).any()
        for stretch in self._settings.stretches:
            field = np.minimum(-below(stretch.low, load), below(stretch.high, load))
            if self._fill(field, gid=stretch.name, zorder=1, **stretch.style):
                # names go to settings within the drive's limits, if any: elsewhere colours are pale
                inside, style = np.minimum(field, reach), dict(stretch.style)
                if not (inside > 0.0).any():
                    inside = field
                    style["facecolor"] = _veiled(style["facecolor"]) if is_veiled else style["facecolor"]
                self._name_region(stretch.name, inside, **style)

    def draw_boundaries(self) -> None:
        """Draw where the first and the last part reach regimes; names of areas explain the lines."""
        for regime, curve in BEGINS.items():
            for name in (curve, LAST + curve):
                if pieces := zero_lines(self.fields, self.fields.log_ratio[name]):
                    look = {"color": INK, "linestyle": _dashes(name), "linewidth": CURVES[curve].width}
                    self._line(pieces, label=_begin_text(regime, name), gid=name, zorder=3, **look)
                    self._clear += pieces
        self._draw_tips()

    def cover_forbidden(self) -> None:
        """Cover settings that the goal forbids: the first part is in too high a regime."""
        regime = self._settings.forbidden
        if regime is not None:
            field = self.fields.log_ratio[BEGINS[regime]]
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
            self.legend[label] = dict(look)


def _begin_text(regime: Regime, name: str) -> str:
    """Label a curve by the event that it marks."""
    return f"{'last' if name.startswith(LAST) else 'first'} part {_BEGINS_TO[regime]}"


def _dashes(name: str) -> Any:
    """Return the dashes of a curve, other ones for the last part than for the first."""
    return _LAST_BEGINS if name.startswith(LAST) else CURVES[name].dashes


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
    return "\n".join(
        [
            spans_text(spans) + _ratio(design),
            goal,
            *_drift(spec, elliptical=shape == "normal_phase"),
            *_machine(settings.chosen),
        ]
    )


def _ratio(design: Design) -> str:
    """Describe the ratio of an ellipse's amplitudes."""
    if not design.along_amplitude_mm:
        return "" if design.along_amplitude_mm is None else ", $X$ = 0"
    return f", $Y/X$ = {number_text((design.normal_amplitude_mm or 0.0) / design.along_amplitude_mm)}"


def _drift(spec: Spec, *, elliptical: bool) -> list[str]:
    """Describe the drifts of drive and trough; empty without any."""
    drift = spec.drift
    parts = [
        (100.0 * drift.amplitude, " % of amplitudes" if elliptical else " % $A$"),
        (100.0 * drift.frequency, " % $f$"),
        (math.degrees(drift.drive_angle), r"° $\alpha$"),
        (math.degrees(drift.trough_angle), r"° $\beta$"),
        (math.degrees(drift.normal_phase), r"° $\varphi$"),
    ]
    said = ", ".join(f"±{number_text(size)}{unit}" for size, unit in parts if size)
    return [f"drift: {said}"] if said else []


def _machine(chosen: Chosen) -> list[str]:
    """Describe the amplitudes that voltage and filling make; empty where they make none."""
    design, machine = chosen.design, chosen.drive.machine
    if machine is None or not machine.has_bands:
        return []
    low, high = (f"{end or 0.0:.3g}" for end in (design.amplitude_least_mm, design.amplitude_most_mm))
    return [f"over all voltages and fillings the design's amplitude is {low} to {high} mm; $A$ is the middle"]


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
    panel = settings.fields.panel
    assert panel.y is not None
    figure, axes = single_frame(panel.x, panel.y, _headline(settings, heading), _question(settings))
    return figure, _Layers(axes, settings)


def _finish(figure: Figure, layers: _Layers, settings: Settings) -> Figure:
    marked: dict[str, dict[str, Any]] = {}
    mark_operating_point(layers.axes, settings.point, marked, _marked(settings))
    place_words(figure, [layers], [settings.point], marked)
    return figure


def _speed_band(settings: Settings, band: SpeedBand) -> Figure:
    """Speeds from the slowest to the fastest part over the amplitude, with the goal and what keeps it."""
    from vibro.plots.picture import Picture

    figure = Picture(figsize=_SIZE)
    strip, axes = figure.subplots(2, 1, sharex=True, height_ratios=[0.09, 1.0])
    set_heading(figure, _headline(settings, "Speed of all parts"), _question(settings, frequency=True))
    low, high = float(band.amplitude[0]), float(band.amplitude[-1])
    axes.set_xlim(low, high)
    legend: dict[str, dict[str, Any]] = {}
    _draw_band(axes, band, legend)
    _draw_goal(axes, settings, band, legend)
    _draw_beginnings(axes, settings, legend)
    design = settings.chosen.design
    point = np.array([[design.nominal, design.speed_min_mm_s]], np.float64)
    mark_operating_point(axes, point, legend, _marked(settings))
    assert settings.fields.panel.y is not None
    axes.set_xlabel(axis_label(settings.fields.panel.y))
    axes.set_ylabel("mean conveying speed [mm/s]")
    axes.grid(axis="y", color="#BBBBBB", linewidth=0.5, zorder=0.1)
    settle(figure, legend)
    stretches = [
        stretch._replace(low=max(low, from_), high=min(high, to))
        for stretch in settings.stretches
        for from_, to in [(settings.amplitude(stretch.low), settings.amplitude(stretch.high))]
        if from_ < high and to > low
    ]
    if unnamed := name_bands(figure, strip, stretches):
        settle(figure, unnamed | legend)
    return figure


def _draw_band(axes: Axes, band: SpeedBand, legend: dict[str, dict[str, Any]]) -> None:
    """Draw the slowest, the nominal and the fastest part, with a band if both extremes are known."""
    least, most = (np.where(np.isfinite(v), v, np.nan) for v in (band.speed_min, band.speed_max))
    axes.fill_between(
        band.amplitude, least, most, facecolor=_BAND, edgecolor=INK, linewidth=0.6, zorder=1, gid="band"
    )
    legend["slowest to fastest part"] = {"facecolor": _BAND}
    looks: dict[str, tuple[Floats, dict[str, Any]]] = {
        "guaranteed speed": (least, {"color": INK, "linewidth": 2.2}),
        "nominal speed": (band.speed_nominal, {"color": INK, "linewidth": 1.2, "linestyle": (0, (4, 2))}),
    }
    for name, (values, look) in looks.items():
        axes.plot(band.amplitude, values, gid=name, label=name, zorder=3, **look)
        legend[name] = look
    known = np.concatenate([least, band.speed_nominal, most])
    top = float(np.nanmax(known, initial=0.0))
    bottom = float(np.nanmin(known, initial=0.0))
    axes.set_ylim(bottom - 0.03 * (top - bottom), top + 0.05 * (top - bottom) or 1.0)


def _draw_goal(axes: Axes, settings: Settings, band: SpeedBand, legend: dict[str, dict[str, Any]]) -> None:
    """Draw the required speed, and the amplitudes that guarantee it."""
    goal: dict[str, Any] = {"color": _GOAL, "linewidth": 1.8, "linestyle": (0, (1, 1))}
    axes.axhline(settings.goal, gid="goal", zorder=2.5, **goal)
    low, high = axes.get_ylim()
    axes.set_ylim(low, max(high, 1.05 * settings.goal))
    legend[f"goal {number_text(settings.goal)} mm/s"] = goal
    if band.window is not None:
        low, high = band.window
        axes.axvspan(low, high, gid="window", zorder=0.5, linewidth=0.6, facecolor=_WINDOW, edgecolor=INK)
        legend["keeps the guarantee"] = {"facecolor": _WINDOW}


def _draw_beginnings(axes: Axes, settings: Settings, legend: dict[str, dict[str, Any]]) -> None:
    """Draw the amplitudes at which the first part reaches a regime, and the last one starts."""
    low, high = axes.get_xlim()
    loads: dict[str, tuple[Regime, float]] = {}
    for regime in settings.first(LIVELIER):
        first, last = settings.data.begins[regime]
        loads[BEGINS[regime]] = regime, first
        if regime is Regime.FORWARD_SLIP and first < last:
            loads[LAST + BEGINS[regime]] = regime, last
    for name, (regime, load) in loads.items():
        amplitude = settings.amplitude(load)
        if low < amplitude < high:
            unit = QUANTITIES[settings.data.amplitude].unit
            text = f"{_begin_text(regime, name)}: {number_text(amplitude)} {unit}".rstrip()
            look = {"color": INK, "linestyle": _dashes(name), "linewidth": 1.0}
            axes.axvline(amplitude, zorder=2, gid=name, label=text, **look)
            legend[text] = look
