"""One slide: the start of its refinement, its end, path and peak against mpmath."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import mpmath
import numpy as np
import pytest
from mpmath import mp, mpf
from vibro.core.contact.slide import Onset, slide, start_inside

from vibro.core.contact import slide as module

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

EPS = float(np.finfo(float).eps)


@pytest.fixture(autouse=True)
def _forty_digits_after_cancellation() -> Iterator[None]:
    # a slide of phase length 1e-12 loses 36 of its 100 digits, those 60 the bisection to 40
    with mp.workdps(100):
        yield


class Exact(NamedTuple):
    """A slide to 40 digits or more: half its length, path and peak speed over its load amplitude."""

    x: mpf
    reach: mpf
    peak: mpf


def exact_onset(vers: float, excess: float, *, behind: bool = False) -> tuple[Onset, mpf, mpf]:
    """Round an onset that ``1 - sin p0`` and ``sin p0 - k`` define; return p0 and k to all digits too."""
    sine = 1 - mpf(vers)
    c = mpmath.acos(sine) * (-1 if behind else 1)
    k = sine - mpf(excess)
    fields = (c, sine, mpmath.sin(c), mpf(vers), mpf(excess), k)
    return Onset(*(np.array([float(value)]) for value in fields)), mpmath.pi / 2 - c, k


def exact_slide(p0: mpf, k: mpf) -> Exact:
    """Bisect the speed of a slide between its maximum and its next minimum, or where it is surely over."""

    def speed(p: mpf) -> mpf:
        return mpmath.cos(p0) - mpmath.cos(p) - k * (p - p0)

    top = mpmath.pi - mpmath.asin(k)
    low, high = top, (2 * mpmath.pi - p0 if k >= 0 else 2 * mpmath.pi + mpmath.asin(k))
    assert speed(low) > 0 >= speed(high)
    for _ in range(int(3.4 * mp.dps / 2)):
        middle = (low + high) / 2
        low, high = (middle, high) if speed(middle) > 0 else (low, middle)
    p1 = (low + high) / 2
    path = mpmath.cos(p0) * (p1 - p0) - (mpmath.sin(p1) - mpmath.sin(p0)) - k * (p1 - p0) ** 2 / 2
    return Exact((p1 - p0) / 2, path, speed(top))


def solved(onset: Onset) -> tuple[float, float, float]:
    end = slide(onset)
    assert end.settled.all()
    return end.x.item(), end.reach.item(), end.peak.item()


def test_a_slide_from_rest_to_rounding() -> None:
    # 1 - sin p0 down to slides of 1e-12 rad, up to a start at phase 1e-7; mu_d = mu_s (excess 0) to k -> 0
    starts = (1e-24, 1e-16, 1e-10, 1e-6, 1e-3, 0.1, 0.3, 0.5, 0.8, 0.99, 1 - 1e-6, 1 - 1e-10, 1 - 1e-13)
    shares = (0.0, 1e-15, 1e-10, 1e-5, 0.01, 0.1, 0.3, 0.6, 0.9, 0.99, 1 - 1e-5, 1 - 1e-9, 1 - 1e-13)
    for vers in starts:
        for share in shares:
            onset, p0, k = exact_onset(vers, share * min(1.0 - vers, 100.0 * vers))
            exact = exact_slide(p0, k)
            x, reach, top = solved(onset)
            assert abs(x - exact.x) < 4 * EPS * exact.x
            assert abs(reach - exact.reach) < 20 * EPS * exact.reach
            assert abs(top - exact.peak) < 4 * EPS * exact.peak


def test_a_slide_that_follows_another_one_to_rounding() -> None:
    # anywhere in the window: what counts is the error beside a whole slide, not beside the shortest
    for c in (-1.57, -1.2, -0.8, -0.3, -0.01, -1e-5, -1e-10, 1e-10, 1e-5, 0.01, 0.3, 0.8, 1.2, 1.5, 1.57):
        for share in (1e-18, 1e-16, 1e-15, 1e-12, 1e-9, 1e-5, 0.01, 0.1, 0.5, 0.9, 0.99, 0.999, 1 - 1e-6):
            k = share * float(np.cos(c))
            exact = exact_slide(mpmath.pi / 2 - mpf(c), mpf(k))
            x, reach, top = solved(start_inside(np.array([c]), np.array([k])))
            # near the crest the load, and with it k - sin p0, hardly changes: 1 / (|c| + x) is the condition
            assert abs(x - exact.x) < EPS * (4 * exact.x + 1 / (abs(c) + exact.x))
            assert abs(reach - exact.reach) < EPS * (24 * exact.reach + 2)
            assert abs(top - exact.peak) < EPS * (4 * exact.peak + 2)


def test_a_slide_without_resistance_lasts_until_the_mirrored_phase() -> None:
    c = np.array([0.0, 1e-8, 0.5, 1.0, 1.5, 0.5 * np.pi])
    end = slide(start_inside(c, np.zeros(c.size)))
    assert end.settled.all()
    assert end.x == pytest.approx(0.5 * np.pi + c, rel=2 * EPS)


def _slopes(c: float, k: float) -> tuple[Onset, mpf, mpf]:
    return start_inside(np.array([c]), np.array([k])), mpmath.pi / 2 - mpf(c), mpf(k)


def test_a_slide_down_a_trough_steeper_than_kinetic_friction() -> None:
    ending = 0
    for c in (-1.5, -1.0, -0.3, 0.0, 0.3, 0.7, 1.0, 1.3, 1.5):
        for k in (-1e-12, -1e-6, -1e-3, -0.01, -0.05, -0.1, -0.2, -0.3, -0.5, -0.7, -0.9):
            onset, p0, exact_k = _slopes(c, k)
            slowest = 2 * mpmath.pi - mpmath.asin(-exact_k)
            spare = mpmath.cos(p0) - mpmath.cos(slowest) - exact_k * (slowest - p0)
            end = slide(onset)
            if spare > 0:
                assert end.x.item() == np.inf
                assert np.isnan(end.reach.item())
                continue
            ending += 1
            exact = exact_slide(p0, exact_k)
            x, reach, top = solved(onset)
            braking = abs(mpmath.sin(p0 + 2 * exact.x) - exact_k)  # of the speed at its zero
            tolerance = 8 * EPS * (1 + 1 / braking)
            assert abs(x - exact.x) < tolerance
            assert abs(reach - exact.reach) < 4 * tolerance
            assert abs(top - exact.peak) < 8 * EPS
    assert ending > 30


def test_slides_of_every_kind_share_one_call() -> None:
    c = np.array([0.7, 0.7, 0.7, -0.4])
    k = np.array([0.3, -0.02, -0.9, 0.1])
    together = slide(start_inside(c, k))
    for i in range(c.size):
        alone = slide(start_inside(c[i : i + 1], k[i : i + 1]))
        assert together.x[i] == alone.x[0]
        assert np.array_equal(together.reach[i], alone.reach[0], equal_nan=True)
    assert np.isinf(together.x).tolist() == [False, False, True, False]


def _grid(side: float) -> Onset:
    """Onsets before (+1) or behind (-1) the crest, dense, and logarithmic towards every corner."""
    # behind the crest a start rounded at 1e-16 leaves slides shorter than that without a length
    small = np.logspace(-15 if side > 0.0 else -6, -2, 200)
    distance = np.concatenate([small, np.linspace(0.01, 0.99, 400), 1.0 - small[::-1]])
    share = np.concatenate([[0.0] * (side > 0.0), small, np.linspace(0.01, 0.99, 300), 1.0 - small[::-1]])
    u, e = (a.ravel() for a in np.meshgrid(distance, share))
    quarter = 0.5 * np.pi
    c = side * quarter * u
    vers = 2.0 * np.sin(0.5 * c) ** 2
    cos = np.where(u > 0.5, np.sin(quarter * (1.0 - u)), 1.0 - vers)
    return Onset(c, cos, np.sin(c), vers, cos * e, cos * (1.0 - e))


@pytest.mark.parametrize(("side", "bound"), [(1.0, 0.012), (-1.0, 0.0125)])
def test_the_refinement_starts_within_its_basin(side: float, bound: float) -> None:
    onset = _grid(side)
    p0 = 0.5 * np.pi - onset.c
    x = slide(onset).x
    start = module._start(onset, 2.0 * np.arcsin(np.sqrt(0.5 * (onset.vers + onset.excess))))
    double_root = np.sqrt(p0 * p0 + 4.0 * onset.k * (np.pi - p0))  # distance to the other root for k, p0 -> 0
    distance: NDArray[np.float64] = np.minimum(x, np.minimum(1.0, x) * np.minimum(1.0, double_root))
    rounding = 3e-15
    assert (np.abs(start - x) <= bound * distance + rounding).all()
    # and the refinement got x right: Eq. (12) holds there
    residual = np.sin(p0 + x) * np.sin(x) - onset.k * x
    assert np.abs(residual).max() < 4e-15


def test_a_slide_that_starts_where_the_load_has_fallen_to_its_resistance_has_no_length() -> None:
    for c in (-0.5, -1.2, -1e-3):
        onset = start_inside(np.array([c]), np.array([math.cos(c)]))
        end = slide(onset._replace(excess=np.zeros(1)))
        assert end.x.item() == pytest.approx(0.0, abs=1e-15)
        assert end.reach.item() == pytest.approx(0.0, abs=1e-15)


def test_weight_beyond_the_pull_leaves_no_end() -> None:
    # |k| >= 1: the speed has no maximum any more
    onset = start_inside(np.array([0.4, 0.4]), np.array([-1.0, -1.7]))
    end = slide(onset)
    assert np.isinf(end.x).all()
    assert np.isnan(end.reach).all()
