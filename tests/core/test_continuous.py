"""Continuous sliding: both slides end where the other one starts, with 50 digits; both solvers; its edges."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import pytest
from helpers.contact_loads import EPS, MP, TURN, Exact, heavier, line, random_ellipses, random_lines

from vibro.core import contact as module
from vibro.core.contact import (
    ContinuousSliding,
    continuous_motion,
    continuous_sliding,
    half_length_root,
    is_sure,
    likely_sliding,
    middle_phase,
    no_cycle,
)
from vibro.core.drive import Loads, mirrored
from vibro.core.slides import Start, resting_start, thresholds

if TYPE_CHECKING:
    from collections.abc import Iterator


class Case(NamedTuple):
    """Loads that slip both ways, and the slides from rest."""

    loads: Loads
    forward: Start
    back: Start

    def cycle(self) -> ContinuousSliding:
        return continuous_sliding(self.loads, self.forward, self.back)

    def by_half_length(self) -> ContinuousSliding:
        return half_length_root(self.loads, self.forward.onset, self.back.onset)

    def likely(self) -> ContinuousSliding:
        return likely_sliding(self.loads, self.forward.onset, self.back.onset)


def case(loads: Loads) -> Case | None:
    at = thresholds(loads)
    if not (at.forward and at.back):
        return None
    return Case(loads, resting_start(loads, at, 1.0), resting_start(loads, at, -1.0))


def cases(loads: Iterator[Loads] | list[Loads]) -> list[Case]:
    return [found for found in map(case, loads) if found]


LINES = cases(random_lines(400, 1)) + cases(random_lines(400, 2, steepest=0.9))
ELLIPSES = cases(random_ellipses(400, 3)) + cases(random_ellipses(800, 4, steepest=0.9, least_ratio=0.02))
STEEP = [x for x in ELLIPSES if module._is_steep(x.loads)]


class Legs(NamedTuple):
    """Phases of the normal motion at which the forward and the back slide start and end."""

    forward: tuple[Any, Any]
    back: tuple[Any, Any]


def legs(loads: Loads, cycle: ContinuousSliding) -> Legs:
    phase = MP.atan2(loads.phase_sine, loads.phase_cosine)
    middle = phase + MP.pi - MP.atan2(cycle.sin_m, cycle.cos_m)
    x = MP.pi / 2 + MP.mpf(cycle.y)
    return Legs((middle - x, middle + x), (middle + x, middle - x + 2 * MP.pi))


def size_of(loads: Loads) -> float:
    weight = loads.kinetic_friction * loads.weight_normal + abs(loads.weight_tangential)
    return 1.0 + loads.kinetic_friction * loads.drive_normal + 4.0 * weight


def assert_closed(loads: Loads, cycle: ContinuousSliding, tolerance: float) -> None:
    """Check that both slides come to a stop where the other one starts."""
    exact, found = Exact(loads), legs(loads, cycle)
    assert abs(exact.speed(1.0, *found.forward)) < tolerance * size_of(loads)
    assert abs(exact.speed(-1.0, *found.back)) < tolerance * size_of(loads)
    assert (cycle.sin_y, cycle.cos_y) == pytest.approx((math.sin(cycle.y), math.cos(cycle.y)), abs=4 * EPS)
    assert cycle.sin_m**2 + cycle.cos_m**2 == pytest.approx(1.0, abs=8 * EPS)
    assert abs(cycle.y) < 0.5 * math.pi


# ------------------------------------------------------------------------------------------ the cycle


def test_the_cycle_of_a_line_closes() -> None:
    found = [(x, x.cycle()) for x in LINES]
    closed = [(x, cycle) for x, cycle in found if not math.isnan(cycle.y)]
    for x, cycle in closed:
        assert_closed(x.loads, cycle, 1e-13 if x.loads.weight_tangential else 64 * EPS)
        assert cycle.sin_m > 0.0 < cycle.cos_m
    assert len(closed) > 300
    assert len(found) - len(closed) > 40


def test_the_cycle_of_an_ellipse_closes() -> None:
    found = [(x, x.cycle()) for x in ELLIPSES]
    closed = [(x, cycle) for x, cycle in found if not math.isnan(cycle.y)]
    for x, cycle in closed:
        assert_closed(x.loads, cycle, 1e-13)
        assert cycle.sin_m > 0.0
    assert len(closed) > 300
    assert len(found) - len(closed) > 40


@pytest.mark.parametrize("some", [LINES, ELLIPSES], ids=["lines", "ellipses"])
def test_it_is_valid_where_both_slides_start_beyond_static_friction(some: list[Case]) -> None:
    said = []
    for x in some:
        cycle = x.cycle()
        if math.isnan(cycle.y):
            assert cycle[:5] == pytest.approx(no_cycle()[:5], nan_ok=True)
            assert (cycle.valid, cycle.edge) == (False, False)
            continue
        exact, found = Exact(x.loads), legs(x.loads, cycle)
        excess = min(
            exact.pull(1.0, exact.mu_s, found.forward[0]), exact.pull(-1.0, exact.mu_s, found.back[0])
        )
        if abs(excess) > 1e-12:
            assert cycle.valid == (excess > 0)
            assert not cycle.edge
            said.append(cycle.valid)
    assert min(said.count(True), said.count(False)) > 50


def test_a_line_as_an_ellipse_has_the_same_cycle() -> None:
    for x in LINES:
        same = case(x.loads._replace(line=False))
        assert same
        ours, other = x.cycle(), same.cycle()
        if ours.valid or other.valid:
            assert ours[:5] == pytest.approx(other[:5], abs=1e-11)
            assert ours.valid == other.valid


def test_both_equations_have_the_same_root() -> None:
    # Eq. (60) is Eq. (61) where its middle comes after the crest of each load
    valid = 0
    for x in LINES + ELLIPSES:
        cycle, other = x.likely(), x.by_half_length()
        if is_sure(x.loads, cycle):
            assert cycle.valid == other.valid
            if cycle.valid:
                valid += 1
                assert cycle[:5] == pytest.approx(other[:5], abs=1e-11)
    assert valid > 500


def test_what_is_not_sure_is_solved_for_half_the_length() -> None:
    unsure = [x for x in ELLIPSES if not is_sure(x.loads, x.likely())]
    unsure += [
        x
        for x in cases(random_ellipses(1500, 5, steepest=0.7, least_ratio=0.02))
        if not is_sure(x.loads, x.likely())
    ]
    missed = 0
    for x in unsure:
        assert x.cycle()[:5] == pytest.approx(x.by_half_length()[:5], nan_ok=True, abs=0.0)
        missed += x.by_half_length().valid and not x.likely().valid
    assert missed > 2
    # steep troughs are sure at once
    assert len(STEEP) > 60
    for x in STEEP:
        assert x.likely()[:5] == pytest.approx(x.by_half_length()[:5], nan_ok=True, abs=0.0)


def test_a_mirror_swaps_both_slides() -> None:
    for x in ELLIPSES[::3] + STEEP:
        seen = case(mirrored(x.loads))
        assert seen
        ours, other = x.by_half_length(), seen.by_half_length()
        assert ours.valid == other.valid
        if not math.isnan(ours.y):
            assert other.y == pytest.approx(-ours.y, abs=1e-12)
            assert (other.sin_m, other.cos_m) == pytest.approx((ours.sin_m, ours.cos_m), abs=1e-11)


def test_without_kinetic_friction_there_is_none() -> None:
    for loads in (line(20.0, 0.4, 0.5, 0.0), line(20.0, 0.4, 0.5, 0.0)._replace(line=False)):
        found = case(loads)
        assert found
        assert math.isnan(found.cycle().y)
        assert not found.cycle().valid


def test_slides_without_resistance_or_load_have_no_root() -> None:
    found = next(x for x in ELLIPSES if x.by_half_length().valid)
    forward, back = found.forward.onset, found.back.onset
    for k in (0.0, -0.1, 1.0):
        for ours, other in ((forward._replace(k=k), back), (forward, back._replace(k=k))):
            cycle = half_length_root(found.loads, ours, other)
            assert math.isnan(cycle.y)
            assert not cycle.valid


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("kind", ["line", "same", "ellipse"])
def test_its_validity_ends_where_rounding_says_so(seed: int, kind: str) -> None:
    draws = random_ellipses if kind == "ellipse" else random_lines
    found = 0
    for loads in draws(60, 10 + seed, steepest=0.5):
        loads = loads._replace(line=loads.line and kind != "same")
        x = case(loads)
        if not (x and x.cycle().valid and not x.cycle().edge):
            continue
        low, high = 1.0, 1.0
        for _ in range(40):
            high *= 1.03
            beyond = case(heavier(loads, high))
            if not beyond or not beyond.cycle().valid:
                break
        else:
            continue
        if beyond is None:
            continue
        while high - low > 2 * EPS * high:
            middle = 0.5 * (low + high)
            at = case(heavier(loads, middle))
            if at and at.cycle().valid:
                low = middle
            else:
                high = middle
        last = case(heavier(loads, low))
        assert last
        cycle = last.cycle()
        assert cycle.valid
        assert cycle.edge
        exact, phases = Exact(last.loads), legs(last.loads, cycle)
        excess = min(
            exact.pull(1.0, exact.mu_s, phases.forward[0]), exact.pull(-1.0, exact.mu_s, phases.back[0])
        )
        assert abs(excess) < 1e-13
        # but not for long
        before = case(heavier(loads, low * (1.0 - 1e-10)))
        assert before
        assert before.cycle().valid
        assert not before.cycle().edge
        found += 1
        if found == 3:
            return
    pytest.fail("no edge was met")


# ---------------------------------------------------------------------------------- displacement, peak


def _top(exact: Exact, way: float, begin: Any, end: Any) -> Any:
    """Largest speed of a slide: where its acceleration falls through zero."""
    load = exact.load(way, exact.mu_d)
    k = exact.resistance(way, exact.mu_d) / abs(load)
    p = MP.pi - MP.asin(k) - MP.arg(load)
    p += MP.ceil((begin - p) / (2 * MP.pi)) * 2 * MP.pi
    assert p < end
    return exact.speed(way, begin, p)


@pytest.mark.parametrize("some", [LINES, ELLIPSES, STEEP], ids=["lines", "ellipses", "steep"])
def test_displacement_and_peak_are_those_of_both_slides(some: list[Case]) -> None:
    count = 0
    for x in some:
        cycle = x.cycle()
        if not cycle.valid:
            continue
        count += 1
        motion = continuous_motion(x.loads, x.forward.onset, x.back.onset, cycle)
        exact, found = Exact(x.loads), legs(x.loads, cycle)
        displacement = exact.path(1.0, *found.forward) - exact.path(-1.0, *found.back)
        near = 1e-12 * size_of(x.loads)
        assert motion.displacement == pytest.approx(float(displacement), abs=near)
        tops = [_top(exact, 1.0, *found.forward), _top(exact, -1.0, *found.back)]
        assert motion.peak == pytest.approx(float(max(tops)), abs=near)
    assert count > (10 if some is STEEP else 200)


def test_the_displacement_of_a_flat_drive_does_not_cancel() -> None:
    # Eq. (20) for alpha -> 0 on a level trough: D = -2 cos(m) (2 + pi^2 / 2) mu_d alpha
    for drive in (1e-6, 1e-10, 1e-14):
        loads = line(math.degrees(drive), 0.5, 0.6, 0.5)
        found = case(loads)
        assert found
        cycle = found.cycle()
        sine = 0.25 * 0.5 * math.pi
        expected = 2.0 * math.sqrt(1.0 - sine * sine) * (2.0 + 0.5 * math.pi**2) * 0.5 * drive
        motion = continuous_motion(loads, found.forward.onset, found.back.onset, cycle)
        assert motion.displacement == pytest.approx(expected, rel=drive + 1e-14)


def test_the_middle_of_the_forward_slide_is_a_phase_of_the_normal_motion() -> None:
    for x in ELLIPSES[:200] + LINES[:50]:
        cycle = x.cycle()
        if not math.isnan(cycle.y):
            expected = sum(legs(x.loads, cycle).forward) / 2
            found = middle_phase(x.loads, cycle)
            assert math.remainder(found - float(expected), TURN) == pytest.approx(0.0, abs=1e-14)
