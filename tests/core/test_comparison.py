"""Comparison bodies: never faster than a body of their box, and as fast where it has no width."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from engines.certificates import bounds as independent_bounds
from helpers.cases import each
from helpers.draws import examples
from helpers.solver_boxes import bodies, box_of, largest_speed, solver_boxes
from hypothesis import assume, given
from hypothesis import strategies as st

import vibro
from vibro import Scene
from vibro.core.boxes import AXES, Box, least_speed

INF = math.inf
ROUNDING = 1e-14  # of the trough's largest speed
DRAWN = np.random.default_rng(3).random((AXES + 1, 192))
SHARES = np.hstack([DRAWN, np.round(DRAWN), np.where(DRAWN < 0.5, np.round(DRAWN), DRAWN)])


def bound(box: Box) -> float:
    return least_speed(box, box.low, box.high, 0)


def assert_none_is_slower(box: Box, every: int = 1) -> None:
    """Each of the bodies, or every so many, unless it has no steady motion."""
    cycle, least = bodies(box, SHARES[:, ::every]), bound(box)
    speed = box.way * np.asarray(cycle.mean_velocity)
    speed = speed[np.isfinite(speed) & (np.asarray(cycle.regime) < 3)]
    assert np.all(least <= speed + ROUNDING * largest_speed(box))


@examples(40)
@given(solver_boxes())
def test_no_body_is_slower_than_the_bound_of_its_box(box: Box) -> None:
    assert_none_is_slower(box)


@given(solver_boxes(widest=1e-3))
def test_no_body_is_slower_than_the_bound_of_a_narrow_box(box: Box) -> None:
    assert_none_is_slower(box)


@examples(30)
@given(solver_boxes(steep=True))
def test_no_body_is_slower_on_a_trough_on_which_some_run_away(box: Box) -> None:
    assert_none_is_slower(box)


@given(solver_boxes(widest=0.0))
def test_the_bound_of_a_single_body_is_its_speed(box: Box) -> None:
    """To rounding where it rests; where it never does it is followed until its cycles nearly repeat."""
    box = box._replace(frequency_low=15.0, factor_low=box.factor_high)
    cycle = bodies(box, np.zeros((AXES + 1, 1)))
    ratios = np.array([cycle.forward_ratio[0], cycle.back_ratio[0]])
    assume(cycle.status[0] == vibro.Status.OK and np.all(np.abs(ratios - 1.0) > 1e-3))  # no jump is near
    rests = cycle.regime[0] == 0 or "_" in str(cycle.pattern[0])
    assume(rests or strength(box) < 20.0)
    slack = (1e-11 if rests else 2e-5 * max(1.0, 0.2 * strength(box))) * largest_speed(box)
    assert bound(box) == pytest.approx(box.way * float(cycle.mean_velocity[0]), rel=0.0, abs=slack)


@given(solver_boxes(), st.integers(0, AXES - 1), st.floats(0.0, 1.0))
def test_a_part_of_a_box_has_no_lower_bound(box: Box, axis: int, share: float) -> None:
    low: Any = list(box.low)
    high: Any = list(box.high)
    cut = low[axis] + share * (high[axis] - low[axis])
    low[axis], high[axis] = (cut, high[axis]) if share < 0.5 else (low[axis], cut)
    assert least_speed(box, low, high, 0) >= bound(box) - 2e-5 * largest_speed(box)


@given(solver_boxes(), st.integers(0, 4))
def test_the_row_of_a_box_does_not_matter(box: Box, row: int) -> None:
    unused: Any = [math.nan] * (AXES * row)
    low, high = (unused + list(end) for end in (box.low, box.high))
    assert least_speed(box, low, high, row) == bound(box)


def strength(box: Box) -> float:
    """Largest push over the least friction [1]; beyond 20 cycles without rest take hundreds to settle."""
    return box.high[0] * (max(box.high[1:3]) if box.ellipse else 1.0) / box.low[6]


def own_bound(box: Box) -> float:
    """The bound of the checker's comparison body."""
    shape = (
        ("along_amplitude", "normal_amplitude", "normal_phase") if box.ellipse else ("drive_angle", "", "")
    )
    names = ("load", *shape, "trough_angle", "static_friction", "kinetic_friction")
    ends = {name: np.array([[low], [high]]) for name, low, high in zip(names, box.low, box.high, strict=True)}
    ends.pop("", None)
    band = {
        "friction_ratio": (box.ratio_low, box.ratio_high), "gravity": (box.gravity,),
        "amplitude": (box.factor_low, box.factor_high), "frequency": (box.frequency_low, box.frequency_high),
    }  # fmt: skip
    return float(independent_bounds(ends, band, box.way)[0])


