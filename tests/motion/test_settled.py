"""Bodies from rest on any periodic motion: histories end in the cycle that ``solve`` gives."""

from __future__ import annotations

import math

import numpy as np
import pytest

import vibro
from vibro import Motion, Scene, Status
from vibro.errors import VibroError
from vibro.motion.settled import cycle_phases, settled_motion

GRAVITY = 9.81
FRICTION = {"static_friction": 0.4, "kinetic_friction": 0.3}
ALONG = [(1e-3, 0.0), (0.3e-3, 1.57)]

MOTIONS = {
    "contact": (Motion.harmonics(ALONG, [(0.2e-3, 0.5)]), 15.0, 0.0, "FBF_"),
    "hops": (Motion.harmonics(ALONG, [(0.6e-3, 0.5), (0.1e-3, 0.0)]), 25.0, 0.0, "HFB"),
    "bounces": (Motion.harmonics(ALONG, [(0.6e-3, 0.5), (0.1e-3, 0.0)]), 25.0, 0.3, "HHHB"),
    "steps": (Motion.steps([(0.8, 3.5), (0.2, -14.0)]), 5.0, 0.0, "F_"),
    "steps that throw": (
        Motion.steps([(0.8, 3.5), (0.2, -14.0)], [(0.5, 11.0), (0.5, -11.0)]), 5.0, 0.0, "HF_",
    ),
    "samples": (
        Motion.samples([6.0 * math.sin(p) + 2.0 * math.cos(2.0 * p) for p in np.arange(32) * math.tau / 32]),
        8.0, 0.0, "FB_",
    ),
    "rest": (Motion.steps([(0.5, 1.0), (0.5, -1.0)]), 5.0, 0.0, "_"),
}  # fmt: skip


def scene_of(name: str) -> Scene:
    motion, frequency, restitution, _ = MOTIONS[name]
    return Scene(motion=motion, frequency=frequency, restitution=restitution, **FRICTION)


@pytest.mark.parametrize("name", MOTIONS)
def test_phases_make_up_the_cycle_in_the_order_of_its_pattern(name: str) -> None:
    scene, pattern = scene_of(name), MOTIONS[name][3]
    cycle, phases = vibro.solve(scene), cycle_phases(scene)
    assert str(cycle.pattern) == pattern
    kinds = "".join(phase.kind for phase in phases)
    if name == "bounces":  # a pattern has a chain of short flights as one
        assert kinds == "HHHHHhB"
    else:
        assert kinds == pattern
    size, period = float(scene.scale), 1.0 / float(scene.frequency)
    assert 0.0 <= phases[0].start < period
    assert [p.start for p in phases[1:]] == pytest.approx([p.end for p in phases[:-1]], abs=1e-12 * period)
    assert phases[-1].end - phases[0].start == pytest.approx(period, rel=1e-12)
    moved = math.fsum(phase.displacement for phase in phases)
    assert moved == pytest.approx(float(cycle.displacement_per_cycle), abs=1e-12 * size)


@pytest.mark.parametrize("name", MOTIONS)
def test_a_settled_motion_repeats_and_advances_as_solved(name: str) -> None:
    scene = scene_of(name)
    motion, size = settled_motion(scene), float(scene.scale)
    assert motion.advance == float(vibro.solve(scene).displacement_per_cycle)
    times = np.linspace(0.0, motion.period, 41)
    first, later = motion.sample(times), motion.sample(times + 3.0 * motion.period)
    np.testing.assert_allclose(later.position - first.position, 3.0 * motion.advance, atol=1e-9 * size)
    ends = motion.sample(np.array([p.start for p in cycle_phases(scene)]))
    # flights begin and end slides with a speed, rests do not
    if name in ("contact", "steps", "samples"):
        np.testing.assert_allclose(ends.velocity, 0.0, atol=1e-9 * size / motion.period)


def test_bodies_that_run_away_have_no_cycle() -> None:
    along = Motion.harmonics(ALONG)
    scene = Scene(motion=along, frequency=25.0, normal_acceleration=20.0, trough_angle=1.2, **FRICTION)
    assert vibro.solve(scene).status == Status.RUNAWAY
    assert cycle_phases(scene) == ()
    with pytest.raises(VibroError, match="no steady motion"):
        settled_motion(scene)


