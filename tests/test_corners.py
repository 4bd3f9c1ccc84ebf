"""Corners of all that quantities may be: each has a value or a status, soon, and nobody is warned."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

import pytest
from extremes import KINDS, cells_of, corners_of
from stress import solve_corners

import vibro
from vibro.core.compiled import doors

if TYPE_CHECKING:
    from collections.abc import Callable

PATIENCE = 2.0  # [s] of the processor; most take a thousandth of it
# [s] Without kinetic friction each of a thousand steady cycles of 16 harmonics has many candidates, and a
# body that never rests may take two million slides to where it arrives. Interrupts are heard meanwhile.
SLOW = {"transitions": 30.0, "critical loads": 30.0, "arrival": 10.0}

pytestmark = pytest.mark.skipif(not doors().compiled, reason="plain Python takes minutes")

ANSWERS: dict[str, Callable[[vibro.Scene], Any]] = {
    "history": lambda scene: vibro.simulate(scene, cycles=3),
    "arrival": lambda scene: vibro.arrival_time(scene, 1e9),
    "transitions": vibro.transitions,
    "critical loads": vibro.critical_loads,
    "search": lambda scene: vibro.solve(scene, starts=16),
    "attractors": vibro.attractors,
}


@pytest.mark.parametrize("kind", KINDS)
def test_every_corner_has_a_value_or_a_status(kind: str) -> None:
    found = solve_corners(kind)
    assert found.scenes > 1000
    assert found.wrong == 0
    assert found.seconds < PATIENCE
    assert {"ok", "boundary", "runaway", "indeterminate", "flight-not-modelled"} <= {*found.statuses}
    assert found.statuses.get("unresolved", 0) <= 4  # hops of bodies whose friction is the least double


@pytest.mark.parametrize("kind", KINDS)
def test_motions_at_corners_are_followed_or_refused(kind: str) -> None:
    refused = 0
    for scene in corners_of(kind):
        for cell in cells_of(scene, 1, 1):
            for name, answer in ANSWERS.items():
                start = time.process_time()
                try:
                    answer(cell)
                except vibro.VibroError:
                    refused += 1
                assert time.process_time() - start < SLOW.get(name, PATIENCE), name
    assert refused
