"""Legs: their hand-over, their closed forms, and the cycle that stands for its repeats."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scenes import Groups, at_load, contact_groups, loads_of

from vibro.core.codes import Mode
from vibro.core.walk.histories import Legs, Motion, follow
from vibro.core.walk.steps import course_of, starting, step

TURN = 2.0 * math.pi
LETTERS = " HFB_"
EPS = 2.0**-52


def followed(groups: Groups, cycles: float, *, velocity: float = 0.0, restitution: float = 0.0) -> Motion:
    course = course_of(loads_of(at_load(*groups)), np.array([restitution]))
    return follow(course, 0.0, velocity, cycles)


def walked(groups: Groups, cycles: int, restitution: float) -> Legs:
    """Walk without looking for a cycle."""
    course = course_of(loads_of(at_load(*groups)), np.array([restitution]))
    at = starting(course, np.zeros(1), np.zeros(1))
    rows = []
    while at.cycle[0] < cycles:
        leg = step(course, at)
        if leg.length[0] > 0.0:
            rows.append(
                (
                    *(x[0] for x in (at.mode, at.cycle, at.phase, leg.length, at.position, at.velocity)),
                    *(x[0] for x in (leg.displacement, leg.velocity, at.rate, leg.impact)),
                )
            )
        at = leg.after
    return Legs._make(np.array(column) for column in zip(*rows, strict=True))


def pattern_of(legs: Legs) -> str:
    return "".join(LETTERS[mode] for mode in legs.mode)


def assert_joined(motion: Motion) -> None:
    """Each phase starts where and when the one before ends, the first of the cycle behind its last too."""
    pairs: Any = zip(motion.transient, motion.steady, strict=True)
    legs = Legs._make(np.concatenate(pair) for pair in pairs)
    last = legs.mode.size - 1
    follower = np.arange(1, last + 2)
    if motion.period:
        follower[last] = motion.transient.mode.size
    else:
        follower = follower[:last]
    first = slice(0, follower.size)
    turns = (legs.phase[first] + legs.length[first] - legs.phase[follower]) / TURN
    assert np.abs(turns - np.rint(turns)).max(initial=0.0) < 1e-9  # the noise of the noisiest converged cycle
    assert (legs.length > 0.0).all()
    assert ((legs.phase >= 0.0) & (legs.phase < TURN)).all()
    inner = slice(0, last)
    ends = legs.position[inner] + legs.displacement[inner]
    np.testing.assert_array_equal(ends, legs.position[1:])
    slides = legs.impact[inner] == 0.0  # only an impact changes the velocity at once
    np.testing.assert_array_equal(
        legs.end_velocity[inner][slides & (legs.mode[inner] != Mode.FLIGHT)],
        legs.velocity[1:][slides & (legs.mode[inner] != Mode.FLIGHT)],
    )
    forward, back = legs.mode == Mode.FORWARD, legs.mode == Mode.BACK
    finite = np.isfinite(legs.length)
    assert (legs.displacement[forward & finite] >= -8 * EPS).all()
    assert (legs.displacement[back & finite] <= 8 * EPS).all()


@given(contact_groups(), st.floats(-3.0, 3.0))
def test_contact_phases_follow_each_other(groups: Groups, velocity: float) -> None:
    assert_joined(followed(groups, 4.0, velocity=velocity))


@pytest.mark.parametrize("restitution", [0.0, 0.3, 0.9])
@pytest.mark.parametrize("throw", [1.01, 1.5, 2.2, 3.2, 3.6])
def test_hopping_phases_follow_each_other(throw: float, restitution: float) -> None:
    groups = Groups(throw / math.sin(math.radians(20.0)), 20.0, 0.74, 0.57)
    assert_joined(followed(groups, 12.0, restitution=restitution))


@pytest.mark.parametrize(
    ("groups", "restitution"),
    [
        (Groups(0.9, 20.0, 0.74, 0.57), 0.0),
        (Groups(1.1, 20.0, 0.74, 0.57), 0.0),
        (Groups(1.36, 20.0, 0.74, 0.57), 0.0),
        (Groups(0.781, 57.03, 0.27, 0.155, 3.46), 0.0),
        (Groups(2.0, 20.0, 0.74, 0.57), 0.0),
        (Groups(4.5, 20.0, 0.74, 0.57), 0.0),
        (Groups(4.5, 20.0, 0.74, 0.57), 0.3),
        (Groups(7.0, 20.0, 0.74, 0.57), 0.0),
    ],
)
def test_the_stored_cycle_is_what_walking_on_would_find(groups: Groups, restitution: float) -> None:
    cycles = 100
    motion = followed(groups, float(cycles), restitution=restitution)
    assert motion.period
    walk = walked(groups, cycles, restitution)
    size, start = motion.steady.mode.size, motion.transient.mode.size
    assert walk.mode.size > start + 3 * size
    for i in range(start, walk.mode.size):
        count, row = divmod(i - start, size)
        assert walk.mode[i] == motion.steady.mode[row]
        assert walk.cycle[i] == motion.steady.cycle[row] + count * motion.period
        assert walk.phase[i] == pytest.approx(motion.steady.phase[row], abs=1e-12)
        expected = motion.steady.position[row] + count * motion.advance
        assert walk.position[i] == pytest.approx(expected, rel=1e-12, abs=1e-12)


def test_the_list_of_phases_does_not_grow_with_the_number_of_cycles() -> None:
    short, long = (followed(Groups(2.0, 20.0, 0.74, 0.57), cycles) for cycles in (200.0, 1e9))
    assert pattern_of(long.transient) == pattern_of(short.transient)
    assert long.advance == short.advance
    assert pattern_of(long.steady) in ("FB", "BF")


def test_a_body_that_never_slips_rests_for_ever() -> None:
    motion = followed(Groups(0.5, 20.0, 0.74, 0.57), 10.0)
    assert pattern_of(motion.transient) == "_"
    assert motion.transient.length[0] == math.inf
    assert motion.period == 0


def test_a_body_on_a_trough_that_falls_away_leaves_it_at_once() -> None:
    course = course_of(loads_of(at_load(6.0, 20.0, 0.74, 0.57)), np.zeros(1))
    assert starting(course, np.array([0.5 * math.pi]), np.zeros(1)).mode[0] == Mode.FLIGHT
    assert starting(course, np.zeros(1), np.zeros(1)).mode[0] == Mode.REST


def test_a_start_phase_is_reduced() -> None:
    course = course_of(loads_of(at_load(2.0, 20.0, 0.74, 0.57)), np.zeros(1))
    early, late = (follow(course, phase, 0.5, 40.0) for phase in (1.0, 1.0 - TURN))
    np.testing.assert_allclose(early.transient.phase, late.transient.phase, rtol=0.0, atol=1e-14)
    assert early.transient.cycle[0] == late.transient.cycle[0] == 0
