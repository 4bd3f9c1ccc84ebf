"""Small HTML tables, by which notebooks show what a call returns; they take over the page's colours."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.reals import shielded

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence


# Notebooks align cells to the right and colour every second row; text of results is read from the left.
_CELL: Final = "text-align: left; vertical-align: top; padding: 0.15em 0.8em 0.15em 0"
_HEAD: Final = f"{_CELL}; font-weight: bold"
_NAME: Final = f"{_HEAD}; white-space: nowrap"
_CAPTION: Final = "text-align: left; font-weight: bold; color: inherit; white-space: nowrap"
_LISTED: Final = 6  # texts, of many


class Shown:
    """What notebooks show as one table; subclasses give its caption, its rows and, optionally, its head."""

    def _table(self) -> tuple[str, Iterable[Sequence[str]], Sequence[str]]:
        raise NotImplementedError

    @shielded
    def _repr_html_(self) -> str:
        """Return a table for notebooks, in the units of tables."""
        return html_table(*self._table())


def html_table(caption: str, rows: Iterable[Sequence[str]], head: Sequence[str] = ()) -> str:
    """Return a table whose first column heads its rows.

    Parameters
    ----------
    caption : str
        What it shows.
    rows : iterable of sequence of str
        Plain texts; rows whose cells after the first are all empty are left out.
    head : sequence of str, optional
        Of the columns.
    """
    from html import escape

    lines = [f'<table style="color: inherit"><caption style="{_CAPTION}">{escape(caption)}</caption>']
    if head:
        cells = "".join(f'<th scope="col" style="{_HEAD}">{escape(text)}</th>' for text in head)
        lines.append(f"<thead><tr>{cells}</tr></thead>")
    lines.append("<tbody>")
    for first, *rest in rows:
        if any(rest):
            # A single cell beside several columns is as wide as these.
            wide = f' colspan="{len(head) - 1}"' if len(rest) < len(head) - 1 else ""
            cells = "".join(f'<td{wide} style="{_CELL}">{escape(text)}</td>' for text in rest)
            lines.append(f'<tr><th scope="row" style="{_NAME}">{escape(first)}</th>{cells}</tr>')
    return "\n".join([*lines, "</tbody></table>"])


def amount(value: float, unit: str = "") -> str:
    """Write a number with its unit, in six digits."""
    return f"{value:z.6g} {unit}".rstrip()


def span(values: Any, unit: str = "") -> str:
    """Summarise numbers: one of them, or the least and the largest, and how many are none."""
    numbers = np.asarray(values, np.float64)
    known = numbers[np.isfinite(numbers)]
    if not numbers.ndim:
        return amount(float(numbers), unit) if known.size else "none"
    ends = "none"
    if known.size:
        low, high = float(known.min()), float(known.max())
        ends = amount(low, unit) if low == high else f"{amount(low)} ... {amount(high, unit)}"
    missing = numbers.size - known.size
    return f"{ends} ({missing} of {numbers.size} without)" if missing and known.size else ends


def counts(codes: Any, texts: Mapping[int, str]) -> str:
    """Summarise codes: the text of one, or how often each occurs, the most frequent first."""
    found = np.asarray(codes)
    different, number = np.unique(found, return_counts=True)
    order = np.argsort(-number, kind="stable")
    names = [texts.get(int(code), str(code)) for code in different[order]]
    if not found.ndim:
        return names[0] or "none"
    return in_numbers(zip(names, number[order].tolist(), strict=True))


def in_numbers(counted: Iterable[tuple[str, int]]) -> str:
    """List texts with the number of each, as far as there is any; of many the first."""
    listed = [f"{text or 'none'}: {n}" for text, n in counted if n]
    more = len(listed) - _LISTED
    return ", ".join(listed if more <= 0 else [*listed[:_LISTED], f"{more} more"]) or "none"
