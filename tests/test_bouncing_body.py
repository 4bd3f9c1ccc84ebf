"""The witnesses of hopping, in doubles and in many digits: against closed forms, SciPy and each other."""

from __future__ import annotations

import math
from functools import cache

import bouncing_runs
import numpy as np
import pytest
from bouncing_body import NAMES, TURN, Bodies, Floats
from bouncing_exact import Settled, follow
from bouncing_runs import long_run, recurrence
from engines.integrated import Body
from helpers.scenes import Groups
from numpy.typing import ArrayLike

Fields = dict[str, Floats]

FREQUENCY = 20.0
GRAVITY = 9.81
LENGTH = GRAVITY / (TURN * FREQUENCY) ** 2  # g/w^2

# Values that need many digits: period, displacement a turn over A cos(alpha).
CHAOTIC = (
    0.0020474208511995144,
    0.4827495094596426,
    0.2654692864610031,
    0.23758149756649322,
    0.5657701716863576,
)
LONG = (
    0.007718065953433521,
    0.33669881340850877,
    0.26965814310580927,
    0.21193762500279054,
    0.5545462625724595,
)
WITHOUT_CONTACT = (0.00832842715129821, 0.2759119957044087, 0.684972411896944, 0.0, 0.02454508144177142)


def scenes(*rows: tuple[float, ...]) -> Fields:
    """Form scenes from amplitude, drive angle, mu_s, mu_d and e."""
    amplitude, alpha, mu_s, mu_d, e = np.array(rows).T
    return fields(amplitude, alpha, mu_s, mu_d, e, 0.0)


def at_throw(
    throw: ArrayLike, alpha_deg: float, mu_s: float, mu_d: float, e: float = 0.0, beta: float = 0.0
) -> Fields:
    alpha = math.radians(alpha_deg)
    return fields(np.multiply(throw, math.cos(beta) / math.sin(alpha) * LENGTH), alpha, mu_s, mu_d, e, beta)


def fields(amplitude: Floats, *others: ArrayLike) -> Fields:
    alpha, mu_s, mu_d, e, beta = others
    values = np.broadcast_arrays(amplitude, FREQUENCY, alpha, mu_s, mu_d, beta, GRAVITY, e)
    return dict(zip(NAMES, values, strict=True))


@cache
def exactly(values: tuple[float, ...]) -> Settled:
    found = follow([field.item() for field in scenes(values).values()], 40)
    assert found is not None
    return found


@pytest.mark.parametrize(("throw", "e"), [(2.2, 0.3), (1.2, 0.5)])
def test_bodies_move_as_integrated_ones(throw: float, e: float) -> None:
    bodies = Bodies(at_throw(throw, 30.0, 0.5, 0.4, e))
    integrated = Body(Groups(2.0 * throw, 30.0, 0.5, 0.4), e)
    turns = 3
    for _ in range(turns):
        bodies.turn()
    integrated.until(turns * TURN)
    place, velocity, height, rise = integrated.state
    found = [*bodies.states(np.array([0]))[0], bodies.place[0] / (2.0 * throw)]
    assert found == pytest.approx([height, rise, velocity, place], abs=1e-6)


def test_doubles_agree_with_digits_where_they_suffice() -> None:
    found = recurrence(scenes(LONG, WITHOUT_CONTACT))
    for i, values in enumerate((LONG, WITHOUT_CONTACT)):
        truth = exactly(values)
        speed = TURN * FREQUENCY * values[0]
        assert found.period[i] == truth.period
        assert found.displacement[i] / values[0] == pytest.approx(truth.displacement, rel=1e-7)
        assert found.peak[i] / speed == pytest.approx(truth.peak, rel=1e-7)
        assert found.flight_fraction[i] == pytest.approx(truth.flight_fraction, rel=1e-7)


@pytest.mark.parametrize(
    ("values", "period", "displacement"),
    [(CHAOTIC, 33, 0.566787), (LONG, 12, 1.999176), (WITHOUT_CONTACT, 2, 6.276968)],
)
def test_digits_decide(values: tuple[float, ...], period: int, displacement: float) -> None:
    truth = exactly(values)
    assert truth.period == period
    assert truth.displacement / math.cos(values[1]) == pytest.approx(displacement, abs=1e-5)


def test_noise_shows_where_rounding_repeats(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("FIRST_WINDOW", "MOST_PERIOD"):
        monkeypatch.setattr(bouncing_runs, name, 32)
    both = scenes(CHAOTIC, (0.002, 0.5, 0.5, 0.4, 0.0))
    means, size = long_run(both, copies=4, last=32), both["amplitude"]
    assert means.error[0] > 1e-3 * size[0]
    assert means.error[1] < 1e-12 * size[1]
    assert means.displacement[1] == pytest.approx(recurrence(both).displacement[1], rel=1e-9)
