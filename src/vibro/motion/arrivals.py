"""When bodies arrive: the exact time from rest over a length, for scenes of any shape, in SI units."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.core.flight.cycles import MOST_THROW
from vibro.core.groups import each, take
from vibro.core.walk.arrival import arrival_cycles
from vibro.core.walk.steps import course_of
from vibro.results.steady import lengths_of
from vibro.steady import solve

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from vibro.core.groups import Loads
    from vibro.scene import Scene

    Floats = NDArray[np.float64]

__all__ = ["EXTREME", "arrival_time", "arrivals", "unfollowed"]

_TURN: Final = 2.0 * np.pi
_BLOCK: Final = 8_192  # scenes walked side by side
# [1] Of groups, and one over the least: walks form products of up to four, and differences of those.
EXTREME: Final = 1e50


def arrival_time(scene: Scene, length: ArrayLike) -> Any:
    """First time at which a body has moved by a length, from rest at trough phase 0.

    Parameters
    ----------
    scene : Scene
        Operating points of any shape.
    length : array_like
        Displacement relative to the trough, > 0; broadcasts against the scene [m].

    Returns
    -------
    array
        Of the common shape; inf where the body never gets there: it rests for ever, or its steady cycle has
        no net advance and the transient stays short of the length. NaN where nobody knows: infeasible
        scenes, bodies whose flights amplify rounding until it has grown past 1e-9 rad, loads and frictions
        beyond 1e50, and ways of more than 1e15 drive cycles [s].

    Raises
    ------
    SceneError
        If the length is not finite and positive, or does not broadcast.

    Notes
    -----
    Exact: within 1e-10 of the reference table, relative (tests/motion/test_arrivals.py). The transient is
    walked phase by phase. A cycle with a rest in it repeats exactly and is jumped at once, in closed form.
    One without, in contact or hopping, is approached geometrically; within 1e-7 of it the rest of the
    transient is summed in closed form from the known contraction per cycle and the steady displacement. At
    low friction the walk to there takes some 20 / (1 - contraction) cycles, all scenes side by side.

    Examples
    --------
    >>> import math, vibro
    >>> scene = vibro.Scene(amplitude=1e-3, frequency=15, drive_angle=math.radians(20),
    ...                     static_friction=0.74, kinetic_friction=0.57)
    >>> print(f"{vibro.arrival_time(scene, 0.6):.6f} s")
    36.890432 s
    """
    return arrivals(scene, lengths_of(length, scene.shape), 0.0, 0.0)[()]


def arrivals(scene: Scene, length: Floats, phase: float, velocity: float) -> Floats:
    """Arrival times from any start, of the shape of ``length``; velocity in m/s."""
    with np.errstate(over="ignore"):  # of an amplitude near 0, whose scene is not followed
        advance = solve(scene).displacement_per_cycle / scene.scale
    fields = each(scene.arrays(), lambda x: np.broadcast_to(x, length.shape).reshape(-1))
    advance, reach = (np.broadcast_to(x, length.shape).reshape(-1) for x in (advance, length))
    groups = fields.loads()
    out = np.full(length.size, np.nan)
    followed = np.flatnonzero(~unfollowed(groups))
    for i in range(0, followed.size, _BLOCK):
        cells = followed[i : i + _BLOCK]
        part = take(fields, cells)
        course = course_of(take(groups, cells), part.restitution)
        start = velocity / (part.scale * _TURN * part.frequency)
        target = reach[cells] / part.scale
        cycles = arrival_cycles(course, target, np.full(cells.size, phase), start, advance[cells])
        out[cells] = cycles / part.frequency
    return out.reshape(length.shape)


def unfollowed(scene: Loads) -> NDArray[np.bool_]:
    """Whether scenes have no motion that could be walked.

    They are infeasible, or thrown so high that the phase of a landing is lost, or of a load or a friction
    whose products overflow.
    """
    with np.errstate(over="ignore"):
        lost = scene.across > MOST_THROW * scene.normal
    weight = np.hypot(scene.normal, scene.tangential)
    extreme = (weight > EXTREME) | (weight < 1.0 / EXTREME) | (scene.static_friction > EXTREME)
    extreme |= (scene.kinetic_friction > 0.0) & (scene.kinetic_friction < 1.0 / EXTREME)
    return np.asarray(scene.infeasible | lost | extreme)
