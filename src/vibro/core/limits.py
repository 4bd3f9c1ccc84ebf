"""Where a scene changes class as the load grows: the critical G = A w^2 / g of each transition.

Equation numbers are those of docs/theory. All functions take the loads of a scene at G = 1.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from vibro.core.contact import Pair, outlasts_back, pair_of
from vibro.core.continuous import continuous_sliding
from vibro.core.drives import Loads
from vibro.core.elementary import INF, NAN, PI, QUARTER
from vibro.core.roots import illinois
from vibro.core.windows import Thresholds, reaches, thresholds

__all__ = ["CriticalLoads", "critical_loads", "onset", "tipping_load", "unknown_loads"]

# [1] Load over that of the onsets up to which drives are looked at that never make bodies hop.
_MOST: Final = 1e8
_HALVINGS: Final = 52  # of the logarithm of a load, down to its rounding


class CriticalLoads(NamedTuple):
    """Critical loads G = A w^2 / g of one scene, as ``vibro.CriticalLoads`` describes them."""

    hop: float
    forward_onset: float
    back_onset: float
    back_slip: float
    continuous_sliding: float


def critical_loads(unit: Loads) -> CriticalLoads:
    """Find the critical load of every transition; NaN where mu_d > mu_s or mu_s = 0.

    Hop and onsets are closed forms, Eqs. (4), (5) and (55). Along a line rest vanishes where both slides of
    continuous sliding start on their onsets, a closed form too, Eq. (21), and back slip enters at its onset
    or at the root of Eq. (22). Other drives are looked at up to the hop, as classes follow each other in one
    order there too (section 6).
    """
    if unit.kinetic_friction > unit.static_friction or unit.static_friction == 0.0:
        return unknown_loads()
    at = thresholds(unit)
    capacity, t = unit.static_friction * unit.weight_normal, unit.weight_tangential
    hop = unit.weight_normal / unit.drive_normal if unit.drive_normal > 0.0 else INF
    forward, back = onset(capacity + t, at.forward_load), onset(capacity - t, at.back_load)
    held = abs(t) < capacity
    if unit.line and unit.drive_tangential <= unit.static_friction * unit.drive_normal:
        back = INF  # the drive presses the body down more than it pushes it back, Eq. (7)
    back_slip, vanishes = back, INF
    if unit.line and back < INF:
        braked = unit.kinetic_friction * unit.weight_normal + t > 0.0
        if held and back > forward:
            back_slip = _back_slip_of_line(unit, forward, back) if braked else INF
        if held and braked:
            vanishes = max(_continuous_sliding_of_line(unit, forward, back), back_slip)
    elif held and not unit.line and max(forward, back) < hop:
        if back > forward:
            back_slip = _begins_at(unit, back, hop, False)
        vanishes = max(_begins_at(unit, max(forward, back_slip), hop, True), back_slip)
    return CriticalLoads(hop, forward, back, back_slip, vanishes if held else 0.0)


def unknown_loads() -> CriticalLoads:
    """Stand for the critical loads of a body that nothing holds, or whose frictions cannot be."""
    return CriticalLoads(NAN, NAN, NAN, NAN, NAN)


def tipping_load(unit: Loads, stand_ratio: float) -> float:
    """Load up to which no edge of a part lifts that starts from rest, Eq. (43).

    The first of the onsets with the stand ratio in place of mu_s; inf where mu_s is at most that, 0 where the
    trough alone is too steep for the part.
    """
    if not unit.static_friction > stand_ratio:
        return INF
    at = thresholds(unit._replace(static_friction=stand_ratio, kinetic_friction=stand_ratio))
    capacity, t = stand_ratio * unit.weight_normal, unit.weight_tangential
    return min(onset(capacity + t, at.forward_load), onset(capacity - t, at.back_load))


def onset(needed: float, load: float) -> float:
    """Load at which the drive exceeds static friction, Eqs. (5) and (55); 0 where nothing holds the body."""
    if not needed > 0.0:
        return 0.0
    return needed / load if load > 0.0 else INF


def _resistance(unit: Loads) -> float:
    """G k of the forward slide along a line, Eq. (3)."""
    mu_d = unit.kinetic_friction
    drag = mu_d * unit.weight_normal + unit.weight_tangential
    return drag / (unit.drive_tangential + mu_d * unit.drive_normal)


class _Windows(NamedTuple):
    """Onsets of a line, and ``_resistance``."""

    forward: float
    back: float
    resistance: float


def _speed_at_close(at: _Windows, weight: float) -> float:
    """Speed of a line's forward slide where the back window closes, over 1/G, Eq. (22): monotone in 1/G."""
    s_f, s_b = weight * at.forward, min(weight * at.back, 1.0)
    cosines = math.sqrt(max((1.0 - s_f) * (1.0 + s_f), 0.0)) + math.sqrt((1.0 - s_b) * (1.0 + s_b))
    if cosines == 0.0:  # both s are 1 to rounding, at the back onset
        return INF
    gain = weight * (at.back - at.forward) * (at.back + at.forward) / cosines
    return gain - at.resistance * (PI + math.acos(min(s_f, 1.0)) + math.acos(s_b))


