"""Cycles that capture irregular bodies, and the means over both."""

from __future__ import annotations

import math

import pytest
from helpers.hopping_bodies import FLIGHTS, HOPS, line

from vibro.core import hops as averages_module
from vibro.core import hops as captures_module
from vibro.core.codes import Status
from vibro.core.flight import Bounces, bed_of, bounces
from vibro.core.hops import Captures, Means, _with_captures, captures, kick
from vibro.core.legs import track_of
from vibro.core.return_map import hopping_cycle, orbit_from, write_hops

TURN = 2.0 * math.pi
BODIES = 8


def _count(monkeypatch: pytest.MonkeyPatch, motions: list[Bounces]) -> list[tuple[float, float]]:
    """Let ``bounces`` find given motions in turn; return the take-offs from which it is asked."""
    asked: list[tuple[float, float]] = []

    def found(*arguments: object) -> Bounces:
        asked.append((float(str(arguments[4])), float(str(arguments[5]))))
        return motions[min(len(asked), len(motions)) - 1]

    monkeypatch.setattr(captures_module, "bounces", found)
    return asked


NONE = Bounces(False, 0, 0, 0, 0, 0.0, 0.0, 0.0)


def test_bodies_end_in_stable_cycles_of_which_each_is_measured_as_alone() -> None:
    loads, e, irregular = line(1.6, 30.0, 0.5, 0.4), 0.7, 0.25
    track, bed = track_of(loads, e), bed_of(loads)
    off: list[float] = []
    impact = peak = 0.0
    for i in range(BODIES):
        motion = bounces(bed, e, FLIGHTS, 512, bed.lift_off, kick(i, 0), False)
        if not motion.repeats or motion.rest > 0.0:
            continue
        last, turns = motion.first + motion.count, motion.cycles
        write_hops(loads, FLIGHTS, HOPS, motion.first, last)
        lengths = sum(FLIGHTS.length[row] for row in range(motion.first, last))
        assert lengths == pytest.approx(TURN * turns, rel=1e-11)
        orbit = orbit_from(hopping_cycle(track, motion.first, last, 0.0, 0.0, TURN * turns), HOPS, 0.0)
        off.append(orbit.cycle.displacement / turns - irregular)
        peak = max(peak, orbit.cycle.peak)
        impact = max(impact, *(FLIGHTS.impact[row] for row in range(motion.first, last)))
    found = captures(track, e, irregular, 0.0, FLIGHTS, HOPS)
    assert found.number >= len(off) > 0  # some come to contact before
    if found.number == len(off):
        assert found.displacement == pytest.approx(sum(off), rel=1e-12)
    assert min(off) - 1e-9 <= found.displacement / found.number <= max(off) + 1e-9
    assert found.squares * found.number >= found.displacement**2 * (1.0 - 1e-12)
    assert found.aloft == pytest.approx(found.number, rel=1e-11)  # they never rest
    assert found.impact == pytest.approx(loads.weight_normal * impact, rel=1e-9)
    assert found.peak == pytest.approx(peak, rel=1e-9)


def test_a_body_that_comes_to_contact_takes_off_again_kicked(monkeypatch: pytest.MonkeyPatch) -> None:
    late = NONE._replace(approach=100, landing=1.0, rest=0.5, approach_end=1.5)
    loads = line(2.45, 30.0, 0.5, 0.4)
    asked = _count(monkeypatch, [late])
    found = captures(track_of(loads, 0.3), 0.3, 0.0, 0.0, FLIGHTS, HOPS)
    assert found == Captures(0, 0.0, 0.0, 0.0, 0.0, 0.0)
    assert len(asked) == 6 * BODIES  # 512 flights each
    lift_off = bed_of(loads).lift_off
    assert [phase for phase, _ in asked] == [lift_off, *[1.5] * 5] * BODIES
    assert all(0.0 <= speed <= 1e-4 for _, speed in asked)


def test_bodies_that_never_repeat_are_not_captured(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = _count(monkeypatch, [NONE])
    assert captures(track_of(line(2.45, 30.0, 0.5, 0.4), 0.3), 0.3, 0.0, 0.0, FLIGHTS, HOPS).number == 0
    assert len(asked) == BODIES


@pytest.mark.parametrize(("status", "counts"), [(Status.BOUNDARY, True), (Status.RUNAWAY, False)])
def test_a_cycle_beside_a_threshold_captures_bodies_too(
    monkeypatch: pytest.MonkeyPatch, status: Status, counts: bool
) -> None:
    monkeypatch.setattr(captures_module, "orbit_from", lambda *x: orbit_from(*x)._replace(status=status))
    found = captures(track_of(line(1.6, 30.0, 0.5, 0.4), 0.7), 0.7, 0.0, 0.0, FLIGHTS, HOPS)
    assert (found.number > 0) is counts


@pytest.mark.parametrize(("number", "each"), [(1, 2.0), (3, -1.0), (12, 0.5)])
def test_the_error_is_the_scatter_of_irregular_motion_and_cycles(
    monkeypatch: pytest.MonkeyPatch, number: int, each: float
) -> None:
    found = Captures(number, number * each, number * each * each, 0.9 * number, 3.0, 0.4)
    monkeypatch.setattr(averages_module, "captures", lambda *_: found)
    means = Means(Status.AVERAGED, 1.0, 0.1, 0.5, 2.0, 0.6)
    track = track_of(line(2.45, 30.0, 0.5, 0.4), 0.3)
    out = _with_captures(track, 0.3, means, 0.0, FLIGHTS, HOPS)
    motions = [1.0] + [1.0 + each] * number
    center = math.fsum(motions) / len(motions)
    variance = math.fsum((x - center) ** 2 for x in motions) / (len(motions) - 1)
    assert out.displacement == pytest.approx(center, rel=1e-14)
    assert out.deviation == pytest.approx(math.sqrt(0.01 + variance), rel=1e-12)
    assert out.flight_fraction == pytest.approx((0.5 + 0.9 * number) / (number + 1), rel=1e-14)
    assert (out.impact, out.peak) == (3.0, 0.6)
    # nothing changes where no body is captured
    monkeypatch.setattr(averages_module, "captures", lambda *_: found._replace(number=0))
    assert _with_captures(track, 0.3, means, 0.0, FLIGHTS, HOPS) == means
