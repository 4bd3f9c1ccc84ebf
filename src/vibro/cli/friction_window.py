"""Which frictions keep a speed, of the cells of a map of both."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

import numpy as np

from vibro.cli.answer import count
from vibro.core.codes import Status
from vibro.quantities import LENGTH, QUANTITIES
from vibro.sweeps.one_scene import number

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from vibro.axes import Axis
    from vibro.results.steady import SteadyCycle

__all__ = ["FrictionWindow", "friction_window"]

_SECOND: Final = ("friction_ratio", "kinetic_friction")


def friction_window(axes: Mapping[str, Axis], speed: float) -> FrictionWindow | None:
    """Return what looks for frictions that keep a speed [mm/s], where both are the axes; else nothing."""
    static, *others = axes.values()
    if static.name != "static_friction" or len(others) != 1 or others[0].name not in _SECOND:
        return None
    return FrictionWindow((static, others[0]), speed)


@dataclass(frozen=True, eq=False)
class FrictionWindow:
    """Cells of a map of static and kinetic friction, or its ratio, that are at least so fast.

    Attributes
    ----------
    axes : pair of Axis
        Of the map.
    speed : float
        [mm/s].
    """

    axes: tuple[Axis, Axis]
    speed: float
    _fast: list[NDArray[np.bool_]] = field(default_factory=list)
    _possible: list[NDArray[np.bool_]] = field(default_factory=list)

    def add(self, cycle: SteadyCycle) -> None:
        """Look at the next cells."""
        speeds = LENGTH.from_si(cycle.mean_velocity).ravel()
        self._fast.append(np.nan_to_num(speeds, nan=-np.inf) >= self.speed)
        self._possible.append(cycle.status.ravel() != Status.INFEASIBLE)

    def text(self) -> str:
        """Say how many cells are fast enough, within which frictions, and whether all within these are."""
        shape = [len(axis) for axis in self.axes]
        fast, possible = (np.concatenate(x).reshape(shape) for x in (self._fast, self._possible))
        share = f"{count(int(fast.sum()))} of {count(int(possible.sum()))} possible cells"
        said = f"at least {number(self.speed, 'mm/s')}: {share}"
        if not fast.any():
            return said
        inside = [np.flatnonzero(fast.any(axis=across)) for across in (1, 0)]
        ranges = []
        for axis, cells in zip(self.axes, inside, strict=True):
            low, high = float(axis.values[cells[0]]), float(axis.values[cells[-1]])
            ranges.append(f"{QUANTITIES[axis.name].label} {number(low)} ... {number(high)}")
        box = np.ix_(*(np.arange(cells[0], cells[-1] + 1) for cells in inside))
        whole = fast[box].sum() == possible[box].sum()
        which = "all" if whole else f"{100.0 * fast[box].sum() / possible[box].sum():.1f} %"
        return f"{said}; they lie within {' and '.join(ranges)}, where {which} of the possible cells do it"
