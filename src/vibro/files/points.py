"""Read tables of what was measured: amplitudes over frequency, and times or speeds of parts over settings."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from decimal import Decimal
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from vibro.errors import InputError, Problems, did_you_mean, shown
from vibro.files.reading import read_text, rows_of
from vibro.quantities import (
    DURATION,
    EITHER_WAY,
    LEAST_SPEED,
    LOAD,
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
# Columns, and how people call them; the first is needed, and one of the next two.
_COLUMNS: Final = {
    "frequency": "frequency|frequenz|freq|f",
    "amplitude": "amplitude|amp|a",
    "stroke": "stroke|peak[ -]to[ -]peak|hub",
    AMPLITUDE_ERROR.name: "amplitude[ _]error|error|fehler",
}
_QUANTITIES: Final = {name: QUANTITIES.get(name, AMPLITUDE_ERROR) for name in _COLUMNS}


class _Sheet(NamedTuple):
    """A table as text: what messages call it, its header row, its other rows, what parts cells."""

    where: str
    row: int
    header: list[str]
    rows: list[tuple[int, list[str]]]
    separator: str = ","

    def values(
        self, columns: Mapping[str, tuple[int, str]], quantities: Mapping[str, Quantity]
    ) -> dict[str, list[float]]:
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
                    found[name].append(_value(text, unit, quantities[name]))
        problems.settle()
        return found


def _sheet(path: Path) -> _Sheet:
    """Read the text of a file; its first row that is not blank is the header row."""
    text, _ = read_text(path)
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
    columns = sheet.values(_found(path, sheet.row, sheet.header), _QUANTITIES)
    if not sheet.rows:
        raise InputError(f"{path}: no rows under the header row", hint="give a row for each frequency")
    frequency, *others = (_QUANTITIES[name].to_si(np.array(values)) for name, values in columns.items())
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


def _found(path: Path, row: int, header: list[str]) -> dict[str, tuple[int, str]]:
    """Find the columns: for each quantity its place and unit."""
    found: dict[str, tuple[int, str]] = {}
    for name, names in _COLUMNS.items():
        for place, text in enumerate(header):
            unit = _unit_in(text, names, _QUANTITIES[name])
            if unit and name in found:
                label = _QUANTITIES[name].label
                raise InputError(f"{path}: row {row} names {label} twice", hint="leave one column")
            if unit:
                found[name] = place, unit
    if "amplitude" in found and "stroke" in found:
        problem = f"{path}: amplitude and stroke are both given"
        raise InputError(problem, hint="leave one column: stroke = 2 A")
    if "frequency" not in found or found.keys().isdisjoint(("amplitude", "stroke")):
        lacks = "amplitude_mm or stroke_mm" if "frequency" in found else "frequency_hz"
        hint = f"name the columns with their units in the first row: {_EXAMPLE}"
        raise InputError(f"{path}: no column {lacks} among {', '.join(map(shown, header))}", hint=hint)
    return found


# ------------------------------------------------------------------------------
# Times or speeds of parts over settings.

#: What a row is about: the time over the trough's length, or the mean speed.
TRAVERSE_TIME: Final = Quantity("traverse_time", TIME, allowed=POSITIVE)
MEAN_VELOCITY: Final = Quantity("mean_velocity", SPEED, allowed=EITHER_WAY)
#: Acceleration of the drive over that of gravity, which gives an amplitude.
ACCELERATION: Final = replace(LOAD, allowed=POSITIVE)
_SETTINGS: Final = {
    "amplitude": "amplitude|amp",
    "stroke": _COLUMNS["stroke"],
    "frequency": "frequency|frequenz|freq",
    **{
        name: name.replace("_", "[ _]")
        for name in (
            "setting", "voltage", "along_amplitude", "normal_amplitude", "normal_phase", "drive_angle",
            "trough_angle", "trough_length",
        )
    },
}  # fmt: skip
_MEASURED: Final = {
    TRAVERSE_TIME.name: "traverse[ _]time|time",
    MEAN_VELOCITY.name: "mean[ _](?:velocity|speed)|velocity|speed",
}
_ERRORS: Final = {  # in the unit of what is measured, or relative
    "traverse_time_error": ("(?:traverse[ _])?time[ _]error", replace(DURATION, name="time_error")),
    "mean_velocity_error": (
        "(?:mean[ _])?(?:velocity|speed)[ _]error",
        replace(LEAST_SPEED, name="speed_error"),
    ),
    "error": (
        "(?:(?:(?:traverse[ _])?time|(?:mean[ _])?(?:velocity|speed))[ _])?error",
        replace(AMPLITUDE_ERROR, name="error"),
    ),
}
_OF_SPEEDS: Final[Mapping[str, tuple[str, Quantity]]] = {
    **{name: (names, QUANTITIES[name]) for name, names in _SETTINGS.items()},
    ACCELERATION.name: ("acceleration", ACCELERATION),
    TRAVERSE_TIME.name: (_MEASURED[TRAVERSE_TIME.name], TRAVERSE_TIME),
    MEAN_VELOCITY.name: (_MEASURED[MEAN_VELOCITY.name], MEAN_VELOCITY),
    **_ERRORS,
}
_CERTAIN: Final = r"(?:traverse[ _]time|mean[ _](?:velocity|speed))\b.*"  # no signal is called so
_NEVER: Final = frozenset(("inf", "infinity", "\u221e", "never"))  # a part that does not arrive
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
        Standard errors of them, if the table has them [s or m/s].
    resolution : (n,) array
        A unit in the last digit of each [s or m/s].
    ignored : list of str
        Columns that are none of these.
    """

    where: str
    rows: list[int]
    settings: Mapping[str, Floats]
    is_time: bool
    measured: Floats
    error: Floats | None
    resolution: Floats
    ignored: list[str]


