"""``vibro simulate``: one scene's exact motion in time."""

from __future__ import annotations

import json
import math
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from vibro.cli.console import Console
from vibro.cli.options import Options, picture_formats
from vibro.errors import InputError, shown

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from vibro.files.tables import TableColumns
    from vibro.results.history import History
    from vibro.sweeps.request import Request

__all__ = ["simulate_command"]

_CYCLES: Final = 3.0
_SAMPLES: Final = 200  # a cycle
_MOST_ROWS: Final = 5_000_000
_ROWS_OF_A_SHEET: Final = 1_048_576
_PRINTED: Final = 24  # phases
_DRAWN: Final = 6.0  # cycles


def simulate_command(
    context: typer.Context,
    options: Options,
    cycles: Annotated[
        float | None,
        typer.Option(
            "--cycles", metavar="N", help="Drive cycles to follow; 3 if not given.", show_default=False
        ),
    ] = None,
    duration: Annotated[
        str | None,
        typer.Option(
            "--duration", metavar="TIME", help="Time to follow, instead of cycles [s].", show_default=False
        ),
    ] = None,
    start_phase: Annotated[
        str, typer.Option("--start-phase", metavar="ANGLE", help="Phase of the trough at the start [deg].")
    ] = "0",
    start_velocity: Annotated[
        str,
        typer.Option(
            "--start-velocity", metavar="SPEED", help="Of the body along the trough at the start [mm/s]."
        ),
    ] = "0",
    samples: Annotated[
        int, typer.Option("--samples-per-cycle", metavar="N", help="Rows a cycle, beside one at every event.")
    ] = _SAMPLES,
    panels: Annotated[
        str | None,
        typer.Option(
            "--panels",
            metavar="NAMES",
            help="Of trough,forces,acceleration,velocity,position,gap.",
            show_default=False,
        ),
    ] = None,
    formats: Annotated[
        str, typer.Option("--format", metavar="png,svg,pdf", help="The picture's formats.")
    ] = "png",
) -> int:
    """Follow a body from its first moment on: phases, motion and forces, exact at any time.

    The phases are printed. With -o they go to STEM-phases.csv too, the sampled motion to STEM.csv, forces per
    unit mass, and its picture to STEM.png.
    """
    from vibro.cli.request import request_of
    from vibro.cli.series import SeriesOutput, scene_record
    from vibro.motion.histories import simulate
    from vibro.plots.history import choose_panels
    from vibro.quantities import DURATION, START_PHASE, START_VELOCITY, exact_number

    console = Console(quiet=options.quiet)
    wanted = picture_formats(formats)
    choose_panels(panels, flies=True)
    request = request_of(options, context.obj)
    scene = request.scene()
    frequency = float(scene.frequency)
    time = None if duration is None else float(exact_number(duration, DURATION))
    lasting = _cycles(cycles, time, frequency)
    _check_rows(lasting, samples, console)
    phase = float(exact_number(start_phase, START_PHASE))
    velocity = float(exact_number(start_velocity, START_VELOCITY))
    content = {
        "scene": scene_record(request),
        "cycles": lasting,
        START_PHASE.column: phase,
        START_VELOCITY.column: velocity,
        "samples_per_cycle": samples,
    }
    with SeriesOutput(
        f"{request.name or 'vibro'}-history",
        ("", "phases"),
        formats=wanted,
        options=options,
        argv=context.obj,
        console=console,
        reads=[options.scene],
    ) as output:
        history = simulate(
            scene, cycles=lasting, start_phase=math.radians(phase), start_velocity=velocity / 1e3
        )
        output.write(
            lambda: _tables(history, samples),
            lambda: {"": _figure(history, samples, panels, request, console)},
            content,
        )
    if output.takes_stdout:
        return 0
    if options.json:
        print(json.dumps({**content, "phases": _records(history)}, indent=2, allow_nan=False))
    else:
        print(_text(history))
    return 0


def _tables(history: History, samples: int) -> dict[str, TableColumns]:
    from vibro.motion.trace import motion_table, phase_table, trace

    rows = trace(history, until=history.end, samples_per_cycle=samples)
    return {"": motion_table(history, rows), "phases": phase_table(history, history.phases)}


