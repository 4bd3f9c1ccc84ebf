"""Pictures of a design: guarantees of a drive's settings, and all parts' speeds over the amplitude."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.axes import Axis
from vibro.core.codes import Regime, Status
from vibro.plots import frame, style
from vibro.plots.fields import BEGINS_AT, Fields, clip_line, zero_lines
from vibro.plots.layers import WHITE, MapLayers
from vibro.plots.maps import colour_bar, place_words
from vibro.plots.scales import Scale, even_levels
from vibro.plots.view import Panel
from vibro.quantities import LENGTH, QUANTITIES

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from vibro.inverse.designs import Chosen
    from vibro.inverse.specs import Spec
    from vibro.results.designs import SettingFields, SpeedBand

    Floats = NDArray[np.float64]

_BEGINS_TO: Final = dict(zip(BEGINS_AT, ("starts", "slips back", "hops"), strict=True))
_TIPS: Final = style.CurveStyle("first part lifts an edge", style.TIPPING, 1.6)
_UNKNOWN: Final = style.no_answer(Status.RUNAWAY)[1]
_FORBIDDEN_HATCH: Final = "\\\\"
_VEIL: Final = "#FFFFFF", 0.55  # over settings beyond the drive's limits: colour, opacity
_DRIVE: Final = style.CurveStyle("limits of the drive", style.LIMITS, 1.5, "#000000")
_MEETS: Final = style.CurveStyle("meets the goal", "-", 3.0, "#000000")
_NOTHING: Final = "no speed guaranteed"
_BAND: Final = "#A9C4E4"
_WINDOW: Final = "#E4E4E4"
_SIZE: Final = (7.4, 5.2)  # [in]
#: Prefix of a curve of the last part; other curves are of the first part.
LAST: Final = "last_"

_RESOLVED: Final = 301  # values an axis
_DEPENDS_HATCH: Final = "////"
_FAR: Final = 30.0  # where logarithms are cut, so that contours find finite numbers


def below(limit: float, values: Any) -> Floats:
    """ln(limit / values): positive below a limit, and finite; negative where a value is unknown."""
    with np.errstate(divide="ignore", invalid="ignore"):
        excess = np.log(limit / np.asarray(values, np.float64))
    return np.asarray(np.clip(np.nan_to_num(excess, nan=-_FAR), -_FAR, _FAR))


@dataclass(frozen=True, eq=False)
class Settings:
    """Amplitudes and frequencies of a drive, in the user's units, with their guarantees.

    Attributes
    ----------
    spec : Spec
        The question.
    chosen : Chosen
        The design that is marked.
    data : SettingFields
        Of its drive and drive angle.
    wanted : str
        The goal in words.
    """

    spec: Spec
    chosen: Chosen
    data: SettingFields
    wanted: str

    @cached_property
    def fields(self) -> Fields:
        """The grid of a map, with the loads at which the first and the last part reach regimes."""
        x = Axis("frequency", np.linspace(*self.data.frequency_hz, _RESOLVED), "linear")
        y = Axis(self.data.amplitude, np.geomspace(*self.data.amplitudes, _RESOLVED), "log")
        loads = {"tips": self.data.tips}
        for regime, curve in BEGINS_AT.items():
            loads[curve], loads[LAST + curve] = self.data.begins[regime]
        critical = {name: np.array([[load]]) for name, load in loads.items()}
        grid = (y.values[:, np.newaxis], x.values)
        speed = self.speed(*grid)
        cycle = {"mean_velocity": speed, "period_cycles": np.ones(speed.shape)}
        return Fields(Panel(x, y, {}, None, cycle, critical, self.load(*grid)))

    @property
    def point(self) -> Floats:
        """The chosen setting, as an array of shape (1, 2)."""
        return np.array([[self.chosen.design.frequency_hz, self.chosen.design.nominal]], np.float64)

    @property
    def marked(self) -> str:
        """Name of the chosen setting."""
        return f"{self.chosen.design.design} design"

    @property
    def goal(self) -> float:
        """Least speed [mm/s]."""
        return float(LENGTH.from_si(self.spec.goal.speed))

    @property
    def forbidden(self) -> Regime | None:
        """Event of the first part that the goal forbids; None if all are allowed."""
        return next((regime for regime in self.first if regime > self.spec.goal.highest_regime), None)

    @property
    def first(self) -> list[Regime]:
        """Regimes that the first part reaches, without those skipped as a higher one begins there."""
        load = {regime: self.data.begins[regime][0] for regime in BEGINS_AT}
        return [r for r in load if load[r] < min((load[h] for h in load if h > r), default=math.inf)]

    @property
    def stretches(self) -> list[frame.Band]:
        """Regimes of all parts, from rest on, as the load rises.

        They have the first part's colour, hatched in that of the last part where that is in another regime.
        """
        begins = [self.data.begins[regime] for regime in BEGINS_AT]
        found = []
        for low, high in pairwise(sorted({0.0, math.inf, *(load for pair in begins for load in pair)})):
            most, least = (Regime(sum(pair[which] <= low for pair in begins)) for which in (0, 1))
            name, look = most.label, {"facecolor": style.REGIME_COLOURS[most]}
            if least is not most:
                name = f"{least.label} {'or' if most - least == 1 else 'to'} {name}, by part"
                look |= {"hatch": _DEPENDS_HATCH, "edgecolor": style.REGIME_COLOURS[least]}
            found.append(frame.Band(low, high, name, look))
        return found

    def load(self, amplitude: Any, frequency: Any) -> Floats:
        """G = A w^2 / g of an amplitude or a stroke in the drive's units [mm], or of a scale [1]."""
        size = QUANTITIES[self.data.amplitude].to_si(amplitude) / self.chosen.drive.told_per_amplitude
        return self.chosen.drive.space.load_at(size, frequency, self.spec.gravity)

    def amplitude(self, load: float) -> float:
        """Amplitude or stroke [mm], or scale [1], at which the chosen frequency has a load."""
        one = self.chosen.drive.space.load_at(1.0, float(self.point[0, 0]), self.spec.gravity)
        size = load / float(one) * self.chosen.drive.told_per_amplitude
        return float(QUANTITIES[self.data.amplitude].from_si(size))

    def speed(self, amplitude: Any, frequency: Any) -> Floats:
        """Guaranteed speed; NaN where none is guaranteed [mm/s]."""
        known = np.where(np.isfinite(self.data.speed_min), self.data.speed_min, np.nan)
        return np.asarray(self._at_load(known, amplitude, frequency) / frequency)

    def strong(self, amplitude: Any, frequency: Any) -> Floats:
        """Positive where amplitude and acceleration keep to the drive's limits, at any frequency."""
        low, high = self.data.limits
        excess = [below(high, amplitude), below(self.data.most_load, self.load(amplitude, frequency))]
        excess += [-below(low, amplitude)] if low > 0.0 else []
        return np.asarray(np.minimum.reduce(np.broadcast_arrays(*excess)))

    def meets(self, amplitude: Any, frequency: Any) -> Floats:
        """Positive where the drive's limits hold and all demands of goal and parts are guaranteed."""
        goal = self.spec.goal
        load = self.load(amplitude, frequency)
        excess = [
            self.strong(amplitude, frequency),
            -below(self.goal, np.fmax(self.speed(amplitude, frequency), 0.0)),
            below(self.data.tips, load),
        ]
        if self.forbidden is not None:
            excess.append(below(self.data.begins[self.forbidden][0], load))
        if self.data.impact_speed is not None:
            impact = self._at_load(self.data.impact_speed, amplitude, frequency) / frequency
            excess.append(below(float(LENGTH.from_si(goal.impact_speed)), impact))
        if self.data.flight_fraction is not None:
            flight = self._at_load(self.data.flight_fraction, amplitude, frequency)
            excess.append(below(goal.flight_fraction, flight))
        return np.asarray(np.minimum.reduce(excess))

    def over(self, excess: Callable[[Any, Any], Floats]) -> Floats:
        """Return an excess over the grid, negative beside the frequency ranges of the drive."""
        y, x = self.fields.y[:, np.newaxis], self.fields.x
        ranges = [span for span in self.chosen.drive.frequency if span[0] < span[1]]
        inside = [np.minimum(-below(low, x), below(high, x)) for low, high in ranges]
        chosen = np.maximum.reduce([np.full(x.shape, -_FAR), *inside])
        return np.asarray(np.minimum(chosen, excess(y, x)))

    def pieces(self, excess: Callable[[Any, Any], Floats]) -> list[Floats]:
        """Return lines around the drive's settings with an excess, and along them at single frequencies."""
        found = zero_lines(self.fields, self.over(excess))
        for low, high in self.chosen.drive.frequency:
            if low == high:
                line = np.column_stack([np.full(self.fields.y.shape, low), self.fields.y])
                found += clip_line(line, -excess(line[:, 1], line[:, 0]))
        return found

    def _at_load(self, values: Floats, amplitude: Any, frequency: Any) -> Floats:
        return np.asarray(np.interp(self.load(amplitude, frequency), self.data.load, values))


