"""Legs, histories and arrivals of one body: beside the law of Newton and 60 digits."""

from __future__ import annotations

import math
from itertools import pairwise

import mpmath
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
    load_along,
    load_normal,
    newton,
    room,
    walked,
)

from vibro.core import history
from vibro.core.codes import Mode
from vibro.core.drive import Loads
from vibro.core.history import (
    Course,
    Followed,
    Launch,
    Legs,
    Sections,
    State,
    Step,
    arrival_cycles,
    course_of,
    follow_legs,
    sections_of,
    starting,
    step,
)
from vibro.core.numbers import MOST_CYCLES

STARTS = [(0.0, 0.0), (4.0, -0.8), (-8.0, 0.5)]


def _check(loads: Loads, restitution: float, at: State, leg: Step) -> None:
    """Compare a leg with Newton's law, and its end with the event that ends it."""
    after, s = leg.after, leg.length
    path, velocity, height, rate = newton(loads, at.mode, at, s)
    mesh = at.phase + s * np.linspace(1e-6, 1.0 - 1e-6, 60)
    along, normal = load_along(loads, mesh), load_normal(loads, mesh)
    end_along, end_normal = float(load_along(loads, at.phase + s)), float(load_normal(loads, at.phase + s))
    capacity = loads.static_friction * end_normal
    assert after.cycle * TURN + after.phase == pytest.approx(at.cycle * TURN + at.phase + s, abs=1e-12)
    assert -1e-15 <= after.phase < TURN
    assert after.position == at.position + leg.displacement
    if at.mode == Mode.FLIGHT:
        assert leg.displacement == pytest.approx(path, abs=1e-12)
        assert leg.velocity == pytest.approx(velocity, abs=1e-12)
        inside = [newton(loads, at.mode, at, share * s)[2] for share in (0.01, 0.3, 0.6, 0.9, 0.99)]
        assert min(inside) > 0.0 or s < 1e-4
        n = loads.weight_normal
        assert height == pytest.approx(0.0, abs=1e-8)  # of the bounces that are summed
        if after.mode == Mode.FLIGHT:
            assert leg.impact * n == pytest.approx(-rate, abs=1e-12)
            assert after.rate == restitution * leg.impact
        impulse = loads.kinetic_friction * n * (1.0 + restitution) * leg.impact
        left = max(abs(leg.velocity) - impulse, 0.0)
        assert after.velocity == pytest.approx(math.copysign(left, leg.velocity), abs=1e-7)
        assert leg.gain == (1.0 if after.velocity else 0.0)
        return
    assert (normal > -1e-12).all()
    assert leg.impact == after.rate == at.rate == 0.0
    assert after.velocity == leg.velocity
    leaves = after.mode == Mode.FLIGHT
    if at.mode == Mode.REST:
        assert leg.displacement == leg.velocity == leg.gain == 0.0
        assert (np.abs(along) <= loads.static_friction * normal + 1e-9).all()
        if not leaves:
            way = 1.0 if after.mode == Mode.FORWARD else -1.0
            assert way * end_along == pytest.approx(capacity, abs=1e-12)
    else:
        way = 1.0 if at.mode == Mode.FORWARD else -1.0
        inside = [way * newton(loads, at.mode, at, share * s)[1] for share in (0.05, 0.3, 0.6, 0.95)]
        assert min(inside) > 0.0 or s < 1e-4
        assert leg.displacement == pytest.approx(path, abs=1e-12)
        assert leg.velocity == pytest.approx(velocity, abs=1e-12)
        if leaves:
            assert leg.gain == 1.0
            assert way * leg.velocity >= 0.0
        else:
            assert leg.velocity == 0.0
            expected = (
                Mode.REST if abs(end_along) <= capacity else Mode.FORWARD if end_along > 0 else Mode.BACK
            )
            assert after.mode == expected
            assert (leg.gain == 0.0) == (after.mode == Mode.REST)
    if leaves:
        assert end_normal == pytest.approx(0.0, abs=1e-12)
        assert math.cos(at.phase + s) > 0.0  # the trough begins to fall away


