"""What a cycle adds to the velocity of a hopping body, and whether that is nothing.

Over a cycle in which the body does not stop the drive adds nothing: gravity along the trough and friction
alone change the velocity, and they are known without the cancellation in the difference of two velocities.
Lengths in A, speeds in A w, phases in radians.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.core.contact.slide import Floats
    from vibro.core.flight.returns import Cells, Return

    Bools = NDArray[np.bool_]

__all__ = ["CLOSED", "FLOOR", "Drift", "Span", "drift", "has_stop", "size_of", "span_of"]

_TURN: Final = 2.0 * np.pi

#: [1] Rounding of one evaluation of the return map, relative to the velocities in it.
FLOOR: Final = 16 * 2.0**-52

#: [1] Distance from the fixed point at which a cycle is closed, over the velocities in it.
CLOSED: Final = 1e-13
_EDGE: Final = 4 * 2.0**-52  # [1] relative distance of two loads that rounding decides


class Span(NamedTuple):
    """Sizes of the velocities in a cycle and of what adds to them.

    Attributes
    ----------
    bounded, edge : bool array
        Whether kinetic friction holds gravity along the trough, and if rounding decides that.
    neutral : bool array
        Whether there is neither of them.
    bound : array
        Limit of the velocity at lift-off at any fixed point.
    fall : array
        What gravity along the trough adds in a cycle.
    drive : array
        Velocity that the drive brings.
    forces : array
        What gravity and friction can bring in a cycle.
    """

    bounded: Bools
    edge: Bools
    neutral: Bools
    bound: Floats
    fall: Floats
    drive: Floats
    forces: Floats


def span_of(cells: Cells, turns: Floats) -> Span:
    """Measure motions that last a phase of ``turns`` [rad]: whole drive cycles, or a long sample.

    The body is stopped, or turns round, once in a cycle; only the drive and gravity can add
    velocity after that.
    Over a cycle the normal impulse is that of the weight, so that friction adds 2 pi mu_d n at most.
    """
    scene = cells.track.scene
    lean, grip = np.abs(scene.tangential), scene.kinetic_friction * scene.normal
    edge = (grip > 0.0) & (np.abs(lean - grip) <= _EDGE * grip)
    bounded = edge | (lean < grip)
    return Span(
        np.broadcast_to(bounded, turns.shape),
        np.broadcast_to(edge, turns.shape),
        np.broadcast_to((grip == 0.0) & (lean == 0.0), turns.shape),
        2.0 * scene.along + turns * lean,
        -scene.tangential * turns,
        np.broadcast_to(scene.along, turns.shape),
        turns * (grip + lean),
    )


def size_of(span: Span, velocity: Floats) -> Floats:
    """Size of the numbers whose sum is the velocity after a cycle."""
    size: Floats = span.drive + span.forces + np.abs(velocity)
    return size


def has_stop(cycle: Return) -> Bools:
    """Tell whether the body stops in a cycle, and so forgets its velocity."""
    stops: Bools = cycle.slope == 0.0
    return stops


class Drift(NamedTuple):
    """Which way orbits go on, by how much Newton's iteration would, and whether they are closed."""

    rises: Bools
    newton: Floats
    closed: Bools


def drift(here: Floats, now: Return, span: Span) -> Drift:
    """Compare states with their images.

    A sample of a motion without a cycle ends at another phase of the drive than it began, so that the
    trough's own velocity changes the relative one. What gravity and friction add is free of that.
    """
    slides = ~has_stop(now)
    change = np.where(slides, span.fall + now.friction, now.velocity - here)
    walk = np.abs(change)
    with np.errstate(divide="ignore", invalid="ignore"):
        newton = walk / (1.0 - now.slope)
    floor = FLOOR * np.where(slides, span.forces, size_of(span, here))
    closed = (walk <= floor) | (newton <= CLOSED * (span.drive + np.abs(here)))
    return Drift(change > 0.0, newton, closed)
