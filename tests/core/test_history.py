"""Histories: legs that join, the cycle that stands for its repeats, and where it is looked for."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers.cases import each
from helpers.followed import (
    ALL,
    CONTACT,
    FLIGHTS,
    HOPS,
    LAST,
    LETTERS,
    TURN,
    ellipse,
    history_of,
    line,
    newton,
    room,
    walked,
)

from vibro.core import history
from vibro.core.codes import Mode
from vibro.core.history import (
    Followed,
    Launch,
    Legs,
    Sections,
    State,
    course_of,
    follow_legs,
    sections_of,
    starting,
    step,
)

INF = math.inf
STARTS = [(0.0, 0.0), (2.0, -0.8), (-8.0, 0.5)]


def _kinds(found: Followed, legs: Legs) -> tuple[str, str]:
    """Spell the transient and the cycle."""
    text = "".join(LETTERS[legs.mode[i]] for i in range(found.number))
    return text[: found.first], text[found.first :]


def _start(legs: Legs, row: int) -> float:
    return legs.cycle[row] * TURN + legs.phase[row]


def _assert_joined(found: Followed, legs: Legs) -> None:
    """Each leg starts where, when and as the one before it ends; the cycle's first behind its last."""
    for i in range(found.number):
        assert legs.length[i] > 0.0
        assert -1e-15 <= legs.phase[i] < TURN
        then, turns, advance = i + 1, 0, 0.0
        if then == found.number:
            if not found.period:
                break
            then, turns, advance = found.first, found.period, found.advance
        gap = _start(legs, then) + turns * TURN - _start(legs, i) - legs.length[i]
        assert abs(gap) < (1e-10 if then == found.first else 2e-14 * (100.0 + _start(legs, i)))
        end = legs.position[i] + legs.displacement[i]
        if turns:
            assert end == pytest.approx(legs.position[then] + advance, abs=1e-10)
        else:
            assert end == legs.position[then]
        if legs.mode[i] != Mode.FLIGHT:
            assert abs(legs.end_velocity[i] - legs.velocity[then]) <= (1e-10 if turns else 0.0)
            assert legs.impact[i] == legs.rate[i] == 0.0


@each(("phase", "velocity"), STARTS)
@each("name", ALL)
def test_legs_follow_each_other(name: str, phase: float, velocity: float) -> None:
    loads, restitution = ALL[name]
    found, legs = history_of(loads, restitution, 60.0, phase=phase, velocity=velocity)
    assert found.number > 0
    _assert_joined(found, legs)
    # and are those of the walk, until the fixed point takes over
    walk = [
        (at, leg) for at, leg in walked(course_of(loads, restitution), phase, velocity, found.number)
        if leg.length > 2e-15
    ]  # fmt: skip
    n = loads.weight_normal
    for i, (at, leg) in enumerate(walk[: min(found.first, 40)]):
        written = [buffer[i] for buffer in legs]
        expected = [
            at.mode, at.cycle, at.phase, leg.length, at.position, at.velocity, leg.displacement, leg.velocity,
            n * at.rate, n * leg.impact,
        ]  # fmt: skip
        assert written == expected


@pytest.mark.parametrize(
    ("name", "cycle", "period"),
    [
        ("F_", "F_", 1),
        ("F_B_", "F_B_", 1),
        ("FB_", "FB_", 1),
        ("BF_", "BF_", 1),
        ("B_", "B_", 1),
        ("FB", "FB", 1),
        ("FB uphill", "FB", 1),
        ("ellipse F_B_", "F_B_", 1),
        ("ellipse FB", "FB", 1),
        ("hops, HFB", "HFB", 1),
        ("hops, HB", "HB", 1),
        ("hops, HHB", "HHB", 2),
        ("hops, HHH", "HHH", 5),
        ("hops, ellipse", "HB_F", 1),
    ],
)
def test_the_stored_cycle_is_what_walking_on_would_find(name: str, cycle: str, period: int) -> None:
    loads, restitution = ALL[name]
    found, legs = history_of(loads, restitution, 1e9)
    assert found.number < 2_000
    spelt = _kinds(found, legs)[1]
    assert len(spelt) == len(cycle)
    assert spelt in 2 * cycle
    assert found.period == period
    size = found.number - found.first
    walk = [
        w for w in walked(course_of(loads, restitution), 0.0, 0.0, found.number + 4 * size) if w[1].length
    ]
    assert len(walk) > found.first + 3 * size
    for i in range(found.first, len(walk)):
        count, row = divmod(i - found.first, size)
        at, leg, row = *walk[i], found.first + row
        assert (at.mode, at.cycle) == (legs.mode[row], legs.cycle[row] + count * found.period)
        assert at.phase == pytest.approx(legs.phase[row], abs=1e-10)
        assert at.position == pytest.approx(legs.position[row] + count * found.advance, abs=1e-10)
        assert leg.length == pytest.approx(legs.length[row], abs=1e-10)


