"""Motions of bodies from many starts, and other sliding between the same flights."""

from __future__ import annotations

import math
from itertools import islice
from typing import Any, NamedTuple

import numpy as np
import pytest
from helpers.hopping_bodies import FLIGHTS, HOPS, Drawn, draw, ellipse, line, unit, walker

from vibro.core.attractors import Attractors, Survey, survey
from vibro.core.bounces import bounces
from vibro.core.codes import Status
from vibro.core.drive import Loads, directions, line_loads, weight_over_load
from vibro.core.flight import sinusoidal
from vibro.core.hops import cycle_of, enter, hopping
from vibro.core.legs import track_of
from vibro.core.numbers import KNOWN
from vibro.core.return_map import (
    HoppingCycle,
    cycle_from,
    hopping_cycle,
    orbit_from,
    others_on,
    return_map,
    write_hop,
)
from vibro.core.slides import thresholds

TURN = 2.0 * math.pi

# from rest it advances 5.97996 g/w^2 a cycle, and 7.36196 if it is thrown otherwise
RESTITUTION = 0.5618659984445926
TWO_FLIGHTS = line_loads(
    weight_over_load(0.0012534742194341873, 20.0, 9.81),
    directions(0.6448704695649682, 0.0),
    0.46894843081393256,
    0.39128583597305744,
)
THROW = TWO_FLIGHTS.drive_normal / TWO_FLIGHTS.weight_normal


LONG_CYCLE = Drawn(line(3.8046065926376924, 20.2169, 0.50327, 0.46190), 0.5)


def slides_otherwise(loads: Loads, restitution: float = 0.0) -> bool:
    """Return whether other velocities repeat along the flights from rest."""
    track = track_of(loads, restitution)
    entry = enter(track, restitution, FLIGHTS, HOPS)
    cycle = cycle_of(track, entry.motion)
    return others_on(cycle, HOPS, entry.velocity, orbit_from(cycle, HOPS, entry.velocity))


def surveyed(
    loads: Loads, restitution: float = 0.0, starts: int = 64, height: float = 0.0
) -> tuple[Survey, list[_Motion]]:
    """Survey a scene; what it has found, and its rows."""
    room = starts + KNOWN
    numbers: Any = [memoryview(bytearray(8 * room)).cast("d") for _ in range(10)]
    codes: Any = [memoryview(bytearray(8 * room)).cast("q") for _ in range(3)]
    out = Attractors(*numbers, *codes)
    found = survey(loads, thresholds(loads), restitution, starts, height, FLIGHTS, HOPS, out, room)
    rows = range(found.number)
    return found, [_Motion(out.displacement[i], out.period[i], out.flights[i], out.starts[i]) for i in rows]


class _Motion(NamedTuple):
    displacement: float
    period: float
    flights: float
    starts: int


# ------------------------------------------------------------------------------- other flights


def test_the_other_flights_of_that_scene() -> None:
    scale = TWO_FLIGHTS.weight_normal
    other = bounces(sinusoidal(THROW), RESTITUTION, FLIGHTS, 256, 5.919035947779313, 4.825954263930713, False)
    assert (other.repeats, other.cycles, other.rest) == (True, 1, 0.0)
    last = other.first + other.count
    for row in range(other.first, last):
        write_hop(TWO_FLIGHTS, FLIGHTS.phase[row], FLIGHTS.length[row], FLIGHTS.impulse[row], HOPS, row)
    velocity, path = -0.5859803624769713 * scale, 0.0
    for _ in range(100):
        now = return_map(track_of(TWO_FLIGHTS, RESTITUTION), HOPS, other.first, last, 0.0, 0.0, velocity)
        velocity, path = now.velocity, now.displacement
    assert path / scale == pytest.approx(7.36196, rel=2e-6)


@pytest.mark.parametrize(
    "e", [0.45, 0.7]
)  # born above K = 1, and below: there nothing else leaves the trough
@pytest.mark.parametrize(("beyond", "there"), [(-1e-3, False), (-1e-9, False), (1e-2, True)])
def test_the_cycle_of_one_bounce_is_found_where_it_is_born(e: float, beyond: float, there: bool) -> None:
    """Eq. (37): it repeats from K = pi (1 - e)/(1 + e) on; bodies dropped from its height get into it."""
    throw = math.pi * (1.0 - e) / (1.0 + e) * (1.0 + beyond)
    loads = line(throw, 30.0, 0.5, 0.4)
    found, motions = surveyed(loads, e, 256, 0.5 * math.pi**2 * loads.weight_normal)
    assert found.lost == 0
    assert sum(one.starts for one in motions) + found.irregular == 256
    assert any((one.flights, one.period) == (1, 1) for one in motions) == there


