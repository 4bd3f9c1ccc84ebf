"""Flights over any periodic normal motion: from zero to zero of the load of a body on the trough.

Between two zeros the height over the trough is concave, where the trough would bear a body, or convex, where
it falls away under one. So each piece has a known number of landings. Seen from the ground the body flies
along a parabola: while that is above the highest point that the trough reaches it cannot land. Normal speeds
are over n [A w n], phases in radians.
"""

from __future__ import annotations

import math
from typing import Final

from vibro.core.cells import behind, number_of_nodes
from vibro.core.elementary import INF, NAN, TURN, wrap
from vibro.core.wave_slides import Crossing, Fall, ahead, crossing, first_ahead, level
from vibro.core.waves import HARMONICS, NORMAL, Mix, Moved, Waves, depart, trough_at

__all__ = ["fly_over_waves"]

_MOST_PIECES: Final = 1_000_000  # [1] of a flight near the highest point of the trough, in a tiny gravity


def fly_over_waves(waves: Waves, lift: Mix, phase: float, speed: float, lifted: bool) -> tuple[float, float]:
    """Fly to the first landing: return the phase until then [rad] and the speed there [A w n].

    Parameters
    ----------
    waves : Waves
        Whose row ``NORMAL`` is known.
    lift : Mix
        -N/n.
    phase, speed : float
        Of the take-off, speed >= 0.
    lifted : bool
        Whether it is at a zero of N: then N is 0 there exactly, unless it jumps.
    """
    phase = wrap(phase)
    load = depart(waves, lift, phase)
    if lifted and waves.kind == HARMONICS:
        load = 0.0
    fall = Fall(waves, lift, phase, load, True, 0.0, speed)
    up, down = _above_all(waves, lift, phase, speed)
    count, index, low, rate = number_of_nodes(waves, NORMAL), first_ahead(waves, NORMAL, phase), 0.0, speed
    for _ in range(_MOST_PIECES):
        far = ahead(waves, NORMAL, phase, index)
        concave = not behind(waves, NORMAL, index % count)
        rises_away = low < up <= far
        if rises_away:
            far = up
        if far > low:
            height_then, rate_then = level(fall, far)
            if concave and height_then <= 0.0 and not (rises_away and rate_then >= 0.0):
                landing = _over_crest(fall, low, far)
                return landing.phase, max(-(speed + landing.moved.velocity), 0.0)
            if not concave and rate < 0.0:
                landing = _through_hollow(fall, low, far)
                if not math.isnan(landing.phase):
                    return landing.phase, max(-(speed + landing.moved.velocity), 0.0)
            low, rate = far, rate_then
        index += 1
        if rises_away:
            low = down
            _, rate = level(fall, low)
            turns = math.floor((phase + low) / TURN)
            index = first_ahead(waves, NORMAL, phase + low - TURN * turns) + count * int(turns)
    return NAN, NAN


def _above_all(waves: Waves, lift: Mix, phase: float, speed: float) -> tuple[float, float]:
    """Return when the body rises above the highest point of the trough, and when it falls through it again.

    Where it never does, the first is infinite.
    """
    height, velocity = trough_at(waves, True, phase)
    rise = speed + lift.normal * velocity
    clearance = rise * rise - 2.0 * lift.normal * (waves.height - height)
    if not (rise > 0.0 and clearance > 0.0):
        return INF, INF
    root = math.sqrt(clearance)
    return lift.normal * 2.0 * (waves.height - height) / (rise + root), rise + root


def _over_crest(fall: Fall, low: float, high: float) -> Crossing:
    """Return the landing in a concave piece at whose end the body would be below the trough."""
    height, rate = level(fall, low)
    height_then, rate_then = level(fall, high)
    if rate > 0.0:  # the take-off is a zero too: begin at the top
        low = crossing(fall._replace(height=False, value=fall.rate), low, high, rate, rate_then).phase
        height, rate = level(fall, low)
    return crossing(fall, low, high, height, height_then)


def _through_hollow(fall: Fall, low: float, high: float) -> Crossing:
    """Return the landing in a convex piece that begins downwards; NaN if there is none.

    Tangents at both ends bound the height from below.
    """
    none = Crossing(NAN, Moved(NAN, NAN, NAN, NAN))
    height, rate = level(fall, low)
    height_then, rate_then = level(fall, high)
    if height_then > 0.0:
        if rate_then <= 0.0:
            return none
        meets = (height_then - height - rate_then * (high - low)) / (rate - rate_then)
        if height + rate * meets > 0.0:
            return none
        high = crossing(fall._replace(height=False, value=fall.rate), low, high, rate, rate_then).phase
        height_then, rate_then = level(fall, high)
        if height_then > 0.0:
            return none
    return crossing(fall, low, high, height, height_then)
