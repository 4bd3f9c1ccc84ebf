"""Estimates of a scene's friction and drive from a record, with confidence intervals."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import product
from operator import itemgetter
from typing import TYPE_CHECKING, Final, NamedTuple, TypeVar

import numpy as np
from scipy.optimize import least_squares
from scipy.special import stdtrit

from vibro.errors import InputError, cut, shown
from vibro.motion.settled import settled_motion
from vibro.quantities import AMPLITUDES, QUANTITIES
from vibro.records.alignment import Observation, check_scene
from vibro.records.problem import FITTABLE, HOPS, Problem, fittable, starts
from vibro.records.reading import TOL
from vibro.scene import Scene

if TYPE_CHECKING:
    from vibro.reals import Floats
    from vibro.records.drive_errors import DriveError
    from vibro.records.sensors import SensorErrors

    _Move = Callable[[Floats], Floats]

# ------------------------------------------------------------------------------
# The least misfit of one pattern, by least squares within it, and along its edge.
#
# A slide begins with a finite length where its load passes static friction: the misfit jumps from pattern to
# pattern, and its least value may lie on the edge of one, where no derivative vanishes. Inside a pattern the
# motion is smooth. A search that an edge stops goes on along it: one coordinate follows the edge, and the
# others move.

_DISTANCES: Final = np.outer((1.0, -1.0), np.geomspace(*TOL.distances)).ravel()


class Minimum(NamedTuple):
    """A point of least misfit within a pattern, and its sum of squares."""

    label: str
    point: Floats
    squares: float


def _squares(minimum: Minimum) -> float:
    return minimum.squares


def minimise(
    problem: Problem, start: Minimum, enough: float, aim: float = np.inf, fixed: Sequence[int] = ()
) -> Minimum:
    """Minimise the misfit within a pattern.

    Parameters
    ----------
    problem : Problem
        The residuals.
    start : Minimum
        First point; it is returned if it lies outside its pattern, with a sum of squares of inf.
    enough : float
        Decrease of the sum of squares of a record that is explained to its noise below which the search ends.
    aim : float
        Sum of squares that is of use: no edge is followed that cannot lead there.
    fixed : sequence of int
        Coordinates that keep their values.
    """
    best, free = start, [i for i in range(start.point.size) if i not in fixed]
    for _ in range(TOL.edges if np.isfinite(start.squares) else 0):
        best = _searched(problem, best, free, enough)
        along = _along_an_edge(problem, best, free, enough, aim)
        gain = best.squares - along.squares
        best = along
        if gain <= enough:
            break
    return best


def _searched(
    problem: Problem, start: Minimum, free: list[int], enough: float, move: _Move = np.copy
) -> Minimum:
    """Return the least squares of the free coordinates, by the method of Levenberg and Marquardt.

    ``move`` moves each point before, for example to an edge. Outside the pattern residuals are so large that
    the search shortens its step.
    """

    def placed(values: Floats) -> Floats:
        point = start.point.copy()
        point[free] = values
        return point

    def residuals(values: Floats) -> Floats:
        (inside,), (found,) = problem.residuals(start.label, move(placed(values)[None]))
        return found if inside else np.full_like(found, TOL.outside)

    def jacobian(values: Floats) -> Floats:
        return _linear(problem, start._replace(point=placed(values)), free, move)[1]

    found = least_squares(
        residuals,
        start.point[free],
        jacobian,
        method="lm",
        x_scale="jac",
        ftol=max(enough / problem.count, TOL.rounding),
        xtol=TOL.step,
        max_nfev=TOL.most_steps if move is np.copy else TOL.steps_along_edge,
    )
    return min(start, best_of(problem, start.label, move(placed(found.x)[None])), key=_squares)


def _along_an_edge(problem: Problem, at: Minimum, free: list[int], enough: float, aim: float) -> Minimum:
    """Search along the edge that stops a search, if one does; return the better point.

    The coordinate that has the edge nearest to it follows the edge.
    """
    residual, jacobian = _linear(problem, at, free)
    steps = -_covariance(jacobian) @ (jacobian.T @ residual)
    ahead = at.point.copy()
    ahead[free] += steps
    least = float(np.square(residual + jacobian @ steps).sum())
    if least > min(at.squares - enough, aim) or problem.labels(ahead[None])[0] == at.label:
        return at
    edges = []
    for follower, step in zip(free, steps.tolist(), strict=True):
        if follower == at.point.size - 1 or not step:
            continue
        most = float(problem.scale(at.point)[follower])
        small = math.copysign(TOL.edge_step * most, step)
        reach = math.copysign(min(max(2.0 * abs(step), abs(small)), most), step)
        to_edge = partial(move_to_edge, problem, at.label, follower=follower, reach=reach)
        beyond = to_edge(at.point[None])
        distance = abs(float(beyond[0, follower] - at.point[follower])) / most
        beyond[0, follower] += small
        if problem.labels(beyond)[0] != at.label:
            edges.append((distance, follower, to_edge))
    if not edges:
        return at
    _, follower, to_edge = min(edges, key=itemgetter(0))
    along = _searched(problem, at, [f for f in free if f != follower], enough, to_edge)
    return min(at, along, key=_squares)


def best_of(problem: Problem, label: str, points: Floats) -> Minimum:
    """Return the point of least misfit; its sum of squares is inf if no point lies in the pattern."""
    squares = problem.residuals(label, points).squares
    place = int(np.argmin(squares))
    return Minimum(label, points[place], float(squares[place]))


def jacobian_at(problem: Problem, minimum: Minimum) -> Floats:
    """Return the Jacobian of the residuals, (K, P + 1); 0 for coordinates without an effect."""
    return _linear(problem, minimum, list(range(minimum.point.size)))[1]


def error_covariance(problem: Problem, minimum: Minimum) -> Floats:
    """Return the covariance of the coordinates at a minimum, within its pattern, shape (P + 1, P + 1).

    Rows and columns of coordinates without an effect are 0.
    """
    return _covariance(jacobian_at(problem, minimum))


def _covariance(jacobian: Floats) -> Floats:
    """Return the inverse of the normal equations; 0 for columns of 0."""
    sizes = np.linalg.norm(jacobian, axis=0)
    sizes = np.where(sizes > 0.0, sizes, np.inf)
    normed = jacobian / sizes
    inverse = np.linalg.pinv(normed.T @ normed, rcond=1e-12, hermitian=True)
    return np.asarray(inverse / np.outer(sizes, sizes))


def nearest_inside(problem: Problem, label: str, point: Floats, movable: Sequence[int]) -> Minimum | None:
    """Move one coordinate of a point to the nearest value inside the pattern.

    Of the coordinates in ``movable`` the one that gives the least misfit moves. Returns None if none leads
    into the pattern.
    """
    if problem.labels(point[None])[0] == label:
        return best_of(problem, label, point[None])
    found = []
    for coordinate in movable:
        points = np.repeat(point[None], _DISTANCES.size, axis=0)
        points[:, coordinate] += _DISTANCES * problem.scale(point)[coordinate]
        inside = problem.labels(points) == label
        if inside.any():
            found.append(points[np.argmin(np.where(inside, np.abs(_DISTANCES), np.inf))])
    return best_of(problem, label, np.array(found)) if found else None


def move_to_edge(problem: Problem, label: str, points: Floats, follower: int, reach: float) -> Floats:
    """Move one coordinate of each point to just inside the nearest edge of the pattern.

    Parameters
    ----------
    problem, label : Problem, str
        The residuals, and the pattern.
    points : array, shape (M, P + 1)
        Points without an edge within ``reach``, to either side, keep their place.
    follower : int
        The coordinate.
    reach : float
        Largest distance; positive for an edge at greater values of the coordinate, negative at smaller ones.
    """
    low, high = np.full(points.shape[0], -reach), np.full(points.shape[0], reach)
    rows, found = np.arange(points.shape[0]), np.ones(points.shape[0], np.bool_)
    for turn in range(TOL.edge_rounds):
        shares = np.linspace(0.0, 1.0, TOL.edge_places[turn > 0])
        places = low[:, None] + (high - low)[:, None] * shares
        trials = np.repeat(points, shares.size, axis=0)
        trials[:, follower] += places.ravel()
        inside = (problem.labels(trials) == label).reshape(places.shape)
        leaves = inside[:, :-1] & ~inside[:, 1:]
        if not turn:
            found = leaves.any(axis=1)
        column = np.argmin(np.where(leaves, np.abs(places[:, :-1]), np.inf), axis=1)
        low, high = places[rows, column], places[rows, column + 1]
        if float(np.abs(high - low).max()) < TOL.step * float(problem.scale(points[0])[follower]):
            break
    moved = points.copy()
    moved[found, follower] += low[found]
    return moved


def _linear(problem: Problem, at: Minimum, free: list[int], move: _Move = np.copy) -> tuple[Floats, Floats]:
    """Return residuals, (K,), and their Jacobian, (K, free): one-sided at an edge, 0 in a corner.

    ``move`` moves the points before, for example to an edge.
    """
    sizes = (TOL.step if move is np.copy else TOL.edge_step) * problem.scale(at.point)[free]
    moved = np.zeros((len(free), at.point.size))
    moved[range(len(free)), free] = sizes
    points = move(np.concatenate([at.point[None], at.point + moved, at.point - moved]))
    inside, values = problem.residuals(at.label, points)
    ahead, behind = inside[1:].reshape(2, -1)
    upper, lower = values[1:].reshape(2, len(free), -1)
    change = np.where(ahead[:, None], upper, values[0]) - np.where(behind[:, None], lower, values[0])
    jacobian = (change / (sizes * np.maximum(ahead.astype(float) + behind, 1.0))[:, None]).T
    effects = np.linalg.norm(jacobian, axis=0) * sizes
    jacobian[:, effects < TOL.idle * effects.max(initial=0.0)] = 0.0
    return values[0], jacobian


_Intervals = tuple[tuple[float, float], ...]
_Groups = list[tuple[str, ...]]
_T = TypeVar("_T")


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
        Confidence intervals at 95 %, ascending and disjoint [SI]; they cover noise, misfit and the errors of
        the drive and the sensors, not what the model leaves out. More than one if patterns fit that are apart
        from each other. Empty if the data do not bound the quantity.
    identified : bool
        Whether the data determine a value; else at most a range is known.
    narrower : mapping of str to float
        By which share the interval would be narrower without each error of the drive and of the sensors, by
        the names of ``DriveError``; within the pattern of the best fit [1].
    """

    name: str
    value: float
    intervals: _Intervals
    identified: bool
    narrower: Mapping[str, float] = field(default_factory=dict)

    @property
    def low(self) -> float:
        """Lower end of all intervals; NaN without one [SI]."""
        return self.intervals[0][0] if self.intervals else math.nan

    @property
    def high(self) -> float:
        """Upper end of all intervals; NaN without one [SI]."""
        return self.intervals[-1][1] if self.intervals else math.nan


