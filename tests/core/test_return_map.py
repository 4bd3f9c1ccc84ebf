"""The return map of hopping bodies and its fixed points, beside walks by the law of Newton."""

from __future__ import annotations

import math
import random
from typing import TYPE_CHECKING

import numpy as np
import pytest
from helpers.cases import each
from helpers.hopping_bodies import (
    FLIGHTS,
    HOPS,
    Drawn,
    draw,
    ellipse,
    lift_off,
    line,
    unit,
    walk_round,
    walker,
)

from vibro.core import return_map as return_map_module
from vibro.core.bounces import Bounces, bounces
from vibro.core.codes import IRREGULAR, MOST_LETTERS, Mode, Status, spelt_text
from vibro.core.drive import Loads, phase_difference, tangential_load
from vibro.core.flight import bed_of
from vibro.core.hops import enter
from vibro.core.legs import track_of
from vibro.core.return_map import (
    HoppingCycle,
    Orbit,
    Return,
    _append,
    between,
    cycle_from,
    has_stop,
    hopping_cycle,
    orbit_from,
    release,
    return_map,
    stopping,
    stops_of,
    with_same_ground_speed,
    write_hop,
)

if TYPE_CHECKING:
    from collections.abc import Sequence


TURN = 2.0 * math.pi

SCENES = [
    *draw(40, 1),
    *draw(40, 2, ellipses=True),
    *draw(25, 3, throw=(1.01, 1.9), restitution=0.4),
    *draw(25, 4, throw=(1.01, 1.9), restitution=0.4, ellipses=True),
    *draw(25, 5, slope=1.5, ratio=(0.2, 0.6)),
]


def _hops(scene: Drawn) -> Bounces:
    """Fly the cycle from a lift-off to the next; write its hops."""
    loads = scene.loads
    bed = bed_of(loads)
    motion = bounces(bed, scene.restitution, FLIGHTS, 256, bed.lift_off, 0.0, True)
    for row in range(motion.first, motion.first + motion.count):
        write_hop(loads, FLIGHTS.phase[row], FLIGHTS.length[row], FLIGHTS.impulse[row], HOPS, row)
    return motion


def _returned(scene: Drawn, motion: Bounces, velocity: float) -> Return:
    last = motion.first + motion.count
    track = track_of(scene.loads, scene.restitution)
    return return_map(track, HOPS, motion.first, last, motion.landing, motion.rest, velocity)


# ------------------------------------------------------------------------------- hops


@each("length", [1e-3, 0.7, 4.0, 9.0, 31.0])
@each("share", [0.0, 0.03, -0.03, 0.4, -0.4, 0.97, -0.97, 1.5, -1.5])
def test_a_hop_holds_what_sampling_the_flight_finds(share: float, length: float) -> None:
    pick = random.Random(f"{share} {length}")
    for _ in range(6):
        loads = ellipse(1.5, pick.uniform(0.2, 1.0), 1.0, pick.uniform(-3.0, 3.0), 0.5, 0.3)
        loads = loads._replace(weight_tangential=share * loads.drive_tangential)
        phase, impulse = pick.uniform(0.0, TURN), pick.uniform(0.0, 3.0)
        HOPS.landing[7], HOPS.rest[7] = 1.0, 2.0
        write_hop(loads, phase, length, impulse, HOPS, 7)
        a, t = loads.drive_tangential, loads.weight_tangential
        q = phase - phase_difference(loads)
        s = np.linspace(0.0, length, 40_001)
        added = a * (math.cos(q) - np.cos(q + s)) - t * s
        scale = 1.0 + abs(t) * length
        assert HOPS.gain[7] == pytest.approx(added[-1], abs=1e-14 * scale)
        shift = a * (math.cos(q) * length - math.sin(q + length) + math.sin(q)) - 0.5 * t * length**2
        assert HOPS.shift[7] == pytest.approx(shift, abs=1e-14 * scale * (1.0 + length))
        # the largest sample is no more than half a step off
        assert HOPS.high[7] == pytest.approx(
            added.max(), abs=a * (length / 40_000) ** 2 / 8.0 + 1e-14 * scale
        )
        assert HOPS.low[7] == pytest.approx(added.min(), abs=a * (length / 40_000) ** 2 / 8.0 + 1e-14 * scale)
        assert HOPS.length[7] == length
        assert HOPS.brake[7] == pytest.approx(0.3 * loads.weight_normal * impulse, rel=1e-15)
        assert (HOPS.landing[7], HOPS.rest[7]) == (0.0, 0.0)


