"""Motion between two events: against quadrature, and to all digits however short it is."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest
from mpmath import mp, mpf
from numpy.typing import NDArray
from scipy.integrate import quad
from vibro.core.free import free_motion

Floats = NDArray[np.float64]

EPS = float(np.finfo(float).eps)


def _arrays(
    pull: float, drag: float, sine: float, cosine: float, velocity: float
) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    return np.array(pull), np.array(drag), np.array(sine), np.array(cosine), np.array(velocity)


@pytest.mark.parametrize(
    ("pull", "drag", "phase", "velocity"), [(1.2, 0.3, 0.4, 0.0), (0.7, -0.2, 5.1, -1.3)]
)
@pytest.mark.parametrize("s", [1e-4, 0.3, 2.9, 3.5, 9.0])
def test_path_and_velocity_are_the_integrals_of_the_acceleration(
    pull: float, drag: float, phase: float, velocity: float, s: float
) -> None:
    def acceleration(u: float) -> float:
        return pull * math.sin(phase + u) - drag

    path, speed = free_motion(
        *(np.array([x]) for x in (pull, drag, math.sin(phase), math.cos(phase), velocity, s))
    )
    gained = quad(acceleration, 0.0, s, epsabs=1e-13, epsrel=1e-12)[0]
    moved = quad(lambda u: (s - u) * acceleration(u), 0.0, s, epsabs=1e-13, epsrel=1e-12)[0]
    assert speed[0] == pytest.approx(velocity + gained, rel=1e-12, abs=1e-15)
    assert path[0] == pytest.approx(velocity * s + moved, rel=1e-12, abs=1e-15)


@pytest.mark.parametrize("sine", [0.0, 1.0, 0.6])
def test_short_motions_do_not_cancel(sine: float) -> None:
    # from 1e-12 rad on, over the change of the formula at 1 rad, to many turns
    s = np.concatenate(
        (np.geomspace(1e-12, 0.9, 40), np.linspace(0.99, 1.01, 21), np.linspace(1.1, 40.0, 50))
    )
    cosine = math.sqrt(1.0 - sine * sine)
    pull, drag, velocity = 1.3, 0.4, 0.7
    path, speed = free_motion(*_arrays(pull, drag, sine, cosine, velocity), s)
    with mp.workdps(60):
        for i, length in enumerate(map(mpf, s)):
            rise, versine = mpmath.sin(length), 1 - mpmath.cos(length)
            moved = pull * (sine * versine + cosine * (length - rise))
            gained = pull * (cosine * versine + sine * rise)
            size = velocity * length + abs(moved) + drag * length**2 / 2
            assert abs(velocity * length + moved - drag * length**2 / 2 - path[i]) < 8 * EPS * size
            size = velocity + pull * (cosine * versine + sine * abs(rise)) + drag * length
            assert abs(velocity + gained - drag * length - speed[i]) < 8 * EPS * (size + pull * EPS * length)


def test_the_path_from_rest_keeps_its_digits_where_it_is_third_order() -> None:
    # from the phase 0 without drag the whole path is s - sin s
    s = np.geomspace(1e-100, 3.0, 200)
    path, _ = free_motion(*_arrays(1.0, 0.0, 0.0, 1.0, 0.0), s)
    with mp.workdps(320):
        exact = [float(mpf(x) - mpmath.sin(mpf(x))) for x in s]
    assert path == pytest.approx(exact, rel=8 * EPS)
