"""Workbooks of sweeps, written and read back."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import openpyxl

import vibro
from vibro.output.record import sweep_record
from vibro.output.xlsx import Xlsx
from vibro.sweeps.columns import Table, arrow_table, columns_of
from vibro.sweeps.run import sweep_blocks
from vibro.sweeps.tally import Tally

if TYPE_CHECKING:
    from collections.abc import Sequence

    from vibro.sweeps.grid import Grid

NUT: dict[str, Any] = {
    "drive_angle_deg": 20,
    "static_friction": 0.74,
    "kinetic_friction": 0.57,
    "trough_length_mm": 600,
}


def grid_of(scene: str | Path | None = None, **quantities: Any) -> Grid:
    """Make the grid of a sweep, of a safety nut where nothing else is given."""
    return vibro.sweep(scene, **(quantities if scene else NUT | quantities))._grid


def write(
    file: BinaryIO,
    grid: Grid,
    *,
    digits: int | None = None,
    name: str = "nut",
    argv: Sequence[str] = ("vibro", "map"),
    sink: Xlsx | None = None,
) -> list[dict[str, Any]]:
    """Write a workbook, and return what its table must hold."""
    table = Table(columns_of(grid.axes, drive=grid.drive, made_with=grid.made_with), digits)
    rows: list[dict[str, Any]] = []
    tally, sink = Tally(), sink or Xlsx(name)
    sink.open(file, grid, table)
    for block in sweep_blocks(grid):
        tally.add(block)
        sink.write(block)
        rows += arrow_table(table.columns, block, table.digits).to_pylist()
    run = {"version": vibro.__version__, "argv": list(argv)}
    sink.close({**sweep_record(grid, table, tally.told()), **run})
    return rows


def written(path: Path, grid: Grid, **how: Any) -> tuple[Any, list[dict[str, Any]]]:
    """Write a workbook to a file; return it as openpyxl reads it, and what its table must hold."""
    with path.open("wb") as file:
        rows = write(file, grid, **how)
    return openpyxl.load_workbook(path), rows


def table_rows(sheet: Any) -> list[dict[str, Any]]:
    """Return the rows of a table by the names in its header, empty cells as None."""
    header, *rows = sheet.iter_rows(min_row=2, values_only=True)
    return [dict(zip(header, row, strict=True)) for row in rows]


def without_texts_that_are_empty(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    return [{name: None if value == "" else value for name, value in row.items()} for row in rows]
