"""The steady cycle of a body on the trough that settles from rest.

The finite rule of theory, section 5, whose equation numbers are cited. Lengths in A, speeds in
A w, phases in radians.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from vibro.core.codes import Model, Pattern, Regime, Status
from vibro.core.drive import Loads, mirrored, normal_load, phase_difference
from vibro.core.numbers import (
    INF,
    NAN,
    PI,
    QUARTER,
    TURN,
    illinois,
    rounded_sign,
    wrap,
    wrap_around,
)
from vibro.core.slides import (
    Onset,
    Start,
    Thresholds,
    cosine_lead,
    no_start,
    outlasts,
    own_phase,
    phase_offset,
    reaches,
    resting_start,
    slide,
    speed_at_close,
    start_inside,
    thresholds,
)

# ------------------------------------------------------------------------------
# Continuous sliding: the cycle of two slides, each of which starts where the other one ends.
#
# Equation numbers are those of docs/theory. Lengths in A, speeds in A w. The middle m of the forward slide is
# a phase of the motion along the trough [rad].

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


class _Sliding(NamedTuple):
    """Motion of a cycle without rest: displacement [A] and peak speed [A w]."""

    displacement: float
    peak: float


def continuous_motion(loads: Loads, forward: Onset, back: Onset, cycle: ContinuousSliding) -> _Sliding:
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
        return _Sliding(displacement, max(ahead, behind))
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
    return _Sliding(displacement, max(ahead, _peak(back, rate / back.load, c)))


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


_MOST_SLIDES: Final = 1000  # without a rest, where there is no cycle without rest to come to


class Steady(NamedTuple):
    """Steady motion of one scene.

    Attributes
    ----------
    regime, status, pattern, model : int
        Codes of ``Regime``, ``Status``, ``Pattern`` and ``Model``.
    displacement : float
        Per drive cycle [A]; NaN without an answer.
    peak : float
        Largest relative speed [A w]; NaN without an answer.
    coexists : int
        1 where a disturbed body can settle elsewhere or run away, 0 where it cannot, -1 without an answer.
    multiplier : float
        Of the cycle, Eq. (71): 0 where it rests; NaN without an answer.
    """

    regime: int
    status: int
    pattern: int
    model: int
    displacement: float
    peak: float
    coexists: int
    multiplier: float


class _Cycle(NamedTuple):
    """A cycle of a scene that slips: ``edge`` says that rounding decided its pattern."""

    pattern: int
    displacement: float
    peak: float
    coexists: bool
    edge: bool
    settled: bool
    multiplier: float


class Pair(NamedTuple):
    """Both slides from rest of a scene that slips both ways, and what decides whether one outlasts.

    ``offset`` is E of static friction, Eq. (57); ``ahead`` and ``ahead_size`` are the speed, over C, that the
    load alone would leave the forward slide where the back window closes, and the size of what cancels in it;
    ``behind`` and ``behind_size`` those of the back slide.
    """

    forward: Start
    back: Start
    offset: float
    ahead: float
    ahead_size: float
    behind: float
    behind_size: float


def pair_of(loads: Loads, at: Thresholds) -> Pair:
    """Solve where both slides from rest start."""
    forward, back = resting_start(loads, at, 1.0), resting_start(loads, at, -1.0)
    if loads.line:
        lead, size = cosine_lead(loads, at, forward.onset, back.onset)
        return Pair(forward, back, 0.0, lead, size, -lead, size)
    ahead, ahead_size = speed_at_close(forward, back)
    behind, behind_size = speed_at_close(back, forward)
    offset = phase_offset(loads, loads.static_friction)
    return Pair(forward, back, offset, ahead, ahead_size, behind, behind_size)


def _mirrored_pair(pair: Pair) -> Pair:
    """See both slides from the other side."""
    return Pair(
        pair.back, pair.forward, -pair.offset, pair.behind, pair.behind_size, pair.ahead, pair.ahead_size
    )


def outlasts_back(pair: Pair) -> int:
    """Whether the forward slide still moves (+1) where the back window closes; 0: rounding decides."""
    return outlasts(pair.forward, pair.back, pair.offset, pair.ahead, pair.ahead_size)


def ratio_of(load: float, needed: float) -> float:
    """Load over its threshold; where nothing holds the body, any load makes it slip."""
    if needed > 0.0:
        return load / needed
    return INF if load > 0.0 else 0.0


def steady_cycle(loads: Loads, at: Thresholds) -> Steady:
    """Solve the steady cycle from rest of a scene; one that hops is left to the flight model."""
    none = without_cycle(loads, at)
    if none.status != Status.OK:
        return none
    status = int(Status.BOUNDARY) if at.edge else int(Status.OK)
    # where gravity along the trough exceeds kinetic friction a pushed body may slide on for ever
    loose = abs(loads.weight_tangential) > loads.kinetic_friction * loads.weight_normal
    if not (at.forward or at.back):
        return Steady(Regime.NO_SLIP, status, Pattern.R, Model.REST, 0.0, 0.0, int(loose), 0.0)
    if not at.back:
        cycle = _one_way(resting_start(loads, at, 1.0).onset, 1.0, Pattern.F_)
    elif not at.forward:
        cycle = _one_way(resting_start(loads, at, -1.0).onset, -1.0, Pattern.B_)
    else:
        cycle = _two_way(loads, at)
    regime = int(Regime.FORWARD_SLIP) if cycle.pattern == Pattern.F_ else int(Regime.BACK_SLIP)
    if not cycle.settled:
        return unanswered(regime, Status.UNRESOLVED)
    if math.isnan(cycle.displacement):
        return unanswered(regime, Status.RUNAWAY)
    if cycle.edge:
        status = int(Status.BOUNDARY)
    return Steady(
        regime, status, cycle.pattern, _model_of(cycle.pattern), cycle.displacement, cycle.peak,
        int(cycle.coexists or loose), cycle.multiplier,
    )  # fmt: skip


def regime_alone(loads: Loads, at: Thresholds) -> Steady:
    """Classify a scene without solving a slide, but where the trough is steep: numbers are NaN.

    A scene that slips both ways slips back in its steady cycle unless its forward slide outlasts the back
    window. Only where the trough is steeper than the angle of kinetic friction may a slide never end.
    """
    steep = abs(loads.weight_tangential) >= loads.kinetic_friction * loads.weight_normal
    if not (at.forward or at.back) or at.hops or at.unheld or steep:
        full = steady_cycle(loads, at)
        if full.regime == Regime.FORWARD_SLIP or full.regime == Regime.BACK_SLIP:
            return unanswered(full.regime, full.status)
        return full
    none = without_cycle(loads, at)
    if none.status != Status.OK:
        return none
    back, edge = at.back, at.edge
    if at.forward and at.back:
        lasts = outlasts_back(pair_of(loads, at))
        back, edge = lasts < 0, edge or lasts == 0
    regime = int(Regime.BACK_SLIP) if back else int(Regime.FORWARD_SLIP)
    return unanswered(regime, Status.BOUNDARY if edge else Status.OK)


def unanswered(regime: int, status: int) -> Steady:
    """Form the answer of a scene without numbers."""
    return Steady(regime, status, Pattern.NONE, Model.NONE, NAN, NAN, -1, NAN)


def without_cycle(loads: Loads, at: Thresholds) -> Steady:
    """Say why a scene has no steady contact cycle; with the status OK if it may have one."""
    if loads.kinetic_friction > loads.static_friction:
        return unanswered(Regime.UNDEFINED, Status.INFEASIBLE)
    if at.hops:
        return unanswered(Regime.HOPPING, Status.FLIGHT_NOT_MODELLED)
    if loads.static_friction == 0.0 and loads.weight_tangential == 0.0:
        return unanswered(Regime.UNDEFINED, Status.INDETERMINATE)
    if at.unheld:
        downhill = Regime.BACK_SLIP if loads.weight_tangential > 0.0 else Regime.FORWARD_SLIP
        return unanswered(downhill, Status.RUNAWAY)
    return unanswered(Regime.UNDEFINED, Status.OK)


def _model_of(pattern: int) -> int:
    if pattern == Pattern.F_ or pattern == Pattern.B_:
        return Model.ONE_SLIDE
    return Model.CLOSED_FORM if pattern == Pattern.FB else Model.TWO_SLIDES


def _one_way(onset: Onset, way: float, pattern: int) -> _Cycle:
    """Cycle of a scene that slips one way only: one slide."""
    end = slide(onset)
    return _Cycle(pattern, way * end.displacement, end.peak, False, False, end.settled, 0.0)


def _two_way(loads: Loads, at: Thresholds) -> _Cycle:
    """Cycle from rest of a scene whose load exceeds static friction both ways."""
    pair = pair_of(loads, at)
    out = _forward_first(loads, pair)
    if loads.line or loads.weight_tangential == 0.0 or not (out.coexists or math.isnan(out.displacement)):
        return out
    # On an incline phase 0 may lie in a window, or the back window may come first: it matters where cycles
    # coexist.
    way = _first_from_rest(loads, pair)
    if way < 0:
        seen = _forward_first(mirrored(loads), _mirrored_pair(pair))
        return seen._replace(pattern=_mirrored_pattern(seen.pattern), displacement=-seen.displacement)
    if way == 0:
        cycle = half_length_root(loads, pair.forward.onset, pair.back.onset)
        if math.isnan(out.displacement) and not cycle.valid:
            return out  # it runs away, if slowly
        return _sliding_on(loads, pair, cycle, 1, False)._replace(settled=cycle.valid)
    return out


def _mirrored_pattern(pattern: int) -> int:
    """Name the pattern of a cycle that is seen from the other side."""
    if pattern == Pattern.F_:
        return Pattern.B_
    if pattern == Pattern.B_:
        return Pattern.F_
    if pattern == Pattern.FB_:
        return Pattern.F_B
    return Pattern.FB_ if pattern == Pattern.F_B else pattern


def _forward_first(loads: Loads, pair: Pair) -> _Cycle:
    """Cycle of a body whose first slide goes forward from rest: the rule of theory, section 5.

    F is the slide from the forward onset, B one back. Signs of v_close and v_open, Eqs. (17) and (58), decide
    all but where F, and a B that follows it directly, end. Equality belongs to rest.
    """
    forward, back = pair.forward.onset, pair.back.onset
    f_lasts, b_lasts = outlasts_back(pair), outlasts_back(_mirrored_pair(pair))  # v_close
    if f_lasts >= 0:  # step 1: F outlasts the back window
        f = slide(forward)
        other = continuous_sliding(loads, pair.forward, pair.back).valid
        other = other or _settles_in_f_b(loads, pair, b_lasts)
        return _Cycle(Pattern.F_, f.displacement, f.peak, other, f_lasts == 0, f.settled, 0.0)
    f_meets = reaches(loads, pair.forward, pair.back, pair.offset)  # v_open
    if f_meets <= 0:  # step 2: F ends before the back window
        return _back_from_rest(loads, pair, b_lasts, f_meets == 0)
    cycle = likely_sliding(loads, forward, back)  # step 3: F ends inside it
    if cycle.valid:
        return _sliding_on(loads, pair, cycle, b_lasts, False)
    f = slide(forward)
    # B begins where F ends, p_f + 2 x, which is pi + E_d less in its own phase
    turn = phase_offset(loads, loads.kinetic_friction)
    c = PI + forward.c - 2.0 * f.half_length + turn
    b = slide(start_inside(c, back.k, back.load))
    # phase from the end of B to p_f + 2 pi; without kinetic friction always 0
    rests = rounded_sign(PI - forward.c + c - 2.0 * b.half_length - turn, TURN)
    edge = cycle.edge or rests == 0
    if rests >= 0:
        return _Cycle(
            Pattern.FB_, f.displacement - b.displacement, max(f.peak, b.peak), b_lasts > 0, edge,
            f.settled and b.settled, 0.0,
        )  # fmt: skip
    if not is_sure(loads, cycle):
        cycle = half_length_root(loads, forward, back)
        if cycle.valid:
            return _sliding_on(loads, pair, cycle, b_lasts, edge)
    return _back_from_rest(loads, pair, b_lasts, edge)


def _back_from_rest(loads: Loads, pair: Pair, b_lasts: int, edge: bool) -> _Cycle:
    """Cycle of a body whose back slide B begins at its onset: steps 2 and 3 of the rule."""
    forward, back = pair.forward.onset, pair.back.onset
    b = slide(back)
    b_meets = reaches(loads, pair.back, pair.forward, -pair.offset)  # v_open
    edge = edge or b_meets == 0 or b_lasts == 0
    if b_lasts >= 0:
        return _Cycle(Pattern.B_, -b.displacement, b.peak, False, edge, b.settled, 0.0)
    pattern, onset = int(Pattern.F_B_), forward
    if b_meets > 0:  # F begins where B ends, pi - E_d less in its own phase
        c = PI + back.c - 2.0 * b.half_length - phase_offset(loads, loads.kinetic_friction)
        pattern, onset = int(Pattern.F_B), start_inside(c, forward.k, forward.load)
    f = slide(onset)
    displacement, peak = f.displacement - b.displacement, max(f.peak, b.peak)
    return _Cycle(pattern, displacement, peak, False, edge, f.settled and b.settled, 0.0)


def _sliding_on(loads: Loads, pair: Pair, cycle: ContinuousSliding, b_lasts: int, edge: bool) -> _Cycle:
    """Form the cycle without rest."""
    motion = continuous_motion(loads, pair.forward.onset, pair.back.onset, cycle)
    return _Cycle(
        Pattern.FB, motion.displacement, motion.peak, b_lasts > 0, edge or cycle.edge, True,
        multiplier(loads, cycle),
    )  # fmt: skip


def _settles_in_f_b(loads: Loads, pair: Pair, b_lasts: int) -> bool:
    """Whether a disturbed body can settle in F_B: the slide after its back slide ends before the next one.

    Without kinetic friction other cycles are a neutral family: none attracts.
    """
    forward, back = pair.forward.onset, pair.back.onset
    if b_lasts >= 0 or not forward.k > 0.0:
        return False
    if reaches(loads, pair.back, pair.forward, -pair.offset) <= 0:
        return False
    turn = phase_offset(loads, loads.kinetic_friction)
    c = PI + back.c - 2.0 * slide(back).half_length - turn
    x = slide(start_inside(c, forward.k, forward.load)).half_length
    return 2.0 * x - c + back.c - turn < PI


def _first_from_rest(loads: Loads, pair: Pair) -> int:
    """Follow a body from its release at phase 0 to its first slide that begins with a rest.

    Returns +1 where that slide goes forward, -1 where it goes back, and 0 where there is none: the body never
    rests again.
    """
    phase = phase_difference(loads)
    mu_s, mu_d, t = loads.static_friction, loads.kinetic_friction, loads.weight_tangential
    if abs(t) <= mu_s * normal_load(loads, phase):
        f_wait = wrap(QUARTER - own_phase(loads, 1.0, mu_s) - pair.forward.window - phase)
        b_wait = wrap(QUARTER - own_phase(loads, -1.0, mu_s) - pair.back.window - phase)
        return 1 if f_wait <= b_wait else -1
    # Where there is a cycle without rest, starts draw near it from one side, and each slide ends between that
    # of the cycle and the one before it: after two slides without a rest there is none.
    draws = half_length_root(loads, pair.forward.onset, pair.back.onset).valid
    way = 1.0 if t < 0.0 else -1.0
    turn = phase_offset(loads, mu_d)
    c = wrap_around(QUARTER - phase - own_phase(loads, way, mu_d))
    for count in range(_MOST_SLIDES):
        own, other = (pair.forward, pair.back) if way > 0.0 else (pair.back, pair.forward)
        x = slide(start_inside(c, own.onset.k, own.onset.load)).half_length
        end = QUARTER - c + 2.0 * x  # in the slide's own phase
        middle = 1.5 * PI + way * pair.offset - (own.onset.c - own.window)  # of the opposite window
        if end <= middle - other.window:
            return -1 if way > 0.0 else 1
        if end >= middle + other.window:
            return 1 if way > 0.0 else -1
        if draws and count > 0:
            return 0
        c = PI + c - 2.0 * x + way * turn
        way = -way
    return 0


# ------------------------------------------------------------------------------
# The slides of a steady contact cycle whose pattern is known, one after the other.
#
# Lengths in A, speeds in A w, phases in radians.

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
    return SlideLeg(0.0, False, no_start(), NAN, NAN, NAN, NAN)


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


# ------------------------------------------------------------------------------
# How the displacement of a steady contact cycle follows the load G, in closed form.
#
# Equation numbers are those of docs/theory. A dot is d / d ln G: n and t are proportional to 1/G, so that
# k. = -k and s. = -s, and nothing else changes. Lengths in A, phases in radians.


class _Response(NamedTuple):
    """How a slide follows ln G.

    Its end moves by ``end`` plus ``end_gain`` times the shift of its start [rad], its displacement changes by
    ``path`` plus ``path_gain`` times that [A].
    """

    end: float
    end_gain: float
    path: float
    path_gain: float


def load_slope(loads: Loads, pattern: int) -> float:
    """Differentiate the displacement with respect to ln G, Eqs. (45)-(48) and (64).

    Within its pattern: 0 at rest, NaN where there is no steady contact cycle of up to two slides. Just above
    an onset it grows without bound, like 1 over the root of the distance.
    """
    if pattern == Pattern.R:
        return 0.0
    slides = cycle_slides(loads, pattern)
    first, second = slides.first, slides.second
    if first.way == 0.0 or math.isnan(first.displacement):
        return NAN
    one = _respond(first)
    if second.way == 0.0:
        return one.path + one.path_gain * _start_shift(first)
    if math.isnan(second.displacement):
        return NAN
    two = _respond(second)
    if first.from_rest:
        one_shift = _start_shift(first)
        two_shift = _start_shift(second) if second.from_rest else one.end + one.end_gain * one_shift
    elif second.from_rest:
        two_shift = _start_shift(second)
        one_shift = two.end + two.end_gain * two_shift
    else:  # continuous sliding: both starts follow each other, Eq. (64)
        closing = _closing(loads, first, second)
        if closing == 0.0:  # next to no friction: any cycle closes
            return NAN
        one_shift = (two.end + two.end_gain * one.end) / closing
        two_shift = one.end + one.end_gain * one_shift
    return one.path + one.path_gain * one_shift + two.path + two.path_gain * two_shift


def _start_shift(leg: SlideLeg) -> float:
    """Rate of the phase at which a slide starts from rest: s. / sin c_s = -cot c_s, Eq. (48)."""
    return -1.0 / math.tan(leg.start.window)


def _respond(leg: SlideLeg) -> _Response:
    """Differentiate a slide, Eqs. (45) and (46)."""
    onset = leg.start.onset
    x = 0.5 * (leg.end - leg.begin)
    braking = 2.0 * math.sin(x - onset.c) * math.sin(x) - onset.excess  # k - sin p1
    if braking == 0.0:  # friction and load balance where it ends, which then has no derivative
        return _Response(NAN, NAN, NAN, NAN)
    lost = 2.0 * x * onset.load * leg.way
    end = 2.0 * x * onset.k / braking
    return _Response(end, -onset.excess / braking, lost * x * onset.k, -lost * onset.excess)


def _closing(loads: Loads, first: SlideLeg, second: SlideLeg) -> float:
    """1 - T' of continuous sliding, section 5, from terms of one sign.

    At each turn the load along the trough is common to both slides, and friction changes its sign.
    """
    phi = phase_difference(loads)
    own = first.start.onset.load * first.start.onset.excess
    other = second.start.onset.load * second.start.onset.excess
    before = 2.0 * loads.kinetic_friction * normal_load(loads, first.begin + phi)
    between = 2.0 * loads.kinetic_friction * normal_load(loads, second.begin + phi)
    if own + before == 0.0 or other + between == 0.0:
        return 0.0
    return before / (own + before) + between / (other + between) * (own / (own + before))
