"""Every row of the contact tables, computed independently with 50 digits, and the published numbers."""

from __future__ import annotations

import csv
import math
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

import vibro
from vibro.motion.settled import cycle_phases

DATA = Path(__file__).parent / "data"
EPS = float(np.finfo(float).eps)

CONTACT_ROWS = {
    "contact_regular": 160,
    "contact_extreme": 160,
    "contact_incline": 100,
    "contact_steep": 50,
    "contact_descent": 50,
}

# The tables print the smallest rotation of a pattern in ASCII order.
PATTERN = {"_": "_", "F_": "F_", "B_": "B_", "B_F_": "F_B_", "B_F": "FB_", "BF_": "F_B", "BF": "FB"}


class Table(NamedTuple):
    columns: dict[str, Any]
    scene: vibro.Scene
    cycle: vibro.SteadyCycle


def _numbers(rows: list[dict[str, str]], column: str) -> np.ndarray:
    return np.array([float(row[column] or "nan") for row in rows])


@pytest.fixture(scope="module", params=CONTACT_ROWS)
def table(request: pytest.FixtureRequest) -> Table:
    with (DATA / f"{request.param}.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == CONTACT_ROWS[request.param]
    scene = vibro.Scene(
        amplitude=_numbers(rows, "amplitude_mm") / 1000.0,
        frequency=_numbers(rows, "frequency_hz"),
        drive_angle=np.radians(_numbers(rows, "drive_angle_deg")),
        static_friction=_numbers(rows, "static_friction"),
        kinetic_friction=_numbers(rows, "kinetic_friction"),
        trough_angle=np.radians(_numbers(rows, "trough_angle_deg")),
    )
    columns = {
        "pattern": [row["pattern"] for row in rows],
        **{
            name: _numbers(rows, name)
            for name in ("displacement_per_cycle_mm", "mean_velocity_mm_s", "condition", "amplitude_mm")
        },
    }
    return Table(columns, scene, vibro.solve(scene))


def test_every_pattern_is_the_reference_s(table: Table) -> None:
    expected = [PATTERN.get(pattern, "") for pattern in table.columns["pattern"]]
    assert table.cycle.pattern.tolist() == expected


def test_status_says_where_no_steady_cycle_exists(table: Table) -> None:
    for pattern, status in zip(table.columns["pattern"], table.cycle.status, strict=True):
        allowed = {vibro.Status.RUNAWAY} if pattern == "runaway" else {vibro.Status.OK, vibro.Status.BOUNDARY}
        assert vibro.Status(status) in allowed


def _excess(table: Table, got: np.ndarray, expected: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """Error over what rounding of the inputs alone explains, in eps; 0 where no number is expected."""
    both_ways = np.array(["F" in p and "B" in p for p in table.columns["pattern"]])
    size = np.abs(expected)
    floor = np.where(both_ways, scale, size)
    condition = np.where(np.isnan(table.columns["condition"]), 0.0, table.columns["condition"])
    missing = np.isnan(expected)
    assert np.array_equal(np.isnan(got), missing)
    still = expected == 0.0
    assert np.array_equal(got[still & ~both_ways], expected[still & ~both_ways])
    unit = np.where(missing | (still & ~both_ways), 1.0, EPS * (condition * size + floor))
    return np.where(missing, 0.0, np.abs(got - expected)) / unit


def test_displacement_is_exact_up_to_conditioning(table: Table) -> None:
    excess = _excess(
        table,
        1000.0 * table.cycle.displacement_per_cycle,
        table.columns["displacement_per_cycle_mm"],
        table.columns["amplitude_mm"],
    )
    assert excess.max() <= 16.0


def test_mean_velocity_is_exact_up_to_conditioning(table: Table) -> None:
    excess = _excess(
        table,
        1000.0 * table.cycle.mean_velocity,
        table.columns["mean_velocity_mm_s"],
        table.columns["amplitude_mm"] * table.scene.frequency,
    )
    assert excess.max() <= 16.0


def _published(amplitude_mm: float) -> vibro.Scene:
    """Return the scene of the published example at some amplitude."""
    return vibro.Scene(
        amplitude=amplitude_mm / 1000.0,
        frequency=15.0,
        drive_angle=math.radians(20.0),
        static_friction=0.74,
        kinetic_friction=0.57,
    )


@pytest.mark.parametrize(
    ("amplitude_mm", "pattern", "mean_velocity_mm_s"),
    [
        (0.685165, "_", "0.000000"),
        (0.8, "F_", "5.454804"),
        (0.9, "F_", "10.441364"),
        (1.0, "F_", "16.263456"),
        (1.1, "F_", "22.741042"),
        (1.19, "F_", "29.019906"),
        (1.2, "F_B_", "27.119929"),
        (1.3, "F_B_", "30.743137"),
        (1.5, "FB_", "40.590623"),
        (1.6, "FB", "46.819272"),
        (2.0, "FB", "67.617507"),
        (3.0, "FB", "113.297416"),
        (3.22, "FB", "122.874100"),
    ],
)
def test_speeds_of_the_published_scene_to_all_digits(
    amplitude_mm: float, pattern: str, mean_velocity_mm_s: str
) -> None:
    cycle = vibro.solve(_published(amplitude_mm))
    assert str(cycle.pattern) == pattern
    assert f"{1000.0 * cycle.mean_velocity:.6f}" == mean_velocity_mm_s


@pytest.mark.parametrize(
    ("last_mm", "before", "after"),
    [
        (0.685165, vibro.Regime.NO_SLIP, vibro.Regime.FORWARD_SLIP),
        (1.190299, vibro.Regime.FORWARD_SLIP, vibro.Regime.BACK_SLIP),
        (3.229052, vibro.Regime.BACK_SLIP, vibro.Regime.HOPPING),
    ],
)
def test_amplitudes_where_the_published_scene_changes_regime(
    last_mm: float, before: vibro.Regime, after: vibro.Regime
) -> None:
    assert vibro.solve(_published(last_mm - 0.5e-6)).regime == before
    assert vibro.solve(_published(last_mm + 1.0e-6)).regime == after


def test_speed_jumps_at_the_forward_onset() -> None:
    onset = 0.74 * 9.81 / ((30.0 * math.pi) ** 2 * (math.cos(math.pi / 9) + 0.74 * math.sin(math.pi / 9)))
    above = [vibro.solve(_published(1000.0 * onset * (1.0 + h))).mean_velocity for h in (1e-12, 1e-6)]
    # The limit is 0.65898397, from 40 digits; above it the speed grows like the root of the excess load.
    assert [f"{1000.0 * v:.4f}" for v in above] == ["0.6590", "0.6624"]


def test_speed_drops_where_back_slip_sets_in() -> None:
    before, after = (vibro.solve(_published(a)).mean_velocity for a in (1.190298, 1.190300))
    assert f"{100.0 * (1.0 - after / before):.0f}" == "6"


def test_one_stroke_of_the_published_scene_to_all_digits() -> None:
    scene = _published(1.0)
    cycle = vibro.solve(scene)
    forward, rest = cycle_phases(scene)
    assert forward.kind + rest.kind == "F_"
    assert f"{1.0 / cycle.forward_ratio:.6f}" == "0.685165"
    assert f"{1000.0 * forward.start:.5f}" == "8.00900"
    assert f"{1000.0 * forward.end:.5f}" == "38.68329"
    assert f"{1000.0 * cycle.peak_velocity:.4f}" == "60.1496"
    assert f"{1000.0 * cycle.displacement_per_cycle:.6f}" == "1.084230"
    assert f"{1000.0 * cycle.mean_velocity:.5f}" == "16.26346"


def test_least_forward_onset_lies_at_the_angle_of_static_friction() -> None:
    # the optimum that JSPE 33/391 confirmed by experiment
    angles = np.radians(np.linspace(0.0, 80.0, 8001))
    scene = vibro.Scene(
        amplitude=1e-3, frequency=15.0, drive_angle=angles, static_friction=0.74, kinetic_friction=0.57
    )
    best = angles[np.argmax(vibro.solve(scene).forward_ratio)]
    assert best == pytest.approx(math.atan(0.74), abs=math.radians(0.01))
