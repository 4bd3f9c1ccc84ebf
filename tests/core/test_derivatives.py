"""How the displacement follows each group of the loads: beside differences, of 60 digits too, and signs."""

from __future__ import annotations

import functools
import math
from typing import TYPE_CHECKING, Any, NamedTuple

import mpmath
import numpy as np
import pytest
from engines.digits_walk import DIGITS, exact_cycle
from helpers.cases import each
from helpers.contact_loads import random_loads
from helpers.scenes import at_load, loads_of

from vibro import Scene, critical_loads, solve
from vibro.core.codes import PATTERNS, Pattern, Status
from vibro.core.contact import Change, Steady, displacement_rate, load_slope, steady_cycle
from vibro.core.drive import Loads
from vibro.core.slides import thresholds
from vibro.slopes import Gradient, displacement_gradient, slides_of
from vibro.slopes import load_slope as load_slope_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Bools = NDArray[np.bool_]

EPS = 2.0**-52
STILL = Change(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
SLIDING = ["F_", "B_", "F_B_", "FB_", "F_B", "FB"]

# ------------------------------------------------------------------------ each group of any drive


def changed(loads: Loads, name: str, by: float) -> Loads:
    """Change one group, or the phase difference."""
    if name == "phase":
        sine, cosine = loads.phase_sine, loads.phase_cosine
        return loads._replace(
            phase_sine=sine * math.cos(by) + cosine * math.sin(by),
            phase_cosine=cosine * math.cos(by) - sine * math.sin(by),
        )
    return loads._replace(**{name: getattr(loads, name) + by})


def steady(loads: Loads) -> Steady:
    return steady_cycle(loads, thresholds(loads))


def far_from_onsets(loads: Loads) -> bool:
    """Whether differences are good there."""
    at = thresholds(loads)
    pairs = ((at.forward_margin, at.forward_load), (at.back_margin, at.back_load))
    shallow = abs(loads.weight_tangential) < 0.9 * loads.kinetic_friction * loads.weight_normal
    return shallow and all(margin < 0.0 or margin > 0.01 * load for margin, load in pairs)


@functools.cache
def sliding() -> list[Loads]:
    """Lines and ellipses, all in the form of ellipses, that slide."""
    some = [x._replace(line=False) for x in random_loads(500, 1, steepest=0.6)]
    return [x for x in some if steady(x).pattern > Pattern.R and far_from_onsets(x)]


@each("name", Change._fields)
@each("pattern", SLIDING)
def test_each_rate_is_that_of_the_solved_displacement(name: str, pattern: str) -> None:
    code, count, h = PATTERNS.index(pattern), 0, 1e-6
    for loads in sliding():
        ends = [steady(changed(loads, name, step)) for step in (-h, h)]
        if any(end.pattern != code or end.status != Status.OK for end in ends):
            continue
        expected = (ends[1].displacement - ends[0].displacement) / (2.0 * h)
        found = displacement_rate(loads, code, STILL._replace(**{name: 1.0}))
        assert found == pytest.approx(expected, rel=2e-6, abs=2e-6), loads
        count += 1
        if count == 8:
            break
    assert count >= 5


def test_rates_add_up() -> None:
    for loads in sliding()[:40]:
        code = steady(loads).pattern
        rates = [displacement_rate(loads, code, STILL._replace(**{name: 1.0})) for name in Change._fields]
        weights = (0.3, -0.2, 0.5, 0.1, 0.7, -0.4, 0.6)
        together = sum(w * rate for w, rate in zip(weights, rates, strict=True))
        size = sum(map(abs, rates))
        assert displacement_rate(loads, code, Change(*weights)) == pytest.approx(together, abs=1e-11 * size)


def test_the_slope_is_that_by_the_logarithm_of_the_load() -> None:
    for loads in sliding()[:60]:
        code = steady(loads).pattern
        n, t = loads.weight_normal, loads.weight_tangential
        lighter = STILL._replace(weight_normal=-n, weight_tangential=-t)
        assert load_slope(loads, code) == displacement_rate(loads, code, lighter)
        # lengths over A: more of both amplitudes, of all but the displacement's own scale
        heavier = STILL._replace(drive_tangential=loads.drive_tangential, drive_normal=loads.drive_normal)
        grown = displacement_rate(loads, code, heavier)
        assert grown == pytest.approx(load_slope(loads, code) + steady(loads).displacement, abs=1e-9)


def test_a_line_as_an_ellipse_has_the_same_slope() -> None:
    for loads in random_loads(100, 3, steepest=0.6):
        code = steady(loads).pattern
        if loads.line and code > Pattern.R and far_from_onsets(loads):
            same = loads._replace(line=False)
            assert load_slope(loads, code) == pytest.approx(load_slope(same, code), rel=1e-10, abs=1e-10)


def test_there_is_none_without_a_cycle_and_0_at_rest() -> None:
    loads = random_loads(1, 2)[0]
    assert load_slope(loads, Pattern.R) == 0.0
    assert math.isnan(load_slope(loads, Pattern.NONE))
    resting = loads._replace(weight_normal=100.0)
    assert math.isnan(load_slope(resting, Pattern.FB))
    runaway = Loads(1.0, 0.1, 0.8, 0.2, 0.78, 0.3, 0.01, 0.0, 1.0, True)
    assert math.isnan(load_slope(runaway, Pattern.B_))
    assert math.isnan(load_slope(runaway, Pattern.F_B_))
    flat = Loads(0.0, 0.0, 0.8, 0.0, 0.78, 0.3, 0.01, 0.0, 1.0, True)
    assert math.isnan(load_slope(flat, Pattern.FB))


# --------------------------------------------------------------------------------- beside 60 digits

COUNT = 2  # scenes of each pattern and slope that are compared with the reference
CONTEXT = mpmath.mp.clone()
CONTEXT.dps = DIGITS
STEP = CONTEXT.mpf("1e-15")
DIFFERENTIATED = (0, 2, 3, 4, 5)  # of the inputs of ``exact_cycle``; amplitude stands for ln G
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
    cycle = solve(scene, flight=False)
    pattern = np.where(cycle.status == Status.OK, cycle.pattern_code, Pattern.NONE)
    gradient = displacement_gradient(scene, pattern)
    return Solved(scene, pattern, cycle.displacement_per_cycle / scene.scale, gradient)


@functools.cache
def drawn(most_trough_deg: float) -> Solved:
    """Draw scenes between the first onset and the hop, log-uniform; low ratios of friction too."""
    random, count = np.random.default_rng(21), 4000
    mu_s = np.exp(random.uniform(np.log(0.05), np.log(1.5), count))
    mu_d = mu_s * np.exp(random.uniform(np.log(0.02), 0.0, count))
    steepest = np.minimum(most_trough_deg, 0.98 * np.degrees(np.arctan(mu_s)))
    trough = random.uniform(-1.0, 1.0, count) * steepest
    drive = random.uniform(0.5, np.minimum(80.0, 85.0 - trough))
    limits = critical_loads(at_load(1.0, drive, mu_s, mu_d, trough))
    low, high = np.log(np.minimum(limits.forward_onset, limits.back_onset)), np.log(0.999 * limits.hop)
    load = np.exp(low + (high - low) * random.uniform(0.0, 1.0, count) ** 2)
    return solved(at_load(load, drive, mu_s, mu_d, trough))


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
    arrays = [x for _, _, x in many.scene.arrays().members()]
    fields = [np.broadcast_to(x, many.scene.shape)[cells].tolist() for x in arrays[:7]]
    groups = loads_of(many.scene)
    for i, cell in enumerate(cells.tolist()):
        at = thresholds(groups[cell])
        hold = groups[cell].kinetic_friction * groups[cell].weight_normal
        distances = {
            "F": at.forward_margin / at.forward_load,
            "B": at.back_margin / at.back_load,
            "t": 1.0 - abs(groups[cell].weight_tangential) / hold,
        }
        pattern = PATTERNS[many.pattern[cell]]
        a, f, alpha, mu_s, mu_d, beta, g = (field[i] for field in fields)
        expected = differences([a, f, alpha, mu_s, mu_d, beta, g], pattern)
        errors = [float(own[cell] - slope) for own, slope in zip(many.gradient, expected, strict=True)]
        condition = 1.0 + 1.0 / min(distances[name] for name in SMALL[pattern])
        sizes = np.abs(np.array(expected, float))
        assert np.abs(errors).max() <= 16 * EPS * condition * sizes.max(), (pattern, cell)
        large = sizes > 0.01 * sizes.max()
        if condition < 1e3:
            assert (np.abs(errors)[large] <= 1e-12 * sizes[large]).all(), (pattern, cell)


@each("most_trough_deg", [0.0, 40.0])
@each("pattern", SLIDING)
def test_the_gradient_is_that_of_the_reference(most_trough_deg: float, pattern: str) -> None:
    many = drawn(most_trough_deg)
    cells = many.of(pattern)[:COUNT]
    if pattern != "B_" or most_trough_deg:  # a level trough conveys nothing back alone
        assert cells.size == COUNT
        assert_exact(many, cells)


def test_it_is_exact_just_above_an_onset() -> None:
    angles = {"drive_deg": np.array([20.0, 20.0, 5.0]), "trough_deg": np.array([0.0, -10.0, 15.0])}
    limits = critical_loads(at_load(1.0, mu_s=0.5, mu_d=0.4, **angles))
    onset = np.minimum(limits.forward_onset, limits.back_onset)
    above = np.array([[1e-2], [1e-6], [1e-8], [1e-10]])
    near = at_load(onset * (1.0 + above), mu_s=0.5, mu_d=0.4, **angles)
    flat = Scene(**near.flat()._asdict())
    found = solved(flat)
    assert {PATTERNS[code] for code in found.pattern} == {"F_", "B_"}
    assert_exact(found, np.arange(above.size * 3))
    # it grows like 1 over the root of the distance
    growth = np.abs(found.gradient.log_load).reshape(-1, 3) * np.sqrt(above)
    np.testing.assert_allclose(growth[1:], growth[-1:].repeat(3, axis=0), rtol=2e-2)


# --------------------------------------------------------------------------------- what is proven


def holds(condition: Bools, where: Bools) -> None:
    """Check that a condition holds for every one of some cells, and that there are such cells."""
    assert where.sum() > 5
    assert condition[where].all()


@pytest.mark.parametrize("most_trough_deg", [0.0, 40.0])
def test_signs_inside_a_pattern(most_trough_deg: float) -> None:
    """dv of v = A f D(G): signs proven, or seen without exception (theory, section 13)."""
    many = drawn(most_trough_deg)
    scene, slopes, level = many.scene, many.gradient, most_trough_deg == 0.0
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


def test_the_growth_of_one_forward_slide_has_its_proven_form() -> None:
    """dV/dG = (V + Q l^2 / 2) / G + l e0 |dp0/dG| >= V/G with V = G D, loads in weights, slide length l."""
    many = drawn(40.0)
    cells = many.of("F_")
    groups = loads_of(many.scene)
    slides = slides_of(many.scene, many.pattern)
    for i in cells[:40].tolist():
        one = groups[i]
        growth = many.displacement[i] + many.gradient.log_load[i]
        if one.kinetic_friction * one.weight_normal + one.weight_tangential >= 0.0:
            assert growth >= many.displacement[i]
        start, end = slides.begin[0, i], slides.end[0, i]
        resistance = one.kinetic_friction * one.weight_normal + one.weight_tangential
        excess = one.drive_tangential * math.sin(start) - one.weight_tangential
        excess -= one.kinetic_friction * (one.weight_normal - one.drive_normal * math.sin(start))
        expected = slides.displacement[0, i] + 0.5 * resistance * (end - start) ** 2
        assert growth == pytest.approx(expected + (end - start) * excess * math.tan(start), rel=1e-9)


# ------------------------------------------------------------------------------------------- the face


def test_the_face_has_the_shape_of_the_scene() -> None:
    scene = at_load(np.array([[0.1], [1.0], [9.0]]), np.array([20.0, 15.0]), 0.74, 0.57)
    pattern = np.array([[Pattern.R] * 2, [Pattern.F_] * 2, [Pattern.NONE] * 2])
    gradient = displacement_gradient(scene, pattern)
    slope = load_slope_of(scene, pattern)
    expected = [load_slope(x, p) for x, p in zip(loads_of(scene), pattern.ravel().tolist(), strict=True)]
    np.testing.assert_array_equal(slope.ravel(), expected)
    np.testing.assert_array_equal(slope, gradient.log_load)
    for member in gradient:
        assert member.shape == (3, 2)
        assert (member[0] == 0.0).all()
        assert np.isfinite(member[1]).all()
        assert np.isnan(member[2]).all()
    slides = slides_of(scene, pattern)
    assert slides.way.tolist() == [[[0, 0], [1, 1], [0, 0]], [[0, 0]] * 3]
    assert slides.begin.shape == (2, 3, 2)
