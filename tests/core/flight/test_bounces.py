"""The normal motion of a hopping body: impacts, accumulated bounces, cycles and their limits."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vibro.core.flight.bounces import BOUNCE, MOST_FLIGHTS, bounces
from vibro.core.flight.landing import after_landing
from vibro.core.flight.trajectory import flight

TURN = 2.0 * math.pi


def test_the_momentum_of_a_cycle_is_that_of_the_weight() -> None:
    random = np.random.default_rng(1)
    throw = random.uniform(1.01, 6.0, 300)
    restitution = random.choice([0.0, 0.1, 0.25], 300)
    motion = bounces(throw, restitution)
    impulse = np.bincount(motion.cycle.owner, motion.cycle.impulse, 300)
    # in contact the load is 1 - K sin p
    start, end = motion.landing, motion.landing + motion.rest
    impulse += motion.rest + throw * (np.cos(end) - np.cos(start))
    closed = motion.repeats
    assert closed.mean() > 0.9
    # bounces that accumulate are summed as if the load were constant over their last 1e-8 rad
    assert impulse[closed] == pytest.approx(TURN * motion.cycles[closed], abs=1e-7)


def test_flights_and_contact_fill_whole_drive_cycles() -> None:
    motion = bounces(np.linspace(1.001, 8.0, 400), np.zeros(400))
    time = np.bincount(motion.cycle.owner, motion.cycle.length) + motion.rest
    assert motion.repeats.all()
    assert time == pytest.approx(TURN * motion.cycles, rel=1e-12)


def test_up_to_one_cycle_of_flight_a_plastic_impact_makes_one_flight_a_cycle() -> None:
    motion = bounces(np.linspace(1.0001, math.sqrt(1.0 + math.pi**2), 200), np.zeros(200))
    assert (motion.cycle.number == 1).all()
    assert (motion.cycles == 1).all()
    assert motion.repeats.all()


@pytest.mark.parametrize("restitution", [0.0, 0.3, 0.9])
def test_hops_near_the_threshold_are_the_same_but_for_their_scale(restitution: float) -> None:
    excess = np.geomspace(1e-15, 1e-7, 33)
    motion = bounces(1.0 + excess, np.full(33, restitution))
    assert motion.repeats.all()
    # while K sin p - 1 is a parabola in time, times are in proportion to sqrt(K^2 - 1)
    scaled = np.bincount(motion.cycle.owner, motion.cycle.length) / np.sqrt((1.0 + excess) ** 2 - 1.0)
    assert scaled[8:] == pytest.approx(scaled[-1], rel=1e-2)
    assert (scaled < 2.0 * scaled[-1]).all()


def test_above_that_the_body_is_thrown_again_where_it_lands_until_that_doubles() -> None:
    # the cycle's closed form holds from K = sqrt(pi^2 + 1) to sqrt(pi^2 + 4); flight after flight leads there
    throw = np.linspace(math.sqrt(1.0 + math.pi**2) + 1e-4, math.sqrt(4.0 + math.pi**2) - 0.02, 500)
    motion = bounces(throw, np.zeros(500))
    assert motion.repeats.all()
    assert (motion.cycles == 1).all()
    assert (motion.rest == 0.0).all()
    phase = np.arcsin(1.0 / throw)
    for _ in range(800):
        step = flight(throw, phase, np.zeros(500))
        phase = np.mod(phase + step.length, TURN)
        assert (throw * np.sin(phase) >= 1.0).all()
    cycle = motion.cycle
    assert cycle.phase == pytest.approx(phase, abs=1e-9)
    assert cycle.length == pytest.approx(step.length, abs=1e-9)
    assert cycle.impact == pytest.approx(step.impact, abs=1e-8)
    assert np.array_equal(cycle.impulse, cycle.impact)
    edges = bounces(
        np.array([math.sqrt(1.0 + math.pi**2) - 1e-3, math.sqrt(4.0 + math.pi**2) + 1e-3]), np.zeros(2)
    )
    assert (edges.rest > 0.0).tolist() == [True, False]
    assert edges.cycles.tolist() == edges.cycle.number.tolist() == [1, 2]


@pytest.mark.parametrize("restitution", [0.1, 0.5, 0.9])
def test_accumulated_bounces_are_summed_as_if_one_flew_them_all(restitution: float) -> None:
    throw, phase = np.array([1.5]), np.array([3.0])
    load = 1.0 - throw * np.sin(phase)
    speed = 0.4e-8 * load * (1.0 - restitution)  # of the first bounce; they last 0.8e-8 altogether
    after = after_landing(throw, phase, speed / restitution, np.array([restitution]))
    assert after.contact.all()
    length, impulse = 0.0, (1.0 + restitution) * speed / restitution
    for _ in range(600):
        length += 2.0 * speed / load
        impulse += (1.0 + restitution) * speed
        speed = speed * restitution
    assert after.length == pytest.approx(length, rel=1e-12)
    assert after.impulse == pytest.approx(impulse, rel=1e-12)


def test_summing_earlier_changes_nothing_but_what_the_cut_says() -> None:
    throw, restitution = np.linspace(1.01, 1.8, 60), np.full(60, 0.3)
    motion = bounces(throw, restitution)
    assert motion.repeats.all()
    phase, speed, left = np.arcsin(1.0 / throw), np.zeros(60), np.ones(60, np.bool_)
    for _ in range(40):
        step = flight(throw, phase, speed)
        after = after_landing(throw, phase + step.length, step.impact, restitution, 1e-5)
        end = np.mod(phase + step.length + after.length, TURN)
        phase, speed = np.where(left, end, phase), np.where(left, after.take_off, 1.0)
        left &= ~after.contact
    assert not left.any()
    assert phase == pytest.approx(motion.landing, abs=1e-9)


def test_a_cycle_that_never_rests_is_one_of_the_flight_map() -> None:
    throw, restitution = np.linspace(2.17, 2.28, 40), np.full(40, 0.3)
    motion = bounces(throw, restitution)
    cycle = motion.cycle
    never = np.flatnonzero(motion.repeats & (motion.rest == 0.0))
    assert never.size > 20
    for i in never:
        own = np.flatnonzero(cycle.owner == i)
        for last, here, onward in zip(np.roll(own, 1), own, np.roll(own, -1), strict=True):
            speed = restitution[:1] * cycle.impact[last]
            step = flight(throw[i : i + 1], cycle.phase[here : here + 1], speed)
            assert np.mod(cycle.phase[here] + step.length, TURN) == pytest.approx(
                cycle.phase[onward], abs=1e-9
            )
            assert step.impact == pytest.approx(cycle.impact[here], abs=1e-9)


def test_motion_without_a_cycle_has_no_flights_to_show() -> None:
    motion = bounces(np.linspace(2.4, 2.5, 20), np.full(20, 0.3))
    assert not motion.repeats.any()
    assert (motion.cycle.number == 0).all()
    assert (motion.approach.number == 0).all()
    assert (motion.rest == 0.0).all()


@pytest.mark.parametrize("restitution", [0.0, 0.5, 0.99])
def test_the_work_is_bounded_for_any_throw_number(restitution: float) -> None:
    throw = np.array([1.0 + 1e-12, 1.0001, 10.0, 1e3, 1e5])
    cycle = bounces(throw, np.full(5, restitution)).cycle
    assert np.bincount(cycle.owner[cycle.length > BOUNCE], minlength=5).max() <= MOST_FLIGHTS
    assert np.isfinite(cycle.length).all()
    assert (cycle.length >= 0.0).all()
