"""Scenes whose drive is a ``Motion``: one kind of drive either way, its scale, and clamped bodies."""

from __future__ import annotations

import dataclasses
import math
import pickle
from typing import Any

import numpy as np
import pytest

from vibro import Motion, Scene, solve
from vibro.drives import Harmonics, Piecewise

REST: dict[str, Any] = {"frequency": 10.0, "static_friction": 0.4, "kinetic_friction": 0.3}
PAIRS: list[tuple[Any, Any]] = [(1e-3, 0.0), (0.3e-3, math.radians(90.0))]
STEPS = Motion.steps(along=[(0.8, 6.9), (0.2, -27.6)])


def test_harmonics_mean_the_same_either_way() -> None:
    normal = [(1e-4, [0.0, 0.5])]
    short = Scene(along_harmonics=PAIRS, normal_harmonics=normal, **REST)
    long = Scene(motion=Motion.harmonics(PAIRS, normal), **REST)
    assert type(short.motion) is type(long.motion)
    assert short.along_harmonics == long.along_harmonics
    for (name, _, a), (same, _, b) in zip(short.arrays().members(), long.arrays().members(), strict=True):
        assert name == same
        np.testing.assert_array_equal(a, b)
    assert np.array_equal(solve(short).mean_velocity, solve(long).mean_velocity)
    assert Scene(motion=STEPS, **REST).along_harmonics is None


def test_a_scale_multiplies_all_amplitudes() -> None:
    pairs = [(2.5 * size, phase) for size, phase in PAIRS]
    one = Scene(along_harmonics=pairs, **REST)
    other = Scene(along_harmonics=PAIRS, motion_scale=[1.0, 2.5], **REST)
    assert other.shape == (2,)
    for name in ("load", "reach", "scale"):
        assert getattr(other, name)[1] == pytest.approx(float(getattr(one, name)), rel=1e-15)
    assert other.arrays().stroke[1] == pytest.approx(float(one.arrays().stroke), rel=1e-14)
    a, b = solve(one), solve(other)
    assert b.pattern[1] == a.pattern
    assert b.displacement_per_cycle[1] == pytest.approx(float(a.displacement_per_cycle), rel=1e-13)


def test_accelerations_of_steps_stay_where_the_frequency_changes() -> None:
    scene = Scene(**(REST | {"motion": STEPS, "frequency": [5.0, 10.0], "motion_scale": [[1.0], [2.0]]}))
    drive = scene.arrays()
    assert isinstance(drive, Piecewise)
    assert scene.shape == (2, 2)
    np.testing.assert_allclose(scene.load, np.array([[1.0] * 2, [2.0] * 2]) * 27.6 / 9.81, rtol=1e-14)
    stroke = 6.9 * 0.8**2 / 8.0 + 27.6 * 0.2**2 / 8.0
    np.testing.assert_allclose(drive.stroke, stroke * np.array([[1, 0.25], [2, 0.5]]) / 25.0, rtol=1e-13)
    np.testing.assert_allclose(scene.scale * (2.0 * np.pi * scene.frequency) ** 2, [[27.6] * 2, [55.2] * 2])
    flat = scene.flat()
    assert isinstance(flat, Piecewise)
    assert flat.motion is STEPS
    assert flat.frequency.tolist() == [5.0, 10.0, 5.0, 10.0]
    slower: dict[str, Any] = {"frequency": 2.0}
    again = dataclasses.replace(scene, **slower)
    assert again.motion is STEPS
    assert pickle.loads(pickle.dumps(scene)).shape == (2, 2)


@pytest.mark.parametrize("count", [1, 2, 3, 8])
def test_the_stroke_of_harmonics_is_the_widest_pair_of_points(count: int) -> None:
    rng = np.random.default_rng(count)
    n = np.arange(1, count + 1)[:, np.newaxis, np.newaxis]
    size, phase = rng.uniform(0.0, 1e-3, (2, count, 6)) / n[:, 0], rng.uniform(-4.0, 4.0, (2, count, 6))
    size[1, :, :2] = 0.0  # along a line
    along, normal = (list(zip(*part, strict=True)) for part in zip(size, phase, strict=True))
    drive = Scene(along_harmonics=along, normal_harmonics=normal, **REST).arrays()
    assert isinstance(drive, Harmonics)
    waves = np.sin(n * np.linspace(0.0, 2.0 * np.pi, 1000)[:, np.newaxis] + phase[:, :, np.newaxis])
    x, y = (size[:, :, np.newaxis] * waves).sum(axis=1)
    widest = np.array(
        [np.hypot(a[:, np.newaxis] - a, b[:, np.newaxis] - b).max() for a, b in zip(x.T, y.T, strict=True)]
    )
    assert (drive.stroke >= widest * (1.0 - 1e-14)).all()
    np.testing.assert_allclose(drive.stroke, widest, rtol=4e-4)
    if count == 1:
        ellipse = Scene(
            along_amplitude=size[0, 0],
            normal_amplitude=size[1, 0],
            normal_phase=phase[1, 0] - phase[0, 0],
            **REST,
        )
        np.testing.assert_allclose(drive.stroke, ellipse.arrays().stroke, rtol=1e-14)
