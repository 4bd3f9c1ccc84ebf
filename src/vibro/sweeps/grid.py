"""What a sweep covers: its axes and fixed quantities, in the user's units."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from vibro.core.codes import Level
from vibro.quantities import QUANTITIES, drive_of, kinetic_friction, scene_fields
from vibro.results.sweep import spread
from vibro.scene import Scene
from vibro.steady import solve

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from vibro.axes import Axis
    from vibro.results.steady import SteadyCycle

    Floats = NDArray[np.float64]

__all__ = ["Grid", "scene_of"]


@dataclass(frozen=True, eq=False)
class Grid:
    """What a sweep covers, in the user's units.

    Attributes
    ----------
    axes : mapping of str to Axis
        The axes that vary, in the order of ``SWEPT``.
    fixed : mapping of str to float
        Every other quantity of the scene by name, with gravity.
    length : float or None
        Length of the trough [mm].
    level, flight, coexistence : optional
        How every cell is solved, as ``vibro.solve`` takes them (``level`` as ``accuracy``).
    arrivals : bool, optional
        Whether bodies are followed from rest to their arrival.
    """

    axes: Mapping[str, Axis]
    fixed: Mapping[str, float]
    length: float | None
    level: Level = Level.EXACT
    flight: bool = True
    coexistence: bool = False
    arrivals: bool = False

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
        """Names of the quantities that tell the drive."""
        return drive_of((*self.axes, *self.fixed))

    def values(self, box: tuple[slice, ...] | None = None) -> dict[str, Floats]:
        """Return every quantity of a box of cells, in the user's units.

        Parameters
        ----------
        box : tuple of slice, optional
            One for each axis; without it the whole grid.

        Returns
        -------
        dict of str to array
            By name; broadcastable to the box's shape. The kinetic friction is always among them.
        """
        result = spread(self.axes, self.fixed, box)
        if "friction_ratio" in result:
            result["kinetic_friction"] = kinetic_friction(result["friction_ratio"], result["static_friction"])
        return result

    def solve(self, values: Mapping[str, Floats], threads: int | None = None) -> SteadyCycle:
        """Solve the cells of a box, given by its ``values``, on so many threads; without, one a core."""
        return solve(
            scene_of(values),
            accuracy=self.level,
            flight=self.flight,
            coexistence=self.coexistence,
            threads=threads,
        )

    def operating_point(self, own: Mapping[str, float] | None) -> dict[str, float] | None:
        """Return a scene's own value of every axis; None unless it gives all and differs in nothing else."""
        if own is None or not self.axes.keys() <= own.keys():
            return None
        others = {name: value for name, value in own.items() if name not in (*self.axes, "trough_length")}
        elsewhere = any(self.fixed.get(name) != value for name, value in others.items())
        return None if elsewhere else {name: own[name] for name in self.axes}

    def describe(self) -> dict[str, Any]:
        """Return what a sidecar says of it: fixed quantities and axes, by their columns."""
        axes = {
            axis.column: {
                "count": len(axis),
                "first": float(axis.values[0]),
                "last": float(axis.values[-1]),
                "spacing": axis.spacing,
                **({"values": axis.values.tolist()} if axis.spacing == "list" else {}),
            }
            for axis in self.axes.values()
        }
        scene = {QUANTITIES[name].column: value for name, value in self.fixed.items()}
        if self.length is not None:
            scene[QUANTITIES["trough_length"].column] = self.length
        return {"scene": scene, "axes": axes}


def scene_of(values: Mapping[str, Floats]) -> Scene:
    """Make the scenes of a box of cells, of which some combinations may be infeasible."""
    return Scene.allowing_infeasible(**scene_fields(values))
