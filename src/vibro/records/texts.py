"""Tables of numbers in text files: the first row of numbers, names and units; pandas reads the cells."""

from __future__ import annotations

import contextlib
import csv
import io
import re
import warnings
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vibro.errors import InputError, shown
from vibro.files.reading import read_text
from vibro.records.channels import DECIMAL, NO_VALUE, WORDS, Table, signal_unit, unit_of_header
from vibro.records.clocks import CLOCK
from vibro.records.formats import lvm_table

_LOOKED_AT, _HEADERS = 300, 20  # rows of data and above it, and of those that may be headers
_LONG: Final = 10_000  # characters of a row whose cells are counted first: pandas takes a minute for 300 000
#: What parts cells, in the order in which it is tried, and its name; a space stands for any number of them.
_SEPARATORS: Final = {";": "semicolons", "\t": "tabs", ",": "commas", " ": "spaces", "": ""}
_APART: Final = re.compile(r'"[^"]*"|\S+')
#: Names of columns apart by spaces, which have them before a unit in brackets too: ``t [s] ax [m/s^2]``.
_BRACKETED: Final = (
    r"(?:\[[^\]]{0,200}\]|\([^)]{0,200}\))"  # not to the end of a line of a million characters
)
_NAMES: Final = re.compile(rf'(?:"[^"]*"|[^\s\[("]+)(?:\s*{_BRACKETED})?')
#: Acc X [g] Acc Z [g]. One begins behind a bracket, so that a long line without any is looked at once.
_WORDY: Final = re.compile(rf"(?:^|(?<=[\[\](\)]))[^\[(]{{1,200}}{_BRACKETED}")
_COMMENT: Final = re.compile(r"^\s*(?:[#%;!*]+|//+)\s*")
_UNIT: Final = re.compile(r"\[(.*)\]|\((.*)\)|([^\[\]]{1,12})")  # a cell that holds nothing else
_OTHER_UNIT: Final = re.compile(r"°[CF]?|%|k?Hz|rpm|deg(?:/s)?|rad(?:/s)?|[kM]?Pa|bar|m?A|k?W|kg|Nm|K|dB")
_NOTHING: Final = re.compile(r"[-\s\[\]()]*")  # a column without a unit
# Marks between thousands: of numbers that hold no decimal mark, or the other one, or several of them.
_SPACES: Final = re.compile("(?<=[0-9])['\u2019\u00a0\u202f ](?=[0-9]{3}(?![0-9]))")
_GROUPED: Final = re.compile(
    "[+-]?[0-9]{1,3}(?:(?:,[0-9]{3})+\\.[0-9]*|(?:\\.[0-9]{3})+,[0-9]*|(?:[,.'\u2019\u00a0\u202f ][0-9]{3})+)"
)
_BEFORE, _GROUP = r"(?<![0-9.,:])", r"[1-9][0-9]{0,2}"
_THOUSANDS: Final = {
    mark: re.compile(rf"{_BEFORE}{_GROUP}(?:\{mark}[0-9]{{3}})+(?:\{mark}[0-9]{{3}}|\{other}[0-9])")
    for mark, other in ((",", "."), (".", ","))
}
# A mark that may stand between thousands, and one that cannot.
_MAYBE_THOUSANDS: Final = {
    mark: re.compile(rf"{_BEFORE}{_GROUP}\{mark}[0-9]{{3}}(?![0-9.,eE])") for mark in _THOUSANDS
}
_DECIMALS: Final = {
    mark: re.compile(
        rf"{_BEFORE}(?:(?:0[0-9]*|[0-9]{{4,}})\{mark}[0-9]"
        rf"|[0-9]*\{mark}(?:[0-9]{{1,2}}(?![0-9])|[0-9]{{4}}|[0-9]+[eE]))(?![0-9]*[.,][0-9])"
    )
    for mark in _THOUSANDS
}
_FORTRAN: Final = re.compile("(?<=[0-9.])[dD](?=[+-]?[0-9])")  # 1.5D+03
_MISSING: Final = ["-", "--", "?", "*", "***"]  # besides what pandas takes as missing


def is_value(cell: str) -> bool:
    """Whether a cell holds a number or a time of day."""
    return any(pattern.fullmatch(cell) for pattern in (DECIMAL, _GROUPED, CLOCK))


def _is_name(cell: str) -> bool:
    return cell != "" and not is_value(cell) and not NO_VALUE.fullmatch(cell)


