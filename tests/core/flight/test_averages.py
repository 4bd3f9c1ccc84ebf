"""Means of motions whose cycle rounding would choose, beside walks of other bodies and among themselves."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
from hopping import hopping_cycles, loads_at_throw

from vibro import Status
from vibro.core.flight.averages import averages
from vibro.core.flight.cycles import HoppingCycles
from vibro.core.groups import Loads, take
from vibro.core.walk.steps import course_of, starting, step

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

TURN = 2.0 * np.pi
WALKERS = 24


def _walked(scene: Loads, restitution: Floats, lead: float, cycles: float) -> tuple[Floats, Floats]:
    """Mean displacement per drive cycle [A] of bodies walked leg by leg, and its error from their scatter.

    They start at rest at phases of their own; what they do in the cycles before ``lead`` is left out.
    """
    n = restitution.size
    owner = np.repeat(np.arange(n), WALKERS)
    course = course_of(take(scene, owner), restitution[owner])
    at = starting(course, np.tile(np.linspace(0.1, 6.2, WALKERS), n), np.zeros(owner.size))
    marks = np.full((2, 2, owner.size), np.nan)  # begin and end: position, time
    while np.isnan(marks).any():
        now = at.cycle + at.phase / TURN
        for mark, due in zip(marks, (lead, lead + cycles), strict=True):
            passed = np.isnan(mark[0]) & (now >= due)
            mark[:, passed] = at.position[passed], now[passed]
        at = step(course, at).after
    path, time = marks[1] - marks[0]
    rates = (path / time).reshape(n, WALKERS)
    return rates.mean(axis=1), rates.std(axis=1, ddof=1) / np.sqrt(WALKERS)


@pytest.mark.parametrize(
    ("throw", "drive_deg", "restitution"), [(2.45, 30.0, 0.3), (4.0, 20.0, 0.8), (3.0, 30.0, 0.9)]
)
def test_means_are_those_of_other_bodies_walked_for_long(
    throw: float, drive_deg: float, restitution: float
) -> None:
    scene, e = loads_at_throw([throw], drive_deg, 0.5, 0.4), np.array([restitution])
    mean = hopping_cycles(scene, e)
    assert mean.status[0] == Status.AVERAGED
    walked, error = _walked(scene, e, 100.0, 300.0)
    assert (np.abs(mean.displacement - walked) < 5.0 * np.hypot(mean.deviation, error)).all()
    # neither error is so large that it hides one
    assert mean.deviation[0] < 0.15 * mean.displacement[0]
    assert error[0] < 0.1 * walked[0]


def test_an_average_has_an_error_and_no_period() -> None:
    scene = loads_at_throw(np.linspace(2.4, 2.5, 12), 30.0, 0.5, 0.4)
    mean = averages(scene, np.full(12, 0.3), length=12, longest=True)
    assert (mean.status == Status.AVERAGED).all()
    assert (mean.deviation > 0.0).all()
    assert np.isnan(mean.period).all()
    assert (mean.flight_fraction > 0.5).all()
    assert (mean.flight_fraction <= 1.0 + 1e-12).all()
    assert (mean.peak > 0.0).all()
    assert (mean.impact > 0.0).all()
    assert (mean.coexists == -1).all()


def test_the_error_shrinks_with_the_root_of_the_sample() -> None:
    scene, e = loads_at_throw(np.linspace(2.4, 2.5, 12), 30.0, 0.5, 0.4), np.full(12, 0.3)
    short, long = (averages(scene, e, length=n, longest=True) for n in (8, 72))
    error = np.hypot(short.deviation, long.deviation)
    assert (np.abs(short.displacement - long.displacement) < 5.0 * error).all()
    ratio = np.sqrt((short.deviation**2).mean() / (long.deviation**2).mean())
    assert 2.0 < ratio < 4.5  # 3


def test_a_mean_is_the_same_whatever_is_solved_with_it() -> None:
    # friction that lets bodies stop, and hardly any
    throw, mu_d = np.array([2.42, 3.3, 2.46, 5.1, 1.7]), np.array([0.4, 0.3, 1e-6, 0.4, 1e-3])
    scene = loads_at_throw(throw, 30.0, 0.5, mu_d)
    restitution = np.array([0.3, 0.5, 0.3, 0.8, 0.7])
    together = averages(scene, restitution, length=6, longest=True)
    assert (together.status == Status.AVERAGED).all()
    order = np.array([3, 0, 4, 2, 1])
    turned = averages(take(scene, order), restitution[order], length=6, longest=True)
    for i in range(5):
        alone = averages(take(scene, np.array([i])), restitution[i : i + 1], length=6, longest=True)
        for name in HoppingCycles._fields:
            value = getattr(together, name)[i]
            assert np.array_equal(getattr(alone, name)[0], value, equal_nan=True), name
            there = getattr(turned, name)[int(np.flatnonzero(order == i)[0])]
            assert np.array_equal(there, value, equal_nan=True), name


def test_bounces_that_hardly_lose_anything_have_a_true_mean() -> None:
    scene, e = loads_at_throw([1.3, 3.0], 30.0, 0.5, 0.4), np.full(2, 0.999)
    mean = hopping_cycles(scene, e)
    assert (mean.status == Status.AVERAGED).all()
    # their energy takes some 1 / (1 - e) cycles to settle
    walked, error = _walked(scene, e, 2000.0, 2000.0)
    assert (np.abs(mean.displacement - walked) < 5.0 * np.hypot(mean.deviation, error)).all()


def test_bodies_that_gravity_drives_on_without_a_stop_run_away() -> None:
    throw, restitution = np.repeat([1.5, 2.45, 4.0], 4), np.tile([0.0, 0.3], 6)
    scene = loads_at_throw(throw, 30.0, 0.5, 0.2, np.tile([-15.0, -15.0, 15.0, 15.0], 3))
    assert (hopping_cycles(scene, restitution).status == Status.RUNAWAY).all()
