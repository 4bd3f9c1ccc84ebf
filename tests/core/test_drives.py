"""Loads of drives: Eqs. (1) and (54), the ends of their ranges, and what a mirror shows."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest
from mpmath import mp, mpf

from vibro.core.drive import (
    Directions,
    directions,
    ellipse_loads,
    ellipse_scale,
    line_loads,
    mirrored,
    normal_load,
    phase_difference,
    tangential_load,
    trough_along,
    weight_over_load,
)
from vibro.core.waves import one_harmonic

EPS = 2.0**-52
LINE = line_loads(0.8, directions(0.4, -0.1), 0.5, 0.3)
ELLIPSE = ellipse_loads(1.0, 0.3, 0.8, directions(-2.1, 0.15), 0.6, 0.4)
PHASES = np.linspace(-7.0, 7.0, 29).tolist()


def test_directions_are_the_functions_of_both_angles() -> None:
    found = directions(0.3, 0.2)
    expected = (math.cos(0.3), math.sin(0.3), math.cos(0.2), math.sin(0.2), math.cos(0.3 + 0.2))
    assert found == Directions(*expected)
    assert directions(0.3, 0.0) == Directions(math.cos(0.3), math.sin(0.3), 1.0, 0.0, math.cos(0.3))


@pytest.mark.parametrize("drive", [0.0, 0.3, 0.5, 1.2, 1.5])
def test_a_line_at_a_right_angle_to_the_ground_or_beyond_is_solved_as_an_ellipse(drive: float) -> None:
    right = 0.5 * math.pi - drive
    for trough in (right, math.nextafter(right, 2.0), right + 0.3):
        angles = directions(drive, trough)
        assert angles.sum_cosine <= 0.0
        assert angles.sum_cosine == pytest.approx(math.cos(drive + trough), abs=1e-15)
        assert not line_loads(0.8, angles, 0.5, 0.4).line
    assert line_loads(0.8, directions(drive, right - 1e-15), 0.5, 0.4).line
    assert directions(drive, right - 1e-15).sum_cosine > 0.0


def test_groups_of_a_line() -> None:
    with mp.workdps(40):
        alpha, beta, weight = mpf(0.4), mpf(-0.1), mpf(0.8)
        a, b = mpmath.cos(alpha), mpmath.sin(alpha)
        n, t = weight * mpmath.cos(beta), weight * mpmath.sin(beta)
        exact = [float(x) for x in (a, b, n, t, a * n - b * t)]
    assert LINE[:5] == pytest.approx(exact, rel=2 * EPS)
    assert LINE[5:] == (0.5, 0.3, 0.0, 1.0, True, one_harmonic())


def test_the_normal_component_of_weight_along_the_line_does_not_cancel() -> None:
    alpha, beta = 1.2, 0.5 * math.pi - 1.2 - 1e-12
    with mp.workdps(40):
        exact = float(mpmath.cos(mpf(alpha + beta)))
    assert line_loads(2.0, directions(alpha, beta), 0.5, 0.3).weight_across == 2.0 * exact


def test_groups_of_an_ellipse() -> None:
    assert ELLIPSE[:2] == (1.0, 0.3)
    assert ELLIPSE[2:4] == (0.8 * math.cos(0.15), 0.8 * math.sin(0.15))
    assert ELLIPSE[4:7] == (0.0, 0.6, 0.4)
    assert ELLIPSE[7:] == (math.sin(-2.1), math.cos(-2.1), False, one_harmonic())


@pytest.mark.parametrize(
    ("along", "normal", "scale"), [(2.0, 3.0, 3.0), (3.0, 2.0, 3.0), (0.0, 1e-9, 1e-9), (0.0, 0.0, 1.0)]
)
def test_the_scale_is_the_larger_amplitude(along: float, normal: float, scale: float) -> None:
    assert ellipse_scale(along, normal) == scale


def test_weight_over_load() -> None:
    assert weight_over_load(2e-3, 15.0, 9.81) == pytest.approx(
        9.81 / (2e-3 * (30.0 * math.pi) ** 2), rel=1e-15
    )
    # products that overflow or vanish on the way
    assert weight_over_load(1e-300, 1e200, 1e100) == pytest.approx(1.0 / (2.0 * math.pi) ** 2, rel=1e-14)
    assert weight_over_load(1e300, 1e-200, 1e-100) == pytest.approx(1.0 / (2.0 * math.pi) ** 2, rel=1e-14)


@pytest.mark.parametrize(
    ("amplitude", "frequency", "weight"), [(5e-324, 1e-300, 1e307), (1.7e308, 1e300, 1e-307)]
)
def test_weights_beyond_the_range_of_doubles_stay_in_it(
    amplitude: float, frequency: float, weight: float
) -> None:
    assert weight_over_load(amplitude, frequency, 9.81) == weight


def test_loads_at_a_phase_of_the_normal_motion() -> None:
    for p in PHASES:
        assert normal_load(ELLIPSE, p) == ELLIPSE.weight_normal - 0.3 * math.sin(p)
        assert tangential_load(ELLIPSE, p) == pytest.approx(
            math.sin(p + 2.1) - ELLIPSE.weight_tangential, abs=2e-15
        )
        assert tangential_load(LINE, p) == pytest.approx(
            math.cos(0.4) * math.sin(p) - LINE.weight_tangential, abs=2e-15
        )
        assert trough_along(ELLIPSE, p).path == pytest.approx(math.sin(p + 2.1), abs=2e-15)
        assert trough_along(ELLIPSE, p).velocity == pytest.approx(math.cos(p + 2.1), abs=2e-15)
        assert trough_along(LINE, p).velocity == math.cos(p)


def test_the_phase_difference_lies_within_half_a_turn() -> None:
    assert phase_difference(LINE) == 0.0
    for phase in (-3.1, -1.0, 0.0, 0.5, 3.1):
        found = phase_difference(ellipse_loads(1.0, 0.3, 0.8, directions(phase, 0.0), 0.6, 0.4))
        assert found == pytest.approx(phase, abs=2e-15)
    beyond = ellipse_loads(1.0, 0.3, 0.8, directions(4.0, 0.0), 0.6, 0.4)
    assert phase_difference(beyond) == pytest.approx(4.0 - 2.0 * math.pi, abs=2e-15)


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
