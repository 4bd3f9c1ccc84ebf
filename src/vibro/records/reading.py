"""Measured records: CSV files with any column names, units, separators and decimals."""

from __future__ import annotations

import csv
import difflib
import io
import re
from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.errors import FileError, InputError, cut, shown
from vibro.files.nearby import suggestion
from vibro.records.signals import MOST, SIGNAL_UNITS, signal_unit

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence
    from pathlib import Path

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

__all__ = ["SIGNALS", "Record", "read_record"]

# Signals that a record may hold in addition to its time; each name is also the kind of its unit.
SIGNALS: Final = ("displacement", "velocity", "acceleration", "force")
_ROLES: Final = ("time", *SIGNALS)

# Words in a header that decide between columns with the same kind of unit.
_WORDS: Final[Mapping[str, str]] = {
    "time": r"time|zeit|t",
    "displacement": r"displacement|position|weg|relative.*|x|xi|s",
    "velocity": r"velocity|speed|geschwindigkeit|relative.*|v|vx",
    "acceleration": r"acceleration|beschleunigung|relative.*|a|ax",
    "force": r"friction|friction force|reibkraft|f",
}
_BRACKETS: Final = re.compile(r"(.*?)\s*[\[(]([^\])]*)[\])]\s*")
# Possessive, so that a long cell takes no longer than its length asks for.
_NUMBER: Final = re.compile(r"[+-]?+(?:\d++[.,]?+\d*+|[.,]\d++)(?:[eE][+-]?+\d++)?+")
# What programs write in place of a number.
_NO_VALUE: Final = re.compile(
    r"[+-]?(nan|inf(inity)?)|n/?a|null|none|error|overflow|#.*|[-?*]+", re.IGNORECASE
)
_SEPARATORS: Final = {";": "semicolon", "\t": "tab", ",": "comma"}
_LOOKED_AT: Final = 300  # rows from which separator and header are found
_GAP: Final = 3.0  # a step longer than this many usual steps is a gap
_TOLD: Final = 5  # number of bad cells of a column that a message lists
_LISTED: Final = 12  # headers that a message lists


@dataclass(frozen=True, eq=False)
class Record:
    """Signals over time, in SI units.

    Attributes
    ----------
    time : float array
        Strictly ascending [s].
    signals : mapping of str to float array
        By a name of ``SIGNALS``: relative displacement [m], velocity [m/s], acceleration [m/s^2] and
        friction [N], of the length of ``time``.
    headers : mapping of str to str
        The columns' headers in the file, by the same names and ``"time"``.
    notes : tuple of str
        How the file was read, to be shown to the user.
    """

    time: Floats
    signals: Mapping[str, Floats]
    headers: Mapping[str, str]
    notes: tuple[str, ...] = ()

    @property
    def sample_time(self) -> float:
        """Usual step of the time [s]."""
        return float(np.median(np.diff(self.time)))


class _Header(NamedTuple):
    """A column: its index, its header, the name and the brackets in it, and its unit's kind and size."""

    place: int
    text: str
    name: str
    in_brackets: str
    unit: tuple[str, float] | None


#: The column of every signal, and the size of its unit in SI units.
_Columns = dict[str, tuple[_Header, float]]


class _Table(NamedTuple):
    """A parsed file: the rows of data, each with its number in the file."""

    rows: list[tuple[int, list[str]]]
    decimal_comma: bool
    separator: str


