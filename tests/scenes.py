"""Scenes by their load, for the tests: what the dimensionless numbers alone decide."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

import vibro
from vibro.core.groups import Loads, loads

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

GRAVITY = 9.81


class Groups(NamedTuple):
    """What decides a motion up to scale: load G = A w^2 / g, angles [deg], coefficients of friction."""

    load: float
    drive_deg: float
    mu_s: float
    mu_d: float
    trough_deg: float = 0.0


def at_load(
    load: ArrayLike,
    drive_deg: ArrayLike,
    mu_s: ArrayLike,
    mu_d: ArrayLike,
    trough_deg: ArrayLike = 0.0,
    frequency: ArrayLike = 15.0,
) -> vibro.Scene:
    """Make scenes whose amplitude gives the load G = A w^2 / g."""
    w = 2.0 * np.pi * np.asarray(frequency, np.float64)
    return vibro.Scene(
        amplitude=np.asarray(load, np.float64) * GRAVITY / w**2,
        frequency=frequency,
        drive_angle=np.radians(drive_deg),
        static_friction=mu_s,
        kinetic_friction=mu_d,
        trough_angle=np.radians(trough_deg),
        gravity=GRAVITY,
    )


def loads_of(scene: vibro.Scene) -> Loads:
    """Form the groups of scenes, as 1-D arrays over the flattened grid."""
    groups = loads(*scene.arrays()[:7])
    return Loads(*(np.broadcast_to(x, scene.shape).reshape(-1) for x in groups))


def random_scenes(
    count: int, seed: int, *, most_trough_deg: float = 0.0, least_ratio: float = 0.4
) -> vibro.Scene:
    """Draw contact scenes that can rest: loads from before any slip to the hop, log-uniform."""
    random = np.random.default_rng(seed)
    mu_s = random.uniform(0.1, 1.0, count)
    drive = random.uniform(2.0, 45.0, count)
    steepest = np.minimum(most_trough_deg, 0.95 * np.degrees(np.arctan(mu_s)))
    trough = random.uniform(-1.0, 1.0, count) * steepest
    hop = np.cos(np.radians(trough)) / np.sin(np.radians(drive))
    load = np.exp(random.uniform(np.log(0.05), np.log(0.999 * hop)))
    return at_load(load, drive, mu_s, mu_s * random.uniform(least_ratio, 1.0, count), trough)


def groups_of(scene: vibro.Scene) -> list[Groups]:
    """List the groups of scenes, one by one."""
    load = scene.amplitude * (2.0 * np.pi * scene.frequency) ** 2 / scene.gravity
    fields = (
        load,
        np.degrees(scene.drive_angle),
        scene.static_friction,
        scene.kinetic_friction,
        np.degrees(scene.trough_angle),
    )
    columns = (np.broadcast_to(x, scene.shape).tolist() for x in fields)
    return [Groups(*row) for row in zip(*columns, strict=True)]


def solve_one(groups: Groups) -> vibro.SteadyCycle:
    """Solve the scene of some groups."""
    return vibro.solve(at_load(*groups))
