"""Pictures of one range over bands of its regimes, and of short lists: a curve or a point for every value."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from helpers.drawn import (
    GRAVITY,
    NUT,
    OWN,
    curve,
    legend,
    pictures_of,
    said,
    sweep,
    unarranged,
    words,
)
from matplotlib.colors import to_hex, to_rgb

from vibro import Regime, Scene, solve
from vibro.plots import map_figures
from vibro.plots.style import BACKWARDS_LABEL, ERROR_LABEL, REGIME_COLOURS
from vibro.quantities import scene_fields

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D
    from numpy.typing import NDArray

    from vibro.results.sweep import SweepResult

    Floats = NDArray[np.float64]

pytestmark = pytest.mark.usefixtures("unarranged")

FRICTIONS = (0.4, 0.6, 0.74)


@pytest.fixture(scope="module")
def curves() -> SweepResult:
    own = {**OWN, "friction_ratio": 0.77}
    del own["kinetic_friction"]
    frictions = ",".join(map(str, FRICTIONS))
    return sweep(
        own=own, length=600, points=801, amplitude="0.1:4", static_friction=frictions, friction_ratio=0.77
    )


@pytest.fixture(scope="module")
def curve_pictures(curves: SweepResult) -> dict[str, Figure]:
    with unarranged():
        return map_figures(curves, ["speed", "traverse", "impact", "flight"])


def numbers(axes: Axes) -> list[Line2D]:
    return [line for line in axes.lines if line.get_gid() == "numbers"]


def points(line: Line2D) -> tuple[Floats, Floats]:
    """Return the points of a curve, without the gaps at which it is broken."""
    x, y = np.asarray(line.get_xdata(), float), np.asarray(line.get_ydata(), float)
    return x[np.isfinite(x)], y[np.isfinite(x)]


def solved(**changes: Any) -> Any:
    """Solve the paper's scene with some quantities changed, in the units outside."""
    given: dict[str, Any] = {**NUT, "gravity": GRAVITY, **changes}
    if "friction_ratio" in given:
        del given["kinetic_friction"]
    return solve(Scene(**scene_fields(given)))


def test_a_picture_for_every_number(line_pictures: dict[str, Figure], one_axis: SweepResult) -> None:
    assert list(line_pictures) == ["speed", "traverse"]
    strip, axes = line_pictures["speed"].axes
    assert axes.get_xlabel() == "amplitude $A$ [mm]"
    assert axes.get_ylabel() == "mean conveying speed [mm/s]"
    assert strip.get_xlim() == axes.get_xlim() == (0.1, 4.0)
    assert line_pictures["traverse"].axes[1].get_ylabel() == "traverse time [s]"
    (line,) = numbers(axes)
    x, y = points(line)
    np.testing.assert_array_equal(x, one_axis.axes["amplitude"].values)
    np.testing.assert_array_equal(y, 1e3 * one_axis.cycle.mean_velocity)
    assert len(np.asarray(line.get_xdata())) - len(x) == 3  # broken at the three transitions


def test_bands_meet_at_the_critical_loads(line_pictures: dict[str, Figure], one_axis: SweepResult) -> None:
    scale = 1e3 * GRAVITY / (2 * math.pi * 15) ** 2
    names = ("forward_onset", "back_slip", "hop")
    inner = [scale * getattr(one_axis.limits, name).item() for name in names]
    regimes = ["no-slip", "forward-slip", "back-slip", "hopping"]
    edges = dict(zip(regimes, pairwise([0.1, *inner, 4.0]), strict=True))
    strip, axes = line_pictures["speed"].axes
    for panel in (strip, axes):
        bands = {p.get_gid(): p.get_extents().transformed(panel.transData.inverted()) for p in panel.patches}
        assert {name: tuple(box.intervalx) for name, box in bands.items()} == {
            name: pytest.approx(ends) for name, ends in edges.items()
        }
        colours = {p.get_gid(): to_rgb(p.get_facecolor()) for p in panel.patches}
        assert colours == {regime.label: to_rgb(REGIME_COLOURS[regime]) for regime in REGIME_COLOURS}
    assert words(strip) == list(edges)


