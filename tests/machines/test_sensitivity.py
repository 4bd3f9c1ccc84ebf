"""Sensitivities of speeds, against differences of operating points."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import vibro
from vibro import Calibration, Machine
from vibro.machines.sensitivity import Sensitivities, sensitivities

STEP = 1e-4
SLIDER: dict[str, Any] = {
    "frequency": 50.0,
    "drive_angle": math.radians(20.0),
    "static_friction": 0.35,
    "kinetic_friction": 0.28,
}


def feeder(ratio: float, counter_mass: float = 12.0) -> Machine:
    return Machine.magnet(
        trough_mass=6.0,
        counter_mass=counter_mass,
        natural_frequency=50.0 / ratio,
        damping_ratio=0.015,
        calibration=Calibration(0.35e-3, 50.0),
    )


def _speed(machine: Machine, **changes: float) -> float:
    points = vibro.operate(machine, **{**SLIDER, **changes})
    return float(vibro.solve(points.scene).mean_velocity)


@pytest.mark.parametrize("ratio", [0.9, 1.05, 1.1])
@pytest.mark.parametrize(
    ("filling", "setting", "close"), [(0.0, 0.7, 1e-5), (2.0, 0.6, 1e-5), (1.0, 1.0, 1e-3)]
)
def test_sensitivities_are_differences_of_operating_points(
    ratio: float, filling: float, setting: float, close: float
) -> None:
    """In contact exact; where bodies hop, which they do at 100 %, within their differences over 1 %."""
    machine = feeder(ratio)
    nominal = {"frequency": 50.0, "setting": setting, "voltage": 1.0, "filling": filling}
    found = sensitivities(vibro.operate(machine, **{**SLIDER, **nominal}))
    for name, value in nominal.items():
        ends = [_speed(machine, **{**nominal, name: value * math.exp(x)}) for x in (-STEP, STEP)]
        right = math.log(ends[1] / ends[0]) / (2.0 * STEP)
        assert getattr(found, name) == pytest.approx(right, rel=close, abs=close), name
    springs, zeta = machine.natural_frequency, machine.damping_ratio  # the damper held, its ratio falls
    ends = [
        _speed(
            machine.with_natural_frequency(springs * math.exp(x / 2))._changed(
                damping_ratio=zeta * math.exp(-x / 2)
            ),
            **nominal,
        )
        for x in (-STEP, STEP)
    ]
    assert found.stiffness == pytest.approx(math.log(ends[1] / ends[0]) / (2.0 * STEP), rel=close)


def test_the_filling_answers_back() -> None:
    """With shares that follow the amplitude the mains count for another amount than with shares held."""
    points = vibro.operate(feeder(1.05), filling=2.0, **SLIDER)
    held = vibro.operate(
        feeder(1.05),
        filling=2.0,
        added_mass_share=points.added_mass_share,
        added_damping_share=points.added_damping_share,
        **SLIDER,
    )
    assert held.amplitude == pytest.approx(points.amplitude, rel=1e-12)
    computed, given = sensitivities(points), sensitivities(held)
    assert given.voltage == pytest.approx(2.0 * given.amplitude, rel=1e-12)
    assert abs(computed.voltage / given.voltage - 1.0) > 0.1


def test_arrays_and_cases_without_a_slope() -> None:
    points = vibro.operate(feeder(1.05), filling=[0.0, 2.0, 2.0], setting=[1.0, 1.0, 0.05], **SLIDER)
    found = sensitivities(points)
    assert isinstance(found, Sensitivities)
    one = sensitivities(vibro.operate(feeder(1.05), filling=2.0, **SLIDER))
    assert found.voltage[1] == pytest.approx(one.voltage, rel=1e-12)
    assert list(np.isnan(found.voltage)) == [False, False, True]  # at rest
    crank = sensitivities(vibro.operate(Machine.crank(radius=0.3e-3), filling=2.0, **SLIDER))
    assert crank.filling == 0.0
    assert crank.setting == crank.amplitude


@pytest.mark.parametrize("counter_mass", [12.0, math.inf])
def test_the_mass_that_brings_resonance(counter_mass: float) -> None:
    machine = feeder(0.9, counter_mass)
    mass = machine.mass_to_resonance(50.0)
    assert machine.response(50.0, added_mass=mass).filled_natural_frequency == pytest.approx(50.0, rel=1e-14)
    above = feeder(1.05, counter_mass).mass_to_resonance(50.0)
    assert above < 0.0
    filled = feeder(1.05, counter_mass).response(50.0, added_mass=above).filled_natural_frequency
    assert filled == pytest.approx(50.0, rel=1e-14)
    proof = machine.mass_to_resonance(50.0, natural_frequency=[60.0, 90.0])
    assert (proof[1] == math.inf) == (counter_mass == 12.0)  # beyond the load-proof pack no mass is enough
    assert Machine.crank(radius=1e-3).mass_to_resonance(5.0) == math.inf
