"""Steady cycles that coexist on one trough, in SI units."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.core.codes import LETTERS, PATTERNS, spelt_text
from vibro.drives import Ability
from vibro.motion.histories import Start, follow_body, grid_of
from vibro.reals import shielded
from vibro.results.attractors import Attractor, Attractors
from vibro.threads import Scratch, doors, lasting

if TYPE_CHECKING:
    from vibro.scene import Scene
    from vibro.threads import Grid


_ROOM: Final = (
    256  # cycles; 64 starts lead to 64 lists of flights at most, nearly all of which have one cycle
)
_NUMBERS: Final = 9  # of a cycle, see ``vibro.core.attractors.Attractors``


@shielded
def attractors(scene: Scene) -> Attractors:
    """Find the steady cycles that coexist, in which bodies settle depending on how they start.

    Parameters
    ----------
    scene : Scene
        One operating point, of shape ().

    Returns
    -------
    Attractors
        Sequence of ``Attractor``, that of a body from rest first. It is empty if bodies run away or all
        motion is irregular.

    Raises
    ------
    SceneError, VibroError
        If the scene is more than one operating point, or its motion cannot be simulated.

    Notes
    -----
    The search is that of ``solve(scene, coexistence=True)``. In contact, under a drive of one harmonic, all
    cycles are known (theory, section 5). Of hopping bodies the start from rest and 64 other starts are
    simulated for up to 64 flights each; 16 of them lie on the cycles of one bounce, Eq. (37). For every cycle
    of flights that is reached, all velocities along the trough at which the motion repeats are found. With
    more than one harmonic, bodies that rest until each of the lift-offs are simulated too.
    ``Attractors.unsettled`` counts the starts that led to no cycle.

    Examples
    --------
    >>> import vibro
    >>> scene = vibro.Scene(amplitude=9.81 * 1.49149 / (2 * 3.141592653589793 * 15) ** 2, frequency=15,
    ...                     drive_angle=0.7034, static_friction=0.457783, kinetic_friction=0.0429106)
    >>> vibro.attractors(scene)
    pattern  period  mm a cycle  mm/s     multiplier
    F_       1       7.14373     107.156  0           from rest
    FB       1       0.633031    9.49547  0.8593
    <all cycles are known>
    """
    grid, solver, scratch = grid_of(scene), doors(), Scratch()
    values, pattern, counts = np.empty((_NUMBERS, _ROOM)), np.empty(_ROOM, np.int64), np.empty(4, np.int64)

    def found_all() -> Any:
        rows = *solver.rows(values), solver.row(pattern)
        return solver.attractors(
            grid.scenes, grid.place(), scratch.flights, scratch.hops, rows, solver.row(counts), _ROOM
        )

    number = lasting(found_all)
    from_rest, starts, lost, away = counts.tolist()
    length, frequency = float(scene.scale), float(scene.frequency)
    speed = length * 2.0 * math.pi * frequency
    hops, one_harmonic = starts > 1, scene.arrays().can(Ability.ONE_HARMONIC)
    found = []
    for i, row in enumerate(values[:, :number].T.tolist()):
        phase, rate, velocity, displacement, period, multiplier, _, _, flights = row
        code = int(pattern[i])
        if rate > 0.0:
            text = "H" * int(flights)
        else:
            text = spelt_text(code) if code > 0 else _spelt(grid, phase, velocity, period)
        found.append(
            Attractor(
                start_phase=phase,
                start_velocity=speed * velocity + 0.0,
                start_normal_velocity=speed * rate,
                period_cycles=int(period),
                displacement_per_cycle=length * displacement + 0.0,
                mean_velocity=length * displacement * frequency + 0.0,
                pattern=_as_named(text, one_harmonic=one_harmonic),
                largest_multiplier=multiplier,
                from_rest=bool(from_rest) and i == 0,
            )
        )
    complete = bool(not hops and not scene.restitution and one_harmonic and scene.kinetic_friction)
    return Attractors(tuple(found), starts, lost, bool(away), complete)


def _as_named(text: str, *, one_harmonic: bool) -> str:
    """Turn the legs of a cycle as ``SteadyCycle.pattern`` has them."""
    if len(text) > 1 and text[0] == text[-1] != "H":
        text = text[:-1]  # one leg, amid which the cycle begins
    turns = [text[i:] + text[:i] for i in range(len(text))]
    if "H" not in text and (named := next((turn for turn in turns if turn in PATTERNS), "")):
        return named
    return text if one_harmonic else min(turns, key=lambda turn: [*map(LETTERS.index, turn)])


def _spelt(grid: Grid, phase: float, velocity: float, period: float) -> str:
    """Follow a cycle for its legs, where they are more than a code has room for."""
    motion = follow_body(grid, Start(phase, velocity, 0.0, 0.0), 3.0 * period)
    return "".join(LETTERS[mode] for mode in motion.legs.mode[motion.first :])