def _cells(line: str, separator: str) -> list[str]:
    """Part a line into cells."""
    if separator == " ":
        return [word.strip('"') for word in _APART.findall(line)]
    if '"' in line and separator:
        with contextlib.suppress(csv.Error):  # a quote that nothing closes before 131 072 characters
            return [cell.strip() for cell in next(csv.reader([line], delimiter=separator), [])]
    return [cell.strip() for cell in (line.split(separator) if separator else [line])]


class _Layout(NamedTuple):
    """What parts the cells of rows of data; how many hold anything, and are there; which hold values."""

    separator: str
    width: int
    most: int
    places: list[int]

    def cells(self, line: str) -> list[str]:
        return _cells(line, self.separator)

    def is_data(self, line: str) -> bool:
        """Whether a line has values wherever rows of data have them, but for empty cells."""
        cells = self.cells(line)
        own = [cells[i] for i in self.places] if len(cells) > self.places[-1] else []
        return any(map(is_value, own)) and all(not c or is_value(c) or NO_VALUE.fullmatch(c) for c in own)


def _layout(lines: Sequence[str]) -> _Layout | None:
    """Return the layout of lines that are mostly data: that with the most values among its cells."""
    best, layout = 0.0, None
    for separator in _SEPARATORS:
        rows = [_cells(line, separator) for line in lines]
        values = [[is_value(cell) for cell in cells] for cells in rows]
        counts = Counter(map(sum, values))
        usual = max(counts, key=lambda count: (min(count, 2), counts[count], count))
        data = [i for i, flags in enumerate(values) if sum(flags) >= usual]
        most = Counter(len(rows[i]) for i in data).most_common(1)[0][0]
        held = np.zeros((2, most))
        for i in data:
            held[:, : len(rows[i])] += np.array([values[i], [cell != "" for cell in rows[i]]])[:, :most]
        places = np.flatnonzero(2.0 * held[0] >= len(data)).tolist()
        share = sum(sum(v) / max(1, sum(map(bool, r))) for v, r in zip(values, rows, strict=True)) / len(rows)
        if usual and places and share > best and (not separator or max(map(len, rows)) > 1):
            best, layout = share, _Layout(separator, int(np.flatnonzero(held[1])[-1]) + 1, most, places)
    return layout


def text_table(path: Path) -> Table:
    """Read a table of numbers from a text file.

    Parameters
    ----------
    path : Path
        Rows of numbers whose cells are apart by commas, semicolons, tabs or spaces, with decimal points or
        commas. Above may stand rows of names, descriptions and units, behind a mark of comments or not, and
        any other lines; below lines that hold no data.

    Returns
    -------
    Table
        Its first row of data is the first one that is like most rows behind the middle of the file.

    Raises
    ------
    FileError
        If the file cannot be read.
    InputError
        If it holds no rows of numbers, or commas that may be decimal, between thousands or between cells.
    """
    text, notes = read_text(path)
    if text.startswith("LabVIEW Measurement"):
        text, left_out = lvm_table(path, text)
        notes += left_out
    lines = text.replace("\u2212", "-").replace("\r\n", "\n").replace("\r", "\n").split("\n")
    filled = [i for i, line in enumerate(lines) if line and not line.isspace()]
    middle = len(filled) // 2
    layout = _layout([lines[i] for i in filled[middle : middle + _LOOKED_AT]]) if filled else None
    first = next((n for n, i in enumerate(filled) if layout and layout.is_data(lines[i])), None)
    if layout is None or first is None:
        none = f"{path}: no table of numbers found"
        raise InputError(none, hint="it needs rows of numbers under a row of names")
    above, data = [(i, lines[i]) for i in filled[:first]], filled[first:]
    widths = Counter(len(layout.cells(lines[i])) for i in data[:_LOOKED_AT])
    if (wide := widths.most_common(1)[0][0]) > layout.most:  # of columns that end before the middle
        layout = layout._replace(width=wide, most=wide)
    layout = _with_sure_commas(path, layout, above, [(i, lines[i]) for i in data[:_LOOKED_AT]])
    names, units, also, lowest = _header(above, layout)
    one, two = ([*map(str.strip, layout.cells(lines[i]))] for i in (data * 2)[:2])
    if not names and one in ([f"{i + n}" for i in range(len(one))] for n in (0, 1)) and "." in "".join(two):
        data = data[1:]  # the first row counts the columns
    while len(data) > 1 and not is_value("".join(layout.cells(lines[data[-1]])[layout.places[0] :][:1])):
        data.pop()
    odd = [i for i in filled if lowest < i < data[0] or i > data[-1] if not _COMMENT.match(lines[i])]
    if odd:
        count = f"{len(odd)} row{'s' if len(odd) > 1 else ''} without data"
        notes.append(f"{path.name}: skipped {count}: row {odd[0] + 1}, {shown(lines[odd[0]].strip())}")
    columns, decimals = _columns(path, layout, lines, data)
    if layout.separator not in {",", ""} or decimals:
        notes.append(f"{path.name}: separated by {_SEPARATORS[layout.separator]}{decimals}")
    columns = columns[: max(layout.width, len(names))]
    rows = [(row + [""] * len(columns))[: len(columns)] for row in (names, units, *also)]

    def cell(row: int, place: int) -> str:
        return "".join(layout.cells(lines[data[row]])[place : place + 1])

    return Table(path, rows[0], columns, rows[1], [i + 1 for i in data], rows[2:], notes, cell=cell)


