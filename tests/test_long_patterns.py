"""Patterns of more letters than a code has room for: whole, told apart, and the same in all tables."""

from __future__ import annotations

import itertools
import math
import pickle
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import vibro
from vibro import Status
from vibro.core.bounces import BOUNCE
from vibro.core.codes import MOST_LETTERS, spelt_code
from vibro.core.timeline import turn_letters
from vibro.steady import scale_slope

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

FREQUENCY = 15.0


def alone(number: int, phase: float = 0.0, size: float = 0.5e-3, **more: Any) -> vibro.Scene:
    """Drive along the trough by one harmonic alone, by default forward and back between rests."""
    harmonics = [(0.0, 0.0)] * (number - 1) + [(size / number**2, phase)]
    given = {"along_harmonics": harmonics, "frequency": FREQUENCY, "static_friction": 0.3}
    return vibro.Scene(**{**given, "kinetic_friction": 0.25, **more})


def pulses(scale: ArrayLike, first: int = 0) -> vibro.Scene:
    """Push forward twenty times, at the end back if the motion is large; begin with one of the pulses."""
    steps = [*[(0.015, -5.0), (0.025, 2.2)] * 20, (0.1, 3.2), (0.1, 0.8)]
    motion = vibro.Motion.steps(along=steps[2 * first :] + steps[: 2 * first])
    return vibro.Scene(
        motion=motion, motion_scale=scale, frequency=FREQUENCY, static_friction=0.3, kinetic_friction=0.2
    )


def of_history(scene: vibro.Scene, cycles: float) -> str:
    """Return the letters of a cycle in which a body that is followed in time has settled; none if it has not.

    Off a trough that does not move along a sine a chain of short flights counts as one.
    """
    history = vibro.simulate(scene, cycles=cycles)
    phases = [p for p in history.phases if p.start >= history.settles_at - 1e-9][: len(history.pattern)]
    short = 0.0 if scene.motion is None and scene.along_harmonics is None else BOUNCE
    text = ""
    for i, phase in enumerate(phases):
        length = 2.0 * math.pi * FREQUENCY * (phase.end - phase.start)
        if not (phases[i - 1].kind == phase.kind == "H" and length < short):
            text += phase.kind
    return text


def is_turn(text: str, other: str) -> bool:
    return len(text) == len(other) and text in 2 * other


@pytest.mark.parametrize("number", [6, 7, 8, 16])
def test_a_harmonic_alone_repeats_the_pattern_of_the_first(number: int) -> None:
    cycle = vibro.solve(alone(number))
    assert cycle.status == Status.OK
    assert cycle.pattern == vibro.solve(alone(1)).pattern * number == "F_B_" * number
    assert is_turn(of_history(alone(number), 10.0), cycle.pattern)


def test_random_motions_are_those_of_bodies_followed_in_time() -> None:
    rng, seen = np.random.default_rng(18), {"contact": 0, "hops": 0}
    for _ in range(150):
        number, mu_s = int(rng.integers(8, 17)), rng.uniform(0.02, 0.4)
        sizes = rng.exponential(1e-3, (2, number)) / np.arange(1, number + 1) ** 2
        sizes[0, -1] *= 10.0
        sizes[1] *= rng.choice([0.0, 0.1, 1.0]) * (rng.random(number) < 0.3)
        phases = rng.uniform(0.0, 2.0 * math.pi, (2, number))
        along, normal = (
            list(zip(*x, strict=True)) for x in zip(sizes.tolist(), phases.tolist(), strict=True)
        )
        scene = vibro.Scene(
            along_harmonics=along, normal_harmonics=normal, motion_scale=rng.uniform(0.5, 3.0),
            frequency=FREQUENCY, static_friction=mu_s, kinetic_friction=mu_s * rng.uniform(0.5, 1.0),
        )  # fmt: skip
        cycle = vibro.solve(scene)
        if cycle.status != Status.OK or len(cycle.pattern) <= MOST_LETTERS:
            continue
        text = of_history(scene, 150.0)
        if text:
            assert is_turn(text, cycle.pattern)
            seen["hops" if "H" in text else "contact"] += 1
    assert min(seen.values()) >= 3, seen


def test_patterns_that_differ_behind_the_room_of_a_code_are_two() -> None:
    onset = 0.3 * 9.81 / 3.2
    cycle = vibro.solve(pulses(np.array([0.99, 1.01]) * onset))
    assert cycle.pattern.tolist() == ["F_" * 20, "F_" * 20 + "B_"]
    assert cycle.pattern_code[0] != cycle.pattern_code[1]
    # the slope is none where the pattern changes within its differences
    beside = pulses(np.array([0.99, 1.0 - 1e-4, 1.01]) * onset)
    assert np.isnan(scale_slope(beside, vibro.solve(beside))).tolist() == [False, True, False]


def test_a_pattern_does_not_depend_on_where_a_period_begins() -> None:
    codes = {int(vibro.solve(pulses(1.0, first)).pattern_code) for first in (0, 3, 20)}
    codes |= {spelt_code("F_" * 20 + "B")}
    assert len(codes) == 1
    phases = np.linspace(0.0, 6.0, 20)
    assert {int(vibro.solve(alone(8, x)).pattern_code) for x in phases} == {spelt_code("F_B_" * 8)}


@pytest.mark.parametrize("number", range(7))
def test_patterns_begin_where_their_letters_are_least(number: int) -> None:
    for letters in itertools.product((1, 2, 4), repeat=number):
        own = letters[:-1] if number > 1 and letters[0] == letters[-1] != 1 else letters
        turns = [own[i:] + own[:i] for i in range(len(own))]  # a rest that the cycle begins amid is one
        buffer = memoryview(bytearray(letters))
        assert (*buffer[: turn_letters(buffer, number)],) == min(turns, default=())


def test_texts_stay_with_their_cells() -> None:
    scales = np.geomspace(0.3, 2.0, 12).reshape(3, 4)
    cycle = vibro.solve(pulses(scales))
    each = [[str(vibro.solve(pulses(float(scale))).pattern) for scale in row] for row in scales]
    assert {"_", "F_" * 20, "F_" * 20 + "B"} <= {*cycle.pattern.flat}
    assert cycle.pattern.tolist() == each
    assert cycle.pattern[1, 2] == each[1][2]
    assert vibro.solve(pulses(scales), threads=1).pattern.tolist() == each
    again = pickle.loads(pickle.dumps(cycle))
    assert again.pattern.tolist() == each
    few = replace(cycle, **{name: x[1:, ::2] for name, x in cycle.arrays().items()})
    assert few.pattern.tolist() == [row[::2] for row in each[1:]]
