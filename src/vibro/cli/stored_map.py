"""``vibro map DIR``: pictures of a stored sweep, without solving it again."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from vibro.cli.console import Console
from vibro.cli.options import picture_formats
from vibro.cli.views import axis_name, held_axes, shown_pictures, tell_choices
from vibro.core.codes import Output
from vibro.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    import typer
    from matplotlib.figure import Figure

    from vibro.cli.options import Options
    from vibro.sweeps.grid import Grid

__all__ = ["map_stored"]

#: What says which pictures there are to be, and where; all other options are of solving and tables.
_OF_PICTURES: Final = {
    "scene", "output", "json", "force", "quiet", "debug", "version",
    "x", "y", "at", "show", "speed", "formats",
}  # fmt: skip


def map_stored(
    context: typer.Context,
    options: Options,
    x: str | None,
    y: str | None,
    at: list[str],
    show: list[str],
    speed: str | None,
    formats: str,
) -> int:
    """Draw pictures of the cells in a folder that ``vibro map --table parquet`` has written.

    Parameters
    ----------
    context : Context
        Of ``vibro map``.
    options : Options
        The folder in place of a scene file, and where to write.
    x, y, at, show, speed, formats
        As of ``vibro map``.

    Returns
    -------
    int
        The exit code.

    Raises
    ------
    InputError
        If another option is given, or there is no such picture.
    FileError
        If the folder cannot be read, or the files cannot be written.
    """
    from vibro.cli.answer import Pictures, drawn, tell_peaks
    from vibro.cli.stems import output_stem
    from vibro.cli.target_speed import target_in_pictures
    from vibro.output.record import json_text, sweep_record
    from vibro.output.shard_files import open_shards
    from vibro.output.shard_folder import MANIFEST
    from vibro.output.staging import Staging
    from vibro.output.stored import stored_picture
    from vibro.plots import map_figures, picture_names
    from vibro.plots.view import check_drawable, choose_view
    from vibro.quantities import LEAST_SPEED, checked_number

    folder = options.scene
    assert folder is not None
    _refuse_others(context, folder, options.output)
    console = Console(quiet=options.quiet)
    wanted, shown = picture_formats(formats), shown_pictures(show)
    target_speed = None if speed is None else checked_number(speed, LEAST_SPEED)
    shards = open_shards(folder)
    plan, grid = shards.plan, shards.plan.grid
    _refuse_unsolved(grid, folder, shown, speed)
    for axis in grid.told_axes.values():
        console.echo(str(axis))
    axes, held = grid.told_axes, grid.told(held_axes(at, grid.told_axes))
    view = choose_view(axes, x and axis_name(x), y and axis_name(y), held, grid.told(grid.fixed))
    names = picture_names(view, has_length=grid.length is not None, on_request=False) + shown
    if grid.output is not Output.EXACT:
        names = [name for name in names if name == "regime"]
    if not names:
        raise InputError(f"there is no picture of {folder}: it has regimes alone, of one range")
    check_drawable(view)
    tell_choices(view, axes, held, console)

    said = ""

    def draw(show: Callable[..., None]) -> dict[str, Figure]:
        nonlocal said
        result = stored_picture(shards, view.drawn, names)
        if target_speed is not None:
            said = target_in_pictures(result, axes, target_speed)
        y_name = view.y.name if view.y else None
        return map_figures(
            result,
            names,
            x=view.x.name,
            y=y_name,
            target_speed=target_speed,
            progress=lambda done, size: show(done),
        )

    with Staging(
        output_stem(options.output, folder.resolve().name),
        force=options.force,
        tables={},
        pictures=names,
        formats=wanted,
        reads=[folder / MANIFEST],
    ) as files:
        origin = {"folder": str(folder), "fingerprint": plan.fingerprint}
        content = {"sweep": origin, **sweep_record(grid, plan.table, shards.tally.told())}
        with drawn(Pictures(names, wanted, draw), console) as figures:
            record = files.finish(context.obj, content, figures)
    console.echo_all(files.told)
    tell_peaks(shards.tally, grid, console)
    if said:
        console.echo(said)
    if options.json:
        print(json_text(record))
    return 0


def _refuse_others(context: typer.Context, folder: Path, output: str | None) -> None:
    """Refuse options about solving cells, or about their table."""
    typed = [
        parameter.opts[0]
        for parameter in context.command.params
        if parameter.name not in _OF_PICTURES
        and getattr(context.get_parameter_source(parameter.name or ""), "name", "") == "COMMANDLINE"
    ]
    typed += ["-o -"] if output == "-" else []
    if typed:
        hint = f"leave {'it' if len(typed) == 1 else 'them'} out, or give a scene file"
        raise InputError(
            *(f"{option}: the cells of {folder} are solved already" for option in typed), hint=hint
        )


def _refuse_unsolved(grid: Grid, folder: Path, shown: list[str], speed: str | None) -> None:
    """Refuse pictures of what the cells were not solved for."""
    if shown and not grid.flight:
        raise InputError(
            f"--show {','.join(shown)}: {folder} was solved without flights", hint="leave it out"
        )
    if speed is not None and grid.output is not Output.EXACT:
        raise InputError(f"--speed: {folder} was solved for regimes alone", hint="leave it out")
