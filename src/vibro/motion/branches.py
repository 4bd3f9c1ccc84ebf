"""A branch of cycles: one cycle along a quantity, stable or not, and what happens to it on the way."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np

from vibro.errors import InputError
from vibro.quantities import QUANTITIES

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

__all__ = ["Branch", "BranchEvent"]

_PICTURES: Final = {
    "landing": "landing speed [mm/s]",
    "phase": "phase of the take-off [\N{DEGREE SIGN}]",
    "speed": "mean conveying speed [mm/s]",
}


@dataclass(frozen=True, kw_only=True)
class BranchEvent:
    """A bifurcation on a branch, or an end of the branch.

    Attributes
    ----------
    kind : str
        What happens:

        * ``fold``: the branch turns back; two cycles meet and vanish.
        * ``doubling``: a cycle of twice the period branches off; a branch of the doubled cycle ends here.
        * ``contact``: the branch ends, because a landing leads to a phase in contact.
        * ``grazing``: the branch ends, because a flight touches the trough earlier.
        * ``hop_limit``: the branch reached throw number 1, below which the trough throws no body.
        * ``end``: the branch leaves the range of values.
        * ``cut``: the search stopped, at its limit of steps or because a step failed; the cycle may go on.
    value : float
        Value of the quantity, in SI units.
    row : int
        Row of the branch, from 0.
    """

    kind: Literal["fold", "doubling", "contact", "grazing", "hop_limit", "end", "cut"]
    value: float
    row: int


@dataclass(frozen=True, kw_only=True, eq=False)
class Branch:
    """A cycle of flights as one quantity varies, in the order of the branch; returned by ``vibro.follow``.

    Attributes
    ----------
    name : str
        Name of the quantity that varies.
    values : array, shape (n,)
        Its values, in SI units; their direction reverses at folds.
    start_phase, start_velocity, start_normal_velocity : array, shape (n,)
        Initial values with which ``vibro.simulate`` reproduces the cycle, as in ``Attractor`` [rad, m/s].
    landing_speeds : array, shape (n, flights)
        Normal speed of each landing [m/s].
    displacement_per_cycle, mean_velocity : array, shape (n,)
        Displacement along the trough in a drive cycle [m] and mean conveying speed [m/s]; NaN where the
        motion along the trough does not become periodic.
    normal_multipliers : complex array, shape (n, 2)
        Floquet multipliers of the normal motion over a period [1].
    largest_multiplier : array, shape (n,)
        Largest modulus of all Floquet multipliers, those of the motion along the trough included; NaN where
        that motion does not become periodic [1].
    period_cycles : int
        Drive cycles until the motion repeats.
    events : tuple of BranchEvent
        Bifurcations and ends, in the order of the branch.
    """

    name: str
    values: Floats
    start_phase: Floats
    start_velocity: Floats
    start_normal_velocity: Floats
    landing_speeds: Floats
    displacement_per_cycle: Floats
    mean_velocity: Floats
    normal_multipliers: NDArray[np.complex128]
    largest_multiplier: Floats
    period_cycles: int
    events: tuple[BranchEvent, ...]

    @property
    def stable(self) -> NDArray[np.bool_]:
        """Whether small disturbances die out, shape (n,); False at a fold or a doubling."""
        found = self.largest_multiplier < 1.0
        found[[one.row for one in self.events if one.kind in ("fold", "doubling")]] = False
        return found

    def __len__(self) -> int:
        return self.values.size

    def __repr__(self) -> str:
        """Return a summary."""
        quantity = QUANTITIES[self.name]
        at = [f"{one.kind} at {quantity.from_si(one.value):.10g} {quantity.unit}" for one in self.events]
        told = ", ".join(text.rstrip() for text in at)
        return f"<cycle of {self._told}: {told}>"

    @property
    def _told(self) -> str:
        flights, turns = self.landing_speeds.shape[1], self.period_cycles
        return f"{flights} flight{'s' * (flights > 1)} in {turns} turn{'s' * (turns > 1)}"

    def to_frame(self) -> pd.DataFrame:
        """Return the branch as a data frame in SI units.

        Returns
        -------
        pandas.DataFrame
            One row per cycle; the column ``event`` holds the kind of an event there, or an empty text.
        """
        import pandas as pd

        events = [""] * len(self)
        for one in self.events:
            events[one.row] = one.kind
        columns: dict[str, Any] = {
            self.name: self.values,
            "start_phase": self.start_phase,
            "start_velocity": self.start_velocity,
            "start_normal_velocity": self.start_normal_velocity,
            "largest_landing_speed": self.landing_speeds.max(axis=1),
            "displacement_per_cycle": self.displacement_per_cycle,
            "mean_velocity": self.mean_velocity,
            "largest_multiplier": self.largest_multiplier,
            "stable": self.stable,
            "event": events,
        }
        return pd.DataFrame(columns)

    def draw(self, picture: Literal["landing", "phase", "speed"] = "landing") -> Figure:
        """Draw the bifurcation diagram.

        Parameters
        ----------
        picture : {"landing", "phase", "speed"}
            What to plot over the quantity: the normal speed of every landing, the phase of the first
            take-off, or the mean conveying speed. For a cycle of one bounce choose the phase, which shows
            the fold: the landing speed is the same on both sides of it.

        Returns
        -------
        matplotlib.figure.Figure
            Stable cycles solid, unstable ones dashed, events marked; ``figure.savefig(path)`` writes it.

        Raises
        ------
        InputError
            If ``picture`` is none of these.
        """
        from vibro.plots.branch import branch_figure

        if picture not in _PICTURES:
            raise InputError(
                f"there is no picture {picture!r} of a branch", hint=f"draw {', '.join(_PICTURES)}"
            )
        curves = {
            "landing": 1e3 * self.landing_speeds,
            "phase": np.degrees(np.unwrap(self.start_phase))[:, None],
            "speed": 1e3 * self.mean_velocity[:, None],
        }
        return branch_figure(
            f"Branch of a cycle of {self._told}",
            self.name,
            QUANTITIES[self.name].from_si(self.values),
            curves[picture],
            _PICTURES[picture],
            self.stable,
            [(one.kind, one.row) for one in self.events],
        )
