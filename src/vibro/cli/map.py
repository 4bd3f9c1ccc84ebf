"""``vibro map``: sweep a scene and draw its regimes and speeds."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from vibro.cli.console import Console
from vibro.cli.options import (
    CoexistOption,
    Options,
    RegimesOnlyOption,
    refuse_without_flight,
)
from vibro.cli.table_options import (
    NEEDS_PART,
    ColumnsOption,
    MassOption,
    PitchOption,
    part_of,
    table_of,
    throughput_of,
)
from vibro.cli.views import SHOWN, names_of, shown_pictures, tell_choices, view_of
from vibro.core.codes import Output
from vibro.errors import FileError, InputError
from vibro.files.nearby import suggestion

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.figure import Figure

    from vibro.cli.outputs import Outputs
    from vibro.results.sweep import Block

WorkersOption = Annotated[
    str | None,
    typer.Option(
        "--workers",
        metavar="NUMBER|ADDRESS",
        help="With -o NAME.parquet: number of processes that make it, or the address of a Dask cluster,"
        " such as tcp://host:8786; by default threads of one process.",
        show_default=False,
    ),
]


def map_command(
    context: typer.Context,
    options: Options,
    x: Annotated[
        str | None,
        typer.Option(
            "--x",
            metavar="AXIS",
            help="Horizontal axis of the pictures.",
            show_default=False,
        ),
    ] = None,
    y: Annotated[
        str | None,
        typer.Option(
            "--y",
            metavar="AXIS",
            help="Vertical axis of the pictures.",
            show_default=False,
        ),
    ] = None,
    at: Annotated[
        list[str] | None,
        typer.Option(
            "--at",
            metavar="AXIS=VALUE",
            help="Fix an axis at one of its values in the pictures; repeatable. By default axes that are not"
            " drawn are fixed at the middle of their feasible values.",
            show_default=False,
        ),
    ] = None,
    show: Annotated[
        list[str] | None,
        typer.Option(
            "--show",
            metavar="|".join(SHOWN),
            help="Draw the impact speed, or the share of time in flight, too; repeatable.",
            show_default=False,
        ),
    ] = None,
    speed: Annotated[
        str | None,
        typer.Option(
            "--speed",
            metavar="SPEED",
            rich_help_panel="Pictures",
            help="Draw the contour of this speed, and print the share of the cells that reach it; in a map of"
            " both frictions, also which frictions reach it [mm/s].",
            show_default=False,
        ),
    ] = None,
    regimes_only: RegimesOnlyOption = False,
    coexist: CoexistOption = False,
    columns: ColumnsOption = None,
    pitch: PitchOption = None,
    mass: MassOption = None,
    workers: WorkersOption = None,
) -> int:
    """Map the regimes, speeds and traverse times of a scene over any of its quantities.

    An axis is a list 15,20,25 or a range lo:hi, lo:hi:count, lo:hi:step=d, each with an optional :log;
    without a count a range has 200 values, 100 beside another axis and 20 beside more. Numbers may carry
    units: 800um, 900rpm, 0.35rad. Without amplitude or frequency the map covers 0.1:3 mm and 5:60 Hz. The
    results go to NAME.csv, NAME.json and pictures; with -o NAME.xlsx to a workbook, with -o NAME.parquet to a
    folder, in which the same command goes on. Give such a folder instead of a scene file to draw its
    pictures. A list of at most 12 values is drawn as curves beside one range, and as several maps beside two.
    """
    if options.scene is not None and options.scene.is_dir():
        from vibro.cli.stored_map import map_stored

        return map_stored(context, options, x, y, at or [], show or [], speed)
    if options.scene is not None and not options.scene.exists():
        raise FileError(
            f"cannot read {options.scene}: there is no such file or folder",
            hint=suggestion(options.scene, (".toml",), folders=True),
        )
    if options.scene is not None and options.scene.suffix == ".parquet":
        raise InputError(f"{options.scene} is one file of a sweep", hint="give the folder that it lies in")
    from vibro.cli.answer import Pictures, make_grid, write_sweep
    from vibro.cli.outputs import MAPS, Outputs
    from vibro.cli.request import question, request_of
    from vibro.cli.target_speed import TargetSpeed, target_in_pictures
    from vibro.plots.view import check_drawable
    from vibro.quantities import LEAST_SPEED, checked_number
    from vibro.results.operating import BENT_SPEED, WARNED_HARMONIC, bent
    from vibro.results.sweep import at_rest, where_motion_begins
    from vibro.sweeps.columns import columns_of
    from vibro.sweeps.request import RANGES
    from vibro.sweeps.run import DrawnCells, limits_of, solved_picture, sweep_picture

    console = Console(quiet=options.quiet)
    shown = shown_pictures(show or [])
    output = Output.REGIMES if regimes_only else Output.EXACT
    if shown:
        refuse_without_flight(f"--show {','.join(shown)}", output)
    if coexist:
        refuse_without_flight("--coexist", output)
    target_speed = None if speed is None else checked_number(speed, LEAST_SPEED)
    if target_speed is not None and output is not Output.EXACT:
        raise InputError("--speed: no speeds are computed with --regimes-only", hint="leave one of them out")
    part = part_of(pitch, mass)
    request = request_of(options, context.obj, reads_map=True, takes_axes=True, ranges=RANGES)
    question(request, options)
    grid = make_grid(request, console, output=output, coexistence=coexist)
    usual = columns_of(
        grid.axes,
        *throughput_of(part),
        drive=grid.drive,
        made_with=grid.made_with,
        machine=grid.machine is not None,
    )
    written = table_of(usual, columns, needed=NEEDS_PART, has_length=grid.length is not None, part=part)
    axes = grid.told_axes
    view, held = view_of(grid, x, y, at or [])
    names = names_of(view, grid, shown)
    name = request.name or "vibro-map"
    outputs = Outputs(
        options, name, context.obj, console, forms=MAPS,
        pictures=names, reads=[options.scene], default=name,
    )  # fmt: skip
    number = _workers(workers, outputs)
    draws = bool(outputs.pictures) or any(form == "xlsx" for _, form in outputs.tables.values())
    if draws:
        check_drawable(view)
        tell_choices(view, axes, held, console)
    target = None if target_speed is None else TargetSpeed(axes, target_speed)
    cells = None if outputs.folder or not draws else DrawnCells.of(grid, view.drawn)
    reached = ""

    def draw(show: Callable[..., None]) -> dict[str, Figure]:
        from vibro.plots import map_figures

        nonlocal reached
        what = grid, view.drawn, request.own, request.name or ""
        if cells:
            result = solved_picture(*what, names, cells.results)
        else:
            result = sweep_picture(*what, lambda done, size: show(0, f"solving {done / size:.0%}"))
        if target and outputs.folder:
            reached = target_in_pictures(result, axes, target.speed)
        return map_figures(
            result,
            names,
            x=view.x.name,
            y=view.y.name if view.y else None,
            target_speed=target_speed,
            progress=lambda done, size: show(done),
        )

    pictures = Pictures(names, draw) if draws else None
    if outputs.folder:
        from vibro.cli.folders import write_stored

        if target and (target.is_of_frictions or not draws):
            raise InputError("--speed: not known of a folder alone", hint="leave it out, or add -o NAME.png")
        code, rests = write_stored(
            grid, written, request.name or "", request.own, outputs, number, options, console, pictures
        )
        if reached:
            console.echo(reached)
        if rests:
            console.echo(where_motion_begins(axes, grid.told(grid.fixed), limits_of(grid.values())))
        return code
    moves, bends = False, 0

    def look(block: Block) -> None:
        nonlocal moves, bends
        moves = moves or not at_rest(block.cycle).all()
        bends += bent(block)
        if target:
            target.add(block)
        if cells:
            cells.add(block)

    code = write_sweep(grid, written, outputs, options, console, pictures, look, view)
    if target:
        console.echo(target.text())
    if bends:
        console.warn(
            f"{bends} of {grid.size} cells: the filling adds a second harmonic to the trough's motion, above"
            f" {100.0 * WARNED_HARMONIC:g} % of the amplitude; the speed with it is the column"
            f" {BENT_SPEED.column} of --columns"
        )
    if not moves:
        console.echo(where_motion_begins(axes, grid.told(grid.fixed), limits_of(grid.values())))
    return code


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