def has_speeds(path: Path) -> bool:
    """Tell a table of times or speeds over settings from a record of signals over time, by its columns."""
    sheet = _sheet(path)
    header = sheet.header
    if any(re.fullmatch(_CERTAIN, text.casefold().replace("_", " ")) for text in header):
        return True
    has_setting = any(_unit_in(text, n, QUANTITIES[name]) for name, n in _SETTINGS.items() for text in header)
    measured = "|".join(_MEASURED.values())
    return (
        has_setting
        and len(sheet.rows) <= _FEW_ROWS
        and any(re.match(rf"(?:{measured})(?:[^a-z]|$)", text.casefold()) for text in header)
    )


def read_speeds(table: Path | Mapping[str, Any]) -> MeasuredSpeeds:
    """Read times or speeds of parts over settings.

    Parameters
    ----------
    table : path or mapping of str to sequence
        A CSV as for ``read_points``, or its columns by their headers: settings such as ``amplitude_mm``,
        ``stroke_mm``, ``acceleration_g``, ``frequency_hz``, ``drive_angle_deg`` or ``setting_percent``, and
        ``traverse_time_s`` or ``mean_velocity_mm_s``; if known ``time_error_s``, ``speed_error_mm_s`` or
        ``error_percent``, a standard error. A time may be ``never``.

    Raises
    ------
    FileError
        If the file cannot be read.
    InputError
        If a column is missing, lacks its unit or is given twice, or a cell is no number that it may hold.
    """
    sheet = _sheet(table) if isinstance(table, Path) else _sheet_of(table)
    columns = _speed_columns(sheet)
    time = TRAVERSE_TIME.name in columns
    quantity = TRAVERSE_TIME if time else MEAN_VELOCITY
    place, unit = columns[quantity.name]
    never = [time and _cell(cells, place).casefold() in _NEVER for _, cells in sheet.rows]
    errors = [name for name in _ERRORS if name in columns]
    for (_, cells), is_never in zip(sheet.rows, never, strict=True):
        if is_never:  # any valid number stands for it, and for its error
            for at in (place, *(columns[name][0] for name in errors)):
                cells[at : at + 1] = ["1"]
    values = sheet.values(columns, {name: quantity for name, (_, quantity) in _OF_SPEEDS.items()})
    if not 1 <= len(sheet.rows) <= _MOST_ROWS:
        wrong = f"{sheet.where}: {len(sheet.rows)} rows under the header row"
        raise InputError(wrong, hint=f"give a row for each time, at most {_MOST_ROWS}")
    measured = np.where(never, np.inf, quantity.to_si(np.array(values.pop(quantity.name))))
    error = None
    for name in errors:
        error = _ERRORS[name][1].to_si(np.array(values.pop(name)))
        error = error * abs(measured) if name == "error" else error
    ends = [_last_digit(_cell(cells, place), unit, quantity) for _, cells in sheet.rows]
    taken = {place for place, _ in columns.values()}
    return MeasuredSpeeds(
        sheet.where,
        [row for row, _ in sheet.rows],
        {name: np.array(column) for name, column in values.items()},
        time,
        measured,
        error,
        np.array(ends),
        [text for place, text in enumerate(sheet.header) if text and place not in taken],
    )


