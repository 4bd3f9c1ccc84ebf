"""The steady solve where floating point is weakest; benchmarks/stress.py does the same on more scenes."""

from __future__ import annotations

import math

import numpy as np
import pytest
from engines.digits_walk import exact_cycle
from extremes import ends_of, extreme_fields
from stress import NAMES, against_reference, broken_invariants

import vibro

SCENES = 2_000
REFERENCE_SCENES = 180

# [eps (condition |d| + S)] error of a displacement that rounding alone may cause
TOLERANCE = 16.0


def solve(*values: float) -> vibro.SteadyCycle:
    return vibro.solve(vibro.Scene(**dict(zip(NAMES, values, strict=True))))


def test_the_scenes_are_extreme() -> None:
    fields = extreme_fields(SCENES, 1)
    for name in ("amplitude", "frequency", "gravity"):
        assert [fields[name].min(), fields[name].max()] == ends_of(name)
    assert fields["static_friction"].min() == 0.0
    assert fields["static_friction"].max() == 10.0
    assert fields["drive_angle"].max() == math.nextafter(0.5 * math.pi, 0.0)
    with np.errstate(all="ignore"):
        cycle = vibro.solve(vibro.Scene(**fields))
    near = np.abs(cycle.throw_number - 1.0) < 1e-14
    assert near.sum() > 0.02 * SCENES
    assert set(np.unique(cycle.pattern)) >= {"_", "F_", "B_", "FB", "FB_", "F_B_"}


def test_invariants_hold_at_the_extremes() -> None:
    assert list(broken_invariants(extreme_fields(SCENES, 1))) == []


def test_patterns_and_displacements_agree_with_arbitrary_precision_at_the_extremes() -> None:
    worst = against_reference(REFERENCE_SCENES, 1)
    assert worst.slipping > 0.3 * REFERENCE_SCENES
    assert worst.undecided < 0.1 * REFERENCE_SCENES
    assert worst.wrong == ()
    assert worst.error < TOLERANCE, worst


def test_kinetic_friction_below_the_rounding_of_1_still_ends_slides() -> None:
    """The forward slide ends inside the back window by a time of some 1e-15 of a cycle."""
    scene = (1.7405755284284677e-10, 28074865.197999418, 2.4129613309251705e-12, 0.5590929778923998)
    cycle = solve(*scene, 2.6318994976094815e-10, 0.0, 9.81)
    assert cycle.pattern == "FB"
    assert cycle.status == vibro.Status.OK
    assert cycle.displacement_per_cycle == pytest.approx(0.0, abs=1e-15 * scene[0])


@pytest.mark.parametrize(
    "scene",
    [
        # The back slide never ends; whether another cycle coexists is not asked.
        (354294.86976718466, 442.7098293589852, 0.0, 1.3131007009778993e-12, 1.9728903006111767e-24,
         1.0519747618462566e-12, 9.81),
        # The forward slide ends within rounding of the back window's end.
        (0.000520263248049116, 312633.9028504501, 0.0, 3.1276025474526037, 3.1601756857674495e-13,
         3.1601756857674455e-13, 9.81),
        # The trough is almost as steep as static friction can hold.
        (4.612268256911697e-13, 0.132502858647908, 3.693444354268408e-06, 0.3355745424441268,
         0.3355745424441265, -0.3237662845625886, 9.81),
        # In continuous sliding half the length of the forward slide is a right angle up to rounding.
        (1.3205146024910965e-23 * 2.0**28, 64405082989.93417 / 2.0**14, 1.5526651535927725,
         0.00141791454401135, 0.0011394278749446362, -0.0011394273818401792, 9.81),
    ],
)  # fmt: skip
def test_troughs_as_steep_as_friction_are_solved_without_a_warning(scene: tuple[float, ...]) -> None:
    assert solve(*scene).status in (vibro.Status.OK, vibro.Status.BOUNDARY, vibro.Status.RUNAWAY)


@pytest.mark.parametrize(
    ("scene", "pattern"),
    [
        # G = 4e-50: products of 1/G with friction are moderate
        ((1e-15, 1e-12, 1.8e-12, 1e-48, 3e-49, 0.0, 1e12), "_"),
        ((1e-15, 1e-12, 1.8e-12, 1e-52, 3e-53, 0.0, 1e12), "FB"),
        # G = 4e43: K = 0.1
        ((1e6, 1e12, 2.5e-45, 0.74, 0.74, 0.0, 1e-12), "FB"),
    ],
)
def test_loads_and_frictions_may_both_be_extreme(scene: tuple[float, ...], pattern: str) -> None:
    assert solve(*scene).pattern == pattern


def test_friction_that_vanishes_beside_the_load_is_not_no_friction() -> None:
    scene = (1e6, 1e12, 0.0, 1.5e-161, 7.4e-162, 1.57, 1e-12)
    assert solve(*scene).status == vibro.Status.RUNAWAY


def test_the_reference_says_what_it_cannot_decide() -> None:
    """The digits cannot distinguish friction of 1e-20 of the load from none."""
    exact = exact_cycle((1.0, 1e12, 0.0, 1e-3, 1e-3, 0.0, 9.81))
    assert exact.pattern == ""
    assert math.isnan(exact.displacement)
