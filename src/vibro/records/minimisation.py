"""The least misfit of one pattern: Levenberg-Marquardt with geodesic acceleration, and steps along edges.

A slide begins with a finite length where its load passes static friction: the misfit jumps from pattern to
pattern, and its least value may lie on the edge of one, where no derivative vanishes. Inside a pattern the
motion is smooth. A step that would leave it is replaced by one along the edge: one coordinate follows the
edge, and the others move.

References
----------
Transtrum, M. K.; Sethna, J. P.: Improvements to the Levenberg-Marquardt algorithm for nonlinear
least-squares minimization. arXiv:1201.5885 (2012). Here several dampings are tried at once, because the
residuals of many points take hardly longer than those of one.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final, NamedTuple

import numpy as np

from vibro.records.folding import Floats
from vibro.records.problem import Problem
from vibro.records.tolerances import TOL

_DISTANCES: Final = np.outer((1.0, -1.0), np.geomspace(*TOL.distances)).ravel()


_Move = Callable[[Floats], Floats]


class Minimum(NamedTuple):
    """A point of least misfit within a pattern, and its sum of squares."""

    label: str
    point: Floats
    squares: float


class _Linear(NamedTuple):
    """Residuals at a point, (K,), their Jacobian, (K, free coordinates), and whether the point is inside."""

    point: Floats
    inside: bool
    residual: Floats
    jacobian: Floats


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
        Decrease of the sum of squares below which the search ends.
    aim : float
        Sum of squares to reach: a search ends if it would need many more steps.
    fixed : sequence of int
        Coordinates that keep their values.
    """
    best, free = start, [i for i in range(start.point.size) if i not in fixed]
    for _ in range(TOL.most_steps if np.isfinite(best.squares) else 0):
        found = _best_step(problem, best, free, enough)
        gain = best.squares - found.squares
        if gain > 0.0:
            best = found
        if not gain > max(enough, (best.squares - aim) / TOL.patience):
            break
    return best


def best_of(problem: Problem, label: str, points: Floats) -> Minimum:
    """Return the point of least misfit; its sum of squares is inf if no point lies in the pattern."""
    return _least(label, points, problem.residuals(label, points).squares)


def _least(label: str, points: Floats, squares: Floats) -> Minimum:
    place = int(np.argmin(squares))
    return Minimum(label, points[place], float(squares[place]))


def jacobian_at(problem: Problem, minimum: Minimum) -> Floats:
    """Return the Jacobian of the residuals, (K, P + 1); 0 for coordinates without an effect."""
    return _linear(problem, minimum, list(range(minimum.point.size))).jacobian


def error_covariance(problem: Problem, minimum: Minimum) -> Floats:
    """Return the covariance of the coordinates at a minimum, within its pattern, shape (P + 1, P + 1).

    Rows and columns of coordinates without an effect are 0.
    """
    jacobian = jacobian_at(problem, minimum)
    sizes = np.linalg.norm(jacobian, axis=0)
    sizes = np.where(sizes > 0.0, sizes, np.inf)
    normed = jacobian / sizes
    return np.asarray(np.linalg.pinv(normed.T @ normed, rcond=1e-12, hermitian=True) / np.outer(sizes, sizes))


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
    shares, rows = np.linspace(0.0, 1.0, TOL.edge_places), np.arange(points.shape[0])
    found = np.ones(points.shape[0], np.bool_)
    for turn in range(TOL.edge_rounds):
        places = low[:, None] + (high - low)[:, None] * shares
        trials = np.repeat(points, TOL.edge_places, axis=0)
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


def _linear(
    problem: Problem, at: Minimum, free: list[int], step: float = TOL.step, move: _Move = np.copy
) -> _Linear:
    """Differentiate the residuals: central differences, one-sided at an edge, 0 in a corner.

    ``move`` moves the points before, for example to an edge.
    """
    sizes = step * problem.scale(at.point)[free]
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
    return _Linear(points[0], bool(inside[0]), values[0], jacobian)


