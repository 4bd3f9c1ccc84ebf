"""Pictures of one axis."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import pytest
from helpers.drawn import GRAVITY, curve, legend, said, sweep, words
from matplotlib.colors import to_rgb

import vibro
from vibro.plots import map_figures
from vibro.plots.style import COEXISTS_LABEL, REGIME_COLOURS
from vibro.results.sweep import SweepResult

if TYPE_CHECKING:
    from matplotlib.figure import Figure

pytestmark = pytest.mark.usefixtures("unarranged")


def test_speed_and_displacement_over_one_axis(line_pictures: dict[str, Figure]) -> None:
    assert list(line_pictures) == ["speed", "traverse"]
    labels = [axes.get_ylabel() for axes in line_pictures["speed"].axes]
    assert labels == ["", "mean conveying speed [mm/s]", "displacement per cycle [mm]"]
    assert line_pictures["speed"].axes[-1].get_xlabel() == "amplitude $A$ [mm]"
    assert line_pictures["traverse"].axes[1].get_ylabel() == "traverse time [s]"


def test_numbers_are_those_of_the_sweep(line_pictures: dict[str, Figure], one_axis: SweepResult) -> None:
    for axes, expected in (
        (line_pictures["speed"].axes[1], 1e3 * one_axis.cycle.mean_velocity),
        (line_pictures["speed"].axes[2], 1e3 * one_axis.cycle.displacement_per_cycle),
    ):
        (line,) = [line for line in axes.lines if line.get_gid() == "numbers"]
        x, y = np.asarray(line.get_xdata(), float), np.asarray(line.get_ydata(), float)
        np.testing.assert_array_equal(x[~np.isnan(x)], one_axis.axes["amplitude"].values)
        np.testing.assert_array_equal(y[~np.isnan(x)], expected)
        assert np.isnan(x).sum() == 3  # broken at the three transitions


def test_bands_meet_at_the_critical_loads(line_pictures: dict[str, Figure], one_axis: SweepResult) -> None:
    strip = line_pictures["speed"].axes[0]
    bands = {p.get_gid(): p.get_extents().transformed(strip.transData.inverted()) for p in strip.patches}
    scale = 1e3 * GRAVITY / (2 * math.pi * 15) ** 2
    onset, back, hop = (
        scale * getattr(one_axis.limits, name).item() for name in ("forward_onset", "back_slip", "hop")
    )
    edges = {
        "no-slip": (0.1, onset),
        "forward-slip": (onset, back),
        "back-slip": (back, hop),
        "hopping": (hop, 4),
    }
    assert bands.keys() == edges.keys()
    for name, (low, high) in edges.items():
        assert (bands[name].x0, bands[name].x1) == (pytest.approx(low), pytest.approx(high))
    assert words(strip) == list(edges)


def test_bands_between_two_points_have_their_own_regime() -> None:
    """Of three points none lies in forward slip: its band is there all the same."""
    t = vibro.sweep(
        amplitude_mm="0.1:4:3",
        frequency_hz=15,
        drive_angle_deg=20,
        static_friction=0.74,
        kinetic_friction=0.57,
    )
    strip = t.draw("speed").axes[0]
    assert [p.get_gid() for p in strip.patches] == ["no-slip", "forward-slip", "back-slip", "hopping"]


def test_bands_shade_every_panel(line_pictures: dict[str, Figure]) -> None:
    for axes in line_pictures["speed"].axes[1:]:
        colours = {p.get_gid(): to_rgb(p.get_facecolor()) for p in axes.patches if not p.get_hatch()}
        assert colours == {regime.label: to_rgb(REGIME_COLOURS[regime]) for regime in REGIME_COLOURS}


def test_critical_values_are_in_the_legend(line_pictures: dict[str, Figure]) -> None:
    assert {
        "forward-slip onset: 0.68517 mm",
        "back-slip onset: 1.1903 mm",
        "continuous sliding: 1.5623 mm",
        "hop limit: 3.2291 mm",
        "operating point",
    } <= set(legend(line_pictures["speed"]))


def test_the_operating_point_lies_on_the_line(line_pictures: dict[str, Figure]) -> None:
    speed = curve(line_pictures["speed"].axes[1], "operating point")
    assert speed[0].tolist() == [1, pytest.approx(16.263456166287, rel=1e-5)]
    time = curve(line_pictures["traverse"].axes[1], "operating point")
    assert time[0].tolist() == [1, pytest.approx(600 / 16.263456166287, rel=1e-5)]


def test_narrow_bands_and_statuses_are_in_the_legend() -> None:
    figure = map_figures(sweep(amplitude="0.1:30", trough_angle=0), ["speed"])["speed"]
    assert {"no-slip", "forward-slip"} <= set(legend(figure))
    assert "hopping" in words(figure.axes[0])


def test_reversal_and_runaway() -> None:
    figures = map_figures(sweep(length=600, amplitude=1.5, trough_angle="-35:35"))
    assert "runaway" in said(figures["speed"])
    (line,) = [line for line in figures["traverse"].axes[1].lines if line.get_gid() == "numbers"]
    time = np.asarray(line.get_ydata(), float)
    assert np.nanmin(time) > 0  # nothing where the body moves backwards
    assert np.isnan(time).mean() > 0.3


def test_a_logarithmic_axis() -> None:
    figure = map_figures(sweep(amplitude="0.1:10:log"), ["speed"])["speed"]
    assert {axes.get_xscale() for axes in figure.axes} == {"log"}


def test_coexisting_cycles() -> None:
    result = sweep(amplitude="0.1:2", drive_angle=30, static_friction=0.4, kinetic_friction=0.02)
    figure = map_figures(result, ["speed"])["speed"]
    assert COEXISTS_LABEL in legend(figure)
    hatched = [p for p in figure.axes[1].patches if p.get_gid() == COEXISTS_LABEL]
    assert {p.get_hatch() for p in hatched} == {"..."}


def test_flight_over_one_axis(one_axis: SweepResult) -> None:
    figures = map_figures(one_axis, ["impact", "flight"])
    for name, label, expected in (
        ("impact", "impact speed [mm/s]", 1e3 * one_axis.cycle.impact_velocity),
        ("flight", "share of time in flight", one_axis.cycle.flight_fraction),
    ):
        _, axes = figures[name].axes
        assert axes.get_ylabel() == label
        (line,) = [line for line in axes.lines if line.get_gid() == "numbers"]
        y = np.asarray(line.get_ydata(), float)
        np.testing.assert_array_equal(y[~np.isnan(y)], expected)


@pytest.mark.parametrize("level", [20.0, 1000.0])
def test_a_speed_that_is_asked_for_is_a_line_across(one_axis: SweepResult, level: float) -> None:
    axes = map_figures(one_axis, ["speed"], target_speed=level)["speed"].axes[1]
    (line,) = [line for line in axes.lines if line.get_gid() == "level"]
    assert set(np.asarray(line.get_ydata(), float)) == {level}
    assert axes.get_ylim()[1] > level
    assert f"{level:g} mm/s" in words(axes)