def _cell(cells: list[str], place: int) -> str:
    return cells[place] if place < len(cells) else ""


def _sheet_of(table: Mapping[str, Any]) -> _Sheet:
    """Return columns in memory as the text that a file would hold."""
    columns = {
        str(key): list(np.atleast_1d(np.asarray(column, object))) for key, column in dict(table).items()
    }
    sizes = {key: len(column) for key, column in columns.items()}
    if len(set(sizes.values())) > 1:
        lengths = ", ".join(f"{key} {size}" for key, size in sizes.items())
        raise InputError(f"table: columns of different lengths: {lengths}", hint="give a value for each row")
    rows = [
        (i, [str(cell) for cell in cells]) for i, cells in enumerate(zip(*columns.values(), strict=True), 1)
    ]
    return _Sheet("table", 0, [*columns], rows)


def _speed_columns(sheet: _Sheet) -> dict[str, tuple[int, str]]:
    """Find the columns of a table of times or speeds: for each quantity its place and unit."""
    found: dict[str, tuple[int, str]] = {}
    problems, taken = Problems(f"{sheet.where}: "), set[int]()
    for place, text in enumerate(sheet.header):
        for name, (names, quantity) in _OF_SPEEDS.items():
            unit = _unit_in(text, names, quantity)
            taken |= {place} if unit else set()
            if unit and name in found:
                problems.add(f"row {sheet.row} names {quantity.label} twice", "leave one column")
            elif unit:
                found[name] = place, unit
    for place, text in enumerate(sheet.header):
        lacking = [
            q
            for names, q in _OF_SPEEDS.values()
            if place not in taken and re.match(rf"(?:{names})(?:[\s_\[(/]|$)", text.casefold())
        ]
        if lacking:
            units = ", ".join(lacking[-1].kind.sizes)
            example = f"write it as {lacking[-1].column}; its units are {units}"
            problems.add(f"column {shown(text)}: a unit of {lacking[-1].label} is missing", example)
    problems.settle()
    both = [name for name in _MEASURED if name in found]
    sizes = [name for name in ("amplitude", "stroke", ACCELERATION.name) if name in found]
    for twice, hint in ((both, "leave one of them"), (sizes, "leave one of them: each gives the amplitude")):
        if len(twice) > 1:
            labels = " and ".join(name.replace("_", " ") for name in twice)
            problems.add(f"{labels} are given", hint)
    errors = [name for name in _ERRORS if name in found]
    if len(errors) > 1:
        problems.add(f"{len(errors)} columns of errors are given", "leave one of them")
    elif errors and both and errors[0] not in (f"{both[0]}_error", "error"):
        own = _ERRORS[f"{both[0]}_error"][1].column
        what = f"the error of the {both[0].replace('_', ' ')} is not in its unit"
        problems.add(what, f"give {own} or error_percent")
    if not both:
        listed = ", ".join(map(shown, sheet.header))
        hint = f"name the columns with their units in the first row: {_SPEEDS_EXAMPLE}"
        known = TRAVERSE_TIME.column, MEAN_VELOCITY.column
        near = (did_you_mean(text, known, cutoff=0.7) for text in sheet.header)
        problems.add(f"no column {' or '.join(known)} among {listed}", next(filter(None, near), hint))
    problems.settle()
    return found


def _last_digit(cell: str, unit: str, quantity: Quantity) -> float:
    """Return the size of a unit in the last digit of a number, in the SI unit."""
    digits = re.match(r"[-+\u2212]?[0-9]*[.,]?[0-9]*(?:[eE][-+]?[0-9]+)?", cell)
    text = digits[0].replace(",", ".").replace("\u2212", "-") if digits else ""
    last = Decimal(1).scaleb(int(Decimal(text).as_tuple().exponent)) if text else Decimal(0)
    return _in_si(f"{last}{cell[len(text) :].strip() or unit}", quantity)


def _in_si(text: str, quantity: Quantity) -> float:
    return float(quantity.to_si(float(exact_number(text, quantity))))
