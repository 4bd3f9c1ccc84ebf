"""``vibro map FOLDER.parquet``: pictures of a stored sweep, without solving it again."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from vibro.cli.exit_codes import ExitCode
from vibro.cli.views import held_axes, shown_pictures, tell_choices
from vibro.core.codes import Output
from vibro.errors import InputError
from vibro.quantities import QUANTITIES

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from vibro.cli.options import Options
    from vibro.sweeps.grid import Grid

_OTHERWISE: Final = "leave {} out, or give a scene file"


def map_stored(
    options: Options,
    x: str | None,
    y: str | None,
    at: list[str],
    show: list[str],
    speed: str | None,
    *,
    unused: Sequence[str],
) -> int:
    """Draw pictures of the cells in a folder that ``vibro map -o FOLDER.parquet`` has written.

    Parameters
    ----------
    options : Options
        The folder in place of a scene file, and where to write.
    x, y, at, show, speed
        As of ``vibro map``.
    unused : sequence of str
        Options that were typed, and are about solving cells or their table.

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
    from vibro.cli.outputs import Outputs
    from vibro.cli.sweeps import Pictures, drawn, tell_peaks
    from vibro.quantities import LEAST_SPEED, checked_number
    from vibro.results.drawing import PICTURES
    from vibro.sweeps.solved import pictures_of, view_of
    from vibro.tables.plan import MANIFEST
    from vibro.tables.record import sweep_record
    from vibro.tables.shard_files import open_shards
    from vibro.tables.stored import stored_picture

    (folder,) = options.files
    console = options.console
    if unused := [*unused, *(QUANTITIES[name].label for name in options.given)]:
        hint = _OTHERWISE.format("it" if len(unused) == 1 else "them")
        problems = (f"{option}: the cells of {folder} are solved already" for option in unused)
        raise InputError(*problems, hint=hint)
    shown = shown_pictures(show)
    target_speed = None if speed is None else checked_number(speed, LEAST_SPEED)
    shards = open_shards(folder)
    plan, grid, tally = shards.plan, shards.plan.grid, shards.summary.tally
    _refuse_unsolved(grid, folder, shown, speed)
    console.echo_all(map(str, grid.given_axes.values()))
    view, held = view_of(grid, x, y, held_axes(at), "--at")
    names = pictures_of(grid, view, on_request=False) + shown
    if not names:
        raise InputError(f"there is no picture of {folder}: it has regimes alone, of one range")
    tell_choices(view, grid.given_axes, held, console)
    name = folder.resolve().stem
    if "-" in (options.output or []):
        raise InputError(f"-o -: the cells of {folder} are solved already", hint=_OTHERWISE.format("it"))
    outputs = Outputs(
        options, name, forms=("json", *PICTURES), pictures=names, reads=[folder / MANIFEST], default=name
    )

    pictures = Pictures(
        names, view, target_speed, lambda peaks, _: stored_picture(shards, view.drawn, names, peaks)
    )
    with outputs:
        origin = {"folder": str(folder), "fingerprint": plan.fingerprint}
        content = {"sweep": origin, **sweep_record(grid, plan.table, tally.record())}
        with drawn(pictures, console, tally) as figures:
            outputs.finish(content, figures)
    tell_peaks(tally, grid, console)
    outputs.print_record()
    return ExitCode.DONE


def _refuse_unsolved(grid: Grid, folder: Path, shown: list[str], speed: str | None) -> None:
    """Refuse pictures of what the cells were not solved for."""
    if shown and not grid.flight:
        raise InputError(
            f"--show {','.join(shown)}: {folder} was solved without flights", hint="leave it out"
        )
    if speed is not None and grid.output is not Output.EXACT:
        raise InputError(f"--speed: {folder} was solved for regimes alone", hint="leave it out")
