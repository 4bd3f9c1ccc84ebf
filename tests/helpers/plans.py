"""Plans of small sweeps in parts."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal
from unittest import mock

import vibro
from vibro.files.part_sets import PartSet
from vibro.sweeps.columns import Table, chosen, columns_of
from vibro.sweeps.derived import throughput
from vibro.sweeps.executors import Threads, Workers
from vibro.sweeps.parted import Summary, agree, make_parts
from vibro.sweeps.plan import PART_CELLS, Plan, versions

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from vibro.sweeps.whole import Sweep

NUT: dict[str, Any] = {"drive_angle_deg": 20, "static_friction": 0.74, "kinetic_friction": 0.57}
"""The paper's angle and frictions."""


def swept(
    accuracy: Literal["exact", "regimes"] = "exact", *, flight: bool = True, coexistence: bool = False,
    **quantities: Any,
) -> Sweep:  # fmt: skip
    """Solve what is swept, in the paper's scene where nothing else is said."""
    usual: dict[str, Any] = {"amplitude_mm": 1, "frequency_hz": 15, **NUT}
    if {"along_amplitude_mm", "normal_amplitude_mm"} & quantities.keys():
        usual = {key: usual[key] for key in usual if key not in ("amplitude_mm", "drive_angle_deg")}
    if "friction_ratio" in quantities:
        del usual["kinetic_friction"]
    return vibro.sweep(accuracy=accuracy, flight=flight, coexistence=coexistence, **{**usual, **quantities})


def plan_of(
    solved: Sweep,
    part_cells: int = PART_CELLS,
    *,
    columns: Sequence[str] | None = None,
    digits: int | None = None,
    part: Mapping[str, float] | None = None,
) -> Plan:
    """Plan the same sweep in parts."""
    grid = solved._grid
    extra = throughput(part["pitch_mm"], part.get("mass_kg")) if part else ()
    usual = columns_of(grid.axes, *extra, drive=grid.drive, made_with=grid.made_with)
    table = Table(usual if columns is None else chosen(columns, usual), digits, part or {})
    return Plan(grid, table, part_cells, solved._title, solved._own, versions())


def written(folder: Path, plan: Plan, workers: Workers | None = None, patience: float = 20.0) -> Summary:
    """Write a plan's parts into a new folder, as the command does."""
    with PartSet(folder, "go on") as files:
        plan = agree(files, plan, resume=False, force=False, own_size=True)
        with workers or Threads(plan.parts) as who:
            summary = make_parts(plan, files, who, ["vibro"], resume=False, patience=patience)
        files.finish(summary.text())
    return summary


def store(
    solved: Sweep,
    folder: Path,
    *,
    columns: Sequence[str] | None = None,
    part_cells: int = 100,
    row_group_cells: int = 40,
) -> Path:
    """Store the cells of a sweep in short parts, each of several row groups."""
    with mock.patch("vibro.sweeps.parts.ROW_GROUP", row_group_cells):
        written(folder, plan_of(solved, part_cells, columns=columns))
    return folder
