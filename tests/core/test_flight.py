"""Flights, landings and the normal motion: beside meshes and 50 digits, over sines and waves."""

from __future__ import annotations

import math
import random
from typing import Any, NamedTuple

import mpmath
import numpy as np
import pytest
from helpers.cases import each
from helpers.waves import coefficients_of, drawn_harmonics, drawn_pieces, harmonic_waves, piecewise_waves

from vibro.core import flight as flight_module
from vibro.core.cells import behind, find_nodes, largest, number_of_nodes
from vibro.core.flight import (
    ACCUMULATED,
    BOUNCE,
    LOST,
    MOST_FLIGHTS,
    SHARP,
    Bounces,
    Covariance,
    Flight,
    Flights,
    _close,
    after_landing,
    bounces,
    flight,
    fly_over_waves,
    lift_off_flight,
    propagate,
    single_bounce,
    sinusoidal,
    tangent_map,
    within,
)
from vibro.core.legs import ahead
from vibro.core.numbers import LONGEST_CYCLE, MOST_BOUNCES
from vibro.core.waves import NORMAL, Mix, Waves, load_at, nodes_of

TURN = 2.0 * math.pi
EPS = 2.0**-52
ONE_TURN = math.sqrt(1.0 + math.pi**2)  # throw number at which a flight from rest lasts one turn
EXACT = Covariance(0.0, 0.0, 0.0)


def _flight(throw: float, phase: float, speed: float) -> Flight:
    return flight(sinusoidal(throw), phase, speed)


def _released(throw: float) -> Flight:
    return lift_off_flight(sinusoidal(throw), math.asin(1.0 / throw))


# ------------------------------------------------------------------------------- flights from rest


@each("cycles", np.linspace(0.05, 1.0, 20).tolist())
def test_flight_time_and_throw_number_are_related_as_published(cycles: float) -> None:
    x = TURN * cycles
    throw = math.sqrt(((math.cos(x) + 0.5 * x * x - 1.0) / (x - math.sin(x))) ** 2 + 1.0)
    assert _released(throw).length / TURN == pytest.approx(cycles, rel=1e-11)


@each(
    ("throw", "cycles"),
    [
        (1.1, "0.27711"),
        (1.5, "0.56758"),
        (2.0, "0.74148"),
        (2.5, "0.85731"),
        (3.0, "0.94977"),
        (ONE_TURN, "1.00000"),
    ],
)
def test_flight_times_to_all_printed_digits(throw: float, cycles: str) -> None:
    assert f"{_released(throw).length / TURN:.5f}" == cycles


def test_a_lift_off_flight_has_all_digits_however_short() -> None:
    """Compare with 50 digits: the docstring of ``lift_off_flight`` states this bound."""
    throws = np.concatenate((1.0 + np.logspace(-15, -1, 29), np.linspace(1.1, ONE_TURN, 60)))
    throws[-1] = math.nextafter(ONE_TURN, 0.0)
    with mpmath.workdps(60):
        for throw in throws.tolist():
            got = _released(throw)
            c = mpmath.mpf(math.sqrt((throw - 1.0) * (throw + 1.0)))

            def height(s: mpmath.mpf, c: mpmath.mpf = c) -> mpmath.mpf:
                return (c * (s - mpmath.sin(s)) + 1 - mpmath.cos(s) - s * s / 2) / s**3

            exact = mpmath.findroot(height, mpmath.mpf(got.length))
            landing = exact - mpmath.sin(exact) - c * (1 - mpmath.cos(exact))
            assert abs(got.length / exact - 1) < 4 * EPS
            assert abs(got.impact / landing - 1) < 20 * EPS


@pytest.mark.parametrize("throw", [1.01, 1.3, 2.0, 3.0, 3.29])
def test_a_flight_from_the_lift_off_agrees_with_the_general_one(throw: float) -> None:
    # near the lift-off the height grows with the cube of time only, so the general one has fewer digits
    general = _flight(throw, math.asin(1.0 / throw), 0.0)
    assert general == pytest.approx(_released(throw), rel=1e-10)


@pytest.mark.parametrize("throw", [math.nextafter(ONE_TURN, 9.0), 3.4, 12.0, 1e6])
def test_a_flight_from_rest_longer_than_a_turn_is_the_general_one(throw: float) -> None:
    lift_off = math.asin(1.0 / throw)
    assert lift_off_flight(sinusoidal(throw), lift_off) == flight(sinusoidal(throw), lift_off, 0.0)
    assert lift_off_flight(sinusoidal(throw), lift_off).length > TURN * (1.0 - 1e-12)


# ------------------------------------------------------------------------------- any take-off


def _take_offs(count: int, seed: int, most_throw: float) -> list[tuple[float, float, float]]:
    """Draw take-offs: from rest where the trough falls away, and with a speed anywhere."""
    draw, states = random.Random(seed), []
    for i in range(count):
        throw = math.exp(draw.uniform(math.log(1.001), math.log(most_throw)))
        lift_off = math.asin(1.0 / throw)
        released = lift_off + (math.pi - 2.0 * lift_off) * draw.random()
        speed = throw * math.exp(draw.uniform(-12.0, 1.0))
        states.append((throw, released, 0.0) if i % 2 else (throw, draw.uniform(0.0, TURN), speed))
    return states


@pytest.mark.parametrize("most_throw", [4.0, 1000.0])
def test_the_landing_is_the_first_return_to_the_trough(most_throw: float) -> None:
    for throw, phase, speed in _take_offs(400, 1, most_throw):
        got = _flight(throw, phase, speed)
        assert got.length > 0.0
        assert got.impact >= 0.0
        s = np.linspace(0.0, got.length, 4001)[1:]
        lever = s * math.cos(phase) + math.sin(phase) - np.sin(phase + s)
        height = speed * s + throw * lever - 0.5 * s * s
        rounding = 1e-14 * (throw * s + s * s) + 1e-15 * throw
        assert (height > -rounding)[:-1].all()
        assert abs(height[-1]) <= 4.0 * rounding[-1]
        rate = speed + throw * (math.cos(phase) - math.cos(phase + got.length)) - got.length
        assert got.impact == pytest.approx(-rate, abs=1e-12 * throw)


