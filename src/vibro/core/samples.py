"""Long samples of the normal motion of a body that is kicked a little, for ``averages.py``.

Every excursion from the trough begins at the same phase, so that rounding would repeat one for ever. So a
body that leaves the trough after a contact gets a small normal speed. Phases in radians, normal speeds over
n = cos(beta)/G [A w n].
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from vibro.core.buffers import BODIES, MOST_HOPS
from vibro.core.drives import Loads, along_cosine
from vibro.core.flight import BOUNCE, after_landing, bed_of, flight, next_take_off
from vibro.core.return_map import Hops, write_hop
from vibro.core.waves import at_break

__all__ = ["BodySample", "fly", "kick"]

_PATIENCE: Final = 3  # [1] factor by which a part is prolonged to end with a contact
# [A w n] Normal speed with which the first body of a scene leaves the trough after a contact, at most. Each
# other is kicked by a tenth of what the one before it gets, down to what rounding does.
_KICK: Final = 1e-4
_SHOVE: Final = 1e-2  # [1] relative change of speed that parts bodies which do not come to contact
# [rad] Bounces summed too early bring a body to rest that the trough would throw again. At this duration the
# error, of the order of its square, is that of the largest kicks squared.
_ACCUMULATED: Final = 1e-4
_GOLDEN: Final = 0.6180339887498949  # [1] multiples of it are spread evenly over [0, 1), modulo 1


class BodySample(NamedTuple):
    """Hops of a body: those of its transient, and those of both halves of the sample.

    Attributes
    ----------
    first, middle, last : int
        Rows of ``Hops`` at which the halves begin, and the one behind the last hop.
    first_time, second_time : float
        Durations of the halves [rad].
    first_swing, second_swing : float
        Velocity relative to the trough, over ``drive_tangential``, that the drive adds in each half.
    trough : float
        Velocity of the trough, over ``drive_tangential``, at the start of the sample.
    aloft : float
        Time of flight in both halves [rad].
    impact : float
        Largest landing speed, that of the transient included [A w n].
    lands : bool
        Whether there is a contact, in the transient or later.
    ends : bool
        Whether the body got to the end of the sample; if not, nothing of it is of use.
    """

    first: int
    middle: int
    last: int
    first_time: float
    second_time: float
    first_swing: float
    second_swing: float
    trough: float
    aloft: float
    impact: float
    lands: bool
    ends: bool


def fly(loads: Loads, restitution: float, body: int, length: int, hops: Hops, row: int) -> BodySample:
    """Fly a body that starts from rest through its transient and its sample.

    Parameters
    ----------
    loads : Loads
        Groups of its scene.
    restitution : float
        e.
    body : int
        Which of the ``BODIES`` of the scene it is.
    length : int
        Events in each half of the sample: flights, of which a chain of short bounces counts as one. A part
        ends with a contact, if there is any: whole excursions have no end effects.
    hops : Hops
        Its hops are written here.
    row : int
        Where the first one goes; up to ``MOST_HOPS`` rows are filled.
    """
    bed = bed_of(loads)
    phase, speed = bed.lift_off, kick(0, body)
    # parts 0 and 1 are the transient, 2 and 3 the halves of the sample
    part, events, has_landed = 0, 0, False
    quota = length // 2 + body  # so that what repeats all the same is met at different moments
    first, middle, trough, trough_between = row, row, 0.0, 0.0
    first_time, second_time, aloft, impact, lands = 0.0, 0.0, 0.0, 0.0, False
    for last in range(row + 1, row + MOST_HOPS + 1):
        flown = flight(bed, phase, speed)
        touch = phase + flown.length
        after = after_landing(bed, touch, flown.impact, restitution, _ACCUMULATED)
        hop, landing = flown.length + after.length, at_break(bed.waves, touch + after.length)
        again = next_take_off(bed, landing)
        rest = again.wait if after.contact else 0.0
        write_hop(loads, phase, hop, after.impulse, hops, last - 1)
        hops.landing[last - 1] = landing
        hops.rest[last - 1] = rest
        impact, lands, has_landed = (
            max(impact, flown.impact),
            lands or rest > 0.0,
            has_landed or after.contact,
        )
        if part == 2:
            first_time += hop + rest
        elif part == 3:
            second_time += hop + rest
        if part >= 2:
            aloft += hop
        if hop > BOUNCE or after.contact:
            events += 1
        # a shove before the first contact would hide what soft kicks do not change
        ready = after.contact or not (has_landed or (part == 0 and body >= BODIES // 2))
        phase, speed = landing, after.take_off
        if after.contact:
            phase, speed = again.phase, kick(last - row, body)
        if events < quota or not (ready or events >= _PATIENCE * quota):
            continue
        events, part = 0, part + 1
        if part == 1 and has_landed:
            part = 2
        if part == 1:
            # a body that has not come to contact is shoved, and gets another transient
            speed *= 1.0 + _SHOVE * _spread(last - row, body)
        elif part == 2:
            quota, first, trough = length, last, along_cosine(loads, phase)
        elif part == 3:
            middle, trough_between = last, along_cosine(loads, phase)
        else:
            second_swing = trough_between - along_cosine(loads, phase)
            return BodySample(
                first, middle, last, first_time, second_time, trough - trough_between, second_swing, trough,
                aloft, impact, lands, True,
            )  # fmt: skip
    return BodySample(first, middle, row + MOST_HOPS, 0.0, 0.0, 0.0, 0.0, trough, aloft, impact, lands, False)


def _spread(count: int, body: int) -> float:
    """Return numbers in [0, 1), spread evenly over bodies and times, and the same in every run."""
    x = _GOLDEN * (BODIES * count + body + 1)
    return x - math.floor(x)


def kick(count: int, body: int) -> float:
    """Return the speed with which a body leaves the trough after a contact."""
    kick = _KICK
    for _ in range(body):
        kick /= 10.0
    return kick * _spread(count, body)
