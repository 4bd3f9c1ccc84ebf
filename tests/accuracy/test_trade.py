"""The trade of speed for accuracy: each method by itself, the reference, and all of them together."""

from __future__ import annotations

import csv
import importlib
import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import mpmath
import numpy as np
import pytest
from engines.digits_walk import exact_cycle, exact_sensitivity
from helpers.scenes import line_of
from matplotlib.text import Text

import vibro
from vibro.accuracy.events import simulate_by_events
from vibro.accuracy.methods import METHODS, Answers, Method, reference_answers
from vibro.accuracy.motion import TroughBody, motion_arrays, motions
from vibro.accuracy.reference import exact
from vibro.accuracy.sample import draw_scenes
from vibro.accuracy.stepping import simulate_by_steps
from vibro.accuracy.trade import Row, Trade, advice, run_methods, runs
from vibro.axes import parse_axis
from vibro.plots.trade import trade_figure
from vibro.quantities import QUANTITIES
from vibro.sweeps.grid import Grid

if TYPE_CHECKING:
    from collections.abc import Iterator

DATA = Path(__file__).parents[1] / "data"
ALPHA, MU_S, MU_D, GRAVITY, FREQUENCY = math.radians(20.0), 0.74, 0.57, 9.81, 15.0

# Displacement per cycle [A] of the paper's scene and pattern by amplitude [mm], from 50 digits.
KNOWN = {
    0.6: (0.0, ""),
    1.0: (16.263456166287 / 15.0, "F"),
    1.2: (27.119929 / 15.0 / 1.2, "BF"),
    1.5: (40.590623 / 15.0 / 1.5, "BF"),
    2.0: (67.617507 / 15.0 / 2.0, "BF"),
}
PRINTED = 1e-7  # [A] digits of KNOWN


def nut(amplitude_mm: float | np.ndarray) -> vibro.Scene:
    return vibro.Scene(
        amplitude=1e-3 * amplitude_mm,
        frequency=FREQUENCY,
        drive_angle=ALPHA,
        static_friction=MU_S,
        kinetic_friction=MU_D,
    )


def motion(amplitude_mm: float) -> TroughBody:
    return next(motions(nut(amplitude_mm)))


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
    return Grid(axes, fixed | {"trough_angle": 0.0, "gravity": GRAVITY, "restitution": 0.0}, None)


@pytest.mark.parametrize("amplitude", KNOWN)
@pytest.mark.parametrize(
    ("solver", "rtol", "tolerance"), [("RK45", 1e-9, 1e-6), ("DOP853", 1e-12, 1e-9), ("LSODA", 1e-9, 1e-6)]
)
def test_event_driven_simulation_finds_the_known_cycles(
    amplitude: float, solver: str, rtol: float, tolerance: float
) -> None:
    known, slides = KNOWN[amplitude]
    found = simulate_by_events(motion(amplitude), solver, rtol)  # type: ignore[arg-type]
    assert found.slides == slides
    assert found.displacement == pytest.approx(known, abs=tolerance + PRINTED)


def test_a_simulation_that_does_not_settle_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vibro.accuracy.events._MOST_SLIDES", 4)
    assert math.isnan(simulate_by_events(motion(2.0), "DOP853", 1e-12).displacement)


def test_a_simulation_reports_slides_that_never_end() -> None:
    scene = vibro.Scene(
        amplitude=1e-3,
        frequency=15.0,
        drive_angle=0.3,
        static_friction=0.6,
        kinetic_friction=0.2,
        trough_angle=-0.5,
    )
    assert math.isnan(simulate_by_events(next(motions(scene)), "DOP853", 1e-9).displacement)


