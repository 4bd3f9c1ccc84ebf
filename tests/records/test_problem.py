"""The residuals of a fit: their weights, what is tried, and what they are made of."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers.made_records import FREQUENCY, ON_ELLIPSES, Walked, bowl, nut

import vibro
from vibro.records.alignment import Observation, detrended
from vibro.records.problem import HOPS, Problem, fittable, starts

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


@pytest.mark.parametrize("trough_deg", [0.0, 8.0, 15.0])
def test_no_drive_angle_is_tried_beyond_the_vertical(trough_deg: float) -> None:
    scene = nut(trough_angle=math.radians(trough_deg))
    problem = Problem(scene, Walked(nut()).observe("velocity", cycles=3), ["drive_angle"])
    steepest = math.degrees(problem.bounds[1, 0])
    assert steepest == pytest.approx(min(80.0, 89.5 - trough_deg))


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


# --- coordinates: their bounds, sizes, sides and turns ------------------------------------------------


def any_problem(scene: vibro.Scene, *names: str) -> Problem:
    return Problem(scene, Walked(nut()).observe("velocity", cycles=2), names)


def test_what_is_tried_of_each_quantity() -> None:
    line = any_problem(nut(), *SLIP, "amplitude", "drive_angle")
    assert line.bounds[0] == pytest.approx([1e-3, 1e-3, 0.2e-3, math.radians(0.5)])
    assert line.bounds[1] == pytest.approx([3.0, 3.0, 5e-3, math.radians(80.0)])
    ellipse = any_problem(bowl(), "normal_amplitude", "normal_phase")
    assert ellipse.bounds[:, 0] == pytest.approx([0.1e-3, 2.5e-3])
    assert np.degrees(ellipse.bounds[:, 1]) == pytest.approx([-600.0, 480.0])
    assert (line.is_curved, ellipse.is_curved) == (False, True)
    assert not any_problem(bowl(), *SLIP).is_curved


def test_what_can_be_fitted_of_each_drive() -> None:
    assert fittable(nut()) == (*SLIP, "amplitude", "drive_angle")
    assert fittable(bowl()) == (*SLIP, "along_amplitude", "normal_amplitude", "normal_phase")


def test_sides_and_turns_of_phases() -> None:
    problem = any_problem(bowl(), "static_friction", "normal_phase")
    for phase, positive in ((0.5, True), (2.8, True), (-0.5, False), (math.pi + 0.5, False), (-6.0, True)):
        assert problem.sides(np.array([0.4, phase, 0.7])) == (positive,)
    assert any_problem(nut(), "static_friction").sides(np.array([0.4, 0.7])) == ()
    point = np.array([9.0, -1.0, 9.0])
    for near, turns in ((-1.0, 0), (2.0, 0), (2.3, 1), (5.0, 1), (8.6, 2), (-4.3, -1), (-10.0, -1)):
        moved = problem.unwound(point, np.array([0.4, near]))
        assert moved == pytest.approx([9.0, -1.0 + turns * math.tau, 9.0])
    assert point[1] == -1.0


# --- residuals and weights ----------------------------------------------------------------------------

SIGNALS = ("displacement", "velocity", "acceleration", "friction")


@pytest.mark.parametrize("signal", SIGNALS)
def test_offsets_have_no_residual_and_drifts_only_of_a_displacement(signal: str) -> None:
    """No sensor of displacement invents a speed."""
    plain = slip_problem(signal)
    observed = plain.observation
    values, time = observed.signals[signal], observed.time
    found = [plain]
    for added in (7.0 + 0.0 * time, 0.5 * time):
        # the weights are those of the plain record
        other = Problem(nut(), observed, SLIP)
        other.observation = Observation(time, {signal: values + float(np.ptp(values)) * added}, FREQUENCY)
        found.append(other)
    wrong = np.array([[0.7, 0.6, 0.2]])
    one, shifted, drifting = (p.residuals("F_", wrong).values for p in found)
    scale = float(np.abs(one).max())
    np.testing.assert_allclose(shifted, one, atol=1e-9 * scale)
    assert (float(np.abs(drifting - one).max()) > 0.1 * scale) == (signal == "displacement")


@pytest.mark.parametrize("signal", SIGNALS)
def test_a_dead_signal_weighs_by_the_size_that_the_drive_gives_it(signal: str) -> None:
    """Its residuals are the model's, over 1e-12 of the trough's amplitude, speed or acceleration."""
    scene, walked = nut(1.5), Walked(nut(1.5))
    observed = walked.observe(signal, cycles=4)
    dead = Observation(observed.time, {signal: 0.0 * observed.time}, FREQUENCY)
    problem = Problem(scene, dead, SLIP)
    assert problem.count == observed.time.size
    (squares,) = problem.residuals("FB_", np.array([[0.74, 0.57, 0.0]])).squares
    model = getattr(walked, signal)(observed.time)
    model = detrended(observed.time, model, 0 if signal == "displacement" else 1)
    rate = 2.0 * math.pi * FREQUENCY
    size = 1.5e-3 * rate ** {"displacement": 0, "velocity": 1}.get(signal, 2)
    assert squares == pytest.approx(float(model @ model) / (1e-12 * size) ** 2, rel=0.02)


@pytest.mark.parametrize("signal", ["acceleration", "friction"])
def test_samples_beside_a_jump_take_no_part(signal: str) -> None:
    """One slide a cycle: two jumps, with two or three samples within a sample time of each."""
    problem = slip_problem(signal)
    problem.weigh(TRUE)
    (values,) = problem.residuals("F_", TRUE[None]).values
    walked, time = Walked(nut()), problem.observation.time
    jumps = [t for _, start, length in walked.slides for t in (start, start + length)]
    away = (np.subtract.outer(time + 0.0137, jumps) / walked.period + 0.5) % 1.0 - 0.5
    near = (np.abs(away) * walked.period).min(axis=1)
    assert (values[near < 0.99 / 600.0] == 0.0).all()
    assert (values[near > 1.01 / 600.0] != 0.0).all()
    used = int(np.count_nonzero(values))
    # two coefficients, the shift, and the sensor's offset and drift are taken from the rest
    assert problem.count * (used - 5) / time.size == pytest.approx(float(values @ values), rel=1e-6)


def test_of_a_resting_body_or_none_there_are_no_rough_squares() -> None:
    scene = nut(static_friction=0.0, kinetic_friction=0.0)
    problem = Problem(scene, Walked(nut()).observe("velocity", cycles=2), ["amplitude"])
    assert problem.labels(np.array([[1e-3]])).tolist() == [""]
    assert np.isinf(problem.rough_squares(np.array([[1e-3]]))[0]).all()


def test_phases_start_on_both_sides() -> None:
    """Up to three starts of each pattern and side."""
    scene = ON_ELLIPSES["F_"]
    problem = Problem(scene, Walked(scene).observe("velocity", cycles=3), ["static_friction", "normal_phase"])
    found = [(label, problem.sides(point)) for label, point in starts(problem, hops=False)]
    for side in (False, True):
        assert found.count(("F_", (side,))) == 3
    misfits = [problem.rough_squares(point[None, :-1])[0][0] for _, point in starts(problem, hops=False)]
    assert misfits == sorted(misfits)


def test_starts_that_hop_are_for_themselves_and_few() -> None:
    problem = Problem(nut(4.0), Walked(nut()).observe("velocity", cycles=3), ["amplitude", "drive_angle"])
    assert HOPS not in {label for label, _ in starts(problem, hops=False)}
    found = starts(problem, hops=True)
    assert [label for label, _ in found] == [HOPS] * 3