def test_critical_values_are_in_the_legend_and_the_operating_point_on_the_line(
    line_pictures: dict[str, Figure],
) -> None:
    assert {
        "forward-slip onset: 0.68517 mm",
        "back-slip onset: 1.1903 mm",
        "continuous sliding: 1.5623 mm",
        "hop limit: 3.2291 mm",
        "operating point",
    } <= set(legend(line_pictures["speed"]))
    speed = curve(line_pictures["speed"].axes[1], "operating point")
    assert speed[0].tolist() == [1, pytest.approx(16.263456166287, rel=1e-5)]
    time = curve(line_pictures["traverse"].axes[1], "operating point")
    assert time[0].tolist() == [1, pytest.approx(600 / 16.263456166287, rel=1e-5)]


def test_a_band_without_room_for_its_name_is_in_the_legend_if_it_is_seen() -> None:
    figure = map_figures(sweep(amplitude="0.1:30"), ["speed"])["speed"]
    assert {"no-slip", "forward-slip"} <= set(legend(figure))
    assert "hopping" in words(figure.axes[0])
    narrow = map_figures(sweep(amplitude="0.1:3000"), ["speed"])["speed"]
    assert {"no-slip", "forward-slip"}.isdisjoint(said(narrow))


def test_what_is_special_of_a_range_is_hatched() -> None:
    figures = pictures_of(sweep(length=600, amplitude=1.5, trough_angle="-35:35"))
    assert "runaway" in said(figures["speed"])
    (line,) = numbers(figures["traverse"].axes[1])
    assert np.nanmin(np.asarray(line.get_ydata(), float)) > 0  # nothing where the body moves backwards
    hatched = [p for p in figures["speed"].axes[1].patches if p.get_gid() == BACKWARDS_LABEL]
    edge, _ = hatched[0].get_extents().transformed(figures["speed"].axes[1].transData.inverted()).intervalx
    before, after = solved(amplitude=1.5, trough_angle=edge + np.array([-0.02, 0.02])).mean_velocity
    assert before > 0.0 > after
    assert BACKWARDS_LABEL in legend(figures["speed"])


def test_one_curve_a_value_with_the_numbers_of_the_solver(curve_pictures: dict[str, Figure]) -> None:
    shown: dict[str, Callable[[Any], Floats]] = {
        "speed": lambda cycle: 1e3 * cycle.mean_velocity,
        "traverse": lambda cycle: cycle.traverse_time(0.6),
        "impact": lambda cycle: 1e3 * cycle.impact_velocity,
        "flight": lambda cycle: cycle.flight_fraction,
    }
    for name, result in shown.items():
        (axes,) = curve_pictures[name].axes
        lines = numbers(axes)
        labels = [rf"$\mu_s$ = {value}" for value in FRICTIONS]
        assert [line.get_label() for line in lines] == labels
        assert [text for text in legend(curve_pictures[name]) if text in labels] == labels
        for line, value in zip(lines, FRICTIONS, strict=True):
            x, y = points(line)
            assert (x[0], x[-1], x.size) == (0.1, 4.0, 201)
            expected = result(solved(amplitude=x, static_friction=value, friction_ratio=0.77))
            expected = np.where(np.isfinite(expected), expected, np.nan)
            np.testing.assert_allclose(y, expected, rtol=1e-13)


