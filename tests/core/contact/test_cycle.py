"""The steady cycle from rest: every pattern against an independent walk, and where patterns change."""

from __future__ import annotations

import math

import numpy as np
import pytest
from event_walk import TURN, Body
from scenes import Groups, at_load, groups_of, random_scenes, replaced, solve_one
from vibro.core.contact.limits import critical_loads

import vibro
from vibro import Status

EPS = float(np.finfo(float).eps)

FLAT = Groups(1.0, 20.0, 0.74, 0.57)
EQUAL_FRICTION = Groups(1.0, 6.0, 0.182, 0.182)
CLIMB = Groups(1.0, 16.44, 0.359, 0.242, 2.97)
STEEP_CLIMB = Groups(1.0, 8.631, 0.4358, 0.2052, 9.165)
ROUGH_CLIMB = Groups(1.0, 22.568, 0.2869, 0.2767, 5.454)
DESCENT = Groups(1.0, 9.03, 0.573, 0.48, -2.46)


def _displacement(cycle: vibro.SteadyCycle, scene: vibro.Scene) -> np.ndarray:
    """Displacement a cycle [g/w^2]."""
    return cycle.displacement_per_cycle * (TURN * scene.frequency) ** 2 / scene.gravity


@pytest.mark.parametrize(
    ("seed", "most_trough_deg", "least_ratio"), [(1, 0.0, 0.4), (2, 12.0, 0.4), (3, 5.0, 0.05)]
)
def test_the_finite_rule_is_what_a_walk_from_rest_settles_into(
    seed: int, most_trough_deg: float, least_ratio: float
) -> None:
    scene = random_scenes(600, seed, most_trough_deg=most_trough_deg, least_ratio=least_ratio)
    cycle = vibro.solve(scene)
    displacement = _displacement(cycle, scene)
    patterns = set()
    for i, groups in enumerate(groups_of(scene)):
        if cycle.status[i] == Status.RUNAWAY:
            with pytest.raises(ArithmeticError, match="never ends"):
                Body(groups).settle()
            continue
        assert cycle.status[i] == Status.OK
        walked = Body(groups).settle()
        assert walked.pattern == cycle.pattern[i], groups
        tolerance = 1e-10 * (abs(walked.displacement) + groups.load)
        assert walked.displacement == pytest.approx(displacement[i], abs=tolerance), groups
        patterns.add(walked.pattern)
    assert patterns >= {"_", "F_", "F_B_", "FB_", "F_B", "FB"}
    assert ("B_" in patterns) == (most_trough_deg > 0.0)


def _last_load_with(groups: Groups, pattern: str, low: float, high: float) -> float:
    """Bisect to the last load whose cycle has a pattern; ``high`` must have another one."""
    assert solve_one(groups._replace(load=low)).pattern == pattern
    assert solve_one(groups._replace(load=high)).pattern != pattern
    while (middle := 0.5 * (low + high)) not in (low, high):
        if solve_one(groups._replace(load=middle)).pattern == pattern:
            low = middle
        else:
            high = middle
    return low


@pytest.mark.parametrize(
    ("groups", "below", "above", "low", "high"),
    [
        (FLAT, "_", "F_", 0.60, 0.65),
        (FLAT, "F_", "F_B_", 1.05, 1.10),
        (FLAT, "F_B_", "FB_", 1.15, 1.36),
        (FLAT, "FB_", "FB", 1.36, 1.46),
        (EQUAL_FRICTION, "FB_", "FB", 0.340, 0.40),
        (CLIMB, "F_B", "FB", 0.60, 0.90),
        (STEEP_CLIMB, "B_", "F_B", 0.65, 0.72),
        (ROUGH_CLIMB, "F_B_", "F_B", 0.48, 0.52),
        (DESCENT, "FB_", "FB", 1.033, 1.30),
    ],
)
def test_patterns_change_at_one_load_and_their_status_says_how_near(
    groups: Groups, below: str, above: str, low: float, high: float
) -> None:
    last = _last_load_with(groups, below, low, high)
    for offset, pattern in ((-1e-12, below), (1e-12, above)):
        cycle = solve_one(groups._replace(load=last * (1.0 + offset)))
        assert cycle.pattern == pattern
        assert cycle.status == Status.OK
    ladder = [solve_one(groups._replace(load=last * (1.0 + i * EPS))) for i in range(-400, 401, 4)]
    patterns = [str(cycle.pattern) for cycle in ladder]
    change = patterns.index(above)
    assert set(patterns[:change]) == {below}
    assert set(patterns[change:]) == {above}
    called = [i for i, cycle in enumerate(ladder) if cycle.status == Status.BOUNDARY]
    assert called == list(range(called[0], called[-1] + 1))
    assert called[0] <= change <= called[-1] + 1
    # all that is called a boundary belongs to one side, and has a number
    assert len({patterns[i] for i in called}) == 1
    assert all(math.isfinite(ladder[i].mean_velocity) for i in called)