def design_figures(
    spec: Spec, chosen: Chosen, fields: SettingFields, band: SpeedBand, wanted: str
) -> dict[str, Figure]:
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
    wanted : str
        The goal in words, and whether it is met, for headings.

    Returns
    -------
    dict of str to Figure
        ``regime``: guaranteed regimes over amplitude and frequency, hatched where they depend on the part;
        ``speed``: the guaranteed speed, and the settings that meet the goal; ``band``: speeds over the
        amplitude.
    """
    settings = Settings(spec, chosen, fields, wanted)
    with style.house_style():
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
            filled = self._fill(field, gid=band.name, zorder=1, **band.look)
            if filled is not None:
                # Names go to settings within the drive's limits, if any.
                inside = np.minimum(field, reach)
                self._name_region(band.name, inside if (inside > 0.0).any() else field, filled)

    def draw_boundaries(self) -> None:
        """Draw where the first and the last part reach regimes; names of areas explain the lines."""
        for curve in BEGINS_AT.values():
            for name in (curve, LAST + curve):
                if pieces := zero_lines(self.fields, self.fields.log_ratio[name]):
                    look = {**style.CURVES[curve].look, "linestyle": _dashes(name)}
                    self._line(pieces, gid=name, zorder=3, **look)
                    self._clear += pieces

    def cover_forbidden(self) -> None:
        """Cover settings that the goal forbids: the first part is in too high a regime."""
        regime = self._settings.forbidden
        if regime is not None:
            field = self.fields.log_ratio[BEGINS_AT[regime]]
            self.cover(field, f"some part {_BEGINS_TO[regime]}", {**_UNKNOWN, "hatch": _FORBIDDEN_HATCH})

    def cover_nothing(self, speed: Floats) -> None:
        """Cover settings without a guaranteed speed: below the last part's start, and others."""
        rest = -self.fields.log_ratio[LAST + "forward_onset"]
        self.cover(rest, f"{_NOTHING}: the last part rests", WHITE)
        others = np.where(np.nan_to_num(speed) > 0.0, -0.5, 0.5)
        self.cover(np.minimum(others, -rest), _NOTHING, _UNKNOWN)

    def draw_drive(self) -> None:
        """Draw where parts tip, and the drive's limits; veil settings beyond these."""
        from matplotlib.colors import to_rgba

        self.draw_curve("tips", _TIPS, zero_lines(self.fields, self.fields.log_ratio["tips"]))
        outside = -self._settings.over(self._settings.strong)
        if outside.min() < 0.0:
            self._fill(outside, gid="beyond the drive", zorder=2.5, facecolor=to_rgba(*_VEIL))
        self.draw_curve("drive", _DRIVE, self._settings.pieces(self._settings.strong))


