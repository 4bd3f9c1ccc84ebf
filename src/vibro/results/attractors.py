"""The motions in which bodies settle, and how many of their starts lead to each."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Final, overload

from vibro.core.codes import Regime
from vibro.errors import cut
from vibro.html_tables import Shown
from vibro.units import LENGTH, SPEED

if TYPE_CHECKING:
    import pandas as pd

_HEAD: Final = ("share of starts", "mm/s", "pattern", "period", "mm a cycle", "multiplier", "")
_Z: Final = 1.959963984540054  # [1] of a normal distribution, for 95 %


def share_interval(count: int, starts: int) -> tuple[float, float]:
    """Return the 95 % interval of a share of which ``count`` of ``starts`` were seen, after Wilson (1927).

    It is never of zero width: of a motion that no start, or every one, leads to the other end is
    z^2/(n + z^2) away, z = 1.96.
    """
    share, weight = count / starts, _Z * _Z / starts
    middle = share + 0.5 * weight
    half = _Z * math.sqrt(share * (1.0 - share) / starts + 0.25 * weight / starts)
    # the ends are exact where no start, or every one, was seen
    low = 0.0 if count == 0 else (middle - half) / (1.0 + weight)
    return low, 1.0 if count == starts else (middle + half) / (1.0 + weight)


@dataclass(frozen=True, kw_only=True)
class Attractor:
    """A motion in which bodies settle, and initial values with which ``simulate`` reproduces it.

    Attributes
    ----------
    share : float
        Share of the starts that lead to it [1].
    share_low, share_high : float
        95 % interval of that share, after Wilson, as if the starts were drawn at random [1].
    mean_velocity : float
        Mean conveying speed [m/s].
    regime : Regime
        Class of the motion.
    period_cycles : int
        Drive cycles until the motion repeats.
    displacement_per_cycle : float
        Displacement relative to the trough in a drive cycle [m].
    peak_velocity : float
        Largest relative speed along the trough, either way [m/s].
    pattern : str
        Phases of a cycle, as in ``SteadyCycle``: F forward slide, B back slide, _ rest, H flight.
    largest_multiplier : float
        Modulus of the largest Floquet multiplier, the factor by which a small disturbance changes in a period
        [1]. Without kinetic friction it is 1, or NaN where the multiplier is not defined.
    from_rest : bool
        Whether a body that starts from rest at trough phase 0 settles in it.
    start_phase : float
        Phase of the trough at the start [rad].
    start_velocity, start_normal_velocity : float
        Velocity of the body relative to the trough at the start, along it and normal to it [m/s].
    """

    share: float
    share_low: float
    share_high: float
    mean_velocity: float
    regime: Regime
    period_cycles: int
    displacement_per_cycle: float
    peak_velocity: float
    pattern: str
    largest_multiplier: float
    from_rest: bool
    start_phase: float
    start_velocity: float
    start_normal_velocity: float

    @property
    def stable(self) -> bool:
        """Whether small disturbances die out: the largest multiplier is below 1."""
        return self.largest_multiplier < 1.0


@dataclass(frozen=True, eq=False, repr=False)
class Attractors(Shown, Sequence[Attractor]):
    """Motions in which bodies from many starts settle; returned by ``vibro.attractors``.

    The motion of a body from rest at trough phase 0 comes first, if it repeats; the others by their shares.

    Attributes
    ----------
    motions : tuple of Attractor
        The motions that repeat.
    starts : int
        Number of bodies.
    drops : float
        Height from which they were dropped; 0 if they were laid down [m].
    irregular_share : float
        Share of the starts whose motion did not repeat within 1024 flights [1].
    irregular_velocity, irregular_velocity_error : float
        Mean speed of these over the second half of their flights, and its standard error; NaN without [m/s].
    mean_velocity : float
        Mean speed over all starts; NaN if any is lost [m/s].
    lost : int
        Number of starts that run away or were not solved.
    runs_away : bool
        Whether a body that is pushed hard enough down the trough never stops.
    complete : bool
        Whether all motions are known, whatever their shares. This holds in contact, under a drive of one
        harmonic, with kinetic friction and without restitution.
    """

    motions: tuple[Attractor, ...]
    starts: int
    drops: float
    irregular_share: float
    irregular_velocity: float
    irregular_velocity_error: float
    mean_velocity: float
    lost: int
    runs_away: bool
    complete: bool

    def __len__(self) -> int:
        return len(self.motions)

    @overload
    def __getitem__(self, index: int) -> Attractor: ...

    @overload
    def __getitem__(self, index: slice) -> Sequence[Attractor]: ...

    def __getitem__(self, index: int | slice) -> Attractor | Sequence[Attractor]:
        """Return one motion, or a slice of them."""
        return self.motions[index]

    @property
    def missed(self) -> float:
        """Share below which a motion may be missed: the 95 % limit of one that no start led to [1]."""
        return share_interval(0, self.starts)[1]

    @property
    def covered(self) -> str:
        """One sentence that says what the starts can tell."""
        how = f"dropped from {LENGTH.from_si(self.drops):.6g} mm" if self.drops else "laid down at rest"
        text = f"{self.starts} bodies {how} at evenly spread phases"
        if self.irregular_share:
            speed, error = map(SPEED.from_si, (self.irregular_velocity, self.irregular_velocity_error))
            text += f"; a share of {self.irregular_share:.3g} does not repeat: {speed:.4g} ± {error:.2g} mm/s"
        text += f"; {self.lost} run away or were not solved" if self.lost else ""
        if self.complete:
            text += "; all motions are known"
        else:
            text += f"; no random sample: motions of less than {self.missed:.2g} of all starts may be missing"
        return text + ("; a body pushed down the trough may never stop" if self.runs_away else "")

    def __repr__(self) -> str:
        """Return a table of the motions, and what the starts can tell."""
        rows = [_HEAD, *self._rows()]
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        lines = ["  ".join(map(str.ljust, row, widths)).rstrip() for row in rows]
        return "\n".join([*lines, f"<{self.covered}>"])

    def _table(self) -> tuple[str, list[tuple[str, ...]], tuple[str, ...]]:
        return f"{len(self)} motions", [*self._rows(), ("starts", self.covered)], _HEAD

    def _rows(self) -> list[tuple[str, ...]]:
        return [
            (
                f"{one.share:.3f} ({one.share_low:.3f} to {one.share_high:.3f})",
                f"{SPEED.from_si(one.mean_velocity):.6g}",
                cut(one.pattern, 40),
                str(one.period_cycles),
                f"{LENGTH.from_si(one.displacement_per_cycle):.6g}",
                f"{one.largest_multiplier:.4g}",
                "from rest" if one.from_rest else "",
            )
            for one in self
        ]

    def to_frame(self) -> pd.DataFrame:
        """Return the motions as a data frame in SI units, one row each."""
        import pandas as pd

        names = [field.name for field in fields(Attractor)]
        return pd.DataFrame([[getattr(one, name) for name in names] for one in self], columns=names)
