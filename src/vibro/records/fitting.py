"""Estimates of a scene's friction, amplitude and drive angle from a record, and what cannot be estimated."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
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
    Intervals = tuple[tuple[float, float], ...]

__all__ = ["FITTABLE", "Fit", "Parameter", "fit"]

_ROUGH: Final = 1.0  # decrease of the sum of squares, in variances, below which a first descent ends
# A pattern is excluded that fits worse by this, in variances: 4 sigma. The values of another pattern may lie
# far away, so that excluding the true one at 2 sigma would be wrong by many half-widths once in 20 times.
_EXCLUDED: Final = 16.0
_BETTER: Final = 0.1  # of the threshold: a point this much better than the best is a new start
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
    rest = next((m for m in minima if m.label == "_" and m.squares <= minima[0].squares + _REST), None)
    if rest is not None:
        return _told(problem, [rest], [()] * len(names))
    for _ in range(_RESTARTS):
        minima = _weighed_minima(problem, minima)
        least = minima[0].squares
        threshold = float(stdtrit(max(problem.count, 2.0), 0.5 + 0.5 * _CONFIDENCE)) ** 2
        fitting = [m for m in minima if m.squares <= least + _EXCLUDED]
        profiles = [profile(problem, fitting, threshold, column) for column in range(len(names))]
        better = min((found.best for found in profiles), key=lambda m: m.squares)
        if better.squares > least - _BETTER * threshold:
            break
        minima = _least([better, *minima])
    return _told(problem, fitting, [found.intervals for found in profiles])


def _told(problem: Problem, fitting: list[Minimum], intervals: list[Intervals]) -> Fit:
    """Choose the best pattern of those that fit, and judge each quantity."""
    spreads = [spread_of(problem, minimum) for minimum in fitting]
    # A pattern in which fewer quantities act needs fewer to be adjusted: each takes 2 off, as in Akaike's
    # criterion. Else one that ends where another begins would be pinned there by the noise.
    costs = [m.squares + 2.0 * np.count_nonzero(s.diagonal()) for m, s in zip(fitting, spreads, strict=True)]
    best = fitting.pop(int(np.argmin(costs)))
    fitting.insert(0, best)
    parameters = []
    for column, (name, found) in enumerate(zip(problem.names, intervals, strict=True)):
        value = float(best.point[column])
        parameter = Parameter(name, value, _bounded(found, *problem.bounds[:, column]), False)
        acts = all(spread[column, column] > 0.0 for spread in spreads)
        if acts and 0.5 * (parameter.high - parameter.low) <= _WIDE * abs(value):
            parameter = replace(parameter, identified=True)
        parameters.append(parameter)
    estimates = {p.name: p.value for p in parameters}
    said = statements(problem, fitting, parameters)
    return Fit(Scene(**problem.fixed | estimates), tuple(parameters), tuple(said))


def _bounded(intervals: Intervals, least: float, most: float) -> Intervals:
    """Drop intervals that reach what is tried: they have no end."""
    if intervals and intervals[0][0] > least * (1.0 + _AT_BOUND) and intervals[-1][1] < most * (1.0 - _AT_BOUND):
        return intervals
    return ()


def _first_minima(problem: Problem) -> list[Minimum]:
    """Descend from the most promising starts in each pattern; return the least misfit of each."""
    everything = list(range(len(problem.names) + 1))
    minima: list[Minimum] = []
    for label, point in starts(problem):
        aim = min((m.squares for m in minima), default=math.inf)
        minima.append(descend(problem, label, point, everything, _ROUGH, aim))
    if not minima:
        raise InputError(
            "--fit: no value that was tried gives a steady motion to compare with",
            hint="check the other quantities of the scene",
        )
    return _least(minima)


def _least(minima: Iterable[Minimum]) -> list[Minimum]:
    """Keep the least of each pattern, in the order of their misfits."""
    kept: dict[str, Minimum] = {}
    for minimum in sorted(minima, key=lambda m: m.squares):
        kept.setdefault(minimum.label, minimum)
    return list(kept.values())


def _weighed_minima(problem: Problem, minima: list[Minimum]) -> list[Minimum]:
    """Weight the signals by the misfit of the best pattern, and minimise that of all again."""
    everything = list(range(len(problem.names) + 1))
    for _ in range(_WEIGHINGS):
        problem.weigh(minima[0].point)
        best = descend(problem, minima[0].label, minima[0].point, everything, ENOUGH)
        squares = problem.misfits(np.array([m.point for m in minima[1:]])).squares() if minima[1:] else []
        others = [m._replace(squares=float(s)) for m, s in zip(minima[1:], squares, strict=True)]
        found = [best]
        for other in _least([*others, *_neighbours(problem, best)]):
            found.append(descend(problem, other.label, other.point, everything, ENOUGH, best.squares + _EXCLUDED))
        minima = _least(found)
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