@pytest.mark.parametrize(
    "groups",
    [
        Groups(1.0, 44.8, 0.492, 0.189),
        Groups(1.0, 36.1, 0.667, 0.229),
        Groups(1.0, 19.0, 0.237, 0.103, -5.0),
        Groups(1.0, 29.8, 0.66, 0.256, -5.0),
    ],
)
def test_back_slip_sets_in_where_the_limits_say(groups: Groups) -> None:
    limits = critical_loads(
        np.radians(groups.drive_deg), groups.mu_s, groups.mu_d, np.radians(groups.trough_deg)
    )
    critical = float(limits.back_slip)
    assert critical > 1.01 * limits.back_onset  # until then the forward slide outlasts the window
    before, at, behind = (solve_one(groups._replace(load=critical * (1.0 + h))) for h in (-1e-12, 0.0, 1e-12))
    assert [before.pattern, at.pattern] == ["F_", "F_"]
    assert [before.status, at.status, behind.status] == [Status.OK, Status.BOUNDARY, Status.OK]
    assert "B" in str(behind.pattern)


def test_the_speed_is_continuous_where_rest_vanishes() -> None:
    for groups in (FLAT, CLIMB, DESCENT, EQUAL_FRICTION):
        limits = critical_loads(
            np.radians(groups.drive_deg), groups.mu_s, groups.mu_d, np.radians(groups.trough_deg)
        )
        critical = float(limits.rest_vanishes)
        before, behind = (solve_one(groups._replace(load=critical * (1.0 + h))) for h in (-1e-10, 1e-10))
        assert "_" in str(before.pattern)
        assert behind.pattern == "FB"
        step = abs(behind.mean_velocity - before.mean_velocity)
        assert step < 1e-4 * max(abs(behind.peak_velocity), abs(behind.mean_velocity))


def test_never_at_rest_the_speed_does_not_depend_on_static_friction() -> None:
    mu_s = np.linspace(0.57, 0.8, 24)
    cycle = vibro.solve(at_load(2.5, 20.0, mu_s, 0.57))
    assert set(cycle.pattern) == {"FB"}
    assert cycle.mean_velocity == pytest.approx(cycle.mean_velocity[0], rel=4 * EPS)


def test_the_never_at_rest_cycle_attracts_from_anywhere() -> None:
    groups = Groups(2.0, 15.0, 0.4, 0.3, 1.5)
    cycle = solve_one(groups)
    assert cycle.pattern == "FB"
    expected = float(_displacement(cycle, at_load(*groups)))
    for phase in np.arange(0.1, TURN, 0.7):
        body = Body(groups)
        way = 1 if body.inside(1, phase) else -1 if body.inside(-1, phase) else 0
        assert body.settle(phase, way).displacement == pytest.approx(expected, rel=1e-10)


def test_two_cycles_of_one_scene() -> None:
    # physics: conveys 6.4684 g/w^2 a cycle from rest and 0.5732 if disturbed
    groups = Groups(1.49149, math.degrees(0.7034), 0.457783, 0.0429106)
    cycle = solve_one(groups)
    assert cycle.coexists == 1
    assert cycle.pattern == "F_"
    assert f"{float(_displacement(cycle, at_load(*groups))):.4f}" == "6.4684"
    body = Body(groups)
    assert f"{body.settle().displacement:.4f}" == "6.4684"
    disturbed = body.settle(body.opens[-1], -1)
    assert disturbed.pattern == "FB"
    assert f"{disturbed.displacement:.4f}" == "0.5732"


@pytest.mark.parametrize(("seed", "trough_deg"), [(1, 0.0), (2, 3.0), (3, -3.0)])
def test_coexistence_is_flagged_where_starts_from_other_phases_settle_elsewhere(
    seed: int, trough_deg: float
) -> None:
    random = np.random.default_rng(seed)
    count = 20_000
    mu_s = random.uniform(0.2, 1.0, count)
    scene = at_load(
        random.uniform(0.3, 1.4, count),
        random.uniform(5.0, 40.0, count),
        mu_s,
        mu_s * random.uniform(0.1, 0.25, count),
        trough_deg,
    )
    cycle = vibro.solve(scene)
    slips_both_ways = (cycle.status == Status.OK) & (cycle.forward_ratio > 1.0) & (cycle.back_ratio > 1.0)
    # a disturbed body may run away where gravity beats kinetic friction: there the walk need not settle
    steep = abs(math.tan(math.radians(trough_deg))) > scene.kinetic_friction
    assert (cycle.coexists[slips_both_ways & steep] == 1).all()
    flagged = np.flatnonzero(slips_both_ways & ~steep & (cycle.coexists == 1))[:12]
    single = np.flatnonzero(slips_both_ways & (cycle.coexists == 0))[:12]
    assert flagged.size == single.size == 12
    scenes = groups_of(scene)
    for i in (*flagged, *single):
        body = Body(scenes[i])
        settled = {str(cycle.pattern[i])}
        for phase in np.arange(0.25, TURN, 0.5):
            way = 1 if body.inside(1, phase) else -1 if body.inside(-1, phase) else 0
            settled.add(body.settle(phase, way).pattern)
        assert (len(settled) == 2) == (cycle.coexists[i] == 1), scenes[i]


def test_the_flag_is_never_up_where_nothing_else_attracts() -> None:
    nearly_equal = random_scenes(20_000, seed=5, most_trough_deg=10.0, least_ratio=0.9)
    assert not (vibro.solve(nearly_equal).coexists == 1).any()
    # without kinetic friction there are other cycles, but no body tends to them
    frictionless = replaced(random_scenes(20_000, seed=6), kinetic_friction=0.0)
    assert not (vibro.solve(frictionless).coexists == 1).any()
