"""Contact, hops and the search in turn, as plain Python, and that every loop ends."""

from __future__ import annotations

import ast
import math
from array import array
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from helpers.scenes import at_load
from helpers.solver_doors import plain

import vibro
import vibro.core
from vibro import Regime, Status
from vibro.core.cells import largest
from vibro.core.compiled import Doors
from vibro.core.contact import Steady
from vibro.core.drive import wave_loads
from vibro.core.numbers import HARMONICS, MIXES, ROOM
from vibro.core.slides import thresholds
from vibro.core.wave_cycle import wave_classes, wave_cycle
from vibro.core.waves import Mix, Waves, prepare_cells, read_harmonic, tabulate, with_bounds

if TYPE_CHECKING:
    from collections.abc import Iterator


LOADS = [0.3, 0.9, 1.1, 1.36, 2.0, 2.9, 3.0, 3.6, 5.0, 9.0]
LINES = at_load(LOADS, 20.0, 0.74, 0.57)


@pytest.fixture(autouse=True)
def solver() -> Iterator[Doors]:
    with plain() as doors:
        yield doors


def test_solving_is_contact_then_hops_then_a_search() -> None:
    told: list[tuple[int, int]] = []
    cycle = vibro.solve(LINES, starts=16, progress=lambda done, size: told.append((done, size)))
    contact = vibro.solve(LINES, flight=False)
    hops = contact.status == Status.FLIGHT_NOT_MODELLED
    assert hops.tolist() == [load > 2.924 for load in LOADS]
    for name, ours in cycle.arrays().items():
        if name in ("share", "mean_velocity_over_starts"):
            continue
        np.testing.assert_array_equal(ours[~hops], getattr(contact, name)[~hops])
    assert (cycle.regime[hops] == Regime.HOPPING).all()
    assert np.isin(cycle.status[hops], (Status.OK, Status.AVERAGED)).all()
    assert np.isfinite(cycle.mean_velocity[hops]).all()
    assert np.isnan(contact.mean_velocity[hops]).all()
    assert (cycle.coexists[hops] >= 0).all()
    np.testing.assert_array_equal(cycle.share[~hops], 1.0)
    np.testing.assert_array_equal(cycle.mean_velocity_over_starts[~hops], contact.mean_velocity[~hops])
    assert np.isnan(contact.share).all()
    assert (cycle.share[hops] <= 1.0).all()
    assert told == [(10, 10), (4, 4)]
    np.testing.assert_array_equal(cycle.flight_fraction[~hops], 0.0)
    np.testing.assert_array_equal(cycle.impact_velocity[~hops], 0.0)
    np.testing.assert_array_equal(cycle.mean_velocity_error[~hops], 0.0)
    classes = vibro.solve(LINES, output="regimes")
    np.testing.assert_array_equal(classes.regime, cycle.regime)
    assert (classes.status[hops] == Status.FLIGHT_NOT_MODELLED).all()
    assert np.isnan(classes.mean_velocity[1:]).all()


# ------------------------------------------------------------------------------
# Every loop of the solver ends: it runs over a range that is known before, or over what is at hand.


def test_the_solver_has_no_loop_without_a_bound() -> None:
    """``while`` may go on for ever: use ``for`` over a range, and say what follows at its end."""
    files = sorted(Path(vibro.core.__path__[0]).glob("*.py"))
    assert len(files) > 20
    for path in files:
        tree = ast.parse(path.read_text("utf-8"))
        assert [node.lineno for node in ast.walk(tree) if isinstance(node, ast.While)] == [], path


def two_harmonics(size: float) -> Waves:
    number, mark = array("d", bytes(8 * (ROOM * 4 + 32))), array("q", bytes(8 * 2 * MIXES))
    waves = Waves(HARMONICS, 2, memoryview(number), memoryview(mark), 0.0, 0.0, 0.0)
    prepare_cells(2, waves.number)
    for normal in (False, True):
        for order, share in ((1, size), (2, 0.3 * size)):
            read_harmonic(waves, normal, order, share, 0.4 * order)
    tabulate(waves)
    return with_bounds(waves)


def test_a_load_whose_square_is_no_double_has_no_bound() -> None:
    assert largest(two_harmonics(1.0), Mix(0.0, 1.0, 1e150)) < math.inf
    assert largest(two_harmonics(1.0), Mix(0.0, 1.0, 1e155)) == math.inf


def test_a_cycle_under_loads_without_a_bound_is_unresolved() -> None:
    loads = wave_loads(two_harmonics(1.0), 1.0, 2.0, 0.0, 1e155, 0.5)
    at = thresholds(loads)
    cycle = wave_cycle(loads, at, False)
    assert isinstance(cycle, Steady)
    assert (cycle.regime, cycle.status) == (Regime.UNDEFINED, Status.UNRESOLVED)
    assert wave_classes(loads, at).pattern == 0
