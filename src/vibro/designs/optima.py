"""Find optimal settings of any kind of drive by exchange of scenarios.

A setting is optimised for a few scenarios of its uncertainty set. If a search of the whole set finds a slower
body, that body joins the scenarios, and the setting is optimised again.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from itertools import product
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from vibro.core.codes import Regime
from vibro.designs.guarantees import BRIEF, Seen, bound, least_of
from vibro.designs.proofs import (
    corners,
    regime_loads,
    slip_ratio,
    tip_load,
)
from vibro.designs.questions import MOST_DESIGN_THROW, Goal
from vibro.designs.search import close_in, evolve, placed, scatter, sobol
from vibro.designs.spaces import SPACES, TOLERANCES, Scaled, Setting, inside
from vibro.drives import Line

if TYPE_CHECKING:
    from collections.abc import Callable, Collection

    from vibro.designs.questions import Drive, Question
    from vibro.designs.spaces import AnySetting, Span, UncertaintySet
    from vibro.reals import Bools, Floats

    Spans = tuple[Span, ...]  # a range of every knob


#: [1] Largest margin that is searched: factor on the bands.
MOST_MARGIN: Final = 10.0

_SEED: Final = 1
_SCATTERED: Final = 4  # ratio of the sampled settings in the first round to those in each later round
_ROUGH: Final = 0.5  # share of the generations where one scale of the bands of many is searched
_STEPS: Final = 60  # iterations at most of the root search
_AROUND: Final = 31  # settings around the best of an evolution, from which it is polished
_NEAR: Final = 0.03  # [share of a range] standard deviation of these


@dataclass(frozen=True, kw_only=True)
class Effort:
    """Sizes and resolutions of the searches.

    Attributes
    ----------
    population, generations : int
        Size of an evolution's population over one coordinate or two, as a base-2 logarithm, and its
        generations; for bodies that hop, the first samples and the further rounds.
    polish : int
        Generations of the polish.
    margins : int
        Margins of one setting that are evaluated at once.
    margin, scale : float
        Tolerances of margins, and of the scale of the bands at which the safest setting is the fastest one.
    exchanges : int
        Largest number of searches for slower bodies.
    """

    population: int
    generations: int
    polish: int
    margins: int
    margin: float
    scale: float
    exchanges: int


# Of bodies in contact, of hops, and of bounces, which are slow to solve.
_EFFORTS: Final = (
    Effort(population=6, generations=50, polish=50, margins=33, margin=1e-4, scale=3e-2, exchanges=6),
    Effort(population=8, generations=3, polish=0, margins=17, margin=1e-2, scale=0.1, exchanges=1),
    Effort(population=6, generations=1, polish=0, margins=5, margin=0.1, scale=0.3, exchanges=1),
)
# [1] Costs of settings that are too slow, at rest, forbidden: in rising order, far above any load or speed.
_SLOW: Final = 1e6
_RESTS: Final = 2e6
_FORBIDDEN: Final = 3e6


class Optimum(NamedTuple):
    """A setting, and the least speed there, of the scenarios or of all bodies [m/s]."""

    setting: AnySetting
    speed: float


class Optimiser(ABC):
    """Finds optimal settings of one question: of least acceleration, top speed or largest margin.

    Every free knob is a coordinate of one search.

    Parameters
    ----------
    question : Question
        Drive, goal and bands.
    """

    #: Sizes of the searches of bodies in contact, of hops and of bounces, which are slow to solve.
    _efforts: tuple[Effort, Effort, Effort] = _EFFORTS
    #: Relative surpluses over the goal, tried in turn until a least-acceleration setting survives rounding.
    surpluses: tuple[float, ...] = (0.0, 1e-4, 1e-2)  # one search each
    #: The active constraint of a least-acceleration design that exceeds its target.
    _least_set_by = "limit"

    def __init__(self, question: Question) -> None:
        self._question = question
        self._effort = self._efforts[question.flies * (2 if question.spec.bounces[1] > 0.0 else 1)]
        #: Unit-cube coordinates, (axes, n), of the bodies for which settings are optimised.
        self.scenarios = corners(question.box(_at_ends(question.drive, 1)).varies)
        #: Bodies in a higher regime than this count as the slowest.
        self._checked = question.highest
        choices = question.drive.choices
        #: Of every knob one of its ranges, in all combinations.
        self._ranges: list[Spans] = list(product(*(choices[knob] for knob in question.space.knobs)))

    @abstractmethod
    def _settings(self, coordinates: Floats, spans: Spans, scale: float) -> tuple[AnySetting, Floats, Bools]:
        """Return settings at unit-cube coordinates, the sum of their sizes' shares, and which can be."""

    def _free(self, spans: Spans) -> Bools:
        """Return which coordinates are free."""
        return np.array([low < high for low, high in spans])

    def _most(self, unit: AnySetting, scale: float) -> Floats:
        """Return the factor on settings up to which no part hops, or is thrown by ``MOST_DESIGN_THROW``."""
        box = self._question.box(unit, scale)
        most = MOST_DESIGN_THROW if self._question.flies else 1.0
        return np.asarray(most * box.hop_load / box.load[1] * (1.0 - TOLERANCES.beside))

    # What may be asked of it: optima, margins, and what they are set by.

    def fastest(self, scale: float = 1.0) -> Optimum | None:
        """Return the setting of the largest guaranteed speed; None if no setting guarantees any."""
        return self._exchanged(lambda: (self._fastest(scale), scale))[0]

    def least_acceleration(self, target: float) -> Optimum | None:
        """Return the setting of least acceleration that guarantees a speed [m/s]; None if there is none."""
        return self._exchanged(lambda: (self._least_acceleration(target), 1.0))[0]

    def safest(self, target: float) -> Optimum | None:
        """Return the setting of the largest margin for a speed [m/s]; None if none guarantees the speed."""
        if not self._question.spec.has_bands:
            best = self.fastest()
            return best if best is not None and best.speed >= target else None
        return self._exchanged(lambda: self._safest(target))[0]

    def margin(self, setting: AnySetting, target: float) -> float | None:
        """Return the largest scale of the bands at which a setting guarantees a speed; None without one."""

        def widest() -> tuple[Optimum | None, float]:
            margin = self._margin(setting, target)
            return None if margin is None else Optimum(setting, target), margin or 0.0

        found, margin = self._exchanged(widest)
        return None if found is None else margin

    def holds(self, setting: AnySetting, target: float) -> bool:
        """Return whether all scenarios reach a speed, within the regime and the drive's limit."""
        most = self._question.drive.acceleration * (1.0 + TOLERANCES.converted)
        if float(self._question.load(setting)) > most:
            return False
        one = setting._make(np.array([float(x)]) for x in setting)
        return bool(self._holds(one, 1.0)[0] and self.least(one, 1.0)[0] >= target)

    def has_more(self) -> bool:
        """Whether this regime allows a setting, or a wider band, that lower regimes forbid."""
        question = self._question
        widest = question.box(_at_ends(question.drive, 1), MOST_MARGIN)
        return not question.flies or widest.throw_number > 1.0 - TOLERANCES.beside

    def keeps_to_regime(self, setting: AnySetting, regimes: Collection[Regime]) -> bool:
        """Return whether a setting keeps to the regime: with bodies of known regimes, and of a search."""
        if any(regime > self._checked for regime in regimes):
            return False
        return self._checked is not Regime.FORWARD_SLIP or slip_ratio(self._question.box(setting))[0] <= 1.0

    def least_set_by(self, setting: AnySetting) -> str:
        """Return the active constraint of a least-acceleration setting that exceeds its target."""
        question = self._question
        least = question.drive.accelerations[0] / question.spec.gravity * (1.0 + TOLERANCES.at)
        return "limit" if question.load(setting) <= least else self._least_set_by

    def limit(self, setting: AnySetting, scale: float) -> str:
        """Return the name of a setting's active constraint, with bands scaled by a factor."""
        question, drive = self._question, self._question.drive
        if question.landings.scaled(TOLERANCES.nearly).worst(question.box(setting, scale)).size:
            return "limit"
        nearly = 1.0 - TOLERANCES.at
        if not question.flies and question.box(setting, scale).throw_number >= nearly:
            return "hop"
        beyond = setting.scaled(1.0 + TOLERANCES.at)
        both: Any = setting._make(np.array(pair) for pair in zip(setting, beyond, strict=True))
        here, there = self.least(both, scale)
        if math.isinf(there) and (by := self._forbids(beyond, scale)):
            return by
        if -math.inf < there < here * (1.0 - TOLERANCES.fall):
            return "back slip"
        sizes = question.space.turned(setting)
        at_most = [sizes[knob] >= drive.span(knob)[1] * nearly for knob in question.space.sizes]
        at_most.append(float(question.load(setting)) >= drive.acceleration * nearly)
        return "limit" if any(at_most) else "speed"

    def _forbids(self, setting: AnySetting, scale: float) -> str:
        """Return the constraint without which a setting would be allowed; empty where bodies run away."""
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
        return "hop" if self._question.box(setting, scale).throw_number > 1.0 else ""

    def first_cap(self) -> str:
        """Return the constraint that bounds the load before any speed is guaranteed."""
        question = self._question
        throw = question.box(_at_ends(question.drive, 0)).throw_number
        if throw > (MOST_DESIGN_THROW if question.flies else 1.0):
            return "hop"
        others = {}
        if math.isfinite(question.spec.stand_ratio):
            others["tip"] = replace(question, spec=replace(question.spec, stand_ratio=math.inf))
        if question.highest is Regime.FORWARD_SLIP:
            others["back slip"] = replace(question, highest=Regime.BACK_SLIP)
        if not question.flies:
            others["hop"] = replace(question, highest=Regime.HOPPING)
        return next((name for name, other in others.items() if type(self)(other).fastest()), "limit")

    # The searches, of the scenarios alone.

    def least(self, setting: AnySetting, scale: Floats | float) -> Floats:
        """Return the least speed of the scenarios at each setting [m/s]."""
        return least_of(self._question.speeds(setting, self.scenarios, scale))

    def _holds(self, setting: AnySetting, scale: Floats | float) -> Bools:
        """Return whether critical loads allow settings; bodies are not solved here."""
        return np.ones(np.broadcast_shapes(np.shape(setting[0]), np.shape(scale)), np.bool_)

    def _fastest(self, scale: float, share: float = 1.0) -> Optimum | None:
        def cost(setting: AnySetting, shares: Floats) -> Floats:
            speeds = self.least(setting, scale)
            return np.where(
                speeds == 0.0, _RESTS - shares, np.where(np.isinf(speeds), _FORBIDDEN + shares, -speeds)
            )

        setting, least = self._best(cost, scale, share)
        return Optimum(setting, -least) if least < 0.0 else None

    def _least_acceleration(self, target: float) -> Optimum | None:
        def cost(setting: AnySetting, shares: Floats) -> Floats:
            speeds = self.least(setting, 1.0)
            slow = np.where(np.isinf(speeds), _FORBIDDEN + shares, _SLOW * (2.0 - speeds / target))
            return np.where(speeds >= target, self._question.load(setting), slow)

        setting, least = self._best(cost, 1.0)
        if least >= _SLOW:
            return None
        columns = setting._make(np.array([x]) for x in setting)
        return Optimum(setting, float(self.least(columns, 1.0)[0]))

    def _safest(self, target: float) -> tuple[Optimum | None, float]:
        """Return the setting that reaches the speed at the largest scale of the bands, and that scale."""
        holds: dict[float, Optimum] = {}

        def surplus(scale: float) -> float:
            best = self._fastest(scale, _ROUGH)
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

    def _margin(self, setting: AnySetting, target: float) -> float | None:
        """Return the margin of a setting.

        Boxes of growing scale contain each other, so a setting that fails at one fails at every larger one.
        """

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

    def _best(
        self, cost: Callable[[AnySetting, Floats], Floats], scale: float, share: float = 1.0
    ) -> tuple[AnySetting, float]:
        """Return the setting of least cost of all ranges, and its cost."""
        found = [self._best_of(cost, spans, scale, share) for spans in self._ranges]
        return min(found, key=lambda best: best[1])

    def _best_of(
        self, cost: Callable[[AnySetting, Floats], Floats], spans: Spans, scale: float, share: float
    ) -> tuple[AnySetting, float]:
        """Return the setting of least cost within one range of every knob, and its cost."""
        free = self._free(spans)
        count = int(free.sum())

        def whole(x: Floats) -> Floats:
            setting, shares, possible = self._settings(placed(free, x), spans, scale)
            costs = np.full(x.shape[1], 2.0 * _FORBIDDEN) + shares
            if possible.any():
                some = setting._make(values[possible] for values in setting)
                costs[possible] = cost(some, shares[possible])
            return costs

        x = np.zeros((0, 1))
        if count:
            first = sobol(count, self._effort.population + max(count - 2, 0), _SEED)
            x = self._minimised(whole, first, share)
        setting = self._settings(placed(free, x), spans, scale)[0]
        return setting._make(float(values[0]) for values in setting), float(whole(x)[0])

    def _minimised(self, cost: Callable[[Floats], Floats], first: Floats, share: float) -> Floats:
        """Return the point of least cost, of shape (d, 1), by a share of the generations.

        An evolution finds the valley, and a second one of few points around its best polishes it. Costs of
        hopping bodies are sampled: one call for many settings is cheaper than many calls for a few.
        """
        effort = self._effort
        if self._question.flies:
            more = first.shape[1] // _SCATTERED
            return scatter(cost, first, more=more, rounds=effort.generations, seed=_SEED)[0]
        best, _ = evolve(cost, first, generations=round(share * effort.generations), seed=_SEED)
        around = np.random.default_rng(_SEED).standard_normal((len(best), _AROUND))
        near = np.hstack([best, np.clip(best + _NEAR * around, 0.0, 1.0)])
        return evolve(cost, near, generations=round(share * effort.polish), seed=_SEED)[0]

    # Scenarios: bodies that the searches of whole uncertainty sets find slower join them.

    def _exchanged(self, find: Callable[[], tuple[Optimum | None, float]]) -> tuple[Optimum | None, float]:
        """Repeat a search until no body is slower at what it finds; return that, and its scale of bands."""
        for _ in range(self._effort.exchanges + 1):
            found, scale = find()
            if found is None:
                break
            found, joined = self.confirmed(found, scale)
            if not joined:
                break
        return found, scale

    def confirmed(self, optimum: Optimum, scale: float = 1.0) -> tuple[Optimum, bool]:
        """Return an optimum with the least speed of all bodies, and whether bodies joined the scenarios.

        Those join that are slower than all scenarios or beyond limits, and differ from them in six decimals:
        the slowest body may be where back slip begins, and move with every setting.
        """
        question, box = self._question, self._question.box(optimum.setting, scale)
        slowest = bound(box, fast=False, seen=Seen(), boxes=BRIEF, highest=self._checked).extreme
        new = [self.scenarios, question.landings.worst(box)]
        if slowest.speed < optimum.speed - TOLERANCES.searched * abs(optimum.speed):
            new.append(slowest.coordinates)
            optimum = optimum._replace(speed=slowest.speed)
        if self._checked is Regime.FORWARD_SLIP:
            ratio, first = slip_ratio(box)
            new += [first] * (ratio > 1.0)
        bodies, known = np.hstack(new), self.scenarios.shape[1]
        _, different = np.unique(np.round(bodies, TOLERANCES.digits), axis=1, return_index=True)
        self.scenarios = bodies[:, np.sort(different)]
        return optimum, different.size > known