@dataclass(frozen=True, eq=False)
class Fit:
    """Estimates of quantities of a scene, with explanations.

    Attributes
    ----------
    scene : Scene
        The scene with the estimates, and with the drive that fits best within its errors.
    parameters : tuple of Parameter
        The estimates, in the order of the names.
    statements : tuple of str
        Sentences: which feature of the motion gives each estimate, which quantities the data cannot identify,
        and why; the doubts are the last ones.
    doubts : tuple of str
        Why intervals may miss the truth.
    """

    scene: Scene
    parameters: tuple[Parameter, ...]
    statements: tuple[str, ...]
    doubts: tuple[str, ...] = ()


class _Work:
    """Counts and reports the searches of a fit; their number grows as patterns are found."""

    def __init__(self, report: Callable[[int, int, str], None] | None) -> None:
        self._report, self._done, self._all = report, 0, 0

    def each(self, things: Iterable[_T], what: str) -> Iterator[_T]:
        """Yield items one by one: each is a search, which is done when the next one is requested."""
        waiting = list(things)
        self._all += len(waiting)
        for thing in waiting:
            if self._report:
                self._report(self._done, self._all, what)
            yield thing
            self._done += 1


def fit(
    scene: Scene,
    observation: Observation,
    names: Sequence[str],
    drive: Sequence[DriveError] = (),
    sensors: SensorErrors | None = None,
    progress: Callable[[int, int, str], None] | None = None,
) -> Fit:
    """Estimate quantities of a scene from a record.

    Parameters
    ----------
    scene : Scene
        Scene of shape (); it gives the quantities that are not estimated, and one start of the search.
    observation : Observation
        The record.
    names : sequence of str
        Some of ``FITTABLE``.
    drive : sequence of DriveError
        Independent errors of the drive, within which it is fitted too.
    sensors : SensorErrors, optional
        Errors of the sensors on the body; without them these are exact.
    progress : callable, optional
        Called before each search with the number of those that are done, of those that are known to be
        needed, and what is searched.

    Returns
    -------
    Fit
        Least squares over all signals, each weighted by the inverse of its own residuals; the unknown trigger
        time and the offsets and drifts of the sensors are fitted too. Of long records the middle is used.
        Phases are within half a turn of the scene's.

    Raises
    ------
    InputError
        If a name is not in ``FITTABLE``, is no quantity of the scene's drive, or is given twice; if an
        amplitude to be estimated is 0; or if no value that is tried gives a steady motion.

    Notes
    -----
    The misfit jumps where the pattern of the motion changes. It is therefore minimised within each pattern,
    and the patterns are compared. Intervals come from the profile of the misfit: they hold every value with
    which the record can be fitted, in any pattern, after the other quantities are fitted again, and
    with them the drive within the errors of its measurement.
    """
    check_scene(scene)
    check_names(scene, names)
    problem, work = Problem(scene, observation.middle, names, drive, sensors), _Work(progress)
    minima = _first_minima(problem, work)
    worst = minima[0].squares + TOL.stands_out
    rest = next((m for m in minima if m.label == "_" and m.squares <= worst), None)
    if rest is not None:
        return _judged(problem, [rest], [()] * len(names), 0.0)
    for _ in range(TOL.restarts):
        minima = _weighed_minima(problem, minima, work)
        # Move phases by whole turns: of the least misfit next to the scene's, of the others next to that.
        near = problem.unwound(minima[0].point, problem.own)[:-1]
        minima = [m._replace(point=problem.unwound(m.point, near)) for m in minima]
        threshold = float(stdtrit(max(problem.count, 2.0), 0.5 + 0.5 * TOL.confidence)) ** 2
        fitting = [m for m in minima if m.squares <= minima[0].squares + TOL.excluded]
        columns = work.each(range(len(names)), "intervals")
        profiles = [_profile(problem, fitting, threshold, column) for column in columns]
        better = min((best for _, best in profiles), key=_squares)
        if better.squares > minima[0].squares - TOL.better * threshold:
            break
        minima = _least_of_each(problem, [better, *minima])
    return _judged(problem, fitting, [intervals for intervals, _ in profiles], threshold)


