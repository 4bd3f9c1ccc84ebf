"""Boxes of operating points within bands, and the speed of one of their bodies.

Speeds have the sign of ``Box.way``: the fastest body is the slowest one for somebody who looks at the trough
from its other side.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from vibro.core.codes import Regime, Status
from vibro.core.contact import steady_cycle
from vibro.core.drive import Loads, directions, ellipse_loads, ellipse_scale, line_loads
from vibro.core.numbers import INF, NAN, PI, QUARTER, TURN, Doubles, Integers, Value, hypotenuse, newton
from vibro.core.slides import thresholds

#: Coordinates of a box: the load, three of the drive, the trough angle, both frictions.
AXES: Final = 7
_LOAD: Final = 0
_FIRST: Final = 1
_SECOND: Final = 2
_THIRD: Final = 3
BETA: Final = 4
_STATIC: Final = 5
_KINETIC: Final = 6


class Box(NamedTuple):
    """Bands of operating points, cut where mu_d / mu_s would leave a band of its own, up to 1 at most.

    Attributes
    ----------
    low, high : Doubles
        Ends of the bands, ``AXES`` long. The load is w^2 / g times the factor of the motion: G of a line [1],
        1/m of an ellipse. The drive has the drive angle of a line [rad], then nothing; both amplitudes [m]
        and the phase [rad] of an ellipse.
    ellipse : bool
        Which drive it is.
    ratio_low, ratio_high : float
        Band of mu_d / mu_s.
    factor_low, factor_high, frequency_low, frequency_high : float
        Bands of the factor [m, 1] and of the frequency [Hz], which the loads stand for.
    gravity : float
        [m/s^2].
    way : float
        1 where the slowest body is sought, -1 where the fastest one is.
    highest : int
        Code of the regime above which a body counts as slower than all others.
    """

    low: Doubles
    high: Doubles
    ellipse: bool
    ratio_low: float
    ratio_high: float
    factor_low: float
    factor_high: float
    frequency_low: float
    frequency_high: float
    gravity: float
    way: float
    highest: int


def frequency_at(box: Box, load: float, slow: bool) -> float:
    """Return the highest, or the lowest, frequency that has a load [Hz]: its bodies are the slowest ones."""
    factor = box.factor_low if slow else box.factor_high
    frequency = math.sqrt(load * box.gravity / factor) / TURN
    return min(max(frequency, box.frequency_low), box.frequency_high)


def mean_speed(box: Box, load: float, path: float) -> float:
    """Return the least mean speed of bodies with a load, from their path per cycle over load g / w^2 [m/s].

    At one load the speed is proportional to 1/f, Eq. (52), so that the sign of the path decides which of its
    frequencies is the slow one.
    """
    frequency = frequency_at(box, load, path > 0.0)
    return path * load * box.gravity / (TURN * TURN * frequency)


def _loads_at(box: Box, x: Doubles, row: int) -> Loads:
    """Form the groups of the body at a point; beyond the cut, of that at the cut."""
    angles = directions(x[row + _THIRD] if box.ellipse else x[row + _FIRST], x[row + BETA])
    mu_s = x[row + _STATIC]
    mu_d = min(max(x[row + _KINETIC], box.ratio_low * mu_s), box.ratio_high * mu_s)
    if not box.ellipse:
        return line_loads(1.0 / x[row + _LOAD], angles, mu_s, mu_d)
    along, normal = x[row + _FIRST], x[row + _SECOND]
    scale = ellipse_scale(along, normal)
    return ellipse_loads(along / scale, normal / scale, 1.0 / (x[row + _LOAD] * scale), angles, mu_s, mu_d)


def speed_at(box: Box, x: Doubles, row: int) -> float:
    """Return the mean speed, the ``way`` that is sought, of the body in contact at a point [m/s].

    Of the frequencies that have its load, the slowest. -inf where there is no steady motion, or a regime too
    high; NaN where the body hops, or could not be solved.
    """
    loads = _loads_at(box, x, row)
    found = steady_cycle(loads, thresholds(loads))
    if found.regime > box.highest:
        return -INF
    if found.status == Status.FLIGHT_NOT_MODELLED or found.status == Status.UNRESOLVED:
        return NAN
    if found.regime == Regime.UNDEFINED or found.status == Status.RUNAWAY:
        return -INF
    scale = ellipse_scale(x[row + _FIRST], x[row + _SECOND]) if box.ellipse else 1.0
    return mean_speed(box, x[row + _LOAD], box.way * found.displacement * scale)


# ------------------------------------------------------------------------------
# A body that is never faster than any body of a box: a proved bound of their speeds.
#
# It is pushed no harder than any of them at every phase and speed, so that it never passes one (theory,
# section 14). Its push is that of no operating point: friction is the largest while it slides forward and the
# smallest while it slides back, and each sine has its least amplitude where it pushes and its largest where
# it brakes. So its push is a sine of two amplitudes less a constant, of each direction. Pushes are over m g
# times the load (and the amplitude along the trough, of an ellipse that is longer than high), so that a band
# of loads is one of drags alone; phases are those of the motion along the trough.

_SETTLED: Final = 1e-13  # [rad] last step
_MOST_SLIDES: Final = 200  # until a cycle repeats
_DIRECT: Final = 4  # slides without a rest, after which the cycle without rest is looked for
_DOUBLINGS: Final = 64  # of how much earlier it starts, until one comes earlier by itself
_TURNS: Final = 100  # cycles that are followed on the way to it
_NEAR: Final = 1e-5  # [rad] by which its slides forward may come earlier from cycle to cycle
# [1] Rounding of a path and of static friction, over the largest push: that of terms that cancel in them.
_ROUNDING: Final = 1e-14


class _Side(NamedTuple):
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

    forward: _Side
    back: _Side
    opens_forward: float
    forward_window: float
    opens_back: float
    back_window: float


def least_speed(box: Box, lows: Doubles, highs: Doubles, row: int) -> float:
    """Bound the speeds of the bodies of a box, a row of ends, from below; -inf without a bound [m/s]."""
    place = AXES * row
    mu_low, mu_high = lows[place + _STATIC], highs[place + _STATIC]
    least = max(lows[place + _KINETIC], box.ratio_low * mu_low)
    most = min(highs[place + _KINETIC], box.ratio_high * mu_high)
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
    unit = ends[place + _FIRST] if _counts_along(box, lows, highs, place) else 1.0
    return mean_speed(box, ends[place + _LOAD], path * unit)


def _counts_along(box: Box, lows: Doubles, highs: Doubles, place: int) -> bool:
    """Whether pushes are counted in the load times the amplitude along the trough of an ellipse.

    If that is the smaller one, its band would cost more than it does by itself.
    """
    return box.ellipse and lows[place + _FIRST] > 0.0 and lows[place + _FIRST] >= highs[place + _SECOND]


def _side(box: Box, lows: Doubles, highs: Doubles, place: int, sigma: float, mu: float) -> _Side:
    """Return the least push on bodies of a box that slide forward (sigma = 1) or back (-1)."""
    way, first, last = box.way, lows[place + _FIRST], highs[place + _FIRST]
    drag = _most_drag(lows[place + BETA], highs[place + BETA], way, sigma * mu)
    drag /= lows[place + _LOAD] if drag > 0.0 else highs[place + _LOAD]
    if box.ellipse:
        flat, steep = lows[place + _SECOND], highs[place + _SECOND]
        if _counts_along(box, lows, highs, place):
            drag /= first if drag > 0.0 else last
            flat, steep, first, last = flat / last, steep / first, 1.0, 1.0
        phase = 0.5 * (lows[place + _THIRD] + highs[place + _THIRD])
        width = highs[place + _THIRD] - lows[place + _THIRD]
        middle, along = 0.5 * (flat + steep), 0.5 * way * (first + last)
        level, across = along + sigma * mu * middle * math.cos(phase), sigma * mu * middle * math.sin(phase)
        amplitude = hypotenuse(level, across)
        # how far the arrow of another shape's sine ends from that of the middle one
        apart = 0.5 * (last - first) + mu * (0.5 * (steep - flat) + 2.0 * middle * math.sin(0.25 * width))
        return _Side(amplitude, amplitude, math.atan2(across, level), drag + apart)
    one = way * math.cos(first) + sigma * mu * math.sin(first)
    two = way * math.cos(last) + sigma * mu * math.sin(last) if last != first else one
    weak, strong = min(one, two), max(one, two)
    if way * sigma > 0.0 and first < math.atan(mu) < last:  # the angle of friction pushes most
        top = math.sqrt(1.0 + mu * mu)
        weak, strong = min(weak, way * top), max(strong, way * top)
    if weak >= 0.0:
        return _Side(weak, strong, 0.0, drag)
    if strong <= 0.0:
        return _Side(-strong, -weak, PI, drag)
    middle, apart = 0.5 * (weak + strong), 0.5 * (strong - weak)
    return _Side(abs(middle), abs(middle), 0.0 if middle >= 0.0 else PI, drag + apart)


def _most_drag(low: float, high: float, way: float, friction: float) -> float:
    """Return the largest weight down the trough plus friction, of the trough angles in a range."""
    one = way * math.sin(low) + friction * math.cos(low)
    if low == high:
        return one
    two = way * math.sin(high) + friction * math.cos(high)
    if friction > 0.0 and low < math.atan2(way, friction) < high:
        return math.sqrt(1.0 + friction * friction)
    return max(one, two)


def _turned(side: _Side) -> _Side:
    """Look at a push back as one that drives: half a turn later in its own phase."""
    return _Side(side.down, side.up, side.lead - PI, -side.drag)


def _opens(held: _Side) -> float:
    """Return the phase, in a turn, at which the push exceeds static friction."""
    start = math.asin(held.drag / held.up) if held.up > held.drag else QUARTER
    phase = start - held.lead
    return phase - TURN * math.floor(phase / TURN)


def _window(held: _Side) -> float:
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


def _slide(side: _Side, phase: float) -> _Path:
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


# ------------------------------------------------------------------------------
# Branch and bound: how slow a body of a box can be at most, proved by boxes that cover it.

_LEAST_WIDTH: Final = 1e-9  # [share of a band] of a box that is divided
_FOUND: Final = 2.0  # [1] what a bound counts where there was none, beside shares of bands


class Cover(NamedTuple):
    """Boxes that cover a box.

    Attributes
    ----------
    low, high : Doubles
        Ends of each, ``AXES`` numbers a row.
    bound : Doubles
        No body of a box is slower [m/s].
    heap : Integers
        Room for as many numbers; the first one is the row of the least bound.
    point : Doubles
        The slowest body that was met, ``AXES`` long, and room for as many numbers.
    speed : Doubles
        Its speed [m/s].
    """

    low: Doubles
    high: Doubles
    bound: Doubles
    heap: Integers
    point: Doubles
    speed: Doubles


def cover(box: Box, out: Cover, gap: float, least: float, most: int) -> int:
    """Divide a box where its bound is least, until that is close to the slowest body that was met.

    Parameters
    ----------
    box : Box
        The box.
    out : Cover
        Room for ``most`` boxes, with a body that is known.
    gap, least : float
        Distance of bound and body that is close: over the speed [1], or over this speed where it is less
        [m/s].
    most : int
        Most boxes.

    Returns
    -------
    int
        Number of boxes.
    """
    for axis in range(AXES):
        out.low[axis], out.high[axis] = box.low[axis], box.high[axis]
    out.bound[0], out.heap[0] = least_speed(box, out.low, out.high, 0), 0
    count = 1
    for _ in range(1, most):
        row, speed = out.heap[0], out.speed[0]
        if out.bound[row] >= speed - gap * max(abs(speed), least):
            break
        axis = _axis(box, out, row)
        if axis < 0:
            break
        for i in range(AXES):
            out.low[AXES * count + i] = out.low[AXES * row + i]
            out.high[AXES * count + i] = out.high[AXES * row + i]
        middle = 0.5 * (out.low[AXES * row + axis] + out.high[AXES * row + axis])
        out.high[AXES * row + axis] = middle
        out.low[AXES * count + axis] = middle
        whole = out.bound[row]  # holds for its parts, whatever rounding makes of theirs
        out.bound[row] = max(least_speed(box, out.low, out.high, row), whole)
        out.bound[count] = max(least_speed(box, out.low, out.high, count), whole)
        _sink(out, count)
        _rise(out, count)
        _look_inside(box, out, row)
        _look_inside(box, out, count)
        count += 1
    return count


def _axis(box: Box, out: Cover, row: int) -> int:
    """Return the axis along which a box is worth dividing, by the bound where it has no width; or -1."""
    best, most, widest, whole = -1, 0.0, 0.0, out.bound[row]
    for axis in range(AXES):
        place = AXES * row + axis
        low, high = out.low[place], out.high[place]
        if not high > low or high - low <= _LEAST_WIDTH * (box.high[axis] - box.low[axis]):
            continue
        out.low[place] = 0.5 * (low + high)
        out.high[place] = out.low[place]
        bound = least_speed(box, out.low, out.high, row)
        out.low[place], out.high[place] = low, high
        width = (high - low) / (box.high[axis] - box.low[axis])
        gain = (_FOUND if bound > -INF else 0.0) if whole == -INF else bound - whole
        if best < 0 or gain > most or (gain == most and width > widest):
            best, most, widest = axis, gain, width
    return best


def _look_inside(box: Box, out: Cover, row: int) -> None:
    """Compare the body in the middle of a box with the slowest one."""
    for axis in range(AXES):
        out.point[AXES + axis] = 0.5 * (out.low[AXES * row + axis] + out.high[AXES * row + axis])
    speed = speed_at(box, out.point, AXES)
    if speed < out.speed[0]:
        out.speed[0] = speed
        for axis in range(AXES):
            out.point[axis] = out.point[AXES + axis]


def _sink(out: Cover, count: int) -> None:
    """Move the first row of the heap down to its place among ``count``."""
    heap, place = out.heap, 0
    row = heap[0]
    for _ in range(count):
        child = 2 * place + 1
        if child >= count:
            break
        if child + 1 < count and out.bound[heap[child + 1]] < out.bound[heap[child]]:
            child += 1
        if out.bound[row] <= out.bound[heap[child]]:
            break
        heap[place] = heap[child]
        place = child
    heap[place] = row


def _rise(out: Cover, row: int) -> None:
    """Put a new row, the last one of the heap, into its place."""
    heap, place = out.heap, row
    for _ in range(row):
        if place == 0 or not out.bound[row] < out.bound[heap[(place - 1) // 2]]:
            break
        heap[place] = heap[(place - 1) // 2]
        place = (place - 1) // 2
    heap[place] = row


# ------------------------------------------------------------------------------
# Differential evolution: the slowest body of a box, by a population of bodies that moves towards it.
#
# Storn and Price, J. Global Optim. 11 (1997) 341, the scheme best/1/bin with a weight drawn anew for every
# generation.

_OVERHANG: Final = 0.1  # [share of a band] trial points so far outside go to its end, where optima often are
_LEAST_WEIGHT: Final = 0.5
_MORE_WEIGHT: Final = 0.5
_CROSSING: Final = 0.7  # share of the coordinates that a trial takes from the mutant
_SETTLED_SPREAD: Final = 1e-12  # relative spread of the speeds at which the search ends
# The least standard generator of Park and Miller, Comm. ACM 31 (1988) 1192.
_FACTOR: Final = 16807
_MODULUS: Final = 2147483647


class Population(NamedTuple):
    """Bodies of a box.

    Attributes
    ----------
    points : Doubles
        ``AXES`` numbers a body; room for one more.
    speeds : Doubles
        Of each [m/s].
    """

    points: Doubles
    speeds: Doubles


def evolve(box: Box, out: Population, size: int, generations: int, seed: int) -> int:
    """Move a population, whose points are given, to the slowest body; return which of them that is."""
    state, best = seed, 0
    for i in range(size):
        out.speeds[i] = _counted(box, out.points, AXES * i)
        if out.speeds[i] < out.speeds[best]:
            best = i
    for _ in range(generations):
        if _is_settled(out, size, best):
            break
        state = _FACTOR * state % _MODULUS
        weight = _LEAST_WEIGHT + _MORE_WEIGHT * state / _MODULUS
        for i in range(size):
            state = _try(box, out, size, i, best, weight, state)
            if out.speeds[size] <= out.speeds[i]:
                out.speeds[i] = out.speeds[size]
                for axis in range(AXES):
                    out.points[AXES * i + axis] = out.points[AXES * size + axis]
                if out.speeds[i] < out.speeds[best]:
                    best = i
    return best


def _counted(box: Box, points: Doubles, row: int) -> float:
    """Return the speed of a body, inf where it is unknown."""
    speed = speed_at(box, points, row)
    return INF if math.isnan(speed) else speed


def _is_settled(out: Population, size: int, best: int) -> bool:
    """Whether all speeds are those of the slowest body, or none can be lower."""
    if out.speeds[best] == -INF:
        return True
    most = out.speeds[0]
    for i in range(1, size):
        most = max(most, out.speeds[i])
    return most <= out.speeds[best] + _SETTLED_SPREAD * abs(out.speeds[best])


def _try(box: Box, out: Population, size: int, i: int, best: int, weight: float, state: int) -> int:
    """Cross a body with a mutant of the slowest one, behind the last row; return the generator's state."""
    state = _FACTOR * state % _MODULUS
    one = state % size
    state = _FACTOR * state % _MODULUS
    two = (one + 1 + state % (size - 1)) % size  # another one: without a difference all become the slowest
    state = _FACTOR * state % _MODULUS
    sure = state % AXES  # which coordinate is taken in any case
    for axis in range(AXES):
        low, high = box.low[axis], box.high[axis]
        state = _FACTOR * state % _MODULUS
        value = out.points[AXES * i + axis]
        if high > low and (axis == sure or state < _CROSSING * _MODULUS):
            apart = out.points[AXES * one + axis] - out.points[AXES * two + axis]
            value = out.points[AXES * best + axis] + weight * apart
            beyond = _OVERHANG * (high - low)
            if value < low - beyond or value > high + beyond:
                state = _FACTOR * state % _MODULUS
                value = low + (high - low) * state / _MODULUS
            value = min(max(value, low), high)
        out.points[AXES * size + axis] = value
    out.speeds[size] = _counted(box, out.points, AXES * size)
    return state
