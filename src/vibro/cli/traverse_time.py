"""``vibro traverse-time``: how long a part takes over the trough's length."""

from __future__ import annotations

from typing import Annotated

from vibro.cli.options import Options, option, rare  # typer reads the annotations
from vibro.cli.table_options import ColumnsOption, table_of


def traverse_time_command(
    options: Options,
    sweep: Annotated[bool, rare("sweep", "Take the axes of the scene file's table [map].")] = False,
    exact: Annotated[
        bool, option("exact", "In a sweep, add the exact time from rest: 20 us to 1 ms a cell.")
    ] = False,
    columns: ColumnsOption = None,
) -> int:
    """Compute the time over the trough's length: at the mean speed, and exactly from rest.

    With axes, in the syntax of vibro map, or with --sweep it prints a table, or writes it with -o.
    """
    from vibro.answers.scene import traverse_answer
    from vibro.cli.answer import Run, answer_one, answer_sweep
    from vibro.cli.request import request_of
    from vibro.sweeps.derived import WITH_ARRIVAL, WITH_STROKES

    request = request_of(options, varies=sweep, reads_map=sweep, takes_axes=True, needs_length=True)
    name = f"{request.name}-traverse-time" if request.name else "vibro-traverse-time"
    follows = exact or not request.varying
    extra = (WITH_ARRIVAL, WITH_STROKES) if follows else (WITH_STROKES,)
    grid = request.grid(arrivals=follows)
    options.console.echo_all(map(str, grid.given_axes.values()))
    table = table_of(grid, columns, extra, needed={WITH_ARRIVAL.name: "--exact"})
    run = Run(request, grid, table, table.columns, columns is not None)
    if request.varying:
        return answer_sweep(run, options, name)
    return answer_one(run, options, name, traverse_answer)
