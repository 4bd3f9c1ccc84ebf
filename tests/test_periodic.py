"""Drives with harmonics beside tables of 200 bits: steady motions, histories, arrivals, counterexamples."""

from __future__ import annotations

import json
import math
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from helpers.cases import each
from helpers.periodic_tables import least_rotation, read_rows, scene_of, size_of

import vibro
from vibro import Status

if TYPE_CHECKING:
    from vibro import SteadyCycle

TURN = 2.0 * math.pi
EXACT = 1e-11
"""Of displacements over |d| + S, S the largest amplitude, and of what goes with them."""
# Row 28 of the table is listed as two flights of one turn each in two cycles; both are the same flight.
ONE_TURN = ("steady_plastic", 27)

STEADY = [(name, i) for name in ("steady_plastic", "steady_bouncing") for i in range(len(read_rows(name)))]


def _check(cycle: SteadyCycle, row: dict[str, str], size: float) -> None:
    """Compare what all tables of steady motions have."""
    expected = float(row["displacement_per_cycle_m"])
    assert cycle.status == Status.OK
    assert float(cycle.throw_number) == pytest.approx(float(row["throw_number"]), rel=1e-14)
    assert abs(float(cycle.displacement_per_cycle) - expected) <= EXACT * (abs(expected) + size)
    assert float(cycle.flight_fraction) == pytest.approx(float(row["flight_fraction"]), abs=EXACT)


def _check_pattern(cycle: SteadyCycle, row: dict[str, str]) -> None:
    """Compare patterns, of which the tables have the first letters where they are very long."""
    text, expected = str(cycle.pattern), row["pattern"]
    assert "..." not in text
    if "..." in expected:
        assert text.startswith("HH")
        assert expected.startswith("HH")
    else:
        assert least_rotation(text) == least_rotation(expected)
    assert float(cycle.period_cycles) == float(row["period_cycles"])


@each(("name", "index"), STEADY)
def test_steady_motions_that_hop(name: str, index: int) -> None:
    row = read_rows(name)[index]
    cycle = vibro.solve(scene_of(row))
    size, f = size_of(row), float(row["frequency_hz"])
    _check(cycle, row, size)
    if (name, index) == ONE_TURN:
        assert (row["pattern"], row["period_cycles"]) == ("HH", "2")
        assert (str(cycle.pattern), float(cycle.period_cycles)) == ("H", 1.0)
    else:
        _check_pattern(cycle, row)
    speed = TURN * f * size
    peak, impact = float(row["peak_speed_m_s"]), float(row["impact_speed_m_s"])
    assert float(cycle.peak_velocity) == pytest.approx(peak, rel=EXACT, abs=EXACT * speed)
    assert float(cycle.impact_velocity) == pytest.approx(impact, rel=EXACT, abs=EXACT * speed)
    assert float(cycle.mean_velocity) == pytest.approx(
        float(row["mean_velocity_m_s"]), rel=EXACT, abs=EXACT * size * f
    )


@each("row", read_rows("counterexamples"))
def test_counterexamples(row: dict[str, str]) -> None:
    scale, start = float(row["scale"]), float(row["start_phase_rad"])
    cycle = vibro.solve(scene_of(row, scale=scale, start=start))
    _check(cycle, row, scale * size_of(row))
    _check_pattern(cycle, row)


# ------------------------------------------------------------------------------- histories


def _merged(phases: Any, least: float) -> list[list[Any]]:
    """List kind, start and end; flights shorter than a time that follow one another are one ``h``."""
    merged: list[list[Any]] = []
    for kind, start, end in phases:
        short = kind == "h" or (kind == "H" and end - start < least)
        if short and merged and merged[-1][0] == "h":
            merged[-1][2] = end
        else:
            merged.append(["h" if short else kind, start, end])
    return merged


@each("row", read_rows("histories"))
def test_histories(row: dict[str, str]) -> None:
    assert float(row["start_velocity_m_s"]) == float(row["start_height_m"]) == 0.0
    history = vibro.simulate(
        scene_of(row), cycles=float(row["cycles"]), start_phase=float(row["start_phase_rad"])
    )
    size, f = size_of(row), float(row["frequency_hz"])
    error = max(EXACT, 1e-15 * float(row["amplification"]))
    found = history.sample(json.loads(row["times_s"]))
    for name, column, unit in (
        ("position", "position_m", size),
        ("velocity", "velocity_m_s", size * TURN * f),
        ("gap", "height_m", size),
    ):
        off = np.abs(getattr(found, name) - json.loads(row[column]))
        assert off.max() <= error * unit, name
    least = 1e-6 / (TURN * f)
    phases = _merged(((p.kind, p.start, p.end) for p in history.phases), least)
    expected = _merged(json.loads(row["phases"]), least)
    assert [p[0] for p in phases] == [p[0] for p in expected]
    starts = np.array([p[1] for p in phases]) - [p[1] for p in expected]
    assert np.abs(starts).max() * f <= error
    ends = np.array([p[2] for p in phases[:-1]]) - [p[2] for p in expected[:-1]]
    assert np.abs(ends).max() * f <= error


# ------------------------------------------------------------------------------- arrivals


@each("row", read_rows("arrival_times"))
def test_arrivals(row: dict[str, str]) -> None:
    time = float(vibro.arrival_time(scene_of(row), float(row["length_m"])))
    expected = float(row["arrival_time_s"])
    assert time == expected or abs(time - expected) <= 1e-10 * expected
