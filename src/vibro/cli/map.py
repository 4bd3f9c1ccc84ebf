"""``vibro map``: sweep a scene and draw its regimes and speeds."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from vibro.cli.forms import MAPS
from vibro.cli.options import (
    Options,
    RegimesOnlyOption,
    StartsOption,
    option,
    rare,
    refuse_without_flight,
    typed_names,
)
from vibro.cli.outputs import Outputs
from vibro.cli.table_options import NEEDS_PART, ColumnsOption, MassOption, PitchOption, part_of, table_of
from vibro.cli.views import SHOWN, held_axes, shown_pictures, tell_choices
from vibro.core.codes import Output
from vibro.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from vibro.cli.console import Console
    from vibro.cli.sweeps import Pictures
    from vibro.plots.view import View
    from vibro.results.operating import Bent
    from vibro.results.sweep import Block, Peak, SweepResult
    from vibro.sweeps.grid import Grid
    from vibro.sweeps.request import Request
    from vibro.sweeps.run import DrawnCells
    from vibro.sweeps.tally import Tally


def map_command(
    options: Options,
    x: Annotated[str | None, option("x", "Horizontal axis of pictures.", "AXIS")] = None,
    y: Annotated[str | None, option("y", "Vertical axis of pictures.", "AXIS")] = None,
    at: Annotated[
        list[str] | None, rare("at", "Value at which pictures hold an axis; repeatable.", "AXIS=X")
    ] = None,
    show: Annotated[
        list[str] | None,
        rare(
            "show", "Draw the impact speed, or the share of time in flight, too; repeatable.", "|".join(SHOWN)
        ),
    ] = None,
    speed: Annotated[str | None, option("speed", "Speed to mark, and to count cells [mm/s].", "X")] = None,
    regimes_only: RegimesOnlyOption = False,
    starts: StartsOption = None,
    columns: ColumnsOption = None,
    pitch: PitchOption = None,
    mass: MassOption = None,
    workers: Annotated[
        str | None,
        rare(
            "workers",
            "With -o NAME.parquet: number of processes, or the address of a Dask cluster.",
            "N|ADDRESS",
        ),
    ] = None,
) -> int:
    """Map regimes, speed and traverse time over any quantities: tables and pictures.

    An axis is a list 15,20,25 or a range lo:hi, lo:hi:count, lo:hi:step=d, each with an optional :log.
    Without amplitude and frequency it sweeps 0.1:3 mm and 5:60 Hz. Files: NAME.csv, NAME.json, pictures, or
    as -o says. A folder NAME.parquet in place of a scene gives its pictures.
    """
    if options.scene is not None and options.scene.is_dir():
        from vibro.cli.stored_map import map_stored

        unused = typed_names(
            pack=options.pack, decimal_comma=options.decimal_comma, regimes_only=regimes_only,
            starts=starts, columns=columns, pitch=pitch, mass=mass, workers=workers,
        )  # fmt: skip
        return map_stored(options, x, y, at or [], show or [], speed, unused=unused)
    from vibro.cli.folders import write_stored
    from vibro.cli.request import request_of
    from vibro.cli.sweeps import conclude, count, write_sweep
    from vibro.cli.target_speed import TargetSpeed
    from vibro.quantities import LEAST_SPEED, checked_number
    from vibro.results.operating import Bent, bent
    from vibro.results.steady import MINORITY
    from vibro.steady import checked_starts
    from vibro.sweeps.derived import throughput
    from vibro.sweeps.request import RANGES
    from vibro.sweeps.run import DrawnCells
    from vibro.sweeps.solved import pictures_of, view_of
    from vibro.tables.plan import Plan

    console = options.console
    shown = shown_pictures(show or [])
    output = Output.REGIMES if regimes_only else Output.EXACT
    for typed, given in ((f"--show {','.join(shown)}", shown), ("--starts", starts is not None)):
        if given:
            refuse_without_flight(typed, output)
    target_speed = None if speed is None else checked_number(speed, LEAST_SPEED)
    if target_speed is not None and output is not Output.EXACT:
        raise InputError("--speed: no speeds are computed with --regimes-only", hint="leave one of them out")
    part = part_of(pitch, mass)
    request = request_of(options, varies=True, reads_map=True, takes_axes=True, ranges=RANGES)
    grid = request.grid(output, starts=None if starts is None else checked_starts(starts))
    console.echo_all(map(str, grid.given_axes.values()))
    table = table_of(grid, columns, throughput(part), needed=NEEDS_PART, part=part)
    view, held = view_of(grid, x, y, held_axes(at or []), "--at")
    names = pictures_of(grid, view, on_request=False) + shown
    name = request.name or "vibro-map"
    outputs = Outputs(options, name, forms=MAPS, pictures=names, default=name)
    made_by = _workers(workers, outputs)
    if outputs.folder and target_speed is not None:
        raise InputError(
            "--speed: cells of a folder are not counted", hint="vibro map NAME.parquet --speed draws it"
        )
    cells, pictures = None, None
    if outputs.pictures or any(form == "xlsx" for _, form in outputs.tables.values()):
        tell_choices(view, grid.given_axes, held, console)
        cells = None if outputs.folder else DrawnCells.of(grid, view.drawn)
        pictures = _pictures(request, grid, view, names, target_speed, cells)
    target = None if target_speed is None else TargetSpeed(grid.given_axes, target_speed)
    bends, minorities = Bent(0, 0), 0

    def look(block: Block) -> None:
        nonlocal bends, minorities
        minorities += int((block.cycle.share < MINORITY).sum())
        bends = Bent(*(x + y for x, y in zip(bends, bent(block), strict=True)))
        if target:
            target.add(block)
        if cells:
            cells.add(block)

    if outputs.folder:
        plan = Plan.of(grid, table, request.name or "", request.own)
        tally = write_stored(plan, outputs, made_by, pictures)
    else:
        tally = write_sweep(grid, table, outputs, pictures, look)
        outputs.print_record()
    code = conclude(tally, grid, console)
    if target:
        console.echo(target.text(tally.peaks.get("fastest")))
    if minorities:
        share = f"{count(minorities)} of {count(grid.size)} cells"
        console.echo(f"in {share} most parts move otherwise than the one released at the start of a cycle")
    _tell_doubts(grid, tally, bends, console)
    return code


def _pictures(
    request: Request,
    grid: Grid,
    view: View,
    names: Sequence[str],
    speed: float | None,
    cells: DrawnCells | None,
) -> Pictures:
    """Say what is drawn: cells of the table where these are dear, else cells of the picture's own."""
    from vibro.cli.sweeps import Pictures
    from vibro.sweeps.run import solved_picture, sweep_picture

    what = grid, view.drawn, request.own, request.name or ""

    def solved(peaks: Mapping[str, Peak], progress: Callable[[int, int], None]) -> SweepResult:
        if cells:
            return solved_picture(*what, names, cells.results, peaks)
        return sweep_picture(*what, progress, peaks)

    return Pictures(names, view, speed, solved)


