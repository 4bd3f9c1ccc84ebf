"""What follows a landing: the next take-off, the bounces that accumulate, and how errors grow on the way.

Phases in radians, normal speeds over n = cos(beta)/G [A w n].
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.free import free_motion
from vibro.core.groups import take

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.core.contact.slide import Floats
    from vibro.core.flight.trajectory import Flight

    Bools = NDArray[np.bool_]
    Counts = NDArray[np.intp]

__all__ = [
    "LOST",
    "SHARP",
    "Blur",
    "FlightList",
    "Flights",
    "Impact",
    "after_landing",
    "carried",
    "flight_list",
    "landed",
    "spread",
]

_TURN: Final = 2.0 * np.pi

# [rad] Bounces whose remaining total length is below this are summed as if the load were constant; the
# error is of the order of its square.
_ACCUMULATED: Final = 1e-8

_NONE: Final = np.zeros(())
_ROUNDING: Final = 2.0**-52  # [1] of a landing, relative to the terms whose sum vanishes there
#: [rad, A w n] Standard errors up to which a contact closes a cycle, and above which what comes next may be
#: chosen by rounding.
SHARP: Final = 1e-9
LOST: Final = 1e-5


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


def after_landing(
    throw: Floats, phase: Floats, impact: Floats, restitution: Floats, accumulated: float = _ACCUMULATED
) -> Impact:
    """Apply the impact law, Eq. (31), and sum the bounces that accumulate, Eq. (33).

    Bounces of take-off speed v, e v, e^2 v, ... under the load N last 2 v / (N (1 - e)) altogether and
    bring the impulse (1 + e) v / (1 - e), the one that starts them not counted. They are summed once they
    last no longer than ``accumulated`` [rad], and end before the trough can fall away.
    """
    load = 1.0 - throw * np.sin(phase)
    speed = restitution * impact
    impulse = impact + speed
    with np.errstate(divide="ignore", invalid="ignore"):
        rest = np.where(speed > 0.0, 2.0 * speed / (load * (1.0 - restitution)), 0.0)
    contact = (load >= 0.0) & (rest <= accumulated)
    bounces = contact & (rest > 0.0)
    if np.count_nonzero(bounces):
        contact &= load >= throw * np.maximum(np.cos(phase), 0.0) * np.where(bounces, rest, 0.0)
    length = np.where(contact, rest, 0.0)
    tail = np.where(contact, speed * (1.0 + restitution) / (1.0 - restitution), 0.0)
    return Impact(np.where(contact, 0.0, speed), length, impulse + tail, contact)


class Flights(NamedTuple):
    """Flights of scenes; ``before`` is the phase elapsed until their take-offs.

    ``length`` and ``impulse`` contain the bounces that are summed after the landing.
    """

    owner: Counts
    before: Floats
    phase: Floats
    speed: Floats
    length: Floats
    impact: Floats
    impulse: Floats


class FlightList(NamedTuple):
    """Flights of scenes, one after the other.

    Attributes
    ----------
    first, number : int array
        Where a scene's flights begin in the arrays below, and how many there are; one element per scene.
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
    owner: Counts
    phase: Floats
    length: Floats
    impact: Floats
    impulse: Floats


def flight_list(records: list[Flights], scenes: int) -> FlightList:
    """Order flights scene by scene, and of each scene as the records have them."""
    filled = [part for part in records if part.owner.size]
    flights = filled[0] if filled else Flights(np.zeros(0, np.intp), *np.zeros((6, 0)))
    if len(filled) > 1:
        flights = Flights(*(np.concatenate(parts) for parts in zip(*filled, strict=True)))
        flights = take(flights, np.argsort(flights.owner, kind="stable"))
    number = np.bincount(flights.owner, minlength=scenes)
    first = np.cumsum(number) - number
    return FlightList(
        first, number, flights.owner, flights.phase, flights.length, flights.impact, flights.impulse
    )


def landed(
    start: tuple[Counts, Floats, Floats, Floats], step: Flight, touch: Floats, after: Impact
) -> tuple[Flights, Floats]:
    """Flights with what follows their landings, and the phase at which that is over."""
    return Flights(*start, step.length + after.length, step.impact, after.impulse), touch + after.length


def carried(
    throw: Floats,
    restitution: Floats,
    phase: Floats,
    step: Flight,
    change: tuple[Floats, Floats],
) -> tuple[Floats, Floats]:
    """Carry small changes of a take-off's phase and speed to the next take-off, to first order, Eq. (34)."""
    d_phase, d_speed = change
    lever, swing = free_motion(throw, _NONE, np.cos(phase), -np.sin(phase), _NONE, step.length)
    late = (d_phase * lever + d_speed * step.length) / step.impact
    d_rate = d_speed + d_phase * swing + (throw * np.sin(phase + step.length) - 1.0) * late
    return d_phase + late, -restitution * d_rate


class Blur(NamedTuple):
    """Variances of the rounding in a take-off's phase and speed, and their covariance."""

    phase: Floats
    both: Floats
    speed: Floats

    def within(self, error: float) -> Bools:
        """Whether both standard errors are below a limit."""
        known: Bools = (self.phase <= error**2) & (self.speed <= error**2)
        return known


def spread(
    throw: Floats, restitution: Floats, start: tuple[Floats, Floats], step: Flight, tail: Floats, blur: Blur
) -> Blur:
    """Carry the blur of take-offs to the next ones, and add the rounding of the flights between.

    ``start`` is the phase and the speed of the take-offs, ``tail`` the length of the bounces summed after the
    landing.

    Irregular motion multiplies small errors by a factor at every flight, and so do grazing landings. A sum
    of absolute values would grow in every chain of bounces too; variances follow what errors do.
    """
    phase, speed = start
    one, none = np.ones(()), np.zeros(())
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        a, c = carried(throw, restitution, phase, step, (one, none))
        b, d = carried(throw, restitution, phase, step, (none, one))
        s, swing = step.length, throw * np.minimum(step.length, 1.0)
        # a flight from a lift-off within a turn has all digits, however short (``lift_off_flight``)
        released = (speed == 0.0) & (s <= _TURN) & (np.abs(throw * np.sin(phase) - 1.0) <= 4.0 * _ROUNDING)
        terms = np.where(released, 0.0, speed + swing + 0.5 * s)
        late = _ROUNDING * (1.0 + s + s * terms / step.impact)
        fast = _ROUNDING * restitution * (speed + swing + s)
        variance = np.maximum(a * (a * blur.phase + 2.0 * b * blur.both) + b * b * blur.speed, 0.0)
        both = a * c * blur.phase + (a * d + b * c) * blur.both + b * d * blur.speed
        rate = np.maximum(c * (c * blur.phase + 2.0 * d * blur.both) + d * d * blur.speed, 0.0)
        # bounces that accumulate last in proportion to the speed of the first
        lever = np.where(tail > 0.0, tail / (restitution * step.impact), 0.0)
        return Blur(variance + late * late + lever * lever * rate, both, rate + fast * fast)
