"""Legs in contact: forcing, onsets, slides from any speed beside a fine mesh and 40 digits, rest, turns."""

from __future__ import annotations

import math
import random

import mpmath
import numpy as np
import pytest
from helpers.cases import each

from vibro.core.codes import Mode
from vibro.core.drive import Loads, directions, ellipse_loads, line_loads
from vibro.core.legs import Forcing, contact_leg, forcing, mode_of, slide_from_speed, track_of
from vibro.core.numbers import until

TURN = 2.0 * math.pi
EPS = 2.0**-52


def _line(drive: float, weight: float, static: float, kinetic: float, trough: float = 0.0) -> Loads:
    return line_loads(weight, directions(math.radians(drive), math.radians(trough)), static, kinetic)


def _ellipse(
    normal: float, phase: float, weight: float, static: float, kinetic: float, trough: float = 0.0
) -> Loads:
    angles = directions(phase, math.radians(trough))
    return ellipse_loads(1.0, normal, weight, angles, static, kinetic)


SCENES = [
    _line(20.0, 0.8, 0.5, 0.4),
    _line(35.0, 0.9, 0.6, 0.3, -8.0),
    _line(80.0, 1.1, 0.9, 0.7, 3.0),  # pressed down more than pushed
    _ellipse(0.4, -1.4, 0.7, 0.5, 0.35),
    _ellipse(0.7, 2.1, 0.9, 0.8, 0.6, 5.0),
]


def _tangential(loads: Loads, phase: float) -> float:
    """F of Eq. (54), at a phase of the normal motion."""
    phi = math.atan2(loads.phase_sine, loads.phase_cosine)
    return loads.drive_tangential * math.sin(phase - phi) - loads.weight_tangential


def _normal(loads: Loads, phase: float) -> float:
    return loads.weight_normal - loads.drive_normal * math.sin(phase)


# ---------------------------------------------------------------------------------------------- forcing


@each("loads", SCENES)
@each("way", [1.0, -1.0])
def test_forcing_is_load_less_kinetic_friction(loads: Loads, way: float) -> None:
    at = forcing(loads, way)
    for phase in np.linspace(0.0, TURN, 17).tolist():
        expected = way * _tangential(loads, phase) - loads.kinetic_friction * _normal(loads, phase)
        assert at.amplitude * math.sin(phase + at.shift) - at.drag == pytest.approx(expected, abs=1e-15)
    assert at.amplitude >= 0.0


def test_forcing_stays_finite_where_friction_and_weight_are_extreme() -> None:
    at = forcing(Loads(0.5, 0.5, 1e307, -1e306, 1.0, 1e300, 1e300, 0.0, 1.0, True), 1.0)
    assert all(math.isfinite(x) for x in at)
    end = slide_from_speed(at, 1.0, 1e3, math.inf)
    assert end.stopped
    assert end.length == pytest.approx(0.0, abs=1e-100)


# ---------------------------------------------------------------------------------------------- onsets


@pytest.mark.parametrize("loads", SCENES)
def test_a_body_at_rest_starts_where_the_load_outgrows_static_friction(loads: Loads) -> None:
    track = track_of(loads, 0.0)
    onsets = [(track.forward_onset, Mode.FORWARD), (track.back_onset, Mode.BACK)]
    assert any(not math.isnan(onset) for onset, _ in onsets)
    for onset, mode in onsets:
        if not math.isnan(onset):
            assert 0.0 <= onset < TURN
            assert mode_of(loads, onset - 1e-9, 0.0, loads.static_friction) == Mode.REST
            assert mode_of(loads, onset + 1e-9, 0.0, loads.static_friction) == mode


@pytest.mark.parametrize(("factor", "starts"), [(1.0 - 1e-12, True), (1.0, False), (1.0 + 1e-12, False)])
def test_a_load_that_just_equals_static_friction_starts_no_slide(factor: float, starts: bool) -> None:
    # alpha = 0, level trough: the load has amplitude 1 both ways, friction holds mu_s n
    track = track_of(Loads(1.0, 0.0, 2.0 * factor, 0.0, 2.0, 0.5, 0.4, 0.0, 1.0, True), 0.0)
    assert math.isnan(track.forward_onset) is not starts
    assert math.isnan(track.back_onset) is not starts


