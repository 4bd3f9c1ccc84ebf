"""Means of motions that do not repeat: beside walks of other bodies, their statistics, and their balance."""

from __future__ import annotations

import itertools
import math
import random
import statistics

import pytest
from helpers.hopping_bodies import FLIGHTS, HOPS, ellipse, line, unit, walker

from vibro.core import hops as averages_module
from vibro.core.codes import Status
from vibro.core.drive import Loads
from vibro.core.flight import single_bounce, sinusoidal
from vibro.core.hops import (
    Bodies,
    Means,
    _balance,
    _variances,
    _with_single_bounces,
    averages,
    fly_sample,
)
from vibro.core.legs import track_of
from vibro.core.numbers import BODIES, doubles, integers
from vibro.core.return_map import (
    hopping_cycle,
    orbit_from,
    release,
    write_hop,
)

TURN = 2.0 * math.pi
LIST = list(range(BODIES))
HALVES = 2 * BODIES
ROOM = Bodies(
    doubles(HALVES), doubles(HALVES), doubles(HALVES), doubles(HALVES), doubles(HALVES), integers(3 * BODIES)
)


def _averaged(loads: Loads, restitution: float, length: int = 12, longest: bool = True) -> Means:
    return averages(track_of(loads, restitution), restitution, length, longest, FLIGHTS, HOPS, ROOM)


# ------------------------------------------------------------------------------- statistics


def test_variances_are_those_of_the_textbook() -> None:
    pick, bodies = random.Random(1), ROOM
    times = [[pick.uniform(5.0, 9.0) for _ in range(2)] for _ in LIST]
    paths = [[0.4 * t + pick.gauss(0.0, 1.0) for t in pair] for pair in times]
    for i in LIST:
        for half in range(2):
            bodies.time[2 * i + half], bodies.path[2 * i + half] = times[i][half], paths[i][half]
    total = sum(map(sum, times))
    mean = sum(map(sum, paths)) / total
    own, halves, drift = _variances(bodies, mean, total)
    off = [
        [(d - mean * t) * BODIES / total for d, t in zip(*x, strict=True)]
        for x in zip(paths, times, strict=True)
    ]
    assert own == pytest.approx(statistics.variance([a + b for a, b in off]), rel=1e-12)
    assert halves == pytest.approx(statistics.fmean([(a - b) ** 2 for a, b in off]), rel=1e-12)
    assert drift == 0.0


def _with(
    monkeypatch: pytest.MonkeyPatch, own: float, halves: float, drift: float = 0.0, **arguments: bool
) -> Means:
    monkeypatch.setattr(averages_module, "_variances", lambda *_: (own, halves, drift))
    # above K = 2 no stable bounce, and never in contact
    return _averaged(line(2.45, 30.0, 0.5, 0.4), 0.3, 6, **arguments)


def test_the_error_is_that_of_twelve_bodies(monkeypatch: pytest.MonkeyPatch) -> None:
    lands = line(4.3, 30.0, 0.5, 0.4)
    for own, halves, expected in (
        (0.5, 1.0, 0.75 / 12.0),
        (2.9, 1.0, 1.95 / 12.0),
        (3.1, 1.0, 3.1 / 12.0),
        (7.9, 1.0, 7.9 / 12.0),
        (8.1, 1.0, 8.1 / 12.0 + 11.0 / 9.0 * 7.1),
        (0.0, 0.0, 0.0),
        (1.0, 0.0, 1.0 / 12.0 + 11.0 / 9.0),
    ):
        means = _with(monkeypatch, own, halves)
        assert means.status == Status.AVERAGED
        assert means.deviation == pytest.approx(TURN * math.sqrt(expected), rel=1e-14)
    # what halves differ by, all bodies together, is added in full
    assert _with(monkeypatch, 0.5, 1.0, 0.4).deviation == pytest.approx(
        TURN * math.sqrt(0.75 / 12.0 + 0.4), rel=1e-14
    )
    # where bodies come to contact the scatter beyond their halves is added in full
    monkeypatch.setattr(averages_module, "_variances", lambda *_: (2.0, 1.0, 0.0))
    expected = 1.5 / 12.0 + 11.0 / 9.0
    assert _averaged(lands, 0.2, 6).deviation == pytest.approx(TURN * math.sqrt(expected), rel=1e-14)


def test_longer_samples_are_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    assert _with(monkeypatch, 2.9, 1.0, longest=False).status == Status.AVERAGED
    longer = _with(monkeypatch, 3.1, 1.0, longest=False)
    assert longer.status == Status.UNRESOLVED
    assert all(math.isnan(x) for x in longer[1:])
    monkeypatch.setattr(averages_module, "_variances", lambda *_: (3.1, 1.0, 0.0))
    # not where bodies come to contact: kicks decide
    assert _averaged(line(4.3, 30.0, 0.5, 0.4), 0.2, 6, longest=False).status == Status.AVERAGED
    # a drift asks for them everywhere
    assert _with(monkeypatch, 1.0, 1.0, 0.1, longest=False).status == Status.UNRESOLVED
    monkeypatch.undo()
    # hardly any friction: bodies remember their velocities
    assert _averaged(line(2.45, 30.0, 0.5, 1e-4), 0.3, 6, longest=False).status == Status.UNRESOLVED
    assert _averaged(line(2.45, 30.0, 0.5, 1e-4), 0.3, 6).status == Status.AVERAGED
    # none, on a level trough: it is no matter for how long
    assert _averaged(line(2.45, 30.0, 0.5, 0.0), 0.3, 6, longest=False).status != Status.RUNAWAY