def test_a_flight_flown_backwards_is_a_flight() -> None:
    # K sin p is the same at pi - p: a take-off that is barely one becomes a landing that barely touches
    draw, grazing = random.Random(3), 0
    for _ in range(4000):
        throw, speed = math.exp(draw.uniform(0.1, 3.0)), math.exp(draw.uniform(-6.0, 0.0))
        lift_off = math.asin(1.0 / throw)
        phase = draw.uniform(lift_off - 2.0 * math.sqrt(speed / throw), math.pi - lift_off)
        there = _flight(throw, phase, speed)
        if there.length < 0.5:
            continue
        back = _flight(throw, math.pi - phase - there.length, there.impact)
        lost = 64.0 * EPS * (there.impact + throw + there.length) * (1.0 + there.length) / speed
        assert back.length == pytest.approx(there.length, rel=0.0, abs=lost)
        assert back.impact == pytest.approx(speed, rel=0.0, abs=lost * (1.0 + throw))
        grazing += phase < lift_off  # where the trough, seen backwards, does not yet press
    assert grazing > 300


@each("phase", [-1.0, 0.0, 2.9, 4.0])
@each("speed", [1e-3, 1e-6, 1e-9, 1e-12])
def test_a_short_bounce_lasts_twice_its_speed_over_the_load(phase: float, speed: float) -> None:
    got = _flight(2.0, phase, speed)
    assert got.length == pytest.approx(2.0 * speed / (1.0 - 2.0 * math.sin(phase)), rel=10.0 * speed + 1e-4)
    assert got.impact == pytest.approx(speed, rel=10.0 * speed + 1e-3)


def test_short_bounces_keep_their_digits() -> None:
    throw, phase = 1.5, 2.9
    with mpmath.workdps(50):
        p = mpmath.mpf(phase)
        for speed in np.geomspace(1e-2, 1e-11, 40).tolist():
            got = _flight(throw, phase, speed)

            def height(s: mpmath.mpf, v: float = speed, p: mpmath.mpf = p) -> mpmath.mpf:
                turned = mpmath.cos(p) * (s - mpmath.sin(s)) + mpmath.sin(p) * (1 - mpmath.cos(s))
                return (v * s + throw * turned - s * s / 2) / s

            exact = mpmath.findroot(height, 2.0 * speed / (1.0 - throw * math.sin(phase)))
            rate = speed + throw * (mpmath.cos(p) - mpmath.cos(p + exact)) - exact
            assert abs(got.length - exact) < 16 * EPS * exact
            assert abs(got.impact + rate) < 64 * EPS * speed


@pytest.mark.parametrize("phase", [4.7, 5.0, 5.5])
def test_a_landing_grazes_before_a_faster_body_clears_the_trough_there(phase: float) -> None:
    speeds = np.linspace(0.5, 8.0, 200)
    lengths = np.array([_flight(3.0, phase, speed).length for speed in speeds.tolist()])
    jump = int(np.argmax(np.diff(lengths)))
    low, high = float(speeds[jump]), float(speeds[jump + 1])
    for _ in range(60):
        middle = 0.5 * (low + high)
        if _flight(3.0, phase, middle).length < 0.5 * (lengths[jump] + lengths[jump + 1]):
            low = middle
        else:
            high = middle
    below, above = _flight(3.0, phase, low), _flight(3.0, phase, high)
    assert below.length < above.length - 0.5
    assert below.impact < 1e-6
    assert above.impact > 0.1


@pytest.mark.parametrize("throw", [1.0 + 1e-15, 1.5, 1e3, 1e6])
def test_a_body_let_go_at_a_crest_lands_within_the_turns_that_its_fall_takes(throw: float) -> None:
    got = _flight(throw, 0.5 * math.pi, 0.0)
    assert 0.0 <= got.length < 2.0 * math.sqrt(throw) + TURN
    below = throw * (math.sin(0.5 * math.pi + got.length) - 1.0)  # height of the trough below the crest
    assert -0.5 * got.length**2 == pytest.approx(below, abs=1e-9 * throw)


# ------------------------------------------------------------------------------- impacts


def test_an_impact_reverses_the_normal_speed_and_shrinks_it() -> None:
    assert after_landing(sinusoidal(2.0), 0.5 * math.pi, 1.5, 0.4, ACCUMULATED) == pytest.approx(
        (0.6, 0.0, 2.1, False)
    )
    # a plastic body stays where the trough presses, and is thrown again where it falls away
    assert after_landing(sinusoidal(2.0), 3.0, 1.5, 0.0, ACCUMULATED) == (0.0, 0.0, 1.5, True)
    assert after_landing(sinusoidal(2.0), 1.0, 1.5, 0.0, ACCUMULATED) == (0.0, 0.0, 1.5, False)


@pytest.mark.parametrize("restitution", [0.1, 0.5, 0.9, 0.9999])
def test_accumulated_bounces_are_summed_as_if_one_flew_them_all(restitution: float) -> None:
    load = 1.0 - 1.5 * math.sin(3.0)
    speed = 0.4e-8 * load * (1.0 - restitution)  # of the first bounce; they last 0.8e-8 altogether
    after = after_landing(sinusoidal(1.5), 3.0, speed / restitution, restitution, ACCUMULATED)
    assert after.contact
    assert after.take_off == 0.0
    # geometric sums of 2 v / N and of (1 + e) v, the impulse of the impact before them too
    assert after.length == pytest.approx(0.8e-8, rel=1e-10)
    impulse = (1.0 + restitution) * speed * (1.0 / restitution + 1.0 / (1.0 - restitution))
    assert after.impulse == pytest.approx(impulse, rel=1e-10)


