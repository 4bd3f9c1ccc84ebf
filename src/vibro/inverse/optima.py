"""The gentlest, the fastest and the safest setting of a drive.

Amplitude and frequency enter through the load G = A w^2 / g and a factor 1/f on all speeds, so that of all
settings with one load the lowest frequency is the best: what is left to choose is a drive angle and a load.
Bodies that turn out to be slower at an optimum than all before are looked at from then on (an exchange).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.codes import Regime
from vibro.core.contact.limits import critical_loads
from vibro.inverse.bodies import Bodies
from vibro.inverse.caps import onset_load
from vibro.inverse.crossings import first_crossing
from vibro.inverse.evolution import evolve, scatter, sobol
from vibro.inverse.extremes import ANY_LANDING, Seen, corners, least_of, steeper_is_slower
from vibro.inverse.guarantees import bound, is_braked
from vibro.inverse.questions import Setting

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from vibro.inverse.questions import Question, Range

    Floats = NDArray[np.float64]

__all__ = ["MOST_MARGIN", "Optimiser", "Optimum"]

#: Factor on the bands up to which a margin is followed.
MOST_MARGIN: Final = 10.0

_SLOWEST_LOAD: Final = 1e-2  # of the largest load, from which on settings are looked for
_STEPS: Final = 60  # at most, to the root of a speed
_HOLDS: Final = 1e-9  # of the speed, by which a search may find less than the bodies at hand
_DRIFTS: Final = np.linspace(0.0, 1.0, 5)  # shares of the load's drift, for every body that was the slowest
_BESIDE: Final = 1e-12  # [1] below a critical load
_ROUNDING: Final = 1e-13  # [1] of a load that is formed anew from amplitude and frequency: caps leave more
_SEED: Final = 1


class _Effort(NamedTuple):
    """How closely is looked.

    Attributes
    ----------
    angles, rounds : int
        Drive angles looked at first, and rounds of looking closer.
    loads : int
        Loads between which a speed is looked for.
    population, generations : int
        Of an evolution, or settings looked at first and rounds of scattered ones; the first as its base-2
        logarithm.
    climbs, steps : int
        Rounds of looking closer at peaks of the speed, and of bisection between two loads.
    margins : int
        Margins of one setting looked at at once.
    margin : float
        To which margins are found.
    exchanges : int
        How often slower bodies are looked for.
    """

    angles: int
    rounds: int
    loads: int
    population: int
    generations: int
    climbs: int
    steps: int
    margins: int
    margin: float
    exchanges: int


_IN_CONTACT: Final = _Effort(65, 9, 129, 6, 80, 5, 60, 33, 1e-6, 8)
_FLYING: Final = _Effort(33, 3, 65, 8, 3, 1, 30, 33, 1e-3, 2)
_BOUNCING: Final = _Effort(9, 1, 17, 7, 2, 0, 12, 9, 3e-2, 1)  # impacts that are not plastic take long

_SCATTERED: Final = 4  # settings looked at first over those of each round of scattered ones
_MISSED: Final = 1e6  # [1] against the load of settings that miss the speed
_AT_REST: Final = 1e6  # [m/s] against the speed of settings at which no part moves
_KEPT: Final = 3  # angles to look around in each round
_CLOSER: Final = 17  # angles around each, closer by a factor of 8


class Optimum(NamedTuple):
    """A setting, and the speed that the bodies looked at reach there [m/s]."""

    setting: Setting
    speed: float


class Optimiser:
    """Optimal settings for one question.

    Parameters
    ----------
    question : Question
        What is asked.
    """

    def __init__(self, question: Question) -> None:
        self._question = question
        angle = question.ranges[0].drive_angle[0]
        one = question.boxes(Setting(1.0, 1.0, angle))
        self._effort = _IN_CONTACT
        if question.flies:
            self._effort = _BOUNCING if question.spec.restitution else _FLYING
        self._monotone = question.highest is Regime.FORWARD_SLIP and is_braked(one) and steeper_is_slower(one)
        if self._monotone:  # the slowest bodies, and those that may run away where bands are scaled
            shares = np.array(
                [[0, 0, 1, 1], [0, 1, 0, 1], [1, 1, 0, 0], [1, 1, 0, 0], [1, 1, 0, 0]], np.float64
            )
        else:
            shares = corners(one)
        self._bodies = Bodies.staying(shares)

    def fastest(self, scale: float = 1.0) -> Optimum | None:
        """Return the setting of the largest guaranteed speed; None where none guarantees any."""

        def best() -> Optimum | None:
            return self._fastest(scale, self._effort.generations)

        return self._exchanged(best, scale)

    def gentlest(self, target: float) -> Optimum | None:
        """Return the setting of least acceleration that guarantees a speed [m/s]; None where none does."""
        return self._exchanged(lambda: self._gentlest(target), 1.0)

    def safest(self, target: float) -> Optimum | None:
        """Return the setting of the largest margin for a speed [m/s]; None where none guarantees it."""
        if not self._question.spec.has_bands:
            best = self.fastest()
            return best if best is not None and best.speed >= target else None
        found = None
        for _ in range(self._effort.exchanges):
            found, scale = self._safest(target)
            if found is None or not self._slower(found, scale):
                break
        return found

    def _safest(self, target: float) -> tuple[Optimum | None, float]:
        """Return the setting that holds at the largest scale, and that scale."""
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

            brentq(surplus, 1.0, MOST_MARGIN, xtol=self._effort.margin, maxiter=_STEPS, disp=False)
        widest = max(holds)
        return holds[widest], widest

    def margin(self, setting: Setting, target: float) -> float | None:
        """Return the largest scale at which a setting guarantees a speed; None where none does.

        Boxes of growing scale hold each other, so that what fails at one fails at every larger one.
        """
        margin = self._margin(setting, target)
        for _ in range(self._effort.exchanges):
            if not margin or not self._slower(Optimum(setting, target), margin):
                break
            margin = self._margin(setting, target)
        return margin

    def _margin(self, setting: Setting, target: float) -> float | None:
        low, high = 0.0, MOST_MARGIN
        while high - low > self._effort.margin:
            scales = np.linspace(low, high, self._effort.margins)
            many = Setting(*(np.full(scales.size, float(x)) for x in setting))
            holds = self._holds(many, scales) & (self._least(many, scales) >= target)
            fails = np.flatnonzero(~holds)
            if not fails.size:
                return high
            if fails[0] == 0:
                return None if low == 0.0 else low
            low, high = float(scales[fails[0] - 1]), float(scales[fails[0]])
        return low

    def holds(self, setting: Setting, target: float) -> bool:
        """Tell whether the bodies looked at reach a speed at a setting, within the regime."""
        one = Setting(*(np.array([float(x)]) for x in setting))
        return bool(self._holds(one, 1.0)[0] and self._least(one, 1.0)[0] >= target)

    def _holds(self, setting: Setting, scale: Floats | float) -> NDArray[np.bool_]:
        """Tell whether settings keep to the regime."""
        question = self._question
        caps = question.caps(np.reshape(setting.drive_angle, (-1, 1)), np.reshape(scale, (-1, 1)))
        load = question.load(setting) * (1.0 - _ROUNDING)
        least = np.min([cap[:, 0] for name, cap in caps.items() if name != "limit"], axis=0, initial=np.inf)
        return np.asarray(load <= least)

    def _least(self, setting: Setting, scale: Floats | float) -> Floats:
        return least_of(self._question.speeds(setting, self._bodies, scale))

    def _exchanged(self, best: Callable[[], Optimum | None], scale: float) -> Optimum | None:
        """Find an optimum again until no body is slower there than those looked at."""
        found = best()
        for _ in range(self._effort.exchanges):
            if found is None or not self._slower(found, scale):
                break
            found = best()
        return found

    def _slower(self, optimum: Optimum, scale: float) -> bool:
        """Look for a body that is slower at an optimum than those looked at; look at it from now on."""
        box = self._question.boxes(optimum.setting, scale)
        slowest = bound(box, fast=False, seen=Seen(), seeds=1).extreme
        new = self._question.landings.worst(box)
        if slowest.speed < optimum.speed - _HOLDS * abs(optimum.speed):
            shares = np.repeat(slowest.shares, _DRIFTS.size if box.varies[0] else 1, axis=1)
            shares[0, 1:] = _DRIFTS[1:] if box.varies[0] else 0.0
            new = np.hstack([new, slowest.shares, shares])
        known = len(self._bodies.axes)
        self._bodies = self._bodies.joined(box, new)
        return len(self._bodies.axes) > known

    def _tops(self, angles: Floats, choice: Range, scale: float) -> Floats:
        """Largest nominal loads at drive angles."""
        caps = self._question.caps(angles[:, None], scale).values()
        reach = np.full(angles.size, self._reach(choice)[1])
        return np.asarray(np.min([*(cap[:, 0] for cap in caps), reach], axis=0))

    def _reach(self, choice: Range) -> tuple[float, float]:
        return self._question.reach(choice.frequency)

    def _fastest(self, scale: float, generations: int) -> Optimum | None:
        """Return the fastest setting for the bodies looked at."""
        search = self._fastest_at_the_top if self._monotone else self._fastest_below
        found = [search(choice, scale, generations) for choice in self._question.ranges]
        best = max(found, key=lambda optimum: optimum.speed)
        return best if best.speed > 0.0 else None

    def _value(self, angles: Floats, loads: Floats, choice: Range, scale: float) -> Floats:
        """Guaranteed speeds of the fastest settings of loads; -inf where a load is beyond reach."""
        setting = self._question.setting(loads, choice.frequency, angles)
        low, high = self._reach(choice)
        inside = (loads >= low * (1.0 - _BESIDE)) & (loads <= high * (1.0 + _BESIDE)) & (loads > 0.0)
        return np.where(inside, self._least(setting, scale), -np.inf)

    def _fastest_at_the_top(self, choice: Range, scale: float, generations: int) -> Optimum:
        """Search the drive angle alone: the speed rises with the load up to where it must end."""

        def value(angles: Floats) -> Floats:
            return self._value(angles, self._tops(angles, choice, scale), choice, scale)

        angle = np.array([_best(value, choice.drive_angle, self._effort)])
        setting = self._question.setting(self._tops(angle, choice, scale), choice.frequency, angle)
        return _optimum(setting, float(value(angle)[0]))

    def _fastest_below(self, choice: Range, scale: float, generations: int) -> Optimum:
        """Search drive angle, load and, where landings have a limit, frequency."""
        least, fastest = self._reach(choice)[0], choice.frequency[1]
        frees = [choice.drive_angle[0] < choice.drive_angle[1], True, self._question.landings != ANY_LANDING]

        def placed(x: Floats) -> tuple[Floats, Floats, Setting]:
            shares = np.zeros((3, x.shape[1]))
            shares[frees] = x
            angles = _between(choice.drive_angle, shares[0])
            tops = self._tops(angles, choice, scale)
            loads = tops * np.minimum(np.maximum(least / tops, _SLOWEST_LOAD), 1.0) ** shares[1]
            lowest = self._question.setting(loads, choice.frequency, angles).frequency
            setting = self._question.setting(
                loads, (lowest * (fastest / lowest) ** shares[2], fastest), angles
            )
            return loads, tops, setting

        def speed(x: Floats) -> Floats:
            loads, tops, setting = placed(x)
            possible = (tops > 0.0) & (loads >= least * (1.0 - _BESIDE))
            return np.where(possible, self._least(setting, scale), -np.inf)

        def cost(x: Floats) -> Floats:
            speeds = speed(x)
            # All parts at rest are worse than some that move backwards: the more, the less they are loaded.
            # Otherwise rest, from where no speed leads anywhere, attracts whole populations.
            return np.where(speeds == 0.0, _AT_REST + x[-1 - frees[2]], -speeds)

        first = sobol(sum(frees), self._effort.population, _SEED)
        ends = first.shape[1] // _SCATTERED  # of them at the largest loads, over all angles
        first[:, :ends] = 0.0
        first[0, :ends] = np.linspace(0.0, 1.0, ends) if frees[0] else 0.0
        if self._question.flies:  # one look at many settings is cheaper than many looks at few
            more = first.shape[1] // _SCATTERED
            x, _ = scatter(cost, first, more=more, rounds=self._effort.generations, seed=_SEED)
        else:
            x, _ = evolve(cost, first, generations=generations, seed=_SEED)
        return _optimum(placed(x)[2], float(speed(x)[0]))

    def _gentlest(self, target: float) -> Optimum | None:
        """Return the setting of least load that reaches a speed, for the bodies looked at."""
        found = []
        for choice in self._question.ranges:

            def value(angles: Floats, choice: Range = choice) -> Floats:
                loads = self._first_load(angles, target, choice)
                if np.isfinite(loads).all():
                    return -loads
                # Angles that do it may lie close together, between two that are looked at first: those that
                # miss the speed by the least at the largest load lead there.
                top = self._value(angles, self._tops(angles, choice, 1.0), choice, 1.0)
                return np.where(np.isfinite(loads), -loads, -_MISSED * (2.0 - top / target))

            angle = np.array([_best(value, choice.drive_angle, self._effort)])
            load = self._first_load(angle, target, choice)
            if np.isfinite(load[0]):
                setting = self._question.setting(load, choice.frequency, angle)
                speed = float(self._value(angle, load, choice, 1.0)[0])
                found.append((float(load[0]), _optimum(setting, speed)))
        return min(found, key=lambda pair: pair[0])[1] if found else None

    def _first_load(self, angles: Floats, target: float, choice: Range) -> Floats:
        """Least loads that reach a speed at drive angles; inf where none does."""
        tops = self._tops(angles, choice, 1.0)
        boxes = self._question.boxes(Setting(1.0, 1.0, angles[:, None]))
        # every body must have started forward
        onset = onset_load(boxes) / boxes.load[0] * self._question.load(Setting(1.0, 1.0, 0.0))
        bottom = np.maximum(onset[:, 0], self._reach(choice)[0])
        if not self._monotone:
            bottom = np.maximum(bottom, _SLOWEST_LOAD * tops)
        bottom = np.minimum(bottom, tops)
        if self._monotone:
            grid = np.column_stack([bottom, tops])
        else:
            shares = np.linspace(0.0, 1.0, self._effort.loads)
            grid = bottom[:, None] * (tops / bottom)[:, None] ** shares
            entries = self._entries(angles)
            beside = np.hstack([entries * (1.0 - _BESIDE), entries * (1.0 + _BESIDE)])
            grid = np.sort(np.hstack([grid, np.clip(beside, bottom[:, None], tops[:, None])]), axis=1)

        def value(rows: NDArray[np.intp], loads: Floats) -> Floats:
            return self._value(angles[rows], loads, choice, 1.0)

        return first_crossing(value, grid, target, climbs=self._effort.climbs, steps=self._effort.steps)

    def _entries(self, angles: Floats) -> Floats:
        """Nominal loads at which each of the bodies begins to slip back, of shape (angles, bodies)."""
        boxes = self._question.boxes(Setting(1.0, 1.0, angles[:, None]))
        points = boxes.points(self._bodies.at(boxes))
        known = critical_loads(
            points.drive_angle, points.static_friction, points.kinetic_friction, points.trough_angle
        )
        own = points.load / self._question.load(Setting(1.0, 1.0, 0.0))
        return np.where(np.isfinite(known.back_slip), known.back_slip / own, 0.0)


def _optimum(setting: Setting, speed: float) -> Optimum:
    """Return the only one of settings."""
    return Optimum(Setting(*(float(np.ravel(x)[0]) for x in setting)), speed)


def _between(span: tuple[float, float], share: Floats) -> Floats:
    """Value at a share of a range, exact at its ends."""
    return np.where(share == 1.0, span[1], span[0] + share * (span[1] - span[0]))


def _best(value: Callable[[Floats], Floats], span: tuple[float, float], effort: _Effort) -> float:
    """Drive angle of the largest value: among many, then closer and closer around the best of them."""
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