def _with_sure_commas(
    path: Path, layout: _Layout, above: list[tuple[int, str]], data: list[tuple[int, str]]
) -> _Layout:
    """Refuse whole numbers between commas that may as well be decimals, unless names above count them."""
    rows, width = [layout.cells(line) for _, line in data], layout.width
    whole = all(cell.strip("+-").isdecimal() for row in rows for cell in row if cell)
    named = len(_cells(_COMMENT.sub("", above[-1][1]), ",")) if above else 0
    if layout.separator != "," or width % 2 or not whole or named >= width:
        return layout
    decimal = any(row[0] == "-0" or re.fullmatch("0[0-9]+", row[1]) for row in rows if len(row) > 1)
    if width == 2 and (named == 1 or decimal):
        return _Layout("", 1, 1, [0])
    doubt = (
        f"{path}: row {data[0][0] + 1}, {shown(data[0][1].strip())}: commas may be decimal, or between cells"
    )
    names = ",".join("abcdefgh"[:width]) if width <= 8 else "a,b,..."
    one = "one column in a row above, a, or " if width == 2 else ""
    hint = f"put semicolons between the cells; or name {one}{width} columns in a row above: {names}"
    raise InputError(doubt, hint=hint)


def _names_in(line: str, layout: _Layout) -> list[str]:
    """Part a line above the data as if it named the columns; empty if it has another number of cells."""
    for text in (_COMMENT.sub("", line), line):
        marks = (layout.separator, ";", "\t", ",") if layout.separator != " " else (";", "\t", ",")
        words = [word.replace('"', "") for word in _NAMES.findall(text)]
        parted = [_cells(text, mark) for mark in marks]
        wordy = [*map(str.strip, _WORDY.findall(text))]
        for cells in (*parted, re.split(r"\s{2,}", text.strip()), words, wordy, _cells(text, " ")):
            while len(cells) > layout.width and not cells[-1]:
                cells.pop()
            if layout.width <= len(cells) <= layout.most and any(cells):
                return [_COMMENT.sub("", cells[0]), *cells[1:]]
    return []


def _header(
    above: list[tuple[int, str]], layout: _Layout
) -> tuple[list[str], list[str], list[list[str]], int]:
    """Find names of columns, units, and what else describes them, above the data; and the lowest line."""
    whole: list[tuple[int, str]] = []  # a quoted cell may go over lines
    for i, line in above[-_LOOKED_AT:]:
        before = whole.pop()[1] + " " if whole and whole[-1][1].count('"') % 2 else ""
        whole.append((i, before + line))
    rows = {i: cells for i, line in reversed(whole) if (cells := _names_in(line, layout))}
    rows = {i: cells for i, cells in rows.items() if not all(map(_NOTHING.fullmatch, cells))}
    units = next((i for i in [*rows][:_HEADERS] if _are_units(rows[i], alone=len(rows) == 1)), -1)
    rest = [i for i in rows if i != units][:_HEADERS]

    def rank(i: int) -> tuple[bool, bool, bool]:
        plain, stated = not any(map(is_value, rows[i])), any(map(unit_of_header, rows[i]))
        tells = stated or rows[i][0] == "Name" or any(map(WORDS["time"].fullmatch, rows[i]))
        return tells and plain, tells, plain

    at = rest.index(max(rest, key=rank)) if rest else 0
    near = [i for i in rest[max(0, at - 2) : at + 3] if i == rest[at] or all(map(_is_name, rows[i]))]
    also = [rows[i] for i in near if i != rest[at]]
    texts = ["" if _NOTHING.fullmatch(text) else text.strip("[]()") for text in rows.get(units, [])]
    return rows[rest[at]] if rest else [""] * len(texts), texts, also, max([units, *near])


