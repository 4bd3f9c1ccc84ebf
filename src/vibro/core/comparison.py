"""A body that is never faster than any body of a box: a proved bound of their speeds.

It is pushed no harder than any of them at every phase and speed, so that it never passes one (theory,
section 14). Its push is that of no operating point: friction is the largest while it slides forward and the
smallest while it slides back, and each sine has its least amplitude where it pushes and its largest where it
brakes. So its push is a sine of two amplitudes less a constant, of each direction. Pushes are over m g times
the load (and the amplitude along the trough, of an ellipse that is longer than high), so that a band of loads
is one of drags alone; phases are those of the motion along the trough.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from vibro.core.boxes import AXES, BETA, FIRST, KINETIC, LOAD, SECOND, STATIC, THIRD, Box, mean_speed
from vibro.core.buffers import Doubles
from vibro.core.elementary import INF, NAN, PI, QUARTER, TURN, hypotenuse
from vibro.core.roots import Value, newton

__all__ = ["least_speed"]

_SETTLED: Final = 1e-13  # [rad] last step
_MOST_SLIDES: Final = 200  # until a cycle repeats
_DIRECT: Final = 4  # slides without a rest, after which the cycle without rest is looked for
_DOUBLINGS: Final = 64  # of how much earlier it starts, until one comes earlier by itself
_TURNS: Final = 100  # cycles that are followed on the way to it
_NEAR: Final = 1e-5  # [rad] by which its slides forward may come earlier from cycle to cycle
# [1] Rounding of a path and of static friction, over the largest push: that of terms that cancel in them.
_ROUNDING: Final = 1e-14


class Side(NamedTuple):
    """Push on a body in one direction: ``up sin q - drag`` where sin q > 0, else ``down sin q - drag``.

    ``lead`` is added to a phase to give q.
    """

    up: float
    down: float
    lead: float
    drag: float


class _Path(NamedTuple):
    """A slide: its length [rad], NaN where it never ends, and its path."""

    length: float
    path: float


class _Body(NamedTuple):
    """Slides forward and back, each in its own phase, and the windows in which a rest ends."""

    forward: Side
    back: Side
    opens_forward: float
    forward_window: float
    opens_back: float
    back_window: float


def least_speed(box: Box, lows: Doubles, highs: Doubles, row: int) -> float:
    """Bound the speeds of the bodies of a box, a row of ends, from below; -inf without a bound [m/s]."""
    place = AXES * row
    mu_low, mu_high = lows[place + STATIC], highs[place + STATIC]
    least = max(lows[place + KINETIC], box.ratio_low * mu_low)
    most = min(highs[place + KINETIC], box.ratio_high * mu_high)
    if least > most:
        return INF  # no body
    if box.ratio_high > 0.0:
        mu_low = max(mu_low, least / box.ratio_high)
    forward = _side(box, lows, highs, place, 1.0, most)
    back = _turned(_side(box, lows, highs, place, -1.0, least))
    held = _side(box, lows, highs, place, 1.0, mu_high)
    released = _turned(_side(box, lows, highs, place, -1.0, mu_low))
    if forward.drag < 0.0 or back.drag < 0.0 or held.drag <= 0.0 or released.drag <= 0.0:
        return -INF  # steep: a slide need not end
    rounding = _ROUNDING * (held.up + held.down + released.up + released.down + held.drag + released.drag)
    held = held._replace(drag=held.drag + rounding)  # else a rest might end, or go on, that does not
    released = released._replace(drag=released.drag - rounding)
    body = _Body(forward, back, _opens(held), _window(held), _opens(released), _window(released))
    path = _path(body)
    if body.forward_window > 0.0 or body.back_window > 0.0:
        path -= _ROUNDING * (forward.up + forward.down + back.up + back.down)
    ends = lows if path > 0.0 else highs
    unit = ends[place + FIRST] if _counts_along(box, lows, highs, place) else 1.0
    return mean_speed(box, ends[place + LOAD], path * unit)


def _counts_along(box: Box, lows: Doubles, highs: Doubles, place: int) -> bool:
    """Whether pushes are counted in the load times the amplitude along the trough of an ellipse.

    If that is the smaller one, its band would cost more than it does by itself.
    """
    return box.ellipse and lows[place + FIRST] > 0.0 and lows[place + FIRST] >= highs[place + SECOND]


def _side(box: Box, lows: Doubles, highs: Doubles, place: int, sigma: float, mu: float) -> Side:
    """Return the least push on bodies of a box that slide forward (sigma = 1) or back (-1)."""
    way, first, last = box.way, lows[place + FIRST], highs[place + FIRST]
    drag = _most_drag(lows[place + BETA], highs[place + BETA], way, sigma * mu)
    drag /= lows[place + LOAD] if drag > 0.0 else highs[place + LOAD]
    if box.ellipse:
        flat, steep = lows[place + SECOND], highs[place + SECOND]
        if _counts_along(box, lows, highs, place):
            drag /= first if drag > 0.0 else last
            flat, steep, first, last = flat / last, steep / first, 1.0, 1.0
        phase = 0.5 * (lows[place + THIRD] + highs[place + THIRD])
        width = highs[place + THIRD] - lows[place + THIRD]
        middle, along = 0.5 * (flat + steep), 0.5 * way * (first + last)
        level, across = along + sigma * mu * middle * math.cos(phase), sigma * mu * middle * math.sin(phase)
        amplitude = hypotenuse(level, across)
        # how far the arrow of another shape's sine ends from that of the middle one
        apart = 0.5 * (last - first) + mu * (0.5 * (steep - flat) + 2.0 * middle * math.sin(0.25 * width))
        return Side(amplitude, amplitude, math.atan2(across, level), drag + apart)
    one = way * math.cos(first) + sigma * mu * math.sin(first)
    two = way * math.cos(last) + sigma * mu * math.sin(last) if last != first else one
    weak, strong = min(one, two), max(one, two)
    if way * sigma > 0.0 and first < math.atan(mu) < last:  # the angle of friction pushes most
        top = math.sqrt(1.0 + mu * mu)
        weak, strong = min(weak, way * top), max(strong, way * top)
    if weak >= 0.0:
        return Side(weak, strong, 0.0, drag)
    if strong <= 0.0:
        return Side(-strong, -weak, PI, drag)
    middle, apart = 0.5 * (weak + strong), 0.5 * (strong - weak)
    return Side(abs(middle), abs(middle), 0.0 if middle >= 0.0 else PI, drag + apart)


def _most_drag(low: float, high: float, way: float, friction: float) -> float:
    """Return the largest weight down the trough plus friction, of the trough angles in a range."""
    one = way * math.sin(low) + friction * math.cos(low)
    if low == high:
        return one
    two = way * math.sin(high) + friction * math.cos(high)
    if friction > 0.0 and low < math.atan2(way, friction) < high:
        return math.sqrt(1.0 + friction * friction)
    return max(one, two)


def _turned(side: Side) -> Side:
    """Look at a push back as one that drives: half a turn later in its own phase."""
    return Side(side.down, side.up, side.lead - PI, -side.drag)


def _opens(held: Side) -> float:
    """Return the phase, in a turn, at which the push exceeds static friction."""
    start = math.asin(held.drag / held.up) if held.up > held.drag else QUARTER
    phase = start - held.lead
    return phase - TURN * math.floor(phase / TURN)


def _window(held: Side) -> float:
    """Return how long the push exceeds static friction [rad]."""
    return PI - 2.0 * math.asin(held.drag / held.up) if held.up > held.drag else 0.0


def _next(opens: float, window: float, phase: float) -> float:
    """Return when a rest ends that begins at a phase, if this window ends it."""
    if window <= 0.0:
        return INF
    last = opens + TURN * math.floor((phase - opens) / TURN)
    return phase if phase < last + window else last + TURN


class _Pushed(NamedTuple):
    """A slide up to half a turn of its own phase, where its sine ends: cosine at the start, and way to go."""

    up: float
    drag: float
    cosine: float
    rest: float


def _missing(at: _Pushed, s: float) -> Value:
    """Return the speed that is missing a phase s before half a turn."""
    value = at.drag * (at.rest - s) - at.up * (at.cosine + math.cos(s))
    return Value(value, at.up * math.sin(s) - at.drag)


class _Braked(NamedTuple):
    """A slide from half a turn of its own phase on, or a whole one: its speed there, and what brakes it."""

    speed: float
    load: float
    drag: float


def _speed(at: _Braked, s: float) -> Value:
    """Return the speed after a phase s."""
    value = at.speed - at.load * (1.0 - math.cos(s)) - at.drag * s
    return Value(value, -(at.load * math.sin(s)) - at.drag)


def _slide(side: Side, phase: float) -> _Path:
    """Slide from rest, or from where the way turns, by half turns of the own phase.

    Newton's steps start in each where the speed's curvature makes them converge from one side.
    """
    q = phase + side.lead
    q -= TURN * math.floor((q + QUARTER) / TURN)  # from where it is pushed: around a quarter of a turn
    up, down, drag = side.up, side.down, side.drag
    cosine, rest = math.cos(q), PI - q
    speed = up * (1.0 + cosine) - drag * rest
    if speed <= 0.0:
        # back from half a turn, where the speed is concave
        s = newton(_missing, _Pushed(up, drag, cosine, rest), 0.0, INF, 0.0, _SETTLED).at
        length = max(rest - s, 0.0)
        path = up * (cosine * length - math.sin(s) + math.sin(q)) - 0.5 * drag * length * length
        return _Path(length, path)
    path = up * (cosine * rest + math.sin(q)) - 0.5 * drag * rest * rest
    after = speed - 2.0 * down - drag * PI
    if after <= 0.0:
        # from where the speed turns from concave to convex
        s = newton(_speed, _Braked(speed, down, drag), QUARTER, INF, 0.0, _SETTLED).at
        return _Path(rest + s, path + s * (speed - 0.5 * drag * s) - down * (s - math.sin(s)))
    path += PI * (speed - 0.5 * drag * PI) - down * PI
    turn = math.asin(drag / up) if drag < up else QUARTER  # where the speed is least
    if drag <= 0.0 or after + up * (1.0 - math.cos(turn)) - drag * turn > 0.0:
        return _Path(NAN, NAN)
    # before the least speed it is convex
    s = newton(_speed, _Braked(after, -up, drag), 0.0, INF, 0.0, _SETTLED).at
    return _Path(rest + PI + s, path + s * (after - 0.5 * drag * s) + up * (s - math.sin(s)))


def _path(body: _Body) -> float:
    """Follow the body from rest at phase 0 until its cycles repeat; return the path of one, or -inf."""
    phase, path, direct = 0.0, 0.0, 0
    known_forward, known_back = NAN, NAN  # paths at which the body has left a rest, and phases
    left_forward, left_back = NAN, NAN
    for _ in range(_MOST_SLIDES):
        ahead = _next(body.opens_forward, body.forward_window, phase)
        behind = _next(body.opens_back, body.back_window, phase)
        if ahead == INF and behind == INF:
            return 0.0
        forward = ahead <= behind
        begin = ahead if forward else behind
        if begin > phase:  # from a rest
            direct = 0
            known = known_forward if forward else known_back
            if not math.isnan(known):
                turns = (begin - (left_forward if forward else left_back)) / TURN
                return (path - known) / math.floor(turns + 0.5)  # rounding can bring more than one
            if forward:
                known_forward, left_forward = path, begin
            else:
                known_back, left_back = path, begin
        elif forward and direct >= _DIRECT:
            steady = _without_rest(body, begin)
            if not math.isnan(steady):
                return steady
            direct = 0
        found = _slide(body.forward if forward else body.back, begin)
        if math.isnan(found.length):
            return -INF
        path += found.path if forward else -found.path
        phase = begin + found.length
        direct += 1
    return -INF


class _Turn(NamedTuple):
    """A slide forward and back without a rest: how much earlier the next one starts, and the path.

    ``earlier`` is NaN where the body rests.
    """

    earlier: float
    path: float


def _cycle(body: _Body, phase: float) -> _Turn:
    if _next(body.opens_forward, body.forward_window, phase) != phase:
        return _Turn(NAN, NAN)
    forth = _slide(body.forward, phase)
    turn = phase + forth.length
    if math.isnan(turn) or _next(body.opens_back, body.back_window, turn) != turn:
        return _Turn(NAN, NAN)
    back = _slide(body.back, turn)
    end = turn + back.length
    if math.isnan(end) or _next(body.opens_forward, body.forward_window, end) != end:
        return _Turn(NAN, NAN)
    return _Turn(phase + TURN - end, forth.path - back.path)


def _without_rest(body: _Body, phase: float) -> float:
    """Bound the path of a cycle that never rests, from the phase of a slide forward; NaN where it rests.

    A body that starts later is slower. If it starts earlier a cycle later, it only gets faster, and so does
    every body that is not behind it: the path of its first cycle is a bound. If the body itself gets slower
    such a start is looked for by the Illinois method.
    """
    low, high, below = phase, phase, _cycle(body, phase)
    above = below
    if above.earlier >= 0.0:  # it gets faster itself
        for _ in range(_TURNS):
            if not above.earlier > _NEAR:
                break
            high -= above.earlier
            above = _cycle(body, high)
        return above.path
    step = -below.earlier
    for _ in range(_DOUBLINGS):
        if not above.earlier < 0.0:
            break
        step *= 2.0
        high = phase + step
        above = _cycle(body, high)
    if above.earlier < 0.0:
        return NAN
    behind, ahead = below.earlier, above.earlier
    for _ in range(_TURNS):
        if not above.earlier > _NEAR:
            break
        middle = high - (high - low) * (ahead / (ahead - behind))
        found = _cycle(body, middle)
        if math.isnan(found.earlier):
            break
        if found.earlier >= 0.0:
            high, above, ahead, behind = middle, found, found.earlier, 0.5 * behind
        else:
            low, behind, ahead = middle, found.earlier, 0.5 * ahead
    return above.path
