"""Least squares in a pattern, and along its edges, on problems whose least misfit is known."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from vibro.records.fitting import (
    Minimum,
    _profile,
    best_of,
    error_covariance,
    jacobian_at,
    minimise,
)
from vibro.records.problem import HOPS, Problem, Residuals

Floats = NDArray[np.float64]


class Valley:
    """Rosenbrock's valley, its lowest point at (1, 1), and a shift that belongs at 0.3; y ends at an edge."""

    count = 3.0

    def __init__(self, edge: float = np.inf, *, shift_effect: float = 3.0, label: str = "F") -> None:
        self.edge, self.shift_effect, self.label = edge, shift_effect, label

    def scale(self, point: Floats) -> Floats:
        return np.ones(3)

    def labels(self, points: Floats) -> NDArray[np.str_]:
        return np.where(points[:, 1] <= self.edge, self.label, "B")

    def residuals(self, label: str, points: Floats) -> Residuals:
        x, y, shift = points.T
        values = np.stack([10.0 * (y - x * x), 1.0 - x, self.shift_effect * (shift - 0.3)], axis=1)
        return Residuals(self.labels(points) == label, values)


def problem(**options: Any) -> Problem:
    return cast(Problem, Valley(**options))


def searched(valley: Problem, **options: Any) -> Minimum:
    return minimise(valley, best_of(valley, "F", np.array([[-1.2, 1.0, 0.0]])), 1e-12, **options)


def test_the_lowest_point_of_a_curved_valley_is_found() -> None:
    found = searched(problem())
    assert found.point == pytest.approx([1.0, 1.0, 0.3], abs=1e-5)
    assert found.squares < 1e-10


def test_the_least_misfit_on_an_edge_is_found_along_it() -> None:
    edge = 0.49
    along = minimize_scalar(lambda x: 100.0 * (edge - x * x) ** 2 + (1.0 - x) ** 2, bounds=(0.5, 1.0))
    valley = problem(edge=edge)
    found = minimise(valley, best_of(valley, "F", np.array([[0.2, 0.1, 0.0]])), 1e-9)
    assert found.point == pytest.approx([float(along.x), edge, 0.3], abs=1e-4)
    assert found.point[1] <= edge


def test_a_search_that_begins_outside_its_pattern_stays() -> None:
    valley = problem(edge=0.5)
    outside = best_of(valley, "F", np.array([[0.0, 1.0, 0.0]]))
    assert np.isinf(outside.squares)
    assert minimise(valley, outside, 1e-9) is outside


def test_an_interval_of_a_body_that_hops_comes_from_the_curvature() -> None:
    """A profile would take too long: the half is the root of threshold times variance."""
    valley = problem(label=HOPS)
    found = minimise(valley, best_of(valley, HOPS, np.array([[0.9, 0.8, 0.3]])), 1e-12)
    ((low, high),), best = _profile(valley, [found], 4.0, 0)
    half = 2.0 * float(np.sqrt(error_covariance(valley, found)[0, 0]))
    assert (low, high) == pytest.approx((found.point[0] - half, found.point[0] + half))
    assert best is found


def test_an_interval_ends_where_the_others_refitted_the_misfit_is_too_large() -> None:
    """Of x the least misfit along the valley is that of 1 - x; an edge of y ends it earlier."""
    for edge, most in ((np.inf, 3.0), (4.0, 2.0)):
        valley = problem(edge=edge)
        found = minimise(valley, best_of(valley, "F", np.array([[0.9, 0.8, 0.3]])), 1e-12)
        ((low, high),), _ = _profile(valley, [found], 4.0, 0)
        assert low == pytest.approx(-1.0, abs=0.05)
        assert high == pytest.approx(most, abs=0.1)