@pytest.mark.parametrize("amplitude", [1.0, 2.0])
def test_time_stepping_converges_with_the_step(amplitude: float) -> None:
    known, slides = KNOWN[amplitude]
    arrays = motion_arrays(nut(amplitude))
    errors = []
    for steps in (400, 1600, 6400):
        (found,) = simulate_by_steps(arrays, steps)
        assert "".join(sorted(found.slides)) == slides
        errors.append(abs(found.displacement - known))
    assert errors[-1] <= 0.003
    assert errors[-1] <= 0.3 * errors[0]


@pytest.mark.parametrize("table", sorted(DATA.glob("contact_*.csv")), ids=lambda path: path.stem)
def test_the_reference_agrees_with_the_tables(table: Path) -> None:
    """To all printed digits; the tables are made by another program."""
    with table.open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert rows
    with mpmath.workdps(60):
        for row in rows:
            degree = mpmath.pi / 180
            values = [
                mpmath.mpf(float(row["amplitude_mm"])) / 1000,
                mpmath.mpf(float(row["frequency_hz"])),
                mpmath.mpf(float(row["drive_angle_deg"])) * degree,
                mpmath.mpf(float(row["static_friction"])),
                mpmath.mpf(float(row["kinetic_friction"])),
                mpmath.mpf(float(row["trough_angle_deg"])) * degree,
                mpmath.mpf("9.81"),
            ]
            exact = exact_cycle(values)
            assert sorted(exact.pattern) == sorted(row["pattern"]), row
            if row["pattern"] != "runaway":
                known = mpmath.mpf(row["displacement_per_cycle_mm"]) / 1000 / values[0]
                assert abs(exact.displacement - known) < 1e-17 * (1 + abs(known)), row


def test_the_sensitivity_is_the_condition_of_the_tables() -> None:
    with (DATA / "contact_regular.csv").open(encoding="utf-8", newline="") as stream:
        rows = [row for row in csv.DictReader(stream) if row["displacement_per_cycle_mm"] != "0"][:10]
    for row in rows:
        amplitude = 1e-3 * float(row["amplitude_mm"])
        values = (
            amplitude,
            float(row["frequency_hz"]),
            math.radians(float(row["drive_angle_deg"])),
            float(row["static_friction"]),
            float(row["kinetic_friction"]),
            0.0,
            GRAVITY,
        )
        displacement = abs(float(row["displacement_per_cycle_mm"])) * 1e-3 / amplitude
        assert float(exact_sensitivity(values)) == pytest.approx(
            float(row["condition"]) * displacement, rel=1e-3
        )


def test_scenes_are_drawn_evenly_from_every_axis() -> None:
    scene = line_of(draw_scenes(grid(amplitude="1:3"), 0, 2000))
    assert scene.amplitude.shape == (2000,)
    for values, low, high in (
        (scene.amplitude, 1e-3, 3e-3),
        (scene.drive_angle, math.radians(2.0), math.radians(45.0)),
        (scene.kinetic_friction / scene.static_friction, 0.4, 1.0),
    ):
        counts, _ = np.histogram(values, 8, (low, high))
        assert abs(counts - 250).max() < 40


def test_scenes_go_on_where_they_ended() -> None:
    whole, rest = draw_scenes(grid(), 0, 60), draw_scenes(grid(), 20, 40)
    np.testing.assert_array_equal(whole.scale[20:], rest.scale)


