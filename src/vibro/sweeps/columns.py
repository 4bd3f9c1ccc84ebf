"""The columns of a sweep's table, and its cells as records and data frames."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.errors import InputError, did_you_mean, shown
from vibro.files.arrow_arrays import number_array, text_array
from vibro.quantities import BY_COLUMN, DRIVES, LINEAR, MACHINE, QUANTITIES, RATES, SIZES, SWEPT
from vibro.results.operating import MACHINE_RESULTS, OPERATING
from vibro.results.steady import RESULTS, Result
from vibro.results.sweep import Block, Column
from vibro.sweeps.derived import (
    TRAVERSE,
    WITH_ACCELERATION,
    WITH_BENT_SPEED,
    WITH_EXPONENT,
    WITH_LENGTH,
    WITH_MULTIPLIER,
    WITH_STROKE,
    WITH_STROKES,
    column_of,
    given_column,
)

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence

    import pandas as pd
    import pyarrow as pa
    from numpy.typing import NDArray

    from vibro.sweeps.grid import Grid


@dataclass(frozen=True)
class Table:
    """The contents of a table.

    Attributes
    ----------
    columns : sequence of Column
        In their order.
    part : mapping of str to float
        Quantities of the conveyed part that columns use, by name with unit.
    """

    columns: Sequence[Column]
    part: Mapping[str, float] = field(default_factory=dict)


def _given(name: str) -> Column:
    return given_column(QUANTITIES[name], partial(_quantity, name))


def _quantity(name: str, block: Block) -> NDArray[Any]:
    return block.values[name]


def _found(result: Result, block: Block) -> NDArray[Any]:
    found = np.asarray(getattr(block.cycle, result.name))
    return np.asarray(result.kind.from_si(found)) if result.is_number else found


def _operating(result: Result, block: Block) -> NDArray[Any]:
    cells: NDArray[Any] = block.values[OPERATING]
    found = cells[result.name]
    return np.asarray(result.kind.from_si(found) if result.is_number else found)


_WHERE_GIVEN: Final = (*MACHINE, *RATES, "friction_ratio", "normal_acceleration", "restitution")
# Inputs that do not follow from a machine, which may have no answer; without nulls they are written faster.
_ALWAYS_KNOWN: Final = {QUANTITIES[name].column for name in SWEPT if name not in (*DRIVES, *SIZES, *MACHINE)}
# What a table was made with, by the names of ``Grid.made_with``.
_MADE_WITH: Final = {"restitution": _given("restitution"), "trough_length": WITH_LENGTH}
# Columns that every table can have, but has only on request or, of those above, where they matter.
_ON_REQUEST: Final = (
    WITH_STROKE, *_MADE_WITH.values(), WITH_ACCELERATION, WITH_EXPONENT, WITH_STROKES,
    WITH_MULTIPLIER,
)  # fmt: skip


def columns_of(
    axes: Collection[str] = (),
    *extra: Column,
    drive: Collection[str] = LINEAR,
    made_with: Collection[str] = (),
    machine: bool = False,
    of_starts: bool = False,
) -> tuple[Column, ...]:
    """Return the columns of a table.

    Parameters
    ----------
    axes : collection of str
        Names of the axes: friction ratio, normal acceleration and restitution have a column among the inputs
        only if they are swept; and of the speed or the acceleration that gives the amplitude.
    *extra : Column
        Further columns of this table, before ``model``, unless they are among these.
    drive : collection of str
        Names of the drive's quantities.
    made_with : collection of str
        As ``Grid.made_with``; their columns stand before the results of flights.
    machine : bool
        Whether the amplitude follows from a machine, whose columns stand before ``model``.
    of_starts : bool
        Whether bodies from many starts are followed.
    """
    left_out = {*DRIVES, *_WHERE_GIVEN}.difference(axes, drive)
    given = [_given(name) for name in QUANTITIES if name in {*SWEPT, *drive} - left_out]
    columns: list[Column] = []
    for result in RESULTS:
        if result.on_request or (result.of_starts and not of_starts):
            continue
        columns += [_MADE_WITH[name] for name in made_with] if result.name == "flight_fraction" else []
        if result.name == "model_code":
            columns += [column for column in extra if column.name not in {one.name for one in given}]
            columns += _of_machine(axes) if machine else []
        columns.append(column_of(result, partial(_found, result)))
        columns += [TRAVERSE] if result.name == "peak_velocity" else []
    return (*given, *columns)


def _of_machine(axes: Collection[str]) -> list[Column]:
    """Return the columns of a machine; axes stand among the inputs."""
    given = [_given(name) for name in MACHINE if name not in axes]
    return [*given, *(column_of(result, partial(_operating, result)) for result in MACHINE_RESULTS)]


def table_columns(
    grid: Grid, names: Sequence[str] | None = None, extra: Iterable[Column] = ()
) -> tuple[Column, ...]:
    """Return the columns of a grid's table: those named, or the usual ones with further ones."""
    axes = {*grid.axes, *(RATES.keys() & grid.fixed.keys())}
    usual = columns_of(
        axes, *extra, drive=grid.drive, made_with=grid.made_with, machine=grid.machine is not None,
        of_starts=grid.starts is not None,
    )  # fmt: skip
    return usual if names is None else chosen(names, usual)


