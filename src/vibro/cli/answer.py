"""From a checked request to its answer: what the commands that solve sweeps share."""

from __future__ import annotations

import json
import math
import sys
from bisect import bisect_right
from contextlib import contextmanager
from dataclasses import dataclass, replace
from itertools import product
from typing import TYPE_CHECKING, Any, Final

from vibro.cli.console import Console
from vibro.cli.exit_codes import ExitCode
from vibro.cli.options import Flight
from vibro.cli.stems import output_stem
from vibro.core.codes import Output, Regime, Status
from vibro.errors import FileError, InputError
from vibro.output.record import json_text, sweep_record
from vibro.output.run import write_table
from vibro.output.sinks import new_sink
from vibro.output.staging import Staging
from vibro.quantities import QUANTITIES, as_given
from vibro.results.steady import NO_REGIME, RESULTS
from vibro.sweeps.columns import arrow_table
from vibro.sweeps.one_scene import OneScene, bounce_text, estimate, number
from vibro.sweeps.run import sweep_blocks
from vibro.sweeps.tally import Tally

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence
    from typing import BinaryIO

    from matplotlib.figure import Figure

    from vibro.axes import Axis
    from vibro.cli.options import Options
    from vibro.results.sweep import Block, Peak
    from vibro.sweeps.columns import Table
    from vibro.sweeps.grid import Grid
    from vibro.sweeps.request import Request

__all__ = [
    "Pictures",
    "answer_one",
    "answer_sweep",
    "byte_count",
    "check_stdout",
    "conclude",
    "count",
    "drawn",
    "make_grid",
    "peak_text",
    "tell_peaks",
    "write_sweep",
]

