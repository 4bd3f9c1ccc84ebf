"""Find settings of an elliptical drive, by evolution."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from vibro.inverse.evolved import Evolution, below
from vibro.inverse.exchange import MOST_MARGIN
from vibro.inverse.questions import MOST_DESIGN_THROW
from vibro.inverse.spaces import Setting, inside
from vibro.inverse.tolerances import TOLERANCES

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.inverse.specs import Span

    Floats = NDArray[np.float64]
    Bools = NDArray[np.bool_]

__all__ = ["EllipseOptimiser"]


class EllipseOptimiser(Evolution):
    """Optimal settings of an elliptical drive.

    Every free amplitude, phase and frequency is a coordinate of one search. The lowest frequency is not
    always the best here, since one amplitude may be fixed.
    """

    def _one(self) -> Setting:
        """Return the setting of both amplitudes 1 m, in phase, at 1 Hz."""
        return Setting(1.0, 1.0, 0.0, 1.0)

    def _spans(self, frequency: Span) -> tuple[Span, Span, Span, Span]:
        """Return the ranges of both amplitudes, the phase and the frequency."""
        x, y, phase = (self._question.drive.span(knob) for knob in Setting._fields[:3])
        return x, y, phase, frequency

    def _settings(self, coordinates: Floats, frequency: Span, scale: float) -> tuple[Setting, Floats, Bools]:
        """Return settings at unit-cube coordinates, the sum of their sizes' shares, and which can be."""
        along, normal, phases, _ = self._spans(frequency)
        f, phase = inside(frequency, coordinates[3]), inside(phases, coordinates[2])
        y, possible = below(self._most_normal(f, scale), normal, coordinates[1])
        x, fits = below(self._most_along(f, y, phase), along, coordinates[0])
        return Setting(x, y, phase, f), coordinates[0] + coordinates[1], possible & fits

    def _most_normal(self, frequency: Floats, scale: float) -> Floats:
        """Return the largest nominal normal amplitude, that of hopping or of ``MOST_DESIGN_THROW`` [m]."""
        question = self._question
        unit = question.box(Setting(1.0, 1.0, 0.0, 1.0), scale)
        weight = question.spec.gravity * unit.hop_load / (2.0 * np.pi * frequency) ** 2
        most = MOST_DESIGN_THROW if question.flies else 1.0
        return np.asarray(most * weight / question.growth(scale) * (1.0 - TOLERANCES.beside))

    def _most_along(self, frequency: Floats, normal_amplitude: Floats, phase: Floats) -> Floats:
        """Return the largest amplitude along the trough that the drive's acceleration allows, or 0 [m].

        An ellipse stays within a radius R where (R^2 - X^2) (R^2 - Y^2) is at least (X Y cos phi)^2.
        """
        acceleration = self._question.drive.acceleration * self._question.spec.gravity
        if math.isinf(acceleration):
            return np.full(np.shape(frequency), np.inf)
        reach = acceleration / (2.0 * np.pi * frequency) ** 2
        share = np.minimum(normal_amplitude / reach, 1.0)
        sine = share * np.sin(phase)
        with np.errstate(divide="ignore", invalid="ignore"):
            rest = (1.0 - share) * (1.0 + share) / ((1.0 - sine) * (1.0 + sine))
        # where the normal amplitude alone reaches the largest acceleration, none is left along the trough
        most = reach * np.sqrt(np.nan_to_num(rest, nan=0.0)) * (1.0 - TOLERANCES.beside)
        return np.where(normal_amplitude <= reach, most, 0.0)

    def has_more(self) -> bool:
        """Whether this regime allows a setting, or a wider band, that lower regimes forbid."""
        question, drive = self._question, self._question.drive
        fastest = max(high for _, high in drive.frequency)
        widest = question.box(Setting(1.0, drive.span("normal_amplitude")[1], 0.0, fastest), MOST_MARGIN)
        return not question.flies or widest.throw_number > 1.0 - TOLERANCES.beside

    def _keeps_contact(self) -> bool:
        """Return whether the least sizes at the lowest frequency keep below the loads that are searched."""
        drive = self._question.drive
        lowest = min(low for low, _ in drive.frequency)
        return drive.span("normal_amplitude")[0] <= float(self._most_normal(np.array(lowest), 1.0))
