"""Legs of one body beside Newton's law: where they end, what they hand over, and thresholds."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest
from helpers.cases import each
from helpers.followed import ALL, CONTACT, HOPS, TURN, ellipse, line, load_along, load_normal, newton, walked

from vibro.core.codes import Mode
from vibro.core.drive import Loads
from vibro.core.history import State, Step, course_of, starting, step

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