@pytest.mark.parametrize(
    ("load", "drive", "trough"), [(3.2, 73.0, -39.0), (1.8, 46.5, 40.1), (1.6, 65.2, 8.0)]
)
def test_a_body_that_its_drive_presses_down_never_starts_back_in_contact(
    load: float, drive: float, trough: float
) -> None:
    # Eq. (7) holds up to the lift-off at any throw number
    loads = _line(drive, 1.0 / load, 1.6, 0.8, trough)
    assert loads.drive_tangential < loads.static_friction * loads.drive_normal
    assert math.isnan(track_of(loads, 0.0).back_onset)
    touches = [p for p in np.linspace(0.0, TURN, 2001).tolist() if _normal(loads, p) > 0.0]
    assert len(touches) > 1000
    assert all(mode_of(loads, phase, 0.0, loads.static_friction) != Mode.BACK for phase in touches)


@pytest.mark.parametrize("throw", [1.0 - 1e-15, 1.0, 1.0 + 1e-15, 2.0, 1e6])
def test_the_trough_falls_away_at_the_phase_whose_sine_is_one_over_the_throw_number(throw: float) -> None:
    lift_off = track_of(Loads(0.8, throw, 1.0, 0.0, 0.8, 0.5, 0.4, 0.0, 1.0, True), 0.0).lift_off
    if throw > 1.0:
        assert 0.0 < lift_off < 0.5 * math.pi
        assert math.sin(lift_off) == pytest.approx(1.0 / throw, rel=1e-15)
    else:
        assert lift_off == math.inf


def test_a_phase_a_rounding_after_an_event_is_at_the_event() -> None:
    assert [until(0.3, 0.3), until(0.3, 0.3 + 1e-12), until(6.2831, 6.2831 + 8e-16)] == [0.0, 0.0, 0.0]
    assert until(0.3, 0.3 - 1e-12) == pytest.approx(1e-12, abs=1e-15)
    assert until(0.3, 0.3 + 1e-6) == pytest.approx(TURN - 1e-6)
    assert until(0.3, 1.3) == pytest.approx(TURN - 1.0)
    assert until(1.3, 0.3) == pytest.approx(1.0)


# ---------------------------------------------------------------------------------- slides from any speed


def _slides(count: int, seed: int) -> list[tuple[Forcing, float, float]]:
    """Draw slides either way, with drags from negative to beyond the amplitude, and their starts."""
    draw = random.Random(seed)
    slides = []
    for _ in range(count):
        alpha, weight = draw.uniform(0.0, 1.4), draw.uniform(0.02, 3.0)
        kinetic, weight_down = draw.uniform(0.0, 1.5), draw.uniform(-0.6, 0.6)
        loads = Loads(
            math.cos(alpha), math.sin(alpha), weight, weight_down, weight, 2.0, kinetic, 0.0, 1.0, True
        )
        speed = math.exp(draw.uniform(math.log(1e-4), math.log(20.0)))
        slides.append((forcing(loads, draw.choice([1.0, -1.0])), draw.uniform(0.0, TURN), speed))
    return slides


def _speed(at: Forcing, phase: float, speed: float, s: np.ndarray) -> np.ndarray:
    p0 = phase + at.shift
    now: np.ndarray = speed + at.amplitude * (math.cos(p0) - np.cos(p0 + s)) - at.drag * s
    return now


