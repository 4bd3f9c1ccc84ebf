"""The steady cycle of a body on the trough that settles from rest.

The finite rule of theory, section 5, whose equation numbers are cited. Lengths in A, speeds in
A w, phases in radians.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from vibro.core.codes import Model, Pattern, Regime, Status
from vibro.core.continuous import (
    ContinuousSliding,
    continuous_motion,
    half_length_root,
    is_sure,
    likely_sliding,
    multiplier,
    no_cycle,
)
from vibro.core.drives import Loads, mirrored, normal_load, phase_difference
from vibro.core.elementary import INF, NAN, PI, QUARTER, TURN, rounded_sign, wrap, wrap_around
from vibro.core.slide import Onset, slide, start_inside
from vibro.core.windows import (
    Start,
    Thresholds,
    cosine_lead,
    outlasts,
    own_phase,
    phase_offset,
    reaches,
    resting_start,
    speed_at_close,
)

__all__ = [
    "Pair", "Steady", "outlasts_back", "pair_of", "ratio_of", "regime_alone", "steady_cycle",
    "unanswered", "without_cycle",
]  # fmt: skip

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

    ``offset`` is E of static friction, Eq. (57); ``lead`` and ``lead_size`` are those of ``cosine_lead``
    along a line.
    """

    forward: Start
    back: Start
    offset: float
    lead: float
    lead_size: float


def pair_of(loads: Loads, at: Thresholds) -> Pair:
    """Solve where both slides from rest start."""
    forward, back = resting_start(loads, at, 1.0), resting_start(loads, at, -1.0)
    if loads.line:
        lead, size = cosine_lead(loads, at, forward.onset, back.onset)
        return Pair(forward, back, 0.0, lead, size)
    return Pair(forward, back, phase_offset(loads, loads.static_friction), NAN, NAN)


def _mirrored_pair(pair: Pair) -> Pair:
    return Pair(pair.back, pair.forward, -pair.offset, -pair.lead, pair.lead_size)


def outlasts_back(loads: Loads, pair: Pair) -> int:
    """Whether the forward slide still moves (+1) where the back window closes; 0: rounding decides."""
    if loads.line:
        return outlasts(pair.forward, pair.back, 0.0, pair.lead, pair.lead_size)
    ahead, size = speed_at_close(pair.forward, pair.back)
    return outlasts(pair.forward, pair.back, pair.offset, ahead, size)


def _outlasts_forward(loads: Loads, pair: Pair) -> int:
    """Whether the back slide still moves (+1) where the forward window closes; 0: rounding decides."""
    if loads.line:
        return outlasts(pair.back, pair.forward, 0.0, -pair.lead, pair.lead_size)
    ahead, size = speed_at_close(pair.back, pair.forward)
    return outlasts(pair.back, pair.forward, -pair.offset, ahead, size)


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
        lasts = outlasts_back(loads, pair_of(loads, at))
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
    if loads.static_friction == 0.0:
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
        motion = continuous_motion(loads, pair.forward.onset, pair.back.onset, cycle)
        return _Cycle(
            Pattern.FB, motion.displacement, motion.peak, True, cycle.edge, cycle.valid,
            multiplier(loads, cycle),
        )  # fmt: skip
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
    """Cycle of a body whose first slide goes forward from rest.

    The sign of the speed at the edges of the opposite window decides the pattern; only a slide that follows
    another one directly needs its end for that. Equality belongs to rest: a slide that stops just where the
    opposite window closes stays at rest.
    """
    forward, back = pair.forward.onset, pair.back.onset
    f_lasts, f_meets = outlasts_back(loads, pair), reaches(loads, pair.forward, pair.back, pair.offset)
    b_lasts = _outlasts_forward(loads, pair)
    f_only = f_lasts >= 0
    meets = f_meets > 0 and not f_only  # ends inside the back window
    edge = f_lasts == 0 or (f_meets == 0 and not f_only)
    cycle = no_cycle()
    if meets or f_only:
        cycle = likely_sliding(loads, forward, back)
    if meets and cycle.valid:
        return _sliding_on(loads, pair, cycle, b_lasts, edge)
    f = slide(forward)
    if f_only:
        if not is_sure(loads, cycle):
            cycle = half_length_root(loads, forward, back)
        other = cycle.valid or _settles_in_f_b(loads, pair, b_lasts)
        return _Cycle(Pattern.F_, f.displacement, f.peak, other, f_lasts == 0, f.settled, 0.0)
    if meets:
        turn = phase_offset(loads, loads.kinetic_friction)
        c = PI + forward.c - 2.0 * f.half_length + turn
        b = slide(start_inside(c, back.k, back.load))
        # phase from the end of that back slide to p_f + 2 pi; without kinetic friction always 0
        rests = rounded_sign(PI - forward.c + c - 2.0 * b.half_length - turn, TURN)
        edge = edge or cycle.edge or rests == 0
        if rests >= 0:
            return _Cycle(
                Pattern.FB_, f.displacement - b.displacement, max(f.peak, b.peak), b_lasts > 0, edge,
                f.settled and b.settled, 0.0,
            )  # fmt: skip
        if not is_sure(loads, cycle):
            cycle = half_length_root(loads, forward, back)
            if cycle.valid:
                return _sliding_on(loads, pair, cycle, b_lasts, edge)
    b = slide(back)
    b_meets = reaches(loads, pair.back, pair.forward, -pair.offset)
    edge = edge or b_meets == 0 or b_lasts == 0
    if b_lasts >= 0:
        return _Cycle(Pattern.B_, -b.displacement, b.peak, False, edge, b.settled, 0.0)
    pattern = int(Pattern.F_B_)
    if b_meets > 0:
        pattern = int(Pattern.F_B)
        c = PI + back.c - 2.0 * b.half_length - phase_offset(loads, loads.kinetic_friction)
        f = slide(start_inside(c, forward.k, forward.load))
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
