"""Sweeps stored as Parquet files: their cells as data frames, as labelled arrays and as pictures."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np

from vibro.axes import axis_of
from vibro.errors import FileError, InputError, how_to_install, shown
from vibro.html_tables import amount, in_numbers
from vibro.plots.view import index_of
from vibro.quantities import QUANTITIES
from vibro.reals import shielded
from vibro.results.steady import NO_REGIME, RESULTS
from vibro.sweeps.columns import frame_of, named
from vibro.sweeps.datasets import TEXT, block_sizes, check_xarray, dataset, results_among, values_of
from vibro.sweeps.run import solved_picture
from vibro.sweeps.solved import SolvedGrid, check_memory, one_value, swept_axis
from vibro.tables.shard_files import Selection, ShardFiles, open_shards
from vibro.units import SPEED

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence
    from os import PathLike

    import pandas as pd
    import xarray as xr
    from numpy.typing import NDArray

    from vibro.axes import Axis
    from vibro.results.sweep import Column, Peak, SweepResult
    from vibro.sweeps.datasets import Values
    from vibro.sweeps.grid import Grid

_BYTES_PER_CELL: Final = 10  # of a column, about


@dataclass(frozen=True, eq=False, repr=False)
class StoredSweep(SolvedGrid):
    """A sweep stored in a folder of Parquet files; returned by ``vibro.open_sweep``.

    Attributes
    ----------
    shape : tuple of int
        Number of values of each axis.
    axes : dict of str to array
        Values of the quantities that vary, by their keys in a scene file, in the unit that the key names.
    fixed : dict of str to float
        Values of all other quantities, by their keys.
    columns : tuple of str
        Names of the stored columns.
    """

    _shards: ShardFiles

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the stored columns."""
        return tuple(self._shards.columns)

    @shielded
    def to_frame(
        self, filters: Mapping[str, Any] | None = None, columns: Sequence[str] | None = None
    ) -> pd.DataFrame:
        """Read cells into a data frame, opening only the files, row groups and columns that hold them.

        Parameters
        ----------
        filters : mapping, optional
            Values to select, by key, name or letter of the axis (``"amplitude_mm"``, ``"A"``): one value, a
            list of values, or a tuple ``(low, high)`` for all values from ``low`` to ``high``, ends included;
            None is an open end. A text may contain a unit, ``"800um"``. All values of other axes are
            selected.
        columns : sequence of str, optional
            Names of the columns to read, in order; by default all.

        Returns
        -------
        pandas.DataFrame
            One row per cell, the last axis fastest. Texts are categorical, flags such as ``coexists`` are
            nullable integers, and missing numbers are NaN, as in ``vibro.sweep(...).to_frame()``.

        Raises
        ------
        InputError
            If an axis, a value or a column is unknown, or the cells do not fit into memory.
        FileError
            If a file cannot be read, or its checksums show damage.
        """
        names, cells = self._wanted(filters, columns)
        hint = "filter the cells, name fewer columns, or let another reader of Parquet, such as DuckDB, do it"
        check_memory(cells.shape, _BYTES_PER_CELL * len(names), hint)
        return frame_of(self._shards.read(names, cells))

    @shielded
    def to_xarray(
        self,
        filters: Mapping[str, Any] | None = None,
        columns: Sequence[str] | None = None,
        *,
        chunks: Literal["auto"] | int | Mapping[str, int] | None = None,
    ) -> xr.Dataset:
        """Read cells into labelled arrays, at once or lazily.

        Parameters
        ----------
        filters, columns : optional
            As for ``to_frame``.
        chunks : "auto", int or mapping of str to int, optional
            By default all cells are read now. With ``chunks``, variables are dask arrays that are read when
            they are computed. A block has that number of values of every axis (``10``), or of the axes given
            by key, name or letter (``{"amplitude_mm": 10}``). Along other axes, and with ``"auto"``, blocks
            are as large as fits 1e6 cells, with the last axes whole, so that a block is stored in few files.

        Returns
        -------
        xarray.Dataset
            As from ``vibro.sweep(...).to_xarray()``. Computing a block opens only the files, row groups and
            columns that contain it; it raises FileError if a file is missing or damaged.

        Raises
        ------
        InputError
            If an axis, a value or a column is unknown, or, without ``chunks``, the cells do not fit into
            memory.
        FileError
            If a file cannot be read, its checksums show damage, or xarray or dask is not installed.

        Examples
        --------
        >>> import tempfile, vibro
        >>> nut = {"drive_angle_deg": 20, "static_friction": 0.74, "kinetic_friction": 0.57}
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     t = vibro.write_sweep(folder, amplitude_mm="0.1:3:30", frequency_hz="5:25:21", **nut)
        ...     speed = t.to_xarray(chunks={"amplitude_mm": 10}).mean_velocity_mm_s
        ...     print(speed.chunksizes["amplitude_mm"], round(float(speed.max()), 1))
        (10, 10, 10) 432.1
        """
        check_xarray()
        shards = self._shards
        names, cells = self._wanted(filters, columns)
        found = results_among((shards.columns[name] for name in names), self._grid)
        if chunks is None:
            hint = 'filter the cells, name fewer columns, or read them when they are needed: chunks="auto"'
            check_memory(cells.shape, _BYTES_PER_CELL * len(found), hint)
            values = values_of(shards.read([column.name for column in found], cells), cells.shape)
        else:
            values = _values_in_blocks(shards, cells, block_sizes(chunks, self._grid, cells.shape))
        version, part = shards.plan.content["made_by"]["vibro"], shards.plan.table.part
        return dataset(
            self._grid, self._title, found, values, indices=cells.indices, version=version, more=part
        )

    def _wanted(
        self, filters: Mapping[str, Any] | None, columns: Sequence[str] | None
    ) -> tuple[Sequence[str], Selection]:
        known = self.columns
        names = known if columns is None else named(columns, known, f"there are {', '.join(known)}")
        return names, _selection(self._grid, {} if filters is None else filters)

    def _summary(self) -> list[tuple[str, str]]:
        tally = self._shards.summary.tally
        shards, columns = self._shards.plan.shards, len(self.columns)
        return [
            ("folder", f"{self._shards.folder}: {shards} files, {columns} columns"),
            ("regime", in_numbers((code.label or NO_REGIME, n) for code, n in tally.regime.most_common())),
            ("status", in_numbers((code.label, n) for code, n in tally.status.most_common())),
            *((name.replace("_", " "), self._where(peak)) for name, peak in tally.peaks.items()),
        ]

    def _where(self, peak: Peak) -> str:
        given, axes = self._grid.as_given(peak.values), self._grid.given_axes.items()
        at = ", ".join(f"{axis.label} {amount(given[name], axis.unit)}" for name, axis in axes)
        return f"{amount(peak.speed, SPEED.unit)}{' at ' if at else ''}{at}"

    def _cells(
        self, results: Collection[str], indices: Sequence[NDArray[np.intp]]
    ) -> dict[str, NDArray[Any]]:
        return _cells(self._shards, results, indices)


