"""The options about tables that several commands share: columns, and parts in a row."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Final

from vibro.cli.options import rare
from vibro.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from vibro.results.sweep import Column
    from vibro.sweeps.columns import Table
    from vibro.sweeps.grid import Grid

ColumnsOption = Annotated[
    str | None,
    rare(
        "columns",
        "Columns of the table, in this order, such as amplitude_mm,regime; further ones are stroke_mm,"
        " restitution, acceleration_g, speed_amplitude_exponent and strokes.",
        "NAMES",
    ),
]
PitchOption = Annotated[
    str | None, rare("pitch", "Distance from one part to the next [mm], to tell parts per minute.", "LENGTH")
]
MassOption = Annotated[
    str | None, rare("mass", "Mass of a part [kg]; with --pitch, to tell kg per hour.", "MASS")
]
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


def table_of(
    grid: Grid,
    columns: str | None,
    extra: Sequence[Column] = (),
    *,
    needed: Mapping[str, str],
    part: Mapping[str, float] = MappingProxyType({}),
) -> Table:
    """Choose what a table holds.

    Parameters
    ----------
    grid : Grid
        What is solved.
    columns : str or None
        The names of columns, as typed; None for the usual ones.
    extra : sequence of Column
        Further columns among the usual ones.
    needed : mapping of str to str
        Columns that are there with options alone, and an example of these.
    part : mapping of str to float, optional
        What is known of the part, for the sidecar.

    Raises
    ------
    InputError
        If there is no such column, one is named twice, or one needs an option that is not there.
    """
    from vibro.sweeps.columns import Table, chosen, table_columns

    usual = table_columns(grid, extra=extra)
    if columns is not None:
        names = [name.strip() for name in columns.split(",")]
        there = {column.name for column in usual}
        missing = {name: option for name, option in needed.items() if name not in there}
        missing |= {} if grid.length is not None else _NEEDS_LENGTH
        for name in names:
            if name in missing:
                raise InputError(
                    f"column {name}: an option that it needs is missing", hint=f"add {missing[name]}"
                )
        usual = chosen(names, usual)
    return Table(usual, part)
