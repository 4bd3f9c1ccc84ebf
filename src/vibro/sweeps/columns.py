"""The columns of a sweep's table, and its cells as records and data frames."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.limits import stays_upright, tipping_load
from vibro.quantities import QUANTITIES, SWEPT, scene_fields
from vibro.results.steady import (
    ARRIVAL_TIME,
    RESULTS,
    STROKES,
    TIPPING_LOAD_RATIO,
    TRAVERSE_TIME,
    UPRIGHT,
    Result,
)
from vibro.results.sweep import Block, Column
from vibro.scene import Scene

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Sequence

    import pandas as pd
    from numpy.typing import NDArray

__all__ = ["WITH_ARRIVAL", "WITH_STROKES", "columns_of", "records", "standing", "to_frame"]


def _given(name: str) -> Column:
    quantity = QUANTITIES[name]
    return Column(quantity.column, quantity.unit, lambda block: block.values[name])


def _found(result: Result) -> Column:
    def values(block: Block) -> NDArray[Any]:
        found = np.asarray(getattr(block.cycle, result.name))
        if result.decode is not None:
            return result.decode(found)
        return np.asarray(result.kind.from_si(found)) if result.is_number else found

    return Column(result.column, result.kind.unit, values, result.texts, result.is_flag)


def _traverse_time(block: Block) -> NDArray[np.float64]:
    if block.length is None:
        return np.full((1,) * len(block.shape), np.nan)
    return np.asarray(block.cycle.traverse_time(QUANTITIES["trough_length"].to_si(block.length)))


def _arrival(block: Block) -> NDArray[np.float64]:
    return np.full((1,) * len(block.shape), np.nan) if block.arrival is None else block.arrival


def _strokes(block: Block) -> NDArray[np.float64]:
    return _traverse_time(block) * block.values["frequency"]


_WHERE_SWEPT: Final = ("friction_ratio", "restitution")
_TRAVERSE: Final = Column(TRAVERSE_TIME.column, TRAVERSE_TIME.kind.unit, _traverse_time)
#: What only some tables have.
WITH_ARRIVAL: Final = Column(ARRIVAL_TIME.column, ARRIVAL_TIME.kind.unit, _arrival)
WITH_STROKES: Final = Column(STROKES.column, STROKES.kind.unit, _strokes)


def columns_of(axes: Collection[str] = (), *extra: Column) -> tuple[Column, ...]:
    """Return the columns of a table.

    Parameters
    ----------
    axes : collection of str
        What is swept: a friction ratio and the restitution have a column only there.
    *extra : Column
        What this table has beside the common ones, before ``model``.
    """
    given = [_given(name) for name in SWEPT if name not in _WHERE_SWEPT or name in axes]
    columns: list[Column] = []
    for result in RESULTS:
        columns += extra if result.name == "model_code" else ()
        columns.append(_found(result))
        columns += [_TRAVERSE] if result.name == "peak_velocity" else []
    return (*given, *columns)


def standing(ratio: float) -> tuple[Column, Column]:
    """Return the columns of a part with a stand ratio: whether it stays upright, and how near it is."""

    def scene(block: Block) -> Scene:
        return Scene.allowing_infeasible(**scene_fields(block.values))

    def load_ratio(block: Block) -> NDArray[np.float64]:
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            return scene(block).load / tipping_load(scene(block), ratio)

    return (
        Column(
            UPRIGHT.column, "", lambda block: stays_upright(scene(block), ratio), UPRIGHT.texts, is_flag=True
        ),
        Column(TIPPING_LOAD_RATIO.column, "", load_ratio),
    )


def records(columns: Sequence[Column], block: Block) -> Iterator[dict[str, float | int | str | None]]:
    """Return cells as mappings, for JSON.

    Parameters
    ----------
    columns : sequence of Column
        The keys.
    block : Block
        Solved cells.

    Yields
    ------
    dict
        One a cell, in their order; None where there is no number.
    """
    values = [np.broadcast_to(column.values(block), block.shape).ravel().tolist() for column in columns]
    for row in zip(*values, strict=True):
        yield {column.name: _plain(column, value) for column, value in zip(columns, row, strict=True)}


def _plain(column: Column, value: float | int | str) -> float | int | str | None:
    if isinstance(value, str):
        return value
    if column.is_flag:
        return None if value < 0 else int(value)
    if column.texts is not None:
        return column.texts[int(value)]
    return float(value) if math.isfinite(value) else None


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
        if column.is_flag:
            data[column.name] = pd.arrays.IntegerArray(values, values < 0)
        elif column.texts is not None:
            data[column.name] = pd.Categorical(np.array(column.texts, dtype=object)[values])
        elif values.dtype.kind == "U":
            data[column.name] = pd.Categorical(values.astype(object))
        else:
            data[column.name] = np.where(np.isfinite(values), values, np.nan)
    return pd.DataFrame(data)
