"""Sweeps that ``vibro map -o NAME.parquet`` writes into a folder, and the messages of such a run."""

from __future__ import annotations

import math
import shutil
from contextlib import contextmanager
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

    from vibro.cli.console import Console
    from vibro.cli.outputs import Outputs
    from vibro.cli.sweeps import Pictures
    from vibro.sweeps.tally import Tally
    from vibro.tables.plan import Plan
    from vibro.tables.shards import Progress

_TENTHS: Final = 10  # lines of progress where nobody watches


def write_stored(plan: Plan, outputs: Outputs, workers: int | str | None, pictures: Pictures | None) -> Tally:
    """Solve a sweep into a folder, and write its pictures and its record beside, if they are wanted.

    Parameters
    ----------
    plan : Plan
        What is solved, and written of it.
    outputs : Outputs
        Where to.
    workers : int, str or None
        As of ``vibro.write_sweep``.
    pictures : Pictures or None
        What to draw.

    Returns
    -------
    Tally
        Of its cells.

    Raises
    ------
    InputError, FileError
        If the files cannot be written, or the folder holds something else.
    """
    from vibro.cli.sweeps import byte_count, drawn
    from vibro.tables.record import sweep_record
    from vibro.tables.writing import write_folder

    options, console, folder = outputs.options, outputs.options.console, outputs.folder
    assert folder is not None
    argv = ["vibro", *options.argv]
    with outputs:
        with _progress(console, folder, plan) as report:
            summary = write_folder(folder, plan, workers, argv, force=options.force, report=report)
        content = {**sweep_record(plan.grid, plan.table, summary.tally.record()), "digest": summary.digest}
        with drawn(pictures, console, summary.tally) as figures:
            outputs.finish(content, figures)
    shards = f"{plan.shards} shard{'' if plan.shards == 1 else 's'}"
    size = f"{byte_count(summary.size)}, {summary.size / plan.grid.size:.1f} bytes a cell"
    is_new = any(made.is_new for made in summary.made.values())
    outcome = "wrote" if is_new else "complete already:"
    console.echo(f"{outcome} {folder}: {shards}, {size}; digest {summary.digest}")
    outputs.print_record(folder=str(folder), shards=plan.shards, bytes=summary.size)
    return summary.tally


@contextmanager
def _progress(console: Console, folder: Path, plan: Plan) -> Iterator[Callable[[Progress], None]]:
    """Print the progress of a run: a bar on a terminal, else a line for every tenth."""
    from vibro.cli.sweeps import byte_count, count

    last = seen = 0  # tenths that were printed, and shards when their size was looked at
    cells = plan.grid.size

    with console.progress("solving", cells) as bar:

        def report(progress: Progress) -> None:
            nonlocal last, seen
            if progress.shards and not seen:  # once, when it is known how large a shard is
                seen = progress.shards
                needed = progress.size * (plan.shards / progress.shards - 1.0)
                free = shutil.disk_usage(folder).free
                if needed > free:
                    console.warn(
                        f"about {byte_count(needed)} more are needed, and {byte_count(free)} are free"
                    )
            speed = progress.solved / progress.seconds if progress.seconds else 0.0
            note = f"{progress.shards} of {plan.shards} shards" + (f", {speed:.3g} cells/s" if speed else "")
            bar(progress.cells, note)
            tenths = _TENTHS * progress.cells // cells
            if last < tenths < _TENTHS and not console.is_terminal:
                last = tenths
                left = (cells - progress.cells) / speed if speed else math.inf
                time_left = f", about {left:.0f} s left" if math.isfinite(left) else ""
                console.echo(f"{100 * tenths // _TENTHS} % of {count(cells)} cells: {note}{time_left}")

        yield report
