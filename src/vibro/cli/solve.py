"""``vibro solve``: one scene's report."""

from __future__ import annotations

from typing import TYPE_CHECKING

import typer  # typer reads the annotations

from vibro.cli.options import (
    CoexistOption,
    Flight,
    FlightOption,
    LevelOption,
    Options,
    refuse_without_flight,
)
from vibro.core.codes import Level

if TYPE_CHECKING:
    from vibro.cli.report import OneScene

__all__ = ["solve_command"]


def solve_command(
    context: typer.Context,
    options: Options,
    flight: FlightOption = Flight.ON,
    accuracy: LevelOption = Level.EXACT,
    coexist: CoexistOption = False,
) -> int:
    """Report one scene: its regime, speed, where the next regimes begin, and the phases of its cycle.

    With -o the row of a map's table is written to STEM.csv too.
    """
    from vibro.cli.output import answer_one, make_grid
    from vibro.cli.request import request_of
    from vibro.sweeps.columns import columns_of

    if coexist:
        refuse_without_flight("--coexist", flight, accuracy)
    request = request_of(options, context.obj)
    grid = make_grid(request, level=accuracy, flight=flight, coexistence=coexist)
    return answer_one(grid, columns_of(), options, context.obj, request.name or "vibro-solve", _report)


def _report(one: OneScene) -> str:
    from vibro.cli.report import aligned, number
    from vibro.core.codes import PHASE_NAMES
    from vibro.quantities import LENGTH

    facts = [
        *one.facts(),
        *one.numbers(),
        ("acceleration", f"{number(float(one.scene.load))} g along the drive"),
    ]
    heads = [("begins", "load now / then", "amplitude [mm]", "frequency [Hz]")]
    begins = [
        (t.name, number(t.ratio), number(LENGTH.from_si(t.amplitude)), number(t.frequency))
        for t in one.transitions()
    ]
    parts = [aligned(facts, right=False), aligned([*heads, *begins])]
    phases = [
        (
            PHASE_NAMES[p.kind],
            f"{1e3 * p.start:.5f}",
            f"{1e3 * p.end:.5f}",
            f"{LENGTH.from_si(p.displacement):.5f}",
        )
        for p in one.phases()
    ]
    if phases:
        parts.append(aligned([("phase", "start [ms]", "end [ms]", "displacement [mm]"), *phases]))
    return "\n\n".join(parts)
