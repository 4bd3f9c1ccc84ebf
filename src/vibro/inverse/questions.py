"""A question about one drive: the boxes of its settings, and how far they may be loaded."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from vibro.core.codes import Regime
from vibro.inverse.boxes import Box
from vibro.inverse.caps import hop_load, regime_loads, tip_load
from vibro.inverse.extremes import ANY_LANDING, Landings, counted
from vibro.steady import solve

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.inverse.bodies import Bodies
    from vibro.inverse.boxes import Ends
    from vibro.inverse.specs import Drive, Span, Spec

    Floats = NDArray[np.float64]

__all__ = ["MOST_THROW", "Asked", "Question", "Range", "Setting", "off"]

_RIGHT_ANGLE: Final = 0.5 * math.pi
_SHORT: Final = 1e-6  # [rad, 1] by which scaled bands keep away from what cannot be
# By which a load stays below one that is not to be exceeded, so that no rounding brings it over that.
_BESIDE: Final = 1e-12
#: Throw number up to which settings that hop are sought: beyond, flights last for many cycles, and landings
#: shake parts and drive apart.
MOST_THROW: Final = 10.0


class Setting(NamedTuple):
    """Nominal settings of a drive; arrays of one shape, or numbers [m, Hz, rad]."""

    amplitude: Any
    frequency: Any
    drive_angle: Any


class Range(NamedTuple):
    """A choice of frequencies and drive angles without a gap [Hz, rad]."""

    frequency: Span
    drive_angle: Span


@dataclass(frozen=True)
class Asked:
    """What is asked whatever the drive, within a regime.

    Attributes
    ----------
    spec : Spec
        The whole question.
    drive : Drive or EllipticalDrive
        The drive.
    highest : Regime
        Highest regime that may occur.
    """

    spec: Spec
    drive: Any
    highest: Regime

    @property
    def flies(self) -> bool:
        """Whether bodies may hop."""
        return self.highest is Regime.HOPPING

    @property
    def landings(self) -> Landings:
        """What landings may be at most."""
        goal = self.spec.goal
        return Landings(goal.impact_speed, goal.flight_fraction) if self.flies else ANY_LANDING

    def parts(self, scale: Floats | float) -> dict[str, Any]:
        """Return the fields of ``Parts``, with all bands and drifts scaled about their middles."""
        bands, drift = self.spec.bands, self.spec.drift
        is_ratio = "friction_ratio" in bands
        low, high = bands["trough_angle"]
        trough = _scaled((low - drift.trough_angle, high + drift.trough_angle), scale)
        second = _scaled(bands["friction_ratio" if is_ratio else "kinetic_friction"], scale)
        static = _scaled(bands["static_friction"], scale)
        return {
            "trough_angle": _cut(trough, _SHORT - _RIGHT_ANGLE, _RIGHT_ANGLE - _SHORT),
            "static_friction": _cut(static, 0.0, math.inf),
            "second_friction": _cut(second, 0.0, 1.0 if is_ratio else math.inf),
            "is_ratio": is_ratio,
            "gravity": self.spec.gravity,
            "restitution": self.spec.restitution,
        }


@dataclass(frozen=True)
class Question(Asked):
    """What is asked of one drive along a line."""

    drive: Drive

    @property
    def ranges(self) -> list[Range]:
        """All choices of frequency and drive angle."""
        return [Range(f, a) for f in self.drive.frequency for a in self.drive.drive_angle]

    def boxes(self, setting: Setting, scale: Floats | float = 1.0) -> Box:
        """Return the box of a setting, or of several where these are arrays of shape (m, 1).

        Parameters
        ----------
        setting : Setting
            Nominal values.
        scale : float or array
            Factor on all bands and drifts about their middles, cut at what can be.
        """
        drift = self.spec.drift
        parts = self.parts(scale)
        steepest = _RIGHT_ANGLE - _SHORT - parts["trough_angle"][1]
        alpha = setting.drive_angle
        return Box(
            amplitude=off(setting.amplitude, drift.amplitude * scale),
            frequency=off(setting.frequency, drift.frequency * scale),
            drive_angle=_cut(
                (alpha - drift.drive_angle * scale, alpha + drift.drive_angle * scale),
                0.0,
                np.maximum(alpha, steepest),
            ),
            **parts,
        )

    def caps(self, drive_angle: Floats, scale: Floats | float = 1.0) -> dict[str, Floats]:
        """Nominal loads up to which a drive angle may be driven, by what ends there, of its shape.

        The largest acceleration is for nominal values, and no matter of the scale. Settings that hop are not
        sought beyond a throw number of 10.
        """
        box = self.boxes(Setting(1.0, 1.0, drive_angle), scale)
        drift = self.spec.drift
        loads = self.tip_loads(box) | regime_loads(box, self.highest)
        most = (1.0 + drift.amplitude * scale) * (1.0 + drift.frequency * scale) ** 2
        shape = np.broadcast_shapes(np.shape(drive_angle), np.shape(scale))
        # a load that is NaN is of bodies without static friction, of which nothing is known
        loads = {name: np.nan_to_num(load, nan=0.0, posinf=math.inf) for name, load in loads.items()}
        caps = {name: np.broadcast_to(load / most * (1.0 - _BESIDE), shape) for name, load in loads.items()}
        limit = np.full(shape, self.drive.acceleration)
        if self.flies:
            limit = np.minimum(limit, MOST_THROW * hop_load(box) / most)
        return {**caps, "limit": limit}

    def tip_loads(self, box: Box) -> dict[str, Floats]:
        """Load up to which every part stays upright, where it must: nothing is known of landings."""
        ratio = self.spec.stand_ratio
        if math.isinf(ratio):
            return {}
        load = tip_load(box, ratio)
        return {"tip": np.minimum(load, hop_load(box)) if self.flies else load}

    def reach(self, frequency: Span) -> Span:
        """Smallest and largest load that the amplitudes allow within a range of frequencies."""
        low, high = (
            a * (2.0 * math.pi * f) ** 2 / self.spec.gravity
            for a, f in zip(self.drive.amplitude, frequency, strict=True)
        )
        return low, high

    def setting(self, load: Floats, frequency: Span, drive_angle: Floats) -> Setting:
        """Return the fastest setting of a nominal load: that of the lowest frequency which the stroke allows.

        At one load the speed of every body goes with 1/f.
        """
        weight = np.maximum(load, _SHORT) * self.spec.gravity / (4.0 * math.pi**2)  # A f^2
        least, most = self.drive.amplitude
        f = np.clip(np.sqrt(weight / most), *frequency)
        return Setting(np.clip(weight / (f * f), least, most), f, drive_angle)

    def load(self, setting: Setting) -> Floats:
        """Nominal load of a setting [1]."""
        return np.asarray(setting.amplitude * (2.0 * np.pi * setting.frequency) ** 2 / self.spec.gravity)

    def speeds(self, setting: Setting, bodies: Bodies, scale: Floats | float = 1.0) -> Floats:
        """Speeds of bodies at settings, 1-D, of shape (settings, bodies); NaN where one is left out."""
        columns = Setting(*(np.reshape(x, (-1, 1)) for x in setting))
        boxes = self.boxes(columns, np.reshape(scale, (-1, 1)))
        scene = boxes.scene(boxes.points(bodies.at(boxes)), fast=False)
        cycle = solve(scene, flight=self.flies)
        speed = counted(cycle, fast=False)
        return np.where(self.landings.exceeded(cycle), -np.inf, speed)


def _scaled(band: Span, scale: Floats | float) -> Ends:
    """Scale a band about its middle; a scale of 1 changes nothing."""
    low, high = band
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    plain = np.equal(scale, 1.0)
    return np.where(plain, low, middle - half * scale), np.where(plain, high, middle + half * scale)


def _cut(ends: Ends, low: float, high: Floats | float) -> Ends:
    """Cut a band at what can be."""
    return np.clip(ends[0], low, high), np.clip(ends[1], low, high)


def off(value: Floats | float, share: Floats | float) -> Ends:
    """Return what a drift of a share of a nominal value brings, positive."""
    return value * np.maximum(1.0 - share, _SHORT), value * (1.0 + share)