def read_record(path: Path, columns: Mapping[str, str] | None = None) -> Record:
    """Read a record from a text file of columns.

    Parameters
    ----------
    path : Path
        CSV with a header row; separated by commas, semicolons or tabs, with decimal points or commas,
        in UTF-8 (with or without a byte order mark), UTF-16 or a Windows code page.
    columns : mapping of str to str, optional
        Headers by ``"time"`` and the names of ``SIGNALS``. The unit of the header, in brackets, may be left
        out; if the file has none, the one given here is used. If no header is given, every column whose unit
        is unambiguous is read.

    Returns
    -------
    Record
        In SI units.

    Raises
    ------
    FileError
        If the file cannot be read.
    InputError
        If a column is missing, ambiguous or without a unit; if a cell is empty or no number; if the time has
        gaps, repeats or goes back. Row and column are named.
    """
    wanted = dict(columns or {})
    text, notes = _decode(path)
    table, chosen = _take_apart(path, text, wanted)
    if table.separator != "," or table.decimal_comma:
        decimals = ", decimal commas" if table.decimal_comma else ""
        notes.append(f"{path.name}: separated by {_SEPARATORS[table.separator]}s{decimals}")
    values = {role: _numbers(path, table, header, unit) for role, (header, unit) in chosen.items()}
    _check_time(path, table, chosen["time"][0], values["time"])
    for role, (header, _) in chosen.items():
        notes.append(f"{role}: column {shown(header.text)}")
    return Record(
        time=values["time"],
        signals={role: values[role] for role in SIGNALS if role in chosen},
        headers={role: header.text for role, (header, _) in chosen.items()},
        notes=tuple(notes),
    )


def _decode(path: Path) -> tuple[str, list[str]]:
    try:
        data = path.read_bytes()
    except OSError as exc:
        raise FileError(
            f"cannot read {path}: {exc.strerror or exc}", hint=suggestion(path, (".csv", ".txt"))
        ) from exc
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        try:
            return data.decode("utf-16"), [f"{path.name}: UTF-16"]
        except UnicodeDecodeError as exc:
            raise InputError(f"{path}: not a text file", hint="save it as CSV") from exc
    if b"\0" in data[:4096]:
        raise InputError(f"{path}: not a text file", hint="export the table as CSV")
    try:
        return data.decode("utf-8-sig"), []
    except UnicodeDecodeError:
        # Older spreadsheets write micro and degree signs in this code page. A byte that it does not define
        # cannot be part of a unit, so any character may replace it.
        return data.decode("cp1252", errors="replace"), [f"{path.name}: not UTF-8, read as Windows-1252"]


def _rows(text: str, separator: str) -> Iterable[tuple[int, list[str]]]:
    """Cells of every line that has any, with the line's number as editors and spreadsheets count."""
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=separator)
    for cells in reader:
        stripped = [cell.strip() for cell in cells]
        if any(stripped):
            yield reader.line_num, stripped


def _first_data(rows: Sequence[tuple[int, list[str]]]) -> int | None:
    """Index of the first row with at least as many numbers as most rows have."""
    counts = [sum(_NUMBER.fullmatch(cell) is not None for cell in cells) for _, cells in rows[:_LOOKED_AT]]
    usual = Counter(count for count in counts if count > 1).most_common(1)
    return next((i for i, count in enumerate(counts) if count >= usual[0][0]), None) if usual else None


def _take_apart(path: Path, text: str, wanted: Mapping[str, str]) -> tuple[_Table, _Columns]:
    """Find separator, decimals and header row, and the columns of the signals."""
    for separator in _SEPARATORS:
        try:
            rows = list(_rows(text, separator))
        except csv.Error as exc:
            raise InputError(f"{path}: not a table: {exc}", hint="export the table as CSV") from exc
        first = _first_data(rows)
        if first is not None:
            break
    else:
        raise InputError(
            f"{path}: no table of numbers found",
            hint="it needs a header row and rows of numbers, separated by commas, semicolons or tabs",
        )
    if first == 0:
        raise InputError(
            f"{path}: row {rows[0][0]} holds numbers, but there is no header row above it",
            hint="name the columns in a first row, with units: Time [s],X [mm]",
        )
    place, chosen = _header_row(path, [cells for _, cells in rows[:first]], wanted)
    width, data = len(rows[place][1]), rows[place + 1 :]
    comma = any("," in cell for _, cells in data[:_LOOKED_AT] for cell in cells)
    for row, cells in data:
        if any(cells[width:]):
            raise InputError(
                f"{path}: row {row} has {len(cells)} cells, the header row {width}",
                hint="decimal commas need semicolons between the cells",
            )
    return _Table(data, comma, separator), chosen


