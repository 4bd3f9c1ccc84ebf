"""The rows of the reference table of drives with two harmonics."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from helpers.harmonics import solved

from vibro.core.codes import Model, Regime, Status, pattern_texts
from vibro.core.harmonic.arrays import largest_amplitude
from vibro.core.harmonic.loads import harmonic_loads

if TYPE_CHECKING:
    from numpy.typing import NDArray

TABLE = Path(__file__).parents[2] / "data" / "two_axis" / "harmonic_contact.csv"
EPS = 2.0**-52


@pytest.fixture(scope="module")
def rows() -> list[dict[str, str]]:
    with TABLE.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def column(rows: list[dict[str, str]], name: str) -> NDArray[np.float64]:
    return np.array([float(row[name] or "nan") for row in rows])


def test_rows_have_their_patterns_and_numbers(rows: list[dict[str, str]]) -> None:
    def pair(axis: str, what: str) -> tuple[NDArray[np.float64], ...]:
        return tuple(column(rows, f"{axis}{n}_{what}") for n in (1, 2))

    along, across = (pair(axis, "amplitude_m") for axis in "xy")
    phases = [pair(axis, "phase_rad") for axis in "xy"]
    frequency = column(rows, "frequency_hz")
    friction = column(rows, "static_friction"), column(rows, "kinetic_friction")
    loads = harmonic_loads(
        along,
        phases[0],
        across,
        phases[1],
        frequency,
        *friction,
        column(rows, "trough_angle_rad"),
        np.array(9.81),
    )
    out = solved(loads, len(rows))
    scale = largest_amplitude(*along, *across)
    texts = pattern_texts(out.pattern).tolist()
    runs = np.array([row["regime"].startswith("runaway") for row in rows])
    assert len(rows) == 60
    assert runs.sum() == 1
    assert [text for text, run in zip(texts, runs, strict=True) if not run] == [
        row["pattern"] for row, run in zip(rows, runs, strict=True) if not run
    ]
    assert set(out.status[~runs]) == {Status.OK}
    assert set(out.status[runs]) == {Status.RUNAWAY}
    assert [Regime(code).label for code in out.regime[~runs]] == [
        row["regime"] for row in rows if not row["regime"].startswith("runaway")
    ]
    assert set(out.model[~runs]) == {Model.REST, Model.SLIDES}
    assert not out.coexists[~runs].any()

    wanted = column(rows, "displacement_per_cycle_m")
    condition = column(rows, "condition")
    both_ways = np.array(["F" in text and "B" in text for text in texts])
    allowed = EPS * (condition * np.abs(wanted) + np.where(both_ways, scale, np.abs(wanted)))
    moves = ~runs & (wanted != 0.0)
    assert np.max(np.abs(out.displacement * scale - wanted)[moves] / allowed[moves]) < 8.0
    assert not out.displacement[~runs & ~moves].any()
    peak = (out.peak * scale * 2.0 * np.pi * frequency)[moves] / column(rows, "peak_speed_m_s")[moves]
    assert np.max(np.abs(peak - 1.0) / (EPS * (1.0 + condition[moves]))) < 4.0
    for ratio, name in (
        (out.throw_number, "throw_number"),
        (out.forward_ratio, "forward_ratio"),
        (out.back_ratio, "back_ratio"),
    ):
        known = column(rows, name)[~runs]
        assert np.max(np.abs(ratio[~runs] - known) / np.maximum(known, 1.0)) < 8.0 * EPS
