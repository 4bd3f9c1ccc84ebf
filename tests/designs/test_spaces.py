"""Settings, points and uncertainty sets: values by hand, ends of bands to the last bit."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from vibro.designs.questions import Drift
from vibro.designs.spaces import SPACES, Setting, UncertaintySet, inside
from vibro.drives import Ellipse, Line

LINES, OVALS = SPACES[Line], SPACES[Ellipse]
TURN = 2.0 * math.pi


def line_box(**changed: Any) -> UncertaintySet:
    """A box of a line with a width along every axis, and others."""
    fields: dict[str, Any] = {
        "space": LINES,
        "factor": (1e-3, 1.5e-3),
        "frequency": (12.0, 15.0),
        "shape": {"drive_angle": (0.3, 0.4)},
        "trough_angle": (-0.1, 0.05),
        "static_friction": (0.4, 0.8),
        "second_friction": (0.3, 0.5),
        "is_ratio": False,
        "gravity": 9.81,
        "restitution": (0.2, 0.3),
    }
    return UncertaintySet(**(fields | changed))


def oval_box(**changed: Any) -> UncertaintySet:
    shape = {"along_amplitude": (1e-3, 1e-3), "normal_amplitude": (2e-4, 3e-4), "normal_phase": (-1.0, -0.5)}
    return line_box(**({"space": OVALS, "factor": (0.9, 1.1), "shape": shape} | changed))


def test_a_line_is_an_ellipse_in_phase() -> None:
    setting = LINES.setting(amplitude=2e-3, frequency=25.0, drive_angle=math.radians(30.0))
    assert setting == pytest.approx((2e-3 * math.cos(math.pi / 6), 1e-3, 0.0, 25.0))
    turned = LINES.turned(setting)
    assert list(turned) == ["amplitude", "frequency", "drive_angle"]
    assert list(turned.values()) == pytest.approx([2e-3, 25.0, math.radians(30.0)])
    assert LINES.leading(setting) == "amplitude"


@pytest.mark.parametrize(
    ("phase", "radius"), [(0.0, 5e-3), (math.pi, 5e-3), (0.5 * math.pi, 4e-3), (-0.5 * math.pi, 4e-3)]
)
def test_the_load_is_the_largest_acceleration_along_the_path(phase: float, radius: float) -> None:
    """3 mm and 4 mm in phase move along 5 mm, a quarter of a turn apart along semi-axes."""
    expected = radius * (TURN * 10.0) ** 2 / 9.81
    assert float(Setting(3e-3, 4e-3, phase, 10.0).load(9.81)) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(
    ("x", "y", "name", "size"), [(3e-3, 1e-3, "along_amplitude", 3e-3), (0.0, 1e-3, "normal_amplitude", 1e-3)]
)
def test_an_ellipse_is_led_by_its_amplitude_along_the_trough(
    x: float, y: float, name: str, size: float
) -> None:
    setting = OVALS.setting(along_amplitude=x, normal_amplitude=y, normal_phase=0.2, frequency=25.0)
    assert (OVALS.leading(setting), OVALS.amplitude(setting)) == (name, size)
    assert OVALS.turned(setting) == {
        "along_amplitude": x, "normal_amplitude": y, "normal_phase": 0.2, "frequency": 25.0,
    }  # fmt: skip


@pytest.mark.parametrize(
    ("angle", "steepest", "expected"),
    [
        (0.5, 1.4, (0.2, 0.8)),
        (0.2, 1.4, (0.0, 0.5)),  # not below the trough
        (1.2, 1.4, (0.9, 1.4)),  # not beyond the right angle
        (1.2, 1.1, (0.9, 1.2)),  # the nominal angle itself always
    ],
)
def test_the_drift_of_a_drive_angle_is_cut(
    angle: float, steepest: float, expected: tuple[float, float]
) -> None:
    setting = LINES.setting(amplitude=2e-3, frequency=25.0, drive_angle=angle)
    drift = Drift(amplitude=0.05, drive_angle=0.1, normal_phase=9.0)
    factor, shape = LINES.band(setting, drift, 3.0, steepest)
    assert factor == pytest.approx((2e-3 * 0.85, 2e-3 * 1.15))
    assert shape["drive_angle"] == pytest.approx(expected)


def test_shares_of_a_band_are_exact_at_both_ends() -> None:
    """0.3 + (0.9 - 0.3) is more than 0.9 in doubles."""
    found = inside((0.3, 0.9), np.array([0.0, 0.25, 1.0]))
    assert found.tolist() == [0.3, pytest.approx(0.45), 0.9]
    below = np.nextafter(1.0, 0.0)
    assert 0.3 + below * (0.9 - 0.3) <= float(inside((0.3, 0.9), np.array(below))) <= 0.9


@pytest.mark.parametrize("troughs", [(-0.3, 0.1), (-0.1, 0.3)])
def test_the_first_body_hops_on_the_steepest_trough_with_the_steepest_drive(troughs: Any) -> None:
    expected = math.cos(0.3) / math.sin(0.4)
    assert float(line_box(trough_angle=troughs).hop_load) == pytest.approx(expected, rel=1e-12)
    assert float(oval_box(trough_angle=troughs).hop_load) == pytest.approx(math.cos(0.3) / 3e-4, rel=1e-12)


@pytest.mark.parametrize(("factor", "hops"), [(1.0, False), (1.0 + 1e-12, True), (1.0 - 1e-12, False)])
def test_a_body_hops_above_a_throw_number_of_one(factor: float, hops: bool) -> None:
    """A vertical drive of just the weight: load and throw number are 1 to the last bit."""
    box = line_box(
        factor=(1e-3, 1e-3), frequency=(15.0, 15.0), shape={"drive_angle": (0.5 * math.pi,) * 2},
        trough_angle=(0.0, 0.0), gravity=1e-3 * (TURN * 15.0) ** 2 / factor,
    )  # fmt: skip
    assert box.throw_number == pytest.approx(factor, rel=1e-13)
    assert (box.throw_number == 1.0) is (factor == 1.0)
    assert box.may_hop is hops
    assert box.hops(box.points(np.zeros((6, 1)))).tolist() == [hops]


def test_the_corner_of_no_kinetic_friction_is_cut() -> None:
    """Static friction begins at the least kinetic one, and kinetic friction ends at the static one."""
    box = line_box(static_friction=(0.2, 0.8))
    assert box.static_span == (0.3, 0.8)
    assert [float(x) for x in box.kinetic_span(np.asarray(0.4))] == [0.3, 0.4]
    assert [float(x) for x in box.kinetic_span(np.asarray(0.7))] == [0.3, 0.5]
    ratio = line_box(static_friction=(0.2, 0.8), second_friction=(0.5, 0.9), is_ratio=True)
    assert ratio.static_span == (0.2, 0.8)
    assert [float(x) for x in ratio.kinetic_span(np.asarray(0.4))] == pytest.approx([0.2, 0.36])


@pytest.mark.parametrize("is_ratio", [False, True])
@pytest.mark.parametrize("box", [line_box, oval_box])
def test_points_have_the_coordinates_that_they_were_made_of(box: Any, is_ratio: bool) -> None:
    """A coordinate of a band without a width is 0."""
    made = box(static_friction=(0.2, 0.8), is_ratio=is_ratio)
    shares = np.linspace(0.0, 1.0, 9) * np.ones((len(made.axes), 1))
    shares[-2:] = shares[-2:, ::-1]
    expected = np.where(made.varies[:, None], shares, 0.0)
    if not is_ratio:
        expected[-2, 0] = 0.0  # at the least static friction there is one kinetic friction alone
    np.testing.assert_allclose(made.coordinates(made.points(shares)), expected, atol=1e-14)