def test_a_small_grid_is_taken_whole_and_without_what_cannot_be() -> None:
    small = grid(
        amplitude="1, 2",
        frequency="15",
        drive_angle="20",
        static_friction="0.3,0.6",
        friction_ratio="0.5,2",
    )
    scene = draw_scenes(small, 0, 50)
    assert scene.shape == (4,)
    assert (scene.kinetic_friction <= scene.static_friction).all()
    assert draw_scenes(small, 50, 50).shape == (0,)


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

    for solver, settings in (
        ("RK45", ("rtol 1e-3", "rtol 1e-6", "rtol 1e-9")),
        ("DOP853", ("rtol 1e-6", "rtol 1e-9", "rtol 1e-12")),
        ("LSODA", ("rtol 1e-3", "rtol 1e-6", "rtol 1e-9")),
    ):
        errors = [named(trade, f"events, {solver}", s).error_max for s in settings]
        assert errors == sorted(errors, reverse=True)
        assert errors[0] > 100.0 * errors[-1]
        assert errors[-1] < 1e-5

    widths = [named(trade, "smoothed friction", f"width {w} A w") for w in ("0.01", "0.001", "0.0001")]
    drifts = [row.drift_at_rest for row in widths]
    assert drifts == sorted(drifts, reverse=True)
    assert drifts[0] > 1e-3
    assert all(row.drift_at_rest == 0.0 for row in trade.rows if row not in widths)
    medians = [row.error_median for row in widths]
    assert medians == sorted(medians, reverse=True)

    steps = [named(trade, "time steps", f"{n} a cycle") for n in (20, 40, 400, 4000)]
    medians = [row.error_median for row in steps]
    assert medians == sorted(medians, reverse=True)
    assert steps[1].beyond_tolerance > 0.3 * steps[1].scenes


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


def test_the_advice_says_when_nothing_is_right() -> None:
    rows = (row("a", 1.0, 0.5, beyond=1), row("b", 1.0, 0.2, beyond=1))
    text = advice(Trade(rows, "truth", 10, 10, 1e-3))
    assert text == "No method stays within 0.001 A f in every scene; the closest is b (s), within 0.2."


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


def test_a_grid_without_a_scene_in_contact_has_no_trade() -> None:
    trade = run_methods(grid(amplitude="20:30", frequency="50:60"), 10, tolerance=1e-3)
    assert (trade.rows, trade.scenes, trade.drawn) == ((), 0, 200)


def test_the_reference_is_the_cycle_of_another_walk() -> None:
    fields: Any = draw_scenes(grid(), 0, 60).flat()[:-1]
    stays = 0
    for values in zip(*(field.tolist() for field in fields), strict=True):
        known = exact_cycle(values)
        if known.pattern != "hopping":
            found = exact(values)
            assert abs(found.displacement - known.displacement) < 1e-17
            assert sorted(found.slides) == sorted(set(known.pattern) - {"_"})
            stays += 1
    assert stays > 30


@pytest.fixture
def without_mpmath(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setitem(sys.modules, "mpmath", None)
    yield
    monkeypatch.undo()
    importlib.reload(sys.modules["vibro.accuracy.reference"])


@pytest.mark.usefixtures("without_mpmath")
def test_without_mpmath_the_reference_is_a_walk_in_doubles() -> None:
    reference = importlib.reload(sys.modules["vibro.accuracy.reference"])
    assert reference.NAME == "event walk in double precision"
    fields: Any = draw_scenes(grid(), 0, 60).flat()[:-1]
    for values in zip(*(field.tolist() for field in fields), strict=True):
        known = exact_cycle(values)
        if known.pattern != "hopping":
            assert reference.exact(values).displacement == pytest.approx(float(known.displacement), abs=1e-10)


def test_the_reference_leaves_out_what_hops_and_what_cannot_rest() -> None:
    scene = vibro.Scene(
        amplitude=np.array([1e-3, 20e-3, 1e-3]),
        frequency=FREQUENCY,
        drive_angle=ALPHA,
        static_friction=MU_S,
        kinetic_friction=MU_D,
        trough_angle=np.array([0.0, 0.0, -0.7]),
    )
    answers = reference_answers(scene, lambda: None)
    assert answers.displacement[0] == pytest.approx(KNOWN[1.0][0], abs=1e-9)
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


def test_progress_reaches_its_total() -> None:
    seen: list[int] = []
    methods = METHODS[:3]
    run_methods(grid(), 40, tolerance=1e-3, methods=methods, report=seen.append)
    assert seen == sorted(seen)
    assert 40 + sum(runs(methods, 40)) <= seen[-1] <= 2 * 40 + 40 + sum(runs(methods, 40))