def check_names(scene: Scene, names: Sequence[str]) -> None:
    """Refuse quantities that the scene's drive lacks, and amplitudes of 0, from which no search can begin."""
    own = fittable(scene)
    choice = f"choose from {', '.join(QUANTITIES[name].letter for name in own)}"
    for name in names:
        fit_of = f"fit {cut(','.join(names))}: "
        if name not in FITTABLE or list(names).count(name) > 1:
            raise InputError(f"{fit_of}{shown(name)} cannot be estimated, or is named twice", hint=choice)
        quantity = QUANTITIES[name]
        if name not in own:
            none = f"{fit_of}the trough moves {scene.arrays().kind}, which has no {quantity.label}"
            raise InputError(none, hint=choice)
        if name in AMPLITUDES and not float(getattr(scene, name)):
            zero = f"{fit_of}the search for the {quantity.label} begins at the scene's, which is 0"
            raise InputError(zero, hint="give what it may be, such as 0.3mm")


def _judged(problem: Problem, fitting: list[Minimum], intervals: list[_Intervals], threshold: float) -> Fit:
    """Choose the best of the patterns that fit, and decide which quantities are identified."""
    acting = [error_covariance(problem, minimum).diagonal() > 0.0 for minimum in fitting]
    # A pattern in which more quantities act can follow the noise better: each costs 2, as in Akaike's
    # criterion. Otherwise the noise would choose a pattern at its edge over its neighbour.
    costs = [m.squares + 2.0 * np.count_nonzero(acts) for m, acts in zip(fitting, acting, strict=True)]
    within = [m.squares <= min(map(_squares, fitting)) + threshold for m in fitting]
    acts = np.all([a for a, counts in zip(acting, within, strict=True) if counts], axis=0)
    fitting = [fitting[i] for i in np.argsort(costs)]
    best = fitting[0]
    sizes = problem.scale(best.point)
    # A curved valley of the misfit cannot be followed to its ends: quantities along it have no interval.
    groups = _groups(problem, best)
    mixed = {name for group in groups if len(group) > 1 for name in group} if problem.is_curved else set()
    narrower = _narrower(problem, best)
    parameters = []
    for column, (name, found) in enumerate(zip(problem.names[: problem.asked], intervals, strict=True)):
        bounded = () if name in mixed else _bounded(found, *problem.bounds[:, column])
        identified = bool(acts[column] and _half_width(bounded) <= TOL.wide * sizes[column])
        shares = {error: float(values[column]) for error, values in narrower.items()}
        parameters.append(Parameter(name, float(best.point[column]), bounded, identified, shares))
    fitted = Scene(**(problem.fixed | dict(zip(problem.names, best.point.tolist(), strict=False))))
    resting = "F" not in best.label and "B" not in best.label and best.label != HOPS
    doubts = () if resting else tuple(_misfits(problem, best))
    statements = _statements(problem, fitting, parameters, fitted, groups)
    return Fit(fitted, tuple(parameters), (*statements, *doubts), doubts)


