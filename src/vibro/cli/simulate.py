"""``vibro simulate``: one scene's exact motion in time."""

from __future__ import annotations

import json
import math
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from vibro.cli.console import Console
from vibro.cli.exit_codes import ExitCode
from vibro.cli.options import Options
from vibro.errors import InputError, cut, shown

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.figure import Figure

    from vibro.files.csv_tables import TableColumns
    from vibro.results.history import History
    from vibro.sweeps.request import Request

__all__ = ["simulate_command"]

_CYCLES: Final = 3.0
_SAMPLES: Final = 200  # a cycle
_MOST_ROWS: Final = 5_000_000
_ROWS_OF_A_SHEET: Final = 1_048_576
_PRINTED: Final = 24  # phases
_DRAWN: Final = 6.0  # cycles at the end of a history, drawn by default
_MOST_DRAWN: Final = 100.0  # cycles of a picture: of more nobody sees one
_ROUNDING: Final = 1e-12  # share of a history by which its end, as typed, may lie behind it
_FOLLOWED: Final = 1000.0  # cycles within which the motion is expected to repeat


def simulate_command(
    context: typer.Context,
    options: Options,
    cycles: Annotated[
        str | None,
        typer.Option(
            "--cycles", metavar="N", help="Number of drive cycles; 3 if not given.", show_default=False
        ),
    ] = None,
    duration: Annotated[
        str | None,
        typer.Option(
            "--duration", metavar="TIME", help="Duration, instead of cycles [s].", show_default=False
        ),
    ] = None,
    start_phase: Annotated[
        str, typer.Option("--start-phase", metavar="ANGLE", help="Phase of the trough at the start [deg].")
    ] = "0",
    start_velocity: Annotated[
        str,
        typer.Option(
            "--start-velocity",
            metavar="SPEED",
            help="Velocity of the body at the start, along the trough and relative to it [mm/s].",
        ),
    ] = "0",
    start_height: Annotated[
        str,
        typer.Option(
            "--start-height", metavar="LENGTH", help="Height of the body above the trough at the start [mm]."
        ),
    ] = "0",
    start_normal_velocity: Annotated[
        str,
        typer.Option(
            "--start-normal-velocity",
            metavar="SPEED",
            help="Velocity of the body at the start, away from the trough and relative to it [mm/s]; a"
            " negative one is an impact. The trough itself moves at the start, except at --start-phase 90.",
        ),
    ] = "0",
    samples: Annotated[
        str, typer.Option("--samples-per-cycle", metavar="N", help="Rows a cycle; each event has one more.")
    ] = str(_SAMPLES),
    panels: Annotated[
        str | None,
        typer.Option(
            "--panels",
            metavar="NAMES",
            help="Panels of the picture, from trough,forces,acceleration,velocity,position,gap.",
            show_default=False,
        ),
    ] = None,
    begin: Annotated[
        str | None,
        typer.Option(
            "--from",
            metavar="TIME",
            help="Time at which the picture begins [s]; by default it shows the last 6 cycles.",
            show_default=False,
        ),
    ] = None,
    end: Annotated[
        str | None,
        typer.Option("--to", metavar="TIME", help="Time at which the picture ends [s].", show_default=False),
    ] = None,
    every: Annotated[
        bool,
        typer.Option("--all", help="Print all phases and every bounce, not only the first 24 rows."),
    ] = False,
) -> int:
    """Simulate the motion of one body: phases, motion and forces, exact at any time.

    The first 24 phases are printed; bounces that die out count as one. With -o all phases go to
    NAME-phases.csv, the motion and the forces per unit mass to NAME.csv, and their picture to NAME.png.
    """
    from vibro.cli.outputs import Outputs, scene_record
    from vibro.cli.request import plain_number, question, request_of, warn_of_machine, whole_number
    from vibro.motion.histories import simulate
    from vibro.plots.history import choose_panels
    from vibro.quantities import (
        DURATION,
        LENGTH,
        SPEED,
        START_HEIGHT,
        START_NORMAL_VELOCITY,
        START_PHASE,
        START_VELOCITY,
        exact_number,
    )

    console = Console(quiet=options.quiet)
    choose_panels(panels, flies=True)
    request = request_of(options, context.obj)
    question(request, options)
    scene = request.scene()
    if request.machine is not None:
        warn_of_machine(request, console)
    frequency = float(scene.frequency)
    time = None if duration is None else float(exact_number(duration, DURATION))
    number = None if cycles is None else plain_number("--cycles", cycles)
    rows = whole_number("--samples-per-cycle", samples)
    lasting = _cycles(number, time, frequency)
    _check_rows(lasting, rows, console)
    window = _window(begin, end, lasting, frequency)
    phase = float(exact_number(start_phase, START_PHASE))
    velocity = float(exact_number(start_velocity, START_VELOCITY))
    height = float(exact_number(start_height, START_HEIGHT))
    rate = float(exact_number(start_normal_velocity, START_NORMAL_VELOCITY))
    content = {
        "scene": scene_record(request),
        "cycles": lasting,
        START_PHASE.column: phase,
        START_VELOCITY.column: velocity,
        START_HEIGHT.column: height,
        START_NORMAL_VELOCITY.column: rate,
        "samples_per_cycle": rows,
    }
    name, tables = f"{request.name or 'vibro'}-history", ("", "phases")
    with Outputs(options, name, context.obj, console, tables=tables, reads=[options.scene]) as output:
        follow = partial(
            simulate,
            scene,
            start_phase=math.radians(phase),
            start_velocity=SPEED.to_si(velocity),
            start_height=LENGTH.to_si(height),
            start_normal_velocity=SPEED.to_si(rate),
        )
        history = follow(cycles=lasting)
        output.write(
            lambda: _tables(history, rows),
            lambda: {"": _figure(history, window, rows, panels, request, console)},
            content,
        )
    if output.takes_stdout:
        return ExitCode.DONE
    if options.json:
        print(json.dumps({**content, "phases": _records(history)}, indent=2, allow_nan=False))
    else:
        print(_text(history, follow, every=every))
    return ExitCode.DONE


