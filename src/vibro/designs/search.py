"""Search numerically for changes of a sign, and for minima in a unit cube."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from vibro.reals import Floats

# ------------------------------------------------------------------------------
# Bracketed root search along one unknown, for all rooms above the core.


def close_in(
    residual: Callable[[Floats], Floats],
    inside: Floats | float,
    outside: Floats | float,
    *,
    relative: float = 0.0,
    absolute: float = 0.0,
    sections: int = 1,
) -> tuple[Floats, Floats]:
    """Narrow brackets around a change of a residual's sign.

    Parameters
    ----------
    residual : callable
        Of arguments of shape ``(*shape, sections)``; returns as many values, >= 0 where what is asked for
        holds. Speeds jump, so that its sign counts and its size does not.
    inside, outside : array or float
        Arguments of one shape at which it holds, and at which it does not.
    relative, absolute : float
        Widths at which the search ends: of the argument, and in its unit. Without both it goes on to
        neighbouring doubles.
    sections : int
        Arguments per bracket and call, for functions whose calls cost the same for many arguments.

    Returns
    -------
    inside, outside : array
        The last argument at which it holds, and the first at which it does not.
    """
    inside, outside = np.asarray(inside, np.float64), np.asarray(outside, np.float64)
    shares = np.arange(1.0, sections + 1.0) / (sections + 1.0)
    while inside.size and np.any(np.abs(outside - inside) > relative * np.abs(inside) + absolute):
        between = inside[..., None] + shares * (outside - inside)[..., None]
        if np.all((between == inside[..., None]) | (between == outside[..., None])):
            break
        fails = ~(np.asarray(residual(between)) >= 0.0)
        all_held = ~fails.any(axis=-1)
        first = np.where(all_held, sections, np.argmax(fails, axis=-1))
        points = np.concatenate([inside[..., None], between, outside[..., None]], axis=-1)
        inside, outside = (np.take_along_axis(points, (first + i)[..., None], -1)[..., 0] for i in range(2))
    return inside, outside


_OVERHANG: Final = 0.1  # trial points this far outside are moved to the face, where optima often are
_SETTLED: Final = 1e-12  # relative spread of the population at which the search ends
_WORST: Final = 1e30  # largest cost: the spread of a population must be finite

_KEPT: Final = 8  # best points, around which more are sampled
_AROUND: Final = 0.1  # standard deviation of these in the first round
_CLOSER: Final = 0.4  # factor on it from round to round


def sobol(dimensions: int, logarithm: int, seed: int) -> Floats:
    """Return scrambled Sobol points in the unit cube, of shape (dimensions, 2**logarithm)."""
    from scipy.stats import qmc  # late: it takes a fifth of a second to load

    points = qmc.Sobol(dimensions, rng=np.random.default_rng(seed)).random_base2(logarithm)
    return np.asarray(points.T)


def placed(free: NDArray[np.bool_], x: Floats) -> Floats:
    """Return points of the whole cube, of shape (axes, n), from those of its free axes; 0 elsewhere."""
    coordinates = np.zeros((len(free), x.shape[1]))
    coordinates[free] = x
    return coordinates


def evolve(
    cost: Callable[[Floats], Floats], first: Floats, *, generations: int, seed: int
) -> tuple[Floats, float]:
    """Minimise a function over the unit cube.

    Parameters
    ----------
    cost : callable
        Of points of shape (d, n); returns n costs, NaN where a point does not count.
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
        warnings.simplefilter("ignore", RuntimeWarning)  # the spread of the population may overflow
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
    """Minimise a discontinuous function over the unit cube, by samples.

    Parameters
    ----------
    cost : callable
        As for ``evolve``.
    first : (d, n) array
        The first points.
    more, rounds : int
        Number of further points in each round, which lie closer and closer around the best.
    seed : int
        Of these.

    Returns
    -------
    point, cost : (d, 1) array, float
        The best point; NaN for its cost where none counts.
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