def _at_ends(drive: Drive, end: int) -> AnySetting:
    """Return the setting with the least (0) or the largest (1) value of every knob."""
    ends = {knob: (min, max)[end](span[end] for span in spans) for knob, spans in drive.choices.items()}
    return drive.space.setting(**ends)


def below(most: Floats, span: Span, share: Floats) -> tuple[Floats, Bools]:
    """Return the value at a share of a range below a limit, and whether the limit leaves any of the range."""
    low, high = span
    top = np.clip(most, low, high)
    return np.where(share == 1.0, top, low + share * (top - low)), most >= low * (1.0 - math.ulp(1.0))


# ------------------------------------------------------------------------------
# Find settings of a drive along a line.
#
# Amplitude and frequency enter through the load G = A w^2 / g and a factor 1/f on all speeds, so that of all
# settings with one load the lowest frequency is the best: what is left to choose is a load and a drive angle.


class LineOptimiser(Optimiser):
    """Optimal settings of a drive along a line; limits of the load keep all bodies to the regime, proved.

    Parameters
    ----------
    question : Question
        Drive, goal and bands.
    """

    _efforts = (
        Effort(population=6, generations=20, polish=50, margins=33, margin=1e-6, scale=1e-4, exchanges=8),
        Effort(population=8, generations=8, polish=0, margins=33, margin=1e-3, scale=1e-2, exchanges=2),
        Effort(population=7, generations=2, polish=0, margins=9, margin=3e-2, scale=1e-1, exchanges=1),
    )
    surpluses = (0.0, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2)
    _least_set_by = "onset"

    def __init__(self, question: Question) -> None:
        super().__init__(question)
        self._checked = Regime.HOPPING  # the load excludes higher regimes than the question's

    def _free(self, spans: Spans) -> Bools:
        """Return which are free: load, drive angle, and where impacts limit it the least frequency."""
        low, high = self._reach(spans)
        raised = math.isfinite(self._question.landings.impact_speed) and spans[1][0] < spans[1][1]
        return np.array([low < high, raised, spans[2][0] < spans[2][1]])

    def _settings(self, coordinates: Floats, spans: Spans, scale: float) -> tuple[Setting, Floats, Bools]:
        """Return settings at unit-cube coordinates, the shares of their loads, and which can be."""
        share, raised, turn = coordinates
        angles, frequency = inside(spans[2], turn), (inside(spans[1], raised), spans[1][1])
        tops = np.min([cap[:, 0] for cap in self._caps(angles[:, None], scale).values()], axis=0)
        loads, possible = below(tops, self._reach(spans), share)
        return self._slowest(loads, frequency, angles), share, possible & (loads > 0.0)

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

    def _reach(self, spans: Spans) -> Span:
        """Return the smallest and the largest load that amplitudes and frequencies allow."""
        low, high = (
            float(self._question.space.load_at(a, f, self._question.spec.gravity))
            for a, f in zip(*spans[:2], strict=True)
        )
        return low, high

    def _slowest(self, load: Floats, frequency: tuple[Any, Any], drive_angle: Floats) -> Setting:
        """Return the fastest setting of a load: at the lowest frequency that the amplitudes allow.

        At one load the speed of every body goes with 1/f, and so do its impacts.
        """
        question = self._question
        weight = np.maximum(load, TOLERANCES.short) * question.spec.gravity / (4.0 * math.pi**2)  # A f^2
        least, most = question.drive.span("amplitude")
        f = np.clip(np.sqrt(weight / most), *frequency)
        amplitude = np.clip(weight / (f * f), least, most)
        return question.space.setting(amplitude=amplitude, frequency=f, drive_angle=drive_angle)

    def _holds(self, setting: Setting, scale: Floats | float) -> Bools:
        """Return whether settings keep to the regime."""
        question = self._question
        angles = question.space.turned(setting)["drive_angle"]
        caps = self._caps(np.reshape(angles, (-1, 1)), np.reshape(scale, (-1, 1)))
        load = question.load(setting) * (1.0 - TOLERANCES.rounding)
        least = np.min([cap[:, 0] for name, cap in caps.items() if name != "limit"], axis=0, initial=np.inf)
        return np.asarray(load <= least)