def _tables(history: History, samples: int) -> dict[str, TableColumns]:
    from vibro.motion.trace import motion_table, trace
    from vibro.results.phase_tables import phase_table

    rows = trace(history, until=history.end, samples_per_cycle=samples)
    return {"": motion_table(history, rows), "phases": phase_table(history, history.phases)}


def _window(begin: str | None, end: str | None, cycles: float, frequency: float) -> tuple[float, float]:
    """Return when the picture begins and ends [s]."""
    from vibro.quantities import TIME, Quantity, exact_number

    last = cycles / frequency
    if begin is None and end is None:
        return max(0.0, last - _DRAWN / frequency), last
    since = 0.0 if begin is None else float(exact_number(begin, Quantity("from", TIME)))
    until = last if end is None else float(exact_number(end, Quantity("to", TIME)))
    given = " ".join(
        f"{name} {cut(text)}" for name, text in (("--from", begin), ("--to", end)) if text is not None
    )
    if not 0.0 <= since < until <= last * (1.0 + _ROUNDING):
        raise InputError(f"{given}: must ascend within the history, 0 to {last:.6g} s")
    if (until - since) * frequency > _MOST_DRAWN:
        raise InputError(
            f"{given}: {(until - since) * frequency:.6g} drive cycles are too many for a picture",
            hint=f"draw at most {_MOST_DRAWN:g} of them: {_MOST_DRAWN / frequency:.4g} s",
        )
    return since, min(until, last)


def _figure(
    history: History,
    window: tuple[float, float],
    samples: int,
    panels: str | None,
    request: Request,
    console: Console,
) -> Figure:
    """Draw a part of a history."""
    from vibro.motion.trace import trace
    from vibro.plots.history import choose_panels, history_figure

    since, until = window
    part = _part(since, until, history)
    if part:
        console.echo(f"the picture shows {part}")
    phases = [p for p in history.phases if p.end > since and p.start < until]
    seen = choose_panels(panels, flies=any(p.kind == "H" for p in phases))
    rows = trace(history, since=since, until=until, samples_per_cycle=max(samples, _SAMPLES), both_sides=True)
    period = 1.0 / float(history.scene.frequency)
    return history_figure(phases, rows, seen, request.name or "Motion", request.told, part, period=period)


