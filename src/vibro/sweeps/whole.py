"""Sweeps from Python: every cell held, as arrays, as a data frame, as pictures."""

from __future__ import annotations

import difflib
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal, NamedTuple

import numpy as np

from vibro.axes import axis_of
from vibro.core.codes import Level
from vibro.errors import InputError
from vibro.files.scene_files import read_scene_file
from vibro.limits import critical_loads
from vibro.quantities import QUANTITIES, find_quantity, scene_fields
from vibro.results.sweep import Block, SweepResult
from vibro.scene import Scene
from vibro.steady import level_of, solve
from vibro.sweeps.columns import columns_of, to_frame
from vibro.sweeps.request import RANGES, gather

if TYPE_CHECKING:
    from collections.abc import Mapping
    from os import PathLike

    import pandas as pd
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from vibro.axes import AxisSpec
    from vibro.quantities import Quantity
    from vibro.results.steady import SteadyCycle
    from vibro.sweeps.grid import Grid
    from vibro.sweeps.request import Request

__all__ = ["Sweep", "read_scene", "sweep"]

_BY_COLUMN: Final = {quantity.column: quantity for quantity in QUANTITIES.values()}


class _Call(NamedTuple):
    """How messages speak of the arguments of a function; ``typed`` are those given, as they were typed."""

    function: str
    typed: tuple[str, ...] = ()
    gives: str = "the call"
    an_axis: str = 'amplitude_mm="0.1:3:200"'
    takes_one_value: tuple[str, str] = ("one value is wanted", "vibro.sweep takes axes")

    def name(self, quantity: Quantity) -> str:
        return quantity.column

    def example(self, values: Mapping[str, str], *, from_scratch: bool) -> str:
        given = [f"{QUANTITIES[name].column}={value}" for name, value in values.items()]
        return f"vibro.{self.function}({', '.join([*(() if from_scratch else self.typed), *given])})"


