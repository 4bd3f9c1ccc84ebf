"""The reference tables of elliptical drives: their rows, and these as the package solves them."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import vibro

DATA = Path(__file__).parents[1] / "data" / "two_axis"
ROWS = {"elliptic_contact": 150, "elliptic_hopping": 30}
# The impact speed of this row is that of a landing before the motion settled. Each flight takes one turn, and
# the impact what gravity gave in it: g cos(beta)/f.
UNSETTLED_IMPACT = 19


def read_rows(name: str) -> list[dict[str, str]]:
    with (DATA / f"{name}.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def _numbers(rows: list[dict[str, str]], column: str) -> np.ndarray:
    return np.array([float(row[column] or "nan") for row in rows])


class Table(NamedTuple):
    columns: dict[str, Any]
    scene: vibro.Scene
    cycle: vibro.SteadyCycle

    @property
    def size(self) -> np.ndarray:
        """Displacements, and the largest amplitude beside those of bodies that slide both ways [m]."""
        both = np.array([set(text) >= set("FB") for text in self.columns["pattern"]])
        amplitudes = np.maximum(self.columns["x_amplitude_m"], self.columns["y_amplitude_m"])
        return np.asarray(np.where(both, amplitudes, np.abs(self.columns["displacement_per_cycle_m"])))


def read_table(name: str) -> Table:
    rows = read_rows(name)
    assert len(rows) == ROWS[name]
    texts = ("kind", "regime", "pattern", "other_rest_start")
    columns: dict[str, Any] = {
        column: [row[column] for row in rows] if column in texts else _numbers(rows, column)
        for column in rows[0]
    }
    scene = vibro.Scene(
        along_amplitude=columns["x_amplitude_m"],
        normal_amplitude=columns["y_amplitude_m"],
        normal_phase=columns["phase_rad"],
        frequency=columns["frequency_hz"],
        static_friction=columns["static_friction"],
        kinetic_friction=columns["kinetic_friction"],
        trough_angle=columns["trough_angle_rad"],
    )
    return Table(columns, scene, vibro.solve(scene))
