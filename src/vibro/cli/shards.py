"""Tables in shards: the options of ``vibro map --table parquet``, and the messages of such a run."""

from __future__ import annotations

import contextlib
import math
import shutil
from enum import StrEnum
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from vibro.errors import InputError
from vibro.output.sinks import FORMS

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence
    from pathlib import Path

    from vibro.cli.answer import Pictures
    from vibro.cli.console import Console
    from vibro.cli.options import Options
    from vibro.output.plan import Plan
    from vibro.output.shard_folder import ShardFolder
    from vibro.output.shards import Progress, Summary
    from vibro.output.writing import Sharding
    from vibro.sweeps.tally import Tally

__all__ = [
    "CSV",
    "Form",
    "ResumeOption",
    "SchedulerOption",
    "ShardCellsOption",
    "ShardsOption",
    "TableOption",
    "WorkersOption",
    "sharding_of",
    "write_sharded",
]

#: What a table is written as.
Form = StrEnum("Form", {name.upper(): name for name in FORMS})  # type: ignore[misc] # not spelt
CSV: Final = Form("csv")
PARQUET: Final = Form("parquet")

TableOption = Annotated[
    Form,
    typer.Option(
        "--table",
        help="One CSV, one Excel workbook with maps (xlsx), or a folder of Parquet files, named by -o, for"
        " more cells than a spreadsheet holds.",
    ),
]
ShardCellsOption = Annotated[
    str | None,
    typer.Option(
        "--shard-cells",
        metavar="NUMBER",
        help="Cells of each Parquet file, a shard. [default: 1e6; 20000 where bodies bounce]",
        show_default=False,
    ),
]
ShardsOption = Annotated[
    str | None,
    typer.Option(
        "--shards",
        metavar="FIRST:STOP",
        help="With --table parquet: make only these shards, such as 0:40, while other jobs make others; a"
        " last run with --resume instead finishes the folder.",
        show_default=False,
    ),
]
WorkersOption = Annotated[
    str | None,
    typer.Option(
        "--workers",
        metavar="NUMBER",
        help="With --table parquet: number of processes; by default threads of one process.",
        show_default=False,
    ),
]
SchedulerOption = Annotated[
    str | None,
    typer.Option(
        "--scheduler",
        metavar="ADDRESS",
        help="With --table parquet: address of a Dask cluster, such as tcp://host:8786; its workers need the"
        " same version of vibro and the same folder.",
        show_default=False,
    ),
]
ResumeOption = Annotated[
    bool, typer.Option("--resume", help="With --table parquet: continue an interrupted run in its folder.")
]

_MANY_FILES: Final = 10_000
_TENTHS: Final = 10  # lines of progress where nobody watches


def sharding_of(
    form: Form,
    options: Options,
    *,
    shard_cells: str | None,
    shards: str | None,
    workers: str | None,
    scheduler: str | None,
    resume: bool,
) -> Sharding | None:
    """Check the options about tables in shards; return None if the table is one file.

    Raises
    ------
    InputError
        If options exclude each other, or a number is none.
    """
    from vibro.cli.request import whole_number

    if form != CSV:
        for option, is_given in (("--excel", options.excel), ("--decimal-comma", options.decimal_comma)):
            if is_given:
                raise InputError(f"{option} is about CSV", hint=f"leave out {option}, or --table {form}")
    if form != CSV and options.output == "-":
        raise InputError(f"--table {form}: it is no text for stdout", hint="give a name, such as -o out/nut")
    if form != PARQUET:
        given = {
            "--shard-cells": shard_cells, "--shards": shards, "--workers": workers, "--scheduler": scheduler,
            "--resume": resume,
        }  # fmt: skip
        for option, value in given.items():
            if value not in (None, False):
                raise InputError(f"{option}: a table as {form} is one file", hint="add --table parquet")
        return None
    from vibro.output.writing import Sharding

    return Sharding(
        shard_cells=None if shard_cells is None else whole_number("--shard-cells", shard_cells),
        shards=shards,
        workers=None if workers is None else whole_number("--workers", workers),
        scheduler=scheduler,
        resume=resume,
        force=options.force,
    )


