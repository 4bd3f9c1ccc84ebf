"""Elliptical drives that throw the body: the reference table, and flights followed apart from the package."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers.reference_tables import UNSETTLED_IMPACT, Table, read_table
from helpers.two_axis_scenes import displacement, random_drives, rotated

from vibro import Regime, Status


@pytest.fixture(scope="module")
def hopping() -> Table:
    return read_table("elliptic_hopping")


def test_every_hopping_row_is_the_reference_s(hopping: Table) -> None:
    columns, cycle = hopping.columns, hopping.cycle
    assert [rotated(text) for text in cycle.pattern.tolist()] == columns["pattern"]
    assert (cycle.regime == Regime.HOPPING).all()
    assert (cycle.status == Status.OK).all()
    np.testing.assert_array_equal(cycle.period_cycles, columns["period_cycles"])
    d = columns["displacement_per_cycle_m"]
    assert (np.abs(cycle.displacement_per_cycle - d) <= 1e-11 * (np.abs(d) + hopping.size)).all()
    np.testing.assert_allclose(cycle.flight_fraction, columns["flight_fraction"], rtol=1e-11)
    impact = columns["impact_speed_m_s"].copy()
    assert columns["pattern"][UNSETTLED_IMPACT] == "H"
    impact[UNSETTLED_IMPACT] = (
        9.81
        * math.cos(columns["trough_angle_rad"][UNSETTLED_IMPACT])
        / columns["frequency_hz"][UNSETTLED_IMPACT]
    )
    np.testing.assert_allclose(cycle.impact_velocity, impact, rtol=1e-11)
    np.testing.assert_allclose(cycle.throw_number, columns["throw_number"], rtol=1e-13)


def test_bodies_are_lifted_above_a_throw_number_of_one() -> None:
    some = random_drives(30, 18, steepest=0.5, least_ratio=0.6)
    below, at, above = (
        some.changed(normal=(1.0 + h) * np.cos(some.trough)).solve() for h in (-1e-12, 0.0, 1e-12)
    )
    answered = below.status != Status.RUNAWAY
    assert answered.sum() > 25
    assert (below.status[answered] == Status.OK).all()
    assert (at.status[answered] == Status.BOUNDARY).all()
    assert Regime.HOPPING not in np.concatenate([below.regime, at.regime])
    assert (above.regime == Regime.HOPPING).all()
    assert below.pattern.tolist() == at.pattern.tolist()
    size = np.abs(displacement(below)) + np.maximum(some.along, 1.0)
    assert not (np.abs(displacement(at) - displacement(below)) > 1e-4 * size).any()
    # flights are so short that nothing changes
    told = answered & (above.status == Status.OK)
    assert told.sum() > 22
    assert not (np.abs(displacement(above) - displacement(below))[told] > 1e-4 * size[told]).any()