def test_a_slide_ends_at_the_first_zero_of_its_speed_or_gains_speed_every_turn() -> None:
    endless = 0
    for at, phase, speed in _slides(400, 1):
        end = slide_from_speed(at, phase, speed, math.inf)
        assert end.settled
        if math.isinf(end.length):
            endless += 1
            assert not end.stopped
            assert math.isnan(end.speed)
            assert math.isnan(end.top)
            assert at.drag <= 0.0
            assert (_speed(at, phase, speed, np.linspace(0.0, 3.0 * TURN, 2001)) > 0.0).all()
            continue
        assert end.stopped
        assert end.speed == 0.0
        mesh = np.linspace(0.0, end.length, 1000)[:-1]
        assert (_speed(at, phase, speed, mesh) > -1e-12 * (1.0 + mesh)).all()
        left = _speed(at, phase, speed, np.array([end.length]))[0]
        assert abs(left) < 1e-13 * (1.0 + speed + abs(at.drag) * end.length)
    assert 5 < endless < 100


def test_a_contact_that_ends_first_cuts_the_slide() -> None:
    draw, stops = random.Random(4), 0
    for at, phase, speed in _slides(400, 3):
        whole, limit = slide_from_speed(at, phase, speed, math.inf), draw.uniform(0.0, 8.0)
        cut = slide_from_speed(at, phase, speed, limit)
        assert cut.stopped == (whole.length < limit)
        assert cut.length == pytest.approx(min(whole.length, limit), rel=1e-13)
        expected = 0.0 if cut.stopped else _speed(at, phase, speed, np.array([limit]))[0]
        assert cut.speed == pytest.approx(expected, abs=1e-12)
        stops += cut.stopped
    assert 50 < stops < 350


def test_the_top_speed_is_the_largest_on_the_way() -> None:
    draw = random.Random(6)
    for at, phase, speed in _slides(200, 5):
        end = slide_from_speed(at, phase, speed, draw.uniform(0.1, 15.0))
        seen = _speed(at, phase, speed, np.linspace(0.0, end.length, 10_001)).max()
        assert seen <= end.top + 1e-12
        assert end.top == pytest.approx(seen, abs=4e-6)


def test_the_end_has_all_digits_unless_the_speed_only_grazes_zero() -> None:
    with mpmath.workdps(40):
        for at, phase, speed in _slides(40, 7):
            length = slide_from_speed(at, phase, speed, math.inf).length
            if math.isinf(length):
                continue
            p0, v0 = mpmath.mpf(phase) + mpmath.mpf(at.shift), mpmath.mpf(speed)
            amplitude, drag = mpmath.mpf(at.amplitude), mpmath.mpf(at.drag)

            def left(
                s: mpmath.mpf,
                p0: mpmath.mpf = p0,
                v0: mpmath.mpf = v0,
                amplitude: mpmath.mpf = amplitude,
                drag: mpmath.mpf = drag,
            ) -> mpmath.mpf:
                return v0 + amplitude * (mpmath.cos(p0) - mpmath.cos(p0 + s)) - drag * s

            exact = mpmath.findroot(left, mpmath.mpf(length))
            slope = abs(amplitude * mpmath.sin(p0 + exact) - drag)
            scale = (v0 + amplitude + abs(drag) * exact) / slope + exact + TURN
            assert abs(length - exact) < 8 * EPS * scale


def test_an_onset_a_rounding_before_the_minimum_starts_a_slide() -> None:
    # mu_s = mu_d: the slide starts just where its speed has its minimum
    at = Forcing(0.0, 1.0, 0.5, math.asin(0.5), math.sqrt(0.75), 0.0)
    for rounding in (-1e-15, 0.0, 1e-15):
        assert 3.0 < slide_from_speed(at, at.kappa + rounding, 0.0, math.inf).length < 4.0


def test_a_body_that_moves_at_the_minimum_of_its_speed_slides_on() -> None:
    # a phase just below 0 that counting from the minimum rounds up to a whole turn
    at = Forcing(0.0, 1.0, 0.01, 0.0, 1.0, 0.01)
    for phase in (-1e-20, 0.0, 1e-20, TURN):
        end = slide_from_speed(at, phase, 1e-18, 1.0)
        assert not end.stopped
        assert end.speed == pytest.approx(1.0 - math.cos(1.0) - 0.01, rel=1e-12)


