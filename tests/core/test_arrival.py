"""Arrival beside the history of the same body, bodies that never arrive, and jumps over whole cycles."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from helpers.cases import each
from helpers.followed import ALL, CONTACT, FLIGHTS, TURN, ellipse, history_of, line, newton, walked

from vibro.core import history
from vibro.core.codes import Mode
from vibro.core.drive import Loads
from vibro.core.history import (
    Course,
    Launch,
    Sections,
    State,
    Step,
    arrival_cycles,
    course_of,
    sections_of,
    step,
)
from vibro.core.numbers import MOST_CYCLES

STARTS = [(0.0, 0.0), (2.0, -0.8), (-8.0, 0.5)]
NAN, INF = math.nan, math.inf


def _arrival(
    loads: Loads, restitution: float, length: float, *, phase: float = 0.0, velocity: float = 0.0,
    steady: float = NAN,
) -> float:  # fmt: skip
    course = course_of(loads, restitution)
    return arrival_cycles(
        course, sections_of(course, FLIGHTS), length, Launch(phase, velocity, 0.0, 0.0), steady
    )


def _first_passage(legs: list[tuple[State, Step]], loads: Loads, length: float) -> float:
    """Cycles until a position is first reached, by Newton's law on a mesh of each leg, and halving."""
    origin = legs[0][0].phase
    for at, leg in legs:
        s = min(leg.length, 40.0)
        mesh = np.linspace(0.0, s, max(9, int(20.0 * s)))
        if at.mode == Mode.REST or (at.mode == Mode.BACK and at.position < length):
            continue
        for low, high in pairwise(mesh):
            if at.position + newton(loads, at.mode, at, float(high))[0] >= length:
                for _ in range(45):
                    middle = 0.5 * (low + high)
                    ahead = at.position + newton(loads, at.mode, at, float(middle))[0] >= length
                    low, high = (low, middle) if ahead else (middle, high)
                return float(at.cycle + (at.phase + high - origin) / TURN)
    return INF


@each(("phase", "velocity"), STARTS)
@each("name", ALL)
def test_a_body_arrives_when_newtons_law_takes_it_there(name: str, phase: float, velocity: float) -> None:
    loads, restitution = ALL[name]
    legs = walked(course_of(loads, restitution), phase, velocity, 12)
    last = legs[-1][0]
    for length in (0.31, 2.6):
        found = _arrival(loads, restitution, length, phase=phase, velocity=velocity)
        expected = _first_passage(legs, loads, length)
        if expected < INF:
            assert found == pytest.approx(expected, abs=1e-9)
        else:
            assert found > last.cycle + (last.phase - legs[0][0].phase) / TURN


