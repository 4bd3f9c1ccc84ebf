"""Numbers of a sweep's cells by status and by regime, and the fastest of them."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Self, TypeVar

import numpy as np

from vibro.core.codes import Regime, Status
from vibro.quantities import QUANTITIES
from vibro.results.sweep import Peak, peaks

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from numpy.typing import NDArray

    from vibro.results.sweep import Block

_Code = TypeVar("_Code", Status, Regime)
_NO_REGIME = "none"
_SPEED, _ERROR = "mean_velocity_mm_s", "mean_velocity_error_mm_s"


@dataclass
class Tally:
    """Cells by status and by regime, and the fastest forwards and backwards, as ``peaks`` names them."""

    status: Counter[Status] = field(default_factory=Counter)
    regime: Counter[Regime] = field(default_factory=Counter)
    peaks: dict[str, Peak] = field(default_factory=dict)

    @classmethod
    def read(cls, record: Mapping[str, Any]) -> Self:
        """Make a tally from the mapping that ``record`` returns."""
        return cls(
            Counter({code: record["status"].get(code.label, 0) for code in Status}),
            Counter({code: record["regime"].get(code.label or _NO_REGIME, 0) for code in Regime}),
            {name: _read_peak(cell) for name, cell in record.get("peaks", {}).items()},
        )

    def add(self, block: Block) -> None:
        """Count the cells of a block."""
        self.status.update(_counted(block.cycle.status, Status))
        self.regime.update(_counted(block.cycle.regime, Regime))
        self._include(peaks(block.cycle.mean_velocity, block.cycle.mean_velocity_error, block.values))

    def include(self, others: Iterable[Tally]) -> None:
        """Add the counts of another tally."""
        for other in others:
            self.status.update(other.status)
            self.regime.update(other.regime)
            self._include(other.peaks)

    def _include(self, others: Mapping[str, Peak]) -> None:
        """Keep the faster peaks; of equally fast ones the first, in any order of blocks."""
        for name, peak in others.items():
            self.peaks[name] = max(self.peaks.get(name, peak), peak, key=_order)

    @property
    def at_rest(self) -> bool:
        """Whether every body rests, or is infeasible."""
        return self.status.total() == self.regime[Regime.NO_SLIP] + self.status[Status.INFEASIBLE]

    def record(self) -> dict[str, Any]:
        """Return the counts that are not 0, by label, and the peaks, by column."""
        return {
            "status": {code.label: self.status[code] for code in Status if self.status[code]},
            "regime": {code.label or _NO_REGIME: self.regime[code] for code in Regime if self.regime[code]},
            "peaks": {name: _peak_record(peak) for name, peak in self.peaks.items()},
        }


def _order(peak: Peak) -> tuple[float, list[float]]:
    return abs(peak.speed), [-value for value in peak.values.values()]


def _peak_record(peak: Peak) -> dict[str, float]:
    # a crank has no natural frequency
    here = {QUANTITIES[name].column: value for name, value in peak.values.items() if math.isfinite(value)}
    return {_SPEED: peak.speed, _ERROR: peak.error, **here}


def _read_peak(record: Mapping[str, float]) -> Peak:
    values = {name: record[q.column] for name, q in QUANTITIES.items() if q.column in record}
    return Peak(record[_SPEED], record[_ERROR], values)


def _counted(codes: NDArray[np.int8], kind: Callable[[int], _Code]) -> dict[_Code, int]:
    numbers = np.bincount(codes.reshape(-1) + 1).tolist()  # from -1 on; to sort them would take longer
    return {kind(code): number for code, number in enumerate(numbers, start=-1) if number}
