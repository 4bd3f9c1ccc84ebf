"""The cycles that coexist on one trough, and what the search for them covered."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Final, overload

from vibro.errors import cut
from vibro.html_tables import Shown
from vibro.units import LENGTH, SPEED

if TYPE_CHECKING:
    import pandas as pd

_HEAD: Final = ("pattern", "period", "mm a cycle", "mm/s", "multiplier", "")


@dataclass(frozen=True, kw_only=True)
class Attractor:
    """A steady cycle in which bodies settle, and initial values with which ``simulate`` reproduces it.

    Attributes
    ----------
    start_phase : float
        Phase of the trough at the start [rad].
    start_velocity, start_normal_velocity : float
        Velocity of the body relative to the trough at the start, along it and normal to it [m/s].
    period_cycles : int
        Drive cycles until the motion repeats.
    displacement_per_cycle : float
        Displacement relative to the trough in a drive cycle [m].
    mean_velocity : float
        Mean conveying speed [m/s].
    pattern : str
        Phases of a cycle, as in ``SteadyCycle``: F forward slide, B back slide, _ rest, H flight.
    largest_multiplier : float
        Modulus of the largest Floquet multiplier, the factor by which a small disturbance changes in a period
        [1]. Without kinetic friction it is 1, or NaN where the multiplier is not defined.
    from_rest : bool
        Whether a body that starts from rest at trough phase 0 settles in this cycle.
    """

    start_phase: float
    start_velocity: float
    start_normal_velocity: float
    period_cycles: int
    displacement_per_cycle: float
    mean_velocity: float
    pattern: str
    largest_multiplier: float
    from_rest: bool

    @property
    def stable(self) -> bool:
        """Whether small disturbances die out: the largest multiplier is below 1."""
        return self.largest_multiplier < 1.0


@dataclass(frozen=True, eq=False, repr=False)
class Attractors(Shown, Sequence[Attractor]):
    """Cycles that coexist on one trough, that of a body from rest first; returned by ``vibro.attractors``.

    Attributes
    ----------
    cycles : tuple of Attractor
        The cycles that were found.
    starts : int
        Number of starts that were simulated, that from rest included.
    unsettled : int
        Number of these starts that led to no cycle: their motion is irregular, or has a long period.
    runs_away : bool
        Whether a body that is pushed hard enough down the trough never stops.
    complete : bool
        Whether all cycles are known. This holds in contact, under a drive of one harmonic, with kinetic
        friction and without restitution. In other cases cycles may be missing: those that attract few starts
        or have long periods, and for throw numbers K <= 1 those of bouncing bodies, which are not searched.
    """

    cycles: tuple[Attractor, ...]
    starts: int
    unsettled: int
    runs_away: bool
    complete: bool

    def __len__(self) -> int:
        return len(self.cycles)

    @overload
    def __getitem__(self, index: int) -> Attractor: ...

    @overload
    def __getitem__(self, index: slice) -> Sequence[Attractor]: ...

    def __getitem__(self, index: int | slice) -> Attractor | Sequence[Attractor]:
        """Return one cycle, or a slice of them."""
        return self.cycles[index]

    @property
    def covered(self) -> str:
        """One sentence that says how complete the search was."""
        if self.complete:
            text = "all cycles are known"
        elif self.starts == 1:
            text = "cycles in contact, perhaps not all; bouncing bodies were not searched"
        else:
            text = f"{self.starts} start{'s' * (self.starts > 1)} followed, {self.unsettled} led to no cycle"
            text += "; cycles that attract none of these starts are missing"
        return text + ("; a body pushed down the trough may never stop" if self.runs_away else "")

    def __repr__(self) -> str:
        """Return a table of the cycles, and what the search covered."""
        rows = [_HEAD, *self._rows()]
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        lines = ["  ".join(map(str.ljust, row, widths)).rstrip() for row in rows]
        return "\n".join([*lines, f"<{self.covered}>"])

    def _table(self) -> tuple[str, list[tuple[str, ...]], tuple[str, ...]]:
        return f"{len(self)} attractors", [*self._rows(), ("search", self.covered)], _HEAD

    def _rows(self) -> list[tuple[str, ...]]:
        return [
            (
                cut(one.pattern, 40),
                str(one.period_cycles),
                f"{LENGTH.from_si(one.displacement_per_cycle):.6g}",
                f"{SPEED.from_si(one.mean_velocity):.6g}",
                f"{one.largest_multiplier:.4g}",
                "from rest" if one.from_rest else "",
            )
            for one in self
        ]

    def to_frame(self) -> pd.DataFrame:
        """Return the cycles as a data frame in SI units, one row each."""
        import pandas as pd

        names = [field.name for field in fields(Attractor)]
        return pd.DataFrame([[getattr(one, name) for name in names] for one in self], columns=names)
