"""At which scales of the whole motion a drive beyond one harmonic has each class of steady contact cycle.

All amplitudes grow alike, so that the waves stay and the weights fall. Classes come and go: they have
intervals, which are sought between the first onset and the hop on ``SCALES`` scales. Equation numbers are
those of docs/theory.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from vibro.core.buffers import CLASSES, Doubles, Integers
from vibro.core.drives import Loads
from vibro.core.elementary import EPS, INF, NAN, PI
from vibro.core.limits import CriticalLoads, onset, unknown_loads
from vibro.core.wave_cycle import Classes, wave_classes
from vibro.core.windows import Thresholds, thresholds, thresholds_of

__all__ = ["SCALES", "wave_limits", "write_spans"]

#: [1] Steps between the first onset and the hop in which a change of the cycle is looked for.
SCALES: Final = 256

# [1] Scale over that of the first onset up to which drives are looked at that never make bodies hop.
_MOST: Final = 1e6
# [1] Behind an onset rounding leaves open whether the body slips.
_NEAR: Final = 1e-12
# [1] Relative width to which a change of pattern is enclosed that leaves all classes as they are.
_COARSE: Final = 1e-5
_FINE: Final = 4.0 * EPS  # [1] the same of a class that begins or ends
_HALVINGS: Final = 80  # of a step; the longest takes 58
_MOST_CHANGES: Final = 1_000  # of the pattern; the most that were met are 40


class _Scaled(NamedTuple):
    """A scene, its thresholds at scale 1, both onsets, just above the later one, and the range to look at."""

    loads: Loads
    at: Thresholds
    forward: float
    back: float
    later: float
    low: float
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
    forward, back = onset(capacity + t, at.forward_load), onset(capacity - t, at.back_load)
    low = min(forward, back)
    high = min(hop, _MOST * low) if low < INF else low
    return _Scaled(loads, at, forward, back, max(forward, back) * (1.0 + _NEAR), low, high, hop)


def _classes_at(scaled: _Scaled, scale: float) -> Classes:
    """Solve the steady cycle of a motion that is so many times as large."""
    loads = scaled.loads
    loads = loads._replace(
        weight_normal=loads.weight_normal / scale, weight_tangential=loads.weight_tangential / scale
    )
    return wave_classes(loads, thresholds_of(loads, scaled.at.forward_load, scaled.at.back_load))


def _scale_at(scaled: _Scaled, index: int) -> float:
    """Return one of the scales to look at: closer to each other next to the onset, and to the hop."""
    if index >= SCALES:
        return scaled.high
    share = 0.5 - 0.5 * math.cos(PI * index / SCALES)
    return scaled.low * math.exp(share * math.log(scaled.high / scaled.low))


def _first(scaled: _Scaled) -> _Stretch:
    """Begin just above the first onset."""
    return _Stretch(scaled.low, 1, _classes_at(scaled, min(scaled.low * (1.0 + _NEAR), scaled.high)))


def _next(scaled: _Scaled, here: _Stretch) -> _Stretch:
    """Find the next scale from which on the pattern is another one; inf if there is none."""
    low = here.scale
    for index in range(here.step, SCALES + 1):
        high = _scale_at(scaled, index)
        if low < scaled.later < high:
            then = _classes_at(scaled, scaled.later)
            if not _is_same(then, here.classes):
                return _enclosed(scaled, here, index, low, scaled.later, then)
            low = scaled.later
        if high > low:
            then = _classes_at(scaled, high)
            if not _is_same(then, here.classes):
                return _enclosed(scaled, here, index, low, high, then)
            low = high
    return _Stretch(INF, SCALES, here.classes)


def _enclosed(
    scaled: _Scaled, here: _Stretch, index: int, low: float, high: float, then: Classes
) -> _Stretch:
    """Halve a step until it ends just behind the first change of the pattern that is met in it."""
    for _ in range(_HALVINGS):
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
        return unknown_loads()
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
        _mark(Classes(1, forward, not forward, rest=False), 0.0, out, counts, room)
    else:
        here = _first(scaled)
        for _ in range(_MOST_CHANGES):
            if not here.scale < scaled.high:
                break
            _mark(here.classes, _told(scaled, here.scale), out, counts, room)
            here = _next(scaled, here)
    _mark(Classes(1, forward=False, back=False, rest=True), end, out, counts, room)


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
