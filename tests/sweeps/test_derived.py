"""What follows from solved cells: how the speed follows the amplitude, and how many parts pass."""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING, NamedTuple

import mpmath
import numpy as np
import pytest
from engines.digits_walk import DIGITS, exact_cycle
from helpers.scenes import at_load

from vibro import Scene, critical_loads, solve
from vibro.core.codes import PATTERNS, Status
from vibro.quantities import QUANTITIES
from vibro.results.sweep import Block
from vibro.sweeps.derived import WITH_EXPONENT, throughput

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

EPS = 2.0**-52
CONTEXT = mpmath.mp.clone()
CONTEXT.dps = DIGITS
STEP = CONTEXT.mpf("1e-17")
COUNT = 5  # scenes of each pattern, at large and just beside a threshold
SLIDING = ["F_", "B_", "F_B_", "FB_", "F_B", "FB"]


def block_of(scene: Scene) -> Block:
    """Solve scenes as a block of cells."""
    fields = dict(zip(scene.arrays()._fields, scene.flat(), strict=True))
    return Block({name: QUANTITIES[name].from_si(x) for name, x in fields.items()}, solve(scene), None)


def exponents(scene: Scene) -> Floats:
    return WITH_EXPONENT.values(block_of(scene))


class Drawn(NamedTuple):
    scene: Scene
    beside: NDArray[np.bool_]  # one of the critical loads
    pattern: NDArray[np.int64]
    exponent: Floats
    condition: Floats


def draw(count: int) -> Drawn:
    """Draw scenes between the first onset and the hop; half of them 1e-13 to 1e-2 beside a critical load."""
    random = np.random.default_rng(3)
    mu_s = np.exp(random.uniform(np.log(0.05), np.log(1.5), count))
    mu_d = mu_s * np.exp(random.uniform(np.log(0.02), 0.0, count))
    steepest = np.minimum(40.0, 0.98 * np.degrees(np.arctan(mu_s)))
    trough = random.uniform(-1.0, 1.0, count) * steepest * random.integers(0, 2, count)
    drive = random.uniform(0.5, np.minimum(80.0, 85.0 - trough))
    limits = critical_loads(at_load(1.0, drive, mu_s, mu_d, trough))
    low, high = np.log(np.minimum(limits.forward_onset, limits.back_onset)), np.log(0.999 * limits.hop)
    load = np.exp(low + (high - low) * random.uniform(0.0, 1.0, count) ** 2)
    critical = np.array(limits)[random.integers(0, len(limits), count), np.arange(count)]
    near = critical * (1.0 + random.choice([-1.0, 1.0], count) * 10.0 ** random.uniform(-13.0, -2.0, count))
    beside = (random.uniform(size=count) < 0.5) & (near > 0.0) & (near < limits.hop)
    scene = at_load(np.where(beside, near, load), drive, mu_s, mu_d, trough)
    cycle = solve(scene)
    with np.errstate(divide="ignore", invalid="ignore"):
        # 1 - s of the onsets
        forward, back = (np.abs(1.0 - 1.0 / x) for x in (cycle.forward_ratio, cycle.back_ratio))
        pushes = np.cos(np.radians(drive)) > mu_s * np.sin(np.radians(drive))
        onsets = np.fmin(forward, np.where(pushes, back, np.inf))
        slack = 1.0 - np.abs(np.tan(scene.trough_angle)) / mu_d
        condition = 1.0 + 1.0 / np.minimum(onsets, np.abs(slack))
        condition += np.abs(scene.scale / cycle.displacement_per_cycle)
    return Drawn(scene, beside, cycle.pattern_code, exponents(scene), condition)