def _tell_doubts(grid: Grid, tally: Tally, bends: Bent, console: Console) -> None:
    """Tell how many troughs do not move as a sine, and if nothing moves, what would."""
    from vibro.results.operating import BENT_SPEED, WARNED_HARMONIC
    from vibro.results.sweep import where_motion_begins
    from vibro.sweeps.run import limits_of

    if bends.number:
        console.warn(
            f"{bends.number} of {grid.size} cells: the filling adds a second harmonic above"
            f" {100.0 * WARNED_HARMONIC:g} % of the amplitude; {BENT_SPEED.column} of --columns has the"
            " speed with it"
        )
    if bends.uncertain:
        console.warn(
            f"{bends.uncertain} of {grid.size} cells: the filling bends the motion much; their amplitude and"
            " speed are uncertain, as the column uncertain says"
        )
    if tally.at_rest:
        limits = limits_of(grid.values())
        console.echo(where_motion_begins(grid.given_axes, grid.as_given(grid.fixed), limits))


def _workers(text: str | None, outputs: Outputs) -> int | str | None:
    """Read who makes a folder; a table in one file is made by this process."""
    from vibro.tables.writing import checked_workers

    if outputs.folder and (outputs.tables or outputs.takes_stdout):
        other = next(map(str, outputs.tables), "-o -")
        raise InputError(
            f"-o {outputs.folder}: a folder is written without another table, such as {other}",
            hint="leave one of them out; pictures may stand beside a folder, -o NAME.png",
        )
    if text is None:
        return None
    if not outputs.folder:
        raise InputError(
            f"--workers {text}: only a folder is made by workers", hint="add -o NAME.parquet, or leave it out"
        )
    return checked_workers(int(text) if text.isdecimal() and len(text) < 5 else text)