def _are_units(cells: list[str], *, alone: bool) -> bool:
    """Whether cells are mostly units, in brackets or not, and dashes; all of them if the row stands alone."""
    texts = [text for text in cells if not _NOTHING.fullmatch(text)]
    plain = [match[1] or match[2] or match[3] for text in texts if (match := _UNIT.fullmatch(text))]
    known = sum(signal_unit(text) is not None for text in plain)
    known += (known > 0) * sum(_OTHER_UNIT.fullmatch(text) is not None for text in plain)
    return len(plain) == len(texts) and (known == len(texts) if alone else 2 * known > len(texts))


def _columns(
    path: Path, layout: _Layout, lines: Sequence[str], data: list[int]
) -> tuple[list[NDArray[Any]], str]:
    """Read the cells of some lines, an array for each column: numbers, or texts if one is no number.

    Returns how decimals are marked too, for a note.
    """
    import pandas as pd  # half of the command's time to start

    separator, own = layout.separator or "\x1f", [lines[i] for i in data]
    if separator == " ":  # no telling which cells of a short row are missing
        own = ["-" if len(line.split()) < layout.width else line for line in own]
    _refuse_wider_rows(path, layout, [line if len(line) > _LONG else "" for line in own], data)
    body = "\n".join(own)
    if '"' in body:
        body, separator = "\n".join(["\t".join(layout.cells(line)) for line in own]), "\t"
    body, decimals = _with_decimal_points(path, _FORTRAN.sub("e", body), separator, data)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", pd.errors.ParserWarning)  # of cells that would be left out
            frame = pd.read_csv(
                io.StringIO(body), sep=r"\s+" if separator == " " else separator, engine="c", header=None,
                names=range(layout.most), index_col=False, na_values=_MISSING,
                skipinitialspace=True, skip_blank_lines=False, quoting=csv.QUOTE_NONE, low_memory=False,
            )  # fmt: skip
    except (pd.errors.ParserError, pd.errors.ParserWarning):  # of a line with more cells, which may be empty
        _refuse_wider_rows(path, layout, own, data)
        own = ["\t".join(layout.cells(line)[: layout.most]) for line in own]
        return _columns(path, layout._replace(separator="\t"), own, [*range(len(own))])
    columns = []
    for _, column in frame.items():
        if column.dtype.kind not in "iuf":
            column = column.astype(object).map(lambda cell: str(cell).strip(), na_action="ignore").fillna("")
        columns.append(column.to_numpy())
    return columns, decimals


def _refuse_wider_rows(path: Path, layout: _Layout, lines: Sequence[str], data: list[int]) -> None:
    """Refuse rows of data that have more cells than the others, unless these are empty."""
    for i, line in enumerate(lines):
        cells = layout.cells(line)
        if any(cells[layout.most :]):
            where = f"{path}: row {data[i] + 1} has {len(cells)} cells, others have {layout.most}"
            hint = "delete what does not belong to it; decimal commas need semicolons between the cells"
            raise InputError(where, hint=hint) from None


def _with_decimal_points(path: Path, body: str, separator: str, data: list[int]) -> tuple[str, str]:
    """Take marks between thousands out of rows of data, make decimal commas points, and say so."""
    if separator != " ":
        body = _SPACES.sub("", body)
    if "," not in body or separator == ",":
        return body, ""
    maybe, sure = ({m for m, p in kinds.items() if p.search(body)} for kinds in (_MAYBE_THOUSANDS, _DECIMALS))
    found = [mark for mark, pattern in _THOUSANDS.items() if pattern.search(body)]
    mark = next(iter(found or (sorted(maybe - sure) if sure else [])), "")
    if mark:
        body = re.sub(rf"(?<=[0-9])\{mark}(?=[0-9]{{3}}(?![0-9]))", "", body)
    elif (doubtful := _MAYBE_THOUSANDS[","].search(body)) and "," not in sure:
        row, text = data[body.count("\n", 0, doubtful.start())] + 1, doubtful[0]
        plain = f"{text.replace(',', '.')} or {text.replace(',', '')}"
        raise InputError(f"{path}: row {row}: {text} may be {plain}", hint="write decimal points")
    marks = f", {'points' if mark == '.' else 'commas'} between thousands" if mark else ""
    return body.replace(",", "."), ("" if mark == "," else ", decimal commas") + marks