def test_a_slide_that_outlasts_what_a_phase_can_count_never_ends() -> None:
    at = Forcing(0.0, 1.0, 1e-17, 1e-17, 1.0, 0.0)
    assert math.isinf(slide_from_speed(at, 0.5, 3.0, math.inf).length)
    at = at._replace(drag=1e-13, kappa=1e-13)
    assert slide_from_speed(at, 0.5, 3.0, math.inf).length == pytest.approx(3e13, rel=0.5)


def test_the_highest_of_several_maxima_is_the_first_or_downhill_the_last() -> None:
    ratio = 0.02
    for drag in (ratio, -ratio):
        at = Forcing(0.0, 1.0, drag, math.asin(drag), math.sqrt(1.0 - ratio * ratio), 0.0)
        peaks = [math.pi - at.kappa + TURN * i - 4.0 for i in (1, 2)]  # after a start at phase 4
        end = slide_from_speed(at, 4.0, 5.0, peaks[1] + 0.5)
        highest = peaks[0] if drag > 0.0 else peaks[1]
        assert end.top == pytest.approx(_speed(at, 4.0, 5.0, np.array([highest]))[0], rel=1e-14)
        # cut a little before the second maximum, downhill it is the speed there or the first maximum
        end = slide_from_speed(at, 4.0, 5.0, peaks[1] - 1e-3)
        assert end.top == pytest.approx(_speed(at, 4.0, 5.0, np.array([highest]))[0], abs=1e-6)


def test_slides_that_just_reach_zero_speed_at_a_minimum_stop_there_or_go_on() -> None:
    # start speeds within rounding of those at which a later minimum of the speed is zero
    draw, count, at_once = random.Random(9), 3000, 0
    for i in range(count):
        amplitude, phase = 10.0 ** draw.uniform(-1.0, 0.5), draw.uniform(0.0, TURN)
        ratio = 10.0 ** draw.uniform(-8.0, 0.0) if i % 2 else 1.0 - 10.0 ** draw.uniform(-9.0, 0.0)
        bend = amplitude * math.sqrt((1.0 - ratio) * (1.0 + ratio))
        at = Forcing(0.0, amplitude, amplitude * ratio, math.asin(ratio), bend, 0.0)
        minimum = at.kappa + TURN * draw.randint(1, 3)
        start = (phase - at.kappa) % TURN + at.kappa
        speed = amplitude * (math.cos(minimum) - math.cos(start)) + at.drag * (minimum - start)
        speed *= 1.0 + draw.randint(-3, 3) * EPS
        end = slide_from_speed(at, phase, speed, math.inf)
        assert end.settled
        left = speed + amplitude * (math.cos(start) - math.cos(start + end.length)) - at.drag * end.length
        assert abs(left) < 1e-14 * (speed + amplitude + at.drag * end.length)
        at_once += abs(start + end.length - minimum) < 1e-5
        if i % 40 == 0:
            mesh = np.linspace(0.0, end.length, 1000)[:-1]
            assert (_speed(at, phase, speed, mesh) > -1e-12 * (1.0 + speed)).all()
    assert 0.2 < at_once / count < 0.9


def test_a_contact_that_ends_within_rounding_of_the_stop_leaves_no_negative_speed() -> None:
    for at, phase, speed in _slides(300, 10):
        whole = slide_from_speed(at, phase, speed, math.inf)
        for ulps in range(-2, 6) if whole.stopped else ():
            limit = whole.length * (1.0 - ulps * 2.0**-53)
            cut = slide_from_speed(at, phase, speed, limit)
            assert 0.0 <= cut.speed < 1e-13 * (1.0 + speed + abs(at.drag) * limit)
            assert cut.length <= limit


# ---------------------------------------------------------------------------------------------- legs


