"""Scenarios: which bodies join, which of them move with a drop of the speed, and to where."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from helpers.scenes import scene_with

from vibro import Regime, solve
from vibro.designs.questions import Scenarios, _drop_axis, _moved_to_drops, _slips_back, at_loads, entry_loads
from vibro.designs.spaces import UncertaintySet, uncertainty_set
from vibro.limits import critical_loads_of_lines

DRIVE = math.radians(20.0)
AXES = ("load", "drive_angle", "trough_angle", "static_friction", "second_friction")


def box_of(amplitude: Any = 1e-3, **bands: Any) -> UncertaintySet:
    if isinstance(amplitude, tuple):
        bands["amplitude"], amplitude = amplitude, amplitude[0]
    return uncertainty_set(scene_with(amplitude=amplitude), bands)


def body(**shares: float) -> Any:
    """Coordinates of one body; 0 along the axes that are left out."""
    return np.array([[shares.get(axis, 0.0)] for axis in AXES])


def entry(mu_s: Any = 0.74, mu_d: Any = 0.57, alpha: Any = DRIVE) -> Any:
    return critical_loads_of_lines(alpha, mu_s, mu_d, 0.0).back_slip


def load_of(amplitude: float) -> float:
    return amplitude * (2.0 * math.pi * 15.0) ** 2 / 9.81


def row(box: UncertaintySet) -> UncertaintySet:
    """Return a box as one of many, of which each has a row."""
    low, high = box.factor
    return replace(box, factor=(np.array([[low]]), np.array([[high]])))


# [m] Back slip of the published example enters here.
ENTRY = float(entry()) / load_of(1.0)


def test_fixed_bodies_stay_where_they_are() -> None:
    coordinates = np.random.default_rng(0).random((5, 3))
    fixed = Scenarios.fixed(coordinates)
    assert fixed.size == 3
    assert fixed.axes.tolist() == [-1, -1, -1]
    assert fixed.ratios.tolist() == [1.0, 1.0, 1.0]
    low = np.array([[1e-3], [2e-3]])
    many = replace(box_of(static_friction=(0.6, 0.8)), factor=(low, 1.1 * low))
    np.testing.assert_array_equal(fixed.at(many), np.stack([coordinates, coordinates], axis=1))


def test_bodies_join_at_loads_of_the_whole_band_and_at_their_own() -> None:
    two = np.hstack([body(load=0.9, static_friction=0.2), body(load=0.8, static_friction=0.7)])
    found = at_loads(box_of((1e-3, 2e-3)), two, 0.3)
    assert found[0].tolist() == [0.0, 0.25, 0.5, 0.75, 1.0, 0.3] * 2
    assert found[3].tolist() == [0.2] * 6 + [0.7] * 6
    assert at_loads(box_of(), two, 0.3)[0].tolist() == [0.0, 0.0]
    assert at_loads(box_of(), two, 0.3)[3].tolist() == [0.2, 0.7]


def test_loads_at_which_back_slip_enters() -> None:
    box = box_of((1e-3, 2e-3), static_friction=(0.7, 0.8), drive_angle=(DRIVE, math.radians(75.0)))
    bodies = np.hstack([body(load=0.3, static_friction=s) for s in (0.0, 1.0)] + [body(drive_angle=1.0)])
    found = entry_loads(box, box.points(bodies))
    assert found[:2] == pytest.approx(entry(np.array([0.7, 0.8])), rel=1e-12)
    assert found[2] == math.inf  # so steep a drive never slips parts back
    bare = box_of((1e-3, 2e-3), static_friction=(0.0, 0.8), friction_ratio=(0.5, 0.9))
    assert entry_loads(bare, bare.points(body())).tolist() == [math.inf]  # nor without friction


def test_a_body_past_its_entry_within_the_band_keeps_to_that_load() -> None:
    low, high = 1.0e-3, 1.6e-3
    box = box_of((low, high))
    shares = [0.0, 0.2, 0.5, 1.0]
    bodies = np.hstack([body(load=share) for share in shares])
    joined = Scenarios.fixed(np.zeros((5, 0))).joined(box, bodies)
    loads = np.array([load_of(low + share * (high - low)) for share in shares])
    ratios = loads / (float(entry()) * (1.0 + 1e-9))
    assert (ratios >= 1.0).tolist() == [False, False, True, True]
    assert joined.axes.tolist() == [-1, -1, 0, -1]  # an end of the band stays one
    assert joined.ratios.tolist() == pytest.approx([1.0, 1.0, ratios[2], 1.0], rel=1e-12)
    np.testing.assert_array_equal(joined.coordinates, bodies)
    # in another box it is at the same ratio to its entry, and within the band in any case
    for ends in ((1.1e-3, 1.5e-3), (1.31e-3, 1.5e-3), (1e-3, 1.25e-3)):
        first, last = (load_of(x) for x in ends)
        at = joined.at(row(box_of(ends)))[:, 0, :]
        expected = (ratios[2] * float(entry()) * (1.0 + 1e-9) - first) / (last - first)
        assert at[0].tolist() == pytest.approx([0.0, 0.2, min(max(expected, 0.0), 1.0), 1.0], rel=1e-9)


def test_a_body_that_keeps_to_a_load_is_at_the_end_of_a_band_without_width() -> None:
    scenarios = Scenarios(body(load=0.4), np.array([0]), np.array([1.1]))
    amplitude = 1.1 * float(entry()) * (1.0 + 1e-9) * 9.81 / (2.0 * math.pi * 15.0) ** 2
    for size, share in ((0.9 * amplitude, 1.0), (1.1 * amplitude, 0.0)):
        assert scenarios.at(row(box_of((size, size))))[0].tolist() == [[share]]
    steep = uncertainty_set(scene_with(drive_angle=math.radians(75.0)), {"amplitude": (1e-3, 2e-3)})
    assert scenarios.at(row(steep))[0].tolist() == [[1.0]]  # it never enters


def test_no_body_joins_twice() -> None:
    box = box_of((1.0e-3, 1.6e-3), static_friction=(0.7, 0.8))
    first = np.hstack([body(load=0.2, static_friction=0.5), body(load=0.2, static_friction=0.8)])
    scenarios = Scenarios.fixed(body()).joined(box, first)
    assert scenarios.size == 3
    again = scenarios.joined(box, first + 1e-8)  # six decimals decide
    assert again.size == 3
    more = scenarios.joined(box, np.hstack([first, body(load=0.2, static_friction=0.9)]))
    assert more.size == 4
    assert more.coordinates[3].tolist() == [0.0, 0.5, 0.8, 0.9]
    assert scenarios.joined(box, np.zeros((5, 0))) is scenarios


def test_bodies_of_one_drop_differ_in_the_other_coordinates_alone() -> None:
    """Along the axis of the drop a body moves anyway, so that its place there makes no other body."""
    moving = Scenarios(
        np.hstack([body(static_friction=s, load=0.5) for s in (0.3, 0.6)]), np.array([3, 3]), np.ones(2)
    )
    assert len(set(moving._keys())) == 1
    fixed = moving._replace(axes=np.array([-1, -1]))
    assert len(set(fixed._keys())) == 2
    assert len(set(moving._replace(ratios=np.array([1.0, 1.1]))._keys())) == 2
    np.testing.assert_array_equal(moving.coordinates[3], [0.3, 0.6])


# Bands about a drop, whether parts slip back at their upper end, and the amplitude of the drop within [m].
# Kinetic friction has one where it is so low that the forward slide outlasts the back window.
DROPS: list[tuple[str, tuple[float, float], bool, float]] = [
    ("static_friction", (0.70, 0.78), False, ENTRY),
    ("kinetic_friction", (0.08, 0.15), True, float(entry(mu_d=0.11)) / load_of(1.0)),
    ("drive_angle", (math.radians(18.0), math.radians(22.0)), False, ENTRY),
]


def drop_of(box: UncertaintySet, axis: int) -> float:
    """Bisect the share of a band at which back slip enters, by solved bodies."""
    low, high = 0.0, 1.0

    def slips(share: float) -> bool:
        at = np.zeros((5, 1))
        at[axis] = share
        return bool(solve(box.scene(box.points(at), fast=False)).regime[0] >= Regime.BACK_SLIP)

    first = slips(low)
    assert first != slips(high)
    for _ in range(45):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if slips(middle) == first else (low, middle)
    return low


@pytest.mark.parametrize(("name", "band", "slips", "amplitude"), DROPS)
def test_a_body_on_a_drop_joins_as_one_that_follows_it(
    name: str, band: tuple[float, float], slips: bool, amplitude: float
) -> None:
    box = box_of(amplitude, **{name: band})
    axis = [1, 3, 4][["drive_angle", "static_friction", "kinetic_friction"].index(name)]
    drop = drop_of(box, axis)
    for offset, expected in ((0.0, axis), (5e-7, axis), (-5e-7, axis), (3e-6, -1), (-3e-6, -1)):
        at = np.zeros((5, 1))
        at[axis] = drop + offset
        assert _drop_axis(box, at) == expected
        assert Scenarios.fixed(np.zeros((5, 0))).joined(box, at).axes.tolist() == [expected]
    # at another amplitude it moves to the drop there, a billionth of the way past it
    for factor in (0.998, 1.002):
        there = box_of(factor * amplitude, **{name: band})
        moved = Scenarios(np.full((5, 1), 0.5), np.array([axis]), np.ones(1)).at(row(there))[:, 0, :]
        others = [i for i in range(5) if i != axis]
        assert moved[others].tolist() == [[0.5]] * 4
        place = drop_of(there, axis)
        past = 1.0 - place if slips else place  # of the way back to the end that slips
        assert abs(moved[axis, 0] - place) == pytest.approx(1e-9 * past, rel=0.01)
        assert bool(moved[axis, 0] > place) is slips
        assert _slips_back(there, there.points(moved)).tolist() == [True]


def test_a_body_without_a_drop_in_a_box_stays() -> None:
    band = {"static_friction": (0.70, 0.78)}
    for amplitude in (0.5 * ENTRY, 2.5 * ENTRY):  # none, and all of the band slips back
        moved = _moved_to_drops(row(box_of(amplitude, **band)), np.full((5, 1, 1), 0.37), np.array([3]))
        assert moved.ravel().tolist() == [0.37] * 5


def test_bodies_that_hop_have_passed_the_entry_of_back_slip() -> None:
    box = box_of((1e-3, 4e-3))
    bodies = np.hstack([body(load=share) for share in (0.0, 0.4, 1.0)])
    regimes = solve(box.scene(box.points(bodies), fast=False)).regime
    assert regimes.tolist() == [Regime.FORWARD_SLIP, Regime.BACK_SLIP, Regime.HOPPING]
    assert _slips_back(box, box.points(bodies)).tolist() == [False, True, True]


@pytest.mark.parametrize(
    ("names", "axis"),
    [
        (("static_friction", "kinetic_friction", "drive_angle"), 3),
        (("static_friction", "drive_angle"), 3),
        (("kinetic_friction", "drive_angle"), 4),
        (("drive_angle", "trough_angle"), 1),
        (("trough_angle",), -1),  # along it back slip enters twice, or not at all
    ],
)
def test_the_drop_is_looked_for_along_frictions_first(names: tuple[str, ...], axis: int) -> None:
    """At a point of the drop that all bands cross; bands without a width are passed over."""
    values = {"static_friction": 0.74, "kinetic_friction": 0.11, "drive_angle": DRIVE, "trough_angle": 0.0}
    amplitude = float(entry(mu_d=0.11)) / load_of(1.0)
    bands = {name: (values[name] - 0.02, values[name] + 0.02) for name in names}
    box = uncertainty_set(scene_with(amplitude=amplitude, **values), bands)
    at = np.where(box.varies, 0.5, 0.0)[:, None]
    assert box.varies.sum() == len(names)
    for step in (-1e-7, 1e-7):  # within reach of every band
        assert _drop_axis(box, at + step * box.varies[:, None]) == axis
