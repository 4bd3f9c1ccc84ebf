"""A block of scenes of every kind: what is known of each, and what is left open."""

from __future__ import annotations

import numpy as np
import pytest
from scenes import Groups, at_load, random_scenes, replaced

import vibro
from vibro import Regime, Status


def test_other_cycles_are_looked_for_wherever_there_is_an_answer_in_contact() -> None:
    scene = random_scenes(5000, seed=11, most_trough_deg=30.0, least_ratio=0.05)
    cycle = vibro.solve(scene, flight=False)
    answered = np.isfinite(cycle.displacement_per_cycle)
    assert {int(s) for s in cycle.status[~answered]} == {Status.RUNAWAY}
    assert (cycle.coexists[~answered] == -1).all()
    assert set(cycle.coexists[answered].tolist()) == {0, 1}
    assert (cycle.coexists[cycle.regime == Regime.NO_SLIP] == 0).all()


def test_regimes_alone_leave_open_whether_cycles_coexist() -> None:
    # on a trough steeper than kinetic friction slides are solved for their class, and withdrawn after it
    steep = at_load([1.2411, 1.49149], [23.7, 40.3], [0.5323, 0.4578], [0.004, 0.0429], [0.3, 0.0])
    assert vibro.solve(steep).coexists.tolist() == [1, 1]
    cycle = vibro.solve(steep, accuracy="regimes")
    assert cycle.pattern.tolist() == ["", ""]
    assert cycle.coexists.tolist() == [-1, -1]
    at_rest = vibro.solve(at_load(0.1, 20.0, 0.5, 0.4), accuracy="regimes")
    assert at_rest.coexists == 0


@pytest.mark.parametrize(
    ("groups", "status"),
    [
        (Groups(8.0, 30.0, 0.5, 0.4), Status.FLIGHT_NOT_MODELLED),
        (Groups(0.5, 30.0, 0.3, 0.2, 20.0), Status.RUNAWAY),
        (Groups(0.5, 30.0, 0.0, 0.0), Status.INDETERMINATE),
    ],
)
def test_cells_without_an_answer_are_not_looked_at(groups: Groups, status: Status) -> None:
    cycle = vibro.solve(at_load(*groups), flight=False)
    assert cycle.status == status
    assert cycle.coexists == -1


def test_hopping_cells_are_looked_at_where_kinetic_friction_is_low() -> None:
    ratio = np.array([0.74, 0.76])
    assert vibro.solve(at_load(3.0, 30.0, 0.5, 0.5 * ratio)).coexists.tolist() == [0, -1]
    # nor is a motion without a period
    irregular = vibro.solve(replaced(at_load([4.9], 30.0, 0.5, 0.1), restitution=0.3))
    assert irregular.status == Status.AVERAGED
    assert irregular.coexists == -1