def test_the_last_extreme_of_a_long_flight_is_the_largest_where_gravity_wins() -> None:
    # downhill forward: each maximum is higher than the one before; uphill: each minimum lower
    for t, way in ((-0.05, 1.0), (0.05, -1.0)):
        loads = line(4.0, 30.0, 0.5, 0.3)._replace(weight_tangential=t)
        a = loads.drive_tangential
        length = 3.0 * TURN + 0.5
        # a flight that starts in a minimum of the velocity, or a maximum, ends short of the last extreme
        start = math.asin(t / a) if way > 0.0 else math.pi - math.asin(t / a)
        write_hop(loads, start, length, 0.0, HOPS, 0)
        extreme = math.pi - 2.0 * math.asin(t / a) * way
        expected = a * (math.cos(start) - math.cos(start + extreme)) - t * (extreme + 2.0 * TURN)
        assert (HOPS.high[0] if way > 0.0 else HOPS.low[0]) == pytest.approx(expected, abs=1e-13)
        assert (HOPS.low[0] if way > 0.0 else HOPS.high[0]) == 0.0


def test_a_trough_that_moves_up_and_down_alone_adds_gravity() -> None:
    loads = ellipse(2.0, 0.0, 1.0, 0.3, 0.5, 0.4, 0.2)
    write_hop(loads, 1.0, 5.0, 1.0, HOPS, 0)
    assert HOPS.gain[0] == HOPS.low[0] == pytest.approx(-5.0 * loads.weight_tangential, rel=1e-15)
    assert HOPS.shift[0] == pytest.approx(-12.5 * loads.weight_tangential, rel=1e-15)
    assert HOPS.high[0] == 0.0


# ------------------------------------------------------------------------------- one cycle


def test_cycles_are_those_of_a_walk_from_event_to_event() -> None:
    pick, seen, patterns = random.Random(6), 0, set()
    for scene in SCENES:
        motion = _hops(scene)
        if not motion.repeats or motion.rest == 0.0:
            continue
        for velocity in (0.0, pick.uniform(-1.0, 1.0), pick.uniform(-3.0, 3.0)):
            now, then = (
                _returned(scene, motion, velocity),
                walk_round(scene.loads, scene.restitution, velocity),
            )
            # the walk leaves the shortest bounces out
            within = 1e-11 if scene.restitution == 0.0 else 1e-6
            assert now.velocity == pytest.approx(then.velocity, abs=within)
            assert now.displacement == pytest.approx(then.displacement, abs=within)
            assert now.peak == pytest.approx(then.peak, abs=within)
            assert now.settled
            if scene.restitution == 0.0:
                assert spelt_text(now.pattern) == then.pattern
                patterns.add(then.pattern)
            if now.slope > 0.0:
                assert now.friction == pytest.approx(then.impulse, abs=within)
                seen += 1
    assert seen > 100
    assert len(patterns) >= 12


def test_without_a_stop_gravity_and_friction_alone_change_the_velocity() -> None:
    pick, seen = random.Random(7), 0
    for scene in SCENES:
        motion = _hops(scene)
        if not motion.repeats or motion.rest == 0.0:
            continue
        velocity = pick.uniform(-3.0, 3.0)
        now = _returned(scene, motion, velocity)
        if now.slope > 0.0:
            seen += 1
            fall = -TURN * motion.cycles * scene.loads.weight_tangential
            assert now.velocity - velocity == pytest.approx(fall + now.friction, abs=1e-11)
            # no more than that of the whole weight, Eq. (29)
            most = scene.loads.kinetic_friction * scene.loads.weight_normal * TURN * motion.cycles
            assert abs(now.friction) <= most * (1.0 + 1e-7)
            if math.copysign(1.0, velocity) * min(velocity, now.velocity) > 2.5:  # never turns
                assert abs(now.friction) == pytest.approx(most, rel=1e-6)
                assert now.friction * velocity < 0.0
    assert seen > 40


