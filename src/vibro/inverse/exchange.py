"""Find optimal settings of any kind of drive by exchange of scenarios.

A setting is optimised for a few scenarios of its uncertainty set. If a search of the whole set finds a slower
body, that body joins the scenarios, and the setting is optimised again.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.codes import Regime
from vibro.inverse.extremes import Seen, least_of
from vibro.inverse.guarantees import BRIEF, bound
from vibro.inverse.scenarios import Scenarios, at_loads
from vibro.inverse.search import evolve, scatter
from vibro.inverse.tolerances import TOLERANCES
from vibro.roots import close_in

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from vibro.inverse.questions import Question
    from vibro.inverse.spaces import AnySetting
    from vibro.results.designs import Guarantee

    Floats = NDArray[np.float64]

__all__ = ["MOST_MARGIN", "SCATTERED", "SEED", "Effort", "Exchange", "Found", "Optimum"]

#: [1] Largest margin that is searched: factor on the bands.
MOST_MARGIN: Final = 10.0

SEED: Final = 1
SCATTERED: Final = 4  # ratio of the sampled settings in the first round to those in each later round
_STEPS: Final = 60  # iterations at most of the root search


@dataclass(frozen=True, kw_only=True)
class Effort:
    """Sizes and resolutions of the searches.

    Attributes
    ----------
    population, generations : int
        Size of an evolution's population, as a base-2 logarithm, and its generations; for bodies that hop,
        the first samples and the further rounds.
    margins : int
        Margins of one setting that are evaluated at once.
    margin, scale : float
        Tolerances of margins, and of the scale of the bands at which the safest setting is the fastest one.
    exchanges : int
        Largest number of searches for slower bodies.
    """

    population: int
    generations: int
    margins: int
    margin: float
    scale: float
    exchanges: int


class Optimum(NamedTuple):
    """A setting, and the least speed of the scenarios there [m/s]."""

    setting: AnySetting
    speed: float


@dataclass(frozen=True)
class Found:
    """A setting, its printed knobs, its guarantee, and its margin with the optimiser that computed it."""

    setting: AnySetting
    printed: tuple[float, ...]
    guarantee: Guarantee
    margin: float | None = None
    optimiser: Exchange | None = None


class Exchange(ABC):
    """Finds optimal settings for one question.

    Parameters
    ----------
    question : Question
        Drive, goal and bands.
    effort : Effort
        Sizes of the searches.
    coordinates : (axes, n) array
        Unit-cube coordinates of the first scenarios.
    """

    #: Bodies in a higher regime than this count as the slowest; where the load excludes them it is hopping.
    _checked = Regime.HOPPING

    #: Relative surpluses over the goal, tried in turn until a least-acceleration setting survives rounding.
    surpluses: tuple[float, ...]
    #: The active constraint of a least-acceleration design that exceeds its target.
    _least_set_by: str

    def __init__(self, question: Question, effort: Effort, coordinates: Floats) -> None:
        self._question, self._effort = question, effort
        #: The bodies for which settings are optimised.
        self.scenarios = Scenarios.fixed(coordinates)

    @abstractmethod
    def _fastest(self, scale: float, generations: int) -> Optimum | None:
        """Return the fastest setting for the current scenarios."""

    @abstractmethod
    def _least_acceleration(self, target: float) -> Optimum | None:
        """Return the setting of least load that reaches a speed, for the current scenarios."""

    @abstractmethod
    def limit(self, found: Found, scale: float) -> str:
        """Return the name of a setting's active constraint, with bands scaled by a factor."""

    def is_allowed(self, setting: AnySetting) -> bool:
        """Return whether the drive's acceleration allows a setting."""
        load = float(self._question.load(setting))
        return load <= self._question.drive.acceleration * (1.0 + TOLERANCES.converted)

    def least_set_by(self, found: Found) -> str:
        """Return the active constraint of a least-acceleration setting that exceeds its target."""
        question = self._question
        least = question.drive.accelerations[0] / question.spec.gravity * (1.0 + TOLERANCES.at)
        return "limit" if question.load(found.setting) <= least else self._least_set_by

    @abstractmethod
    def first_cap(self) -> str:
        """Return the constraint that bounds the load before any speed is guaranteed."""

    def has_more(self) -> bool:
        """Whether this regime allows a setting, or a wider band, that lower regimes forbid."""
        return True

    def keeps_to_regime(self, found: Found) -> bool:
        """Return whether every body of a setting keeps to the regime."""
        return True

    def _minimised(self, cost: Callable[[Floats], Floats], first: Floats, generations: int) -> Floats:
        """Return the point of least cost, of shape (d, 1); costs of hopping bodies are sampled."""
        if self._question.flies:  # one call for many settings is cheaper than many calls for a few
            more = first.shape[1] // SCATTERED
            return scatter(cost, first, more=more, rounds=self._effort.generations, seed=SEED)[0]
        return evolve(cost, first, generations=generations, seed=SEED)[0]

    def fastest(self, scale: float = 1.0) -> Optimum | None:
        """Return the setting of the largest guaranteed speed; None if no setting guarantees any."""

        def best() -> Optimum | None:
            return self._fastest(scale, self._effort.generations)

        return self._exchanged(best, scale)

    def least_acceleration(self, target: float) -> Optimum | None:
        """Return the setting of least acceleration that guarantees a speed [m/s]; None if there is none."""
        return self._exchanged(lambda: self._least_acceleration(target), 1.0)

    def safest(self, target: float) -> Optimum | None:
        """Return the setting of the largest margin for a speed [m/s]; None if none guarantees the speed."""
        if not self._question.spec.has_bands:
            best = self.fastest()
            return best if best is not None and best.speed >= target else None
        found = None
        for _ in range(self._effort.exchanges):
            found, scale = self._safest(target)
            if found is None or not self.finds_slower(found, scale):
                break
        return found

    def _safest(self, target: float) -> tuple[Optimum | None, float]:
        """Return the setting that reaches the speed at the largest scale of the bands, and that scale."""
        holds: dict[float, Optimum] = {}

        def surplus(scale: float) -> float:
            best = self._fastest(scale, self._effort.generations // 2)
            if best is None:
                return -target
            if best.speed >= target:
                holds[scale] = best
            return best.speed - target

        if surplus(1.0) < 0.0:
            return None, 1.0
        if surplus(MOST_MARGIN) < 0.0:
            from scipy.optimize import brentq  # late: it takes a fifth of a second to load

            brentq(surplus, 1.0, MOST_MARGIN, xtol=self._effort.scale, maxiter=_STEPS, disp=False)
        widest = max(holds)
        return holds[widest], widest

    def margin(self, setting: AnySetting, target: float) -> float | None:
        """Return the largest scale of the bands at which a setting guarantees a speed; None without one.

        Boxes of growing scale contain each other, so a setting that fails at one fails at every larger one.
        """
        margin = self._margin(setting, target)
        for _ in range(self._effort.exchanges):
            if not margin or not self.finds_slower(Optimum(setting, target), margin):
                break
            margin = self._margin(setting, target)
        return margin

    def _margin(self, setting: AnySetting, target: float) -> float | None:
        def surplus(scales: Floats) -> Floats:
            many = setting._make(np.full(scales.size, float(x)) for x in setting)
            holds = self._holds(many, scales.ravel()) & (self.least(many, scales.ravel()) >= target)
            return np.where(holds, 1.0, -1.0).reshape(scales.shape)

        if surplus(np.zeros(1))[0] < 0.0:
            return None
        if surplus(np.array([MOST_MARGIN]))[0] > 0.0:
            return MOST_MARGIN
        effort = self._effort
        inside, _ = close_in(surplus, 0.0, MOST_MARGIN, absolute=effort.margin, sections=effort.margins)
        return float(inside)

    def holds(self, setting: AnySetting, target: float) -> bool:
        """Return whether all scenarios reach a speed at a setting, within the regime."""
        one = setting._make(np.array([float(x)]) for x in setting)
        return bool(self._holds(one, 1.0)[0] and self.least(one, 1.0)[0] >= target)

    def _holds(self, setting: AnySetting, scale: Floats | float) -> NDArray[np.bool_]:
        """Return whether critical loads allow settings; bodies are not solved here."""
        return np.ones(np.broadcast_shapes(np.shape(setting[0]), np.shape(scale)), np.bool_)

    def least(self, setting: AnySetting, scale: Floats | float) -> Floats:
        """Return the least speed of the scenarios at each setting [m/s]."""
        return least_of(self._question.speeds(setting, self.scenarios, scale))

    def _exchanged(self, best: Callable[[], Optimum | None], scale: float) -> Optimum | None:
        """Repeat an optimisation until no body is slower at the optimum than the scenarios."""
        found = best()
        for _ in range(self._effort.exchanges):
            if found is None or not self.finds_slower(found, scale):
                break
            found = best()
        return found

    def finds_slower(self, optimum: Optimum, scale: float = 1.0) -> bool:
        """Search for a body slower than all scenarios at an optimum, add it; return whether there is one."""
        box = self._question.box(optimum.setting, scale)
        slowest = bound(box, fast=False, seen=Seen(), boxes=BRIEF, highest=self._checked).extreme
        new = self._question.landings.worst(box)
        if slowest.speed < optimum.speed - TOLERANCES.searched * abs(optimum.speed):
            new = np.hstack([new, at_loads(box, slowest.coordinates, slowest.coordinates[0, 0])])
        known = self.scenarios.size
        self.scenarios = self.scenarios.joined(box, new)
        return self.scenarios.size > known
