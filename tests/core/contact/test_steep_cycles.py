"""Elliptical drives on troughs as steep as kinetic friction holds, beside the solver for harmonics."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import vibro

GAPS = (0.0, 2.0**-53, 2.0**-52, 1e-12, 1e-9, 4e-9, 1e-8, 1e-7, 1e-4, 1e-2)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_cycles_beside_the_angle_of_kinetic_friction_are_those_of_one_harmonic(way: float) -> None:
    random = np.random.default_rng(47)
    mu_d = random.uniform(0.05, 0.8, (300, 1))
    normal, phase = 3e-4 * random.uniform(0.1, 1.0, (300, 1)), random.uniform(-math.pi, math.pi, (300, 1))
    along = mu_d * 4e-4 * 10.0 ** random.uniform(-0.5, 1.0, (300, 1))
    others: dict[str, Any] = {
        "frequency": 25.0,
        "static_friction": 1.25 * mu_d,
        "kinetic_friction": mu_d,
        "trough_angle": way * np.arctan(mu_d * (1.0 - np.array(GAPS))),
    }
    pair = vibro.Scene(along_amplitude=along, normal_amplitude=normal, normal_phase=phase, **others)
    ours = vibro.solve(pair)
    other = vibro.solve(
        vibro.Scene(along_harmonics=[(along, 0.0)], normal_harmonics=[(normal, phase)], **others)
    )
    both = (ours.status == vibro.Status.OK) & (other.status == vibro.Status.OK)
    assert np.count_nonzero(both) > 0.9 * both.size
    assert np.all(ours.pattern[both] == other.pattern[both])
    apart = np.abs(ours.displacement_per_cycle - other.displacement_per_cycle) / np.maximum(along, normal)
    assert np.max(apart[both]) < 1e-11
    assert {"FB", "FB_" if way < 0.0 else "F_B"} <= set(ours.pattern[both].tolist())


def test_a_scene_of_round_numbers() -> None:
    scene = vibro.Scene(
        along_amplitude=1e-3,
        normal_amplitude=3e-4,
        normal_phase=math.radians(-60.0),
        frequency=25.0,
        static_friction=0.4,
        kinetic_friction=0.25,
        trough_angle=math.atan(0.25 * (1.0 - 1e-9)),
    )
    cycle = vibro.solve(scene)
    assert cycle.pattern == "B_"
    assert cycle.displacement_per_cycle == pytest.approx(-6.06029e-3, rel=1e-6)