def test_bodies_that_always_slide_one_way_feel_the_friction_of_their_weight() -> None:
    for scene in SCENES[::5]:
        motion = _hops(scene)
        if not motion.repeats or motion.rest == 0.0:
            continue
        most = scene.loads.kinetic_friction * scene.loads.weight_normal * TURN * motion.cycles
        fast = 10.0 + 2.0 * most + TURN * motion.cycles * abs(scene.loads.weight_tangential)
        for way in (1.0, -1.0):
            now = _returned(scene, motion, way * fast)
            assert now.friction == pytest.approx(-way * most, rel=1e-7)
            assert now.slope == 1.0
            if now.pattern > 0:
                assert set(spelt_text(now.pattern)) <= {"H", "F" if way > 0.0 else "B"}


def test_the_map_never_decreases_and_its_slope_is_its_derivative() -> None:
    smooth = points = 0
    for scene in SCENES[::2]:
        motion = _hops(scene)
        if not motion.repeats or motion.rest == 0.0:
            continue
        before = -math.inf
        for velocity in np.linspace(-1.5, 1.5, 13).tolist():
            left, here, right = (_returned(scene, motion, velocity + h) for h in (-1e-6, 0.0, 1e-6))
            assert before - 1e-12 <= left.velocity <= here.velocity + 1e-12 <= right.velocity + 2e-12
            assert 0.0 <= here.slope <= 1.0
            before = right.velocity
            points += 1
            if abs(left.slope - right.slope) < 1e-4 and left.pattern == here.pattern == right.pattern:
                smooth += 1
                assert (right.velocity - left.velocity) / 2e-6 == pytest.approx(here.slope, abs=3e-4)
    assert smooth > 0.9 * points > 300


def test_impacts_take_what_friction_can_and_no_more() -> None:
    track = track_of(line(1.5, 30.0, 0.5, 0.4), 0.0)
    for brake in (0.5, 0.3, 0.1):
        for column, value in zip(HOPS, (0.2, 1.0, 0.05, brake, 0.25, -0.1, 0.0, 0.0), strict=True):
            column[0] = value
        for velocity, after in ((0.1, 0.3), (-0.5, -0.3), (0.4, 0.6), (-0.7, -0.5)):
            now = return_map(track, HOPS, 0, 1, 0.0, 0.0, velocity)
            left = max(abs(after) - brake, 0.0)
            assert abs(now.velocity) == pytest.approx(left, abs=1e-15)
            assert now.velocity * after >= 0.0
            assert now.slope == (1.0 if abs(now.velocity) > 0.0 else 0.0)
            assert now.friction == pytest.approx(-math.copysign(brake, after), abs=1e-15)
            assert now.displacement == pytest.approx(velocity + 0.05, abs=1e-15)
            assert now.peak == pytest.approx(max(abs(velocity + 0.25), abs(velocity - 0.1)), abs=1e-15)
    # a stop is forgotten, whatever follows
    HOPS.brake[0] = 0.2
    for column in HOPS:
        column[1] = column[0]
    HOPS.brake[1] = 0.0
    stopped = return_map(track, HOPS, 0, 2, 0.0, 0.0, -0.1)
    assert (stopped.velocity, stopped.slope) == (0.2, 0.0)
    assert spelt_text(stopped.pattern) == "HH"


