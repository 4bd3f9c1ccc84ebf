"""The normal motion of a hopping body: a list of flights and impacts that friction has no part in.

It depends on the throw number K and the restitution e alone, and a contact that ends at the lift-off
phase forgets everything before it. So the flights from one such lift-off to the next make the cycle.
Phases in radians, normal speeds over n = cos(beta)/G [A w n].
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.contact.legs import until
from vibro.core.flight.landing import (
    LOST,
    SHARP,
    Blur,
    FlightList,
    Flights,
    after_landing,
    flight_list,
    landed,
    spread,
)
from vibro.core.flight.repeats import close, near_repeat
from vibro.core.flight.trajectory import ONE_CYCLE, Flight, flight, lift_off_flight
from vibro.core.groups import put, take
from vibro.core.roots import OpenCells

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.core.contact.slide import Floats

    Bools = NDArray[np.bool_]
    Counts = NDArray[np.intp]

__all__ = ["BOUNCE", "MOST_FLIGHTS", "Bounces", "bounces", "first_flight"]

_TURN: Final = 2.0 * np.pi

#: Flights, short bounces not counted, after which the search for a cycle ends.
MOST_FLIGHTS: Final = 256

#: [rad] A bounce shorter than this is one of a chain, and a chain that accumulates is one event.
BOUNCE: Final = 0.1
_MOST_BOUNCES: Final = 8192  # short ones included; restitutions above 0.995 may need more

# [rad] Rounding is no matter in hops that end in contact this soon after their lift-off. The load grows with
# the square of that time s, so that friction would bring a velocity of s^3 / 6 at most in it: ``SHARP``.
_SHORT: Final = 1.8e-3

_LOOK_BACK: Final = 8  # flights after which it looks for a cycle, and again whenever they have doubled


class Bounces(NamedTuple):
    """The steady normal motion of scenes.

    Attributes
    ----------
    cycle : FlightList
        Flights of the cycle; none where none was found.
    approach : FlightList
        Flights from the first lift-off until a cycle that begins amid the motion.
    cycles : int array
        Drive cycles that the flights and the contact after them last, to a whole cycle.
    landing : array
        Phase at which the contact begins, in [0, 2 pi) [rad].
    rest : array
        Length of the contact, 0 where the body never rests on the trough [rad].
    repeats : bool array
        Whether a cycle was found before rounding could choose it.
    """

    cycle: FlightList
    approach: FlightList
    cycles: Counts
    landing: Floats
    rest: Floats
    repeats: Bools


def bounces(
    throw: Floats,
    restitution: Floats,
    most: int = MOST_FLIGHTS,
    start: tuple[Floats, Floats] | None = None,
) -> Bounces:
    """Flights of the steady normal motion.

    Parameters
    ----------
    throw : array
        K > 1, 1-D.
    restitution : array
        e, 0 <= e < 1, 1-D.
    most : int, optional
        Flights after which the search ends.
    start : tuple of array, optional
        Phases and speeds [A w n] of the first take-offs, instead of lift-offs from rest. Rounding is no
        matter then.

    Returns
    -------
    Bounces
        From the lift-off of a resting body to the next such lift-off; if there is none, the flights of a
        cycle that never rests.

    Notes
    -----
    The rounding of the flights is carried along, Eq. (34). Where it has grown past 1e-9 before the cycle
    closes, the scene does not say which cycle it is.
    """
    n = throw.size
    lift_off = np.arcsin(1.0 / throw)
    landing, repeats, contact = np.zeros(n), np.zeros(n, np.bool_), np.zeros(n, np.bool_)
    cycles = np.zeros(n, np.intp)
    records: list[Flights] = []
    closing: list[Flights] = []
    if start is None:
        closing.append(_once_a_turn(throw, restitution))
        owner = closing[0].owner
        repeats[owner], cycles[owner] = True, 1
    owner = np.flatnonzero(~repeats)
    zero = np.zeros(owner.shape)
    begin = (lift_off[owner], zero) if start is None else start
    group = throw[owner], restitution[owner], zero, *begin, zero, Blur(zero, zero, zero)
    aloft = OpenCells(owner, group, _MOST_BOUNCES)
    for owner, (k, e, before, phase, speed, events, blur) in aloft:
        step = flight(k, phase, speed) if records or start is not None else first_flight(k)
        touch = phase + step.length
        after = after_landing(k, touch, step.impact, e)
        flights, end = landed((owner, before, phase, speed), step, touch, after)
        records.append(flights)
        turns = np.floor(end / _TURN)
        cycles[owner] += turns.astype(np.intp)
        end -= _TURN * turns
        landing[owner] = end
        blur = spread(k, e, (phase, speed), step, after.length, blur)
        short = (before + flights.length <= _SHORT) & (start is None)
        contact[owner] = repeats[owner] = after.contact & (blur.within(SHARP) | short)
        onward = ~after.contact & (blur.within(LOST) | short | (start is not None))
        count = len(records)
        if count >= _LOOK_BACK and count & (count - 1) == 0:
            guess = near_repeat(records) * onward
            for part, found, period in close(throw, restitution, records, guess):
                closing += part
                cycles[found], repeats[found] = period, True
            onward &= ~repeats[owner]
        events = events + (flights.length > BOUNCE)
        group = k, e, before + flights.length, end, after.take_off, events, blur
        aloft.keep(onward & (events < most), group)
    rest = np.where(contact, until(lift_off, landing), 0.0)
    cycles += contact & (landing + rest > lift_off + np.pi)
    amid = repeats & ~contact
    approach = flight_list([_of(part, amid) for part in records], n)
    # the last of them has become the first of the cycle
    approach = approach._replace(number=np.maximum(approach.number - 1, 0))
    cycle = flight_list([_of(part, contact) for part in records] + closing, n)
    return Bounces(cycle, approach, cycles, landing, rest, repeats)


def _of(flights: Flights, scenes: Bools) -> Flights:
    """Flights of some scenes."""
    kept = scenes[flights.owner]
    return flights if kept.all() else take(flights, np.flatnonzero(kept))


def _once_a_turn(throw: Floats, restitution: Floats) -> Flights:
    """Flights of plastic bodies that the trough throws again, at the same phase, each time they land.

    A flight of one turn from rest has K cos p = pi. It repeats if its map's slope 1 - K sin p is within
    +-1, and attracts the body from the lift-off then (tests/core/flight/test_bounces.py).
    """
    square = throw * throw - np.pi * np.pi  # (K sin p)^2
    owner = np.flatnonzero((restitution == 0.0) & (square > 1.0) & (square < 4.0))
    turn, rest = np.full(owner.size, _TURN), np.zeros(owner.size)
    return Flights(owner, rest, np.arccos(np.pi / throw[owner]), rest, turn, turn, turn)


def first_flight(throw: Floats) -> Flight:
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
