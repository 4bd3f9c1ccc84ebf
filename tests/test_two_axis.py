"""Elliptical drives: every row of the reference tables, and motion followed apart from the package."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from engines import integrated
from engines.two_axis_walk import Body, NeverEndsError
from helpers.scenes import Groups
from helpers.two_axis_scenes import EPS, TURN, compare, drives, random_drives
from helpers.two_axis_tables import ROWS, UNSETTLED_IMPACT, Table, read_rows, read_table

import vibro
from vibro import Regime, Status


@pytest.fixture(scope="module")
def contact() -> Table:
    return read_table("elliptic_contact")


# --- the tables -------------------------------------------------------------------------------------


def test_every_pattern_regime_and_status_is_the_reference_s(contact: Table) -> None:
    columns, cycle = contact.columns, contact.cycle
    expected = ["" if text == "runaway" else text for text in columns["pattern"]]
    assert cycle.pattern.tolist() == expected
    runaway = {"runaway-forward": "forward-slip", "runaway-back": "back-slip"}
    assert [Regime(r).label for r in cycle.regime] == [runaway.get(r, r) for r in columns["regime"]]
    ends = [Status.RUNAWAY if text == "runaway" else Status.OK for text in columns["pattern"]]
    assert [Status(s) for s in cycle.status] == ends


def test_displacements_are_exact_up_to_conditioning(contact: Table) -> None:
    d, got = contact.columns["displacement_per_cycle_m"], contact.cycle.displacement_per_cycle
    np.testing.assert_array_equal(np.isnan(got), np.isnan(d))
    rounding = 16.0 * EPS * (np.nan_to_num(contact.columns["condition"]) * np.abs(d) + contact.size)
    assert not (np.abs(got - d) > rounding).any()
    speed = contact.columns["mean_velocity_m_s"]
    assert not (np.abs(contact.cycle.mean_velocity - speed) > rounding * contact.scene.frequency).any()


def test_peak_speeds_are_exact_up_to_conditioning(contact: Table) -> None:
    peak, got = contact.columns["peak_speed_m_s"], contact.cycle.peak_velocity
    np.testing.assert_array_equal(np.isnan(got), np.isnan(peak))
    moves = np.zeros(peak.shape)
    for name in ("along_amplitude", "normal_amplitude", "normal_phase", "frequency", "static_friction",
                 "kinetic_friction", "trough_angle"):  # fmt: skip
        x = np.asarray(getattr(contact.scene, name))
        other = vibro.solve(
            vibro.Scene.allowing_infeasible(**_fields(contact.scene) | {name: x * (1.0 - 1e-9)})
        )
        change = np.where(other.pattern == contact.cycle.pattern, other.peak_velocity - got, 0.0)
        moves += np.nan_to_num(np.abs(change)) / 1e-9
    allowed = np.maximum(1e-11 * peak, 16.0 * EPS * moves)
    assert not (np.abs(got - peak) > allowed).any()


def _fields(scene: vibro.Scene) -> dict[str, Any]:
    names = ("along_amplitude", "normal_amplitude", "normal_phase", "frequency", "static_friction",
             "kinetic_friction", "trough_angle")  # fmt: skip
    return {name: getattr(scene, name) for name in names}


@pytest.mark.parametrize("name", ["throw_number", "forward_ratio", "back_ratio"])
def test_loads_over_thresholds_are_the_reference_s(contact: Table, name: str) -> None:
    np.testing.assert_allclose(getattr(contact.cycle, name), contact.columns[name], rtol=1e-13)


# --- the walk ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ROWS)
def test_the_walk_is_right_on_every_row(name: str) -> None:
    for i, row in enumerate(read_rows(name)):
        units = ("_m", "_rad", "_hz")
        values = {column: float(text) for column, text in row.items() if column.endswith(units) and text}
        body = Body(
            values["x_amplitude_m"],
            values["y_amplitude_m"],
            values["phase_rad"],
            values["frequency_hz"],
            float(row["static_friction"]),
            float(row["kinetic_friction"]),
            values["trough_angle_rad"],
        )
        if row["pattern"] == "runaway":
            with pytest.raises(NeverEndsError):
                body.settle()
            continue
        cycle = body.settle()
        assert (cycle.pattern, cycle.period) == (row["pattern"], int(row["period_cycles"])), i
        d = values["displacement_per_cycle_m"]
        size = abs(d) + max(values["x_amplitude_m"], values["y_amplitude_m"])
        assert cycle.displacement * body.unit == pytest.approx(d, abs=1e-11 * size), i
        speed = body.unit * TURN * values["frequency_hz"]
        if name == "elliptic_contact":
            assert cycle.peak * speed == pytest.approx(float(row["peak_speed_m_s"]), rel=1e-11), i
        else:
            assert cycle.flight_fraction == pytest.approx(float(row["flight_fraction"]), rel=1e-11), i
            if i != UNSETTLED_IMPACT:
                assert cycle.impact * speed == pytest.approx(float(row["impact_speed_m_s"]), rel=1e-11), i


@pytest.mark.parametrize(
    ("groups", "lead", "e", "turns"),
    [
        (Groups(1.0, 20.0, 0.74, 0.57), -1.0, 0.0, 3),
        (Groups(1.3, 20.0, 0.5, 0.4, 2.0), 2.2, 0.0, 6),
        (Groups(1.4, 35.0, 0.4, 0.3, -4.0), -2.5, 0.0, 6),
        (Groups(0.95, 80.0, 0.5, 0.4, 6.0), 1.4, 0.0, 3),
        (Groups(3.0, 25.0, 0.5, 0.4), -1.2, 0.0, 4),
        (Groups(3.0, 35.0, 0.5, 0.4, 3.0), 2.0, 0.3, 3),
    ],
)
def test_bodies_walk_as_integrated_ones(groups: Groups, lead: float, e: float, turns: int) -> None:
    alpha = math.radians(groups.drive_deg)
    along, normal = groups.load * math.cos(alpha), groups.load * math.sin(alpha)
    (walk,) = drives(
        along, normal, lead, groups.mu_s, groups.mu_d, math.radians(groups.trough_deg), e
    ).bodies()
    body = integrated.Body(groups, e, lead=lead)
    phase, place = 0.0, 0.0
    for leg in walk.legs():
        phase, place = phase + leg.length, place + leg.path
        if phase > turns * TURN:
            break
        body.until(phase)
        # the smallest bounces are left out by both, but not the same ones
        assert groups.load * body.state[0] == pytest.approx(place, abs=1e-9 if e == 0.0 else 1e-6)


# --- random scenes ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("seed", "steepest", "least_ratio"), [(1, 0.0, 0.4), (2, 0.9, 0.4), (3, 0.0, 0.05), (4, 0.3, 0.05)]
)
def test_random_scenes_settle_as_the_walk_does(seed: int, steepest: float, least_ratio: float) -> None:
    seen = compare(random_drives(60, seed, steepest=steepest, least_ratio=least_ratio))
    assert len(seen) >= 5