def test_contacts_amid_hops_are_those_at_the_end_of_a_cycle() -> None:
    for scene in SCENES[::6]:
        motion = _hops(scene)
        if not motion.repeats or motion.rest == 0.0:
            continue
        one = _returned(scene, motion, 0.3)
        two = _returned(scene, motion, one.velocity)
        count = motion.count
        for column in HOPS:
            for row in range(count):
                column[count + row] = column[row]
        for row in (count - 1, 2 * count - 1):
            HOPS.landing[row], HOPS.rest[row] = motion.landing, motion.rest
        both = return_map(track_of(scene.loads, scene.restitution), HOPS, 0, 2 * count, 0.0, 0.0, 0.3)
        assert both.velocity == two.velocity
        assert both.slope == pytest.approx(one.slope * two.slope, rel=1e-15)
        assert both.displacement == pytest.approx(one.displacement + two.displacement, abs=1e-14)
        assert both.friction == pytest.approx(one.friction + two.friction, abs=1e-14)
        assert both.peak == max(one.peak, two.peak)
        if both.pattern > 0:
            assert spelt_text(both.pattern) == spelt_text(one.pattern) + spelt_text(two.pattern)


def _spelt(modes: Sequence[int]) -> int:
    code = 0
    for mode in modes:
        code = _append(code, mode)
    return code


def test_long_patterns_have_marks_that_tell_them_apart() -> None:
    modes = [Mode.FLIGHT if i % 2 else Mode.BACK for i in range(400)]
    marks = []
    for i in range(1, 401):
        marks.append(_spelt(modes[:i]))
        assert (marks[-1] < IRREGULAR) == (i > MOST_LETTERS)
        assert abs(marks[-1]) < 2**63
        assert abs(marks[-1]) % 5 == modes[i - 1]  # that a chain of flights is known by
    # one other letter anywhere makes another mark
    marks += [_spelt([*modes[:i], Mode.REST, *modes[i + 1 :]]) for i in range(400)]
    assert len(set(marks)) == len(marks)


# ------------------------------------------------------------------------------- release


def _first_lift_off(loads: Loads) -> tuple[float, bool]:
    """Walk a body from rest to its first take-off: its velocity, and whether that is at once."""
    body = walker(loads)
    if body.lift().first > 0.0:
        return 0.0, True
    aloft = False
    while not aloft:
        leg, aloft = body._touch()
        body.p = (body.p + leg.length) % TURN
    return body.v / unit(loads), False


def test_bodies_leave_as_they_do_in_a_walk() -> None:
    aloft = backwards = turning = 0
    for scene in [*draw(60, 8, slope=3.0), *draw(150, 9, ellipses=True, slope=3.0)]:
        loads = scene.loads
        slope = abs(loads.weight_tangential)
        if slope >= loads.static_friction * loads.weight_normal or loads.weight_across < 0.0:
            continue
        velocity, at_once = _first_lift_off(loads)
        start = release(track_of(loads, 0.0))
        assert start.aloft == at_once
        assert start.velocity == pytest.approx(velocity, abs=1e-12)
        assert start.phase == pytest.approx(
            phase_difference(loads) % TURN if at_once else lift_off(loads), abs=1e-15
        )
        aloft += at_once
        backwards += velocity < 0.0
        # has not stopped yet since the load has changed its sign
        turning += velocity * tangential_load(loads, start.phase) < 0.0
    assert min(aloft, backwards) > 10
    assert turning > 0


@pytest.mark.parametrize(
    ("beyond", "aloft"), [(-1e-6, False), (-1e-10, False), (0.0, False), (1e-10, False), (1e-6, True)]
)
def test_a_release_at_the_lift_off_itself_is_no_other_take_off(beyond: float, aloft: bool) -> None:
    loads = ellipse(2.0, 1.0, 0.8, math.asin(0.5) + beyond, 0.5, 0.4, 0.1)
    start = release(track_of(loads, 0.0))
    assert start.aloft == aloft
    assert start.phase == pytest.approx(math.asin(0.5) + max(beyond, 0.0), abs=2e-10)
    assert abs(start.velocity) < 1e-6


def test_the_velocity_over_the_ground_is_that_of_the_body_and_the_trough() -> None:
    loads = ellipse(2.0, 0.7, 1.0, 0.9, 0.5, 0.4)
    later = with_same_ground_speed(loads, 0.25, 1.3, 4.0)
    assert later + 0.7 * math.cos(4.0 - 0.9) == pytest.approx(0.25 + 0.7 * math.cos(1.3 - 0.9), abs=1e-15)
    assert with_same_ground_speed(loads, 0.25, 1.3, 1.3) == 0.25


