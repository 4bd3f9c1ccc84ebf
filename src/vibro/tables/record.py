"""The record of a run: the request, the method, and the number of cells of each kind.

The JSON beside a table, the manifest of a folder of Parquet files and the metadata of pictures all have it.
"""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from vibro.version import __version__

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from vibro.sweeps.columns import Table
    from vibro.sweeps.grid import Grid


def sweep_record(
    grid: Grid, table: Table, counts: Mapping[str, Any] | None = None, *, every_value: bool = False
) -> dict[str, Any]:
    """Describe a sweep: enough to run it again.

    Parameters
    ----------
    grid : Grid
        What is solved.
    table : Table
        What is written.
    counts : mapping, optional
        Counts of the cells, from ``Tally.record``.
    every_value : bool
        Whether every value of an axis is listed, not only those that do not follow from its ends.
    """
    return {
        **grid.describe(every_value=every_value),
        **({"part": dict(table.part)} if table.part else {}),
        "accuracy": grid.output.value,
        "flight": grid.flight,
        **({} if grid.starts is None else {"starts": grid.starts}),
        "cells": grid.size,
        **(counts or {}),
        "columns": {column.name: column.unit for column in table.columns},
    }


def run_record(argv: Sequence[str], content: Mapping[str, Any]) -> dict[str, Any]:
    """Add to a description which version made it, from which arguments of the command."""
    return {"version": __version__, "argv": ["vibro", *argv], **content}


def json_text(content: Mapping[str, Any]) -> str:
    """Write JSON for people; numbers that JSON does not know are refused."""
    return json.dumps(content, indent=2, allow_nan=False)


def picture_metadata(content: Mapping[str, Any]) -> dict[str, str]:
    """Return what a picture carries of a description."""
    return {"Software": f"vibro {__version__}", "Description": json.dumps(content, allow_nan=False)}
