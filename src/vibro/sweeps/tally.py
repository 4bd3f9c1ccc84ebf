"""Numbers of a sweep's cells by status and by regime."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Self, TypeVar

import numpy as np

from vibro.core.codes import Regime, Status

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from numpy.typing import NDArray

    from vibro.results.sweep import Block

__all__ = ["Tally"]

_Code = TypeVar("_Code", Status, Regime)
_NO_REGIME = "none"


@dataclass
class Tally:
    """Cells by status and by regime."""

    status: Counter[Status] = field(default_factory=Counter)
    regime: Counter[Regime] = field(default_factory=Counter)

    @classmethod
    def read(cls, told: Mapping[str, Mapping[str, int]]) -> Self:
        """Make one of what ``told`` returns."""
        return cls(
            Counter({code: told["status"].get(code.label, 0) for code in Status}),
            Counter({code: told["regime"].get(code.label or _NO_REGIME, 0) for code in Regime}),
        )

    def add(self, block: Block) -> None:
        """Count the cells of a block."""
        self.status.update(_counted(block.cycle.status, Status))
        self.regime.update(_counted(block.cycle.regime, Regime))

    def include(self, others: Iterable[Tally]) -> None:
        """Add the counts of another tally."""
        for other in others:
            self.status.update(other.status)
            self.regime.update(other.regime)

    @property
    def at_rest(self) -> bool:
        """Whether every body rests, or is infeasible."""
        return self.status.total() == self.regime[Regime.NO_SLIP] + self.status[Status.INFEASIBLE]

    def told(self) -> dict[str, Any]:
        """Return the counts that are not 0, by label."""
        return {
            "status": {code.label: self.status[code] for code in Status if self.status[code]},
            "regime": {code.label or _NO_REGIME: self.regime[code] for code in Regime if self.regime[code]},
        }


def _counted(codes: NDArray[np.int8], kind: Callable[[int], _Code]) -> dict[_Code, int]:
    numbers = np.bincount(codes.reshape(-1) + 1).tolist()  # from -1 on; to sort them would take longer
    return {kind(code): number for code, number in enumerate(numbers, start=-1) if number}
