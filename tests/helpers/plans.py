"""Small sweeps as files: plans of shards, folders that hold them, workbooks."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal
from unittest import mock

import openpyxl

import vibro
from vibro.plots.view import choose_view
from vibro.sweeps.columns import Table, table_columns
from vibro.sweeps.derived import throughput
from vibro.tables.plan import Plan
from vibro.tables.record import run_record, sweep_record
from vibro.tables.sinks import write_table
from vibro.tables.writing import write_folder
from vibro.tables.xlsx import Xlsx

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from pathlib import Path

    import pyarrow as pa

    from vibro.sweeps.whole import Sweep
    from vibro.tables.shards import Progress, Summary

NUT: dict[str, Any] = {"drive_angle_deg": 20, "static_friction": 0.74, "kinetic_friction": 0.57}
"""The paper's angle and frictions."""


def swept(
    output: Literal["exact", "regimes"] = "exact", *, flight: bool = True, starts: int | None = None,
    **quantities: Any,
) -> Sweep:  # fmt: skip
    """Solve what is swept, in the paper's scene where nothing else is said."""
    usual: dict[str, Any] = {"amplitude_mm": 1, "frequency_hz": 15, **NUT}
    if {"along_amplitude_mm", "normal_amplitude_mm"} & quantities.keys():
        usual = {key: usual[key] for key in usual if key not in ("amplitude_mm", "drive_angle_deg")}
    for name, other in (("friction_ratio", "kinetic_friction"), ("stroke_mm", "amplitude_mm")):
        if name in quantities:
            del usual[other]
    return vibro.sweep(output=output, flight=flight, starts=starts, **{**usual, **quantities})


def plan_of(
    solved: Sweep,
    shard_cells: int | None = None,
    *,
    columns: Sequence[str] | None = None,
    part: Mapping[str, float] | None = None,
    row_group_cells: int | None = None,
) -> Plan:
    """Plan the same sweep in shards, each of several row groups if their size is given."""
    grid = solved._grid
    part = part or {}
    table = Table(table_columns(grid, columns, throughput(part)), part)
    with mock.patch("vibro.tables.plan.BLOCK", row_group_cells or vibro.tables.plan.BLOCK):
        return Plan.of(grid, table, solved._title, solved._own, shard_cells)


def written(
    folder: Path,
    plan: Plan,
    workers: int | str | None = None,
    *,
    force: bool = False,
    report: Callable[[Progress], None] = lambda progress: None,
) -> Summary:
    """Write a plan's shards into a folder."""
    return write_folder(folder, plan, workers, ["test"], force=force, report=report)


def store(
    solved: Sweep,
    folder: Path,
    *,
    columns: Sequence[str] | None = None,
    shard_cells: int = 100,
    row_group_cells: int = 40,
) -> Path:
    """Store the cells of a sweep in short shards, each of several row groups."""
    written(folder, plan_of(solved, shard_cells, columns=columns, row_group_cells=row_group_cells))
    return folder


def workbook(path: Path, solved: Sweep, **shown: Any) -> tuple[Any, list[dict[str, Any]]]:
    """Write a workbook as the command does; return it as openpyxl reads it, and the cells of its table.

    What is shown are the arguments of ``choose_view``, the name, arguments of the command, and pictures.
    """
    grid, argv, name = solved._grid, shown.pop("argv", ["map"]), shown.pop("name", "nut")
    pictures = shown.pop("pictures", {})
    table = Table(table_columns(grid))
    view = choose_view(grid.given_axes, **shown) if grid.axes else None
    book, rows = Xlsx(path, path.parent, grid, table, view), Rows()
    tally = write_table(grid, table, [book.write, rows.write])
    book.close(run_record(argv, {"name": name, **sweep_record(grid, table, tally.record())}), pictures)
    return openpyxl.load_workbook(path), rows.cells


class Rows:
    """Keeps cells by their columns."""

    def __init__(self) -> None:
        self.cells: list[dict[str, Any]] = []

    def write(self, cells: pa.Table) -> None:
        self.cells += cells.to_pylist()
