"""Results as tables: the column list, CSV with exact floats, data frames."""

from __future__ import annotations

import csv
import io
import math
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import numpy as np

from vibro.core.codes import MODELS, Regime, Status
from vibro.quantities import QUANTITIES, from_si, to_si

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    import pandas as pd
    from numpy.typing import NDArray

    from vibro.sweeps.run import Block

__all__ = [
    "ARRIVAL",
    "COLUMNS",
    "STROKES",
    "Column",
    "CsvFormat",
    "TableColumns",
    "columns_with",
    "record",
    "to_frame",
]

# [cells] from which a block is worth the import of pyarrow
_WORTH_ARROW: Final = 50_000

# Numbers, or texts, by their header.
TableColumns: TypeAlias = "Mapping[str, NDArray[np.float64] | Sequence[str]]"


@dataclass(frozen=True)
class Column:
    """One column of every table.

    Attributes
    ----------
    name : str
        Header, with the unit.
    unit : str
        Unit of the numbers; empty for pure numbers and texts.
    values : callable
        From a ``Block`` to an array that broadcasts to its shape: floats, NaN or inf where there is no
        number; texts; or codes into ``texts``.
    texts : tuple of str, optional
        What the codes mean, the last one standing for -1; None for a column of numbers or texts.
    """

    name: str
    unit: str
    values: Callable[[Block], NDArray[Any]]
    texts: tuple[str, ...] | None = None


def _given(name: str) -> Column:
    quantity = QUANTITIES[name]
    return Column(quantity.column, quantity.unit, lambda block: block.values[name])


def _result(name: str, unit: str, attribute: str, scale: float = 1.0) -> Column:
    if scale == 1.0:
        return Column(name, unit, lambda block: np.asarray(getattr(block.cycle, attribute)))
    return Column(name, unit, lambda block: scale * getattr(block.cycle, attribute))


def _traverse_time(block: Block) -> NDArray[np.float64]:
    if block.length is None:
        return np.full((1,) * len(block.shape), np.nan)
    return np.asarray(block.cycle.traverse_time(to_si("trough_length", block.length)))


def _arrival(block: Block) -> NDArray[np.float64]:
    return np.full((1,) * len(block.shape), np.nan) if block.arrival is None else block.arrival


def _strokes(block: Block) -> NDArray[np.float64]:
    return _traverse_time(block) * block.values["frequency"]


_MM: Final = from_si("amplitude", 1.0)

COLUMNS: Final = (
    *map(
        _given,
        ("amplitude", "frequency", "drive_angle", "static_friction", "kinetic_friction", "trough_angle"),
    ),
    Column("regime", "", lambda block: block.cycle.regime, (*(r.label for r in Regime if r >= 0), "")),
    Column("pattern", "", lambda block: np.asarray(block.cycle.pattern)),
    _result("mean_velocity_mm_s", "mm/s", "mean_velocity", _MM),
    _result("displacement_per_cycle_mm", "mm", "displacement_per_cycle", _MM),
    _result("peak_velocity_mm_s", "mm/s", "peak_velocity", _MM),
    Column("traverse_time_s", "s", _traverse_time),
    _result("throw_number", "", "throw_number"),
    _result("forward_ratio", "", "forward_ratio"),
    _result("back_ratio", "", "back_ratio"),
    _result("flight_fraction", "", "flight_fraction"),
    _result("impact_speed_mm_s", "mm/s", "impact_velocity", _MM),
    _result("period_cycles", "", "period_cycles"),
    Column("model", "", lambda block: block.cycle.model_code, MODELS),
    Column("status", "", lambda block: block.cycle.status, tuple(s.label for s in Status)),
)

ARRIVAL: Final = Column("arrival_time_s", "s", _arrival)
STROKES: Final = Column("strokes", "", _strokes)


def columns_with(*extra: Column) -> tuple[Column, ...]:
    """Return the columns of a table that has more than the common ones: they go before ``model``."""
    place = [column.name for column in COLUMNS].index("model")
    return (*COLUMNS[:place], *extra, *COLUMNS[place:])


@dataclass(frozen=True)
class CsvFormat:
    """How a CSV is written.

    Attributes
    ----------
    excel : bool
        Whether it begins with a byte order mark, by which spreadsheets know UTF-8.
    decimal_comma : bool
        Whether decimals are written with a comma, and cells separated by semicolons.
    """

    excel: bool = False
    decimal_comma: bool = False

    @property
    def separator(self) -> str:
        """What stands between cells."""
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
            Floats have the fewest digits that read back as the same double; no number is an empty cell.
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
        values = column.values(block)
        if column.texts is not None:
            codes = values.ravel() % len(column.texts)  # -1 is the last
            texts = arrow.array(column.texts).take(arrow.array(codes))
        elif values.dtype.kind == "U":
            texts = arrow.array(values.ravel())
        else:
            texts = self._arrow_numbers(values.ravel(), arrow)
        if values.shape == block.shape:
            return texts
        which = np.broadcast_to(np.arange(values.size).reshape(values.shape), block.shape)
        return texts.take(arrow.array(which.ravel()))

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
        values = column.values(block)
        # Only the values that differ are converted: an axis has few, however many cells there are.
        if column.texts is not None:
            texts = np.array(column.texts, dtype=object)[values]
        elif values.dtype.kind == "U":
            texts = values.astype(object)
        else:
            texts = np.array(self._numbers(values.ravel()), dtype=object).reshape(values.shape)
        return np.broadcast_to(texts, block.shape).ravel().tolist()

    def _numbers(self, values: NDArray[np.float64]) -> list[str]:
        texts = list(map(float.__repr__, values.tolist()))
        for i in np.flatnonzero(~np.isfinite(values)):
            texts[i] = ""
        for i in np.flatnonzero(values == np.trunc(values)):
            texts[i] = texts[i].removesuffix(".0")
        return [text.replace(".", ",") for text in texts] if self.decimal_comma else texts


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


def record(columns: Sequence[Column], block: Block, index: int = 0) -> dict[str, float | str | None]:
    """Return one cell as a mapping, for JSON.

    Parameters
    ----------
    columns : sequence of Column
        The keys.
    block : Block
        Solved cells.
    index : int
        Which cell, in their order.

    Returns
    -------
    dict
        None where there is no number.
    """
    result: dict[str, float | str | None] = {}
    for column in columns:
        value = np.broadcast_to(column.values(block), block.shape).flat[index]
        if column.texts is not None:
            result[column.name] = column.texts[value]
        elif isinstance(value, str):
            result[column.name] = str(value)
        else:
            result[column.name] = float(value) if math.isfinite(value) else None
    return result


def to_frame(columns: Sequence[Column], block: Block) -> pd.DataFrame:
    """Return cells as a data frame, one row a cell.

    Parameters
    ----------
    columns : sequence of Column
        What it holds.
    block : Block
        Solved cells.

    Returns
    -------
    pandas.DataFrame
        Texts are categorical; no number is NaN.
    """
    import pandas as pd

    data: dict[str, Any] = {}
    for column in columns:
        values = np.broadcast_to(column.values(block), block.shape).ravel()
        if column.texts is not None:
            data[column.name] = pd.Categorical(np.array(column.texts, dtype=object)[values])
        elif values.dtype.kind == "U":
            data[column.name] = pd.Categorical(values.astype(object))
        else:
            data[column.name] = np.where(np.isfinite(values), values, np.nan)
    return pd.DataFrame(data)
