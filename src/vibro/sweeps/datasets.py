"""Sweeps as labelled arrays: axes are dimensions, inputs coordinates, results variables of xarray.

Names and units follow the CF conventions. A dataset written to netCDF is read back unchanged: codes have a
flag of -1 and no fill value, with which they would come back as floats.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.errors import FileError, InputError, how_to_install, shown
from vibro.quantities import QUANTITIES
from vibro.sweeps.solved import swept_axis
from vibro.units import cf_unit
from vibro.version import __version__

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    import pyarrow as pa
    import xarray as xr
    from numpy.typing import NDArray

    from vibro.results.sweep import Column
    from vibro.sweeps.grid import Grid

    Values = Callable[[Column], Any]

#: Texts of any length. The metadata, by which xarray knows its own, has it write blocks of them one by one.
TEXT: Final = np.dtype("O", metadata={"element_type": str})
_CONVENTIONS: Final = "CF-1.11"
_FLAGS: Final = {"unknown": -1, "no": 0, "yes": 1}
_BLOCK: Final = 1_000_000  # [cells] 8 MB of numbers; dask takes some 0.1 ms a block


def check_xarray() -> None:
    """Say what to install where xarray is missing.

    Raises
    ------
    FileError
        If it is missing.
    """
    try:
        import xarray  # noqa: F401 - whether it is installed
    except ImportError:
        raise FileError("to_xarray() needs xarray", hint=how_to_install("xarray")) from None


def dataset(
    grid: Grid,
    name: str,
    columns: Iterable[Column],
    values: Values,
    *,
    indices: Sequence[NDArray[np.intp]] | None = None,
    version: str = __version__,
    more: Mapping[str, Any] | None = None,
) -> xr.Dataset:
    """Make the dataset of a sweep.

    Parameters
    ----------
    grid : Grid
        What was solved.
    name : str
        Name of the scene; may be empty.
    columns : iterable of Column
        Its results, as ``results_among`` returns them: every input is a coordinate.
    values : callable
        From a column to its values, of the shape of the cells: numbers, codes or texts.
    indices : sequence of array, optional
        For every axis the indices of the values that are kept; without, all.
    version : str, optional
        Of the vibro that solved it.
    more : mapping, optional
        Further attributes.

    Returns
    -------
    xarray.Dataset
    """
    import xarray as xr

    axes = [axis.column for axis in grid.axes.values()]
    variables = {column.name: (axes, values(column), _attributes(column)) for column in columns}
    what = f"sweep of {' x '.join(axes)}" if axes else "one operating point"
    attributes = {
        "title": f"{name}: {what}" if name else what,
        "source": f"vibro {version}",
        "Conventions": _CONVENTIONS,
        "accuracy": grid.output.value,
        "flight": int(grid.flight),
        **({} if grid.starts is None else {"starts": grid.starts}),
        **({} if grid.motion is None else {"motion": json.dumps(dict(grid.motion.table))}),
        **({} if grid.machine is None else {"machine": json.dumps(dict(grid.machine.table))}),
        **(more or {}),
    }
    result = xr.Dataset(variables, _coordinates(grid, indices), attributes)
    for coordinate in result.coords.values():
        coordinate.encoding["_FillValue"] = None  # CF allows none
    return result


def results_among(columns: Iterable[Column], grid: Grid) -> list[Column]:
    """Return those columns of a grid's table that hold no inputs."""
    inputs = {QUANTITIES[name].column for name in _inputs(grid)}
    return [column for column in columns if column.name not in inputs]


def _inputs(grid: Grid) -> dict[str, NDArray[np.float64]]:
    """Return every input by name, as ``Grid.values`` does, and the trough's length."""
    values = replace(grid, machine=None).values()  # what follows from a machine is a result
    if grid.length is not None:
        values["trough_length"] = np.full((1,) * len(grid.axes), grid.length)
    return {name: values[name] for name in QUANTITIES if name in values}


def _coordinates(grid: Grid, indices: Sequence[NDArray[np.intp]] | None) -> dict[str, Any]:
    """Return every input by its column, as dimensions, values and attributes.

    Fixed ones have no dimensions; kinetic friction has those of its ratio and of static friction.
    """
    coordinates = {}
    for name, values in _inputs(grid).items():
        quantity = QUANTITIES[name]
        dimensions: list[str] = []
        for i, axis in enumerate(grid.axes.values()):
            if axis.name == name or values.shape[len(dimensions)] > 1:
                if indices is not None:
                    values = values.take(indices[i], len(dimensions))
                dimensions.append(axis.column)
            else:
                values = values.squeeze(len(dimensions))
        attributes = {"long_name": quantity.meaning, "units": cf_unit(quantity.unit)}
        coordinates[quantity.column] = (dimensions, values, attributes)
    return coordinates


def _attributes(column: Column) -> dict[str, Any]:
    meaning = column.meaning
    short = meaning.replace(":", ";").partition(";")[0]
    attributes: dict[str, Any] = {"long_name": short, **({} if meaning == short else {"comment": meaning})}
    if column.is_number:
        return {**attributes, "units": cf_unit(column.unit)}
    if column.texts is None:
        return attributes
    codes = _FLAGS if column.is_flag else {_word(text): code for text, code in column.codes.items()}
    words = sorted(codes, key=codes.__getitem__)
    flags = np.array([codes[word] for word in words], np.int8)
    return {**attributes, "flag_values": flags, "flag_meanings": " ".join(words)}


def _word(text: str) -> str:
    return text.replace("-", "_") or "none"


def values_of(cells: pa.Table, shape: Sequence[int]) -> Values:
    """Return the callable of ``dataset`` for the cells of an Arrow table, as ``arrow_table`` makes it."""

    def values(column: Column) -> NDArray[Any]:
        found = cells[column.name]
        if column.is_number:
            return np.asarray(found.to_numpy()).reshape(shape)
        if column.is_flag:
            return np.asarray(found.fill_null(-1).to_numpy()).reshape(shape)
        whole = found.combine_chunks()
        texts, which = whole.dictionary.to_pylist(), whole.indices.to_numpy().reshape(shape)
        if column.decode is not None:
            return np.asarray(np.array(texts, TEXT)[which])
        return np.asarray(np.array([column.codes[text] for text in texts], np.int8)[which])

    return values


def block_sizes(chunks: object, grid: Grid, shape: Sequence[int]) -> tuple[int, ...]:
    """Return how many values of each axis a block has.

    Parameters
    ----------
    chunks : "auto", int or mapping of str to int
        One size for every axis, or sizes by axis, which is called by key, name or letter; those that are not
        given are such that a block has at most 1e6 cells, which lie near each other: all values of the last
        axes.
    grid : Grid
        The axes.
    shape : sequence of int
        Values of each axis that are kept.

    Raises
    ------
    InputError
        If an axis is unknown, or a size is no whole number.
    """
    given: dict[str, Any] = {}
    if isinstance(chunks, Mapping):
        given = {swept_axis(grid, called, "chunks")[0]: size for called, size in chunks.items()}
    elif chunks != "auto":
        given = dict.fromkeys(grid.axes, chunks)
    for size in given.values():
        if not isinstance(size, int) or isinstance(size, bool) or size < 1:
            raise InputError(
                f"chunks = {shown(size)}: must be 'auto', a whole number > 0, or sizes by axis",
                hint='write it like "auto", 10 or {"amplitude_mm": 10}',
            )
    sizes, room = [], _BLOCK
    for name, count in zip(reversed(list(grid.axes)), reversed(shape), strict=True):
        sizes.append(min(count, given.get(name, max(room, 1))))
        room //= sizes[-1]
    return tuple(reversed(sizes))
