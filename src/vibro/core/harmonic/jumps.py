"""Jumps of the return map: where a body at rest stays so, but slides on once it is set in motion."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from vibro.core.harmonic.cycle import Bodies, Track, follow, no_cycles, put_in, stopped
from vibro.core.harmonic.waves import TURN

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.core.harmonic.slides import Lanes

    Floats = NDArray[np.float64]
    Bools = NDArray[np.bool_]
    Indices = NDArray[np.intp]
    Signs = NDArray[np.int8]

__all__ = ["direction_after_turn", "jumps_of", "leads"]


def jumps_of(at: Lanes, cell: Indices) -> Floats:
    """Phases of all jumps, those to forward slides first, in 4 H rows."""
    return np.concatenate([at.jump.take(x, axis=1) for x in (cell, cell + at.noise.size // 2)])


def leads(at: Lanes, row: Indices) -> Signs:
    """Directions of the slides that bodies are set in motion to at jumps in these rows."""
    return np.where(row < at.jump.shape[0], 1, -1).astype(np.int8)


def direction_after_turn(at: Lanes, cell: Indices, row: Indices, slides_on: Bools) -> Signs:
    """Directions in which bodies slide a turn after they passed a jump; 0 at rest.

    Parameters
    ----------
    at : Lanes
        Scenes.
    cell, row : int array
        Scene and jump of each body.
    slides_on : bool array
        Whether it is set in motion there, or rests.
    """
    h, n = at.onset.shape[0], at.noise.size // 2
    rows = at.jump.shape[0]
    lane = np.where(row < rows, cell, cell + n)
    phase = at.jump[row % rows, lane]
    begun = stopped(at, cell, phase, ())
    put_in(begun, slides_on, lane, phase, at.jump_excess[row % rows, lane])
    track, out = Track(cell.size, h), no_cycles(cell.size, h)
    bodies = Bodies(np.arange(cell.size), cell, begun, begun.waited, np.zeros(cell.size, np.intp))
    for k in range(2 * h + 1):  # 2 H in a turn, and one at its end
        bodies = follow(at, bodies, track, out, range(k, k + 1))
        bodies = bodies.some((bodies.travelled < TURN).nonzero()[0])
    covers = (track.when < TURN) & (track.when + track.slides.length > TURN)
    way = np.where(track.slides.lane < n, 1, -1)
    return np.asarray(np.where(covers, way, 0).sum(axis=0), np.int8)