def test_a_quantity_without_an_effect_has_an_interval_without_ends() -> None:
    class Flat(Valley):
        def residuals(self, label: str, points: Floats) -> Residuals:
            _, y, shift = points.T
            return Residuals(self.labels(points) == label, np.stack([y, shift, 0.0 * y], axis=1))

    flat = cast(Problem, Flat())
    found = minimise(flat, best_of(flat, "F", np.array([[0.5, 0.1, 0.1]])), 1e-12)
    assert _profile(flat, [found], 4.0, 0)[0] == ((-np.inf, np.inf),)


# --- coordinates of other sizes, and patterns with more edges -----------------------------------------


class Shaped(Valley):
    """The valley in coordinates of other sizes, and with a pattern of any shape."""

    def __init__(
        self, inside: Callable[[Floats, Floats], Any], sizes: tuple[float, ...] = (1.0, 1.0, 1.0)
    ) -> None:
        super().__init__()
        self.inside, self.sizes = inside, np.array(sizes)

    def scale(self, point: Floats) -> Floats:
        return self.sizes

    def labels(self, points: Floats) -> NDArray[np.str_]:
        x, y, _ = (points / self.sizes).T
        return np.where(self.inside(x, y), "F", "B")

    def residuals(self, label: str, points: Floats) -> Residuals:
        found = super().residuals(label, points / self.sizes)
        return Residuals(self.labels(points) == label, found.values)


def shaped(inside: Callable[[Floats, Floats], Any], *sizes: float) -> Problem:
    return cast(Problem, Shaped(inside, sizes or (1.0, 1.0, 1.0)))


SIZES = (1e-4, 1e12, 1.0)


@pytest.mark.parametrize("sizes", [(1.0, 1.0, 1.0), SIZES, SIZES[::-1]])
def test_coordinates_may_have_any_size(sizes: tuple[float, ...]) -> None:
    valley, units = shaped(lambda x, y: x + y < 9.0, *sizes), np.array(sizes)
    begun = best_of(valley, "F", np.array([[-1.2, 1.0, 0.0]]) * units)
    found = minimise(valley, begun, 1e-12)
    assert found.point / units == pytest.approx([1.0, 1.0, 0.3], abs=1e-5)
    jacobian = np.array([[-20.0, 10.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 3.0]])
    np.testing.assert_allclose(jacobian_at(valley, found) * units, jacobian, atol=1e-3)
    covariance = error_covariance(valley, found) / np.outer(units, units)
    np.testing.assert_allclose(covariance, np.linalg.inv(jacobian.T @ jacobian), rtol=1e-3, atol=1e-6)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_the_least_misfit_on_a_lower_edge_or_across_x_is_found(way: float) -> None:
    """The valley's lowest point lies outside: y stays above 1.5, or x below or above -0.5."""
    edge = 1.5
    along = minimize_scalar(lambda x: 100.0 * (edge - x * x) ** 2 + (1.0 - x) ** 2, bounds=(1.0, 1.5))
    above = shaped(lambda x, y: y >= edge)
    found = minimise(above, best_of(above, "F", np.array([[1.1, 1.6, 0.0]])), 1e-9)
    assert found.point == pytest.approx([float(along.x), edge, 0.3], abs=1e-4)
    aside = shaped(lambda x, y: way * x <= -0.5 * way)
    begun = best_of(aside, "F", np.array([[-0.5 - 0.3 * way, 0.5, 0.0]]))
    found = minimise(aside, begun, 1e-9)
    expected = [-0.5, 0.25, 0.3] if way > 0.0 else [1.0, 1.0, 0.3]
    assert found.point == pytest.approx(expected, abs=1e-4)


@pytest.mark.parametrize("radius", [1e-5, 1e-3])
def test_a_search_does_not_end_higher_than_it_began(radius: float) -> None:
    """On an island in another pattern nearly every step ends in the sea."""
    island = shaped(lambda x, y: np.hypot(x + 1.2, y - 1.0) <= radius)
    begun = best_of(island, "F", np.array([[-1.2, 1.0, 0.3]]))
    found = minimise(island, begun, 1e-12)
    assert np.isfinite(found.squares)
    assert found.squares < begun.squares
    assert island.labels(found.point[None]).tolist() == ["F"]