def waves_aloft(count: int, seed: int) -> list[Scene]:
    """Draw scenes whose trough cannot bear the body at phase 0, harmonics and steps in turn."""
    rng, scenes = np.random.default_rng(seed), list[Scene]()
    while len(scenes) < count:
        mu_s, w = rng.uniform(0.1, 0.8), math.tau * rng.uniform(10.0, 40.0)
        mu_d = mu_s * rng.uniform(0.4, 1.0)
        beta = math.atan(mu_d) * rng.uniform(-0.6, 0.6) * (rng.random() < 0.5)
        throw, weight = rng.uniform(1.05, 2.8), GRAVITY * math.cos(beta)
        parts = int(rng.integers(2, 5))
        if len(scenes) % 2:
            shares = rng.dirichlet(np.full(parts, 3.0))
            along, normal = rng.normal(size=(2, parts))
            along, normal = along - shares @ along, normal - shares @ normal
            along *= 1.5 * GRAVITY / np.abs(along).max()
            normal *= -throw * weight / normal.min()
            leaves = normal[0] < -weight
            motion = Motion.steps([*zip(shares, along, strict=True)], [*zip(shares, normal, strict=True)])
        else:
            n = np.arange(1, parts + 1)
            (x, y), (xi, eta) = rng.uniform(0.1, 1.0, (2, parts)) / n**2, rng.uniform(0.0, 7.0, (2, parts))
            p = np.linspace(0.0, math.tau, 2000)
            load = np.sin(np.outer(p, n) + eta) @ (n**2 * y)
            unit = throw * weight / (load.max() * w**2)
            leaves = load[0] / load.max() * throw > 1.0
            pairs = (zip(1.5 * unit * x, xi, strict=True), zip(unit * y, eta, strict=True))
            motion = Motion.harmonics(*([*pair] for pair in pairs))
        e = 0.0 if rng.random() < 0.7 else rng.uniform(0.05, 0.3)
        if leaves:
            scenes.append(
                Scene(
                    motion=motion, frequency=w / math.tau, static_friction=mu_s, kinetic_friction=mu_d,
                    trough_angle=beta, restitution=e,
                )
            )  # fmt: skip
    return scenes


def test_from_rest_means_the_same_to_solve_and_to_histories_that_begin_aloft() -> None:
    compared = 0
    for i, scene in enumerate(waves_aloft(60, 7)):
        cycle, history = vibro.solve(scene), vibro.simulate(scene, cycles=5000)
        assert history.sample(0.0).normal == 0.0, i
        if cycle.status != Status.OK:
            assert cycle.status == Status.AVERAGED, i
            continue
        size = abs(float(cycle.displacement_per_cycle)) + float(scene.scale)
        assert history.cycle_displacement == pytest.approx(
            float(cycle.displacement_per_cycle), abs=1e-10 * size
        ), i
        assert history.period_cycles == int(cycle.period_cycles), i
        speed = float(cycle.mean_velocity)
        if speed > 1e-3 * size * float(scene.frequency):
            length = 40.0 * speed / float(scene.frequency) * history.period_cycles
            arrival = float(vibro.arrival_time(scene, length))
            at = vibro.simulate(scene, duration=arrival).sample(arrival).position
            assert float(at) == pytest.approx(length, abs=1e-9 * (length + size)), i
        compared += 1
    assert compared > 54


def test_of_two_normal_motions_a_history_finds_that_of_its_start() -> None:
    """From a lift-off the normal motion of this trough is not found to repeat."""
    scene = Scene(
        motion=Motion.steps(
            [(0.47694492, -6.731037), (0.24301824, 3.998397), (0.17562388, 3.998397), (0.10441296, 14.715)],
            [(0.55623944, -26.40948), (0.16372372, 117.495394), (0.28003684, -16.236394)],
        ),
        frequency=31.377587, static_friction=0.352528, kinetic_friction=0.14542, trough_angle=0.0640892,
    )  # fmt: skip
    cycle, history = vibro.solve(scene), vibro.simulate(scene, cycles=2000)
    assert str(cycle.pattern) == history.pattern == "H"
    assert history.period_cycles == 1
    assert history.settles_at < 1000.0 / float(scene.frequency)
    assert history.cycle_displacement == pytest.approx(
        float(cycle.displacement_per_cycle), abs=1e-10 * float(scene.scale)
    )