@pytest.mark.parametrize(("factor", "contact"), [(1.0 - 1e-9, True), (1.0 + 1e-9, False)])
@pytest.mark.parametrize("accumulated", [ACCUMULATED, 5e-2])
def test_bounces_are_summed_once_they_are_short_enough(
    factor: float, contact: bool, accumulated: float
) -> None:
    load = 1.0 - 1.5 * math.sin(3.0)
    impact = 0.5 * accumulated * factor * load * (1.0 - 0.3) / 0.3
    after = after_landing(sinusoidal(1.5), 3.0, impact, 0.3, accumulated)
    assert after.contact is contact
    assert after.take_off == (0.0 if contact else pytest.approx(0.3 * impact))
    assert after.length == (pytest.approx(accumulated) if contact else 0.0)


def test_bounces_are_not_summed_where_the_trough_falls_away_before_they_end() -> None:
    # ahead of the lift-off the load is positive, but vanishes there
    throw, restitution, length, seen = 1.5, 0.5, 1e-9, set()
    for before in np.geomspace(1e-12, 1e-2, 41).tolist():
        phase = math.asin(1.0 / throw) - before
        load = 1.0 - throw * math.sin(phase)
        impact = 0.5 * length * load * (1.0 - restitution) / restitution
        after = after_landing(sinusoidal(throw), phase, impact, restitution, ACCUMULATED)
        fall = throw * math.cos(phase) * length  # of the load, until the bounces end
        if abs(load / fall - 1.0) > 1e-3:
            assert after.contact is (load > fall)
        seen.add(after.contact)
    assert seen == {True, False}
    # where the load grows it does not matter how small it is
    assert after_landing(
        sinusoidal(throw), math.pi - math.asin(1.0 / throw) + 1e-6, 1e-16, 0.5, ACCUMULATED
    ).contact


@pytest.mark.parametrize("impact", [0.0, 1e-320])
def test_a_landing_without_impact_or_load_divides_by_nothing(impact: float) -> None:
    for phase in (0.5 * math.pi, math.pi / 6.0, 3.0):
        for throw in (1.0, 2.0):
            after = after_landing(sinusoidal(throw), phase, impact, 0.5, ACCUMULATED)
            assert all(math.isfinite(x) for x in after)
            assert after.take_off in (0.0, 0.5 * impact)


# ------------------------------------------------------------------------------- errors


def _bounce(throw: float, restitution: float, phase: float, speed: float) -> tuple[float, float]:
    flown = _flight(throw, phase, speed)
    return phase + flown.length, restitution * flown.impact


def _bouncing(count: int) -> list[tuple[float, float, float, float]]:
    draw = random.Random(7)
    return [
        (draw.uniform(1.2, 6.0), draw.uniform(0.2, 0.9), draw.uniform(0.0, TURN), draw.uniform(1.0, 8.0))
        for _ in range(count)
    ]


def test_the_tangent_map_is_the_derivative_of_a_flight_and_its_impact() -> None:
    checked, h = 0, 1e-6
    for throw, restitution, phase, speed in _bouncing(100):
        flown = _flight(throw, phase, speed)
        if flown.impact < 0.5:  # grazing landings bend within the difference
            continue
        got = tangent_map(sinusoidal(throw), restitution, phase, flown)
        for column, (p, v) in enumerate(((h, 0.0), (0.0, h))):
            after = _bounce(throw, restitution, phase + p, speed + v)
            before = _bounce(throw, restitution, phase - p, speed - v)
            for row in (0, 1):
                slope = (after[row] - before[row]) / (2.0 * h)
                assert got[2 * row + column] == pytest.approx(slope, rel=1e-5, abs=1e-5)
        # the flux v dp dv through the trough's surface is conserved in flight
        a, b, c, d = got
        assert a * d - b * c == pytest.approx(restitution * speed / flown.impact, rel=1e-9)
        checked += 1
    assert checked > 90


def test_the_covariance_of_many_bodies_is_what_is_propagated() -> None:
    noise, error, checked = np.random.default_rng(8).standard_normal((40, 2, 200)), 1e-8, 0
    for (throw, restitution, phase, speed), (phases, speeds) in zip(_bouncing(40), noise, strict=True):
        bodies = [
            (phase + error * p, speed + error * (0.6 * p + 0.8 * v))
            for p, v in zip(phases.tolist(), speeds.tolist(), strict=True)
        ]
        errors = Covariance(error**2, 0.6 * error**2, error**2)
        for _ in range(2):
            flown = _flight(throw, phase, speed)
            errors = propagate(sinusoidal(throw), restitution, phase, speed, flown, 0.0, errors)
            phase, speed = _bounce(throw, restitution, phase, speed)
            bodies = [_bounce(throw, restitution, *body) for body in bodies]
            if flown.impact < 0.3 or errors.phase > 1e-12:
                break
            off = np.array(bodies) - (phase, speed)
            drawn = off.T @ off / len(bodies)
            assert 0.6 < errors.phase / drawn[0, 0] < 1.7
            assert 0.6 < errors.speed / drawn[1, 1] < 1.7
            scale = math.sqrt(errors.phase * errors.speed)
            assert errors.both / scale == pytest.approx(drawn[0, 1] / scale, abs=0.35)
            checked += 1
    assert checked > 60


def test_summed_bounces_add_the_scatter_of_their_duration() -> None:
    throw, restitution, phase, speed = 1.5, 0.5, 4.0, 0.3
    flown, errors = _flight(throw, phase, speed), Covariance(0.0, 0.0, 1.0)
    without = propagate(sinusoidal(throw), restitution, phase, speed, flown, 0.0, errors)
    tail = 0.7
    got = propagate(sinusoidal(throw), restitution, phase, speed, flown, tail, errors)
    # they last in proportion to the speed of the first, e u
    lever = tail / (restitution * flown.impact)
    assert got.phase - without.phase == pytest.approx(lever**2 * without.speed, rel=1e-9)
    assert (got.both, got.speed) == (without.both, without.speed)


