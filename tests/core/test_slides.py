"""Thresholds, onsets and slides from rest, of both kinds of drive: beside 50 digits."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import mpmath
import pytest
from helpers.cases import each
from helpers.contact_loads import EPS, MP, Exact, random_ellipses, random_loads
from mpmath import mp, mpf

from vibro.core import slides
from vibro.core.drive import Loads
from vibro.core.slides import (
    Onset,
    Start,
    cosine_lead,
    outlasts,
    phase_offset,
    reaches,
    resting_start,
    slide,
    speed_at_close,
    start_inside,
    thresholds,
)

if TYPE_CHECKING:
    from collections.abc import Iterator


WAYS = (1.0, -1.0)


def level(n: float, *, a: float = 1.0, b: float = 0.0, t: float = 0.0, mu_s: float = 1.0) -> Loads:
    """Make loads that are numbers as they stand."""
    return Loads(a, b, n, t, a * n - b * t, mu_s, 0.5 * mu_s, 0.0, 1.0, True)


# -------------------------------------------------------------------------------------- thresholds


@each("is_line", [True, False])
@each("b", [1e-3, 1e-9, 1e-15])
def test_margins_do_not_cancel_where_the_drive_hardly_lifts(is_line: bool, b: float) -> None:
    at = thresholds(level(2.0, b=b, mu_s=0.5)._replace(line=is_line))
    assert at.forward_margin == pytest.approx(0.5 * b, rel=4 * EPS)
    assert at.back_margin == pytest.approx(-0.5 * b, rel=4 * EPS)
    steep = thresholds(level(2.0, b=b, mu_s=0.5)._replace(line=False, phase_sine=1.0, phase_cosine=0.0))
    growth = 0.25 * b * b / (math.sqrt(1.0 + 0.25 * b * b) + 1.0)
    assert steep.forward_margin == steep.back_margin == pytest.approx(growth, rel=4 * EPS)


# ------------------------------------------------------------------------------------------- onsets


def _compare(loads: Loads, way: float) -> Start:
    """Compare a start with what Eq. (55) says of it, with 50 digits."""
    at, exact = thresholds(loads), Exact(loads)
    found = resting_start(loads, at, way)
    opens, closes = exact.window(way)
    kinetic = exact.load(way, exact.mu_d)
    own = opens + MP.arg(kinetic)
    load, window = abs(kinetic), (closes - opens) / 2
    onset = found.onset
    # rounding of the loads shifts the start by 1 / tan(window) of it
    margin = at.forward_margin if way > 0.0 else at.back_margin
    static_load = at.forward_load if way > 0.0 else at.back_load
    rounding = 16 * EPS * (1.0 + (static_load + abs(exact.resistance(way, exact.mu_s))) / margin)
    near = float(rounding * window) + 64 * EPS / float(load)
    c = MP.pi / 2 - own
    c -= MP.nint(c / (2 * MP.pi)) * 2 * MP.pi
    assert onset.c == pytest.approx(float(c), abs=near)
    assert onset.cos == pytest.approx(float(MP.cos(c)), abs=near)
    assert onset.sin == pytest.approx(float(MP.sin(c)), abs=near)
    assert onset.vers == pytest.approx(float(1 - MP.cos(c)), abs=near)
    assert onset.load == pytest.approx(float(load), rel=8 * EPS, abs=4 * EPS)
    assert onset.k == pytest.approx(
        float(exact.resistance(way, exact.mu_d) / load), rel=64 * EPS / float(load)
    )
    excess = exact.pull(way, exact.mu_d, opens) / load
    assert onset.excess == pytest.approx(float(excess), abs=near)
    assert onset.excess >= 0.0
    assert found.window == pytest.approx(float(window), abs=near)
    # slopes of the opposite slide's load at both edges of the window
    other = exact.load(-way, exact.mu_d)
    slopes = [float((other * MP.expj(p)).real) for p in (opens, closes)]
    assert [found.open_rate, found.close_rate] == pytest.approx(slopes, abs=near)
    return found


@pytest.mark.parametrize("way", WAYS)
def test_a_start_from_rest_of_an_ellipse(way: float) -> None:
    loads = [*random_ellipses(200, 6, steepest=0.8), *random_ellipses(200, 7, least_throw=0.99)]
    slips = [x for x in loads if (thresholds(x).forward if way > 0.0 else thresholds(x).back)]
    assert len(slips) > 150
    nearly_lifted = 0
    for x in slips:
        _compare(x, way)
        exact = Exact(x)
        normal = exact.n - exact.b * MP.sin(exact.window(way)[0])
        nearly_lifted += normal < slides._NEARLY_LIFTED * exact.n
    assert nearly_lifted > 20


def test_a_load_just_above_its_threshold_has_a_start_to_all_digits() -> None:
    # b = 0: the margin is exact, and c = acos(1 - margin)
    for margin in (1e-15, 1e-12, 1e-6, 0.3):
        n = 1.0 - margin
        for is_line in (True, False):
            loads = level(n)._replace(line=is_line)
            found = resting_start(loads, thresholds(loads), 1.0)
            exact = float(MP.acos(MP.mpf(n)))
            assert found.onset.c == pytest.approx(exact, rel=8 * EPS)
            assert found.window == pytest.approx(exact, rel=8 * EPS)
            assert found.onset.vers == pytest.approx(1.0 - n, rel=8 * EPS)
            assert found.onset.sin == pytest.approx(float(MP.sin(MP.acos(MP.mpf(n)))), rel=8 * EPS)
            assert found.onset.excess == pytest.approx(0.5 * n, rel=8 * EPS)


# -------------------------------------------------------------------------------------- what follows


def _lasts(loads: Loads, way: float, edge: int) -> int:
    """Whether a slide lasts to where the opposite window opens (edge 0) or closes (1)."""
    at = thresholds(loads)
    forward, back = resting_start(loads, at, 1.0), resting_start(loads, at, -1.0)
    own, other = (forward, back) if way > 0.0 else (back, forward)
    offset = way * phase_offset(loads, loads.static_friction)
    if edge == 0:
        return reaches(loads, own, other, offset)
    ahead, size = speed_at_close(own, other)
    if loads.line:
        ahead, size = cosine_lead(loads, at, forward.onset, back.onset)
        ahead *= way
    return outlasts(own, other, offset, ahead, size)


def _speed_there(loads: Loads, way: float, edge: int) -> tuple[Any, Any]:
    """Speed of the slide at that edge, or at its minimum if that comes first, and the size of its terms."""
    exact = Exact(loads)
    p0, load = exact.window(way)[0], exact.load(way, exact.mu_d)
    resistance = exact.resistance(way, exact.mu_d)
    p = exact.next_window(-way, p0)[edge]
    if edge == 1 and resistance < 0:  # the speed grows again from here
        least = MP.asin(resistance / abs(load)) - MP.arg(load)
        p = min(p, least + MP.ceil((p0 - least) / (2 * MP.pi)) * 2 * MP.pi)
    size = abs(load) + abs(exact.load(-way, exact.mu_d)) + abs(resistance) * (p - p0)
    return exact.speed(way, p0, p), size


def _kinds(loads: list[Loads]) -> Iterator[Loads]:
    """Those that slip both ways; lines also as ellipses."""
    for x in loads:
        at = thresholds(x)
        if at.forward and at.back:
            yield x
            if x.line:
                yield x._replace(line=False)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("edge", [0, 1])
def test_a_slide_lasts_to_an_edge_of_the_opposite_window_if_it_has_speed_there(way: float, edge: int) -> None:
    signs = []
    for x in _kinds(random_loads(100, 10, steepest=0.9, least_ratio=0.001) + random_loads(80, 11)):
        sign = _lasts(x, way, edge)
        signs.append(sign)
        speed, size = _speed_there(x, way, edge)
        if abs(speed) > 1e-12 * size:
            assert sign == MP.sign(speed)
    assert min(signs.count(1), signs.count(-1)) > 8


# ------------------------------------------------------------------------------
# One slide from rest: the start of its refinement, its end, path and peak against mpmath.


LOAD = 2.0  # a power of two changes no rounding


@pytest.fixture(autouse=True)
def _forty_digits_after_cancellation() -> Iterator[None]:
    # a slide of phase length 1e-12 loses 36 of its 100 digits, those 60 the bisection to 40
    with mp.workdps(100):
        yield


class ExactSlide(NamedTuple):
    """A slide to 40 digits or more: half its length, path and peak speed over its load amplitude."""

    x: mpf
    reach: mpf
    peak: mpf


def exact_onset(vers: float, excess: float, *, behind: bool = False) -> tuple[Onset, mpf, mpf]:
    """Round an onset that ``1 - sin p0`` and ``sin p0 - k`` define; return p0 and k to all digits too."""
    sine = 1 - mpf(vers)
    c = mpmath.acos(sine) * (-1 if behind else 1)
    k = sine - mpf(excess)
    fields = (c, sine, mpmath.sin(c), mpf(vers), mpf(excess), k, LOAD)
    return Onset(*map(float, fields)), mpmath.pi / 2 - c, k


def exact_slide(p0: mpf, k: mpf) -> ExactSlide:
    """Find the zero of a slide's speed between its maximum and its next minimum, or where it is over."""

    def speed(p: mpf) -> mpf:
        return mpmath.cos(p0) - mpmath.cos(p) - k * (p - p0)

    top = mpmath.pi - mpmath.asin(k)
    low, high = top, (2 * mpmath.pi - p0 if k >= 0 else 2 * mpmath.pi + mpmath.asin(k))
    assert speed(low) > 0 >= speed(high)
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (middle, high) if speed(middle) > 0 else (low, middle)
    p1 = (low + high) / 2
    for _ in range(5):  # Newton's method doubles the digits
        p1 -= speed(p1) / (mpmath.sin(p1) - k)
    path = mpmath.cos(p0) * (p1 - p0) - (mpmath.sin(p1) - mpmath.sin(p0)) - k * (p1 - p0) ** 2 / 2
    return ExactSlide((p1 - p0) / 2, path, speed(top))


