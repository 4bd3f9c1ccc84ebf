"""Steady motion of bodies that hop, and means where it does not repeat: tables, walks and limits."""

from __future__ import annotations

import itertools
import math
import statistics

import pytest
from helpers.hopping_bodies import FLIGHTS, HOPS, ellipse, line, unit, walker

from vibro.core import hops as averages_module
from vibro.core import hops as captures_module
from vibro.core.codes import Status
from vibro.core.drive import Loads
from vibro.core.hops import (
    Bodies,
    Captures,
    Hopping,
    Means,
    _with_captures,
    averages,
    captures,
    hopping,
    settle,
)
from vibro.core.legs import track_of
from vibro.core.numbers import BODIES, MOST_THROW, doubles, integers
from vibro.core.return_map import Release, hopping_cycle, orbit_from

TURN = 2.0 * math.pi


def _solved(loads: Loads, restitution: float = 0.0) -> Hopping:
    return hopping(loads, restitution, FLIGHTS, HOPS)


# ------------------------------------------------------------------------------- statuses


def test_hardly_hopping_tends_to_one_speed() -> None:
    for drive, mu_s in ((15.0, 0.9), (25.0, 0.6), (45.0, 0.3)):
        found = [_solved(line(1.0 + h, drive, mu_s, 0.8 * mu_s)) for h in (1e-10, 1e-8, 1e-6, 1e-4)]
        gaps = [abs(x.displacement - found[0].displacement) for x in found[1:]]
        assert gaps[0] < 1e-7
        assert gaps[1] < 0.02 * gaps[2]
        for x, h in zip(found, (1e-10, 1e-8, 1e-6, 1e-4), strict=True):
            assert x.flight_fraction < 2.0 * math.sqrt(h)


def test_bodies_that_nothing_holds_have_no_steady_cycle() -> None:
    for loads, status in (
        (line(1.5, 20.0, 0.3, 0.2, -20.0), Status.RUNAWAY),
        (line(1.5, 20.0, 0.3, 0.2, 20.0), Status.RUNAWAY),
        (line(1.5, 20.0, 0.0, 0.0), Status.INDETERMINATE),
        (line(1.5, 20.0, 0.0, 0.0, 1e-13), Status.RUNAWAY),
        (line(1.5, 20.0, 0.0, 0.0, -5.0), Status.RUNAWAY),
        (line(2e6, 20.0, 0.3, 0.2), Status.FLIGHT_NOT_MODELLED),
        (line(2e6, 20.0, 0.0, 0.0), Status.FLIGHT_NOT_MODELLED),
        (line(1.2, 30.0, 0.6, 0.2, -15.0), Status.RUNAWAY),
        (line(3.0, 30.0, 0.6, 0.2, -15.0), Status.RUNAWAY),
    ):
        found = _solved(loads)
        assert found.status == status
        assert (found.pattern, found.coexists) == (0, -1)
        assert all(math.isnan(x) for x in found[2:8])


def test_the_largest_throw_number_is_followed() -> None:
    loads = line(1.0, 30.0, 0.5, 0.4)._replace(drive_normal=1.0, weight_normal=1.0 / MOST_THROW)
    assert _solved(loads).status in (Status.OK, Status.AVERAGED)
    beyond = loads._replace(weight_normal=1.0 / MOST_THROW * (1.0 - 1e-12))
    assert _solved(beyond).status == Status.FLIGHT_NOT_MODELLED


def test_a_pushed_body_may_run_away_where_gravity_beats_kinetic_friction() -> None:
    for sign in (1.0, -1.0):
        loads = line(1.9789987, 20.007654, 0.29272432, 0.050192435, -2.8908320)
        loads = loads._replace(weight_tangential=sign * loads.weight_tangential)
        found = _solved(loads)
        if found.status == Status.OK:
            assert found.coexists == 1
        held = _solved(loads._replace(kinetic_friction=0.0506))
        assert held.status == Status.OK
        assert held.coexists == -1


# ------------------------------------------------------------------------------
# Means of motions that do not repeat: beside walks of other bodies, their statistics, and their balance.

HALVES = 2 * BODIES
ROOM = Bodies(
    doubles(HALVES), doubles(HALVES), doubles(HALVES), doubles(HALVES), doubles(HALVES), integers(3 * BODIES)
)


def _averaged(loads: Loads, restitution: float, length: int = 12, longest: bool = True) -> Means:
    return averages(track_of(loads, restitution), restitution, length, longest, FLIGHTS, HOPS, ROOM)


# ------------------------------------------------------------------------------- statistics