@examples(10)
@given(solver_boxes())
def test_bounds_are_no_higher_than_those_of_another_program(box: Box) -> None:
    assume(strength(box) < 20.0)
    assert bound(box) <= own_bound(box) + 1e-11 * largest_speed(box)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_terms_that_are_at_their_worst_inside_a_band_count(way: float) -> None:
    """At drive angles about that of friction and its complement, on troughs whose slope is 1 / mu."""
    for drive in ((0.3, 0.8), (0.5, 0.55), (0.9, 1.2), (1.0, 1.1)):
        for beta in (-0.45, 0.0, 0.45):
            for load in (0.3, 0.8):
                box = line(load=(load, load), first=drive, beta=(beta, beta), way=way)
                assert bound(box) == pytest.approx(own_bound(box), abs=2e-5 * largest_speed(box))
    for slopes in ((0.5, 0.8), (0.6, 0.65), (-0.8, 0.8)):
        ends = sorted(way * b for b in slopes)
        steep = line(load=(1.9, 1.9), beta=(ends[0], ends[1]), static=(1.5, 1.5), kinetic=(1.4, 1.4), way=way)
        assert -INF < bound(steep) == pytest.approx(own_bound(steep), abs=2e-5 * largest_speed(steep))


LINE = [1.4, 0.35, 0.0, 0.0, 0.0, 0.74, 0.57]


def line(*, way: float = 1.0, **changed: Any) -> Box:
    """A box of a line; ends of bands by the names of its axes."""
    names = ("load", "first", "second", "third", "beta", "static", "kinetic")
    ends = [changed.pop(name, (x, x)) for name, x in zip(names, LINE, strict=True)]
    return box_of([low for low, _ in ends], [high for _, high in ends], way=way, **changed)


@pytest.mark.parametrize(
    ("beta", "way", "bounded"),
    [
        (math.atan(0.57) * (1.0 - 1e-9), 1.0, True), (math.atan(0.57) * (1.0 + 1e-9), 1.0, False),
        (-math.atan(0.57) * (1.0 - 1e-9), 1.0, True), (-math.atan(0.57) * (1.0 + 1e-9), 1.0, False),
        (math.atan(0.57) * (1.0 - 1e-9), -1.0, True), (math.atan(0.57) * (1.0 + 1e-9), -1.0, False),
    ],
)  # fmt: skip
def test_steep_troughs_have_no_bound(beta: float, way: float, bounded: bool) -> None:
    """A band too, if some trough of it is that steep upwards; downwards if all of them are."""
    assert (bound(line(beta=(beta, beta), load=(0.9, 0.9), way=way)) > -INF) is bounded


def test_bodies_that_do_not_slip_have_a_bound_of_0() -> None:
    """Up to the load at which the first one slips."""
    onset = 0.6 / (math.cos(0.35) + 0.6 * math.sin(0.35))
    for way in (1.0, -1.0):
        at_rest = line(load=(0.1, onset * (1.0 - 1e-9)), static=(0.6, 0.8), way=way)
        assert bound(at_rest) == 0.0
    moves = line(load=(0.1, onset * (1.0 + 1e-6)), static=(0.6, 0.8), way=-1.0)
    assert -1e-2 < bound(moves) < 0.0
    assert bound(line(load=(onset * (1.0 + 1e-6),) * 2, static=(0.6, 0.6))) > 0.0


@pytest.mark.parametrize(
    ("kinetic", "ratio", "has_bodies"),
    [
        ((0.5, 0.6), (0.7, 0.75), True), ((0.6, 0.7), (0.7, 0.75), True), ((0.61, 0.7), (0.7, 0.75), False),
        ((0.3, 0.489), (0.7, 0.75), False), ((0.3, 0.491), (0.7, 0.75), True),
        ((0.81, 0.9), (0.0, 1.0), False),
    ],
)  # fmt: skip
def test_a_box_without_bodies_has_the_bound_of_none(
    kinetic: tuple[float, float], ratio: tuple[float, float], has_bodies: bool
) -> None:
    box = line(static=(0.7, 0.8), kinetic=kinetic, ratio_low=ratio[0], ratio_high=ratio[1])
    assert (bound(box) < INF) is has_bodies


