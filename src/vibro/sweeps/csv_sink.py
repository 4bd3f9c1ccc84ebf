"""A sweep to CSV: rows block by block, and the count of cells by status and regime."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from vibro.sweeps.run import sweep_blocks
from vibro.sweeps.tally import Tally

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from typing import TextIO

    from vibro.files.tables import CsvFormat
    from vibro.results.sweep import Block, Column
    from vibro.sweeps.columns import Table
    from vibro.sweeps.grid import Grid

__all__ = ["provenance", "write_rows"]


def write_rows(
    grid: Grid,
    columns: Sequence[Column],
    form: CsvFormat,
    stream: TextIO,
    report: Callable[[int], None] = lambda done: None,
    look: Callable[[Block], None] | None = None,
) -> Tally:
    """Solve a grid and write its table, header first.

    Parameters
    ----------
    grid : Grid
        What to solve.
    columns : sequence of Column
        What the table holds.
    form : CsvFormat
        How it is written.
    stream : text stream
        Receives the text; it must not translate line ends.
    report : callable, optional
        Called with the number of cells done so far.
    look : callable, optional
        Called with every block, in the order of its cells.
    """
    tally = Tally()
    stream.write(form.header(columns))
    done = 0
    for block in sweep_blocks(grid):
        stream.write(form.rows(columns, block))
        tally.add(block)
        if look is not None:
            look(block)
        done += block.cycle.status.size
        report(done)
    return tally


def provenance(grid: Grid, table: Table, tally: Tally) -> dict[str, Any]:
    """Return the sidecar's description of a table: enough to run the sweep again."""
    return {
        **grid.describe(),
        **({"part": dict(table.part)} if table.part else {}),
        "accuracy": grid.level.value,
        "flight": grid.flight,
        "coexistence": grid.coexistence,
        "cells": grid.size,
        **tally.told(),
        "columns": {column.name: column.unit for column in table.columns},
        "digits": table.digits,
    }
