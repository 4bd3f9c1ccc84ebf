"""``vibro accuracy``: what speed costs in accuracy, and the other way round, measured on this machine."""

from __future__ import annotations

from dataclasses import asdict, replace
from typing import TYPE_CHECKING, Annotated, Final

from vibro.cli.exit_codes import ExitCode
from vibro.cli.options import AllOption, Options, option, rare  # typer reads the annotations
from vibro.errors import InputError
from vibro.quantities import LINEAR, POSITIVE, Quantity, checked_number

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.figure import Figure

    from vibro.accuracy.trade import Row, Trade
    from vibro.cli.console import Console
    from vibro.files.csv_tables import TableColumns
    from vibro.sweeps.grid import Grid
    from vibro.sweeps.request import Request

# Default ranges, those of the paper: its drive angles are below 45 deg, its scenes within these.
_SAMPLE: Final = {
    "amplitude": "0.1:3:log",
    "frequency": "5:60:log",
    "drive_angle": "2:45",
    "static_friction": "0.1:1",
    "friction_ratio": "0.4:1",
}
_AROUND_A_SCENE: Final = {name: _SAMPLE[name] for name in ("amplitude", "frequency")}
_LINE_ALONE: Final = (
    "vibro accuracy runs methods for a drive along a line alone",
    "give -A and -a in place of along=, normal= and phase=",
)
_VALUES: Final = 1001  # of a range that leaves it open
_SCENES: Final = 5000
_MOST_SCENES: Final = 10_000_000


def accuracy_command(
    options: Options,
    scenes: Annotated[
        str, option("scenes", "Scenes to sample [default: 5000]; slow methods run on the first of them.", "N")
    ] = str(_SCENES),
    tolerance: Annotated[
        str, rare("tolerance", "Tolerated error in mean speed [A f] [default: 0.001].", "E")
    ] = "0.001",
    every: AllOption = False,
) -> int:
    """Run several methods on the same scenes: time a scene against error in mean speed.

    Scenes are drawn evenly from axes, in the syntax of vibro map; those that hop are left out. Without
    any, from A 0.1:3 mm, f 5:60 Hz (both log), drive angle 2:45 deg, mu_s 0.1:1 and mu_d/mu_s 0.4:1.
    Errors are against a walk from event to event, in arbitrary precision if mpmath is installed (pip
    install '.[accuracy]' in the project's folder), else in double precision. -o writes the table and its
    picture.
    """
    from vibro.answers.accuracy import trade_answer
    from vibro.cli.forms import HISTORIES
    from vibro.cli.outputs import Outputs
    from vibro.cli.request import whole_number
    from vibro.cli.sweeps import count

    number = whole_number("--scenes", scenes, range(1, _MOST_SCENES + 1))
    limit = checked_number(tolerance, Quantity("--tolerance", allowed=POSITIVE))
    request = _request(options)
    name = f"{request.name or 'vibro'}-accuracy"
    with Outputs(options, name, forms=HISTORIES) as output:
        grid = _grid(request, options.console)
        trade = _run(grid, number, limit, options.console)
        answer = trade_answer(trade, grid.describe())

        def draw() -> dict[str, Figure]:
            from vibro.plots.trade import trade_figure

            return {"": trade_figure(trade)}

        output.write_answer(answer, lambda: {"": _columns(trade.rows)}, draw)
    if trade.scenes < number:
        options.console.warn(f"only {count(trade.scenes)} of {count(trade.drawn)} scenes stay in contact")
    output.print_answer(answer, every=every)
    return ExitCode.DONE


def _request(options: Options) -> Request:
    """Merge options, scene file and the default ranges of the sample."""
    from vibro.cli.request import request_of

    if options.scene is None and not options.given:
        options = replace(options, given=_SAMPLE)
    request = request_of(
        options,
        varies=True,
        reads_map=True,
        takes_axes=True,
        ranges=_AROUND_A_SCENE,
        without_machine="the methods that are compared know amplitudes alone",
    )
    if request.drive != LINEAR:
        raise InputError(_LINE_ALONE[0], hint=_LINE_ALONE[1])
    return request


def _grid(request: Request, console: Console) -> Grid:
    from vibro.sweeps.grid import Grid

    grid = Grid(request.axes(_VALUES), request.fixed, None, in_stroke=request.in_stroke)
    console.echo_all(map(str, grid.given_axes.values()))
    return grid


def _run(grid: Grid, scenes: int, tolerance: float, console: Console) -> Trade:
    from vibro.accuracy.methods import METHODS
    from vibro.accuracy.trade import run_methods, runs

    with console.progress("scenes", 2 * scenes + sum(runs(METHODS, scenes))) as report:
        trade = run_methods(grid, scenes, tolerance=tolerance, report=report)
    if not trade.scenes:
        raise InputError(
            "no scene stays in contact", hint="lower the amplitude, the frequency or the drive angle"
        )
    return trade


def _columns(rows: Sequence[Row]) -> TableColumns:
    """Return the columns of the table, with their units in their names."""
    from vibro.files.csv_tables import columns_of

    def header(name: str) -> str:
        return f"{name}_af" if name.startswith(("error", "drift")) else name

    return columns_of([{header(name): value for name, value in asdict(row).items()} for row in rows])
