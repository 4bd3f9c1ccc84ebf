"""Drives with harmonics for the tests: random ones, and how the second solver sees them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from engines.harmonic_walk import Drive

from vibro import Scene

if TYPE_CHECKING:
    from vibro.drives import Pairs


def random_harmonics(
    count: int,
    seed: int,
    harmonics: int = 2,
    *,
    ratio: tuple[float, float] = (0.4, 1.0),
    along_only: bool = False,
    steep: float = 0.5,
    load: tuple[float, float] = (0.3, 8.0),
) -> Scene:
    """Draw scenes: ratios of the frictions, and the steepest trough over the angle of static friction."""
    rng = np.random.default_rng(seed)
    size = np.exp(rng.uniform(math.log(load[0]), math.log(load[1]), count))
    along = [
        size * rng.uniform(0.1, 1.0, count) / n ** rng.uniform(0.5, 2.0, count)
        for n in range(1, harmonics + 1)
    ]
    across = [x * rng.uniform(0.0, 0.5, count) * (not along_only) / n for n, x in enumerate(along, 1)]
    phases = [tuple(rng.uniform(-np.pi, np.pi, (harmonics, count))) for _ in range(2)]
    static = rng.uniform(0.1, 1.0, count)
    kinetic = static * np.exp(rng.uniform(math.log(ratio[0]), math.log(ratio[1]), count))
    beta = np.arctan(static) * steep * rng.uniform(-1.0, 1.0, count) * (rng.uniform(size=count) < 0.6)
    w = np.full(count, 1.0 / (2.0 * np.pi))
    return Scene(
        along_harmonics=list(zip(along, phases[0], strict=True)),
        normal_harmonics=list(zip(across, phases[1], strict=True)),
        frequency=w,
        static_friction=static,
        kinetic_friction=kinetic,
        trough_angle=beta,
        gravity=1.0,
    )


def drive_of(scene: Scene, i: int) -> Drive:
    """Return one of these scenes as the second solver sees it, which counts lengths in g/w^2 = 1."""

    def pairs(harmonics: Pairs | None) -> list[tuple[float, float]]:
        found = []
        for n, (sizes, phases) in enumerate(harmonics or (), 1):
            load, phase = n * n * float(sizes[i]), float(phases[i])
            found.append((load * math.cos(phase), load * math.sin(phase)))
        return found

    others = (scene.static_friction, scene.kinetic_friction, scene.trough_angle)
    return Drive(pairs(scene.along_harmonics), pairs(scene.normal_harmonics), *(float(x[i]) for x in others))
