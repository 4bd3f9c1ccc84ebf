"""Hopping scenes by their throw number, for the tests."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scenes import at_load, loads_of
from vibro.core.flight.cycles import HoppingCycles, unresolved
from vibro.core.groups import Loads, put, take

from vibro import Status, steady

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray


def hopping_cycles(scene: Loads, restitution: NDArray[np.float64]) -> HoppingCycles:
    """Solve hopping scenes as ``vibro.solve`` does: what a stage leaves unresolved is left to the next."""
    out = unresolved(np.broadcast(*scene.flattened(), restitution).size)
    left = np.arange(out.status.size)
    for stage, _ in steady._HOPPING:
        put(out, left, stage(take(scene, left), take((restitution,), left)[0]))
        left = left[out.status[left] == Status.UNRESOLVED]
    return out


def loads_at_throw(
    throw: ArrayLike,
    drive_deg: ArrayLike,
    mu_s: ArrayLike,
    mu_d: ArrayLike,
    trough_deg: ArrayLike = 0.0,
) -> Loads:
    """Form the groups of scenes from K = G sin(alpha) / cos(beta)."""
    weight = np.cos(np.radians(trough_deg)) / np.sin(np.radians(drive_deg))
    return loads_of(at_load(np.multiply(throw, weight), drive_deg, mu_s, mu_d, trough_deg))


def random_loads(count: int, seed: int, *, most_throw: float = 3.2, least_ratio: float = 0.05) -> Loads:
    """Draw hopping scenes on troughs where a body can rest."""
    random = np.random.default_rng(seed)
    mu_s = np.exp(random.uniform(np.log(0.1), np.log(1.5), count))
    ratio = random.uniform(least_ratio, 1.0, count)
    drive = random.uniform(5.0, 60.0, count)
    trough = random.choice([0.0, 1.0], count) * random.uniform(-0.8, 0.8, count)
    trough *= np.minimum(np.degrees(np.arctan(mu_s * ratio)), 25.0)
    throw = np.exp(random.uniform(np.log(1.001), np.log(most_throw), count))
    return loads_at_throw(throw, drive, mu_s, mu_s * ratio, trough)
