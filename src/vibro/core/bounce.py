"""The normal motion of a hopping body: a list of flights and impacts that friction has no part in.

It depends on the throw number K and the restitution e alone, and a contact that ends at the lift-off
phase forgets everything before it. So the flights from one such lift-off to the next make the cycle.
Phases in radians, normal speeds over n = cos(beta)/G [A w n].
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.flight import ONE_CYCLE, Flight, flight, lift_off_flight
from vibro.core.groups import put, take

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.core.slide import Floats

    Bools = NDArray[np.bool_]
    Counts = NDArray[np.intp]

__all__ = ["MOST_FLIGHTS", "Bounces", "Impact", "after_landing", "bounces"]

_TURN: Final = 2.0 * np.pi

#: Flights, bounces that do not accumulate included, after which the search for a repetition ends.
MOST_FLIGHTS: Final = 256

# [rad] Bounces whose remaining total length is below this are summed as if the load were constant; the
# error is of the order of its square.
_ACCUMULATED: Final = 1e-8

_LOOK_BACK: Final = (16, 32, 64, 128, MOST_FLIGHTS)  # numbers of flights after which it looks for one
_LONGEST_REPEAT: Final = 64  # flights in a cycle that never rests on the trough
_REPEATS: Final = 1e-11  # [rad, A w n] two states closer than this are one


class Impact(NamedTuple):
    """What follows a landing.

    Attributes
    ----------
    speed : array
        Normal speed of the next take-off [A w n].
    length : array
        Phase until then [rad]: 0, or that of all bounces still to come where they accumulate.
    impulse : array
        Normal impulse of the impact and of those bounces [A w n].
    contact : bool array
        Whether the body stays on the trough.
    """

    speed: Floats
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
    """Flights of scenes, one behind the other, and the contact behind the last.

    Attributes
    ----------
    first, count : int array
        Where a scene's flights begin in the arrays below, and how many there are; one entry a scene.
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
        Normal impulse behind each flight [A w n].
    """

    first: Counts
    count: Counts
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
    """One flight of each scene still under way; ``turns`` counts whole turns before it."""

    owner: Counts
    phase: Floats
    speed: Floats
    length: Floats
    impact: Floats
    impulse: Floats
    turns: Counts


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
    turns, lag = np.zeros(throw.shape, np.intp), np.zeros(throw.shape, np.intp)
    records: list[_Flights] = []
    owner = np.arange(throw.size)
    phase, speed = lift_off, np.zeros(throw.shape)
    while owner.size and len(records) < MOST_FLIGHTS:
        k = throw[owner]
        step = flight(k, phase, speed) if records else _first_flight(k)
        touch = phase + step.length
        after = after_landing(k, touch, step.impact, restitution[owner])
        end = touch + after.length
        whole = np.floor(end / _TURN).astype(np.intp)
        length = step.length + after.length
        records.append(_Flights(owner, phase, speed, length, step.impact, after.impulse, turns[owner]))
        end -= _TURN * whole
        turns[owner] += whole
        landing[owner] = end
        contact[owner] = after.contact
        bouncing = ~after.contact
        if len(records) in _LOOK_BACK:
            lag[owner] = _repeat(records)
            bouncing &= lag[owner] == 0
        owner, phase, speed = owner[bouncing], end[bouncing], after.speed[bouncing]
    return _cycle(records, landing, contact, turns, lag, lift_off)


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


def _cycle(
    records: list[_Flights], landing: Floats, contact: Bools, turns: Counts, lag: Counts, lift_off: Floats
) -> Bounces:
    """Order the flights scene by scene and keep those that repeat."""
    flights = records[0]
    if len(records) > 1:
        flights = _Flights(*(np.concatenate(parts) for parts in zip(*records, strict=True)))
        flights = take(flights, np.argsort(flights.owner, kind="stable"))
    count = np.bincount(flights.owner, minlength=landing.size)
    first = np.cumsum(count) - count
    rest = np.where(contact, np.mod(lift_off - landing, _TURN), 0.0)
    cycles = turns + (contact & (landing > lift_off))
    cells = np.flatnonzero(~contact)
    if cells.size:
        last = first[cells] + count[cells] - 1
        # without a repetition the first quarter is left to the transient
        kept = np.where(lag[cells] > 0, lag[cells], 3 * MOST_FLIGHTS // 4)
        cycles[cells] = flights.turns[last] - flights.turns[last - kept]
        skipped = np.zeros(count.shape, np.intp)
        skipped[cells] = last - kept - first[cells]
        count[cells] = kept
        position = np.arange(flights.owner.size) - first[flights.owner] - skipped[flights.owner]
        flights = take(flights, np.flatnonzero((position >= 0) & (position < count[flights.owner])))
        first = np.cumsum(count) - count
    return Bounces(
        first, count, cycles, landing, rest, contact | (lag > 0),
        flights.owner, flights.phase, flights.length, flights.impact, flights.impulse,
    )  # fmt: skip


def _repeat(records: list[_Flights]) -> Counts:
    """Least number of flights after which the last take-off was one before; 0 where there is none."""
    last = records[-1]
    found = np.zeros(last.owner.shape, np.intp)
    for lag in range(min(_LONGEST_REPEAT, len(records) - 1), 0, -1):
        before = records[-1 - lag]
        same = np.searchsorted(before.owner, last.owner)
        apart = np.abs(last.speed - before.speed[same])
        apart += np.abs(np.sin(0.5 * (last.phase - before.phase[same])))
        found[apart <= _REPEATS] = lag
    return found
