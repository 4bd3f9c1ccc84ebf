"""What noise, sensors and the last harmonic make of the speed, against scenes made by hand."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from helpers.feeders import feeder
from helpers.made_records import trough_record

import vibro
from vibro.records.sensors import Mounting, SensorErrors
from vibro.records.trough import Motions, change_by_harmonics, hop_onset, motion_of, speeds_of

FRICTION = {"static_friction": 0.4, "kinetic_friction": 0.3}


def speed(drive: dict[str, Any]) -> float:
    return float(vibro.solve(vibro.Scene(**drive, **FRICTION)).mean_velocity)


def test_errors_of_sensors_are_those_of_scenes_made_by_hand() -> None:
    errors = SensorErrors(tilt=0.01, gain=0.02, cross=0.005, delay=2e-5)
    measured = motion_of(feeder(8).record(8), Mounting(errors))
    x, y, rate = measured.along, measured.normal, math.tau * measured.frequency

    def half(one: Any, other: Any) -> float:
        more, less = (speed(Motions(np.array(measured.frequency), *way).drive()) for way in (one, other))
        return 0.5 * (more - less)

    late = np.exp(1j * np.arange(1, 4) * rate * 2e-5)
    by_hand = {
        "gain": [half((1.02 * x, y), (0.98 * x, y)), half((x, 1.02 * y), (x, 0.98 * y))],
        "cross": [
            half((x + 0.005 * y, y), (x - 0.005 * y, y)),
            half((x, y + 0.005 * x), (x, y - 0.005 * x)),
        ],
        "tilt": [half((x - 0.01 * y, y + 0.01 * x), (x + 0.01 * y, y - 0.01 * x))],
        "delay": [half((x, y * late), (x, y / late))],
    }
    found = speeds_of(measured, FRICTION, draws=200)
    for kind, parts in by_hand.items():
        assert found.parts[kind] == pytest.approx(float(np.linalg.norm(parts)), rel=0.03), kind
    assert [*found.parts.values()] == sorted(found.parts.values(), reverse=True)
    # All together are the error of the speed, as draws give it.
    assert found.speed.error == pytest.approx(float(np.linalg.norm([*found.parts.values()])), rel=0.15)


def test_one_sensor_has_one_gain_and_the_error_of_its_line() -> None:
    errors = SensorErrors(tilt=0.0, gain=0.02, cross=0.0, angle=0.01)
    measured = motion_of(feeder(8).record(8, sensors=1), Mounting(errors), drive_angle=0.4)
    found = speeds_of(measured, FRICTION, draws=2).parts
    assert found.keys() == {"noise", "gain", "angle"}

    def scaled(along: float, angle: float = 0.4) -> float:
        x = along * measured.along
        return speed(Motions(np.array(measured.frequency), x, math.tan(angle) * x).drive())

    assert found["gain"] == pytest.approx(0.5 * abs(scaled(1.02) - scaled(0.98)), rel=1e-3)
    assert found["angle"] == pytest.approx(0.5 * abs(scaled(1.0, 0.41) - scaled(1.0, 0.39)), rel=1e-9)
    sizes = measured.drawn(2000)
    slopes = abs(sizes.normal[0] / sizes.along[0])
    assert np.std(np.arctan(slopes)) == pytest.approx(0.01, rel=0.06)
    assert np.std(abs(sizes.along[0])) / abs(measured.along[0]) == pytest.approx(0.02, rel=0.06)


def test_the_throw_number_needs_no_friction() -> None:
    measured = motion_of(trough_record(noise=0.05, cycles=40.0))
    throw = hop_onset(measured, {}).throw_number
    exact = 1.02e-3 * math.sin(math.radians(20.5)) * (math.tau * 15.003) ** 2 / 9.81
    assert abs(throw.value - exact) < 3.0 * throw.error < 0.01 * exact
    light = hop_onset(measured, {"gravity": 9.81 / 2.0}).throw_number
    assert light.value == pytest.approx(2.0 * throw.value)
    feeding = motion_of(feeder(8).record(8))
    cycle = vibro.solve(vibro.Scene(**feeding.drive(), **FRICTION))
    assert hop_onset(feeding, {}).throw_number.value == pytest.approx(float(cycle.throw_number))


def test_parts_begin_to_hop_at_the_amplitude_that_is_told() -> None:
    """Just above it and not just below; of a line it has no error from the amplitude of today."""
    line = motion_of(trough_record(noise=0.05, cycles=40.0))
    throw, growth, amplitudes, parts = hop_onset(line, {})
    assert throw.error == pytest.approx(parts["noise"], rel=0.15)
    exact = 9.81 / (math.sin(math.radians(20.5)) * (math.tau * 15.003) ** 2)
    assert growth.value == pytest.approx(1.0 / throw.value)
    assert growth.error == pytest.approx(throw.error / throw.value**2, rel=0.05)
    assert amplitudes.keys() == {"amplitude"}
    assert abs(amplitudes["amplitude"].value - exact) < 3.0 * amplitudes["amplitude"].error < 0.01 * exact

    three = motion_of(feeder(8).record(8))
    onset = hop_onset(three, {})
    for factor, regime in ((1.001, vibro.Regime.HOPPING), (0.999, vibro.Regime.FORWARD_SLIP)):
        size = factor * onset.growth.value
        grown = replace(three.motion, along=size * three.along, normal=size * three.normal)
        hops = vibro.solve(vibro.Scene(**grown.drive(), **FRICTION)).regime == vibro.Regime.HOPPING
        assert hops == (regime is vibro.Regime.HOPPING)
    along = motion_of(trough_record(columns=("trough_along",), noise=0.05), drive_angle=0.0)
    assert hop_onset(along, {}) == ((0.0, 0.0), (math.inf, 0.0), {}, {"noise": 0.0})


def test_the_change_by_harmonics_is_relative_to_the_fundamental_alone() -> None:
    measured = motion_of(feeder(3).record(3))
    alone = speed(measured.motion.up_to(1).drive())
    assert change_by_harmonics(measured, FRICTION) == pytest.approx(speed(measured.drive()) / alone - 1.0)
    assert change_by_harmonics(measured, {**FRICTION, "gravity": 1e3}) == 0.0  # it rests with either
    onset = 1.0 / float(
        vibro.solve(vibro.Scene(**measured.motion.up_to(1).drive(), **FRICTION)).forward_ratio
    )
    weak = replace(measured, accelerations=0.999 * onset * measured.accelerations)
    assert change_by_harmonics(weak, FRICTION) == math.inf  # the fundamental alone conveys nothing
