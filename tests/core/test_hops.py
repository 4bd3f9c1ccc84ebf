"""Steady motion of bodies that hop, and means where it does not repeat: tables, walks and limits."""

from __future__ import annotations

import itertools
import math
import random
import statistics

import pytest
from engines.two_axis_walk import NeverEndsError, NeverSettlesError
from helpers.hopping_bodies import FLIGHTS, HOPS, draw, ellipse, lift_off, line, unit, walked, walker
from helpers.reference_tables import read_rows

from vibro.core import hops as averages_module
from vibro.core import hops as captures_module
from vibro.core import hops as hopping_module
from vibro.core.bounces import Bounces, bounces
from vibro.core.codes import IRREGULAR, Status, spelt_text
from vibro.core.drive import Loads, directions, line_loads, weight_over_load
from vibro.core.flight import sinusoidal
from vibro.core.hops import (
    Bodies,
    Captures,
    Hopping,
    Means,
    _balance,
    _spread,
    _variances,
    _with_captures,
    averages,
    captures,
    enter,
    fly_sample,
    hopping,
    kick,
    settle,
)
from vibro.core.legs import Track, track_of
from vibro.core.numbers import BODIES, MOST_HOPS, MOST_THROW, doubles, integers
from vibro.core.return_map import Hops, Release, hopping_cycle, orbit_from, release, return_map

TURN = 2.0 * math.pi


def _solved(loads: Loads, restitution: float = 0.0) -> Hopping:
    return hopping(loads, restitution, FLIGHTS, HOPS)


# ------------------------------------------------------------------------------- tables


def test_every_row_of_the_table() -> None:
    rows = read_rows("hopping")
    assert len(rows) == 47
    for row in rows:
        amplitude = float(row["amplitude_mm"]) / 1000.0
        weight = weight_over_load(amplitude, float(row["frequency_hz"]), 9.81)
        angles = directions(math.radians(float(row["drive_angle_deg"])), 0.0)
        friction = float(row["static_friction"]), float(row["kinetic_friction"])
        found = _solved(line_loads(weight, angles, *friction))
        expected = float(row["displacement_per_cycle_mm"]) / 1000.0 / amplitude
        assert found.status == Status.OK
        assert found.displacement == pytest.approx(expected, rel=5e-11, abs=5e-11)
        assert found.flight_fraction == pytest.approx(float(row["flight_fraction"]), abs=1e-12)
        assert found.deviation == 0.0
        pattern = spelt_text(found.pattern)
        if row["pattern"] == "HH":
            # K = 3.48392: one flight of one cycle each time, at K cos p = pi; the table counts two
            assert (pattern, found.period) == ("H", 1.0)
            continue
        assert found.period == float(row["period_cycles"])
        assert len(pattern) == len(row["pattern"])
        assert pattern in row["pattern"] * 2  # the table starts some cycles elsewhere
        assert pattern[0] == "H"


@pytest.mark.parametrize(
    ("throw", "pattern", "displacement"),
    [
        (1.5, "HFB", "12.028332"),
        (2.0, "HB", "23.645166"),
        (2.5, "HBF", "41.364250"),
        (3.0, "H_F", "51.291633"),
    ],
)
def test_published_scene_thrown_higher_to_all_digits(throw: float, pattern: str, displacement: str) -> None:
    found = _solved(line(throw, 20.0, 0.74, 0.57))
    assert spelt_text(found.pattern) == pattern
    assert f"{found.displacement * throw / math.sin(math.radians(20.0)):.6f}" == displacement


# ------------------------------------------------------------------------------- walks


