"""The normal motion of a hopping body: a list of flights and impacts that friction has no part in.

It depends on the throw number K and the restitution e alone, and a contact that ends at the lift-off
phase forgets everything before it. So the flights from one such lift-off to the next make the cycle.
Phases in radians, normal speeds over n = cos(beta)/G [A w n].
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.contact.legs import until
from vibro.core.flight.trajectory import ONE_CYCLE, Flight, flight, lift_off_flight
from vibro.core.groups import put, take
from vibro.core.roots import OpenCells

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from vibro.core.contact.slide import Floats

    Bools = NDArray[np.bool_]
    Counts = NDArray[np.intp]

__all__ = ["MOST_FLIGHTS", "Bounces", "Impact", "after_landing", "bounces"]

_TURN: Final = 2.0 * np.pi

#: Flights, bounces that do not accumulate included, after which the search for a cycle ends.
MOST_FLIGHTS: Final = 256

# [rad] Bounces whose remaining total length is below this are summed as if the load were constant; the
# error is of the order of its square.
_ACCUMULATED: Final = 1e-8

_LOOK_BACK: Final = (8, 16, 32, 64, 128, MOST_FLIGHTS)  # numbers of flights after which it looks for a cycle
_LONGEST_CYCLE: Final = 64  # flights in a cycle that never rests on the trough
_NEAR: Final = 0.1  # [rad, A w n] distance, over the number of flights between, of states that may be one
_PREFERRED: Final = 4.0  # [1] factor by which more flights must bring a state closer to be preferred
_NEWTON_STEPS: Final = 12
_FIRST_STEP: Final = 0.1  # [rad, A w n] longest first step
_SHRINKS: Final = 0.75  # [1] a longer next step, over the one before, shows that there is no cycle nearby
_CLOSED: Final = 1e-12  # [1] relative distance at which a cycle is closed
_SAME: Final = 1e-8  # [1] relative distance below which a cycle repeats within itself


class Impact(NamedTuple):
    """What follows a landing.

    Attributes
    ----------
    take_off : array
        Normal speed of the next take-off [A w n].
    length : array
        Phase until then [rad]: 0, or that of all bounces still to come where they accumulate.
    impulse : array
        Normal impulse of the impact and of those bounces [A w n].
    contact : bool array
        Whether the body stays on the trough.
    """

    take_off: Floats
    length: Floats
    impulse: Floats
    contact: Bools


def after_landing(throw: Floats, phase: Floats, impact: Floats, restitution: Floats) -> Impact:
    """Apply the impact law, Eq. (31), and sum the bounces that accumulate, Eq. (33).

    Bounces of take-off speed v, e v, e^2 v, ... under the load N last 2 v / (N (1 - e)) altogether and
    bring the impulse (1 + e) v / (1 - e), the one that starts them not counted.
    """
    load = 1.0 - throw * np.sin(phase)
    speed = restitution * impact
    impulse = impact + speed
    with np.errstate(divide="ignore", invalid="ignore"):
        rest = np.where(speed > 0.0, 2.0 * speed / (load * (1.0 - restitution)), 0.0)
    contact = (load >= 0.0) & (rest <= _ACCUMULATED)
    length = np.where(contact, rest, 0.0)
    tail = np.where(contact, speed * (1.0 + restitution) / (1.0 - restitution), 0.0)
    return Impact(np.where(contact, 0.0, speed), length, impulse + tail, contact)


class Bounces(NamedTuple):
    """Flights of scenes, one after the other, and the contact after the last.

    Attributes
    ----------
    first, number : int array
        Where a scene's flights begin in the arrays below, and how many there are; one element per
        scene.
    cycles : int array
        Drive cycles that they and the contact last, to a whole cycle.
    landing : array
        Phase at which the contact begins, in [0, 2 pi) [rad].
    rest : array
        Length of the contact, 0 where the body never rests on the trough [rad].
    repeats : bool array
        Whether they are a cycle; otherwise they are a long sample of a motion without a short period.
    owner : int array
        Scene of each flight.
    phase, length : array
        Take-off phase in [0, 2 pi) and length of each flight, with the bounces that it sums [rad].
    impact : array
        Landing speed of each flight [A w n].
    impulse : array
        Normal impulse of the landing of each flight, with the bounces that it sums [A w n].
    """

    first: Counts
    number: Counts
    cycles: Counts
    landing: Floats
    rest: Floats
    repeats: Bools
    owner: Counts
    phase: Floats
    length: Floats
    impact: Floats
    impulse: Floats


class _Flights(NamedTuple):
    """One flight of each scene still under way; ``before`` is the phase elapsed until its take-off."""

    owner: Counts
    before: Floats
    phase: Floats
    speed: Floats
    length: Floats
    impact: Floats
    impulse: Floats


def bounces(throw: Floats, restitution: Floats) -> Bounces:
    """Flights of the steady normal motion.

    Parameters
    ----------
    throw : array
        K > 1, 1-D.
    restitution : array
        e, 0 <= e < 1, 1-D.

    Returns
    -------
    Bounces
        From the lift-off of a resting body to the next such lift-off; if there is none within
        ``MOST_FLIGHTS``, the flights of a cycle that never rests, or a long sample.
    """
    lift_off = np.arcsin(1.0 / throw)
    landing, contact = np.zeros(throw.shape), np.zeros(throw.shape, np.bool_)
    cycles, lag = np.zeros(throw.shape, np.intp), np.zeros(throw.shape, np.intp)
    records: list[_Flights] = []
    closing = [_once_a_turn(throw, restitution)]
    lag[closing[0].owner] = cycles[closing[0].owner] = 1
    owner = np.flatnonzero(lag == 0)
    zero = np.zeros(owner.shape)
    group = throw[owner], restitution[owner], zero, lift_off[owner], zero
    aloft = OpenCells(owner, group, MOST_FLIGHTS)
    for owner, (k, e, before, phase, speed) in aloft:
        step = flight(k, phase, speed) if records else _first_flight(k)
        flights, end, after = _landed((owner, before, phase, speed), k, e, step)
        records.append(flights)
        turns = np.floor(end / _TURN)
        cycles[owner] += turns.astype(np.intp)
        end -= _TURN * turns
        landing[owner] = end
        contact[owner] = after.contact
        bouncing = ~after.contact
        if len(records) in _LOOK_BACK:
            guess = _near_repeat(records) * bouncing
            for part, found, period in _close(throw, restitution, records, guess):
                closing += part
                lag[found] = len(part)
                cycles[found] = period
            bouncing &= lag[owner] == 0
        aloft.keep(bouncing, (k, e, before + flights.length, end, after.take_off))
    rest = np.where(contact, until(lift_off, landing), 0.0)
    cycles += contact & (landing + rest > lift_off + np.pi)
    # of a motion without a cycle the first quarter is left to the transient
    kept = np.where(contact, MOST_FLIGHTS, np.where(lag > 0, lag, 3 * MOST_FLIGHTS // 4))
    first, count, flights = _ordered(records + closing, kept)
    return Bounces(
        first, count, cycles, landing, rest, contact | (lag > 0),
        flights.owner, flights.phase, flights.length, flights.impact, flights.impulse,
    )  # fmt: skip


def _once_a_turn(throw: Floats, restitution: Floats) -> _Flights:
    """Flights of plastic bodies that the trough throws again, at the same phase, each time they land.

    A flight of one turn from rest has K cos p = pi. It repeats if its map's slope 1 - K sin p is within
    +-1, and attracts the body from the lift-off then (tests/core/flight/test_bounces.py).
    """
    square = throw * throw - np.pi * np.pi  # (K sin p)^2
    owner = np.flatnonzero((restitution == 0.0) & (square > 1.0) & (square < 4.0))
    turn, rest = np.full(owner.size, _TURN), np.zeros(owner.size)
    return _Flights(owner, rest, np.arccos(np.pi / throw[owner]), rest, turn, turn, turn)


def _landed(
    start: tuple[Counts, Floats, Floats, Floats], throw: Floats, restitution: Floats, step: Flight
) -> tuple[_Flights, Floats, Impact]:
    """Flights with what follows their landings, and the phase at which that is over."""
    phase = start[2]
    touch = phase + step.length
    after = after_landing(throw, touch, step.impact, restitution)
    length = step.length + after.length
    return _Flights(*start, length, step.impact, after.impulse), touch + after.length, after


def _first_flight(throw: Floats) -> Flight:
    """Flight from the lift-off of a resting body."""
    c = np.sqrt((throw - 1.0) * (throw + 1.0))
    out = Flight(np.empty(c.shape), np.empty(c.shape))
    short = np.flatnonzero(c <= ONE_CYCLE)
    put(out, short, lift_off_flight(c[short]))
    long = np.flatnonzero(c > ONE_CYCLE)
    if long.size:
        k = throw[long]
        put(out, long, flight(k, np.arcsin(1.0 / k), np.zeros(k.shape)))
    return out


def _ordered(records: list[_Flights], kept: Counts) -> tuple[Counts, Counts, _Flights]:
    """Order flights scene by scene and keep the last so many of each."""
    flights = records[0]
    if sum(part.owner.size > 0 for part in records) > 1:
        flights = _Flights(*(np.concatenate(parts) for parts in zip(*records, strict=True)))
        flights = take(flights, np.argsort(flights.owner, kind="stable"))
    count = np.bincount(flights.owner, minlength=kept.size)
    end = np.cumsum(count)
    if (count > kept).any():
        chosen = np.arange(flights.owner.size) >= (end - kept)[flights.owner]
        flights, count = take(flights, np.flatnonzero(chosen)), np.minimum(count, kept)
        end = np.cumsum(count)
    return end - count, count, flights


def _near_repeat(records: list[_Flights]) -> Counts:
    """Count back to the flight that began nearly as the last did; 0 where there is none."""
    last = records[-1]
    found = np.zeros(last.owner.shape, np.intp)
    nearest = np.full(last.owner.shape, _NEAR)
    for lag in range(1, min(_LONGEST_CYCLE, len(records) // 2) + 1):
        before = take(records[-1 - lag], np.searchsorted(records[-1 - lag].owner, last.owner))
        apart = lag * _apart(before.phase, before.speed, last.phase, last.speed)
        closer = (apart < nearest) & (last.before - before.before > np.pi)  # not within one chain of bounces
        found[closer] = lag
        nearest[closer] = apart[closer] / _PREFERRED
    return found


def _apart(phase: Floats, speed: Floats, other_phase: Floats, other_speed: Floats) -> Floats:
    return np.abs(2.0 * np.sin(0.5 * (phase - other_phase))) + np.abs(speed - other_speed)


def _close(
    throw: Floats, restitution: Floats, records: list[_Flights], guess: Counts
) -> Iterator[tuple[list[_Flights], Counts, Counts]]:
    """Solve cycles of ``guess`` flights by Newton's iteration, from the last take-offs.

    Yields the flights of the stable ones, their scenes and their periods, for each number of flights.
    """
    for lag in np.unique(guess[guess > 0]).tolist():
        last = take(records[-1], np.flatnonzero(guess == lag))
        group = throw[last.owner], restitution[last.owner], last.phase, last.speed
        unclosed = OpenCells(last.owner, (*group, np.full(last.owner.shape, _FIRST_STEP)), _NEWTON_STEPS)
        for owner, (k, e, phase, speed, least) in unclosed:
            flights, end, slope, valid = _around(owner, k, e, phase, speed, lag)
            turn = np.mod(end[0] - phase + np.pi, _TURN) - np.pi
            residual = np.stack((turn, end[1] - speed))
            matrix = np.eye(2)[:, :, None] - slope
            determinant = matrix[0, 0] * matrix[1, 1] - matrix[0, 1] * matrix[1, 0]
            with np.errstate(divide="ignore", invalid="ignore"):
                step_phase = (matrix[1, 1] * residual[0] - matrix[0, 1] * residual[1]) / determinant
                step_speed = (matrix[0, 0] * residual[1] - matrix[1, 0] * residual[0]) / determinant
                step = np.abs(step_phase) + np.abs(step_speed)
                onward = np.mod(phase + step_phase, _TURN), np.maximum(speed + step_speed, 0.0)
            closed = step <= _CLOSED * (1.0 + k)
            trace = slope[0, 0] + slope[1, 1]
            product = slope[0, 0] * slope[1, 1] - slope[0, 1] * slope[1, 0]
            stable = (np.abs(trace) < 1.0 + product) & (np.abs(product) < 1.0)
            done = np.flatnonzero(closed & valid & stable)
            if done.size:
                yield from _shortest(take(tuple(flights), done), phase[done], end[0][done], lag)
            unclosed.keep(valid & ~closed & (step < least), (k, e, *onward, _SHRINKS * step))


def _around(
    owner: Counts, throw: Floats, restitution: Floats, phase: Floats, speed: Floats, lag: int
) -> tuple[list[_Flights], tuple[Floats, Floats], Floats, Bools]:
    """Fly ``lag`` times; return the flights, the state after them, its derivatives and whether none rests."""
    flights = []
    slope = np.eye(2)[:, :, None] * np.ones(phase.size)
    valid = np.ones(phase.shape, np.bool_)
    total = phase.copy()
    for _ in range(lag):
        # a resting start that the trough would not let go stays where it is
        valid &= (speed > 0.0) | (throw * np.sin(phase) > 1.0)
        start = np.where(valid, phase, 0.5 * np.pi)
        step = flight(throw, start, speed)
        record, end, after = _landed((owner, total, start, speed), throw, restitution, step)
        valid &= ~after.contact & (step.impact > 0.0)
        sine, cosine, touch = np.sin(start), np.cos(start), start + step.length
        lever = throw * (cosine - np.cos(touch))
        impact = np.where(valid, step.impact, 1.0)
        d_phase, d_speed = slope
        d_end = d_phase + (d_phase * (lever - throw * step.length * sine) + d_speed * step.length) / impact
        d_rate = d_speed + throw * (np.sin(touch) * d_end - sine * d_phase) - (d_end - d_phase)
        slope = np.stack((d_end, -restitution * d_rate))
        flights.append(record)
        total = total + step.length
        phase, speed = np.mod(end, _TURN), after.take_off
    return flights, (total, speed), slope, valid


def _shortest(
    flights: tuple[_Flights, ...], phase: Floats, end: Floats, lag: int
) -> Iterator[tuple[list[_Flights], Counts, Counts]]:
    """Cut cycles that repeat within themselves."""
    period = np.rint((end - phase) / _TURN).astype(np.intp)
    left = np.ones(phase.shape, np.bool_)
    first = flights[0]
    for part in (n for n in range(1, lag + 1) if lag % n == 0):
        again = left.copy()
        if part < lag:
            apart = _apart(first.phase, first.speed, flights[part].phase, flights[part].speed)
            again &= apart <= _SAME * (1.0 + first.impact)
        cells = np.flatnonzero(again)
        if cells.size:
            yield list(take(flights[:part], cells)), first.owner[cells], period[cells] * part // lag
        left &= ~again
