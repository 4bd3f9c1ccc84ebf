"""The cycles that coexist on one trough, and what the search for them covered."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, overload

from vibro.errors import cut
from vibro.html_tables import amount
from vibro.quantities import LENGTH, SPEED

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["Attractor", "Attractors"]


@dataclass(frozen=True, kw_only=True)
class Attractor:
    """A steady cycle in which bodies settle, and a start from which ``simulate`` follows it.

    Attributes
    ----------
    start_phase : float
        Phase of the trough at the start [rad].
    start_velocity, start_normal_velocity : float
        Velocity relative to the trough there, along it and off it [m/s].
    period_cycles : int
        Drive cycles until the motion repeats.
    displacement_per_cycle : float
        Displacement relative to the trough in a drive cycle [m].
    mean_velocity : float
        Mean conveying speed [m/s].
    pattern : str
        Phases of a cycle, as in ``SteadyCycle``: F forward slide, B back slide, _ rest, H flight.
    largest_multiplier : float
        Modulus of the largest Floquet multiplier: a disturbance shrinks by it in a period [1]. NaN without
        kinetic friction, where bodies that stop do so at an instant, unless it is 1.
    from_rest : bool
        Whether a body settles there that starts from rest at trough phase 0.
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
        """Whether small disturbances die out; where nothing acts on the body they stay, and it is not."""
        return self.largest_multiplier < 1.0


@dataclass(frozen=True, eq=False, repr=False)
class Attractors(Sequence[Attractor]):
    """Cycles that coexist on one trough, that of a body from rest first; made by ``vibro.attractors``.

    Attributes
    ----------
    cycles : tuple of Attractor
        Those that were found.
    starts : int
        Starts of bodies that were followed, that from rest included.
    unsettled : int
        Those of them that led to no cycle: their motion is irregular, or takes longer to repeat.
    runs_away : bool
        Whether a body that is pushed hard enough down the trough never stops.
    complete : bool
        Whether no other cycles exist: in contact under a drive of one harmonic, with kinetic friction, no
        restitution. Else others may have been missed: those that attract few starts or take long to repeat,
        and where K <= 1 those of bodies that bounce, which are not looked for.
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
        """Return a cycle, or some of them."""
        return self.cycles[index]

    @property
    def covered(self) -> str:
        """What the search covered, in a sentence."""
        if self.complete:
            told = "all cycles are known"
        elif self.starts == 1:
            told = "cycles in contact, not surely all; bodies that bounce on were not looked for"
        else:
            told = f"{self.starts} start{'s' * (self.starts > 1)} followed, {self.unsettled} led to no cycle"
            told += "; cycles that attract none of them are missing"
        return told + ("; a body pushed down the trough may never stop" if self.runs_away else "")

    def __repr__(self) -> str:
        """Return a table of the cycles, and what the search covered."""
        head = ("pattern", "period", "mm a cycle", "mm/s", "multiplier", "")
        rows = [
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
        widths = [max(map(len, column)) for column in zip(head, *rows, strict=True)]
        lines = ["  ".join(x.ljust(w) for x, w in zip(row, widths, strict=True)) for row in (head, *rows)]
        return "\n".join([line.rstrip() for line in lines] + [f"<{self.covered}>"])

    def _repr_html_(self) -> str:
        """Return the cycles as a table for notebooks."""
        from vibro.html_tables import html_table

        rows = [
            (cut(one.pattern, 40), f"{amount(SPEED.from_si(one.mean_velocity), SPEED.unit)}, multiplier "
             f"{one.largest_multiplier:.4g}{', from rest' * one.from_rest}")
            for one in self
        ]  # fmt: skip
        return html_table(f"{len(self)} attractors", [*rows, ("search", self.covered)])

    def to_frame(self) -> pd.DataFrame:
        """Return the cycles as a data frame in SI units, one row each."""
        import pandas as pd

        names = [field.name for field in fields(Attractor)]
        return pd.DataFrame([[getattr(one, name) for name in names] for one in self], columns=names)
