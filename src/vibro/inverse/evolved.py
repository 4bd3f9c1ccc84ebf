"""Find settings by evolution over all knobs: of least acceleration, top speed or largest margin."""

from __future__ import annotations

import math
from abc import abstractmethod
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.core.codes import Regime
from vibro.inverse.exchange import SEED, Effort, Exchange, Optimum
from vibro.inverse.extremes import least_of
from vibro.inverse.proofs import corners, slip_ratio
from vibro.inverse.search import placed, sobol
from vibro.inverse.specs import Goal
from vibro.inverse.tolerances import TOLERANCES

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from vibro.inverse.exchange import Found
    from vibro.inverse.questions import Question
    from vibro.inverse.spaces import AnySetting
    from vibro.inverse.specs import Span

    Floats = NDArray[np.float64]
    Bools = NDArray[np.bool_]

__all__ = ["Evolution", "below"]

_IN_CONTACT: Final = Effort(population=5, generations=100, margins=33, margin=1e-4, scale=3e-2, exchanges=6)
_FLYING: Final = Effort(population=7, generations=3, margins=17, margin=1e-2, scale=0.1, exchanges=1)
# bounces are slow to solve
_BOUNCING: Final = Effort(population=5, generations=1, margins=5, margin=0.1, scale=0.3, exchanges=1)
# [1] Costs of settings that are too slow, at rest, forbidden: in rising order, far above any load or speed.
_SLOW: Final = 1e6
_RESTS: Final = 2e6
_FORBIDDEN: Final = 3e6


