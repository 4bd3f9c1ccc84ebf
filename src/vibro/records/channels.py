"""Channels of a file of any format: their names, their units as programs spell them, their cells."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vibro.errors import InputError, cut, shown
from vibro.records import clocks
from vibro.units import LENGTH, SPEED, STANDARD_GRAVITY

if TYPE_CHECKING:
    from vibro.reals import Floats

#: Largest value in a record [SI]: fourth powers that are summed over the rows must be doubles.
LARGEST: Final = 1e20
#: Bad cells of a column, or rows, that a message names.
CELLS_NAMED: Final = 5
_LONG_AGO: Final = 1e7  # [s] times from further back count from the first row, as those since 1970
_LONGEST: Final = 40  # characters of a unit
#: Kind of a unit, a key of ``SIGNAL_UNITS``, and its size in SI units.
Unit = tuple[str, float]
#: Signals of the body that a record may hold; each name but friction's is also the kind of its unit.
SIGNALS: Final = ("displacement", "velocity", "acceleration", "friction")
#: The axes of a phone on the trough that nobody named.
AXES: Final = ("trough_x", "trough_y", "trough_z")
#: Motions of the trough that it may hold: along the trough's surface, normal to it, and across both.
TROUGH: Final = ("trough_along", "trough_normal", "trough_across", *AXES)
#: Kinds of unit that a motion of the trough may have, with the derivatives from each to the acceleration.
DERIVATIVES: Final[Mapping[str, int]] = {"acceleration": 0, "velocity": 1, "displacement": 2}
#: Kind of unit of each column; of the trough's the usual one.
KINDS: Final[Mapping[str, str]] = {r: r for r in ("time", *SIGNALS)} | {
    "friction": "force",
    **dict.fromkeys(TROUGH, "acceleration"),
}


def _per_time(suffix: str) -> dict[str, float]:
    return {f"{unit}{suffix}": float(size / 1000) for unit, size in LENGTH.sizes.items()}


# Units of each kind, and their sizes in SI units; hints use the first one.
SIGNAL_UNITS: Final[Mapping[str, Mapping[str, float]]] = {
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "\u00b5s": 1e-6, "ns": 1e-9, "min": 60.0},
    "displacement": _per_time("") | {"mil": 25.4e-6},
    "velocity": {u: float(size / 1000) for u, size in SPEED.sizes.items()}
    | {"ips": 0.0254, "mil/s": 25.4e-6},
    "acceleration": {"m/s^2": 1.0, "g": STANDARD_GRAVITY, "mg": 9.80665e-3, "ug": 9.80665e-6}
    | _per_time("/s^2")
    | {"Gal": 0.01},
    "force": {"N": 1.0, "mN": 1e-3, "kN": 1e3},
    "voltage": {"V": 1.0, "mV": 1e-3},
}
_BY_NAME: Final = {
    unit.casefold().replace("^", ""): (kind, size)
    for kind, sizes in SIGNAL_UNITS.items()
    for unit, size in sizes.items()
}
# Spellings of MATLAB, SolidWorks, loggers and the column names of vibro, one after the other.
_SPELLINGS: Final = tuple(
    (re.compile(spelling), plain)
    for spelling, plain in (
        ("[\u00c2\u00e2](?=[\u00b2\u00b5\u00b7])|[{}$]", ""),  # of UTF-8 read as Latin, of LaTeX
        (r"\s+(?:per|pro|par)\s+", "/"),
        (r"g['\u2019]s", "g"),
        (r"milli[\s-]*(?=g|s|m|v|n)", "m"),
        (r"mi[ck]ro[\s-]*(?=g|s|m|v)", "u"),
        (r"nano[\s-]*(?=s)", "n"),
        (r"secondes?|seconds?|sekunden?|segundos?|secondi|secs?|sek", "s"),
        (r"minutes?|minuten?", "min"),
        (r"met(?:er|re)s?", "m"),
        (r"inch(?:es)?", "in"),
        (r"mils|thou", "mil"),
        (r"microns?", "um"),
        (r"newtons?", "n"),
        (r"volts?", "v"),
        (r"g[n0]", "g"),
        ("[\u00b2\u2072]", "2"),
        ("\u207b\u00b9", "-1"),
        ("\u207b", "-"),
        (r"[\s\u00b7\u22c5.*^()]", ""),
        (r"/s/s|/ss", "/s2"),
        (r"(?<=[mn])_(?=s)", "/"),
        (r"(?<=[mnt])s-2", "/s2"),
        (r"(?<=[mnt])s-1", "/s"),
    )
)


def signal_unit(text: str) -> Unit | None:
    """Return the kind and the size of a unit.

    Parameters
    ----------
    text : str
        A unit such as ``mm``, ``mm/sec**2``, ``m_s2``, ``m s\u207b\u00b2``, ``ips``, ``milli-g`` or ``mV``.

    Returns
    -------
    Unit or None
        None if the text is no unit of a signal.
    """
    if text == "v" or len(text) > _LONGEST:  # a velocity's name, not a volt
        return None
    name = text.casefold()
    if name not in _BY_NAME:
        for spelling, plain in _SPELLINGS:
            name = spelling.sub(plain, name)
    return _BY_NAME.get(name)


def kinds_of(role: str) -> tuple[str, ...]:
    """Return the kinds of unit that a column may have, the usual one first."""
    return tuple(DERIVATIVES) if role in TROUGH else (KINDS[role],)


# Words in a header that decide between columns whose units are of the same kind.
WORDS: Final = {
    role: re.compile(rf"(?:{words})(?:[\W_\d].*)?", re.IGNORECASE)
    for role, words in (
        ("time", r"(?:date|elapsed|relative)? ?time|(?:uhr)?zeit|t|time ?stamps?|clock|epoch"),
        ("displacement", r"displacement|position|weg|relative.*|x|xi|s"),
        ("velocity", r"velocity|speed|geschwindigkeit|relative.*|v|vx"),
        ("acceleration", r"acceleration|beschleunigung|relative.*|a|ax"),
        ("friction", r"friction|friction force|reibkraft|f"),
    )
}
_BRACKETS: Final = re.compile(r"(.*?)\s*[\[(](?:in\s+)?([^\])]*)[\])]\s*")
_BEFORE: Final = re.compile(r"\s*[\[(]([^\])]*)[\])]\s*(\S.*)")  # [g] ax
_IN: Final = re.compile(r"(.*\S)(?:\s+(?:in|/)|\s*,)\s+(\S.*)", re.IGNORECASE)  # Zeit in s, or Zeit / s
_OVER: Final = re.compile(r"([^/]*[^/\s])\s*/\s*(\S.*)")  # Zeit/s, v/mm/s


class Header(NamedTuple):
    """Header of a column: its place, text and names, and the kind and size of its unit."""

    place: int
    text: str
    names: tuple[str, ...]
    stated: str
    unit: Unit | None

    @property
    def name(self) -> str:
        """Its name, without the unit."""
        return self.names[0]


def headers_of(table: Table) -> list[Header]:
    """Take the names and units of the columns apart."""
    headers = []
    for place, texts in enumerate(zip(table.names, *table.also, strict=True)):
        unit = table.units[place] if table.units else ""
        split = [split_header(text) for text in texts]
        stated = unit or split[0][1]
        text = f"{texts[0]} [{unit}]".lstrip() if unit else texts[0] or f"{place + 1}"
        names = tuple(dict.fromkeys([*(name for name, _ in split), *texts, f"{texts[0]} [{unit}]"]))
        headers.append(Header(place, text, names, stated, signal_unit(unit) or unit_of_header(texts[0])))
    return headers


def unit_of_header(text: str) -> Unit | None:
    """Return the kind and the size of the unit that a header states; None if it states none that is known."""
    name, unit = split_header(text)
    return signal_unit(unit) if unit else _unit_at_end(name)


def split_header(text: str) -> tuple[str, str]:
    """Split ``X [mm]``, ``X in mm`` or ``X/mm`` into name and unit."""
    if match := _BRACKETS.fullmatch(text):
        name = match[1].removesuffix("/")
        if name == match[1]:
            return name, match[2].strip()
        parts = name.rstrip(), match[2].strip()
        return parts if signal_unit(parts[1]) is None or _is_quotient(*parts) else (text, "")
    if signal_unit(text):  # m / s is a unit
        return text, ""
    if (match := _BEFORE.fullmatch(text)) and signal_unit(match[1]):
        return match[2], match[1]
    if (match := _IN.fullmatch(text)) and signal_unit(match[2].strip()):
        return match[1], match[2].strip()
    match = _OVER.fullmatch(text)
    return (match[1], match[2].strip()) if match and _is_quotient(match[1], match[2].strip()) else (text, "")


def _is_quotient(name: str, unit_text: str) -> bool:
    """Whether a text is the name of a signal over its unit, as ``s/mm``, unlike ``N/mm`` and ``Weg/s``."""
    unit = signal_unit(unit_text)
    if unit is None:
        return False
    kinds = [KINDS[role] for role, word in WORDS.items() if word.fullmatch(name)]
    return unit[0] in (*kinds, "voltage") if kinds else signal_unit(name) is None


def _unit_at_end(name: str) -> Unit | None:
    """Return the unit at the end of a name, as of ``velocity_mm_s`` and ``Laser mm``."""
    words = name.split("_")
    for count in (2, 1):
        if len(words) > count and (unit := signal_unit("_".join(words[-count:]))):
            return unit
    first, _, last = name.rpartition(" ")
    unit = signal_unit(last) if "/" in last or last.casefold() in _BY_NAME else None
    if not first or last.casefold() in {"in", "min", "mil"} or unit is None:
        return None
    kinds = {KINDS[role] for role, word in WORDS.items() if word.fullmatch(first)}
    return unit if len(last) > 1 or unit[0] in kinds else None


# Possessive quantifiers: the time for a cell is proportional to its length.
DECIMAL: Final = re.compile(r"[+-]?+(?:[0-9]++[.,]?+[0-9]*+|[.,][0-9]++)(?:[eEdD][+-]?+[0-9]++)?+")
# What programs write instead of a number: without a value, and after an error.
NO_VALUE: Final = re.compile(
    r"[+-]?nan|#?n/?a|n\.?a\.|null|none|[-?*]+|[+-]?1\.#(?:qnan|snan|ind)\w*", re.IGNORECASE
)
DELETE: Final = "delete those rows, or keep the part before or after them"


Flags = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Table:
    """Columns of a file of any format, from which ``read_record`` takes the signals that are wanted.

    A reader of a format returns one: names, columns and units are all that it has to give. Which column is
    which signal, sensitivities, rows without a value and the clock are the business of ``read_record``.

    Attributes
    ----------
    path : Path
        The file, for messages.
    names : sequence of str
        Name of each column, which may hold its unit: ``Acc along`` or ``Acc along [g]``; all empty if the
        file has none. Messages list them, and users choose by them, or by their numbers, from 1.
    columns : sequence of array
        Values of each column, as long as one another: floats, NaN where there is no value; whole numbers, as
        of a clock of nanoseconds; or cells as text, if one of them is no number.
    units : sequence of str
        Unit of each column as the file spells it; empty for one without, whose name may hold it then.
    rows : sequence of int
        Number of each row in the file, for messages; from 1 if it is left out.
    also : sequence of sequence of str
        More names of the columns, such as a row of descriptions; users may choose by them too.
    notes : sequence of str
        How the file was read, for the user.
    cell : callable, optional
        The text of a cell in the file, by the index of its row and by its column from 0.
    """

    path: Path
    names: Sequence[str]
    columns: Sequence[NDArray[Any]]
    units: Sequence[str] = ()
    rows: Sequence[int] = ()
    also: Sequence[Sequence[str]] = ()
    notes: Sequence[str] = ()
    cell: Callable[[int, int], str] | None = None

    def row(self, index: int) -> int:
        """Return the number in the file of a row."""
        return int(self.rows[index]) if len(self.rows) else index + 1

    def is_empty(self, index: int) -> bool:
        """Whether a row holds no number at all, but perhaps a text."""
        cells = [column[index] for column in self.columns]
        return not any(DECIMAL.fullmatch(x) if isinstance(x, str) else x == x for x in cells)

    @np.errstate(over="ignore", invalid="ignore")  # of values that are refused
    def numbers(self, header: Header, unit: float, cells: NDArray[Any] | None = None) -> Floats:
        """Read a column, or other cells in its place, in SI units; NaN for cells without a value."""
        cells = self.columns[header.place] if cells is None else cells
        values, bad = np.full(cells.size, np.nan), np.zeros(cells.size, np.bool_)
        if cells.dtype != object:
            values = np.asarray(cells * unit, np.float64)
            bad = np.abs(values) > LARGEST
        else:
            for i, cell in enumerate(cells):
                if DECIMAL.fullmatch(cell):
                    values[i] = float(cell) * unit
                    bad[i] = not abs(values[i]) <= LARGEST
                else:
                    bad[i] = bool(cell) and not NO_VALUE.fullmatch(cell) and not self.is_empty(i)
        if bad.any():
            raise InputError(*self.named(header, bad, values, LARGEST / abs(unit)), hint=DELETE)
        return values

    @np.errstate(over="ignore", invalid="ignore")
    def times(self, header: Header, unit: float) -> tuple[Floats, Floats]:
        """Read a column of times [s], NaN where there is none; and times after which it may start anew."""
        cells = self.columns[header.place]
        if clocks.is_clock(cells):
            time, periods = clocks.seconds_of(cells)
            bad = np.isnan(time)
            bad[bad] = [bool(cells[i]) and not self.is_empty(i) for i in np.flatnonzero(bad).tolist()]
            if bad.any():
                raise InputError(*self.named(header, bad, np.full(time.size, np.nan)), hint=DELETE)
            return time - time[~np.isnan(time)][0], periods
        if (
            cells.dtype != object
            and (there := cells[cells == cells]).size
            and abs(there[0]) * unit > _LONG_AGO
        ):
            cells = cells - there[0]  # doubles would round nanoseconds since 1970
        return self.numbers(header, unit, cells), clocks.overflows(unit, whole=cells.dtype.kind in "iu")

    def named(self, header: Header, bad: Flags, values: Floats, most: float = math.nan) -> list[str]:
        """Describe the first bad cells of a column, and count the others; one with a value is too large."""
        problems, places, column = [], np.flatnonzero(bad).tolist(), f"column {shown(header.text)}"
        for i in places[:CELLS_NAMED]:
            cell = self.cell(i, header.place) if self.cell else str(self.columns[header.place][i])
            what = f"{shown(cell)} is not a number" if cell else "the cell is empty"
            if DECIMAL.fullmatch(cell) and not math.isnan(values[i]):
                what = f"{cut(cell)} is too large to compute with, at most {most:g} is allowed"
            problems.append(f"{self.path}: row {self.row(i)}, {column}: {what}")
        if (more := len(places) - CELLS_NAMED) > 0:
            problems.append(f"{self.path}: {column}: {more} more such cell{'s' if more > 1 else ''}")
        return problems
