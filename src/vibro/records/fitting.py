"""Estimates of a scene's friction and drive from a record, and what cannot be estimated."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import product
from typing import TYPE_CHECKING, Final

import numpy as np
from scipy.special import stdtrit

from vibro.errors import InputError, cut, shown
from vibro.quantities import AMPLITUDES, QUANTITIES
from vibro.records.alignment import check_scene
from vibro.records.cycles import HOPS
from vibro.records.descent import Minimum, descend, to_edge
from vibro.records.intervals import ENOUGH, profile, spread_of
from vibro.records.misfits import FITTABLE, Problem, fittable
from vibro.records.starts import starts
from vibro.records.statements import groups, statements
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
_EXPLAINED: Final = 1.5  # sum of squares over the number of samples, in variances of the noise
_BETTER: Final = 0.1  # of the threshold: a point this much better than the best is a new start
_WEIGHINGS: Final = 3
_NEIGHBOURS: Final = 400  # points around a minimum at which other patterns are looked for
_WIDEST: Final = 4.0  # standard deviations: how far these reach,
_FARTHEST: Final = 0.3  # and how far in any case, relative
_ACROSS: Final = np.geomspace(1e-5, 0.3, 40)  # relative distances beyond an edge, for the same
_KEPT: Final = 24  # of both, of each pattern
_RESTARTS: Final = 3  # from a better point than the search had found
_CONFIDENCE: Final = 0.95
# A motion must fit this much better than rest to be one, in variances: 5 sigma.
_STANDS_OUT: Final = 25.0
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
        time and the sensors' offsets and drifts are fitted too. Of long records the middle is used. A phase
        is the one next to the scene's of those that differ by whole turns.

    Raises
    ------
    InputError
        If a name is none of ``FITTABLE``, or none of the scene's drive, or is given twice; if an amplitude to
        be estimated is 0; or if no value tried gives a steady motion.

    Notes
    -----
    The misfit jumps where the pattern of the motion changes. It is therefore minimised within each pattern,
    and the patterns are compared. An interval holds every value with which the record can be fitted, in any
    pattern, the other quantities refitted: the profile of the misfit.
    """
    check_scene(scene)
    _check_names(scene, names)
    problem = Problem(scene, observation.middle, names)
    minima = _first_minima(problem)
    rest = next((m for m in minima if m.label == "_" and m.squares <= minima[0].squares + _STANDS_OUT), None)
    if rest is not None:
        return _told(problem, [rest], [()] * len(names), 0.0)
    for _ in range(_RESTARTS):
        minima = _in_one_turn(problem, _weighed_minima(problem, minima))
        threshold = float(stdtrit(max(problem.count, 2.0), 0.5 + 0.5 * _CONFIDENCE)) ** 2
        fitting = [m for m in minima if m.squares <= minima[0].squares + _EXCLUDED]
        profiles = [profile(problem, fitting, threshold, column) for column in range(len(names))]
        better = min((found.best for found in profiles), key=lambda m: m.squares)
        if better.squares > minima[0].squares - _BETTER * threshold:
            break
        minima = _least(problem, [better, *minima])
    return _told(problem, fitting, [p.intervals for p in profiles], threshold)


def _check_names(scene: Scene, names: Sequence[str]) -> None:
    """Refuse what the scene has not, and what a search cannot begin from."""
    own = fittable(scene)
    choice = f"choose from {', '.join(QUANTITIES[name].letter for name in own)}"
    for name in names:
        said = f"--fit {cut(','.join(names))}: "
        if name not in FITTABLE or list(names).count(name) > 1:
            raise InputError(f"{said}{shown(name)} cannot be estimated, or is named twice", hint=choice)
        quantity = QUANTITIES[name]
        if name not in own:
            path = "a line" if scene.amplitude is not None else "an ellipse"
            raise InputError(
                f"{said}the trough moves along {path}, which has no {quantity.label}", hint=choice
            )
        if name in AMPLITUDES and not float(getattr(scene, name)):
            raise InputError(
                f"{said}the search for the {quantity.label} begins at the scene's, which is 0",
                hint=f"give what it may be, for example {quantity.options[0]} 0.3",
            )


def _in_one_turn(problem: Problem, minima: list[Minimum]) -> list[Minimum]:
    """Move phases by whole turns: of the least misfit next to the scene's, of the others next to that."""
    near = problem.unwound(minima[0].point, problem.own)[:-1]
    return [m._replace(point=problem.unwound(m.point, near)) for m in minima]


def _all(problem: Problem) -> list[int]:
    """Coordinates of a point: the quantities and the shift."""
    return list(range(len(problem.names) + 1))


