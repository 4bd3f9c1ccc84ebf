"""Find settings of an elliptical drive, by evolution: of least acceleration, top speed or largest margin."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from vibro.core.codes import Regime
from vibro.inverse.exchange import MOST_MARGIN, SEED, Effort, Exchange, Optimum
from vibro.inverse.extremes import least_of
from vibro.inverse.proofs import corners, extreme_ratio, first_ratio
from vibro.inverse.questions import MOST_THROW
from vibro.inverse.search import placed, sobol
from vibro.inverse.spaces import Setting, inside
from vibro.inverse.specs import Goal
from vibro.inverse.tolerances import TOLERANCES
from vibro.limits import critical_loads

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from vibro.inverse.exchange import Found
    from vibro.inverse.questions import Question
    from vibro.inverse.specs import Span

    Floats = NDArray[np.float64]

__all__ = ["EllipseOptimiser"]

_IN_CONTACT: Final = Effort(population=5, generations=100, margins=33, margin=1e-4, scale=3e-2, exchanges=6)
_FLYING: Final = Effort(population=7, generations=3, margins=17, margin=1e-2, scale=0.1, exchanges=1)
# bounces are slow to solve
_BOUNCING: Final = Effort(population=5, generations=1, margins=5, margin=0.1, scale=0.3, exchanges=1)
# [1] Costs of settings that are too slow, at rest, forbidden: in rising order, far above any load or speed.
_SLOW: Final = 1e6
_RESTS: Final = 2e6
_FORBIDDEN: Final = 3e6


class EllipseOptimiser(Exchange):
    """Optimal settings of an elliptical drive.

    Every free amplitude, phase and frequency is a coordinate of one search. The lowest frequency is not
    always the best here, since one amplitude may be fixed.

    Parameters
    ----------
    question : Question
        Drive, goal and bands.
    """

    surpluses = (0.0, 1e-4, 1e-2)  # one search each
    _least_set_by = "limit"

    def __init__(self, question: Question) -> None:
        one = question.box(Setting(1.0, 1.0, 0.0, 1.0))
        effort = _IN_CONTACT
        if question.flies:
            effort = _BOUNCING if question.spec.restitution else _FLYING
        super().__init__(question, effort, corners(one.varies))
        self._checked = question.highest

    def finds_slower(self, optimum: Optimum, scale: float = 1.0) -> bool:
        """Search for slower bodies and, if none may slip back, for the one that slips back first."""
        slower = super().finds_slower(optimum, scale)
        if self._checked is not Regime.FORWARD_SLIP:
            return slower
        box = self._question.box(optimum.setting, scale)
        ratio, coordinates = extreme_ratio(box, lambda scene: critical_loads(scene).back_slip, largest=True)
        known = self.scenarios.size
        if ratio > 1.0:
            self.scenarios = self.scenarios.joined(box, coordinates)
        return slower or self.scenarios.size > known

    def _fastest(self, scale: float, generations: int) -> Optimum | None:
        """Return the fastest setting for the current scenarios."""

        def cost(setting: Setting, shares: Floats) -> Floats:
            speeds = self.least(setting, scale)
            return np.where(
                speeds == 0.0, _RESTS - shares, np.where(np.isinf(speeds), _FORBIDDEN + shares, -speeds)
            )

        setting, least = self._best(cost, scale, generations)
        return Optimum(setting, -least) if least < 0.0 else None

    def _least_acceleration(self, target: float) -> Optimum | None:
        """Return the setting of least load that reaches a speed, for the current scenarios."""

        def cost(setting: Setting, shares: Floats) -> Floats:
            speeds = self.least(setting, 1.0)
            slow = np.where(np.isinf(speeds), _FORBIDDEN + shares, _SLOW * (2.0 - speeds / target))
            return np.where(speeds >= target, self._question.load(setting), slow)

        setting, least = self._best(cost, 1.0, self._effort.generations)
        if least >= _SLOW:
            return None
        columns = Setting(*(np.array([x]) for x in setting))
        return Optimum(setting, float(self.least(columns, 1.0)[0]))

    def _best(
        self, cost: Callable[[Setting, Floats], Floats], scale: float, generations: int
    ) -> tuple[Setting, float]:
        """Return the best setting over all frequency ranges, and its cost."""
        ranges = self._question.drive.frequency
        return min((self._best_of(cost, f, scale, generations) for f in ranges), key=lambda best: best[1])

    def _best_of(
        self,
        cost: Callable[[Setting, Floats], Floats],
        frequency: Span,
        scale: float,
        generations: int,
    ) -> tuple[Setting, float]:
        """Return the setting of least cost within one frequency range, and its cost."""
        along, normal, phases, _ = spans = self._spans(frequency)
        free = np.array([low < high for low, high in spans])
        count = int(free.sum())

        def settings(x: Floats) -> tuple[Setting, Floats, NDArray[np.bool_]]:
            coordinates = placed(free, x)
            f, phase = inside(frequency, coordinates[3]), inside(phases, coordinates[2])
            most = self._most_normal(f, scale)
            y, possible = _below(most, normal, coordinates[1])
            most = self._most_along(f, y, phase)
            x_, fits = _below(most, along, coordinates[0])
            return Setting(x_, y, phase, f), coordinates[0] + coordinates[1], possible & fits

        def whole(x: Floats) -> Floats:
            setting, shares, possible = settings(x)
            costs = np.full(x.shape[1], 2.0 * _FORBIDDEN) + shares
            if possible.any():
                some = Setting(*(values[possible] for values in setting))
                costs[possible] = cost(some, shares[possible])
            return costs

        x = np.zeros((0, 1))
        if count:
            x = self._minimised(whole, sobol(count, self._effort.population + count - 1, SEED), generations)
        setting = settings(x)[0]
        return Setting(*(float(values[0]) for values in setting)), float(whole(x)[0])

    def _spans(self, frequency: Span) -> tuple[Span, Span, Span, Span]:
        """Return the ranges of both amplitudes, the phase and the frequency."""
        x, y, phase = (self._question.drive.span(knob) for knob in Setting._fields[:3])
        return x, y, phase, frequency

    def _most_normal(self, frequency: Floats, scale: float) -> Floats:
        """Return the largest nominal normal amplitude [m]: where bodies hop, or reach ``MOST_THROW``."""
        question = self._question
        unit = question.box(Setting(1.0, 1.0, 0.0, 1.0), scale)
        weight = question.spec.gravity * unit.hop_load / (2.0 * np.pi * frequency) ** 2
        most = MOST_THROW if question.flies else 1.0
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

    def keeps_to_regime(self, found: Found) -> bool:
        """Return whether every body found by the searches keeps to the regime."""
        if any(regime > self._question.highest for regime in found.guarantee.regimes):
            return False
        if self._question.highest is not Regime.FORWARD_SLIP:
            return True
        return first_ratio(self._question.box(found.setting), Regime.BACK_SLIP) <= 1.0

    def limit(self, found: Found, scale: float) -> str:
        """Return the name of a setting's active constraint, with bands scaled by a factor."""
        question, setting, drive = self._question, found.setting, self._question.drive
        if question.landings.scaled(TOLERANCES.nearly).worst(question.box(setting, scale)).size:
            return "limit"
        nearly = 1.0 - TOLERANCES.at
        if not question.flies and question.box(setting, scale).throw_number >= nearly:
            return "hop"
        beyond = setting.scaled(1.0 + TOLERANCES.at)
        both = Setting(*(np.array(pair) for pair in zip(setting, beyond, strict=True)))
        here, there = self.least(both, scale)
        if math.isinf(there):
            return self._forbids(beyond, scale)
        if there < here * (1.0 - TOLERANCES.fall):
            return "back slip"
        at_most = (
            setting.along_amplitude >= drive.span("along_amplitude")[1] * nearly,
            setting.normal_amplitude >= drive.span("normal_amplitude")[1] * nearly,
            float(question.load(setting)) >= drive.acceleration * nearly,
        )
        return "limit" if any(at_most) else "speed"

    def first_cap(self) -> str:
        """Return the constraint that bounds the load before any speed is guaranteed."""
        question = self._question
        lowest = min(low for low, _ in question.drive.frequency)
        if question.drive.span("normal_amplitude")[0] > float(self._most_normal(np.array(lowest), 1.0)):
            return "hop"
        lower, higher = Regime.FORWARD_SLIP, replace(question, highest=Regime.BACK_SLIP)
        slips = question.highest is lower and EllipseOptimiser(higher).fastest()
        return "back slip" if slips else "limit"

    def _forbids(self, setting: Setting, scale: float) -> str:
        """Return the constraint that forbids a setting: the one without which it would be allowed."""
        spec = self._question.spec
        anywhere = replace(spec, stand_ratio=math.inf)
        for name, question in {
            "tip": replace(self._question, spec=anywhere),
            "limit": replace(self._question, spec=replace(anywhere, goal=Goal(spec.goal.speed))),
            "back slip": replace(self._question, spec=anywhere, highest=Regime.BACK_SLIP),
        }.items():
            one = Setting(*(np.array([x]) for x in setting))
            if np.isfinite(least_of(question.speeds(one, self.scenarios, scale))[0]):
                return name
        return "hop"


def _below(most: Floats, span: Span, share: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """Return the value at a share of a range below a limit, and whether the limit leaves any of the range."""
    low, high = span
    top = np.clip(most, low, high)
    return np.where(share == 1.0, top, low + share * (top - low)), most >= low * (1.0 - math.ulp(1.0))
