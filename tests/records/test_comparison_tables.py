"""A comparison in the user's units: the times and sizes of its tables."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers.made_records import PERIOD, Walked, nut

from vibro.records.comparison import compare
from vibro.records.comparison_tables import ComparisonTables
from vibro.records.reading import Record

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
    assert np.ptp(turns) > 15.0


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
