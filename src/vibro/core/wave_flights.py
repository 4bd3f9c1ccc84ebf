"""Flights over any periodic normal motion: from zero to zero of the load of a body on the trough.

Between two zeros the height over the trough is concave, where the trough would bear a body, or convex, where
it falls away under one. So each piece has a known number of landings. Seen from the ground the body flies
along a parabola: while that is above the highest point that the trough reaches it cannot land. Normal speeds
are over n [A w n], phases in radians.
"""

from __future__ import annotations

import math
from typing import Final

from vibro.core.buffers import HARMONICS, PIECES
from vibro.core.cells import behind, number_of_nodes
from vibro.core.elementary import FEW_ULP, INF, NAN, TURN, wrap
from vibro.core.wave_slides import Crossing, Fall, Left, ahead, crossing, first_ahead, left_after
from vibro.core.waves import NORMAL, Mix, Moved, Waves, depart, trough_at

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
    load = depart(waves, lift, phase).load
    if lifted and waves.kind == HARMONICS:
        load = 0.0
    fall = Fall(waves, lift, phase, load, True, 0.0, speed)
    up, down = _above_all(waves, lift, phase, speed)
    count, index = number_of_nodes(waves, NORMAL), first_ahead(waves, NORMAL, phase)
    low = Left(0.0, 0.0, speed, load)
    for _ in range(_MOST_PIECES):
        far = ahead(waves, NORMAL, phase, index)
        concave = behind(waves, NORMAL, index % count)
        rises_away = low.phase < up <= far
        if rises_away:
            far = up
        if far > low.phase:
            high, landing = left_after(fall, far), _none()
            if concave and high.value <= 0.0 and not (rises_away and high.rate >= 0.0):
                landing = _over_crest(fall, low, high)
            elif not concave and low.rate < 0.0:
                landing = _through_hollow(fall, low, high)
            if not math.isnan(landing.phase):
                return landing.phase, max(-(speed + landing.moved.velocity), 0.0)
            low = high
        index += 1
        if rises_away:
            low = left_after(fall, down)
            turns = float(math.floor((phase + down) / TURN))
            index = first_ahead(waves, NORMAL, phase + down - TURN * turns) + count * int(turns)
    return NAN, NAN


def _none() -> Crossing:
    """Stand for no landing."""
    return Crossing(NAN, Moved(NAN, NAN, NAN, NAN))


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


def _over_crest(fall: Fall, low: Left, high: Left) -> Crossing:
    """Return the landing in a concave piece at whose end the body would be below the trough."""
    if low.rate > 0.0:  # the take-off is a zero too: begin at the top
        low = _turn(fall, low, high)
    return crossing(fall, low, high)


def _through_hollow(fall: Fall, low: Left, high: Left) -> Crossing:
    """Return the landing in a convex piece that begins downwards; NaN if there is none.

    Tangents at both ends bound the height from below. Where the load jumps, a body may land without speed as
    the trough ceases to fall away: rounding would make it miss the jump by the root of an ulp.
    """
    noise = FEW_ULP * (1.0 + fall.mix.normal) * (1.0 + high.phase * high.phase)
    if fall.waves.kind == PIECES and max(abs(high.value), abs(high.rate)) <= noise:
        return Crossing(high.phase, Moved(0.0, -fall.rate, -fall.rate * high.phase, 0.0))
    if high.value > 0.0:
        if high.rate <= 0.0:
            return _none()
        meets = (high.value - low.value - high.rate * (high.phase - low.phase)) / (low.rate - high.rate)
        if low.value + low.rate * meets > 0.0:
            return _none()
        high = _turn(fall, low, high)
        if high.value > 0.0:
            return _none()
    return crossing(fall, low, high)


def _turn(fall: Fall, low: Left, high: Left) -> Left:
    """Return the top, or the bottom, between phases at which the body rises and falls."""
    rate = fall._replace(height=False, value=fall.rate)
    return left_after(fall, crossing(rate, left_after(rate, low.phase), left_after(rate, high.phase)).phase)