class Evolution(Exchange):
    """Optimal settings of a drive whose best load is not known by the corners of its box.

    Every free knob is a coordinate of one search.

    Parameters
    ----------
    question : Question
        Drive, goal and bands.
    """

    _in_contact = _IN_CONTACT

    surpluses = (0.0, 1e-4, 1e-2)  # one search each
    _least_set_by = "limit"

    def __init__(self, question: Question) -> None:
        effort = self._in_contact
        if question.flies:
            effort = _BOUNCING if question.spec.restitution else _FLYING
        super().__init__(question, effort, corners(question.box(self._one()).varies))
        self._checked = question.highest

    @abstractmethod
    def _one(self) -> AnySetting:
        """Return the setting of a factor of 1 at 1 Hz."""

    @abstractmethod
    def _spans(self, frequency: Span) -> tuple[Span, ...]:
        """Return the ranges of all coordinates of the search."""

    @abstractmethod
    def _settings(
        self, coordinates: Floats, frequency: Span, scale: float
    ) -> tuple[AnySetting, Floats, Bools]:
        """Return settings at unit-cube coordinates, the sum of their sizes' shares, and which can be."""

    def finds_slower(self, optimum: Optimum, scale: float = 1.0) -> bool:
        """Search for slower bodies and, if none may slip back, for the one that slips back first."""
        slower = super().finds_slower(optimum, scale)
        if self._checked is not Regime.FORWARD_SLIP:
            return slower
        box = self._question.box(optimum.setting, scale)
        ratio, coordinates = slip_ratio(box)
        known = self.scenarios.size
        if ratio > 1.0:
            self.scenarios = self.scenarios.joined(box, coordinates)
        return slower or self.scenarios.size > known

    def _fastest(self, scale: float, generations: int) -> Optimum | None:
        """Return the fastest setting for the current scenarios."""

        def cost(setting: AnySetting, shares: Floats) -> Floats:
            speeds = self.least(setting, scale)
            return np.where(
                speeds == 0.0, _RESTS - shares, np.where(np.isinf(speeds), _FORBIDDEN + shares, -speeds)
            )

        setting, least = self._best(cost, scale, generations)
        return Optimum(setting, -least) if least < 0.0 else None

    def _least_acceleration(self, target: float) -> Optimum | None:
        """Return the setting of least load that reaches a speed, for the current scenarios."""

        def cost(setting: AnySetting, shares: Floats) -> Floats:
            speeds = self.least(setting, 1.0)
            slow = np.where(np.isinf(speeds), _FORBIDDEN + shares, _SLOW * (2.0 - speeds / target))
            return np.where(speeds >= target, self._question.load(setting), slow)

        setting, least = self._best(cost, 1.0, self._effort.generations)
        if least >= _SLOW:
            return None
        columns = setting._make(np.array([x]) for x in setting)
        return Optimum(setting, float(self.least(columns, 1.0)[0]))

    def _best(
        self, cost: Callable[[AnySetting, Floats], Floats], scale: float, generations: int
    ) -> tuple[AnySetting, float]:
        """Return the best setting over all frequency ranges, and its cost."""
        ranges = self._question.drive.frequency
        return min((self._best_of(cost, f, scale, generations) for f in ranges), key=lambda best: best[1])

    def _best_of(
        self,
        cost: Callable[[AnySetting, Floats], Floats],
        frequency: Span,
        scale: float,
        generations: int,
    ) -> tuple[AnySetting, float]:
        """Return the setting of least cost within one frequency range, and its cost."""
        free = np.array([low < high for low, high in self._spans(frequency)])
        count = int(free.sum())

        def settings(x: Floats) -> tuple[AnySetting, Floats, Bools]:
            return self._settings(placed(free, x), frequency, scale)

        def whole(x: Floats) -> Floats:
            setting, shares, possible = settings(x)
            costs = np.full(x.shape[1], 2.0 * _FORBIDDEN) + shares
            if possible.any():
                some = setting._make(values[possible] for values in setting)
                costs[possible] = cost(some, shares[possible])
            return costs

        x = np.zeros((0, 1))
        if count:
            x = self._minimised(whole, sobol(count, self._effort.population + count - 1, SEED), generations)
        setting = settings(x)[0]
        return setting._make(float(values[0]) for values in setting), float(whole(x)[0])

    def keeps_to_regime(self, found: Found) -> bool:
        """Return whether every body found by the searches keeps to the regime."""
        if any(regime > self._question.highest for regime in found.guarantee.regimes):
            return False
        if self._question.highest is not Regime.FORWARD_SLIP:
            return True
        return slip_ratio(self._question.box(found.setting))[0] <= 1.0

    def limit(self, found: Found, scale: float) -> str:
        """Return the name of a setting's active constraint, with bands scaled by a factor."""
        question, setting, drive = self._question, found.setting, self._question.drive
        if question.landings.scaled(TOLERANCES.nearly).worst(question.box(setting, scale)).size:
            return "limit"
        nearly = 1.0 - TOLERANCES.at
        if not question.flies and question.box(setting, scale).throw_number >= nearly:
            return "hop"
        beyond = setting.scaled(1.0 + TOLERANCES.at)
        both: Any = setting._make(np.array(pair) for pair in zip(setting, beyond, strict=True))
        here, there = self.least(both, scale)
        if math.isinf(there):
            return self._forbids(beyond, scale)
        if there < here * (1.0 - TOLERANCES.fall):
            return "back slip"
        sizes = question.space.turned(setting)
        at_most = [sizes[knob] >= drive.span(knob)[1] * nearly for knob in question.space.sizes]
        at_most.append(float(question.load(setting)) >= drive.acceleration * nearly)
        return "limit" if any(at_most) else "speed"

    def first_cap(self) -> str:
        """Return the constraint that bounds the load before any speed is guaranteed."""
        question = self._question
        if not self._keeps_contact():
            return "hop"
        others = {}
        if math.isfinite(question.spec.stand_ratio):
            others["tip"] = replace(question, spec=replace(question.spec, stand_ratio=math.inf))
        if question.highest is Regime.FORWARD_SLIP:
            others["back slip"] = replace(question, highest=Regime.BACK_SLIP)
        return next((name for name, other in others.items() if type(self)(other).fastest()), "limit")

    @abstractmethod
    def _keeps_contact(self) -> bool:
        """Return whether the least sizes at the lowest frequency keep below the loads that are searched."""

    def _forbids(self, setting: AnySetting, scale: float) -> str:
        """Return the constraint that forbids a setting: the one without which it would be allowed."""
        spec = self._question.spec
        anywhere = replace(spec, stand_ratio=math.inf)
        for name, question in {
            "tip": replace(self._question, spec=anywhere),
            "limit": replace(self._question, spec=replace(anywhere, goal=Goal(spec.goal.speed))),
            "back slip": replace(self._question, spec=anywhere, highest=Regime.BACK_SLIP),
        }.items():
            one = setting._make(np.array([x]) for x in setting)
            if np.isfinite(least_of(question.speeds(one, self.scenarios, scale))[0]):
                return name
        return "hop"


def below(most: Floats, span: Span, share: Floats) -> tuple[Floats, Bools]:
    """Return the value at a share of a range below a limit, and whether the limit leaves any of the range."""
    low, high = span
    top = np.clip(most, low, high)
    return np.where(share == 1.0, top, low + share * (top - low)), most >= low * (1.0 - math.ulp(1.0))
