"""How the speed follows the scale of a motion: differences of the exact solution."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vibro import Motion, Scene, solve
from vibro.slopes import load_slope, scale_slope

FRICTION = {"static_friction": 0.4, "kinetic_friction": 0.3}


def test_of_one_harmonic_they_are_the_closed_form() -> None:
    """Wherever the difference is kept; it is left out next to onsets and changes of the pattern alone."""
    x, y = 1e-3, np.array([2e-4, 3e-4])[:, np.newaxis]
    frequency, phase = np.linspace(10.0, 25.0, 400), np.radians(-60.0)
    ellipse = Scene(
        along_amplitude=x, normal_amplitude=y, normal_phase=phase, frequency=frequency, **FRICTION
    )
    same = Scene(along_harmonics=[(x, 0.0)], normal_harmonics=[(y, phase)], frequency=frequency, **FRICTION)
    cycle = solve(ellipse, flight=False)
    found = scale_slope(same, solve(same, flight=False))
    with np.errstate(divide="ignore", invalid="ignore"):
        # the unit of length grows with the motion: one more power of it
        expected = 1.0 + load_slope(ellipse, cycle.pattern_code) / (
            cycle.displacement_per_cycle / ellipse.scale
        )
    known = np.isfinite(found)
    moves = np.isfinite(expected) & (cycle.displacement_per_cycle != 0.0)
    assert not known[~moves].any()
    assert known[moves].mean() > 0.95
    error = np.abs(found - expected)[known] / (1.0 + np.abs(expected[known]))
    assert error.max() < 1e-6
    assert np.median(error) < 1e-10


def test_of_steps_they_follow_the_speed() -> None:
    motion = Motion.steps([(0.8, 3.5), (0.2, -14.0)])
    scene = Scene(motion=motion, frequency=5.0, **FRICTION)
    slope = float(scale_slope(scene, solve(scene)))
    up, down = (
        float(solve(Scene(motion=motion, motion_scale=c, frequency=5.0, **FRICTION)).mean_velocity)
        for c in (1.01, 1.0 / 1.01)
    )
    assert slope == pytest.approx(math.log(up / down) / (2.0 * math.log(1.01)), rel=1e-4)


@pytest.mark.parametrize("scale", [0.1, 3.924 / 14.0 * (1.0 + 1e-5), 100.0], ids=["rest", "onset", "hops"])
def test_there_are_none_at_rest_beside_an_onset_and_in_flight(scale: float) -> None:
    normal = [(0.5, 2.0), (0.5, -2.0)] if scale > 50.0 else None
    motion = Motion.steps([(0.8, 3.5), (0.2, -14.0)], normal)
    scene = Scene(motion=motion, motion_scale=scale, frequency=5.0, **FRICTION)
    assert np.isnan(scale_slope(scene, solve(scene)))
