"""The gentlest, the fastest and the safest setting of a drive.

Amplitude and frequency enter through the load G = A w^2 / g and a factor 1/f on all speeds, so that of all
settings with one load the lowest frequency is the best: what is left to choose is a drive angle and a load.
Bodies that turn out to be slower at an optimum than all before are looked at from then on (an exchange).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from vibro.core.codes import Regime
from vibro.inverse.bodies import Bodies
from vibro.inverse.caps import onset_load
from vibro.inverse.crossings import first_crossing
from vibro.inverse.evolution import evolve, scatter, sobol
from vibro.inverse.exchange import Effort, Exchange, Optimum
from vibro.inverse.extremes import ANY_LANDING, corners, steeper_is_slower
from vibro.inverse.guarantees import is_braked
from vibro.inverse.questions import Setting
from vibro.limits import critical_loads_of_lines

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from vibro.inverse.questions import Question, Range

    Floats = NDArray[np.float64]

__all__ = ["Optimiser"]

_SLOWEST_LOAD: Final = 1e-2  # of the largest load, from which on settings are looked for
_BESIDE: Final = 1e-12  # [1] below a critical load
_ROUNDING: Final = 1e-13  # [1] of a load that is formed anew from amplitude and frequency: caps leave more
_SEED: Final = 1


@dataclass(frozen=True, kw_only=True)
class _Effort(Effort):
    """How closely is looked.

    Attributes
    ----------
    angles, rounds : int
        Drive angles looked at first, and rounds of looking closer.
    loads : int
        Loads between which a speed is looked for.
    climbs, steps : int
        Rounds of looking closer at peaks of the speed, and of bisection between two loads.
    """

    angles: int
    rounds: int
    loads: int
    climbs: int
    steps: int


_IN_CONTACT: Final = _Effort(
    angles=65, rounds=9, loads=129, population=6, generations=80, climbs=5, steps=60, margins=33,
    margin=1e-6, scale=1e-6, exchanges=8,
)  # fmt: skip
_FLYING: Final = _Effort(
    angles=33, rounds=3, loads=65, population=8, generations=3, climbs=1, steps=30, margins=33,
    margin=1e-3, scale=1e-3, exchanges=2,
)  # fmt: skip
# impacts that are not plastic take long
_BOUNCING: Final = _Effort(
    angles=9, rounds=1, loads=17, population=7, generations=2, climbs=0, steps=12, margins=9,
    margin=3e-2, scale=3e-2, exchanges=1,
)  # fmt: skip

_SCATTERED: Final = 4  # settings looked at first over those of each round of scattered ones
_MISSED: Final = 1e6  # [1] against the load of settings that miss the speed
_AT_REST: Final = 1e6  # [m/s] against the speed of settings at which no part moves
_KEPT: Final = 3  # angles to look around in each round
_CLOSER: Final = 17  # angles around each, closer by a factor of 8


class Optimiser(Exchange):
    """Optimal settings of a drive along a line.

    Parameters
    ----------
    question : Question
        What is asked.
    """

    def __init__(self, question: Question) -> None:
        angle = question.ranges[0].drive_angle[0]
        one = question.boxes(Setting(1.0, 1.0, angle))
        effort = _IN_CONTACT
        if question.flies:
            effort = _BOUNCING if question.spec.restitution else _FLYING
        self._closely = effort
        self._monotone = question.highest is Regime.FORWARD_SLIP and is_braked(one) and steeper_is_slower(one)
        if self._monotone:  # the slowest bodies, and those that may run away where bands are scaled
            shares = np.array(
                [[0, 0, 1, 1], [0, 1, 0, 1], [1, 1, 0, 0], [1, 1, 0, 0], [1, 1, 0, 0]], np.float64
            )
        else:
            shares = corners(one)
        super().__init__(question, effort, Bodies.staying(shares))

    def _holds(self, setting: Setting, scale: Floats | float) -> NDArray[np.bool_]:
        """Tell whether settings keep to the regime."""
        question = self._question
        caps = question.caps(np.reshape(setting.drive_angle, (-1, 1)), np.reshape(scale, (-1, 1)))
        load = question.load(setting) * (1.0 - _ROUNDING)
        least = np.min([cap[:, 0] for name, cap in caps.items() if name != "limit"], axis=0, initial=np.inf)
        return np.asarray(load <= least)

    def _tops(self, angles: Floats, choice: Range, scale: float) -> Floats:
        """Largest nominal loads at drive angles."""
        caps = self._question.caps(angles[:, None], scale).values()
        reach = np.full(angles.size, self._reach(choice)[1])
        return np.asarray(np.min([*(cap[:, 0] for cap in caps), reach], axis=0))

    def _reach(self, choice: Range) -> tuple[float, float]:
        low, high = self._question.reach(choice.frequency)
        return low, high

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
        return np.where(inside, self.least(setting, scale), -np.inf)

    def _fastest_at_the_top(self, choice: Range, scale: float, generations: int) -> Optimum:
        """Search the drive angle alone: the speed rises with the load up to where it must end."""

        def value(angles: Floats) -> Floats:
            return self._value(angles, self._tops(angles, choice, scale), choice, scale)

        angle = np.array([_best(value, choice.drive_angle, self._closely)])
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
            return np.where(possible, self.least(setting, scale), -np.inf)

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

            angle = np.array([_best(value, choice.drive_angle, self._closely)])
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
            shares = np.linspace(0.0, 1.0, self._closely.loads)
            grid = bottom[:, None] * (tops / bottom)[:, None] ** shares
            entries = self._entries(angles)
            beside = np.hstack([entries * (1.0 - _BESIDE), entries * (1.0 + _BESIDE)])
            grid = np.sort(np.hstack([grid, np.clip(beside, bottom[:, None], tops[:, None])]), axis=1)

        def value(rows: NDArray[np.intp], loads: Floats) -> Floats:
            return self._value(angles[rows], loads, choice, 1.0)

        return first_crossing(value, grid, target, climbs=self._closely.climbs, steps=self._closely.steps)

    def _entries(self, angles: Floats) -> Floats:
        """Nominal loads at which each of the bodies begins to slip back, of shape (angles, bodies)."""
        boxes = self._question.boxes(Setting(1.0, 1.0, angles[:, None]))
        points = boxes.points(self.bodies.at(boxes))
        known = critical_loads_of_lines(
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
