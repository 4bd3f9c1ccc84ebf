"""Pictures of a design: what a drive's settings do to all parts, and all parts' speeds over the amplitude."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.axes import Axis
from vibro.core.codes import Regime, Status
from vibro.plots import DESIGN_PICTURES, frame, style
from vibro.plots.fields import BEGINS_AT, Fields, clip_line, zero_lines
from vibro.plots.layers import WHITE, MapLayers
from vibro.plots.maps import colour_bar, place_words
from vibro.plots.scales import SEQUENTIAL, Scale, even_levels
from vibro.plots.view import Panel
from vibro.units import LENGTH

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from matplotlib.figure import Figure

    from vibro.designs.design import Chosen
    from vibro.designs.questions import Spec
    from vibro.reals import Floats
    from vibro.results.designs import SettingFields, SpeedBand


_BEGINS_TO: Final = dict(zip(BEGINS_AT, ("starts", "slips back", "hops"), strict=True))
_TIPS: Final = style.CurveStyle("first part lifts an edge", style.TIPPING, 1.6)
_UNKNOWN: Final = style.no_answer(Status.RUNAWAY)[1]
_FORBIDDEN_HATCH: Final = "\\\\"
_VEIL: Final = (1.0, 1.0, 1.0, 0.55)  # over settings beyond the drive's limits
_DRIVE: Final = style.CurveStyle("limits of the drive", style.LIMITS, 1.5, "#000000")
_MEETS: Final = style.CurveStyle("meets the goal", "-", 3.0, "#000000")
_NOTHING: Final = "no speed for every part"
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
        size = self.chosen.drive.size(self.chosen.setting).read(amplitude)
        return self.chosen.drive.space.load_at(size, frequency, self.spec.gravity)

    def amplitude(self, load: float) -> float:
        """Amplitude or stroke [mm], or scale [1], at which the chosen frequency has a load."""
        one = self.chosen.drive.space.load_at(1.0, float(self.point[0, 0]), self.spec.gravity)
        return float(self.chosen.drive.size(self.chosen.setting).printed(load / float(one)))

    def speed(self, amplitude: Any, frequency: Any) -> Floats:
        """Speed of the slowest of some parts; NaN where one has none [mm/s]."""
        known = np.where(np.isfinite(self.data.speed_min), self.data.speed_min, np.nan)
        return np.asarray(self._at_load(known, amplitude, frequency) / frequency)

    def strong(self, amplitude: Any, frequency: Any) -> Floats:
        """Positive where amplitude and acceleration keep to the drive's limits, at any frequency."""
        low, high = self.data.limits
        excess = [below(high, amplitude), below(self.data.most_load, self.load(amplitude, frequency))]
        excess += [-below(low, amplitude)] if low > 0.0 else []
        return np.asarray(np.minimum.reduce(np.broadcast_arrays(*excess)))

    def meets(self, amplitude: Any, frequency: Any) -> Floats:
        """Positive where the drive's limits hold and all demands of goal and parts are kept."""
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


@style.house_style()
def design_figures(
    spec: Spec,
    chosen: Chosen,
    fields: SettingFields,
    band: SpeedBand,
    wanted: str,
    names: Sequence[str] = DESIGN_PICTURES,
) -> dict[str, Figure]:
    """Draw speeds and regimes around a design.

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
    names : sequence of str, optional
        Those that are drawn.

    Returns
    -------
    dict of str to Figure
        ``regime``: regimes over amplitude and frequency, hatched where they depend on the part; ``speed``:
        the speed of the slowest part, and the settings that meet the goal; ``band``: speeds over the
        amplitude.
    """
    settings = Settings(spec, chosen, fields, wanted)
    drawings: dict[str, Callable[[], Figure]] = {
        "regime": lambda: _map(settings, "Regimes of all parts", _draw_regimes),
        "speed": lambda: _map(settings, "Speed of the slowest part", _draw_speed),
        "band": lambda: _speed_band(settings, band),
    }
    return {name: drawings[name]() for name in names}


