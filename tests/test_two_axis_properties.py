"""What holds for every elliptical drive: symmetries, scales, and what a drive along a line already tells."""

from __future__ import annotations

import numpy as np
from helpers.scenes import assert_same
from helpers.two_axis_scenes import (
    FREQUENCY,
    GRAVITY,
    UNIT,
    Drives,
    contact_drives,
    displacement,
    random_drives,
    rounding,
)
from hypothesis import assume, given
from hypothesis import strategies as st

import vibro
from vibro import Regime, Scene, Status

MIRRORED = {"": "", "_": "_", "F_": "B_", "B_": "F_", "F_B_": "F_B_", "FB_": "F_B", "F_B": "FB_", "FB": "FB"}


def _clear_of_boundaries(some: Drives) -> np.ndarray:
    """Whether a rounding of the inputs changes no pattern."""
    near = [some.changed(**{name: getattr(some, name) * (1.0 + h)}).scaled(1.0 + h).solve()
            for name in ("lead", "trough") for h in (-1e-11, 1e-11)]  # fmt: skip
    same = np.all([cycle.pattern == near[0].pattern for cycle in near], axis=0)
    return np.asarray(same & np.all([cycle.status == near[0].status for cycle in near], axis=0))


# --- the trough seen from its other end -------------------------------------------------------------


def _assert_mirrored(some: Drives) -> set[str]:
    """Compare both views of scenes where one motion alone is stable: one view starts half a turn later."""
    here, there = some.solve(), some.mirrored().solve()
    single = (here.coexists != 1) & (there.coexists != 1) & _clear_of_boundaries(some)
    expected = np.array([MIRRORED[text] for text in here.pattern.tolist()])
    assert there.pattern[single].tolist() == expected[single].tolist()
    assert there.status[single].tolist() == here.status[single].tolist()
    apart = np.abs(displacement(here) + displacement(there))
    assert not (apart > 16.0 * rounding(some, here))[single].any()
    moves = single & (here.peak_velocity > 0.0)
    np.testing.assert_allclose(there.peak_velocity[moves], here.peak_velocity[moves], rtol=1e-9)
    return set(here.pattern[single].tolist())


def test_a_trough_seen_from_its_other_end_conveys_as_much() -> None:
    assert _assert_mirrored(random_drives(2000, 26, steepest=0.95, least_ratio=0.1)) == set(MIRRORED)
    assert len(_assert_mirrored(random_drives(2000, 27, least_ratio=0.1))) == len(MIRRORED) - 1


@given(contact_drives())
def test_any_trough_seen_from_its_other_end_conveys_as_much(one: Drives) -> None:
    _assert_mirrored(one)


# --- scales -----------------------------------------------------------------------------------------


@given(contact_drives(), st.floats(0.01, 100.0))
def test_similar_scenes_move_alike(one: Drives, scale: float) -> None:
    assume(_clear_of_boundaries(one).all())
    here, there = one.solve(), vibro.solve(one.scene(similar=scale))
    assert here.pattern.tolist() == there.pattern.tolist()
    apart = np.abs(displacement(here) - displacement(there) * scale**2)
    assert not (apart > 32.0 * rounding(one, here)).any()


# --- drives along a line ----------------------------------------------------------------------------


def _assert_line(some: Drives) -> None:
    """Compare drives without a lead with the same ones given by amplitude and drive angle."""
    some = some.changed(lead=0.0)
    angle = np.arctan2(some.normal, some.along)
    # the cosine of an angle that is rounded near 90 deg is no longer that of the pair
    some = Drives(*(x[(angle < 1.4) & (angle + some.trough < 1.57)] for x in some))
    ellipse, clear = some.solve(), _clear_of_boundaries(some)
    line = vibro.solve(
        Scene(
            amplitude=np.hypot(some.along, some.normal) * UNIT,
            drive_angle=np.arctan2(some.normal, some.along),
            frequency=FREQUENCY,
            static_friction=some.mu_s,
            kinetic_friction=some.mu_d,
            trough_angle=some.trough,
            gravity=GRAVITY,
        )
    )
    assert_same(ellipse, line, names=["regime"])
    for name in ("pattern_code", "status", "coexists"):
        np.testing.assert_array_equal(getattr(ellipse, name)[clear], getattr(line, name)[clear], name)
    apart = np.abs(displacement(ellipse) - displacement(line))
    assert not (apart > 32.0 * rounding(some, ellipse))[clear].any()
    pushed_back = some.along > 1.001 * some.mu_s * some.normal  # else the ratio is no one's onset
    for name in ("throw_number", "forward_ratio", "back_ratio", "peak_velocity"):
        told = clear & (pushed_back | (name != "back_ratio"))
        left, right = getattr(ellipse, name)[told], getattr(line, name)[told]
        np.testing.assert_allclose(left, right, rtol=1e-9, atol=1e-300, err_msg=name)


def test_without_a_lead_drives_are_those_along_a_line() -> None:
    _assert_line(random_drives(2000, 29, steepest=0.9, least_ratio=0.1))


@given(contact_drives())
def test_without_a_lead_any_drive_is_one_along_a_line(one: Drives) -> None:
    _assert_line(one)


# --- grids ------------------------------------------------------------------------------------------


def test_fields_of_ellipses_broadcast() -> None:
    grid = Scene(
        along_amplitude=np.array([0.5, 1.0, 2.0])[:, None] * UNIT,
        normal_amplitude=0.3 * UNIT,
        normal_phase=np.linspace(-3.0, 3.0, 5),
        frequency=FREQUENCY,
        static_friction=0.4,
        kinetic_friction=0.3,
    )
    cycle = vibro.solve(grid)
    assert cycle.mean_velocity.shape == grid.shape == (3, 5)
    assert (cycle.mean_velocity < 0.0).any()
    assert (cycle.mean_velocity > 0.0).any()


# --- growing loads ----------------------------------------------------------------------------------


def test_classes_come_in_one_order_with_growing_load() -> None:
    some = random_drives(300, 22, steepest=0.35, throw=(1e-3, 1e-2))
    factors = np.geomspace(0.3, 1.1 / some.normal.min(), 120)
    order = np.array(
        [vibro.solve(some.scaled(f).scene(), output="regimes").regime for f in factors], dtype=np.int64
    )
    assert (np.diff(order, axis=0) >= 0).all()
    assert set(np.unique(order)) >= set(Regime) - {Regime.UNDEFINED}
    exact = vibro.solve(some.scaled(factors[60]).scene(), flight=False)
    told = (exact.status == Status.OK) & (exact.regime != Regime.HOPPING)
    np.testing.assert_array_equal(exact.regime[told], order[60][told])
