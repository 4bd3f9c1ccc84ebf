"""The steady motion of a body in contact on a drive with harmonics, sampled like that on any other drive."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Final, NamedTuple

import numpy as np

from vibro.core.codes import Regime, Status
from vibro.drives import Ability, Harmonics
from vibro.errors import VibroError
from vibro.motion.settled import CyclePhase, SettledMotion, cycle_phases, settled_motion
from vibro.records.folding import Floats
from vibro.scene import Scene
from vibro.steady import solve

__all__ = ["HarmonicMotion", "SteadyMotion", "steady_motion"]

_WAYS: Final = {"F": 1, "B": -1}


class Sampled(NamedTuple):
    """Position [m], velocity [m/s] and inertial load [m/s^2] of a body, as in ``Sample``."""

    position: Floats
    velocity: Floats
    inertial: Floats


@dataclass(frozen=True, eq=False)
class HarmonicMotion:
    """A body that has settled, with the attributes of ``SettledMotion``.

    Attributes
    ----------
    scene : Scene
        Of shape (), with a drive with harmonics, on which the body stays in contact.
    pattern : str
        Phases of a cycle: F forward slide, B back slide, _ rest.
    phases : tuple of CyclePhase
        One cycle, at trough times.
    """

    scene: Scene
    pattern: str
    phases: tuple[CyclePhase, ...]

    @property
    def period(self) -> float:
        """Period of the drive [s]."""
        return 1.0 / float(self.scene.frequency)

    @property
    def advance(self) -> float:
        """Displacement relative to the trough per cycle [m]."""
        return math.fsum(phase.displacement for phase in self.phases)

    @property
    def slides(self) -> tuple[tuple[int, float, float], ...]:
        """Direction, start and end of each slide of a cycle [s]."""
        return tuple((_WAYS[p.kind], p.start, p.end) for p in self.phases if p.kind in _WAYS)

    def sample(self, time: Floats) -> Sampled:
        """Return the motion at any trough times, also before the first cycle.

        A slide begins at rest, and its acceleration is the sum of known sines and a constant.
        """
        position, velocity = np.zeros(time.shape), np.zeros(time.shape)
        for way, start, end in self.slides:
            turns, since = np.divmod(time - start, self.period)
            moved, gained = self._slid(way, start, np.minimum(since, end - start))
            whole, _ = self._slid(way, start, np.array(end - start))
            position += turns * whole + moved
            velocity += np.where(since < end - start, gained, 0.0)
        weight = float(self.scene.gravity) * math.sin(float(self.scene.trough_angle))
        return Sampled(position, velocity, -self._trough("along", time, 2) - weight)

    def _slid(self, way: int, start: float, since: Floats) -> tuple[Floats, Floats]:
        """Return displacement and velocity at times since the start of a slide [m, m/s]."""
        names = ("gravity", "trough_angle", "kinetic_friction")
        gravity, beta, mu_d = (float(getattr(self.scene, name)) for name in names)
        clamped = self.scene.normal_acceleration
        weight = gravity * math.cos(beta) if clamped is None else float(clamped)
        drag = gravity * math.sin(beta) + way * mu_d * weight

        def forced(at: Floats, order: int) -> Floats:
            return self._trough("along", at, order) + way * mu_d * self._trough("normal", at, order)

        begun, first = forced(np.array(start), 0), forced(np.array(start), 1)
        moved = begun - forced(start + since, 0) + first * since - 0.5 * drag * since**2
        return moved, first - forced(start + since, 1) - drag * since

    def _trough(self, way: str, time: Floats, order: int) -> Floats:
        """Return a derivative of the trough's motion along itself, or normal to itself [m/s^order]."""
        sizes, phases = self._harmonics[way]
        rates = math.tau * float(self.scene.frequency) * np.arange(1, sizes.size + 1)
        angles = np.multiply.outer(time, rates) + phases + 0.5 * math.pi * order
        return np.asarray(np.sin(angles) @ (sizes * rates**order))

    @cached_property
    def _harmonics(self) -> dict[str, tuple[Floats, Floats]]:
        """Amplitudes and phases of both motions."""
        fields = Harmonics.of(self.scene)
        scale = float(fields.motion_scale)
        return {
            "along": (scale * np.array(fields.along_amplitudes), np.array(fields.along_phases)),
            "normal": (scale * np.array(fields.normal_amplitudes), np.array(fields.normal_phases)),
        }


SteadyMotion = SettledMotion | HarmonicMotion


def steady_motion(scene: Scene) -> SteadyMotion:
    """Solve the steady motion of one scene.

    Parameters
    ----------
    scene : Scene
        Of shape ().

    Raises
    ------
    VibroError
        If there is none that repeats in every drive cycle, or none that is known.
    """
    if scene.arrays().can(Ability.LIMITS):
        return settled_motion(scene)
    cycle = solve(scene)
    if cycle.regime == Regime.HOPPING:
        raise VibroError("no steady motion to compare with: the body hops on a drive with harmonics")
    phases = cycle_phases(scene) if Status(int(cycle.status)).answered else ()
    if not phases:
        raise VibroError(f"no steady motion to compare with: {Status(int(cycle.status)).message}")
    return HarmonicMotion(scene, str(cycle.pattern), phases)
