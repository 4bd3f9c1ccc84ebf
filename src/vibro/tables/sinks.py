"""A sweep from its grid to tables, block by block into every form that is wanted, with counts."""

from __future__ import annotations

from typing import TYPE_CHECKING, BinaryIO, Protocol

from vibro.files.csv_tables import CsvFormat
from vibro.sweeps.columns import arrow_table
from vibro.sweeps.run import sweep_blocks
from vibro.sweeps.tally import Tally

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    import pyarrow as pa

    from vibro.results.sweep import Block
    from vibro.sweeps.columns import Table
    from vibro.sweeps.grid import Grid


class Sink(Protocol):
    """Where the cells of a sweep go as they are solved."""

    def write(self, cells: pa.Table) -> None:
        """Add cells, in the order of the grid."""


class Csv:
    """Cells as CSV.

    Parameters
    ----------
    file : binary file
        Where to.
    table : Table
        What is written.
    form : CsvFormat
        How.
    """

    def __init__(self, file: BinaryIO, table: Table, form: CsvFormat) -> None:
        self._file, self._form = file, form
        file.write(form.header(column.name for column in table.columns))

    def write(self, cells: pa.Table) -> None:
        """Write a row a cell."""
        self._file.write(self._form.rows(cells))


def write_table(
    grid: Grid,
    table: Table,
    sinks: Iterable[Sink],
    *,
    report: Callable[[int], None] = lambda done: None,
    look: Callable[[Block], None] = lambda block: None,
) -> Tally:
    """Solve a grid and write its cells.

    Parameters
    ----------
    grid : Grid
        What to solve.
    table : Table
        What is written of it.
    sinks : iterable of Sink
        Where to.
    report : callable, optional
        Called with the number of cells done so far.
    look : callable, optional
        Called with every block, in the order of its cells.

    Returns
    -------
    Tally
        Of all cells.
    """
    sinks, tally, done = list(sinks), Tally(), 0
    for block in sweep_blocks(grid):
        if sinks:
            cells = arrow_table(table.columns, block)
            for sink in sinks:
                sink.write(cells)
        tally.add(block)
        look(block)
        done += block.cycle.status.size
        report(done)
    return tally
