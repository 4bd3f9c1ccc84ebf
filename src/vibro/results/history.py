"""Time histories: what a body does from its first moment on, exact at any time, in SI units.

    history = vibro.simulate(scene, cycles=10)    # or duration= [s], or length= [m]: until arrival
    history.phases                                # tuple of Phase: kind F B _ H, start and end
    history.sample(times)                         # Sample: arrays of motion and forces at those times
    history.sample(times, side="left")            # the values just before, where a time is that of an event
    history.to_frame()                            # the phases as a data frame
    history.draw("history.png")                   # forces and motion over time, as a figure
    history.end, history.settles_at, history.pattern, history.cycle_displacement

Each phase has a closed form; no differential equation is integrated numerically. Once the motion repeats,
its cycle is stored once, with a count, so that 1e5 cycles take no more memory than the transient; ``phases``
lists all of them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final, Literal, NamedTuple

import numpy as np

from vibro.core.codes import LETTERS, PHASE_NAMES
from vibro.core.numbers import TURN, Sampled, Span
from vibro.drives import PiecewiseMotion
from vibro.errors import InputError, VibroError, cut, shown
from vibro.html_tables import Shown, amount
from vibro.reals import NotRealError, real_array, shielded
from vibro.results.drawing import drawn
from vibro.threads import doors
from vibro.units import LENGTH

if TYPE_CHECKING:
    from collections.abc import Sequence
    from os import PathLike

    import pandas as pd
    from matplotlib.figure import Figure
    from numpy.typing import ArrayLike, NDArray

    from vibro.reals import Floats
    from vibro.scene import Scene
    from vibro.threads import Grid


# ------------------------------------------------------------------------------
# Phases of a history in rows, in the units of tables.

_SHORT: Final = 0.1  # [drive cycles] a longer flight has a row of its own
_FEWEST: Final = 3  # bounces of a chain


def with_chains(phases: Sequence[Phase], period: float) -> list[tuple[str, Phase]]:
    """Sum up chains of bounces: flights within a tenth of a cycle, each landing slower than the one before.

    Parameters
    ----------
    phases : sequence of Phase
        One after the other.
    period : float
        Of the drive [s].

    Returns
    -------
    list of tuple of str and Phase
        What people call each row, and the phase; a chain of three bounces or more is one phase, from its
        start to its end, with the largest of its impact velocities.
    """
    rows: list[tuple[str, Phase]] = []
    chain: list[Phase] = []
    for phase in phases:
        bounces = phase.kind == "H" and phase.end - phase.start < _SHORT * period
        if chain and not (bounces and phase.impact_velocity < chain[-1].impact_velocity):
            rows += _summed(chain, dies=phase.kind != "H")
            chain = []
        if bounces:
            chain.append(phase)
        else:
            rows.append(_named(phase))
    return rows + _summed(chain, dies=False)


def _named(phase: Phase) -> tuple[str, Phase]:
    return PHASE_NAMES[phase.kind], phase


def _summed(chain: Sequence[Phase], *, dies: bool) -> list[tuple[str, Phase]]:
    """Return the one row of a chain, or the rows of one that is too short to be summed up."""
    if len(chain) < _FEWEST:
        return [_named(bounce) for bounce in chain]
    first, last = chain[0], chain[-1]
    whole = replace(
        first,
        end=last.end,
        end_position=last.end_position,
        end_velocity=last.end_velocity,
        impact_velocity=max(bounce.impact_velocity for bounce in chain),
    )
    return [(f"{len(chain)} bounces{', until they die out' if dies else ''}", whole)]


def phase_table(history: History, phases: Sequence[Phase]) -> dict[str, Floats | list[str]]:
    """Return the columns of a list of phases, one row a phase, by their names with units."""
    return {
        "phase": [PHASE_NAMES[p.kind] for p in phases],
        "start_s": np.array([p.start for p in phases]),
        "end_s": np.array([p.end for p in phases]),
        "trough_phase_at_start_deg": trough_phase(history, np.array([p.start for p in phases])),
        "start_position_mm": in_mm(np.array([p.start_position for p in phases])),
        "end_position_mm": in_mm(np.array([p.end_position for p in phases])),
        "start_velocity_mm_s": in_mm(np.array([p.start_velocity for p in phases])),
        "end_velocity_mm_s": in_mm(np.array([p.end_velocity for p in phases])),
        "impact_velocity_mm_s": in_mm(np.array([p.impact_velocity for p in phases])),
    }


def in_mm(values: Floats) -> Floats:
    """Convert from m, or m/s, to mm, or mm/s; without negative zeros."""
    return np.asarray(LENGTH.from_si(values)) + 0.0


def trough_phase(history: History, time: Floats) -> Floats:
    """Trough phase in [0, 360) [deg]."""
    turns = float(history.scene.frequency) * time + history.start_phase / (2.0 * math.pi)
    return np.asarray(360.0 * (turns - np.floor(turns)))


#: Phases of a history that do not repeat, and phases that are spelt out: half a gigabyte of them.
MOST_PHASES: Final = 2_000_000
_MOMENTS: Final = 16_384  # of a call, so that an interrupt is noticed within a fraction of a second

_OFF_JUMP: Final = 1e-9  # [rad] from a jump to the moment whose forces are those on one side of it
_SLACK: Final = 1e-12  # [1] share of the whole by which a time may lie outside, for rounding by the caller


class Legs(NamedTuple):
    """Legs of one body, one after the other: the fields of ``vibro.core.history.Legs`` as arrays."""

    mode: NDArray[np.int8]
    cycle: NDArray[np.int64]
    phase: Floats
    length: Floats
    position: Floats
    velocity: Floats
    displacement: Floats
    end_velocity: Floats
    rate: Floats
    impact: Floats

    @classmethod
    def of_size(cls, rows: int) -> Legs:
        """Make room for legs."""
        return cls(np.empty(rows, np.int8), np.empty(rows, np.int64), *np.empty((8, rows)))


class SolvedMotion(NamedTuple):
    """A whole motion.

    Attributes
    ----------
    legs : Legs
        The transient, then one steady cycle, which repeats.
    first : int
        The first leg of that cycle; the number of legs if it was not reached.
    period : int
        Drive cycles of the steady cycle, 0 without one.
    advance : float
        Displacement in it [A].
    """

    legs: Legs
    first: int
    period: int
    advance: float

    def span(self, frequency: float) -> Span:
        """Return what the solver takes of it, beside its legs, at a drive's frequency [Hz]."""
        return Span(self.first, self.legs.mode.size, self.period, self.advance, frequency)