def _map(settings: Settings, heading: str, draw: Callable[[Figure, MapLayers, Settings], None]) -> Figure:
    """Draw a map with the drive's limits and the chosen setting; veil settings beyond these limits."""
    figure, (axes,) = frame.facets([settings.fields.panel])
    _head(figure, settings, heading)
    layers = MapLayers(axes, settings.fields, single=True)
    draw(figure, layers, settings)
    layers.draw_curve("tips", _TIPS, zero_lines(layers.fields, layers.fields.log_ratio["tips"]))
    outside = -settings.over(settings.strong)
    if outside.min() < 0.0:
        layers.fill(outside, gid="beyond the drive", zorder=2.5, facecolor=_VEIL)
    layers.draw_curve("drive", _DRIVE, settings.pieces(settings.strong))
    frame.mark_point(axes, settings.point, settings.marked)
    place_words(figure, [layers], [settings.point])
    return figure


def _draw_regimes(_: Figure, layers: MapLayers, settings: Settings) -> None:
    """Fill the regimes of all parts, hatched where they depend on the part, with their boundaries."""
    fields = layers.fields
    load, reach = settings.load(fields.y[:, np.newaxis], fields.x), settings.over(settings.strong)
    for band in settings.stretches:
        field = np.minimum(-below(band.low, load), below(band.high, load))
        # Names go to settings within the drive's limits, if any.
        inside = np.minimum(field, reach)
        layers.fill_region(band.name, field, inside if (inside > 0.0).any() else field, band.look)
    for regime in BEGINS_AT:
        for last in (False, True):
            name, curve = _boundary(regime, last)  # that the names of areas explain
            layers.draw_curve(name, curve._replace(label=""), zero_lines(fields, fields.log_ratio[name]))


def _draw_speed(figure: Figure, layers: MapLayers, settings: Settings) -> None:
    """Draw the speed of the slowest part, with the settings that meet the goal."""
    from matplotlib.colors import Normalize

    fields, speed = layers.fields, layers.fields.panel.cycle["mean_velocity"]
    if (regime := settings.forbidden) is not None:  # the first part is in too high a regime
        look = {**_UNKNOWN, "hatch": _FORBIDDEN_HATCH}
        layers.cover(fields.log_ratio[BEGINS_AT[regime]], f"some part {_BEGINS_TO[regime]}", look)
    rest = -fields.log_ratio[LAST + "forward_onset"]
    layers.cover(rest, f"{_NOTHING}: the last part rests", WHITE)
    moves = np.nan_to_num(speed) > 0.0
    layers.cover(np.minimum(np.where(moves, -0.5, 0.5), -rest), _NOTHING, _UNKNOWN)
    # Scale colours to speeds within the drive's limits, as those beyond may be far higher. A drive with fixed
    # settings may have no cell within them.
    shown = moves & layers.open
    within = shown & (settings.strong(fields.y[:, np.newaxis], fields.x) > 0.0)
    high = float(speed[within if within.any() else shown].max(initial=0.0)) or 1.0
    extend = "max" if np.any(speed[shown] > high) else "neither"
    scale = Scale(Normalize(0.0, high), SEQUENTIAL, even_levels(0.0, high), extend=extend)
    layers.draw_numbers(speed, scale)
    layers.draw_level(speed, settings.goal, f"goal {style.number_text(settings.goal)} mm/s")
    machine = settings.chosen.drive.machine
    if machine is None or not machine.is_filled:  # other amplitudes are not covered
        layers.draw_curve("meets", _MEETS, settings.pieces(settings.meets))
    colour_bar(figure, [layers], scale, "speed of the slowest part [mm/s]")


def _boundary(regime: Regime, last: bool) -> tuple[str, style.CurveStyle]:
    """Name and draw the load at which the first or the last part reaches a regime."""
    name, curve = BEGINS_AT[regime], style.CURVES[BEGINS_AT[regime]]
    label = f"{'last' if last else 'first'} part {_BEGINS_TO[regime]}"
    dashes = style.LAST_PART if last else curve.dashes
    return LAST * last + name, curve._replace(label=label, dashes=dashes)