def write_sharded(
    plan: Plan,
    how: Sharding,
    options: Options,
    argv: Sequence[str],
    console: Console,
    name: str,
    pictures: Pictures | None = None,
) -> tuple[int, Tally]:
    """Solve a sweep and write its table in shards, and its pictures.

    Parameters
    ----------
    plan : Plan
        What is solved and written.
    how : Sharding
        How.
    options, argv, console, name, pictures
        As for ``write_sweep``; ``-o`` names the folder.

    Returns
    -------
    tuple of int and Tally
        The exit code, and what was counted.

    Raises
    ------
    InputError, FileError, VibroError
        If the files cannot be written, or the folder holds something else.
    """
    from vibro.cli.answer import conclude, count
    from vibro.output.record import json_text, sweep_record
    from vibro.output.writing import shard_folder

    folder = shard_folder(name if options.output is None else options.output)
    with how.folder(folder, "the same command with --resume goes on") as files:
        plan, shards = how.agree(files, plan)
        if plan.shards > _MANY_FILES:
            console.warn(f"{count(plan.shards)} files are many for a folder: --shard-cells makes fewer")
        if how.resume:
            there = len(files.shards())
            console.echo(f"{_shards(there)} there, checked first" if there else "nothing is there yet")
        first, last = (plan.range_of(shard) for shard in (shards[0], shards[-1]))
        with _progress(console, folder, last[1] - first[0]) as report:
            summary, manifest = how.carry_out(plan, shards, files, ["vibro", *argv], report, console.echo)
        content = {**sweep_record(plan.grid, plan.table, summary.tally.told()), "digest": summary.digest}
        written = []
        if how.shards is None:
            written = _draw(files, pictures, content, console)
            summary.finish(files, manifest)
    _tell(console, folder, summary, plan, written, is_range=how.shards is not None)
    if options.json:
        made = {"folder": str(folder), "shards": len(summary.sizes), "bytes": summary.size}
        print(json_text({**made, **content, "cells": summary.tally.status.total()}))
    return conclude(summary.tally, plan.grid, console), summary.tally


def _draw(
    files: ShardFolder, pictures: Pictures | None, content: Mapping[str, Any], console: Console
) -> list[str]:
    """Draw pictures into the folder, under names that readers of Parquet skip; return the names."""
    if pictures is None:
        return []
    from vibro.cli.answer import drawn
    from vibro.output.record import picture_metadata
    from vibro.plots import save

    with drawn(pictures, console) as figures:
        for file, (name, form) in pictures.files.items():
            with files.new(file) as path:
                save(figures[name], path, form, picture_metadata(content))
    return list(pictures.files)


@contextlib.contextmanager
def _progress(console: Console, folder: Path, cells: int) -> Iterator[Callable[[Progress], None]]:
    """Print the progress of a run: a bar on a terminal, else a line for every tenth."""
    from vibro.cli.answer import byte_count, count

    said = seen = 0
    warned = False

    def look_at_disk(progress: Progress) -> None:
        nonlocal seen, warned
        if progress.shards > seen and not warned:
            seen = progress.shards
            needed = progress.size * (progress.all_shards / progress.shards - 1.0)
            free = shutil.disk_usage(folder).free
            if needed > free:
                warned = True
                console.warn(f"about {byte_count(needed)} more are needed, and {byte_count(free)} are free")

    with console.progress("solving", cells) as bar:

        def report(progress: Progress) -> None:
            nonlocal said
            look_at_disk(progress)
            speed = progress.solved / progress.seconds if progress.seconds else 0.0
            rate = f", {speed:.3g} cells/s" if speed else ""
            note = f"{progress.shards} of {progress.all_shards} shards{rate}"
            bar(progress.cells, note)
            tenths = _TENTHS * progress.cells // progress.all_cells
            if said < tenths < _TENTHS and not console.is_terminal:
                said = tenths
                left = (progress.all_cells - progress.cells) / speed if speed else math.inf
                time_left = f", about {left:.0f} s left" if math.isfinite(left) else ""
                console.echo(
                    f"{100 * tenths // _TENTHS} % of {count(progress.all_cells)} cells: {note}{time_left}"
                )

        yield report


def _tell(
    console: Console, folder: Path, summary: Summary, plan: Plan, written: Sequence[str], *, is_range: bool
) -> None:
    """Tell what was written."""
    from vibro.cli.answer import byte_count
    from vibro.output.shard_folder import MANIFEST, SUCCESS

    number, cells = len(summary.sizes), summary.tally.status.total()
    each = f"{byte_count(summary.size)}, {summary.size / cells:.1f} bytes a cell"
    shards = f"{number} of {plan.shards} shards" if is_range else _shards(number)
    console.echo(f"wrote {folder}: {shards}, {each}; digest {summary.digest}")
    if not is_range:
        console.echo_all(f"wrote {folder / name}" for name in (*written, MANIFEST, SUCCESS))
    elif (folder / SUCCESS).exists():
        console.echo("the folder is finished: all of its shards are there")
    else:
        console.echo("--resume in place of --shards finishes the folder, once all ranges are made")


def _shards(number: int) -> str:
    return f"{number} shard{'' if number == 1 else 's'}"
