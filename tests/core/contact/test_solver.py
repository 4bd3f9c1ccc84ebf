"""A block of scenes of every kind: what is known of each, and what is left open."""

from __future__ import annotations

import numpy as np
import pytest
from scenes import Groups, at_load, random_scenes

import vibro
from vibro import Regime, Status


def test_other_cycles_are_looked_for_wherever_there_is_an_answer_in_contact() -> None:
    scene = random_scenes(5000, seed=11, most_trough_deg=30.0, least_ratio=0.05)
    cycle = vibro.solve(scene, flight=False)
    answered = np.isfinite(cycle.displacement_per_cycle)
    assert {int(s) for s in cycle.status[~answered]} == {Status.RUNAWAY}
    assert (cycle.coexists[~answered] == -1).all()
    assert set(cycle.coexists[answered].tolist()) == {0, 1}
    # a pushed body at rest slides on for ever where gravity beats kinetic friction, and there alone
    steep = np.abs(np.tan(scene.trough_angle)) > scene.kinetic_friction
    rests = cycle.regime == Regime.NO_SLIP
    assert (cycle.coexists[rests] == steep[rests]).all()
    assert (cycle.coexists[answered & steep] == 1).all()
    assert (answered & steep & ~rests).sum() > 40


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


@pytest.mark.parametrize("way", [-1.0, 1.0])
def test_running_away_exists_from_the_angle_of_kinetic_friction_on(way: float) -> None:
    load = np.array([0.1, 0.9])[:, None]  # at rest, and sliding
    # tan(45 deg) is 1 to rounding, and so are sin / cos of the angle in radians
    below, at, above = (way * 45.0 * (1.0 + h) for h in (-1e-14, 0.0, 1e-14))
    cycle = vibro.solve(at_load(load, 20.0, 2.0, 1.0, [below, at, above]))
    assert np.isin(cycle.status, (Status.OK, Status.BOUNDARY)).all()
    assert cycle.coexists.tolist() == [[0, 0, 1]] * 2
