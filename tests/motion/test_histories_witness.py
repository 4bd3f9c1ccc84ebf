"""What histories keep: friction inside its cone, energy over phases, and both of two coexisting cycles."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from engines.integrated import TURN
from helpers.scenes import Groups, at_load, contact_groups, replaced
from hypothesis import given

import vibro


def _scene(groups: Groups, restitution: float) -> vibro.Scene:
    return replaced(at_load(*groups), restitution=restitution)


def _units(scene: vibro.Scene) -> tuple[float, float]:
    """Return A [m] and w [1/s]."""
    return float(scene.scale), TURN * float(scene.frequency)


def _late(
    groups: Groups, restitution: float = 0.0
) -> tuple[vibro.History, list[vibro.motion.histories.Phase]]:
    """Return a history and its last complete phases."""
    scene = _scene(groups, restitution)
    history = vibro.simulate(scene, cycles=12)
    last = [p for p in history.phases if p.start >= history.end - 2.0 / float(scene.frequency)]
    return history, last[:-1]


@given(contact_groups())
def test_friction_keeps_inside_its_cone_and_takes_what_the_drive_gives(groups: Groups) -> None:
    history, phases = _late(groups)
    nodes, weights = np.polynomial.legendre.leggauss(24)
    for phase in phases:
        half = 0.5 * (phase.end - phase.start)
        at = history.sample(phase.start + half * (1.0 + nodes))
        sliding = {"F": 1.0, "B": -1.0, "_": 0.0}[phase.kind]
        scale = float(history.scene.gravity)
        if sliding:
            kinetic = -sliding * groups.mu_d * at.normal
            assert at.friction == pytest.approx(kinetic, abs=1e-12 * scale)
            assert (sliding * at.velocity >= 0.0).all()
        else:
            assert (np.abs(at.friction) <= at.static_limit * (1.0 + 1e-9) + 1e-9 * scale).all()
            assert (at.velocity == 0.0).all()
        assert at.acceleration == pytest.approx(at.inertial + at.friction, abs=1e-12 * scale)
        # work of the load and of friction over a phase that begins and ends at rest
        given_work = half * float((weights * at.inertial * at.velocity).sum())
        lost = -half * float((weights * at.friction * at.velocity).sum())
        gained = 0.5 * (phase.end_velocity**2 - phase.start_velocity**2)
        assert lost >= 0.0
        assert given_work - lost == pytest.approx(gained, abs=1e-9 * (given_work + lost) + 1e-15)


@pytest.mark.parametrize("restitution", [0.0, 0.3])
@pytest.mark.parametrize("load", [2.2, 3.0, 3.6, 5.0])
def test_impacts_and_friction_take_what_the_drive_gives(load: float, restitution: float) -> None:
    history, phases = _late(Groups(load, 30.0, 0.5, 0.4), restitution)
    nodes, weights = np.polynomial.legendre.leggauss(24)
    for phase, following in pairwise(phases):
        half = 0.5 * (phase.end - phase.start)
        at = history.sample(phase.start + half * (1.0 + nodes))
        work = half * (weights * (at.inertial + at.friction) * at.velocity).sum()
        gained = 0.5 * (phase.end_velocity**2 - phase.start_velocity**2)
        assert work == pytest.approx(gained, abs=1e-9)
        if phase.kind == "H":
            assert (at.friction == 0.0).all()
            assert (at.gap >= 0.0).all()
            # friction under the impact brakes by mu_d times its normal impulse, and never reverses the body
            change = following.start_velocity - phase.end_velocity
            most = 0.4 * (1.0 + restitution) * phase.impact_velocity
            assert abs(change) <= most * (1.0 + 1e-6) + 1e-9
            assert change * phase.end_velocity <= 0.0
            assert following.start_velocity * phase.end_velocity >= 0.0
        else:
            assert following.start_velocity == pytest.approx(phase.end_velocity, abs=1e-12)


def test_of_two_coexisting_cycles_a_push_reaches_the_other() -> None:
    # 6.4684 g/w^2 a cycle from rest, 0.5732 if disturbed
    groups = Groups(1.49149, math.degrees(0.7034), 0.457783, 0.0429106)
    scene = at_load(*groups)
    a, w = _units(scene)
    assert vibro.solve(scene).coexists == 1
    rates = []
    for velocity in (0.0, -0.3, 0.3, 1.0):
        history = vibro.simulate(scene, cycles=3000, start_velocity=velocity * a * w)
        rates.append(history.cycle_displacement / a * groups.load)
    assert f"{rates[0]:.4f}" == "6.4684"
    assert {f"{rate:.4f}" for rate in rates} == {"6.4684", "0.5732"}


def test_of_two_coexisting_hopping_cycles_a_push_reaches_the_other() -> None:
    random = np.random.default_rng(5)
    mu_s, drive, throw = (
        random.uniform(0.3, 1.0, 300),
        random.uniform(20.0, 50.0, 300),
        random.uniform(1.01, 1.4, 300),
    )
    scenes = at_load(throw / np.sin(np.radians(drive)), drive, mu_s, 0.05 * mu_s)
    cycles = vibro.solve(scenes, starts=16)
    i = int(np.flatnonzero(cycles.coexists == 1)[0])
    scene = at_load(throw[i] / math.sin(math.radians(drive[i])), drive[i], mu_s[i], 0.05 * mu_s[i])
    a, w = _units(scene)
    pushes = np.linspace(-1.5, 1.5, 7) * a * w
    rates = [vibro.simulate(scene, cycles=1000, start_velocity=v).cycle_displacement for v in pushes]
    from_rest = cycles.displacement_per_cycle[i]
    apart = np.abs(np.array(rates) - from_rest) / a
    assert apart.min() < 1e-9
    assert apart.max() > 1e-6
    assert len(np.unique(np.round(np.array(rates) / a, 9))) == 2
