"""Find optimal settings of any kind of drive by exchange of scenarios.

A setting is optimised for a few scenarios of its uncertainty set. If a search of the whole set finds a slower
body, that body joins the scenarios, and the setting is optimised again.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from vibro.core.codes import Regime
from vibro.designs.guarantees import BRIEF, Seen, bound, least_of
from vibro.designs.proofs import (
    corners,
    is_braked,
    onset_load,
    regime_loads,
    slip_ratio,
    steeper_is_slower,
    tip_load,
)
from vibro.designs.questions import MOST_DESIGN_THROW, Goal, Scenarios, at_loads, entry_loads
from vibro.designs.search import close_in, evolve, first_crossing, placed, scatter, sobol
from vibro.designs.spaces import SPACES, TOLERANCES, Scaled, Setting, inside
from vibro.drives import Line

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from vibro.designs.questions import Question
    from vibro.designs.spaces import AnySetting, Span, UncertaintySet
    from vibro.reals import Bools, Floats
    from vibro.results.designs import Guarantee


#: [1] Largest margin that is searched: factor on the bands.
MOST_MARGIN: Final = 10.0

_SEED: Final = 1
_SCATTERED: Final = 4  # ratio of the sampled settings in the first round to those in each later round
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
            more = first.shape[1] // _SCATTERED
            return scatter(cost, first, more=more, rounds=self._effort.generations, seed=_SEED)[0]
        return evolve(cost, first, generations=generations, seed=_SEED)[0]

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


# ------------------------------------------------------------------------------
# Find settings by evolution over all knobs: of least acceleration, top speed or largest margin.

_IN_CONTACT: Final = Effort(population=5, generations=100, margins=33, margin=1e-4, scale=3e-2, exchanges=6)
_FLYING: Final = Effort(population=7, generations=3, margins=17, margin=1e-2, scale=0.1, exchanges=1)
# bounces are slow to solve
_BOUNCING: Final = Effort(population=5, generations=1, margins=5, margin=0.1, scale=0.3, exchanges=1)
# [1] Costs of settings that are too slow, at rest, forbidden: in rising order, far above any load or speed.
_SLOW: Final = 1e6
_RESTS: Final = 2e6
_FORBIDDEN: Final = 3e6


class _Evolution(Exchange):
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
            x = self._minimised(whole, sobol(count, self._effort.population + count - 1, _SEED), generations)
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


# ------------------------------------------------------------------------------
# Find settings of a drive along a line: of least acceleration, top speed or largest margin.
#
# Amplitude and frequency enter through the load G = A w^2 / g and a factor 1/f on all speeds, so that of all
# settings with one load the lowest frequency is the best: what is left to choose is a drive angle and a load.

_LINES: Final = SPACES[Line]
_SLOWEST_LOAD: Final = 1e-2  # share of the largest load at which the search for settings begins


@dataclass(frozen=True, kw_only=True)
class _Effort(Effort):
    """Sizes and resolutions of the searches.

    Attributes
    ----------
    angles, rounds : int
        Drive angles of the first grid, and rounds of refinement.
    loads : int
        Loads between which a speed is searched.
    climbs : int
        Rounds of looking closer at peaks of the speed.
    width : float
        Relative width to which a load is found.
    """

    angles: int
    rounds: int
    loads: int
    climbs: int
    width: float


_LINE_IN_CONTACT: Final = _Effort(
    angles=65, rounds=9, loads=129, population=6, generations=80, climbs=5, width=1e-13, margins=33,
    margin=1e-6, scale=1e-6, exchanges=8,
)  # fmt: skip
_LINE_FLYING: Final = _Effort(
    angles=33, rounds=3, loads=65, population=8, generations=3, climbs=1, width=5e-11, margins=33,
    margin=1e-3, scale=1e-3, exchanges=2,
)  # fmt: skip
# bounces are slow to solve
_LINE_BOUNCING: Final = _Effort(
    angles=9, rounds=1, loads=17, population=7, generations=2, climbs=0, width=6e-5, margins=9,
    margin=3e-2, scale=3e-2, exchanges=1,
)  # fmt: skip

_IN_WINDOW: Final = 9  # loads at which a speed is searched near those of other angles
_END_MARGIN: Final = 1e-6  # [1] of a load, least distance of the window's ends from them
_MISSED: Final = 1e6  # [1] against the load of settings that miss the speed
_AT_REST: Final = 1e6  # [m/s] against the speed of settings at which no part moves
_KEPT: Final = 3  # angles to look around in each round
_CLOSER: Final = 17  # angles around each, closer by a factor of 8


class Range(NamedTuple):
    """A choice of frequencies and drive angles without a gap [Hz, rad]."""

    frequency: Span
    drive_angle: Span


class LineOptimiser(Exchange):
    """Optimal settings of a drive along a line.

    Parameters
    ----------
    question : Question
        Drive, goal and bands.
    """

    surpluses = (0.0, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2)
    _least_set_by = "onset"

    def __init__(self, question: Question) -> None:
        choices = question.drive.choices
        self._ranges = [Range(f, a) for f in question.drive.frequency for a in choices["drive_angle"]]
        one = question.box(_unit(question.drive.choices["drive_angle"][0][0]))
        effort = _LINE_IN_CONTACT
        if question.flies:
            effort = _LINE_BOUNCING if question.spec.restitution else _LINE_FLYING
        self._closely = effort
        self._monotone = question.highest is Regime.FORWARD_SLIP and is_braked(one) and steeper_is_slower(one)
        # corners of the slowest bodies, and of those that may run away where bands are scaled
        if self._monotone:
            coordinates = np.array(
                [[0, 0, 1, 1], [0, 1, 0, 1], [1, 1, 0, 0], [1, 1, 0, 0], [1, 1, 0, 0]], np.float64
            )
        else:
            coordinates = corners(one.varies)
        super().__init__(question, effort, coordinates)

    def _caps(self, drive_angle: Floats, scale: Floats | float = 1.0) -> dict[str, Floats]:
        """Return the largest nominal load of each drive angle, by the constraint that sets it.

        The drive's own limit is on nominal values, at any scale. Settings that hop are searched up to a throw
        number of 10.
        """
        question = self._question
        box = question.box(_unit(drive_angle), scale)
        loads = self._tip_loads(box) | regime_loads(box, question.highest)
        most = question.growth(scale)
        shape = np.broadcast_shapes(np.shape(drive_angle), np.shape(scale))
        # without static friction the load is NaN, and no load is allowed
        loads = {name: np.nan_to_num(load, nan=0.0, posinf=math.inf) for name, load in loads.items()}
        least = 1.0 - TOLERANCES.beside
        caps = {name: np.broadcast_to(load / most * least, shape) for name, load in loads.items()}
        limit = np.full(shape, question.drive.acceleration)
        if question.flies:
            limit = np.minimum(limit, MOST_DESIGN_THROW * box.hop_load / most)
        return {**caps, "limit": limit}

    def _tip_loads(self, box: UncertaintySet) -> dict[str, Floats]:
        """Return the load up to which every part stays upright, if it must; landings are not modelled."""
        ratio = self._question.spec.stand_ratio
        if math.isinf(ratio):
            return {}
        load = tip_load(box, ratio)
        return {"tip": np.minimum(load, box.hop_load) if self._question.flies else load}

    def _setting(self, load: Floats, frequency: tuple[Any, Any], drive_angle: Floats) -> Setting:
        """Return the fastest setting of a load: the lowest frequency that the amplitudes allow.

        At one load the speed of every body goes with 1/f.
        """
        question = self._question
        weight = np.maximum(load, TOLERANCES.short) * question.spec.gravity / (4.0 * math.pi**2)  # A f^2
        least, most = question.drive.span("amplitude")
        f = np.clip(np.sqrt(weight / most), *frequency)
        amplitude = np.clip(weight / (f * f), least, most)
        return question.space.setting(amplitude=amplitude, frequency=f, drive_angle=drive_angle)

    def _soft_setting(
        self, load: Floats, frequency: Span, drive_angle: Floats, scale: Floats | float
    ) -> Setting:
        """Return the fastest setting of a load whose impacts keep to their limit: they too go with 1/f."""
        setting, limit = self._setting(load, frequency, drive_angle), self._question.landings.impact_speed
        if math.isinf(limit):
            return setting
        hardest = self._question.hardest_impacts(setting, self.scenarios, scale) * (1.0 + TOLERANCES.beside)
        raised = setting.frequency * np.maximum(hardest / limit, 1.0)
        return self._setting(load, (raised, frequency[1]), drive_angle)

    def _holds(self, setting: Setting, scale: Floats | float) -> NDArray[np.bool_]:
        """Return whether settings keep to the regime."""
        question = self._question
        angles = question.space.turned(setting)["drive_angle"]
        caps = self._caps(np.reshape(angles, (-1, 1)), np.reshape(scale, (-1, 1)))
        load = question.load(setting) * (1.0 - TOLERANCES.rounding)
        least = np.min([cap[:, 0] for name, cap in caps.items() if name != "limit"], axis=0, initial=np.inf)
        return np.asarray(load <= least)

    def _tops(self, angles: Floats, choice: Range, scale: float) -> Floats:
        """Largest nominal loads at drive angles."""
        caps = self._caps(angles[:, None], scale).values()
        reach = np.full(angles.size, self._reach(choice)[1])
        return np.asarray(np.min([*(cap[:, 0] for cap in caps), reach], axis=0))

    def _reach(self, choice: Range) -> tuple[float, float]:
        """Smallest and largest load that the amplitudes allow within a range of frequencies."""
        low, high = (
            a * (2.0 * math.pi * f) ** 2 / self._question.spec.gravity
            for a, f in zip(self._question.drive.span("amplitude"), choice.frequency, strict=True)
        )
        return low, high

    def _fastest(self, scale: float, generations: int) -> Optimum | None:
        """Return the fastest setting for the current scenarios."""
        search = self._fastest_at_the_top if self._monotone else self._fastest_below
        found = [search(choice, scale, generations) for choice in self._ranges]
        best = max(found, key=lambda optimum: optimum.speed)
        return best if best.speed > 0.0 else None

    def _value(self, angles: Floats, loads: Floats, choice: Range, scale: float) -> Floats:
        """Guaranteed speeds of the fastest settings of loads; -inf where a load is beyond reach."""
        setting = self._soft_setting(loads, choice.frequency, angles, scale)
        low, high = self._reach(choice)
        beside = TOLERANCES.beside
        possible = (loads >= low * (1.0 - beside)) & (loads <= high * (1.0 + beside)) & (loads > 0.0)
        return np.where(possible, self.least(setting, scale), -np.inf)

    def _fastest_at_the_top(self, choice: Range, scale: float, generations: int) -> Optimum:
        """Search the drive angle alone: the speed rises with the load up to the first constraint."""

        def value(angles: Floats) -> Floats:
            return self._value(angles, self._tops(angles, choice, scale), choice, scale)

        angle = np.array([_best(value, choice.drive_angle, self._closely)])
        setting = self._setting(self._tops(angle, choice, scale), choice.frequency, angle)
        return _optimum(setting, float(value(angle)[0]))

    def _fastest_below(self, choice: Range, scale: float, generations: int) -> Optimum:
        """Search drive angle and load."""
        least = self._reach(choice)[0]
        turns = choice.drive_angle[0] < choice.drive_angle[1]
        frees = np.array([turns, True])

        def settings(x: Floats) -> tuple[Floats, Floats, Setting]:
            coordinates = placed(frees, x)
            angles = inside(choice.drive_angle, coordinates[0])
            tops = self._tops(angles, choice, scale)
            loads = tops * np.minimum(np.maximum(least / tops, _SLOWEST_LOAD), 1.0) ** coordinates[1]
            return loads, tops, self._soft_setting(loads, choice.frequency, angles, scale)

        def speed(x: Floats) -> Floats:
            loads, tops, setting = settings(x)
            possible = (tops > 0.0) & (loads >= least * (1.0 - TOLERANCES.beside))
            return np.where(possible, self.least(setting, scale), -np.inf)

        def cost(x: Floats) -> Floats:
            speeds = speed(x)
            # Where all bodies rest the speed is flat and would trap the population, so rest costs more than
            # any speed, and the more the lower the load.
            return np.where(speeds == 0.0, _AT_REST + x[-1], -speeds)

        first = sobol(int(frees.sum()), self._effort.population, _SEED)
        ends = first.shape[1] // _SCATTERED  # of them at the largest loads, over all angles
        first[:, :ends] = 0.0
        first[0, :ends] = np.linspace(0.0, 1.0, ends) if turns else 0.0
        x = self._minimised(cost, first, generations)
        return _optimum(settings(x)[2], float(speed(x)[0]))

    def _least_acceleration(self, target: float) -> Optimum | None:
        """Return the setting of least load that reaches a speed, for the current scenarios."""
        found = []
        for choice in self._ranges:
            known = (np.zeros(0), np.zeros(0))  # angles and loads

            def value(angles: Floats, choice: Range = choice) -> Floats:
                nonlocal known
                loads = self._first_loads(angles, target, choice, *known)
                order = np.argsort(all_angles := np.append(known[0], angles))
                known = all_angles[order], np.append(known[1], loads)[order]
                if np.isfinite(loads).all():
                    return -loads
                # The angles that reach the speed may all lie between two of the grid. The speed at the
                # largest load leads the search there.
                top = self._value(angles, self._tops(angles, choice, 1.0), choice, 1.0)
                return np.where(np.isfinite(loads), -loads, -_MISSED * (2.0 - top / target))

            angle = np.array([_best(value, choice.drive_angle, self._closely)])
            load = self._first_load(angle, target, choice)
            if np.isfinite(load[0]):
                setting = self._soft_setting(load, choice.frequency, angle, 1.0)
                speed = float(self._value(angle, load, choice, 1.0)[0])
                found.append((float(load[0]), _optimum(setting, speed)))
        return min(found, key=lambda pair: pair[0])[1] if found else None

    def _first_loads(
        self, angles: Floats, target: float, choice: Range, known: Floats, loads: Floats
    ) -> Floats:
        """Least loads that reach a speed at drive angles, given those at others, in ascending order.

        The load is searched near those of both neighbours, and over all loads if it is not found there.
        """
        if not known.size:
            return self._first_load(angles, target, choice)
        after = np.clip(np.searchsorted(known, angles), 1, known.size - 1)
        ends = np.array([loads[after - 1], loads[after]])
        found = np.full(angles.size, np.inf)
        near = np.isfinite(ends).all(axis=0)
        if near.any():
            low, high = ends[:, near].min(axis=0), ends[:, near].max(axis=0)
            margin = high - low + _END_MARGIN * high
            found[near] = self._first_load(angles[near], target, choice, (low - margin, high + margin))
            near[near] = found[near] > low - margin  # else a load below may reach it too
        lost = ~(near & np.isfinite(found))
        if lost.any():
            found[lost] = self._first_load(angles[lost], target, choice)
        return found

    def _first_load(
        self, angles: Floats, target: float, choice: Range, window: tuple[Floats, Floats] | None = None
    ) -> Floats:
        """Least loads that reach a speed at drive angles, between two where given; inf where none does."""
        tops = self._tops(angles, choice, 1.0)
        boxes = self._question.box(_unit(angles[:, None]))
        # below the onset of the last body no speed is guaranteed
        onset = onset_load(boxes) / boxes.load[0] * self._question.load(_unit(0.0))
        bottom = np.maximum(onset[:, 0], self._reach(choice)[0])
        if not self._monotone:
            bottom = np.maximum(bottom, _SLOWEST_LOAD * tops)
        if window is not None:
            bottom, tops = np.maximum(bottom, window[0]), np.minimum(tops, window[1])
        bottom = np.minimum(bottom, tops)
        if self._monotone:
            grid = np.column_stack([bottom, tops])
        else:
            coordinates = np.linspace(0.0, 1.0, self._closely.loads if window is None else _IN_WINDOW)
            grid = bottom[:, None] * (tops / bottom)[:, None] ** coordinates
            entries = self._entries(angles)
            beside = np.hstack([entries * (1.0 - TOLERANCES.beside), entries * (1.0 + TOLERANCES.beside)])
            beside = np.clip(beside, bottom[:, None], tops[:, None])
            inside = np.any((beside > bottom[:, None]) & (beside < tops[:, None]), axis=0)
            grid = np.sort(np.hstack([grid, beside[:, inside]]), axis=1)

        def value(rows: NDArray[np.intp], loads: Floats) -> Floats:
            return self._value(angles[rows], loads, choice, 1.0)

        return first_crossing(value, grid, target, climbs=self._closely.climbs, relative=self._closely.width)

    def _entries(self, angles: Floats) -> Floats:
        """Nominal loads at which each of the bodies begins to slip back, of shape (angles, bodies)."""
        boxes = self._question.box(_unit(angles[:, None]))
        points = boxes.points(self.scenarios.at(boxes))
        entries = entry_loads(boxes, points) / points.load * self._question.load(_unit(0.0))
        return np.where(np.isfinite(entries), entries, 0.0)

    def limit(self, found: Found, scale: float) -> str:
        """Return the name of a setting's active constraint, with bands scaled by a factor."""
        question = self._question
        load = float(question.load(found.setting))
        landings = question.landings.scaled(TOLERANCES.nearly)
        if landings.worst(question.box(found.setting, scale)).size:
            return "limit"
        turned = question.space.turned(found.setting)
        caps = self._caps(np.array([[turned["drive_angle"]]]), scale)
        name, cap = min(((name, float(cap[0, 0])) for name, cap in caps.items()), key=lambda pair: pair[1])
        if load >= cap * (1.0 - TOLERANCES.at):
            return name
        most = question.drive.span("amplitude")[1]
        return "limit" if turned["amplitude"] >= most * (1.0 - TOLERANCES.at) else "speed"

    def first_cap(self) -> str:
        """Return the constraint that bounds the load before any speed is guaranteed, at the middle angle."""
        middle = np.array([[float(np.mean(self._ranges[0].drive_angle))]])
        caps = {name: float(cap[0, 0]) for name, cap in self._caps(middle).items()}
        reach = max(self._reach(choice)[1] for choice in self._ranges)
        caps["limit"] = min(caps["limit"], reach)
        return min(caps, key=lambda name: caps[name])


