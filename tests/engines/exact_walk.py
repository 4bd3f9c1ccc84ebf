"""A plastic body on a level trough of steps, in rational numbers: events that coincide do so exactly."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import NamedTuple

__all__ = ["Body", "Drive", "walk"]


class Drive(NamedTuple):
    """Steps of a period of 1, each a share with accelerations along and normal; and what resists."""

    steps: list[tuple[Fraction, Fraction, Fraction]]
    static_friction: Fraction
    kinetic_friction: Fraction
    gravity: Fraction


class Body(NamedTuple):
    """Position and velocity along the trough, and height and velocity off it; in contact or not."""

    x: Fraction = Fraction(0)
    v: Fraction = Fraction(0)
    height: Fraction = Fraction(0)
    rise: Fraction = Fraction(0)
    aloft: bool = False


def walk(drive: Drive, cycles: int) -> list[Body]:
    """Return the body at the end of each cycle, from rest at phase 0, up to the first irrational event."""
    now, found = Body(), [Body()]
    for _ in range(cycles):
        for share, along, normal in drive.steps:
            left, force, load = share, -along, drive.gravity + normal
            while left > 0:
                if not now.aloft and load < 0:
                    now = now._replace(aloft=True)
                if now.aloft:
                    time = _landing(now.height, now.rise, load, left)
                    if time is None:
                        return found
                    now = _moved(now, force, load, min(time, left))
                    if time <= left:
                        brake = drive.kinetic_friction * -now.rise
                        v = math.copysign(1, now.v) * max(abs(now.v) - brake, Fraction(0))
                        now = Body(now.x, Fraction(v))
                elif now.v == 0 and abs(force) <= drive.static_friction * load:
                    break
                else:
                    way = 1 if (now.v or force) > 0 else -1
                    gain = force - way * drive.kinetic_friction * load
                    time = min(left, -now.v / gain) if now.v * gain < 0 else left
                    now = _moved(now, gain, Fraction(0), time)
                left -= min(time, left)
        found.append(now)
    return found


def _moved(now: Body, gain: Fraction, load: Fraction, time: Fraction) -> Body:
    """Move under a constant acceleration along the trough, and under a load off it."""
    x = now.x + time * (now.v + gain * time / 2)
    height = now.height + time * (now.rise - load * time / 2)
    return Body(x, now.v + gain * time, height, now.rise - load * time, now.aloft)


def _landing(height: Fraction, rise: Fraction, load: Fraction, left: Fraction) -> Fraction | None:
    """Return when a body lands, later than ``left`` if not until then; None where that is irrational."""
    later, at_end = left + 1, height + left * (rise - load * left / 2)
    dips = load < 0 and rise < 0 and rise / load < left and rise * rise + 2 * load * height >= 0
    if at_end > 0 and not dips:
        return later
    if load == 0:
        return -height / rise
    square = rise * rise + 2 * load * height
    root = Fraction(math.isqrt(square.numerator), math.isqrt(square.denominator))
    return (rise + root) / load if root * root == square else None
