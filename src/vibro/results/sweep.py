"""Solved sweeps: a block of cells as tables need it, and a grid as pictures need it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from vibro.core.codes import Regime, Status
from vibro.quantities import QUANTITIES

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from numpy.typing import NDArray

    from vibro.axes import Axis
    from vibro.core.contact.limits import CriticalLoads
    from vibro.results.steady import SteadyCycle

    Floats = NDArray[np.float64]

__all__ = ["Block", "Column", "SweepResult", "at_rest", "where_motion_begins"]


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

    @property
    def rest_text(self) -> str:
        """Where motion begins, if every body rests; else empty."""
        rests = np.all(at_rest(self.cycle))
        return where_motion_begins(self.axes, self.fixed, self.limits) if rests else ""


def at_rest(cycle: SteadyCycle) -> NDArray[np.bool_]:
    """Whether each body rests, or cannot be."""
    return np.asarray((cycle.regime == Regime.NO_SLIP) | (cycle.status == Status.INFEASIBLE))


def where_motion_begins(axes: Mapping[str, Axis], fixed: Mapping[str, float], limits: CriticalLoads) -> str:
    """Say at which amplitude and frequency the first body of a sweep begins to move.

    Parameters
    ----------
    axes, fixed, limits
        As in ``SweepResult``.

    Returns
    -------
    str
        The amplitude at the highest frequency, and the frequency at the largest amplitude, of the body with
        the least critical load.
    """
    loads = (limits.forward_onset, limits.back_onset, limits.hop)
    least = min(float(np.fmin.reduce(np.ravel(load), initial=math.inf)) for load in loads)
    if not math.isfinite(least):
        return "at rest everywhere"
    amplitude, frequency = (
        float(axes[name].values[-1]) if name in axes else fixed[name] for name in ("amplitude", "frequency")
    )
    length = QUANTITIES["amplitude"]
    acceleration = least * fixed["gravity"]
    enough = length.from_si(acceleration / (2.0 * math.pi * frequency) ** 2)
    fast = math.sqrt(acceleration / length.to_si(amplitude)) / (2.0 * math.pi)
    return (
        f"at rest everywhere: motion begins at {enough:.4g} mm with {frequency:.4g} Hz,"
        f" or at {fast:.4g} Hz with {amplitude:.4g} mm"
    )