@shielded
def open_sweep(path: str | PathLike[str]) -> StoredSweep:
    """Open a folder that ``vibro map -o NAME.parquet`` or ``vibro.write_sweep`` has written.

    Parameters
    ----------
    path : path
        The folder, of a finished sweep.

    Returns
    -------
    StoredSweep
        The sweep. Its methods read only the cells that they need; pictures are drawn from stored cells.

    Raises
    ------
    FileError
        If the folder does not exist, is not finished, lacks a file or is damaged.

    Examples
    --------
    >>> import tempfile, vibro
    >>> nut = {"drive_angle_deg": 20, "static_friction": 0.74, "kinetic_friction": 0.57}
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = vibro.write_sweep(folder, amplitude_mm="0.5:1.5:3", frequency_hz=[10, 15], **nut)
    ...     t = vibro.open_sweep(folder)
    ...     t.to_frame({"amplitude_mm": (1, 2), "f": 15}, ["amplitude_mm", "pattern"])
       amplitude_mm pattern
    0           1.0      F_
    1           1.5     FB_
    >>> t.axes
    {'amplitude_mm': array([0.5, 1. , 1.5]), 'frequency_hz': array([10., 15.])}
    """
    if not isinstance(path, str | os.PathLike):
        raise InputError(f"path = {shown(path)}: must be a path", hint='write it like "wide_sweep"')
    shards = open_shards(Path(path))
    return StoredSweep(shards.plan.grid, shards.plan.own, shards.plan.name, shards)