@pytest.mark.parametrize(
    ("seed", "ellipses", "restitution", "most_throw", "ratio"),
    [
        (1, False, 0.0, 3.2, 0.3),
        (2, True, 0.0, 3.2, 0.3),
        (3, True, 0.0, 2.0, 0.05),
        (4, False, 0.3, 1.9, 0.4),
        (5, True, 0.3, 1.9, 0.4),
    ],
)
def test_cycles_are_those_of_walks_from_rest(
    seed: int, ellipses: bool, restitution: float, most_throw: float, ratio: float
) -> None:
    seen = aloft = 0
    scenes = draw(
        10, seed, throw=(1.01, most_throw), ratio=(ratio, 1.0), ellipses=ellipses, restitution=restitution
    )
    for loads, e in scenes:
        found = _solved(loads, e)
        if found.status != Status.OK:
            continue
        try:
            cycle = walked(loads, e)
        except (NeverSettlesError, NeverEndsError):
            continue
        seen += 1
        aloft += release(track_of(loads, 0.0)).aloft
        # the walk leaves the shortest bounces out
        within = 1e-10 if e == 0.0 else 1e-6
        assert found.period == cycle.period
        assert found.displacement == pytest.approx(cycle.displacement, abs=within)
        assert found.peak == pytest.approx(cycle.peak, abs=within)
        assert found.impact == pytest.approx(cycle.impact, abs=within)
        assert found.flight_fraction == pytest.approx(cycle.flight_fraction, abs=within)
        if e == 0.0 and found.pattern > 0:
            assert spelt_text(found.pattern) in 2 * cycle.pattern
    assert seen >= 7
    assert aloft >= (ellipses and restitution == 0.0)


def _aloft(
    throw: float, mu_d: float, phase: float = 1.5, mu_s: float = 0.5, along: float = 0.9, trough: float = 0.0
) -> Loads:
    loads = ellipse(throw, along, 1.0, phase, mu_s, mu_d, trough)
    assert release(track_of(loads, 0.0)).aloft
    return loads


def _rested(throw: float, restitution: float) -> Bounces:
    return bounces(sinusoidal(throw), restitution, FLIGHTS, 256, math.asin(1.0 / throw), 0.0, True)


@pytest.mark.parametrize("phase", [0.9, 1.2, 1.6, 2.0])
def test_a_body_released_where_the_trough_cannot_bear_it_takes_off_at_once(phase: float) -> None:
    # without friction it keeps for good what it has got by then
    other = 0
    for throw in (1.5, 2.2, 2.9):
        loads = ellipse(throw, 0.9, 1.0, phase, 0.5, 0.0)
        found, cycle = _solved(loads), walked(loads)
        assert found.displacement == pytest.approx(cycle.displacement, abs=1e-11)
        track = track_of(loads, 0.0)
        if release(track).aloft:
            entry = enter(track, 0.0, FLIGHTS, HOPS)
            # unless a contact stops it, its velocity over the ground is that of the trough at its release
            ground = entry.velocity + 0.9 * math.cos(lift_off(loads) - phase)
            other += abs(ground - 0.9) < 1e-12
            assert abs(ground) < 0.9 + 1e-12
    assert other > 0 or phase == 0.9


def test_a_contact_forgets_the_flights_from_the_release() -> None:
    loads = _aloft(2.0, 0.3)
    track = track_of(loads, 0.0)
    entry = enter(track, 0.0, FLIGHTS, HOPS)
    # the first flight begins at the release, and ends in a contact that lasts to the lift-off
    motion = bounces(sinusoidal(2.0), 0.0, FLIGHTS, 256, 1.5, 0.0, False)
    assert (motion.count, motion.approach, motion.first) == (1, 0, 0)
    assert FLIGHTS.phase[0] == 1.5
    assert entry.motion == _rested(2.0, 0.0)
    assert entry.motion.rest != motion.rest
    assert entry.velocity != 0.0


def test_a_body_may_never_come_to_contact_from_its_release() -> None:
    # a plastic body that is thrown again, once a turn, each time it lands
    loads = _aloft(3.6, 0.3, 0.6)
    entry = enter(track_of(loads, 0.0), 0.0, FLIGHTS, HOPS)
    assert entry.motion.rest == 0.0
    assert entry.motion.approach > 0
    found = _solved(loads)
    assert (spelt_text(found.pattern), found.period) == ("H", 1.0)
    assert found.flight_fraction == pytest.approx(1.0, abs=1e-13)
    assert found.impact == pytest.approx(TURN * loads.weight_normal, rel=1e-12)
    begin = FLIGHTS.phase[entry.motion.first]
    assert 3.6 * math.cos(begin) == pytest.approx(math.pi, rel=1e-12)
    assert HOPS.length[entry.motion.first] == pytest.approx(TURN, rel=1e-12)
    # without friction, its velocity over the ground is that of its release
    free = _solved(_aloft(3.6, 0.0, 0.6))
    assert free.status == Status.BOUNDARY
    assert free.displacement == pytest.approx(TURN * 0.9, rel=1e-12)


