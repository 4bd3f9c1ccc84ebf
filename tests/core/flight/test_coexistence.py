"""Other motions of hopping scenes than that from rest: running away, other sliding, other flights."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hopping import loads_at_throw, random_loads
from scenes import at_load, replaced

from vibro import Scene, Status, solve
from vibro.core.flight.bounces import bounces
from vibro.core.flight.coexistence import coexisting
from vibro.core.flight.cycles import cycles, entered
from vibro.core.flight.returns import hops_of, return_map
from vibro.core.groups import each, loads, take

TURN = 2.0 * math.pi
# from rest it advances 5.97996 g/w^2 a cycle, and 7.36196 if it is thrown otherwise
TWO_FLIGHTS = Scene(
    amplitude=0.0012534742194341873,
    frequency=20,
    drive_angle=0.6448704695649682,
    static_friction=0.46894843081393256,
    kinetic_friction=0.39128583597305744,
    restitution=0.5618659984445926,
)


def test_other_flights_are_looked_for_on_request_alone() -> None:
    cycle, searched = solve(TWO_FLIGHTS), solve(TWO_FLIGHTS, coexistence=True)
    assert cycle.status == searched.status == Status.OK
    assert [int(x.coexists) for x in (cycle, searched)] == [-1, 1]
    unit = 9.81 / (TURN * 20.0) ** 2
    assert float(cycle.displacement_per_cycle) / unit == pytest.approx(5.97996, rel=2e-6)
    for name in ("mean_velocity", "peak_velocity", "period_cycles"):
        assert getattr(cycle, name) == getattr(searched, name)


def test_the_other_flights_of_that_scene() -> None:
    groups = loads(*TWO_FLIGHTS.arrays()[:7])
    # states over g/w, for speeds over A w n
    scale = float(groups.normal)
    throw, start = (
        groups.across / groups.normal,
        (np.array([5.919035947779313]), np.array([4.825954263930713])),
    )
    other = bounces(throw.reshape(1), TWO_FLIGHTS.restitution.reshape(1), start=start)
    assert other.repeats.all()
    assert other.cycles.tolist() == [1]
    scene = each(groups, lambda x: x.reshape(-1))
    cells, _ = entered(scene, other)
    hops, velocity = hops_of(scene, other.cycle), np.array([-0.5859803624769713 * scale])
    for _ in range(100):
        cycle = return_map(cells, hops, velocity)
        velocity = cycle.velocity
    assert cycle.displacement / scale == pytest.approx(7.36196, rel=2e-6)


def test_without_bounces_and_with_friction_alike_nothing_else_is_found() -> None:
    scene = at_load(np.linspace(1.1, 3.0, 6) * 2.0, 30.0, 0.5, 0.4)
    assert solve(scene, coexistence=True).coexists.tolist() == [0] * 6


def test_hops_on_a_trough_steeper_than_kinetic_friction_can_run_away() -> None:
    # a pushed body; that from rest is stopped in every cycle
    throw, drive, mu_s, mu_d, trough = (
        np.array(column)
        for column in zip(
            (1.9789987, 20.007654, 0.29272432, 0.050192435, -2.8908320),
            (1.9583244, 42.015682, 0.91119969, 0.19707930, -11.274574),
            (1.4692720, 29.524596, 0.34150943, 0.13885237, -7.9549534),
            strict=True,
        )
    )
    load = throw * np.cos(np.radians(trough)) / np.sin(np.radians(drive))
    scene = at_load(load, drive, mu_s, mu_d, trough)
    cycle = solve(scene, coexistence=True)
    assert (cycle.status == Status.OK).all()
    assert cycle.coexists.tolist() == [1, 1, 1]
    assert solve(scene).coexists.tolist() == [1, 1, 1]  # no search is needed
    # one that runs away from rest has no other motion to compare with
    steep = replaced(scene, static_friction=mu_d)
    assert (solve(steep, coexistence=True).status == Status.RUNAWAY).all()
    assert (solve(steep, coexistence=True).coexists == -1).all()


def test_means_are_looked_at_too() -> None:
    scene = replaced(at_load([4.9, 4.9], 30.0, 0.5, 0.4, [0.0, 1.0]), restitution=0.3)
    cycle = solve(scene, coexistence=True)
    assert (cycle.status == Status.AVERAGED).all()
    assert np.isin(cycle.coexists, (0, 1)).all()


def test_low_kinetic_friction_can_leave_two_cycles() -> None:
    scene = random_loads(800, 5, most_throw=1.5, least_ratio=0.01)
    found = cycles(scene, np.zeros(800))
    assert (found.status == Status.OK).all()
    looked_at = np.flatnonzero(scene.kinetic_friction < 0.4 * scene.static_friction)
    others = coexisting(
        take(scene, looked_at), np.zeros(()), found.period[looked_at], found.impact[looked_at]
    )
    flagged = looked_at[others]
    assert 5 < flagged.size < 150
    part = take(scene, flagged)
    motion = bounces(part.across / part.normal, np.zeros(flagged.size))
    hops = hops_of(part, motion.cycle)
    cells, _ = entered(part, motion)
    ends = []
    for start in (-3.0, 3.0):
        velocity = np.full(flagged.size, start)
        for _ in range(400):
            step = return_map(cells, hops, velocity)
            velocity = step.velocity
        ends.append(step.displacement)
    other = np.maximum(*(np.abs(end - found.displacement[flagged]) for end in ends))
    assert (other > 1e-6).all()


def test_what_is_solved_together_changes_no_flag() -> None:
    scene = loads_at_throw([1.2, 2.2, 1.4, 2.45], 30.0, 0.5, [0.4, 0.4, 0.02, 0.4])
    restitution = np.array([0.3, 0.56, 0.0, 0.3])
    found = cycles(scene, restitution)
    group = restitution, found.period, found.impact
    together = coexisting(scene, *group)
    alone = [coexisting(take(scene, i), *take(group, i))[0] for i in np.arange(4)[:, None]]
    assert together.tolist() == alone
