"""``vibro traverse-time``: how long a body takes over the trough's length."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from vibro.cli.options import Flight, FlightOption, Options  # typer reads the annotations
from vibro.errors import InputError

if TYPE_CHECKING:
    from vibro.cli.report import OneScene

__all__ = ["traverse_time_command"]


def traverse_time_command(
    context: typer.Context,
    options: Options,
    sweep: Annotated[bool, typer.Option("--sweep", help="Sweep the axes of the scene file's [map].")] = False,
    flight: FlightOption = Flight.ON,
) -> int:
    """Tell how long a body takes over the trough's length at its mean speed, and why if it never arrives.

    With axes, in the syntax of vibro map, or with --sweep the answers go to STEM.csv and STEM.json.
    """
    from vibro.cli.console import Console
    from vibro.cli.output import answer_one, make_grid, write_sweep
    from vibro.cli.request import gather
    from vibro.tables import STROKES, columns_with

    request = gather(options, context.obj, reads_map=sweep, takes_axes=True, needs_length=True)
    columns = columns_with(STROKES)
    name = f"{request.name}-traverse-time" if request.name else "vibro-traverse-time"
    if sweep and not request.varying:
        raise InputError("nothing varies", hint="give an axis, for example -A 0.1:3:200")
    if not request.varying:
        grid = make_grid(request, flight=flight)
        return answer_one(grid, columns, options, context.obj, name, _report)
    console = Console(quiet=options.quiet)
    grid = make_grid(request, console, flight=flight)
    return write_sweep(grid, columns, options, context.obj, console, name)


def _report(scene: OneScene) -> str:
    from vibro.cli.report import aligned, number

    time = scene.traverse_time
    if time is None:
        return aligned([("traverse time", scene.why_never()), *scene.facts()], right=False)
    strokes = number(time * scene.given["frequency"])
    answer = ("traverse time", f"{number(time, 's')} over {number(scene.length, 'mm')}")
    return aligned([answer, *scene.facts(), ("strokes", strokes)], right=False)
