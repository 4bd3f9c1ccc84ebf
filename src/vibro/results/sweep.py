"""Solved sweeps: a block of cells as tables need it, and a grid as pictures need it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from numpy.typing import NDArray

    from vibro.axes import Axis
    from vibro.core.contact.limits import CriticalLoads
    from vibro.results.steady import SteadyCycle

    Floats = NDArray[np.float64]

__all__ = ["Block", "Column", "SweepResult"]


@dataclass(frozen=True)
class Column:
    """One column of every table.

    Attributes
    ----------
    name : str
        Header, with the unit.
    unit : str
        Unit of the numbers; empty for pure numbers, flags and texts.
    values : callable
        From a ``Block`` to an array that broadcasts to its shape: floats, NaN or inf where there is no
        number; texts; or codes into ``texts``.
    texts : tuple of str, optional
        What the codes mean, the last one standing for -1; None for a column of numbers or texts.
    is_flag : bool
        Whether the codes are 0, 1 and, for unknown, -1: numbers where a format has them.
    """

    name: str
    unit: str
    values: Callable[[Block], NDArray[Any]]
    texts: tuple[str, ...] | None = None
    is_flag: bool = False


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
        or friction_ratio, trough_angle, restitution; values in the user's units. They are the dimensions of
        ``cycle``, in this order.
    fixed : mapping of str to float
        Every other quantity of the scene, by name, in the user's units, with gravity. It has
        kinetic_friction or, where that was given instead, friction_ratio.
    cycle : SteadyCycle
        Arrays of the grid's shape.
    limits : CriticalLoads
        Critical loads G of the grid's angles and frictions: arrays of the grid's shape, but of length 1 along
        amplitude, frequency and restitution.
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
