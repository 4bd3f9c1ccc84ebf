"""The steady contact cycle from rest, coexisting ones, and continuous sliding: walks and 50 digits."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import pytest
from helpers.cases import each
from helpers.contact_loads import (
    EPS,
    MP,
    TURN,
    Exact,
    body_of,
    ellipse,
    line,
    random_ellipses,
    random_lines,
)
from helpers.scenes import Groups
from helpers.two_axis_scenes import rotated

from vibro.core.codes import PATTERNS, Model, Pattern, Regime, Status
from vibro.core.contact import (
    ContinuousSliding,
    Steady,
    continuous_motion,
    continuous_sliding,
    half_length_root,
    is_sure,
    likely_sliding,
    outlasts_back,
    pair_of,
    regime_alone,
    steady_cycle,
)
from vibro.core.drive import Loads, directions, line_loads
from vibro.core.slides import Start, Thresholds, resting_start, thresholds

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from engines.two_axis_walk import Body, Cycle


def steady(loads: Loads) -> Steady:
    return steady_cycle(loads, thresholds(loads))


def at_load(groups: Groups, load: float) -> Loads:
    return line(groups.drive_deg, 1.0 / load, groups.mu_s, groups.mu_d, groups.trough_deg)


def settled(body: Body) -> Cycle:
    """Walk without the leaps that may carry a body past the cycle that it draws near."""
    body._leap = lambda legs: None  # type: ignore[method-assign]
    return body.settle()


# --------------------------------------------------------------------------------------- boundaries

FLAT = Groups(1.0, 20.0, 0.74, 0.57)
EQUAL_FRICTION = Groups(1.0, 6.0, 0.182, 0.182)
CLIMB = Groups(1.0, 16.44, 0.359, 0.242, 2.97)
STEEP_CLIMB = Groups(1.0, 8.631, 0.4358, 0.2052, 9.165)
ROUGH_CLIMB = Groups(1.0, 22.568, 0.2869, 0.2767, 5.454)
DESCENT = Groups(1.0, 9.03, 0.573, 0.48, -2.46)
LATE_BACK = Groups(1.0, 44.8, 0.492, 0.189)


def pattern_of(loads: Loads) -> str:
    return PATTERNS[steady(loads).pattern]


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


@pytest.mark.parametrize("mu_s", [0.3, 0.74])
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_trough_at_the_angle_of_static_friction_is_a_boundary(mu_s: float, way: float) -> None:
    angle = math.degrees(math.atan(mu_s))
    # with next to no drive; and slipping, where the same friction holds what moves
    for weight, mu_d, most in ((1e20, 0.5 * mu_s, 1), (1.2, mu_s, 0)):

        def beside(share: float, weight: float = weight, mu_d: float = mu_d) -> Steady:
            return steady(line(20.0, weight, mu_s, mu_d, way * angle * share))

        for ulps in range(-1, most + 1):
            assert beside(1.0 + ulps * EPS).status == Status.BOUNDARY
            assert (beside(1.0 + ulps * EPS).pattern == Pattern.R) == (mu_d < mu_s)
        assert beside(1.0 - 1e-14).status == Status.OK
        assert beside(1.0 + 1e-14).status == Status.RUNAWAY


# --------------------------------------------------------------------- scenes without a cycle, and classes


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


def _top(exact: Exact, way: float, begin: Any, end: Any) -> Any:
    """Largest speed of a slide: where its acceleration falls through zero."""
    load = exact.load(way, exact.mu_d)
    k = exact.resistance(way, exact.mu_d) / abs(load)
    p = MP.pi - MP.asin(k) - MP.arg(load)
    p += MP.ceil((begin - p) / (2 * MP.pi)) * 2 * MP.pi
    assert p < end
    return exact.speed(way, begin, p)


DRAWS: dict[str, Callable[[], list[Case]]] = {
    "lines": lambda: cases([*random_lines(300, 1), *random_lines(300, 2, steepest=0.9)]),
    "ellipses": lambda: cases([*random_ellipses(300, 3), *random_ellipses(400, 4, least_ratio=0.02)]),
    "inclined": lambda: cases(random_ellipses(800, 4, steepest=0.9, least_ratio=0.02)),
}


@pytest.mark.parametrize("kind", DRAWS)
def test_sliding_without_rest_is_that_of_50_digits(kind: str) -> None:
    """Each slide ends where the other one starts, beyond static friction or not; displacement and peak."""
    said, sure = [], 0
    for x in DRAWS[kind]():
        cycle, likely = x.cycle(), x.likely()
        if is_sure(x.loads, likely):  # Eq. (60) is Eq. (61) where its middle comes after both crests
            other = x.by_half_length()
            assert likely.valid == other.valid
            assert likely[:5] == pytest.approx(other[:5], abs=1e-11) or not likely.valid
            sure += likely.valid
        if math.isnan(cycle.y):
            assert (cycle.valid, cycle.edge) == (False, False)
            continue
        exact, (forward, back), near = Exact(x.loads), legs(x.loads, cycle), 1e-12 * size_of(x.loads)
        assert abs(exact.speed(1.0, *forward)) < near
        assert abs(exact.speed(-1.0, *back)) < near
        excess = min(exact.pull(1.0, exact.mu_s, forward[0]), exact.pull(-1.0, exact.mu_s, back[0]))
        if abs(excess) > 1e-12:
            assert (cycle.valid, cycle.edge) == (excess > 0, False)
            said.append(cycle.valid)
        if cycle.valid:
            motion = continuous_motion(x.loads, x.forward.onset, x.back.onset, cycle)
            displacement = exact.path(1.0, *forward) - exact.path(-1.0, *back)
            assert motion.displacement == pytest.approx(float(displacement), abs=near)
            tops = _top(exact, 1.0, *forward), _top(exact, -1.0, *back)
            assert motion.peak == pytest.approx(float(max(tops)), abs=near)
    assert min(said.count(True), said.count(False), sure) > 30
