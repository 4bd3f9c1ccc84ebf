"""The steady motion of one scene over trough time: what a record of a running conveyor should show."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.codes import LETTERS, Mode, Regime, Status
from vibro.core.numbers import TURN
from vibro.drives import Ability
from vibro.errors import VibroError
from vibro.motion.histories import Start, follow_body, is_followed, simulate
from vibro.reals import shielded
from vibro.results.history import Legs
from vibro.steady import slides_of, solve
from vibro.threads import Grid

if TYPE_CHECKING:
    from vibro.reals import Floats
    from vibro.results.history import History, Phase, Sample
    from vibro.results.steady import SteadyCycle
    from vibro.scene import Scene


_SETTLING: Final = 20_000.0  # [drive cycles] at most; more than any scene within the tables needs
_PERIODIC: Final = 1e-6  # relative change between cycles that count as the same
_LONGEST_RUN: Final = 1000.0  # [drive cycles] from rest in which phases with flights must begin to repeat
_ROUNDING: Final = 1e-12  # [drive cycles] shorter phases at the ends of a cycle are rounding
_DIFFERENCE: Final = 1e-5  # [drive cycles] half the time of a difference: ten digits of a speed are left
_SHORT: Final = 1e-2  # [rad] shorter flights are listed as one phase


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
    if not is_followed(grid):
        return ()
    cycle = solve(scene, flight=False)
    hops = cycle.regime == Regime.HOPPING
    legs = _followed_legs(scene, grid, _LONGEST_RUN) if hops else _contact_legs(scene, grid, cycle)
    w, scale = TURN * float(scene.frequency), float(scene.scale)
    return tuple(_CyclePhase(leg.kind, leg.start / w, leg.end / w, leg.displacement * scale) for leg in legs)


class _Leg(NamedTuple):
    """One leg of a cycle: its kind as in a pattern, drive phases at its ends [rad], displacement [A].

    The first leg starts in [0, 2 pi), each other one at the end before it.
    """

    kind: str
    start: float
    end: float
    displacement: float


def _contact_legs(scene: Scene, grid: Grid, cycle: SteadyCycle) -> list[_Leg]:
    """Legs of a steady contact cycle, in the order of its pattern; none if there is none."""
    pattern = str(cycle.pattern)
    if pattern in ("", "_"):
        return [_Leg("_", 0.0, TURN, 0.0)] if pattern else []
    if not scene.arrays().can(Ability.ONE_HARMONIC):
        return _followed_legs(scene, grid, _SETTLING)
    slides = slides_of(scene, cycle.pattern_code)
    columns = (x.tolist() for x in (slides.begin, slides.end, slides.displacement))
    legs = [_Leg(kind, *leg) for kind, *leg in zip(pattern.replace("_", ""), *columns, strict=False)]
    for i, kind in enumerate(pattern):
        if kind == "_":
            until = legs[i].start if i < len(legs) else legs[0].start + TURN
            legs.insert(i, _Leg("_", legs[i - 1].end, until, 0.0))
    return legs


def _followed_legs(scene: Scene, grid: Grid, most: float) -> list[_Leg]:
    """Legs of the steady cycle, by following a body from rest; none if they do not repeat within ``most``."""
    motion, drive = follow_body(grid, Start(0.0, 0.0, 0.0, 0.0), most), scene.arrays()
    steady = Legs._make(x[motion.first :] for x in motion.legs)
    turns = TURN * motion.period
    # a drive of one harmonic counts phases from the middle of its motion along the trough
    starts = TURN * steady.cycle + steady.phase - math.remainder(drive.phase.item(), TURN)
    columns = (steady.mode, starts, starts + steady.length, steady.displacement)
    legs: list[_Leg] = []
    for mode, start, end, displacement in zip(*(column.tolist() for column in columns), strict=True):
        kind = "h" if mode == Mode.FLIGHT and end - start < _SHORT else LETTERS[mode]
        if legs and legs[-1].kind == kind == "h":
            start, displacement = legs[-1].start, legs.pop().displacement + displacement
        legs.append(_Leg(kind, start, end, displacement))
    if legs and not drive.can(Ability.ONE_HARMONIC):
        # its patterns begin where their letters are least in the order of ``Mode``
        order = [LETTERS.index(leg.kind.upper()) for leg in legs]
        first = min(range(len(legs)), key=lambda i: order[i:] + order[:i])
        later = [leg._replace(start=leg.start + turns, end=leg.end + turns) for leg in legs[:first]]
        legs = legs[first:] + later
    since = TURN * math.floor(legs[0].start / TURN) if legs else 0.0
    return [leg._replace(start=leg.start - since, end=leg.end - since) for leg in legs]


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
    phases : tuple of Phase
        One cycle, at trough times.
    """

    pattern: str
    period: float
    advance: float
    phases: tuple[Phase, ...]
    _history: History
    _since: float
    _lag: float

    @property
    def slides(self) -> tuple[tuple[int, float, float], ...]:
        """Direction, start and end of each slide of a cycle [s]."""
        ways = {"F": 1, "B": -1}
        return tuple((ways[p.kind], p.start, p.end) for p in self.phases if p.kind in ways)

    def sample(self, time: Floats) -> Sample:
        """Motion and forces at any trough times, also before the first cycle."""
        since = time - self._lag
        turns = np.floor(since / self.period)
        within = np.clip(since - turns * self.period, 0.0, self.period)
        sample = self._history.sample(self._since + within)
        return replace(sample, time=time, position=sample.position + turns * self.advance)

    def trough(self, time: Floats) -> dict[str, Floats]:
        """Displacement, velocity, acceleration of the trough along itself at trough times [m, m/s, m/s^2]."""
        step = _DIFFERENCE * self.period
        before, now, after = (self.sample(time + x) for x in (-step, 0.0, step))
        scene = self._history.scene
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
        raise VibroError(f"no steady motion to compare with: {status.message}")
    frequency = float(scene.frequency)
    grid = Grid(scene.arrays())
    if not is_followed(grid):
        raise VibroError("no steady motion to compare with: its loads or frictions are too extreme")
    contact = [] if cycle.regime == Regime.HOPPING else _contact_legs(scene, grid, cycle)
    if contact:
        # The cycle has a slide that begins at a known phase: start there instead of following the transient.
        history = simulate(scene, cycles=1.0, start_phase=contact[0].start)
        since, lag = 0.0, contact[0].start / (TURN * frequency)
    else:
        history, since = _settled_flight(scene)
        lag = since % (1.0 / frequency)
    ends = history.sample([since, since + 1.0 / frequency], side="left")
    advance = float(cycle.displacement_per_cycle)
    moved = float(ends.position[1] - ends.position[0])
    if abs(moved - advance) > _PERIODIC * max(abs(advance), float(scene.scale)):
        raise VibroError(
            "no steady motion to compare with: the body repeats its motion only every few cycles"
        )
    return SettledMotion(
        pattern=str(cycle.pattern),
        period=1.0 / frequency,
        advance=advance,
        phases=tuple(_at_trough_times(history, since, lag)),
        _history=history,
        _since=since,
        _lag=lag,
    )


def _settled_flight(scene: Scene) -> tuple[History, float]:
    """Follow a hopping body until it repeats its motion; return the start of a flight from then on too."""
    settles_at = simulate(scene, cycles=_SETTLING).settles_at
    if math.isinf(settles_at):
        raise VibroError("no steady motion to compare with: the body hops without a period")
    history = simulate(scene, cycles=settles_at * float(scene.frequency) + 3.0)
    return history, next(p.start for p in history.phases if p.kind == "H" and p.start >= settles_at)


def _at_trough_times(history: History, since: float, lag: float) -> list[Phase]:
    """Cut one cycle out of a history."""
    period = 1.0 / float(history.scene.frequency)
    until, rounding = since + period, _ROUNDING * period
    return [
        replace(p, start=max(p.start, since) - since + lag, end=min(p.end, until) - since + lag)
        for p in history.phases
        if p.end > since + rounding and p.start < until - rounding
    ]
