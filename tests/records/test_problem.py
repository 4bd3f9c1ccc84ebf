"""The residuals of a fit: their weights, what is tried, and what they are made of."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers.made_records import ON_ELLIPSES, Walked, nut

import vibro
from vibro.records.alignment import Observation
from vibro.records.problem import Problem, _candidates, _variances, starts

SLIP = ("static_friction", "kinetic_friction")
TRUE = np.array([0.74, 0.57, 0.0137 * 15.0])


def slip_problem(*signals: str, cycles: int = 4) -> Problem:
    return Problem(nut(), Walked(nut()).observe(*signals, cycles=cycles), SLIP)


@pytest.mark.parametrize(("signal", "powers"), [("displacement", 1), ("velocity", 2)])
def test_the_unit_of_squares_is_the_variance_by_the_degrees_of_freedom(signal: str, powers: int) -> None:
    """A short record: two coefficients, the shift and what the sensor adds are taken from its samples."""
    problem = slip_problem(signal, cycles=2)
    problem.weigh(TRUE)
    (squares,) = problem.residuals("F_", TRUE[None]).squares
    size = problem.observation.time.size
    assert squares == pytest.approx(problem.count * (size - powers - 3) / size, rel=1e-6)


def test_what_a_sensor_adds_has_no_residual() -> None:
    plain = slip_problem("velocity")
    observed = plain.observation
    signals = {"velocity": observed.signals["velocity"] + 0.3 - 0.2 * observed.time}
    shifted = Problem(nut(), Observation(observed.time, signals, observed.frequency), SLIP)
    for problem in (plain, shifted):
        problem.weigh(TRUE)
    one, other = (p.residuals("F_", TRUE[None]).values for p in (plain, shifted))
    np.testing.assert_allclose(one, other, atol=1e-9)


def test_samples_that_are_late_weigh_less_where_the_signal_is_steep() -> None:
    walked = Walked(nut())
    observed = walked.observe("velocity", cycles=30)
    slope = walked.acceleration(observed.time + 0.0137)
    random = np.random.default_rng(1)
    late = 1e-3 * slope * random.standard_normal(slope.size) + 2e-3 * random.standard_normal(slope.size)
    expected = slope**2 + 4.0
    found = _variances(observed, late, slope**2)
    assert found / found.mean() == pytest.approx(expected / expected.mean(), rel=0.4)
    assert np.corrcoef(found, expected)[0, 1] > 0.99
    white = 2e-3 * random.standard_normal(slope.size)
    assert (_variances(observed, white, slope**2) == 1.0).all()


def test_weights_fall_where_samples_are_late_and_the_signal_is_steep() -> None:
    walked = Walked(nut())
    time = np.arange(401) / 600.0
    random = np.random.default_rng(1)
    late = walked.velocity(time + 0.0137 + 5e-4 * random.standard_normal(time.size))
    noisy = late + 4e-4 * random.standard_normal(time.size)
    problem = Problem(nut(), Observation(time, {"velocity": noisy}, 15.0), SLIP)
    problem.weigh(TRUE)
    weights, slope = problem._weights["velocity"], np.abs(walked.acceleration(time + 0.0137))
    steep = slope > np.quantile(slope, 0.9)
    assert np.median(weights[steep]) < 0.5 * np.median(weights[slope == 0.0])


@pytest.mark.parametrize("trough_deg", [0.0, 8.0, 15.0])
def test_no_drive_angle_is_tried_beyond_the_vertical(trough_deg: float) -> None:
    scene = nut(trough_angle=math.radians(trough_deg))
    problem = Problem(scene, Walked(nut()).observe("velocity", cycles=3), ["drive_angle"])
    steepest = math.degrees(problem.bounds[1, 0])
    assert steepest == pytest.approx(min(80.0, 89.5 - trough_deg))


def test_amplitudes_are_tried_relative_to_the_scenes_and_phases_beside_its() -> None:
    scene = ON_ELLIPSES["FB_"]
    names = ["along_amplitude", "normal_phase"]
    problem = Problem(scene, Walked(scene).observe("velocity", cycles=3), names)
    assert problem.bounds[:, 0] == pytest.approx([0.2e-3, 5e-3])
    assert np.degrees(problem.bounds[:, 1]) == pytest.approx([-600.0, 480.0])
    assert problem.labels(np.array([[1e-3, -1.0, 0.0], [5.1e-3, -1.0, 0.0]])).tolist()[1] == ""


def test_the_best_start_is_near_the_truth() -> None:
    """From the grid alone, and with the shift that one correlation gives."""
    scene = nut(static_friction=0.2, kinetic_friction=0.1)
    problem = Problem(scene, Walked(nut()).observe("velocity", cycles=6), SLIP)
    found = starts(problem, hops=False)
    label, point = found[0]
    assert label == "F_"
    assert point == pytest.approx(TRUE, rel=0.2)
    kinetic = np.array([start[1] for _, start in found])
    assert (kinetic > 0.0).all()
    labels = [label for label, _ in found]
    assert len(set(labels)) > 2
    assert max(labels.count(label) for label in labels) == 3


def test_kinetic_friction_is_tried_as_a_share_of_static_friction() -> None:
    own, *points = _candidates(slip_problem("velocity"))
    assert own == pytest.approx(TRUE[:2])
    shares = np.array([kinetic / static for static, kinetic in points])
    assert (shares.min(), shares.max()) == pytest.approx((0.1, 0.99))
    assert len(points) == 24 * 11


def test_the_shift_of_a_rough_search_is_that_of_the_record() -> None:
    problem = slip_problem("displacement", "velocity", cycles=6)
    (square,), (shift,) = problem.rough_squares(TRUE[None, :2])
    assert shift == pytest.approx(TRUE[2], abs=0.5 / 128)
    assert square < problem.rough_squares(np.array([[0.6, 0.5]]))[0][0]


def test_outside_the_pattern_the_squares_are_infinite() -> None:
    problem = slip_problem("velocity")
    assert vibro.solve(nut()).pattern == "F_"
    assert np.isfinite(problem.residuals("F_", TRUE[None]).squares).all()
    assert np.isinf(problem.residuals("FB", TRUE[None]).squares).all()