def test_at_zero_velocity_the_loads_decide_and_equality_is_rest() -> None:
    # alpha = 0, level trough: load sin p, friction holds mu_s n = 1/2
    loads = Loads(1.0, 0.0, 1.0, 0.0, 1.0, 0.5, 0.4, 0.0, 1.0, True)
    half = math.asin(0.5)
    assert mode_of(loads, 1.0, 0.0, math.sin(1.0)) == Mode.REST
    for phase, mode in ((half - 1e-12, Mode.REST), (half + 1e-12, Mode.FORWARD)):
        assert mode_of(loads, phase, 0.0, loads.static_friction) == mode
        opposite = Mode.BACK if mode == Mode.FORWARD else Mode.REST
        assert mode_of(loads, -phase, 0.0, loads.static_friction) == opposite
    # after bounces kinetic friction alone holds
    assert [track_of(loads, e).landed_friction for e in (0.0, 1e-300, 0.5)] == [0.5, 0.4, 0.4]
    assert mode_of(loads, half - 1e-12, 0.0, 0.4) == Mode.FORWARD
    assert mode_of(loads, 0.5 * math.pi, -1e-300, loads.static_friction) == Mode.BACK
    assert mode_of(loads, -0.5 * math.pi, 1e-300, loads.static_friction) == Mode.FORWARD


def test_rest_lasts_until_the_nearer_onset_or_the_end_of_the_contact() -> None:
    loads = SCENES[0]
    track = track_of(loads, 0.0)
    assert track.forward_onset < track.back_onset
    before = track.forward_onset - 0.25
    leg = contact_leg(track, Mode.REST, before, 0.7, math.inf)
    assert leg.length == pytest.approx(0.25)
    assert leg.next_mode == Mode.FORWARD
    assert (leg.velocity, leg.displacement, leg.impulse, leg.gain, leg.top) == (0.0, 0.0, 0.0, 0.0, 0.0)
    assert contact_leg(track, Mode.REST, before, 0.0, 0.125).length == 0.125
    leg = contact_leg(track, Mode.REST, track.back_onset - 0.25, 0.0, math.inf)
    assert leg.length == pytest.approx(0.25)
    assert leg.next_mode == Mode.BACK
    never = track._replace(forward_onset=math.nan)
    assert contact_leg(never, Mode.REST, before, 0.0, math.inf).next_mode == Mode.BACK
    both = track._replace(back_onset=track.forward_onset)
    assert contact_leg(both, Mode.REST, before, 0.0, math.inf).next_mode == Mode.FORWARD
    held = never._replace(back_onset=math.nan)
    assert contact_leg(held, Mode.REST, before, 0.0, 9.0).length == 9.0
    assert contact_leg(held, Mode.REST, before, 0.0, math.inf).length == math.inf


@each("loads", SCENES)
@each(("mode", "way"), [(Mode.FORWARD, 1.0), (Mode.BACK, -1.0)])
@each("limit", [0.4, 3.0, math.inf])
def test_a_slide_obeys_newtons_second_law(loads: Loads, mode: Mode, way: float, limit: float) -> None:
    track, phase, velocity = track_of(loads, 0.0), 2.3, way * 0.6
    leg = contact_leg(track, mode, phase, velocity, limit)
    assert leg.settled
    # Gauss-Legendre quadrature of Eq. (2): velocity, displacement and normal impulse
    nodes, weights = np.polynomial.legendre.leggauss(40)
    s, w = 0.5 * leg.length * (nodes + 1.0), 0.5 * leg.length * weights
    force = np.array([_tangential(loads, phase + x) for x in s.tolist()])
    normal = np.array([_normal(loads, phase + x) for x in s.tolist()])
    acceleration = force - way * loads.kinetic_friction * normal
    assert leg.velocity == pytest.approx(velocity + (w * acceleration).sum(), abs=1e-12)
    path = velocity * leg.length + (w * (leg.length - s) * acceleration).sum()
    assert leg.displacement == pytest.approx(path, abs=1e-12)
    assert leg.impulse == pytest.approx(way * (w * normal).sum(), abs=1e-12)
    assert leg.top >= abs(velocity)
    if leg.length == limit:
        assert (leg.next_mode, leg.gain) == (mode, 1.0)
    else:
        assert leg.velocity == 0.0
        load, normal_end = _tangential(loads, phase + leg.length), _normal(loads, phase + leg.length)
        if -way * load > loads.static_friction * normal_end:
            friction = loads.kinetic_friction * normal_end
            assert leg.next_mode == (Mode.BACK if way > 0.0 else Mode.FORWARD)
            assert leg.gain == pytest.approx((-way * load - friction) / (-way * load + friction))
        else:
            assert (leg.next_mode, leg.gain) == (Mode.REST, 0.0)


