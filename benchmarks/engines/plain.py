"""Two textbook methods in plain Python: what an engine of one body and one contact needs at least.

Both have a rigid trough and Newton's law of impact; a step whose gap is closed has a contact.

- Time stepping after Moreau: the friction impulse is what stops the body, or mu times the normal impulse if
  that is less. J. J. Moreau, Unilateral contact and dry friction in finite freedom dynamics, in Nonsmooth
  Mechanics and Applications, CISM 302 (1988); V. Acary, B. Brogliato, Numerical Methods for Nonsmooth
  Dynamical Systems (2008).
- Regularised friction: proportional to the speed up to 1 mm/s, the full friction above, taken implicitly.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from scenes import Floats, Scene

SPEED: Final = 1e-3  # [m/s] up to which friction is proportional to it
VARIANTS: Final = {
    "Moreau's time stepping": "friction is an impulse that may stop the body",
    "regularised friction": "proportional to the speed up to 1 mm/s, implicit",
}


def follow(scene: Scene, loads: Floats, step: float, variant: str, velocity: float = 0.0) -> Floats:
    """Return the displacement at each step [m], from rest on the trough or from a velocity along it [m/s]."""
    position, height, normal_velocity = 0.0, 0.0, 0.0
    positions = [position]
    regular = variant == "regularised friction"
    for along, normal in loads.tolist():
        velocity += along * step
        free = normal_velocity + normal * step
        if height <= 0.0:
            rebound = scene.restitution * max(-normal_velocity, 0.0)
            impulse = max(rebound - free, 0.0)
            limit = scene.friction * impulse
            slow = velocity / (1.0 + limit / SPEED) if regular else 0.0
            if abs(slow) > SPEED or (not regular and abs(velocity) > limit):
                velocity -= math.copysign(limit, velocity)
            else:
                velocity = slow
            free += impulse
        normal_velocity = free
        position += velocity * step
        height += normal_velocity * step
        positions.append(position)
    return np.array(positions)