def test_the_rounding_of_a_flight_is_covered_and_not_exaggerated() -> None:
    worst = 0.0
    with mpmath.workdps(40):
        for throw, restitution, phase, speed in _bouncing(40):
            flown = _flight(throw, phase, speed)
            errors = propagate(sinusoidal(throw), restitution, phase, speed, flown, 0.0, EXACT)
            p, v = mpmath.mpf(phase), mpmath.mpf(speed)

            def height(s: mpmath.mpf, k: float = throw, p: mpmath.mpf = p, v: mpmath.mpf = v) -> mpmath.mpf:
                return v * s + k * (s * mpmath.cos(p) + mpmath.sin(p) - mpmath.sin(p + s)) - s * s / 2

            exact = mpmath.findroot(height, flown.length)
            rate = v + throw * (mpmath.cos(p) - mpmath.cos(p + exact)) - exact
            late = abs(float(exact - flown.length)) / math.sqrt(errors.phase)
            fast = restitution * abs(float(flown.impact + rate)) / math.sqrt(errors.speed)
            assert max(late, fast) <= 4.0
            worst = max(worst, late)
    assert worst > 0.02


def test_a_flight_from_rest_on_the_trough_has_all_digits() -> None:
    # its terms do not cancel, however short it is: only the phase of its landing is rounded
    throw = 1.0 + 1e-10
    lift_off = math.asin(1.0 / throw)
    flown = lift_off_flight(sinusoidal(throw), lift_off)
    errors = propagate(sinusoidal(throw), 0.0, lift_off, 0.0, flown, 0.0, EXACT)
    assert math.sqrt(errors.phase) == pytest.approx(EPS * (1.0 + flown.length))
    kicked = propagate(sinusoidal(throw), 0.0, lift_off, 1e-300, flown, 0.0, EXACT)
    later = propagate(sinusoidal(throw), 0.0, lift_off + 1e-5, 0.0, flown, 0.0, EXACT)
    longer = propagate(sinusoidal(throw), 0.0, lift_off, 0.0, flown._replace(length=TURN * 1.01), 0.0, EXACT)
    for other in (kicked, later, longer):
        assert other.phase > 1e4 * errors.phase


def test_a_grazing_landing_loses_digits() -> None:
    flown = _flight(2.0, 2.0, 1.0)
    known = [
        propagate(sinusoidal(2.0), 0.5, 2.0, 1.0, flown._replace(impact=impact), 0.0, EXACT)
        for impact in (1.0, 1e-4, 1e-12, 0.0)
    ]
    assert [within(errors, SHARP) for errors in known] == [True, True, False, False]
    assert [within(errors, LOST) for errors in known] == [True, True, False, False]


# ------------------------------------------------------------------------------
# Flights over any periodic trough: first landings beside a dense mesh, and how few pieces they take.

LIFT = Mix(0.0, 0.0, 1.0)


class Trough(NamedTuple):
    """A trough's normal motion, N/n = 1 - K B / max B, and how steep a body on it rises and falls."""

    waves: Waves
    lift: Mix
    breaks: Any
    pieces: Any  # of -N/n; the coefficients of harmonics where there are no breaks

    def fallen(self, phase: float, speed: float, s: Any) -> tuple[Any, Any]:
        """Height and rate over the trough, a phase after a take-off, by sums of their own."""
        s = np.asarray(s)
        if self.breaks is None:
            k = np.arange(1, len(self.pieces) + 1)
            c = self.pieces * np.exp(1j * k * phase)
            turned = np.exp(1j * np.multiply.outer(s, k))
            rate = (((turned - 1.0) / (1j * k)) @ c).imag
            path = ((-(turned - 1.0) / k**2 - np.multiply.outer(s, 1.0 / (1j * k))) @ c).imag
            return speed * s + path - 0.5 * s * s, speed + rate - s
        ends = TURN * self.breaks
        width = np.diff(ends)
        c = self.pieces
        whole_rate = width * (c @ (1.0, 1 / 2, 1 / 3, 1 / 4))
        whole_path = width**2 * (c @ (1 / 2, 1 / 6, 1 / 12, 1 / 20))
        starts_rate = np.concatenate(([0.0], np.cumsum(whole_rate)))
        starts_path = np.zeros(len(c) + 1)
        for j in range(len(c)):
            starts_path[j + 1] = starts_path[j] + starts_rate[j] * width[j] + whole_path[j]

        def integrals(p: Any) -> tuple[Any, Any]:
            turns = np.floor(p / TURN)
            here = p - TURN * turns
            j = np.clip(np.searchsorted(ends, here, side="right") - 1, 0, len(c) - 1)
            step = here - ends[j]
            u = step / width[j]
            a0, a1, a2, a3 = c[j].T
            rate = starts_rate[j] + step * (a0 + u * (a1 / 2 + u * (a2 / 3 + u * a3 / 4)))
            path = starts_path[j] + starts_rate[j] * step
            path += step**2 * (a0 / 2 + u * (a1 / 6 + u * (a2 / 12 + u * a3 / 20)))
            drift, whole = starts_rate[-1], starts_path[-1]
            path = path + turns * whole + drift * (TURN * turns * (turns - 1) / 2 + turns * here)
            return rate + turns * drift, path

        rate0, path0 = integrals(np.asarray([phase]))
        rate1, path1 = integrals(phase + s)
        return speed * s + path1 - path0 - rate0 * s, speed + rate1 - rate0


