"""Other motions of bodies that hop: other sliding between the same flights, and other flights."""

from __future__ import annotations

import math

import pytest
from helpers.hopping_bodies import FLIGHTS, HOPS, draw, ellipse, line

from vibro.core import attractors as coexistence_module
from vibro.core.attractors import _flies_otherwise, _slides_otherwise, coexisting
from vibro.core.bounces import bounces, single_bounce
from vibro.core.codes import Status
from vibro.core.drive import Loads, directions, line_loads, weight_over_load
from vibro.core.flight import sinusoidal
from vibro.core.hops import enter, hopping
from vibro.core.legs import track_of
from vibro.core.return_map import (
    HoppingCycle,
    cycle_from,
    hopping_cycle,
    return_map,
    write_hop,
)

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


def _coexists(loads: Loads, restitution: float = 0.0) -> bool:
    found = hopping(loads, restitution, FLIGHTS, HOPS)
    assert found.status in (Status.OK, Status.BOUNDARY, Status.AVERAGED)
    return coexisting(loads, restitution, found.period, found.impact, FLIGHTS, HOPS)


# ------------------------------------------------------------------------------- other flights


def test_other_flights_are_found() -> None:
    found = hopping(TWO_FLIGHTS, RESTITUTION, FLIGHTS, HOPS)
    assert found.status == Status.OK
    assert found.displacement / TWO_FLIGHTS.weight_normal == pytest.approx(5.97996, rel=2e-6)
    assert _coexists(TWO_FLIGHTS, RESTITUTION)
    assert not _slides_otherwise(TWO_FLIGHTS, RESTITUTION, FLIGHTS, HOPS)
    impact = found.impact / TWO_FLIGHTS.weight_normal
    assert _flies_otherwise(sinusoidal(THROW), RESTITUTION, found.period, impact, FLIGHTS)


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


def test_flights_are_told_from_those_from_rest() -> None:
    # a stable cycle of one bounce coexists with contact: K of m = 1, just above where it is born
    for restitution in (0.4, 0.55, 0.7):
        ratio = math.pi * (1.0 - restitution) / (1.0 + restitution)
        for throw in (ratio * 0.99, ratio * 1.02):
            if throw <= 1.0:
                continue
            bounce = single_bounce(sinusoidal(throw), restitution, 1, 0)
            motion = bounces(sinusoidal(throw), restitution, FLIGHTS, 256, math.asin(1.0 / throw), 0.0, True)
            if motion.repeats and motion.rest > 0.0:
                rows = range(motion.first, motion.first + motion.count)
                impact = max(FLIGHTS.impact[row] for row in rows)
                found = _flies_otherwise(
                    sinusoidal(throw), restitution, float(motion.cycles), impact, FLIGHTS
                )
                assert found == bounce.exists


def test_a_start_grid_finds_cycles_of_several_bounces() -> None:
    # one bounce is no longer stable, and its double is
    seen = 0
    for throw in (1.40, 1.45, 1.5, 1.55):
        bounce = single_bounce(sinusoidal(throw), 0.5618659984445926, 1, 0)
        if bounce.exists and not bounce.stable:
            seen += _flies_otherwise(sinusoidal(throw), RESTITUTION, 1.0, -1.0, FLIGHTS)
    assert seen > 0


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
        assert _slides_otherwise(loads, e, FLIGHTS, HOPS) == apart
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
    assert _slides_otherwise(loads, restitution, FLIGHTS, HOPS)


@pytest.mark.parametrize("turned", [0.0, math.pi])
def test_sliding_beside_a_cycle_with_a_stop_is_found_on_either_side(
    monkeypatch: pytest.MonkeyPatch, turned: float
) -> None:
    # 0.18 A w below the cycle from rest, and in its mirror image as much above
    phase = turned - 0.10156095187271674
    loads = ellipse(
        1.660488794618818, 0.3107727770420339, 1.0, phase, 0.18240888251511478, 0.019668063737400692
    )
    home = 0.0702510930459127 * math.cos(turned)
    monkeypatch.setattr(
        coexistence_module, "enter", lambda *arguments: enter(*arguments)._replace(velocity=home)
    )
    assert _slides_otherwise(loads, 0.0, FLIGHTS, HOPS)


def test_without_bounces_and_with_friction_alike_nothing_else_is_found() -> None:
    for i in range(6):
        assert not _coexists(line(1.1 + 0.35 * i, 30.0, 0.5, 0.4))


def test_means_are_looked_at_for_other_flights_alone() -> None:
    loads = line(2.45, 30.0, 0.5, 0.4)
    # an irregular motion: a period is unknown, so that any cycle of flights is another
    assert coexisting(loads, 0.3, math.nan, 1.0, FLIGHTS, HOPS) == _flies_otherwise(
        sinusoidal(2.45), 0.3, math.nan, 1.0 / loads.weight_normal, FLIGHTS
    )
    assert not _slides_otherwise(loads, 0.3, FLIGHTS, HOPS)


def test_bodies_on_which_nothing_acts_may_keep_another_velocity() -> None:
    kept = ellipse(3.6, 0.9, 1.0, 1.2, 0.5, 0.0)
    assert hopping(kept, 0.0, FLIGHTS, HOPS).status == Status.BOUNDARY
    assert _coexists(kept)