def _header_row(path: Path, above: list[list[str]], wanted: Mapping[str, str]) -> tuple[int, _Columns]:
    """Find the row that names the columns, above the first row that is all numbers.

    The lowest row may be one of data in which a cell is bad. It is no header then: it lacks the columns, and
    holds a number, or what stands for one.
    """
    place = len(above) - 1
    while True:
        try:
            return place, _choose(path, _headers(above[: place + 1]), wanted)
        except InputError:
            if not place or not any(_NUMBER.fullmatch(c) or _NO_VALUE.fullmatch(c) for c in above[place]):
                raise
        place -= 1


def _headers(above: list[list[str]]) -> list[_Header]:
    """Read the header row, and a row of units under it if there is one."""
    texts = above[-1]
    units = [text.strip("[]()") for text in texts]
    if len(above) > 1 and len(above[-2]) == len(units) and all(signal_unit(unit) for unit in units if unit):
        texts = [f"{name} [{unit}]" if unit else name for name, unit in zip(above[-2], units, strict=True)]
    headers = []
    for place, text in enumerate(texts):
        name, unit = _bracketed(text)
        headers.append(_Header(place, text, name, unit, signal_unit(unit) if unit else _unit_at_end(name)))
    return headers


def _bracketed(text: str) -> tuple[str, str]:
    """Split ``X [mm]`` into name and unit."""
    match = _BRACKETS.fullmatch(text)
    return (match[1], match[2].strip()) if match else (text, "")


def _unit_at_end(name: str) -> tuple[str, float] | None:
    """Find the unit that ends a name of vibro's own tables, such as ``velocity_mm_s``."""
    words = name.split("_")
    for count in (2, 1):
        if len(words) > count and (unit := signal_unit("_".join(words[-count:]))):
            return unit
    return None


def _choose(path: Path, headers: list[_Header], wanted: Mapping[str, str]) -> _Columns:
    """Find the columns of the signals."""
    problems: list[str] = []
    hints: list[str] = []
    chosen: _Columns = {}
    # A user who names one signal wants only the named ones; the time is needed in any case.
    roles = [r for r in _ROLES if r in wanted or r == "time" or not any(s in wanted for s in SIGNALS)]
    for role in roles:
        try:
            if role in wanted:
                chosen[role] = _named(path, headers, role, wanted[role])
            elif found := _detected(path, headers, role):
                chosen[role] = found
        except InputError as exc:
            problems += exc.problems
            hints += [exc.hint]
    if not problems and "time" not in chosen:
        problems.append(f"{path}: no column of time found among {_list(headers)}")
        hints.append('name it, with its unit: --time "t [s]"')
    if not problems and len(chosen) < 2:
        problems.append(f"{path}: no signal found among {_list(headers)}")
        hints.append('name one, with its unit: --displacement "X [mm]"')
    if problems:
        raise InputError(*problems, hint="; ".join(dict.fromkeys(hints)))
    places = {role: header.place for role, (header, _) in chosen.items()}
    for role, place in places.items():
        same = [other for other in places if places[other] == place]
        if len(same) > 1:
            raise InputError(
                f"{path}: column {shown(chosen[role][0].text)} is given as {' and as '.join(same)}"
            )
    return chosen


def _named(path: Path, headers: list[_Header], role: str, text: str) -> tuple[_Header, float]:
    name, unit_text = _bracketed(text.strip())
    key = text.strip()
    found = (
        [h for h in headers if h.text == key]
        or [h for h in headers if h.text.casefold() == key.casefold()]
        or [h for h in headers if h.name.casefold() == name.casefold() and not (unit_text and h.in_brackets)]
    )
    if not found:
        close = difflib.get_close_matches(text, [h.text for h in headers], n=1, cutoff=0.5)
        raise InputError(
            f"{path}: no column {shown(text)} for --{role}; its columns are {_list(headers)}",
            hint=f"did you mean {shown(close[0])}?" if close else "write it as the header row does",
        )
    if len(found) > 1:
        raise InputError(
            f"{path}: {len(found)} columns are called {shown(text)}",
            hint="give them different names in the file",
        )
    (header,) = found
    unit = header.unit
    if unit_text and not header.in_brackets:
        unit = signal_unit(unit_text)
    if unit is None or unit[0] != role:
        stated = unit_text or header.in_brackets
        problem = f"{shown(stated)} is no unit of {role}" if stated else "it has no unit"
        example = next(iter(SIGNAL_UNITS[role]))
        raise InputError(
            f"{path}: column {shown(header.text)} for --{role}: {problem}",
            hint=f'write the unit in brackets: --{role} "{header.name} [{example}]"; '
            f"units of {role} are {', '.join(SIGNAL_UNITS[role])}",
        )
    return header, unit[1]


