"""Every row of the contact tables, computed independently with 50 digits, and the published numbers."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import pytest
from helpers.cases import each
from helpers.reference_tables import CONTACT, Table, read_table

import vibro
from vibro import Regime, Status
from vibro.motion.settled import cycle_phases

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

EPS = float(np.finfo(float).eps)
LIMIT = {**dict.fromkeys(CONTACT, 16.0), "harmonic_contact": 8.0}
"""Times what rounding of the inputs alone explains."""


@pytest.fixture(scope="module", params=CONTACT)
def table(request: pytest.FixtureRequest) -> Table:
    return read_table(request.param)


@pytest.fixture(scope="module", params=["elliptic_contact", "harmonic_contact"])
def wide_table(request: pytest.FixtureRequest) -> Table:
    """A table that has regimes, peak speeds, and loads over thresholds too."""
    return read_table(request.param)


def test_every_pattern_is_the_reference_s(table: Table) -> None:
    assert table.cycle.pattern.tolist() == table.pattern


def test_status_says_where_no_steady_cycle_exists(table: Table) -> None:
    expected = [Status.OK if pattern else Status.RUNAWAY for pattern in table.pattern]
    assert [Status(s) for s in table.cycle.status] == expected


def test_every_regime_is_the_reference_s(wide_table: Table) -> None:
    runaway = {"runaway-forward": "forward-slip", "runaway-back": "back-slip"}
    expected = [runaway.get(text, text) for text in wide_table.columns["regime"]]
    assert [Regime(r).label for r in wide_table.cycle.regime] == expected


def _excess(table: Table, got: Floats, expected: Floats, scale: Floats | float) -> Floats:
    """Error over what rounding of the inputs alone explains, in eps; 0 where no number is expected."""
    size = np.abs(expected)
    floor = np.where(table.both_ways, scale, size)
    missing = np.isnan(expected)
    assert np.array_equal(np.isnan(got), missing)
    still = (expected == 0.0) & ~table.both_ways
    assert np.array_equal(got[still], expected[still])
    unit = np.where(missing | still, 1.0, EPS * (np.nan_to_num(table.columns["condition"]) * size + floor))
    return np.where(missing, 0.0, np.abs(got - expected)) / unit


def test_displacement_is_exact_up_to_conditioning(table: Table) -> None:
    got = table.metre * table.cycle.displacement_per_cycle
    assert _excess(table, got, table.displacement, table.amplitude).max() <= LIMIT[table.name]


def test_mean_velocity_is_exact_up_to_conditioning(table: Table) -> None:
    got, scale = table.metre * table.cycle.mean_velocity, table.amplitude * table.scene.frequency
    assert _excess(table, got, table.mean_velocity, scale).max() <= LIMIT[table.name]


def test_peak_speeds_of_ellipses_are_exact_up_to_conditioning() -> None:
    table = read_table("elliptic_contact")
    peak, got = table.columns["peak_speed_m_s"], table.cycle.peak_velocity
    np.testing.assert_array_equal(np.isnan(got), np.isnan(peak))
    moves = np.zeros(peak.shape)
    fields = table.scene.arrays()._asdict()
    for name in fields.keys() - {"gravity", "restitution"}:
        x = fields[name] * (1.0 - 1e-9)
        other = vibro.solve(vibro.Scene.allowing_infeasible(**fields | {name: x}))
        change = np.where(other.pattern == table.cycle.pattern, other.peak_velocity - got, 0.0)
        moves += np.nan_to_num(np.abs(change)) / 1e-9
    allowed = np.maximum(1e-11 * peak, 16.0 * EPS * moves)
    assert not (np.abs(got - peak) > allowed).any()


def test_peak_speeds_of_harmonics_are_exact_up_to_conditioning() -> None:
    table = read_table("harmonic_contact")
    peak, got = table.columns["peak_speed_m_s"], table.cycle.peak_velocity
    np.testing.assert_array_equal(np.isnan(got), np.isnan(peak))
    moves = table.displacement != 0.0
    error = np.abs(got / np.where(moves, peak, 1.0) - 1.0)[moves & ~np.isnan(got)]
    assert (error < 4.0 * EPS * (1.0 + table.columns["condition"][moves & ~np.isnan(got)])).all()


@pytest.mark.parametrize("name", ["throw_number", "forward_ratio", "back_ratio"])
def test_loads_over_thresholds_are_the_reference_s(wide_table: Table, name: str) -> None:
    known, got = wide_table.columns[name], getattr(wide_table.cycle, name)
    if wide_table.name == "harmonic_contact":
        known, got = (x[wide_table.cycle.status == Status.OK] for x in (known, got))
        assert (np.abs(got - known) / np.maximum(known, 1.0) < 8.0 * EPS).all()
    np.testing.assert_allclose(got, known, rtol=1e-13)


def _published(amplitude_mm: float) -> vibro.Scene:
    """Return the scene of the published example at some amplitude."""
    return vibro.Scene(
        amplitude=amplitude_mm / 1000.0,
        frequency=15.0,
        drive_angle=math.radians(20.0),
        static_friction=0.74,
        kinetic_friction=0.57,
    )


@each(
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


def test_speed_jumps_at_the_forward_onset() -> None:
    onset = 0.74 * 9.81 / ((30.0 * math.pi) ** 2 * (math.cos(math.pi / 9) + 0.74 * math.sin(math.pi / 9)))
    above = [vibro.solve(_published(1000.0 * onset * (1.0 + h))).mean_velocity for h in (1e-12, 1e-6)]
    # The limit is 0.65898397, from 40 digits; above it the speed grows like the root of the excess load.
    assert [f"{1000.0 * v:.4f}" for v in above] == ["0.6590", "0.6624"]


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
