"""Read tables of what was measured: amplitudes over frequency, and times or speeds of parts over settings."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from vibro.errors import InputError, Problems, shown
from vibro.files.reading import read_text, rows_of
from vibro.quantities import (
    EITHER_WAY,
    POSITIVE,
    QUANTITIES,
    Quantity,
    Range,
    exact_number,
)
from vibro.units import PERCENT, SPEED, TIME

if TYPE_CHECKING:
    from vibro.reals import Floats


_EXAMPLE: Final = "frequency_hz,amplitude_mm"
#: Relative standard error of an amplitude.
AMPLITUDE_ERROR: Final = Quantity("amplitude_error", PERCENT, allowed=Range(0.0, 100.0, with_low=False))
# Columns, as people call them, and their quantities.
_Columns = Mapping[str, tuple[str, Quantity]]
_POINTS: Final[_Columns] = {
    "frequency": ("frequency|frequenz|freq|f", QUANTITIES["frequency"]),
    "amplitude": ("amplitude|amp|a", QUANTITIES["amplitude"]),
    "stroke": ("stroke|peak[ -]to[ -]peak|hub", QUANTITIES["stroke"]),
    AMPLITUDE_ERROR.name: ("amplitude[ _]error|error|fehler", AMPLITUDE_ERROR),
}


class _Sheet(NamedTuple):
    """A table as text: what messages call it, its header row, its other rows, what parts cells."""

    where: str
    row: int
    header: list[str]
    rows: list[tuple[int, list[str]]]
    separator: str = ","

    def values(self, columns: Mapping[str, tuple[int, str]], known: _Columns) -> dict[str, Floats]:
        """Read columns, given by their places and units; return them in the units outside.

        Raises
        ------
        InputError
            It names row and quantity of each cell that is wrong.
        """
        found: dict[str, list[float]] = {name: [] for name in columns}
        problems = Problems(f"{self.where}: ")
        for row, cells in self.rows:
            if any(cells[len(self.header) :]):
                wide = f"row {row} has {len(cells)} cells, the header row {len(self.header)}"
                problems.add(wide, "decimal commas need semicolons between the cells")
                continue
            for name, (place, unit) in columns.items():
                cell = cells[place] if place < len(cells) else ""
                with problems.taken(f"row {row}, "):
                    text = cell.replace(",", ".") if self.separator != "," else cell
                    found[name].append(_value(text, unit, known[name][1]))
        problems.settle()
        return {name: np.array(values) for name, values in found.items()}


def _sheet(path: Path, most: int | None = None) -> _Sheet:
    """Read the text of a file, or its first lines; its first row that is not blank is the header row."""
    text = "".join(read_text(path)[0].splitlines(keepends=True)[:most])
    first = next((line for line in text.splitlines() if line.strip()), "")
    separator = next((mark for mark in ";\t," if mark in first), ",")
    (row, header), *rows = rows_of(path, text, separator) or [(1, [""])]
    return _Sheet(str(path), row, header, rows, separator)


class MeasuredPoints(NamedTuple):
    """Amplitudes over frequency, in the order of the file.

    Attributes
    ----------
    frequency, amplitude : (n,) array
        In Hz and m.
    error : (n,) array or None
        Relative standard errors of the amplitudes [1], if the file has them.
    in_stroke : bool
        Whether the file gives strokes, twice the amplitudes.
    """

    frequency: Floats
    amplitude: Floats
    error: Floats | None
    in_stroke: bool

    @property
    def pairs(self) -> Floats:
        """Frequency and amplitude of each point, shape (n, 2) [Hz, m]."""
        return np.stack([self.frequency, self.amplitude], axis=1)


def read_points(path: Path) -> MeasuredPoints:
    """Read measured amplitudes over frequency.

    Parameters
    ----------
    path : Path
        CSV with a header row that names columns with their units, such as ``frequency_hz`` or
        ``frequency [Hz]``: a frequency, an amplitude or a stroke, and if known ``error_percent``, the
        standard error of an amplitude. Separated by commas, semicolons or tabs; decimal commas need one of
        the latter two. Other columns are left alone.

    Returns
    -------
    MeasuredPoints
        All rows, in SI units.

    Raises
    ------
    FileError
        If the file cannot be read.
    InputError
        If a column is missing or given twice, or a cell is no number that it may hold.
    """
    sheet = _sheet(path)
    found = _found(sheet, _POINTS)
    if "frequency" not in found or found.keys().isdisjoint(("amplitude", "stroke")):
        lacks = "amplitude_mm or stroke_mm" if "frequency" in found else "frequency_hz"
        raise _lacking(sheet, lacks, _EXAMPLE)
    if not sheet.rows:
        raise InputError(f"{path}: no rows under the header row", hint="give a row for each frequency")
    columns = sheet.values(found, _POINTS)
    frequency, *others = (_POINTS[name][1].to_si(values) for name, values in columns.items())
    stroke = "stroke" in columns
    error = others[1] if AMPLITUDE_ERROR.name in columns else None
    return MeasuredPoints(frequency, others[0] / 2.0 if stroke else others[0], error, stroke)


def _value(cell: str, unit: str, quantity: Quantity) -> float:
    """Read a cell, in the unit of its column unless it has one of its own; return it in the unit outside."""
    if not cell:
        raise InputError(f"{quantity.label}: the cell is empty", hint="delete that row")
    value = float(exact_number(cell, quantity))  # raises an error that names the cell
    if cell[-1] in "0123456789.":
        value = float(exact_number(cell + unit, quantity))
    if not quantity.allows(quantity.to_si(value)):
        allowed = f"above 0 {quantity.unit}"
        if quantity is AMPLITUDE_ERROR:
            allowed = "above 0 % and below 100 %"
        elif quantity.allowed.low <= 0.0:
            allowed = quantity.allowed.text(quantity.unit)
        raise InputError(f"{quantity.label} = {shown(cell)}: must be {allowed}")
    return value


def _unit_in(text: str, names: str, quantity: Quantity) -> str | None:
    """Return the unit in a header that names a quantity; None if it names none, or not with its unit."""
    spelled = {unit: unit for unit in quantity.kind.ratios}
    spelled |= {re.sub(r"[/ ]", "_", unit.replace("^", "")): unit for unit in spelled}  # as in mm_s
    spelled |= {"percent": "%"} if "%" in spelled else {}
    units = "|".join(sorted(map(re.escape, spelled), key=len, reverse=True))
    match = re.fullmatch(rf"(?:{names})[\s_]*(?:[\[(/]|in\s)?\s*({units})\s*[\])]?", text.casefold())
    return spelled[match[1]] if match else None


def _found(sheet: _Sheet, known: _Columns) -> dict[str, tuple[int, str]]:
    """Find the columns: for each quantity its place and unit."""
    found: dict[str, tuple[int, str]] = {}
    for name, (names, quantity) in known.items():
        for place, text in enumerate(sheet.header):
            unit = _unit_in(text, names, quantity)
            if unit and name in found:
                twice = f"{sheet.where}: row {sheet.row} names {quantity.label} twice"
                raise InputError(twice, hint="leave one column")
            if unit:
                found[name] = place, unit
    if "amplitude" in found and "stroke" in found:
        problem = f"{sheet.where}: amplitude and stroke are both given"
        raise InputError(problem, hint="leave one column: stroke = 2 A")
    return found


def _lacking(sheet: _Sheet, column: str, example: str) -> InputError:
    hint = f"name the columns with their units in the first row: {example}"
    return InputError(
        f"{sheet.where}: no column {column} among {', '.join(map(shown, sheet.header))}", hint=hint
    )


# ------------------------------------------------------------------------------
# Times or speeds of parts over settings.

#: What a row is about: the time over the trough's length, or the mean speed.
TRAVERSE_TIME: Final = Quantity("traverse_time", TIME, allowed=POSITIVE)
MEAN_VELOCITY: Final = Quantity("mean_velocity", SPEED, allowed=EITHER_WAY)
#: Quantities that a column may set.
SETTINGS: Final = ("amplitude", "stroke", "frequency", "drive_angle", "trough_angle")
_GERMAN: Final = ("schwingweite", "hub", "frequenz", "wurfwinkel|antriebswinkel", "neigung")
_SPEEDS: Final[_Columns] = {
    **{
        name: (f"{name.replace('_', '[ _]')}|{german}", QUANTITIES[name])
        for name, german in zip(SETTINGS, _GERMAN, strict=True)
    },
    TRAVERSE_TIME.name: ("(?:traverse[ _])?time|(?:lauf|transport)?zeit", TRAVERSE_TIME),
    MEAN_VELOCITY.name: ("(?:mean[ _])?(?:velocity|speed)|(?:förder)?geschwindigkeit", MEAN_VELOCITY),
    "error": ("error|fehler", replace(AMPLITUDE_ERROR, name="error")),
}
_NEVER: Final = "never"  # of a part that does not arrive
_SPEEDS_EXAMPLE: Final = "amplitude_mm,frequency_hz,traverse_time_s"
_MOST_ROWS: Final = 1000
_FEW_ROWS: Final = 50  # a record of signals has more


class MeasuredSpeeds(NamedTuple):
    """Times or speeds of parts over settings, in the order of the table.

    Attributes
    ----------
    where : str
        What messages call the table.
    rows : list of int
        Number of each row, as spreadsheets count.
    settings : mapping of str to (n,) array
        Columns by the names of their quantities, in the units outside.
    is_time : bool
        Whether times were measured, not speeds.
    measured : (n,) array
        Times, inf of a part that does not arrive [s], or speeds [m/s].
    error : (n,) array or None
        Relative standard errors of them [1], if the table has them.
    ignored : list of str
        Columns that are none of these.
    """

    where: str
    rows: list[int]
    settings: Mapping[str, Floats]
    is_time: bool
    measured: Floats
    error: Floats | None
    ignored: list[str]


def has_speeds(path: Path) -> bool:
    """Tell a table of times or speeds over settings from a record of signals over time, by its columns."""
    sheet = _sheet(path, 2 * _FEW_ROWS)
    named = {name for name, (x, _) in _SPEEDS.items() for text in sheet.header if _named(text, x)}
    if any(_named(text, "traverse[ _]time|mean[ _](?:velocity|speed)") for text in sheet.header):
        return True  # no signal is called so
    return bool(named & {*SETTINGS} and named & {TRAVERSE_TIME.name, MEAN_VELOCITY.name}) and (
        len(sheet.rows) <= _FEW_ROWS
    )


def read_speeds(table: Path | Mapping[str, Any]) -> MeasuredSpeeds:
    """Read times or speeds of parts over settings.

    Parameters
    ----------
    table : path or mapping of str to sequence
        A CSV as for ``read_points``, or its columns by their headers: settings such as ``amplitude_mm``,
        ``stroke_mm``, ``frequency_hz`` or ``drive_angle_deg``, and ``traverse_time_s`` or
        ``mean_velocity_mm_s``; if known ``error_percent``, a standard error. A time may be ``never``.

    Raises
    ------
    FileError
        If the file cannot be read.
    InputError
        If a column is missing, lacks its unit or is given twice, or a cell is no number that it may hold.
    """
    sheet = _sheet(table) if isinstance(table, Path) else _sheet_of(table)
    found = _found(sheet, _SPEEDS)
    taken = {place for place, _ in found.values()}
    for place, text in enumerate(sheet.header):
        for names, quantity in _SPEEDS.values():
            if place not in taken and _named(text, names):
                hint = f"write it as {quantity.column}; its units are {', '.join(quantity.kind.sizes)}"
                lacks = f"{sheet.where}: column {shown(text)}: a unit of {quantity.label} is missing"
                raise InputError(lacks, hint=hint)
    measured = [q for q in (TRAVERSE_TIME, MEAN_VELOCITY) if q.name in found]
    if len(measured) > 1:
        both = f"{sheet.where}: traverse time and mean velocity are both given"
        raise InputError(both, hint="leave one column")
    if not measured:
        raise _lacking(sheet, f"{TRAVERSE_TIME.column} or {MEAN_VELOCITY.column}", _SPEEDS_EXAMPLE)
    if not 1 <= len(sheet.rows) <= _MOST_ROWS:
        wrong = f"{sheet.where}: {len(sheet.rows)} rows under the header row"
        raise InputError(wrong, hint=f"give a row for each time, at most {_MOST_ROWS}")
    place, is_time = found[measured[0].name][0], measured[0] is TRAVERSE_TIME
    never = [is_time and _NEVER in cells[place : place + 1] for _, cells in sheet.rows]
    rows = [
        (row, [*cells[:place], "1", *cells[place + 1 :]] if out else cells)  # any valid time stands for it
        for (row, cells), out in zip(sheet.rows, never, strict=True)
    ]
    values = sheet._replace(rows=rows).values(found, _SPEEDS)
    return MeasuredSpeeds(
        sheet.where,
        [row for row, _ in rows],
        {name: values[name] for name in SETTINGS if name in found},
        is_time,
        np.where(never, np.inf, measured[0].to_si(values[measured[0].name])),
        values["error"] / 100.0 if "error" in found else None,
        [text for place, text in enumerate(sheet.header) if text and place not in taken],
    )


def _named(text: str, names: str) -> bool:
    """Whether a header begins with one of some names."""
    return re.match(rf"(?:{names})(?:[\s_\[(/]|$)", text.casefold()) is not None


def _sheet_of(table: Mapping[str, Any]) -> _Sheet:
    """Return columns in memory as the text that a file would hold."""
    columns = {str(key): np.atleast_1d(np.asarray(column, object)) for key, column in dict(table).items()}
    sizes = {key: len(column) for key, column in columns.items()}
    if len(set(sizes.values())) > 1:
        lengths = ", ".join(f"{key} {size}" for key, size in sizes.items())
        raise InputError(f"table: columns of different lengths: {lengths}", hint="give a value for each row")
    rows = [(i, [*map(str, cells)]) for i, cells in enumerate(zip(*columns.values(), strict=True), 1)]
    return _Sheet("table", 0, [*columns], rows)