def _bounded(intervals: _Intervals, least: float, most: float) -> _Intervals:
    """Return no interval if it reaches the bounds of the search: its end is unknown."""
    low, high = (bound + way * TOL.at_bound * abs(bound) for bound, way in ((least, 1.0), (most, -1.0)))
    return intervals if intervals and intervals[0][0] > low and intervals[-1][1] < high else ()


def _half_width(intervals: _Intervals) -> float:
    """Return half the length of the hull of intervals; inf without any."""
    return 0.5 * (intervals[-1][1] - intervals[0][0]) if intervals else math.inf


# --- the search -----------------------------------------------------------------------------------------


def _first_minima(problem: Problem, work: _Work) -> list[Minimum]:
    """Search from the best starts of each pattern; return the least misfit of each.

    A scene that hops takes as long as several others: they are tried only if no other explains the record
    to its noise.
    """
    minima: list[Minimum] = []
    aim = math.inf
    for hops in (False, True):
        if aim > TOL.explained * problem.count:
            for label, point in work.each(
                starts(problem, hops=hops), "patterns with hops" if hops else "patterns"
            ):
                start = best_of(problem, label, point[None])
                minima.append(minimise(problem, start, TOL.rough, aim))
                aim = min(aim, minima[-1].squares)
    if not minima:
        none = "no value that was tried gives a steady motion to compare with"
        raise InputError(none, hint="check the other quantities of the scene")
    return _least_of_each(problem, minima)


