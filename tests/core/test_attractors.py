"""Motions of bodies from many starts."""

from __future__ import annotations

import math
from itertools import islice
from typing import Any, NamedTuple

import numpy as np
import pytest
from helpers.hopping_bodies import FLIGHTS, HOPS, Drawn, line, unit, walker

from vibro.core.attractors import Attractors, Survey, survey
from vibro.core.codes import Status
from vibro.core.drive import Loads
from vibro.core.hops import hopping
from vibro.core.numbers import KNOWN
from vibro.core.slides import thresholds

TURN = 2.0 * math.pi


LONG_CYCLE = Drawn(line(3.8046065926376924, 20.2169, 0.50327, 0.46190), 0.5)


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
