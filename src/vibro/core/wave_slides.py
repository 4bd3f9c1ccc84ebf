"""Slides under any periodic load: from zero to zero of what accelerates them, until the speed is lost.

Between two zeros of the load beyond kinetic friction the speed is monotone. It is least where that load
begins to rise above 0: the body stops before the first such phase at which no speed would be left. Lengths
in A, speeds in A w, phases in radians.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from vibro.core.buffers import HARMONICS, PIECES
from vibro.core.cells import behind, find_nodes, number_of_nodes
from vibro.core.drives import Loads, mix_of
from vibro.core.elementary import EPS, INF, NAN, NOISE, TURN, wrap
from vibro.core.waves import (
    KINETIC_BACK,
    KINETIC_FORWARD,
    Mix,
    Moved,
    Waves,
    depart,
    integrals_of,
    moved,
    nodes_of,
    place_in,
)

__all__ = [
    "Crossing", "Fall", "Left", "WaveSlide", "ahead", "crossing", "first_ahead", "left_after",
    "slide_over_waves",
]  # fmt: skip

_STEPS: Final = 100  # of Halley's iteration with halvings, in a bracket
_SETTLED: Final = 0.1 * EPS  # [1] error, over the phase, that Halley's next step may have
# [A w] Below this a difference of integrals would leave too few digits of a change of the speed.
_SMALL: Final = 0.01
_MOST_BEND: Final = 0.5  # [1] share of the rate that the curvature may change over a step
# [turn] A slide that outlasts so many turns never ends: a phase has no digit left to say where.
_MOST_TURNS: Final = 1e15
# [turn] that are followed one by one: one before all but the last are skipped, one after, and rounding.
_FOLLOWED_TURNS: Final = 64


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


class Left(NamedTuple):
    """What is left a phase after the start, its rate, and its second derivative."""

    phase: float
    value: float
    rate: float
    bend: float


def left_after(fall: Fall, s: float) -> Left:
    """Return what is left after a phase."""
    return _left(fall, s, fallen(fall, s))


def _left(fall: Fall, s: float, now: Moved) -> Left:
    if fall.height:
        return Left(s, fall.value + (fall.rate * s + now.path), fall.rate + now.velocity, now.load)
    return Left(s, fall.value + now.velocity, now.load, now.slope)


def _noise(waves: Waves) -> float:
    """Return the speed, or height, that rounding may leave of none: pieces may keep a body there."""
    return NOISE if waves.kind == PIECES else 0.0


class Crossing(NamedTuple):
    """Where nothing is left, and what the load has done until then."""

    phase: float
    moved: Moved


def crossing(fall: Fall, low: Left, high: Left) -> Crossing:
    """Find where nothing is left, between phases at which values have opposite signs, or are 0.

    Halley's iteration in the bracket that its steps leave, from the zero of the cubic that is level at both
    ends; halving where it converges slowly, next to a double zero.
    """
    begin, end, fell = low.phase, high.phase, low.value - high.value
    lost = min(max(low.value / fell, 0.0), 1.0) if fell != 0.0 else 0.5
    if lost == 1.0:  # at the end the load may have jumped, and nothing be left long before
        lost = 0.5
    x = begin + (end - begin) * (0.5 - math.sin(math.asin(1.0 - 2.0 * lost) / 3.0))
    before, least, most = end - begin, begin, end
    now = fallen(fall, x)
    for _ in range(_STEPS):
        here = _left(fall, x, now)
        # pieces may leave nothing for a while: then find where that begins
        if (here.value > 0.0) != (fell > 0.0) or (here.rate == 0.0 and abs(here.value) <= _noise(fall.waves)):
            most = x
        else:
            least = x
        step = -here.value / here.rate if here.rate != 0.0 else INF
        bend = -0.5 * step * here.bend
        if abs(bend) < _MOST_BEND * abs(here.rate):
            step *= here.rate / (here.rate - bend)
        inside = least <= x + step <= most and abs(step) < 0.5 * before
        if not inside:
            step = 0.5 * (least + most) - x
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
    return place_in(waves, nodes_of(waves, row), number_of_nodes(waves, row), phase)


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
        _find(waves, row, mix)
    start = depart(waves, mix, phase)
    fall = Fall(waves, mix, phase, start.load, False, speed, 0.0)
    count = number_of_nodes(waves, row)
    if count == 0:
        return _monotone(fall, limit)
    index = first_ahead(waves, row, phase)
    rises = behind(waves, row, index % count)
    if speed == 0.0 and rises:
        # rounding has put the onset in front of the phase from which the load exceeds friction
        index, rises = index + 1, False
    drop, noise = -TURN * mix.constant, _noise(waves)
    low, top, least, minima = Left(0.0, speed, start.load, 0.0), speed, INF, 0
    for _ in range(_FOLLOWED_TURNS * count):
        far = ahead(waves, row, phase, index)
        if far >= limit:
            then = fallen(fall, limit)
            high = _left(fall, limit, then)
            if not (high.value <= noise and rises):
                end = max(high.value, 0.0)
                return WaveSlide(limit, False, end, max(top, high.value), speed * limit + then.path)
        else:
            high = _at_node(fall, row, index, far, start.integral)
        if high.value <= noise and rises:
            return _stopped(fall, crossing(fall, low, high), top)
        top = max(top, high.value)
        if rises:
            least = min(least, high.value)
            minima += 2
        low, index, rises = high, index + 1, not rises
        if minima >= count and rises and limit == INF:
            # all minima of a turn were passed, and all maxima: each turn takes as much from them
            if not drop > 0.0 or least / drop > _MOST_TURNS:
                return WaveSlide(INF, False, NAN, NAN, NAN)
            turns = float(math.floor(least / drop))
            if turns >= 1.0:
                index += count * int(turns)
                low = _at_node(fall, row, index - 1, ahead(waves, row, phase, index - 1), start.integral)
            least, minima = INF, 0
    return WaveSlide(NAN, False, NAN, NAN, NAN)


def _find(waves: Waves, row: int, mix: Mix) -> None:
    """Find the zeros of a load beyond kinetic friction, and its integral there."""
    find_nodes(waves, row, mix)
    for i in range(number_of_nodes(waves, row)):
        zero = waves.number[nodes_of(waves, row) + i]
        waves.number[integrals_of(waves, row) + i] = depart(waves, mix, zero).integral


def _at_node(fall: Fall, row: int, index: int, far: float, integral: float) -> Left:
    """Return what is left at a zero of the load, from its integrals there and at the start."""
    node = integrals_of(fall.waves, row) + index % number_of_nodes(fall.waves, row)
    gain = fall.mix.constant * far + (fall.waves.number[node] - integral)
    if abs(gain) < _SMALL:
        gain = fallen(fall, far).velocity
    return Left(far, fall.value + gain, 0.0, 0.0)


def _monotone(fall: Fall, limit: float) -> WaveSlide:
    """Follow a slide under a load that never changes its sign."""
    drop = -TURN * fall.mix.constant
    if limit == INF:
        if not drop > 0.0 or fall.value / drop > _MOST_TURNS:
            return WaveSlide(INF, False, NAN, NAN, NAN)
        limit = TURN * (math.floor(fall.value / drop) + 1.0)
    then = fallen(fall, limit)
    high = _left(fall, limit, then)
    if high.value > 0.0:
        path = fall.value * limit + then.path
        return WaveSlide(limit, False, high.value, max(fall.value, high.value), path)
    if fall.value == 0.0:
        return WaveSlide(0.0, True, 0.0, 0.0, 0.0)
    return _stopped(fall, crossing(fall, left_after(fall, 0.0), high), fall.value)


def _stopped(fall: Fall, stop: Crossing, top: float) -> WaveSlide:
    return WaveSlide(stop.phase, True, 0.0, top, fall.value * stop.phase + stop.moved.path)
