"""How much of a sweep reaches the speed that ``--speed`` asks for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from vibro.answers.answer import number
from vibro.cli.sweeps import count, peak_text
from vibro.core.codes import Status
from vibro.units import LENGTH

if TYPE_CHECKING:
    from collections.abc import Mapping

    from vibro.axes import Axis
    from vibro.results.sweep import Block, Peak


@dataclass
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
    _fast: int = 0
    _irregular: int = 0
    _possible: int = 0

    def add(self, block: Block) -> None:
        """Count the next cells."""
        status = block.cycle.status
        fast = np.nan_to_num(LENGTH.from_si(block.cycle.mean_velocity), nan=-np.inf) >= self.speed
        self._fast += int(fast.sum())
        self._irregular += int((fast & (status == Status.AVERAGED)).sum())
        self._possible += int((status != Status.INFEASIBLE).sum())

    def text(self, fastest: Peak | None) -> str:
        """Say how many cells are fast enough, or how fast the fastest is."""
        of_all = f"{count(self._fast)} of {count(self._possible)} possible cells"
        text = f"at least {number(self.speed, 'mm/s')}: {of_all}"
        if not self._fast:
            place = f"the fastest: {peak_text(fastest, self.axes)}" if fastest else "none moves forwards"
            return f"{text}; {place}"
        text += f" ({100.0 * self._fast / self._possible:.1f} %)"
        irregular = f", {count(self._irregular)} of them by the mean of irregular motion"
        return text + irregular * bool(self._irregular)
