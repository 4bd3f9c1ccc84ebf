"""The options about tables that several commands share: columns, and parts in a row."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Final

import typer

from vibro.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from vibro.cli.options import Options
    from vibro.results.sweep import Column
    from vibro.sweeps.columns import Table

ColumnsOption = Annotated[
    str | None,
    typer.Option(
        "--columns",
        metavar="NAMES",
        help="Columns of the table, in this order, such as amplitude_mm,regime; further ones are stroke_mm,"
        " restitution, acceleration_g, speed_amplitude_exponent and strokes.",
        show_default=False,
    ),
]
PitchOption = Annotated[
    str | None,
    typer.Option(
        "--pitch",
        metavar="LENGTH",
        help="Distance from one part to the next [mm], to print parts per minute: an upper bound, as parts"
        " in a row do not push each other in this model.",
        show_default=False,
    ),
]
MassOption = Annotated[
    str | None,
    typer.Option(
        "--mass", metavar="MASS", help="Mass of a part [kg]; with --pitch, to print kg per hour.",
        show_default=False,
    ),
]  # fmt: skip
#: Columns that follow from the part's pitch and mass, and what gives these.
NEEDS_PART: Final = {"parts_per_min": "--pitch 25mm", "mass_flow_kg_h": "--pitch 25mm --mass 12g"}
#: Columns that are empty without a trough length.
_NEEDS_LENGTH: Final = dict.fromkeys(("trough_length_mm", "traverse_time_s", "strokes"), "-L 600mm")


def part_of(pitch: str | None, mass: str | None) -> dict[str, float]:
    """Read the pitch of parts in a row and the mass of one, if given, by their names with units."""
    from vibro.quantities import MASS, PITCH, checked_number

    if mass is not None and pitch is None:
        raise InputError(
            "--mass: kg an hour need the distance from part to part too", hint="add --pitch 25mm"
        )
    return {
        quantity.column: checked_number(text, quantity)
        for quantity, text in ((PITCH, pitch), (MASS, mass))
        if text is not None
    }


def throughput_of(part: Mapping[str, float]) -> tuple[Column, ...]:
    """Return the columns that follow from what ``part_of`` has read."""
    from vibro.sweeps.derived import throughput

    return throughput(part["pitch_mm"], part.get("mass_kg")) if "pitch_mm" in part else ()


def table_of(
    usual: Sequence[Column],
    columns: str | None,
    *,
    needed: Mapping[str, str],
    has_length: bool,
    part: Mapping[str, float] | None = None,
) -> Table:
    """Choose what a table holds.

    Parameters
    ----------
    usual : sequence of Column
        Its columns by default.
    columns : str or None
        The names of columns, as typed.
    needed : mapping of str to str
        Columns that are there with options alone, and an example of these.
    has_length : bool
        Whether the trough has a length.
    part : mapping of str to float, optional
        What is known of the part, for the sidecar.

    Raises
    ------
    InputError
        If there is no such column, one is named twice, or one needs an option that is not there.
    """
    from vibro.sweeps.columns import Table, chosen

    if columns is not None:
        names = [name.strip() for name in columns.split(",")]
        there = {column.name for column in usual}
        missing = {name: option for name, option in needed.items() if name not in there}
        missing |= {} if has_length else _NEEDS_LENGTH
        for name in names:
            if name in missing:
                raise InputError(
                    f"column {name}: an option that it needs is missing", hint=f"add {missing[name]}"
                )
        usual = chosen(names, usual)
    return Table(usual, part or {})


def refuse_without_table(options: Options, columns: str | None) -> None:
    """Refuse to choose columns where a report is printed."""
    if not options.output and not options.json and columns is not None:
        raise InputError("--columns: the report is no table", hint="add --json, -o - or -o NAME.csv")