def test_friction_that_holds_gravity_by_a_hair_leaves_no_mean() -> None:
    """Samples seemed to balance at two million times the speed of the trough, with a small standard error."""
    slope = math.degrees(math.atan(0.3 * (1.0 - 1e-10)))
    assert _averaged(line(2.45, 30.0, 0.3, 0.3, -slope), 0.6, 60).status != Status.AVERAGED
    assert _averaged(line(2.45, 30.0, 0.3, 0.3, -0.5 * slope), 0.6, 12).status == Status.AVERAGED


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


# ------------------------------------------------------------------------------
# Cycles that capture irregular bodies, and the means over both.

CAPTURED_BODIES = 4


def test_bodies_end_in_stable_cycles_of_which_each_is_measured_as_alone() -> None:
    loads, e, irregular = line(1.6, 30.0, 0.5, 0.4), 0.7, 0.25
    track = track_of(loads, e)
    off: list[float] = []
    aloft = impact = peak = 0.0
    for i in range(CAPTURED_BODIES):
        settled = settle(track, e, Release(False, track.lift_off, 0.0), 0.0, i, FLIGHTS, HOPS)
        motion = settled.motion
        assert motion.repeats
        rows, turns = range(motion.first, motion.first + motion.count), motion.cycles
        cycle = hopping_cycle(
            track, motion.first, motion.first + motion.count, motion.landing, motion.rest, TURN * turns
        )
        orbit = orbit_from(cycle, HOPS, settled.velocity)
        off.append(orbit.cycle.displacement / turns - irregular)
        aloft += sum(FLIGHTS.length[row] for row in rows) / (TURN * turns)
        peak = max(peak, orbit.cycle.peak)
        impact = max(impact, *(loads.weight_normal * FLIGHTS.impact[row] for row in rows))
    found = captures(track, e, irregular, 0.0, FLIGHTS, HOPS)
    assert found.number == CAPTURED_BODIES
    assert found.displacement == pytest.approx(sum(off), rel=1e-9)
    assert found.squares == pytest.approx(sum(x * x for x in off), rel=1e-9)
    assert (found.aloft, found.impact, found.peak) == pytest.approx((aloft, impact, peak), rel=1e-9)


@pytest.mark.parametrize(("status", "counts"), [(Status.BOUNDARY, True), (Status.RUNAWAY, False)])
def test_a_cycle_beside_a_threshold_captures_bodies_too(
    monkeypatch: pytest.MonkeyPatch, status: Status, counts: bool
) -> None:
    monkeypatch.setattr(captures_module, "orbit_from", lambda *x: orbit_from(*x)._replace(status=status))
    found = captures(track_of(line(1.6, 30.0, 0.5, 0.4), 0.7), 0.7, 0.0, 0.0, FLIGHTS, HOPS)
    assert (found.number > 0) is counts


@pytest.mark.parametrize(("number", "each"), [(1, 2.0), (3, -1.0), (CAPTURED_BODIES, 0.5)])
def test_the_error_is_the_scatter_of_irregular_motion_and_cycles(
    monkeypatch: pytest.MonkeyPatch, number: int, each: float
) -> None:
    found = Captures(number, number * each, number * each * each, 0.9 * number, 3.0, 0.4)
    monkeypatch.setattr(averages_module, "captures", lambda *_: found)
    means = Means(Status.AVERAGED, 1.0, 0.1, 0.5, 2.0, 0.6)
    track = track_of(line(2.45, 30.0, 0.5, 0.4), 0.3)
    out = _with_captures(track, 0.3, means, 0.0, FLIGHTS, HOPS)
    # irregular motion is one body more, unless all have ended
    rest = [1.0] if number < CAPTURED_BODIES else []
    motions = [*rest, *[1.0 + each] * number]
    center = math.fsum(motions) / len(motions)
    variance = math.fsum((x - center) ** 2 for x in motions) / (len(motions) - 1)
    assert out.displacement == pytest.approx(center, rel=1e-14)
    own = 0.1 / (number + 1)
    assert out.deviation == pytest.approx(math.sqrt(own * own + variance), rel=1e-12)
    assert out.flight_fraction == pytest.approx((0.5 * len(rest) + 0.9 * number) / len(motions), rel=1e-14)
    assert (out.impact, out.peak) == (3.0, 0.6)
    # nothing changes where no body is captured
    monkeypatch.setattr(averages_module, "captures", lambda *_: found._replace(number=0))
    assert _with_captures(track, 0.3, means, 0.0, FLIGHTS, HOPS) == means
