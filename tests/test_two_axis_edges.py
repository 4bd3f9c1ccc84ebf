"""Elliptical drives just below, at and just above everything that is special about them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers.two_axis_scenes import EPS, TURN, Drives, compare, displacement, drives, random_drives, rounding

import vibro
from vibro import Regime, Status

NEAR = (-1e-12, 0.0, 1e-12)


def _labels(cycle: vibro.SteadyCycle) -> list[str]:
    return [Regime(r).label for r in np.atleast_1d(cycle.regime)]


# --- amplitudes of zero -----------------------------------------------------------------------------


@pytest.mark.parametrize("normal", [0.0, 5e-324, 1e-300])
def test_without_normal_motion_a_level_trough_conveys_nothing(normal: float) -> None:
    along = np.array([1e-3, 0.5, 1.0 - 1e-12, 1.0, 1.0 + 1e-12, 1.1, 1.5, 2.0, 5.0, 100.0])
    some = drives(along * 0.4, normal, np.linspace(-3.0, 3.0, 10), 0.4, [0.1, 0.3, 0.4, 0.3, 0.3] * 2)
    cycle = some.solve()
    assert (np.abs(displacement(cycle)) <= 16.0 * EPS * some.along).all()
    assert cycle.pattern.tolist()[:4] == ["_"] * 4
    assert set(cycle.pattern.tolist()[4:]) == {"F_B_", "FB"}
    assert [Status(s) for s in cycle.status] == [*[Status.OK] * 3, Status.BOUNDARY, *[Status.OK] * 6]


def test_without_normal_motion_bodies_slide_down_the_trough() -> None:
    seen = compare(random_drives(30, 11, steepest=0.9).changed(normal=0.0))
    assert len(seen) >= 4


@pytest.mark.parametrize("above", [1e-1, 1e-3, 1e-5, 1e-7, 1e-9, 1e-11])
def test_without_kinetic_friction_a_quarter_turn_ends_slides_where_the_window_closes(above: float) -> None:
    draw = np.random.default_rng(3)
    mu_s, ratio = draw.uniform(0.1, 1.0, 400), draw.uniform(0.1, 3.0, 400)
    along = mu_s / np.hypot(1.0, mu_s * ratio) * (1.0 + above)
    borne = ratio * along < 1.0
    cycle = drives(along[borne], (ratio * along)[borne], math.pi / 2.0, mu_s[borne], 0.0).solve()
    assert np.count_nonzero(borne) > 100
    assert (cycle.status == Status.BOUNDARY).all()


# --- phases -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("lead", [0.0, 0.5 * math.pi, -0.5 * math.pi, math.pi, -math.pi, TURN, -TURN])
def test_special_leads_are_nothing_special(lead: float) -> None:
    some = random_drives(12, 14, steepest=0.5)
    cycles = [some.changed(lead=value).solve() for value in (lead - 1e-12, lead, lead + 1e-12)]
    size = np.abs(displacement(cycles[1])) + np.maximum(some.along, some.normal)
    for other in cycles[::2]:
        assert cycles[1].pattern.tolist() == other.pattern.tolist()
        apart = np.abs(displacement(cycles[1]) - displacement(other))
        assert not (apart > 1e-9 * size).any()
    compare(some.changed(lead=lead))


def test_leads_count_modulo_turns() -> None:
    some = random_drives(300, 15, steepest=0.9)
    here = some.solve()
    allowed = 16.0 * rounding(some, here)
    for turns in (-2, -1, 1, 2):
        there = some.changed(lead=some.lead + turns * TURN).solve()
        assert there.pattern.tolist() == here.pattern.tolist()
        assert not (np.abs(displacement(there) - displacement(here)) > allowed).any()


# --- equal values -----------------------------------------------------------------------------------


def test_equal_coefficients_of_friction_are_the_limit() -> None:
    some = random_drives(15, 17, steepest=0.9)
    some = some.changed(mu_d=some.mu_s)
    compare(some)
    here = some.solve()
    allowed = 16.0 * rounding(some, here)
    there = some.changed(mu_d=np.nextafter(some.mu_s, 0.0)).solve()
    assert there.pattern.tolist() == here.pattern.tolist()
    assert not (np.abs(displacement(there) - displacement(here)) > allowed).any()


# --- thresholds -------------------------------------------------------------------------------------


@pytest.mark.parametrize("way", [1, -1])
def test_bodies_slip_above_an_onset(way: int) -> None:
    some = random_drives(200, 19 + way, steepest=0.9, throw=(0.05, 0.9))
    first = some.onset(way) < some.onset(-way)
    contact = some.onset(way) * some.normal < 0.95 * np.cos(some.trough)
    some = Drives(*(x[first & contact] for x in some))
    assert some.lead.size > 30
    below, at, above = (some.scaled(some.onset(way) * (1.0 + h)).solve() for h in NEAR)
    letter = "_FB"[way]
    assert below.pattern.tolist() == at.pattern.tolist() == ["_"] * some.lead.size
    assert {text[0] for text in above.pattern[above.status == Status.OK].tolist()} == {letter}
    assert (below.status == Status.OK).all()
    assert (at.status == Status.BOUNDARY).all()
    assert np.isin(above.status, [Status.OK, Status.RUNAWAY]).all()
    ratio = "forward_ratio" if way > 0 else "back_ratio"
    np.testing.assert_allclose(getattr(at, ratio), 1.0, rtol=1e-13)
    # what rounding of the sums in the onset can move it by
    slope, hold = way * np.sin(some.trough), some.mu_s * np.cos(some.trough)
    pull = (some.along + some.mu_s * some.normal) * some.onset(way) / (hold + slope)
    unsure = EPS * ((hold + np.abs(slope)) / (hold + slope) + pull)
    for steps in (-64, -8, -2, 0, 2, 8, 64):
        cycle = some.scaled(some.onset(way) * (1.0 + steps * unsure)).solve()
        rests = cycle.pattern == "_"
        assert rests[cycle.status == Status.BOUNDARY].all()
        if abs(steps) == 64:
            assert (rests == (steps < 0)).all()
            assert (cycle.status != Status.BOUNDARY).all()


def test_troughs_are_solved_about_as_steep_as_kinetic_friction_holds() -> None:
    some = random_drives(300, 31)
    steep = np.arctan(some.mu_d * np.random.default_rng(31).uniform(0.7, 1.2, 300))
    steep = np.minimum(steep, 0.99 * np.arctan(some.mu_s))
    trough = np.where(some.lead > 0.0, steep, -steep)
    seen = compare(some.changed(trough=trough, normal=some.normal * np.cos(trough)))
    assert seen.keys() >= {"runaway", "FB", "F_B", "FB_"}


# --- starts -----------------------------------------------------------------------------------------


def test_a_body_may_start_inside_a_window() -> None:
    some = random_drives(4000, 23, steepest=0.95, throw=(0.8, 0.999))
    normal = np.cos(some.trough) - some.normal * np.sin(some.lead)
    inside = np.abs(np.sin(some.trough)) > some.mu_s * normal
    some = Drives(*(x[inside][:50] for x in some))
    assert some.lead.size == 50
    assert {1.0, -1.0} == set(np.sign(some.trough))
    compare(some)


def test_where_cycles_coexist_the_answer_is_the_one_from_rest_at_phase_0() -> None:
    some = random_drives(20_000, 24)
    some = some.changed(mu_d=some.mu_s * np.linspace(0.02, 0.25, 20_000))
    cycle = some.solve()
    several = np.flatnonzero(cycle.coexists == 1)[::2][:60]
    assert several.size == 60
    some = Drives(*(x[several] for x in some))
    assert compare(some).keys() >= {"F_", "FB", "FB_"}
    others = 0
    for text, body, again in zip(cycle.pattern[several].tolist(), some.bodies(), some.bodies(), strict=True):
        for start, way in ((body, 1), (again, -1)):
            start.p, start.way = start.opens[way] % TURN, way
            others += start.settle().pattern != text
    assert others >= 50


# --- scenes without an answer -----------------------------------------------------------------------


def test_on_troughs_steeper_than_static_friction_bodies_run_away() -> None:
    some = random_drives(40, 25)
    for way in (1.0, -1.0):
        for above in (1e-12, 0.1):
            steep = some.changed(trough=-way * np.minimum(np.arctan(some.mu_s) * (1.0 + above), 1.5))
            cycle = steep.changed(normal=0.9 * some.normal * np.cos(steep.trough)).solve()
            assert (cycle.status == Status.RUNAWAY).all()
            assert np.isnan(cycle.mean_velocity).all()
            assert set(_labels(cycle)) == {"forward-slip" if way > 0.0 else "back-slip"}
