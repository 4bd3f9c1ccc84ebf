"""``vibro design``: which settings of which drive guarantee a speed for all parts."""

from __future__ import annotations

from enum import StrEnum
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vibro.cli.console import Console
from vibro.cli.exit_codes import ExitCode
from vibro.cli.options import Options
from vibro.errors import InputError

if TYPE_CHECKING:
    from pathlib import Path

    from matplotlib.figure import Figure

    from vibro.files.csv_tables import TableColumns
    from vibro.inverse.designs import Chosen
    from vibro.inverse.specs import Spec
    from vibro.results.designs import DesignResult

__all__ = ["design_command", "design_record"]


class Only(StrEnum):
    """Which regimes are answered."""

    GOAL = "goal"


OnlyOption = Annotated[
    Only | None,
    typer.Option(
        "--only", help="Leave out the designs of other regimes than the goal's.", show_default=False
    ),
]
DigitsOption = Annotated[
    str | None,
    typer.Option(
        "--digits",
        metavar="1...15",
        help="Significant digits of settings [default: 4]; those that do not hold so have more.",
        show_default=False,
    ),
]


def design_command(
    context: typer.Context,
    options: Options,
    only: OnlyOption = None,
    digits: DigitsOption = None,
) -> int:
    """Find drive settings that convey every part at least at a required speed, for all its frictions.

    The design file gives what is known of the parts and the trough as bands lo:hi, the range and drift of
    each drive, and the goal. Drives move along a line, an ellipse or in a given motion. For every drive three
    designs within the goal's highest regime are printed: the gentlest (least acceleration) that meets the
    goal, the fastest, and the safest; then those within other regimes. -o writes them too,
    with pictures of one of them. If no drive meets the goal, the closest designs are printed
    and the exit code is 4.
    """
    from vibro.cli.design_report import design_report
    from vibro.cli.outputs import Outputs
    from vibro.cli.request import whole_number
    from vibro.inverse.designs import checked_digits, chosen_of, find_designs
    from vibro.inverse.reading import read_spec
    from vibro.inverse.rounding import DIGITS
    from vibro.plots.design import DESIGN_PICTURES
    from vibro.tables.record import json_text

    console = Console(quiet=options.quiet)
    count = DIGITS if digits is None else checked_digits("--digits", whole_number("--digits", digits))
    source = options.scene
    if source is None:
        raise InputError("missing: a design file", hint="for example: vibro design design.toml")
    spec = read_spec(source)
    for doubt in spec.doubts():
        console.warn(doubt)
    name = f"{spec.name}-design"
    with Outputs(options, name, context.obj, console, pictures=DESIGN_PICTURES, reads=[source]) as output:
        with console.progress("searching", None) as report:
            result = find_designs(
                spec,
                lambda done, total, what: report(done, what, total),
                digits=count,
                goal_only=only is Only.GOAL,
            )
            chosen = chosen_of(spec, result)

        def draw() -> dict[str, Figure]:
            with console.progress("drawing", None):
                return _figures(spec, chosen)

        output.write(
            lambda: {"": _columns(result)},
            draw,
            design_record(source, result) if options.output else {},
        )
    if not output.takes_stdout:
        print(json_text(result.to_dict()) if options.json else design_report(spec, result, chosen))
    return ExitCode.DONE if result.met else ExitCode.NOT_MET


def _columns(result: DesignResult) -> TableColumns:
    """Return the table: texts as they are, missing numbers as NaN."""
    import numpy as np

    columns: dict[str, Any] = {}
    for column in result.columns:
        values = [getattr(design, column.name) for design in result.designs]
        texts = any(isinstance(value, str) for value in values)
        columns[column.name] = [v or "" for v in values] if texts else np.array(values, np.float64)
    return columns


def _figures(spec: Spec, chosen: Chosen | None) -> dict[str, Figure]:
    """Draw the pictures of the chosen design; none if nothing is guaranteed anywhere."""
    if chosen is None:
        return {}
    from vibro.inverse.pictured import setting_fields, speed_band
    from vibro.plots.design import design_figures

    return design_figures(spec, chosen, setting_fields(spec, chosen), speed_band(spec, chosen))


def design_record(source: Path, result: DesignResult) -> dict[str, Any]:
    """Return the content of the sidecar: the question as it was given, and its answer."""
    from vibro.files.toml_files import read_toml

    units = {column.name: column.unit for column in result.columns}
    return {"spec": read_toml(source), **result.to_dict(), "columns": units}
