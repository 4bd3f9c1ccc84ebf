"""Time histories of one scene, from its first moment on."""

from __future__ import annotations

import math
from dataclasses import fields
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from vibro.core.codes import PHASE_NAMES, Status
from vibro.core.numbers import EXTREME, LONGEST_CYCLE, MOST_BOUNCES, MOST_CYCLES, TURN
from vibro.errors import InputError, SceneError, VibroError
from vibro.quantities import (
    CYCLES,
    DURATION,
    START_HEIGHT,
    START_NORMAL_VELOCITY,
    START_PHASE,
    START_VELOCITY,
    WAY,
)
from vibro.reals import NotRealError, real_number, shielded
from vibro.results.history import MOST_PHASES, History, Legs, Sample, SolvedMotion, in_mm, trough_phase
from vibro.results.steady import lengths_of
from vibro.scene import check_single
from vibro.steady import solve
from vibro.threads import Grid, Scratch, doors, over_cells

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from vibro.files.csv_tables import TableColumns
    from vibro.quantities import Quantity
    from vibro.reals import Floats
    from vibro.scene import Scene


# ------------------------------------------------------------------------------
# When bodies arrive: the exact time from rest over a length, for scenes of any shape, in SI units.

_LONGEST_FLIGHT: Final = 1e5  # [drive cycles] after which rounding has lost 1e-10 rad of the phase
_CELLS: Final = 16  # of a range, so that threads share the work evenly


@shielded
def arrival_time(
    scene: Scene,
    length: ArrayLike,
    *,
    start_phase: float = 0.0,
    start_velocity: float = 0.0,
    start_height: float = 0.0,
    start_normal_velocity: float = 0.0,
) -> Any:
    """Return the first time at which a body has moved by a length.

    Parameters
    ----------
    scene : Scene
        Operating points of any shape.
    length : array_like
        Displacement relative to the trough, > 0; broadcasts against the scene [m].
    start_phase, start_velocity, start_height, start_normal_velocity : float, optional
        How bodies start, as for ``simulate``; by default from rest at trough phase 0 [rad, m/s, m, m/s].

    Returns
    -------
    array
        Times, of the common shape [s]. inf if the body never arrives: it rests for ever, or its steady cycle
        has no net advance and the transient is shorter than the length. NaN if the time is unknown: for
        infeasible scenes, for flights that amplify rounding errors beyond 1e-9 rad, for loads and frictions
        above 1e50, for arrivals later than 1e15 drive cycles, and where a body has not settled after two
        million slides.

    Raises
    ------
    SceneError
        If the length is not finite and positive, or does not broadcast, or a start is out of its range.

    Notes
    -----
    Exact to rounding: the relative error against the reference table is below 1e-10
    (tests/motion/test_histories_arrivals.py). The transient is computed leg by leg. A cycle that contains a
    rest repeats exactly, so that all its repetitions are skipped in one step. A cycle without rest is
    approached geometrically: within 1e-7 of it the remaining transient is summed in closed form, from the
    contraction per cycle and the steady displacement. At low friction about 20 / (1 - contraction) cycles are
    computed before.

    Examples
    --------
    >>> import math, vibro
    >>> scene = vibro.Scene(amplitude=1e-3, frequency=15, drive_angle=math.radians(20),
    ...                     static_friction=0.74, kinetic_friction=0.57)
    >>> print(f"{vibro.arrival_time(scene, 0.6):.6f} s")
    36.890432 s
    """
    lengths = lengths_of(length, scene.shape)
    start = start_of(scene, start_phase, start_velocity, start_height, start_normal_velocity)
    return _arrivals(scene, lengths, start)[()]


class Start(NamedTuple):
    """How a body starts: as the arguments of ``simulate`` [rad, m/s, m, m/s]."""

    phase: float
    velocity: float
    height: float
    normal_velocity: float


def start_of(scene: Scene, phase: Any, velocity: Any, height: Any, normal_velocity: Any) -> Start:
    """Check how bodies start.

    Raises
    ------
    SceneError
        If a value is no finite number, the height is negative, a speed too large for a scene, or a body lands
        so late that rounding loses the phase of the trough.
    """
    start = Start(
        number_of(START_PHASE, phase),
        number_of(START_VELOCITY, velocity),
        number_of(START_HEIGHT, height),
        number_of(START_NORMAL_VELOCITY, normal_velocity),
    )
    if scene.normal_acceleration is not None and (start.height or start.normal_velocity):
        name, given = ("start_height", f"{start.height:.15g} m")
        if not start.height:
            name, given = ("start_normal_velocity", f"{start.normal_velocity:.15g} m/s")
        raise SceneError.of(name, given, "left out: a clamped part cannot leave the trough")
    w = 2.0 * np.pi * np.asarray(scene.frequency)
    speed = np.asarray(scene.scale) * w
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        speeds = {"start_velocity": start.velocity, "start_normal_velocity": start.normal_velocity}
        for name, value in speeds.items():
            if not (np.abs(value) <= EXTREME * speed).all():
                limit = f"at most {EXTREME:g} times the peak speed of the trough"
                raise SceneError.of(name, f"{value:.15g} m/s", limit)
        if start.height or start.normal_velocity > 0.0:
            weight = np.asarray(scene.gravity) * np.cos(scene.trough_angle)
            rise = max(start.normal_velocity, 0.0) + speed
            lasts = (rise + np.sqrt(rise * rise + 2.0 * weight * start.height)) / weight * w / (2.0 * np.pi)
            throw = speed * w / weight
            if not (lasts <= _LONGEST_FLIGHT * (1.0 + throw)).all():
                limit = f"such that the body lands within {_LONGEST_FLIGHT:g} drive cycles"
                name = "start_height" if start.height else "start_normal_velocity"
                value = start.height if start.height else start.normal_velocity
                raise SceneError.of(name, f"{value:.15g} {'m' if start.height else 'm/s'}", limit)
    return start


