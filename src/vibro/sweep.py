"""Sweeps: axes to blocks of scenes to results."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping

    from vibro.axes import Axis
    from vibro.core.limits import CriticalLoads
    from vibro.steady import SteadyCycle

__all__ = ["SweepResult"]


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