def _part(since: float, until: float, history: History) -> str:
    """Say which part of a history is drawn; an empty text for all of it."""
    frequency = float(history.scene.frequency)
    first, last, whole = (f"{time * frequency:.4g}" for time in (since, until, history.end))
    if until < history.end:
        return f"from {first} to {last} of {whole} drive cycles"
    return f"the last {(until - since) * frequency:.4g} of {whole} drive cycles" if since else ""


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

    from vibro.results.phase_tables import phase_table

    columns = phase_table(history, history.phases)
    rows = zip(*(c.tolist() if isinstance(c, np.ndarray) else c for c in columns.values()), strict=True)
    return [dict(zip(columns, row, strict=True)) for row in rows]


def _text(history: History, follow: Callable[..., History], *, every: bool) -> str:
    """Return the phases as lines, and what becomes of the body; ``follow`` makes a longer history."""
    import numpy as np

    from vibro.cli.report import aligned
    from vibro.core.codes import PHASE_NAMES
    from vibro.results.phase_tables import phase_table, with_chains
    from vibro.sweeps.one_scene import bounce_text

    phases = history.phases
    if every:
        told = [(PHASE_NAMES[phase.kind], phase) for phase in phases]
    else:
        told = with_chains(phases, 1.0 / float(history.scene.frequency))
    more, told = (0, told) if every else (len(told) - _PRINTED, told[:_PRINTED])
    columns = phase_table(history, [phase for _, phase in told])
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
    rows = [(name, *(f"{value:.5f}" for value in row)) for (name, _), row in zip(told, numbers, strict=True)]
    lines = [aligned([head, *rows])]
    if more > 0:
        lines.append(f"... {more} more phases: --all prints them")
    lines.append("")
    end = 1e3 * phases[-1].end_position
    lines.append(f"after {history.end:.6g} s: {end:.6g} mm along the trough")
    if any(phase.kind == "H" for phase in phases):
        lines.append(f"restitution {bounce_text(float(history.scene.restitution))}")
    lines.append(_outlook(history, follow))
    return "\n".join(lines)


def _outlook(history: History, follow: Callable[..., History]) -> str:
    """Say from when on the motion repeats or rests; if it does not yet, how many cycles would show it."""
    from vibro.core.codes import Regime, Status
    from vibro.steady import solve

    steady = solve(history.scene)
    frequency = float(history.scene.frequency)
    if math.isfinite(history.settles_at):
        again, pattern = str(steady.pattern), history.pattern
        if len(again) == len(pattern) and pattern in 2 * again:
            pattern = again  # the same cycle from another phase on
        return (
            f"from {1e3 * history.settles_at:.6g} ms on the phases {pattern} repeat:"
            f" {1e3 * history.cycle_displacement:.6g} mm a cycle"
        )
    stays = steady.regime == Regime.NO_SLIP  # where it has come to rest
    last = history.phases[-1]
    if stays and last.kind == "_":
        return f"from {1e3 * last.start:.6g} ms on the body rests" if last.start else "the body rests"
    said = f"the motion has not {'ended' if stays else 'begun to repeat'} yet"
    if steady.status not in (Status.OK, Status.BOUNDARY):
        why, *_ = Status(int(steady.status)).message.split(":")
        return f"{said}: {why}"
    longer = follow(cycles=_FOLLOWED)
    needed = longer.settles_at * frequency + longer.period_cycles
    if stays and longer.phases[-1].kind == "_":
        needed = longer.phases[-1].start * frequency
    if not needed < _FOLLOWED:
        return f"{said}, and does not within {_FOLLOWED:g} drive cycles"
    return f"{said}: --cycles {math.floor(needed) + 1} would do"
