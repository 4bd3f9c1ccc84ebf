"""Loads of drives: Eqs. (1) and (54), the ends of their ranges, and what a mirror shows."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest
from mpmath import mp, mpf

from vibro.core.drive import (
    directions,
    ellipse_loads,
    line_loads,
    mirrored,
    normal_load,
    tangential_load,
    weight_over_load,
)

LINE = line_loads(0.8, directions(0.4, -0.1), 0.5, 0.3)
ELLIPSE = ellipse_loads(1.0, 0.3, 0.8, directions(-2.1, 0.15), 0.6, 0.4)
PHASES = np.linspace(-7.0, 7.0, 29).tolist()


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


@pytest.mark.parametrize("loads", [LINE, ELLIPSE])
def test_a_mirror_turns_the_load_along_the_trough_alone(loads: object) -> None:
    assert isinstance(loads, type(LINE))
    seen = mirrored(loads)
    assert not seen.line
    for p in PHASES:
        assert normal_load(seen, p) == normal_load(loads, p)
        assert tangential_load(seen, p) == pytest.approx(-tangential_load(loads, p), abs=2e-15)
    same = ("drive_tangential", "static_friction", "kinetic_friction")
    assert [getattr(seen, name) for name in same] == [getattr(loads, name) for name in same]
    assert mirrored(seen)._replace(line=loads.line) == loads
