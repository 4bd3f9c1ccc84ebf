"""Find settings of a drive that is a given motion, by evolution over its scale and its frequency."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from vibro.inverse.evolved import Evolution, below
from vibro.inverse.exchange import MOST_MARGIN, Effort
from vibro.inverse.questions import MOST_DESIGN_THROW
from vibro.inverse.spaces import Scaled, inside
from vibro.inverse.tolerances import TOLERANCES

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.inverse.specs import Span

    Floats = NDArray[np.float64]
    Bools = NDArray[np.bool_]

__all__ = ["MotionOptimiser"]


class MotionOptimiser(Evolution):
    """Optimal settings of a drive that is a given motion."""

    # a scene takes fifty times as long as an ellipse, and there are two coordinates at most
    _in_contact = Effort(population=4, generations=40, margins=9, margin=1e-4, scale=3e-2, exchanges=4)

    def _one(self) -> Scaled:
        """Return the whole motion at 1 Hz."""
        return Scaled(1.0, 1.0)

    def _spans(self, frequency: Span) -> tuple[Span, Span]:
        """Return the ranges of the scale and the frequency."""
        return self._question.drive.span("motion_scale"), frequency

    def _settings(self, coordinates: Floats, frequency: Span, scale: float) -> tuple[Scaled, Floats, Bools]:
        """Return settings at unit-cube coordinates, the shares of their scales, and which can be."""
        share, f = coordinates[0], inside(frequency, coordinates[1])
        size, possible = below(self._most(f, scale), self._spans(frequency)[0], share)
        return Scaled(size, f), share, possible

    def _most(self, frequency: Floats, scale: float) -> Floats:
        """Return the largest nominal scale: that of hopping, of ``MOST_DESIGN_THROW``, or of the drive."""
        question = self._question
        one = Scaled(1.0, frequency)
        hop = question.box(one, scale).hop_load / question.load(one)
        most = (MOST_DESIGN_THROW if question.flies else 1.0) * hop / question.growth(scale)
        limit = question.drive.acceleration / question.load(one)
        return np.asarray(np.minimum(most, limit) * (1.0 - TOLERANCES.beside))

    def has_more(self) -> bool:
        """Whether this regime allows a setting, or a wider band, that lower regimes forbid."""
        question, drive = self._question, self._question.drive
        largest = Scaled(drive.span("motion_scale")[1], max(high for _, high in drive.frequency))
        widest = question.box(largest, MOST_MARGIN)
        return not question.flies or widest.throw_number > 1.0 - TOLERANCES.beside

    def _keeps_contact(self) -> bool:
        """Return whether the least scale at the lowest frequency keeps below the loads that are searched."""
        drive = self._question.drive
        lowest = min(low for low, _ in drive.frequency)
        return drive.span("motion_scale")[0] <= float(self._most(np.array(lowest), 1.0))
