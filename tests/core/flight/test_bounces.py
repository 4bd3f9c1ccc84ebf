"""The normal motion of a hopping body: impacts, accumulated bounces, cycles and their limits."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vibro.core.flight import bounces as bounce
from vibro.core.flight.bounces import MOST_FLIGHTS, after_landing, bounces
from vibro.core.flight.trajectory import flight

TURN = 2.0 * math.pi


def test_the_momentum_of_a_cycle_is_that_of_the_weight() -> None:
    random = np.random.default_rng(1)
    throw = random.uniform(1.01, 6.0, 300)
    restitution = random.choice([0.0, 0.2, 0.4], 300)
    cycle = bounces(throw, restitution)
    impulse = np.bincount(cycle.owner, cycle.impulse)
    # in contact the load is 1 - K sin p
    start, end = cycle.landing, cycle.landing + cycle.rest
    impulse += cycle.rest + throw * (np.cos(end) - np.cos(start))
    assert cycle.repeats.mean() > 0.9
    closed = cycle.repeats
    # bounces that accumulate are summed as if the load were constant over their last 1e-8 rad
    assert impulse[closed] == pytest.approx(TURN * cycle.cycles[closed], abs=1e-7)


def test_flights_and_contact_fill_whole_drive_cycles() -> None:
    throw = np.linspace(1.001, 8.0, 400)
    cycle = bounces(throw, np.zeros(400))
    time = np.bincount(cycle.owner, cycle.length) + cycle.rest
    closed = cycle.repeats
    assert time[closed] == pytest.approx(TURN * cycle.cycles[closed], rel=1e-12)


def test_up_to_one_cycle_of_flight_a_plastic_impact_makes_one_flight_a_cycle() -> None:
    cycle = bounces(np.linspace(1.0001, math.sqrt(1.0 + math.pi**2), 200), np.zeros(200))
    assert (cycle.number == 1).all()
    assert (cycle.cycles == 1).all()
    assert cycle.repeats.all()


def test_above_that_the_body_is_thrown_again_where_it_lands_until_that_doubles() -> None:
    # the cycle's closed form holds from K = sqrt(pi^2 + 1) to sqrt(pi^2 + 4); flight after flight leads there
    throw = np.linspace(math.sqrt(1.0 + math.pi**2) + 1e-4, math.sqrt(4.0 + math.pi**2) - 0.02, 500)
    cycle = bounces(throw, np.zeros(500))
    assert cycle.repeats.all()
    assert (cycle.cycles == 1).all()
    assert (cycle.rest == 0.0).all()
    phase = np.arcsin(1.0 / throw)
    for _ in range(800):
        step = flight(throw, phase, np.zeros(500))
        phase = np.mod(phase + step.length, TURN)
        assert (throw * np.sin(phase) >= 1.0).all()
    assert cycle.phase == pytest.approx(phase, abs=1e-9)
    assert cycle.length == pytest.approx(step.length, abs=1e-9)
    assert cycle.impact == pytest.approx(step.impact, abs=1e-8)
    assert np.array_equal(cycle.impulse, cycle.impact)
    edges = bounces(
        np.array([math.sqrt(1.0 + math.pi**2) - 1e-3, math.sqrt(4.0 + math.pi**2) + 1e-3]), np.zeros(2)
    )
    assert (edges.rest > 0.0).tolist() == [True, False]
    assert edges.cycles.tolist() == edges.number.tolist() == [1, 2]


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


def test_summing_earlier_changes_nothing_but_what_the_cut_says(monkeypatch: pytest.MonkeyPatch) -> None:
    throw, restitution = np.linspace(1.01, 1.8, 60), np.full(60, 0.3)
    fine = bounces(throw, restitution)
    monkeypatch.setattr(bounce, "_ACCUMULATED", 1e-5)
    coarse = bounces(throw, restitution)
    assert fine.repeats.all()
    assert (coarse.number < fine.number).all()
    assert coarse.landing == pytest.approx(fine.landing, abs=1e-9)


def test_a_cycle_that_never_rests_is_one_of_the_flight_map() -> None:
    throw, restitution = np.full(40, 0.3), np.full(40, 0.3)
    throw = np.linspace(2.17, 2.28, 40)
    cycle = bounces(throw, restitution)
    never = np.flatnonzero(cycle.repeats & (cycle.rest == 0.0))
    assert never.size > 20
    for i in never:
        own = np.flatnonzero(cycle.owner == i)
        k = np.array([throw[i]])
        phase, speed = cycle.phase[own[-1:]], restitution[:1] * cycle.impact[own[-2]]
        if own.size == 1:
            speed = restitution[:1] * cycle.impact[own]
        step = flight(k, phase, speed)
        assert np.mod(phase + step.length, TURN) == pytest.approx(cycle.phase[own[0]], abs=1e-9)


def test_motion_without_a_cycle_is_a_long_sample() -> None:
    cycle = bounces(np.linspace(2.4, 2.5, 20), np.full(20, 0.3))
    chaotic = ~cycle.repeats
    assert chaotic.sum() > 10
    assert (cycle.number[chaotic] == 3 * MOST_FLIGHTS // 4).all()


@pytest.mark.parametrize("restitution", [0.0, 0.5, 0.99])
def test_the_work_is_bounded_for_any_throw_number(restitution: float) -> None:
    throw = np.array([1.0 + 1e-12, 1.0001, 10.0, 1e3, 1e5])
    cycle = bounces(throw, np.full(5, restitution))
    assert cycle.owner.size <= 5 * MOST_FLIGHTS
    assert np.isfinite(cycle.length).all()
    assert (cycle.length >= 0.0).all()
