"""Every loop of the solver ends: it runs over a range that is known before, or over what is at hand."""

from __future__ import annotations

import ast
import math
from array import array
from pathlib import Path

import pytest

import vibro.core
from vibro.core.cells import largest
from vibro.core.codes import Regime, Status
from vibro.core.contact import Steady
from vibro.core.drive import wave_loads
from vibro.core.numbers import HARMONICS, MIXES, ROOM
from vibro.core.slides import thresholds
from vibro.core.wave_cycle import wave_classes, wave_cycle
from vibro.core.waves import Mix, Waves, prepare_cells, read_harmonic, tabulate, with_bounds

FILES = sorted(Path(vibro.core.__path__[0]).glob("*.py"))


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_the_solver_has_no_loop_without_a_bound(path: Path) -> None:
    """``while`` may go on for ever: use ``for`` over a range, and say what follows at its end."""
    tree = ast.parse(path.read_text("utf-8"))
    assert [node.lineno for node in ast.walk(tree) if isinstance(node, ast.While)] == []


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
