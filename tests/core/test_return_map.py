"""The return map of hopping bodies: hops, impacts and contact beside walks by Newton's law, and its order."""

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

from vibro.core.codes import IRREGULAR, MOST_LETTERS, Mode, spelt_text
from vibro.core.drive import Loads, phase_difference, tangential_load
from vibro.core.flight import Bounces, bed_of, bounces
from vibro.core.legs import track_of
from vibro.core.return_map import (
    Return,
    _append,
    release,
    return_map,
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
