"""Sweeps from Python: all cells in memory, as arrays, as a data frame, as pictures."""

from __future__ import annotations

import os
from dataclasses import dataclass
from inspect import signature
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal, NamedTuple

import numpy as np

from vibro.errors import InputError, did_you_mean, shown
from vibro.files.scene_files import SceneFile, read_scene_file
from vibro.quantities import BY_COLUMN, QUANTITIES
from vibro.reals import shielded
from vibro.results.steady import summary
from vibro.results.sweep import Block
from vibro.scene import Scene
from vibro.steady import check_switch, checked_starts, output_of
from vibro.sweeps.columns import arrow_table, frame_of, table_columns
from vibro.sweeps.datasets import check_xarray, dataset, results_among, values_of
from vibro.sweeps.request import RANGES, gather
from vibro.sweeps.solved import SolvedGrid, check_memory

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Mapping, Sequence
    from os import PathLike

    import pandas as pd
    import xarray as xr
    from numpy.typing import NDArray

    from vibro.quantities import Quantity
    from vibro.results.steady import SteadyCycle
    from vibro.sweeps.grid import Grid
    from vibro.sweeps.request import Caller, Request

_BYTES_PER_CELL: Final = 110  # [B] of all results


class _Call(NamedTuple):
    """How messages name the arguments of a function; ``typed`` holds them as they were typed."""

    function: str = "sweep"
    typed: tuple[str, ...] = ()
    gives: str = "the call"
    takes_one_value: tuple[str, str] = ("one value is wanted", "vibro.sweep takes axes")

    def name(self, quantity: Quantity) -> str:
        return quantity.column

    def example(self, values: Mapping[str, str], *, from_scratch: bool) -> str:
        given = [f"{QUANTITIES[name].column}={value}" for name, value in values.items()]
        return f"vibro.{self.function}({', '.join([*(() if from_scratch else self.typed), *given])})"


class _File(_Call):
    """How messages name the inputs of a scene file."""

    def example(self, values: Mapping[str, str], *, from_scratch: bool) -> str:
        return "; ".join(f"{QUANTITIES[name].column} = {value}" for name, value in values.items())


@dataclass(frozen=True, eq=False, repr=False)
class Sweep(SolvedGrid):
    """A solved sweep in memory; returned by ``vibro.sweep``.

    Attributes
    ----------
    cycle : SteadyCycle
        Results: arrays with one dimension per axis, in the order of ``axes``.
    shape : tuple of int
        Number of values of each axis.
    axes : dict of str to array
        Values of the quantities that vary, by their keys in a scene file, in the unit that the key names.
    fixed : dict of str to float
        Values of all other quantities, by their keys.
    """

    _block: Block

    @property
    def cycle(self) -> SteadyCycle:
        """Results: arrays with one dimension per axis, in the order of ``axes``."""
        return self._block.cycle

    @shielded
    def to_frame(self, columns: Sequence[str] | None = None) -> pd.DataFrame:
        """Return the cells as a data frame.

        Parameters
        ----------
        columns : sequence of str, optional
            Names of columns, as for ``--columns`` of ``vibro map``; by default its standard columns.

        Returns
        -------
        pandas.DataFrame
            One row per cell, the last axis fastest, with the columns of the CSV of ``vibro map``; their names
            contain the units. Texts are categorical, ``coexists`` is a nullable integer, and missing numbers
            are NaN. The categories of regimes, models and statuses are complete and in the order of their
            codes, from no-slip to hopping.

        Raises
        ------
        InputError
            If a column does not exist or is named twice.
        """
        return frame_of(arrow_table(table_columns(self._grid, columns), self._block))

    @shielded
    def to_xarray(self, columns: Sequence[str] | None = None) -> xr.Dataset:
        """Return the cells as labelled arrays.

        Parameters
        ----------
        columns : sequence of str, optional
            As for ``to_frame``.

        Returns
        -------
        xarray.Dataset
            The axes are the dimensions; all other inputs are coordinates, which are scalars if they are
            fixed. Results are variables, with the names of ``to_frame``: missing numbers are NaN, ``pattern``
            is text, and ``regime``, ``model``, ``status`` and ``coexists`` are integer codes (int8), which
            the attributes ``flag_values`` and ``flag_meanings`` explain. Attributes follow the CF
            conventions; ``to_netcdf(path, engine="h5netcdf")`` writes a file.

        Raises
        ------
        InputError
            If a column does not exist or is named twice.
        FileError
            If xarray is not installed.

        Examples
        --------
        >>> import vibro
        >>> t = vibro.sweep(amplitude_mm=[0.5, 1, 1.5], frequency_hz=[10, 15], drive_angle_deg=20,
        ...                 static_friction=0.74, kinetic_friction=0.57)
        >>> nut = t.to_xarray()
        >>> dict(nut.sizes)
        {'amplitude_mm': 3, 'frequency_hz': 2}
        >>> speed = nut.mean_velocity_mm_s
        >>> print(speed.sel(amplitude_mm=1, frequency_hz=15).round(3).item(), speed.units)
        16.263 mm s-1
        >>> nut.regime.flag_meanings
        'none no_slip forward_slip back_slip hopping'
        """
        check_xarray()
        found = results_among(table_columns(self._grid, columns), self._grid)
        return dataset(self._grid, self._title, found, values_of(arrow_table(found, self._block), self.shape))

    def _summary(self) -> list[tuple[str, str]]:
        return summary(self.cycle)

    def _cells(
        self, results: Collection[str], indices: Sequence[NDArray[np.intp]]
    ) -> dict[str, NDArray[Any]]:
        box = np.ix_(*indices)
        return {name: getattr(self.cycle, name)[box] for name in results}