def test_friction_is_cut_where_its_ratio_has_a_band() -> None:
    """A band of kinetic friction beyond the ratios, or of static friction below them, costs nothing."""
    cut = line(static=(0.7, 0.7), kinetic=(0.49, 0.525), ratio_low=0.7, ratio_high=0.75)
    wide = line(static=(0.7, 0.7), kinetic=(0.2, 0.7), ratio_low=0.7, ratio_high=0.75)
    assert bound(wide) == pytest.approx(bound(cut), rel=1e-14)
    # at kinetic friction from 0.6 on there is no static friction below 0.8
    cut = line(load=(2.0, 2.0), static=(0.8, 0.9), kinetic=(0.6, 0.62), ratio_high=0.75)
    wide = line(load=(2.0, 2.0), static=(0.6, 0.9), kinetic=(0.6, 0.62), ratio_high=0.75)
    assert bound(wide) == pytest.approx(bound(cut), rel=1e-14)


def test_a_cycle_that_settles_slowly_is_followed_to_its_end() -> None:
    """After 30 cycles only; its first ones are faster."""
    scene = Scene(
        amplitude=3.1966e-3, frequency=15.0, drive_angle=0.2308, static_friction=0.18177,
        kinetic_friction=0.13857, trough_angle=0.12184,
    )  # fmt: skip
    box = box_of([float(scene.load), 0.2308, 0.0, 0.0, 0.12184, 0.18177, 0.13857])
    speed = float(vibro.solve(scene).mean_velocity)
    assert speed == pytest.approx(-0.277259, abs=1e-6)
    assert speed - 1e-6 <= bound(box) <= speed
    assert -speed - 1e-6 <= bound(box._replace(way=-1.0)) <= -speed


@each("way", [1.0, -1.0])
@each("drive", [0.0, 0.3, math.atan(0.74), 0.5 * math.pi - 1e-5])
@each("ratio", [0.0, 0.5, 1.0])
def test_no_body_is_slower_beside_a_threshold(drive: float, ratio: float, way: float) -> None:
    """Loads about the onsets of both ways, and up to the hop."""
    mu_s, hop = 0.74, 1.0 / max(math.sin(drive), 0.05)
    onsets = [mu_s / abs(math.cos(drive) + sigma * mu_s * math.sin(drive)) for sigma in (1.0, -1.0)]
    for onset in (*onsets, hop):
        for factor in (1.0 - 1e-12, 1.0, 1.0 + 1e-15, 1.0 + 1e-9, 1.0 + 1e-3):
            load = min(onset * factor, hop)
            low = [load, drive, 0.0, 0.0, 0.0, mu_s, ratio * mu_s]
            assert_none_is_slower(box_of(low, way=way), 12)
            for axis in (0, 1, 4, 5, 6):
                high = list(low)
                high[axis] = min(low[axis] + 1e-6, hop if axis == 0 else mu_s if axis == 6 else INF)
                if drive + high[4] < 0.5 * math.pi and high[0] * math.sin(high[1]) <= math.cos(high[4]):
                    assert_none_is_slower(box_of(low, high, way=way), 12)


@pytest.mark.parametrize("load", [14.4, 15.0, 20.0])
def test_a_cycle_counts_once_where_rounding_parts_it(load: float) -> None:
    """Without kinetic friction on a level trough a slide ends at the phase at which the next may start."""
    assert_none_is_slower(box_of([load, 0.0, 0.0, 0.0, 0.0, 0.5, 0.0], [load, 0.0, 0.0, 0.0, 0.0, 0.57, 0.0]))
    for drive in np.linspace(0.0, 0.2, 21):
        for way in (1.0, -1.0):
            least = min(load, 0.99 / max(math.sin(drive), 1e-3))
            assert_none_is_slower(box_of([least, float(drive), 0.0, 0.0, 0.0, 0.1167, 0.0], way=way))


def test_ellipses_are_lines_in_step() -> None:
    """Bounds of the same motion, in both kinds of coordinates."""
    for load in (0.9, 1.4, 2.5):
        for way in (1.0, -1.0):
            narrow = line(load=(load, load), way=way)
            along, normal = 1e-3 * math.cos(0.35), 1e-3 * math.sin(0.35)
            low = [1e3 * load, along, normal, 0.0, 0.0, 0.74, 0.57]
            assert bound(box_of(low, ellipse=True, way=way)) == pytest.approx(bound(narrow), rel=1e-6)
