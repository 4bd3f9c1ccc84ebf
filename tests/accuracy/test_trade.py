"""The trade of speed for accuracy: each method by itself, the reference, and all of them together."""

from __future__ import annotations

import importlib
import math
import sys
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from engines.digits_walk import exact_cycle
from matplotlib.text import Text

import vibro
from vibro.accuracy.events import simulate_by_events
from vibro.accuracy.methods import METHODS, Answers, Method, reference_answers
from vibro.accuracy.motion import motions
from vibro.accuracy.reference import exact
from vibro.accuracy.sample import draw_scenes
from vibro.accuracy.trade import Row, Trade, advice, run_methods, runs
from vibro.axes import parse_axis
from vibro.plots.trade import trade_figure
from vibro.quantities import QUANTITIES
from vibro.sweeps.grid import Grid

if TYPE_CHECKING:
    from collections.abc import Iterator


def nut(amplitude_mm: Any, trough_angle: Any = 0.0) -> vibro.Scene:
    return vibro.Scene(
        amplitude=1e-3 * amplitude_mm, frequency=15.0, drive_angle=math.radians(20.0), static_friction=0.74,
        kinetic_friction=0.57, trough_angle=trough_angle,
    )  # fmt: skip


def grid(**texts: str) -> Grid:
    defaults = {
        "amplitude": "0.1:3:log",
        "frequency": "5:60:log",
        "drive_angle": "2:45",
        "static_friction": "0.1:1",
        "friction_ratio": "0.4:1",
    }
    specs = {name: parse_axis(text, QUANTITIES[name]) for name, text in (defaults | texts).items()}
    axes = {name: spec.axis(101) for name, spec in specs.items() if spec.varies}
    fixed = {name: spec.value for name, spec in specs.items() if not spec.varies}
    return Grid(axes, fixed | {"trough_angle": 0.0, "gravity": 9.81, "restitution": 0.0}, None)


def test_a_simulation_that_does_not_settle_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    steep = vibro.Scene(
        amplitude=1e-3, frequency=15.0, drive_angle=0.3, static_friction=0.6, kinetic_friction=0.2,
        trough_angle=-0.5,
    )  # fmt: skip
    assert math.isnan(simulate_by_events(next(motions(steep)), "DOP853", 1e-9).displacement)
    monkeypatch.setattr("vibro.accuracy.events._MOST_SLIDES", 4)
    assert math.isnan(simulate_by_events(next(motions(nut(2.0))), "DOP853", 1e-12).displacement)


def test_a_small_grid_is_taken_whole_and_without_what_cannot_be() -> None:
    small = grid(
        amplitude="1, 2", frequency="15", drive_angle="20", static_friction="0.3,0.6", friction_ratio="0.5,2"
    )
    scene = draw_scenes(small, 0, 50)
    assert run_methods(grid(amplitude="20:30", frequency="50:60"), 10, tolerance=1e-3).rows == ()
    assert scene.shape == (4,)
    assert (scene.kinetic_friction <= scene.static_friction).all()
    assert draw_scenes(small, 50, 50).shape == (0,)
    whole, rest = draw_scenes(grid(), 0, 60), draw_scenes(grid(), 20, 40)
    np.testing.assert_array_equal(whole.scale[20:], rest.scale)


SCENES = 12


