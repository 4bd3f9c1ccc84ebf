"""Find settings of a drive along a line: of least acceleration, top speed or largest margin.

Amplitude and frequency enter through the load G = A w^2 / g and a factor 1/f on all speeds, so that of all
settings with one load the lowest frequency is the best: what is left to choose is a drive angle and a load.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from vibro.core.codes import Regime
from vibro.drives import Line
from vibro.inverse.exchange import SCATTERED, SEED, Effort, Exchange, Optimum
from vibro.inverse.proofs import corners, is_braked, onset_load, regime_loads, steeper_is_slower, tip_load
from vibro.inverse.questions import MOST_DESIGN_THROW
from vibro.inverse.scenarios import entry_loads
from vibro.inverse.search import first_crossing, placed, sobol
from vibro.inverse.spaces import SPACES, Setting, inside
from vibro.inverse.tolerances import TOLERANCES

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from vibro.inverse.exchange import Found
    from vibro.inverse.questions import Question
    from vibro.inverse.spaces import UncertaintySet
    from vibro.inverse.specs import Span

    Floats = NDArray[np.float64]

__all__ = ["LineOptimiser"]

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


_IN_CONTACT: Final = _Effort(
    angles=65, rounds=9, loads=129, population=6, generations=80, climbs=5, width=1e-13, margins=33,
    margin=1e-6, scale=1e-6, exchanges=8,
)  # fmt: skip
_FLYING: Final = _Effort(
    angles=33, rounds=3, loads=65, population=8, generations=3, climbs=1, width=5e-11, margins=33,
    margin=1e-3, scale=1e-3, exchanges=2,
)  # fmt: skip
# bounces are slow to solve
_BOUNCING: Final = _Effort(
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
        effort = _IN_CONTACT
        if question.flies:
            effort = _BOUNCING if question.spec.restitution else _FLYING
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

        first = sobol(int(frees.sum()), self._effort.population, SEED)
        ends = first.shape[1] // SCATTERED  # of them at the largest loads, over all angles
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
