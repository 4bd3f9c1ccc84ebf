"""Drives with harmonics for the tests: random ones, and how the core and the second solver see them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from engines.harmonic_walk import Drive

from vibro import Scene
from vibro.core.harmonic.loads import HarmonicLoads
from vibro.core.harmonic.solver import SteadyState, harmonic_state
from vibro.drives import Harmonics

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]


def solved(loads: HarmonicLoads, count: int, *, classes_alone: bool = False) -> SteadyState:
    """Solve scenes."""
    out = unsolved(count)
    harmonic_state(loads, out, classes_alone=classes_alone)
    return out


def unsolved(count: int) -> SteadyState:
    """Make arrays to be filled."""
    codes = [np.empty(count, dtype) for dtype in (np.int8, np.int8, np.int64, np.int8)]
    return SteadyState._make((*codes, *np.empty((5, count)), np.empty(count, np.int8)))


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


def drawn(count: int, seed: int, harmonics: int = 2, **kind: Any) -> HarmonicLoads:
    """Draw the loads of such scenes."""
    fields = random_harmonics(count, seed, harmonics, **kind).arrays()
    assert isinstance(fields, Harmonics)
    return fields.loads()


def drive_of(loads: HarmonicLoads, i: int) -> tuple[Drive, float]:
    """Return a scene as the second solver sees it, and its g/w^2 over A."""

    def at(x: Floats) -> float:
        return float(x[i] if x.ndim else x)

    normal, lean = at(loads.normal), at(loads.tangential)
    weight = float(np.hypot(normal, lean))

    def pairs(sines: tuple[Floats, ...], cosines: tuple[Floats, ...]) -> list[tuple[float, float]]:
        return [(at(s) / weight, at(c) / weight) for s, c in zip(sines, cosines, strict=True)]

    drive = Drive(
        pairs(loads.along_sine, loads.along_cosine),
        pairs(loads.across_sine, loads.across_cosine),
        at(loads.static_friction),
        at(loads.kinetic_friction),
        float(np.arctan2(lean, normal)),
    )
    return drive, weight