@pytest.mark.parametrize("steady_known", [False, True])
@pytest.mark.parametrize(
    "name",
    [
        "F_", "F_B_", "FB_", "FB", "presses", "ellipse F_B_", "ellipse turned", "hops, HFB", "hops, HB",
        "hops, HHB", "hops, HHH", "hops, bounces", "hops, ellipse",
    ],
)  # fmt: skip
def test_whole_cycles_are_added_at_once(
    name: str, *, steady_known: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Far away, beside the walk through every cycle until there, and a million cycles farther."""
    loads, restitution = ALL[name]
    motion, _ = history_of(loads, restitution, 1e9)
    steady = motion.advance / motion.period
    assert steady > 0.0
    known = steady if steady_known else NAN
    length = 120.3 * steady
    walks = 0

    def counted(course: Course, now: State) -> Step:
        nonlocal walks
        walks += 1
        return step(course, now)

    monkeypatch.setattr(history, "step", counted)
    near = _arrival(loads, restitution, length, steady=known)
    jumped, walks = walks, 0
    # to and fro, no two cycles before a settled one take the same way
    far = _arrival(loads, restitution, length + 1e6 * motion.advance, steady=known)
    assert walks < jumped + 60
    assert far - near == pytest.approx(1e6 * motion.period, rel=1e-11)
    walks = 0
    monkeypatch.setattr(history, "_compare", lambda course, length, steady, at, memory: (at, False))
    assert _arrival(loads, restitution, length, steady=known) == pytest.approx(near, rel=1e-11)
    assert jumped < walks


@pytest.mark.parametrize(("friction", "drive"), [((0.05, 0.03), line), ((0.3, 0.05), ellipse)])
def test_the_end_of_a_slow_transient_is_summed(
    friction: tuple[float, float], drive: object, monkeypatch: pytest.MonkeyPatch
) -> None:
    loads = line(2.0, 10.0, *friction) if drive is line else ellipse(2.0, 0.2, -20.0, *friction)
    motion, legs = history_of(loads, 0.0, 1e9)
    assert motion.advance > 0.0
    settles = legs.position[motion.first]
    lengths = [settles + motion.advance * cycles for cycles in (100.7, 400.2, 2000.4)]
    lengths.insert(0, 0.999 * settles)
    summed = [_arrival(loads, 0.0, x, steady=motion.advance) for x in lengths]
    monkeypatch.setattr(history, "_LINEAR", 0.0)
    settled = [_arrival(loads, 0.0, x, steady=motion.advance) for x in lengths]
    assert summed == pytest.approx(settled, rel=1e-12)
    assert settled[3] - settled[2] == pytest.approx(1600.2, abs=1.5)


def test_a_transient_that_is_summed_may_not_have_faded_at_the_arrival(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    loads = line(2.0, 10.0, 0.3, 0.01)
    motion, legs = history_of(loads, 0.0, 1e9)
    lengths = [legs.position[motion.first] + motion.advance * cycles for cycles in (3.4, 50.4)]
    summed = [_arrival(loads, 0.0, x, steady=motion.advance) for x in lengths]
    monkeypatch.setattr(history, "_LINEAR", 0.0)
    walked_to = [_arrival(loads, 0.0, x, steady=motion.advance) for x in lengths]
    assert summed == pytest.approx(walked_to, rel=1e-12)


def test_the_way_a_body_has_gone_counts_if_the_steady_cycle_given_is_another() -> None:
    for name in ("F_", "FB", "hops, HB"):
        loads, restitution = ALL[name]
        motion, _ = history_of(loads, restitution, 1e9)
        length = 900.3 * motion.advance
        expected = _arrival(loads, restitution, length, steady=NAN)
        for other in (-0.5 * motion.advance, 0.0, 1.7 * motion.advance):
            assert _arrival(loads, restitution, length, steady=other) == pytest.approx(expected, rel=1e-11)


@pytest.mark.parametrize("name", ["B_", "BF_", "FB uphill", "ellipse FB", "hops, ellipse back"])
def test_a_body_that_goes_back_never_arrives_beyond_its_farthest_position(name: str) -> None:
    loads, restitution = ALL[name]
    motion, _ = history_of(loads, restitution, 1e9, velocity=0.9)
    assert motion.advance < 0.0
    course = course_of(loads, restitution)
    top, when = 0.0, 0.0
    for at, leg in walked(course, 0.0, 0.9, 24):
        if at.mode in (Mode.REST, Mode.BACK):
            continue
        for share in np.linspace(0.0, 1.0, 150):
            x = at.position + newton(loads, at.mode, at, share * leg.length)[0]
            if x > top:
                top, when = x, at.cycle + (at.phase + share * leg.length) / TURN
    steady = motion.advance / motion.period
    start = course_of(loads, restitution)
    origin = walked(start, 0.0, 0.9, 1)[0][0].phase / TURN
    just_below = _arrival(loads, restitution, top * (1.0 - 1e-4), velocity=0.9, steady=steady)
    assert just_below < when - origin + 1e-6
    for known in (steady, NAN):
        assert _arrival(loads, restitution, top * (1.0 + 1e-4), velocity=0.9, steady=known) == INF


def test_the_end_of_a_slide_is_reached_and_what_lies_behind_it_is_not() -> None:
    """Rest follows, and the next slide a cycle later goes on."""
    loads = CONTACT["F_"]
    (_, _), (at, leg), (then, _) = walked(course_of(loads, 0.0), 0.0, 0.0, 3)
    end = leg.after.position
    stop = at.cycle + (at.phase + leg.length) / TURN
    assert then.mode == Mode.REST
    assert _arrival(loads, 0.0, math.nextafter(end, 0.0)) == pytest.approx(stop, abs=1e-7)
    assert _arrival(loads, 0.0, end) == pytest.approx(stop, abs=1e-7)
    later = _arrival(loads, 0.0, end * (1.0 + 1e-9))
    assert 1.0 + at.phase / TURN < later < 1.02 + at.phase / TURN


@pytest.mark.timeout(10)  # where one is followed to the end, it takes a minute
def test_bodies_at_rest_and_to_and_fro_never_arrive() -> None:
    assert _arrival(line(0.4, 20.0, 0.5, 0.4), 0.0, 1e-9) == INF
    level = line(3.0, 0.0, 0.74, 0.57)
    motion, legs = history_of(level, 0.0, 1e9)
    top = max(legs.position[i] + max(legs.displacement[i], 0.0) for i in range(motion.number))
    assert _arrival(level, 0.0, top * (1.0 - 1e-9), steady=0.0) < 40.0
    assert _arrival(level, 0.0, top * (1.0 + 1e-9), steady=0.0) == INF


def test_endless_slides() -> None:
    down, up = (line(0.5, 20.0, 0.5, 0.4, degrees) for degrees in (-40.0, 40.0))
    for length in (0.1, 3.0, 1e3, 1e9):
        found = _arrival(down, 0.0, length)
        at, leg = walked(course_of(down, 0.0), 0.0, 0.0, 9)[-1]
        assert leg.length == INF
        start = at.cycle + at.phase / TURN
        if length > at.position and length < 1e4:
            path = newton(down, Mode.FORWARD, at, (found - start) * TURN)[0]
            assert at.position + path == pytest.approx(length, rel=1e-10)
        # the weight less friction, over n w^2
        fall = (math.sin(math.radians(40.0)) - 0.4 * math.cos(math.radians(40.0))) / 0.5
        if length >= 1e9:
            assert found * TURN == pytest.approx(math.sqrt(2.0 * length / fall), rel=1e-3)
        assert _arrival(up, 0.0, length) == INF


@pytest.mark.parametrize("velocity", [-0.4, 0.3, 2.0])
@pytest.mark.parametrize("slope", [0.0, 3.0, -3.0])
def test_arrivals_in_flights_of_many_turns(velocity: float, slope: float) -> None:
    """There the velocity turns twice a cycle; a hundred turns without an arrival are passed over."""
    loads = line(600.0, 40.0, 0.5, 0.4, slope)
    course = course_of(loads, 0.0)
    lift_off = course.track.lift_off
    at, leg = walked(course, lift_off + 0.5, velocity, 1)[0]
    assert at.mode == Mode.FLIGHT
    assert leg.length > 100.0
    mesh = np.linspace(0.0, leg.length, 40_001)
    a, t = loads.drive_tangential, loads.weight_tangential
    path = velocity * mesh + a * (mesh * math.cos(at.phase) - np.sin(at.phase + mesh) + math.sin(at.phase))
    path -= 0.5 * t * mesh * mesh
    for share in (1e-4, 0.03, 0.5, 0.97, 0.99999):
        length = share * float(path.max())
        first = int(np.argmax(path >= length))
        exact = np.interp(length, path[first - 1 : first + 1], mesh[first - 1 : first + 1])
        found = _arrival(loads, 0.0, length, phase=lift_off + 0.5, velocity=velocity)
        assert found * TURN == pytest.approx(exact, abs=2e-3)
        s = found * TURN
        assert newton(loads, Mode.FLIGHT, at, s)[0] == pytest.approx(length, rel=1e-11, abs=1e-11)


@pytest.mark.parametrize(
    ("load", "drive_deg", "trough_deg", "later", "velocity"),
    [(1.53, 52.0, 29.7, 0.465, -0.135), (1.582, 48.85, -28.67, 0.07, -0.963)],
    ids=["up", "down"],
)
def test_arrivals_in_flights_along_a_steep_trough(
    load: float, drive_deg: float, trough_deg: float, later: float, velocity: float
) -> None:
    """Upwards the velocity turns twice within half a turn; downwards gravity outgrows the drive."""
    loads = line(load, drive_deg, 1.9, 1.5, trough_deg)
    course = course_of(loads, 0.0)
    phase = course.track.lift_off + later
    legs = walked(course, phase, velocity, 1)
    at, leg = legs[0]
    assert at.mode == Mode.FLIGHT
    top = max(newton(loads, at.mode, at, s)[0] for s in np.linspace(0.0, leg.length, 200).tolist())
    assert top > 0.0
    for share in (0.2, 0.5, 0.9, 0.999):
        found = _arrival(loads, 0.0, share * top, phase=phase, velocity=velocity)
        assert found == pytest.approx(_first_passage(legs, loads, share * top), abs=1e-9)


def test_flights_along_a_trough_that_does_not_move_along_itself() -> None:
    loads = ellipse(3.0, 1.0, 0.0, 0.5, 0.4)._replace(drive_tangential=0.0)
    found = _arrival(loads, 0.0, 0.5, phase=1.0, velocity=0.7)
    assert found * TURN == pytest.approx(0.5 / 0.7, rel=1e-12)
    assert _arrival(loads, 0.0, 1e3, phase=1.0, velocity=0.7) == INF
    assert _arrival(loads, 0.0, 0.5) == INF


def test_motion_without_a_period_is_unknown_once_rounding_has_grown() -> None:
    loads = line(12.0, 30.0, 0.5, 0.4)
    assert sections_of(course_of(loads, 0.3), FLIGHTS) == Sections(0, lands=False, cycles=0)
    assert 0.0 < _arrival(loads, 0.3, 1.0) < 5.0
    assert math.isnan(_arrival(loads, 0.3, 1e5))
    # rounding does not matter to a body that comes to rest on the trough in between
    for name in ("hops, HFB", "hops, bounces"):
        assert _arrival(*ALL[name], 1e5) > 1e3


def test_ways_without_end_are_unknown(monkeypatch: pytest.MonkeyPatch) -> None:
    loads = CONTACT["F_"]
    motion, _ = history_of(loads, 0.0, 1e9)
    near = _arrival(loads, 0.0, 0.9 * MOST_CYCLES * motion.advance, steady=motion.advance)
    assert near == pytest.approx(0.9 * MOST_CYCLES, rel=1e-14)
    assert math.isnan(_arrival(loads, 0.0, 1.1 * MOST_CYCLES * motion.advance, steady=motion.advance))
    monkeypatch.setattr(history, "_MOST_LEGS", 60)
    slow = line(1.5, 20.0, 0.3, 0.01)
    assert math.isnan(_arrival(slow, 0.0, 1e6))


def test_a_start_that_does_not_come_again_is_not_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pushed back at first, the body slides forward alone later."""
    loads = CONTACT["F_"]
    motion, legs = history_of(loads, 0.0, 1e9, velocity=-0.8)
    assert legs.mode[0] == Mode.BACK
    assert Mode.BACK not in [legs.mode[i] for i in range(motion.first, motion.number)]
    monkeypatch.setattr(history, "_MOST_LEGS", 60)
    found = _arrival(loads, 0.0, 1e6 * motion.advance, velocity=-0.8, steady=motion.advance)
    assert found == pytest.approx(1e6, rel=1e-5)


def test_a_body_without_kinetic_friction_that_repeats_is_moved_on() -> None:
    """Nothing brings its cycle back after a push, but from rest it repeats exactly."""
    loads = line(1.5, 20.0, 0.5, 0.0)
    motion, _ = history_of(loads, 0.0, 1e9)
    assert motion.advance > 0.0
    length = 1e6 * motion.advance
    assert _arrival(loads, 0.0, length, steady=motion.advance) == pytest.approx(1e6, rel=1e-5)


@pytest.mark.parametrize("name", ["F_", "FB", "hops, bounces", "ellipse turned"])
def test_arrivals_count_from_the_start(name: str) -> None:
    """A later start in the same motion arrives as much earlier."""
    loads, restitution = ALL[name]
    course = course_of(loads, restitution)
    legs = walked(course, 0.0, 0.0, 30)
    at = next(state for state, _ in legs[6:] if state.mode in (Mode.FORWARD, Mode.BACK) and state.rate == 0.0)
    phi = math.atan2(loads.phase_sine, loads.phase_cosine)
    target = at.position + 9.7
    whole = _arrival(loads, restitution, target)
    phase = at.phase - phi
    rest = _arrival(loads, restitution, 9.7, phase=phase + 1e-12, velocity=at.velocity)
    passed = at.cycle + (at.phase - legs[0][0].phase) / TURN
    assert whole - passed == pytest.approx(rest, abs=1e-7)