def _dashes(name: str) -> Any:
    """Return the dashes of a curve, other ones for the last part than for the first."""
    return style.LAST_PART if name.startswith(LAST) else style.CURVES[name].dashes


def _head(figure: Figure, settings: Settings, heading: str, *, frequency: bool = False) -> None:
    """Write the heading; below, parts, trough and goal in two lines."""
    design, spans = settings.chosen.design, dict(settings.spec.bands)
    shape = "drive_angle" if design.drive_angle_deg is not None else "normal_phase"
    angle = math.radians(design.drive_angle_deg or design.normal_phase_deg or 0.0)
    if design.motion_scale is None:
        spans[shape] = (angle, angle)
    if frequency:
        spans["frequency"] = (float(settings.point[0, 0]),) * 2
    parts = [style.spans_text(spans)]
    if design.along_amplitude_mm:
        ratio = (design.normal_amplitude_mm or 0.0) / design.along_amplitude_mm
        parts.append(f"$Y/X$ = {style.number_text(ratio)}")
    elif design.along_amplitude_mm is not None:
        parts.append("$X$ = 0")
    headline = f"{heading} – {settings.spec.name} – {settings.chosen.drive.name}"
    frame.set_heading(figure, headline, f"{', '.join(parts)}\n{settings.wanted}")


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
    layers.draw_level(speed, settings.goal, f"goal {style.number_text(settings.goal)} mm/s")
    layers.draw_drive()
    machine = settings.chosen.drive.machine
    if machine is None or not machine.is_filled:  # other amplitudes are not covered
        layers.draw_curve("meets", _MEETS, settings.pieces(settings.meets))
    colour_bar(figure, [layers], scale, "guaranteed speed [mm/s]")
    return _finish(figure, layers, settings)