def test_the_motion_of_contacts_is_known_where_rounding_chooses_how_it_begins() -> None:
    # a hundred flights that double their errors before the first contact
    known = irregular = 0
    for i in range(30):
        loads = _aloft(2.5 + 0.02 * i, 0.3, 1.3)
        throw = loads.drive_normal / loads.weight_normal
        motion = bounces(sinusoidal(throw), 0.6, FLIGHTS, 256, 1.3, 0.0, False)
        late = not motion.repeats
        entry = enter(track_of(loads, 0.6), 0.6, FLIGHTS, HOPS)
        rested = _rested(throw, 0.6)
        if late and rested.repeats and rested.rest > 0.0:
            known += 1
            assert entry.motion == rested
        elif late:
            irregular += 1
            assert not entry.motion.repeats
    assert known > 0
    assert irregular > 0


# ------------------------------------------------------------------------------- entering a cycle


def test_a_body_enters_a_cycle_amid_its_motion_with_the_velocity_of_its_approach() -> None:
    seen = 0
    for scene in draw(60, 6, throw=(3.3, 6.0), restitution=0.3, ratio=(0.0, 0.0), slope=0.0):
        loads, e = scene
        track = track_of(loads, e)
        entry = enter(track, e, FLIGHTS, HOPS)
        motion = entry.motion
        if not motion.repeats or motion.rest > 0.0:
            continue
        seen += 1
        # no friction: the velocity over the ground has not changed since the lift-off
        a, at_rest = loads.drive_tangential, release(track)
        ground = at_rest.velocity + a * math.cos(at_rest.phase)
        here = entry.velocity + a * math.cos(FLIGHTS.phase[motion.first])
        assert here == pytest.approx(ground, abs=1e-10)
        last = motion.first + motion.count
        again = return_map(track, HOPS, motion.first, last, 0.0, 0.0, entry.velocity)
        assert again.velocity == pytest.approx(entry.velocity, abs=1e-9)
        assert sum(HOPS.length[motion.first : last]) == pytest.approx(TURN * motion.cycles, rel=1e-10)
    assert seen > 4


# ------------------------------------------------------------------------------- limits


def test_ideal_sticking_is_the_limit_of_high_friction() -> None:
    for throw in (1.05, 1.7, 2.4, 3.2):
        for friction, tolerance in ((1e3, 1e-2), (1e5, 1e-4), (1e7, 1e-6)):
            loads = line(throw, 30.0, friction, friction)
            found = _solved(loads)
            # v = g n^2 / (2 f) cot(alpha), Eq. (39), with n = flight fraction
            share = found.flight_fraction**2 * loads.weight_normal / math.tan(math.radians(30.0))
            assert found.displacement == pytest.approx(2.0 * math.pi**2 * share, rel=tolerance)


def test_hardly_hopping_tends_to_one_speed() -> None:
    for drive, mu_s in ((15.0, 0.9), (25.0, 0.6), (45.0, 0.3)):
        found = [_solved(line(1.0 + h, drive, mu_s, 0.8 * mu_s)) for h in (1e-10, 1e-8, 1e-6, 1e-4)]
        gaps = [abs(x.displacement - found[0].displacement) for x in found[1:]]
        assert gaps[0] < 1e-7
        assert gaps[1] < 0.02 * gaps[2]
        for x, h in zip(found, (1e-10, 1e-8, 1e-6, 1e-4), strict=True):
            assert x.flight_fraction < 2.0 * math.sqrt(h)


# ------------------------------------------------------------------------------- statuses


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


def test_static_friction_holds_less_than_the_weight_along_the_trough() -> None:
    loads = line(1.5, 20.0, 0.3, 0.3)
    held, not_held = (
        loads._replace(weight_tangential=0.3 * loads.weight_normal * f) for f in (1.0 - 1e-9, 1.0)
    )
    assert _solved(held).status == Status.OK
    assert _solved(not_held).status == _solved(not_held._replace(line=False)).status == Status.RUNAWAY
    down = not_held._replace(weight_tangential=-not_held.weight_tangential)
    assert _solved(down).status == Status.RUNAWAY


def test_the_largest_throw_number_is_followed() -> None:
    loads = line(1.0, 30.0, 0.5, 0.4)._replace(drive_normal=1.0, weight_normal=1.0 / MOST_THROW)
    assert _solved(loads).status in (Status.OK, Status.AVERAGED)
    beyond = loads._replace(weight_normal=1.0 / MOST_THROW * (1.0 - 1e-12))
    assert _solved(beyond).status == Status.FLIGHT_NOT_MODELLED


