"""Sweeps: axes to blocks of scenes to results."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from vibro.axes import Axis
from vibro.core.codes import Status
from vibro.core.contact.limits import CriticalLoads, critical_loads
from vibro.motion.arrivals import arrival_time
from vibro.quantities import to_si
from vibro.scene import Scene
from vibro.steady import Accuracy, SteadyCycle, grid_blocks, solve

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

__all__ = ["Block", "Grid", "SweepResult", "sweep_blocks", "sweep_picture"]

# [cells] Enough that a block's fixed costs vanish, few enough that memory stays bounded and an interrupt is
# noticed at once.
_BLOCK: Final = 131_072
_WALKED_BLOCK: Final = 8_192  # where bodies are followed to their arrival, a hundred times the work

# [values of an axis] What a picture of one, two or three axes resolves, whatever the table's axes hold.
_RESOLVED: Final = {1: 4001, 2: 361, 3: 161}


@dataclass(frozen=True, eq=False)
class Grid:
    """What a sweep covers, in the user's units.

    Attributes
    ----------
    axes : mapping of str to Axis
        The axes that vary, in the order amplitude, frequency, drive_angle, static_friction, kinetic_friction
        or friction_ratio, trough_angle.
    fixed : mapping of str to float
        Every other quantity of the scene by name, with gravity and restitution.
    length : float or None
        Length of the trough [mm].
    accuracy, flight : optional
        How every cell is solved, as ``vibro.solve`` takes them.
    arrivals : bool, optional
        Whether bodies are followed from rest to their arrival.
    """

    axes: Mapping[str, Axis]
    fixed: Mapping[str, float]
    length: float | None
    accuracy: Accuracy = "exact"
    flight: bool = True
    arrivals: bool = False

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values of each axis."""
        return tuple(len(axis) for axis in self.axes.values())

    @property
    def size(self) -> int:
        """Number of cells."""
        return math.prod(self.shape)

    def values(self, box: tuple[slice, ...]) -> dict[str, Floats]:
        """Return every quantity of a box of cells, in the user's units.

        Parameters
        ----------
        box : tuple of slice
            One for each axis.

        Returns
        -------
        dict of str to array
            By name; broadcastable to the box's shape. The kinetic friction is always among them.
        """
        result = {name: np.full((1,) * len(box), value) for name, value in self.fixed.items()}
        for i, (axis, part) in enumerate(zip(self.axes.values(), box, strict=True)):
            result[axis.name] = axis.values[part].reshape([-1 if j == i else 1 for j in range(len(box))])
        if "friction_ratio" in result:
            result["kinetic_friction"] = result["friction_ratio"] * result["static_friction"]
        return result


@dataclass(frozen=True, eq=False)
class Block:
    """A solved part of a grid, as tables need it.

    Attributes
    ----------
    values : mapping of str to array
        Every quantity by name, in the user's units; broadcastable to the cycle's shape.
    cycle : SteadyCycle
        Results of the block's cells.
    length : float or None
        Length of the trough [mm].
    arrival : array or None
        Time from rest to the arrival, inf or NaN where there is none, if asked for [s].
    """

    values: Mapping[str, Floats]
    cycle: SteadyCycle
    length: float | None
    arrival: Floats | None = None

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the block's cells."""
        return self.cycle.status.shape