@dataclass(frozen=True)
class Phase:
    """One phase of the motion.

    Attributes
    ----------
    kind : str
        ``"F"`` forward slide, ``"B"`` back slide, ``"_"`` rest, ``"H"`` flight.
    start, end : float
        Times at which it begins and ends [s]; the next phase begins at ``end``.
    start_position, end_position : float
        Displacement relative to the trough since time 0, positive in the conveying direction [m].
    start_velocity, end_velocity : float
        Velocity along the trough relative to it, just after the start and just before the end of the phase;
        exactly 0 where the body stops [m/s].
    impact_velocity : float
        Normal speed at which a flight ends on the trough, 0 for other phases [m/s].
    """

    kind: str
    start: float
    end: float
    start_position: float
    end_position: float
    start_velocity: float
    end_velocity: float
    impact_velocity: float


@dataclass(frozen=True, eq=False)
class Sample:
    """Motion and forces at given times; arrays of the times' shape, forces per unit mass.

    Attributes
    ----------
    time : array
        The times [s].
    trough_displacement : array
        Displacement of the trough along the drive's line; NaN for elliptical drives [m].
    trough_along, trough_normal : array
        Displacement of the trough along its surface, positive in the conveying direction, and normal to it,
        positive upwards [m].
    position, velocity, acceleration : array
        Motion of the body along the trough relative to it, positive in the conveying direction [m, m/s,
        m/s^2].
    inertial : array
        Tangential load on the body: inertia of the drive and the component of the weight [m/s^2].
    friction : array
        Friction force on the body; ``acceleration = inertial + friction`` [m/s^2].
    normal : array
        Normal force of the trough on the body, 0 in flight [m/s^2].
    static_limit : array
        Largest static friction force, in either direction: mu_s times ``normal`` [m/s^2].
    gap : array
        Height of the body above the trough, 0 in contact [m].
    """

    time: Floats
    trough_displacement: Floats
    trough_along: Floats
    trough_normal: Floats
    position: Floats
    velocity: Floats
    acceleration: Floats
    inertial: Floats
    friction: Floats
    normal: Floats
    static_limit: Floats
    gap: Floats


