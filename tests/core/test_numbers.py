"""Signs, series and the motion between two events: beside mpmath and quadrature."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import mpmath
import numpy as np
import pytest
from mpmath import mp, mpf

from vibro.core.numbers import (
    free_motion,
    hypotenuse,
    rounded_sign,
    series_q,
    series_r,
    sine_gap,
    wrap,
    wrap_around,
)

if TYPE_CHECKING:
    from collections.abc import Callable


EPS = 2.0**-52


def test_phases_are_reduced_to_one_turn() -> None:
    turn = 2.0 * math.pi
    for phase in (0.0, 1.0, 3.0, 4.0, 6.0):
        for turns in (-3, -1, 0, 1, 5):
            assert wrap(phase + turns * turn) == pytest.approx(phase, abs=1e-14)
            around = phase if phase < math.pi else phase - turn
            assert wrap_around(phase + turns * turn) == pytest.approx(around, abs=1e-14)
    assert wrap(turn) == 0.0
    assert wrap_around(-math.pi) == -math.pi == wrap_around(math.pi)


@pytest.mark.parametrize("scale", [1.0, 1e-150, 1e-200, 1e150, 1e200, 1e307])
def test_the_length_of_a_vector_whatever_its_size_and_direction(scale: float) -> None:
    for x, y in ((3.0, 4.0), (-4.0, 3.0), (4.0, -3.0), (-3.0, -4.0), (-5.0, 0.0), (0.0, -5.0)):
        assert hypotenuse(x * scale, y * scale) == pytest.approx(5.0 * scale, rel=4 * EPS)
    assert hypotenuse(0.0, -0.0) == 0.0
    assert hypotenuse(-math.inf, scale) == math.inf == hypotenuse(scale, math.inf)


@pytest.mark.parametrize("scale", [1.0, 3.0, 1e-200])
def test_a_sign_that_rounding_decides_is_zero(scale: float) -> None:
    noise = 16 * EPS * scale
    assert [rounded_sign(s * noise, scale) for s in (-1.0, -0.5, 0.0, 0.5, 1.0)] == [0] * 5
    assert rounded_sign(noise * (1.0 + EPS), scale) == 1
    assert rounded_sign(-noise * (1.0 + EPS), scale) == -1


def _gap(x: mpf) -> mpf:
    return (x - mpmath.sin(x)) / x**3


def _bulge(x: mpf) -> mpf:
    return (mpmath.sin(x) - x * mpmath.cos(x)) / x**3


@pytest.mark.parametrize(("series", "exact"), [(series_q, _gap), (series_r, _bulge)], ids=["Q", "R"])
def test_the_series_are_exact_up_to_the_rounding_of_their_coefficients(
    series: Callable[[mpf], mpf], exact: Callable[[mpf], mpf]
) -> None:
    with mp.workdps(60):  # all of a series in multiple precision, but for its coefficients
        for i in range(1, 201):
            x = mpmath.pi * i / 200
            sizes = series(-x * x)  # their signs alternate
            assert abs(series(x * x) - exact(x)) < 6e-18 * exact(x) + EPS / 2 * sizes


def test_the_gap_between_an_angle_and_its_sine_to_rounding() -> None:
    angles = np.concatenate((np.geomspace(1e-100, 1.0, 60), np.linspace(1.0, np.pi, 60))).tolist()
    with mp.workdps(320):
        for x in angles:
            assert sine_gap(x) == pytest.approx(float(mpf(x) - mpmath.sin(mpf(x))), rel=4 * EPS)


@pytest.mark.parametrize("sine", [0.0, 1.0, 0.6])
def test_short_motions_do_not_cancel(sine: float) -> None:
    # from 1e-12 rad on, over the change of the formula at 1 rad, to many turns
    lengths = [*np.geomspace(1e-12, 0.9, 40), *np.linspace(0.99, 1.01, 21), *np.linspace(1.1, 40.0, 50)]
    cosine = math.sqrt(1.0 - sine * sine)
    amplitude, drag, velocity = 1.3, 0.4, 0.7
    with mp.workdps(60):
        for s in map(float, lengths):
            path, speed = free_motion(amplitude, drag, sine, cosine, velocity, s)
            length = mpf(s)
            rise, versine = mpmath.sin(length), 1 - mpmath.cos(length)
            moved = amplitude * (sine * versine + cosine * (length - rise))
            size = velocity * length + abs(moved) + drag * length**2 / 2
            assert abs(velocity * length + moved - drag * length**2 / 2 - path) < 8 * EPS * size
            gained = amplitude * (cosine * versine + sine * rise)
            size = velocity + amplitude * (cosine * versine + sine * abs(rise)) + drag * length
            assert abs(velocity + gained - drag * length - speed) < 8 * EPS * (size + EPS * length)


# ------------------------------------------------------------------------------
# Zeros by halving, by false position and by Newton's iteration, and where they give up.
