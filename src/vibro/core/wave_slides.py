"""Slides under any periodic load: from zero to zero of what accelerates them, until the speed is lost.

Between two zeros of the load beyond kinetic friction the speed is monotone. It is least where that load
begins to rise above 0: the body stops before the first such phase at which no speed would be left. Lengths
in A, speeds in A w, phases in radians.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from vibro.core.cells import behind, find_nodes, number_of_nodes
from vibro.core.drives import Loads, mix_of
from vibro.core.elementary import EPS, INF, NAN, TURN, wrap
from vibro.core.waves import (
    HARMONICS,
    KINETIC_BACK,
    KINETIC_FORWARD,
    Mix,
    Moved,
    Waves,
    depart,
    moved,
    nodes_of,
)

__all__ = ["Crossing", "Fall", "WaveSlide", "ahead", "crossing", "first_ahead", "slide_over_waves"]

_STEPS: Final = 100  # of Halley's iteration with halvings, in a bracket
_SETTLED: Final = 0.1 * EPS  # [1] error, over the phase, that Halley's next step may have
_MOST_BEND: Final = 0.5  # [1] share of the rate that the curvature may change over a step
# [turn] A slide that outlasts so many turns never ends: a phase has no digit left to say where.
_MOST_TURNS: Final = 1e15


class Fall(NamedTuple):
    """What falls to 0 under a load: a speed, or a height that begins with a rate.

    Attributes
    ----------
    waves, mix : Waves, Mix
        The load, kept by ``depart``.
    phase, load : float
        Start of the leg, and the load there [rad].
    height : bool
        Whether it is a height.
    value, rate : float
        At the start; the rate of a height alone.
    """

    waves: Waves
    mix: Mix
    phase: float
    load: float
    height: bool
    value: float
    rate: float


def fallen(fall: Fall, s: float) -> Moved:
    """Integrate the load over a phase since the start."""
    return moved(fall.waves, fall.mix, fall.phase, fall.load, s)


def level(fall: Fall, s: float) -> tuple[float, float]:
    """Return what is left after a phase, and its rate."""
    return _left(fall, s, fallen(fall, s))


def _left(fall: Fall, s: float, now: Moved) -> tuple[float, float]:
    if fall.height:
        return fall.value + (fall.rate * s + now.path), fall.rate + now.velocity
    return fall.value + now.velocity, now.load


class Crossing(NamedTuple):
    """Where nothing is left, and what the load has done until then."""

    phase: float
    moved: Moved


def crossing(fall: Fall, low: float, high: float, at_low: float, at_high: float) -> Crossing:
    """Find where nothing is left, between phases at which values have opposite signs, or are 0.

    Halley's iteration in the bracket that its steps leave, from the zero of the cubic that is level at both
    ends; halving where it converges slowly, next to a double zero.
    """
    lost = min(max(at_low / (at_low - at_high), 0.0), 1.0) if at_low != at_high else 0.0
    x = low + (high - low) * (0.5 - math.sin(math.asin(1.0 - 2.0 * lost) / 3.0))
    falls, before, begin, end = at_low > at_high, high - low, low, high
    now = fallen(fall, x)
    for _ in range(_STEPS):
        value, rate = _left(fall, x, now)
        if (value > 0.0) == falls:
            low = x
        else:
            high = x
        step = -value / rate if rate != 0.0 else INF
        bend = -0.5 * step * (now.load if fall.height else now.slope)
        if abs(bend) < _MOST_BEND * abs(rate):
            step *= rate / (rate - bend)
        inside = value == 0.0 or (low <= x + step <= high and abs(step) < 0.5 * before)
        if not inside:
            step = 0.5 * (low + high) - x
        before = abs(step)
        x += step
        # the next step would be of the cube of this one, over the square of the distance from a double zero,
        # unless the load jumps
        room = min(x - begin, end - x) if inside and fall.waves.kind == HARMONICS else 0.0
        if before <= 4.0 * EPS * x or before * before * before <= _SETTLED * x * room * room:
            return Crossing(x, _onward(now, step))
        now = fallen(fall, x)
    return Crossing(x, now)


def _onward(now: Moved, s: float) -> Moved:
    """Go on by a phase so short that the load's curvature does not matter."""
    return Moved(
        now.load + s * now.slope,
        now.velocity + s * (now.load + s * now.slope / 2.0),
        now.path + s * (now.velocity + s * (now.load / 2.0 + s * now.slope / 6.0)),
        now.slope,
    )


