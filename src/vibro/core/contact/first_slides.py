"""Which slide comes first where a body starts from rest at phase 0 of the motion along the trough.

On a level trough that is a forward slide from its onset. On an incline phase 0 may lie inside a window, or
the back window may come first; it matters where steady cycles coexist.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from vibro.core.contact.never_at_rest import by_half_length
from vibro.core.contact.slide import slide, start_inside
from vibro.core.contact.windows import own_phase, skew_of
from vibro.core.groups import take
from vibro.core.roots import OpenCells

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.core.contact.starts import Pair
    from vibro.core.groups import Loads

__all__ = ["first_from_rest"]

_TURN: Final = 2.0 * np.pi
_MOST_SLIDES: Final = 1000  # without a rest, where there is no cycle without rest to come to


def first_from_rest(scene: Loads, pair: Pair) -> NDArray[np.int8]:
    """Follow bodies on elliptical drives to their first slide that begins with a rest.

    Parameters
    ----------
    scene : Loads
        Scenes that slip both ways, 1-D.
    pair : Pair
        Their slides from rest.

    Returns
    -------
    int8 array
        +1 where that slide goes forward, -1 where it goes back, and 0 where there is none: the body never
        rests again.
    """
    assert scene.lead is not None
    phase = scene.lead.angle  # of the normal motion
    waits = [
        np.mod(0.5 * np.pi - own_phase(scene, way, scene.static_friction) - window.c - phase, _TURN)
        for way, window in ((1, pair.forward.window), (-1, pair.back.window))
        if window is not None
    ]
    out = np.where(waits[0] <= waits[1], 1, -1).astype(np.int8)
    hold = scene.static_friction * (scene.normal - scene.across * scene.lead.sine)
    cells = (np.abs(scene.tangential) > hold).nonzero()[0]
    way = np.where(np.broadcast_to(scene.tangential, out.shape) < 0.0, 1, -1)
    c = 0.5 * np.pi - phase - own_phase(scene, way)
    swing = skew_of(scene, scene.kinetic_friction)
    start = way, np.mod(c + np.pi, _TURN) - np.pi
    out[cells] = 0
    # Where there is a cycle without rest, starts draw near it from one side, and each slide ends between that
    # of the cycle and the one before it: after two slides without a rest there is none.
    never = by_half_length(*take((scene, pair.forward, pair.back), cells))[1].positive
    going = OpenCells(cells, (*take((pair, swing, *start), cells), never), _MOST_SLIDES)
    for count, (open_, (both, turned, now, c, draws)) in enumerate(going):
        rests, after = np.zeros(open_.size, np.int8), np.empty(open_.size)
        for direction, own, other in ((1, both.forward, both.back), (-1, both.back, both.forward)):
            mine = (now == direction).nonzero()[0]
            onset, near, far, skew, swing, begin = take(
                (own.onset, own.window, other.window, both.skew, turned, c), mine
            )
            x = slide(start_inside(begin, onset.k)).x
            end = 0.5 * np.pi - begin + 2.0 * x  # in the slide's own phase
            middle = 1.5 * np.pi + direction * skew - (onset.c - near.c)  # of the opposite window
            rests[mine] = np.where(
                end <= middle - far.c, -direction, np.where(end >= middle + far.c, direction, 0)
            )
            after[mine] = np.pi + begin - 2.0 * x + direction * swing
        out[open_] = rests
        going.keep((rests == 0) & ~(draws & (count > 0)), (both, turned, -now, after, draws))
    return out
