"""How much of a sweep reaches the speed that ``--speed`` asks for, and, of a map of both frictions, which."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.answers.answer import number
from vibro.cli.sweeps import count, peak_text
from vibro.core.codes import Status
from vibro.quantities import LENGTH, QUANTITIES

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from vibro.axes import Axis
    from vibro.results.sweep import Block, Peak

_FRICTIONS: Final = ({"static_friction", "friction_ratio"}, {"static_friction", "kinetic_friction"})


@dataclass(eq=False)
class TargetSpeed:
    """Cells of a sweep that are at least so fast.

    Attributes
    ----------
    axes : mapping of str to Axis
        Of the sweep.
    speed : float
        [mm/s].
    """

    axes: Mapping[str, Axis]
    speed: float
    _irregular: int = 0
    _fast: list[NDArray[np.bool_]] = field(default_factory=list)
    _possible: list[NDArray[np.bool_]] = field(default_factory=list)

    def add(self, block: Block) -> None:
        """Look at the next cells."""
        cycle = block.cycle
        fast = np.nan_to_num(LENGTH.from_si(cycle.mean_velocity).ravel(), nan=-np.inf) >= self.speed
        status = cycle.status.ravel()
        self._irregular += int((fast & (status == Status.AVERAGED)).sum())
        self._fast.append(fast)
        self._possible.append(status != Status.INFEASIBLE)

    def text(self, fastest: Peak | None) -> str:
        """Say how many cells are fast enough, or how fast the fastest is; of frictions, within which."""
        fast, possible = (sum(int(x.sum()) for x in cells) for cells in (self._fast, self._possible))
        said = f"at least {number(self.speed, 'mm/s')}: {count(fast)} of {count(possible)} possible cells"
        if not fast:
            return f"{said}; " + (
                f"the fastest: {peak_text(fastest, self.axes)}" if fastest else "none moves forwards"
            )
        said += f" ({100.0 * fast / possible:.1f} %)"
        if self._irregular:
            said += f", {count(self._irregular)} of them by the mean of irregular motion"
        return said + (f"; {self._frictions()}" if self.axes.keys() in _FRICTIONS else "")

    def _frictions(self) -> str:
        shape = [len(axis) for axis in self.axes.values()]
        fast, possible = (np.concatenate(x).reshape(shape) for x in (self._fast, self._possible))
        inside = [np.flatnonzero(fast.any(axis=across)) for across in (1, 0)]
        ranges = []
        for axis, cells in zip(self.axes.values(), inside, strict=True):
            low, high = float(axis.values[cells[0]]), float(axis.values[cells[-1]])
            ranges.append(f"{QUANTITIES[axis.name].label} {number(low)} ... {number(high)}")
        box: Any = np.ix_(*(np.arange(cells[0], cells[-1] + 1) for cells in inside))
        whole = fast[box].sum() == possible[box].sum()
        which = "all" if whole else f"{100.0 * fast[box].sum() / possible[box].sum():.1f} %"
        return f"they lie within {' and '.join(ranges)}, where {which} of the possible cells reach it"
