"""Common part of sweeps in memory and in files: their axes, and their pictures."""

from __future__ import annotations

import math
import os
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

from vibro.axes import axis_of
from vibro.core.codes import Output
from vibro.errors import InputError, did_you_mean, shown
from vibro.html_tables import Shown, amount
from vibro.quantities import BY_COLUMN, LEAST_SPEED, QUANTITIES, checked_number, find_quantity, quantity_meant
from vibro.reals import shielded
from vibro.sweeps.run import solved_picture

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Mapping, Sequence

    import numpy as np
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from vibro.axes import Axis
    from vibro.plots.view import View
    from vibro.quantities import Quantity
    from vibro.sweeps.grid import Grid


@dataclass(frozen=True, eq=False, repr=False)
class SolvedGrid(Shown, ABC):
    """A grid with solved cells, in memory or in files."""

    _grid: Grid
    _own: Mapping[str, float]
    _title: str

    def __repr__(self) -> str:
        """Say what was swept: ``<Sweep of amplitude_mm (3 values) x frequency_hz (4 values)>``."""
        axes = [f"{axis.column} ({len(axis)} values)" for axis in self._grid.axes.values()]
        return f"<{type(self).__name__} of {' x '.join(axes) or 'one operating point'}>"

    def _table(self) -> tuple[str, list[tuple[str, ...]], tuple[()]]:
        """Return axes, fixed quantities and a summary of the cells."""
        rows = [tuple(str(axis).split(": ", 1)) for axis in self._grid.given_axes.values()]
        fixed = self._grid.as_given(self._grid.fixed)
        if self._grid.length is not None:
            fixed["trough_length"] = self._grid.length
        if self._grid.motion is not None:
            rows.append(("motion", ", ".join(self._grid.motion.table)))
        rows += [(QUANTITIES[n].label, amount(x, QUANTITIES[n].unit)) for n, x in fixed.items()]
        return repr(self).strip("<>"), [*rows, *self._summary()], ()

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values of each axis."""
        return self._grid.shape

    @property
    def axes(self) -> dict[str, NDArray[np.float64]]:
        """Values of the quantities that vary, by their keys in a scene file."""
        return {axis.column: axis.values.copy() for axis in self._grid.axes.values()}

    @property
    def fixed(self) -> dict[str, float]:
        """Values of all other quantities, by their keys in a scene file."""
        fixed = {QUANTITIES[name].column: value for name, value in self._grid.fixed.items()}
        return fixed if self._grid.length is None else {**fixed, "trough_length_mm": self._grid.length}

    @shielded
    def draw(
        self,
        name: Literal["regime", "speed", "traverse", "impact", "flight"],
        *,
        x: str | None = None,
        y: str | None = None,
        at: Mapping[str, float] | None = None,
        target_speed: float | str | None = None,
        path: str | os.PathLike[str] | None = None,
    ) -> Figure:
        """Draw a picture of the cells; ``vibro map`` solves more cells for finer pictures.

        Two ranges give a map, and one range gives a curve over bands of its regimes. A list of at most 12
        values is not a range: beside one range it gives several curves, beside two several maps, and alone
        points. A third range gives up to 12 maps. All further axes are fixed at the middle of their feasible
        values.

        Parameters
        ----------
        name : {"regime", "speed", "traverse", "impact", "flight"}
            The quantity to show.
        x, y : str, optional
            Horizontal and vertical axis, by key, name or letter (``"amplitude_mm"``, ``"A"``).
        at : mapping of str to float or str, optional
            Values of the axes that are fixed, by the same names; each must be one of the axis's values.
        target_speed : float or str, optional
            A speed that stands out in the picture of speeds: in mm/s, or with its unit.
        path : str or path, optional
            File to write, by its ending: ``.png``, ``.svg`` or ``.pdf``; an existing one is replaced.

        Returns
        -------
        matplotlib.figure.Figure
            No window opens. Of a range with at least twice as many values
            as a picture resolves (301 in a map, 161 in several maps, 4001 in a curve), every second, third
            ... value is shown.

        Raises
        ------
        InputError
            If this sweep has no such picture, axis or value.
        FileError
            If the file cannot be written.
        """
        from vibro.plots import map_figures, saver

        write, grid = saver(path), self._grid
        if target_speed is not None:
            target_speed = checked_number(f"{target_speed}", LEAST_SPEED)
        if not self.shape:
            raise _no_picture(name, "there are none")
        view, _ = view_of(grid, x, y, (at or {}).items())
        known = pictures_of(grid, view)
        if name not in known:
            hint = f"there are {', '.join(known) or 'none'}"
            raise _no_picture(
                name, "give trough_length_mm" if name == "traverse" and not grid.length else hint
            )
        result = solved_picture(grid, view.drawn, self._own, self._title, [name], self._cells)
        y = view.y.name if view.y else None
        return write(map_figures(result, [name], x=view.x.name, y=y, target_speed=target_speed)[name])

    @abstractmethod
    def _summary(self) -> list[tuple[str, str]]:
        """Summarise the cells: pairs of a name and a text."""

    @abstractmethod
    def _cells(
        self, results: Collection[str], indices: Sequence[NDArray[np.intp]]
    ) -> dict[str, NDArray[Any]]:
        """Return results by name, of the cells at some values of every axis: arrays of their shape."""


def _no_picture(name: str, hint: str) -> InputError:
    return InputError(f"draw({shown(name)}): no such picture of this sweep", hint=hint)


def view_of(
    grid: Grid, x: str | None, y: str | None, at: Iterable[tuple[str, Any]], argument: str = "at"
) -> tuple[View, dict[str, float]]:
    """Choose what the pictures of a sweep show; return the values that axes are held at on request, too."""
    from vibro.plots.view import choose_view

    held: dict[str, float] = {}
    for called, value in at:
        quantity = axis_called(called, argument)
        if quantity.name == "amplitude" and isinstance(value, str):  # which may be 4g
            quantity = quantity_meant((value,), quantity)
        given = grid.as_given({quantity.name: one_value(value, quantity, argument)})
        if held.keys() & given.keys():
            raise InputError(f"{argument}: {quantity.label} is given twice", hint="give it once")
        held |= given
    x, y = (found.name if (found := find_quantity(axis or "")) else axis for axis in (x, y))
    return choose_view(grid.given_axes, x, y, held, grid.as_given(grid.fixed)), held


def pictures_of(grid: Grid, view: View, *, on_request: bool = True) -> list[str]:
    """Name the pictures of a sweep; those of flights are drawn on request only."""
    names = ["regime"] if view.y else []
    if grid.output is Output.EXACT:
        names += ["speed", *(["traverse"] if grid.length is not None else [])]
        names += ["impact", "flight"] if on_request else []
    return names


def axis_called(called: object, argument: str) -> Quantity:
    """Find the quantity that an argument names by key, name or letter."""
    quantity = find_quantity(str(called))
    if quantity is None:
        raise InputError(
            f"{argument}: {shown(called)} is no axis",
            hint=did_you_mean(called, BY_COLUMN) or "axes are called by key, such as amplitude_mm, or letter",
        )
    return quantity


def swept_axis(grid: Grid, called: object, argument: str) -> tuple[str, Axis]:
    """Find the axis of a sweep that an argument names: its name there, and its values as they are called."""
    quantity = axis_called(called, argument)
    in_stroke = quantity.name == "stroke"
    name = "amplitude" if in_stroke else quantity.name
    if name not in grid.axes:
        known = ", ".join(axis.label for axis in grid.axes.values()) or "none"
        raise InputError(
            f"{argument}: {quantity.label} does not vary in this sweep", hint=f"its axes are {known}"
        )
    return name, grid.axes[name].in_stroke if in_stroke else grid.axes[name]


def one_value(value: object, quantity: Quantity, argument: str) -> float:
    """Read one value of a quantity, which may be a text with a unit."""
    spec = axis_of(value, quantity)
    if spec.varies:
        raise InputError(
            f"{argument}: {quantity.label} = {shown(value)}: must be one value", hint="give one number"
        )
    return spec.value


def check_memory(shape: Sequence[int], bytes_per_cell: int, hint: str) -> None:
    """Refuse cells that do not fit into memory, if the system reports its size."""
    if not hasattr(os, "sysconf"):  # Windows
        return
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    needed = math.prod(shape) * bytes_per_cell
    if needed > memory:
        cells = f"{' x '.join(map(str, shape))} = {math.prod(shape)} cells"
        raise InputError(
            f"{cells} take about {needed / 1e9:.3g} GB, of {memory / 1e9:.3g} GB in all", hint=hint
        )
