"""Long samples of the normal motion of bodies that are kicked a little, for ``averages.py``.

Phases in radians, normal speeds over n = cos(beta)/G [A w n].
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.contact.legs import until
from vibro.core.flight.bounces import BOUNCE
from vibro.core.flight.landing import Flights, after_landing, flight_list, landed
from vibro.core.flight.returns import Hops, hops_of
from vibro.core.flight.trajectory import flight
from vibro.core.groups import take
from vibro.core.roots import OpenCells

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.core.contact.slide import Floats
    from vibro.core.groups import Loads

    Bools = NDArray[np.bool_]
    Counts = NDArray[np.intp]

__all__ = ["BODIES", "Sample", "fly"]

_TURN: Final = 2.0 * np.pi

#: Bodies of each scene.
BODIES: Final = 12

_PATIENCE: Final = 3  # factor by which a part is prolonged to end with a contact
_PARTS: Final = 4
# [A w n] Normal speed with which the first body of a scene leaves the trough after a contact, at most. Each
# other is kicked by a tenth of what the one before it gets, down to what rounding does.
_KICK: Final = 1e-4
_SHOVE: Final = 1e-2  # [1] relative change of speed that parts bodies which do not come to contact
# [rad] Here the error of summing bounces, of the order of the square of this, is far below that of a mean.
_ACCUMULATED: Final = 5e-2
_MOST_BOUNCES: Final = 10_000
_GOLDEN: Final = 0.6180339887498949  # multiples of it are spread evenly over [0, 1), modulo 1


class Sample(NamedTuple):
    """Flights of bodies, in four parts: two of the transient, and the halves of the sample.

    Attributes
    ----------
    hops : Hops
        What each flight, and the contact after it, does to the motion along the trough.
    first, number : int array
        Where the flights of a part begin, and how many there are; as the next three of shape (4, bodies).
    time, aloft : array
        Duration of each part, and of the flights in it [rad].
    swing : array
        Velocity relative to the trough, over ``along``, that the drive adds in a part.
    trough : array
        Velocity of the trough, over ``along``, at the start of the sample; one element per body, as are the
        next three.
    impact : array
        Largest landing speed [A w n].
    lands, ends : bool array
        Whether there is a contact, and whether the sample was completed.
    """

    hops: Hops
    first: Counts
    number: Counts
    time: Floats
    aloft: Floats
    swing: Floats
    trough: Floats
    impact: Floats
    lands: Bools
    ends: Bools


def fly(scene: Loads, throw: Floats, restitution: Floats, body: Counts, length: int) -> Sample:
    """Fly the transient and the sample of bodies that start from rest.

    Parameters
    ----------
    scene : Loads
        Groups of the bodies' scenes, 1-D, or 0-d members for all.
    throw, restitution : array
        K and e.
    body : int array
        Which of the ``BODIES`` of its scene each is.
    length : int
        Events in each half of the sample: flights, of which a chain of short bounces counts as one.
        A part ends with a contact, if there is any: whole excursions have no end effects.

    Returns
    -------
    Sample
        The same whatever scenes are flown together.
    """
    n = throw.size
    lift_off = np.arcsin(1.0 / throw)
    records: list[Flights] = []
    contacts: list[tuple[Floats, Floats, Counts]] = []
    events, part, lands = np.zeros(n, np.intp), np.zeros(n, np.intp), np.zeros(n, np.bool_)
    quota = length // 2 + body  # so that what repeats all the same is met at different moments
    state = lift_off, _kick(0, body), events, part, lands, quota
    aloft = OpenCells(np.arange(n), (throw, restitution, lift_off, body, *state), _MOST_BOUNCES)
    for owner, (k, e, lifts, body, phase, speed, events, part, lands, quota) in aloft:
        step = flight(k, phase, speed)
        touch = phase + step.length
        after = after_landing(k, touch, step.impact, e, _ACCUMULATED)
        hop, end = landed((owner, np.zeros(owner.size), phase, speed), step, touch, after)
        landing = np.mod(end, _TURN)
        rest = np.where(after.contact, until(lifts, landing), 0.0)
        records.append(hop)
        contacts.append((landing, rest, _PARTS * owner + part))
        events = events + ((hop.length > BOUNCE) | after.contact)
        lands = lands | after.contact
        # what soft kicks do not change is not to be lost by a shove before the first contact
        ready = after.contact | ~(lands | ((part == 0) & (body >= BODIES // 2)))
        over = (events >= quota) & (ready | (events >= _PATIENCE * quota))
        phase = np.where(after.contact, lifts, landing)
        speed = np.where(after.contact, _kick(len(records), body), after.take_off)
        # a body that has not come to contact is shoved, and gets another lead
        begins = over & (part == 0)
        speed *= np.where(begins & ~lands, 1.0 + _SHOVE * _spread(len(records), body), 1.0)
        part = part + over + (begins & lands)
        quota = np.where(part > 1, length, quota)
        events = np.where(over, 0, events)
        aloft.keep(part < _PARTS, (k, e, lifts, body, phase, speed, events, part, lands, quota))
    ends = np.ones(n, np.bool_)
    ends[aloft.cells] = False

    flights = flight_list(records, n)
    order = np.argsort(np.concatenate([x.owner for x in records]), kind="stable")
    landing, rest = (np.concatenate([x[i] for x in contacts])[order] for i in (0, 1))
    of_part = np.concatenate([x[2] for x in contacts])[order]
    hops = hops_of(scene, flights)._replace(landing=landing, rest=rest)
    landed_on = np.bincount(flights.owner, rest, n) > 0.0
    impact = np.zeros(n)
    np.maximum.at(impact, flights.owner, flights.impact)

    def sums(weights: Floats | None = None) -> Floats:
        """Sum over the flights of each part."""
        total = np.bincount(of_part, weights, _PARTS * n).reshape(n, _PARTS).T
        return np.asarray(total, np.float64)

    number: Counts = sums().astype(np.intp)
    first = flights.first + np.cumsum(number, axis=0) - number
    trough = take(scene, flights.owner)
    velocity = trough.along_cosine(flights.phase)  # at the start of each part and at the end of the last
    begin = velocity[np.minimum(first, velocity.size - 1)]
    last = np.minimum(first[-1] + number[-1] - 1, velocity.size - 1)
    stop = scene.along_cosine(np.where(rest[last] > 0.0, lift_off, landing[last]))
    swing = begin - np.concatenate((begin[1:], stop[None]))
    time, time_aloft = sums(flights.length + rest), sums(flights.length)
    return Sample(hops, first, number, time, time_aloft, swing, begin[2], impact, landed_on, ends)


def _spread(flights: int, body: Counts) -> Floats:
    """Numbers in [0, 1), spread evenly over bodies and times, and the same in every run."""
    numbers: Floats = np.mod(_GOLDEN * (BODIES * flights + body + 1), 1.0)
    return numbers


def _kick(flights: int, body: Counts) -> Floats:
    """Speeds with which bodies leave the trough after a contact."""
    kick: Floats = _KICK * 10.0**-body * _spread(flights, body)
    return kick
