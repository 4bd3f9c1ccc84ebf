"""The exact motion of one body from any start: phases with closed forms, and one steady cycle with a count.

A run is a list of phases (rest, slide, flight), each with its start, end, position and velocity at both
ends. Phases are kept reduced: a cycle count and a phase in [0, 2 pi), so that late cycles are as sharp
as early ones. Once a cycle repeats, it is stored once, with a count.

Lengths in A, speeds in A w, phases in radians.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from vibro.core.motion import Mode

__all__ = ["Stage"]


class Stage(NamedTuple):
    """One phase of the motion.

    Attributes
    ----------
    mode : Mode
        What the body does.
    cycle : int
        Drive cycles completed at its start.
    phase : float
        Trough phase at its start, in [0, 2 pi) [rad].
    length : float
        Phase from its start to its end [rad].
    position, velocity : float
        Relative displacement and velocity at its start.
    advance : float
        Displacement during the phase.
    end_velocity : float
        Relative velocity at its end, before an impact.
    height_rate : float
        Speed away from the trough at its start, of a flight.
    """

    mode: Mode
    cycle: int
    phase: float
    length: float
    position: float
    velocity: float
    advance: float
    end_velocity: float
    height_rate: float
