"""The legs of one scene's steady cycle: when it slides which way, and when it rests."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from vibro.core.harmonic.arrays import CycleLeg
from vibro.core.harmonic.patterns import spelt
from vibro.core.harmonic.solver import from_rest, lanes_of, scenes_of

if TYPE_CHECKING:
    from vibro.core.harmonic.loads import HarmonicLoads

__all__ = ["harmonic_legs"]

_TURN = 2.0 * math.pi


def harmonic_legs(scene: HarmonicLoads) -> list[CycleLeg]:
    """Legs of the steady cycle of one scene, in the order of its pattern.

    Parameters
    ----------
    scene : HarmonicLoads
        Groups of one scene, each of shape (1,) or ().

    Returns
    -------
    list of CycleLeg
        Displacements are over the scene's scale. Empty where there is no steady contact cycle.
    """
    scenes = scenes_of(scene, 1)
    if scenes.exceptional[0]:
        return []
    if not scenes.slips[0]:
        return [CycleLeg("_", 0.0, _TURN, 0.0)]
    cycles = from_rest(lanes_of(scenes, np.zeros(1, np.intp))).cycles
    count = int(cycles.size[0])
    if not count:
        return []
    first = int(spelt(cycles, 1)[1][0])
    legs: list[CycleLeg] = []
    begin = float(cycles.start[first, 0])
    start = begin
    for i in range(count):
        row, following = (first + i) % count, (first + i + 1) % count
        forward = cycles.lane[row, 0] == 0
        end = start + float(cycles.length[row, 0])
        path = float(cycles.path[row, 0])
        legs.append(CycleLeg("F" if forward else "B", start, end, path if forward else -path))
        # the next start, in the turn it belongs to; the last leg ends a turn after the first has begun
        turns = round((end - float(cycles.start[following, 0])) / _TURN + 0.5 * cycles.rests[row, 0])
        start = begin + _TURN if i == count - 1 else float(cycles.start[following, 0]) + _TURN * turns
        if cycles.rests[row, 0]:
            legs.append(CycleLeg("_", end, start, 0.0))
        else:
            legs[-1] = legs[-1]._replace(end=start)
    return legs
