"""Tables as text: CSV with exact floats, or rounded to significant digits."""

from __future__ import annotations

import csv
import io
import math
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import numpy as np

from vibro.files.rounding import rounded

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from vibro.results.sweep import Block, Column

__all__ = ["CsvFormat", "TableColumns", "rounded_cells"]

# [cells] from which a block is worth the import of pyarrow
_WORTH_ARROW: Final = 50_000

# Numbers, or texts, by their header.
TableColumns: TypeAlias = "Mapping[str, NDArray[np.float64] | Sequence[str]]"


@dataclass(frozen=True)
class CsvFormat:
    """How a CSV is written.

    Attributes
    ----------
    excel : bool
        Whether it begins with a byte order mark, by which spreadsheets know UTF-8.
    decimal_comma : bool
        Whether decimals are written with a comma, and cells separated by semicolons.
    digits : int or None
        Significant digits of the numbers of ``rows``; None where they are exact.
    """

    excel: bool = False
    decimal_comma: bool = False
    digits: int | None = None

    @property
    def separator(self) -> str:
        """Separator between cells."""
        return ";" if self.decimal_comma else ","

    def header(self, columns: Sequence[Column]) -> str:
        """Return the first line."""
        return ("\ufeff" if self.excel else "") + self.separator.join(c.name for c in columns) + "\n"

    def rows(self, columns: Sequence[Column], block: Block) -> str:
        """Return the lines of a block, one a cell, in the order of its cells.

        Parameters
        ----------
        columns : sequence of Column
            What to write.
        block : Block
            Solved cells.

        Returns
        -------
        str
            Floats have the fewest digits that read back as the same double, once rounded if they are to be;
            no number is an empty cell.
        """
        number = math.prod(block.shape)
        if not number:
            return ""
        if number >= _WORTH_ARROW and (arrow := _arrow()):
            return self._rows_by_arrow(columns, block, arrow)
        cells = [self._cells(column, block) for column in columns]
        return "\n".join(map(self.separator.join, zip(*cells, strict=True))) + "\n"

    def _rows_by_arrow(self, columns: Sequence[Column], block: Block, arrow: Any) -> str:
        """Return the same lines, faster (benchmarks/share.py)."""
        cells = [self._arrow_cells(column, block, arrow) for column in columns]
        lines = arrow.compute.binary_join_element_wise(*cells, self.separator)
        text: bytes = arrow.compute.binary_join_element_wise(lines, "", "\n").buffers()[2].to_pybytes()
        return text.decode()

    def _arrow_cells(self, column: Column, block: Block, arrow: Any) -> Any:
        which: NDArray[np.integer[Any]]
        if column.is_number:
            values = rounded_cells(column, block, self.digits)
            texts = self._arrow_numbers(values.ravel(), arrow)
            if values.shape == block.shape:
                return texts
            which = np.arange(values.size).reshape(values.shape)
        else:
            which, known = column.coded(block)
            texts = arrow.array(known)
        return texts.take(arrow.array(np.broadcast_to(which, block.shape).ravel()))

    def _arrow_numbers(self, values: NDArray[np.float64], arrow: Any) -> Any:
        texts = arrow.compute.cast(arrow.array(values), arrow.string())
        if self.decimal_comma:
            texts = arrow.compute.replace_substring(texts, ".", ",")
        finite = np.isfinite(values)
        texts = arrow.compute.if_else(arrow.array(finite), texts, "")
        # Outside this range it writes exponents where Python does not, or the other way round.
        size = np.abs(values)
        others = finite & ~((size >= 1e-4) & (size < 1e10) | (size == 0.0))
        return arrow.compute.replace_with_mask(
            texts, arrow.array(others), arrow.array(self._numbers(values[others]), arrow.string())
        )

    def table(self, columns: TableColumns) -> str:
        """Return a whole table of columns of equal length.

        Parameters
        ----------
        columns : mapping of str to array or sequence of str
            By their header.

        Returns
        -------
        str
            Numbers as ``rows`` writes them. Texts are quoted where they must be, and those that a spreadsheet
            would take for a formula begin with an apostrophe.
        """
        stream = io.StringIO()
        writer = csv.writer(stream, delimiter=self.separator, lineterminator="\n")
        writer.writerow([_harmless(name) for name in columns])
        cells = [
            self._numbers(values) if isinstance(values, np.ndarray) else list(map(_harmless, values))
            for values in columns.values()
        ]
        writer.writerows(zip(*cells, strict=True))
        return ("\ufeff" if self.excel else "") + stream.getvalue()

    def _cells(self, column: Column, block: Block) -> list[str]:
        # Only the values that differ are converted: an axis has few, however many cells there are.
        if column.is_number:
            values = rounded_cells(column, block, self.digits)
            texts = np.array(self._numbers(values.ravel()), dtype=object).reshape(values.shape)
        else:
            which, known = column.coded(block)
            texts = known[which]
        return np.broadcast_to(texts, block.shape).ravel().tolist()

    def _numbers(self, values: NDArray[np.float64]) -> list[str]:
        texts = list(map(float.__repr__, values.tolist()))
        for i in np.flatnonzero(~np.isfinite(values)):
            texts[i] = ""
        for i in np.flatnonzero(values == np.trunc(values)):
            texts[i] = texts[i].removesuffix(".0")
        return [text.replace(".", ",") for text in texts] if self.decimal_comma else texts


def rounded_cells(column: Column, block: Block, digits: int | None) -> NDArray[np.float64]:
    """Return the values of a column of numbers, as it does, but to so many significant digits."""
    values = column.values(block)
    return values if digits is None else rounded(values, digits)


@cache
def _arrow() -> Any:
    """Return pyarrow with its functions, if it is installed: the extra ``fast``."""
    try:
        import pyarrow.compute
    except ImportError:
        return None
    return pyarrow


def _harmless(text: str) -> str:
    return f"'{text}" if text.startswith(("=", "+", "-", "@")) else text
