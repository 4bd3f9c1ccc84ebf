"""Motions beyond one harmonic next to the hop, and landings where their load jumps."""

from __future__ import annotations

import math

import pytest

import vibro
from vibro import Regime, Scene, Status


@pytest.mark.parametrize(
    "off", [-1e-3, -1e-6, -1e-7, -1e-9, -1e-12, -1e-15, 0.0, 1e-15, 1e-12, 1e-9, 1e-7, 1e-6, 1e-3]
)
def test_throw_numbers_and_regimes_next_to_the_hop(off: float) -> None:
    size = 9.81 / (100.0 * math.pi) ** 2 * (1.0 + off)
    scene = Scene(along_harmonics=[(2e-4, 0.0)], normal_harmonics=[(size, 0.3)], frequency=50,
                  static_friction=0.5, kinetic_friction=0.4)  # fmt: skip
    cycle = vibro.solve(scene)
    assert float(cycle.throw_number) == pytest.approx(1.0 + off, rel=1e-15)
    if abs(off) > 1e-14:
        assert (int(cycle.regime) == Regime.HOPPING) == (off > 0.0)
        assert Status(int(cycle.status)) is Status.OK
    assert math.isfinite(float(cycle.mean_velocity))


def test_a_landing_at_a_jump_of_the_load_is_a_lift_off_at_it() -> None:
    """A square wave throws a body for one whole period: eta = pi s at first, then pi s - 3 s^2 / 2."""
    motion = vibro.Motion.steps(
        along=[(0.5, -7.3575), (0.5, 7.3575)], normal=[(0.5, 19.62), (0.5, -19.62)]
    )  # fmt: skip
    scene = Scene(motion=motion, frequency=88.79536745757292, static_friction=0.5, kinetic_friction=0.25)
    cycle = vibro.solve(scene)
    assert (Status(int(cycle.status)), str(cycle.pattern), float(cycle.period_cycles)) == (
        Status.OK,
        "H",
        1.0,
    )
    assert float(vibro.arrival_time(scene, 8e-6)) == math.inf