def _unit(drive_angle: Any) -> Setting:
    """Return the setting of an amplitude of 1 m at 1 Hz."""
    return SPACES[Line].setting(amplitude=1.0, frequency=1.0, drive_angle=drive_angle)


# ------------------------------------------------------------------------------
# Find settings of an elliptical drive, by evolution.


class EllipseOptimiser(Optimiser):
    """Optimal settings of an elliptical drive.

    Every free amplitude, phase and frequency is a coordinate of one search. The lowest frequency is not
    always the best here, since one amplitude may be fixed.
    """

    def _settings(self, coordinates: Floats, spans: Spans, scale: float) -> tuple[Setting, Floats, Bools]:
        """Return settings at unit-cube coordinates, the sum of their sizes' shares, and which can be."""
        along, normal, phases, frequency = spans
        f, phase = inside(frequency, coordinates[3]), inside(phases, coordinates[2])
        y, possible = below(self._most(Setting(1.0, 1.0, 0.0, f), scale), normal, coordinates[1])
        setting = Setting(inside(along, coordinates[0]), y, phase, f)
        fits = self._question.load(setting) <= self._question.drive.acceleration
        return setting, coordinates[0] + coordinates[1], possible & fits


# ------------------------------------------------------------------------------
# Find settings of a drive that is a given motion, by evolution over its scale and its frequency.


class MotionOptimiser(Optimiser):
    """Optimal settings of a drive that is a given motion."""

    # a scene takes fifty times as long as an ellipse, and there are two coordinates at most
    _efforts = (
        Effort(population=5, generations=15, polish=20, margins=9, margin=1e-4, scale=3e-2, exchanges=4),
        *_EFFORTS[1:],
    )

    def _settings(self, coordinates: Floats, spans: Spans, scale: float) -> tuple[Scaled, Floats, Bools]:
        """Return settings at unit-cube coordinates, the shares of their scales, and which can be."""
        scales, frequency = spans
        share, f = coordinates[0], inside(frequency, coordinates[1])
        one = Scaled(1.0, f)
        limit = self._question.drive.acceleration / self._question.load(one) * (1.0 - TOLERANCES.beside)
        size, possible = below(np.minimum(self._most(one, scale), limit), scales, share)
        return Scaled(size, f), share, possible
