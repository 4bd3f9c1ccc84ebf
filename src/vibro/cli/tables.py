"""The options about tables that several commands share: columns and digits."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from vibro.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from vibro.cli.options import Options
    from vibro.results.sweep import Column
    from vibro.sweeps.columns import Table

__all__ = [
    "ColumnsOption",
    "DigitsOption",
    "refuse_without_table",
    "table_of",
]

ColumnsOption = Annotated[
    str | None,
    typer.Option(
        "--columns",
        metavar="NAMES",
        help="Columns of the table, in this order, such as amplitude_mm,regime; there are also stroke_mm,"
        " restitution, acceleration_g, speed_amplitude_exponent and strokes.",
        show_default=False,
    ),
]
DigitsOption = Annotated[
    int | None,
    typer.Option(
        "--digits",
        metavar="1...17",
        help="Significant digits of the table's numbers; without, they are exact.",
        show_default=False,
    ),
]


def table_of(
    usual: Sequence[Column],
    columns: str | None,
    digits: int | None,
    *,
    needed: Mapping[str, str],
    part: Mapping[str, float] | None = None,
) -> Table:
    """Choose what a table holds.

    Parameters
    ----------
    usual : sequence of Column
        What it holds where nothing is asked for.
    columns : str or None
        The names asked for, as typed.
    digits : int or None
        Significant digits; None for exact numbers.
    needed : mapping of str to str
        Columns that are there with options alone, and an example of these.
    part : mapping of str to float, optional
        What is known of the part, for the sidecar.

    Raises
    ------
    InputError
        If there is no such column, one is named twice, one needs an option that is not there, or there are no
        doubles of so many digits.
    """
    from vibro.files.rounding import MOST_DIGITS
    from vibro.sweeps.columns import Table, chosen

    if digits is not None and not 1 <= digits <= MOST_DIGITS:
        raise InputError(
            f"--digits {digits}: must be from 1 to {MOST_DIGITS}", hint="without it numbers are exact"
        )
    if columns is not None:
        names = [name.strip() for name in columns.split(",")]
        there = {column.name for column in usual}
        for name in names:
            if name in needed and name not in there:
                raise InputError(
                    f"column {name}: an option that it needs is missing", hint=f"add {needed[name]}"
                )
        usual = chosen(names, usual)
    return Table(usual, digits, part or {})


def refuse_without_table(options: Options, columns: str | None, digits: int | None) -> None:
    """Refuse options about a table where a report is printed."""
    if options.output is None and not options.json:
        for option, value in (("--columns", columns), ("--digits", digits)):
            if value is not None:
                raise InputError(f"{option}: the report is no table", hint="add --json, -o - or -o STEM")
