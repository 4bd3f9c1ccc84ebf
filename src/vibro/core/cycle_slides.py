"""The slides of a steady contact cycle whose pattern is known, one after the other.

Lengths in A, speeds in A w, phases in radians.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from vibro.core.codes import Pattern
from vibro.core.continuous import continuous_sliding, middle_phase
from vibro.core.drives import Loads, phase_difference
from vibro.core.elementary import INF, NAN, QUARTER, TURN, wrap_around
from vibro.core.slide import Onset, slide, start_inside
from vibro.core.windows import Start, own_phase, resting_start, thresholds

__all__ = ["CycleSlides", "SlideLeg", "cycle_slides", "no_leg"]

_ROUNDING: Final = 1e-9  # [1] of a turn: two phases so close are one


class SlideLeg(NamedTuple):
    """One slide of a cycle.

    Attributes
    ----------
    way : float
        +1 forward, -1 back, 0 where there is no slide.
    from_rest : bool
        Whether it starts from rest at its onset; else it follows the other slide directly.
    start : Start
        Its onset and the static window of its direction.
    zero : float
        Phase of the trough's motion along itself at which its load is zero and rises [rad].
    begin, end : float
        Phases of the trough's motion along itself; the first slide begins in [0, 2 pi), the second one within
        a turn after the end of the first [rad].
    displacement : float
        Displacement of the body, with its sign [A].
    """

    way: float
    from_rest: bool
    start: Start
    zero: float
    begin: float
    end: float
    displacement: float


class CycleSlides(NamedTuple):
    """Both slides of a cycle, in the order of its pattern."""

    first: SlideLeg
    second: SlideLeg


def no_leg() -> SlideLeg:
    """Stand in for a slide that a cycle does not have."""
    none = Start(Onset(NAN, NAN, NAN, NAN, NAN, NAN, NAN), NAN, NAN, NAN)
    return SlideLeg(0.0, False, none, NAN, NAN, NAN, NAN)


def cycle_slides(loads: Loads, pattern: int) -> CycleSlides:
    """Solve the slides of a steady contact cycle of one or two slides."""
    at = thresholds(loads)
    if at.hops or at.unheld or pattern == Pattern.R or pattern == Pattern.NONE:
        return CycleSlides(no_leg(), no_leg())
    if pattern == Pattern.F_ and at.forward:
        return _in_order(_from_rest(loads, resting_start(loads, at, 1.0), 1.0), no_leg())
    if pattern == Pattern.B_ and at.back:
        return _in_order(_from_rest(loads, resting_start(loads, at, -1.0), -1.0), no_leg())
    if not (at.forward and at.back):
        return CycleSlides(no_leg(), no_leg())
    forward, back = resting_start(loads, at, 1.0), resting_start(loads, at, -1.0)
    if pattern == Pattern.FB:
        cycle = continuous_sliding(loads, forward, back)
        middle, x = middle_phase(loads, cycle) - phase_difference(loads), QUARTER + cycle.y
        return _in_order(_from(loads, forward, 1.0, middle - x), _from(loads, back, -1.0, middle + x))
    if pattern == Pattern.FB_:
        first = _from_rest(loads, forward, 1.0)
        return _in_order(first, _from(loads, back, -1.0, first.end))
    second = _from_rest(loads, back, -1.0)
    if pattern == Pattern.F_B:
        return _in_order(_from(loads, forward, 1.0, second.end), second)
    return _in_order(_from_rest(loads, forward, 1.0), second)


def _from_rest(loads: Loads, start: Start, way: float) -> SlideLeg:
    """Slide from the onset."""
    zero = -(own_phase(loads, way, loads.kinetic_friction) + phase_difference(loads))
    end = slide(start.onset)
    begin = zero + QUARTER - start.onset.c
    return SlideLeg(way, True, start, zero, begin, begin + 2.0 * end.half_length, way * end.displacement)


def _from(loads: Loads, start: Start, way: float, begin: float) -> SlideLeg:
    """Slide from a phase, at once after the other slide; none where that never ends."""
    if not abs(begin) < INF:
        return no_leg()
    zero = -(own_phase(loads, way, loads.kinetic_friction) + phase_difference(loads))
    onset = start_inside(wrap_around(QUARTER - (begin - zero)), start.onset.k, start.onset.load)
    end = slide(onset)
    return SlideLeg(
        way, False, start._replace(onset=onset), zero, begin, begin + 2.0 * end.half_length,
        way * end.displacement,
    )  # fmt: skip


def _in_order(first: SlideLeg, second: SlideLeg) -> CycleSlides:
    """Move slides by whole turns."""
    if not abs(first.begin) < INF:
        return CycleSlides(no_leg(), no_leg())
    shift = -TURN * math.floor(first.begin / TURN)
    first = first._replace(begin=first.begin + shift, end=first.end + shift)
    if second.way == 0.0 or not abs(first.end) < 1e300:
        return CycleSlides(first, second)
    shift = TURN * math.ceil((first.end - second.begin) / TURN - _ROUNDING)
    return CycleSlides(first, second._replace(begin=second.begin + shift, end=second.end + shift))