@dataclass(frozen=True, eq=False, repr=False)
class History(Shown):
    """The motion of one body on one trough, exact at any time; returned by ``vibro.simulate``.

    Attributes
    ----------
    scene : Scene
        The operating point.
    end : float
        Time at which the history ends; it begins at 0 [s].
    start_phase : float
        Phase of the trough at time 0 [rad].
    start_height : float
        Height of the body above the trough at time 0 [m].
    pattern : str
        Kinds of the phases that repeat, starting at any of them; empty if none repeat before the end, or if
        the body rests for ever.
    settles_at : float
        Time from which they repeat; inf if they do not before the end [s].
    period_cycles : int
        Drive cycles after which they repeat; 0 if they do not.
    cycle_displacement : float
        Displacement per drive cycle from then on; NaN if they do not repeat [m].
    """

    scene: Scene
    end: float
    start_phase: float
    start_height: float
    _motion: SolvedMotion
    _grid: Grid

    @shielded
    def __repr__(self) -> str:
        """Return a summary: ``<History of 0.667 s: 21 phases, of which F_ repeat>``."""
        repeats = f", of which {cut(self.pattern)} repeat" if self.pattern else ""
        return f"<History of {amount(self.end, 's')}: {self._count} phases{repeats}>"

    def _table(self) -> tuple[str, list[tuple[str, str]], tuple[()]]:
        period = self.period_cycles
        rows = [
            ("duration", amount(self.end, "s")),
            ("phases", str(self._count)),
            ("pattern", cut(self.pattern) or "none repeats"),
        ]
        if period:
            rows += [
                ("repeats from", amount(self.settles_at, "s")),
                ("period", f"{period} drive cycle{'s' * (period > 1)}"),
                ("displacement per cycle", amount(LENGTH.from_si(self.cycle_displacement), LENGTH.unit)),
            ]
        return "history", rows, ()

    @property
    def _count(self) -> int:
        """Number of phases until the end, repeated ones included."""
        return int(doors().phase_at(self._legs, self._span, self.end, False)) + 1

    @property
    def pattern(self) -> str:
        """Kinds of the phases that repeat, such as ``F_``; empty if none repeat before the end."""
        return "".join(LETTERS[mode] for mode in self._motion.legs.mode[self._motion.first :])

    @property
    @shielded
    def settles_at(self) -> float:
        """Time at which the first phase begins that repeats; inf if none does before the end [s]."""
        if not self._motion.period:
            return math.inf
        legs, first = self._motion.legs, self._motion.first
        turns = (legs.phase[first] - legs.phase[0]) / TURN
        return float((legs.cycle[first] + turns) / float(self.scene.frequency))

    @property
    def period_cycles(self) -> int:
        """Drive cycles after which the phases repeat; 0 if they do not."""
        return self._motion.period

    @property
    @shielded
    def cycle_displacement(self) -> float:
        """Displacement per drive cycle once the phases repeat; NaN if they do not [m]."""
        if not self._motion.period:
            return math.nan
        return float(self.scene.scale) * self._motion.advance / self._motion.period

    @cached_property
    @shielded
    def phases(self) -> tuple[Phase, ...]:
        """All phases until the end of the history; repeated cycles are listed in full.

        Raises
        ------
        InputError
            If there are more than 2 million.
        """
        if self._count > MOST_PHASES:
            raise InputError(
                f"a history of {self._count} phases: at most {MOST_PHASES} are spelt out",
                hint="follow fewer cycles; sample() and cycle_displacement need no list of phases",
            )
        count, legs, solver = self._count, self._motion.legs, doors()
        row, start, position = np.empty(count + 1, np.int64), np.empty(count + 1), np.empty(count + 1)
        buffers = [solver.row(x) for x in (row, start, position)]
        solver.phases(self._legs, self._span, *buffers, count + 1)
        row, starts = row[:count], start[:count]
        length, speed = self._units
        final, position = self.sample(self.end, side="left"), length * position[:count]
        ends = np.append(starts[1:], self.end)
        end_position = np.append(position[1:], final.position)
        end_velocity = speed * legs.end_velocity[row]
        end_velocity[-1] = final.velocity
        impact = speed * legs.impact[row]
        if self.end < start[count]:
            impact[-1] = 0.0
        columns = (starts, ends, position, end_position, speed * legs.velocity[row], end_velocity, impact)
        kinds = (LETTERS[mode] for mode in legs.mode[row])
        numbers = zip(*(x.tolist() for x in columns), strict=True)
        return tuple(Phase(kind, *values) for kind, values in zip(kinds, numbers, strict=True))

    @shielded
    def to_frame(self) -> pd.DataFrame:
        """Return the phases as a data frame.

        Returns
        -------
        pandas.DataFrame
            One row per phase, with the columns of ``vibro simulate -o``; their names contain the units.
            Positions and velocities are relative to the trough, positive in the conveying direction;
            positions are 0 at time 0.

        Examples
        --------
        >>> import math, vibro
        >>> scene = vibro.Scene(amplitude=1e-3, frequency=15, drive_angle=math.radians(20),
        ...                     static_friction=0.74, kinetic_friction=0.57)
        >>> frame = vibro.simulate(scene, cycles=1).to_frame()
        >>> frame[["phase", "start_s", "end_position_mm"]].round(4)
                   phase  start_s  end_position_mm
        0           rest   0.0000           0.0000
        1  forward slide   0.0080           1.0842
        2           rest   0.0387           1.0842
        """
        import pandas as pd

        return pd.DataFrame(phase_table(self, self.phases))

    @shielded
    def draw(
        self,
        path: str | PathLike[str] | None = None,
        *,
        start: float | None = None,
        end: float | None = None,
        panels: str | None = None,
    ) -> Figure:
        """Draw the trough, the forces, and the motion relative to the trough, as ``vibro simulate -o`` does.

        Parameters
        ----------
        path : str or path, optional
            File to write, by its ending: ``.png``, ``.svg`` or ``.pdf``; an existing one is replaced.
        start, end : float, optional
            When the picture begins and ends; by default it has the last six drive cycles [s].
        panels : str, optional
            Some of ``trough,forces,acceleration,velocity,position,gap``; by default all, the gap only if the
            body leaves the trough.

        Returns
        -------
        matplotlib.figure.Figure
            Panels above each other over one time axis; below them the path of an elliptical drive. No window
            opens.

        Raises
        ------
        InputError
            If a time lies outside the history, the picture would have more than 100 drive cycles, or a panel
            is unknown.
        FileError
            If the file cannot be written.
        """
        return drawn(self, path, start=start, end=end, panels=panels)

    @shielded
    def sample(self, times: ArrayLike, side: Literal["left", "right"] = "right") -> Sample:
        """Return motion and forces at any times.

        Parameters
        ----------
        times : array_like
            Between 0 and ``end``, in any order [s].
        side : {"right", "left"}, optional
            Which values to return at a time at which a phase ends and the next one begins: those of the next
            phase (``"right"``) or those of the one before (``"left"``). Velocities jump at impacts; forces
            jump where a slide starts or stops, and where the trough's acceleration jumps.

        Returns
        -------
        Sample
            Arrays of the times' shape.

        Raises
        ------
        VibroError
            If a time is outside the history, or ``side`` is neither.

        Examples
        --------
        >>> import math, vibro
        >>> scene = vibro.Scene(amplitude=1e-3, frequency=15, drive_angle=math.radians(20),
        ...                     static_friction=0.74, kinetic_friction=0.57)
        >>> sample = vibro.simulate(scene, cycles=1).sample([0.0, 0.02, 0.04])
        >>> print(*(f"{1e3 * x:.3f} mm" for x in sample.position))
        0.000 mm 0.230 mm 1.084 mm
        """
        if side not in ("left", "right"):
            raise VibroError(f"side = {shown(side)}: must be 'left' or 'right'")
        try:
            time = real_array(times)
        except NotRealError as exc:
            raise VibroError(f"time = {exc.value}: must be {exc.allowed}") from None
        slack = _SLACK * self.end
        outside = ~((time >= -slack) & (time <= self.end + slack))
        if outside.any():
            raise VibroError(
                f"time {time[outside].flat[0]:.15g} s is outside of the history, 0 to {self.end:.15g} s"
            )
        flat = np.clip(time.ravel(), 0.0, self.end)
        after, solver = np.full(flat.size, side == "right", np.int8), doors()
        values = np.empty((len(Sampled._fields), flat.size))
        height, off = self.start_height / self._units[0], _OFF_JUMP if self._jumps.size else 0.0
        for begin in range(0, flat.size, _MOMENTS):
            part = slice(begin, begin + _MOMENTS)
            given = solver.row(flat[part]), solver.row(after[part]), solver.rows(values[:, part])
            cell = self._grid.scenes, self._grid.place()
            solver.sample(*cell, self._legs, self._span, height, off, *given, flat[part].size)
        return Sample(time, *(x.reshape(time.shape) for x in values))

    @property
    def _jumps(self) -> Floats:
        """Shares of the period at which the trough's acceleration jumps [1]."""
        motion = self.scene.motion
        return motion.jumps if isinstance(motion, PiecewiseMotion) else np.empty(0)

    def jumps(self, since: float, until: float) -> Floats:
        """Return the times at which the trough's acceleration jumps.

        Parameters
        ----------
        since, until : float
            Interval of times [s].

        Returns
        -------
        array
            Ascending times within the interval; empty for drives whose acceleration is continuous [s].
        """
        frequency, turns = float(self.scene.frequency), self.start_phase / TURN
        cycles = np.arange(math.floor(turns + since * frequency), math.ceil(turns + until * frequency))
        times = ((cycles[:, np.newaxis] + self._jumps).ravel() - turns) / frequency
        return np.asarray(times[(since < times) & (times < until)])

    @property
    def _units(self) -> tuple[float, float]:
        """A and A w."""
        scale = float(self.scene.scale)
        return scale, scale * TURN * float(self.scene.frequency)

    @property
    def _span(self) -> Span:
        return self._motion.span(float(self.scene.frequency))

    @property
    def _legs(self) -> tuple[Any, ...]:
        return tuple(doors().row(x) for x in self._motion.legs)