_ROWS_OF_A_SHEET: Final = 1_048_576
# [B] What cells with their separator come to, rounded up: exact numbers that vary; texts, numbers that do not
# vary, and those that do where bodies hop alone.
_LONG, _SHORT = 19, 8


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
        Returns the figures by name; called with what shows how many are drawn, and a note beside.
    """

    names: Sequence[str]
    formats: Sequence[str]
    draw: Callable[[Callable[..., None]], Mapping[str, Figure]]

    @property
    def files(self) -> dict[str, tuple[str, str]]:
        """Name and format of each, by its file in a folder of shards."""
        from vibro.output.names import picture_file

        return {picture_file(*which): which for which in product(self.names, self.formats)}


@contextmanager
def drawn(pictures: Pictures | None, console: Console) -> Iterator[Mapping[str, Figure]]:
    """Draw pictures, if there are any, and show progress until they are written."""
    if pictures is None:
        yield {}
        return
    with console.progress("drawing", len(pictures.names)) as bar:
        bar(0)
        yield pictures.draw(bar)


def count(number: int) -> str:
    """Write a whole number for people, its thousands apart."""
    return f"{number:,}".replace(",", " ")


def make_grid(
    request: Request,
    console: Console | None = None,
    *,
    output: Output = Output.EXACT,
    flight: Flight = Flight.ON,
    coexistence: bool = False,
    arrivals: bool = False,
) -> Grid:
    """Spell out the axes of a request, and echo them."""
    follows = output is Output.EXACT and flight is Flight.ON
    grid = request.grid(output, flight=follows, coexistence=coexistence, arrivals=arrivals)
    if console is not None:
        for axis in grid.told_axes.values():
            console.echo(str(axis))
    return grid


def write_sweep(
    grid: Grid,
    table: Table,
    options: Options,
    argv: Sequence[str],
    console: Console,
    name: str,
    pictures: Pictures | None = None,
    look: Callable[[Block], None] = lambda block: None,
    form: str = "csv",
    style: Mapping[str, Any] | None = None,
) -> int:
    """Solve a grid and write its table, pictures and JSON.

    Parameters
    ----------
    grid : Grid
        What to solve.
    table : Table
        What is written of it.
    options : Options
        Where to write, and how.
    argv : sequence of str
        The arguments as typed.
    console : Console
        For progress and messages.
    name : str
        The files' name where the options name none, or a folder.
    pictures : Pictures, optional
        What to draw.
    look : callable, optional
        Called with every block of solved cells, in their order.
    form, style : optional
        Form of the table, and options of its class.

    Returns
    -------
    int
        The exit code.

    Raises
    ------
    InputError, FileError
        If the grid is too large, or the files cannot be written.
    """
    if style is None:
        style = {"excel": options.excel, "decimal_comma": options.decimal_comma}
    sink = new_sink(form, **style)
    if form == "csv" and grid.size > _ROWS_OF_A_SHEET:
        console.warn(
            f"{count(grid.size)} rows are more than the {count(_ROWS_OF_A_SHEET)} of a spreadsheet;"
            " --table parquet suits them better"
        )

    def write(file: BinaryIO) -> Tally:
        with console.progress("solving", grid.size) as bar:

            def report(done: int) -> None:
                bar(done)
                if form != "csv" and done == grid.size:
                    console.echo(f"writing the table as {form}")

            return write_table(grid, table, sink, file, argv, report=report, look=look)

    if options.output == "-":
        check_stdout(json=options.json)
        return conclude(write(sys.stdout.buffer), grid, console)

    with Staging(
        output_stem(options.output, name, form),
        force=options.force,
        tables={"": form},
        pictures=pictures.names if pictures else (),
        formats=pictures.formats if pictures else (),
        reads=[options.scene],
    ) as files:
        if form == "csv":
            _check_size(grid, _row_bytes(grid, table), files)
        with files.table().open("wb") as file:
            tally = write(file)
        content = sweep_record(grid, table, tally.told())
        with drawn(pictures, console) as figures:
            record = files.finish(argv, content, figures)
    console.echo_all(files.told)
    if options.json:
        print(json_text(record))
    return conclude(tally, grid, console)


def answer_sweep(
    grid: Grid,
    table: Table,
    options: Options,
    argv: Sequence[str],
    console: Console,
    name: str,
) -> int:
    """Solve a grid and print its table, as CSV or as JSON; write files if the options name an output.

    Parameters and errors are those of ``write_sweep``.
    """
    if options.output is not None:
        return write_sweep(grid, table, options, argv, console, name)
    if not options.json:
        return write_sweep(grid, table, replace(options, output="-"), argv, console, name)
    tally = Tally()
    between = "[\n"
    for block in sweep_blocks(grid):
        tally.add(block)
        for cell in arrow_table(table.columns, block, table.digits).to_pylist():
            print(between, json.dumps(cell, allow_nan=False), sep="", end="")
            between = ",\n"
    print("\n]")
    return conclude(tally, grid, console)


def answer_one(
    grid: Grid,
    table: Table,
    options: Options,
    argv: Sequence[str],
    name: str,
    report: Callable[[OneScene], str],
    answer: Table | None = None,
) -> int:
    """Solve one scene and print its report or its JSON; write its row if the options name an output.

    Parameters
    ----------
    grid : Grid
        Of a single cell.
    table : Table
        What the row holds.
    options : Options
        What to print and where to write.
    argv : sequence of str
        The arguments as typed.
    name : str
        The files' name where the options name a folder.
    report : callable
        Writes the report.
    answer : Table, optional
        What the JSON holds, if not the same.

    Returns
    -------
    int
        The exit code.

    Raises
    ------
    InputError, FileError
        If the files cannot be written.
    """
    if grid.machine is not None:
        from vibro.sweeps.machine_facts import machine_warnings
        from vibro.sweeps.machines import check_operating

        values = grid.values()
        check_operating(grid.machine, values)
        for text in machine_warnings(grid.machine, values):
            Console(quiet=options.quiet).warn(text)
    blocks: list[Block] = []
    if options.output is None:
        blocks += sweep_blocks(grid)
    else:
        # JSON on stdout is the answer here, not the description of the files.
        quiet = replace(options, json=options.json and options.output == "-")
        code = write_sweep(grid, table, quiet, argv, Console(quiet=options.quiet), name, look=blocks.append)
        if options.output == "-":
            return code
    (block,) = blocks
    if options.json:
        answer = answer or table
        print(json_text(arrow_table(answer.columns, block, answer.digits).to_pylist()[0]))
    else:
        print(report(OneScene(block)))
    return ExitCode.UNRESOLVED if block.cycle.status == Status.UNRESOLVED else ExitCode.DONE


def check_stdout(*, json: bool) -> None:
    """Refuse JSON on stdout beside a table."""
    if json:
        raise InputError("--json and -o - both want stdout", hint="leave one of them out")


def _row_bytes(grid: Grid, table: Table) -> int:
    """Estimate what a row of a table comes to [B]."""
    short = {QUANTITIES[name].column for name in (*grid.fixed, "trough_length")}
    short |= {result.column for result in RESULTS if result.in_contact is not None or not result.is_number}
    long = _LONG if table.digits is None else min(_LONG, table.digits + 2)  # a point, a separator
    return sum(_SHORT if column.name in short else long for column in table.columns)


def _check_size(grid: Grid, row_bytes: int, files: Staging) -> None:
    free, needed = files.free_space(), grid.size * row_bytes
    if needed > free:
        sizes = f"about {byte_count(needed)}, but only {byte_count(free)} are free"
        product = f"{' x '.join(map(str, grid.shape))} = " if len(grid.shape) > 1 else ""
        cells = f"{product}{count(grid.size)} cells are" if grid.size > 1 else "one cell is"
        raise FileError(
            f"{cells} {sizes} in {files.folder}",
            hint=f"free some space, {_fewer(grid.shape, free // row_bytes)}, or write --table parquet",
        )


def _fewer(counts: Sequence[int], room: int) -> str:
    """Say how many values would fit into so many cells, by shortening the longest axes."""
    most = (
        bisect_right(range(max(counts, default=1)), room, key=lambda n: math.prod(min(n, m) for m in counts))
        - 1
    )
    most -= most % 10 ** max(0, len(str(most)) - 2)  # two digits are enough
    fitting = [min(most, m) for m in counts]
    if most < 2:
        return "ask for fewer values"
    example = " x ".join(map(str, fitting))
    return f"ask for at most {count(room)} cells{f', such as {example}' if len(counts) > 1 else ''}"


def byte_count(number: float) -> str:
    """Write a number of bytes for people."""
    for unit in ("B", "kB", "MB", "GB", "TB"):
        if number < 1000:
            return f"{number:.3g} {unit}"
        number /= 1000
    return f"{number:.3g} PB"


def tell_peaks(tally: Tally, grid: Grid, console: Console) -> None:
    """Tell which cells of a sweep are conveyed fastest, forwards and backwards."""
    for name, peak in tally.peaks.items():
        console.echo(f"{name.replace('_', ' ')}: {peak_text(peak, grid.told_axes)}")


def peak_text(peak: Peak, axes: Mapping[str, Axis]) -> str:
    """Write how fast the fastest cell of a sweep is, and where it lies."""
    values = as_given(peak.values, in_stroke="stroke" in axes)
    place = [f"{axis.label} {number(values[name], axis.unit)}" for name, axis in axes.items()]
    return f"{estimate(peak.speed, peak.error, 'mm/s')} at {', '.join(place)}"


def conclude(tally: Tally, grid: Grid, console: Console) -> int:
    """Tell how it went, and return the exit code."""
    size = tally.status.total()  # of some shards alone fewer than the grid's
    for status in Status:
        if status is not Status.OK and tally.status[status]:
            cells = "cell" if size == 1 else f"of {count(size)} cells"
            console.echo(f"{count(tally.status[status])} {cells}: {status.label} ({status.message})")
    if size > 1:
        for regime in Regime:
            if tally.regime[regime]:
                console.echo(f"{regime.label or NO_REGIME:>12} {tally.regime[regime] / size:7.1%}")
        if tally.regime[Regime.HOPPING] and grid.flight and grid.fixed.get("restitution") == 0.0:
            console.echo(f"restitution {bounce_text(0.0)}; --restitution changes that")
        tell_peaks(tally, grid, console)
    return ExitCode.UNRESOLVED if tally.status[Status.UNRESOLVED] else ExitCode.DONE
