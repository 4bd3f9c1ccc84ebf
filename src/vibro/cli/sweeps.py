"""Sweeps that a command solves: their tables, pictures and record, and how they went."""

from __future__ import annotations

import io
import shutil
import sys
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from vibro.answers.answer import NO_BOUNCE, number, uncertain
from vibro.cli.exit_codes import ExitCode
from vibro.core.codes import Regime, Status
from vibro.errors import FileError
from vibro.quantities import LOAD, as_given, scene_fields
from vibro.results.steady import NO_REGIME
from vibro.sweeps.tally import Tally
from vibro.tables.record import sweep_record
from vibro.tables.sinks import csv_sink, write_table

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence
    from pathlib import Path

    from matplotlib.figure import Figure

    from vibro.axes import Axis
    from vibro.cli.console import Console
    from vibro.cli.outputs import Outputs
    from vibro.plots.view import View
    from vibro.results.sweep import Block, Peak, SweepResult
    from vibro.sweeps.columns import Table
    from vibro.sweeps.grid import Grid
    from vibro.tables.sinks import Sink
    from vibro.tables.xlsx import Xlsx

_ROWS_OF_A_SHEET: Final = 1_048_576
_BACK_SLIP: Final = "  (also slides back; advances unless the speed is negative)"
_CELL: Final = 12  # [B] on average with its separator: numbers that vary have up to 19


@dataclass(frozen=True)
class Pictures:
    """Pictures to be made of a sweep.

    Attributes
    ----------
    names : sequence of str
        Which.
    view : View
        What they show.
    speed : float or None
        To be marked [mm/s].
    solved : callable
        Returns their cells; called with the fastest cells of the table, and with what shows progress.
    """

    names: Sequence[str]
    view: View
    speed: float | None
    solved: Callable[[Mapping[str, Peak], Callable[[int, int], None]], SweepResult]


@contextmanager
def drawn(pictures: Pictures | None, console: Console, tally: Tally) -> Iterator[Mapping[str, Figure]]:
    """Draw pictures of tallied cells, if there are any, and show progress until they are written."""
    if pictures is None:
        yield {}
        return
    from vibro.plots import map_figures

    names, view = pictures.names, pictures.view
    with console.progress("drawing", len(names)) as bar:
        bar(0)
        result = pictures.solved(tally.peaks, lambda done, size: bar(0, f"solving {done / size:.0%}"))
        yield map_figures(
            result,
            names,
            x=view.x.name,
            y=view.y.name if view.y else None,
            target_speed=pictures.speed,
            progress=lambda done, size: bar(done),
        )


def count(number: int) -> str:
    """Write a whole number for people, its thousands apart."""
    return f"{number:,}".replace(",", " ")


def write_sweep(
    grid: Grid,
    table: Table,
    outputs: Outputs,
    pictures: Pictures | None = None,
    look: Callable[[Block], None] = lambda block: None,
    more: Callable[[], Mapping[str, Any]] = dict,
    page: Callable[[Mapping[str, Figure]], str] | None = None,
) -> Tally:
    """Solve a grid and write its table, pictures and JSON.

    Parameters
    ----------
    grid : Grid
        What to solve.
    table : Table
        What is written of it.
    outputs : Outputs
        Where to.
    pictures : Pictures, optional
        What to draw.
    look : callable, optional
        Called with every block of solved cells, in their order.
    more : callable, optional
        Returns what the record says beside, once all is solved.
    page : callable, optional
        Makes the page about it, of the pictures.

    Returns
    -------
    Tally
        Of its cells.

    Raises
    ------
    InputError, FileError
        If the grid is too large, or the files cannot be written.
    """
    from vibro.tables.files import hidden_folder

    console, form = outputs.options.console, outputs.csv_format
    with outputs, ExitStack() as stack:
        sinks: list[Sink] = []
        books: dict[Path, Xlsx] = {}
        for path, (_, ending) in outputs.tables.items():
            if ending == "csv":
                _check_size(grid, _CELL * len(table.columns), path.parent, console)
                sinks.append(csv_sink(stack.enter_context(outputs.waiting[path].open("wb")), table, form))
            else:
                from vibro.tables.xlsx import Xlsx

                scratch = stack.enter_context(hidden_folder(path.parent))
                view = pictures.view if pictures else None
                books[path] = Xlsx(outputs.waiting[path], scratch, grid, table, view)
                sinks.append(books[path].write)
        if outputs.takes_stdout:
            sinks.append(csv_sink(sys.stdout.buffer, table, form))
        with console.progress("solving", grid.size) as bar:
            tally = write_table(grid, table, sinks, report=bar, look=look)
        content = sweep_record(grid, table, tally.record())
        with drawn(pictures if outputs.pictures or books else None, console, tally) as figures:
            if page is not None:
                outputs.write_texts({"html": page}, figures)
            outputs.finish({**content, **more()}, figures)
            if books:
                console.echo("writing the workbook")
            for path, book in books.items():
                book.close(
                    {"name": path.stem, **outputs.record, **content},
                    {name: _png(figure, outputs.record) for name, figure in figures.items()},
                )
    return tally


