"""A question about one elliptical drive: the boxes of its settings, and how far they may be driven."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from vibro.inverse.ellipses import EllipticalBox
from vibro.inverse.extremes import counted
from vibro.inverse.questions import MOST_THROW, Asked, Question, off
from vibro.inverse.specs import Drive
from vibro.limits import stays_upright
from vibro.scene import Scene
from vibro.steady import solve

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.core.codes import Regime
    from vibro.inverse.ellipses import EllipticalBodies
    from vibro.inverse.specs import AnyDrive, EllipticalDrive, Span, Spec

    Floats = NDArray[np.float64]

__all__ = ["AnyQuestion", "EllipticalQuestion", "EllipticalSetting", "question_of"]

#: By which a motion stays below one that is not to be exceeded, so that no rounding brings it over that.
_BESIDE: Final = 1e-12


class EllipticalSetting(NamedTuple):
    """Nominal settings of an elliptical drive; arrays of one shape, or numbers [m, m, rad, Hz]."""

    along_amplitude: Any
    normal_amplitude: Any
    normal_phase: Any
    frequency: Any

    @property
    def leading(self) -> str:
        """The amplitude that windows and pictures are of, the other one in proportion."""
        return "along_amplitude" if self.along_amplitude > 0.0 else "normal_amplitude"


@dataclass(frozen=True)
class EllipticalQuestion(Asked):
    """What is asked of one elliptical drive."""

    drive: EllipticalDrive

    def boxes(self, setting: EllipticalSetting, scale: Floats | float = 1.0) -> EllipticalBox:
        """Return the box of a setting, or of several where these are arrays of shape (m, 1).

        Parameters
        ----------
        setting : EllipticalSetting
            Nominal values.
        scale : float or array
            Factor on all bands and drifts about their middles, cut at what can be.
        """
        drift = self.spec.drift
        x, y, phase, frequency = setting
        return EllipticalBox(
            factor=off(1.0, drift.amplitude * scale),
            along_amplitude=(x, x),
            normal_amplitude=(y, y),
            normal_phase=(phase - drift.normal_phase * scale, phase + drift.normal_phase * scale),
            frequency=off(frequency, drift.frequency * scale),
            **self.parts(scale),
        )

    def load(self, setting: EllipticalSetting) -> Floats:
        """Nominal load of a setting: the largest acceleration along its path over g [1]."""
        known = {"static_friction": 1.0, "kinetic_friction": 1.0, "gravity": self.spec.gravity}
        return Scene.allowing_infeasible(**setting._asdict(), **known).load

    def most_throw(self, frequency: Floats, scale: float) -> Floats:
        """Largest nominal amplitude normal to the trough: up to the hop, or the last throw number sought."""
        drift, (low, high) = self.spec.drift, self.parts(scale)["trough_angle"]
        factor = (1.0 + drift.amplitude * scale) * (1.0 + drift.frequency * scale) ** 2
        weight = self.spec.gravity * np.minimum(np.cos(low), np.cos(high)) / (2.0 * np.pi * frequency) ** 2
        most = MOST_THROW if self.flies else 1.0
        return np.asarray(most * weight / factor * (1.0 - _BESIDE))

    def most_along(self, frequency: Floats, normal_amplitude: Floats, phase: Floats) -> Floats:
        """Largest amplitude along the trough that the drive's acceleration allows; 0 where it allows none.

        With reach R an ellipse fits in where (R^2 - X^2) (R^2 - Y^2) is at least (X Y cos phi)^2.
        """
        with np.errstate(over="ignore"):
            reach = self.drive.acceleration * self.spec.gravity / (2.0 * np.pi * frequency) ** 2
        if math.isinf(self.drive.acceleration):
            return np.full(np.shape(reach), np.inf)
        share = np.minimum(normal_amplitude / reach, 1.0)
        sine = share * np.sin(phase)
        with np.errstate(divide="ignore", invalid="ignore"):
            rest = (1.0 - share) * (1.0 + share) / ((1.0 - sine) * (1.0 + sine))
        # upright where the normal amplitude takes it all
        most = reach * np.sqrt(np.nan_to_num(rest, nan=0.0)) * (1.0 - _BESIDE)
        return np.where(normal_amplitude <= reach, most, 0.0)

    def speeds(
        self, setting: EllipticalSetting, bodies: EllipticalBodies, scale: Floats | float = 1.0
    ) -> Floats:
        """Speeds of bodies at settings, 1-D, of shape (settings, bodies).

        -inf where a body does what is not allowed; NaN where it is left out.
        """
        columns = EllipticalSetting(*(np.reshape(x, (-1, 1)) for x in setting))
        boxes = self.boxes(columns, np.reshape(scale, (-1, 1)))
        scene = boxes.scene(boxes.points(bodies.at(boxes)), fast=False)
        cycle = solve(scene, flight=self.flies)
        bad = (np.asarray(cycle.regime) > self.highest) | self.landings.exceeded(cycle)
        if math.isfinite(self.spec.stand_ratio):
            bad |= stays_upright(scene, self.spec.stand_ratio) != 1
        return np.where(bad, -np.inf, counted(cycle, fast=False))

    @property
    def free(self) -> list[bool]:
        """Which of the fields of a setting may be chosen, but for the frequency."""
        drive = self.drive
        return [
            low < high for low, high in (drive.along_amplitude, drive.normal_amplitude, drive.normal_phase)
        ]

    @property
    def ranges(self) -> tuple[Span, ...]:
        """All choices of frequency."""
        return self.drive.frequency


AnyQuestion = Question | EllipticalQuestion


def question_of(spec: Spec, drive: AnyDrive, highest: Regime) -> AnyQuestion:
    """Return what is asked of a drive within a regime."""
    if isinstance(drive, Drive):
        return Question(spec, drive, highest)
    return EllipticalQuestion(spec, drive, highest)