@pytest.mark.parametrize("name", ["FB", "FB uphill", "ellipse FB"])
@pytest.mark.parametrize(("phase", "velocity"), STARTS)
def test_a_cycle_without_rest_is_the_closed_form(name: str, phase: float, velocity: float) -> None:
    """Its slides start where those before them end, to rounding: no converging sequence gets so near."""
    loads = CONTACT[name]
    found, legs = history_of(loads, 0.0, 1e9, phase=phase, velocity=velocity)
    assert sorted(_kinds(found, legs)[1]) == ["B", "F"]
    first, second = found.first, found.first + 1
    joint = math.remainder(legs.phase[first] + legs.length[first] - legs.phase[second], TURN)
    assert abs(joint) < 2e-15
    assert legs.length[first] + legs.length[second] == pytest.approx(TURN, abs=4e-15)
    for row in (first, second):
        at = State(0, legs.phase[row], legs.mode[row], 0.0, 0.0, 0.0)
        path, left, _, _ = newton(loads, legs.mode[row], at, legs.length[row])
        assert left == pytest.approx(0.0, abs=4e-15)
        assert legs.displacement[row] == pytest.approx(path, abs=4e-15)
    if name == "FB":  # Eq. (20)
        a, b, mu = loads.drive_tangential, loads.drive_normal, loads.kinetic_friction
        y = 0.5 * math.pi * mu * b / a
        sin_m = mu * loads.weight_normal / (a + mu * b) * (0.5 * math.pi + y) / math.cos(y)
        swing = 2.0 * mu * b * math.cos(y) + (2.0 * mu * y * b + math.pi * a) * math.sin(y)
        advance = 2.0 * math.sqrt(1.0 - sin_m * sin_m) * swing
        assert found.advance == pytest.approx(advance, rel=1e-13)


def test_a_cycle_that_starts_with_the_drive_s_lasts_one_turn() -> None:
    """The fixed point may lie on the other side of phase 0 than the start that approaches it."""

    def start(phase_deg: float) -> tuple[float, Followed]:
        found, legs = history_of(ellipse(2.2, 0.1, phase_deg, 0.2, 0.15), 0.0, 1e9)
        _assert_joined(found, legs)
        rows = [i for i in range(found.first, found.number) if legs.mode[i] == Mode.FORWARD]
        return math.remainder(legs.phase[rows[0]], TURN), found

    low, high = -80.0, -60.0
    assert start(low)[0] < 0.0 < start(high)[0]
    seen = 0
    for _ in range(52):
        middle = 0.5 * (low + high)
        at, found = start(middle)
        assert found.period == 1
        seen += abs(at) < 1e-10
        low, high = (middle, high) if at < 0.0 else (low, middle)
    assert seen > 10


def test_the_number_of_legs_does_not_grow_with_the_number_of_cycles() -> None:
    (short, _), (long, _) = (history_of(CONTACT["FB"], 0.0, cycles) for cycles in (500.0, 1e15))
    assert short == long


def test_legs_that_do_not_fit_are_asked_for_again() -> None:
    for name, cycles in (("FB", 1e9), ("F_", 1e9), ("hops, many bounces", 9.0), ("more than 90 deg", 0.01)):
        loads, restitution = ALL[name]
        found, legs = history_of(loads, restitution, cycles)
        enough, again = history_of(loads, restitution, cycles, rows=found.number)
        assert enough == found
        assert all((np.asarray(a)[: found.number] == np.asarray(b)[: found.number]).all()
                   for a, b in zip(legs, again, strict=True))  # fmt: skip
        assert history_of(loads, restitution, cycles, rows=found.number - 1)[0].number == -1


