"""Settings of a drive over amplitude and frequency: their guarantees, as fields that maps draw."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.axes import Axis
from vibro.core.codes import Regime
from vibro.plots.bands import Band
from vibro.plots.fields import BEGINS_AT, Fields, clip_line, zero_lines
from vibro.plots.style import REGIME_COLOURS
from vibro.plots.view import Panel
from vibro.quantities import LENGTH, QUANTITIES

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from vibro.inverse.designs import Chosen
    from vibro.inverse.specs import Spec
    from vibro.results.designs import SettingFields

    Floats = NDArray[np.float64]

#: Regimes with motion.
LIVELIER: Final = tuple(BEGINS_AT)
#: Prefix of a curve of the last part; other curves are of the first part.
LAST: Final = "last_"

_RESOLVED: Final = 301  # values an axis
_DEPENDS_HATCH: Final = "////"
_FAR: Final = 30.0  # where logarithms are cut, so that contours find finite numbers
_ROUNDING: Final = 1.0 + 1e-9


def below(limit: float, values: Any) -> Floats:
    """ln(limit / values): positive below a limit, and finite; negative where a value is unknown."""
    with np.errstate(divide="ignore", invalid="ignore"):
        excess = np.log(limit / np.asarray(values, np.float64))
    return np.asarray(np.clip(np.nan_to_num(excess, nan=-_FAR), -_FAR, _FAR))


def _stretch(low: float, high: float, least: Regime, most: Regime) -> Band:
    """Return a range of loads in which the first part keeps one regime and the last one another, or the same.

    It has the first part's colour, hatched in that of the last part.
    """
    face = {"facecolor": REGIME_COLOURS[most]}
    if least is most:
        return Band(low, high, most.label, face)
    join = "or" if most - least == 1 else "to"
    name = f"{least.label} {join} {most.label}, by part"
    return Band(low, high, name, {**face, "hatch": _DEPENDS_HATCH, "edgecolor": REGIME_COLOURS[least]})


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
    """

    spec: Spec
    chosen: Chosen
    data: SettingFields

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
    def goal(self) -> float:
        """Least speed [mm/s]."""
        return float(LENGTH.from_si(self.spec.goal.speed))

    @property
    def forbidden(self) -> Regime | None:
        """Event of the first part that the goal forbids; None if all are allowed."""
        higher = [regime for regime in LIVELIER if regime > self.spec.goal.highest_regime]
        return next(iter(self.first(higher)), None)

    def first(self, regimes: Sequence[Regime]) -> list[Regime]:
        """Leave out regimes that the first part never reaches, or skips as a higher one begins there too."""
        load = {regime: self.data.begins[regime][0] for regime in regimes}
        return [r for r in regimes if load[r] < min((load[h] for h in regimes if h > r), default=math.inf)]

    @property
    def stretches(self) -> list[Band]:
        """Regimes of all parts, from rest on, as the load rises."""
        begins = [self.data.begins[regime] for regime in LIVELIER]
        edges = sorted({0.0, math.inf, *(load for pair in begins for load in pair)})
        found = []
        for low, high in pairwise(edges):
            most, least = (Regime(sum(pair[which] <= low for pair in begins)) for which in (0, 1))
            found.append(_stretch(low, high, least, most))
        return found

    def __post_init__(self) -> None:
        shown = self.load(*np.array([self.data.amplitudes, self.data.frequency_hz]))
        if not (self.data.load[0] <= shown[0] * _ROUNDING and shown[1] <= self.data.load[-1] * _ROUNDING):
            raise ValueError(f"loads {self.data.load[[0, -1]]} do not cover the settings' {shown}")

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