def _detected(path: Path, headers: list[_Header], role: str) -> tuple[_Header, float] | None:
    """Find the one column whose unit fits, or the one among several whose name does."""
    fitting = [h for h in headers if h.unit and h.unit[0] == role]
    if len(fitting) > 1:
        word = re.compile(rf"(?:{_WORDS[role]})(?:[\W_\d].*)?", re.IGNORECASE)
        fitting = [h for h in fitting if word.fullmatch(h.name)] or fitting
    if len(fitting) > 1:
        raise InputError(
            f"{path}: {_list(fitting)} could each be the {role}",
            hint=f'choose: --{role} "{fitting[0].text}"',
        )
    return (fitting[0], fitting[0].unit[1]) if fitting and fitting[0].unit else None


def _list(headers: Sequence[_Header]) -> str:
    texts = [shown(h.text) for h in headers if h.text]
    more = len(texts) - _LISTED
    return ", ".join(texts[:_LISTED]) + (f" and {more} more" if more > 0 else "")


def _numbers(path: Path, table: _Table, header: _Header, unit: float) -> Floats:
    """Read a column, in SI units."""
    values = np.full(len(table.rows), np.nan)
    for i, (_, cells) in enumerate(table.rows):
        cell = cells[header.place] if header.place < len(cells) else ""
        if _NUMBER.fullmatch(cell) and ("," in cell) <= table.decimal_comma and not {",", "."} <= set(cell):
            values[i] = float(cell.replace(",", ".")) * unit
    bad = np.flatnonzero(~(np.abs(values) <= MOST))
    problems = []
    for i in bad[:_TOLD]:
        row, cells = table.rows[i]
        cell = cells[header.place] if header.place < len(cells) else ""
        what = f"{shown(cell)} is not a number" if cell else "the cell is empty"
        if not np.isnan(values[i]):
            what = f"{cut(cell)} is too large to compute with, at most {MOST / unit:g} is allowed"
        problems.append(f"{path}: row {row}, column {shown(header.text)}: {what}")
    if bad.size > _TOLD:
        problems.append(f"{path}: column {shown(header.text)}: {bad.size - _TOLD} more such cells")
    if problems:
        raise InputError(*problems, hint="delete those rows, or keep the part before or after them")
    return values


def _check_time(path: Path, table: _Table, header: _Header, time: Floats) -> None:
    """Refuse a time that repeats, goes back or jumps."""
    steps = np.diff(time)
    usual = float(np.median(steps)) if steps.size else 0.0
    for bad, what, hint in (
        (steps < 0.0, "goes back to", "sort the rows by time, or keep one of the runs"),
        (steps == 0.0, "repeats", "keep one row for each time, or export more digits"),
        (steps > _GAP * usual, "jumps to", "fill the gap, or keep the part before or after it"),
    ):
        places = np.flatnonzero(bad)
        if places.size:
            i = int(places[0]) + 1
            before, now = time[i - 1], time[i]
            where = f"{path}: row {table.rows[i][0]}, column {shown(header.text)}"
            more = f"; {places.size - 1} more such rows" if places.size > 1 else ""
            said = f"time {what} {now:.9g} s" + (f" after {before:.9g} s" if now != before else "")
            raise InputError(f"{where}: {said}, usual steps are {usual:.3g} s{more}", hint=hint)
