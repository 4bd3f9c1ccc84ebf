"""Histories in rows: even steps, events with one or both of their sides, and units."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers.made_records import PERIOD, nut

import vibro
from vibro.core.codes import PHASE_NAMES
from vibro.motion.histories import motion_table, trace
from vibro.results.history import phase_table


@pytest.fixture
def history() -> vibro.History:
    return vibro.simulate(nut(), cycles=3)


def test_rows_begin_and_end_where_they_are_asked_to(history: vibro.History) -> None:
    slide = history.phases[1]
    whole = trace(history, until=history.end, samples_per_cycle=40, both_sides=True)
    rows = trace(history, since=0.5 * PERIOD, until=2.2 * PERIOD, samples_per_cycle=40, both_sides=True)
    inside = (whole.time > 0.5 * PERIOD) & (whole.time < 2.2 * PERIOD)
    assert rows.time[0] == 0.5 * PERIOD
    assert rows.time[-1] == 2.2 * PERIOD
    kept = (rows.time > 0.5 * PERIOD) & (rows.time < 2.2 * PERIOD)
    np.testing.assert_array_equal(rows.time[kept], whole.time[inside])
    np.testing.assert_array_equal(rows.friction[kept], whole.friction[inside])
    at = trace(history, since=slide.start, until=history.end, samples_per_cycle=40, both_sides=True)
    assert at.time[1] > at.time[0] == slide.start
    assert at.acceleration[0] > 1.0  # of the slide that begins


def test_both_sides_of_an_event_follow_each_other(history: vibro.History) -> None:
    rows = trace(history, until=history.end, samples_per_cycle=40, both_sides=True)
    assert (np.diff(rows.time) >= 0.0).all()
    slide = history.phases[1]
    before, after = np.flatnonzero(rows.time == slide.start)
    assert after == before + 1
    assert rows.acceleration[before] == 0.0 < rows.acceleration[after]
    assert abs(rows.friction[before]) == pytest.approx(rows.static_limit[before], rel=1e-12)
    np.testing.assert_allclose(rows.acceleration, rows.inertial + rows.friction, atol=1e-12)


def test_both_sides_of_a_jump_follow_each_other() -> None:
    """Else a picture draws a slope there, and a friction that no trough can exert."""
    motion = vibro.Motion.steps(along=[(0.8, 2.4), (0.2, -9.6)])
    scene = vibro.Scene(motion=motion, frequency=2.5, static_friction=0.3, kinetic_friction=0.25)
    history = vibro.simulate(scene, cycles=3)
    rows = trace(history, until=history.end, samples_per_cycle=100, both_sides=True)
    changes = np.flatnonzero(np.diff(rows.inertial))
    assert np.diff(rows.time)[changes].max() < 1e-12
    assert rows.time[changes] == pytest.approx([0.32, 0.4, 0.72, 0.8, 1.12])
    assert np.abs(rows.friction).max() < 0.3 * 9.81
    assert (rows.time[-1], rows.inertial[-1]) == (history.end, pytest.approx(9.6))  # before it jumps back
    tabled = trace(history, until=history.end, samples_per_cycle=0)
    assert tabled.time.tolist() == [0.0, *[p.start for p in history.phases[1:]], history.end]


def test_the_motion_table_is_in_the_units_of_its_headers(history: vibro.History) -> None:
    rows = trace(history, until=history.end, samples_per_cycle=100)
    table = motion_table(history, rows)
    sizes = {len(column) for column in table.values()}
    assert sizes == {rows.time.size}
    position = np.asarray(table["relative_position_mm"], float)
    assert position[-1] == pytest.approx(3 * 1.0842304, rel=1e-6)
    velocity = np.asarray(table["relative_velocity_mm_s"], float)
    assert velocity.max() == pytest.approx(60.15, abs=0.05)
    trough = np.asarray(table["trough_displacement_mm"], float)
    phase = np.asarray(table["trough_phase_deg"], float)
    assert ((phase >= 0.0) & (phase < 360.0)).all()
    np.testing.assert_allclose(trough, np.sin(np.radians(phase)), atol=1e-9)
    names = np.array(table["phase"])
    assert set(names) == {"rest", "forward slide"}
    assert (velocity[names == "rest"] == 0.0).all()
    assert (np.asarray(table["gap_mm"], float) == 0.0).all()


def test_the_motion_table_names_the_phase_that_begins_at_an_event(history: vibro.History) -> None:
    table = motion_table(history, trace(history, until=history.end, samples_per_cycle=0))
    begun = [PHASE_NAMES[p.kind] for p in history.phases]
    assert table["phase"] == [*begun, begun[-1]]


def test_trough_phases_begin_where_the_run_does() -> None:
    history = vibro.simulate(nut(), cycles=1, start_phase=math.radians(90))
    table = motion_table(history, trace(history, until=history.end, samples_per_cycle=4))
    assert np.asarray(table["trough_phase_deg"], float)[0] == pytest.approx(90.0)
    assert np.asarray(table["trough_displacement_mm"], float)[0] == pytest.approx(1.0)


def test_the_phase_table(history: vibro.History) -> None:
    table = phase_table(history, history.phases)
    assert list(table["phase"]) == [PHASE_NAMES[p.kind] for p in history.phases]
    starts, ends = np.asarray(table["start_s"], float), np.asarray(table["end_s"], float)
    np.testing.assert_array_equal(starts[1:], ends[:-1])
    assert 1e3 * starts[1] == pytest.approx(8.00900, abs=5e-6)
    assert 1e3 * ends[1] == pytest.approx(38.68329, abs=5e-6)
    degrees = np.asarray(table["trough_phase_at_start_deg"], float)
    assert degrees[1] == pytest.approx(math.degrees(math.asin(0.685165)), abs=1e-4)
    for column in table.values():
        if isinstance(column, np.ndarray):
            assert not np.signbit(column).any()
