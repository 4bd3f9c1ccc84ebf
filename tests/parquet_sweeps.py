"""Folders of Parquet parts, written as ``vibro map --table parquet`` does."""

from __future__ import annotations

from typing import TYPE_CHECKING
from unittest import mock

from vibro.files.part_sets import PartSet
from vibro.sweeps.columns import Table, chosen, columns_of
from vibro.sweeps.executors import Threads
from vibro.sweeps.parted import make_parts
from vibro.sweeps.plan import Plan, versions

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from vibro.sweeps.whole import Sweep


def store(
    t: Sweep,
    folder: Path,
    *,
    columns: Sequence[str] | None = None,
    part_cells: int = 100,
    row_group_cells: int = 40,
) -> Path:
    """Store the cells of a sweep in short parts, each of several row groups."""
    grid = t._grid
    usual = columns_of(grid.axes, drive=grid.drive)
    table = Table(usual if columns is None else chosen(columns, usual))
    plan = Plan(grid, table, part_cells, t._title, t._own, versions())
    with (
        mock.patch("vibro.sweeps.parts.ROW_GROUP", row_group_cells),
        PartSet(folder, "") as files,
        Threads(plan.parts) as workers,
    ):
        files.finish(make_parts(plan, files, workers, ["vibro", "map"], resume=False).text())
    return folder
