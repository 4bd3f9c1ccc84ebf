"""The gradient of the displacement, beside differences with 60 digits and what is proven of its signs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import mpmath
import numpy as np
import pytest
from scenes import at_load, loads_of
from vibro.core.contact.cycle_legs import cycle_legs
from vibro.core.contact.derivatives import Gradient, displacement_gradient
from vibro.core.contact.onset import thresholds
from vibro.core.groups import take

from vibro import Scene, critical_loads, solve
from vibro.accuracy.reference import DIGITS, exact_cycle
from vibro.core.codes import PATTERNS, Pattern, Status

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Bools = NDArray[np.bool_]

EPS = 2.0**-52
COUNT = 16  # scenes of each pattern and slope that are compared with the reference
CONTEXT = mpmath.mp.clone()
CONTEXT.dps = DIGITS
STEP = CONTEXT.mpf("1e-15")
DIFFERENTIATED = (0, 2, 3, 4, 5)  # of the inputs of ``exact_cycle``; amplitude stands for ln G
SLIDING = ["F_", "B_", "F_B_", "FB_", "F_B", "FB"]
# What may be small in a pattern, see ``assert_exact``.
SMALL = {"F_": "F", "B_": "B", "F_B_": "FB", "FB_": "F", "F_B": "B", "FB": "t"}


class Solved(NamedTuple):
    """Scenes in contact that slide, and the derivatives at them."""

    scene: Scene
    pattern: NDArray[np.int64]
    displacement: Floats  # [A]
    gradient: Gradient

    def of(self, name: str) -> NDArray[np.intp]:
        return np.flatnonzero(self.pattern == PATTERNS.index(name))


def solved(scene: Scene) -> Solved:
    cycle = solve(scene)
    pattern = np.where(cycle.status == Status.OK, cycle.pattern_code, Pattern.NONE)
    gradient = displacement_gradient(loads_of(scene), pattern)
    return Solved(scene, pattern, cycle.displacement_per_cycle / scene.scale, gradient)


def drawn(count: int, seed: int, most_trough_deg: float) -> Scene:
    """Draw scenes between the first onset and the hop, log-uniform; low ratios of friction too."""
    random = np.random.default_rng(seed)
    mu_s = np.exp(random.uniform(np.log(0.05), np.log(1.5), count))
    mu_d = mu_s * np.exp(random.uniform(np.log(0.02), 0.0, count))
    steepest = np.minimum(most_trough_deg, 0.98 * np.degrees(np.arctan(mu_s)))
    trough = random.uniform(-1.0, 1.0, count) * steepest
    drive = random.uniform(0.5, np.minimum(80.0, 85.0 - trough))
    limits = critical_loads(at_load(1.0, drive, mu_s, mu_d, trough))
    low, high = np.log(np.minimum(limits.forward_onset, limits.back_onset)), np.log(0.999 * limits.hop)
    load = np.exp(low + (high - low) * random.uniform(0.0, 1.0, count) ** 2)
    return at_load(load, drive, mu_s, mu_d, trough)


@pytest.fixture(scope="module", params=[0.0, 40.0], ids=["level", "inclined"])
def many(request: pytest.FixtureRequest) -> Solved:
    return solved(drawn(150_000, seed=21, most_trough_deg=request.param))


def differences(values: list[float], pattern: str) -> list[Any]:
    """Differentiate the independent walk with 60 digits, over a step to each side that keeps the pattern."""
    slopes = []
    for i in DIFFERENTIATED:
        ends = []
        for way in (1, -1):
            moved = [CONTEXT.mpf(v) for v in values]
            moved[i] += way * STEP * (moved[0] if i == 0 else 1)
            ends.append(exact_cycle(moved))
        assert {end.pattern for end in ends} == {pattern}
        slopes.append((ends[0].displacement - ends[1].displacement) / (2 * STEP))
    return slopes


def assert_exact(many: Solved, cells: NDArray[np.intp]) -> None:
    """Hold the gradient against the reference, within 16 eps (1 + 1 / d) of its largest member.

    d is the condition of a root near 0: of the onsets from which slides of the cycle start 1 - s, in FB the
    distance 1 - |t| / (mu_d n) of gravity along the trough from kinetic friction, where a slide vanishes.
    """
    fields = [np.broadcast_to(x, many.scene.shape)[cells].tolist() for x in many.scene.arrays()[:7]]
    groups = take(loads_of(many.scene), cells)
    margins = thresholds(groups).margins
    distances = {
        "F": margins.forward / margins.forward_load,
        "B": margins.back / margins.back_load,
        "t": 1.0 - np.abs(groups.tangential) / (groups.kinetic_friction * groups.normal),
    }
    for i, cell in enumerate(cells):
        pattern = PATTERNS[many.pattern[cell]]
        expected = differences([field[i] for field in fields], pattern)
        errors = [float(own[cell] - slope) for own, slope in zip(many.gradient, expected, strict=True)]
        condition = 1.0 + 1.0 / min(distances[name][i] for name in SMALL[pattern])
        sizes = np.abs(np.array(expected, float))
        assert np.abs(errors).max() <= 16 * EPS * condition * sizes.max(), (pattern, cell)
        large = sizes > 0.01 * sizes.max()
        if condition < 1e3:
            assert (np.abs(errors)[large] <= 1e-12 * sizes[large]).all(), (pattern, cell)


@pytest.mark.parametrize("pattern", SLIDING)
def test_the_gradient_is_that_of_the_reference(many: Solved, pattern: str) -> None:
    cells = many.of(pattern)[:COUNT]
    if pattern != "B_" or many.scene.trough_angle.any():  # a level trough conveys nothing back alone
        assert cells.size == COUNT
        assert_exact(many, cells)


def test_it_is_exact_just_above_an_onset() -> None:
    angles = {"drive_deg": np.array([20.0, 20.0, 5.0]), "trough_deg": np.array([0.0, -10.0, 15.0])}
    limits = critical_loads(at_load(1.0, mu_s=0.5, mu_d=0.4, **angles))
    onset = np.minimum(limits.forward_onset, limits.back_onset)
    above = np.array([[1e-2], [1e-4], [1e-6], [1e-8], [1e-10]])
    near = at_load(onset * (1.0 + above), mu_s=0.5, mu_d=0.4, **angles)
    flat = Scene(**near.flat()._asdict())
    found = solved(flat)
    assert {PATTERNS[code] for code in found.pattern} == {"F_", "B_"}
    assert_exact(found, np.arange(above.size * 3))
    # it grows like 1 over the root of the distance
    growth = np.abs(found.gradient.log_load).reshape(-1, 3) * np.sqrt(above)
    np.testing.assert_allclose(growth[2:], growth[-1:].repeat(3, axis=0), rtol=2e-2)


def holds(condition: Bools, where: Bools) -> None:
    """Check that a condition holds for every one of some cells, and that there are such cells."""
    assert where.sum() > 20
    assert condition[where].all()


def test_signs_inside_a_pattern(many: Solved) -> None:
    """dv of v = A f D(G): signs proven, or seen without exception (theory.md, section 13)."""
    scene, slopes = many.scene, many.gradient
    level = not scene.trough_angle.any()
    by_amplitude = many.displacement + slopes.log_load
    by_frequency = many.displacement + 2.0 * slopes.log_load
    faster, slower = np.sign(by_amplitude) > 0, np.sign(by_amplitude) < 0
    noise = 64 * EPS * np.abs(np.array(slopes)).max(axis=0)
    is_ = {name: many.pattern == PATTERNS.index(name) for name in SLIDING}
    gentle = scene.static_friction * np.tan(np.abs(scene.trough_angle)) < 1.0
    slides = many.pattern > Pattern.R

    for name in ("F_", "FB_"):
        holds(slopes.static_friction < noise, is_[name])
        holds(faster & (by_frequency > 0), is_[name])
    holds(slopes.kinetic_friction < noise, is_["F_"])
    backs = ["F_B"] if level else ["F_B", "B_"]
    for name in backs:
        holds(slopes.static_friction > -noise, is_[name])
        holds(slopes.kinetic_friction > -noise, is_[name])
        holds(slopes.drive_angle > -noise, is_[name])
    if level:
        holds(slopes.static_friction > -noise, is_["F_B_"])
        holds(slopes.kinetic_friction < noise, is_["FB_"])
    else:
        holds(slower & (by_frequency < 0), is_["B_"])
    holds(slopes.static_friction == 0.0, is_["FB"])
    forward = np.sign(many.displacement)
    holds((np.sign(by_amplitude) == forward) & (np.sign(by_frequency) == forward), is_["FB"])
    holds(slopes.trough_angle < noise, slides & gentle)
    rising = scene.drive_angle < np.arctan(scene.kinetic_friction)
    falling = scene.drive_angle > np.arctan(scene.static_friction)
    holds(slopes.drive_angle > -noise, is_["F_"] & rising)
    holds(slopes.drive_angle < noise, is_["F_"] & falling)


def test_the_growth_of_one_forward_slide_has_its_proven_form(many: Solved) -> None:
    """dV/dG = (V + Q l^2 / 2) / G + l e0 |dp0/dG| >= V/G with V = G D, loads in weights, slide length l."""
    cells = many.of("F_")
    groups = take(loads_of(many.scene), cells)
    growth = many.displacement[cells] + many.gradient.log_load[cells]
    braked = groups.kinetic_friction * groups.normal + groups.tangential >= 0.0
    holds(growth >= many.displacement[cells], braked)
    for i in range(40):
        one = take(groups, np.array([i]))
        leg = cycle_legs(one, Pattern.F_)[0]
        length, start = leg.end - leg.start, leg.start
        resistance = (one.kinetic_friction * one.normal + one.tangential).item()
        excess = (one.along * np.sin(start) - one.tangential).item()
        excess -= (one.kinetic_friction * (one.normal - one.across * np.sin(start))).item()
        expected = leg.displacement + 0.5 * resistance * length**2 + length * excess * np.tan(start)
        assert growth[i] == pytest.approx(expected, rel=1e-9)


def test_there_is_none_without_a_cycle_and_0_at_rest() -> None:
    scene = at_load([0.1, 1.0, 9.0], 20.0, 0.74, 0.57)
    pattern = np.array([Pattern.R, Pattern.F_, Pattern.NONE])
    rest, slides, hops = np.array(displacement_gradient(loads_of(scene), pattern)).T
    assert (rest == 0.0).all()
    assert np.isfinite(slides).all()
    assert np.isnan(hops).all()
