"""Continuous sliding: the cycle of two slides, each of which starts where the other one ends.

Equation numbers are those of docs/theory. Lengths in A, speeds in A w. The middle m of the forward slide
is a phase of the motion along the trough [rad].
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from vibro.core.drives import Loads, phase_difference
from vibro.core.elementary import NAN, PI, QUARTER, rounded_sign
from vibro.core.roots import illinois
from vibro.core.slide import Onset, slide, start_inside
from vibro.core.windows import Start, own_phase, phase_offset

__all__ = [
    "ContinuousSliding",
    "Sliding",
    "continuous_motion",
    "continuous_sliding",
    "half_length_root",
    "is_sure",
    "likely_sliding",
    "middle_phase",
    "multiplier",
    "no_cycle",
]  # fmt: skip

_STEPS: Final = 63  # of Halley's iteration; nearly every scene needs three
_SETTLED: Final = 1e-8  # [1] a last step below this share of 1 - cot m leaves rounding errors only
# [1] tan(beta) / mu_d above which Eq. (61) is solved in place of (60): there y follows cot m so closely that
# a small step is no sign of a root.
_STEEP: Final = 0.8
_SHORTEST: Final = 1e-300  # [rad] half a slide against which the other one meets next to no friction


class ContinuousSliding(NamedTuple):
    """The cycle without rest, Eqs. (18)-(19) and (59)-(61); NaN where there is none.

    Attributes
    ----------
    y, sin_y, cos_y : float
        x - pi/2, where x is half the length of the forward slide.
    sin_m, cos_m : float
        Of pi - m: positive, along a line both.
    valid : bool
        Whether both slides start beyond static friction, or just there.
    edge : bool
        Whether rounding decides that it is valid.
    """

    y: float
    sin_y: float
    cos_y: float
    sin_m: float
    cos_m: float
    valid: bool
    edge: bool


def no_cycle() -> ContinuousSliding:
    """Say that there is no cycle without rest."""
    return ContinuousSliding(NAN, NAN, NAN, NAN, NAN, False, False)


def continuous_sliding(loads: Loads, forward: Start, back: Start) -> ContinuousSliding:
    """Find the cycle without rest of a scene that slips both ways."""
    cycle = likely_sliding(loads, forward.onset, back.onset)
    if not is_sure(loads, cycle):
        cycle = half_length_root(loads, forward.onset, back.onset)
    return cycle


def likely_sliding(loads: Loads, forward: Onset, back: Onset) -> ContinuousSliding:
    """Cheap version of ``continuous_sliding``; for ellipses valid only where ``is_sure``."""
    if loads.line:
        return _of_a_line(loads, forward, back)
    if _is_steep(loads):
        return half_length_root(loads, forward, back)
    if not (loads.drive_tangential > 0.0 and loads.kinetic_friction * loads.weight_normal > 0.0):
        return no_cycle()
    at = _middle_equation(loads)
    return _from_middle(loads, at, _lower_root(at))


def _of_a_line(loads: Loads, forward: Onset, back: Onset) -> ContinuousSliding:
    """Evaluate the closed form of drives along a line, Eqs. (18) and (19)."""
    if not (forward.k > 0.0 and back.k > 0.0 and loads.kinetic_friction > 0.0):
        return no_cycle()
    mu_d, a, b = loads.kinetic_friction, loads.drive_tangential, loads.drive_normal
    turn = mu_d * b * loads.weight_normal
    if loads.weight_tangential != 0.0:
        turn -= loads.weight_tangential / mu_d * a
    y = QUARTER * turn / loads.weight_across
    if not abs(y) < QUARTER:
        return no_cycle()
    sin_y, cos_y = math.sin(y), math.cos(y)
    sin_m = forward.k * (QUARTER + y) / cos_y
    if not sin_m < 1.0:
        return no_cycle()
    cos_m = math.sqrt((1.0 - sin_m) * (1.0 + sin_m))
    rise, fall, scale = cos_m * cos_y, sin_m * sin_y, 1.0 + sin_m
    ahead = rounded_sign(rise - fall - forward.cos, scale)
    behind = rounded_sign(rise + fall - back.cos, scale)
    valid = ahead >= 0 and behind >= 0
    return ContinuousSliding(y, sin_y, cos_y, sin_m, cos_m, valid, valid and (ahead == 0 or behind == 0))


class _Middle(NamedTuple):
    """Eq. (60) over a, as a function of z = cot m.

    R = ``rho_0 + rho_1 z`` is mu_d times the ratio of normal to tangential motion in the middle of the
    slides; ``slope`` is t / (mu_d n), ``capacity`` pi mu_d n / (2 a), ``weight`` t / a.
    """

    rho_0: float
    rho_1: float
    slope: float
    capacity: float
    weight: float


def _middle_equation(loads: Loads) -> _Middle:
    """Form the coefficients of Eq. (60); a, mu_d and n are positive."""
    mu_d, a, t = loads.kinetic_friction, loads.drive_tangential, loads.weight_tangential
    ratio = mu_d * loads.drive_normal / a
    return _Middle(
        rho_0=ratio * loads.phase_cosine,
        rho_1=ratio * loads.phase_sine,
        slope=t / (mu_d * loads.weight_normal) if t != 0.0 else 0.0,
        capacity=QUARTER * mu_d * loads.weight_normal / a,
        weight=t / a,
    )


def _lower_root(at: _Middle) -> float:
    """Find z = cot m of the cycle, the lower root of Eq. (60); NaN where there is none.

    On a level trough its left side is concave and not positive at the start, so that Halley's iteration rises
    to the root, or passes the top of the curve. On an incline it need not be, and a root may be missed.
    """
    least = at.capacity - QUARTER * abs(at.weight)
    if not 0.0 < least < 1.0:  # the drive cannot outweigh the drag
        return NAN
    z = -math.sqrt((1.0 - least) * (1.0 + least)) / least
    if at.rho_1 != 0.0:  # where a slide would take the whole cycle
        z = max(z, (-math.copysign(1.0, at.rho_1) - at.rho_0) / at.rho_1)
    for _ in range(_STEPS):
        rho = at.rho_0 + at.rho_1 * z
        share = 1.0
        y, rate = QUARTER * rho, QUARTER * at.rho_1
        if at.weight != 0.0:
            share = 1.0 - rho * at.slope
            if share == 0.0:
                return NAN
            y = QUARTER * (rho - at.slope) / share
            rate *= (1.0 - at.slope) * (1.0 + at.slope) / (share * share)
        if not abs(y) < 1e3:  # far from any cycle
            return NAN
        sine, cosine = math.sin(y), math.cos(y)
        square = 1.0 + z * z
        root = math.sqrt(square)
        drag = (at.capacity + at.weight * y) * root
        slope = -sine * rate - at.weight * rate * root - drag * z / square
        left = cosine - drag
        # with the sign turned, and without what is of the order of t on inclines
        curve = cosine * rate * rate + drag / (square * square)
        scale = slope * slope + 0.5 * left * curve
        if scale == 0.0:
            return NAN
        step = -left * slope / scale
        z += step
        if not abs(z) < 1e150:
            return NAN
        if abs(step) <= _SETTLED * (1.0 + abs(z)):
            return z if slope > 0.0 else NAN
    return NAN


def _from_middle(loads: Loads, at: _Middle, z: float) -> ContinuousSliding:
    """Form the cycle from z = cot m, where it is one; Eq. (59)."""
    if math.isnan(z):
        return no_cycle()
    rho = at.rho_0 + at.rho_1 * z
    if not abs(rho) < 1.0:
        return no_cycle()
    y = QUARTER * (rho - at.slope) / (1.0 - rho * at.slope)
    sin_m = 1.0 / math.sqrt(1.0 + z * z)
    return _checked(loads, y, math.sin(y), math.cos(y), sin_m, -z * sin_m)


def _checked(
    loads: Loads, y: float, sin_y: float, cos_y: float, sin_m: float, cos_m: float
) -> ContinuousSliding:
    """Tell whether both slides start where the load exceeds static friction, Eq. (62)."""
    a, lift = loads.drive_tangential, loads.static_friction * loads.drive_normal
    capacity, t = loads.static_friction * loads.weight_normal, loads.weight_tangential
    scale = a + lift + capacity
    sine, cosine = _turned(loads, sin_m, cos_m)
    # sines of the motion along the trough and of the normal motion, where each slide starts
    level, tilt = -cos_m * cos_y, sin_m * sin_y
    n_level, n_tilt = cosine * cos_y, sine * sin_y
    ahead = rounded_sign(a * (-level - tilt) + lift * (-n_level - n_tilt) - capacity - t, scale)
    behind = rounded_sign(lift * (n_level - n_tilt) - a * (level - tilt) - capacity + t, scale)
    valid = ahead >= 0 and behind >= 0
    edge = valid and (ahead == 0 or behind == 0)
    return ContinuousSliding(y, sin_y, cos_y, sin_m, cos_m, valid, edge)


def _turned(loads: Loads, sin_m: float, cos_m: float) -> tuple[float, float]:
    """Sine and cosine of m + phi, from those of pi - m."""
    sine = sin_m * loads.phase_cosine - cos_m * loads.phase_sine
    return sine, -cos_m * loads.phase_cosine - sin_m * loads.phase_sine


def _is_steep(loads: Loads) -> bool:
    """Whether the trough is about as steep as kinetic friction holds."""
    return abs(loads.weight_tangential) > _STEEP * loads.kinetic_friction * loads.weight_normal


def is_sure(loads: Loads, cycle: ContinuousSliding) -> bool:
    """Whether ``likely_sliding`` has found the root of Eq. (61), which has but one, or its absence.

    Its root of Eq. (60) is that where the middle of each slide comes after the crest of its load. Where it
    found none there is none on a level trough, since the left side of Eq. (60) is concave there.
    """
    if loads.line or _is_steep(loads):
        return True
    if math.isnan(cycle.y):
        return loads.weight_tangential == 0.0
    _, cosine = _turned(loads, cycle.sin_m, cycle.cos_m)
    lift = loads.kinetic_friction * loads.drive_normal
    return abs(lift * cosine) < loads.drive_tangential * cycle.cos_m


def _arc(sine: float, over: float) -> float:
    """Arc sine of a quotient that rounding may bring above 1."""
    return math.asin(min(max(sine / over, -1.0), 1.0))


class _Slides(NamedTuple):
    """k of both slides, and E of kinetic friction."""

    k: float
    other: float
    offset: float


def _apart(of: _Slides, x: float) -> float:
    """H of Eq. (61), monotone: phase between the middles that either slide has by itself."""
    sine = math.sin(x)
    return _arc(of.k * x, sine) - _arc(of.other * (PI - x), sine) + of.offset


def _longest(k: float) -> float:
    """Half the length of the longest slide, which starts with the load that resists it: sin x = k x."""
    return slide(start_inside(math.acos(k), k, 1.0)).half_length


def half_length_root(loads: Loads, forward: Onset, back: Onset) -> ContinuousSliding:
    """Solve Eq. (61), whose root is the only one.

    The root lies between the lengths at which one of the slides would start with the load that resists it,
    counted as half the length of the slide that is the shorter one where the other hardly ends.
    """
    swapped = back.k > forward.k
    k, other = forward.k, back.k
    offset = phase_offset(loads, loads.kinetic_friction)
    if swapped:
        k, other, offset = other, k, -offset
    if not (other > 0.0 and k < 1.0):
        return no_cycle()
    low, high = max(PI - _longest(other), _SHORTEST), _longest(k)
    if not low < high:
        return no_cycle()
    of = _Slides(k, other, offset)
    below, above = _apart(of, low), _apart(of, high)
    if below > 0.0 or above < 0.0:
        return no_cycle()
    x = illinois(_apart, of, low, high, below, above)
    sine = math.sin(x)
    before, after = _arc(k * x, sine), _arc(other * (PI - x), sine)
    # from the slide whose load is farther from its crest there; m is a phase of the motion along
    own = before <= after
    way = 1.0 if own != swapped else -1.0
    zero = own_phase(loads, way, loads.kinetic_friction) + phase_difference(loads)
    middle = PI - (before if own else after) - zero
    if way < 0.0:  # that of the back slide is half a turn later
        middle -= PI
    y, sin_y = x - QUARTER, -math.cos(x)
    if swapped:
        y, sin_y = -y, -sin_y
    return _checked(loads, y, sin_y, sine, math.sin(middle), -math.cos(middle))


class Sliding(NamedTuple):
    """Motion of a cycle without rest: displacement [A] and peak speed [A w]."""

    displacement: float
    peak: float


def continuous_motion(loads: Loads, forward: Onset, back: Onset, cycle: ContinuousSliding) -> Sliding:
    """Displacement, Eqs. (20) and (63), and peak speed of a cycle without rest.

    Its slides are never short, so that Eq. (14) is used as it stands.
    """
    a, lift = loads.drive_tangential, loads.kinetic_friction * loads.drive_normal
    sin_m, cos_m, sin_y, cos_y = cycle.sin_m, cycle.cos_m, cycle.sin_y, cycle.cos_y
    if loads.line:
        span = (2.0 * lift * cycle.y + PI * a) * sin_y
        displacement = 2.0 * cos_m * (2.0 * lift * cos_y + span)
        c_m, middle, tilt = math.asin(sin_m), sin_m * cos_y, cos_m * sin_y
        ahead = _peak(forward, middle + tilt, c_m + cycle.y)
        behind = _peak(back, middle - tilt, c_m - cycle.y)
        return Sliding(displacement, max(ahead, behind))
    sine, cosine = _turned(loads, sin_m, cos_m)
    displacement = 2.0 * PI * a * cos_m * sin_y - 4.0 * lift * cosine * (cos_y + cycle.y * sin_y)
    # sines and cosines of both motions where the forward slide starts, and where the back slide does
    level, tilt = -cos_m * cos_y, sin_m * sin_y
    n_level, n_tilt = cosine * cos_y, sine * sin_y
    rise, lean = sin_m * cos_y, -cos_m * sin_y
    n_rise, n_lean = sine * cos_y, cosine * sin_y
    rate = a * (rise - lean) + lift * (n_rise - n_lean)
    c = math.atan2(rate, a * (-level - tilt) + lift * (-n_level - n_tilt))
    ahead = _peak(forward, rate / forward.load, c)
    rate = a * (rise + lean) - lift * (n_rise + n_lean)
    c = math.atan2(rate, -a * (level - tilt) + lift * (n_level - n_tilt))
    return Sliding(displacement, max(ahead, _peak(back, rate / back.load, c)))


def multiplier(loads: Loads, cycle: ContinuousSliding) -> float:
    """Return the multiplier of a cycle without rest: what is left of a disturbance after both turns."""
    sine, cosine = _turned(loads, cycle.sin_m, cycle.cos_m)
    a, b, sin_y, cos_y = loads.drive_tangential, loads.drive_normal, cycle.sin_y, cycle.cos_y
    # loads where the forward slide ends, and where the back slide does
    level, tilt = -cycle.cos_m * cos_y, cycle.sin_m * sin_y
    n_level, n_tilt = cosine * cos_y, sine * sin_y
    ahead = _kept(loads, loads.weight_tangential - a * (level - tilt), b * (n_level - n_tilt))
    return ahead * _kept(loads, a * (-level - tilt) - loads.weight_tangential, b * (-n_level - n_tilt))


def _kept(loads: Loads, against: float, lift: float) -> float:
    """Return the ratio of the accelerations after and before a turn, Eq. (26)."""
    friction = loads.kinetic_friction * (loads.weight_normal - lift)
    return (against - friction) / (against + friction)


def _peak(onset: Onset, sine: float, c: float) -> float:
    """Largest speed, Eq. (14), of a slide that starts at pi/2 - c of its own phase."""
    k = min(onset.k, 1.0)
    return onset.load * (sine + math.sqrt((1.0 - k) * (1.0 + k)) - k * (c + math.acos(k)))


def middle_phase(loads: Loads, cycle: ContinuousSliding) -> float:
    """Phase of the normal motion in the middle of the forward slide [rad]."""
    return phase_difference(loads) + PI - math.atan2(cycle.sin_m, cycle.cos_m)
