"""Time histories: what a body does from its first moment on, phase by phase, in SI.

``simulate(scene, cycles=10)`` returns a `History`: the exact list of phases and, by `History.sample`,
displacements, velocities and forces at any time, from closed forms.
"""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Phase"]


@dataclass(frozen=True)
class Phase:
    """One phase of the motion.

    Attributes
    ----------
    kind : str
        ``"F"`` forward slide, ``"B"`` back slide, ``"_"`` rest, ``"H"`` flight.
    start, end : float
        Its first and last moment [s].
    start_position, end_position : float
        Displacement relative to the trough, positive in the conveying direction [m].
    start_velocity, end_velocity : float
        Velocity relative to the trough, after what happened at its start and before what happens at its
        end (an impact) [m/s].
    """

    kind: str
    start: float
    end: float
    start_position: float
    end_position: float
    start_velocity: float
    end_velocity: float
