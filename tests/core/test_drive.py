"""Loads of drives: Eqs. (1) and (54), the ends of their ranges, and what a mirror shows."""

from __future__ import annotations

import math

import mpmath
import pytest
from mpmath import mp, mpf

from vibro.core.drive import (
    directions,
    line_loads,
    weight_over_load,
)


@pytest.mark.parametrize("drive", [0.3, 0.5, 1.2, 1.5, math.nextafter(0.5 * math.pi, 0.0)])
@pytest.mark.parametrize("beyond", [-0.3, -1e-12, -1e-15, -1e-16, 0.0, 1e-16, 1e-15, 1e-12, 0.3])
def test_a_line_at_a_right_angle_to_the_ground_or_beyond_is_solved_as_an_ellipse(
    drive: float, beyond: float
) -> None:
    trough = 0.5 * math.pi - drive + beyond
    with mp.workdps(60):
        exact = mpmath.cos(mpf(drive) + mpf(trough))
        angles = directions(drive, trough)
        assert abs(angles.sum_cosine - exact) <= 4e-16 * abs(exact)
    assert line_loads(2.0, angles, 0.5, 0.4).weight_across == 2.0 * angles.sum_cosine
    assert line_loads(0.8, angles, 0.5, 0.4).line == (exact > 0)


@pytest.mark.parametrize(
    ("amplitude", "frequency", "weight"), [(5e-324, 1e-300, 1e307), (1.7e308, 1e300, 1e-307)]
)
def test_weights_beyond_the_range_of_doubles_stay_in_it(
    amplitude: float, frequency: float, weight: float
) -> None:
    assert weight_over_load(amplitude, frequency, 9.81) == weight