def number_of(quantity: Quantity, value: Any) -> float:
    """Convert an argument in SI units to a number in the range of its quantity."""
    unit = quantity.kind.si_unit
    try:
        number = real_number(value)
    except NotRealError as exc:
        raise SceneError.of(quantity.name, exc.value, exc.allowed) from None
    if not quantity.allows(number):
        raise SceneError.of(quantity.name, f"{number:.15g} {unit}".rstrip(), quantity.range_text)
    return number


def _arrivals(scene: Scene, length: Floats, start: Start) -> Floats:
    """Arrival times from any start, of the shape of ``length``."""
    fields = scene.arrays().changed(lambda x: np.broadcast_to(x, length.shape))
    grid = Grid(fields)
    advance = np.broadcast_to(solve(scene).displacement_per_cycle, length.shape).flatten()
    reach, times = length.flatten(), np.empty(length.size)
    buffers, scratch = [doors().row(x) for x in (reach, advance, times)], Scratch()
    grid.hold(reach, advance, times)

    def follow(begin: int, end: int) -> None:
        doors().arrivals(grid.scenes, grid.place(), *start, *buffers, scratch.flights, begin, end)

    over_cells(follow, grid.size, _CELLS, None, cost=grid.cost)
    return times.reshape(length.shape)


_FEW: Final = 1024  # legs allocated at first; nearly every motion repeats sooner
_MORE: Final = 4  # factor by which that grows
STARTS: Final = MOST_BOUNCES + LONGEST_CYCLE  # flights of a cycle, at most


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
        end = float(_arrivals(scene, np.array(given["length"]), start))
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
    check_single(scene)
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
    row, change = np.empty(STARTS, np.int64), np.empty(STARTS)

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
        number = followed(legs, rows)
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


# ------------------------------------------------------------------------------
# A history in rows: its motion at even steps and at every event.

_ROUNDING: Final = 1e-9  # of the number of steps, or of a drive cycle


def trace(
    history: History, *, since: float = 0.0, until: float, samples_per_cycle: int, both_sides: bool = False
) -> Sample:
    """Sample a history at even steps and at every event.

    Parameters
    ----------
    history : History
        What to sample.
    since, until : float
        When the samples begin and end [s].
    samples_per_cycle : int
        Even steps in a drive cycle; 0 for the events alone.
    both_sides : bool
        Whether there are two rows at an event, before and after it, as a picture needs them, also where the
        trough's acceleration jumps; else there is one, after it.

    Returns
    -------
    Sample
        Arrays of one row a time, ascending, from ``since`` on.
    """
    events = np.array([p.start for p in history.phases if since < p.start < until])
    if both_sides:
        jumps, beside = history.jumps(since, until), _ROUNDING / float(history.scene.frequency)
        # Where a phase begins at a jump, both times may differ by rounding: they are one event.
        ends = (np.searchsorted(events, jumps + side) for side in (-beside, beside))
        events = np.union1d(events, jumps[np.equal(*ends)])
    rate = samples_per_cycle * float(history.scene.frequency)
    # A last step that differs from the end by rounding alone is dropped: the end is added below.
    steps = np.arange(math.ceil(rate * since), math.ceil(rate * until * (1.0 - _ROUNDING)))
    even = steps / rate if rate else np.array([])
    times = np.unique(np.concatenate([[since], even, events, [until]]))
    if not both_sides:
        return history.sample(times)
    after, before = history.sample(times[:-1]), history.sample(np.append(events, until), side="left")
    # Stable: the row before an event stands first.
    order = np.argsort(np.concatenate([before.time, after.time]), kind="stable")
    return Sample(
        *(np.concatenate([getattr(before, f.name), getattr(after, f.name)])[order] for f in fields(Sample))
    )


def motion_table(history: History, sample: Sample) -> TableColumns:
    """Return the columns of a sampled motion, forces per unit mass."""
    phases = history.phases
    place = np.searchsorted([p.start for p in phases], sample.time, side="right") - 1
    return {
        "time_s": sample.time,
        "trough_phase_deg": trough_phase(history, sample.time),
        "phase": [PHASE_NAMES[phases[i].kind] for i in place],
        **_trough(sample),
        "relative_position_mm": in_mm(sample.position),
        "relative_velocity_mm_s": in_mm(sample.velocity),
        "relative_acceleration_m_s2": sample.acceleration,
        "inertial_m_s2": sample.inertial,
        "friction_m_s2": sample.friction,
        "normal_m_s2": sample.normal,
        "static_limit_m_s2": sample.static_limit,
        "gap_mm": in_mm(sample.gap),
    }


def _trough(sample: Sample) -> TableColumns:
    """Return the columns of the trough's own motion: one along a line, two of an ellipse."""
    if np.isnan(sample.trough_displacement).all():
        return {
            "trough_along_mm": in_mm(sample.trough_along),
            "trough_normal_mm": in_mm(sample.trough_normal),
        }
    return {"trough_displacement_mm": in_mm(sample.trough_displacement)}