def test_a_long_cycle_that_ends_irregular_motion_is_found() -> None:
    """Its mean is 1.3 errors from the cycle of 18 turns in which every body ends, and the error is 38 %."""
    scene = LONG_CYCLE
    average = hopping(scene.loads, scene.restitution, FLIGHTS, HOPS)
    assert average.status == Status.AVERAGED
    found, (one,) = surveyed(scene.loads, scene.restitution)
    assert (found.irregular, found.lost, one.starts) == (0, 0, 64)
    assert one.period > 12
    assert found.mean == pytest.approx(one.displacement, rel=1e-12)
    body = walker(scene.loads, scene.restitution)
    for phase in (0.7, 3.9):
        body.p, body.v, body.way = phase, 0.0, 0
        times, paths = [0.0], [0.0]
        for leg in islice(body.legs(), 2000):
            times.append(times[-1] + leg.length)
            paths.append(paths[-1] + leg.path)
        end, turns = times[-1], TURN * one.period
        moved = float(np.interp(end, times, paths) - np.interp(end - turns, times, paths))
        assert moved / unit(scene.loads) / one.period == pytest.approx(one.displacement, rel=1e-7)


def test_starts_that_run_away_are_lost_and_told() -> None:
    # the slope exceeds kinetic friction: bodies that move never stop, those at rest stay
    loads = line(0.9, 30.0, 0.6, 0.1, 12.0)
    found, motions = surveyed(loads)
    assert found.runs_away
    assert found.lost + sum(one.starts for one in motions) == 64
    assert math.isnan(found.mean) == (found.lost > 0)


# ------------------------------------------------------------------------------- other sliding


def _ends(cycle: HoppingCycle) -> list[float]:
    """Where walks from beyond all fixed points, and between, end; none if one has not ended."""
    ends = []
    for share in (-1.0, -0.2, 0.1, 0.5, 1.0):
        velocity = share * cycle.bound
        for _ in range(400):
            before, velocity = velocity, cycle_from(cycle, HOPS, velocity).velocity
            if abs(velocity - before) < 1e-15:
                break
        if abs(velocity - before) > 1e-14:
            return []
        ends.append(velocity)
    return ends


@pytest.mark.parametrize(("ellipses", "seed"), [(False, 7), (True, 8)])
def test_all_other_sliding_is_found(ellipses: bool, seed: int) -> None:
    several = alone = 0
    for loads, e in draw(32, seed, throw=(1.01, 2.0), ratio=(0.02, 0.2), ellipses=ellipses):
        entry = enter(track_of(loads, e), e, FLIGHTS, HOPS)
        motion = entry.motion
        if not motion.repeats:
            continue
        last, duration = motion.first + motion.count, TURN * motion.cycles
        cycle = hopping_cycle(track_of(loads, e), motion.first, last, motion.landing, motion.rest, duration)
        ends = _ends(cycle)
        if not ends:
            continue
        apart = max(ends) - min(ends) > 1e-7
        assert slides_otherwise(loads, e) == apart
        several += apart
        alone += not apart
    assert several > 1
    assert alone > 11


@pytest.mark.parametrize(
    ("amplitude", "frequency", "drive", "mu_s", "mu_d", "restitution"),
    [
        (1.3748956736119936e-4, 51.236, 1.0669505127608383, 0.30035830, 0.06672496, 0.4668653293478722),
        (3.36438085517087e-3, 15.0, 0.5277495776122026, 1.00793060, 0.28847504, 0.14350018392575653),
    ],
)
def test_several_stops_may_lead_to_another_cycle(
    amplitude: float, frequency: float, drive: float, mu_s: float, mu_d: float, restitution: float
) -> None:
    weight = weight_over_load(amplitude, frequency, 9.81)
    loads = line_loads(weight, directions(drive, 0.0), mu_s, mu_d)
    assert slides_otherwise(loads, restitution)


@pytest.mark.parametrize("turned", [0.0, math.pi])
def test_sliding_beside_a_cycle_with_a_stop_is_found_on_either_side(turned: float) -> None:
    # 0.18 A w below the cycle from rest, and in its mirror image as much above
    phase = turned - 0.10156095187271674
    loads = ellipse(
        1.660488794618818, 0.3107727770420339, 1.0, phase, 0.18240888251511478, 0.019668063737400692
    )
    home = 0.0702510930459127 * math.cos(turned)
    track = track_of(loads, 0.0)
    cycle = cycle_of(track, enter(track, 0.0, FLIGHTS, HOPS).motion)
    assert others_on(cycle, HOPS, home, orbit_from(cycle, HOPS, home))


def test_without_bounces_and_with_friction_alike_nothing_else_is_found() -> None:
    for i in range(6):
        found, motions = surveyed(line(1.1 + 0.35 * i, 30.0, 0.5, 0.4))
        assert found.number + (found.irregular > 0) == 1
        assert sum(one.starts for one in motions) + found.irregular == 64


def test_bodies_on_which_nothing_acts_may_keep_another_velocity() -> None:
    kept = ellipse(3.6, 0.9, 1.0, 1.2, 0.5, 0.0)
    assert hopping(kept, 0.0, FLIGHTS, HOPS).status == Status.BOUNDARY
    assert surveyed(kept)[0].number > 1