@each(("phase", "velocity"), STARTS)
@each("name", ALL)
def test_legs_obey_newtons_law_and_end_at_their_events(name: str, phase: float, velocity: float) -> None:
    loads, restitution = ALL[name]
    legs = walked(course_of(loads, restitution), phase, velocity, 24)
    for (at, leg), (then, _) in zip(legs, [*legs[1:], (legs[-1][1].after, None)], strict=True):
        assert then == leg.after
        _check(loads, restitution, at, leg)


@each("name", ALL)
def test_scenes_have_all_kinds_of_legs(name: str) -> None:
    loads, restitution = ALL[name]
    kinds = {at.mode for phase, v in STARTS for at, _ in walked(course_of(loads, restitution), phase, v, 24)}
    assert len(kinds) >= 2
    assert (Mode.FLIGHT in kinds) == name.startswith("hops")


@each("name", ALL)
def test_rests_end_at_onsets_and_contacts_at_the_lift_off_themselves(name: str) -> None:
    loads, restitution = ALL[name]
    course = course_of(loads, restitution)
    exact = {Mode.FORWARD: course.track.forward_onset, Mode.BACK: course.track.back_onset}
    for at, leg in walked(course, 0.0, 0.0, 24):
        if leg.after.mode == Mode.FLIGHT and at.mode != Mode.FLIGHT:
            assert leg.after.phase == course.track.lift_off
        elif at.mode == Mode.REST:
            assert leg.after.phase == exact[Mode(leg.after.mode)]


def test_onsets_are_those_of_theory() -> None:
    course = course_of(line(1.3, 20.0, 0.5, 0.4, 3.0), 0.0)
    a, b = math.cos(math.radians(20.0)), math.sin(math.radians(20.0))
    n, t = math.cos(math.radians(3.0)) / 1.3, math.sin(math.radians(3.0)) / 1.3
    ahead, behind = (0.5 * n + t) / (a + 0.5 * b), (0.5 * n - t) / (a - 0.5 * b)
    assert course.track.forward_onset == pytest.approx(math.asin(ahead), rel=1e-14)
    assert course.track.back_onset == pytest.approx(math.pi + math.asin(behind), rel=1e-14)
    assert course.rests
    assert course.bed.throw == b / n
    assert course.restitution == 0.0


