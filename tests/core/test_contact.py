"""The steady contact cycle from rest, its slides, and continuous sliding: walks and 50 digits."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import pytest
from engines.event_walk import Body as Walker
from engines.two_axis_walk import NeverEndsError, NeverSettlesError
from helpers.cases import each
from helpers.contact_loads import (
    EPS,
    MP,
    TURN,
    Exact,
    body_of,
    ellipse,
    heavier,
    line,
    random_ellipses,
    random_lines,
    random_loads,
)
from helpers.scenes import Groups
from helpers.two_axis_scenes import rotated

from vibro.core import contact as module
from vibro.core.codes import PATTERNS, Model, Pattern, Regime, Status
from vibro.core.contact import (
    ContinuousSliding,
    CycleSlides,
    SlideLeg,
    Steady,
    continuous_motion,
    continuous_sliding,
    cycle_slides,
    half_length_root,
    is_sure,
    likely_sliding,
    middle_phase,
    no_cycle,
    outlasts_back,
    pair_of,
    regime_alone,
    steady_cycle,
)
from vibro.core.drive import Loads, directions, line_loads, mirrored
from vibro.core.slides import Start, Thresholds, resting_start, thresholds

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from engines.two_axis_walk import Body, Cycle

    from vibro.core.drive import Loads


MODELS = {"_": Model.REST, "F_": Model.ONE_SLIDE, "B_": Model.ONE_SLIDE, "FB": Model.CLOSED_FORM}


def steady(loads: Loads) -> Steady:
    return steady_cycle(loads, thresholds(loads))


def pattern_of(loads: Loads) -> str:
    return PATTERNS[steady(loads).pattern]


def slips_both_ways(loads: Loads) -> bool:
    at = thresholds(loads)
    return at.forward and at.back


def at_load(groups: Groups, load: float) -> Loads:
    return line(groups.drive_deg, 1.0 / load, groups.mu_s, groups.mu_d, groups.trough_deg)


def settled(body: Body) -> Cycle:
    """Walk without the leaps that may carry a body past the cycle that it draws near."""
    body._leap = lambda legs: None  # type: ignore[method-assign]
    return body.settle()


# ------------------------------------------------------------------------------------ beside the walk


@pytest.mark.parametrize(("seed", "steepest", "least_ratio"), [(1, 0.0, 0.1), (2, 0.9, 0.02), (3, 0.3, 0.02)])
def test_the_finite_rule_is_what_a_walk_from_rest_settles_into(
    seed: int, steepest: float, least_ratio: float
) -> None:
    patterns = set()
    for loads in random_loads(60, seed, steepest=steepest, least_ratio=least_ratio):
        cycle = steady(loads)
        body = body_of(loads)
        try:
            walked = settled(body) if cycle.coexists == 1 else body.settle()
        except NeverEndsError:
            assert cycle.status == Status.RUNAWAY
            assert cycle.coexists == -1
            assert math.isnan(cycle.displacement)
            continue
        except NeverSettlesError:
            continue
        assert cycle.status == Status.OK
        pattern, weight = PATTERNS[cycle.pattern], math.hypot(loads.weight_normal, loads.weight_tangential)
        assert rotated(pattern) == walked.pattern, loads
        near = 1e-10 * (1.0 + abs(cycle.displacement))
        assert cycle.displacement == pytest.approx(weight * walked.displacement, abs=near)
        assert cycle.peak == pytest.approx(weight * walked.peak, abs=1e-10)
        expected = Regime.NO_SLIP if pattern == "_" else Regime.FORWARD_SLIP
        assert cycle.regime == (Regime.BACK_SLIP if "B" in pattern else expected)
        assert cycle.model == MODELS.get(pattern, Model.TWO_SLIDES)
        patterns.add(pattern)
    assert patterns >= {"_", "F_", "F_B_", "FB_", "FB"}
    assert (patterns >= {"B_", "F_B"}) or seed != 2


def test_a_line_as_an_ellipse_has_the_same_cycle() -> None:
    some = [*random_lines(500, 4), *random_lines(700, 5, steepest=0.9, least_ratio=0.02)]
    seen = set()
    for loads in some:
        ours, other = steady(loads), steady(loads._replace(line=False))
        assert ours[:4] == other[:4]
        assert ours.coexists == other.coexists
        # 1 - s of the onsets: conditions of both
        at = thresholds(loads)
        margins = [
            (margin / load)
            for margin, load in ((at.forward_margin, at.forward_load), (at.back_margin, at.back_load))
            if margin > 0.0
        ]
        near = 1e-13 * (1.0 + 1.0 / min(margins, default=1.0))
        assert ours.displacement == pytest.approx(other.displacement, rel=near, abs=near, nan_ok=True)
        assert ours.peak == pytest.approx(other.peak, rel=near, abs=near, nan_ok=True)
        seen.add(ours.pattern)
    assert seen == set(Pattern)


def _mirror_image(cycle: Steady) -> Steady:
    swaps = {Pattern.F_: Pattern.B_, Pattern.FB_: Pattern.F_B}
    swaps |= {b: a for a, b in swaps.items()}
    regimes = {Pattern.F_: Regime.FORWARD_SLIP, Pattern.R: Regime.NO_SLIP}
    pattern = swaps.get(Pattern(cycle.pattern), Pattern(cycle.pattern))
    return cycle._replace(
        pattern=pattern,
        displacement=-cycle.displacement,
        regime=regimes.get(pattern, Regime.BACK_SLIP),
    )


def test_a_mirror_image_slides_the_other_way() -> None:
    compared = set()
    for loads in random_loads(250, 6, steepest=0.6):
        loads = loads._replace(line=False)
        ours, seen = steady(loads), steady(mirrored(loads))
        if ours.status == Status.OK and ours.coexists == seen.coexists == 0:
            expected = _mirror_image(ours)
            assert (seen.regime, seen.pattern) == (expected.regime, expected.pattern)
            assert seen.displacement == pytest.approx(expected.displacement, abs=1e-11)
            assert seen.peak == pytest.approx(expected.peak, abs=1e-11)
            compared.add(seen.pattern)
    assert compared == set(Pattern) - {Pattern.NONE}
    named = [module._mirrored_pattern(p) for p in Pattern]
    assert named == [Pattern.NONE, Pattern.R, Pattern.B_, Pattern.F_, Pattern.F_B_, Pattern.F_B,
                     Pattern.FB_, Pattern.FB]  # fmt: skip


# ------------------------------------------------------------------------- scenes without a cycle


@each("solve", [steady_cycle, regime_alone])
@each(
    ("loads", "regime", "status"),
    [
        (line(20.0, 0.1, 0.5, 0.6), Regime.UNDEFINED, Status.INFEASIBLE),  # hops too
        (line(20.0, 0.1, 0.0, 0.0), Regime.HOPPING, Status.FLIGHT_NOT_MODELLED),
        (line(20.0, 0.1, 0.5, 0.4), Regime.HOPPING, Status.FLIGHT_NOT_MODELLED),
        (line(20.0, 0.9, 0.0, 0.0), Regime.UNDEFINED, Status.INDETERMINATE),
        (line(20.0, 0.9, 0.0, 0.0, 1e-13), Regime.BACK_SLIP, Status.RUNAWAY),
        (line(20.0, 0.9, 0.0, 0.0, -5.0), Regime.FORWARD_SLIP, Status.RUNAWAY),
        (line(20.0, 0.9, 0.3, 0.2, 25.0), Regime.BACK_SLIP, Status.RUNAWAY),
        (line(20.0, 0.9, 0.3, 0.2, -25.0), Regime.FORWARD_SLIP, Status.RUNAWAY),
        (ellipse(1.0, 0.2, 2.0, 0.9, 0.3, 0.2, 0.5), Regime.BACK_SLIP, Status.RUNAWAY),
        (line(80.0, 1.2, 0.4, 0.3, 30.0), Regime.BACK_SLIP, Status.RUNAWAY),  # 110 deg in all
    ],
)
def test_scenes_without_a_cycle_say_why(
    solve: Callable[[Loads, Thresholds], Steady], loads: Loads, regime: Regime, status: Status
) -> None:
    found = solve(loads, thresholds(loads))
    assert found[:4] == (regime, status, Pattern.NONE, Model.NONE)
    assert math.isnan(found.displacement)
    assert math.isnan(found.peak)
    assert found.coexists == -1


def test_a_slide_that_never_ends_is_no_cycle() -> None:
    # held by static friction alone, and pushed off its place by the drive
    for trough, way in ((14.0, Regime.BACK_SLIP), (-14.0, Regime.FORWARD_SLIP)):
        cycle = steady(line(20.0, 1.0, 0.3, 0.02, trough))
        assert (cycle.regime, cycle.status, cycle.coexists) == (way, Status.RUNAWAY, -1)
        assert (cycle.pattern, cycle.model) == (Pattern.NONE, Model.NONE)
        alone = regime_alone(*(lambda x: (x, thresholds(x)))(line(20.0, 1.0, 0.3, 0.02, trough)))
        assert (alone.regime, alone.status) == (way, Status.RUNAWAY)


def test_a_slide_whose_refinement_does_not_settle_is_unresolved(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vibro.core.slides._SETTLED", -1.0)
    seen = set()
    for weight in (0.9, 1.1, 0.85, 0.74, 0.7):
        for back in (1.0, -1.0):
            loads = line(20.0, weight, 0.74, 0.57)
            loads = loads if back > 0.0 else mirrored(loads)
            cycle = steady(loads)
            if cycle.status == Status.UNRESOLVED:
                seen.add(cycle.regime)
                assert (cycle.pattern, cycle.coexists) == (Pattern.NONE, -1)
                assert math.isnan(cycle.displacement)
    assert seen == {Regime.FORWARD_SLIP, Regime.BACK_SLIP}


# --------------------------------------------------------------------------------------- boundaries

FLAT = Groups(1.0, 20.0, 0.74, 0.57)
EQUAL_FRICTION = Groups(1.0, 6.0, 0.182, 0.182)
CLIMB = Groups(1.0, 16.44, 0.359, 0.242, 2.97)
STEEP_CLIMB = Groups(1.0, 8.631, 0.4358, 0.2052, 9.165)
ROUGH_CLIMB = Groups(1.0, 22.568, 0.2869, 0.2767, 5.454)
DESCENT = Groups(1.0, 9.03, 0.573, 0.48, -2.46)
LATE_BACK = Groups(1.0, 44.8, 0.492, 0.189)


@each("line_too", [True, False])
@each(
    ("groups", "below", "above", "low", "high"),
    [
        (FLAT, "_", "F_", 0.60, 0.65),
        (STEEP_CLIMB, "_", "B_", 0.2, 0.6),
        (FLAT, "F_", "F_B_", 1.05, 1.10),
        (FLAT, "F_B_", "FB_", 1.15, 1.36),
        (FLAT, "FB_", "FB", 1.36, 1.46),
        (FLAT, "FB", "", 2.5, 3.0),
        (EQUAL_FRICTION, "FB_", "FB", 0.340, 0.40),
        (CLIMB, "F_B", "FB", 0.60, 0.90),
        (STEEP_CLIMB, "B_", "F_B", 0.65, 0.72),
        (ROUGH_CLIMB, "F_B_", "F_B", 0.48, 0.52),
        (DESCENT, "FB_", "FB", 1.033, 1.30),
        (LATE_BACK, "F_", "FB", 1.0, 1.4),
    ],
)
def test_patterns_change_at_one_load_and_their_status_says_how_near(
    groups: Groups, below: str, above: str, low: float, high: float, line_too: bool
) -> None:
    def solved(load: float) -> Steady:
        return steady(at_load(groups, load)._replace(line=line_too))

    def name(load: float) -> str:
        return PATTERNS[solved(load).pattern]

    assert [name(low), name(high)] == [below, above]
    while (middle := 0.5 * (low + high)) not in (low, high):
        low, high = (middle, high) if name(middle) == below else (low, middle)
    for offset, pattern in ((-1e-12, below), (1e-12, above)):
        cycle = solved(low * (1.0 + offset))
        assert PATTERNS[cycle.pattern] == pattern
        assert cycle.status == (Status.OK if pattern else Status.FLIGHT_NOT_MODELLED)
    ladder = [solved(low * (1.0 + i * EPS)) for i in range(-400, 401, 2)]
    patterns = [PATTERNS[cycle.pattern] for cycle in ladder]
    change = patterns.index(above)
    assert set(patterns[:change]) == {below}
    assert set(patterns[change:]) == {above}
    called = [i for i, cycle in enumerate(ladder) if cycle.status == Status.BOUNDARY]
    assert called == list(range(called[0], called[-1] + 1))
    assert called[0] <= change <= called[-1] + 1
    # all that is called a boundary belongs to one side, and has a number; FB_ becomes FB without a step
    assert len({patterns[i] for i in called}) == 1 or (below, above) == ("FB_", "FB")
    assert all(math.isfinite(ladder[i].displacement) for i in called)


@pytest.mark.parametrize("groups", [FLAT, CLIMB, STEEP_CLIMB, DESCENT])
@pytest.mark.parametrize("line_too", [True, False])
def test_equality_is_rest(groups: Groups, line_too: bool) -> None:
    # 1/G at the first onset, to its last digits
    loads = line(groups.drive_deg, 1.0, groups.mu_s, groups.mu_d, groups.trough_deg)
    at = thresholds(loads)
    hold = groups.mu_s * loads.weight_normal
    t = loads.weight_tangential
    weight = max(at.forward_load / (hold + t), at.back_load / (hold - t))
    for ulps in range(-2, 3):
        near = heavier(loads, weight * (1.0 + ulps * EPS))._replace(line=line_too)
        cycle = steady(near)
        assert cycle[:4] == (Regime.NO_SLIP, Status.BOUNDARY, Pattern.R, Model.REST)
        assert cycle[4:] == (0.0, 0.0, 0, 0.0)
        alone = regime_alone(near, thresholds(near))
        assert alone == cycle


@pytest.mark.parametrize("mu_s", [0.3, 0.74])
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_trough_at_the_angle_of_static_friction_is_a_boundary(mu_s: float, way: float) -> None:
    angle = math.degrees(math.atan(mu_s))

    def beside(share: float) -> Steady:  # with next to no drive
        return steady(line(20.0, 1e20, mu_s, 0.5 * mu_s, way * angle * share))

    for ulps in range(-1, 2):
        assert beside(1.0 + ulps * EPS)[1:3] == (Status.BOUNDARY, Pattern.R)
    assert beside(1.0 - 1e-14).status == Status.OK
    assert beside(1.0 + 1e-14).status == Status.RUNAWAY


def test_slides_without_kinetic_friction_that_just_meet_are_a_boundary() -> None:
    # level, mu_d = 0: each slide ends at the mirrored phase
    boundaries = 0
    for i in range(200):
        loads = ellipse(1.0, 0.3 + 0.003 * i, -2.5 + 0.02 * i, 1.0, 0.5, 0.0)
        if slips_both_ways(loads):
            cycle = steady(loads)
            if cycle.status == Status.BOUNDARY:
                boundaries += 1
                assert cycle.pattern in (Pattern.FB_, Pattern.F_, Pattern.B_)
                assert math.isfinite(cycle.displacement)
            else:
                assert cycle.pattern in (Pattern.F_, Pattern.B_)
    assert boundaries > 20
    # a flat line: F stops just where the back window closes, and equality is rest
    flat = steady(line(0.0, 0.5, 0.6, 0.0))
    assert (flat.pattern, flat.status) == (Pattern.F_, Status.BOUNDARY)


@pytest.mark.parametrize("loads", [line(0.0, 0.4, 0.6, 0.5), line(0.0, 1.4, 0.6, 0.5)])
def test_a_flat_drive_on_a_level_trough_conveys_nothing(loads: Loads) -> None:
    for same in (loads, loads._replace(line=False), ellipse(1.0, 0.0, 1.0, loads.weight_normal, 0.6, 0.5)):
        cycle = steady(same)
        assert cycle.displacement == pytest.approx(0.0, abs=1e-15)
        assert cycle.pattern == (Pattern.FB if loads.weight_normal < 1.0 else Pattern.F_B_)
        assert cycle.peak > 0.0


def test_drives_that_reach_no_threshold_leave_the_body_at_rest() -> None:
    for loads in (ellipse(0.0, 0.0, 1.0, 1.0, 0.5, 0.4), ellipse(0.0, 1.0, 1.0, 1.1, 0.5, 0.4)):
        assert steady(loads) == (Regime.NO_SLIP, Status.OK, Pattern.R, Model.REST, 0.0, 0.0, 0, 0.0)


# --------------------------------------------------------------------------------------- classes alone


@pytest.mark.parametrize("steepest", [0.0, 1.05])
def test_the_class_alone_is_that_of_the_cycle(steepest: float) -> None:
    for loads in random_loads(400, 7, steepest=steepest, least_ratio=0.02):
        cycle, alone = steady(loads), regime_alone(loads, thresholds(loads))
        assert alone.regime == cycle.regime
        if cycle.regime in (Regime.FORWARD_SLIP, Regime.BACK_SLIP):
            assert alone[2:4] == (Pattern.NONE, Model.NONE)
            assert alone.coexists == -1
            assert math.isnan(alone.displacement)
            assert math.isnan(alone.peak)
        else:
            assert alone == pytest.approx(cycle, nan_ok=True)
        assert alone.status == cycle.status or cycle.status == Status.BOUNDARY


def test_where_back_slip_enters_the_class_alone_is_a_boundary() -> None:
    low, high = 1.0, 1.4
    while (middle := 0.5 * (low + high)) not in (low, high):
        low, high = (middle, high) if pattern_of(at_load(LATE_BACK, middle)) == "F_" else (low, middle)
    for line_too in (True, False):
        loads = at_load(LATE_BACK, low)._replace(line=line_too)
        assert outlasts_back(pair_of(loads, thresholds(loads))) == 0 or not line_too
        alone = regime_alone(loads, thresholds(loads))
        assert (alone.regime, alone.status) == (Regime.FORWARD_SLIP, Status.BOUNDARY)
        for offset, regime in ((-1e-10, Regime.FORWARD_SLIP), (1e-10, Regime.BACK_SLIP)):
            beside = at_load(LATE_BACK, low * (1.0 + offset))._replace(line=line_too)
            alone = regime_alone(beside, thresholds(beside))
            assert (alone.regime, alone.status) == (regime, Status.OK)


# ---------------------------------------------------------------------------------------- coexistence


def test_two_cycles_of_one_scene() -> None:
    # physics: conveys 6.4684 g/w^2 a cycle from rest and 0.5732 if disturbed
    groups = Groups(1.49149, math.degrees(0.7034), 0.457783, 0.0429106)
    for line_too in (True, False):
        cycle = steady(at_load(groups, groups.load)._replace(line=line_too))
        assert (cycle.pattern, cycle.coexists, cycle.status) == (Pattern.F_, 1, Status.OK)
        assert f"{cycle.displacement * groups.load:.4f}" == "6.4684"
    body = Walker(groups)
    assert f"{body.settle().displacement:.4f}" == "6.4684"
    disturbed = body.settle(body.opens[-1], -1)
    assert disturbed.pattern == "FB"
    assert f"{disturbed.displacement:.4f}" == "0.5732"


def _attractors(loads: Loads, leaps: bool) -> set[str]:
    """Patterns that a body settles into which is released from rest at several phases."""
    found = set()
    for i in range(7):
        body = body_of(loads)
        body.p = 0.1 + TURN * i / 7
        for way in (1, -1):
            if body.push(way, body.mu_s).first > 0.0:
                body.way = way
        found.add((body.settle() if leaps else settled(body)).pattern)
    return found


# As ``line_loads``: drive angle [rad], 1/G, mu_s, mu_d, trough angle [rad].
LINES = {
    "B_": (0.1351, 1.864, 0.4666, 0.101, 0.08458),
    "FB": (0.5014, 1.03, 0.2828, 0.04838, 0.01052),
    "FB_": (0.1662, 1.08, 0.6291, 0.1558, -0.06648),
    "F_": (0.3777, 1.903, 0.3299, 0.07813, -0.0638),
    "F_ or F_B": (0.39, 1.085, 0.633, 0.05307, 0.0348),
    "F_ or F_B, level": (0.3669, 0.8263, 0.7875, 0.07437, 0.0),
    "F_ or FB": (0.2673, 0.7517, 0.8931, 0.07572, 0.0),
    "F_B": (0.5252, 1.331, 0.2799, 0.06201, 0.04264),
    "F_B_": (0.1383, 1.787, 0.5129, 0.1253, 0.0),
}
# As ``ellipse``: X/A, Y/A, phase [rad], 1/G, mu_s, mu_d, trough angle [rad].
ELLIPSES = {
    "B_": (1.0, 0.6789, 2.62, 1.127, 0.3611, 0.06771, 0.04119),
    "FB": (1.0, 0.05354, 1.569, 0.09573, 0.3478, 0.05026, -0.02928),
    "FB or B_": (1.0, 0.7459, 2.383, 0.7579, 0.5226, 0.08621, 0.0),
    "FB or B_, inclined": (1.0, 0.3638, -2.617, 0.643, 0.9966, 0.0922, 0.02641),
    "FB_": (1.0, 0.9412, -2.099, 1.852, 0.3752, 0.07023, 0.0),
    "FB_ or B_": (1.0, 0.5274, -2.802, 0.6308, 0.8645, 0.06408, 0.003489),
    "FB_ or B_, declined": (1.0, 0.6444, -2.934, 0.8232, 0.6553, 0.03619, -0.02968),
    "F_": (0.836, 1.0, -0.6895, 1.431, 0.289, 0.06562, -0.01528),
    "F_ or F_B": (1.0, 0.5533, 0.5038, 0.7635, 0.8319, 0.09106, 0.0),
    "F_ or F_B, inclined": (1.0, 0.4738, -0.7993, 0.7888, 0.8936, 0.06292, 0.04628),
    "F_ or FB": (1.0, 0.633, -0.9556, 1.19, 0.5557, 0.06637, 0.0),
    "F_ or FB, inclined": (1.0, 0.7482, -0.4808, 0.7981, 0.621, 0.09414, 0.05011),
    "F_B": (0.9086, 1.0, 0.6821, 1.189, 0.4956, 0.03887, 0.006709),
}


@each(
    ("name", "loads"),
    [
        *((name, line_loads(x[1], directions(x[0], x[4]), *x[2:4])) for name, x in LINES.items()),
        *((name, ellipse(*x)) for name, x in ELLIPSES.items()),
    ],
)
def test_coexistence_is_flagged_where_starts_from_other_phases_settle_elsewhere(
    name: str, loads: Loads
) -> None:
    patterns = name.split(",")[0].split(" or ")
    cycle = steady(loads)
    assert cycle[1:3] == (Status.OK, PATTERNS.index(patterns[0]))
    assert cycle.coexists == len(patterns) - 1
    assert _attractors(loads, leaps=cycle.coexists == 0) == {rotated(pattern) for pattern in patterns}


@pytest.mark.parametrize("way", [-1.0, 1.0])
def test_running_away_exists_from_the_angle_of_kinetic_friction_on(way: float) -> None:
    for weight in (10.0, 1.0 / 0.9):  # at rest, and sliding
        # tan(45 deg) is 1 to rounding, and so are sin / cos of the angle in radians
        for share, flag in ((1.0 - 1e-14, 0), (1.0 + 1e-14, 1)):
            cycle = steady(line(20.0, weight, 2.0, 1.0, way * 45.0 * share))
            assert cycle.status in (Status.OK, Status.BOUNDARY)
            assert cycle.coexists == flag


def test_the_flag_is_never_up_where_nothing_else_attracts() -> None:
    for loads in random_lines(800, 10, steepest=0.2, least_ratio=0.9):
        assert steady(loads).coexists != 1
    # without kinetic friction there are other cycles, but no body tends to them
    for loads in random_lines(800, 11):
        for same in (loads, loads._replace(line=False)):
            assert steady(same._replace(kinetic_friction=0.0)).coexists == 0


# ------------------------------------------------------------------------------- which slide comes first


def assert_walked(loads: Loads) -> None:
    """Compare the cycle from rest with the walk."""
    cycle, walked = steady(loads), settled(body_of(loads))
    weight = math.hypot(loads.weight_normal, loads.weight_tangential)
    assert rotated(PATTERNS[cycle.pattern]) == walked.pattern
    assert cycle.displacement == pytest.approx(weight * walked.displacement, abs=1e-9)
    assert cycle.peak == pytest.approx(weight * walked.peak, abs=1e-9)


@pytest.mark.parametrize(
    ("pattern", "values"),
    [
        ("F_B", (0.1605, 1.0, 1.46, 1.058, 0.2289, 0.02097, -0.01991)),
        ("B_", (0.07688, 1.0, 1.536, 1.014, 0.07485, 0.006354, 0.006354)),
        ("FB", (0.0704, 1.0, 1.957, 1.005, 0.08489, 0.01222, -0.01028)),
    ],
)
def test_where_cycles_coexist_the_body_gets_the_one_it_comes_to_from_rest(
    pattern: str, values: tuple[float, ...]
) -> None:
    # the first slide from rest goes back in the first two; forward first the former would be F_
    loads = ellipse(*values)
    cycle = steady(loads)
    assert (PATTERNS[cycle.pattern], cycle.status, cycle.coexists) == (pattern, Status.OK, 1)
    assert cycle.regime == Regime.BACK_SLIP
    assert_walked(loads)


def test_not_both_slides_from_rest_outlast_the_opposite_window() -> None:
    # where friction holds a sliding body; on steeper troughs both may, and pushed bodies slide for ever
    outlasting = {"F": 0, "B": 0}
    for some in random_loads(4_000, 16, steepest=0.03):
        loads = some._replace(kinetic_friction=0.1 * some.kinetic_friction)
        weight = abs(loads.weight_tangential)
        if weight > loads.kinetic_friction * loads.weight_normal or not slips_both_ways(loads):
            continue
        pair = pair_of(loads, thresholds(loads))
        forward, back = outlasts_back(pair) > 0, outlasts_back(module._mirrored_pair(pair)) > 0
        assert not (forward and back), loads
        outlasting["F"] += forward
        outlasting["B"] += back
    assert min(outlasting.values()) > 100


# ------------------------------------------------------------------------------
# Continuous sliding: both slides end where the other one starts, with 50 digits; both solvers; its edges.


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


LINE_CASES = cases(random_lines(400, 1)) + cases(random_lines(400, 2, steepest=0.9))
ELLIPSE_CASES = cases(random_ellipses(400, 3)) + cases(
    random_ellipses(800, 4, steepest=0.9, least_ratio=0.02)
)
STEEP = [x for x in ELLIPSE_CASES if module._is_steep(x.loads)]


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
    found = [(x, x.cycle()) for x in LINE_CASES]
    closed = [(x, cycle) for x, cycle in found if not math.isnan(cycle.y)]
    for x, cycle in closed:
        assert_closed(x.loads, cycle, 1e-13 if x.loads.weight_tangential else 64 * EPS)
        assert cycle.sin_m > 0.0 < cycle.cos_m
    assert len(closed) > 300
    assert len(found) - len(closed) > 40


def test_the_cycle_of_an_ellipse_closes() -> None:
    found = [(x, x.cycle()) for x in ELLIPSE_CASES]
    closed = [(x, cycle) for x, cycle in found if not math.isnan(cycle.y)]
    for x, cycle in closed:
        assert_closed(x.loads, cycle, 1e-13)
        assert cycle.sin_m > 0.0
    assert len(closed) > 300
    assert len(found) - len(closed) > 40


@pytest.mark.parametrize("some", [LINE_CASES, ELLIPSE_CASES], ids=["lines", "ellipses"])
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


def test_a_line_as_an_ellipse_slides_on_alike() -> None:
    for x in LINE_CASES:
        same = case(x.loads._replace(line=False))
        assert same
        ours, other = x.cycle(), same.cycle()
        if ours.valid or other.valid:
            assert ours[:5] == pytest.approx(other[:5], abs=1e-11)
            assert ours.valid == other.valid


def test_both_equations_have_the_same_root() -> None:
    # Eq. (60) is Eq. (61) where its middle comes after the crest of each load
    valid = 0
    for x in LINE_CASES + ELLIPSE_CASES:
        cycle, other = x.likely(), x.by_half_length()
        if is_sure(x.loads, cycle):
            assert cycle.valid == other.valid
            if cycle.valid:
                valid += 1
                assert cycle[:5] == pytest.approx(other[:5], abs=1e-11)
    assert valid > 500


def test_what_is_not_sure_is_solved_for_half_the_length() -> None:
    unsure = [x for x in ELLIPSE_CASES if not is_sure(x.loads, x.likely())]
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
    for x in ELLIPSE_CASES[::3] + STEEP:
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
    found = next(x for x in ELLIPSE_CASES if x.by_half_length().valid)
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


@pytest.mark.parametrize("some", [LINE_CASES, ELLIPSE_CASES, STEEP], ids=["lines", "ellipses", "steep"])
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
    for x in ELLIPSE_CASES[:200] + LINE_CASES[:50]:
        cycle = x.cycle()
        if not math.isnan(cycle.y):
            expected = sum(legs(x.loads, cycle).forward) / 2
            found = middle_phase(x.loads, cycle)
            assert math.remainder(found - float(expected), TURN) == pytest.approx(0.0, abs=1e-14)


# ------------------------------------------------------------------------------
# The slides of known patterns: starts, ends and paths with 50 digits, and their order.


# Direction of each slide, and whether it starts from rest, in the order of the pattern.
SLIDES = {
    "F_": ((1.0, True),),
    "B_": ((-1.0, True),),
    "F_B_": ((1.0, True), (-1.0, True)),
    "FB_": ((1.0, True), (-1.0, False)),
    "F_B": ((1.0, False), (-1.0, True)),
    "FB": ((1.0, False), (-1.0, False)),
}
MOST = 12  # scenes of a pattern and kind of drive


def _check(loads: Loads, leg: SlideLeg) -> None:
    exact, phase = Exact(loads), MP.atan2(loads.phase_sine, loads.phase_cosine)
    begin, end = leg.begin + phase, leg.end + phase  # of the normal motion
    if leg.from_rest:
        opens, closes = exact.window(leg.way)
        assert math.remainder(float(begin - opens), TURN) == pytest.approx(0.0, abs=1e-11)
        assert leg.start.window == pytest.approx(float(closes - opens) / 2, abs=1e-11)
    else:
        assert exact.pull(leg.way, exact.mu_s, begin) > -1e-11
    assert abs(exact.speed(leg.way, begin, end)) < 1e-12
    assert exact.speed(leg.way, begin, (begin + end) / 2) > 0
    assert leg.displacement == pytest.approx(float(leg.way * exact.path(leg.way, begin, end)), abs=1e-11)
    # the load's zero, where it rises
    kinetic = exact.load(leg.way, exact.mu_d)
    wave = kinetic * MP.expj(leg.zero + phase)
    assert abs(wave.imag) < 1e-14
    assert wave.real > 0
    assert leg.start.onset.load == pytest.approx(float(abs(kinetic)), rel=1e-14)
    resistance = exact.resistance(leg.way, exact.mu_d) / abs(kinetic)
    assert leg.start.onset.k == pytest.approx(float(resistance), abs=1e-13)
    own = leg.begin - leg.zero + leg.start.onset.c
    assert math.remainder(own - 0.5 * math.pi, TURN) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("name", SLIDES)
def test_slides_start_at_their_onsets_or_where_the_other_one_ends(name: str) -> None:
    pattern, seen = PATTERNS.index(name), {True: 0, False: 0}
    for loads in random_loads(500, 1, steepest=0.6):
        cycle = steady_cycle(loads, thresholds(loads))
        if cycle.pattern != pattern or cycle.status != Status.OK or seen[loads.line] == MOST:
            continue
        seen[loads.line] += 1
        found = cycle_slides(loads, pattern)
        legs = [leg for leg in found if leg.way]
        assert tuple((leg.way, leg.from_rest) for leg in legs) == SLIDES[name]
        for leg in legs:
            _check(loads, leg)
        assert 0.0 <= legs[0].begin < TURN
        assert sum(leg.displacement for leg in legs) == pytest.approx(cycle.displacement, abs=1e-10)
        if len(legs) == 2:
            first, second = legs
            follows = second.begin - first.end
            assert -1e-8 < follows < TURN
            if not second.from_rest:
                assert follows == pytest.approx(0.0, abs=1e-10)
            wait = first.begin + TURN - second.end
            assert wait > -1e-9
            assert (wait == pytest.approx(0.0, abs=1e-9)) == (not first.from_rest)
        else:
            assert found.second.way == 0.0
            assert math.isnan(found.second.begin)
    assert min(seen.values()) >= 5


def _is_empty(found: CycleSlides) -> bool:
    return all(leg.way == 0.0 and math.isnan(leg.displacement) for leg in found)


def test_there_are_none_without_slip() -> None:
    both = line(20.0, 0.5, 0.74, 0.57)
    assert _is_empty(cycle_slides(both, Pattern.R))
    assert _is_empty(cycle_slides(both, Pattern.NONE))
    assert not _is_empty(cycle_slides(both, Pattern.FB))
    one_way = line(20.0, 1.0, 0.74, 0.57)  # no back slip
    for pattern in (Pattern.F_B_, Pattern.FB_, Pattern.F_B, Pattern.FB):
        assert _is_empty(cycle_slides(one_way, pattern))


@pytest.mark.parametrize(
    ("loads", "pattern"),
    [
        (line(20.0, 1.0, 0.3, 0.02, -14.0), Pattern.F_),
        (line(5.0, 0.4, 0.3, 0.02, -14.0), Pattern.F_B_),
        (ellipse(1.0, 0.2, 2.0, 1.0, 0.3, 0.02, 0.25), Pattern.B_),
    ],
)
def test_a_slide_that_never_ends_has_a_start(loads: Loads, pattern: int) -> None:
    first = cycle_slides(loads, pattern).first
    assert 0.0 <= first.begin < TURN
    assert first.end == math.inf
    assert math.isnan(first.displacement)
