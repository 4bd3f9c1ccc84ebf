"""A plastic body on a trough of steps, piece after piece: in rational numbers, or in doubles.

In rational numbers events that coincide do so exactly.
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any, NamedTuple

_CYCLES = 2000


class Drive(NamedTuple):
    """Steps of a period, each a share with accelerations along and normal; and what resists.

    The weight over mass acts normal to the trough, and down it.
    """

    steps: list[tuple[Any, Any, Any]]
    static_friction: Any
    kinetic_friction: Any
    weight_normal: Any
    weight_downhill: Any = 0
    period: Any = 1


class Body(NamedTuple):
    """Position and velocity along the trough, and height and velocity off it; in contact or not."""

    x: Any = Fraction(0)
    v: Any = Fraction(0)
    height: Any = Fraction(0)
    rise: Any = Fraction(0)
    aloft: bool = False


def walk(drive: Drive, cycles: int) -> list[Body]:
    """Return the body at the end of each cycle, from rest at phase 0.

    In rational numbers up to the first irrational event.
    """
    found = [Body()]
    while len(found) <= cycles and (now := _cycle(drive, found[-1])) is not None:
        found.append(now)
    return found


def displacement(drive: Drive) -> float:
    """Return the displacement in a cycle that repeats, from rest, in doubles; NaN where none does."""
    now, before = Body(0.0, 0.0, 0.0, 0.0), math.nan
    for _ in range(_CYCLES):
        moved = _cycle(drive, now._replace(x=0.0))
        assert moved is not None
        if not moved.aloft and abs(moved.x - before) <= 1e-15 * abs(moved.x):
            return float(moved.x)
        now, before = moved, moved.x
    return math.nan


def _cycle(drive: Drive, now: Body) -> Body | None:
    """Follow a cycle; None where that leads to an event that is not rational."""
    for share, along, normal in drive.steps:
        left, force = share * drive.period, -along - drive.weight_downhill
        load = drive.weight_normal + normal
        while left > 0:
            if not now.aloft and load < 0:
                now = now._replace(aloft=True)
            if now.aloft:
                time = _landing(now.height, now.rise, load, left)
                if time is None:
                    return None
                now = _moved(now, force, load, min(time, left))
                if time <= left:
                    speed = max(abs(now.v) - drive.kinetic_friction * -now.rise, 0 * left)
                    now = Body(now.x, speed if now.v > 0 else -speed, 0 * left, 0 * left)
            elif now.v == 0 and abs(force) <= drive.static_friction * load:
                break
            else:
                way = 1 if (now.v or force) > 0 else -1
                gain = force - way * drive.kinetic_friction * load
                stop = -now.v / gain if now.v * gain < 0 else left + 1
                time = min(left, stop)
                now = _moved(now, gain, 0 * left, time)
                now = now._replace(v=0 * left) if stop <= left else now
            left -= min(time, left)
    return now


def _moved(now: Body, gain: Any, load: Any, time: Any) -> Body:
    """Move under a constant acceleration along the trough, and under a load off it."""
    x = now.x + time * (now.v + gain * time / 2)
    height = now.height + time * (now.rise - load * time / 2)
    return Body(x, now.v + gain * time, height, now.rise - load * time, now.aloft)


def _landing(height: Any, rise: Any, load: Any, left: Any) -> Any:
    """Return when a body lands, later than ``left`` if not until then; None where that is irrational."""
    later, at_end = left + 1, height + left * (rise - load * left / 2)
    dips = load < 0 and rise < 0 and rise / load < left and rise * rise + 2 * load * height >= 0
    if at_end > 0 and not dips:
        return later
    if load == 0:
        return -height / rise
    root = _root(rise * rise + 2 * load * height)
    return None if root is None else (rise + root) / load


def _root(square: Any) -> Any:
    if isinstance(square, float):
        return math.sqrt(max(square, 0.0))
    root = Fraction(math.isqrt(square.numerator), math.isqrt(square.denominator))
    return root if root * root == square else None
