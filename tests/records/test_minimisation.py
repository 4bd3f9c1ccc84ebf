"""Levenberg-Marquardt with geodesic acceleration, and edges, on problems whose least misfit is known."""

from __future__ import annotations

import math
from typing import Any, cast

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from vibro.records.cycles import HOPS
from vibro.records.fitting import _bounded, _half_width, _merged, _profile
from vibro.records.minimisation import (
    Minimum,
    best_of,
    error_covariance,
    jacobian_at,
    minimise,
    move_to_edge,
    nearest_inside,
)
from vibro.records.problem import Problem, Residuals

Floats = NDArray[np.float64]


class Valley:
    """Rosenbrock's valley, its lowest point at (1, 1), and a shift that belongs at 0.3; y ends at an edge."""

    def __init__(
        self, edge: float = np.inf, *, is_curved: bool = False, shift_effect: float = 3.0, label: str = "F"
    ) -> None:
        self.edge, self.is_curved, self.shift_effect = edge, is_curved, shift_effect
        self.label, self.points = label, 0

    def scale(self, point: Floats) -> Floats:
        return np.ones(3)

    def labels(self, points: Floats) -> NDArray[np.str_]:
        return np.where(points[:, 1] <= self.edge, self.label, "B")

    def residuals(self, label: str, points: Floats) -> Residuals:
        self.points += points.shape[0]
        x, y, shift = points.T
        values = np.stack([10.0 * (y - x * x), 1.0 - x, self.shift_effect * (shift - 0.3)], axis=1)
        return Residuals(self.labels(points) == label, values)


def problem(**options: Any) -> Problem:
    return cast(Problem, Valley(**options))


def searched(valley: Problem, **options: Any) -> Minimum:
    return minimise(valley, best_of(valley, "F", np.array([[-1.2, 1.0, 0.0]])), 1e-12, **options)


@pytest.mark.parametrize("is_curved", [False, True])
def test_the_lowest_point_of_a_curved_valley_is_found(is_curved: bool) -> None:
    found = searched(problem(is_curved=is_curved))
    assert found.point == pytest.approx([1.0, 1.0, 0.3], abs=1e-5)
    assert found.squares < 1e-10


def test_geodesic_acceleration_reaches_farther_along_a_curved_valley() -> None:
    """One step of a problem with a steep and quadratically curved valley; the straight step is short."""
    reached = []
    for is_curved in (False, True):
        valley = problem(is_curved=is_curved)
        begun = best_of(valley, "F", np.array([[-4.0, 16.0, 0.3]]))
        reached.append(minimise(valley, begun, enough=80.0).squares / begun.squares)
    straight, accelerated = reached
    assert accelerated < 0.01
    assert straight > 0.9


def test_a_coordinate_that_is_fixed_stays() -> None:
    found = searched(problem(), fixed=[0])
    assert found.point == pytest.approx([-1.2, 1.44, 0.3], abs=1e-6)
    assert found.squares == pytest.approx(2.2**2)


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


def test_a_hopeless_search_ends_early() -> None:
    costs = []
    for aim in (np.inf, -1e9):
        valley = Valley()
        searched(cast(Problem, valley), aim=aim)
        costs.append(valley.points)
    assert costs[1] < 0.2 * costs[0]


@pytest.mark.parametrize("reach", [0.8, -0.8])
def test_points_are_moved_to_the_edge_just_inside(reach: float) -> None:
    points = np.array([[0.0, 0.1, 0.0], [0.0, 0.9, 0.0], [0.0, -9.0, 0.0]])
    moved = move_to_edge(problem(edge=0.5), "F", points, 1, reach)
    # The pattern has one edge, above it; a point that is too far from one stays.
    expected = [0.5, 0.5, -9.0] if reach > 0.0 else [0.1, 0.9, -9.0]
    assert moved[:, 1] == pytest.approx(expected, abs=1e-6)
    assert reach < 0.0 or (moved[:2, 1] <= 0.5).all()
    assert (moved[:, [0, 2]] == points[:, [0, 2]]).all()


def test_the_nearest_point_of_a_pattern_is_as_near_as_its_edge() -> None:
    valley = problem(edge=0.5)
    found = nearest_inside(valley, "F", np.array([0.3, 0.501, 0.0]), [0, 1])
    assert found is not None
    assert 0.499 < found.point[1] <= 0.5
    assert nearest_inside(valley, "F", np.array([0.3, 0.501, 0.0]), [0]) is None


def test_the_covariance_is_the_inverse_of_the_curvature() -> None:
    valley = problem()
    found = searched(valley)
    jacobian = np.array([[-20.0, 10.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 3.0]])
    np.testing.assert_allclose(jacobian_at(valley, found), jacobian, atol=1e-3)
    expected = np.linalg.inv(jacobian.T @ jacobian)
    np.testing.assert_allclose(error_covariance(valley, found), expected, rtol=1e-3, atol=1e-6)


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


def test_intervals_that_overlap_are_one() -> None:
    """One that lies inside another does not end it."""
    assert _merged([(20.0, 21.0), (0.0, 10.0), (1.0, 2.0)]) == ((0.0, 10.0), (20.0, 21.0))


def test_what_reaches_the_end_of_what_is_tried_has_no_interval() -> None:
    inside = ((0.2, 0.3), (0.6, 0.8))
    assert _bounded(inside, 0.0, 1.0) == inside
    assert _bounded(((0.0, 0.3),), 0.0, 1.0) == ()
    assert _bounded(((0.2, 1.0),), 0.0, 1.0) == ()
    assert _half_width(inside) == pytest.approx(0.3)
    assert _half_width(()) == math.inf


def test_a_coordinate_whose_effect_is_rounding_has_none() -> None:
    """Else it would move by far, and have a variance."""
    valley = problem(shift_effect=1e-7)
    point = np.array([0.3, 0.4, 0.0])
    found = best_of(valley, "F", point[None])
    assert (jacobian_at(valley, found)[:, 2] == 0.0).all()
    covariance = error_covariance(valley, found)
    assert (covariance[2] == 0.0).all()
    assert covariance[0, 0] > 0.0


def test_derivatives_at_an_edge_are_one_sided() -> None:
    jacobian = jacobian_at(problem(edge=0.5), Minimum("F", np.array([0.3, 0.5, 0.0]), 0.0))
    assert jacobian[:, 1] == pytest.approx([10.0, 0.0, 0.0], rel=1e-6)
