"""Time histories of one scene, from its first moment on."""

from __future__ import annotations

import math
from functools import partial
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.core.codes import Status
from vibro.core.compiled import doors
from vibro.core.numbers import LONGEST_CYCLE, MOST_BOUNCES, MOST_CYCLES, TURN
from vibro.errors import InputError, Problem, SceneError, VibroError
from vibro.motion.arrivals import Start, arrivals, number_of, start_of
from vibro.quantities import CYCLES, DURATION, WAY
from vibro.reals import shielded
from vibro.results.history import MOST_PHASES, History, Legs, SolvedMotion
from vibro.solver import Grid, Scratch, lasting
from vibro.steady import solve

if TYPE_CHECKING:
    from vibro.scene import Scene

__all__ = ["follow_body", "grid_of", "is_followed", "simulate"]

_FEW: Final = 1024  # legs allocated at first; nearly every motion repeats sooner
_MORE: Final = 4  # factor by which that grows
_STARTS: Final = MOST_BOUNCES + LONGEST_CYCLE  # flights of a cycle, at most


@shielded
def simulate(
    scene: Scene,
    *,
    cycles: float | None = None,
    duration: float | None = None,
    length: float | None = None,
    start_phase: float = 0.0,
    start_velocity: float = 0.0,
    start_height: float = 0.0,
    start_normal_velocity: float = 0.0,
) -> History:
    """Simulate the motion of one body on the trough from time 0 on.

    Parameters
    ----------
    scene : Scene
        One operating point, of shape ().
    cycles, duration, length : float
        End of the history; give exactly one of them, > 0: a number of drive cycles [1], a time [s], or a
        displacement relative to the trough [m].
    start_phase : float, optional
        Phase of the trough at time 0 [rad].
    start_velocity : float, optional
        Velocity of the body relative to the trough at time 0, positive in the conveying direction [m/s].
    start_height : float, optional
        Height of the body above the trough at time 0, >= 0 [m].
    start_normal_velocity : float, optional
        Normal velocity of the body relative to the trough at time 0, positive away from it [m/s]. If the
        height is 0, a positive one throws the body, and a negative one is an impact at time 0.

    Returns
    -------
    History
        The phases of the motion; ``History.sample`` gives motion and forces at any time.

    Raises
    ------
    SceneError, VibroError
        If an argument is out of its range, the motion of the scene cannot be simulated, the body never covers
        ``length``, or the motion has not begun to repeat within 2 million phases.

    Notes
    -----
    By default the body starts at rest on the trough at phase 0; it leaves the trough at once if the trough
    accelerates away from it there. The motion is simulated until it repeats. A cycle that contains a rest
    repeats exactly. A cycle without rest has then converged to rounding, and in contact it is replaced by the
    closed form, Eqs. (18)-(20) and (59)-(63). Its displacement agrees with ``solve`` to 1e-12
    (tests/motion/test_histories.py). Irregular motion is simulated to the end; rounding errors grow in it as
    in any chaotic motion.

    Examples
    --------
    >>> import math, vibro
    >>> scene = vibro.Scene(amplitude=1e-3, frequency=15, drive_angle=math.radians(20),
    ...                     static_friction=0.74, kinetic_friction=0.57)
    >>> for phase in vibro.simulate(scene, cycles=1).phases:
    ...     print(phase.kind, f"{1e3 * phase.start:.5f} ms to {1e3 * phase.end:.5f} ms")
    _ 0.00000 ms to 8.00900 ms
    F 8.00900 ms to 38.68329 ms
    _ 38.68329 ms to 66.66667 ms
    """
    given = {
        quantity.name: number_of(quantity, value)
        for quantity, value in ((CYCLES, cycles), (DURATION, duration), (WAY, length))
        if value is not None
    }
    if len(given) != 1:
        named = " and ".join(f"{name} = {value:.15g}" for name, value in given.items()) or "none"
        raise VibroError(f"give exactly one of cycles, duration and length; given: {named}")
    grid = grid_of(scene)
    start = start_of(scene, start_phase, start_velocity, start_height, start_normal_velocity)
    frequency = float(scene.frequency)
    if "length" in given:
        end = float(arrivals(scene, np.array(given["length"]), start))
        if not math.isfinite(end):
            why = "the body never gets so far" if end > 0.0 else "whether the body gets so far is unknown"
            raise VibroError(f"length = {given['length']:.15g} m: {why}; give cycles or duration instead")
    else:
        end = given["duration"] if "duration" in given else given["cycles"] / frequency
    cycles = end * frequency
    if not 0.0 < cycles <= MOST_CYCLES:
        (name, value), limit = *given.items(), f"above 0 and at most {MOST_CYCLES:g} drive cycles"
        raise VibroError(f"{name} = {value:.15g}: comes to {cycles:g} drive cycles: must be {limit}")
    length_unit, speed_unit = float(scene.scale), float(scene.scale) * TURN * frequency
    started = Start(
        start.phase,
        start.velocity / speed_unit,
        start.height / length_unit,
        start.normal_velocity / speed_unit,
    )
    return History(scene, end, start.phase, start.height, follow_body(grid, started, cycles), grid)


def grid_of(scene: Scene) -> Grid:
    """Return the grid of a scene.

    Raises
    ------
    SceneError, VibroError
        If it is no single one, or its motion cannot be followed.
    """
    if scene.shape:
        raise SceneError((Problem("scene", f"shape {scene.shape}", "one operating point, of shape ()"),))
    grid = Grid(scene.arrays())
    if not is_followed(grid):
        status = Status(int(solve(scene).status))
        why = "its loads or frictions are too extreme" if status.answered else status.message
        raise VibroError(f"no motion to follow: {why}")
    return grid


def is_followed(grid: Grid) -> bool:
    """Whether the body of one scene can be followed."""
    return bool(doors().followed(grid.scenes, grid.place(), 0))


def follow_body(grid: Grid, start: Start, cycles: float) -> SolvedMotion:
    """Follow the body of one scene until its motion repeats, or for so many drive cycles.

    The start has velocities in A w and a height in A.

    Raises
    ------
    InputError
        If it has more than ``MOST_PHASES`` phases that do not repeat: memory would run out sooner or later.
    """
    solver, scratch = doors(), Scratch()
    first, period, advance = np.zeros(1, np.int64), np.zeros(1, np.int64), np.zeros(1)
    row, change = np.empty(_STARTS, np.int64), np.empty(_STARTS)

    def followed(legs: Legs, rows: int) -> Any:
        parts = (legs, (first, period, advance), (row, change))
        buffers, cycle, last = (tuple(solver.row(x) for x in part) for part in parts)
        return solver.history(
            grid.scenes, grid.place(), *start, cycles, buffers, rows, cycle, last, scratch.flights
        )

    rows, number = _FEW, -1
    while number < 0:
        rows = min(rows, MOST_PHASES)
        legs = Legs.of_size(rows)
        number = lasting(partial(followed, legs, rows))
        if number < 0 and rows == MOST_PHASES:
            known = int(legs.cycle[-1])
            raise InputError(
                f"the motion does not begin to repeat within {MOST_PHASES} phases, which end in drive cycle"
                f" {known} of {cycles:.6g}: no more are kept",
                hint=f"ask for at most {known} cycles",
            )
        rows *= _MORE
    return SolvedMotion(
        Legs._make(x[:number].copy() for x in legs), int(first[0]), int(period[0]), float(advance[0])
    )