def _unit(drive_angle: Any) -> Setting:
    """Return the setting of an amplitude of 1 m at 1 Hz."""
    return _LINES.setting(amplitude=1.0, frequency=1.0, drive_angle=drive_angle)


def _optimum(setting: Setting, speed: float) -> Optimum:
    """Return a setting of shape (1,) as an optimum."""
    return Optimum(Setting(*(float(np.ravel(x)[0]) for x in setting)), speed)


def _best(value: Callable[[Floats], Floats], span: tuple[float, float], effort: _Effort) -> float:
    """Return the drive angle of the largest value: on a grid, refined around its best peaks."""
    low, high = span
    if low == high:
        return low
    width = (high - low) / (effort.angles - 1)
    angles = np.linspace(low, high, effort.angles)
    values = value(angles)
    for _ in range(effort.rounds):
        peaks = np.flatnonzero(
            (values >= np.append(values[1:], -np.inf)) & (values >= np.append(-np.inf, values[:-1]))
        )
        kept = peaks[np.argsort(-values[peaks])][:_KEPT]
        near = angles[kept, None] + width * np.linspace(-1.0, 1.0, _CLOSER)
        more = np.setdiff1d(np.clip(near, low, high), angles)
        angles, values = np.append(angles, more), np.append(values, value(more))
        order = np.argsort(angles)
        angles, values = angles[order], values[order]
        width /= 0.5 * (_CLOSER - 1)
    return float(angles[np.argmax(values)])


# ------------------------------------------------------------------------------
# Find settings of an elliptical drive, by evolution.


class EllipseOptimiser(_Evolution):
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


# ------------------------------------------------------------------------------
# Find settings of a drive that is a given motion, by evolution over its scale and its frequency.


class MotionOptimiser(_Evolution):
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
