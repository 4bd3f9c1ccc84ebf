"""When bodies arrive: the exact time from rest over a length, for scenes of any shape, in SI units."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.core.compiled import doors
from vibro.reals import shielded
from vibro.results.steady import lengths_of
from vibro.solver import Grid, Scratch, over_cells
from vibro.steady import solve

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from vibro.scene import Scene

    Floats = NDArray[np.float64]

__all__ = ["arrival_time", "arrivals"]

_CELLS: Final = 64  # of a range: an interrupt is noticed between two, and a slow transient takes a second


@shielded
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
        no net advance and the transient stays short of the length. NaN where it is unknown: infeasible
        scenes, bodies whose flights amplify rounding until it has grown past 1e-9 rad, loads and frictions
        beyond 1e50, and arrivals later than 1e15 drive cycles [s].

    Raises
    ------
    SceneError
        If the length is not finite and positive, or does not broadcast.

    Notes
    -----
    Exact: within 1e-10 of the reference table, relative (tests/motion/test_arrivals.py). The transient is
    followed leg by leg. A cycle with a rest in it repeats exactly and is jumped at once, in closed form.
    A cycle without rest, in contact or hopping, is approached geometrically; within 1e-7 of it the rest of
    the transient is summed in closed form from the known contraction per cycle and the steady displacement.
    At low friction some 20 / (1 - contraction) cycles have to be followed until then.

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
    fields = scene.arrays().changed(lambda x: np.broadcast_to(x, length.shape))
    grid = Grid(fields)
    advance = np.broadcast_to(solve(scene).displacement_per_cycle, length.shape).flatten()
    reach, times = length.flatten(), np.empty(length.size)
    buffers, scratch = [doors().row(x) for x in (reach, advance, times)], Scratch()
    grid.hold(reach, advance, times)

    def follow(begin: int, end: int) -> None:
        doors().arrivals(grid.scenes, grid.place(), phase, velocity, *buffers, scratch.flights, begin, end)

    over_cells(follow, grid.size, _CELLS, None)
    return times.reshape(length.shape)