def test_friction_that_holds_gravity_by_a_hair_leaves_no_mean() -> None:
    """Samples seemed to balance at two million times the speed of the trough, with a small standard error."""
    slope = math.degrees(math.atan(0.3 * (1.0 - 1e-10)))
    assert _averaged(line(2.45, 30.0, 0.3, 0.3, -slope), 0.6, 60).status != Status.AVERAGED
    assert _averaged(line(2.45, 30.0, 0.3, 0.3, -0.5 * slope), 0.6, 12).status == Status.AVERAGED


def test_a_body_with_too_many_bounces_leaves_no_mean(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        averages_module, "fly_sample", lambda *a: fly_sample(*a)._replace(ends=a[2] != BODIES - 1)
    )
    assert _averaged(line(2.45, 30.0, 0.5, 0.4), 0.3, 6).status == Status.UNRESOLVED


# ------------------------------------------------------------------------------- walks


def test_means_are_those_of_a_body_walked_for_long() -> None:
    for loads, e in ((line(2.45, 30.0, 0.5, 0.4), 0.3), (ellipse(2.5, 0.8, 1.0, -1.0, 0.5, 0.3, 0.1), 0.3)):
        means = _averaged(loads, e, 60)
        body, rates, path, time, aloft, peak = walker(loads, e), [], 0.0, 0.0, 0.0, 0.0
        parts, due = [], TURN * 40.0
        for leg in body.legs():
            path, time, peak = path + leg.path, time + leg.length, max(peak, leg.peak)
            aloft += leg.length if leg.kind == "H" else 0.0
            if time > due:
                parts.append((path, time, aloft))
                due = time + TURN * 40.0
            if len(parts) > 12:
                break
        # what it does in the first cycles is left out
        rates = [(b[0] - a[0]) / (b[1] - a[1]) for a, b in itertools.pairwise(parts)]
        walked = TURN * statistics.fmean(rates) / unit(loads)
        error = TURN * statistics.stdev(rates) / math.sqrt(len(rates)) / unit(loads)
        assert means.status == Status.AVERAGED
        assert abs(means.displacement - walked) < 4.0 * math.hypot(means.deviation, error)
        assert math.hypot(means.deviation, error) < 0.1 * abs(walked)
        share = (parts[-1][2] - parts[0][2]) / (parts[-1][1] - parts[0][1])
        assert means.flight_fraction == pytest.approx(share, abs=0.02)
        assert means.peak == pytest.approx(peak / unit(loads), rel=0.25)


def test_without_friction_bodies_keep_their_velocity_over_the_ground() -> None:
    # as long as no contact stops them
    loads = line(2.45, 30.0, 0.5, 0.0)
    start = release(track_of(loads, 0.0))
    ground = start.velocity + loads.drive_tangential * math.cos(start.phase)
    means = _averaged(loads, 0.3)
    assert abs(means.displacement - TURN * ground) < 6.0 * means.deviation
    # one that takes off at its release has the velocity of the trough there
    aloft = ellipse(2.45, 0.8, 1.0, 1.2, 0.5, 0.0)
    assert release(track_of(aloft, 0.0)).aloft
    means = _averaged(aloft, 0.3)
    assert abs(means.displacement - TURN * 0.8) < 6.0 * means.deviation
    assert means.deviation < 0.4


def test_the_error_shrinks_with_the_root_of_the_sample() -> None:
    errors: list[tuple[float, float]] = []
    for i in range(4):
        loads = line(2.4 + 0.03 * i, 30.0, 0.5, 0.4)
        short, long = _averaged(loads, 0.3, 6), _averaged(loads, 0.3, 54)
        errors.append((short.deviation, long.deviation))
        apart = abs(short.displacement - long.displacement)
        assert apart < 5.0 * math.hypot(short.deviation, long.deviation)
    ratio = math.sqrt(sum(a * a for a, _ in errors) / sum(b * b for _, b in errors))
    assert 1.8 < ratio < 5.0  # 3


# ------------------------------------------------------------------------------- gains and balance