# ------------------------------------------------------------------------------
# Fixed points of the return map: where plain walks of it end, and each way an orbit can end.

EPS = 2.0**-52


def _cycle(loads: Loads, restitution: float = 0.0) -> tuple[HoppingCycle, float, int] | None:
    """Find the cycle of the normal motion, the velocity with which a body enters it, and its period."""
    track = track_of(loads, restitution)
    entry = enter(track, restitution, FLIGHTS, HOPS)
    motion = entry.motion
    if not motion.repeats:
        return None
    last = motion.first + motion.count
    cycle = hopping_cycle(track, motion.first, last, motion.landing, motion.rest, TURN * motion.cycles)
    return cycle, entry.velocity, motion.cycles


def _solved(loads: Loads, restitution: float = 0.0) -> tuple[Orbit, int]:
    found = _cycle(loads, restitution)
    assert found is not None
    cycle, start, period = found
    return orbit_from(cycle, HOPS, start), period


def _iterated(cycle: HoppingCycle, velocity: float, most: int = 300) -> tuple[float, float]:
    """Go round and round; the last velocity, and its last change."""
    change = math.inf
    for _ in range(most):
        after = cycle_from(cycle, HOPS, velocity).velocity
        change, velocity = after - velocity, after
        if abs(change) < 1e-15:
            break
    return velocity, change


# ------------------------------------------------------------------------------- sizes


def _bare(loads: Loads, duration: float = TURN) -> HoppingCycle:
    return hopping_cycle(track_of(loads, 0.0), 0, 0, 0.0, 0.0, duration)


@each("way", [1.0, -1.0])
@each(
    ("ulps", "bounded", "edge"),
    [(-6, True, False), (-3, True, True), (0, True, True), (3, True, True), (6, False, False)],
)
def test_rounding_decides_whether_friction_holds_within_four_ulp(
    ulps: int, bounded: bool, edge: bool, way: float
) -> None:
    loads = line(1.5, 30.0, 0.5, 0.25)
    slope = 0.25 * loads.weight_normal * (1.0 + ulps * EPS)
    cycle = _bare(loads._replace(weight_tangential=way * slope))
    assert (cycle.bounded, cycle.edge, cycle.neutral) == (bounded, edge, False)


def test_a_body_is_neutral_where_neither_gravity_nor_friction_acts() -> None:
    loads = line(1.5, 30.0, 0.5, 0.0)
    assert _bare(loads)[5:8] == (False, False, True)
    assert _bare(loads._replace(weight_tangential=1e-300))[5:8] == (False, False, False)
    assert _bare(loads._replace(kinetic_friction=1e-300))[5:8] == (True, False, False)


# ------------------------------------------------------------------------------- where orbits end


@pytest.mark.parametrize(
    ("throw", "drive_deg", "mu_s", "mu_d", "trough_deg", "pattern", "displacement"),
    [
        (1.24, 0.00075, 1.0, 1.3e-10, 0.0, "HFB", 0.28197766550342690587),
        (2.0, 0.01, 0.3, 1e-7, -2e-6, "HFB", 3.6495948504758313772),
        (1.5, 30.0, 0.5, 1e-9, 0.0, "HF_F", 5.3823184539217098557),
        (1.1, 2.0, 0.4, 1e-12, 0.0, "HF_F", 6.2788666264706534638),
        (1.4, 1.0, 0.2, 1e-8, 0.0, "HF_F", 6.2822089608441947166),
    ],
)
def test_low_friction_as_50_digits_have_it(
    throw: float,
    drive_deg: float,
    mu_s: float,
    mu_d: float,
    trough_deg: float,
    pattern: str,
    displacement: float,
) -> None:
    # the fixed point was bracketed by 90 bisections of a cycle computed event by event with mpmath
    found, period = _solved(line(throw, drive_deg, mu_s, mu_d, trough_deg))
    assert (found.status, period) == (Status.OK, 1)
    assert spelt_text(found.cycle.pattern) == pattern
    assert found.cycle.displacement == pytest.approx(displacement, rel=1e-12)