@pytest.mark.parametrize("loads", [SCENES[1], SCENES[4]])
def test_neighbours_come_closer_by_the_gain_where_they_turn(loads: Loads) -> None:
    """Slide two bodies through a turn and compare the difference of their velocities, Eq. (26)."""
    track, end, checked = track_of(loads, 0.0), 0.0, 0
    for mode, way in ((Mode.FORWARD, 1.0), (Mode.BACK, -1.0)):
        for phase in np.linspace(0.0, 6.0, 13).tolist():
            first = contact_leg(track, mode, phase, way * 0.6, math.inf)
            if first.next_mode == Mode.REST:
                continue
            end, after = first.length + 0.05, []
            for change in (-1e-6, 1e-6):
                leg = contact_leg(track, mode, phase, way * (0.6 + change), math.inf)
                left = end - leg.length
                after.append(contact_leg(track, leg.next_mode, phase + leg.length, 0.0, left).velocity)
            assert (after[1] - after[0]) / 2e-6 * way == pytest.approx(first.gain, abs=1e-4)
            assert 0.0 < first.gain < 1.0
            checked += 1
    assert checked > 3


def test_gravity_that_friction_does_not_hold_lets_a_slide_go_on_for_ever() -> None:
    track = track_of(_line(20.0, 0.9, 0.9, 0.1, -20.0), 0.0)
    leg = contact_leg(track, Mode.FORWARD, 1.0, 5.0, math.inf)
    assert (leg.length, leg.next_mode, leg.gain, leg.settled) == (math.inf, Mode.FORWARD, 1.0, True)
    assert all(math.isnan(x) for x in (leg.velocity, leg.displacement, leg.impulse, leg.top))
    back = contact_leg(track_of(_line(20.0, 0.9, 0.9, 0.1, 20.0), 0.0), Mode.BACK, 1.0, -5.0, math.inf)
    assert (back.length, back.next_mode) == (math.inf, Mode.BACK)
    cut = contact_leg(track, Mode.FORWARD, 1.0, 5.0, TURN)
    gained = -TURN * forcing(track.loads, 1.0).drag  # Eq. (24)
    assert gained > 0.0
    assert cut.velocity == pytest.approx(5.0 + gained, rel=1e-13)


def test_a_line_is_an_ellipse_without_phase_difference() -> None:
    line = SCENES[1]
    ellipse = line._replace(line=False)
    one, other = track_of(line, 0.0), track_of(ellipse, 0.0)
    assert one[3:] == pytest.approx(other[3:], rel=1e-15, nan_ok=True)
    for mode, velocity in ((Mode.FORWARD, 0.4), (Mode.BACK, -0.4)):
        legs = [contact_leg(t, mode, 1.0, velocity, 2.0) for t in (one, other)]
        assert legs[0] == pytest.approx(legs[1], rel=1e-13, abs=1e-15)


def test_a_slide_that_stops_where_the_trough_has_just_fallen_away_turns_without_friction() -> None:
    # a rounding after the lift-off the normal load is negative, and there is no friction then
    loads = Loads(0.5, 2.0, 1.0, 0.0, 0.5, 0.6, 0.4, 0.0, 1.0, True)
    leg = contact_leg(track_of(loads, 0.0), Mode.BACK, 1.3, -0.05, math.inf)
    assert _normal(loads, 1.3 + leg.length) < 0.0
    assert (leg.next_mode, leg.gain) == (Mode.FORWARD, 1.0)
