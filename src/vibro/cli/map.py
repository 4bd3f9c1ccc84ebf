"""``vibro map``: sweep a scene and draw its regimes and speeds."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

import typer

from vibro.cli.console import Console
from vibro.cli.options import (
    CoexistOption,
    Options,
    RegimesOnlyOption,
    refuse_without_flight,
)
from vibro.cli.outputs import MAPS, Outputs
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
from vibro.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from matplotlib.figure import Figure

    from vibro.cli.target_speed import TargetSpeed
    from vibro.plots.view import View
    from vibro.results.sweep import Block, Peak
    from vibro.sweeps.columns import Table
    from vibro.sweeps.grid import Grid
    from vibro.sweeps.request import Request
    from vibro.sweeps.run import DrawnCells


def map_command(
    context: typer.Context,
    options: Options,
    x: Annotated[
        str | None,
        typer.Option("--x", metavar="AXIS", help="Horizontal axis of pictures.", show_default=False),
    ] = None,
    y: Annotated[
        str | None, typer.Option("--y", metavar="AXIS", help="Vertical axis of pictures.", show_default=False)
    ] = None,
    at: Annotated[
        list[str] | None,
        typer.Option(
            "--at",
            metavar="AXIS=X",
            help="Value at which pictures hold an axis; repeatable.",
            show_default=False,
            hidden=True,
        ),
    ] = None,
    show: Annotated[
        list[str] | None,
        typer.Option(
            "--show",
            metavar="|".join(SHOWN),
            help="Draw the impact speed, or the share of time in flight, too; repeatable.",
            show_default=False,
            hidden=True,
        ),
    ] = None,
    speed: Annotated[
        str | None,
        typer.Option(
            "--speed", metavar="X", help="Speed to mark, and to count cells [mm/s].", show_default=False
        ),
    ] = None,
    regimes_only: RegimesOnlyOption = False,
    coexist: CoexistOption = False,
    columns: ColumnsOption = None,
    pitch: PitchOption = None,
    mass: MassOption = None,
    workers: Annotated[
        str | None,
        typer.Option(
            "--workers",
            metavar="N|ADDRESS",
            help="With -o NAME.parquet: number of processes, or the address of a Dask cluster.",
            show_default=False,
            hidden=True,
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

        return map_stored(context, options, x, y, at or [], show or [], speed)
    from vibro.cli.request import question, request_of
    from vibro.quantities import LEAST_SPEED, checked_number
    from vibro.sweeps.request import RANGES

    console = Console(quiet=options.quiet)
    shown = shown_pictures(show or [])
    output = Output.REGIMES if regimes_only else Output.EXACT
    for option, given in ((f"--show {','.join(shown)}", shown), ("--coexist", coexist)):
        if given:
            refuse_without_flight(option, output)
    target_speed = None if speed is None else checked_number(speed, LEAST_SPEED)
    if target_speed is not None and output is not Output.EXACT:
        raise InputError("--speed: no speeds are computed with --regimes-only", hint="leave one of them out")
    part = part_of(pitch, mass)
    request = request_of(options, context.obj, reads_map=True, takes_axes=True, ranges=RANGES)
    question(request, options)
    grid = request.grid(output, flight=output is Output.EXACT, coexistence=coexist)
    console.echo_all(map(str, grid.told_axes.values()))
    table = table_of(grid, columns, throughput_of(part), needed=NEEDS_PART, part=part)
    view, held = view_of(grid, x, y, at or [])
    names = names_of(view, grid, shown)
    name = request.name or "vibro-map"
    outputs = Outputs(
        options, name, context.obj, console, forms=MAPS,
        pictures=names, reads=[options.scene], default=name,
    )  # fmt: skip
    made_by = _workers(workers, outputs)
    sweep = _Map(
        request=request, grid=grid, table=table, view=view, names=names, target_speed=target_speed,
        outputs=outputs, console=console,
    )  # fmt: skip
    if sweep.draws:
        tell_choices(view, grid.told_axes, held, console)
    return sweep.into_folder(options, made_by) if outputs.folder else sweep.into_files(options)


@dataclass(kw_only=True)
class _Map:
    """A sweep that is solved and drawn.

    Attributes
    ----------
    request, grid, table : Request, Grid, Table
        What is solved, and written of it.
    view, names : View, list of str
        What pictures show, and which there are.
    target_speed : float or None
        What ``--speed`` says [mm/s].
    outputs, console : Outputs, Console
        Where to.
    """

    request: Request
    grid: Grid
    table: Table
    view: View
    names: list[str]
    target_speed: float | None
    outputs: Outputs
    console: Console
    cells: DrawnCells | None = None
    target: TargetSpeed | None = None
    moves: bool = False
    bends: int = 0

    @property
    def draws(self) -> bool:
        """Whether any picture is wanted, beside the table or in its workbook."""
        return bool(self.outputs.pictures) or any(form == "xlsx" for _, form in self.outputs.tables.values())

    def look(self, block: Block) -> None:
        """Take from solved cells what is told, or drawn, of them."""
        from vibro.results.operating import bent
        from vibro.results.sweep import at_rest

        self.moves = self.moves or not at_rest(block.cycle).all()
        self.bends += bent(block)
        if self.target:
            self.target.add(block)
        if self.cells:
            self.cells.add(block)

    def draw(self, show: Callable[..., None], peaks: Mapping[str, Peak]) -> dict[str, Figure]:
        """Draw the pictures, from the cells of the table where these are dear; mark its fastest ones."""
        from vibro.plots import map_figures
        from vibro.sweeps.run import solved_picture, sweep_picture

        what = self.grid, self.view.drawn, self.request.own, self.request.name or ""
        if self.cells:
            result = solved_picture(*what, self.names, self.cells.results, peaks)
        else:
            result = sweep_picture(*what, lambda done, size: show(0, f"solving {done / size:.0%}"), peaks)
        return map_figures(
            result,
            self.names,
            x=self.view.x.name,
            y=self.view.y.name if self.view.y else None,
            target_speed=self.target_speed,
            progress=lambda done, size: show(done),
        )

    def into_files(self, options: Options) -> int:
        """Solve the sweep into tables, and tell what came out."""
        from vibro.cli.sweeps import Pictures, write_sweep
        from vibro.cli.target_speed import TargetSpeed
        from vibro.results.operating import BENT_SPEED, WARNED_HARMONIC
        from vibro.sweeps.run import DrawnCells

        if self.target_speed is not None:
            self.target = TargetSpeed(self.grid.told_axes, self.target_speed)
        if self.draws:
            self.cells = DrawnCells.of(self.grid, self.view.drawn)
        pictures = Pictures(self.names, self.draw) if self.draws else None
        code = write_sweep(
            self.grid, self.table, self.outputs, options, self.console, pictures, self.look, self.view
        )
        if self.target:
            self.console.echo(self.target.text())
        if self.bends:
            self.console.warn(
                f"{self.bends} of {self.grid.size} cells: the filling adds a second harmonic above"
                f" {100.0 * WARNED_HARMONIC:g} % of the amplitude; {BENT_SPEED.column} of --columns has the"
                " speed with it"
            )
        if not self.moves:
            self._tell_beginning()
        return code

    def into_folder(self, options: Options, workers: int | str | None) -> int:
        """Solve the sweep into a folder of Parquet files, and tell what came out."""
        from vibro.cli.folders import write_stored
        from vibro.cli.sweeps import Pictures

        if self.target_speed is not None:
            raise InputError("--speed: not told of a folder", hint="vibro map NAME.parquet --speed draws it")
        code, rests = write_stored(
            self.grid, self.table, self.request.name or "", self.request.own, self.outputs, workers, options,
            self.console, Pictures(self.names, self.draw) if self.draws else None,
        )  # fmt: skip
        if rests:
            self._tell_beginning()
        return code

    def _tell_beginning(self) -> None:
        from vibro.results.sweep import where_motion_begins
        from vibro.sweeps.run import limits_of

        grid = self.grid
        self.console.echo(
            where_motion_begins(grid.told_axes, grid.told(grid.fixed), limits_of(grid.values()))
        )


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