ORBIT_SCENES: list[Drawn] = [
    *draw(30, 1, ratio=(0.1, 1.0)),
    *draw(30, 2, ratio=(0.1, 1.0), ellipses=True),
    *draw(16, 3, throw=(1.01, 1.9), restitution=0.3),
    *draw(20, 4, throw=(1.01, 2.0), ratio=(0.03, 0.3)),
    *draw(20, 5, throw=(1.01, 2.0), ratio=(0.03, 0.3), ellipses=True),
    *draw(16, 6, throw=(3.3, 9.0)),
]


def test_orbits_end_where_walks_from_rest_do() -> None:
    ways, stops, far = set(), 0, 0
    for scene in ORBIT_SCENES:
        found = _cycle(*scene)
        if found is None:
            continue
        cycle, start, _ = found
        end = orbit_from(cycle, HOPS, start)
        assert end.status == Status.OK
        assert end.cycle == cycle_from(cycle, HOPS, end.velocity)
        assert abs(end.cycle.velocity - end.velocity) < 1e-11
        assert abs(end.velocity) <= cycle.bound
        velocity, change = _iterated(cycle, start)
        if abs(change) < 1e-14:
            assert end.velocity == pytest.approx(velocity, abs=1e-9)
            ways.add(math.copysign(1.0, velocity - start))
            stops += has_stop(end.cycle)
            far += abs(velocity - start) > 1e-3
    assert ways == {-1.0, 1.0}
    assert 30 < stops < 110
    assert far > 20


def test_of_several_fixed_points_the_first_on_the_way_is_reached() -> None:
    several = reached = 0
    for scene in draw(50, 8, throw=(1.01, 2.0), ratio=(0.02, 0.2), ellipses=True):
        found = _cycle(*scene)
        if found is None:
            continue
        cycle, _, _ = found
        ends = [_iterated(cycle, way * cycle.bound) for way in (-1.0, 1.0)]
        if any(abs(change) > 1e-14 for _, change in ends) or ends[1][0] - ends[0][0] < 1e-7:
            continue
        several += 1
        for share in (-1.0, -0.4, 0.0, 0.1, 0.3, 1.0):
            velocity, change = _iterated(cycle, share * cycle.bound)
            if abs(change) < 1e-14:
                reached += 1
                end = orbit_from(cycle, HOPS, share * cycle.bound)
                assert end.status == Status.OK
                assert end.velocity == pytest.approx(velocity, abs=1e-9)
    assert several > 2
    assert reached > 4 * several


def test_of_several_fixed_points_of_a_line_that_from_rest_is_reached() -> None:
    several = 0
    for scene in draw(60, 7, throw=(1.01, 2.0), ratio=(0.02, 0.2)):
        found = _cycle(*scene)
        if found is None:
            continue
        cycle, start, _ = found
        end = orbit_from(cycle, HOPS, start)
        velocity, change = _iterated(cycle, start)
        if abs(change) < 1e-14:
            assert end.velocity == pytest.approx(velocity, abs=1e-9)
            ends = [_iterated(cycle, way * cycle.bound)[0] for way in (-1.0, 1.0)]
            several += max(abs(velocity - e) for e in ends) > 1e-6
    assert several > 2