def named(names: object, known: Collection[str], hint: str) -> list[str]:
    """Return the names of columns that a call gives.

    Parameters
    ----------
    names : object
        As given.
    known : collection of str
        The columns that there are.
    hint : str
        What there are.

    Raises
    ------
    InputError
        If they are no names, or one is unknown, or named twice, or there is none.
    """
    found: list[Any] = list(names) if not isinstance(names, str) and isinstance(names, Iterable) else [None]
    if not all(isinstance(name, str) for name in found):
        raise InputError(f"columns = {shown(names)}: must be names", hint='write it like ["regime"]')
    unknown = [name for name in found if name not in known]
    if unknown or not found:
        problems = [f"there is no column {shown(name)}" for name in unknown] or ["no column is named"]
        meant = did_you_mean(unknown[0], known) if unknown else ""
        raise InputError(*problems, hint=f"{meant}\n{hint}".lstrip())
    if twice := [name for i, name in enumerate(found) if name in found[:i]]:
        raise InputError(f"column {twice[0]} is named twice", hint="name it once")
    return found


def chosen(names: Sequence[str], columns: Sequence[Column]) -> tuple[Column, ...]:
    """Return columns by name, in the order of the names.

    Parameters
    ----------
    names : sequence of str
        Which: of ``columns``, and of those that every table can have.
    columns : sequence of Column
        The usual columns of the table.

    Raises
    ------
    InputError
        If there is no such column, or one is named twice.
    """
    known = {column.name: column for column in columns}
    known |= {column.name: column for column in _ON_REQUEST if column.name not in known}
    if MACHINE_RESULTS[0].column in known:
        known[WITH_BENT_SPEED.name] = WITH_BENT_SPEED
    inputs, results = (", ".join(name for name in known if (name in BY_COLUMN) is of) for of in (True, False))
    hint = f"those of inputs are {inputs}\nthose of results are {results}"
    names = named(names, known, hint)
    return tuple(known[name] for name in names)


def arrow_table(columns: Sequence[Column], block: Block) -> pa.Table:
    """Return cells as an Arrow table, one row a cell: all tables are made of it.

    Parameters
    ----------
    columns : sequence of Column
        What it holds.
    block : Block
        Solved cells.

    Returns
    -------
    pyarrow.Table
        Numbers are doubles, flags are int8, both null where unknown; texts are dictionaries: of a column that
        lists its texts all of them, in the order of their codes, else those that occur, in the order of the
        alphabet. The metadata of a field are its unit and its meaning.
    """
    import pyarrow as pa

    arrays = [_array(column, block) for column in columns]
    fields = [
        pa.field(
            column.name,
            array.type,
            column.name not in _ALWAYS_KNOWN and (column.is_number or column.is_flag),
            {"unit": column.unit, "meaning": column.meaning},
        )
        for column, array in zip(columns, arrays, strict=True)
    ]
    return pa.Table.from_arrays(arrays, schema=pa.schema(fields))


def _array(column: Column, block: Block) -> pa.Array:
    import pyarrow as pa

    values = column.values(block)
    if column.is_number or column.is_flag:
        known = np.isfinite(values) if column.is_number else values >= 0
        cells = values if column.is_number else values.astype(np.int8, copy=False)
        return number_array(cells, block.shape, known)
    if column.decode is None:
        texts: Any = column.texts
        which = np.where(values < 0, np.int8(len(texts) - 1), values)  # a remainder would take longer
    else:
        found = number_array(values, values.shape).dictionary_encode()  # it hashes where NumPy sorts
        codes = np.frombuffer(found.dictionary.buffers()[1], values.dtype)
        unsorted = column.decode(codes, block.cycle.long_patterns)
        texts, place = np.unique(unsorted.astype(str), return_inverse=True)
        which = place[np.frombuffer(found.indices.buffers()[1], np.int32)].reshape(values.shape)
    indices = number_array(which.astype(np.int32), block.shape)
    return pa.DictionaryArray.from_arrays(indices, text_array(texts))


def frame_of(cells: pa.Table) -> pd.DataFrame:
    """Return the cells of ``arrow_table`` as a data frame.

    Texts are categorical, with all texts of a dictionary as categories; flags are nullable integers, and
    missing numbers are NaN.
    """
    import pandas as pd
    import pyarrow as pa

    found: pd.DataFrame = cells.to_pandas(types_mapper={pa.int8(): pd.Int8Dtype()}.get)
    return found
