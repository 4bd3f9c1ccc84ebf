"""The gentlest, the fastest and the safest setting of an elliptical drive, by evolutions."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from vibro.core.codes import Regime
from vibro.inverse.ellipses import EllipticalBodies, critical, extreme_ratio
from vibro.inverse.elliptical_questions import EllipticalSetting
from vibro.inverse.evolution import evolve, scatter, sobol
from vibro.inverse.exchange import Effort, Exchange, Optimum
from vibro.inverse.extremes import corners

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from vibro.inverse.elliptical_questions import EllipticalQuestion
    from vibro.inverse.specs import Span

    Floats = NDArray[np.float64]

__all__ = ["EllipticalOptimiser"]

_SEED: Final = 1
_IN_CONTACT: Final = Effort(population=5, generations=100, margins=33, margin=1e-4, scale=3e-2, exchanges=6)
_FLYING: Final = Effort(population=7, generations=3, margins=17, margin=1e-2, scale=0.1, exchanges=1)
_BOUNCING: Final = Effort(
    population=5, generations=1, margins=5, margin=0.1, scale=0.3, exchanges=1
)  # they take long
_SCATTERED: Final = 4  # settings looked at first over those of each round of scattered ones
# Costs of settings that do not do it, each worse than the one before: [1] over loads and speeds.
_SLOW: Final = 1e6
_RESTS: Final = 2e6
_FORBIDDEN: Final = 3e6


class EllipticalOptimiser(Exchange):
    """Optimal settings of an elliptical drive.

    Every free amplitude, phase and frequency is a coordinate of one search: of the frequency the least is not
    always the best here, since one amplitude may be fixed.

    Parameters
    ----------
    question : EllipticalQuestion
        What is asked.
    """

    def __init__(self, question: EllipticalQuestion) -> None:
        one = question.boxes(EllipticalSetting(1.0, 1.0, 0.0, 1.0))
        effort = _IN_CONTACT
        if question.flies:
            effort = _BOUNCING if question.spec.restitution else _FLYING
        super().__init__(question, effort, EllipticalBodies(corners(one)))
        self._checked = question.highest

    def finds_slower(self, optimum: Optimum, scale: float = 1.0) -> bool:
        """Look for the body that slips back first, too, where none may."""
        slower = super().finds_slower(optimum, scale)
        if self._checked is not Regime.FORWARD_SLIP:
            return slower
        box = self._question.boxes(optimum.setting, scale)
        ratio, shares = extreme_ratio(box, critical("back_slip"), largest=True)
        known = self.bodies.shares.shape[1]
        if ratio > 1.0:
            self.bodies = self.bodies.joined(box, shares)
        return bool(slower or self.bodies.shares.shape[1] > known)

    def _fastest(self, scale: float, generations: int) -> Optimum | None:
        """Return the fastest setting for the bodies looked at."""

        def cost(setting: EllipticalSetting, shares: Floats) -> Floats:
            speeds = self.least(setting, scale)
            return np.where(
                speeds == 0.0, _RESTS - shares, np.where(np.isinf(speeds), _FORBIDDEN + shares, -speeds)
            )

        best = min(
            (self._best(cost, f, scale, generations) for f in self._question.ranges), key=lambda b: b[1]
        )
        return Optimum(best[0], -best[1]) if best[1] < 0.0 else None

    def _gentlest(self, target: float) -> Optimum | None:
        """Return the setting of least load that reaches a speed, for the bodies looked at."""

        def cost(setting: EllipticalSetting, shares: Floats) -> Floats:
            speeds = self.least(setting, 1.0)
            slow = np.where(np.isinf(speeds), _FORBIDDEN + shares, _SLOW * (2.0 - speeds / target))
            return np.where(speeds >= target, self._question.load(setting), slow)

        generations = self._effort.generations
        setting, least = min(
            (self._best(cost, f, 1.0, generations) for f in self._question.ranges), key=lambda b: b[1]
        )
        if least >= _SLOW:
            return None
        columns = EllipticalSetting(*(np.array([x]) for x in setting))
        return Optimum(setting, float(self.least(columns, 1.0)[0]))

    def _best(
        self,
        cost: Callable[[EllipticalSetting, Floats], Floats],
        frequency: Span,
        scale: float,
        generations: int,
    ) -> tuple[EllipticalSetting, float]:
        """Minimise the cost of settings and of the shares of their amplitudes, and say what it is."""
        drive = self._question.drive
        spans = (drive.along_amplitude, drive.normal_amplitude, drive.normal_phase, frequency)
        free = [low < high for low, high in spans]

        def placed(x: Floats) -> tuple[EllipticalSetting, Floats, NDArray[np.bool_]]:
            shares = np.zeros((4, x.shape[1]))
            shares[free] = x
            f, phase = _between(frequency, shares[3]), _between(drive.normal_phase, shares[2])
            most = self._question.most_throw(f, scale)
            y, possible = _below(most, drive.normal_amplitude, shares[1])
            most = self._question.most_along(f, y, phase)
            x_, fits = _below(most, drive.along_amplitude, shares[0])
            return EllipticalSetting(x_, y, phase, f), shares[0] + shares[1], possible & fits

        def whole(x: Floats) -> Floats:
            setting, shares, possible = placed(x)
            costs = np.full(x.shape[1], 2.0 * _FORBIDDEN) + shares
            if possible.any():
                some = EllipticalSetting(*(values[possible] for values in setting))
                costs[possible] = cost(some, shares[possible])
            return costs

        if not any(free):
            x = np.zeros((0, 1))
        else:
            first = sobol(sum(free), self._effort.population + sum(free) - 1, _SEED)
            if self._question.flies:
                more = first.shape[1] // _SCATTERED
                x, _ = scatter(whole, first, more=more, rounds=generations, seed=_SEED)
            else:
                x, _ = evolve(whole, first, generations=generations, seed=_SEED)
        setting = placed(x)[0]
        return EllipticalSetting(*(float(values[0]) for values in setting)), float(whole(x)[0])


def _between(span: Span, share: Floats) -> Floats:
    """Value at a share of a range, exact at its ends."""
    return np.where(share == 1.0, span[1], span[0] + share * (span[1] - span[0]))


def _below(most: Floats, span: Span, share: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """Value at a share of what of a range is allowed, and whether anything is."""
    low, high = span
    top = np.clip(most, low, high)
    return np.where(share == 1.0, top, low + share * (top - low)), most >= low * (1.0 - math.ulp(1.0))
