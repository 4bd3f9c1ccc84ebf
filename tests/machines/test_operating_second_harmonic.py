"""Speeds with the trough's second harmonic, against trough and body followed together in time."""

from __future__ import annotations

import cmath
import math
from typing import Any

import numpy as np
import pytest
from helpers.two_way_machines import Case, drawn

import vibro
from vibro import Calibration, Machine

SLIDER: dict[str, Any] = {
    "drive_angle": math.radians(20.0),
    "static_friction": 0.35,
    "kinetic_friction": 0.28,
}


def worked(ratio: float) -> Case:
    """Make the worked feeder of docs/theory with 4 kg in its trough."""
    machine = Machine.magnet(
        trough_mass=6.0,
        counter_mass=12.0,
        natural_frequency=50.0 / ratio,
        damping_ratio=0.015,
        calibration=Calibration(0.35e-3, 50.0),
    )
    return Case(f"worked {ratio}", machine, 50.0, 4.0, SLIDER)


CASES = [*(case for case in drawn(10, seed=33) if case.share > 0.05 and case.machine.kind == "unbalance"),
         worked(0.95), worked(1.05)]  # fmt: skip


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_the_second_harmonic_explains_most_of_the_error_of_the_speed(case: Case) -> None:
    points, motion = case.operate(), case.followed()
    sine = motion.speed / vibro.solve(points.scene).mean_velocity - 1.0
    bent = motion.speed / points.speed_with_second_harmonic() - 1.0
    assert abs(bent) < 0.045
    if abs(sine) > 0.05:
        assert abs(bent) < 0.35 * abs(sine)
    # where the first harmonic is a sine of p, the second one is the imaginary part of this times e^(2ip)
    phasor = -1j * motion.second * cmath.exp(-2j * cmath.phase(motion.amplitude)) / abs(motion.amplitude)
    assert abs(phasor / points.second_phasor - 1.0) < 0.1
    assert abs(cmath.phase(phasor / points.second_phasor)) < 0.02


def test_the_scene_moves_along_the_line_of_the_drive() -> None:
    points = vibro.operate(worked(1.05).machine, frequency=50.0, filling=[0.0, 2.0], **SLIDER)
    scene = points.scene_with_second_harmonic
    assert scene.along_harmonics is not None
    assert scene.normal_harmonics is not None
    for (along, shift), (normal, same) in zip(scene.along_harmonics, scene.normal_harmonics, strict=True):
        assert np.allclose(normal, along * math.tan(math.radians(20.0)), rtol=1e-14)
        assert np.array_equal(shift, same)
    (first, _), (second, phase) = scene.along_harmonics
    assert np.allclose(first, points.amplitude * math.cos(math.radians(20.0)), rtol=1e-14)
    assert np.allclose(second / first, points.second_harmonic, rtol=1e-13)
    assert phase[1] == np.angle(points.second_phasor[1])
    speed = points.speed_with_second_harmonic()
    assert speed[0] == pytest.approx(vibro.solve(points.scene).mean_velocity[0], rel=1e-10)
    assert speed[1] > 1.05 * vibro.solve(points.scene).mean_velocity[1]


def test_without_an_amplitude_there_is_no_speed() -> None:
    machine = worked(0.9).machine
    points = vibro.operate(machine, frequency=50.0, filling=1.0, trough_angle=math.radians(-25.0), **SLIDER)
    assert np.isnan(points.speed_with_second_harmonic())
