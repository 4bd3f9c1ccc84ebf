"""How the displacement of a steady contact cycle changes as the load grows, for any drive.

Equation numbers are those of docs/theory.md. Lengths in A, phases in radians.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibro.core.codes import Pattern
from vibro.core.contact.derivatives import displacement_gradient
from vibro.core.contact.never_at_rest import never_at_rest, never_at_rest_slope
from vibro.core.contact.onset import thresholds
from vibro.core.contact.slide import slide, start_inside
from vibro.core.contact.starts import pair_of, resting_start
from vibro.core.contact.windows import skew_of
from vibro.core.groups import take

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.core.contact.onset import Margins
    from vibro.core.contact.slide import Floats, Onset
    from vibro.core.contact.starts import Start
    from vibro.core.groups import Loads

__all__ = ["load_slope"]


def load_slope(scene: Loads, pattern: NDArray[np.integer]) -> Floats:
    """Differentiate the displacement of steady contact cycles with respect to ln G.

    Parameters
    ----------
    scene : Loads
        Groups of the scenes, 1-D, or 0-d where one value serves all.
    pattern : int array
        Codes of ``Pattern``, 1-D, from ``steady_state``.

    Returns
    -------
    array
        Over A, 1-D; 0 at rest, NaN where there is no steady contact cycle. The amplitudes keep their ratio.

    Notes
    -----
    Eqs. (45)-(50) along a line; of elliptical drives (45), (46) and (64).
    """
    scene = scene._replace(normal=np.broadcast_to(scene.normal, pattern.shape))
    if scene.lead is None:
        return displacement_gradient(scene, pattern).log_load
    margins = thresholds(scene).margins
    out = np.where(pattern == Pattern.R, 0.0, np.nan)
    for code in (Pattern.F_, Pattern.B_, Pattern.F_B_, Pattern.FB_, Pattern.F_B, Pattern.FB):
        cells = np.flatnonzero(pattern == code)
        if cells.size:
            out[cells] = _slope(take(scene, cells), take(margins, cells), code)
    return out


def _slope(scene: Loads, at: Margins, pattern: Pattern) -> Floats:
    """Differentiate scenes of one pattern."""
    if pattern is Pattern.FB:
        return _never_at_rest(scene, at)
    if pattern in (Pattern.F_, Pattern.B_):
        way = 1 if pattern is Pattern.F_ else -1
        return way * _from_rest(resting_start(scene, at, way)).displacement
    pair = pair_of(scene, at)
    swing = skew_of(scene, scene.kinetic_friction)
    if pattern is Pattern.F_B:
        first = _from_rest(pair.back)
        return _after(first, pair.forward, -swing).displacement - first.displacement
    first = _from_rest(pair.forward)
    second = _from_rest(pair.back) if pattern is Pattern.F_B_ else _after(first, pair.back, swing)
    return first.displacement - second.displacement


class _Slid(NamedTuple):
    """One slide: c of one that follows it but for the swing, and how its displacement and end change."""

    c_next: Floats
    displacement: Floats
    end_change: Floats


def _from_rest(start: Start) -> _Slid:
    """Slide from the onset, whose sine is over G as the window's is: it comes earlier as the load grows."""
    assert start.window is not None
    return _slid(start.onset, start.load, -1.0 / np.tan(start.window.c))


def _after(before: _Slid, start: Start, swing: Floats) -> _Slid:
    """Slide from where the opposite slide ends."""
    return _slid(start_inside(before.c_next + swing, start.onset.k), start.load, before.end_change)


def _slid(onset: Onset, load: Floats, start_change: Floats) -> _Slid:
    """Differentiate a slide, Eqs. (45) and (46), where k is over G and its load amplitude is not."""
    x = slide(onset).x
    u = x - onset.c
    lost = onset.excess * start_change
    displacement = -2.0 * x * load * (lost - x * onset.k)
    braking = 2.0 * np.sin(u) * np.sin(x) - onset.excess  # k - sin p1
    return _Slid(np.pi + onset.c - 2.0 * x, displacement, (2.0 * x * onset.k - lost) / braking)


def _never_at_rest(scene: Loads, at: Margins) -> Floats:
    """Differentiate cycles without rest."""
    pair = pair_of(scene, at)
    return never_at_rest_slope(scene, never_at_rest(scene, pair.forward, pair.back)[0])
