"""Measured records: CSV files with any column names, units, separators and decimals."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vibro.errors import InputError, cut, shown
from vibro.files.reading import read_text, rows_of
from vibro.records.folding import Floats
from vibro.records.headers import Columns, Header, Wanted, columns_of
from vibro.records.signals import DERIVATIVES, SIGNALS, TROUGH, Sensitivity
from vibro.records.tolerances import TOL

Flags = NDArray[np.bool_]

# Possessive quantifiers: the time for a cell is proportional to its length.
_NUMBER: Final = re.compile(r"[+-]?+(?:[0-9]++[.,]?+[0-9]*+|[.,][0-9]++)(?:[eE][+-]?+[0-9]++)?+")
# What programs write instead of a number: without a value, and after an error.
_NO_VALUE: Final = re.compile(r"[+-]?nan|#?n/?a|null|none|[-?*]+", re.IGNORECASE)
_WRONG: Final = re.compile(r"[+-]?inf(inity)?|error|overflow|#.*", re.IGNORECASE)
_SEPARATORS: Final = {";": "semicolon", "\t": "tab", ",": "comma"}
_DELETE: Final = "delete those rows, or keep the part before or after them"


@dataclass(frozen=True, eq=False)
class Record:
    """Signals over time, in SI units.

    Attributes
    ----------
    time : float array
        Strictly ascending [s].
    signals : mapping of str to float array
        Relative displacement [m], velocity [m/s], acceleration [m/s^2] and friction [N] at these times, by
        their names in ``SIGNALS``.
    trough : mapping of str to float array
        Motions of the trough [m/s^2, m/s or m] at these times, by their names in ``TROUGH``.
    headers : mapping of str to str
        The columns' headers in the file, by the same names and ``"time"``.
    sensitivities : mapping of str to str
        Sensitivities of the columns that are voltages, as typed, by the same names.
    trough_kinds : mapping of str to str
        What each motion of the trough is, a key of ``DERIVATIVES``; without one an acceleration.
    notes : tuple of str
        How the file was read, for the user.
    """

    time: Floats
    signals: Mapping[str, Floats]
    trough: Mapping[str, Floats]
    headers: Mapping[str, str]
    sensitivities: Mapping[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    trough_kinds: Mapping[str, str] = field(default_factory=dict)

    @property
    def trough_derivatives(self) -> dict[str, int]:
        """Derivatives over time from each motion of the trough, as recorded, to its acceleration."""
        return {name: DERIVATIVES[self.trough_kinds.get(name, "acceleration")] for name in self.trough}


class _Table(NamedTuple):
    """A parsed file: the rows of data, each with its number in the file, and as wide as the header row."""

    path: Path
    rows: list[tuple[int, list[str]]]
    decimal_comma: bool
    separator: str

    def numbers(self, header: Header, unit: float) -> Floats:
        """Read a column in SI units; NaN for cells without a value."""
        values = np.full(len(self.rows), np.nan)
        bad = np.zeros(values.size, np.bool_)
        for i, (_, cells) in enumerate(self.rows):
            cell = cells[header.place]
            if _NUMBER.fullmatch(cell) and ("," in cell) <= self.decimal_comma:
                values[i] = float(cell.replace(",", ".")) * unit
                bad[i] = not abs(values[i]) <= TOL.largest
            else:
                bad[i] = bool(cell) and not _NO_VALUE.fullmatch(cell)
        if bad.any():
            raise InputError(*self.named(header, bad, values, TOL.largest / abs(unit)), hint=_DELETE)
        return values

    def named(self, header: Header, bad: Flags, values: Floats, most: float = math.nan) -> list[str]:
        """Describe the first bad cells of a column, and count the others; one with a value is too large."""
        problems, places, column = [], np.flatnonzero(bad).tolist(), f"column {shown(header.text)}"
        for i in places[: TOL.cells_named]:
            row, cell = self.rows[i][0], self.rows[i][1][header.place]
            what = f"{shown(cell)} is not a number" if cell else "the cell is empty"
            if not math.isnan(values[i]):
                what = f"{cut(cell)} is too large to compute with, at most {most:g} is allowed"
            problems.append(f"{self.path}: row {row}, {column}: {what}")
        if (more := len(places) - TOL.cells_named) > 0:
            problems.append(f"{self.path}: {column}: {more} more such cell{'s' if more > 1 else ''}")
        return problems


def read_record(
    path: Path,
    columns: Mapping[str, str] | None = None,
    sensitivities: Sequence[Sensitivity] = (),
    *,
    body: bool = True,
) -> Record:
    """Read a record from a text file of columns.

    Parameters
    ----------
    path : Path
        CSV with a header row; separated by commas, semicolons or tabs, with decimal points or commas,
        in UTF-8 (with or without a byte order mark), UTF-16 or a Windows code page.
    columns : mapping of str to str, optional
        Headers by ``"time"`` and the names of ``SIGNALS`` and ``TROUGH``. The unit of the header, in
        brackets, may be left out; if the file has none, the one given here is used. If no signal of the body
        is named, every column whose unit is unambiguous is read.
    sensitivities : sequence of Sensitivity
        Sensitivities of the sensors whose voltages the file holds.
    body : bool
        Whether a signal of the body is needed; else a motion of the trough is.

    Returns
    -------
    Record
        The columns in SI units, without the few rows in which a cell of them holds no value.

    Raises
    ------
    FileError
        If the file cannot be read.
    InputError
        If a column is missing, ambiguous or without a unit; if a cell is no number, or too many are empty; if
        the time has gaps, repeats or goes back. Row and column are named.
    """
    text, notes = read_text(path)
    table, chosen = _take_apart(path, text, Wanted(columns or {}, sensitivities, body))
    if table.separator != "," or table.decimal_comma:
        decimals = ", decimal commas" if table.decimal_comma else ""
        notes.append(f"{path.name}: separated by {_SEPARATORS[table.separator]}s{decimals}")
    values = {role: table.numbers(column.header, column.size) for role, column in chosen.items()}
    if not values.keys().isdisjoint(TROUGH):  # a part that nobody named is not worth a record of the trough
        unnamed = [role for role in values if role in SIGNALS and role not in (columns or {})]
        for role in unnamed:
            if np.isnan(values[role]).mean() > TOL.skipped:
                notes.append(
                    f"{role}: column {shown(chosen.pop(role).header.text)} lacks values: it is left out"
                )
                del values[role]
    kept = _with_values(table, {chosen[role].header: column for role, column in values.items()})
    values = {role: column[kept] for role, column in values.items()}
    _check_time(table, chosen["time"].header, values["time"], np.flatnonzero(kept))
    if not kept.all():
        rows = [table.rows[i][0] for i in np.flatnonzero(~kept)]
        more = f" and {len(rows) - TOL.cells_named} more" if len(rows) > TOL.cells_named else ""
        named = f"row{'s' if len(rows) > 1 else ''} {', '.join(map(str, rows[: TOL.cells_named]))}{more}"
        lack = "lack a value and are" if len(rows) > 1 else "lacks a value and is"
        notes.append(f"{path.name}: {len(rows)} of {kept.size} rows {lack} skipped: {named}")
    texts = {role: column.sensitivity.text for role, column in chosen.items() if column.sensitivity}
    headers = {role: column.header.text for role, column in chosen.items()}
    for role, header in headers.items():
        at = f" at {texts[role]}" if role in texts else ""
        notes.append(f"{role.replace('_', ' ')}: column {shown(header)}{at}")
    kinds = {role: column.kind for role, column in chosen.items() if role in TROUGH}
    signals = {role: x for role, x in values.items() if role in SIGNALS}
    trough = {role: x for role, x in values.items() if role in TROUGH}
    return Record(values["time"], signals, trough, headers, texts, tuple(notes), kinds)


def _first_data(rows: Sequence[tuple[int, list[str]]]) -> int | None:
    """Return the index of the first row with at least as many numbers as most rows have."""
    looked_at = [cells for _, cells in rows[: TOL.looked_at]]
    counts = [sum(_NUMBER.fullmatch(cell) is not None for cell in cells) for cells in looked_at]
    usual = Counter(count for count in counts if count > 1).most_common(1)
    return next((i for i, count in enumerate(counts) if count >= usual[0][0]), None) if usual else None


def _take_apart(path: Path, text: str, wanted: Wanted) -> tuple[_Table, Columns]:
    """Find separator, decimals and header row, and the columns of the signals."""
    for separator in _SEPARATORS:
        rows = rows_of(path, text, separator)
        first = _first_data(rows)
        if first is not None:
            break
    else:
        hint = "it needs a header row and rows of numbers, separated by commas, semicolons or tabs"
        raise InputError(f"{path}: no table of numbers found", hint=hint)
    if first == 0:
        bare = f"{path}: row {rows[0][0]} holds numbers, but there is no header row above it"
        raise InputError(bare, hint="name the columns in a first row, with units: Time [s],X [mm]")
    place, chosen = _header_row(path, [cells for _, cells in rows[:first]], wanted)
    width, data = len(rows[place][1]), rows[place + 1 :]
    comma = any("," in cell for _, cells in data[: TOL.looked_at] for cell in cells)
    for row, cells in data:
        if any(cells[width:]):
            wide = f"{path}: row {row} has {len(cells)} cells, the header row {width}"
            raise InputError(wide, hint="decimal commas need semicolons between the cells")
        cells += [""] * (width - len(cells))
    return _Table(path, data, comma, separator), chosen


def _header_row(path: Path, above: list[list[str]], wanted: Wanted) -> tuple[int, Columns]:
    """Find the row that names the columns, above the first row of numbers.

    The lowest row may be data with a bad cell. It is no header if it does not name the columns, and holds a
    number or a text instead of one: try the row above it.
    """
    *higher, lowest = above
    try:
        return len(higher), columns_of(path, above, wanted)
    except InputError:
        patterns = (_NUMBER, _NO_VALUE, _WRONG)
        if not higher or not any(p.fullmatch(cell) for cell in lowest for p in patterns):
            raise
    return _header_row(path, higher, wanted)


def _with_values(table: _Table, columns: Mapping[Header, Floats]) -> Flags:
    """Return which rows hold a value in every column; refuse a table in which too many do not."""
    kept = np.asarray(~np.isnan(list(columns.values())).any(axis=0))
    count = int(np.count_nonzero(~kept))
    if count > TOL.skipped * kept.size:
        named = [t for header, x in columns.items() for t in table.named(header, np.isnan(x), x)]
        limit = f"at most {100.0 * TOL.skipped:.0f} % are skipped"
        lost = f"{table.path}: {count} of {kept.size} rows lack a value: {limit}"
        raise InputError(*named, lost, hint=_DELETE)
    return kept


def _check_time(table: _Table, header: Header, time: Floats, kept: NDArray[np.intp]) -> None:
    """Refuse a time that repeats, goes back or jumps; ``kept`` holds the places of its rows in the table."""
    steps = np.diff(time)
    usual = float(np.median(steps)) if steps.size else 0.0
    for bad, what, hint in (
        (steps < 0.0, "goes back to", "sort the rows by time, or keep one of the runs"),
        (steps == 0.0, "repeats", "keep one row for each time, or export more digits"),
        (steps > TOL.gap * usual, "jumps to", "fill the gap, or keep the part before or after it"),
    ):
        places = np.flatnonzero(bad)
        if places.size:
            i = int(places[0]) + 1
            before, now = time[i - 1], time[i]
            where = f"{table.path}: row {table.rows[kept[i]][0]}, column {shown(header.text)}"
            others = places.size - 1
            more = f"; {others} more such row{'s' if others > 1 else ''}" if others else ""
            said = f"time {what} {now:.9g} s" + (f" after {before:.9g} s" if now != before else "")
            skipped = int(kept[i] - kept[i - 1]) - 1
            lost = "row before it lacks" if skipped == 1 else f"{skipped} rows before it lack"
            between = f", as the {lost} a value" if skipped else ""
            raise InputError(f"{where}: {said}, usual steps are {usual:.3g} s{between}{more}", hint=hint)