def _back_slip_of_line(unit: Loads, forward: float, back: float) -> float:
    """Load from which the forward slide ends before the back window closes; at least the back onset."""
    at, high = _Windows(forward, back, _resistance(unit)), 1.0 / back
    above = _speed_at_close(at, high)
    if not (above > 0.0 and high < INF):
        return back
    return 1.0 / illinois(_speed_at_close, at, 0.0, high, -2.0 * PI * at.resistance, above)


def _continuous_sliding_of_line(unit: Loads, forward: float, back: float) -> float:
    """Load from which a line's cycle without rest is valid, Eq. (21); inf where there is none."""
    mu_d, a, b = unit.kinetic_friction, unit.drive_tangential, unit.drive_normal
    n, t = unit.weight_normal, unit.weight_tangential
    if not mu_d * n > abs(t):
        return INF
    y = QUARTER * ((mu_d * b * n - t / mu_d * a) / unit.weight_across)
    cos_y = math.cos(y) if abs(y) < QUARTER else 0.0
    if cos_y <= 0.0:
        return INF
    middle = _resistance(unit) * (QUARTER + y) / cos_y  # G sin m
    drop = middle * math.sin(y)
    needed = max(forward + drop, back - drop) / cos_y
    return math.sqrt(middle * middle + needed * needed)


def _at_load(unit: Loads, load: float) -> Loads:
    return unit._replace(drive_tangential=load * unit.drive_tangential, drive_normal=load * unit.drive_normal)


def _pair_at(loads: Loads) -> Pair:
    """Both slides of a scene whose load reaches both onsets, but for rounding."""
    at: Thresholds = thresholds(loads)
    ahead, behind = max(at.forward_margin, 0.0), max(at.back_margin, 0.0)
    return pair_of(loads, at._replace(forward_margin=ahead, back_margin=behind))


def _has_begun(unit: Loads, load: float, continuous: bool) -> bool:
    """Whether the forward slide does not outlast the back window, or the cycle is even that without rest."""
    loads = _at_load(unit, load)
    pair = _pair_at(loads)
    if outlasts_back(loads, pair) >= 0:
        return False
    if not continuous:
        return True
    reached = reaches(loads, pair.forward, pair.back, pair.offset) > 0
    return reached and continuous_sliding(loads, pair.forward, pair.back).valid


def _begins_at(unit: Loads, low: float, hop: float, continuous: bool) -> float:
    """Load from which the body slips back, or slides all the time; inf where not before the hop."""
    if not low < hop:
        return INF
    if _has_begun(unit, low, continuous):
        return low
    high = min(hop, _MOST * low)
    if not _has_begun(unit, high, continuous):
        return INF
    for _ in range(_HALVINGS):
        middle = math.sqrt(low) * math.sqrt(high)
        if _has_begun(unit, middle, continuous):
            high = middle
        else:
            low = middle
    return high
