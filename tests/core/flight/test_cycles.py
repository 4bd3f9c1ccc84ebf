"""Steady cycles of hopping scenes: tables, limits, closed forms, and the plain walk that they stand for."""

from __future__ import annotations

import csv
import math
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import pytest
from hopping import hopping_cycles, loads_at_throw, random_loads
from scenes import at_load, loads_of

from vibro import Scene, Status, solve
from vibro.core.codes import Mode, spelt_text
from vibro.core.flight import returns
from vibro.core.flight.bounces import bounces
from vibro.core.flight.cycles import MOST_THROW, HoppingCycles, entered
from vibro.core.flight.returns import Return, hops_of, return_map
from vibro.core.groups import Loads, each

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

DATA = Path(__file__).parents[2] / "data"
TURN = 2.0 * math.pi


def _solve(scene: Loads, restitution: float = 0.0) -> HoppingCycles:
    return hopping_cycles(scene, np.full(scene.normal.shape, restitution))


def _return_map(scene: Loads) -> tuple[Callable[[Floats], Return], Floats]:
    """One cycle after the other by hand, and the velocity to start from."""
    motion = bounces(scene.across / scene.normal, np.zeros(scene.normal.shape))
    cells, velocity = entered(scene, motion)
    return partial(return_map, cells, hops_of(scene, motion.cycle)), velocity


def _patterns(cycles: HoppingCycles) -> list[str]:
    return [spelt_text(code) for code in cycles.pattern.tolist()]


class Row(NamedTuple):
    pattern: str
    period: int
    displacement: float  # [A]
    flight_fraction: float


