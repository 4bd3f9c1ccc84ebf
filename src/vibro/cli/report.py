"""Layout of the commands' reports."""

from __future__ import annotations

import shutil
import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

__all__ = ["aligned", "line_width", "stacked"]


def aligned(rows: Iterable[Sequence[str]], *, right: bool = True) -> str:
    """Return rows as lines with their cells below each other, all but the first to the right if wanted."""
    rows = list(rows)
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = []
    for first, *rest in rows:
        cells = [cell.rjust(w) if right else cell.ljust(w) for cell, w in zip(rest, widths[1:], strict=True)]
        lines.append("  ".join([first.ljust(widths[0]), *cells]).rstrip())
    return "\n".join(lines)


def line_width() -> int | None:
    """Return how many characters a line of stdout may have; None if it is not a terminal."""
    return shutil.get_terminal_size().columns if sys.stdout.isatty() else None


def stacked(rows: Sequence[Sequence[str]], *, heads: int, width: int | None) -> str:
    """Return rows as ``aligned`` does, in parts below each other where lines would be too long.

    Parameters
    ----------
    rows : sequence of sequence of str
        All of the same length.
    heads : int
        Number of first columns, which every part repeats.
    width : int or None
        Of a line, in characters; None where lines may be as long as they are.

    Returns
    -------
    str
        No cell is cut: a part of a single column is as wide as that is.
    """
    parts: list[list[int]] = [[]]
    for place in range(heads, len(rows[0])):
        longer = _columns(rows, heads, [*parts[-1], place])
        if parts[-1] and width is not None and max(map(len, longer.splitlines())) > width:
            parts.append([])
        parts[-1].append(place)
    return "\n\n".join(_columns(rows, heads, part) for part in parts)


def _columns(rows: Sequence[Sequence[str]], heads: int, places: Sequence[int]) -> str:
    return aligned([*row[:heads], *(row[place] for place in places)] for row in rows)