def solved(onset: Onset) -> tuple[float, float, float]:
    end = slide(onset)
    assert end.settled
    return end.half_length, end.displacement / LOAD, end.peak / LOAD


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


def test_a_slide_that_starts_behind_the_crest_to_rounding() -> None:
    for vers in (1e-12, 1e-6, 1e-3, 0.1, 0.5, 0.9):
        for share in (1e-3, 0.1, 0.5, 0.9, 0.999):
            onset, p0, k = exact_onset(vers, share * (1.0 - vers), behind=True)
            exact = exact_slide(p0, k)
            x, reach, top = solved(onset)
            assert abs(x - exact.x) < 4 * EPS * exact.x
            assert abs(reach - exact.reach) < EPS * (24 * exact.reach + 2)
            assert abs(top - exact.peak) < EPS * (4 * exact.peak + 2)


def test_a_slide_that_follows_another_one_to_rounding() -> None:
    # anywhere in the window: what counts is the error beside a whole slide, not beside the shortest
    for c in (-1.57, -1.2, -0.8, -0.3, -0.01, -1e-5, -1e-10, 1e-10, 1e-5, 0.01, 0.3, 0.8, 1.2, 1.5, 1.57):
        for share in (1e-18, 1e-15, 1e-12, 1e-9, 1e-5, 0.01, 0.1, 0.5, 0.9, 0.99, 1 - 1e-6):
            k = share * math.cos(c)
            exact = exact_slide(mpmath.pi / 2 - mpf(c), mpf(k))
            x, reach, top = solved(start_inside(c, k, LOAD))
            # near the crest the load, and with it k - sin p0, hardly changes: 1 / (|c| + x) is the condition
            assert abs(x - exact.x) < EPS * (4 * exact.x + 1 / (abs(c) + exact.x))
            assert abs(reach - exact.reach) < EPS * (24 * exact.reach + 2)
            assert abs(top - exact.peak) < EPS * (4 * exact.peak + 2)