def _least_of_each(problem: Problem, minima: Iterable[Minimum]) -> list[Minimum]:
    """Keep the least minimum of each pattern and each sign of its phases, by ascending misfit."""
    kept: dict[tuple[str, tuple[bool, ...]], Minimum] = {}
    for minimum in sorted(minima, key=_squares):
        kept.setdefault((minimum.label, problem.sides(minimum.point)), minimum)
    return list(kept.values())


def _weighed_minima(problem: Problem, minima: list[Minimum], work: _Work) -> list[Minimum]:
    """Weight the signals by the residuals of the best pattern, and minimise all patterns again."""
    for _ in range(TOL.weighings):
        best = minima[0]
        for _ in range(TOL.weighings):
            problem.weigh(best.point)
            start = best_of(problem, best.label, best.point[None])
            best = minimise(problem, start, TOL.enough)
            # Far from the best point weights are too small, as of a misfit that it does not have.
            if best.squares > start.squares - TOL.rough:
                break
        others = [best_of(problem, m.label, m.point[None]) for m in minima[1:]]
        most = best.squares + TOL.excluded
        others = _least_of_each(problem, [*others, *_neighbours(problem, best)])
        found = [minimise(problem, m, TOL.enough, most) for m in work.each(others, "estimates")]
        minima = _least_of_each(problem, [best, *found])
        if minima[0].squares >= best.squares - TOL.enough:
            break
    return minima


