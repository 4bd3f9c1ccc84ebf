"""Where a scene changes class as the load grows: the critical G = A w^2 / g of each transition.

Equation numbers are those of docs/theory. All functions take the loads of a scene at G = 1.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from vibro.core.contact import Pair, continuous_sliding, outlasts_back, pair_of
from vibro.core.drive import Loads
from vibro.core.numbers import CLASSES, EPS, INF, NAN, PI, QUARTER, Doubles, Integers, illinois
from vibro.core.slides import Thresholds, reaches, thresholds, thresholds_of
from vibro.core.wave_cycle import Classes, wave_classes

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
        return _unknown_loads()
    at = thresholds(unit)
    capacity, t = unit.static_friction * unit.weight_normal, unit.weight_tangential
    hop = unit.weight_normal / unit.drive_normal if unit.drive_normal > 0.0 else INF
    forward, back = _onset(capacity + t, at.forward_load), _onset(capacity - t, at.back_load)
    held = abs(t) < capacity
    back_slip, vanishes = back, INF
    if unit.line:
        if unit.drive_tangential <= unit.static_friction * unit.drive_normal:
            back, back_slip = INF, INF  # the drive presses the body down more than it pushes it back, Eq. (7)
        braked = unit.kinetic_friction * unit.weight_normal + t > 0.0
        if held and forward < back < INF:
            back_slip = _back_slip_of_line(unit, forward, back) if braked else INF
        if held and braked and back < INF:
            vanishes = max(_continuous_sliding_of_line(unit, forward, back), back_slip)
    elif held and max(forward, back) < hop:
        if back > forward:
            back_slip = _begins_at(unit, back, hop, False)
        vanishes = max(_begins_at(unit, max(forward, back_slip), hop, True), back_slip)
    return CriticalLoads(hop, forward, back, back_slip, vanishes if held else 0.0)


def _unknown_loads() -> CriticalLoads:
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
    return min(_onset(capacity + t, at.forward_load), _onset(capacity - t, at.back_load))


def _onset(needed: float, load: float) -> float:
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
    if outlasts_back(pair) >= 0:
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


# ------------------------------------------------------------------------------
# At which scales of the whole motion a drive beyond one harmonic has each class of steady contact cycle.
#
# All amplitudes grow alike, so that the waves stay and the weights fall. Classes come and go: they have
# intervals, which are sought between the first onset and the hop on ``_SCALES`` scales. Equation numbers are
# those of docs/theory.

#: [1] Steps between the first onset and the hop in which a change of the cycle is looked for.
_SCALES: Final = 256

# [1] Scale over that of the first onset up to which drives are looked at that never make bodies hop.
_MOST_SCALE: Final = 1e6
# [1] Behind an onset rounding leaves open whether the body slips.
_NEAR: Final = 1e-12
# [1] Relative width to which a change of pattern is enclosed that leaves all classes as they are.
_COARSE: Final = 1e-5
_FINE: Final = 4.0 * EPS  # [1] the same of a class that begins or ends
_HALVINGS_OF_SCALES: Final = 80  # of a step; the longest takes 58
# [1] A step is halved, down to this relative width, where what the pattern has to spare falls so fast that it
# would be lost in the step: there may be another pattern amid it.
_FINEST: Final = 1e-4
_MOST_HALVED: Final = 1_000  # steps in place of one
_MOST_CHANGES: Final = 1_000  # of the pattern; the most that were met are 40


class _Scaled(NamedTuple):
    """A scene, its thresholds at scale 1, both onsets, the range to look at, and the hop.

    ``later`` is just above the later onset. Where kinetic friction holds gravity a body that slips one way
    alone stops in every turn: between both onsets it has one class, and ``begin`` is ``later``.
    """

    loads: Loads
    at: Thresholds
    forward: float
    back: float
    later: float
    low: float
    begin: float
    high: float
    hop: float


class _Stretch(NamedTuple):
    """Scales with one pattern: where they begin, the next one to look at, and the legs of the cycle."""

    scale: float
    step: int
    classes: Classes


def _scaled(loads: Loads) -> _Scaled:
    """Find the scales of both onsets and of the hop, Eqs. (4) and (5), from the largest loads."""
    at = thresholds(loads)
    capacity, t = loads.static_friction * loads.weight_normal, loads.weight_tangential
    hop = loads.weight_normal / loads.drive_normal if loads.drive_normal > 0.0 else INF
    forward, back = _onset(capacity + t, at.forward_load), _onset(capacity - t, at.back_load)
    low = min(forward, back)
    high = min(hop, _MOST_SCALE * low) if low < INF else low
    later = max(forward, back) * (1.0 + _NEAR)
    held = loads.kinetic_friction * loads.weight_normal > abs(loads.weight_tangential)
    return _Scaled(loads, at, forward, back, later, low, later if held else low, high, hop)


def _classes_at(scaled: _Scaled, scale: float) -> Classes:
    """Solve the steady cycle of a motion that is so many times as large."""
    loads = scaled.loads
    loads = loads._replace(
        weight_normal=loads.weight_normal / scale, weight_tangential=loads.weight_tangential / scale
    )
    return wave_classes(loads, thresholds_of(loads, scaled.at.forward_load, scaled.at.back_load))


def _scale_at(scaled: _Scaled, index: int) -> float:
    """Return one of the scales to look at: closer to each other next to the onset, and to the hop."""
    if index >= _SCALES:
        return scaled.high
    share = 0.5 - 0.5 * math.cos(PI * index / _SCALES)
    return scaled.begin * math.exp(share * math.log(scaled.high / scaled.begin))


def _first(scaled: _Scaled) -> _Stretch:
    """Begin just above the first onset."""
    return _Stretch(scaled.low, 1, _classes_at(scaled, min(scaled.low * (1.0 + _NEAR), scaled.high)))


def _next(scaled: _Scaled, here: _Stretch) -> _Stretch:
    """Find the next scale from which on the pattern is another one; inf if there is none."""
    low = here.scale
    if low < scaled.begin:
        if not scaled.begin < scaled.high:
            return _Stretch(INF, _SCALES, here.classes)
        return _Stretch(scaled.begin, 1, _classes_at(scaled, scaled.begin))
    before, spare, earlier = 0.0, here.classes.spare, 0.0
    for index in range(here.step, _SCALES + 1):
        high = _scale_at(scaled, index)
        if low < scaled.later < high:
            then = _classes_at(scaled, scaled.later)
            if not _is_same(then, here.classes):
                return _enclosed(scaled, here, index, low, scaled.later, then)
            low = scaled.later
        for _ in range(_MOST_HALVED):
            if not high > low:
                break
            then = _classes_at(scaled, high)
            if not _is_same(then, here.classes):
                return _enclosed(scaled, here, index, low, high, then)
            falls = (before - spare) / (low - earlier)
            if high > low * (1.0 + _FINEST) and falls * (high - low) > spare:
                high = 0.5 * (low + high)
                continue
            before, spare, earlier, low, high = spare, then.spare, low, high, _scale_at(scaled, index)
    return _Stretch(INF, _SCALES, here.classes)


def _enclosed(
    scaled: _Scaled, here: _Stretch, index: int, low: float, high: float, then: Classes
) -> _Stretch:
    """Halve a step until it ends just behind the first change of the pattern that is met in it."""
    for _ in range(_HALVINGS_OF_SCALES):
        middle = 0.5 * (low + high)
        if high - low <= (_COARSE if _alike(here.classes, then) else _FINE) * high or not low < middle < high:
            break
        amid = _classes_at(scaled, middle)
        if _is_same(amid, here.classes):
            low = middle
        else:
            high, then = middle, amid
    return _Stretch(high, index, then)


def _is_same(a: Classes, b: Classes) -> bool:
    """Return whether two cycles have one pattern; marks of long ones might agree by chance."""
    return a.pattern == b.pattern and _alike(a, b)


def _alike(a: Classes, b: Classes) -> bool:
    return a.forward == b.forward and a.back == b.back and a.rest == b.rest


def wave_limits(loads: Loads) -> CriticalLoads:
    """Find the first scale of every class, where this scene has the scale 1.

    NaN where mu_d > mu_s or mu_s = 0, and for classes that have not begun where a cycle is unresolved.
    """
    if loads.kinetic_friction > loads.static_friction or loads.static_friction == 0.0:
        return _unknown_loads()
    scaled = _scaled(loads)
    back_slip, vanishes = INF, INF
    if scaled.low == 0.0:  # nothing holds the body, which runs down the trough
        return CriticalLoads(
            scaled.hop, scaled.forward, scaled.back, 0.0 if loads.weight_tangential > 0.0 else INF, 0.0
        )
    here = _first(scaled)
    for _ in range(_MOST_CHANGES):
        if not here.scale < scaled.high:
            break
        begins, classes = _told(scaled, here.scale), here.classes
        unresolved = classes.pattern == 0
        if back_slip == INF and (classes.back or unresolved):
            back_slip = NAN if unresolved else begins
        if vanishes == INF and not classes.rest:
            vanishes = NAN if unresolved else begins
        if back_slip != INF and vanishes != INF:
            break
        here = _next(scaled, here)
    return CriticalLoads(scaled.hop, scaled.forward, scaled.back, back_slip, vanishes)


def write_spans(loads: Loads, out: Doubles, counts: Integers, room: int) -> None:
    """List the intervals of the scale in which each class holds, where this scene has the scale 1.

    Parameters
    ----------
    loads : Loads
        Of the scene.
    out : Doubles
        For each of the ``CLASSES`` room for so many pairs of scales; then the scales of the hop and of both
        onsets, forward first.
    counts : Integers
        For each class the number of intervals, which may exceed the room, and then whether one is open; last
        the number of stretches with an unresolved cycle.
    room : int
        Pairs.
    """
    for i in range(2 * CLASSES + 1):
        counts[i] = 0
    closed = 2 * CLASSES * room
    if loads.kinetic_friction > loads.static_friction or loads.static_friction == 0.0:
        for i in range(3):
            out[closed + i] = NAN
        return
    scaled = _scaled(loads)
    end = scaled.hop
    out[closed], out[closed + 1], out[closed + 2] = end, scaled.forward, scaled.back
    if scaled.low == 0.0:
        forward = loads.weight_tangential <= 0.0
        _mark(Classes(1, forward, not forward, rest=False, spare=INF), 0.0, out, counts, room)
    else:
        here = _first(scaled)
        for _ in range(_MOST_CHANGES):
            if not here.scale < scaled.high:
                break
            _mark(here.classes, _told(scaled, here.scale), out, counts, room)
            here = _next(scaled, here)
    _mark(Classes(1, forward=False, back=False, rest=True, spare=INF), end, out, counts, room)


def _told(scaled: _Scaled, scale: float) -> float:
    """Replace a scale by the onset that it is but for rounding."""
    for i in range(2):
        closed = scaled.forward if i == 0 else scaled.back
        if abs(scale - closed) <= 2.0 * _NEAR * closed:
            return closed
    return scale


def _mark(classes: Classes, scale: float, out: Doubles, counts: Integers, room: int) -> None:
    """Begin and end intervals where the cycle has other classes; one that is unresolved changes none."""
    if classes.pattern == 0:
        counts[2 * CLASSES] += 1
        return
    for row in range(CLASSES):
        holds = not classes.rest
        if row < 2:
            holds = classes.forward if row == 0 else classes.back
        count = counts[row]
        last = 2 * (row * room + count - 1)
        if holds and counts[CLASSES + row] == 0:
            counts[CLASSES + row] = 1
            # rounding alone may part two intervals
            if 0 < count <= room and scale <= out[last + 1] * (1.0 + _NEAR):
                continue
            if count < room:
                out[last + 2] = scale
            counts[row] = count + 1
        elif not holds and counts[CLASSES + row] == 1:
            counts[CLASSES + row] = 0
            if count <= room:
                out[last + 1] = scale
                if scale <= out[last] * (1.0 + _NEAR):  # or make one
                    counts[row] = count - 1