@shielded
def sweep(
    scene_file: str | PathLike[str] | None = None,
    *,
    output: Literal["exact", "regimes"] = "exact",
    flight: bool = True,
    starts: int | None = None,
    progress: Callable[[int, int], None] | None = None,
    **quantities: Any,
) -> Sweep:
    """Solve all combinations of several axes in memory, like ``vibro map``.

    Parameters
    ----------
    scene_file : path, optional
        A scene file; its tables ``[scene]``, ``[machine]`` and ``[map]`` are read.
    output, flight, starts, progress : optional
        As for ``vibro.solve``.
    **quantities
        Values by the keys of a scene file, whose values they override:

        * a line: ``amplitude_mm`` or ``stroke_mm``, and ``drive_angle_deg``;
        * an ellipse: ``along_amplitude_mm``, ``normal_amplitude_mm`` and ``normal_phase_deg``, with ``_2``
          before the unit for the second harmonic (``along_phase_2_deg``);
        * a machine, which the scene file describes, instead of an amplitude: ``setting_percent``,
          ``voltage_percent``, ``filling_kg``, and ``natural_hz`` or the name of a spring ``pack``;
        * and ``frequency_hz``, ``static_friction``, ``kinetic_friction`` or ``friction_ratio``,
          ``trough_angle_deg``, ``trough_length_mm``, ``gravity_m_s2``, ``restitution``.

        A value is a number, an ascending sequence of numbers, or an axis such as ``"0.1:3:100"`` or
        ``"10,20"``; a text may contain a unit, ``"800um"``. The amplitude of a line may be given by its
        acceleration or speed, ``"4g"``, ``"110mm/s rms"``: this is then the axis, ``acceleration_g`` or
        ``drive_speed_mm_s``, and the amplitude has its column too. Without amplitude and frequency the sweep
        covers 0.1 to 3 mm and 5 to 60 Hz.

    Returns
    -------
    Sweep
        The solved cells, about 110 bytes each.

    Raises
    ------
    InputError
        If an input is wrong or missing, or memory is too small; the message lists all problems.
    FileError
        If the scene file cannot be read.

    Examples
    --------
    >>> import vibro
    >>> t = vibro.sweep(amplitude_mm="0.5:1.5:3", frequency_hz=15, drive_angle_deg=20,
    ...                 static_friction=0.74, kinetic_friction=0.57)
    >>> t.axes
    {'amplitude_mm': array([0.5, 1. , 1.5])}
    >>> print(t.cycle.pattern, t.cycle.mean_velocity.round(6))
    ['_' 'F_' 'FB_'] [0.       0.016263 0.040591]
    """
    request = request_of_call(scene_file, quantities)
    grid = grid_of_call(request, output, flight=flight, starts=starts)
    check_memory(
        grid.shape, _BYTES_PER_CELL, "ask for fewer values, or write them to files by vibro.write_sweep"
    )
    values = grid.values()
    block = Block(values, grid.solve(values, progress=progress), grid.length)
    return Sweep(grid, request.own, request.name or "", block)