@pytest.fixture(scope="module")
def table() -> tuple[HoppingCycles, list[Row]]:
    with (DATA / "hopping.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 47
    columns = {name: np.array([float(r[name]) for r in rows]) for name in rows[0] if name != "pattern"}
    scene = Scene(
        amplitude=columns["amplitude_mm"] / 1000.0,
        frequency=columns["frequency_hz"],
        drive_angle=np.radians(columns["drive_angle_deg"]),
        static_friction=columns["static_friction"],
        kinetic_friction=columns["kinetic_friction"],
    )
    expected = [
        Row(r["pattern"], int(r["period_cycles"]), float(d), float(r["flight_fraction"]))
        for r, d in zip(rows, columns["displacement_per_cycle_mm"] / columns["amplitude_mm"], strict=True)
    ]
    return _solve(loads_of(scene)), expected


def test_displacement_of_every_row_of_the_table(table: tuple[HoppingCycles, list[Row]]) -> None:
    cycles, rows = table
    expected = np.array([row.displacement for row in rows])
    assert (cycles.status == Status.OK).all()
    assert np.abs((cycles.displacement - expected) / (1.0 + np.abs(expected))).max() < 5e-11


def test_flight_fraction_of_every_row_of_the_table(table: tuple[HoppingCycles, list[Row]]) -> None:
    cycles, rows = table
    assert cycles.flight_fraction == pytest.approx([row.flight_fraction for row in rows], abs=1e-12)


def test_period_and_pattern_of_every_row_of_the_table(table: tuple[HoppingCycles, list[Row]]) -> None:
    cycles, rows = table
    for period, got, row in zip(cycles.period, _patterns(cycles), rows, strict=True):
        if row.pattern == "HH":
            # K = 3.48392: one flight of one cycle each time, its take-off at K cos p = pi; the table
            # counts two of them (test_bounce.py)
            assert (got, period) == ("H", 1)
            continue
        assert period == row.period
        # the table starts some cycles elsewhere
        assert len(got) == len(row.pattern)
        assert got in row.pattern + row.pattern
        assert got[0] == "H"


@pytest.mark.parametrize(
    ("throw", "pattern", "displacement"),
    [
        (1.5, "HFB", "12.028332"),
        (2.0, "HB", "23.645166"),
        (2.5, "HBF", "41.364250"),
        (3.0, "H_F", "51.291633"),
    ],
)
def test_published_scene_thrown_higher_to_all_digits(throw: float, pattern: str, displacement: str) -> None:
    scene = loads_at_throw([throw], 20.0, 0.74, 0.57)
    cycles = _solve(scene)
    load = throw / math.sin(math.radians(20.0))
    assert _patterns(cycles) == [pattern]
    assert f"{cycles.displacement[0] * load:.6f}" == displacement


def test_ideal_sticking_is_the_limit_of_high_friction() -> None:
    throw = np.linspace(1.05, 3.2, 12)
    for friction, tolerance in ((1e3, 1e-2), (1e5, 1e-4), (1e7, 1e-6)):
        scene = loads_at_throw(throw, 30.0, friction, friction)
        cycles = _solve(scene)
        # v = g n^2 / (2 f) cot(alpha) with n = flight fraction
        per_cycle = 2.0 * math.pi**2 * cycles.flight_fraction**2 * scene.normal * scene.along / scene.across
        assert cycles.displacement == pytest.approx(per_cycle, rel=tolerance)


def test_hardly_hopping_tends_to_contact() -> None:
    drive, mu_s = np.array([15.0, 25.0, 35.0, 45.0]), np.array([0.9, 0.6, 0.5, 0.3])
    below = at_load((1.0 - 1e-12) / np.sin(np.radians(drive)), drive, mu_s, 0.8 * mu_s)
    contact = solve(below).displacement_per_cycle / below.scale
    gaps = []
    for excess in (1e-4, 1e-6, 1e-8):
        cycles = _solve(loads_at_throw(1.0 + excess, drive, mu_s, 0.8 * mu_s))
        gaps.append(np.abs(cycles.displacement - contact))
        assert (cycles.flight_fraction < 2.0 * math.sqrt(excess)).all()
    assert (gaps[1] < 0.02 * gaps[0]).all()
    assert (gaps[2] < 1e-7).all()


def test_the_fixed_point_is_where_the_plain_walk_from_rest_ends() -> None:
    scene = random_loads(400, 1)
    cycles = _solve(scene)
    assert (cycles.status == Status.OK).all()
    step_from, velocity = _return_map(scene)
    for _ in range(600):
        walked = step_from(velocity)
        change, velocity = np.abs(walked.velocity - velocity), walked.velocity
    settled = change < 1e-14
    assert settled.mean() > 0.95
    assert (walked.displacement / cycles.period)[settled] == pytest.approx(
        cycles.displacement[settled], rel=1e-10, abs=1e-10
    )


def test_a_scene_of_low_friction_that_takes_hundreds_of_cycles_to_settle() -> None:
    scene = loads_at_throw([1.0521], 20.0, 0.219, 0.133)
    cycles = _solve(scene)
    step_from, velocity = _return_map(scene)
    walked = []
    for _ in range(1500):
        step = step_from(velocity)
        walked.append(step.displacement[0])
        velocity = step.velocity
    distance = np.abs(np.array(walked) - cycles.displacement[0])
    assert distance[20] > 1e-6
    assert distance[-1] < 1e-12


def test_the_return_map_never_decreases() -> None:
    scene = random_loads(60, 2)
    step_from, _ = _return_map(scene)
    before = np.full(60, -np.inf)
    for velocity in np.linspace(-2.0, 2.0, 161):
        after = step_from(np.full(60, velocity))
        assert (after.velocity >= before - 1e-12).all()
        assert ((after.slope >= 0.0) & (after.slope <= 1.0)).all()
        before = after.velocity


def test_the_slope_of_the_return_map_is_its_derivative() -> None:
    scene = random_loads(200, 3)
    step_from, _ = _return_map(scene)
    velocity = np.random.default_rng(4).uniform(-1.0, 1.0, 200)
    here, left, right = (step_from(velocity + h) for h in (0.0, -1e-6, 1e-6))
    smooth = np.abs(right.slope - left.slope) < 1e-4  # the velocities are on one piece of the map
    smooth &= (left.pattern == here.pattern) & (right.pattern == here.pattern)
    assert smooth.mean() > 0.95
    difference = (right.velocity - left.velocity) / 2e-6
    assert difference[smooth] == pytest.approx(here.slope[smooth], abs=2e-4)


def test_bodies_that_nothing_holds_have_no_steady_cycle() -> None:
    mu_s, mu_d = [0.3, 0.3, 0.0, 0.3], [0.2, 0.2, 0.0, 0.2]
    scene = loads_at_throw([1.5, 1.5, 1.5, 2e6], 20.0, mu_s, mu_d, [-20.0, 20.0, 0.0, 0.0])
    cycles = _solve(scene)
    assert cycles.status.tolist() == [
        Status.RUNAWAY, Status.RUNAWAY, Status.INDETERMINATE, Status.UNRESOLVED,
    ]  # fmt: skip
    assert np.isnan(cycles.displacement).all()
    assert _patterns(cycles) == [""] * 4
    assert scene.across[3] / scene.normal[3] > MOST_THROW


def test_a_slope_between_the_two_frictions_may_run_away_once_it_slides() -> None:
    # gravity along the trough beats kinetic friction but not static friction
    scene = loads_at_throw([1.2, 2.0, 3.0], 30.0, 0.6, 0.2, -15.0)
    cycles = _solve(scene)
    assert (cycles.status == Status.RUNAWAY).all()


@pytest.mark.parametrize("restitution", [0.0, 0.7])
def test_any_throw_number_has_an_answer_at_bounded_cost(restitution: float) -> None:
    cycles = _solve(loads_at_throw([10.0, 100.0, 1e3, 1e4], 30.0, 0.5, 0.4), restitution)
    assert set(cycles.status.tolist()) <= {Status.OK, Status.AVERAGED}
    assert (cycles.displacement > 0.0).all()
    assert (cycles.impact > 0.0).all()


def test_impact_and_peak_speeds_are_those_on_the_way() -> None:
    scene = random_loads(50, 6, least_ratio=0.6)
    cycles = _solve(scene)
    throw = scene.across / scene.normal
    lift_off = np.arcsin(1.0 / throw)
    flights = bounces(throw, np.zeros(50)).cycle
    once = flights.number == 1
    length = flights.length[flights.first]
    rate = scene.across * (np.cos(lift_off) - np.cos(lift_off + length)) - scene.normal * length
    assert cycles.impact[once] == pytest.approx(-rate[once], rel=1e-9)
    step_from, velocity = _return_map(scene)
    for _ in range(400):
        velocity = step_from(velocity).velocity
    s = np.linspace(0.0, 1.0, 4001)[:, None] * length
    flying = velocity + scene.along * (np.cos(lift_off) - np.cos(lift_off + s)) - scene.tangential * s
    assert (cycles.peak[once] >= np.abs(flying).max(axis=0)[once] - 1e-10).all()


def test_accumulating_bounces_lengthen_the_time_off_the_trough() -> None:
    scene = loads_at_throw(np.linspace(1.05, 1.5, 10), 30.0, 0.5, 0.4)
    fractions = [_solve(scene, e).flight_fraction for e in (0.0, 0.1, 0.2, 0.3)]
    assert (np.diff(fractions, axis=0) > 0.0).all()


def test_one_value_for_all_cells_may_be_zero_dimensional() -> None:
    scene = loads_at_throw(np.linspace(1.1, 3.0, 7), 30.0, 0.5, 0.4)
    narrow = scene._replace(
        along=scene.along[0], across=scene.across[0], tangential=scene.tangential[0],
        static_friction=scene.static_friction[0], kinetic_friction=scene.kinetic_friction[0],
    )  # fmt: skip
    wide, got = _solve(scene), hopping_cycles(narrow, np.array(0.0))
    one = each(scene, lambda x: x[3])
    restitution = np.array([0.0, 0.0])
    for name in HoppingCycles._fields:
        assert np.array_equal(getattr(wide, name), getattr(got, name)), name
        both = getattr(hopping_cycles(one, restitution), name)
        assert np.array_equal(both, np.repeat(getattr(wide, name)[3], 2)), name


def test_long_patterns_are_cut_and_say_so() -> None:
    code = np.zeros(1, np.int64)
    for _ in range(40):
        code = returns._append(code, np.int64(Mode.FLIGHT))
    assert spelt_text(int(code[0])) == "H" * 27 + "..."
