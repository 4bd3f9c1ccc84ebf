"""A sweep from its grid to a table: block by block, in any form, with the count of its cells."""

from __future__ import annotations

from typing import TYPE_CHECKING, BinaryIO

from vibro.output.record import run_record, sweep_record
from vibro.sweeps.run import sweep_blocks
from vibro.sweeps.tally import Tally

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from vibro.output.sinks import Sink
    from vibro.results.sweep import Block
    from vibro.sweeps.columns import Table
    from vibro.sweeps.grid import Grid

__all__ = ["write_table"]


def write_table(
    grid: Grid,
    table: Table,
    sink: Sink,
    file: BinaryIO,
    argv: Sequence[str] = (),
    *,
    report: Callable[[int], None] = lambda done: None,
    look: Callable[[Block], None] = lambda block: None,
) -> Tally:
    """Solve a grid and write its table.

    Parameters
    ----------
    grid : Grid
        What to solve.
    table : Table
        What is written of it.
    sink : Sink
        The form of the table.
    file : binary file
        Where to.
    argv : sequence of str
        The arguments of the command, for forms that describe the run.
    report : callable, optional
        Called with the number of cells done so far.
    look : callable, optional
        Called with every block, in the order of its cells.
    """
    sink.open(file, grid, table)
    tally, done = Tally(), 0
    for block in sweep_blocks(grid):
        sink.write(block)
        tally.add(block)
        look(block)
        done += block.cycle.status.size
        report(done)
    sink.close(run_record(argv, sweep_record(grid, table, tally.told())))
    return tally
