"""Intervals of confidence from the profile of the misfit, across the patterns that fit."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.records.cycles import HOPS
from vibro.records.descent import Minimum, derivatives, descend, nearest_inside

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from vibro.records.misfits import Problem

    Floats = NDArray[np.float64]

__all__ = ["ENOUGH", "Profile", "profile", "spread_of"]

ENOUGH: Final = 2e-3  # decrease of the sum of squares, in variances, below which a descent ends
_CLOSE: Final = 0.03  # of the threshold: the misfit at an end of an interval may miss it by this
_NARROW: Final = 0.02  # of the distance to the estimate: an end at an edge of a pattern is found to this
_FIRST: Final = 0.02  # relative first step where the derivatives give none,
_LEAST: Final = 1e-12  # and the least
_MOST: Final = 0.5  # and the greatest where they give one
_TRIES: Final = 24  # points that are tried for one end
_GAP: Final = 0.02  # of the hull: intervals closer to each other than this are one


class Profile(NamedTuple):
    """Values of one quantity that fit, and the best point that was met on the way."""

    intervals: tuple[tuple[float, float], ...]
    best: Minimum


class _Tried(NamedTuple):
    value: float
    root: float  # of the sum of squares above the minimum's; inf where the pattern has no such value
    point: Floats


def spread_of(problem: Problem, minimum: Minimum) -> Floats:
    """Covariance of the coordinates at a minimum, inside its pattern, shape (P + 1, P + 1).

    Coordinates without an effect have neither variance nor covariance.
    """
    free = list(range(minimum.point.size))
    _, jacobian = derivatives(problem, minimum.label, minimum.point, free)
    sizes = np.sqrt(np.einsum("ij,ij->j", jacobian, jacobian))
    sizes = np.where(sizes > 0.0, sizes, np.inf)
    normed = jacobian / sizes
    return np.asarray(np.linalg.pinv(normed.T @ normed, rcond=1e-12, hermitian=True) / np.outer(sizes, sizes))


def profile(problem: Problem, minima: Sequence[Minimum], threshold: float, column: int) -> Profile:
    """Find all values of one quantity with which the record can still be fitted.

    In each pattern the quantity is moved away from the minimum, the others refitted, until the sum of squares
    exceeds that of the minimum by the threshold, or the pattern ends.

    Parameters
    ----------
    problem : Problem
        The misfit.
    minima : sequence of Minimum
        Of each pattern that fits.
    threshold : float
        Increase of the sum of squares that counts as too much.
    column : int
        Of the quantity among the coordinates.
    """
    pieces: list[tuple[float, float]] = []
    best = minima[0]
    for minimum in minima:
        ends = []
        spread = spread_of(problem, minimum)
        if minimum.label == HOPS:
            # A point takes up to a tenth of a second: take the curvature at the minimum for the profile.
            half = math.sqrt(threshold * spread[column, column])
            value = float(minimum.point[column])
            pieces.append((value - half, value + half) if half else (-math.inf, math.inf))
            continue
        for way in (-1.0, 1.0):
            end, met = _end(problem, minimum, spread, threshold, column, way)
            ends.append(end)
            best = min(best, met, key=lambda m: m.squares)
        pieces.append((ends[0], ends[1]))
    return Profile(_merged(pieces), best)


def _merged(pieces: list[tuple[float, float]]) -> tuple[tuple[float, float], ...]:
    pieces = sorted(pieces)
    hull = max(high for _, high in pieces) - pieces[0][0]
    merged = pieces[:1]
    for low, high in pieces[1:]:
        if low - merged[-1][1] <= _GAP * hull:
            merged[-1] = (merged[-1][0], max(high, merged[-1][1]))
        else:
            merged.append((low, high))
    return tuple(merged)


def _end(
    problem: Problem, minimum: Minimum, spread: Floats, threshold: float, column: int, way: float
) -> tuple[float, Minimum]:
    """Return the last value that fits on one side, infinite if none is the last, and the best point met."""
    origin, variance = float(minimum.point[column]), float(spread[column, column])
    path = spread[:, column] / variance if variance else np.zeros(minimum.point.size)
    aim = math.sqrt(threshold)
    size = float(problem.scale(minimum.point)[column])
    step = _FIRST * size
    if variance:
        step = min(max(math.sqrt(variance) * aim, _LEAST * size), _MOST * size)
    inside, best = _Tried(origin, 0.0, minimum.point), minimum
    outside: _Tried | None = None
    for _ in range(_TRIES):
        if outside is None:
            value = inside.value + way * step
            step *= 2.0
        else:
            gap = outside.value - inside.value
            if abs(gap) <= _NARROW * abs(outside.value - origin):
                break
            share = 0.5
            if math.isfinite(outside.root):
                share = min(max((aim - inside.root) / (outside.root - inside.root), 0.05), 0.95)
            value = inside.value + share * gap
        found = _refitted(problem, minimum.label, inside, path, column, value)
        best = min(best, found, key=lambda m: m.squares)
        tried = _Tried(value, math.sqrt(max(found.squares - minimum.squares, 0.0)), found.point)
        if abs(tried.root**2 - threshold) <= _CLOSE * threshold:
            return value, best
        if tried.root >= aim:
            outside = tried
            continue
        inside = tried
        if outside is None and tried.root > 0.0:
            # as if the misfit grew with the square of the distance
            step = min(max(aim / tried.root - 1.0, 0.1), 2.0) * abs(value - origin)
    return (outside.value if outside else way * math.inf), best


def _refitted(problem: Problem, label: str, near: _Tried, path: Floats, column: int, value: float) -> Minimum:
    """Set a quantity to a value, and fit the others again; inf where the pattern has no such value.

    They begin where the quantity takes them by the slopes at the minimum, or else where they were.
    """
    free = [place for place in range(near.point.size) if place != column]
    for slopes in (path, np.zeros(path.size)):
        start = near.point + slopes * (value - near.value)
        start[column] = value
        begun = nearest_inside(problem, label, start, free[:-1])
        if begun is not None:
            return descend(problem, label, begun, free, ENOUGH)
    return Minimum(label, start, math.inf)
