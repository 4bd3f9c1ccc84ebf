"""A worksheet of XlsxWriter with exact numbers, whose many rows are made while the file is written.

XlsxWriter rounds numbers to 16 digits, where 17 tell every double from its neighbours, and keeps hundreds of
bytes for every cell of a table. So the rows of large tables are made here, some at a time, and numbers are
spelled with the digits that give back the same double.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np
from xlsxwriter.utility import xl_col_to_name, xl_range
from xlsxwriter.worksheet import Worksheet

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

    from numpy.typing import NDArray

__all__ = ["Cells", "Sheet"]

_AT_ONCE: Final = 100_000  # [cells] Few enough that their text stays small beside the table.


class Cells(NamedTuple):
    """A column of some rows: attributes of its cells in XML, and their values, empty without a value."""

    attributes: str
    values: Sequence[str]


class Sheet(Worksheet):  # type: ignore[misc]
    """A worksheet with a head, written by XlsxWriter's methods, and rows below that follow each other."""

    def __init__(self) -> None:
        super().__init__()
        self._head = 0  # rows
        self._rows: Iterable[Sequence[Cells]] | None = None
        self._places: dict[str, str] = {}  # of texts among those of the workbook

    def put_rows(self, first: int, number: int, rows: Iterable[Sequence[Cells]]) -> None:
        """Set the source of the rows below the head, which are made when the file is written.

        Parameters
        ----------
        first, number : int
            The first of these rows, counted from 0, and how many there are.
        rows : iterable of sequence of Cells
            Stretches of rows, each as its columns from the first column on.
        """
        self._head, self._rows = first, rows
        self.dim_rowmax = first + number - 1

    def put_table(
        self, first: int, number: int, names: Sequence[str], style: Any, options: Mapping[str, Any]
    ) -> None:
        """Make an Excel table of a header, in this style, and the rows below it, which ``put_rows`` sets."""
        columns = [{"header": name, "header_format": style} for name in names]
        last = len(names) - 1
        self.add_table(first, 0, first + 1, last, {**options, "columns": columns})
        # It keeps every cell of a table, at hundreds of bytes each: set the true size afterwards.
        whole = xl_range(first, 0, first + number, last)
        self.tables[-1] |= dict.fromkeys(("range", "a_range", "autofilter"), whole)

    def note_texts(self, texts: Iterable[str]) -> None:
        """Register all texts of the rows, before rows are written."""
        for text in dict.fromkeys(texts):
            if text and text not in self._places:
                self._places[text] = str(self.str_table._get_shared_string_index(text))

    def numbers(self, values: NDArray[np.float64], shape: tuple[int, ...], style: Any) -> Cells:
        """Make a column of numbers that broadcast to a shape; of those that are not finite, empty cells."""
        # Only the values that differ are spelled: an axis has few, however many cells there are.
        texts = np.array(list(map(float.__repr__, values.ravel().tolist())), dtype=object)
        texts[~np.isfinite(values.ravel())] = ""
        return self._cells(style, "", texts.reshape(values.shape), shape)

    def strings(
        self, which: NDArray[np.integer[Any]], texts: Sequence[str], shape: tuple[int, ...], style: Any
    ) -> Cells:
        """Make a column of texts, noted before: an array says which, broadcastable to a shape."""
        places = [self._places[text] if text else "" for text in texts]
        return self._cells(style, ' t="s"', np.array(places, dtype=object)[which], shape)

    @property
    def is_complete(self) -> bool:
        """Whether the rows, if any, were written."""
        return self._rows is None

    def _cells(self, style: Any, kind: str, texts: NDArray[np.object_], shape: tuple[int, ...]) -> Cells:
        number = style._get_xf_index()
        return Cells(f' s="{number}"{kind}', np.broadcast_to(texts, shape).ravel().tolist())

    def _xml_number_element(self, number: float, attributes: Iterable[tuple[str, Any]] = ()) -> None:
        told = "".join(f' {key}="{value}"' for key, value in attributes)
        self.fh.write(f"<c{told}><v>{float(number)!r}</v></c>")

    def _write_rows(self) -> None:
        if self._rows is None:
            super()._write_rows()
            return
        last, self.dim_rowmax = self.dim_rowmax, self._head - 1
        super()._write_rows()
        self.dim_rowmax = last
        first = self._head + 1
        for columns in self._rows:
            self.fh.writelines(_row_texts(first, columns))
            first += len(columns[0].values)
        self._rows = None


def _row_texts(first: int, columns: Sequence[Cells]) -> Iterator[str]:
    """Spell rows as XML, the first of them with the number ``first``."""
    heads = [(f'<c r="{xl_col_to_name(place)}', column.attributes) for place, column in enumerate(columns)]
    count, at_once = len(columns[0].values), max(1, _AT_ONCE // len(columns))
    for start in range(0, count, at_once):
        stop = min(start + at_once, count)
        rows = range(first + start, first + stop)
        cells = [
            [
                f'{head}{row}"{attributes}><v>{value}</v></c>' if value else ""
                for row, value in zip(rows, column.values[start:stop], strict=True)
            ]
            for (head, attributes), column in zip(heads, columns, strict=True)
        ]
        for row, parts in zip(rows, zip(*cells, strict=True), strict=True):
            yield f'<row r="{row}">{"".join(parts)}</row>'