def _told(problem: Problem, fitting: list[Minimum], intervals: list[Intervals], threshold: float) -> Fit:
    """Choose the best pattern of those that fit, and judge each quantity."""
    spreads = [spread_of(problem, minimum) for minimum in fitting]
    # A pattern in which fewer quantities act needs fewer to be adjusted: each takes 2 off, as in Akaike's
    # criterion. Else one that ends where another begins would be pinned there by the noise.
    costs = [m.squares + 2.0 * np.count_nonzero(s.diagonal()) for m, s in zip(fitting, spreads, strict=True)]
    order = np.argsort(costs)
    fitting, spreads = [fitting[i] for i in order], [spreads[i] for i in order]
    best, least = fitting[0], min(m.squares for m in fitting)
    sizes = problem.scale(best.point)
    # A valley that bends cannot be followed to where the misfit ends it: no interval of what lies along it.
    mixed = [group for group in groups(problem, best) if len(group) > 1] if problem.bends else []
    parameters = []
    for column, (name, found) in enumerate(zip(problem.names, intervals, strict=True)):
        value = float(best.point[column])
        bounded = _bounded(found, *problem.bounds[:, column])
        known = not any(name in group for group in mixed)
        parameter = Parameter(name, value, bounded if known else (), False)
        acts = all(
            spread[column, column] > 0.0
            for minimum, spread in zip(fitting, spreads, strict=True)
            if minimum.squares <= least + threshold
        )
        if acts and parameter.intervals and 0.5 * (parameter.high - parameter.low) <= _WIDE * sizes[column]:
            parameter = replace(parameter, identified=True)
        parameters.append(parameter)
    estimates = {p.name: p.value for p in parameters}
    said = statements(problem, fitting, parameters)
    return Fit(Scene(**problem.fixed | estimates), tuple(parameters), tuple(said))


def _bounded(intervals: Intervals, least: float, most: float) -> Intervals:
    """Drop intervals that reach what is tried: they have no end."""
    if (
        intervals
        and intervals[0][0] > least + _AT_BOUND * abs(least)
        and intervals[-1][1] < most - _AT_BOUND * abs(most)
    ):
        return intervals
    return ()


def _first_minima(problem: Problem) -> list[Minimum]:
    """Descend from the most promising starts in each pattern; return the least misfit of each.

    A scene that hops takes as long as a hundred others. A record that is explained to its noise without one
    needs none.
    """
    minima: list[Minimum] = []
    for hops in (False, True):
        aim = min((m.squares for m in minima), default=math.inf)
        if aim > _EXPLAINED * problem.count:
            for label, point in starts(problem, hops=hops):
                minima.append(descend(problem, label, point, _all(problem), _ROUGH, aim))
                aim = min(aim, minima[-1].squares)
    if not minima:
        raise InputError(
            "--fit: no value that was tried gives a steady motion to compare with",
            hint="check the other quantities of the scene",
        )
    return _least(problem, minima)


def _least(problem: Problem, minima: Iterable[Minimum]) -> list[Minimum]:
    """Keep the least of each pattern, and of each side of its phases, in the order of their misfits."""
    kept: dict[tuple[str, tuple[bool, ...]], Minimum] = {}
    for minimum in sorted(minima, key=lambda m: m.squares):
        kept.setdefault((minimum.label, problem.sides(minimum.point)), minimum)
    return list(kept.values())


def _weighed_minima(problem: Problem, minima: list[Minimum]) -> list[Minimum]:
    """Weight the signals by the misfit of the best pattern, and minimise that of all again."""
    for _ in range(_WEIGHINGS):
        problem.weigh(minima[0].point)
        best = descend(problem, minima[0].label, minima[0].point, _all(problem), ENOUGH)
        others = [descend(problem, m.label, m.point, [], ENOUGH) for m in minima[1:]]  # their misfits alone
        found = [best]
        for other in _least(problem, [*others, *_neighbours(problem, best)]):
            found.append(
                descend(problem, other.label, other.point, _all(problem), ENOUGH, best.squares + _EXCLUDED)
            )
        minima = _least(problem, found)
        if minima[0].squares >= best.squares - ENOUGH:
            break
    return minima


def _neighbours(problem: Problem, minimum: Minimum) -> list[Minimum]:
    """Points of other patterns: as far as the data could mistake the minimum, and across its edges."""
    values, vectors = np.linalg.eigh(spread_of(problem, minimum))
    size, scale = values.size, problem.scale(minimum.point)
    reach = np.linspace(0.0, _WIDEST, _NEIGHBOURS)[:, None] * np.sqrt(np.maximum(values, 0.0))
    random = np.random.default_rng(1).standard_normal((_NEIGHBOURS, size))
    cloud = np.clip((random * reach) @ vectors.T, -_FARTHEST * scale, _FARTHEST * scale)
    parts = [minimum.point + cloud]
    for column, way in product(range(size - 1), (1.0, -1.0)):
        across = way * scale[column]
        edge = to_edge(problem, minimum.label, minimum.point[None], column, across)
        parts.append(edge + np.outer(_ACROSS * across, np.eye(size)[column]))
    points = np.concatenate(parts)
    labels = problem.labels(points)
    found = []
    # Scenes that hop take too long for a guess: they are starts of the search alone.
    for label in set(labels.tolist()) - {"", HOPS}:
        cells = np.flatnonzero(labels == label)
        cells = np.concatenate([cells[:_KEPT], cells[cells >= _NEIGHBOURS][:_KEPT]])
        squares = problem.misfits(label, points[cells]).squares
        place = int(np.argmin(squares))
        found.append(Minimum(label, points[cells[place]], float(squares[place])))
    return found
