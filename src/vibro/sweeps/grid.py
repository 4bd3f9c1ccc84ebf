"""The grid of a sweep: its axes and fixed quantities, in the user's units."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.core.codes import Output
from vibro.quantities import (
    LINEAR,
    QUANTITIES,
    RATES,
    STANDS_FOR,
    as_given,
    drive_of,
    kinetic_friction,
    millimetres,
    scene_fields,
    with_amplitude,
)
from vibro.results.operating import OPERATING
from vibro.results.sweep import cell_values
from vibro.scene import Scene
from vibro.steady import solve
from vibro.sweeps.machines import operated, withheld

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from numpy.typing import NDArray

    from vibro.axes import Axis
    from vibro.files.machines import GivenMachine
    from vibro.files.motions import GivenMotion
    from vibro.reals import Floats
    from vibro.results.steady import SteadyCycle


#: Key of a description: the quantity in which the amplitude was given, if that is another one.
GIVEN_IN: Final = "amplitude_given_as"

_LEAST_ROW: Final = 24  # [cells] Shorter rows save little.
_LEAST_ROWS: Final = 32  # With fewer, the extra cells of whole rows would outweigh the saving.


@dataclass(frozen=True, eq=False)
class Grid:
    """The grid of a sweep, in the user's units.

    Attributes
    ----------
    axes : mapping of str to Axis
        The axes that vary, in the order of ``SWEPT``.
    fixed : mapping of str to float
        Every other quantity of the scene by name, with gravity.
    length : float or None
        Length of the trough [mm].
    output, flight, starts : optional
        Arguments of ``vibro.solve`` for every cell.
    arrivals : bool, optional
        Whether bodies are followed from rest to their arrival.
    motion : GivenMotion, optional
        Of a drive by steps or samples, which has neither amplitudes nor angles.
    in_stroke : bool, optional
        Whether texts contain the stroke of a drive along a line, as it was given, in place of its
        amplitude; tables have the amplitude.
    machine : GivenMachine, optional
        From which the amplitude of every cell follows: it is neither an axis nor fixed.
    """

    axes: Mapping[str, Axis]
    fixed: Mapping[str, float]
    length: float | None
    output: Output = Output.EXACT
    flight: bool = True
    starts: int | None = None
    arrivals: bool = False
    motion: GivenMotion | None = None
    in_stroke: bool = False
    machine: GivenMachine | None = None

    @property
    def given_axes(self) -> dict[str, Axis]:
        """The axes in the quantities that were given, by their names, for texts."""
        axes = [axis.in_stroke if self.in_stroke else axis for axis in self.axes.values()]
        return {axis.name: axis for axis in axes}

    def as_given(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Return quantities as they were given, by their names, for texts."""
        return as_given(values, in_stroke=self.in_stroke)

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values of each axis."""
        return tuple(len(axis) for axis in self.axes.values())

    @property
    def size(self) -> int:
        """Number of cells."""
        return math.prod(self.shape)

    @property
    def drive(self) -> tuple[str, ...]:
        """Names of the drive's quantities."""
        return LINEAR if self.machine is not None else drive_of((*self.axes, *self.fixed))

    @property
    def made_with(self) -> tuple[str, ...]:
        """Names of the quantities in every row of tables, because the results depend on them.

        Restitution where flights are followed, which a clamped part never begins, unless it is an axis, which
        has its column anyway; the trough's length where there is one.
        """
        hops = self.flight and "normal_acceleration" not in {*self.axes, *self.fixed}
        names = {
            "restitution": hops and "restitution" not in self.axes,
            "trough_length": self.length is not None,
        }
        return tuple(name for name, is_needed in names.items() if is_needed)

    @property
    def is_dear(self) -> bool:
        """Whether bodies may bounce, or start many times: that takes up to some ms a cell."""
        bounces = self.fixed.get("restitution", 1.0) > 0.0
        return self.flight and (self.starts is not None or bounces)

    def values(self, box: tuple[slice, ...] | None = None) -> dict[str, Floats]:
        """Return every quantity of a box of cells, in the user's units.

        Parameters
        ----------
        box : tuple of slice, optional
            One for each axis; without it the whole grid.

        Returns
        -------
        dict of str to array
            By name; broadcastable to the box's shape. The amplitude of a line and the kinetic friction are
            always among them, whatever gives them, and the motion is under ``motion``, an array of one
            object. With a machine the amplitude found is among them, NaN where there is none, and under
            ``OPERATING`` its other results.
        """
        return self._completed(cell_values(self.axes, self.fixed, box))

    def cells(self, start: int, stop: int) -> dict[str, Floats]:
        """Return every quantity of some cells in a row, the last axis running fastest."""
        return self.picked(np.arange(start, stop))

    def picked(self, cells: NDArray[np.intp]) -> dict[str, Floats]:
        """Return every quantity of cells by their numbers, as ``values`` does: flat arrays."""
        result = {name: np.array([value]) for name, value in self.fixed.items()}
        where = np.unravel_index(cells, self.shape) if self.axes else ()
        result |= {axis.name: axis.values[i] for axis, i in zip(self.axes.values(), where, strict=True)}
        return self._completed(result)

    def solve(
        self,
        values: Mapping[str, Floats],
        threads: int | None = None,
        progress: Callable[[int, int], None] | None = None,
    ) -> SteadyCycle:
        """Solve the cells of a box, given by its ``values``, on so many threads, telling the progress."""
        cycle = solve(
            scene_of(values),
            output=self.output,
            flight=self.flight,
            starts=self.starts,
            threads=threads,
            progress=progress,
        )
        return cycle if self.machine is None else withheld(cycle, values)

    def solve_cells(
        self,
        start: int,
        stop: int,
        threads: int | None = None,
        progress: Callable[[int, int], None] | None = None,
    ) -> tuple[dict[str, Floats], SteadyCycle]:
        """Solve some cells in a row, as ``cells`` numbers them; return their quantities too.

        Notes
        -----
        Groups of quantities that the inner axes share are formed once a row of these, not once a cell: whole
        rows are solved, a few cells more than asked for.
        """
        values = self.cells(start, stop)
        inner = self._row(stop - start) if self.machine is None else 0
        if not inner:
            return values, self.solve(values, threads, progress)
        length = math.prod(self.shape[-inner:])
        first, last = start // length, -(-stop // length)
        cycle = self.solve(self._rows(first, last, inner), threads, progress)
        asked = slice(start - first * length, stop - first * length)
        return values, replace(cycle, **{name: x.reshape(-1)[asked] for name, x in cycle.arrays().items()})

    def _row(self, cells: int) -> int:
        """Return how many of the last axes make a row worth solving whole, with an axis left over; else 0."""
        lengths = [math.prod(self.shape[-inner:]) for inner in range(1, len(self.axes))]
        inner = sum(length * _LEAST_ROWS <= cells for length in lengths)
        return inner if inner and lengths[inner - 1] >= _LEAST_ROW else 0

    def _rows(self, start: int, stop: int, inner: int) -> dict[str, Floats]:
        """Return every quantity of rows along so many inner axes: shaped like the rows, then these axes."""
        axes = list(self.axes.values())
        along = {axis.name: axis for axis in axes[-inner:]}
        result = {name: values[np.newaxis] for name, values in cell_values(along, self.fixed).items()}
        where = np.unravel_index(np.arange(start, stop), self.shape[:-inner])
        for axis, i in zip(axes[:-inner], where, strict=True):
            result[axis.name] = axis.values[i].reshape(-1, *(1,) * inner)
        return self._completed(result)

    def operating_point(self, own: Mapping[str, float] | None) -> dict[str, float] | None:
        """Return the scene's value of every axis; None unless it gives all and is otherwise the same."""
        here = with_amplitude(own or {})
        for name in RATES.keys() & self.axes.keys() - here.keys():
            if {"amplitude", "frequency"} <= here.keys():
                here[name] = here["amplitude"] / millimetres(name, here["frequency"])
        if own is None or not self.axes.keys() <= here.keys():
            return None
        varying = {"trough_length", *(STANDS_FOR.get(name, name) for name in self.axes)}
        others = {name: value for name, value in own.items() if STANDS_FOR.get(name, name) not in varying}
        elsewhere = any(self.fixed.get(name) != value for name, value in others.items())
        return None if elsewhere else {name: here[name] for name in self.axes}

    def describe(self, *, every_value: bool = False) -> dict[str, Any]:
        """Describe the grid: fixed quantities and axes, by their columns.

        Values of an axis are listed where they do not follow from its ends, or with ``every_value``.
        """
        axes = {
            axis.column: {
                "count": len(axis),
                "first": float(axis.values[0]),
                "last": float(axis.values[-1]),
                "spacing": axis.spacing,
                **({"values": axis.values.tolist()} if every_value or axis.spacing == "list" else {}),
            }
            for axis in self.axes.values()
        }
        scene = {QUANTITIES[name].column: value for name, value in self.fixed.items()}
        if self.length is not None:
            scene[QUANTITIES["trough_length"].column] = self.length
        motion = {} if self.motion is None else {"motion": dict(self.motion.table)}
        motion |= {} if self.machine is None else {"machine": dict(self.machine.table)}
        given = {GIVEN_IN: QUANTITIES["stroke"].column} if self.in_stroke else {}
        return {"scene": scene, **motion, "axes": axes, **given}

    def _completed(self, values: dict[str, Any]) -> dict[str, Any]:
        """Add what follows: amplitude, kinetic friction where its ratio is given, and what the drive does."""
        values = with_amplitude(values)
        if "friction_ratio" in values:
            values["kinetic_friction"] = kinetic_friction(values["friction_ratio"], values["static_friction"])
        if self.motion is not None:
            values["motion"] = np.full((1,) * max(x.ndim for x in values.values()), self.motion.motion)
        return values if self.machine is None else values | operated(self.machine, values)


def scene_of(values: Mapping[str, Floats]) -> Scene:
    """Make the scenes of a box of cells, of which some combinations may be infeasible.

    Cells whose machine has no operating point get an arbitrary amplitude; their results are removed later.
    """
    if OPERATING in values:
        amplitude = values["amplitude"]
        values = {**values, "amplitude": np.where(np.isnan(amplitude), 1.0, amplitude)}
    return Scene.allowing_infeasible(**scene_fields(values))
