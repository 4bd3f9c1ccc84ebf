"""Machines and their filling, against Newton's law for trough and body at once (tests/engines/two_way.py)."""

from __future__ import annotations

import cmath
import math
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import pytest
from engines import two_way
from helpers.cases import each
from helpers.two_way_machines import Case, drawn

import vibro

TURN = 2.0 * math.pi
FEEDER: dict[str, Any] = {"frequency": 50.0, "trough_mass": 6.0, "counter_mass": 12.0, "stiffness": 4e5}

# --- the engine: where phasors suffice ------------------------------------------------------------------


@pytest.mark.parametrize(
    "more",
    [
        {"force_on_trough": 8.0, "force_on_counter_mass": -8.0},
        {"force_on_trough": 8.0, "force_on_counter_mass": -8.0, "base_stiffness": 3e5},
        {"force_on_counter_mass": 15.0},
        {"force_on_trough": 8.0, "counter_mass": math.inf},
    ],
    ids=["magnet", "mounted", "exciter", "floor"],
)
def test_a_body_that_sticks_is_mass_of_the_trough(more: dict[str, float]) -> None:
    machine = two_way.Machine(**{**FEEDER, "damping": 600.0, **more})
    body = two_way.Body(mass=2.0, drive_angle=0.3, static_friction=5.0, kinetic_friction=5.0)
    w = TURN * machine.frequency
    kappa = machine.stiffness + 1j * w * machine.damping
    masses = [machine.trough_mass + body.mass, machine.counter_mass]
    forces = [machine.force_on_trough, machine.force_on_counter_mass]
    matrix = np.array([[kappa, -kappa], [-kappa, kappa + machine.base_stiffness]]) - w * w * np.diag(masses)
    if math.isinf(machine.counter_mass):
        matrix, forces = matrix[:1, :1], forces[:1]
    motion = np.append(np.linalg.solve(matrix, forces), 0.0)
    found = two_way.follow(machine, body)
    assert found.turns > 0
    assert found.amplitude == pytest.approx(motion[0], rel=1e-9)
    assert found.relative == pytest.approx(motion[0] - motion[1], rel=1e-9)
    assert abs(found.second) < 1e-12 * abs(found.amplitude)
    assert found.speed == 0.0


# --- the force of a filling on a trough that moves as prescribed ----------------------------------------


def random_scenes(count: int, seed: int) -> list[dict[str, float]]:
    """Draw scenes from rest to throws beyond a period, on troughs that climb or fall."""
    random = np.random.default_rng(seed)
    drawn = []
    for _ in range(count):
        frequency, throw, angle = random.uniform(10, 100), random.uniform(0.2, 3.1), random.uniform(0.1, 1.0)
        trough = random.choice([0.0, random.uniform(-0.1, 0.1)])
        friction = random.uniform(0.1, 1.0)
        drawn.append(
            {
                "amplitude": throw * 9.81 * math.cos(trough) / math.sin(angle) / (TURN * frequency) ** 2,
                "frequency": frequency,
                "drive_angle": angle,
                "static_friction": friction,
                "kinetic_friction": friction * random.choice([1.0, random.uniform(0.5, 1.0)]),
                "trough_angle": trough,
            }
        )
    return drawn


BOUNCING = [
    {
        "amplitude": throw * 9.81 / math.sin(0.5) / (TURN * 25.0) ** 2,
        "frequency": 25.0,
        "drive_angle": 0.5,
        "static_friction": 0.5,
        "kinetic_friction": 0.4,
        "restitution": restitution,
    }
    for throw, restitution in ((1.2, 0.2), (1.5, 0.3), (2.2, 0.1), (2.9, 0.05))
]


def reaction_of(given: dict[str, float]) -> two_way.Reaction:
    """Follow a body on a trough that moves as a scene says."""
    bodys = {name: value for name, value in given.items() if name not in ("amplitude", "frequency")}
    return two_way.react(given["amplitude"], given["frequency"], two_way.Body(mass=1.0, **bodys))


@each("drawn", [*random_scenes(20, seed=1), *BOUNCING])
def test_a_filling_weighs_what_its_force_says(drawn: dict[str, float]) -> None:
    scene = vibro.Scene(**drawn)
    found, walked = vibro.filling(scene), reaction_of(drawn)
    assert walked.turns > 0
    assert found.share == pytest.approx(walked.share, abs=1e-10)
    assert found.second_harmonic == pytest.approx(walked.second, abs=1e-10)
    squared_speed = (drawn["amplitude"] * TURN * drawn["frequency"]) ** 2
    # each loss from its own law: friction, impacts, climb
    assert found.energy_per_cycle == pytest.approx(walked.energy, abs=1e-10 * squared_speed)
    assert abs(walked.share) <= found.bound
    assert vibro.solve(scene).mean_velocity == pytest.approx(
        walked.speed, abs=1e-10 * math.sqrt(squared_speed)
    )


# --- machine and filling together -----------------------------------------------------------------------

CASES = [case for case in drawn(10, seed=33) if case.share > 0.05][:7]


class Off(NamedTuple):
    """What the engine finds over what ``vibro.operate`` does, - 1; sizes of the second harmonic."""

    amplitude: float
    speed: float
    second: float
    points: vibro.OperatingPoints
    motion: two_way.Motion


def off(case: Case) -> Off:
    points, motion = case.operate(), case.followed()
    assert motion.turns > 0
    assert points.number == 1
    speed = float(vibro.solve(points.scene).mean_velocity)
    size = abs(motion.amplitude)
    second = abs(motion.second) / size / float(points.second_harmonic)
    return Off(size / float(points.amplitude) - 1.0, motion.speed / speed - 1.0, second - 1.0, points, motion)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_a_full_machine_does_what_trough_and_body_do_together(case: Case) -> None:
    """The motion is no sine: its second harmonic is the filling's, and changes the speed most."""
    found = off(case)
    assert abs(found.amplitude) < 0.018
    assert -0.08 < found.speed < 0.15
    assert abs(found.second) < 0.1
    assert cmath.phase(found.motion.amplitude) == pytest.approx(float(found.points.phase), abs=0.02)
    assert abs(found.motion.relative) == pytest.approx(float(found.points.relative_amplitude), rel=0.018)


@pytest.mark.parametrize("case", CASES[::3], ids=lambda case: case.name)
def test_the_difference_goes_with_the_filling(case: Case) -> None:
    """Of the amplitude with its square, as the first harmonic of the filling's force is exact."""
    some, few = (off(replace(case, filling=share * case.machine.trough_mass)) for share in (0.01, 0.0025))
    assert abs(some.amplitude) < 5e-6
    assert abs(some.speed) < 4e-3
    assert some.amplitude / few.amplitude == pytest.approx(16.0, rel=0.2)
    assert some.speed / few.speed == pytest.approx(4.0, rel=0.2)
    assert some.second / few.second == pytest.approx(4.0, rel=0.1)
    assert cmath.phase(some.motion.amplitude) == pytest.approx(float(some.points.phase), abs=1e-4)
    assert abs(some.motion.relative) == pytest.approx(float(some.points.relative_amplitude), rel=1e-5)


def test_the_machines_are_of_all_kinds_and_both_sides_of_resonance() -> None:
    assert {case.machine.kind for case in CASES} == {"magnet", "exciter", "unbalance"}
    ratios = [case.frequency / case.machine.natural_frequency for case in CASES]
    assert {ratio > 1.0 for ratio in ratios if ratio < 1.2} == {True, False}
    assert {bool("H" in str(vibro.solve(case.operate().scene).pattern)) for case in CASES} == {
        True,
        False,
    }
