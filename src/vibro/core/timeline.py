"""A history at any time: its phases one after the other, also those that repeat, and the motion in each."""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from vibro.core.codes import Mode
from vibro.core.drive import (
    Loads,
    free_along,
    free_normal,
    normal_height,
    normal_load,
    tangential_load,
    trough_along,
)
from vibro.core.history import Legs
from vibro.core.numbers import INF, TURN, Bytes, Span, wrap

_DOUBLINGS: Final = 60  # no history has so many phases


class _Leg(NamedTuple):
    """The leg of a phase, and how often the cycle was completed before."""

    row: int
    cycles: int


def _leg_of(span: Span, place: int) -> _Leg:
    beyond, size = place - span.first, max(span.number - span.first, 1)
    return _Leg(place, 0) if beyond < 0 else _Leg(span.first + beyond % size, beyond // size)


def start_of(legs: Legs, span: Span, place: int) -> float:
    """Return when the phase with a number begins; inf after the last [s]."""
    at = _leg_of(span, place)
    if at.row >= span.number:
        return INF
    turns = (legs.phase[at.row] - legs.phase[0]) / TURN
    return (legs.cycle[at.row] + span.period * at.cycles + turns) / span.frequency


def _has_begun(legs: Legs, span: Span, place: int, time: float, after: bool) -> bool:
    start = start_of(legs, span, place)
    return start <= time if after else start < time


def phase_at(legs: Legs, span: Span, time: float, after: bool) -> int:
    """Return the number of the phase at a time; where one ends there, that one, or the next if ``after``."""
    low, high = 0, 1
    for _ in range(_DOUBLINGS):
        if not _has_begun(legs, span, high, time, after):
            break
        low, high = high, 2 * high
    for _ in range(_DOUBLINGS):
        if high - low <= 1:
            break
        middle = (low + high) // 2
        if _has_begun(legs, span, middle, time, after):
            low = middle
        else:
            high = middle
    return low


class _Instant(NamedTuple):
    """A moment of a phase: its leg, the displacement in cycles before [A], and the phase since its start."""

    row: int
    advance: float
    since: float


def instant_at(legs: Legs, span: Span, time: float, after: bool) -> _Instant:
    """Find a moment."""
    place = phase_at(legs, span, time, after)
    at = _leg_of(span, place)
    length, since = legs.length[at.row], TURN * span.frequency * (time - start_of(legs, span, place))
    since = min(max(since, 0.0), length)
    if time >= start_of(legs, span, place + 1):
        since = length
    return _Instant(at.row, at.cycles * span.advance, since)


def position_of(legs: Legs, span: Span, place: int) -> float:
    """Return where the phase with a number begins [A]."""
    at = _leg_of(span, place)
    return legs.position[at.row] + at.cycles * span.advance


def row_of(span: Span, place: int) -> int:
    """Return the leg of the phase with a number."""
    return _leg_of(span, place).row


def least_turn(modes: Bytes, first: int, number: int) -> int:
    """Return by how many places to turn a list of letters for the least of its turns, in linear time.

    Two turns are compared; where they differ first, no turn between the greater one and there is the least.
    """
    one, other, same = 0, 1, 0
    for _ in range(3 * number):
        if one >= number or other >= number or same >= number:
            break
        a, b = modes[first + (one + same) % number], modes[first + (other + same) % number]
        if a == b:
            same += 1
        else:
            if a > b:
                one += same + 1
            else:
                other += same + 1
            if one == other:
                other += 1
            same = 0
    return min(one, other)


def turn_letters(letters: Bytes, number: int) -> int:
    """Turn the legs of a cycle to their least turn, as ``canonical`` turns digits; return their number."""
    if number > 1 and letters[0] == letters[number - 1] and letters[0] != Mode.FLIGHT:
        number -= 1
    turn = least_turn(letters, 0, number)
    _reverse(letters, 0, turn)
    _reverse(letters, turn, number)
    _reverse(letters, 0, number)
    return number


def _reverse(letters: Bytes, begin: int, end: int) -> None:
    for i in range((end - begin) // 2):
        letters[begin + i], letters[end - 1 - i] = letters[end - 1 - i], letters[begin + i]


def steady_legs(legs: Legs, span: Span, turns: bool, out: Legs) -> None:
    """Write the legs that repeat as a history of their own, of their letters the least turn if ``turns``.

    What was before the first of them comes a cycle later.
    """
    size = span.number - span.first
    turn = least_turn(legs.mode, span.first, size) if turns else 0
    begin = span.first + turn
    for n in range(size):
        late = turn + n >= size
        row = begin + n - size if late else begin + n
        out.mode[n], out.phase[n], out.length[n] = legs.mode[row], legs.phase[row], legs.length[row]
        out.velocity[n], out.displacement[n] = legs.velocity[row], legs.displacement[row]
        out.end_velocity[n], out.rate[n], out.impact[n] = (
            legs.end_velocity[row],
            legs.rate[row],
            legs.impact[row],
        )
        out.cycle[n] = legs.cycle[row] + (span.period if late else 0) - legs.cycle[begin]
        out.position[n] = legs.position[row] + (span.advance if late else 0.0) - legs.position[begin]


class Moment(NamedTuple):
    """Motion and loads at a moment; lengths in A, speeds in A w.

    Attributes
    ----------
    sine : float
        Of the trough's motion normal to itself.
    trough_along, trough_normal : float
        Position of the trough.
    path, velocity, acceleration : float
        Of the body along the trough, relative to it; ``path`` since the start of the leg.
    inertial, normal : float
        Load along the trough, and force of the trough on the body.
    gap : float
        Height above the trough.
    """

    sine: float
    trough_along: float
    trough_normal: float
    path: float
    velocity: float
    acceleration: float
    inertial: float
    normal: float
    gap: float


def moment_of(loads: Loads, legs: Legs, leg: int, since: float, height: float) -> Moment:
    """Evaluate the motion in a leg.

    Parameters
    ----------
    loads, legs : Loads, Legs
        The scene and its history.
    leg, since : int, float
        Which leg, and the phase since its start, at most its length [rad].
    height : float
        The body's above the trough at the start of the history [A].
    """
    mode, start = legs.mode[leg], legs.phase[leg]
    phase = start + (wrap(since) if mode == Mode.REST else since)
    load, pressed = tangential_load(loads, phase), max(normal_load(loads, phase), 0.0)
    flies = mode == Mode.FLIGHT
    path, velocity, acceleration, gap = 0.0, 0.0, 0.0, 0.0
    if mode != Mode.REST:
        # N = -eta'': friction moves the body as far as the normal motion of a body without support would
        friction = -loads.kinetic_friction if mode == Mode.BACK else loads.kinetic_friction
        if flies:
            friction = 0.0
        acceleration = load - friction * pressed
        if since >= legs.length[leg]:
            path, velocity = legs.displacement[leg], legs.end_velocity[leg]
        else:
            along = free_along(loads, start, legs.velocity[leg], since)
            off = free_normal(loads, start, legs.rate[leg], since)
            path, velocity = along.path + friction * off.path, along.velocity + friction * off.velocity
            above = height if leg == 0 else 0.0
            gap = max(above + off.path, 0.0) if flies else 0.0
    return Moment(
        math.sin(phase), loads.drive_tangential * trough_along(loads, phase).path,
        normal_height(loads, phase), path, velocity, acceleration, load, 0.0 if flies else pressed, gap,
    )  # fmt: skip
