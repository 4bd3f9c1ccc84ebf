"""From a checked request to its files: what the commands that write tables share."""

from __future__ import annotations

import json
import sys
from collections import Counter
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final, TypeVar

import numpy as np

from vibro import __version__
from vibro.axes import default_count
from vibro.cli.console import Console
from vibro.cli.options import Accuracy, Flight
from vibro.cli.report import OneScene
from vibro.core.codes import Regime, Status
from vibro.errors import InputError
from vibro.files.outputs import OutputSet, output_stem, suffixed, write_json
from vibro.quantities import QUANTITIES
from vibro.sweeps.columns import CsvFormat, record
from vibro.sweeps.run import Grid, sweep_blocks

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from pathlib import Path
    from typing import TextIO

    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from vibro.cli.options import Options
    from vibro.cli.request import Request
    from vibro.sweeps.columns import Column
    from vibro.sweeps.run import Block

__all__ = ["Pictures", "answer_one", "count", "describe_grid", "make_grid", "table_stream", "write_sweep"]

_Code = TypeVar("_Code", Status, Regime)

_ROWS_OF_A_SHEET: Final = 1_048_576
_BYTES_PER_ROW: Final = 210  # [B] what a row of all columns comes to, rounded up
_UNRESOLVED: Final = 3  # exit code


@dataclass(frozen=True)
class Pictures:
    """Pictures to be made of a sweep.

    Attributes
    ----------
    names : sequence of str
        What ``draw`` returns.
    formats : sequence of str
        Such as ``png``.
    draw : callable
        Returns the figures by name.
    """

    names: Sequence[str]
    formats: Sequence[str]
    draw: Callable[[], Mapping[str, Figure]]


def count(number: int) -> str:
    """Write a whole number for people, its thousands apart."""
    return f"{number:,}".replace(",", " ")


def make_grid(
    request: Request,
    console: Console | None = None,
    *,
    accuracy: Accuracy = Accuracy.EXACT,
    flight: Flight = Flight.ON,
    arrivals: bool = False,
) -> Grid:
    """Spell out the axes of a request, and echo them."""
    open_count = default_count(len(request.varying))
    axes = {name: request.specs[name].axis(open_count) for name in request.varying}
    if console is not None:
        for axis in axes.values():
            console.echo(str(axis))
    fixed = {
        name: spec.value
        for name, spec in request.specs.items()
        if not spec.varies and name != "trough_length"
    }
    exact = accuracy is Accuracy.EXACT
    return Grid(
        axes,
        fixed,
        request.length,
        "exact" if exact else "regimes",
        flight=exact and flight is Flight.ON,
        arrivals=arrivals,
    )


def write_sweep(
    grid: Grid,
    columns: Sequence[Column],
    options: Options,
    argv: Sequence[str],
    console: Console,
    name: str,
    pictures: Pictures | None = None,
) -> int:
    """Solve a grid and write its table, pictures and sidecar.

    Parameters
    ----------
    grid : Grid
        What to solve.
    columns : sequence of Column
        What the table holds.
    options : Options
        Where to write, and how.
    argv : sequence of str
        The arguments as typed.
    console : Console
        For progress and messages.
    name : str
        The files' name where the options name none.
    pictures : Pictures, optional
        What to draw.

    Returns
    -------
    int
        The exit code.

    Raises
    ------
    InputError, FileError
        If the grid is too large, or the files cannot be written.
    """
    form = CsvFormat(options.excel, options.decimal_comma)
    if grid.size > _ROWS_OF_A_SHEET:
        console.warn(f"{count(grid.size)} rows are more than the {count(_ROWS_OF_A_SHEET)} of a spreadsheet")
    if options.output == "-":
        tally = _write_table(grid, columns, form, table_stream(json=options.json), console)
        return _conclude(tally, grid.size, console, [])

    stem = output_stem(options.output, name)
    table, sidecar = suffixed(stem, ".csv"), suffixed(stem, ".json")
    drawn = {
        (picture, form_): suffixed(stem, f"-{picture}.{form_}")
        for picture in (pictures.names if pictures else ())
        for form_ in (pictures.formats if pictures else ())
    }
    targets = [table, *drawn.values(), sidecar]
    with OutputSet(targets, force=options.force) as files:
        _check_size(grid, files)
        with files[table].open("w", encoding="utf-8", newline="") as stream:
            tally = _write_table(grid, columns, form, stream, console)
        content = _provenance(grid, columns, argv, tally, targets)
        if pictures:
            _write_pictures(pictures, {key: files[path] for key, path in drawn.items()}, content)
        write_json(files[sidecar], content)
    if options.json:
        print(json.dumps(content, indent=2, allow_nan=False))
    return _conclude(tally, grid.size, console, targets)