def test_curves_are_marked_where_regimes_begin(
    curve_pictures: dict[str, Figure], curves: SweepResult
) -> None:
    scale = 1e3 * GRAVITY / (2 * math.pi * 15) ** 2
    (axes,) = curve_pictures["speed"].axes
    for name, regime in (("forward_onset", Regime.FORWARD_SLIP), ("hop", Regime.HOPPING)):
        marks = [line for line in axes.lines if line.get_gid() == name]
        found = [float(np.ravel(line.get_xdata())[0]) for line in marks]
        expected = np.broadcast_to(scale * getattr(curves.limits, name), (1, 3))[0]
        assert found == pytest.approx(expected.tolist(), rel=1e-12)
        assert {to_hex(line.get_markerfacecolor()) for line in marks} == {REGIME_COLOURS[regime].lower()}
        assert f"{regime.label} begins or ends" in legend(curve_pictures["speed"])
    speed = 1e3 * float(solved(static_friction=0.74, friction_ratio=0.77).mean_velocity)
    assert curve(axes, "operating point").tolist() == [[1.0, pytest.approx(speed, rel=1e-4)]]


def test_a_panel_says_for_which_values_there_are_no_numbers() -> None:
    result = sweep(points=101, amplitude="0.1:3", static_friction="0.3,0.4,0.6", kinetic_friction=0.5)
    axes = map_figures(result, ["speed"])["speed"].axes[0]
    assert words(axes) == ["infeasible: 0.3, 0.4"]
    assert [np.isfinite(points(line)[1]).any() for line in numbers(axes)] == [False, False, True]
    hops = sweep(flight=False, points=101, amplitude="3:4", drive_angle="20, 25")
    axes = map_figures(hops, ["speed"])["speed"].axes[0]
    assert words(axes) == ["flight not modelled in part: 20°\nflight not modelled: 25°"]


@pytest.mark.parametrize("restitution", [0.6])
def test_a_list_alone_is_points_in_the_colours_of_their_regimes(restitution: float) -> None:
    values = np.array([0.5, 1.0, 3.5, 5.3, 6.0])
    result = sweep(length=600, amplitude=",".join(map(str, values)), restitution=restitution)
    figures = map_figures(result, ["speed", "traverse", "impact", "flight"])
    expected = solved(amplitude=values, restitution=restitution)
    averaged = expected.status == 7
    assert averaged.any() == (restitution > 0)
    (axes,) = figures["speed"].axes
    (line,) = numbers(axes)
    assert line.get_linestyle() == "None"
    np.testing.assert_allclose(points(line), [values, 1e3 * expected.mean_velocity], rtol=1e-13)
    assert axes.get_xticks().tolist() == values.tolist()
    assert (ERROR_LABEL in legend(figures["speed"])) == averaged.any()
    for code in np.unique(expected.regime):
        regime = Regime(code)
        (coloured,) = [line for line in axes.lines if line.get_gid() == regime.label]
        assert np.asarray(coloured.get_xdata()).tolist() == values[expected.regime == code].tolist()
        assert to_hex(coloured.get_markerfacecolor()) == REGIME_COLOURS[regime].lower()
        assert regime.label in legend(figures["speed"])


def test_a_second_list_makes_facets_of_curves() -> None:
    result = sweep(own=OWN, points=101, amplitude="0.1:3", static_friction="0.5,0.74", drive_angle="10,20,30")
    figure = map_figures(result, ["speed"])["speed"]
    assert [axes.get_title() for axes in figure.axes] == [rf"$\mu_s$ = {v}" for v in (0.5, 0.74)]
    for name in (r"\alpha", r"\mu_s"):
        assert name not in figure.get_suptitle()
    empty, axes = figure.axes
    assert words(empty) == ["infeasible: 10°, 20°, 30°"]
    assert words(axes) == []
    assert [line.get_label() for line in numbers(axes)] == [rf"$\alpha$ = {a}°" for a in (10, 20, 30)]
    for line, angle in zip(numbers(axes), (10.0, 20.0, 30.0), strict=True):
        x, y = points(line)
        cycle = solved(amplitude=x, static_friction=0.74, drive_angle=angle)
        np.testing.assert_allclose(y, 1e3 * cycle.mean_velocity, rtol=1e-13)
    marked = [any(line.get_gid() == "operating point" for line in a.lines) for a in figure.axes]
    assert marked == [False, True]
