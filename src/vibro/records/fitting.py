"""Estimates of a scene's friction, amplitude and drive angle from a record, and what cannot be estimated."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
from scipy.special import stdtrit

from vibro.errors import InputError
from vibro.records.descent import Minimum, descend
from vibro.records.intervals import ENOUGH, profile, spread_of
from vibro.records.misfits import FITTABLE, Problem
from vibro.records.starts import starts
from vibro.records.statements import statements
from vibro.scene import Scene

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from numpy.typing import NDArray

    from vibro.records.alignment import Observation

    Floats = NDArray[np.float64]

__all__ = ["FITTABLE", "Fit", "Parameter", "fit"]

_ROUGH: Final = 1.0  # decrease of the sum of squares, in variances, below which a first descent ends
_FIRST_STEPS: Final = 5  # of every descent, before the hopeless ones are given up
_HOPELESS: Final = (1.5, 200.0)  # sum of squares, times and plus, beyond that of the best pattern
_WEIGHINGS: Final = 3
_NEIGHBOURS: Final = 400  # points around a minimum at which other patterns are looked for
_WIDEST: Final = 4.0  # standard deviations of these points, at most
_KEPT: Final = 24  # of them, of each pattern
_RESTARTS: Final = 3  # from a better point than the search had found
_CONFIDENCE: Final = 0.95
_REST: Final = 25.0  # a motion must fit this much better than rest, in variances, to be one: 5 sigma
# An interval whose half exceeds this share of the estimate leaves no estimate: 30 % of standard error.
_WIDE: Final = 0.6
_AT_BOUND: Final = 1e-3  # relative: an interval that reaches this near what is tried has no end


@dataclass(frozen=True)
class Parameter:
    """One estimate.

    Attributes
    ----------
    name : str
        A field of ``Scene``.
    value : float
        The best fit [SI].
    intervals : tuple of pairs of float
        Values that the data allow with 95 % confidence, ascending, apart [SI]: for noise and misfit, not for
        what the model leaves out. More than one pair where patterns apart from each other fit. Empty where
        the data do not bound the quantity.
    identified : bool
        Whether the data determine a value; else there is at most a range.
    """

    name: str
    value: float
    intervals: tuple[tuple[float, float], ...]
    identified: bool

    @property
    def low(self) -> float:
        """Least value of all intervals; NaN without one [SI]."""
        return self.intervals[0][0] if self.intervals else math.nan

    @property
    def high(self) -> float:
        """Greatest value of all intervals; NaN without one [SI]."""
        return self.intervals[-1][1] if self.intervals else math.nan


@dataclass(frozen=True, eq=False)
class Fit:
    """Estimates, and how far they can be trusted.

    Attributes
    ----------
    scene : Scene
        The scene with the estimates.
    parameters : tuple of Parameter
        In the order asked for.
    statements : tuple of str
        In words: what each estimate comes from, which parameters the data cannot identify, and why.
    """

    scene: Scene
    parameters: tuple[Parameter, ...]
    statements: tuple[str, ...]


def fit(scene: Scene, observation: Observation, names: Sequence[str]) -> Fit:
    """Estimate quantities of a scene from a record.

    Parameters
    ----------
    scene : Scene
        Of shape (); it gives the quantities that are not estimated, and one start of the search.
    observation : Observation
        The record.
    names : sequence of str
        Some of ``FITTABLE``.

    Returns
    -------
    Fit
        By least squares over all signals, each weighted by the inverse of its own misfit; the unknown trigger
        time and the sensors' offsets and drifts are fitted too. Of long records the middle is used.

    Raises
    ------
    InputError
        If a name is none of ``FITTABLE``, or is given twice, or no value tried gives a steady motion.

    Notes
    -----
    The misfit jumps where the pattern of the motion changes. It is therefore minimised within each pattern,
    and the patterns are compared. An interval holds every value with which the record can be fitted, in any
    pattern, the other quantities refitted: the profile of the misfit.
    """
    for name in names:
        if name not in FITTABLE or list(names).count(name) > 1:
            raise InputError(
                f"--fit {','.join(names)}: {name!r} cannot be estimated, or is named twice",
                hint="choose from mu_s, mu_d, A and alpha",
            )
    problem = Problem(scene, observation.middle, names)
    minima = _first_minima(problem)
    for _ in range(_RESTARTS):
        minima = _weighed_minima(problem, minima)
        best = minima[0]
        freedom = max(problem.count - len(names) - 1.0, 1.0)
        threshold = float(stdtrit(freedom, 0.5 + 0.5 * _CONFIDENCE)) ** 2
        if any(m.label == "_" and m.squares <= best.squares + _REST for m in minima):
            best = next(m for m in minima if m.label == "_")
            parameters = [Parameter(n, v, (), False) for n, v in _values(problem, best).items()]
            minima = [best]
            break
        fitting = [m for m in minima if m.squares <= best.squares + threshold]
        profiles = [profile(problem, fitting, best.squares, threshold, i) for i in range(len(names))]
        parameters = [
            _parameter(problem, best, i, found.intervals) for i, found in enumerate(profiles)
        ]
        better = min((found.best for found in profiles), key=lambda m: m.squares)
        if better.squares > best.squares - 0.1 * threshold:
            minima = fitting
            break
        minima = _least(problem, [better, *minima])
    said = statements(problem, minima, parameters)
    return Fit(Scene(**problem.fixed | _values(problem, best)), tuple(parameters), tuple(said))


def _values(problem: Problem, minimum: Minimum) -> dict[str, float]:
    return dict(zip(problem.names, minimum.point.tolist(), strict=False))


def _parameter(
    problem: Problem, best: Minimum, column: int, intervals: tuple[tuple[float, float], ...]
) -> Parameter:
    value = float(best.point[column])
    (low, *_), (*_, high) = intervals[0], intervals[-1]
    least, most = problem.bounds[:, column]
    if low <= least * (1.0 + _AT_BOUND) or high >= most * (1.0 - _AT_BOUND):
        intervals = ()
    idle = not spread_of(problem, best)[column, column]
    identified = bool(intervals) and not idle and 0.5 * (high - low) <= _WIDE * abs(value)
    return Parameter(problem.names[column], value, intervals, identified)


def _first_minima(problem: Problem) -> list[Minimum]:
    """Descend from the most promising starts in each pattern; return the least misfit of each."""
    everything = list(range(len(problem.names) + 1))
    first = [
        descend(problem, label, point, everything, _ROUGH, _FIRST_STEPS) for label, point in starts(problem)
    ]
    if not first:
        raise InputError(
            "--fit: no value that was tried gives a steady motion to compare with",
            hint="check the other quantities of the scene",
        )
    times, plus = _HOPELESS
    limit = times * min(m.squares for m in first) + plus
    return _least(
        problem,
        [
            descend(problem, m.label, m.point, everything, _ROUGH) if m.squares <= limit else m
            for m in first
        ],
    )


def _least(problem: Problem, minima: Iterable[Minimum]) -> list[Minimum]:
    """Keep the least of each pattern, in the order of their misfits."""
    kept: dict[str, Minimum] = {}
    for minimum in sorted(minima, key=lambda m: m.squares):
        kept.setdefault(minimum.label, minimum)
    return list(kept.values())


def _weighed_minima(problem: Problem, minima: list[Minimum]) -> list[Minimum]:
    """Weight the signals by the misfit of the best pattern, and minimise that of all again."""
    everything = list(range(len(problem.names) + 1))
    for _ in range(_WEIGHINGS):
        best = minima[0]
        problem.weigh(best.point)
        best = descend(problem, best.label, best.point, everything, ENOUGH)
        limit = best.squares + _HOPELESS[1]
        others = [Minimum(m.label, m.point, float(problem.misfits(m.point[None]).squares()[0])) for m in minima[1:]]
        others += _neighbours(problem, best)
        minima = [best]
        for other in _least(problem, others):
            if other.squares <= limit:
                minima.append(descend(problem, other.label, other.point, everything, ENOUGH))
        minima = _least(problem, minima)
        if minima[0].squares >= best.squares - ENOUGH:
            break
    return minima


def _neighbours(problem: Problem, minimum: Minimum) -> list[Minimum]:
    """Points of other patterns beside a minimum, as far as the data could mistake it."""
    values, vectors = np.linalg.eigh(spread_of(problem, minimum))
    sizes = np.sqrt(np.maximum(values, 0.0))
    random = np.random.default_rng(1)
    draws = random.standard_normal((_NEIGHBOURS, values.size)) * np.linspace(0.0, _WIDEST, _NEIGHBOURS)[:, None]
    scale = np.maximum(np.abs(minimum.point), 0.1)
    moves = np.clip((draws * sizes) @ vectors.T, -0.3 * scale, 0.3 * scale)
    points = minimum.point + moves
    labels = problem.labels(points)
    found = []
    for label in set(labels.tolist()) - {""}:
        cells = np.flatnonzero(labels == label)[:_KEPT]
        squares = problem.misfits(points[cells]).squares(label)
        place = int(np.argmin(squares))
        found.append(Minimum(label, points[cells[place]], float(squares[place])))
    return found
