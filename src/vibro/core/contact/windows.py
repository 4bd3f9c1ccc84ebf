"""Where the load of a body at rest exceeds static friction: one window a cycle in each direction.

Equation numbers are those of docs/theory.md. A slide in the direction s = +1 or -1 with the coefficient mu is
pulled by C sin(p + psi), C e^{i psi} = s a e^{-i phi} + mu b, Eq. (54): p + psi is the slide's own phase.
Loads are over m A w^2, phases in radians.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from vibro.core.contact.slide import Floats
    from vibro.core.groups import Loads

__all__ = ["load_amplitude", "own_phase", "skew_of", "static_lifts"]

_TINY: Final = 1e-300  # [1] keeps the quotients of a trough that stands still from being 0 / 0


def load_amplitude(scene: Loads, direction: int | Floats, friction: Floats) -> Floats:
    """C of Eq. (54); of drives along a line a + s mu b, below zero where the angle is not that of s."""
    lift = friction * scene.across
    if scene.lead is None:
        return scene.along + direction * lift
    level, steep = direction * scene.along * scene.lead.cosine + lift, scene.along * scene.lead.sine
    return np.asarray(np.sqrt(level * level + steep * steep))


def own_phase(scene: Loads, direction: int | Floats, friction: Floats | None = None) -> Floats:
    """Psi of Eq. (54), while the body slides unless a friction is given: it makes a phase the slide's own."""
    lift = (scene.kinetic_friction if friction is None else friction) * scene.across
    if scene.lead is None:
        return np.where(direction * scene.along + lift < 0.0, np.pi, 0.0)
    way = direction * scene.along
    return np.asarray(np.arctan2(-way * scene.lead.sine, way * scene.lead.cosine + lift))


def static_lifts(scene: Loads) -> tuple[Floats, Floats]:
    """C - a of a body at rest, forward and back, without cancellation where b is small."""
    lift = scene.static_friction * scene.across
    if scene.lead is None:
        return lift, -lift
    level, steep = scene.along * scene.lead.cosine, scene.along * scene.lead.sine
    double, square = 2.0 * level, steep * steep
    low, high = lift - level, lift + level
    along = scene.along + _TINY
    return (
        lift * (lift + double) / (np.sqrt(high * high + square) + along),
        lift * (lift - double) / (np.sqrt(low * low + square) + along),
    )


def skew_of(scene: Loads, friction: Floats) -> Floats:
    """E of Eq. (57): the angle beyond half a turn between the phases of the forward and the back load.

    With static friction it tells how much more than half a turn after the forward window the back window
    lies; with kinetic friction the same of the zeros of both slides' own phases. 0 of drives along a line.
    """
    if scene.lead is None:
        return np.zeros(())
    a, lift = scene.along, friction * scene.across
    return np.asarray(np.arctan2(2.0 * a * lift * scene.lead.sine, (a - lift) * (a + lift)))
