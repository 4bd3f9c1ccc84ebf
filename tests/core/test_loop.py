"""The doors as plain Python: what goes where, in SI units, and which cells are left as they are."""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from helpers.scenes import at_load, loads_of
from helpers.solver_doors import plain

import vibro
from vibro import Regime, Scene, Status
from vibro.core import loop
from vibro.core.attractors import coexisting
from vibro.core.codes import IRREGULAR, SPELT_PATTERNS, Model
from vibro.core.compiled import Doors
from vibro.core.contact import (
    ratio_of,
    regime_alone,
    steady_cycle,
)
from vibro.core.flight import Flights
from vibro.core.hops import hopping
from vibro.core.return_map import Hops
from vibro.core.slides import thresholds
from vibro.results.steady import RESULTS
from vibro.threads import Grid, Scratch

if TYPE_CHECKING:
    from collections.abc import Iterator

LOADS = [0.3, 0.9, 1.1, 1.36, 2.0, 2.9, 3.0, 3.6, 5.0, 9.0]
LINES = at_load(LOADS, 20.0, 0.74, 0.57)
# bounces once a cycle for good: from wherever it starts, with the same impact
BOUNCING = dataclasses.replace(at_load([8.0], 20.0, 0.74, 0.57), restitution=np.full(1, 0.1))
INCLINES = Scene.allowing_infeasible(
    amplitude=[2e-3, 1e-3, 3e-3, 1e-3],
    frequency=[20.0, 30.0, 15.0, 15.0],
    drive_angle=[0.3, 0.2, 0.3, 0.3],
    static_friction=[0.5, 0.3, 0.5, 0.0],
    kinetic_friction=[0.4, 0.02, 0.6, 0.0],
    trough_angle=[-0.1, 0.2, 0.1, 0.1],
    gravity=9.81,
    restitution=0.0,
)
ELLIPSES = Scene(
    along_amplitude=[1e-3, 2e-4, 1e-3, 1.0, 0.0],
    normal_amplitude=[3e-4, 4e-4, 1.5e-3, 1e-9, 1e-4],
    normal_phase=[-1.0, 2.0, 0.5, 0.1, 0.0],
    frequency=25.0,
    static_friction=0.4,
    kinetic_friction=[0.3, 0.1, 0.3, 0.2, 0.3],
    trough_angle=[0.0, 0.05, -0.1, 0.0, 0.1],
    restitution=[0.0, 0.0, 0.3, 0.0, 0.0],
)
SCENES = pytest.mark.parametrize("scene", [LINES, INCLINES, ELLIPSES], ids=["lines", "inclines", "ellipses"])
TURN = 2.0 * math.pi


@pytest.fixture(autouse=True)
def solver() -> Iterator[Doors]:
    with plain() as doors:
        yield doors


class Answers:
    """Buffers of answers, filled with what no answer is."""

    def __init__(self, size: int) -> None:
        self.columns: dict[str, Any] = {r.name: np.full(size, 77).astype(r.dtype) for r in RESULTS}

    @property
    def buffers(self) -> tuple[Any, ...]:
        return tuple(memoryview(x) for x in self.columns.values())

    def row(self, i: int) -> dict[str, Any]:
        return {name: x[i].item() for name, x in self.columns.items()}


def solved(
    solver: Doors, scene: Scene, begin: int, end: int, *, classes: bool = False
) -> tuple[Answers, int]:
    grid = Grid(scene.arrays())
    answers = Answers(grid.size)
    count = solver.solve_contact(grid.scenes, grid.place(), answers.buffers, begin, end, classes)
    return answers, count