def test_where_gravity_wins_a_body_stops_or_runs_away() -> None:
    lost = stopped = 0
    for scene in [
        Drawn(line(1.9789987, 20.007654, 0.29272432, 0.050192435, -2.8908320), 0.0),
        Drawn(line(1.9583244, 42.015682, 0.91119969, 0.19707930, -11.274574), 0.0),
        Drawn(line(1.4692720, 29.524596, 0.34150943, 0.13885237, -7.9549534), 0.0),
        *draw(60, 9, throw=(1.05, 3.4), ratio=(0.3, 0.9), slope=1.4),
        *draw(100, 9, throw=(1.05, 3.4), ratio=(0.3, 0.9), slope=1.25, ellipses=True),
    ]:
        loads = scene.loads
        slope = abs(loads.weight_tangential)
        friction = loads.kinetic_friction * loads.weight_normal
        if slope < 1.01 * friction or slope >= loads.static_friction * loads.weight_normal:
            continue
        if loads.weight_across < 0.0 or (found := _cycle(*scene)) is None:
            continue
        cycle, start, _ = found
        end = orbit_from(cycle, HOPS, start)
        velocity, change = _iterated(cycle, start)
        if abs(change) < 1e-14:
            stopped += 1
            assert end.status == Status.OK
            assert has_stop(end.cycle)
            assert end.velocity == pytest.approx(velocity, abs=1e-10)
        elif abs(velocity) > 2.0 * cycle.bound:
            lost += 1
            assert velocity * loads.weight_tangential < 0.0
            assert end.status == Status.RUNAWAY
    assert lost > 10
    assert stopped > 2


def test_a_body_that_is_carried_uphill_does_not_run_away(monkeypatch: pytest.MonkeyPatch) -> None:
    """Even where the stop at which its way ends is not found."""
    loads = line(1.9583244, 42.015682, 0.91119969, 0.19707930, -11.274574)
    found = _cycle(loads._replace(line=False))
    assert found is not None
    cycle, start, _ = found
    home = orbit_from(cycle, HOPS, start)
    assert home.status == Status.OK
    downhill = home.velocity + 1e-3  # of that cycle
    begin = cycle_from(cycle, HOPS, downhill)
    assert has_stop(begin)
    assert begin.velocity < downhill
    assert orbit_from(cycle, HOPS, downhill).velocity == pytest.approx(home.velocity, abs=1e-12)
    none = Orbit(0.0, begin, Status.UNRESOLVED)
    monkeypatch.setattr(return_map_module, "_first_stopping", lambda *arguments: none)
    assert orbit_from(cycle, HOPS, downhill).status == Status.UNRESOLVED


def test_gravity_that_kinetic_friction_just_holds() -> None:
    mu_d = 1e-9
    trough = math.degrees(math.atan(mu_d))
    for throw, mu_s in ((1.0 + 1e-8, 1.5e-9), (1.2, 1e-3), (1.6, 1e-3), (2.2, 1e-3)):
        loads = line(throw, 20.0, mu_s, mu_d, trough)
        # the groups' own rounding aside
        loads = loads._replace(weight_tangential=mu_d * loads.weight_normal)
        found, period = _solved(loads)
        assert found.status == Status.BOUNDARY
        flatter, _ = _solved(loads._replace(kinetic_friction=mu_d * (1.0 + 1e-9)))
        assert flatter.status == Status.OK
        assert flatter.cycle.displacement == pytest.approx(found.cycle.displacement, rel=1e-3)
        steeper, _ = _solved(loads._replace(kinetic_friction=mu_d * (1.0 - 1e-9)))
        assert steeper.status in (Status.OK, Status.RUNAWAY)
        if throw == 1.0 + 1e-8:
            # it slides back ever faster until the trough never overtakes it
            ground = -TURN * loads.drive_tangential
            assert found.cycle.displacement / period == pytest.approx(ground, rel=1e-3)


def test_the_orbit_ends_at_the_first_of_a_continuum() -> None:
    loads = line(1.3, 20.0, 0.3, 0.1)
    loads = loads._replace(weight_tangential=0.1 * loads.weight_normal)
    found = _cycle(loads)
    assert found is not None
    cycle, _, _ = found
    # bodies that slide back alone keep their velocity
    for velocity in (-2.5, -4.0):
        assert cycle_from(cycle, HOPS, velocity).slope == 1.0
        end = orbit_from(cycle, HOPS, velocity)
        assert end.status == Status.BOUNDARY
        assert end.velocity == velocity
    first = orbit_from(cycle, HOPS, 2.0)
    assert _iterated(cycle, 2.0)[0] == pytest.approx(first.velocity, abs=1e-9)


def test_a_rest_leaves_nothing_to_rounding_where_kinetic_friction_just_holds_gravity() -> None:
    found, _ = _solved(line(1.2, 20.0, 0.5, 0.1, -math.degrees(math.atan(0.1))))
    assert found.status == Status.OK
    assert has_stop(found.cycle)


