"""Boxes of bodies that hop, with a band of restitution, and bodies drawn from them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from vibro import Scene, solve
from vibro.designs.spaces import uncertainty_set

if TYPE_CHECKING:
    from vibro import Guarantee
    from vibro.designs.spaces import UncertaintySet


def drawn_band(seed: int) -> tuple[Scene, dict[str, Any]]:
    """Draw a scene that hops, throw number 1.1 to 4, and bands of restitution and of what else is unknown."""
    rng = np.random.default_rng([7, seed])
    frequency, angle = rng.uniform(12.0, 60.0), math.radians(rng.uniform(15.0, 40.0))
    amplitude = rng.uniform(1.1, 4.0) * 9.81 / (2.0 * math.pi * frequency) ** 2 / math.sin(angle)
    static = rng.uniform(0.2, 0.8)
    scene = Scene(
        amplitude=amplitude, frequency=frequency, drive_angle=angle, static_friction=static,
        kinetic_friction=static * rng.uniform(0.5, 1.0),
    )  # fmt: skip
    low = rng.choice([0.0, rng.uniform(0.0, 0.4)])
    bands: dict[str, Any] = {"restitution": (low, low + rng.uniform(0.05, 0.4))}
    if rng.random() < 0.7:
        bands["friction_ratio"] = (0.6, 0.9)
        bands["static_friction"] = (0.9 * static, 1.1 * static)
    if rng.random() < 0.4:
        bands["amplitude"] = (0.97 * amplitude, 1.03 * amplitude)
    return scene, bands


def box_of(scene: Scene, bands: dict[str, Any]) -> UncertaintySet:
    """Return the box that bands span around a scene."""
    return uncertainty_set(scene, bands)


def beyond(guarantee: Guarantee, box: UncertaintySet, count: int, seed: int) -> tuple[float, float]:
    """Return by how much bodies drawn at random are slower and faster than bounds, over the larger one."""
    coordinates = np.random.default_rng([11, seed]).random((len(box.axes), count)) * box.varies[:, None]
    speeds = solve(box.scene(box.points(coordinates), fast=False)).mean_velocity
    size = max(abs(guarantee.speed_min), abs(guarantee.speed_max))
    slower, faster = guarantee.speed_min - np.nanmin(speeds), np.nanmax(speeds) - guarantee.speed_max
    return float(slower) / size, float(faster) / size
