"""``vibro friction``: what sources say about friction and restitution of a pair of materials."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from vibro.cli.exit_codes import ExitCode
from vibro.cli.options import (
    DebugOption,
    HelpAllOption,
    JsonOption,
    VersionOption,
)  # typer reads the annotations

if TYPE_CHECKING:
    from collections.abc import Sequence

    from vibro.friction import Row

_HEADINGS: Final = ("pair", "condition", "mu_s", "mu_d", "e", "impact", "source")
_UNITS: Final = ("", "", "", "", "", "[m/s]", "")


def friction_command(
    pair: Annotated[
        list[str] | None,
        typer.Argument(metavar="PAIR", help="Words of the pair, such as steel.", show_default=False),
    ] = None,
    json: JsonOption = False,
    debug: DebugOption = False,
    version: VersionOption = False,
    help_all: HelpAllOption = False,
) -> int:
    """List coefficients of friction and restitution by pair of materials, with their sources.

    mu_s and mu_d are static and kinetic friction, e is restitution, measured at the impact speeds beside it.
    A band lo:hi is as wide as its source prints it. Sources that contradict each other stay side by side.
    In a question of vibro design a row is named static_friction = "steel on steel, dry, Lust".
    """
    from vibro.friction import find
    from vibro.tables.record import json_text

    found = find(" ".join(pair or ()))
    if json:
        print(json_text({"rows": [_content(row) for row in found]}))
    else:
        _print_table(found)
    return ExitCode.DONE


def _content(row: Row) -> dict[str, Any]:
    content: dict[str, Any] = {"pair": row.pair, "condition": row.condition}
    for name in ("static_friction", "kinetic_friction", "restitution", "impact_speed"):
        low, high = getattr(row, name) or (None, None)
        unit = "_m_s" if name == "impact_speed" else ""
        content |= {f"{name}_low{unit}": low, f"{name}_high{unit}": high}
    return content | {"source": row.source, "url": row.url or None, "note": row.note or None}


def _print_table(found: Sequence[Row]) -> None:
    """Print the rows, and below them the notes on each source."""
    from vibro.answers.answer import aligned
    from vibro.friction import band_text

    cells = [
        (
            row.pair,
            row.condition,
            *map(band_text, (row.static_friction, row.kinetic_friction, row.restitution, row.impact_speed)),
            row.source,
        )
        for row in found
    ]
    print(aligned([_HEADINGS, _UNITS, *cells], right=False))
    for source in dict.fromkeys(row.source for row in found):
        rows = [row for row in found if row.source == source]
        print(f"\n{source}")
        for url in dict.fromkeys(row.url for row in rows if row.url):
            print(f"  {url}")
        for row in rows:
            if row.note:
                print(f"  {row.pair}, {row.condition}: {row.note}")