@dataclass(frozen=True, eq=False)
class SweepResult:
    """A solved grid, as pictures need it.

    Attributes
    ----------
    axes : mapping of str to Axis
        The axes that vary, in the order amplitude, frequency, drive_angle, static_friction, kinetic_friction
        or friction_ratio, trough_angle; values in the user's units. They are the dimensions of ``cycle``, in
        this order.
    fixed : mapping of str to float
        Every other quantity of the scene, by name, in the user's units, with gravity and restitution. It has
        kinetic_friction or, where that was given instead, friction_ratio.
    cycle : SteadyCycle
        Arrays of the grid's shape.
    limits : CriticalLoads
        Critical loads G of the grid's angles and frictions: arrays of the grid's shape, but of length 1 along
        amplitude and frequency.
    length : float or None
        Length of the trough [mm].
    operating_point : mapping of str to float, or None
        The scene's own value of every axis, in the user's units; None unless the scene gives all of them.
    title : str
        What the sweep is of, in one line.
    """

    axes: Mapping[str, Axis]
    fixed: Mapping[str, float]
    cycle: SteadyCycle
    limits: CriticalLoads
    length: float | None
    operating_point: Mapping[str, float] | None
    title: str

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values of each axis."""
        return tuple(len(axis) for axis in self.axes.values())


def sweep_blocks(grid: Grid) -> Iterator[Block]:
    """Solve a grid block by block, in the order of its cells.

    Parameters
    ----------
    grid : Grid
        Every value within its own range; combinations may be infeasible.

    Yields
    ------
    Block
        Together the whole grid; the last axis runs fastest.
    """
    for box in grid_blocks(grid.shape, _WALKED_BLOCK if grid.arrivals else _BLOCK):
        values = grid.values(box)
        cycle = _solve(grid, values)
        yield Block(values, cycle, grid.length, _arrival(grid, values, cycle) if grid.arrivals else None)


def sweep_picture(
    grid: Grid, drawn: Mapping[str, tuple[int, ...]], operating_point: Mapping[str, float] | None, title: str
) -> SweepResult:
    """Solve what pictures show of a grid, with a resolution of their own.

    Parameters
    ----------
    grid : Grid
        The whole grid.
    drawn : mapping of str to tuple of int
        Indices to keep of an axis, by name; a single one holds the axis at that value. Every other axis is
        resolved evenly between its ends.
    operating_point : mapping of str to float, or None
        The scene's own values.
    title : str
        What the sweep is of.

    Returns
    -------
    SweepResult
        Of at most three axes.
    """
    held = {name: indices[0] for name, indices in drawn.items() if len(indices) == 1}
    fixed = {**grid.fixed, **{name: float(grid.axes[name].values[i]) for name, i in held.items()}}
    varying = [axis for name, axis in grid.axes.items() if name not in held]
    count = _RESOLVED[len(varying)]
    axes = {
        axis.name: replace(axis, values=axis.values[list(drawn[axis.name])])
        if axis.name in drawn
        else _resolved(axis, count)
        for axis in varying
    }
    part = replace(grid, axes=axes, fixed=fixed)
    values = part.values((slice(None),) * len(axes))
    point = None
    if operating_point is not None and grid.axes.keys() <= operating_point.keys():
        point = {name: operating_point[name] for name in grid.axes}
    return SweepResult(axes, fixed, _solve(part, values), _limits(values), grid.length, point, title)


def _resolved(axis: Axis, count: int) -> Axis:
    """Spread values evenly between the ends of an axis."""
    ends = float(axis.values[0]), float(axis.values[-1])
    if axis.spacing == "log":
        return Axis(axis.name, np.geomspace(*ends, count), "log")
    return Axis(axis.name, np.linspace(*ends, count), "linear")


def _scene(values: Mapping[str, Floats]) -> Scene:
    return Scene.allowing_infeasible(
        **{name: to_si(name, value) for name, value in values.items() if name != "friction_ratio"}
    )


def _solve(grid: Grid, values: Mapping[str, Floats]) -> SteadyCycle:
    return solve(_scene(values), accuracy=grid.accuracy, flight=grid.flight)


def _arrival(grid: Grid, values: Mapping[str, Floats], cycle: SteadyCycle) -> Floats | None:
    """Follow bodies from rest; those whose flight is not modelled have no arrival."""
    if grid.length is None:
        return None
    time = np.asarray(arrival_time(_scene(values), to_si("trough_length", grid.length)))
    return np.where(cycle.status == Status.FLIGHT_NOT_MODELLED, np.nan, time)


def _limits(values: Mapping[str, Floats]) -> CriticalLoads:
    names = ("drive_angle", "static_friction", "kinetic_friction", "trough_angle")
    return critical_loads(*(to_si(name, values[name]) for name in names))