@pytest.fixture(scope="module")
def trade() -> Iterator[Trade]:
    """Run slow methods on seven scenes."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("vibro.accuracy.trade._FEWEST", 7)
        yield run_methods(grid(), SCENES, tolerance=1e-3)


def named(trade: Trade, method: str, setting: str) -> Row:
    (row,) = [r for r in trade.rows if r.method == method and r.setting == setting]
    return row


def test_every_method_runs_on_its_share(trade: Trade) -> None:
    assert trade.reference == "event walk in 60-digit arithmetic"
    assert trade.scenes == SCENES
    assert [row.scenes for row in trade.rows] == runs(METHODS, SCENES)
    assert all(row.time_us > 0.0 for row in trade.rows)
    # A median needs scenes that slip: slow methods, which run on the first scenes alone, have some too.
    assert all(row.error_median >= 0.0 for row in trade.rows if row.setting != "regimes alone")


def test_the_order_of_the_methods_is_that_of_the_documentation(trade: Trade) -> None:
    exact = named(trade, "vibro", "exact")
    assert exact.error_max < 1e-13
    assert exact.beyond_tolerance == exact.gave_up == exact.silent_failures == 0
    assert exact.wrong_regime_share == 0.0
    assert named(trade, "vibro", "regimes alone").wrong_regime_share == 0.0

    others = [row for row in trade.rows if row.method != "vibro"]
    assert all(row.error_max > 1e3 * exact.error_max for row in others)
    assert all(row.time_us > 10.0 * exact.time_us for row in others)

    for method, settings in (
        ("events, RK45", [f"rtol 1e-{digits}" for digits in (3, 6, 9)]),
        ("events, DOP853", [f"rtol 1e-{digits}" for digits in (6, 9, 12)]),
        ("events, LSODA", [f"rtol 1e-{digits}" for digits in (3, 6, 9)]),
        ("smoothed friction", [f"width {width} A w" for width in ("0.01", "0.001", "0.0001")]),
        ("time steps", [f"{n} a cycle" for n in (20, 40, 400, 4000)]),
    ):
        rows = [named(trade, method, setting) for setting in settings]
        medians, drifts = [row.error_median for row in rows], [row.drift_at_rest for row in rows]
        assert medians == sorted(medians, reverse=True)
        assert drifts == sorted(drifts, reverse=True)
        assert (drifts[0] > 1e-3) == (method == "smoothed friction")  # the others rest
        assert rows[-1].error_max < 1e-5 or not method.startswith("events")


def test_the_advice_names_what_is_right_in_every_scene(trade: Trade) -> None:
    assert advice(trade).startswith("Use vibro (exact): ")


def row(method: str, time_us: float, error: float, beyond: int = 0, gave_up: int = 0) -> Row:
    return Row(method, "s", 10, time_us, error, error, error, beyond, 0.0, 0, gave_up, 0.0)


def test_the_advice_compares_with_the_next_method_that_is_right() -> None:
    rows = (
        row("a", 1.0, 1e-9),
        row("b", 25.0, 1e-5),
        row("c", 2.0, 0.1, beyond=3),
        row("d", 3.0, 0.0, gave_up=1),
    )
    text = advice(Trade(rows, "truth", 10, 10, 1e-3))
    assert (
        text == "Use a (s): 25 times as fast as the next that stays within 0.001 A f in every scene (b, s)."
    )
    none = advice(Trade(rows[2:3], "truth", 10, 10, 1e-3))
    assert none == "No method stays within 0.001 A f in every scene; the closest is c (s), within 0.1."


def test_errors_are_counted_where_they_are() -> None:
    """A method that is right in some scenes, and wrong in a known way in the others."""

    def answer(scene: vibro.Scene, tick: object) -> tuple[Answers, float]:
        cycle = vibro.solve(scene)
        displacement = cycle.displacement_per_cycle / scene.scale
        regime = cycle.regime.copy()
        still, moves = np.flatnonzero(displacement == 0.0), np.flatnonzero(displacement > 0.1)
        displacement[still[0]] = 0.25  # creeps
        displacement[moves[0]] *= 0.4  # misses half the speed
        regime[moves[1]] = vibro.Regime.NO_SLIP
        displacement[moves[2]], regime[moves[2]] = np.nan, vibro.Regime.UNDEFINED
        return Answers(displacement, regime), 1.0

    method = Method("odd", "", 1.0, answer)
    result = run_methods(grid(), 100, tolerance=1e-3, methods=[method])
    (found,) = result.rows
    assert found.beyond_tolerance == 2
    assert found.wrong_regime_share == pytest.approx(1 / 99)
    assert found.silent_failures == 1
    assert found.gave_up == 1
    assert found.drift_at_rest == 0.25
    assert found.time_us == 1e4


def test_the_reference_is_the_cycle_of_another_walk(monkeypatch: pytest.MonkeyPatch) -> None:
    """In 60 digits, and in doubles where mpmath is not installed."""
    fields: Any = draw_scenes(grid(), 0, 60).flat()[:-1]
    known = [(values, exact_cycle(values)) for values in zip(*(x.tolist() for x in fields), strict=True)]
    known = [(values, cycle) for values, cycle in known if cycle.pattern != "hopping"]
    assert len(known) > 30
    for values, cycle in known:
        found = exact(values)
        assert abs(found.displacement - cycle.displacement) < 1e-17
        assert sorted(found.slides) == sorted(set(cycle.pattern) - {"_"})
    with monkeypatch.context() as patch:
        patch.setitem(sys.modules, "mpmath", None)
        plain = importlib.reload(sys.modules["vibro.accuracy.reference"])
        assert plain.NAME == "event walk in double precision"
        for values, cycle in known:
            assert plain.exact(values).displacement == pytest.approx(float(cycle.displacement), abs=1e-10)
    importlib.reload(plain)


def test_the_reference_leaves_out_what_hops_and_what_cannot_rest() -> None:
    scene = nut(np.array([1.0, 20.0, 1.0]), np.array([0.0, 0.0, -0.7]))
    answers = reference_answers(scene, lambda: None)
    assert answers.displacement[0] == pytest.approx(16.263456166287 / 15.0, abs=1e-9)  # of 50 digits
    assert np.isnan(answers.displacement[1:]).all()


def test_labels_of_the_picture_do_not_overlap(trade: Trade) -> None:
    figure = trade_figure(trade)
    figure.draw_without_rendering()
    (axes,) = figure.axes
    boxes = [Text.get_window_extent(text) for text in axes.texts if text.get_text()]
    assert len(boxes) == sum(math.isfinite(r.error_max) for r in trade.rows) + 1
    for i, box in enumerate(boxes):
        assert not box.count_overlaps(boxes[:i])
    legend = [text.get_text() for text in figure.legends[0].get_texts()]
    assert legend[:2] == ["vibro", "events, RK45"]
    assert axes.get_xlabel() == "time per scene [µs]"
    (steps,) = (line for line in axes.lines if line.get_label() == "time steps")
    worst = [row.error_max for row in trade.rows if row.method == "time steps"]
    assert np.asarray(steps.get_ydata()).tolist() == worst