@SCENES
@pytest.mark.parametrize("classes", [False, True])
def test_contact_cycles_in_si_units(solver: Doors, scene: Scene, classes: bool) -> None:
    loads = loads_of(scene)
    answers, count = solved(solver, scene, 0, len(loads), classes=classes)
    scales = np.broadcast_to(scene.scale, scene.shape).tolist()
    frequencies = np.broadcast_to(scene.frequency, scene.shape).tolist()
    hops = 0
    for i, one in enumerate(loads):
        at = thresholds(one)
        cycle = regime_alone(one, at) if classes else steady_cycle(one, at)
        hops += cycle.status == Status.FLIGHT_NOT_MODELLED
        d, f, a = scales[i] * cycle.displacement, frequencies[i], scales[i]
        missing = cycle.model == Model.NONE
        capacity = one.static_friction * one.weight_normal
        expected = {
            "regime": cycle.regime,
            "pattern_code": cycle.pattern,
            "mean_velocity": d * f,
            "displacement_per_cycle": d,
            "peak_velocity": cycle.peak * TURN * f * a,
            "throw_number": one.drive_normal / one.weight_normal,
            "forward_ratio": ratio_of(at.forward_load, capacity + one.weight_tangential),
            "back_ratio": ratio_of(at.back_load, capacity - one.weight_tangential),
            "flight_fraction": math.nan if missing else 77.0,  # zero at first
            "impact_velocity": math.nan if missing else 77.0,
            "period_cycles": math.nan if missing else 1.0,
            "mean_velocity_error": math.nan if missing else 77.0,
            "coexists": cycle.coexists,
            "model_code": cycle.model,
            "status": cycle.status,
            "largest_multiplier": cycle.multiplier,
        }
        if cycle.status == Status.INFEASIBLE:
            expected |= dict.fromkeys(("throw_number", "forward_ratio", "back_ratio"), math.nan)
        row = answers.row(i)
        assert row.keys() == expected.keys()
        assert row == pytest.approx(expected, rel=1e-15, nan_ok=True)
    assert count == hops


@SCENES
def test_a_range_leaves_other_cells_as_they_are(solver: Doors, scene: Scene) -> None:
    whole, _ = solved(solver, scene, 0, len(loads_of(scene)))
    for begin, end in ((0, 2), (1, 3), (2, 2)):
        part, _ = solved(solver, scene, begin, end)
        for i in range(len(loads_of(scene))):
            if begin <= i < end:
                assert part.row(i) == pytest.approx(whole.row(i), nan_ok=True, rel=0.0)
            else:
                assert set(part.row(i).values()) == {77}


def hopped(solver: Doors, scene: Scene, cells: list[int], begin: int, end: int) -> tuple[Answers, Any]:
    grid, scratch = Grid(scene.arrays()), Scratch()
    answers = Answers(grid.size)
    place, room = grid.place(), (scratch.flights, scratch.hops)
    solver.solve_hops(grid.scenes, place, answers.buffers, np.array(cells), *room, begin, end)
    return answers, (grid, place, room)


@pytest.mark.parametrize(("scene", "cells"), [(LINES, [9, 6, 7, 8]), (BOUNCING, [0]), (ELLIPSES, [2])])
def test_hops_in_si_units(solver: Doors, scene: Scene, cells: list[int]) -> None:
    answers, (grid, place, room) = hopped(solver, scene, cells, 0, len(cells))
    fields, loads = scene.flat(), loads_of(scene)
    scales = np.broadcast_to(scene.scale, scene.shape)
    flights, hops = Flights(*room[0]), Hops(*room[1])
    for i in range(grid.size):
        row = answers.row(i)
        if i not in cells:
            assert set(row.values()) == {77}
            continue
        found = hopping(loads[i], float(fields.restitution[i]), flights, hops)
        a, f = float(scales[i]), float(fields.frequency[i])
        pattern = found.pattern + SPELT_PATTERNS * (found.pattern > 0)
        assert row["mean_velocity"] == pytest.approx(a * found.displacement * f, rel=1e-15)
        assert row["displacement_per_cycle"] == a * found.displacement
        assert row["mean_velocity_error"] == pytest.approx(a * found.deviation * f, rel=1e-15)
        assert row["peak_velocity"] == pytest.approx(TURN * f * a * found.peak, rel=1e-15)
        assert row["impact_velocity"] == pytest.approx(TURN * f * a * found.impact, rel=1e-15)
        assert (row["flight_fraction"], row["period_cycles"]) == (found.flight_fraction, found.period)
        assert (row["status"], row["coexists"], row["pattern_code"]) == (
            found.status, found.coexists, pattern,
        )  # fmt: skip
        assert row["model_code"] == Model.FLIGHT
        assert {row[name] for name in ("regime", "throw_number", "forward_ratio", "back_ratio")} == {77}
    first, _ = hopped(solver, scene, cells, 0, 1)
    assert first.row(cells[0]) == pytest.approx(answers.row(cells[0]), rel=0.0, nan_ok=True)
    answers.columns["coexists"][:] = 5
    found = solver.find_others(grid.scenes, place, answers.buffers, np.array(cells), *room, 0, len(cells))
    assert found is None
    for i in range(grid.size):
        if i in cells:
            row, frequency = answers.row(i), float(fields.frequency[i])
            impact = row["impact_velocity"] / (TURN * frequency * float(scales[i]))
            e = float(fields.restitution[i])
            others = coexisting(loads[i], e, row["period_cycles"], impact, flights, hops)
            assert row["coexists"] == int(others)
        else:
            assert answers.columns["coexists"][i] == 5


