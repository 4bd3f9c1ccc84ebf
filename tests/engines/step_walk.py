"""Steady displacement in contact of a trough whose acceleration is constant on steps: piece after piece."""

from __future__ import annotations

import math
from typing import NamedTuple

__all__ = ["Steps", "displacement"]

_CYCLES = 4000


class Steps(NamedTuple):
    """Steps of a trough, and what acts on a body: its weight normal to the trough and down it, over mass."""

    shares: list[float]
    along: list[float]
    normal: list[float]
    static_friction: float
    kinetic_friction: float
    weight_normal: float
    weight_downhill: float
    period: float


def displacement(steps: Steps) -> float:
    """Return the displacement in a cycle that repeats, from rest; NaN where none does, or the body hops."""
    before, speed = math.nan, 0.0
    for _ in range(_CYCLES):
        moved = 0.0
        for share, along, normal in zip(steps.shares, steps.along, steps.normal, strict=True):
            left, force = share * steps.period, -along - steps.weight_downhill
            load = steps.weight_normal + normal
            if load <= 0.0:
                return math.nan
            while left > 0.0:
                if speed == 0.0 and abs(force) <= steps.static_friction * load:
                    break
                way = math.copysign(1.0, speed or force)
                gain = force - way * steps.kinetic_friction * load
                time = left
                if speed * gain < 0.0:
                    time = min(left, -speed / gain)
                moved += time * (speed + 0.5 * gain * time)
                stops = time < left or speed + gain * time == 0.0
                speed = 0.0 if stops else speed + gain * time
                left -= time
        if abs(moved - before) <= 1e-15 * abs(moved):
            return moved
        before = moved
    return math.nan
