"""The return map of hopping bodies and its fixed points, beside walks by the law of Newton."""

from __future__ import annotations

import math
import random

import pytest
from helpers.cases import each
from helpers.hopping_bodies import (
    FLIGHTS,
    HOPS,
    Drawn,
    draw,
    ellipse,
    line,
    walk_round,
)

from vibro.core.bounces import Bounces, bounces
from vibro.core.codes import Status, spelt_text
from vibro.core.drive import Loads
from vibro.core.flight import bed_of
from vibro.core.hops import enter
from vibro.core.legs import track_of
from vibro.core.return_map import (
    HoppingCycle,
    Orbit,
    Return,
    hopping_cycle,
    orbit_from,
    release,
    return_map,
    write_hop,
)

TURN = 2.0 * math.pi

SCENES = [
    *draw(40, 1),
    *draw(40, 2, ellipses=True),
    *draw(25, 3, throw=(1.01, 1.9), restitution=0.4),
    *draw(25, 4, throw=(1.01, 1.9), restitution=0.4, ellipses=True),
    *draw(25, 5, slope=1.5, ratio=(0.2, 0.6)),
]


def _hops(scene: Drawn) -> Bounces:
    """Fly the cycle from a lift-off to the next; write its hops."""
    loads = scene.loads
    bed = bed_of(loads)
    motion = bounces(bed, scene.restitution, FLIGHTS, 256, bed.lift_off, 0.0, True)
    for row in range(motion.first, motion.first + motion.count):
        write_hop(loads, FLIGHTS.phase[row], FLIGHTS.length[row], FLIGHTS.impulse[row], HOPS, row)
    return motion


def _returned(scene: Drawn, motion: Bounces, velocity: float) -> Return:
    last = motion.first + motion.count
    track = track_of(scene.loads, scene.restitution)
    return return_map(track, HOPS, motion.first, last, motion.landing, motion.rest, velocity)


# ------------------------------------------------------------------------------- one cycle


def test_cycles_are_those_of_a_walk_from_event_to_event() -> None:
    pick, seen, patterns = random.Random(6), 0, set()
    for scene in SCENES:
        motion = _hops(scene)
        if not motion.repeats or motion.rest == 0.0:
            continue
        for velocity in (0.0, pick.uniform(-1.0, 1.0), pick.uniform(-3.0, 3.0)):
            now, then = (
                _returned(scene, motion, velocity),
                walk_round(scene.loads, scene.restitution, velocity),
            )
            # the walk leaves the shortest bounces out
            within = 1e-11 if scene.restitution == 0.0 else 1e-6
            assert now.velocity == pytest.approx(then.velocity, abs=within)
            assert now.displacement == pytest.approx(then.displacement, abs=within)
            assert now.peak == pytest.approx(then.peak, abs=within)
            assert now.settled
            if scene.restitution == 0.0:
                assert spelt_text(now.pattern) == then.pattern
                patterns.add(then.pattern)
            if now.slope > 0.0:
                assert now.friction == pytest.approx(then.impulse, abs=within)
                seen += 1
    assert seen > 100
    assert len(patterns) >= 12


# ------------------------------------------------------------------------------- release


@pytest.mark.parametrize(
    ("beyond", "aloft"), [(-1e-6, False), (-1e-10, False), (0.0, False), (1e-10, False), (1e-6, True)]
)
def test_a_release_at_the_lift_off_itself_is_no_other_take_off(beyond: float, aloft: bool) -> None:
    loads = ellipse(2.0, 1.0, 0.8, math.asin(0.5) + beyond, 0.5, 0.4, 0.1)
    start = release(track_of(loads, 0.0))
    assert start.aloft == aloft
    assert start.phase == pytest.approx(math.asin(0.5) + max(beyond, 0.0), abs=2e-10)
    assert abs(start.velocity) < 1e-6


# ------------------------------------------------------------------------------
# Fixed points of the return map: where plain walks of it end, and each way an orbit can end.

EPS = 2.0**-52