@pytest.mark.parametrize("slope", [0.0, 3.0])
@pytest.mark.parametrize("excess", [1e-13, 1e-9, 1e-5])
def test_short_slides_keep_their_digits(excess: float, slope: float) -> None:
    """Just above the onset, beside 60 digits: the length, and the displacement of the order of its cube."""
    static, kinetic = 0.5, 0.5 * (1.0 - 1e-3 * excess)
    drive, trough = math.radians(20.0), math.radians(slope)
    onset = (static * math.cos(trough) + math.sin(trough)) / (math.cos(drive) + static * math.sin(drive))
    loads = line(onset * (1.0 + excess), 20.0, static, kinetic, slope)
    (_, rest), (at, leg) = walked(course_of(loads, 0.0), 0.0, 0.0, 2)
    assert rest.after.mode == Mode.FORWARD
    with mpmath.workdps(60):
        a, b, n, t = (mpmath.mpf(x) for x in loads[:4])
        p = mpmath.asin((static * n + t) / (a + static * b))
        c = a + kinetic * b
        k = (kinetic * n + t) / c

        def velocity(s: mpmath.mpf) -> mpmath.mpf:
            return (mpmath.cos(p) - mpmath.cos(p + s)) / s - k

        s = mpmath.findroot(velocity, (0.9 * leg.length, 1.1 * leg.length))
        path = c * (s * mpmath.cos(p) - mpmath.sin(p + s) + mpmath.sin(p) - k * s * s / 2)
        assert leg.length == pytest.approx(float(s), rel=2e-15)
        assert leg.displacement == pytest.approx(float(path), rel=1e-14)
        assert at.phase == pytest.approx(float(p), abs=4e-16)


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize("excess", [1e-12, 1e-6, 0.1])
def test_onsets_in_short_windows_keep_their_digits(way: float, excess: float) -> None:
    """Beside 60 digits; half of them is lost in the arc sine of a number next to 1."""
    for phi in (-2.1, -0.4, 1.3):
        static, b = 0.5, 0.3
        level, steep = way * math.cos(phi) + static * b, way * math.sin(phi)
        weight = math.sqrt(level * level + steep * steep) / static / (1.0 + excess)
        loads = ellipse(1.0 / weight, b, math.degrees(phi), static, 0.4)
        track = course_of(loads, 0.0).track
        with mpmath.workdps(60):
            a, b_, n, sine, cosine = (mpmath.mpf(x) for x in (
                loads.drive_tangential, loads.drive_normal, loads.weight_normal, loads.phase_sine,
                loads.phase_cosine,
            ))  # fmt: skip
            level_, steep_ = way * a * cosine + static * b_, way * a * sine
            size = mpmath.sqrt(level_ * level_ + steep_ * steep_)
            onset = float(mpmath.asin(static * n / size) + mpmath.atan2(steep_, level_))
        found = track.forward_onset if way > 0.0 else track.back_onset
        assert 0.0 <= found < TURN
        noise = 8.0 * 2.0**-52 / math.sqrt(excess) * (0.1 if excess < 1e-9 else 1.0)
        assert abs(math.remainder(found - onset, TURN)) < noise + 4e-15


@pytest.mark.parametrize("name", ["F_B_", "FB", "FB uphill", "ellipse FB", "ellipse turned"])
def test_slides_that_follow_each_other_are_as_sharp(name: str) -> None:
    loads = CONTACT[name]
    turned = [
        (at, leg) for at, leg in walked(course_of(loads, 0.0), 0.0, 0.0, 60)
        if at.mode != Mode.REST and at.velocity == 0.0
    ]  # fmt: skip
    assert len(turned) > 10
    for at, leg in turned:
        path, velocity, _, _ = newton(loads, at.mode, at, leg.length)
        assert velocity == pytest.approx(0.0, abs=2e-15)
        assert leg.displacement == pytest.approx(path, abs=2e-15 * leg.length**2)


def test_a_start_is_reduced_and_counts_from_the_motion_along_the_trough() -> None:
    of_line, of_ellipse = course_of(CONTACT["FB"], 0.0), course_of(CONTACT["ellipse FB"], 0.0)
    for turns in (-3, 0, 2):
        at = starting(of_line, 1.0 + turns * TURN, 0.25)
        assert (at.cycle, at.position, at.velocity, at.rate) == (0, 0.0, 0.25, 0.0)
        assert at.phase == pytest.approx(1.0, abs=1e-14)
        at = starting(of_ellipse, 1.0 + turns * TURN, 0.0)
        assert at.phase == pytest.approx(1.0 + math.radians(130.0), abs=1e-14)
    assert [starting(of_line, 0.0, v).mode for v in (-1.0, 0.0, 1.0)] == [Mode.BACK, Mode.REST, Mode.FORWARD]
    assert starting(of_line, 0.5 * math.pi, 0.0).mode == Mode.FORWARD
    assert starting(of_line, 1.5 * math.pi, 0.0).mode == Mode.BACK


