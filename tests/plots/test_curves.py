"""Pictures of short lists: a curve, a bar or a point for every value, and nothing between them."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from helpers.drawn import GRAVITY, NUT, OWN, legend, lightness, sweep, unarranged, words
from matplotlib.colors import to_hex
from matplotlib.patches import Rectangle

from vibro import Scene, solve
from vibro.plots import map_figures
from vibro.plots.style import AVERAGED_LABEL, BACKWARDS_LABEL, NO_ANSWER_HATCH
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
    return sweep(
        own=own,
        length=600,
        points=801,
        amplitude="0.1:4",
        static_friction="0.4,0.6,0.74",
        friction_ratio=0.77,
    )


@pytest.fixture(scope="module")
def curve_pictures(curves: SweepResult) -> dict[str, Figure]:
    with unarranged():
        return map_figures(curves, ["regime", "speed", "traverse", "impact", "flight"])


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


def bars(axes: Axes, row: int) -> list[Any]:
    """Return the parts of a bar from left to right, without what is hatched over them."""
    patches: list[Any] = list(axes.patches)
    here = [p for p in patches if p.get_y() < row < p.get_y() + p.get_height()]
    return sorted((p for p in here if p.get_facecolor()[3] > 0), key=lambda p: p.get_x())


def test_one_curve_a_value_with_the_numbers_of_the_solver(curve_pictures: dict[str, Figure]) -> None:
    shown: list[tuple[str, int, Callable[[Any], Floats]]] = [
        ("speed", 1, lambda cycle: 1e3 * cycle.mean_velocity),
        ("speed", 2, lambda cycle: 1e3 * cycle.displacement_per_cycle),
        ("traverse", 1, lambda cycle: cycle.traverse_time(0.6)),
        ("impact", 1, lambda cycle: 1e3 * cycle.impact_velocity),
        ("flight", 1, lambda cycle: cycle.flight_fraction),
    ]
    for name, place, result in shown:
        lines = numbers(curve_pictures[name].axes[place])
        assert [line.get_label() for line in lines] == [rf"$\mu_s$ = {value}" for value in FRICTIONS]
        for line, value in zip(lines, FRICTIONS, strict=True):
            x, y = points(line)
            assert (x[0], x[-1], x.size) == (0.1, 4.0, 201)
            expected = result(solved(amplitude=x, static_friction=value, friction_ratio=0.77))
            expected = np.where(np.isfinite(expected), expected, np.nan)
            np.testing.assert_allclose(y, expected, rtol=1e-13)


def test_a_key_names_every_curve(curve_pictures: dict[str, Figure]) -> None:
    (key,) = [key for axes in curve_pictures["speed"].axes if (key := axes.get_legend()) is not None]
    assert [t.get_text() for t in key.get_texts()] == [rf"$\mu_s$ = {v}" for v in reversed(FRICTIONS)]
    drawn = {line.get_label(): line for line in numbers(curve_pictures["speed"].axes[1])}
    for handle in key.get_lines():
        line = drawn[handle.get_label()]
        assert handle.get_color() == line.get_color()
        assert handle.get_linestyle() == line.get_linestyle()


def test_bars_are_cut_at_the_critical_loads(curve_pictures: dict[str, Figure], curves: SweepResult) -> None:
    scale = 1e3 * GRAVITY / (2 * math.pi * 15) ** 2
    for axes in (curve_pictures["regime"].axes[0], curve_pictures["speed"].axes[0]):
        assert [tick.get_text() for tick in axes.get_yticklabels()] == [rf"$\mu_s$ = {v}" for v in FRICTIONS]
        for row in range(len(FRICTIONS)):
            critical = [getattr(curves.limits, name) for name in ("forward_onset", "back_slip", "hop")]
            inner = [scale * np.broadcast_to(g, (1, 3))[0, row] for g in critical]
            parts = bars(axes, row)
            assert [p.get_gid() for p in parts] == ["no-slip", "forward-slip", "back-slip", "hopping"]
            edges = [parts[0].get_x(), *(p.get_x() + p.get_width() for p in parts)]
            assert edges == pytest.approx([0.1, *inner, 4.0], rel=1e-12)
            for left, right in pairwise(parts):
                assert left.get_x() + left.get_width() == pytest.approx(right.get_x(), rel=1e-15)


def test_names_of_regimes_keep_clear_of_the_critical_loads(curve_pictures: dict[str, Figure]) -> None:
    figure = curve_pictures["regime"]
    (axes,) = figure.axes
    assert {"no-slip", "back-slip", "hopping"} <= set(words(axes))
    crossings = [
        line for line in axes.lines if line.get_gid() in ("continuous_sliding", "hop", "operating point")
    ]
    assert len(crossings) == 7
    for text in axes.texts:
        box = text.get_window_extent()
        for line in crossings:
            (x, *_), (y, *_) = (np.asarray(data, float) for data in (line.get_xdata(), line.get_ydata()))
            left, height = axes.transData.transform((x, y))
            assert not (box.x0 < left < box.x1 and box.y0 < height < box.y1)


def test_the_operating_point_is_on_its_curve(curve_pictures: dict[str, Figure]) -> None:
    def marked(axes: Axes) -> list[Any]:
        return [
            (float(np.ravel(line.get_xdata())[0]), float(np.ravel(line.get_ydata())[0]))
            for line in axes.lines
            if line.get_gid() == "operating point"
        ]

    assert marked(curve_pictures["regime"].axes[0]) == [(1.0, 2.0)]
    speed = 1e3 * float(solved(static_friction=0.74, friction_ratio=0.77).mean_velocity)
    assert marked(curve_pictures["speed"].axes[1]) == [(1.0, pytest.approx(speed, rel=1e-4))]
    assert "operating point" in legend(curve_pictures["speed"])
    among = sweep(own=OWN, amplitude="0.5,1,1.5", static_friction="0.6,0.74")
    assert len(marked(map_figures(among, ["speed"])["speed"].axes[1])) == 1
    between = sweep(own=OWN, amplitude="0.5,1.5", static_friction="0.6,0.74")
    assert marked(map_figures(between, ["speed"])["speed"].axes[1]) == []


def test_twelve_curves_are_told_apart_in_grey() -> None:
    values = ",".join(str(v / 10) for v in range(2, 14))
    result = sweep(points=41, amplitude="0.1:3", static_friction=values, friction_ratio=0.8)
    lines = numbers(map_figures(result, ["speed"])["speed"].axes[1])
    assert len(lines) == 12
    greys = [lightness(to_hex(line.get_color())) for line in lines]
    assert greys == sorted(greys)
    assert greys[-1] < 72  # on white, which has 100
    dashes = [str(line._dash_pattern) for line in lines]  # type: ignore[attr-defined]
    assert all(a != b for a, b in pairwise(dashes))
    for (one, its), (other, others) in ((a, b) for a in enumerate(dashes) for b in enumerate(dashes)):
        assert one >= other or its != others or greys[other] - greys[one] > 15


def test_a_value_without_answers_is_hatched_and_has_no_curve() -> None:
    result = sweep(points=101, amplitude="0.1:3", static_friction="0.4,0.6", kinetic_friction=0.5)
    figures = map_figures(result, ["regime", "speed"])
    for name in ("regime", "speed"):
        (part,) = bars(figures[name].axes[0], 0)
        assert part.get_gid() == "infeasible"
        assert (
            part.get_hatch() == NO_ANSWER_HATCH[next(s for s in NO_ANSWER_HATCH if s.label == "infeasible")]
        )
        assert (part.get_x(), part.get_width()) == pytest.approx((0.1, 2.9))
        assert len(bars(figures[name].axes[0], 1)) > 1
    infeasible, feasible = numbers(figures["speed"].axes[1])
    assert np.isnan(points(infeasible)[1]).all()
    assert np.isfinite(points(feasible)[1]).all()


def test_hops_that_are_not_followed_are_hatched_over_their_regime() -> None:
    result = sweep(flight=False, points=101, amplitude="3:4", drive_angle="20, 25")
    for name, figure in map_figures(result, ["regime", "speed"]).items():
        axes = figure.axes[0]
        patches: list[Any] = list(axes.patches)
        hatched = [p for p in patches if p.get_gid() == "flight not modelled"]
        hops = [p for p in patches if p.get_gid() == "hopping"]
        assert [p.get_bbox().bounds for p in hatched] == [p.get_bbox().bounds for p in hops], name
        assert "flight not modelled" in legend(figure)


@pytest.mark.parametrize("restitution", [0, 0.6])
def test_a_list_alone_is_points_that_nothing_joins(restitution: float) -> None:
    values = np.array([0.5, 1.0, 3.5, 5.3, 6.0])
    result = sweep(length=600, amplitude=",".join(map(str, values)), restitution=restitution)
    figures = map_figures(result, ["speed", "traverse", "impact", "flight"])
    expected = solved(amplitude=values, restitution=restitution)
    averaged = expected.status == 7
    assert averaged.any() == (restitution > 0)
    strip, *panels = figures["speed"].axes
    for axes, field in zip(panels, ("mean_velocity", "displacement_per_cycle"), strict=True):
        drawn = [line for line in axes.lines if line.get_gid() in ("numbers", AVERAGED_LABEL)]
        assert {line.get_linestyle() for line in drawn} == {"None"}
        assert "None" not in {line.get_marker() for line in drawn}
        found = np.concatenate([np.column_stack(points(line)) for line in drawn])
        found = found[np.isfinite(found[:, 1])]
        found = found[np.argsort(found[:, 0])]
        np.testing.assert_allclose(
            found, np.column_stack([values, 1e3 * getattr(expected, field)]), rtol=1e-13
        )
    assert panels[-1].get_xticks().tolist() == values.tolist()
    assert (AVERAGED_LABEL in legend(figures["speed"])) == averaged.any()
    squares = {s.get_gid() for s in strip.collections}
    assert len(strip.collections) == len(values)
    assert squares <= set(legend(figures["speed"]))
    assert not strip.patches  # no band between points


def test_two_lists_are_series_of_points_over_the_longer() -> None:
    result = sweep(frequency="15, 20", amplitude="0.5,1,1.5")
    figures = map_figures(result)
    lines = numbers(figures["speed"].axes[1])
    assert [line.get_label() for line in lines] == ["$f$ = 15 Hz", "$f$ = 20 Hz"]
    assert len({line.get_marker() for line in lines}) == 2
    for line, frequency in zip(lines, (15, 20), strict=True):
        x, y = points(line)
        assert line.get_linestyle() == "None"
        assert x.tolist() == [0.5, 1, 1.5]
        np.testing.assert_allclose(
            y, 1e3 * solved(amplitude=x, frequency=float(frequency)).mean_velocity, rtol=1e-13
        )
    assert len(figures["regime"].axes[0].collections) == 6
    assert {"forward-slip", "back-slip"} <= set(legend(figures["regime"]))


def test_a_second_list_makes_facets_of_curves() -> None:
    result = sweep(own=OWN, points=101, amplitude="0.1:3", static_friction="0.5,0.74", drive_angle="10,20,30")
    figures = map_figures(result, ["regime", "speed"])
    for figure in figures.values():
        assert [axes.get_title() for axes in figure.axes] == [rf"$\mu_s$ = {v}" for v in (0.5, 0.74)]
        for name in (r"\alpha", r"\mu_s"):
            assert name not in figure.get_suptitle()
    for axes, friction in zip(figures["speed"].axes, (0.5, 0.74), strict=True):
        assert [line.get_label() for line in numbers(axes)] == [rf"$\alpha$ = {a}°" for a in (10, 20, 30)]
        if friction < 0.57:
            assert words(axes) == ["infeasible"]
            continue
        assert words(axes) == []
        for line, angle in zip(numbers(axes), (10.0, 20.0, 30.0), strict=True):
            x, y = points(line)
            cycle = solved(amplitude=x, static_friction=friction, drive_angle=angle)
            np.testing.assert_allclose(y, 1e3 * cycle.mean_velocity, rtol=1e-13)
    marked = [any(line.get_gid() == "operating point" for line in a.lines) for a in figures["regime"].axes]
    assert marked == [False, True]


def test_a_level_and_the_zero_line(curves: SweepResult) -> None:
    axes = map_figures(curves, ["speed"], target_speed=20.0)["speed"].axes[1]
    assert "20 mm/s" in words(axes)
    climbs = sweep(points=101, amplitude=1.5, trough_angle="-10:25", drive_angle="20, 30")
    for axes in map_figures(climbs, ["speed"])["speed"].axes[1:]:
        (zero,) = [line for line in axes.lines if set(np.ravel(line.get_ydata())) == {0.0}]
        assert zero.get_gid() is None


def test_bars_and_bands_are_hatched_where_bodies_move_backwards() -> None:
    result = sweep(points=801, length=600, trough_angle="-10:10", amplitude="1.5,2")
    figures = map_figures(result, ["regime", "speed"])
    hatched = [p for p in figures["regime"].axes[0].patches if p.get_gid() == BACKWARDS_LABEL]
    assert len(hatched) == 2
    for patch, amplitude in zip(hatched, (1.5, 2.0), strict=True):
        assert isinstance(patch, Rectangle)
        beside = patch.get_x() + np.array([-0.02, 0.02])  # deg
        before, after = solved(amplitude=amplitude, trough_angle=beside).mean_velocity
        assert before > 0.0 > after
        assert patch.get_x() + patch.get_width() == pytest.approx(10.0)
    assert BACKWARDS_LABEL in legend(figures["speed"])