def _over_harmonics(rng: np.random.Generator, count: int, throw: float) -> Trough:
    waves = harmonic_waves(np.zeros(count, complex), drawn_harmonics(rng, count))
    share = throw / largest(waves, LIFT)
    lift = Mix(-1.0, 0.0, share)
    find_nodes(waves, NORMAL, Mix(-1.0, 0.0, share))
    return Trough(waves, lift, None, share * coefficients_of(waves, normal=True))


def _over_pieces(rng: np.random.Generator, count: int, throw: float) -> Trough:
    breaks, pieces = drawn_pieces(rng, count)
    waves = piecewise_waves(breaks, pieces)
    share = throw / largest(waves, LIFT)
    find_nodes(waves, NORMAL, Mix(-1.0, 0.0, share))
    lift = -share * pieces[1]
    lift[:, 0] -= 1.0
    return Trough(waves, Mix(-1.0, 0.0, share), breaks, lift)


def _drawn(seed: int, count: int, *, pieces: bool = False) -> list[tuple[Trough, float, float, bool]]:
    """Draw troughs, and take-offs: from a lift-off, where the trough falls away, or with a speed."""
    rng = np.random.default_rng(seed)
    drawn = []
    for i in range(count):
        throw = 1.0 + 10.0 ** rng.uniform(-6.0, 1.0)
        size = 2 + i % 12 if pieces else 1 + i % 16
        trough = (_over_pieces if pieces else _over_harmonics)(rng, size, throw)
        waves = trough.waves
        lift_offs = [
            waves.number[nodes_of(waves, NORMAL) + j]
            for j in range(number_of_nodes(waves, NORMAL))
            if behind(waves, NORMAL, j)
        ]
        phase, speed, lifted = lift_offs[i % len(lift_offs)], 0.0, i % 3 == 0
        if i % 3 == 1:
            phase, speed = rng.uniform(0.0, TURN), 10.0 ** rng.uniform(-4.0, 1.5)
        elif i % 3 == 2:
            falls = [p for p in rng.uniform(0.0, TURN, 400).tolist() if load_at(waves, trough.lift, p) > 0.0]
            phase, lifted = (falls[0], False) if falls else (phase, True)
        drawn.append((trough, phase, speed, lifted))
    return drawn


@pytest.mark.parametrize(("seed", "pieces"), [(1, False), (2, False), (3, True), (4, True)])
def test_the_landing_is_the_first_return_to_the_trough_of_waves(seed: int, pieces: bool) -> None:
    """320 flights, over harmonics to H = 16 and over pieces with jumps."""
    for trough, phase, speed, lifted in _drawn(seed, 80, pieces=pieces):
        length, impact = fly_over_waves(trough.waves, trough.lift, phase, speed, lifted)
        assert 0.0 < length < math.inf
        throw = 1.0 + float(np.abs(trough.pieces).sum())
        mesh = np.linspace(0.0, length, 2 + min(int(30.0 * trough.waves.size * max(length, 0.1)), 6000))
        height, rate = trough.fallen(phase, speed, mesh)
        rounding = 32.0 * EPS * throw * (1.0 + length) ** 2
        # of a flight from rest the height begins like the cube of the phase, or the square
        assert (height[1:-1] >= -rounding).all()
        fall = max(abs(float(rate[-1])), 1e-3)
        assert abs(float(height[-1])) <= rounding + 1e-12 * fall * length
        assert impact == pytest.approx(-float(rate[-1]), abs=1e-12 * throw * (1.0 + length))
        assert impact >= 0.0


def test_a_short_flight_lasts_twice_as_long_as_the_trough_falls_away() -> None:
    """Just above K = 1 the load is a parabola, so that the height is s^3 (u/6 - s/12) times a constant."""
    rng, checked = np.random.default_rng(5), 0
    for i in range(60):
        trough = _over_harmonics(rng, 1 + i % 8, 1.0 + 10.0 ** rng.uniform(-10.0, -8.0))
        waves = trough.waves
        assert number_of_nodes(waves, NORMAL) == 2
        first = 0 if behind(waves, NORMAL, 0) else 1
        begin = waves.number[nodes_of(waves, NORMAL) + first]
        upwards = ahead(waves, NORMAL, begin, first + 1)
        length, impact = fly_over_waves(waves, trough.lift, begin, 0.0, True)
        assert length == pytest.approx(2.0 * upwards, rel=1e-2)
        bend = 8.0 * load_at(waves, trough.lift, begin + 0.5 * upwards) / upwards**2
        assert impact == pytest.approx(bend * upwards**3 / 3.0, rel=2e-2)
        checked += 1
    assert checked == 60


