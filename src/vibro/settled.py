"""The steady motion of one scene as functions of time: what a record of a running conveyor should show."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from vibro.core.codes import Status
from vibro.core.groups import Loads, loads
from vibro.core.phases import Phase, steady_phases
from vibro.errors import VibroError
from vibro.steady import solve

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.scene import Scene

    Floats = NDArray[np.float64]

__all__ = ["SettledMotion", "settled_motion"]

_TURN = 2.0 * math.pi


@dataclass(frozen=True, eq=False)
class SettledMotion:
    """A body that has settled; times count from a passage of the trough through its middle, upwards.

    Attributes
    ----------
    pattern : str
        Phases of a cycle: F forward slide, B back slide, _ rest.
    period : float
        Of the drive [s].
    advance : float
        Displacement relative to the trough per cycle [m].
    slides : tuple of (int, float, float)
        Direction, start and end of each slide of a cycle [s].
    """

    pattern: str
    period: float
    advance: float
    slides: tuple[tuple[int, float, float], ...]
    _scene: Scene
    _loads: Loads
    _phases: tuple[Phase, ...]

    def displacement(self, time: Floats) -> Floats:
        """Displacement relative to the trough [m], from the start of the cycle's first phase at time >= 0."""
        return self._sample(time)[0]

    def velocity(self, time: Floats) -> Floats:
        """Velocity relative to the trough [m/s]."""
        return self._sample(time)[1]

    def inertial(self, time: Floats) -> Floats:
        """Inertial and gravitational load along the trough, per unit mass [m/s^2]."""
        scene = self._scene
        w = _TURN / self.period
        load = float(scene.amplitude) * w * w * math.cos(scene.drive_angle) * np.sin(w * time)
        return np.asarray(load - float(scene.gravity) * math.sin(scene.trough_angle))

    def _sample(self, time: Floats) -> tuple[Floats, Floats]:
        w = _TURN / self.period
        phase = w * np.asarray(time)
        first = self._phases[0].start
        turns = np.floor((phase - first) / _TURN)
        phase = phase - _TURN * turns
        place = np.searchsorted([p.start for p in self._phases], phase, side="right") - 1
        place = np.maximum(place, 0)
        s = self._loads
        rows = []
        position = 0.0
        for p in self._phases:
            sign = {"F": 1.0, "B": -1.0, "_": 0.0}[p.kind]
            load = float(s.along.item() + sign * s.kinetic_friction.item() * s.across.item())
            k = (s.kinetic_friction.item() * s.normal.item() + sign * s.tangential.item()) / load
            zero = math.pi if sign < 0 else 0.0
            rows.append((sign * load, k, zero, p.start - zero, position))
            position += p.displacement
        c, k, zero, q0, start = np.array(rows)[place].T
        q = phase - zero
        velocity = c * (np.cos(q0) - np.cos(q) - k * (q - q0))
        path = c * ((q - q0) * np.cos(q0) - (np.sin(q) - np.sin(q0)) - 0.5 * k * (q - q0) ** 2)
        amplitude = float(self._scene.amplitude)
        return amplitude * (start + path + turns * position), amplitude * w * velocity


def settled_motion(scene: Scene) -> SettledMotion:
    """Solve the steady motion of one scene.

    Parameters
    ----------
    scene : Scene
        Of shape ().

    Returns
    -------
    SettledMotion
        The cycle that a body at rest settles into.

    Raises
    ------
    VibroError
        If there is no steady contact cycle.
    """
    cycle = solve(scene)
    status = Status(int(cycle.status))
    if status > Status.BOUNDARY:
        raise VibroError(f"no steady motion to compare with: {status.message}")
    groups = loads(*(np.atleast_1d(a) for a in scene.arrays()[:7]))
    phases = steady_phases(groups, int(cycle.pattern_code))
    period = 1.0 / float(scene.frequency)
    to_time = period / _TURN
    return SettledMotion(
        pattern=str(cycle.pattern),
        period=period,
        advance=float(cycle.displacement_per_cycle),
        slides=tuple(
            (1 if p.kind == "F" else -1, p.start * to_time, p.end * to_time) for p in phases if p.kind != "_"
        ),
        _scene=scene,
        _loads=groups,
        _phases=tuple(phases),
    )