@pytest.mark.parametrize("cycles", [0.1, 2.0, 7.3])
@pytest.mark.parametrize("phase", [0.0, 5.0])
def test_a_motion_is_followed_as_long_as_is_asked(cycles: float, phase: float) -> None:
    loads, restitution = HOPS["many bounces"]
    found, legs = history_of(loads, restitution, cycles, phase=phase)
    assert (found.period, found.first, found.advance) == (0, found.number, 0.0)
    end = _start(legs, 0) + cycles * TURN
    assert _start(legs, found.number - 1) < end
    assert _start(legs, found.number - 1) + legs.length[found.number - 1] >= end


def test_a_leg_that_starts_with_the_end_is_not_followed() -> None:
    loads, restitution = HOPS["many bounces"]
    walk = walked(course_of(loads, restitution), 0.0, 0.0, 7)
    at, origin = walk[-1][0], walk[0][0].phase
    end = at.cycle + (at.phase - origin) / TURN
    assert history_of(loads, restitution, end)[0].number == 6
    assert history_of(loads, restitution, math.nextafter(end, INF))[0].number == 7
    assert history_of(loads, restitution, 0.0)[0] == Followed(0, 0, 0, 0.0)


def test_the_last_leg_may_have_no_end() -> None:
    found, legs = history_of(line(0.4, 20.0, 0.5, 0.4), 0.0, 10.0)
    assert found == Followed(1, 1, 0, 0.0)
    assert (legs.mode[0], legs.length[0], legs.displacement[0]) == (Mode.REST, math.inf, 0.0)
    found, legs = history_of(line(0.5, 20.0, 0.5, 0.4, -40.0), 0.0, 1e9)
    assert found.first == found.number
    assert (legs.mode[found.number - 1], legs.length[found.number - 1]) == (Mode.FORWARD, math.inf)


@pytest.mark.parametrize("name", ["bounces", "many bounces", "ellipse back"])
def test_normal_speeds_are_over_those_of_the_trough(name: str) -> None:
    loads, restitution = HOPS[name]
    found, legs = history_of(loads, restitution, 20.0)
    bounced = 0
    for i in range(found.number - 1):
        if legs.mode[i] != Mode.FLIGHT:
            continue
        rate = legs.rate[i] / loads.weight_normal
        at = State(0, legs.phase[i], int(Mode.FLIGHT), 0.0, legs.velocity[i], rate)
        if legs.mode[i + 1] == Mode.FLIGHT:
            assert legs.impact[i] == pytest.approx(
                -newton(loads, Mode.FLIGHT, at, legs.length[i])[3], abs=1e-12
            )
            assert legs.rate[i + 1] == pytest.approx(restitution * legs.impact[i], rel=1e-14)
            bounced += 1
    assert bounced > 3


def test_a_cycle_of_several_flights_is_compared_flight_by_flight() -> None:
    """At another distance between the starts compared, a cycle of three flights does not close, or late."""
    loads, restitution = HOPS["HHH"]
    course, legs = course_of(loads, restitution), room(20_000)
    sections = sections_of(course, FLIGHTS)
    assert sections == Sections(3, lands=False, cycles=3)
    found = [
        follow_legs(course, sections._replace(lag=lag), Launch(0.0, 0.0, 0.0, 0.0), 900.0, legs, 20_000, LAST)
        for lag in (0, 1, 2, 3, 6)
    ]
    assert [f.period for f in found] == [0, 0, 0, 5, 10]
    assert found[3].advance == pytest.approx(0.5 * found[4].advance, rel=1e-12)


def test_a_body_that_rounding_holds_stays_where_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without length its legs would follow each other for ever."""
    loads = CONTACT["F_"]
    course = course_of(loads, 0.0)
    steps = 0

    def short(course: object, now: State) -> object:
        nonlocal steps
        steps += 1
        leg = step(course_of(loads, 0.0), now)
        return leg if steps < 3 else leg._replace(length=0.0, after=now)

    monkeypatch.setattr(history, "step", short)
    found = follow_legs(course, Sections(1, True, 1), Launch(0.0, 0.0, 0.0, 0.0), 50.0, room(99), 99, LAST)
    assert found == Followed(2, 2, 0, 0.0)
    assert starting(course, 0.0, 0.0).mode == Mode.REST
    assert 50 < steps < 200
