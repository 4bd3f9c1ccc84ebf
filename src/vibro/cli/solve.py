"""``vibro solve``: one scene's report."""

from __future__ import annotations

from typing import TYPE_CHECKING

import typer  # typer reads the annotations

from vibro.cli.options import Accuracy, AccuracyOption, Flight, FlightOption, Options

if TYPE_CHECKING:
    from vibro.cli.report import OneScene

__all__ = ["solve_command"]


def solve_command(
    context: typer.Context,
    options: Options,
    flight: FlightOption = Flight.ON,
    accuracy: AccuracyOption = Accuracy.EXACT,
) -> int:
    """Report one scene: its regime, speed, where the next regimes begin, and the phases of its cycle.

    With -o the row of a map's table is written to STEM.csv too.
    """
    from vibro.cli.output import answer_one, make_grid
    from vibro.cli.request import gather
    from vibro.sweeps.columns import COLUMNS

    request = gather(options, context.obj)
    grid = make_grid(request, accuracy=accuracy, flight=flight)
    return answer_one(grid, COLUMNS, options, context.obj, request.name or "vibro-solve", _report)


def _report(scene: OneScene) -> str:
    from vibro.cli.report import aligned, number

    facts = [
        *scene.facts(),
        *scene.numbers(),
        ("acceleration", f"{number(scene.load)} g along the drive"),
    ]
    heads = [("begins", "load now / then", "amplitude [mm]", "frequency [Hz]")]
    begins = [(t.name, *(number(value) for value in t[1:])) for t in scene.transitions()]
    parts = [aligned(facts, right=False), aligned([*heads, *begins])]
    phases = [(p[0], *(f"{value:.5f}" for value in p[1:])) for p in scene.phases()]
    if phases:
        parts.append(aligned([("phase", "start [ms]", "end [ms]", "displacement [mm]"), *phases]))
    return "\n\n".join(parts)
