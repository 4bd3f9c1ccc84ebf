"""The cells of a sweep that are conveyed fastest."""

from __future__ import annotations

import numpy as np
import pytest

from vibro import Scene, solve
from vibro.results.sweep import Peak, at_rest, peaks

NAN = np.nan
EXACT = np.zeros(4)
FREQUENCY = {"frequency": np.array([10.0, 20.0, 30.0, 40.0]), "amplitude": 1.0}


def test_the_fastest_forwards_and_backwards_in_the_units_of_tables() -> None:
    found = peaks(np.array([0.25, 0.25, -0.3, 0.0]), EXACT, FREQUENCY)
    assert found == {
        "fastest": Peak(250.0, 0.0, {"amplitude": 1.0, "frequency": 10.0}),  # the first of two
        "fastest_backwards": Peak(-300.0, 0.0, {"amplitude": 1.0, "frequency": 30.0}),
    }
    assert [*found["fastest"].values] == ["amplitude", "frequency"]  # in the order of tables


def test_quantities_are_broadcast_to_the_cells() -> None:
    speed = np.array([[0.1, 0.2, 0.0], [NAN, 0.1, 0.3]])
    values = {"frequency": np.array([[10.0, 20.0, 30.0]]), "drive_angle": np.array([[15.0], [25.0]])}
    assert peaks(speed, np.zeros((2, 3)), values)["fastest"].values == {
        "frequency": 30.0,
        "drive_angle": 25.0,
    }


def test_without_a_known_motion_there_is_none() -> None:
    for speed in ([-0.0] * 4, [NAN] * 4, [NAN, 0.0, NAN, np.inf]):
        assert peaks(np.array(speed), EXACT, FREQUENCY) == {}


def test_bodies_that_rest_and_those_that_cannot_be_do_not_move() -> None:
    static, amplitude = np.array([0.5, 0.7, 0.7]), np.array([1e-4, 1e-4, 5e-3])
    scene = Scene.allowing_infeasible(
        amplitude=amplitude, frequency=15.0, drive_angle=0.3, static_friction=static, kinetic_friction=0.6
    )
    assert at_rest(solve(scene)).tolist() == [True, True, False]


@pytest.mark.parametrize(("error", "counts"), [(0.0999, True), (0.1, False), (0.1001, False), (NAN, True)])
def test_a_mean_counts_beyond_three_standard_errors(error: float, counts: bool) -> None:
    speed, errors = np.array([-0.3, 0.1, 0.1, 0.1]), np.array([error, NAN, 0.0, 0.0])
    found = peaks(speed, errors, FREQUENCY)
    assert ("fastest_backwards" in found) is counts
    if counts:
        assert found["fastest_backwards"].error == pytest.approx(1e3 * np.nan_to_num(error))
