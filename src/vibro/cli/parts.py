"""Tables in parts: the options of ``vibro map --table parquet``, and how such a run is told about."""

from __future__ import annotations

import contextlib
import json
import math
import shutil
from enum import StrEnum
from itertools import product
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from vibro import __version__
from vibro.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence
    from pathlib import Path

    from vibro.cli.console import Console
    from vibro.cli.options import Options
    from vibro.cli.output import Pictures
    from vibro.files.part_sets import PartSet
    from vibro.sweeps.parted import Progress, Summary
    from vibro.sweeps.plan import Plan
    from vibro.sweeps.tally import Tally
    from vibro.sweeps.writing import Parting

__all__ = [
    "Form",
    "PartCellsOption",
    "ResumeOption",
    "SchedulerOption",
    "TableOption",
    "WorkersOption",
    "parting_of",
    "write_parted",
]


class Form(StrEnum):
    """What a table is written as."""

    CSV = "csv"
    PARQUET = "parquet"


TableOption = Annotated[
    Form,
    typer.Option(
        "--table",
        help="One CSV, or a folder of Parquet files, named by -o, for more cells than a spreadsheet holds.",
    ),
]
PartCellsOption = Annotated[
    str | None,
    typer.Option(
        "--part-cells",
        metavar="NUMBER",
        help="Cells of each Parquet file. [default: 1e6]",
        show_default=False,
    ),
]
WorkersOption = Annotated[
    str | None,
    typer.Option(
        "--workers",
        metavar="NUMBER",
        help="With --table parquet: processes that make the files; without, threads of this one.",
        show_default=False,
    ),
]
SchedulerOption = Annotated[
    str | None,
    typer.Option(
        "--scheduler",
        metavar="ADDRESS",
        help="With --table parquet: a Dask cluster that makes the files, such as tcp://host:8786; its workers"
        " need the same vibro and the same folder.",
        show_default=False,
    ),
]
ResumeOption = Annotated[
    bool, typer.Option("--resume", help="With --table parquet: go on in a folder where a run was cut short.")
]

_MANY_FILES: Final = 10_000
_TENTHS: Final = 10  # lines of progress where nobody watches


def parting_of(
    form: Form,
    options: Options,
    *,
    part_cells: str | None,
    workers: str | None,
    scheduler: str | None,
    resume: bool,
) -> Parting | None:
    """Check the options about tables in parts; return nothing where the table is one CSV.

    Raises
    ------
    InputError
        If options exclude each other, or a number is none.
    """
    from vibro.cli.request import whole_number

    given = {"--part-cells": part_cells, "--workers": workers, "--scheduler": scheduler, "--resume": resume}
    if form is Form.CSV:
        for option, value in given.items():
            if value not in (None, False):
                raise InputError(f"{option}: a CSV is one file", hint="add --table parquet")
        return None
    for option, is_given in (("--excel", options.excel), ("--decimal-comma", options.decimal_comma)):
        if is_given:
            raise InputError(f"{option} is about CSV", hint="leave it out, or --table parquet")
    from vibro.sweeps.writing import Parting

    return Parting(
        part_cells=None if part_cells is None else whole_number("--part-cells", part_cells),
        workers=None if workers is None else whole_number("--workers", workers),
        scheduler=scheduler,
        resume=resume,
        force=options.force,
    )


def write_parted(
    plan: Plan,
    parting: Parting,
    options: Options,
    argv: Sequence[str],
    console: Console,
    name: str,
    pictures: Pictures | None = None,
) -> tuple[int, Tally]:
    """Solve a sweep and write its table in parts, and its pictures.

    Parameters
    ----------
    plan : Plan
        What is solved and written.
    parting : Parting
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
    from vibro.cli.output import conclude, count
    from vibro.files.part_sets import PartSet, part_folder
    from vibro.files.publication import json_text
    from vibro.sweeps.csv_sink import provenance

    cells = plan.grid.size
    folder = part_folder(options.output, name)
    if plan.parts > _MANY_FILES:
        console.warn(f"{count(plan.parts)} files are many for a folder: --part-cells makes fewer")
    with PartSet(folder, "the same command with --resume goes on") as files:
        if parting.resume:
            there = len(files.parts())
            console.echo(f"{there} files are there and checked first" if there else "nothing is there yet")
        with _progress(console, folder, cells) as report:
            summary = parting.carry_out(plan, files, ["vibro", *argv], report)
        content = {**provenance(plan.grid, plan.table, summary.tally), "digest": summary.digest}
        drawn = _draw(files, pictures, content)
        files.finish(summary.text())
    _tell(console, folder, summary, cells, drawn)
    if options.json:
        print(
            json_text({"folder": str(folder), "parts": len(summary.sizes), "bytes": summary.size, **content})
        )
    return conclude(summary.tally, plan.grid, console), summary.tally


def _draw(files: PartSet, pictures: Pictures | None, content: Mapping[str, Any]) -> list[str]:
    """Draw pictures into the folder; return their names."""
    if pictures is None:
        return []
    metadata = {"Software": f"vibro {__version__}", "Description": json.dumps(content, allow_nan=False)}
    save = pictures.saver()
    drawn = []
    for name, form in product(pictures.names, pictures.formats):
        drawn.append(f"{name}.{form}")
        with files.new(drawn[-1]) as path:
            save(name, path, form, metadata)
    return drawn


@contextlib.contextmanager
def _progress(console: Console, folder: Path, cells: int) -> Iterator[Callable[[Progress], None]]:
    """Tell how far a run has come: a bar where somebody watches, else a line for every tenth."""
    from vibro.cli.output import byte_count, count

    said = seen = 0
    warned = False

    def look_at_disk(progress: Progress) -> None:
        nonlocal seen, warned
        if progress.parts > seen and not warned:
            seen = progress.parts
            needed = progress.size * (progress.all_parts / progress.parts - 1.0)
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
            note = f"{progress.parts} of {progress.all_parts} parts{rate}"
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


def _tell(console: Console, folder: Path, summary: Summary, cells: int, drawn: Sequence[str]) -> None:
    """Tell what was written."""
    from vibro.cli.output import byte_count
    from vibro.files.part_sets import MANIFEST, SUCCESS

    number = len(summary.sizes)
    each = f"{byte_count(summary.size)}, {summary.size / cells:.1f} bytes a cell"
    console.echo(
        f"wrote {folder}: {number} part{'' if number == 1 else 's'}, {each}; digest {summary.digest}"
    )
    for name in (*drawn, MANIFEST, SUCCESS):
        console.echo(f"wrote {folder / name}")
