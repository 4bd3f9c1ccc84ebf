"""A comparison in the user's units: the times and sizes of its tables."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers.made_records import PERIOD, Walked, nut

from vibro.records.alignment import Observation
from vibro.records.comparison import compare
from vibro.records.comparison_tables import ComparisonTables
from vibro.records.fitting import Fit, Parameter
from vibro.records.folding import Estimate
from vibro.records.reading import Record
from vibro.records.trough import MeasuredDrive, Trough, Wave

UNITS = {"displacement": ("mm", 1e-3), "velocity": ("mm_s", 1e-3), "acceleration": ("m_s2", 1.0)}


@pytest.fixture(scope="module")
def tables() -> ComparisonTables:
    observed = Walked(nut()).observe(*UNITS, "friction", trigger=0.0501)
    record = Record(observed.time, observed.signals, {}, {"time": "t [s]", "velocity": "v [mm/s]"})
    return ComparisonTables(compare(nut(), observed), record, mass=0.02)


def test_trough_times_lie_within_one_period(tables: ComparisonTables) -> None:
    signals = tables.signals()
    times = np.asarray(signals["trough_time_s"], float)
    assert 0.0 <= times.min() < 0.02 * PERIOD
    assert 0.95 * PERIOD < times.max() < PERIOD
    turns = (times - np.asarray(signals["time_s"], float) - 0.0501) / PERIOD
    assert np.abs(turns - np.round(turns)).max() < 0.01
    assert np.ptp(turns) > 8.0


def test_signals_have_the_units_of_their_headers(tables: ComparisonTables) -> None:
    """Friction is a force, as the mass is known."""
    signals, comparison = tables.signals(), tables.comparison
    for name, (suffix, size) in {**UNITS, "friction": ("N", 1.0 / 0.02)}.items():
        for kind, values in (("measured", comparison.observation.signals), ("computed", comparison.computed)):
            found = np.asarray(signals[f"{name}_{kind}_{suffix}"], float)
            np.testing.assert_allclose(found * size, values[name], rtol=1e-12)


def test_figures_are_the_same_in_the_table_and_in_json(tables: ComparisonTables) -> None:
    summary, content = tables.summary(), tables.content()
    rows = {row.key: row for row in tables.comparison.rows}
    assert list(summary["quantity"]) == list(content["figures"]) == list(rows)
    for i, (key, figure) in enumerate(content["figures"].items()):
        row = rows[key]
        size = {"mm": 1e-3, "mm/s": 1e-3, "ms": 1e-3, "m/s^2": 1.0, "N": 50.0}[figure["unit"]]
        assert summary["unit"][i] == figure["unit"]
        expected = {
            "measured": row.measured.value,
            "standard_error": row.measured.error,
            "computed": row.computed,
        }
        for column, value in expected.items():
            assert float(summary[column][i]) * size == pytest.approx(value, nan_ok=True)
            assert figure[column] == (None if math.isnan(value) else pytest.approx(value / size))


def test_trough_times_are_those_of_the_clock_within_a_period() -> None:
    """Also of a clock that counts from far away."""
    observed = Walked(nut()).observe("velocity", trigger=0.0501)
    late = Observation(observed.time + 7.0 * PERIOD, observed.signals, observed.frequency)
    found = ComparisonTables(compare(nut(), late), Record(late.time, late.signals, {}, {}))
    times = np.asarray(found.signals()["trough_time_s"], float)
    expected = (observed.time + 0.0501) % PERIOD
    off = (times - expected + 0.5 * PERIOD) % PERIOD - 0.5 * PERIOD
    assert np.abs(off).max() < 1e-4
    assert np.all((times >= 0.0) & (times < PERIOD))


def test_without_a_mass_friction_is_an_acceleration() -> None:
    observed = Walked(nut()).observe("friction", trigger=0.02)
    found = ComparisonTables(compare(nut(), observed), Record(observed.time, {}, {}, {}))
    measured = np.asarray(found.signals()["friction_measured_m_s2"], float)
    np.testing.assert_allclose(measured, observed.signals["friction"])
    assert found.content()["figures"]["rms_friction"]["unit"] == "m/s^2"


def test_the_columns_of_the_data_are_listed(tables: ComparisonTables) -> None:
    assert set(tables.summary()["data_columns"]) == {"t [s]; v [mm/s]"}
    assert tables.content()["columns"] == {"time": "t [s]", "velocity": "v [mm/s]"}
    assert tables.content()["trough_time_at_zero_s"] == tables.comparison.alignment.shift
    assert tables.content()["trough_time_error_s"] == tables.comparison.alignment.error


def test_what_is_not_finite_is_nothing_in_json() -> None:
    resting = nut(0.5)
    observed = Walked(resting).observe("velocity")
    content = ComparisonTables(compare(resting, observed), Record(observed.time, {}, {}, {})).content()
    assert content["trough_time_at_zero_s"] is None
    assert content["trough_time_error_s"] is None
    assert content["figures"]["rms_velocity"]["computed"] is None


def test_estimates_are_in_the_users_units() -> None:
    """A range without an estimate has ends; what has neither has none."""
    observed = Walked(nut()).observe("velocity")
    parameters = (
        Parameter("amplitude", 1.5e-3, ((1e-3, 2e-3), (3e-3, 4e-3)), True),
        Parameter("drive_angle", math.radians(30.0), ((math.radians(20.0), math.radians(45.0)),), False),
        Parameter("kinetic_friction", 0.4, (), False),
    )
    fitted = Fit(nut(), parameters, ("one", "two"))
    found = ComparisonTables(compare(nut(), observed), Record(observed.time, {}, {}, {}), fit=fitted)
    content = found.content()
    assert content["fit"] == {
        "amplitude": {
            "unit": "mm",
            "estimate": pytest.approx(1.5),
            "low": pytest.approx(1.0),
            "high": pytest.approx(4.0),
            "intervals": [pytest.approx([1.0, 2.0]), pytest.approx([3.0, 4.0])],
        },
        "drive_angle": {
            "unit": "deg",
            "estimate": None,
            "low": pytest.approx(20.0),
            "high": pytest.approx(45.0),
            "intervals": [pytest.approx([20.0, 45.0])],
        },
        "kinetic_friction": {"unit": "", "estimate": None, "low": None, "high": None, "intervals": []},
    }
    assert content["fit_statements"] == ["one", "two"]


def test_what_was_measured_of_the_trough() -> None:
    """In the user's units; nothing of a phase that is not there."""
    along = Wave("u [g]", 3.0 - 4.0j, 0.1, 0.02, 0.3, "")
    normal = Wave("w [g]", -0.6 + 0.8j, 0.2, 0.04, 0.05, "1V/g")
    observed = Walked(nut()).observe("velocity")
    comparison, record = compare(nut(), observed), Record(observed.time, {}, {}, {})
    quantities = {
        "amplitude": Estimate(1e-3, 2e-6),
        "drive_angle": Estimate(math.radians(20.0), math.radians(0.5)),
        "frequency": Estimate(15.0, math.nan),
    }
    drive = MeasuredDrive(
        Trough(Estimate(15.0, 0.1), along, normal, 2.0), quantities, Estimate(0.01, 1e-4), ("doubtful",)
    )
    content = ComparisonTables(comparison, record, drive=drive).content()["trough"]
    assert content == {
        "amplitude_mm": {"measured": pytest.approx(1.0), "standard_error": pytest.approx(2e-3)},
        "drive_angle_deg": {"measured": pytest.approx(20.0), "standard_error": pytest.approx(0.5)},
        "frequency_hz": {"measured": 15.0, "standard_error": None},
        "phase_normal_to_along_deg": pytest.approx(180.0),
        "along": {
            "column": "u [g]",
            "acceleration_m_s2": {"measured": pytest.approx(5.0), "standard_error": 0.1},
            "harmonics": 0.02,
            "rest": 0.3,
        },
        "normal": {
            "column": "w [g]",
            "acceleration_m_s2": {"measured": pytest.approx(1.0), "standard_error": 0.2},
            "harmonics": 0.04,
            "rest": 0.05,
        },
        "warnings": ["doubtful"],
    }
    alone = drive._replace(trough=Trough(Estimate(15.0, 0.1), None, normal, 2.0))
    content = ComparisonTables(comparison, record, drive=alone).content()["trough"]
    assert content["phase_normal_to_along_deg"] is None
    assert "along" not in content
