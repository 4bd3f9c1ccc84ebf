"""The steady motion of one scene over trough time: what a record of a running conveyor should show."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.codes import Regime, Status
from vibro.core.numbers import TURN
from vibro.drives import Ability
from vibro.errors import VibroError
from vibro.motion.histories import Start, follow_body, is_followed, simulate
from vibro.reals import shielded
from vibro.results.history import History, Legs, SolvedMotion
from vibro.steady import slides_of, solve
from vibro.threads import Grid, doors

if TYPE_CHECKING:
    from vibro.reals import Floats
    from vibro.results.history import Phase, Sample
    from vibro.results.steady import SteadyCycle
    from vibro.scene import Scene


_SETTLING: Final = 20_000.0  # [drive cycles] at most; more than any scene within the tables needs
_LONGEST_RUN: Final = 1000.0  # [drive cycles] from rest in which phases with flights must begin to repeat
_ROUNDING: Final = 1e-12  # [drive cycles] shorter phases at the ends of a cycle are rounding
_DIFFERENCE: Final = 1e-5  # [drive cycles] half the time of a difference: ten digits of a speed are left
_SHORT: Final = 1e-2  # [rad] shorter flights are listed as one phase
_NONE: Final = "no steady motion to compare with"


@dataclass(frozen=True)
class _CyclePhase:
    """One phase of a steady cycle.

    Attributes
    ----------
    kind : str
        ``"F"`` forward slide, ``"B"`` back slide, ``"_"`` rest, ``"H"`` flight; ``"h"`` several flights of
        less than 0.01 rad each, one after the other.
    start, end : float
        Time since the trough passed its middle upwards; of an ellipse, forwards; of others since phase 0 [s].
    displacement : float
        Displacement relative to the trough during the phase [m].
    """

    kind: str
    start: float
    end: float
    displacement: float


@shielded
def cycle_phases(scene: Scene) -> tuple[_CyclePhase, ...]:
    """Phases of the steady cycle that a body at rest settles into.

    Parameters
    ----------
    scene : Scene
        Of shape ().

    Returns
    -------
    tuple of CyclePhase
        In the order of the pattern; empty where there is no steady cycle, where it cannot be followed, or
        where flights do not begin to repeat within 1000 drive cycles.
    """
    grid = Grid(scene.arrays())
    cycle = solve(scene, flight=False)
    if not is_followed(grid) or (cycle.regime != Regime.HOPPING and not cycle.pattern):
        return ()
    steady = _steady_cycle(scene, grid, cycle, _LONGEST_RUN)
    if steady is None:
        return ()
    short = _SHORT / (TURN * float(scene.frequency))
    found: list[_CyclePhase] = []
    for p in _at_trough_times(steady):
        kind = "h" if p.kind == "H" and p.end - p.start < short else p.kind
        moved, start = p.end_position - p.start_position, p.start
        if found and found[-1].kind == kind == "h":
            start, moved = found[-1].start, found.pop().displacement + moved
        found.append(_CyclePhase(kind, start, p.end, moved))
    return tuple(found)


class _SteadyCycle(NamedTuple):
    """One steady cycle, from the start of a leg on, and the trough time of that, in [0, period) [s]."""

    history: History
    lag: float


def _steady_cycle(scene: Scene, grid: Grid, cycle: SteadyCycle, most: float) -> _SteadyCycle | None:
    """Return the cycle that a body at rest settles into; None if none repeats within ``most`` drive cycles.

    Its first leg is that of the pattern.
    """
    drive, pattern = scene.arrays(), str(cycle.pattern)
    hops, one_harmonic = cycle.regime == Regime.HOPPING, drive.can(Ability.ONE_HARMONIC)
    rate = TURN * float(scene.frequency)
    if pattern == "_" or (one_harmonic and not hops):
        # The first slide of the cycle begins at rest, at a known phase.
        phase = 0.0 if pattern == "_" else float(slides_of(scene, cycle.pattern_code).begin.flat[0])
        return _SteadyCycle(simulate(scene, cycles=1.0, start_phase=phase), phase / rate)
    motion = follow_body(grid, Start(0.0, 0.0, 0.0, 0.0), most)
    span = motion.span(float(scene.frequency))
    if span.number == span.first:
        return None
    legs, solver = Legs.of_size(span.number - span.first), doors()
    rows = [tuple(solver.row(x) for x in part) for part in (motion.legs, legs)]
    solver.steady_legs(rows[0], span, not one_harmonic, rows[1])
    # A drive of one harmonic counts phases from the middle of its motion along the trough.
    phase = (float(legs.phase[0]) - math.remainder(drive.phase.item(), TURN)) % TURN
    steady = SolvedMotion(legs, 0, motion.period, motion.advance)
    end = motion.period / float(scene.frequency)
    return _SteadyCycle(History(scene, end, phase, 0.0, steady, grid), phase / rate)


def _at_trough_times(steady: _SteadyCycle) -> list[Phase]:
    """Return the phases of a cycle, without those that rounding makes at its ends."""
    history, lag = steady
    rounding = _ROUNDING / float(history.scene.frequency)
    return [
        replace(p, start=p.start + lag, end=p.end + lag)
        for p in history.phases
        if p.end > rounding and p.start < history.end - rounding
    ]


@dataclass(frozen=True, eq=False)
class SettledMotion:
    """A body that has settled; times count as those of ``_CyclePhase``.

    Attributes
    ----------
    pattern : str
        Phases of a cycle: F forward slide, B back slide, _ rest, H flight.
    period : float
        Of the drive [s].
    advance : float
        Displacement relative to the trough per cycle [m].
    """

    pattern: str
    period: float
    advance: float
    _steady: _SteadyCycle

    @cached_property
    def phases(self) -> tuple[Phase, ...]:
        """One cycle, at trough times."""
        return tuple(_at_trough_times(self._steady))

    @property
    def slides(self) -> tuple[tuple[int, float, float], ...]:
        """Direction, start and end of each slide of a cycle [s]."""
        ways = {"F": 1, "B": -1}
        return tuple((ways[p.kind], p.start, p.end) for p in self.phases if p.kind in ways)

    def sample(self, time: Floats) -> Sample:
        """Motion and forces at any trough times, also before the first cycle."""
        history, lag = self._steady
        turns = np.floor((time - lag) / self.period)
        sample = history.sample(np.clip(time - lag - turns * self.period, 0.0, self.period))
        return replace(sample, time=time, position=sample.position + turns * self.advance)

    def trough(self, time: Floats) -> dict[str, Floats]:
        """Displacement, velocity, acceleration of the trough along itself at trough times [m, m/s, m/s^2]."""
        step = _DIFFERENCE * self.period
        before, now, after = (self.sample(time + x) for x in (-step, 0.0, step))
        scene = self._steady.history.scene
        weight = float(scene.gravity) * math.sin(float(scene.trough_angle))
        return {
            "displacement": now.trough_along,
            "velocity": (after.trough_along - before.trough_along) / (2.0 * step),
            "acceleration": -(now.inertial + weight),
        }


def settled_motion(scene: Scene) -> SettledMotion:
    """Solve the steady motion of one scene.

    Parameters
    ----------
    scene : Scene
        Of shape ().

    Returns
    -------
    SettledMotion
        The cycle that a body at rest settles into.

    Raises
    ------
    VibroError
        If there is none that repeats in every drive cycle.
    """
    cycle = solve(scene)
    status = Status(int(cycle.status))
    if status is Status.AVERAGED or not status.answered:
        raise VibroError(f"{_NONE}: {status.message}")
    grid = Grid(scene.arrays())
    if not is_followed(grid):
        raise VibroError(f"{_NONE}: its loads or frictions are too extreme")
    steady = _steady_cycle(scene, grid, cycle, _SETTLING)
    if steady is None:
        raise VibroError(f"{_NONE}: the body hops without a period")
    if steady.history.period_cycles > 1:
        raise VibroError(f"{_NONE}: the body repeats its motion only every few cycles")
    period, advance = 1.0 / float(scene.frequency), float(cycle.displacement_per_cycle)
    return SettledMotion(str(cycle.pattern), period, advance, steady)
