"""The least misfit of one pattern: damped Gauss-Newton steps inside it, and along its edges.

A slide begins with a finite length where its load passes static friction, so that the misfit jumps from
pattern to pattern, and its least value may lie on the edge of one, where no derivative vanishes. Inside a
pattern the motion is smooth. A step that would leave it is replaced by one along the edge: one coordinate
follows the edge, and the others move.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.records.misfits import Problem

    Floats = NDArray[np.float64]

__all__ = ["Minimum", "derivatives", "descend", "nearest_inside", "to_edge"]

_STEP: Final = 1e-6  # relative step of the derivatives: the model's noise is 1e-15, its curvature of order 1
_IDLE: Final = 1e-6  # of the largest effect of a coordinate: less is rounding, and counts as none
_DAMPINGS: Final = np.array([1e-12, 1e-3, 1e-2, 0.1, 1.0, 10.0, 100.0])  # of the normalised equations
_LIGHT: Final = np.geomspace(1e-7, 1e-2, 11)  # the same of steps that bend
_FAR: Final = 10.0  # decrease of the sum of squares, in variances: a step that promises less does not bend
_BEGUN: Final = 0.1  # of a step: how far a curvature is taken from
_MOST_STEPS: Final = 40
_FAIR: Final = 0.3  # share of the decrease that a whole step promises: with less, edges are looked for
_PATIENCE: Final = 5.0  # steps as large as the last one that a descent may still need
_PLACES: Final = 65  # points between which an edge is looked for, in each round
_ROUNDS: Final = 6  # at most
_SHARP: Final = 1e-6  # of a coordinate's scale: an edge is found to this
_DISTANCES: Final = np.outer((1.0, -1.0), np.geomspace(1e-7, 0.5, 60)).ravel()  # relative, to a pattern
_STEP_ALONG: Final = 1e-4  # relative step of the derivatives along an edge, which is known less sharply


class Minimum(NamedTuple):
    """A point of least misfit within a pattern, and its sum of squares."""

    label: str
    point: Floats
    squares: float


def descend(
    problem: Problem, label: str, start: Floats, free: list[int], enough: float, aim: float = np.inf
) -> Minimum:
    """Descend to the least misfit of a pattern.

    Parameters
    ----------
    problem : Problem
        The misfit.
    label : str
        The pattern.
    start : array, shape (P + 1,)
        Where it begins; if it lies outside the pattern, the sum of squares is inf.
    free : list of int
        Coordinates that may move.
    enough : float
        Decrease of the sum of squares below which the search ends.
    aim : float
        A sum of squares that matters: a descent that would not reach it with many more such steps ends.
    """
    best = Minimum(label, start, float(problem.misfits(label, start[None]).squares[0]))
    for _ in range(_MOST_STEPS if np.isfinite(best.squares) else 0):
        found = _best_step(problem, best, free, enough)
        gain = best.squares - found.squares
        if gain > 0.0:
            best = found
        if not gain > max(enough, (best.squares - aim) / _PATIENCE):
            break
    return best


def derivatives(problem: Problem, label: str, point: Floats, free: list[int]) -> tuple[Floats, Floats]:
    """Residuals at a point, shape (K,), and their derivatives, shape (K, len(free)); 0 without an effect."""
    steps = np.zeros((len(free), point.size))
    steps[range(len(free)), free] = _STEP * problem.scale(point)[free]
    misfits = problem.misfits(label, np.concatenate([point[None], point + steps, point - steps]))
    sizes = steps[range(len(free)), free]
    jacobian = _differences(misfits.residuals, misfits.inside, sizes)
    effects = np.sqrt(np.einsum("ij,ij->j", jacobian, jacobian)) * sizes
    jacobian[:, effects < _IDLE * effects.max(initial=0.0)] = 0.0
    return misfits.residuals[0], jacobian


def nearest_inside(problem: Problem, label: str, point: Floats, movable: list[int]) -> Floats | None:
    """Move one coordinate of a point as little as needed to bring it into the pattern.

    Of several such coordinates the one with the least misfit moves; None if there is none.
    """
    if problem.labels(point[None])[0] == label:
        return point
    found = []
    for coordinate in movable:
        points = np.repeat(point[None], _DISTANCES.size, axis=0)
        points[:, coordinate] += _DISTANCES * problem.scale(point)[coordinate]
        inside = problem.labels(points) == label
        if inside.any():
            found.append(points[np.argmin(np.where(inside, np.abs(_DISTANCES), np.inf))])
    if not found:
        return None
    best: Floats = found[int(np.argmin(problem.misfits(label, np.array(found)).squares))]
    return best


def _differences(residuals: Floats, inside: NDArray[np.bool_], sizes: Floats) -> Floats:
    """Central differences, one-sided at an edge, none in a corner."""
    count = sizes.size
    ahead, behind = inside[1 : count + 1], inside[count + 1 :]
    upper = np.where(ahead[:, None], residuals[1 : count + 1], residuals[0])
    lower = np.where(behind[:, None], residuals[count + 1 :], residuals[0])
    widths = sizes * np.maximum(ahead.astype(float) + behind, 1.0)
    return np.asarray(((upper - lower) / widths[:, None]).T)


def _steps(residual: Floats, jacobian: Floats, dampings: Floats = _DAMPINGS) -> Floats:
    """Damped steps, shape (dampings, columns); 0 in coordinates without an effect.

    Residuals are of shape (K,), or (dampings, K).
    """
    sizes = np.sqrt(np.einsum("ij,ij->j", jacobian, jacobian))
    acting = sizes > 0.0
    steps = np.zeros((dampings.size, sizes.size))
    if acting.any():
        normed = jacobian[:, acting] / sizes[acting]
        values, vectors = np.linalg.eigh(normed.T @ normed)
        slope = residual @ normed @ vectors
        damped = -slope / (np.maximum(values, 0.0) + dampings[:, None])
        steps[:, acting] = (damped @ vectors.T) / sizes[acting]
    return steps


def _best_step(problem: Problem, at: Minimum, free: list[int], enough: float) -> Minimum:
    residual, jacobian = derivatives(problem, at.label, at.point, free)
    steps = _steps(residual, jacobian)
    points = np.repeat(at.point[None], steps.shape[0], axis=0)
    points[:, free] += steps
    misfits = problem.misfits(at.label, points)
    squares = misfits.squares
    place = int(np.argmin(squares))
    best = Minimum(at.label, points[place], float(squares[place]))
    hoped = at.squares - float(np.square(residual + jacobian @ steps[0]).sum())
    if at.squares - best.squares > _FAIR * hoped:
        return best
    if problem.bends and hoped > _FAR:
        bent = _bent(problem, at, free, residual, jacobian)
        best = bent if bent.squares < best.squares else best
    if misfits.inside[0]:
        return best
    for column, coordinate in enumerate(free):
        step = float(steps[0, column])
        if coordinate == at.point.size - 1 or step == 0.0:
            continue
        along = _step_along_edge(problem, at, [f for f in free if f != coordinate], coordinate, step)
        if along is not None and along.squares < best.squares - enough:
            return along
    return best


def _bent(problem: Problem, at: Minimum, free: list[int], residual: Floats, jacobian: Floats) -> Minimum:
    """Best of lightly damped steps with their terms of second order.

    Amplitudes and phase of an ellipse can make up for each other: the valley of the misfit is narrow and
    bends, so that straight steps leave it soon, and are short.
    """
    steps = _steps(residual, jacobian, _LIGHT)
    moved = np.zeros((steps.shape[0], at.point.size))
    moved[:, free] = _BEGUN * steps
    begun = problem.misfits(at.label, at.point + moved)
    curves = 2.0 * ((begun.residuals - residual) / _BEGUN - steps @ jacobian.T) / _BEGUN
    curves[~begun.inside] = 0.0
    moved[:, free] = steps + 0.5 * _steps(curves, jacobian, _LIGHT)
    squares = problem.misfits(at.label, at.point + moved).squares
    place = int(np.argmin(squares))
    return Minimum(at.label, at.point + moved[place], float(squares[place]))


def _step_along_edge(
    problem: Problem, at: Minimum, free: list[int], follower: int, step: float
) -> Minimum | None:
    """One step along the edge that bounds a coordinate, the follower, on the side of ``step``."""
    reach = float(np.sign(step) * max(2.0 * abs(step), 1e-4 * problem.scale(at.point)[follower]))
    reach = float(np.clip(reach, -problem.scale(at.point)[follower], problem.scale(at.point)[follower]))
    sizes = _STEP_ALONG * problem.scale(at.point)[free]
    moved = np.zeros((len(free), at.point.size))
    moved[range(len(free)), free] = sizes
    points = to_edge(
        problem,
        at.label,
        np.concatenate([at.point[None], at.point + moved, at.point - moved]),
        follower,
        reach,
    )
    misfits = problem.misfits(at.label, points)
    if not misfits.inside[0]:
        return None
    jacobian = _differences(misfits.residuals, misfits.inside, sizes)
    steps = _steps(misfits.residuals[0], jacobian)
    trials = np.repeat(points[:1], steps.shape[0], axis=0)
    trials[:, free] += steps
    trials = np.concatenate([points[:1], to_edge(problem, at.label, trials, follower, reach)])
    squares = problem.misfits(at.label, trials).squares
    place = int(np.argmin(squares))
    return Minimum(at.label, trials[place], float(squares[place]))


def to_edge(problem: Problem, label: str, points: Floats, follower: int, reach: float) -> Floats:
    """Move one coordinate of each point to the nearest edge where it leaves the pattern, just inside.

    Parameters
    ----------
    problem, label : Problem, str
        The misfit, and the pattern.
    points : array, shape (M, P + 1)
        From which no edge lies within ``reach``, to either side, stay.
    follower : int
        The coordinate.
    reach : float
        Farthest distance; its sign tells on which side of the pattern the edge lies.
    """
    low, high = np.full(points.shape[0], -reach), np.full(points.shape[0], reach)
    shares = np.linspace(0.0, 1.0, _PLACES)
    found = np.ones(points.shape[0], np.bool_)
    for turn in range(_ROUNDS):
        places = low[:, None] + (high - low)[:, None] * shares
        trials = np.repeat(points, _PLACES, axis=0)
        trials[:, follower] += places.ravel()
        inside = (problem.labels(trials) == label).reshape(places.shape)
        leaves = inside[:, :-1] & ~inside[:, 1:]
        if not turn:
            found = leaves.any(axis=1)
        near = np.where(leaves, np.abs(places[:, :-1]), np.inf)
        column = np.argmin(near, axis=1)
        rows = np.arange(points.shape[0])
        low, high = places[rows, column], places[rows, column + 1]
        if float(np.abs(high - low).max()) < _SHARP * float(problem.scale(points[0])[follower]):
            break
    moved = points.copy()
    moved[found, follower] += low[found]
    return moved