@pytest.mark.parametrize("harmonics", [1, 2, 3, 5, 8, 16])
def test_flights_take_few_pieces_however_long_they_are(
    harmonics: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls = 0

    def counted(waves: Waves, row: int, phase: float, index: int) -> float:
        nonlocal calls
        calls += 1
        return ahead(waves, row, phase, index)

    monkeypatch.setattr(flight_module, "ahead", counted)
    rng = np.random.default_rng(harmonics)
    worst, longest = 0, 0.0
    for i in range(60):
        throw = 10.0 ** rng.uniform(0.001, 5.0)
        trough = _over_harmonics(rng, harmonics, throw)
        speed = throw * 10.0 ** rng.uniform(-6.0, 1.0) if i % 2 else 0.0
        phase, waves = rng.uniform(0.0, TURN), trough.waves
        if speed == 0.0:
            first = 0 if behind(waves, NORMAL, 0) else 1
            phase = waves.number[nodes_of(waves, NORMAL) + first]
        calls = 0
        length, _ = fly_over_waves(waves, trough.lift, phase, speed, speed == 0.0)
        worst, longest = max(worst, calls), max(longest, length)
        assert calls <= 4 * harmonics + 2
    assert longest > 1000.0 * TURN
    assert worst > 2


# ------------------------------------------------------------------------------
# The normal motion of a hopping body: cycles with contact, without, their balance and their limits.

BYTES = 8 * (MOST_BOUNCES + LONGEST_CYCLE)
FLIGHTS = Flights(*(memoryview(bytearray(BYTES)).cast("d") for _ in Flights._fields))


def _from_rest(throw: float, restitution: float, most: int = MOST_FLIGHTS) -> Bounces:
    return bounces(sinusoidal(throw), restitution, FLIGHTS, most, math.asin(1.0 / throw), 0.0, True)


def _column(column: memoryview[float], motion: Bounces) -> list[float]:
    """List what the flights of a cycle have in a column."""
    return [column[row] for row in range(motion.first, motion.first + motion.count)]


def _onward(throw: float, restitution: float, phase: float, speed: float) -> tuple[float, float]:
    """Fly once and bounce."""
    flown = flight(sinusoidal(throw), phase, speed)
    return (phase + flown.length) % TURN, restitution * flown.impact


def _apart(one: float, other: float) -> float:
    return abs(math.remainder(one - other, TURN))


# ------------------------------------------------------------------------------- cycles with contact


def test_the_momentum_of_a_cycle_is_that_of_the_weight() -> None:
    draw, closed = random.Random(1), 0
    for i in range(200):
        throw, restitution = draw.uniform(1.01, 6.0), (0.0, 0.1, 0.25)[i % 3]
        motion = _from_rest(throw, restitution)
        if not motion.repeats:
            continue
        closed += 1
        # Eq. (29); in contact the load is 1 - K sin p
        end = motion.landing + motion.rest
        impulse = sum(_column(FLIGHTS.impulse, motion)) + motion.rest
        impulse += throw * (math.cos(end) - math.cos(motion.landing))
        # bounces that accumulate are summed as if the load were constant over their last 1e-8 rad
        assert impulse == pytest.approx(TURN * motion.cycles, abs=1e-7)
        assert sum(_column(FLIGHTS.length, motion)) + motion.rest == pytest.approx(TURN * motion.cycles)
    assert closed > 170


@pytest.mark.parametrize(("throw", "restitution"), [(1.3, 0.3), (1.05, 0.9), (3.9, 0.0), (5.0, 0.1)])
def test_each_flight_begins_where_the_one_before_it_ends(throw: float, restitution: float) -> None:
    motion = _from_rest(throw, restitution)
    assert motion.repeats
    assert motion.rest > 0.0
    assert (motion.first, motion.approach) == (0, 0)
    lift_off = math.asin(1.0 / throw)
    assert motion.approach_end == lift_off
    phase, speed, before = lift_off, 0.0, 0.0
    for row in range(motion.count):
        assert _apart(FLIGHTS.phase[row], phase) < 1e-9
        assert 0.0 <= FLIGHTS.phase[row] < TURN
        assert FLIGHTS.speed[row] == pytest.approx(speed, abs=1e-9)
        assert FLIGHTS.before[row] == pytest.approx(before, rel=1e-12)
        phase, speed = FLIGHTS.phase[row] + FLIGHTS.length[row], restitution * FLIGHTS.impact[row]
        before += FLIGHTS.length[row]
    assert _apart(motion.landing, phase) < 1e-9
    assert 0.0 <= motion.landing < TURN
    assert _apart(motion.landing + motion.rest, lift_off) < 1e-9
    assert (before + motion.rest) / TURN == pytest.approx(motion.cycles, rel=1e-12)


def test_plastic_bodies_fill_whole_drive_cycles_at_any_throw_number() -> None:
    for throw in np.linspace(1.001, 8.0, 100).tolist():
        motion = _from_rest(throw, 0.0)
        assert motion.repeats
        time = sum(_column(FLIGHTS.length, motion)) + motion.rest
        assert time == pytest.approx(TURN * motion.cycles, rel=1e-12)


@pytest.mark.parametrize("throw", [1.0001, 1.5, 3.0, math.sqrt(1.0 + math.pi**2) - 1e-9])
def test_up_to_one_cycle_of_flight_a_plastic_impact_makes_one_flight_a_cycle(throw: float) -> None:
    motion = _from_rest(throw, 0.0)
    assert motion.repeats
    assert (motion.count, motion.cycles) == (1, 1)
    assert motion.rest > 0.0
    assert _column(FLIGHTS.impulse, motion) == _column(FLIGHTS.impact, motion)


@pytest.mark.parametrize("restitution", [0.0, 0.3, 0.9])
def test_hops_near_the_threshold_are_the_same_but_for_their_scale(restitution: float) -> None:
    # while K sin p - 1 is a parabola in time, times are in proportion to sqrt(K^2 - 1)
    scaled = []
    for excess in np.geomspace(1e-15, 1e-7, 17).tolist():
        motion = _from_rest(1.0 + excess, restitution)
        assert motion.repeats
        scaled.append(sum(_column(FLIGHTS.length, motion)) / math.sqrt((1.0 + excess) ** 2 - 1.0))
    assert scaled[5:] == pytest.approx([scaled[-1]] * 12, rel=1e-2)
    assert max(scaled) < 2.0 * scaled[-1]


def test_rounding_decides_longer_hops_and_they_have_no_cycle() -> None:
    # past 1.8e-3 rad after the lift-off the landing must be known to 1e-9 rad
    throw, restitution = 1.0 + 1e-5, 0.3
    motion = _from_rest(throw, restitution)
    errors = Covariance(0.0, 0.0, 0.0)
    for row in range(motion.count):
        phase, speed = FLIGHTS.phase[row], FLIGHTS.speed[row]
        flown = flight(sinusoidal(throw), phase, speed)
        errors = propagate(sinusoidal(throw), restitution, phase, speed, flown, 0.0, errors)
    assert sum(_column(FLIGHTS.length, motion)) > 1.8e-3
    assert motion.repeats is (math.sqrt(errors.phase) < 1e-9)


# ------------------------------------------------------------------------------- cycles without contact

LOWEST, HIGHEST = math.sqrt(math.pi**2 + 1.0), math.sqrt(math.pi**2 + 4.0)


@pytest.mark.parametrize(
    ("throw", "count"),
    [(LOWEST - 1e-3, 1), (LOWEST + 1e-9, 1), (3.5, 1), (HIGHEST - 1e-9, 1), (HIGHEST + 1e-3, 2)],
)
def test_above_one_cycle_of_flight_the_body_is_thrown_again_where_it_lands(throw: float, count: int) -> None:
    motion = _from_rest(throw, 0.0)
    assert motion.repeats
    assert (motion.count, motion.cycles) == (count, count)
    assert (motion.rest > 0.0) is (throw < LOWEST)
    if LOWEST < throw < HIGHEST:
        # Eq. (32) for a turn: K cos p = pi; nothing bounces, so that the impulse is that of the impact alone
        assert motion == Bounces(True, 0, 1, 0, 1, 0.0, 0.0, math.asin(1.0 / throw))
        assert throw * math.cos(FLIGHTS.phase[0]) == pytest.approx(math.pi)
        row = (FLIGHTS.speed[0], FLIGHTS.length[0], FLIGHTS.impact[0], FLIGHTS.impulse[0], FLIGHTS.before[0])
        assert row == (0.0, TURN, TURN, TURN, 0.0)


@pytest.mark.parametrize("throw", [3.35, 3.5, 3.7])
def test_flight_after_flight_leads_to_the_closed_form_of_one_turn(throw: float) -> None:
    phase = math.asin(1.0 / throw)
    for _ in range(400):
        phase, _ = _onward(throw, 0.0, phase, 0.0)
        assert throw * math.sin(phase) >= 1.0
    _from_rest(throw, 0.0)
    assert FLIGHTS.phase[0] == pytest.approx(phase, abs=1e-9)


@pytest.mark.parametrize(
    ("throw", "restitution", "count", "cycles", "approach"),
    [
        (3.76, 0.0, 2, 2, 7),
        (6.4, 0.0, 1, 2, 7),
        (2.54, 0.1, 2, 1, 7),
        (2.24, 0.3, 2, 2, 15),
        (2.3, 0.3, 4, 4, 15),
        (2.4, 0.2, 1, 1, 31),
    ],
)
def test_a_cycle_that_never_rests_is_one_of_the_flight_map(
    throw: float, restitution: float, count: int, cycles: int, approach: int
) -> None:
    motion = _from_rest(throw, restitution)
    assert motion.repeats
    # it is looked for after 8, 16, 32 ... flights
    assert (motion.count, motion.cycles, motion.approach) == (count, cycles, approach)
    assert (motion.landing, motion.rest) == (0.0, 0.0)
    # its flights stand behind those of the approach, and behind the one that it was started from
    assert motion.first == motion.approach + 1
    assert FLIGHTS.phase[motion.approach] == motion.approach_end
    rows = range(motion.first, motion.first + count)
    jacobian = np.eye(2)
    for row, following in zip(rows, [*rows[1:], rows[0]], strict=True):
        phase, speed = FLIGHTS.phase[row], FLIGHTS.speed[row]
        flown = flight(sinusoidal(throw), phase, speed)
        assert (FLIGHTS.length[row], FLIGHTS.impact[row]) == pytest.approx(flown, rel=1e-12)
        assert FLIGHTS.impulse[row] == pytest.approx((1.0 + restitution) * flown.impact)
        assert not after_landing(
            sinusoidal(throw), phase + flown.length, flown.impact, restitution, 1e-8
        ).contact
        assert _apart(phase + flown.length, FLIGHTS.phase[following]) < 1e-11
        assert restitution * flown.impact == pytest.approx(FLIGHTS.speed[following], abs=1e-11)
        jacobian = (
            np.array(tangent_map(sinusoidal(throw), restitution, phase, flown)).reshape(2, 2) @ jacobian
        )
    assert abs(np.linalg.eigvals(jacobian)).max() < 1.0
    assert sum(_column(FLIGHTS.length, motion)) == pytest.approx(TURN * cycles, rel=1e-12)
    # the approach ends near it
    near = [_apart(motion.approach_end, p) for p in _column(FLIGHTS.phase, motion)]
    assert min(near) < 0.1


def test_an_unstable_cycle_and_a_start_far_from_any_are_not_closed() -> None:
    throw, restitution = 1.6, 0.7
    at = single_bounce(sinusoidal(throw), restitution, 2, 0)
    assert at.exists
    assert not at.stable
    FLIGHTS.phase[20], FLIGHTS.speed[20] = at.phase + 1e-6, at.speed
    assert _close(sinusoidal(throw), restitution, FLIGHTS, 20, 1) == (0, 0)
    FLIGHTS.phase[20], FLIGHTS.speed[20] = at.phase + 1.0, at.speed
    assert _close(sinusoidal(1.4), restitution, FLIGHTS, 20, 1) == (0, 0)


def test_motion_without_a_cycle_has_no_flights_to_show() -> None:
    for throw in np.linspace(2.4, 2.5, 10).tolist():
        assert _from_rest(throw, 0.3) == Bounces(False, 0, 0, 0, 0, 0.0, 0.0, 0.0)


@each("throw", [1.0 + 1e-12, 1.0001, 10.0, 1e3, 1e6])
@each("restitution", [0.0, 0.5, 0.99])
def test_the_work_is_bounded_for_any_throw_number(throw: float, restitution: float) -> None:
    motion = _from_rest(throw, restitution)
    lengths = _column(FLIGHTS.length, motion)
    assert sum(length > BOUNCE for length in lengths) <= MOST_FLIGHTS
    assert all(math.isfinite(length) and length >= 0.0 for length in lengths)
    assert motion.first + motion.count <= MOST_BOUNCES + LONGEST_CYCLE


def test_the_search_ends_after_so_many_flights_that_are_no_short_bounces() -> None:
    needed = _from_rest(7.0, 0.0)
    assert needed.count == 2
    assert _from_rest(7.0, 0.0, 2) == needed
    assert not _from_rest(7.0, 0.0, 1).repeats
    # a chain of hundreds of short bounces counts as nothing
    chain = _from_rest(1.0001, 0.9)
    assert chain.count > 50
    assert _from_rest(1.0001, 0.9, 1) == chain


# ------------------------------------------------------------------------------- other starts


def test_a_start_amid_the_motion_is_followed_from_there() -> None:
    motion = bounces(sinusoidal(1.3), 0.3, FLIGHTS, 64, 2.5, 4.0, False)
    assert (FLIGHTS.phase[0], FLIGHTS.speed[0], FLIGHTS.before[0]) == (2.5, 4.0, 0.0)
    assert motion.repeats
    expected = flight(sinusoidal(1.3), 2.5, 4.0)
    assert (FLIGHTS.length[0], FLIGHTS.impact[0]) == expected
    last = motion.count - 1
    assert _apart(motion.landing, FLIGHTS.phase[last] + FLIGHTS.length[last]) < 1e-9
    assert _apart(motion.landing + motion.rest, math.asin(1.0 / 1.3)) < 1e-9


def test_a_start_beside_a_single_bounce_is_drawn_to_it_if_that_is_stable() -> None:
    at = single_bounce(sinusoidal(1.4), 0.7, 2, 0)
    assert at.stable
    motion = bounces(sinusoidal(1.4), 0.7, FLIGHTS, 64, at.phase + 1e-3, at.speed, False)
    assert motion.repeats
    assert (motion.count, motion.cycles, motion.rest) == (1, 2, 0.0)
    assert FLIGHTS.phase[motion.first] == pytest.approx(at.phase, abs=1e-10)
    assert FLIGHTS.speed[motion.first] == pytest.approx(at.speed, abs=1e-10)


def test_a_resting_body_at_the_phase_of_one_turn_is_not_taken_for_another_start() -> None:
    # the closed form belongs to bodies from rest alone
    motion = bounces(sinusoidal(3.5), 0.0, FLIGHTS, 64, 0.0, 9.0, False)
    assert FLIGHTS.speed[0] == 9.0
    assert motion.repeats


def test_rounding_ends_the_search_from_rest_alone() -> None:
    # irregular flights: from rest they are known to 1e-5 for some dozens, other starts go on to the limit
    _from_rest(2.45, 0.3)
    FLIGHTS.phase[200] = -1.0
    _from_rest(2.45, 0.3)
    assert FLIGHTS.phase[200] == -1.0
    bounces(sinusoidal(2.45), 0.3, FLIGHTS, 256, math.asin(1.0 / 2.45), 0.0, False)
    assert FLIGHTS.phase[200] >= 0.0


# ------------------------------------------------------------------------------- cycles of one bounce


@pytest.mark.parametrize("turns", [1, 2, 3])
@pytest.mark.parametrize("restitution", [0.5, 0.8, 0.95])
def test_a_single_bounce_repeats_and_is_stable_as_its_tangent_map_says(
    turns: int, restitution: float
) -> None:
    plus, length = 1.0 + restitution, TURN * turns
    level, steep = math.pi * turns * (1.0 - restitution) / plus, 2.0 * (1.0 + restitution**2) / plus**2
    for share, stable in ((1e-3, True), (0.5, True), (0.999, True), (1.001, False), (3.0, False)):
        throw = math.hypot(level, share * steep)
        bed = sinusoidal(max(throw, 1.0))._replace(throw=throw)  # a body may bounce on a trough that bears it
        at = single_bounce(bed, restitution, turns, 0)
        assert at.exists
        assert at.stable is stable
        # it lands with u = 2 pi m / (1 + e) after m turns: Eqs. (30) and (37)
        assert throw * math.cos(at.phase) == pytest.approx(level)
        assert at.speed == pytest.approx(restitution * length / plus)
        height = at.speed * length + throw * length * math.cos(at.phase) - 0.5 * length**2
        assert height == pytest.approx(0.0, abs=1e-12 * length**2)
        slopes = tangent_map(bed, restitution, at.phase, Flight(length, length - at.speed))
        jacobian = np.array(slopes).reshape(2, 2)
        assert np.linalg.det(jacobian) == pytest.approx(restitution**2)
        assert stable is bool(abs(np.linalg.eigvals(jacobian)).max() < 1.0)


def test_a_single_bounce_exists_from_the_throw_number_on_that_can_throw_it_so_far() -> None:
    least = 2.0 * math.pi * (1.0 - 0.2) / (1.0 + 0.2)
    below, above = (single_bounce(sinusoidal(least * x), 0.2, 2, 0) for x in (1.0 - 1e-9, 1.0 + 1e-9))
    assert not below.exists
    assert not below.stable
    assert math.isnan(below.phase)
    assert math.isnan(below.speed)
    assert above.exists
    assert above.phase == pytest.approx(0.0, abs=1e-4)
    assert not single_bounce(sinusoidal(math.pi), 0.0, 1, 0).exists  # equality


def test_a_contact_that_rounding_has_moved_tells_where_the_body_takes_off_again() -> None:
    bed, e = sinusoidal(1.6), 0.7
    motion = bounces(bed, e, FLIGHTS, 512, bed.lift_off, 1e-6, False)
    assert not motion.repeats
    assert motion.count == motion.cycles == 0
    assert motion.approach > 20
    assert motion.landing == motion.rest == 0.0
    assert motion.approach_end == bed.lift_off