def _damped_steps(residual: Floats, jacobian: Floats, dampings: tuple[float, ...] = TOL.dampings) -> Floats:
    """Return a step for each damping, shape (dampings, columns); 0 in coordinates without an effect.

    The residuals have the shape (K,), or (dampings, K).
    """
    sizes = np.linalg.norm(jacobian, axis=0)
    acting = sizes > 0.0
    steps = np.zeros((len(dampings), sizes.size))
    if acting.any():
        normed = jacobian[:, acting] / sizes[acting]
        values, vectors = np.linalg.eigh(normed.T @ normed)
        damped = -(residual @ normed @ vectors) / (np.maximum(values, 0.0) + np.array(dampings)[:, None])
        steps[:, acting] = (damped @ vectors.T) / sizes[acting]
    return steps


def _best_step(problem: Problem, at: Minimum, free: list[int], enough: float) -> Minimum:
    """Return the best point of one step: damped, accelerated in a curved valley, or along an edge."""
    linear = _linear(problem, at, free)
    steps = _damped_steps(linear.residual, linear.jacobian)
    points = _moved(at.point, free, steps)
    tried = problem.residuals(at.label, points)
    best = _least(at.label, points, tried.squares)
    hoped = at.squares - float(np.square(linear.residual + linear.jacobian @ steps[0]).sum())
    if at.squares - best.squares > TOL.fair * hoped:
        return best
    if problem.is_curved and hoped > TOL.accelerated:
        best = min(best, _accelerated_step(problem, at, free, linear), key=lambda m: m.squares)
    if tried.inside[0]:
        return best
    for coordinate, step in zip(free, steps[0].tolist(), strict=True):
        if coordinate < at.point.size - 1 and step:
            along = _step_along_edge(problem, at, [f for f in free if f != coordinate], coordinate, step)
            if along is not None and along.squares < best.squares - enough:
                return along
    return best


def _moved(point: Floats, free: list[int], steps: Floats) -> Floats:
    """Return a point moved by each of several steps of its free coordinates."""
    points = np.repeat(point[None], steps.shape[0], axis=0)
    points[:, free] += steps
    return points


def _accelerated_step(problem: Problem, at: Minimum, free: list[int], linear: _Linear) -> Minimum:
    """Return the best of lightly damped steps with their geodesic acceleration.

    Amplitudes and phase of an ellipse can compensate each other: the valley of the misfit is narrow and
    curved, and straight steps inside it are short. Each step is the velocity of a geodesic; the second
    derivative of the residuals along it gives the acceleration, by the same damped equations.
    """
    h, dampings = TOL.acceleration_step, TOL.light_dampings
    velocity = _damped_steps(linear.residual, linear.jacobian, dampings)
    inside, ahead = problem.residuals(at.label, _moved(at.point, free, h * velocity))
    second = 2.0 * ((ahead - linear.residual) / h - velocity @ linear.jacobian.T) / h
    second[~inside] = 0.0
    acceleration = _damped_steps(second, linear.jacobian, dampings)
    return best_of(problem, at.label, _moved(at.point, free, velocity + 0.5 * acceleration))


def _step_along_edge(
    problem: Problem, at: Minimum, free: list[int], follower: int, step: float
) -> Minimum | None:
    """Step along the edge that bounds a coordinate, the follower, on the side of ``step``."""
    size = float(problem.scale(at.point)[follower])
    reach = float(np.copysign(np.clip(2.0 * abs(step), TOL.edge_step * size, size), step))

    def to_edge(points: Floats) -> Floats:
        return move_to_edge(problem, at.label, points, follower, reach)

    linear = _linear(problem, at, free, TOL.edge_step, to_edge)
    if not linear.inside:
        return None
    trials = to_edge(_moved(linear.point, free, _damped_steps(linear.residual, linear.jacobian)))
    return best_of(problem, at.label, np.concatenate([linear.point[None], trials]))