def test_bodies_that_remember_get_the_velocity_of_balance() -> None:
    loads = line(2.45, 30.0, 0.5, 1e-3, 0.02)
    track, a = track_of(loads, 0.3), loads.drive_tangential
    means = _averaged(loads, 0.3, 24)
    bodies = ROOM
    # from wherever the search begins, it ends where gains cancel
    grounds = []
    for shift in (0.0, -0.7, 0.6):
        for i in LIST:
            bodies.start[2 * i] += shift
        _balance(track, HOPS, bodies)
        ground = bodies.start[0] + a * bodies.start[1]
        for i in LIST:
            assert bodies.start[2 * i] + a * bodies.start[2 * i + 1] == pytest.approx(ground, abs=1e-13)
        gains = [bodies.gain[2 * i] + bodies.gain[2 * i + 1] for i in LIST]
        assert abs(sum(gains)) <= 0.1 * math.sqrt(sum(g * g for g in gains))
        total = sum(bodies.time[i] for i in range(2 * BODIES))
        mean = TURN * sum(bodies.path[i] for i in range(2 * BODIES)) / total
        grounds.append(ground)
        assert mean == pytest.approx(means.displacement, abs=means.deviation)
    assert max(grounds) - min(grounds) < 0.3 * a
    assert means.deviation < 0.5


def test_bodies_that_gravity_drives_on_without_a_stop_run_away() -> None:
    for throw in (1.5, 4.0):
        for trough in (-15.0, 15.0):
            for longest in (False, True):
                means = _averaged(line(throw, 30.0, 0.5, 0.2, trough), 0.3, 24, longest=longest)
                assert means.status == Status.RUNAWAY or (means.status == Status.UNRESOLVED and not longest)
                assert all(math.isnan(x) for x in means[1:])
    # not where friction holds them
    assert _averaged(line(2.45, 30.0, 0.5, 0.2, -11.0), 0.3, 24).status == Status.AVERAGED


def test_a_body_that_has_not_stopped_again_may_yet_run_away() -> None:
    # it gains so little that its speed does not tell: a longer sample is needed, then it is taken to run
    loads = line(2.45, 30.0, 0.5, 1e-5)
    loads = loads._replace(weight_tangential=1.5e-5 * loads.weight_normal)
    assert _averaged(loads, 0.3, 6, longest=False).status == Status.UNRESOLVED
    assert _averaged(loads, 0.3, 6).status == Status.RUNAWAY


# ------------------------------------------------------------------------------- single bounces


def test_stable_cycles_of_one_bounce_are_averaged_with_the_irregular_motion() -> None:
    loads, e = line(1.5, 30.0, 0.5, 0.4), 0.7
    throw = loads.drive_normal / loads.weight_normal
    track = track_of(loads, e)
    means = Means(Status.AVERAGED, 2.0, 0.1, 0.9, 0.3, 0.25)
    bounce = {m: single_bounce(sinusoidal(throw), e, m, 0) for m in range(1, 65)}
    turns = [m for m in bounce if bounce[m].exists and bounce[m].stable]
    assert len(turns) >= 1
    found, peaks = [], []
    for m in turns:
        # it lands at the speed 2 pi m / (1 + e), and the impulse is that of the weight
        write_hop(loads, bounce[m].phase, TURN * m, TURN * m, HOPS, 0)
        orbit = orbit_from(hopping_cycle(track, 0, 1, 0.0, 0.0, TURN * m), HOPS, 0.1)
        found.append(orbit.cycle.displacement / m)
        peaks.append(orbit.cycle.peak)
    out = _with_single_bounces(track, e, means, 0.1, HOPS, FLIGHTS.speed)
    motions = [2.0, *found]
    assert out.displacement == pytest.approx(statistics.fmean(motions), rel=1e-13)
    assert out.deviation == pytest.approx(math.sqrt(0.01 + statistics.variance(motions)), rel=1e-13)
    assert out.flight_fraction == pytest.approx((0.9 + len(turns)) / len(motions), rel=1e-13)
    landing = loads.weight_normal * TURN * max(turns) / (1.0 + e)
    assert out.impact == pytest.approx(max(0.3, landing), rel=1e-13)
    assert out.peak == pytest.approx(max(0.25, *peaks), rel=1e-12)
    # none of them: nothing changes
    assert (
        _with_single_bounces(track_of(line(1.01, 30.0, 0.5, 0.4), 0.0), 0.0, means, 0.1, HOPS, FLIGHTS.speed)
        == means
    )


def test_above_a_throw_number_of_two_single_bounces_capture_hardly_anything(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    mark = Means(Status.AVERAGED, 1.0, 2.0, 3.0, 4.0, 5.0)
    monkeypatch.setattr(averages_module, "_with_single_bounces", lambda *_: mark)
    assert _averaged(line(1.999, 30.0, 0.5, 0.4), 0.7, 4) == mark
    assert _averaged(line(2.001, 30.0, 0.5, 0.4), 0.7, 4) != mark


def test_a_stable_bounce_that_runs_away_leaves_no_mean() -> None:
    loads = line(1.5, 30.0, 0.5, 0.1, -8.0)
    means = Means(Status.AVERAGED, 2.0, 0.1, 0.9, 0.3, 0.25)
    out = _with_single_bounces(track_of(loads, 0.7), 0.7, means, 0.1, HOPS, FLIGHTS.speed)
    assert out.status == Status.RUNAWAY
    assert all(math.isnan(x) for x in out[1:])
