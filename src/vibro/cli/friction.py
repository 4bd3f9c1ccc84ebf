"""``vibro friction``: what sources say about the friction of a pair of materials."""

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

_HEADINGS: Final = ("pair", "condition", "mu_s", "mu_d", "source")


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
    """List coefficients of friction by pair of materials, with their sources.

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
    for name, band in (("static_friction", row.static_friction), ("kinetic_friction", row.kinetic_friction)):
        low, high = band or (None, None)
        content |= {f"{name}_low": low, f"{name}_high": high}
    return content | {"source": row.source, "url": row.url or None, "note": row.note or None}


def _print_table(found: Sequence[Row]) -> None:
    """Print the rows, and below them the notes on each source."""
    from vibro.answers.answer import aligned
    from vibro.friction import band_text

    cells = [
        (row.pair, row.condition, band_text(row.static_friction), band_text(row.kinetic_friction), row.source)
        for row in found
    ]
    print(aligned([_HEADINGS, *cells], right=False))
    for source in dict.fromkeys(row.source for row in found):
        rows = [row for row in found if row.source == source]
        print(f"\n{source}")
        for url in dict.fromkeys(row.url for row in rows if row.url):
            print(f"  {url}")
        for row in rows:
            if row.note:
                print(f"  {row.pair}, {row.condition}: {row.note}")
