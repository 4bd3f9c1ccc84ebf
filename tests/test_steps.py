"""Steady cycles of steps and of samples: closed forms, a walk of uniform accelerations, and harmonics."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from engines.steps_walk import Drive, displacement

from vibro import Motion, Scene, Status, solve

REST: dict[str, Any] = {"frequency": 2.5, "static_friction": 0.3, "kinetic_friction": 0.25}
GRAVITY = 9.81


def slip_stick(scale: Any = 1.0) -> Scene:
    return Scene(motion=Motion.steps([(0.8, 2.4), (0.2, -9.6)]), motion_scale=scale, **REST)


@pytest.mark.parametrize("mu_s", [2.4 / GRAVITY, 9.6 / GRAVITY])
def test_thresholds_of_two_levels(mu_s: float) -> None:
    """Just below, and just above, the static friction that a step reaches."""
    below, above = (
        solve(
            Scene(
                motion=Motion.steps([(0.8, 2.4), (0.2, -9.6)]),
                **(REST | {"static_friction": mu, "kinetic_friction": 0.2}),
            )
        )
        for mu in (mu_s * (1.0 - 1e-12), mu_s * (1.0 + 1e-12))
    )
    ratio = "back_ratio" if mu_s < 0.5 else "forward_ratio"
    assert getattr(below, ratio) > 1.0 > getattr(above, ratio)
    assert getattr(below, ratio) == pytest.approx(1.0, rel=2e-12)


def test_a_body_that_never_rests_takes_no_notice_of_the_scale() -> None:
    """Friction is the same either way, and its mean is zero: it slides each way for half of the period."""
    cycle = solve(slip_stick([1.5, 3.0]))
    assert cycle.pattern.tolist() == ["FB", "FB"]
    assert cycle.mean_velocity[0] == pytest.approx(float(cycle.mean_velocity[1]), rel=1e-13)
    assert cycle.mean_velocity[0] == pytest.approx(two_levels_without_rest(), rel=1e-13)


def two_levels_without_rest() -> float:
    found = displacement(Drive([(0.8, 7.2, 0.0), (0.2, -28.8, 0.0)], 0.3, 0.25, GRAVITY, 0.0, 0.4))
    return found / 0.4


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


def test_steps_off_the_trough_make_a_body_hop() -> None:
    """Thrown up at c times gravity less for 1/4 of the period, and it lands before the next throw."""
    hop = Scene(motion=Motion.steps([(0.75, 2.0), (0.25, -6.0)], [(0.75, 4.0), (0.25, -12.0)]), **REST)
    cycle = solve(hop)
    assert cycle.throw_number == pytest.approx(12.0 / GRAVITY, rel=1e-14)
    assert cycle.status == Status.OK
    # falls freely for T/4 while the trough falls faster, and until the trough, then slower, meets it
    gap, speed = 0.5 * (12.0 - GRAVITY) * 0.1**2, (12.0 - GRAVITY) * 0.1
    down = 4.0 + GRAVITY
    flight = 0.1 + (speed + math.sqrt(speed**2 + 2.0 * down * gap)) / down
    assert cycle.flight_fraction == pytest.approx(flight / 0.4, rel=1e-12)