@dataclass(frozen=True, eq=False)
class Sweep:
    """A solved sweep; made by ``vibro.sweep``.

    Attributes
    ----------
    cycle : SteadyCycle
        Results: arrays with one dimension for each axis, in the order of ``axes``.
    shape : tuple of int
        Number of values of each axis.
    axes : dict of str to array
        Values of what varies, by its key in a scene file, in the unit that the key names.
    fixed : dict of str to float
        Every other quantity, likewise.
    """

    cycle: SteadyCycle
    _grid: Grid
    _own: Mapping[str, float]
    _title: str

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values of each axis."""
        return self._grid.shape

    @property
    def axes(self) -> dict[str, NDArray[np.float64]]:
        """Values of what varies, by key."""
        return {axis.column: axis.values for axis in self._grid.axes.values()}

    @property
    def fixed(self) -> dict[str, float]:
        """Every other quantity, by key."""
        return dict(self._grid.describe()["scene"])

    def to_frame(self) -> pd.DataFrame:
        """Return the cells as a data frame.

        Returns
        -------
        pandas.DataFrame
            One row a cell, the last axis fastest; the columns of the CSV of ``vibro map``, their units in
            their names. Texts are categorical, ``coexists`` is a nullable integer, and what has no number
            is NaN.
        """
        block = Block(self._values, self.cycle, self._grid.length)
        return to_frame(columns_of(self._grid.axes), block)

    def draw(
        self,
        name: Literal["regime", "speed", "traverse", "impact", "flight"],
        *,
        x: str | None = None,
        y: str | None = None,
        at: Mapping[str, float] | None = None,
    ) -> Figure:
        """Draw a picture of the cells held; ``vibro map`` solves its own, finer ones.

        Parameters
        ----------
        name : {"regime", "speed", "traverse", "impact", "flight"}
            What is drawn: a map where two axes vary or more, else lines over bands of the regimes.
        x, y : str, optional
            The axes drawn across and up, by key, name or letter (``"amplitude_mm"``, ``"A"``).
        at : mapping of str to float, optional
            Where other axes are held, by the same names, in the user's units.

        Returns
        -------
        matplotlib.figure.Figure
            Without a window; ``figure.savefig(path)`` writes it.

        Raises
        ------
        InputError
            If there is no such picture of this sweep, or an axis or a value is not one of its own.
        """
        from vibro.plots import map_figures, picture_names

        known = picture_names(len(self.shape), has_length=self._grid.length is not None)
        if name not in known:
            raise InputError(
                f"draw({name!r}): no such picture of this sweep", hint=f"there are {', '.join(known)}"
            )
        axes = self._grid.axes
        result = SweepResult(
            axes,
            self._grid.fixed,
            self.cycle,
            critical_loads(_scene_of(self._values)),
            self._grid.length,
            {axis: self._own[axis] for axis in self._grid.axes}
            if self._grid.axes.keys() <= self._own.keys()
            else None,
            self._title,
        )
        held = {_axis_name(axis): value for axis, value in (at or {}).items()}
        return map_figures(result, [name], x=x and _axis_name(x), y=y and _axis_name(y), at=held)[name]

    @property
    def _values(self) -> dict[str, NDArray[np.float64]]:
        return self._grid.values((slice(None),) * len(self.shape))


def _scene_of(values: Mapping[str, NDArray[np.float64]]) -> Scene:
    return Scene.allowing_infeasible(**scene_fields(values))


def _axis_name(text: str) -> str:
    quantity = find_quantity(text)
    return quantity.name if quantity else text


def sweep(
    scene_file: str | PathLike[str] | None = None,
    *,
    accuracy: Literal["exact", "regimes"] = "exact",
    flight: bool = True,
    **quantities: Any,
) -> Sweep:
    """Solve all combinations of what varies, as ``vibro map`` does, and hold them.

    Parameters
    ----------
    scene_file : path, optional
        A scene file; its table ``[map]`` counts.
    accuracy, flight : optional
        As for ``vibro.solve``.
    **quantities
        Keys and values as in a scene file, which they override: ``amplitude_mm``, ``stroke_mm``,
        ``frequency_hz``, ``drive_angle_deg``, ``static_friction``, ``kinetic_friction`` or
        ``friction_ratio``, ``trough_angle_deg``, ``trough_length_mm``, ``gravity_m_s2``, ``restitution``. A
        value is a number, an ascending sequence of numbers, or an axis such as ``"0.1:3:100"`` or
        ``"10,20"``. Without amplitude and frequency they sweep 0.1:3 mm and 5:60 Hz.

    Returns
    -------
    Sweep
        With about 110 bytes a cell.

    Raises
    ------
    InputError
        It names everything that is wrong or missing.
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
    request = _request(scene_file, quantities)
    level = level_of(accuracy)
    grid = request.grid(level, flight=flight and level is Level.EXACT)
    values = grid.values((slice(None),) * len(grid.shape))
    cycle = solve(_scene_of(values), accuracy=level, flight=grid.flight)
    return Sweep(cycle, grid, request.own, request.name or "")


def _request(scene_file: str | PathLike[str] | None, quantities: Mapping[str, Any]) -> Request:
    """Read what is given by the keys of scene files."""
    unknown = [key for key in quantities if key not in _BY_COLUMN]
    if unknown:
        close = difflib.get_close_matches(unknown[0], list(_BY_COLUMN), n=1, cutoff=0.5)
        hint = f"did you mean {close[0]}?" if close else f"known are {', '.join(_BY_COLUMN)}"
        raise InputError(f"unknown argument {unknown[0]!r}", hint=hint)
    given: dict[str, AxisSpec | InputError] = {}
    for key, value in quantities.items():
        quantity = _BY_COLUMN[key]
        try:
            given[quantity.name] = axis_of(value, quantity)
        except InputError as exc:
            given[quantity.name] = exc
    file = None if scene_file is None else read_scene_file(Path(scene_file))
    typed = [repr(str(scene_file))] if scene_file is not None else []
    call = _Call("sweep", (*typed, *(f"{key}={value!r}" for key, value in quantities.items())))
    return gather(given, file, call, reads_map=True, takes_axes=True, ranges=RANGES)


def read_scene(path: str | PathLike[str]) -> Scene:
    """Read the operating point of a scene file: its table ``[scene]``.

    Parameters
    ----------
    path : path
        TOML, as the commands read it.

    Returns
    -------
    Scene
        Of shape (); the trough's length is no part of it.

    Raises
    ------
    InputError
        If it does not give a whole scene; it names everything that is wrong or missing.
    FileError
        If it cannot be read.

    Examples
    --------
    >>> import vibro
    >>> scene = vibro.read_scene("examples/safety_nut.toml")
    >>> print(vibro.solve(scene).pattern)
    F_
    """
    return gather({}, read_scene_file(Path(path)), _Call("read_scene")).scene()