def grid_of_call(request: Request, output: str, *, flight: bool, starts: int | None) -> Grid:
    """Make the grid of a request with the switches of a call, which are checked."""
    kept = output_of(output)
    check_switch("flight", flight)
    number = None if starts is None else checked_starts(starts)
    return request.grid(kept, flight=flight, starts=number)


class Inputs(NamedTuple):
    """Arguments of a function that are named as the keys of scene files, for ``gather``."""

    given: Mapping[str, object]
    file: SceneFile | None
    caller: Caller
    pack: str | None


def request_of_call(
    scene_file: str | PathLike[str] | None,
    quantities: Mapping[str, Any],
    function: Callable[..., Any] = sweep,
    *typed: str,
) -> Request:
    """Read the request of a function, as ``inputs_of_call`` reads its arguments."""
    given, file, call, pack = inputs_of_call(scene_file, quantities, function, *typed)
    return gather(given, file, call, reads_map=True, takes_axes=True, ranges=RANGES, pack=pack)


def inputs_of_call(
    scene_file: str | PathLike[str] | None,
    quantities: Mapping[str, Any],
    function: Callable[..., Any],
    *typed: str,
) -> Inputs:
    """Read arguments of a function that are named as the keys of scene files.

    Parameters
    ----------
    scene_file, quantities
        Its arguments.
    function : callable
        Which.
    *typed : str
        Arguments before these, as they were typed.
    """
    quantities = dict(quantities)
    pack = quantities.pop("pack", None)
    if not isinstance(pack, str | None):
        raise InputError(f"pack = {shown(pack)}: must be a name", hint='write it like pack="6 leaves"')
    unknown = [key for key in quantities if key not in BY_COLUMN]
    if unknown:
        hint = (
            did_you_mean(unknown[0], [*signature(function).parameters, *BY_COLUMN])
            or f"known are {', '.join(BY_COLUMN)}"
        )
        raise InputError(*(f"unknown argument {shown(key)}" for key in unknown), hint=hint)
    given = {BY_COLUMN[key].name: value for key, value in quantities.items()}
    file = None if scene_file is None else _read(scene_file)
    typed += (repr(str(scene_file)),) if scene_file is not None else ()
    call = _Call(function.__name__, (*typed, *(f"{key}={shown(value)}" for key, value in quantities.items())))
    return Inputs(given, file, call, pack)


def _read(path: str | PathLike[str]) -> SceneFile:
    if not isinstance(path, str | os.PathLike):
        raise InputError(f"scene file = {shown(path)}: must be a path", hint='write it like "scene.toml"')
    return read_scene_file(Path(path))


@shielded
def read_scene(path: str | PathLike[str]) -> Scene:
    """Read the operating point of a scene file, from its tables ``[scene]``, ``[motion]`` and ``[machine]``.

    Parameters
    ----------
    path : path
        A scene file in TOML, as for the commands.

    Returns
    -------
    Scene
        One operating point, of shape (), without the trough's length. With a machine the amplitude is that of
        its operating point.

    Raises
    ------
    InputError
        If the file does not describe a complete scene; the message lists all problems.
    FileError
        If the file cannot be read.

    Examples
    --------
    >>> import vibro
    >>> scene = vibro.read_scene("examples/safety_nut.toml")
    >>> print(vibro.solve(scene).pattern)
    F_
    """
    return gather({}, _read(path), _File()).scene()