def _start(settings: Settings, heading: str) -> tuple[Figure, _Layers]:
    figure, (axes,) = frame.facets([settings.fields.panel])
    _head(figure, settings, heading)
    return figure, _Layers(axes, settings)


def _finish(figure: Figure, layers: _Layers, settings: Settings) -> Figure:
    frame.mark_point(layers.axes, settings.point, settings.marked)
    place_words(figure, [layers], [settings.point])
    return figure


def _speed_band(settings: Settings, band: SpeedBand) -> Figure:
    """Speeds from the slowest to the fastest part over the amplitude, with the goal and what keeps it."""
    figure, (strip, axes) = frame.stack(_SIZE, (0.09, 1.0))
    _head(figure, settings, "Speed of all parts", frequency=True)
    axes.set_xlim(float(band.amplitude[0]), float(band.amplitude[-1]))
    _draw_band(axes, band)
    frame.draw_wanted(axes, settings.goal, f"goal {style.number_text(settings.goal)} mm/s")
    if band.window is not None:
        look: dict[str, Any] = {"zorder": 0.5, "linewidth": 0.6, "facecolor": _WINDOW, "edgecolor": style.INK}
        axes.axvspan(*band.window, gid="window", label="keeps the guarantee", **look)
    _draw_beginnings(axes, settings)
    design = settings.chosen.design
    frame.mark_point(axes, np.array([[design.nominal, design.speed_min_mm_s]], np.float64), settings.marked)
    assert settings.fields.panel.y is not None
    axes.set(xlabel=style.axis_label(settings.fields.panel.y), ylabel="mean conveying speed [mm/s]")
    axes.grid(axis="y", color="#BBBBBB", linewidth=0.5, zorder=0.1)
    shown = [
        stretch._replace(low=settings.amplitude(stretch.low), high=settings.amplitude(stretch.high))
        for stretch in settings.stretches
    ]
    frame.settle_bands(figure, strip, shown)
    return figure


def _draw_band(axes: Axes, band: SpeedBand) -> None:
    """Draw the slowest, the nominal and the fastest part, with a band if both extremes are known."""
    least, most = (np.where(np.isfinite(v), v, np.nan) for v in (band.speed_min, band.speed_max))
    look: dict[str, Any] = {"facecolor": _BAND, "edgecolor": style.INK, "linewidth": 0.6, "zorder": 1}
    axes.fill_between(band.amplitude, least, most, gid="band", label="slowest to fastest part", **look)
    for name, values, width in (("guaranteed speed", least, 2.4), ("nominal speed", band.speed_nominal, 1.0)):
        axes.plot(band.amplitude, values, gid=name, label=name, zorder=3, color=style.INK, linewidth=width)


def _draw_beginnings(axes: Axes, settings: Settings) -> None:
    """Draw the amplitudes at which the first part reaches a regime, and the last one starts."""
    unit = QUANTITIES[settings.data.amplitude].unit
    for regime in settings.first:
        for prefix, load in zip(("", LAST), settings.data.begins[regime], strict=True):
            amplitude = settings.amplitude(load)
            if math.isfinite(amplitude) and (not prefix or regime is Regime.FORWARD_SLIP):
                name = prefix + BEGINS_AT[regime]
                text = f"{'last' if prefix else 'first'} part {_BEGINS_TO[regime]}: "
                text += f"{style.number_text(amplitude)} {unit}".rstrip()
                look = {**style.CURVES[BEGINS_AT[regime]].look, "linestyle": _dashes(name), "linewidth": 1.0}
                axes.axvline(amplitude, zorder=2, gid=name, label=text, **look)