def _cycle(loads: Loads, restitution: float = 0.0) -> tuple[HoppingCycle, float, int] | None:
    """Find the cycle of the normal motion, the velocity with which a body enters it, and its period."""
    track = track_of(loads, restitution)
    entry = enter(track, restitution, FLIGHTS, HOPS)
    motion = entry.motion
    if not motion.repeats:
        return None
    last = motion.first + motion.count
    cycle = hopping_cycle(track, motion.first, last, motion.landing, motion.rest, TURN * motion.cycles)
    return cycle, entry.velocity, motion.cycles


def _solved(loads: Loads, restitution: float = 0.0) -> tuple[Orbit, int]:
    found = _cycle(loads, restitution)
    assert found is not None
    cycle, start, period = found
    return orbit_from(cycle, HOPS, start), period


# ------------------------------------------------------------------------------- sizes


def _bare(loads: Loads, duration: float = TURN) -> HoppingCycle:
    return hopping_cycle(track_of(loads, 0.0), 0, 0, 0.0, 0.0, duration)


@each("way", [1.0, -1.0])
@each(
    ("ulps", "bounded", "edge"),
    [(-6, True, False), (-3, True, True), (0, True, True), (3, True, True), (6, False, False)],
)
def test_rounding_decides_whether_friction_holds_within_four_ulp(
    ulps: int, bounded: bool, edge: bool, way: float
) -> None:
    loads = line(1.5, 30.0, 0.5, 0.25)
    slope = 0.25 * loads.weight_normal * (1.0 + ulps * EPS)
    cycle = _bare(loads._replace(weight_tangential=way * slope))
    assert (cycle.bounded, cycle.edge, cycle.neutral) == (bounded, edge, False)


# ------------------------------------------------------------------------------- where orbits end


@pytest.mark.parametrize(
    ("throw", "drive_deg", "mu_s", "mu_d", "trough_deg", "pattern", "displacement"),
    [
        (1.24, 0.00075, 1.0, 1.3e-10, 0.0, "HFB", 0.28197766550342690587),
        (2.0, 0.01, 0.3, 1e-7, -2e-6, "HFB", 3.6495948504758313772),
        (1.5, 30.0, 0.5, 1e-9, 0.0, "HF_F", 5.3823184539217098557),
        (1.1, 2.0, 0.4, 1e-12, 0.0, "HF_F", 6.2788666264706534638),
        (1.4, 1.0, 0.2, 1e-8, 0.0, "HF_F", 6.2822089608441947166),
    ],
)
def test_low_friction_as_50_digits_have_it(
    throw: float,
    drive_deg: float,
    mu_s: float,
    mu_d: float,
    trough_deg: float,
    pattern: str,
    displacement: float,
) -> None:
    # the fixed point was bracketed by 90 bisections of a cycle computed event by event with mpmath
    found, period = _solved(line(throw, drive_deg, mu_s, mu_d, trough_deg))
    assert (found.status, period) == (Status.OK, 1)
    assert spelt_text(found.cycle.pattern) == pattern
    assert found.cycle.displacement == pytest.approx(displacement, rel=1e-12)


def test_gravity_that_kinetic_friction_just_holds() -> None:
    mu_d = 1e-9
    trough = math.degrees(math.atan(mu_d))
    for throw, mu_s in ((1.0 + 1e-8, 1.5e-9), (1.2, 1e-3), (1.6, 1e-3), (2.2, 1e-3)):
        loads = line(throw, 20.0, mu_s, mu_d, trough)
        # the groups' own rounding aside
        loads = loads._replace(weight_tangential=mu_d * loads.weight_normal)
        found, period = _solved(loads)
        assert found.status == Status.BOUNDARY
        flatter, _ = _solved(loads._replace(kinetic_friction=mu_d * (1.0 + 1e-9)))
        assert flatter.status == Status.OK
        assert flatter.cycle.displacement == pytest.approx(found.cycle.displacement, rel=1e-3)
        steeper, _ = _solved(loads._replace(kinetic_friction=mu_d * (1.0 - 1e-9)))
        assert steeper.status in (Status.OK, Status.RUNAWAY)
        if throw == 1.0 + 1e-8:
            # it slides back ever faster until the trough never overtakes it
            ground = -TURN * loads.drive_tangential
            assert found.cycle.displacement / period == pytest.approx(ground, rel=1e-3)
