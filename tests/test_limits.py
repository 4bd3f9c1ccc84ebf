"""What comes next from one operating point, and the loads of whole grids."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import pytest
from helpers.scenes import GRAVITY, at_load, scene_with

import vibro
from vibro import Regime
from vibro.limits import stays_upright, tipping_load

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

EXAMPLES = Path(__file__).parents[1] / "examples"


def test_each_transition_is_where_the_motion_changes() -> None:
    scene = vibro.read_scene(EXAMPLES / "safety_nut.toml")
    seen = []
    for t in vibro.transitions(scene):
        assert t.ratio == pytest.approx(float(scene.scale) / t.amplitude, rel=1e-14)
        assert t.ratio == pytest.approx((float(scene.frequency) / t.frequency) ** 2, rel=1e-14)
        for name, value in (("amplitude", t.amplitude), ("frequency", t.frequency)):
            below, above = (
                vibro.solve(scene_with(**{name: value * factor})) for factor in (1 - 1e-9, 1 + 1e-9)
            )
            assert (below.regime, below.pattern) != (above.regime, above.pattern), t.name
        seen.append(Regime(int(above.regime)).label)
    assert seen == ["forward-slip", "back-slip", "back-slip", "hopping"]
    assert [t.name for t in vibro.transitions(scene)] == [
        "forward slip", "back slip", "continuous sliding", "hopping",
    ]  # fmt: skip


def test_what_hopping_forestalls_is_left_out() -> None:
    names = [t.name for t in vibro.transitions(scene_with(drive_angle=math.radians(80)))]
    assert names == ["forward slip", "hopping"]


class Stands(NamedTuple):
    """Parts on troughs where they can rest: angles [deg], frictions, stand ratios, loads of hop and tip."""

    drive: Floats
    mu_s: Floats
    mu_d: Floats
    trough: Floats
    ratio: Floats
    hop: Floats
    tip: Floats

    def scene(self, load: Floats) -> vibro.Scene:
        return at_load(load, self.drive, self.mu_s, self.mu_d, self.trough)


def some_stands(count: int, seed: int) -> Stands:
    random = np.random.default_rng(seed)
    mu_s = random.uniform(0.1, 1.2, count)
    trough = random.uniform(-0.99, 0.99, count) * np.degrees(np.arctan(mu_s)) * random.integers(0, 2, count)
    drive = random.uniform(1.0, np.minimum(89.0, 89.0 - trough))
    mu_d, ratio = mu_s * random.uniform(0.0, 1.0, count), mu_s * random.uniform(0.2, 1.2, count)
    loads = vibro.critical_loads(at_load(1.0, drive, mu_s, mu_d, trough))
    tip = tipping_load(at_load(1.0, drive, mu_s, mu_d, trough), ratio)
    return Stands(drive, mu_s, mu_d, trough, ratio, loads.hop, tip)


def most_friction(stands: Stands, load: Floats) -> tuple[Floats, Floats]:
    """Step Newton's law from rest over two turns; largest |T| / N ever, and before the first slip."""
    along, across = (f(np.radians(stands.drive)) for f in (np.cos, np.sin))
    weight, slope = np.cos(np.radians(stands.trough)) / load, np.sin(np.radians(stands.trough)) / load
    velocity = np.zeros(load.shape)
    most, first = np.zeros(load.shape), np.full(load.shape, np.nan)
    step = 2.0 * math.pi / 1600  # a quarter of the turn is a whole number of steps
    for i in range(3200):
        sine = math.sin(i * step)
        pull, normal = along * sine - slope, weight - across * sine
        rests = velocity == 0.0
        held = rests & (np.abs(pull) <= stands.mu_s * normal)
        # Friction that gives way has been as large as it can be.
        ratio = np.where(rests, np.minimum(np.abs(pull) / normal, stands.mu_s), stands.mu_d)
        most = np.maximum(most, ratio)
        first = np.where(np.isnan(first) & ~held, most, first)
        way = np.where(rests, np.sign(pull), np.sign(velocity))
        then = velocity + step * (pull - way * stands.mu_d * normal)
        velocity = np.where(held | (then * way < 0.0), 0.0, then)
    return most, np.where(np.isnan(first), most, first)


def test_an_edge_lifts_above_the_tipping_load_and_never_below() -> None:
    stands = some_stands(1500, seed=12)
    random = np.random.default_rng(13)
    anywhere = stands.hop * np.exp(random.uniform(np.log(0.01), np.log(0.999), stands.hop.shape))
    tips = np.isfinite(stands.tip) & (stands.tip > 0.0)
    loads = [anywhere, *(np.where(tips, stands.tip * (1.0 + change), anywhere) for change in (-1e-9, 1e-9))]
    seen = set()
    for load in loads:
        upright = stays_upright(stands.scene(load), stands.ratio)
        ever, before_slip = most_friction(stands, load)
        np.testing.assert_array_equal(upright, ever <= stands.ratio)
        # the claim: it lifts before the first slip, or never
        np.testing.assert_array_equal(before_slip > stands.ratio, ever > stands.ratio)
        back_first = np.tan(np.radians(stands.trough)) > stands.ratio**2 * np.tan(np.radians(stands.drive))
        seen |= set(zip(upright.tolist(), tips.tolist(), back_first.tolist(), strict=True))
    assert len(seen) >= 7  # both answers, with and without a load, tipping either way


def test_what_tips_does_so_before_it_hops() -> None:
    stands = some_stands(4000, seed=14)
    finite = np.isfinite(stands.tip)
    assert (stands.tip < stands.hop)[finite].all()
    assert finite.any()
    hopping = stays_upright(stands.scene(1.01 * stands.hop), stands.ratio)
    np.testing.assert_array_equal(hopping, np.where(finite, 0, -1))


def test_the_threshold_itself_keeps_the_base_on_the_trough() -> None:
    flat = {"drive_angle": 0.0, "static_friction": 0.5, "kinetic_friction": 0.4}
    scene = scene_with(amplitude=0.25 * GRAVITY / (30 * math.pi) ** 2, **flat)
    np.testing.assert_array_equal(tipping_load(scene, [0.25, 0.5, 0.6]), [0.25, np.inf, np.inf])
    assert float(scene.load) <= 0.25 < float(scene.load) * (1 + 1e-15)
    np.testing.assert_array_equal(stays_upright(scene, [0.24, 0.25, 0.5]), [0, 1, 1])


def test_steep_troughs_and_parts_that_never_tip() -> None:
    steep = scene_with(trough_angle=math.radians(35))
    np.testing.assert_array_equal(tipping_load(steep, [0.6, np.inf]), [0.0, np.inf])
    np.testing.assert_array_equal(stays_upright(steep, [0.6, 0.8]), [0, 1])
    too_steep = scene_with(trough_angle=math.radians(37))
    np.testing.assert_array_equal(stays_upright(too_steep, [0.6, 0.8]), [-1, 1])


def test_a_forward_onset_after_back_slip_is_told_as_a_load_alone() -> None:
    scene = vibro.Scene(
        along_amplitude=1e-3, normal_amplitude=2.9e-3, normal_phase=math.radians(114.0), frequency=9.15,
        static_friction=0.35, kinetic_friction=0.29,
    )  # fmt: skip
    begun = {t.name: t.ratio for t in vibro.transitions(scene)}
    assert begun["load for forward slip"] > 1.0
    assert "forward slip" not in begun
    assert vibro.solve(scene).pattern == "B_"
