"""A finished folder of shards: what it holds, and some of its cells, read and checked."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, Final

import numpy as np

from vibro.errors import FileError
from vibro.files.arrow_arrays import number_array, text_array
from vibro.files.reading import opened
from vibro.tables.plan import MANIFEST, SUCCESS, Plan, read_plan, shard_name
from vibro.tables.shards import GO_ON, Summary, chunk_sum, damaged, footer_digest

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    import pyarrow as pa
    from numpy.typing import NDArray

    from vibro.results.sweep import Column
    from vibro.tables.shards import Made

_WANTED: Final = "give a folder that a sweep was written to"


@dataclass(frozen=True, eq=False)
class Selection:
    """Cells of a grid, numbered with the last axis fastest, at some of the values of every axis.

    Attributes
    ----------
    grid : tuple of int
        Shape of the whole grid.
    indices : sequence of array
        For every axis the indices of its values, ascending.
    """

    grid: tuple[int, ...]
    indices: Sequence[NDArray[np.intp]]

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values of each axis."""
        return tuple(len(kept) for kept in self.indices)

    @property
    def numbers(self) -> NDArray[np.intp]:
        """Their numbers in the grid, ascending."""
        return np.ravel(np.ravel_multi_index(np.ix_(*self.indices), self.grid))


@dataclass(frozen=True, eq=False)
class ShardFiles:
    """A finished folder.

    Attributes
    ----------
    folder : Path
        Where it is.
    plan : Plan
        The grid that was solved, and the columns written.
    summary : Summary
        What was counted of its cells, and what its files must be.
    """

    folder: Path
    plan: Plan
    summary: Summary

    @property
    def columns(self) -> dict[str, Column]:
        """The columns of its table, by name."""
        return {column.name: column for column in self.plan.table.columns}

    def read(self, names: Sequence[str], cells: Selection) -> pa.Table:
        """Read columns of some cells, in their order, from those files and row groups that hold them.

        Returns
        -------
        pyarrow.Table
            As ``arrow_table`` makes it.

        Raises
        ------
        FileError
            If a shard cannot be read, or is not what was written.
        """
        import pyarrow as pa

        numbers, found = cells.numbers, []
        first, last = (int(numbers[end]) // self.plan.shard_cells for end in (0, -1))
        for shard in range(first, last + 1):
            start, stop = self.plan.range_of(shard)
            rows = numbers[slice(*np.searchsorted(numbers, (start, stop)))] - start
            if rows.size:
                path, made = self.folder / shard_name(shard), self.summary.made[shard]
                found.append(_rows(path, made, names, rows, self.plan.row_group_cells))
        together, schema = pa.concat_tables(found).columns[::-1], found[0].schema
        del found  # so that each column goes once it is copied
        arrays = [_whole(self.columns[name], together.pop()) for name in names]
        return pa.Table.from_arrays(arrays, schema=schema)


def open_shards(folder: Path) -> ShardFiles:
    """Open a folder that a sweep was written to.

    Raises
    ------
    FileError
        If it is no such folder, is not finished, or something in it is missing or damaged.
    """
    if not folder.is_dir():
        what = "is no folder" if folder.exists() else "is not there"
        raise FileError(f"cannot open {folder}: it {what}", hint=_WANTED)
    if not (folder / MANIFEST).is_file():
        raise FileError(f"{folder} holds no sweep: there is no {MANIFEST} in it", hint=_WANTED)
    plan = read_plan(folder / MANIFEST)
    if summary := read_success(folder, plan):
        return ShardFiles(folder, plan, summary)
    there = sum((folder / shard_name(shard)).is_file() for shard in range(plan.shards))
    raise FileError(f"{folder} is not finished: {there} of {plan.shards} shards are there", hint=GO_ON)


def read_success(folder: Path, plan: Plan) -> Summary | None:
    """Read what is known of a finished folder; None if it is not finished.

    Raises
    ------
    FileError
        If what says so is damaged.
    """
    path = folder / SUCCESS
    try:
        with opened(path) as stream:
            return Summary.read(stream.read(), plan)
    except FileNotFoundError:
        return None
    except OSError as exc:
        raise FileError(f"cannot read {path}: {exc.strerror or exc}", hint=f"remove it; {GO_ON}") from exc
    except Exception as exc:  # whatever a change may lead to
        raise damaged(path, str(exc)) from exc


def _rows(path: Path, made: Made, names: Sequence[str], rows: NDArray[np.intp], size: int) -> pa.Table:
    """Read rows of a shard whose row groups have that size."""
    from pyarrow import ArrowException, parquet

    group, row = np.divmod(rows, size)
    groups, place = np.unique(group, return_inverse=True)
    try:
        # Opened here: Arrow gives names such as s3: or ~ a special meaning.
        with opened(path) as stream:
            if footer_digest(stream) != made.footer:
                raise damaged(path, "its footer is not what was written")
            stream.seek(0)
            with parquet.ParquetFile(stream) as file:
                columns = file.schema_arrow.names
                sums = np.array(made.chunks.split()).reshape(-1, len(columns))
                for chunk in product(groups.tolist(), map(columns.index, names)):
                    if chunk_sum(stream, file.metadata, *chunk) != sums[chunk]:
                        raise damaged(path, f"{columns[chunk[1]]} is not what was written")
                table = file.read_row_groups(groups.tolist(), list(names))
        if rows.size == table.num_rows:
            return table
        return table.take(place * size + row)
    except FileNotFoundError as exc:
        raise FileError(f"{path} is missing", hint=GO_ON) from exc
    except MemoryError:  # one of Arrow's exceptions, too
        raise
    except (OSError, ArrowException) as exc:
        raise damaged(path, str(exc)) from exc


def _whole(column: Column, found: pa.ChunkedArray) -> pa.Array:
    """Return a column as one array, with the dictionary that ``arrow_table`` gives it."""
    import pyarrow as pa

    whole = found.combine_chunks()
    if column.is_number or column.is_flag:
        return whole
    there, which = whole.dictionary.to_pylist(), whole.indices.to_numpy()
    texts = column.texts or sorted(there[i] for i in np.unique(which))
    place = {text: i for i, text in enumerate(texts)}
    codes = np.array([place.get(text, 0) for text in there], np.int32)[which]
    return pa.DictionaryArray.from_arrays(number_array(codes, codes.shape), text_array(texts))