def _head(figure: Figure, settings: Settings, heading: str, **more: tuple[float, float]) -> None:
    """Write the heading; below, parts, trough, further quantities, and goal in two lines."""
    design, spans = settings.chosen.design, {**settings.spec.bands, **more}
    if settings.spec.goal.highest_regime is Regime.HOPPING:
        spans["restitution"] = settings.spec.bounces
    angle = math.radians(design.drive_angle_deg or design.normal_phase_deg or 0.0)
    if design.motion_scale is None:
        shape = "drive_angle" if design.drive_angle_deg is not None else "normal_phase"
        spans[shape] = (angle, angle)
    parts = [style.spans_text(spans)]
    if design.along_amplitude_mm:
        ratio = (design.normal_amplitude_mm or 0.0) / design.along_amplitude_mm
        parts.append(f"$Y/X$ = {style.number_text(ratio)}")
    elif design.along_amplitude_mm is not None:
        parts.append("$X$ = 0")
    headline = f"{heading} – {settings.spec.name} – {settings.chosen.drive.name}"
    frame.set_heading(figure, headline, f"{', '.join(parts)}\n{settings.wanted}")


def _speed_band(settings: Settings, band: SpeedBand) -> Figure:
    """Speeds from the slowest to the fastest part over the amplitude, with the goal and what keeps it."""
    figure, (strip, axes) = frame.stack(_SIZE, (0.09, 1.0))
    _head(figure, settings, "Speed of all parts", frequency=(float(settings.point[0, 0]),) * 2)
    axes.set_xlim(float(band.amplitude[0]), float(band.amplitude[-1]))
    least, most = (np.where(np.isfinite(v), v, np.nan) for v in (band.speed_min, band.speed_max))
    edge: dict[str, Any] = {"edgecolor": style.INK, "linewidth": 0.6}
    look = {"facecolor": _BAND, "zorder": 1, "label": "slowest to fastest part", **edge}
    axes.fill_between(band.amplitude, least, most, gid="band", **look)
    for name, values, width in (("slowest part", least, 2.4), ("middle part", band.speed_nominal, 1.0)):
        axes.plot(band.amplitude, values, gid=name, label=name, zorder=3, color=style.INK, linewidth=width)
    frame.draw_wanted(axes, settings.goal, f"goal {style.number_text(settings.goal)} mm/s")
    if band.window is not None:
        look = {"facecolor": _WINDOW, "zorder": 0.5, "label": "keeps the goal", **edge}
        axes.axvspan(*band.window, gid="window", **look)
    for regime in settings.first:
        for last, load in enumerate(settings.data.begins[regime]):
            amplitude = settings.amplitude(load)
            if math.isfinite(amplitude) and (not last or regime is Regime.FORWARD_SLIP):
                name, curve = _boundary(regime, bool(last))
                text = f"{curve.label}: {style.value_text(settings.data.amplitude, amplitude)}".rstrip()
                axes.axvline(amplitude, zorder=2, gid=name, label=text, **{**curve.look, "linewidth": 1.0})
    design = settings.chosen.design
    frame.mark_point(axes, np.array([[design.nominal, design.speed_min_mm_s]], np.float64), settings.marked)
    assert settings.fields.panel.y is not None
    machine = settings.chosen.drive.machine
    middle = "middle of voltages and fillings: " if machine is not None and machine.has_bands else ""
    axes.set_xlabel(middle + style.axis_label(settings.fields.panel.y))
    axes.set_ylabel("mean conveying speed [mm/s]")
    axes.grid(axis="y", color="#BBBBBB", linewidth=0.5, zorder=0.1)
    shown = [
        stretch._replace(low=settings.amplitude(stretch.low), high=settings.amplitude(stretch.high))
        for stretch in settings.stretches
    ]
    frame.settle_bands(figure, strip, shown)
    return figure
