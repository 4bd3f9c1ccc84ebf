"""Minima in a unit cube whose faces matter: of what is smooth in pieces, and of what is not."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

__all__ = ["evolve", "scatter", "sobol"]

_OVERHANG: Final = 0.1  # beyond each end, searched for the end itself: optima lie on faces
_SETTLED: Final = 1e-12  # relative spread of the population at which the search ends
_WORST: Final = 1e30  # in place of larger costs, so that populations have a spread

_KEPT: Final = 8  # points around which more are scattered
_AROUND: Final = 0.1  # first standard deviation of these
_CLOSER: Final = 0.4  # factor from round to round


def sobol(dimensions: int, logarithm: int, seed: int) -> Floats:
    """Return scrambled Sobol points in the unit cube, of shape (dimensions, 2**logarithm)."""
    from scipy.stats import qmc  # late: it takes a fifth of a second to load

    points = qmc.Sobol(dimensions, rng=np.random.default_rng(seed)).random_base2(logarithm)
    return np.asarray(points.T)


def evolve(
    cost: Callable[[Floats], Floats], first: Floats, *, generations: int, seed: int
) -> tuple[Floats, float]:
    """Minimise a function over the unit cube.

    Parameters
    ----------
    cost : callable
        Of points of shape (d, n); returns n costs, NaN where a point is of no account.
    first : (d, n) array
        The first population.
    generations : int
        After which the search ends at the latest.
    seed : int
        Of the search.

    Returns
    -------
    point, cost : (d, 1) array, float
        The best point that was met.
    """
    from scipy.optimize import Bounds, differential_evolution  # late: it takes a fifth of a second to load

    def inside(x: Floats) -> Floats:
        return np.clip(x, 0.0, 1.0)

    def bounded(x: Floats, /) -> Floats:
        costs = np.clip(cost(inside(x)), -_WORST, _WORST)
        return np.where(np.isnan(costs), _WORST, costs)

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # of spreads that overflow
        found = differential_evolution(
            bounded,  # type: ignore[arg-type]  # vectorised
            Bounds(np.full(len(first), -_OVERHANG), np.full(len(first), 1.0 + _OVERHANG)),
            init=first.T,
            maxiter=generations,
            tol=_SETTLED,
            rng=np.random.default_rng(seed),
            polish=False,
            updating="deferred",
            vectorized=True,
        )
    return inside(found.x[:, None]), float(found.fun)


def scatter(
    cost: Callable[[Floats], Floats], first: Floats, *, more: int, rounds: int, seed: int
) -> tuple[Floats, float]:
    """Minimise a function over the unit cube that is not smooth in anything: by samples.

    Parameters
    ----------
    cost : callable
        As for ``evolve``.
    first : (d, n) array
        The points looked at first.
    more, rounds : int
        How many more are looked at in each round, closer and closer around the best.
    seed : int
        Of these.

    Returns
    -------
    point, cost : (d, 1) array, float
        The best point; NaN for its cost where all are of no account.
    """
    rng = np.random.default_rng(seed)
    points, costs = first, cost(first)
    for n in range(rounds + 1):
        order = np.argsort(costs)[:_KEPT]  # NaN last
        points, costs = points[:, order], costs[order]
        if n == rounds or not len(first):
            break
        around = np.repeat(points, -(-more // order.size), axis=1)
        around += _AROUND * _CLOSER**n * rng.standard_normal(around.shape)
        around = np.clip(around, 0.0, 1.0)
        points, costs = np.hstack([points, around]), np.append(costs, cost(around))
    return points[:, :1], float(costs[0])