def answer_one(
    grid: Grid,
    columns: Sequence[Column],
    options: Options,
    argv: Sequence[str],
    name: str,
    report: Callable[[OneScene], str],
) -> int:
    """Solve one scene and print its report or its JSON; write its row if the options name an output.

    Parameters
    ----------
    grid : Grid
        Of a single cell.
    columns : sequence of Column
        Keys of the JSON, and what the row holds.
    options : Options
        What to print and where to write.
    argv : sequence of str
        The arguments as typed.
    name : str
        The files' name where the options name a folder.
    report : callable
        Writes the report.

    Returns
    -------
    int
        The exit code.

    Raises
    ------
    InputError, FileError
        If the files cannot be written.
    """
    if options.output is not None:
        # JSON on stdout is the answer here, not the sidecar.
        quiet = replace(options, json=options.json and options.output == "-")
        code = write_sweep(grid, columns, quiet, argv, Console(quiet=options.quiet), name)
        if options.output == "-":
            return code
    (block,) = sweep_blocks(grid)
    if options.json:
        print(json.dumps(record(columns, block), indent=2, allow_nan=False))
    else:
        print(report(OneScene(block)))
    return _UNRESOLVED if block.cycle.status == Status.UNRESOLVED else 0


def table_stream(*, json: bool) -> TextIO:
    """Return stdout for a table alone: in UTF-8, with line ends as they are written."""
    if json:
        raise InputError("--json and -o - both want stdout", hint="leave one of them out")
    sys.stdout.reconfigure(encoding="utf-8", newline="")  # type: ignore[union-attr]
    return sys.stdout


@dataclass
class _Tally:
    """Cells by status and by regime."""

    status: Counter[Status]
    regime: Counter[Regime]

    def add(self, block: Block) -> None:
        self.status.update(_counted(block.cycle.status, Status))
        self.regime.update(_counted(block.cycle.regime, Regime))


def _counted(codes: NDArray[np.int8], kind: Callable[[int], _Code]) -> dict[_Code, int]:
    values, numbers = np.unique(codes, return_counts=True)
    return {kind(code): number for code, number in zip(values.tolist(), numbers.tolist(), strict=True)}


def _check_size(grid: Grid, files: OutputSet) -> None:
    needed, free = grid.size * _BYTES_PER_ROW, files.free_space()
    if needed > free:
        sizes = f"about {_bytes(needed)}, but only {_bytes(free)} are free"
        raise InputError(
            f"{' x '.join(map(str, grid.shape))} = {count(grid.size)} cells are {sizes} in {files.folder}",
            hint="ask for fewer values, or write to stdout with -o -",
        )


def _bytes(number: float) -> str:
    for unit in ("kB", "MB", "GB", "TB", "PB"):
        number /= 1000
        if number < 1000:
            return f"{number:.3g} {unit}"
    return f"{number:.3g} PB"


def _write_table(
    grid: Grid, columns: Sequence[Column], form: CsvFormat, stream: TextIO, console: Console
) -> _Tally:
    tally = _Tally(Counter(), Counter())
    stream.write(form.header(columns))
    done = 0
    with console.progress("solving", grid.size) as report:
        for block in sweep_blocks(grid):
            stream.write(form.rows(columns, block))
            tally.add(block)
            done += block.cycle.status.size
            report(done)
    return tally


def _write_pictures(
    pictures: Pictures, paths: Mapping[tuple[str, str], Path], content: Mapping[str, Any]
) -> None:
    from vibro.plots import save

    figures = pictures.draw()
    metadata = {
        "Software": f"vibro {__version__}",
        "Description": json.dumps(content, allow_nan=False),
    }
    for (name, form), path in paths.items():
        heading = figures[name].get_suptitle().partition("\n")[0]
        save(figures[name], path, form, {"Title": heading, **metadata})


def describe_grid(grid: Grid) -> dict[str, Any]:
    """Return what a sidecar says of a grid: its fixed quantities and its axes, by their columns."""
    axes = {
        axis.column: {
            "count": len(axis),
            "first": float(axis.values[0]),
            "last": float(axis.values[-1]),
            "spacing": axis.spacing,
            **({"values": axis.values.tolist()} if axis.spacing == "list" else {}),
        }
        for axis in grid.axes.values()
    }
    scene = {QUANTITIES[name].column: value for name, value in grid.fixed.items()}
    if grid.length is not None:
        scene[QUANTITIES["trough_length"].column] = grid.length
    return {"scene": scene, "axes": axes}


def _provenance(
    grid: Grid, columns: Sequence[Column], argv: Sequence[str], tally: _Tally, targets: Sequence[Path]
) -> dict[str, Any]:
    """Return what a sidecar says: enough to run the sweep again."""
    return {
        "version": __version__,
        "argv": ["vibro", *argv],
        **describe_grid(grid),
        "accuracy": grid.accuracy,
        "flight": grid.flight,
        "cells": grid.size,
        "status": {status.label: tally.status[status] for status in Status if tally.status[status]},
        "regime": {regime.label or "none": tally.regime[regime] for regime in Regime if tally.regime[regime]},
        "columns": {column.name: column.unit for column in columns},
        "files": [target.name for target in targets],
    }


def _conclude(tally: _Tally, size: int, console: Console, targets: Sequence[Path]) -> int:
    """Tell how it went, and return the exit code."""
    for status in Status:
        if status is not Status.OK and tally.status[status]:
            cells = "cell" if size == 1 else f"of {count(size)} cells"
            console.echo(f"{count(tally.status[status])} {cells}: {status.label} ({status.message})")
    if console.is_terminal:
        for target in targets:
            console.echo(f"wrote {target}")
        for regime in Regime:
            if tally.regime[regime]:
                console.echo(f"{regime.label or 'no regime':>12} {tally.regime[regime] / size:7.1%}")
    return _UNRESOLVED if tally.status[Status.UNRESOLVED] else 0