def test_a_body_leaves_at_once_where_the_trough_cannot_bear_it() -> None:
    loads, _ = HOPS["HFB"]
    course = course_of(loads, 0.0)
    edge = course.track.lift_off
    assert edge == pytest.approx(math.asin(1.0 / (3.4 * math.sin(math.radians(30.0)))), rel=1e-15)
    modes = [starting(course, edge + d, 0.0).mode for d in (-1e-9, 1e-9)]
    assert modes == [Mode.FORWARD, Mode.FLIGHT]
    modes = [starting(course, math.pi - edge + d, 0.7).mode for d in (-1e-9, 1e-9)]
    assert modes == [Mode.FLIGHT, Mode.FORWARD]
    loads, _ = HOPS["ellipse thrown at once"]  # from rest too
    at = starting(course_of(loads, 0.0), 0.0, 0.0)
    assert (at.mode, at.rate) == (Mode.FLIGHT, 0.0)
    assert load_normal(loads, at.phase) < 0.0


@pytest.mark.parametrize(("above", "hops"), [(-1e-14, False), (0.0, False), (1e-14, True)])
def test_bodies_hop_above_a_throw_number_of_one(above: float, *, hops: bool) -> None:
    loads = line(1.0, 90.0 - 1e-9, 0.5, 0.4)._replace(drive_normal=1.0 + above, weight_normal=1.0)
    course = course_of(loads, 0.0)
    assert math.isfinite(course.track.lift_off) == hops
    assert starting(course, 0.5 * math.pi, 0.0).mode != Mode.FLIGHT or hops


def test_a_line_that_presses_more_than_it_pushes_starts_no_body_back() -> None:
    """With mu_s b > a the load that would do it comes where the body flies."""
    loads = line(3.25, 64.3, 0.78, 0.37, -4.5)
    assert loads.static_friction * loads.drive_normal > loads.drive_tangential
    course = course_of(loads, 0.3)
    assert math.isnan(course.track.back_onset)
    assert math.isnan(course.back.onset.k)
    assert math.isfinite(course.track.forward_onset)


def test_static_friction_without_measure_holds_a_body_until_it_is_thrown() -> None:
    """Its windows are too short for the sharp form of their starts."""
    loads = ellipse(8.0, 1.0, 180.0, 1e40, 1e10)
    course = course_of(loads, 0.9)
    for onset in (course.track.forward_onset, course.track.back_onset):
        assert onset == pytest.approx(course.track.lift_off, abs=1e-12)
    assert [at.mode for at, _ in walked(course, 0.0, 0.0, 3)][-1] == Mode.FLIGHT


def test_a_body_that_never_slips_rests_for_ever() -> None:
    ((at, leg),) = walked(course_of(line(0.4, 20.0, 0.5, 0.4), 0.0), 0.0, 0.0, 5)
    assert (at.mode, leg.length, leg.displacement, leg.velocity) == (Mode.REST, math.inf, 0.0, 0.0)
    assert math.isnan(leg.after.phase)


@pytest.mark.parametrize(("trough", "mode"), [(-40.0, Mode.FORWARD), (40.0, Mode.BACK)])
def test_on_a_steep_trough_a_slide_never_ends(trough: float, mode: Mode) -> None:
    course = course_of(line(0.5, 20.0, 0.5, 0.4, trough), 0.0)
    assert not course.rests
    at, leg = walked(course, 0.0, 0.0, 9)[-1]
    assert (at.mode, leg.length, leg.gain) == (mode, math.inf, 1.0)
    assert math.isnan(leg.displacement)
    assert math.isnan(leg.after.position)
    assert (leg.impact, leg.after.rate, leg.after.cycle) == (0.0, 0.0, at.cycle)
    # equality is not held
    loads = line(0.5, 20.0, 0.5, 0.4, 5.0)._replace(weight_normal=1.0, weight_tangential=0.5)
    assert not course_of(loads, 0.0).rests
    assert course_of(line(0.5, 20.0, 0.5, 0.4, math.copysign(26.5, trough)), 0.0).rests
    assert not course_of(line(0.5, 20.0, 0.5, 0.4, math.copysign(26.6, trough)), 0.0).rests