def test_a_slide_down_a_trough_steeper_than_kinetic_friction() -> None:
    ending = 0
    for c in (-1.5, -1.0, -0.3, 0.0, 0.3, 0.7, 1.0, 1.3, 1.5, 1.7, 2.5):
        for k in (-1e-12, -1e-6, -1e-3, -0.01, -0.05, -0.1, -0.2, -0.3, -0.5, -0.7, -0.9):
            onset, p0, exact_k = start_inside(c, k, LOAD), mpmath.pi / 2 - mpf(c), mpf(k)
            if mpmath.cos(c) < exact_k:
                continue  # no slide starts there
            slowest = 2 * mpmath.pi - mpmath.asin(-exact_k)
            spare = mpmath.cos(p0) - mpmath.cos(slowest) - exact_k * (slowest - p0)
            end = slide(onset)
            assert end.settled
            if spare > 0:
                assert end.half_length == math.inf
                assert math.isnan(end.displacement)
                assert end.peak > 0.0
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


@pytest.mark.parametrize("k", [-1e-9, -1e-3, -0.1, -0.4])
def test_whether_a_downhill_slide_ends_is_decided_where_its_speed_just_reaches_zero(k: float) -> None:
    slowest = 2 * mpmath.pi - mpmath.asin(-mpf(k))

    def spare(c: mpf) -> mpf:  # of speed at its slowest
        return mpmath.sin(c) - mpmath.cos(slowest) - mpf(k) * (slowest - mpmath.pi / 2 + c)

    low, high = mpf(-1), mpmath.pi / 2  # it ends from the former, not from the latter
    assert spare(low) < 0 < spare(high)
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if spare(middle) < 0 else (low, middle)
    scale = 1e-14 / max(abs(float(mpmath.cos(low))), 1e-3)
    assert slide(start_inside(float(low) - scale, k, LOAD)).half_length < 4.0
    assert slide(start_inside(float(low) + scale, k, LOAD)).half_length == math.inf


@pytest.mark.parametrize("k", [-1.0, -1.7, -1e300])
def test_weight_beyond_the_load_leaves_no_end(k: float) -> None:
    # |k| >= 1: the speed has no maximum any more
    end = slide(start_inside(0.4, k, LOAD))
    assert end.half_length == math.inf
    assert math.isnan(end.displacement)
