"""Steady cycles of steps and of samples: a walk of uniform accelerations, and harmonics."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from engines.steps_walk import Drive, displacement

from vibro import Motion, Scene, Status, solve

REST: dict[str, Any] = {"frequency": 2.5, "static_friction": 0.3, "kinetic_friction": 0.25}
GRAVITY = 9.81


def random_steps(seed: int, count: int) -> Any:
    rng = np.random.default_rng(seed)
    for _ in range(count):
        size = int(rng.integers(2, 7))
        shares = rng.dirichlet(np.ones(size))
        sizes = rng.uniform(1.0, 9.0), rng.choice([0.0, 2.0, 15.0])
        along, normal = (a - (shares * a).sum() for a in rng.normal(0.0, sizes, (size, 2)).T)
        mu_s = rng.uniform(0.1, 0.7)
        mu_d = mu_s * rng.uniform(0.3, 1.0)
        angle = math.atan(mu_d) * rng.uniform(-0.6, 0.6) * rng.integers(0, 2)
        yield shares, along, normal, mu_s, mu_d, angle, rng.uniform(1.0, 30.0)


def test_random_steps_agree_with_a_walk_of_uniform_accelerations() -> None:
    """In contact and with flights."""
    compared, slid, hopped = 0, 0, 0
    for shares, along, normal, mu_s, mu_d, angle, frequency in random_steps(4, 150):
        weights = GRAVITY * math.cos(angle), GRAVITY * math.sin(angle)
        levels = [(float(s), float(a), float(n)) for s, a, n in zip(shares, along, normal, strict=True)]
        walked = displacement(Drive(levels, mu_s, mu_d, *weights, 1.0 / frequency))
        motion = Motion.steps(list(zip(shares, along, strict=True)), list(zip(shares, normal, strict=True)))
        scene = Scene(
            motion=motion,
            frequency=frequency,
            static_friction=mu_s,
            kinetic_friction=mu_d,
            trough_angle=angle,
        )
        cycle = solve(scene)
        if math.isnan(walked) or cycle.status != Status.OK:
            continue
        size = abs(walked) + float(scene.scale)
        assert abs(cycle.displacement_per_cycle - walked) <= 1e-12 * size
        compared += 1
        slid += walked != 0.0
        hopped += "H" in str(cycle.pattern)
    assert compared >= 100
    assert slid >= 70
    assert hopped >= 10


def test_a_clamped_part_climbs_a_vertical_trough() -> None:
    """Its friction is mu N; gravity pulls it down: the walk has the same numbers."""
    normal = 40.0
    motion = Motion.steps([(0.8, 1.5), (0.2, -6.0)])
    given: dict[str, Any] = {"motion_scale": 1.5, "normal_acceleration": normal, "trough_angle": math.pi / 2}
    cycle = solve(Scene(motion=motion, **(REST | given | {"frequency": 5.0})))
    walked = displacement(Drive([(0.8, 2.25, 0.0), (0.2, -9.0, 0.0)], 0.3, 0.25, normal, GRAVITY, 0.2))
    assert cycle.displacement_per_cycle == pytest.approx(walked, rel=1e-12)
    assert cycle.throw_number == 0.0
    assert cycle.status == Status.OK


def test_samples_convey_as_the_harmonics_that_they_are_of() -> None:
    pairs = [(20e-3, 0.0), (5e-3, -1.92), (1e-3, 0.7)]
    share = np.arange(512) / 512
    w = 2.0 * math.pi * REST["frequency"]
    waves = [size * np.sin(2.0 * np.pi * k * share + phase) for k, (size, phase) in enumerate(pairs, 1)]
    accelerations = -sum((k * w) ** 2 * wave for k, wave in enumerate(waves, 1))
    expected = float(solve(Scene(along_harmonics=pairs, **REST)).mean_velocity)
    splined = solve(Scene(motion=Motion.samples(accelerations), **REST))
    assert splined.mean_velocity == pytest.approx(expected, rel=1e-6)
    heard = solve(Scene(motion=Motion.samples(sum(waves), of="displacement"), **REST))
    assert heard.mean_velocity == pytest.approx(expected, rel=1e-11)