@pytest.mark.parametrize(("friction", "gain"), [(1e-3, 1.0), (5.0, 0.0)])
def test_friction_may_take_all_speed_in_an_impact(friction: float, gain: float) -> None:
    loads = HOPS["HFB"][0]._replace(static_friction=friction, kinetic_friction=friction)
    legs = walked(course_of(loads, 0.0), 0.0, 0.0, 24)
    flights = [leg for at, leg in legs if at.mode == Mode.FLIGHT]
    assert len(flights) > 3
    assert {leg.gain for leg in flights} == {gain}
    assert {leg.after.velocity == 0.0 for leg in flights} == {gain == 0.0}


def test_bounces_that_accumulate_are_one_leg() -> None:
    """A body that lands softly: its bounces last and brake as their sums say, Eq. (33)."""
    loads, e = line(3.0, 30.0, 0.5, 0.4), 0.5
    course = course_of(loads, e)
    at = State(2, 4.5, int(Mode.FLIGHT), 1.0, 0.3, 1e-9)
    leg = step(course, at)
    normal = float(load_normal(loads, 4.5))
    v = 1e-9 * loads.weight_normal
    assert leg.after.mode == Mode.FORWARD
    assert leg.after.rate == 0.0
    assert leg.length == pytest.approx(2.0 * v / normal / (1.0 - e), rel=1e-6)
    # impulses: v (1 + e) at the first landing, and the same share of each bounce after it
    assert leg.after.velocity - leg.velocity == pytest.approx(-0.4 * v * (1.0 + e) / (1.0 - e), rel=1e-6)
    assert leg.after.cycle == 2


def test_a_rest_that_ends_where_the_drive_s_cycle_begins_counts_that_cycle() -> None:
    """Rounding may leave its end on the other side."""
    course = course_of(CONTACT["F_"], 0.0)
    for onset in (0.0, 1e-16, math.nextafter(TURN, 0.0)):
        there = course._replace(track=course.track._replace(forward_onset=onset))
        for phase in np.linspace(0.5, 6.0, 200):
            after = step(there, State(7, float(phase), int(Mode.REST), 0.0, 0.0, 0.0)).after
            assert after.phase == onset
            assert after.cycle == (8 if onset < 1.0 else 7)


def test_states_are_mirrored_with_the_drive() -> None:
    """From the other end forward is back: half a turn more of phase, and the slope turned."""
    one, other = ellipse(2.2, 0.4, 130.0, 0.2, 0.15, 2.0), ellipse(2.2, 0.4, -50.0, 0.2, 0.15, -2.0)
    ours, theirs = (walked(course_of(loads, 0.0), p, v, 20) for loads, p, v in (
        (one, 0.4, 0.1), (other, 0.4 + math.pi, -0.1),
    ))  # fmt: skip
    swapped = {Mode.FORWARD: Mode.BACK, Mode.BACK: Mode.FORWARD, Mode.REST: Mode.REST}
    for (at, leg), (at_2, leg_2) in zip(ours, theirs, strict=True):
        assert at_2.mode == swapped[Mode(at.mode)]
        assert leg_2.displacement == pytest.approx(-leg.displacement, abs=1e-13)


# ------------------------------------------------------------------------------
# Histories: legs that join, the cycle that stands for its repeats, and where it is looked for.


INF = math.inf
HISTORY_STARTS = [(0.0, 0.0), (2.0, -0.8), (-8.0, 0.5)]


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


@each(("phase", "velocity"), HISTORY_STARTS)
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
@pytest.mark.parametrize(("phase", "velocity"), HISTORY_STARTS)
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


# ------------------------------------------------------------------------------
# Arrival beside the history of the same body, bodies that never arrive, and jumps over whole cycles.


ARRIVAL_STARTS = [(0.0, 0.0), (2.0, -0.8), (-8.0, 0.5)]
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


@each(("phase", "velocity"), ARRIVAL_STARTS)
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
