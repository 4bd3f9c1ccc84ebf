"""When bodies arrive: the exact time from rest over a length, for scenes of any shape, in SI units."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from vibro.core.compiled import doors
from vibro.core.numbers import EXTREME
from vibro.errors import Problem, SceneError
from vibro.quantities import START_HEIGHT, START_NORMAL_VELOCITY, START_PHASE, START_VELOCITY
from vibro.reals import NotRealError, real_number, shielded
from vibro.results.steady import lengths_of
from vibro.solver import Grid, Scratch, lasting, over_cells
from vibro.steady import solve

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from vibro.quantities import Quantity
    from vibro.scene import Scene

    Floats = NDArray[np.float64]

__all__ = ["Start", "arrival_time", "arrivals", "number_of", "start_of"]

_LONGEST_FLIGHT: Final = 1e5  # [drive cycles] after which rounding has lost 1e-10 rad of the phase
_CELLS: Final = 16  # of a range: an interrupt is noticed between two


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
        above 1e50, and for arrivals later than 1e15 drive cycles.

    Raises
    ------
    SceneError
        If the length is not finite and positive, or does not broadcast, or a start is out of its range.

    Notes
    -----
    Exact to rounding: the relative error against the reference table is below 1e-10
    (tests/motion/test_arrivals.py). The transient is computed leg by leg. A cycle that contains a rest
    repeats exactly, so that all its repetitions are skipped in one step. A cycle without rest is approached
    geometrically: within 1e-7 of it the remaining transient is summed in closed form, from the contraction
    per cycle and the steady displacement. At low friction about 20 / (1 - contraction) cycles are computed
    before.

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
    return arrivals(scene, lengths, start)[()]


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
        raise SceneError((Problem(name, given, "left out: a clamped part cannot leave the trough"),))
    w = 2.0 * np.pi * np.asarray(scene.frequency)
    speed = np.asarray(scene.scale) * w
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        told = {"start_velocity": start.velocity, "start_normal_velocity": start.normal_velocity}
        for name, value in told.items():
            if not (np.abs(value) <= EXTREME * speed).all():
                limit = f"at most {EXTREME:g} times the peak speed of the trough"
                raise SceneError((Problem(name, f"{value:.15g} m/s", limit),))
        if start.height or start.normal_velocity > 0.0:
            weight = np.asarray(scene.gravity) * np.cos(scene.trough_angle)
            rise = max(start.normal_velocity, 0.0) + speed
            lasts = (rise + np.sqrt(rise * rise + 2.0 * weight * start.height)) / weight * w / (2.0 * np.pi)
            throw = speed * w / weight
            if not (lasts <= _LONGEST_FLIGHT * (1.0 + throw)).all():
                limit = f"such that the body lands within {_LONGEST_FLIGHT:g} drive cycles"
                name = "start_height" if start.height else "start_normal_velocity"
                value = start.height if start.height else start.normal_velocity
                raise SceneError((Problem(name, f"{value:.15g} {'m' if start.height else 'm/s'}", limit),))
    return start


def number_of(quantity: Quantity, value: Any) -> float:
    """Convert an argument in SI units to a number in the range of its quantity."""
    unit = quantity.kind.si_unit
    try:
        number = real_number(value)
    except NotRealError as exc:
        raise SceneError((Problem(quantity.name, exc.value, exc.allowed),)) from None
    if not quantity.allows(number):
        raise SceneError((Problem(quantity.name, f"{number:.15g} {unit}".rstrip(), quantity.range_text),))
    return number


def arrivals(scene: Scene, length: Floats, start: Start) -> Floats:
    """Arrival times from any start, of the shape of ``length``."""
    fields = scene.arrays().changed(lambda x: np.broadcast_to(x, length.shape))
    grid = Grid(fields)
    advance = np.broadcast_to(solve(scene).displacement_per_cycle, length.shape).flatten()
    reach, times = length.flatten(), np.empty(length.size)
    buffers, scratch = [doors().row(x) for x in (reach, advance, times)], Scratch()
    grid.hold(reach, advance, times)

    def follow(begin: int, end: int) -> None:
        doors().arrivals(grid.scenes, grid.place(), *start, *buffers, scratch.flights, begin, end)

    if grid.size == 1:
        lasting(lambda: follow(0, 1))
    else:
        over_cells(follow, grid.size, _CELLS, None, cost=grid.cost)
    return times.reshape(length.shape)
