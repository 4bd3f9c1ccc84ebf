"""docs/theory/validation.md: a part on a vibrating finger, as a laboratory measured it."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from helpers.cases import each
from validation import (
    GRAVITY,
    MM,
    STATIC_FRICTION,
    Trial,
    computed_advances,
    fine,
    read_table,
    walk,
    walked_advances,
)

PAGE = (Path(__file__).parents[1] / "docs" / "theory" / "validation.md").read_text(encoding="utf-8")
ROWS = {int(row[1]): row[0] for row in re.finditer(r"^\| (\d+) \|.*\|$", PAGE, flags=re.MULTILINE)}
TRIALS = read_table()


def row(trial: Trial) -> str:
    velocity, holds = fine(trial.finger), STATIC_FRICTION * trial.force
    acceleration = np.diff(velocity) / trial.period * (velocity.size - 1) / GRAVITY
    less, computed, more = computed_advances(trial) / MM
    error = f" ± {trial.error / MM:.3f}" if trial.cycles > 1 else ""
    cells = (
        trial.number,
        f"{1.0 / trial.period:.1f}",
        f"{trial.force:.1f}",
        trial.cycles,
        f"{acceleration.min():.1f} to {acceleration.max():.1f}",
        f"{-holds - 1.0:.1f}, {holds - 1.0:.1f}",
        f"{trial.advance / MM:.3f}{error}",
        *(f"{advance:.3f}" for advance in (computed, less, more)),
    )
    return "| " + " | ".join(map(str, cells)) + " |"


def test_all_ten_trials_are_told() -> None:
    assert sorted(ROWS) == [trial.number for trial in TRIALS] == list(range(1, 11))


@each("trial", TRIALS)
def test_every_row_is_what_the_benchmark_computes(trial: Trial) -> None:
    assert ROWS[trial.number] == row(trial)


@each("trial", TRIALS)
def test_the_solver_agrees_with_a_walk_that_shares_nothing_with_it(trial: Trial) -> None:
    assert computed_advances(trial) == pytest.approx(walked_advances(trial), rel=0.0, abs=1e-12)


def test_what_the_page_says_of_all_ten() -> None:
    found = np.array([computed_advances(trial) for trial in TRIALS])
    measured = np.array([trial.advance for trial in TRIALS])
    share = found[:, 1] / measured
    assert np.flatnonzero(share < 0.0).tolist() == [2]
    assert np.sum(share < 1.0) == 9
    assert f"The median miss of all ten is {100.0 * np.median(np.abs(share - 1.0)):.0f} %" in PAGE
    assert f"the mean miss {np.mean(np.abs(found[:, 1] - measured)) / MM:.2f} mm a cycle" in PAGE
    within = (found.min(axis=1) <= measured) & (measured <= found.max(axis=1))
    assert [trial.number for trial, near in zip(TRIALS, within, strict=True) if near] == [4, 5, 6, 7, 8]


@pytest.mark.parametrize(
    ("static", "kinetic", "place"),
    [
        (GRAVITY * (1.0 + 1e-12), 4.0, 0.0),
        (GRAVITY, 4.0, 0.0),
        (GRAVITY * (1.0 - 1e-12), 4.0, -0.5 * (GRAVITY - 4.0) * 0.3**2),
    ],
    ids=["held", "just held", "falls"],
)
def test_a_part_on_a_finger_at_rest(static: float, kinetic: float, place: float) -> None:
    assert walk(np.zeros(4), 0.1, static, kinetic)[-1] == pytest.approx(place, rel=1e-13, abs=0.0)


def test_a_pushed_part_stops_within_a_step_and_stays() -> None:
    places = walk(np.zeros(3), 0.1, 12.0, 11.0, start=1.0)
    assert places[1:] == pytest.approx([0.5 / (GRAVITY + 11.0)] * 2, rel=1e-13)
