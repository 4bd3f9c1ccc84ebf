"""Tables as text: CSV with the fewest digits that read back as the same doubles."""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from vibro.files.arrow_arrays import number_array, text_array

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    import pyarrow as pa
    from numpy.typing import NDArray

# Numbers, or texts, by their header.
TableColumns: TypeAlias = "Mapping[str, NDArray[np.float64] | Sequence[str]]"


@dataclass(frozen=True)
class CsvFormat:
    """How a CSV is written.

    Attributes
    ----------
    decimal_comma : bool
        Whether decimals are written with a comma, and cells separated by semicolons.
    """

    decimal_comma: bool = False

    @property
    def separator(self) -> str:
        """Separator between cells."""
        return ";" if self.decimal_comma else ","

    def header(self, names: Iterable[str]) -> bytes:
        """Return the first line."""
        return self._quoted([list(map(_harmless, names))]).encode()

    def rows(self, cells: pa.Table) -> bytes:
        """Return the lines of an Arrow table of numbers and texts.

        Returns
        -------
        bytes
            UTF-8. Null is an empty cell. Texts are quoted where they must be, and those that a spreadsheet
            would take for a formula begin with an apostrophe.
        """
        import pyarrow as pa
        import pyarrow.csv as arrow_csv

        whole = [column.combine_chunks() for column in cells.columns]
        columns = list(map(self._plain, whole))
        if any(map(self._needs_quotes, whole)):  # pyarrow quotes all texts, or none
            texts = (column.cast(pa.string()).fill_null("").to_pylist() for column in columns)
            return self._quoted(zip(*texts, strict=True)).encode()
        style = arrow_csv.WriteOptions(include_header=False, delimiter=self.separator, quoting_style="none")
        stream = pa.BufferOutputStream()
        arrow_csv.write_csv(pa.Table.from_arrays(columns, cells.column_names), stream, style)
        written: bytes = stream.getvalue().to_pybytes()
        return written

    def table(self, columns: TableColumns) -> bytes:
        """Return a whole table of columns of equal length, by their header; non-finite numbers are empty."""
        import pyarrow as pa

        arrays = [
            number_array(c, c.shape, np.isfinite(c)) if isinstance(c, np.ndarray) else text_array(c)
            for c in columns.values()
        ]
        return self.header(columns) + self.rows(pa.Table.from_arrays(arrays, list(columns)))

    def _plain(self, column: pa.Array) -> pa.Array:
        """Return a column as it is written."""
        import pyarrow as pa
        import pyarrow.compute as pc

        if pa.types.is_dictionary(column.type):
            return pa.DictionaryArray.from_arrays(column.indices, self._plain(column.dictionary))
        if pa.types.is_string(column.type):
            return text_array(map(_harmless, column.to_pylist()))
        if self.decimal_comma and pa.types.is_floating(column.type):
            return pc.replace_substring(column.cast(pa.string()), ".", ",")
        return column

    def _needs_quotes(self, column: pa.Array) -> bool:
        import pyarrow as pa
        import pyarrow.compute as pc

        texts = column.dictionary if pa.types.is_dictionary(column.type) else column
        if not pa.types.is_string(texts.type):
            return False
        return bool(pc.any(pc.match_substring_regex(texts, f'[{self.separator}"\\r\\n]')).as_py())

    def _quoted(self, rows: Iterable[Iterable[str]]) -> str:
        stream = io.StringIO()
        csv.writer(stream, delimiter=self.separator, lineterminator="\n").writerows(rows)
        return stream.getvalue()


def column_of(values: Sequence[Any]) -> NDArray[np.float64] | Sequence[str]:
    """Return a column of a table: texts, or numbers that are NaN where there is None."""
    if any(isinstance(value, str) for value in values):
        return [value or "" for value in values]
    return np.array(values, np.float64)


def columns_of(rows: Sequence[Mapping[str, Any]]) -> TableColumns:
    """Return rows of the same keys as columns."""
    return {key: column_of([row[key] for row in rows]) for key in rows[0]}


def _harmless(text: str) -> str:
    return f"'{text}" if text.startswith(("=", "+", "-", "@")) else text