def test_the_exponent_is_that_of_the_reference() -> None:
    """Beside differences with 60 digits, within 256 eps of the conditions of onsets, slides and their sum.

    The largest of 9000 was 101 eps (F_B, whose second slide starts where the first ends).
    """
    drawn = draw(40_000)
    fields = [np.ravel(x).tolist() for _, _, x in drawn.scene.flat().members()[:7]]
    for pattern, beside in product(SLIDING, (False, True)):
        of_kind = (drawn.pattern == PATTERNS.index(pattern)) & (drawn.beside == beside)
        cells = np.flatnonzero(of_kind & ~np.isnan(drawn.exponent))[:COUNT]
        assert cells.size == COUNT
        for cell in cells:
            amplitude, *others = (CONTEXT.mpf(field[cell]) for field in fields)
            low, here, high = (exact_cycle([amplitude * (1 + way * STEP), *others]) for way in (-1, 0, 1))
            assert {low.pattern, high.pattern} == {pattern}
            expected = 1 + (high.displacement - low.displacement) / (2 * STEP * here.displacement)
            error = abs(float(CONTEXT.mpf(drawn.exponent[cell].item()) - expected))
            assert error <= 256 * EPS * drawn.condition[cell] * max(1.0, abs(float(expected))), cell


def test_there_is_none_where_nothing_is_conveyed_or_rounding_decides() -> None:
    onset = critical_loads(at_load(1.0, 20.0, 0.74, 0.57)).forward_onset.item()
    level = at_load([0.305, 2.0], 0.0, 0.3, 0.28)  # slides to and fro alike
    for scene in (at_load([0.1, onset, 9.0], 20.0, 0.74, 0.57), level, at_load([1.0], 20.0, 0.0, 0.0)):
        assert np.isnan(exponents(scene)).all()
    assert solve(at_load(onset, 20.0, 0.74, 0.57)).status == Status.BOUNDARY
    assert solve(level).pattern.tolist() == ["F_B_", "FB"]
    # just above the onset it grows without bound; below there is none
    beside = exponents(at_load(onset * np.array([1.0 - 1e-12, 1.0 + 1e-8, 1.0 + 1e-10]), 20.0, 0.74, 0.57))
    assert np.isnan(beside[0])
    assert beside[2] == pytest.approx(10.0 * beside[1], rel=1e-3)


def test_a_speed_that_nearly_vanishes_has_none() -> None:
    """Two slides that cancel leave rounding: no number is made of it."""

    def speed(drive_deg: float) -> float:
        return float(solve(at_load(0.6, drive_deg, 0.3, 0.25, 3.0)).mean_velocity)

    low, high = 5.0, 40.0
    assert speed(low) < 0.0 < speed(high)
    while (middle := 0.5 * (low + high)) not in (low, high):
        low, high = (middle, high) if speed(middle) < 0.0 else (low, middle)
    assert np.isnan(exponents(at_load(0.6, [low, high], 0.3, 0.25, 3.0))).all()
    assert np.isfinite(exponents(at_load(0.6, [low - 1e-3, high + 1e-3], 0.3, 0.25, 3.0))).all()


def test_parts_pass_where_they_are_conveyed_forward() -> None:
    scene = at_load(
        [0.1, 1.0, 3.9, 0.8], [20.0, 20.0, 20.0, 5.0], 0.5, [0.4, 0.4, 0.4, 0.3], [0.0, 0.0, 0.0, 10.0]
    )
    cycle = solve(scene, flight=False)
    assert np.sign(cycle.mean_velocity).tolist()[:2] == [0.0, 1.0]
    assert np.isnan(cycle.mean_velocity[2])
    assert cycle.mean_velocity[3] < 0.0
    block = Block({}, cycle, None)
    parts, flow = (column.values(block) for column in throughput({"pitch_mm": 25.0, "mass_kg": 0.012}))
    expected = 60.0 * cycle.mean_velocity[1] / 0.025
    np.testing.assert_allclose(parts, [0.0, expected, np.nan, 0.0], rtol=1e-15)
    np.testing.assert_allclose(flow, [0.0, 60.0 * 0.012 * expected, np.nan, 0.0], rtol=1e-15)
    (parts_alone,) = throughput({"pitch_mm": 25.0})
    assert (parts_alone.name, parts_alone.unit) == ("parts_per_min", "1/min")
    assert np.isinf(throughput({"pitch_mm": 1e-308})[0].values(block)[1])
