"""Read measured amplitudes over frequency: ``points.csv``, for the fit of a machine."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.errors import InputError, Problems, shown
from vibro.files.reading import read_text, rows_of
from vibro.quantities import QUANTITIES, Quantity, Range, exact_number
from vibro.units import PERCENT

if TYPE_CHECKING:
    from pathlib import Path

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
    text, _ = read_text(path)
    first = next((line for line in text.splitlines() if line.strip()), "")
    separator = next((mark for mark in ";\t," if mark in first), ",")
    (row, header), *rows = rows_of(path, text, separator) or [(1, [""])]
    units = _found(path, row, header)
    columns: dict[str, list[float]] = {name: [] for name in units}
    problems = Problems(f"{path}: ")
    for row, cells in rows:
        if any(cells[len(header) :]):
            wide = f"row {row} has {len(cells)} cells, the header row {len(header)}"
            problems.add(wide, "decimal commas need semicolons between the cells")
            continue
        for name, (place, unit) in units.items():
            cell = cells[place] if place < len(cells) else ""
            with problems.taken(f"row {row}, "):
                text = cell.replace(",", ".") if separator != "," else cell
                columns[name].append(_value(text, unit, _QUANTITIES[name]))
    problems.settle()
    if not rows:
        raise InputError(f"{path}: no rows under the header row", hint="give a row for each frequency")
    frequency, *others = (np.array(column) for column in columns.values())
    stroke = "stroke" in columns
    error = others[1] if AMPLITUDE_ERROR.name in columns else None
    return MeasuredPoints(frequency, others[0] / 2.0 if stroke else others[0], error, stroke)


def _value(cell: str, unit: str, quantity: Quantity) -> float:
    """Read a cell, in the unit of its column unless it has one of its own; return it in the SI unit."""
    if not cell:
        raise InputError(f"{quantity.label}: the cell is empty", hint="delete that row")
    value = float(exact_number(cell, quantity))  # raises an error that names the cell
    if cell[-1] in "0123456789.":
        value = float(exact_number(cell + unit, quantity))
    value = float(quantity.to_si(value))
    if not quantity.allows(value) or not value > 0.0:
        above = "above 0 % and below 100 %" if quantity is AMPLITUDE_ERROR else f"above 0 {quantity.unit}"
        raise InputError(f"{quantity.label} = {shown(cell)}: must be {above}")
    return value


def _found(path: Path, row: int, header: list[str]) -> dict[str, tuple[int, str]]:
    """Find the columns: for each quantity its place and unit."""
    found: dict[str, tuple[int, str]] = {}
    for name, names in _COLUMNS.items():
        units = "|".join(sorted(map(re.escape, _QUANTITIES[name].kind.ratios), key=len, reverse=True))
        units = units.replace("%", "%|percent")
        pattern = re.compile(rf"(?:{names})[\s_]*(?:[\[(/]|in\s)?\s*({units})\s*[\])]?")
        for place, text in enumerate(header):
            match = pattern.fullmatch(text.casefold())
            if match and name in found:
                label = _QUANTITIES[name].label
                raise InputError(f"{path}: row {row} names {label} twice", hint="leave one column")
            if match:
                found[name] = place, match[1].replace("percent", "%")
    if "amplitude" in found and "stroke" in found:
        problem = f"{path}: amplitude and stroke are both given"
        raise InputError(problem, hint="leave one column: stroke = 2 A")
    if "frequency" not in found or found.keys().isdisjoint(("amplitude", "stroke")):
        lacks = "amplitude_mm or stroke_mm" if "frequency" in found else "frequency_hz"
        hint = f"name the columns with their units in the first row: {_EXAMPLE}"
        raise InputError(f"{path}: no column {lacks} among {', '.join(map(shown, header))}", hint=hint)
    return found
