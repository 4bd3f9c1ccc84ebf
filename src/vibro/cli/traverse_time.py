"""``vibro traverse-time``: how long a body takes over the trough's length."""

from __future__ import annotations

import math
from functools import partial
from typing import TYPE_CHECKING, Annotated

import typer

from vibro.cli.options import Options  # typer reads the annotations
from vibro.cli.table_options import ColumnsOption, refuse_without_table, table_of
from vibro.errors import InputError

if TYPE_CHECKING:
    from vibro.sweeps.grid import Grid
    from vibro.sweeps.one_scene import OneScene

__all__ = ["traverse_time_command"]


def traverse_time_command(
    context: typer.Context,
    options: Options,
    sweep: Annotated[bool, typer.Option("--sweep", help="Sweep the axes of the scene file's [map].")] = False,
    exact: Annotated[
        bool,
        typer.Option(
            "--exact",
            help="In a sweep, add the column arrival_time_s: the exact time from rest. It takes about 20 us a"
            " cell in contact and 1 ms a cell that hops, a hundred times the rest.",
        ),
    ] = False,
    columns: ColumnsOption = None,
) -> int:
    """Compute the time over the trough's length, or say why the body never arrives.

    For one scene it prints the time at the mean speed and the exact time from rest at trough phase 0. With
    axes, in the syntax of vibro map, or with --sweep it prints a table, or writes it with -o.
    """
    from vibro.cli.answer import answer_one, answer_sweep, make_grid
    from vibro.cli.console import Console
    from vibro.cli.request import question, request_of
    from vibro.quantities import QUANTITIES
    from vibro.sweeps.columns import columns_of
    from vibro.sweeps.derived import WITH_ARRIVAL, WITH_STROKES

    request = request_of(options, context.obj, reads_map=sweep, takes_axes=True, needs_length=True)
    question(request, options)
    name = f"{request.name}-traverse-time" if request.name else "vibro-traverse-time"
    if sweep and not request.varying:
        example = QUANTITIES[request.drive[0]].typed("0.1:3:200")
        raise InputError("nothing varies", hint=f"give an axis, for example {example}")
    follows = exact or not request.varying
    extra = (WITH_ARRIVAL, WITH_STROKES) if follows else (WITH_STROKES,)
    console = Console(quiet=options.quiet)
    grid = make_grid(request, console, arrivals=follows)
    usual = columns_of(
        grid.axes, *extra, drive=grid.drive, made_with=grid.made_with, machine=grid.machine is not None
    )
    table = table_of(usual, columns, needed={WITH_ARRIVAL.name: "--exact"}, has_length=True)
    if not request.varying:
        refuse_without_table(options, columns)
        return answer_one(grid, table, options, context.obj, name, partial(_report, grid=grid))
    return answer_sweep(grid, table, options, context.obj, console, name)


def _report(scene: OneScene, grid: Grid) -> str:
    from vibro.cli.report import aligned
    from vibro.sweeps.one_scene import estimate, machine_lines, number

    steady = scene.traverse_time
    if steady is None:
        answer, strokes = scene.why_never(), []
    else:
        error, frequency = steady * scene.relative_error, scene.given["frequency"]
        answer = f"{estimate(steady, error, 's')} over {number(scene.length, 'mm')}"
        strokes = [("strokes", estimate(steady * frequency, error * frequency))]
    rows = [
        ("traverse time", answer),
        *_exactly(scene, steady),
        *machine_lines(scene, grid),
        *scene.facts(),
        *strokes,
    ]
    return aligned(rows, right=False)


def _exactly(scene: OneScene, steady: float | None) -> list[tuple[str, str]]:
    """Say when a body arrives that starts from rest, and why that is not length over mean speed."""
    from vibro.sweeps.one_scene import number

    time, frequency = scene.arrival_time, scene.given["frequency"]
    if not math.isfinite(time):
        # without a time at the mean speed the row above has said why
        return [] if steady is None else [("exactly", f"unknown: {_why_not(scene)}")]
    rows = [("exactly", f"{number(time, 's')} from rest at trough phase 0")]
    if steady is None:
        why = "the body gets so far before it settles; its steady motion would not take it there"
        if scene.runs:
            why = f"the body never settles: it gains speed every cycle, {scene.runs}"
            if scene.scene.trough_angle > 0.0:
                why = f"the body gets so far before it turns and runs {scene.runs}"
        if scene.relative_error:
            why = "the body gets so far on its way; its mean speed would not take it there"
        return [*rows, ("why", why)]
    apart = (time - steady) * frequency
    text = f"{number(abs(apart))} drive cycles {'later' if apart > 0 else 'earlier'} than at the mean speed"
    why = "the start from rest, and an arrival within a cycle, whose speed is not the mean"
    if scene.relative_error:
        why = "the motion is irregular, and over this length its speed is not the mean"
    return [*rows, ("why", f"{text}: {why}")]


def _why_not(scene: OneScene) -> str:
    """Say why nobody knows when a body arrives whose mean speed is known."""
    if scene.hops:
        bodies = "; a body may differ from the mean by more than its error" if scene.relative_error else ""
        return f"flights amplify rounding, which grows past 1e-9 rad before the body arrives{bodies}"
    return "the body needs too many slides to settle"
