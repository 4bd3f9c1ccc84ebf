"""Small sweeps in shards: their plans, and folders that are written as the command and the library do it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal
from unittest import mock

import vibro
from vibro.output.plan import Plan
from vibro.output.workers import Threads, Workers
from vibro.output.writing import Sharding
from vibro.sweeps.columns import Table, chosen, columns_of
from vibro.sweeps.derived import throughput

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from pathlib import Path

    from vibro.output.shards import Progress, Summary
    from vibro.sweeps.whole import Sweep

NUT: dict[str, Any] = {"drive_angle_deg": 20, "static_friction": 0.74, "kinetic_friction": 0.57}
"""The paper's angle and frictions."""


def swept(
    output: Literal["exact", "regimes"] = "exact", *, flight: bool = True, coexistence: bool = False,
    **quantities: Any,
) -> Sweep:  # fmt: skip
    """Solve what is swept, in the paper's scene where nothing else is said."""
    usual: dict[str, Any] = {"amplitude_mm": 1, "frequency_hz": 15, **NUT}
    if {"along_amplitude_mm", "normal_amplitude_mm"} & quantities.keys():
        usual = {key: usual[key] for key in usual if key not in ("amplitude_mm", "drive_angle_deg")}
    for name, other in (("friction_ratio", "kinetic_friction"), ("stroke_mm", "amplitude_mm")):
        if name in quantities:
            del usual[other]
    return vibro.sweep(output=output, flight=flight, coexistence=coexistence, **{**usual, **quantities})


def plan_of(
    solved: Sweep,
    shard_cells: int | None = None,
    *,
    columns: Sequence[str] | None = None,
    digits: int | None = None,
    part: Mapping[str, float] | None = None,
) -> Plan:
    """Plan the same sweep in shards."""
    grid = solved._grid
    extra = throughput(part["pitch_mm"], part.get("mass_kg")) if part else ()
    usual = columns_of(grid.axes, *extra, drive=grid.drive, made_with=grid.made_with)
    table = Table(usual if columns is None else chosen(columns, usual), digits, part or {})
    return Plan.of(grid, table, shard_cells, solved._title, solved._own)


def written(
    folder: Path,
    plan: Plan,
    workers: Workers | None = None,
    report: Callable[[Progress], None] = lambda progress: None,
    **how: Any,
) -> Summary:
    """Write a plan's shards into a folder; ``how`` is that of ``Sharding``."""
    sharding = Sharding(**how)
    with (
        mock.patch("vibro.output.writing.workers_of", lambda shards, *_: workers or Threads(shards)),
        sharding.folder(folder, "go on") as files,
    ):
        plan, wanted = sharding.agree(files, plan)
        summary, manifest = sharding.carry_out(plan, wanted, files, ["test"], report)
        if sharding.shards is None:
            summary.finish(files, manifest)
    return summary


def store(
    solved: Sweep,
    folder: Path,
    *,
    columns: Sequence[str] | None = None,
    shard_cells: int = 100,
    row_group_cells: int = 40,
) -> Path:
    """Store the cells of a sweep in short shards, each of several row groups."""
    with mock.patch("vibro.output.shards.ROW_GROUP", row_group_cells):
        written(folder, plan_of(solved, shard_cells, columns=columns))
    return folder
