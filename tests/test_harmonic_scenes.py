"""Drives with harmonics as scenes: their fields, what is wrong with them, their load, what they refuse."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest

from vibro import Scene, Status, solve
from vibro.drives import HarmonicMotion, Harmonics
from vibro.quantities import MOST_HARMONICS

REST: dict[str, Any] = {"frequency": 10.0, "static_friction": 0.4, "kinetic_friction": 0.3}
SLIP_STICK = [(1e-3, 0.0), (0.3e-3, math.radians(90.0))]


def test_either_motion_may_be_left_out_or_have_fewer_harmonics() -> None:
    scene = Scene(along_harmonics=SLIP_STICK, **REST)
    assert scene.amplitude is scene.along_amplitude is None
    fields = scene.arrays()
    assert isinstance(fields, Harmonics)
    assert isinstance(fields.motion, HarmonicMotion)
    assert [float(x) for x in fields.motion.table[0]] == [1e-3, 0.3e-3]
    assert [float(x) for x in fields.motion.table[2]] == [0.0, 0.0]
    same = Scene(along_harmonics=SLIP_STICK, normal_harmonics=[(0.0, 0.5)], **REST)
    assert solve(same).displacement_per_cycle == solve(scene).displacement_per_cycle
    most = Scene(normal_harmonics=[(1e-4, 0.0)] * MOST_HARMONICS, **REST).flat()
    assert isinstance(most, Harmonics)
    assert isinstance(most.motion, HarmonicMotion)
    assert len(most.motion.along) == MOST_HARMONICS


def test_every_coefficient_broadcasts() -> None:
    second = np.radians([-90.0, 0.0, 90.0])
    harmonics: Any = [([[1e-3], [2e-3]], 0.0), (0.3e-3, second)]
    scene = Scene(along_harmonics=harmonics, **REST)
    cycle = solve(scene)
    assert scene.shape == scene.load.shape == cycle.regime.shape == (2, 3)
    assert (cycle.status == Status.OK).all()
    one = Scene(along_harmonics=[(2e-3, 0.0), (0.3e-3, second[2])], **REST)
    assert solve(one).displacement_per_cycle == cycle.displacement_per_cycle[1, 2]
    # the second harmonic turned by half a turn reverses a level drive without normal motion
    np.testing.assert_allclose(cycle.mean_velocity[:, 0], -cycle.mean_velocity[:, 2], rtol=1e-13)


def test_fields_are_replaced() -> None:
    scene = Scene(along_harmonics=SLIP_STICK, **REST)
    slower: dict[str, Any] = {"frequency": 5.0}
    again = dataclasses.replace(scene, **slower)
    assert float(again.load) == pytest.approx(float(scene.load) / 4.0, rel=1e-14)
    assert again.along_harmonics is not None
    with pytest.raises(ValueError, match="read-only"):
        again.along_harmonics[0][0][...] = 1.0