def test_an_irregular_motion_is_averaged() -> None:
    found = _solved(line(2.45, 30.0, 0.5, 0.4), 0.3)
    assert found.status == Status.AVERAGED
    assert found.pattern == IRREGULAR
    assert math.isnan(found.period)
    assert 0.0 < found.deviation < 0.2 * found.displacement
    assert 0.5 < found.flight_fraction <= 1.0
    assert found.coexists == -1
    assert found.impact > 0.0
    assert found.peak > 0.0


def test_samples_are_lengthened_until_one_suffices(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[tuple[int, bool]] = []
    loads, mean = line(2.45, 30.0, 0.5, 0.4), Means(Status.AVERAGED, 1.0, 0.1, 0.9, 2.0, 3.0)

    def sampled(track: Track, e: float, length: int, longest: bool, *_: object) -> Means:
        assert (track.loads, e) == (loads, 0.3)
        asked.append((length, longest))
        return mean if len(asked) == suffices else mean._replace(status=Status.UNRESOLVED)

    monkeypatch.setattr(hopping_module, "averages", sampled)
    for suffices in (1, 2, 3, 4):
        asked.clear()
        found = _solved(loads, 0.3)
        assert asked == [(12, False), (48, False), (240, True)][:suffices]
        if suffices < 4:
            assert found[:4] == (Status.AVERAGED, IRREGULAR, 1.0, 0.1)
            assert found[5:9] == (0.9, 2.0, 3.0, -1)
            assert math.isnan(found.multiplier)
        else:
            assert found.status == Status.UNRESOLVED
            assert math.isnan(found.displacement)


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


def test_a_steady_cycle_without_any_force_along_the_trough_is_one_of_many() -> None:
    found = _solved(line(1.5, 30.0, 0.5, 0.0))
    assert found.status in (Status.OK, Status.BOUNDARY)
    kept = [_solved(ellipse(1.5 + 0.1 * i, 0.9, 1.0, -1.0, 0.5, 0.0)) for i in range(10)]
    assert {x.status for x in kept} == {Status.OK, Status.BOUNDARY} or Status.BOUNDARY in {
        x.status for x in kept
    }
    # where a body comes to rest just as it would slide on, rounding decides whether it does
    grazing = _solved(line(2.863057741121708, 53.2596, 0.511069091792448, 0.0))
    assert spelt_text(grazing.pattern) in ("HB_F", "HBF")
    assert grazing.status == Status.BOUNDARY


def test_a_trough_that_moves_up_and_down_alone_conveys_nothing() -> None:
    for mu_d in (0.0, 0.3):
        found = _solved(ellipse(1.6, 0.0, 1.0, 0.4, 0.5, mu_d))
        assert found.status in (Status.OK, Status.BOUNDARY)
        assert abs(found.displacement) < 1e-14


# ------------------------------------------------------------------------------
# Long samples of kicked bodies: their hops, where their parts begin and end, and sums over them.


def _hops() -> Hops:
    return Hops(*(memoryview(bytearray(8 * (MOST_HOPS + 10))).cast("d") for _ in range(8)))


SAMPLED, OTHERS = _hops(), _hops()


# ------------------------------------------------------------------------------- kicks


def test_kicks_are_spread_evenly_and_differ_by_tenths_from_body_to_body() -> None:
    numbers = sorted(_spread(count, body) for count in range(50) for body in range(BODIES))
    assert numbers[0] >= 0.0
    assert numbers[-1] < 1.0
    gaps = [after - before for before, after in itertools.pairwise(numbers)]
    assert max(gaps) < 3.0 / len(numbers)  # multiples of the golden ratio: gaps of three lengths
    assert min(gaps) > 0.3 / len(numbers)
    for body in range(BODIES):
        assert kick(3, body) == pytest.approx(1e-4 * 10.0**-body * _spread(3, body), rel=1e-14)
    assert _spread(2, 1) == pytest.approx((26 * (math.sqrt(5.0) - 1.0) / 2.0) % 1.0, rel=1e-13)


# ------------------------------------------------------------------------------- hops


# ------------------------------------------------------------------------------- parts


# ------------------------------------------------------------------------------
# Means of motions that do not repeat: beside walks of other bodies, their statistics, and their balance.

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
