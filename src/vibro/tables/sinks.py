"""A sweep from its grid to tables, block by block into every form that is wanted, with counts."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, BinaryIO

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

    Sink = Callable[[pa.Table], Any]


def csv_sink(file: BinaryIO, table: Table, form: CsvFormat) -> Sink:
    """Begin a table as CSV; what is returned adds cells, a row each."""
    file.write(form.header(column.name for column in table.columns))
    return lambda cells: file.write(form.rows(cells))


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
    sinks : iterable of callable
        What takes the cells, in the order of the grid, as they are solved.
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
                sink(cells)
        tally.add(block)
        look(block)
        done += block.cycle.status.size
        report(done)
    return tally
