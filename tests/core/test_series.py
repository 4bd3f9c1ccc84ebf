"""Differences that cancel for small angles: their polynomials against mpmath."""

from __future__ import annotations

from typing import TYPE_CHECKING

import mpmath
import numpy as np
import pytest
from mpmath import mp, mpf
from vibro.core.free import GAP
from vibro.core.series import Q, R, sine_gap

if TYPE_CHECKING:
    from collections.abc import Callable

EPS = float(np.finfo(float).eps)


def _gap(x: mpf) -> mpf:
    return (x - mpmath.sin(x)) / x**3


def _bulge(x: mpf) -> mpf:
    return (mpmath.sin(x) - x * mpmath.cos(x)) / x**3


@pytest.mark.parametrize(
    ("coefficients", "function", "most"),
    [(Q, _gap, mpmath.pi), (R, _bulge, mpmath.pi), (GAP, _gap, mpf(1))],
    ids=["Q", "R", "GAP"],
)
def test_the_series_are_exact_up_to_the_rounding_of_their_coefficients(
    coefficients: tuple[float, ...], function: Callable[[mpf], mpf], most: mpf
) -> None:
    with mp.workdps(60):
        powers = range(len(coefficients) - 1, -1, -1)
        for i in range(1, 201):
            x = most * i / 200
            terms = [mpf(a) * x ** (2 * n) for a, n in zip(coefficients, powers, strict=True)]
            rounding = EPS / 2 * sum(abs(term) for term in terms)
            assert abs(sum(terms) - function(x)) < 6e-18 * function(x) + rounding


def test_the_gap_between_an_angle_and_its_sine_to_rounding() -> None:
    angles = np.concatenate((np.geomspace(1e-100, 1.0, 60), np.linspace(1.0, np.pi, 60)))
    with mp.workdps(320):
        exact = [float(mpf(x) - mpmath.sin(mpf(x))) for x in angles]
    assert sine_gap(angles) == pytest.approx(exact, rel=4 * EPS)
