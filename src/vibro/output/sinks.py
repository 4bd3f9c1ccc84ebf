"""Forms of tables: each is a class with the methods of ``Sink``, and a line in ``FORMS``."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any, BinaryIO, Final, Protocol

if TYPE_CHECKING:
    from collections.abc import Mapping

    from vibro.results.sweep import Block
    from vibro.sweeps.columns import Table
    from vibro.sweeps.grid import Grid

__all__ = ["FORMS", "Csv", "Sink", "new_sink"]


class Sink(Protocol):
    """One form of a table, which is written to one file."""

    def open(self, file: BinaryIO, grid: Grid, table: Table) -> None:
        """Begin a table, before any cell is solved.

        Raises
        ------
        InputError
            If the form does not hold so many cells.
        FileError
            If a library is missing.
        """

    def write(self, block: Block) -> None:
        """Add solved cells, in the order of the grid."""

    def close(self, record: Mapping[str, Any]) -> None:
        """End the table, whose run a record describes; the file stays open."""


#: Where the class of each form is; the name is the suffix of its files.
FORMS: Final = {
    "csv": "vibro.output.sinks:Csv",
    "xlsx": "vibro.output.xlsx:Xlsx",
    "parquet": "vibro.output.parquet:Parquet",
}


def new_sink(form: str, **options: Any) -> Sink:
    """Return a new table of a form; ``options`` are those of its class."""
    module, _, name = FORMS[form].partition(":")
    sink: Sink = getattr(import_module(module), name)(**options)
    return sink


class Csv:
    """CSV, as ``CsvFormat`` writes it."""

    def __init__(self, *, excel: bool = False, decimal_comma: bool = False) -> None:
        self._style = excel, decimal_comma

    def open(self, file: BinaryIO, grid: Grid, table: Table) -> None:
        """Write the header."""
        from vibro.files.csv_tables import CsvFormat  # late: listing the forms must not load NumPy

        self._file, self._table = file, table
        self._format = CsvFormat(*self._style)
        self._file.write(self._format.header(column.name for column in table.columns))

    def write(self, block: Block) -> None:
        """Write a row a cell."""
        from vibro.sweeps.columns import arrow_table

        self._file.write(self._format.rows(arrow_table(self._table.columns, block, self._table.digits)))

    def close(self, record: Mapping[str, Any]) -> None:
        """Ignore the record, which has its own file."""
