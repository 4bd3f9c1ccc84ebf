"""Loads up to which a whole box keeps to a regime, beside dense grids of its bodies."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from helpers.boxed import Boxed, boxes
from helpers.draws import examples
from helpers.scenes import scene_with
from hypothesis import example, given
from hypothesis import strategies as st

from vibro import Regime, Scene
from vibro.designs.proofs import (
    back_slip_load,
    extreme_ratio,
    first_ratio,
    is_braked,
    last_ratio,
    onset_load,
    steeper_is_slower,
    tip_load,
)
from vibro.designs.spaces import uncertainty_set
from vibro.limits import critical_loads, critical_loads_of_lines, tipping_load_of_lines

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.designs.spaces import UncertaintySet

    Floats = NDArray[np.float64]

COUNT = 7  # values of each band in a grid
drawn = boxes(drifts=True)


def grid_of(box: UncertaintySet) -> Any:
    """All combinations of values of angles and frictions, the ends of the bands among them."""
    shares = np.linspace(0.0, 1.0, COUNT)
    grid = np.array(np.meshgrid([0.0], *[shares] * 4, [0.0], indexing="ij")).reshape(6, -1)
    return box.points(grid)


def criticals_of(box: UncertaintySet) -> Any:
    points = grid_of(box)
    return critical_loads_of_lines(
        points.shape[0], points.static_friction, points.kinetic_friction, points.trough_angle
    )


def assert_least(cap: Floats, loads: Floats) -> None:
    """A cap is below all loads of a grid, but not by more than the grid may miss."""
    least = np.min(loads)
    if math.isinf(least):
        assert math.isinf(cap)
        return
    assert cap <= least * (1 + 1e-12)
    assert cap >= least * 0.98


@examples(25)
@given(drawn)
def test_hop_and_onset(box: Boxed) -> None:
    one = uncertainty_set(box.scene, box.bands)
    loads = criticals_of(one)
    assert float(one.hop_load) == pytest.approx(np.min(loads.hop), rel=1e-12)
    assert float(onset_load(one)) == pytest.approx(np.max(loads.forward_onset), rel=1e-12)


@examples(25)
@given(drawn)
def test_back_slip(box: Boxed) -> None:
    one = uncertainty_set(box.scene, box.bands)
    loads = criticals_of(one).back_slip
    assert_least(back_slip_load(one), loads)
    last = float(back_slip_load(one, last=True))
    assert np.max(loads) * (1 - 1e-12) <= last <= np.max(loads) * 1.02


@examples(25)
@given(drawn, st.floats(0.1, 1.5))
def test_tip(box: Boxed, stand_ratio: float) -> None:
    one = uncertainty_set(box.scene, box.bands)
    points = grid_of(one)
    loads = tipping_load_of_lines(points.shape[0], points.static_friction, points.trough_angle, stand_ratio)
    assert_least(tip_load(one, stand_ratio), loads)
    if one.static_friction[1] <= stand_ratio:
        assert math.isinf(tip_load(one, stand_ratio))


def test_on_a_decline_the_smoothest_part_may_be_the_last_to_slip_back() -> None:
    """Kinetic friction grows with the static one here: the roughest part need not be the last."""
    mu_s = np.linspace(0.5, 0.625, 2001)
    angles = math.radians(2.0), (math.radians(-11.0), math.radians(-9.0))
    scene = scene_with(drive_angle=angles[0], trough_angle=angles[1][0], kinetic_friction=0.25)
    bands = {"static_friction": (0.5, 0.625), "friction_ratio": (0.5, 0.5), "trough_angle": angles[1]}
    box = uncertainty_set(scene, bands)
    loads = np.array(
        [critical_loads_of_lines(angles[0], mu_s, 0.5 * mu_s, beta).back_slip for beta in angles[1]]
    )
    assert int(np.argmax(loads)) == 0
    assert float(back_slip_load(box, last=True)) == pytest.approx(np.max(loads), rel=1e-12)
    expected = float(box.load[0]) / np.max(loads)
    assert last_ratio(box, Regime.BACK_SLIP) == pytest.approx(expected, rel=1e-12)


@examples(1)
@example(2.93, 0.7, -0.65, 0.17, 0.5, False)  # so steep that a steeper one holds better against back slip
@example(1.83, 0.78, -0.51, 0.2, 0.5, True)
@given(
    st.floats(0.3, 4.0), st.floats(0.2, 0.95), st.floats(-0.98, 0.98), st.floats(0.05, 1.2),
    st.floats(0.1, 1.5), st.booleans(),
)  # fmt: skip
def test_loads_on_steep_troughs(
    friction: float, ratio: float, share: float, drive: float, stand: float, is_ratio: bool
) -> None:
    """Troughs up to the angle of static friction, 76 degrees either way, which friction of 4 still holds.

    Up to a share of 1 of the angle whose tangent is 1/mu_s parts can slip back at all.
    """
    steepest = math.atan(friction)
    slope = share * steepest
    scene = scene_with(
        drive_angle=min(drive * math.atan(1.0 / friction), 0.49 * math.pi - 0.05 - slope),
        trough_angle=slope,
        static_friction=friction,
        kinetic_friction=ratio * friction,
    )
    second = {"friction_ratio": (0.8 * ratio, ratio)} if is_ratio else {}
    trough = (max(slope - 0.05, -0.99 * steepest), min(slope + 0.05, 0.99 * steepest))
    box = uncertainty_set(
        scene, {"static_friction": (friction, 1.3 * friction), "trough_angle": trough, **second}
    )
    points = grid_of(box)
    loads = criticals_of(box)
    assert float(box.hop_load) == pytest.approx(np.min(loads.hop), rel=1e-9)
    assert np.max(loads.forward_onset) <= float(onset_load(box)) * (1 + 1e-12)
    assert float(onset_load(box)) <= np.max(loads.forward_onset) * 1.05
    # down steeper declines than those of Eq. (53) the trough angles of both loads are searched
    slack = 1e-12 if steeper_is_slower(box) else 1e-9
    assert float(back_slip_load(box)) <= np.min(loads.back_slip) * (1 + slack)
    assert float(back_slip_load(box, last=True)) >= np.max(loads.back_slip) * (1 - slack)
    tips = tipping_load_of_lines(points.shape[0], points.static_friction, points.trough_angle, stand)
    assert float(tip_load(box, stand)) <= np.min(tips) * (1 + 1e-12)


@pytest.mark.parametrize("regime", [Regime.FORWARD_SLIP, Regime.BACK_SLIP, Regime.HOPPING])
@examples(3)
@given(box=drawn)
def test_ratios_of_a_line_are_those_that_a_search_finds(regime: Regime, box: Boxed) -> None:
    one = uncertainty_set(box.scene, box.bands)
    field = {1: "forward_onset", 2: "back_slip", 3: "hop"}[int(regime)]

    def critical(scene: Scene) -> Any:
        return getattr(critical_loads(scene), field)

    proved = first_ratio(one, regime), last_ratio(one, regime)
    for ratio, largest in zip(proved, (True, False), strict=True):
        found, _ = extreme_ratio(one, critical, largest=largest)
        slack = 1e-9 * max(ratio, found)
        assert (found <= ratio + slack) if largest else (found >= ratio - slack)
        assert ratio == pytest.approx(found, rel=2e-2)


def test_the_last_part_hops_on_a_level_trough_within_the_band() -> None:
    """It is heaviest there, against the trough: neither end of the band tells."""
    box = uncertainty_set(scene_with(), {"trough_angle": (math.radians(-20.0), math.radians(10.0))})
    level = scene_with()
    expected = float(level.load / critical_loads(level).hop)
    assert last_ratio(box, Regime.HOPPING) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(("least", "braked"), [(0.249327, False), (0.249329, True)])
def test_friction_brakes_down_to_the_angle_of_the_trough(least: float, braked: bool) -> None:
    """tan 14 deg = 0.249328; the steepest decline and the least kinetic friction decide."""
    scene = scene_with(static_friction=0.4, kinetic_friction=0.3, trough_angle=math.radians(-10.0))
    bands = {"kinetic_friction": (least, 0.3), "trough_angle": (math.radians(-14.0), math.radians(5.0))}
    assert is_braked(uncertainty_set(scene, bands)) is braked


@pytest.mark.parametrize(
    ("friction", "troughs", "last"),
    [
        (2.0, (-0.9, -0.2), False),
        (2.0, (-0.8, 0.0), True),
        (2.0, (-0.5, 0.9), True),
        (3.0, (-0.9, -0.2), True),
    ],
)
def test_back_slip_may_begin_first_or_last_between_two_steep_troughs(
    friction: float, troughs: tuple[float, float], last: bool
) -> None:
    """So high a friction holds better on a steeper trough: neither end of the band tells."""
    scene = scene_with(drive_angle=0.1, static_friction=friction, kinetic_friction=0.9 * friction)
    box = uncertainty_set(scene, {"trough_angle": troughs})
    betas = np.linspace(*troughs, 20001)
    loads = critical_loads_of_lines(0.1, friction, 0.9 * friction, betas).back_slip
    expected, ends = (
        (np.max(loads), max(loads[0], loads[-1])) if last else (np.min(loads), min(loads[0], loads[-1]))
    )
    assert abs(expected / ends - 1.0) > 5e-4
    found = float(back_slip_load(box, last=last))
    assert found == pytest.approx(expected, rel=1e-6)
    assert (found >= expected * (1 - 1e-9)) if last else (found <= expected * (1 + 1e-9))


@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize(
    ("friction", "slower"), [(1.0, True), (1.0 / np.tan(0.25 * np.pi), False), (1.1, False)]
)
def test_a_steeper_trough_is_slower_where_friction_is_below_its_slope(
    side: float, friction: float, slower: bool
) -> None:
    """45 degrees either way; the product with 1/tan is 1 to the last bit."""
    assert 1.0 / np.tan(0.25 * np.pi) * np.tan(0.25 * np.pi) == 1.0
    troughs = sorted((side * 0.25 * math.pi, side * 0.1))
    scene = scene_with(static_friction=0.5, kinetic_friction=0.4)
    box = uncertainty_set(scene, {"static_friction": (0.5, friction), "trough_angle": tuple(troughs)})
    assert steeper_is_slower(box) is slower
