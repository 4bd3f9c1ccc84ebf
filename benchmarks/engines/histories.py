"""Make the exact histories of the benchmark's scenes with vibro; the runner and the engines do without it.

Usage: python benchmarks/engines/histories.py [FOLDER]

Writes a CSV for each scene of data/scenes.csv, and the phases of all of them, into data or another folder.
"""

from __future__ import annotations

import csv
import math
import sys
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

import vibro

sys.path.insert(0, str(Path(__file__).parent))
from scenes import CYCLES, DATA, Scene, history_file, scenes

if TYPE_CHECKING:
    from collections.abc import Iterable

SAMPLES: Final = 20  # a drive cycle
KINDS: Final = {"F": "forward slide", "B": "back slide", "_": "rest", "H": "flight"}
HISTORY: Final = (
    "time_s", "trough_along_mm", "trough_normal_mm", "displacement_mm", "velocity_mm_s", "height_mm",
    "friction_m_s2", "normal_force_m_s2",
)  # fmt: skip
PHASES: Final = (
    "scene", "kind", "start_s", "end_s", "start_displacement_mm", "end_displacement_mm",
    "start_velocity_mm_s", "end_velocity_mm_s", "impact_speed_mm_s",
)  # fmt: skip


def of_vibro(scene: Scene) -> vibro.Scene:
    """Return a scene as vibro has it."""
    quantities = asdict(scene)
    friction = quantities.pop("friction")
    del quantities["name"]
    return vibro.Scene(static_friction=friction, kinetic_friction=friction, **quantities)


def _write(path: Path, header: Iterable[str], rows: Iterable[Iterable[object]]) -> None:
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        writer.writerows(rows)


def write(folder: Path) -> None:
    """Write the histories and the phases of all scenes."""
    phases = []
    for scene in scenes():
        found = vibro.simulate(of_vibro(scene), cycles=CYCLES)
        times = np.arange(CYCLES * SAMPLES + 1) / (SAMPLES * scene.frequency)
        at = found.sample(np.minimum(times, found.end))
        lengths = (at.trough_along, at.trough_normal, at.position, at.velocity, at.gap)
        columns = (at.time, *(1e3 * values for values in lengths), at.friction, at.normal)
        rows = np.column_stack(columns) + 0.0  # no negative zeros
        _write(folder / history_file(scene).name, HISTORY, rows.tolist())
        for phase in found.phases:
            moved = (phase.start_position, phase.end_position, phase.start_velocity, phase.end_velocity)
            numbers = [1e3 * value + 0.0 for value in (*moved, phase.impact_velocity)]
            assert all(map(math.isfinite, numbers))
            phases.append([scene.name, KINDS[phase.kind], phase.start, phase.end, *numbers])
    _write(folder / "phases.csv", PHASES, phases)


if __name__ == "__main__":
    write(Path(sys.argv[1]) if len(sys.argv) > 1 else DATA)
