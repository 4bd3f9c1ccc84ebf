"""Cells of a folder as arrays for a dataset: read at once, or block by block when they are computed with."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.errors import FileError, how_to_install
from vibro.output.gathered import Flags, Numbers, gathering
from vibro.output.selection import Selection

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from vibro.output.gathered import Gathered
    from vibro.output.shard_files import ShardFiles
    from vibro.results.sweep import Column
    from vibro.sweeps.datasets import Values

__all__ = ["values_in_blocks", "values_of_files"]

# Texts of any length. The metadata, by which xarray knows its own, has it write blocks of them one by one.
_TEXT: Final = np.dtype("O", metadata={"element_type": str})


def values_of_files(shards: ShardFiles, names: Sequence[str], cells: Selection) -> Values:
    """Return the callable of ``dataset`` for cells in files, which are read here."""
    found = shards.read(names, cells)
    return lambda column: _gathered(column, found.pop(column.name)).reshape(cells.shape)


def _gathered(column: Column, found: Gathered) -> NDArray[Any]:
    if isinstance(found, Numbers | Flags):
        return found.values
    return found.coded(column) if column.decode is None else np.array(list(found.texts), _TEXT)[found.codes]


def values_in_blocks(shards: ShardFiles, cells: Selection, sizes: Sequence[int]) -> Values:
    """Return the callable of ``dataset`` for cells in files, which are read when they are computed with.

    Each block of each column is a task of dask of its own, which opens those files alone that hold its cells.

    Parameters
    ----------
    shards : ShardFiles
        The cells.
    cells : Selection
        Which of them.
    sizes : sequence of int
        Most values of each axis in a block.

    Raises
    ------
    FileError
        If dask is not installed.
    """
    try:
        import dask.array as da
    except ImportError:
        raise FileError("to_xarray(chunks=...) needs dask", hint=how_to_install("xarray")) from None
    chunks = da.core.normalize_chunks(tuple(sizes), cells.shape)
    there = replace(shards, folder=shards.folder.absolute())  # the current folder may have changed by then

    def values(column: Column) -> Any:
        kind = gathering(column)
        dtype = np.dtype(np.float64 if kind is Numbers else np.int8) if column.decode is None else _TEXT
        return da.map_blocks(
            _read_block, there, column.name, cells, chunks=chunks, dtype=dtype,
            meta=np.empty((0,) * len(cells.shape), dtype),
        )  # fmt: skip

    return values


def _read_block(shards: ShardFiles, name: str, cells: Selection, block_info: Any = None) -> NDArray[Any]:
    """Read a column of the cells of one block, which ``block_info`` places among ``cells``."""
    places = block_info[None]["array-location"]
    indices = [kept[slice(*place)] for kept, place in zip(cells.indices, places, strict=True)]
    block = Selection(cells.grid, indices)
    found: NDArray[Any] = values_of_files(shards, [name], block)(shards.columns[name])
    return found
