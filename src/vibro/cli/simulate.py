"""``vibro simulate``: one scene's exact motion in time."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Final

from vibro.cli.exit_codes import ExitCode
from vibro.cli.options import Options, option, rare
from vibro.errors import InputError, cut
from vibro.quantities import START_HEIGHT, START_NORMAL_VELOCITY, START_PHASE, START_VELOCITY

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from vibro.cli.console import Console
    from vibro.files.csv_tables import TableColumns
    from vibro.results.history import History
    from vibro.sweeps.request import Request

_CYCLES: Final = 3.0
_SAMPLES: Final = 200  # a cycle
_MOST_ROWS: Final = 5_000_000
_EVENTS: Final = 4  # of a cycle, which have rows of their own
#: Quantities of the body at the start.
STARTS: Final = (START_PHASE, START_VELOCITY, START_HEIGHT, START_NORMAL_VELOCITY)


def simulate_command(
    options: Options,
    cycles: Annotated[str | None, option("cycles", "Number of drive cycles [default: 3].", "N")] = None,
    duration: Annotated[str | None, rare("duration", "Duration, in place of cycles [s].", "TIME")] = None,
    samples: Annotated[
        str, rare("samples-per-cycle", "Rows a cycle [default: 200]; an event has one more.", "N")
    ] = str(_SAMPLES),
    begin: Annotated[
        str | None,
        rare("from", "Time at which the picture begins [s]; by default it shows the last 6 cycles.", "TIME"),
    ] = None,
    end: Annotated[str | None, rare("to", "Time at which the picture ends [s].", "TIME")] = None,
    panels: Annotated[
        str | None,
        rare(
            "panels", "Panels of the picture, from trough,forces,acceleration,velocity,position,gap.", "NAMES"
        ),
    ] = None,
    every: Annotated[bool, option("all", "Print all phases and every bounce.")] = False,
) -> int:
    """Simulate the motion of one body: phases, motion and forces, exact at any time.

    The first 24 phases are printed; bounces that die out count as one. With -o all phases go to
    NAME-phases.csv, the motion and the forces per unit mass to NAME.csv, and their picture to NAME.png.
    The body is at rest on the trough at first; start_height=2mm or start_velocity=50 change that.
    """
    from vibro.answers.history import history_answer
    from vibro.answers.scene import scene_record
    from vibro.cli.forms import HISTORIES
    from vibro.cli.outputs import Outputs
    from vibro.cli.request import request_of, warn_of_machine, whole_number
    from vibro.motion.histories import simulate
    from vibro.quantities import CYCLES, DURATION, checked_number

    if panels is not None:  # before anything is computed
        from vibro.plots.history import choose_panels

        choose_panels(panels, flies=True)
    request = request_of(options)
    scene = request.scene()
    warn_of_machine(request.grid(), options.console)
    frequency = float(scene.frequency)
    if cycles is not None and duration is not None:
        raise InputError("--cycles and --duration are both given", hint="leave one of them out")
    lasting = _CYCLES if cycles is None else checked_number(cycles, CYCLES)
    if duration is not None:
        lasting = checked_number(duration, DURATION) * frequency
    rows = whole_number("--samples-per-cycle", samples, range(_MOST_ROWS + 1))
    if lasting * max(rows, _EVENTS) > _MOST_ROWS:
        raise InputError(
            f"{lasting:g} cycles of {rows} rows are more than {_MOST_ROWS:.0e} rows",
            hint="ask for fewer cycles, or fewer --samples-per-cycle",
        )
    window = _window(begin, end, lasting, frequency)
    start = [checked_number(options.own.get(q.name, "0"), q) for q in STARTS]
    content = {
        "scene": scene_record(request),
        "cycles": lasting,
        **{q.column: value for q, value in zip(STARTS, start, strict=True)},
        "samples_per_cycle": rows,
    }
    name, tables = f"{request.name or 'vibro'}-history", ("", "phases")
    with Outputs(options, name, forms=HISTORIES, tables=tables) as output:
        in_si = {q.name: float(q.to_si(value)) for q, value in zip(STARTS, start, strict=True)}
        history = simulate(scene, cycles=lasting, **in_si)
        output.write(
            lambda: _tables(history, rows),
            lambda: {"": _figure(history, window, rows, panels, request, options.console)},
            content,
        )
    output.print_answer(history_answer(history, content, every=every))
    return ExitCode.DONE


def _tables(history: History, samples: int) -> dict[str, TableColumns]:
    from vibro.motion.histories import motion_table, trace
    from vibro.results.history import phase_table

    rows = trace(history, until=history.end, samples_per_cycle=samples)
    return {"": motion_table(history, rows), "phases": phase_table(history, history.phases)}


def _window(begin: str | None, end: str | None, cycles: float, frequency: float) -> tuple[float, float]:
    """Return when the picture begins and ends [s]."""
    from vibro.answers.drawing import drawn_window
    from vibro.quantities import Quantity, exact_number
    from vibro.units import TIME

    typed = {"from": begin, "to": end}
    since, until = (
        None if text is None else float(exact_number(text, Quantity(name, TIME)))
        for name, text in typed.items()
    )
    given = " ".join(f"--{name} {cut(text)}" for name, text in typed.items() if text)
    return drawn_window(since, until, cycles / frequency, frequency, given)


def _figure(
    history: History,
    window: tuple[float, float],
    samples: int,
    panels: str | None,
    request: Request,
    console: Console,
) -> Figure:
    """Draw a part of a history."""
    from vibro.answers.drawing import drawn_part, history_picture

    if part := drawn_part(*window, history):
        console.echo(f"the picture shows {part}")
    title = request.name or "Motion"
    return history_picture(history, window, title, request.given_values, panels, samples=samples)