class WaveSlide(NamedTuple):
    """A slide: as ``SlideEnd`` and, relative to its way, its path."""

    length: float
    stopped: bool
    speed: float
    top: float
    path: float


def first_ahead(waves: Waves, row: int, phase: float) -> int:
    """Return the index of the first zero of a row that lies ahead of a phase in [0, 2 pi), from 0 on."""
    start, count = nodes_of(waves, row), number_of_nodes(waves, row)
    for i in range(count):
        if waves.number[start + i] > phase:
            return i
    return count


def ahead(waves: Waves, row: int, phase: float, index: int) -> float:
    """Return how far ahead of a phase in [0, 2 pi) a zero lies; indices beyond the last count on, a turn on.

    The row must not be empty.
    """
    count = number_of_nodes(waves, row)
    turns = index // count
    return waves.number[nodes_of(waves, row) + index - turns * count] - phase + TURN * turns


def slide_over_waves(loads: Loads, way: float, phase: float, speed: float, limit: float) -> WaveSlide:
    """Follow a slide until it stops or the contact ends.

    Parameters
    ----------
    loads : Loads
        Groups of the scene; zeros of its load beyond kinetic friction are found when first needed.
    way : float
        +1.0 forward, -1.0 back.
    phase, speed : float
        Of its start, speed >= 0; where that is 0 the load must exceed friction [rad, A w].
    limit : float
        Phase from the start to the end of the contact; inf where there is none [rad].
    """
    waves = loads.waves
    row = KINETIC_FORWARD if way > 0.0 else KINETIC_BACK
    mix, phase = mix_of(loads, row), wrap(phase)
    if number_of_nodes(waves, row) < 0:
        find_nodes(waves, row, mix)
    fall = Fall(waves, mix, phase, depart(waves, mix, phase), False, speed, 0.0)
    count = number_of_nodes(waves, row)
    if count == 0:
        return _monotone(fall, limit)
    index = first_ahead(waves, row, phase)
    rises = behind(waves, row, index % count)
    if speed == 0.0 and rises:
        # rounding has put the onset in front of the phase from which the load exceeds friction
        index, rises = index + 1, False
    drop = -TURN * mix.constant
    low, at_low, top, least, minima = 0.0, speed, speed, INF, 0
    while True:
        far = ahead(waves, row, phase, index)
        end = min(far, limit)
        then = fallen(fall, end)
        at_end = speed + then.velocity
        if at_end <= 0.0 and rises:
            return _stopped(fall, crossing(fall, low, end, at_low, at_end), top)
        top = max(top, at_end)
        if far >= limit:
            return WaveSlide(limit, False, max(at_end, 0.0), top, speed * limit + then.path)
        if rises:
            least = min(least, at_end)
            minima += 2
        low, at_low = far, at_end
        index, rises = index + 1, not rises
        if minima >= count and rises and limit == INF:
            # all minima of a turn were passed, and all maxima: each turn takes as much from them
            if not drop > 0.0 or least / drop > _MOST_TURNS:
                return WaveSlide(INF, False, NAN, NAN, NAN)
            turns = math.floor(least / drop)
            if turns >= 1.0:
                index += count * int(turns)
                low = ahead(waves, row, phase, index - 1)
                at_low = speed + fallen(fall, low).velocity
            least, minima = INF, 0


def _monotone(fall: Fall, limit: float) -> WaveSlide:
    """Follow a slide under a load that never changes its sign."""
    drop = -TURN * fall.mix.constant
    if limit == INF:
        if not drop > 0.0 or fall.value / drop > _MOST_TURNS:
            return WaveSlide(INF, False, NAN, NAN, NAN)
        limit = TURN * (math.floor(fall.value / drop) + 1.0)
    then = fallen(fall, limit)
    at_end = fall.value + then.velocity
    if at_end > 0.0:
        return WaveSlide(limit, False, at_end, max(fall.value, at_end), fall.value * limit + then.path)
    if fall.value == 0.0:
        return WaveSlide(0.0, True, 0.0, 0.0, 0.0)
    return _stopped(fall, crossing(fall, 0.0, limit, fall.value, at_end), fall.value)


def _stopped(fall: Fall, stop: Crossing, top: float) -> WaveSlide:
    return WaveSlide(stop.phase, True, 0.0, top, fall.value * stop.phase + stop.moved.path)