def _png(figure: Figure, record: Mapping[str, Any]) -> bytes:
    from vibro.plots import save
    from vibro.tables.record import picture_metadata

    stream = io.BytesIO()
    save(figure, stream, "png", picture_metadata(record))
    return stream.getvalue()


def _check_size(grid: Grid, row_bytes: int, folder: Path, console: Console) -> None:
    """Refuse a CSV for which there is no space, and warn of one that no spreadsheet opens."""
    cells, free, needed = count(grid.size), shutil.disk_usage(folder).free, grid.size * row_bytes
    if needed > free:
        raise FileError(
            f"{cells} cells are about {byte_count(needed)}, but only {byte_count(free)} are free in {folder}",
            hint="free some space, ask for fewer values, or write a folder, such as -o wide.parquet",
        )
    if grid.size > _ROWS_OF_A_SHEET:
        console.warn(
            f"{cells} rows are more than the {count(_ROWS_OF_A_SHEET)} of a spreadsheet;"
            " a folder suits them better, such as -o wide.parquet"
        )


def byte_count(number: float) -> str:
    """Write a number of bytes for people."""
    for unit in ("B", "kB", "MB", "GB", "TB"):
        if number < 1000:
            return f"{number:.3g} {unit}"
        number /= 1000
    return f"{number:.3g} PB"


def tell_peaks(tally: Tally, grid: Grid, console: Console) -> None:
    """Tell which cells of a sweep are conveyed fastest, forwards and backwards."""
    from vibro.scene import Scene

    for name, peak in tally.peaks.items():
        console.echo(f"{name.replace('_', ' ')}: {peak_text(peak, grid.given_axes)}")
        motion = {} if grid.motion is None else {"motion": grid.motion.motion}
        load = float(f"{float(Scene(**scene_fields({**peak.values, **motion})).load):.4g}")
        if load > (usual := LOAD.usual.high):
            console.warn(f"there the acceleration is {load:g} g; usual are up to {usual:g} g")


def peak_text(peak: Peak, axes: Mapping[str, Axis]) -> str:
    """Write how fast the fastest cell of a sweep is, and where it lies."""
    values = as_given(peak.values, in_stroke="stroke" in axes)
    place = [f"{axis.label} {number(values[name], axis.unit)}" for name, axis in axes.items()]
    return f"{uncertain(peak.speed, peak.error, 6)} mm/s at {', '.join(place)}"


def conclude(tally: Tally, grid: Grid, console: Console) -> int:
    """Tell how it went, and return the exit code."""
    size = grid.size
    for status in Status:
        if status is not Status.OK and tally.status[status]:
            cells = "cell" if size == 1 else f"of {count(size)} cells"
            console.echo(f"{count(tally.status[status])} {cells}: {status.label} ({status.message})")
    if size > 1:
        for regime in Regime:
            if tally.regime[regime]:
                note = _BACK_SLIP if regime is Regime.BACK_SLIP else ""
                console.echo(f"{regime.label or NO_REGIME:>12} {tally.regime[regime] / size:7.1%}{note}")
        if tally.regime[Regime.HOPPING] and grid.flight and grid.fixed.get("restitution") == 0.0:
            console.echo(f"{NO_BOUNCE}; --restitution changes that")
        tell_peaks(tally, grid, console)
    return ExitCode.UNRESOLVED if tally.status[Status.UNRESOLVED] else ExitCode.DONE