def _neighbours(problem: Problem, minimum: Minimum) -> list[Minimum]:
    """Return the best points of other patterns: within the errors of a minimum, and across its edges."""
    values, vectors = np.linalg.eigh(error_covariance(problem, minimum))
    count, size, scale = TOL.neighbours, values.size, problem.scale(minimum.point)
    reach = np.linspace(0.0, TOL.widest, count)[:, None] * np.sqrt(np.maximum(values, 0.0))
    random = np.random.default_rng(1).standard_normal((count, size))
    farthest = TOL.farthest_neighbour * scale
    parts = [minimum.point + np.clip((random * reach) @ vectors.T, -farthest, farthest)]
    for column, way in product(range(size - 1), (1.0, -1.0)):
        across = way * scale[column]
        edge = move_to_edge(problem, minimum.label, minimum.point[None], column, across)
        parts.append(edge + np.outer(np.geomspace(*TOL.across) * across, np.eye(size)[column]))
    points = np.concatenate(parts)
    labels = problem.labels(points)
    found = []
    # Scenes that hop take too long: only the first search tries them.
    for label in sorted(set(labels.tolist()) - {"", HOPS}):
        cells = np.flatnonzero(labels == label)
        cells = np.concatenate([cells[: TOL.kept], cells[cells >= count][: TOL.kept]])
        found.append(best_of(problem, label, points[cells]))
    return found


# --- intervals of confidence ----------------------------------------------------------------------------


def _profile(
    problem: Problem, minima: Sequence[Minimum], threshold: float, column: int
) -> tuple[_Intervals, Minimum]:
    """Return the intervals of one quantity in which the record can be fitted, and the best point on the way.

    In each pattern the quantity is moved away from the minimum, and the others are fitted again, until the
    sum of squares exceeds that of the minimum by the threshold, or the pattern ends.

    Parameters
    ----------
    problem : Problem
        The residuals.
    minima : sequence of Minimum
        Minima of the patterns that fit, best first.
    threshold : float
        Increase of the sum of squares at the ends of an interval.
    column : int
        Place of the quantity among the coordinates.
    """
    pieces: list[tuple[float, float]] = []
    best = minima[0]
    for minimum in minima:
        covariance = error_covariance(problem, minimum)
        value, variance = float(minimum.point[column]), float(covariance[column, column])
        if minimum.label == HOPS:
            # A point takes up to a tenth of a second: use the curvature at the minimum for the profile.
            half = math.sqrt(threshold * variance) or math.inf
            pieces.append((value - half, value + half))
            continue
        path = covariance[:, column] / variance if variance else np.zeros(minimum.point.size)
        size = float(problem.scale(minimum.point)[column])
        step = TOL.first_step * size
        if variance:
            step = min(max(math.sqrt(variance * threshold), TOL.rounding * size), TOL.most_step * size)
        ends = []
        for way in (-step, step):
            end, met = _end(problem, minimum, path, threshold, column, way)
            ends.append(end)
            best = min(best, met, key=_squares)
        pieces.append((ends[0], ends[1]))
    return merged(pieces), best


def merged(pieces: list[tuple[float, float]]) -> _Intervals:
    """Unite intervals that overlap, or nearly do."""
    pieces = sorted(pieces)
    hull = max(high for _, high in pieces) - pieces[0][0]
    merged = pieces[:1]
    for low, high in pieces[1:]:
        if low - merged[-1][1] <= TOL.apart * hull:
            merged[-1] = (merged[-1][0], max(high, merged[-1][1]))
        else:
            merged.append((low, high))
    return tuple(merged)