def _figure(history: History, samples: int, panels: str | None, request: Request, console: Console) -> Figure:
    """Draw the first cycles of a history."""
    from vibro.motion.trace import trace
    from vibro.plots.history import choose_panels, history_figure

    frequency = float(history.scene.frequency)
    until = min(history.end, _DRAWN / frequency)
    if until < history.end:
        console.echo(f"the picture shows the first {_DRAWN:g} of {history.end * frequency:g} cycles")
    phases = [p for p in history.phases if p.start < until]
    seen = choose_panels(panels, flies=any(p.kind == "H" for p in phases))
    rows = trace(history, until=until, samples_per_cycle=max(samples, _SAMPLES), both_sides=True)
    given = {name: spec.value for name, spec in request.specs.items() if name != "trough_length"}
    return history_figure(phases, rows, seen, request.name or "Motion", given)


def _cycles(cycles: float | None, duration: float | None, frequency: float) -> float:
    if cycles is not None and duration is not None:
        raise InputError("--cycles and --duration are both given", hint="give one of them")
    for name, value, unit in (("cycles", cycles, ""), ("duration", duration, " s")):
        if value is not None and not (math.isfinite(value) and value > 0.0):
            raise InputError(f"--{name} {value:g}: must be finite and > 0{unit}")
    return duration * frequency if duration is not None else cycles or _CYCLES


def _check_rows(cycles: float, samples: int, console: Console) -> None:
    if not 0 <= samples <= _MOST_ROWS:
        raise InputError(
            f"--samples-per-cycle {shown(samples)}: must be in [0, {_MOST_ROWS}]",
            hint="0 gives the events alone",
        )
    rows = cycles * max(samples, 4)
    if rows > _MOST_ROWS:
        raise InputError(
            f"{cycles:g} cycles of {samples} rows are more than {_MOST_ROWS:.0e} rows",
            hint="ask for fewer cycles, or fewer --samples-per-cycle",
        )
    if rows > _ROWS_OF_A_SHEET:
        console.warn(f"{rows:.3g} rows are more than the {_ROWS_OF_A_SHEET} of a spreadsheet")


def _records(history: History) -> list[dict[str, Any]]:
    """Return the phases, one a record, as their table has them."""
    import numpy as np

    from vibro.motion.trace import phase_table

    columns = phase_table(history, history.phases)
    rows = zip(*(c.tolist() if isinstance(c, np.ndarray) else c for c in columns.values()), strict=True)
    return [dict(zip(columns, row, strict=True)) for row in rows]


def _text(history: History) -> str:
    """Return the phases as lines, and what becomes of the body."""
    import numpy as np

    from vibro.cli.report import aligned
    from vibro.motion.trace import phase_table
    from vibro.steady import solve

    phases = history.phases
    columns = phase_table(history, phases[:_PRINTED])
    head = ("phase", "start [ms]", "end [ms]", "from [mm]", "to [mm]", "from [mm/s]", "to [mm/s]")
    numbers = zip(
        *(1e3 * np.asarray(columns[name]) for name in ("start_s", "end_s")),
        *(
            np.asarray(columns[f"{end}_{what}"])
            for what in ("position_mm", "velocity_mm_s")
            for end in ("start", "end")
        ),
        strict=True,
    )
    rows = [
        (name, *(f"{value:.5f}" for value in row))
        for name, row in zip(columns["phase"], numbers, strict=True)
    ]
    lines = [aligned([head, *rows])]
    if len(phases) > _PRINTED:
        lines.append(f"... {len(phases) - _PRINTED} more phases")
    lines.append("")
    end = 1e3 * phases[-1].end_position
    lines.append(f"after {history.end:.6g} s: {end:.6g} mm along the trough")
    if math.isfinite(history.settles_at):
        steady, pattern = str(solve(history.scene).pattern), history.pattern
        if len(steady) == len(pattern) and pattern in 2 * steady:
            pattern = steady  # the same cycle from another phase on
        lines.append(
            f"from {1e3 * history.settles_at:.6g} ms on the phases {pattern} repeat:"
            f" {1e3 * history.cycle_displacement:.6g} mm a cycle"
        )
    elif len(phases) == 1 and phases[0].kind == "_":
        lines.append("the body rests")
    else:
        lines.append("the motion has not begun to repeat yet")
    return "\n".join(lines)