# ------------------------------------------------------------------------------- nothing acts


@pytest.mark.parametrize("throw", [2.9, 40.0, 2e3, 1e5])
def test_a_body_on_which_nothing_acts_keeps_its_velocity_over_the_ground(throw: float) -> None:
    loads = line(throw, 1.0, 0.5, 0.0)
    start = release(track_of(loads, 0.0))
    found, period = _solved(loads)
    # it may rest a little, just before the forward onset
    assert found.status == Status.OK if has_stop(found.cycle) else Status.BOUNDARY
    ground = start.velocity + loads.drive_tangential * math.cos(start.phase)
    assert found.cycle.displacement / period == pytest.approx(TURN * ground, rel=1e-8)


def test_a_stop_leads_it_to_another_velocity_for_good() -> None:
    stopped = kept = 0
    for scene in draw(120, 11, ratio=(0.0, 0.0), ellipses=True):
        found = _cycle(*scene)
        if found is None:
            continue
        cycle, start, _ = found
        end = orbit_from(cycle, HOPS, start)
        velocity, change = _iterated(cycle, start)
        assert abs(change) < 1e-13
        assert end.velocity == pytest.approx(velocity, abs=1e-12)
        if has_stop(end.cycle):
            stopped += end.status == Status.OK
        else:
            kept += end.velocity == start
            assert end.status == Status.BOUNDARY
            beside = [cycle_from(cycle, HOPS, end.velocity + h).velocity - h for h in (-1e-9, 1e-9)]
            assert min(abs(v - end.velocity) for v in beside) < 1e-12
    assert min(stopped, kept) > 10


# ------------------------------------------------------------------------------- stops


def _stops(cycle: HoppingCycle, start: float, way: float = 0.0) -> list[Orbit]:
    begin = cycle_from(cycle, HOPS, start)
    return [stopping(cycle, HOPS, start, begin, way, i) for i in range(stops_of(cycle))]


# ------------------------------------------------------------------------------- without a stop


def test_the_fixed_point_without_a_stop_is_found_from_either_side() -> None:
    seen = barred = 0
    for scene in ORBIT_SCENES[::2]:
        found = _cycle(*scene)
        if found is None:
            continue
        cycle, start, _ = found
        end = orbit_from(cycle, HOPS, start)
        stops = [o.velocity for o in _stops(cycle, start) if o.status == Status.OK]
        for way in (-1.0, 1.0):
            begin = -way * cycle.bound
            target = min((v for v in stops), key=lambda v: way * v, default=-begin)
            sliding = between(cycle, HOPS, begin, target)
            velocity, change = _iterated(cycle, begin)
            if abs(change) > 1e-14:
                continue
            now = cycle_from(cycle, HOPS, velocity)
            if has_stop(now):
                barred += 1
                assert sliding.status == Status.UNRESOLVED
            else:
                seen += 1
                assert sliding.status == Status.OK
                assert sliding.velocity == pytest.approx(velocity, abs=1e-9)
                assert not has_stop(sliding.cycle)
        if end.status == Status.OK:
            nowhere = between(cycle, HOPS, end.velocity, end.velocity)
            assert (nowhere.velocity, nowhere.status) == (end.velocity, Status.UNRESOLVED)
    assert min(seen, barred) > 20


@pytest.mark.parametrize("phase", [0.4, -2.2])
def test_ellipses_and_their_mirror_images_mirror_their_fixed_points(phase: float) -> None:
    one = ellipse(1.6, 0.8, 1.0, phase, 0.5, 0.2, 0.05)
    other = ellipse(1.6, 0.8, 1.0, phase + math.pi, 0.5, 0.2, -0.05)
    (here, _), (there, _) = _solved(one), _solved(other)
    assert here.status == there.status == Status.OK
    assert there.velocity == pytest.approx(-here.velocity, abs=1e-12)
    assert there.cycle.displacement == pytest.approx(-here.cycle.displacement, abs=1e-11)