def _end(
    problem: Problem, minimum: Minimum, path: Floats, threshold: float, column: int, step: float
) -> tuple[float, Minimum]:
    """Return the end of an interval on one side, infinite if there is none, and the best point on the way.

    ``path`` is the derivative of the coordinates by the quantity along the valley; ``step`` is the first
    step, with the sign of the side.
    """
    origin, aim = float(minimum.point[column]), math.sqrt(threshold)
    value, way = origin, math.copysign(1.0, step)
    inside, root, best = minimum, 0.0, minimum
    outside, far = math.inf, math.inf  # the nearest value that does not fit, and the root of its increase
    for _ in range(TOL.tries):
        near = float(inside.point[column])
        if math.isinf(outside):
            value = near + step
            step *= 2.0
        elif abs(outside - near) <= TOL.narrow * abs(outside - origin):
            break
        else:
            share = min(max((aim - root) / (far - root), 0.05), 0.95) if math.isfinite(far) else 0.5
            value = near + share * (outside - near)
        found = _refitted(problem, inside, path, column, value)
        best = min(best, found, key=_squares)
        # Root of the increase of the sum of squares; inf if the pattern has no such value.
        tried = math.sqrt(max(found.squares - minimum.squares, 0.0))
        if abs(tried**2 - threshold) <= TOL.close * threshold:
            return value, best
        if tried >= aim:
            outside, far = value, tried
            continue
        inside, root = found, tried
        if math.isinf(outside) and root > 0.0:
            # Extrapolate a misfit that grows with the square of the distance.
            step = way * min(max(aim / root - 1.0, 0.1), 2.0) * abs(value - origin)
    return way * outside if math.isinf(outside) else outside, best


def _refitted(problem: Problem, near: Minimum, path: Floats, column: int, value: float) -> Minimum:
    """Set a quantity to a value, and fit the others again; inf if the pattern has no such value.

    The others begin on the tangent of the valley at the minimum; if the pattern cannot be reached from there,
    where they were.
    """
    movable = [place for place in range(near.point.size - 1) if place != column]
    for slopes in (path, np.zeros(path.size)):
        start = near.point + slopes * (value - near.point[column])
        start[column] = value
        begun = nearest_inside(problem, near.label, start, movable)
        if begun is not None:
            return minimise(problem, begun, TOL.enough, fixed=[column])
    return Minimum(near.label, start, math.inf)


def _narrower(problem: Problem, best: Minimum) -> dict[str, Floats]:
    """Return by which share intervals would be narrower without each error, by linear theory."""
    if not problem.effects.size:
        return {}
    jacobian, first = jacobian_at(problem.without_errors(), best), problem.asked
    design = np.hstack(
        [jacobian[:, :first], jacobian[:, -1:], jacobian[:, first:-1] @ problem.steps, problem.effects]
    )
    names = np.array([""] * (first + 1) + problem.errors)
    costs = np.diag((names != "").astype(float))
    sizes = {}
    for name in dict.fromkeys(names.tolist()):
        kept = (names != name) | (names == "")
        covariance = _covariance(np.vstack([design, costs])[:, kept])
        sizes[name] = np.sqrt(covariance.diagonal()[:first])
    whole = sizes.pop("")
    return {
        name: np.where(whole > 0.0, 1.0 - size / np.maximum(whole, 1e-300), 0.0)
        for name, size in sizes.items()
    }


# --- in words -------------------------------------------------------------------------------------------


def _statements(
    problem: Problem, minima: list[Minimum], parameters: list[Parameter], fitted: Scene, groups: _Groups
) -> list[str]:
    """Say what determines the estimates, which quantities cannot be identified, and which are at a limit."""
    best = minima[0]
    pattern = settled_motion(fitted).pattern if best.label == HOPS else best.label
    lost = {p.name: p for p in parameters if not p.identified}
    if "F" not in pattern and "B" not in pattern:
        letters = ", ".join(QUANTITIES[name].letter for name in lost)
        return [f"the fitted body rests: the data cannot identify {letters}"] if letters else []
    found = []
    static, kinetic = (p in problem.names and p not in lost for p in ("static_friction", "kinetic_friction"))
    if "_" in pattern and (static or kinetic):
        start = "mu_s sets the start of a slide" if static else ""
        end = f"mu_d {'its end' if static else 'sets the end of a slide'}" if kinetic else ""
        found.append(f"pattern {pattern}: {' and '.join(filter(None, (start, end)))}")
    if best.label == HOPS:
        found.append("the body hops: intervals come from the curvature of the misfit, within its pattern")
    if any(len(p.intervals) > 1 for p in parameters):
        labels = dict.fromkeys(m.label for m in minima)
        several = f"patterns {' and '.join(labels)}" if len(labels) > 1 else "phases to both sides of 0"
        found.append(f"{several} fit: an interval in pieces holds the values of each")
    found += _unidentified(pattern, lost, groups)
    return found + _limits(problem, pattern, parameters, fitted)