def test_averaged_and_unmodelled_motions_keep_their_codes(solver: Doors) -> None:
    scene = Scene(
        amplitude=[5e-3, 1e4], frequency=25.0, drive_angle=0.5, static_friction=0.5, kinetic_friction=0.3,
        restitution=0.9,
    )  # fmt: skip
    answers, (_, _, room) = hopped(solver, scene, [0, 1], 0, 2)
    averaged, thrown = answers.row(0), answers.row(1)
    assert averaged["status"] == Status.AVERAGED
    assert averaged["pattern_code"] == IRREGULAR
    assert averaged["model_code"] == Model.FLIGHT
    deviation = hopping(loads_of(scene)[0], 0.9, Flights(*room[0]), Hops(*room[1])).deviation
    assert deviation > 0.0
    assert averaged["mean_velocity_error"] == pytest.approx(5e-3 * 25.0 * deviation, rel=1e-13)
    assert thrown["status"] == Status.FLIGHT_NOT_MODELLED
    assert (thrown["pattern_code"], thrown["model_code"]) == (0, Model.NONE)
    assert math.isnan(thrown["mean_velocity"])


def test_solving_is_contact_then_hops_then_a_search() -> None:
    told: list[tuple[int, int]] = []
    cycle = vibro.solve(LINES, coexistence=True, progress=lambda done, size: told.append((done, size)))
    contact = vibro.solve(LINES, flight=False)
    hops = contact.status == Status.FLIGHT_NOT_MODELLED
    assert hops.tolist() == [load > 2.924 for load in LOADS]
    for name, ours in cycle.arrays().items():
        np.testing.assert_array_equal(ours[~hops], getattr(contact, name)[~hops])
    assert (cycle.regime[hops] == Regime.HOPPING).all()
    assert np.isin(cycle.status[hops], (Status.OK, Status.AVERAGED)).all()
    assert np.isfinite(cycle.mean_velocity[hops]).all()
    assert np.isnan(contact.mean_velocity[hops]).all()
    assert (cycle.coexists[hops] >= 0).all()
    assert told == [(10, 10), (4, 4)]
    np.testing.assert_array_equal(cycle.flight_fraction[~hops], 0.0)
    np.testing.assert_array_equal(cycle.impact_velocity[~hops], 0.0)
    np.testing.assert_array_equal(cycle.mean_velocity_error[~hops], 0.0)
    classes = vibro.solve(LINES, output="regimes")
    np.testing.assert_array_equal(classes.regime, cycle.regime)
    assert (classes.status[hops] == Status.FLIGHT_NOT_MODELLED).all()
    assert np.isnan(classes.mean_velocity[1:]).all()


# ------------------------------------------------------------------------------- limits and slopes


def test_all_doors_are_functions() -> None:
    assert len(loop.DOORS) == len(set(loop.DOORS))
    assert all(callable(door) for door in loop.DOORS)
