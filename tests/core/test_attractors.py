"""Motions of bodies from many starts, and other sliding between the same flights."""

from __future__ import annotations

import math
from itertools import islice
from typing import Any, NamedTuple

import numpy as np
import pytest
from helpers.hopping_bodies import FLIGHTS, HOPS, Drawn, draw, line, unit, walker

from vibro.core.attractors import Attractors, Survey, survey
from vibro.core.codes import Status
from vibro.core.drive import Loads
from vibro.core.hops import cycle_of, enter, hopping
from vibro.core.legs import track_of
from vibro.core.numbers import KNOWN
from vibro.core.return_map import (
    HoppingCycle,
    cycle_from,
    hopping_cycle,
    orbit_from,
    others_on,
)
from vibro.core.slides import thresholds

TURN = 2.0 * math.pi


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
