"""Tables as Parquet, a row group per block: exact numbers, nulls for missing ones, encoded texts."""

from __future__ import annotations

import hashlib
import json
from inspect import signature
from typing import TYPE_CHECKING, Any, BinaryIO, Final

from vibro.output.plan import ROW_GROUP
from vibro.quantities import BY_COLUMN, DRIVES, QUANTITIES, SWEPT
from vibro.sweeps.columns import arrow_table

if TYPE_CHECKING:
    from collections.abc import Mapping

    from vibro.results.sweep import Block, Column
    from vibro.sweeps.columns import Table
    from vibro.sweeps.grid import Grid

__all__ = ["HashedFile", "Parquet", "read_footer"]

# Of zstd: higher levels take longer and save almost no space (benchmarks/sweeps.py --encodings).
_LEVEL: Final = -1
# [cells] of a page: compression starts anew with each, and larger pages do not fit into the core's cache.
_PAGE: Final = ROW_GROUP // 2
_FOOTER: Final = b"vibro"  # key of the record in a footer
_GIVEN: Final = frozenset(QUANTITIES[name].column for name in (*SWEPT, *DRIVES))
# Cells lack no input, but a machine whose masses strike has no amplitude, and a crank no springs.
_NEVER_NULL: Final = _GIVEN - {QUANTITIES[name].column for name in ("amplitude", "natural")}


class HashedFile:
    """A file that is written once, and knows the SHA-256 and the size of what was written.

    Parameters
    ----------
    file : binary file
        Where to.
    """

    def __init__(self, file: BinaryIO) -> None:
        self._file = file
        self._digest = hashlib.sha256()
        self.size = 0
        self.closed = False

    @property
    def digest(self) -> str:
        """SHA-256 in hexadecimal."""
        return self._digest.hexdigest()

    def write(self, data: Any) -> int:
        """Write bytes, or any object with a buffer."""
        self._digest.update(data)
        self.size += len(data)
        return self._file.write(data)

    def tell(self) -> int:
        """Return how much has been written."""
        return self.size

    def writable(self) -> bool:
        """Whether it can be written: yes."""
        return True

    def flush(self) -> None:
        """Write the buffered rows."""
        self._file.flush()

    def close(self) -> None:
        """End; the file itself stays open."""
        self.closed = True


class Parquet:
    """Parquet; the bytes follow from the cells and the record alone."""

    def open(self, file: Any, grid: Grid, table: Table) -> None:
        """Begin a file."""
        import pyarrow as arrow

        self._table = table
        self._schema = arrow.schema([_field(column, arrow) for column in table.columns])
        self._writer = _open_writer(file, self._schema)

    def write(self, block: Block) -> None:
        """Write cells as one row group."""
        import pyarrow as arrow

        cells = arrow_table(self._table.columns, block, self._table.digits)
        self.copy(arrow.Table.from_arrays(cells.columns, schema=self._schema))

    def copy(self, cells: Any) -> None:
        """Write cells that pyarrow has read as one row group."""
        self._writer.write_table(cells, ROW_GROUP)

    def close(self, record: Mapping[str, Any] | None = None) -> None:
        """End the file, once; its footer has the record with a checksum, as Parquet has none of it."""
        if record is not None:
            text = json.dumps(record)
            footer = {**record, "sha256": hashlib.sha256(text.encode()).hexdigest()}
            self._writer.add_key_value_metadata({_FOOTER: json.dumps(footer)})
        self._writer.close()


def read_footer(metadata: Any) -> dict[str, Any]:
    """Return the record in the footer of a file, with its checksum; empty if it has none."""
    content: dict[str, Any] = json.loads((metadata.metadata or {}).get(_FOOTER, b"{}"))
    return content


def _open_writer(sink: Any, schema: Any) -> Any:
    import pyarrow as arrow
    from pyarrow import parquet

    numbers = [field.name for field in schema if arrow.types.is_floating(field.type)]
    # Newer ones also cut pages after 20 000 rows.
    known = signature(parquet.ParquetWriter).parameters
    rows = {name: _PAGE for name in ("max_rows_per_page",) if name in known}
    return parquet.ParquetWriter(
        sink,
        schema,
        compression="zstd",
        compression_level=_LEVEL,
        use_dictionary=[field.name for field in schema if field.name not in numbers] or False,
        # Values of inputs repeat: splitting their bytes takes longer and saves no space.
        use_byte_stream_split=[name for name in numbers if name not in _GIVEN] or False,
        # Statistics of the axes alone select row groups: results follow no order.
        write_statistics=[name for name in schema.names if name in BY_COLUMN] or False,
        write_page_checksum=True,
        data_page_size=8 * _PAGE,
        write_batch_size=_PAGE,
        **rows,
    )


def _field(column: Column, arrow: Any) -> Any:
    """Describe a column. To say where there are no nulls saves a tenth of the time of encoding."""
    if column.is_number:
        return arrow.field(column.name, arrow.float64(), nullable=column.name not in _NEVER_NULL)
    if column.is_flag:
        return arrow.field(column.name, arrow.int8())
    return arrow.field(column.name, arrow.dictionary(arrow.int32(), arrow.string()), nullable=False)
