"""Differences of an angle, its sine and its cosine, without cancellation where the angle is small."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

__all__ = ["Q", "R", "polynomial", "sine_gap"]

# 1 - sin(x)/x = x^2 Q(x^2) and sin x - x cos x = x^3 R(x^2) on 0 <= x <= pi, highest power first:
# Chebyshev economisations computed with 60 digits, error below 6e-18 of the value (test_series.py),
# since both differences cancel for short slides.
Q: Final = (
    -1.77516651900580094e-20, 8.18304374281322528e-18, -2.81102438733084008e-15, 7.64713352785736226e-13,
    -1.60590425313094057e-10, 2.50521083511001472e-8, -2.75573192234679305e-6, 0.00019841269841265893,
    -0.00833333333333332184, 0.166666666666666666,
)  # fmt: skip
R: Final = (
    7.7088580917279416e-22, -3.89610970345939686e-19, 1.47947161254262735e-16, -4.49831175269064113e-14,
    1.07060281802820307e-11, -1.92708525689134348e-9, 2.5052108384699699e-7, -0.0000220458553791796289,
    0.00119047619047618481, -0.033333333333333332, 0.333333333333333333,
)  # fmt: skip


def polynomial(y: Floats, coefficients: tuple[Any, ...]) -> Floats:
    """Horner's rule, in place; coefficients that are columns serve a row of ``y`` each."""
    value: Floats = coefficients[0] * y
    for a in coefficients[1:-1]:
        value += a
        value *= y
    value += coefficients[-1]
    return value


def sine_gap(x: Floats) -> Floats:
    """Compute x - sin x, 0 <= x <= pi, to rounding."""
    y = x * x
    return x * y * polynomial(y, Q)