def stored_picture(
    shards: ShardFiles,
    drawn: Mapping[str, tuple[int, ...]],
    pictures: Sequence[str],
    peaks: Mapping[str, Peak] | None = None,
) -> SweepResult:
    """Read the cells of pictures from files.

    Parameters
    ----------
    shards : ShardFiles
        The cells.
    drawn : mapping of str to tuple of int
        As for ``solved_picture``.
    pictures : sequence of str
        Their names.
    peaks : mapping of str to Peak, optional
        The fastest of all cells.

    Raises
    ------
    InputError
        If a column that a picture needs was not written.
    FileError
        If a file cannot be read.
    """
    plan = shards.plan
    return solved_picture(plan.grid, drawn, plan.own, plan.name, pictures, partial(_cells, shards), peaks)


def _cells(
    shards: ShardFiles, results: Collection[str], indices: Sequence[NDArray[np.intp]]
) -> dict[str, NDArray[Any]]:
    """Read results of the cells at some values of every axis."""
    wanted = [result for result in RESULTS if result.name in results]
    missing = [result.column for result in wanted if result.column not in shards.columns]
    if missing:
        problem = f"there is no picture without the columns {', '.join(missing)}: {shards.folder} lacks them"
        raise InputError(problem, hint="write them too: name them in columns, or leave that out")
    cells = Selection(shards.plan.grid.shape, indices)
    values = values_of(shards.read([result.column for result in wanted], cells), cells.shape)
    found = {}
    for result in wanted:
        there = values(shards.columns[result.column])
        found[result.name] = np.asarray(result.kind.to_si(there)) if result.is_number else there
    return found


def _values_in_blocks(shards: ShardFiles, cells: Selection, sizes: Sequence[int]) -> Values:
    """Return the callable of ``dataset`` for cells that are read when they are computed with.

    Each block of each column is a task of dask of its own, which opens those files alone that hold its cells.
    """
    try:
        import dask.array as da
    except ImportError:
        raise FileError("to_xarray(chunks=...) needs dask", hint=how_to_install("xarray")) from None
    chunks = da.core.normalize_chunks(tuple(sizes), cells.shape)
    there = replace(shards, folder=shards.folder.absolute())  # the current folder may have changed by then

    def values(column: Column) -> Any:
        kind = np.dtype(np.float64 if column.is_number else np.int8) if column.decode is None else TEXT
        return da.map_blocks(
            _read_block, there, column.name, cells, chunks=chunks, dtype=kind,
            meta=np.empty((0,) * len(cells.shape), kind),
        )  # fmt: skip

    return values


def _read_block(shards: ShardFiles, name: str, cells: Selection, block_info: Any = None) -> NDArray[Any]:
    """Read a column of the cells of one block, which ``block_info`` places among ``cells``."""
    places = block_info[None]["array-location"]
    indices = [kept[slice(*place)] for kept, place in zip(cells.indices, places, strict=True)]
    block = Selection(cells.grid, indices)
    found: NDArray[Any] = values_of(shards.read([name], block), block.shape)(shards.columns[name])
    return found


def _selection(grid: Grid, filters: Mapping[str, Any]) -> Selection:
    if not isinstance(filters, Mapping):
        raise InputError(f"filters = {shown(filters)}: must be a mapping", hint='write it like {"mu_s": 0.3}')
    kept: dict[str, NDArray[np.intp]] = {}
    for called, wanted in filters.items():
        name, axis = swept_axis(grid, called, "filters")
        if name in kept:
            raise InputError(f"filters: {axis.label} is given twice", hint="give it once")
        kept[name] = _kept(axis, wanted)
    indices = [kept.get(name, np.arange(len(axis))) for name, axis in grid.axes.items()]
    return Selection(grid.shape, indices)


def _kept(axis: Axis, wanted: Any) -> NDArray[np.intp]:
    """Return the indices of those values of an axis that a filter keeps."""
    quantity = QUANTITIES[axis.name]
    spec = None if isinstance(wanted, tuple) else axis_of(wanted, quantity)
    if len(wanted) != 2 if spec is None else spec.is_range:
        problem = f"filters: {axis.label} = {shown(wanted)}: must be a value, a list, or a pair (low, high)"
        raise InputError(problem, hint="write it like 1.5, [10, 20] or (10, 20)")
    if spec is not None:
        return np.unique([index_of(axis, float(value)) for value in spec.values])
    ends = zip(wanted, (-math.inf, math.inf), strict=True)
    low, high = (end if given is None else one_value(given, quantity, "filters") for given, end in ends)
    kept = np.flatnonzero((axis.values >= low) & (axis.values <= high))
    if not kept.size:
        span = f"{low:.10g} to {high:.10g} {axis.unit}".rstrip()
        raise InputError(f"filters: no value of {axis.label} lies from {span}", hint=f"there are {axis}")
    return kept
