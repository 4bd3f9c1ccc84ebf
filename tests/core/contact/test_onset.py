"""Thresholds of slip, hop and rest: just below, at and just above, and what equality belongs to."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest
from mpmath import mpf
from scenes import GRAVITY, Groups, at_load, random_scenes

import vibro
from vibro import Regime, Status

FREQUENCY = 15.0
FEW = 16  # ulp; four roundings enter G, and the status allows for them

FLAT = Groups(1.0, 20.0, 0.74, 0.57)
CLIMB = Groups(1.0, 25.0, 0.6, 0.45, 7.0)
DESCENT = Groups(1.0, 12.0, 0.5, 0.4, -9.0)
LOW_FRICTION = Groups(1.0, 5.0, 0.01, 0.009)
STEEP_CLIMB = Groups(1.0, 70.0, 0.4, 0.3, 10.0)


def _exact(groups: Groups) -> tuple[float, float, float]:
    """Critical loads of hop, forward and back onset with 40 digits, from the doubles as given."""
    with mpmath.mp.workdps(40):
        alpha, beta = (mpf(float(np.radians(x))) for x in (groups.drive_deg, groups.trough_deg))
        mu = mpf(groups.mu_s)
        cosine, sine = mpmath.cos(beta), mpmath.sin(beta)
        hop = cosine / mpmath.sin(alpha)
        forward = (mu * cosine + sine) / (mpmath.cos(alpha) + mu * mpmath.sin(alpha))
        back_load = mpmath.cos(alpha) - mu * mpmath.sin(alpha)
        back = (mu * cosine - sine) / back_load if back_load > 0 else mpf("inf")
        return float(hop), float(forward), float(back)


def _at(groups: Groups, load: float, steps: int = 0, offset: float = 0.0) -> vibro.SteadyCycle:
    """Solve at a load, some ulp of the amplitude or a relative offset away from it."""
    scene = at_load(load, groups.drive_deg, groups.mu_s, groups.mu_d, groups.trough_deg, FREQUENCY)
    amplitude = float(scene.scale) * (1.0 + offset)
    amplitude += steps * math.ulp(amplitude)
    return vibro.solve(
        vibro.Scene(
            amplitude=amplitude,
            frequency=FREQUENCY,
            drive_angle=scene.drive_angle,
            static_friction=scene.static_friction,
            kinetic_friction=scene.kinetic_friction,
            trough_angle=scene.trough_angle,
            gravity=GRAVITY,
        )
    )


def _check_threshold(groups: Groups, load: float, below: Regime, above: Regime) -> None:
    assert _at(groups, load, offset=-1e-12).regime == below
    assert _at(groups, load, offset=-1e-12).status == Status.OK
    assert _at(groups, load, offset=+1e-12).regime == above
    assert _at(groups, load, offset=+1e-12).status != Status.BOUNDARY
    at = _at(groups, load)
    assert at.regime == below
    assert at.status == Status.BOUNDARY
    # ulp by ulp the class changes once, and only the few next to the threshold are called so
    ladder = [_at(groups, load, steps) for steps in range(-4 * FEW, 4 * FEW + 1)]
    regimes = [int(c.regime) for c in ladder]
    change = regimes.index(int(above))
    assert set(regimes[:change]) == {int(below)}
    assert set(regimes[change:]) == {int(above)}
    called = [i - 4 * FEW for i, c in enumerate(ladder) if c.status == Status.BOUNDARY]
    assert called == list(range(called[0], called[-1] + 1))
    assert -FEW <= called[0] <= 0 <= called[-1] <= FEW
    for cycle in ladder:
        if cycle.status == Status.BOUNDARY:
            assert cycle.regime == below


@pytest.mark.parametrize("groups", [FLAT, CLIMB, DESCENT, LOW_FRICTION, STEEP_CLIMB])
def test_slip_begins_at_its_first_onset(groups: Groups) -> None:
    _, forward, back = _exact(groups)
    above = Regime.FORWARD_SLIP if forward < back else Regime.BACK_SLIP
    _check_threshold(groups, min(forward, back), Regime.NO_SLIP, above)


@pytest.mark.parametrize("groups", [FLAT, DESCENT])
def test_hopping_begins_above_a_throw_number_of_one(groups: Groups) -> None:
    hop, _, _ = _exact(groups)
    _check_threshold(groups, hop, Regime.BACK_SLIP, Regime.HOPPING)
    assert _at(groups, hop).throw_number == pytest.approx(1.0, rel=1e-15)


def test_hopping_out_of_rest_in_a_steep_drive() -> None:
    # mu_s tan(alpha) > 1 leaves no back onset: rest, forward slip, hop
    groups = Groups(1.0, 75.0, 0.7, 0.5)
    hop, forward, back = _exact(groups)
    assert forward < hop
    assert math.isinf(back)
    _check_threshold(groups, hop, Regime.FORWARD_SLIP, Regime.HOPPING)


@pytest.mark.parametrize("groups", [FLAT, CLIMB, DESCENT, LOW_FRICTION, STEEP_CLIMB])
def test_ratios_are_the_load_over_its_critical_values(groups: Groups) -> None:
    hop, forward, back = _exact(groups)
    for load in (0.3 * forward, 0.99 * forward, 0.999 * hop, 1.5 * hop):
        cycle = _at(groups, load)
        assert cycle.throw_number == pytest.approx(load / hop, rel=2e-15)
        assert cycle.forward_ratio == pytest.approx(load / forward, rel=4e-15)
        assert cycle.back_ratio == pytest.approx(load / back, rel=4e-15)


def test_no_load_slips_a_body_back_that_its_drive_presses_down_too_hard() -> None:
    drive = math.degrees(math.atan(1.0 / 0.8))  # a = mu_s b
    angles = drive + np.array([-1.0, 1e-9, 1.0, 30.0])
    ratio = vibro.solve(at_load(0.9, angles, 0.8, 0.8)).back_ratio
    assert ratio[0] > 0.0
    assert ratio[1:].tolist() == [0.0, 0.0, 0.0]


def test_a_trough_as_steep_as_static_friction_never_rests() -> None:
    friction_angle = math.degrees(math.atan(0.5))
    tilts = np.array([-1.001, -0.999, 0.999, 1.001]) * friction_angle
    cycle = vibro.solve(at_load(1e-4, 20.0, 0.5, 0.4, tilts))
    assert [Status(s) for s in cycle.status] == [Status.RUNAWAY, Status.OK, Status.OK, Status.RUNAWAY]
    assert [Regime(r) for r in cycle.regime] == [
        Regime.FORWARD_SLIP,
        Regime.NO_SLIP,
        Regime.NO_SLIP,
        Regime.BACK_SLIP,
    ]


def test_the_onsets_alone_say_which_slides_can_occur() -> None:
    scene = random_scenes(20_000, seed=1, most_trough_deg=15.0)
    cycle = vibro.solve(scene)
    solved = cycle.status == Status.OK
    forward, back = cycle.forward_ratio > 1.0, cycle.back_ratio > 1.0
    assert solved.mean() > 0.8
    for name, slips in (("_", ~forward & ~back), ("F_", forward & ~back), ("B_", back & ~forward)):
        assert (solved & slips).any()
        assert (cycle.pattern[solved & slips] == name).all()
    both = solved & forward & back
    assert set(cycle.pattern[both]) == {"F_", "B_", "F_B_", "FB_", "F_B", "FB"}
