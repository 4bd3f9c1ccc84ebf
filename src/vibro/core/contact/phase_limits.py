"""Loads at which elliptical drives begin to make bodies slip back, and keep them from resting.

Equation numbers are those of docs/theory.md.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from vibro.core.contact.never_at_rest import never_at_rest
from vibro.core.contact.onset import thresholds
from vibro.core.contact.starts import pair_of
from vibro.core.groups import take
from vibro.core.roots import bisect

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from vibro.core.contact.slide import Floats
    from vibro.core.contact.starts import Pair
    from vibro.core.groups import Loads

    Bools = NDArray[np.bool_]

__all__ = ["phase_limits"]

# [1] Load over that of the onsets up to which drives are looked at that never make bodies hop.
_MOST: Final = 1e8


def phase_limits(unit: Loads, hop: Floats, forward: Floats, back: Floats) -> tuple[Floats, Floats]:
    """Find the loads G from which the cycle has a back slide, and no rest.

    Parameters
    ----------
    unit : Loads
        Of elliptical drives at G = 1, 1-D.
    hop, forward, back : array
        Loads of the hop and of both onsets.

    Returns
    -------
    back_slip, rest_vanishes : array
        inf where neither comes before the hop.
    """
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        both = np.maximum(forward, back)
        slips_both = (both < hop) & (np.abs(unit.tangential) < unit.static_friction * unit.normal)
        back_slip = back.copy()
        late = np.flatnonzero(slips_both & (back > forward))
        back_slip[late] = _begins(unit, late, back, hop, _slips_back)
        vanishes = np.full(hop.shape, np.inf)
        cells = np.flatnonzero(slips_both)
        vanishes[cells] = _begins(unit, cells, both, hop, _never_rests)
        return back_slip, np.maximum(vanishes, back_slip)


def _begins(
    unit: Loads, cells: NDArray[np.intp], low: Floats, high: Floats, holds: Callable[[Loads, Pair], Bools]
) -> Floats:
    """Load from which something holds that goes on holding; ``low`` where it does there, else inf."""
    scenes, low, high = take(unit, cells), low[cells], np.minimum(high[cells], _MOST * low[cells])

    def at(load: Floats) -> Bools:
        scene = scenes._replace(along=scenes.along * load, across=scenes.across * load)
        margins = thresholds(scene).margins
        ahead, behind = (np.maximum(margin, 0.0) for margin in (margins.forward, margins.back))
        return holds(scene, pair_of(scene, margins._replace(forward=ahead, back=behind)))

    between = bisect(lambda x: np.where(at(np.exp(x)), 0.0, 1.0), np.log(low), np.log(high))
    return np.where(at(low), low, np.where(at(high), np.asarray(np.exp(between)), np.inf))


def _slips_back(scene: Loads, pair: Pair) -> Bools:
    """Whether the forward slide does not outlast the back window."""
    outlasts = pair.outlasts(1)
    return np.asarray(~(outlasts.positive | outlasts.edge))


def _never_rests(scene: Loads, pair: Pair) -> Bools:
    """Whether the cycle is that without rest."""
    meets = _slips_back(scene, pair) & pair.reaches(1).positive
    cells = meets.nonzero()[0]
    meets[cells] = never_at_rest(*take((scene, pair.forward, pair.back), cells))[1].positive
    return meets