def _misfits(problem: Problem, best: Minimum) -> list[str]:
    """Say what the best motion does not explain."""
    found = []
    if best.label != HOPS and (signals := problem.unexplained(best.label, best.point)):
        which = f"{', '.join(signals)}: a misfit repeats in every cycle, and no value explains it"
        causes = "a low-pass filter that is not stated"
        causes += "" if problem.observation.absolute else ", data over the ground"
        found.append(f"{which}; the intervals may miss the truth: {causes}, or another law of friction")
    most = float(np.abs(problem.pulled(best.point)).max(initial=0.0))
    if most > TOL.likely_sigmas:
        off = f"the record fits best {most:.2g} standard errors from the drive that is measured or stated"
        found.append(f"{off}: the intervals may miss the truth")
    return found


def _unidentified(pattern: str, lost: Mapping[str, Parameter], groups: _Groups) -> list[str]:
    """Say why quantities have no estimate."""
    found = []
    left = set(lost)
    for group in groups:
        if left.isdisjoint(group):
            continue
        left.difference_update(group)
        *first, last = (QUANTITIES[name].letter for name in group)
        symbols = f"{', '.join(first)} and {last}" if first else last
        if group == ("static_friction",) and "_" not in pattern:
            why = f"in pattern {pattern} the body never rests, and mu_s has no effect at all"
            found.append(f"the data cannot identify mu_s: {why}")
        elif first:
            found.append(f"the data cannot tell {symbols} apart: their effects cancel; give one of them")
        else:
            found.append(f"the data cannot identify {symbols}: its effect is smaller than the misfit")
    for name in sorted(left):
        wide = lost[name].intervals
        why = "a wide range of values fits" if wide else "the search found no end of its interval"
        found.append(f"the data cannot identify {QUANTITIES[name].letter}: {why}")
    return found


def _groups(problem: Problem, best: Minimum) -> _Groups:
    """Return combinations of quantities that the data do not determine.

    They are singular vectors of the relative sensitivities, after the effects of the trigger time and of the
    drive's errors are projected out.
    """
    jacobian = jacobian_at(problem, best)
    free, others = jacobian[:, : problem.asked], jacobian[:, problem.asked :]
    free = free - others @ (_covariance(others) @ (others.T @ free))
    sizes = problem.scale(best.point)[: problem.asked]
    _, singular, directions = np.linalg.svd(free * sizes, full_matrices=False)
    asked = problem.names[: problem.asked]
    return [
        tuple(name for name, share in zip(asked, row, strict=True) if abs(share) > TOL.group_share)
        for row in directions[singular * TOL.unknown < 1.0]
    ]


def _limits(problem: Problem, pattern: str, parameters: list[Parameter], fitted: Scene) -> list[str]:
    """Say which estimates are at a limit."""
    found = []
    both = {"static_friction", "kinetic_friction"} <= set(problem.names)
    for p, low, high in zip(parameters, *problem.bounds[:, : problem.asked], strict=True):
        if p.name == "static_friction" and "_" not in pattern:
            continue  # it has no effect, and any value
        within, quantity = TOL.at_limit * (high - low), QUANTITIES[p.name]
        least, most = (f"{quantity.from_si(end):.4g} {quantity.unit}".rstrip() for end in (low, high))
        limits = [
            (p.value - low, f"the lowest value that is tried, {least}"),
            (high - p.value, f"the highest value that is tried, {most}"),
        ]
        if p.name == "static_friction" or (p.name == "kinetic_friction" and not both):
            limits.append((float(fitted.static_friction - fitted.kinetic_friction), "mu_d = mu_s"))
        found += [f"{quantity.letter} is at its limit, {what}" for d, what in limits if d < within]
    return found
