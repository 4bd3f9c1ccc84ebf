"""Scenes with hopping bodies, drawn at random: what hopping_truth.py is run on."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from bouncing_body import NAMES, Floats

Drawn = dict[str, Floats]

FREQUENCY: Final = 20.0  # [Hz]
GRAVITY: Final = 9.81  # [m/s^2]


def drawn(throw: Floats, alpha: Floats, mu_s: Floats, mu_d: Floats, e: Floats, beta: Any = 0.0) -> Drawn:
    """Form the fields of ``vibro.Scene`` by the throw number K."""
    amplitude = throw * np.cos(beta) / np.sin(alpha) * GRAVITY / (2.0 * np.pi * FREQUENCY) ** 2
    values = (amplitude, FREQUENCY, alpha, mu_s, mu_d, beta, GRAVITY, e)
    return {name: np.array(v) for name, v in zip(NAMES, np.broadcast_arrays(*values), strict=True)}


def usual_scenes(n: int, seed: int, *, e: tuple[float, float] = (0.0, 0.9), ratio: float = 0.6) -> Drawn:
    """Level troughs, K 1-6, usual friction with mu_d/mu_s from some ratio on."""
    rng = np.random.default_rng(seed)
    mu_s = rng.uniform(0.2, 0.9, n)
    alpha = np.radians(rng.uniform(15.0, 60.0, n))
    return drawn(rng.uniform(1.0, 6.0, n), alpha, mu_s, mu_s * rng.uniform(ratio, 1.0, n), rng.uniform(*e, n))


def wide_scenes(n: int, seed: int) -> Drawn:
    """K 1-50 and mu_s .05-3, log-uniform; e to .95, any ratio of frictions, slopes on which a body rests."""
    rng = np.random.default_rng(seed)
    mu_s = np.exp(rng.uniform(np.log(0.05), np.log(3.0), n))
    beta = rng.uniform(-1.0, 1.0, n) * np.minimum(np.arctan(mu_s), np.pi / 4.0)
    alpha = np.radians(rng.uniform(2.0, np.minimum(80.0, 89.0 - np.degrees(beta))))
    throw = 50.0 ** rng.uniform(0.0, 1.0, n)
    return drawn(throw, alpha, mu_s, mu_s * rng.uniform(0.0, 1.0, n), rng.uniform(0.0, 0.95, n), beta)


def slow_chains(n: int, seed: int) -> Drawn:
    """K just above 1 with high e: up to a thousand bounces a turn."""
    scenes = usual_scenes(n, seed, e=(0.9, 0.97))
    excess = 10.0 ** np.random.default_rng([seed, 1]).uniform(-3.0, -1.0, n)
    scenes["amplitude"] *= (1.0 + excess) / throw_of(scenes)
    return scenes


def without_kinetic_friction(n: int, seed: int) -> Drawn:
    """No kinetic friction: a body that never stops never forgets its start."""
    return usual_scenes(n, seed) | {"kinetic_friction": np.zeros(n)}


def hardly_hopping(n: int, seed: int) -> Drawn:
    """K 1-3.3 without bounces, steep drives too."""
    rng = np.random.default_rng(seed)
    mu_s = rng.uniform(0.1, 1.2, n)
    alpha = np.radians(rng.uniform(5.0, 85.0, n))
    return drawn(3.3 ** rng.uniform(0.0, 1.0, n), alpha, mu_s, mu_s * rng.uniform(0.4, 1.0, n), np.zeros(n))


def in_contact(n: int, seed: int) -> Drawn:
    """K below 1, any ratio of frictions, slopes on which a body rests."""
    rng = np.random.default_rng(seed)
    mu_s = rng.uniform(0.1, 1.0, n)
    beta = rng.choice([0.0, 1.0], n) * rng.uniform(-0.95, 0.95, n) * np.arctan(mu_s)
    alpha = np.radians(rng.uniform(5.0, 45.0, n))
    throw = rng.uniform(0.2, 0.999, n)
    return drawn(throw, alpha, mu_s, mu_s * rng.uniform(0.0, 1.0, n), np.zeros(n), beta)


def throw_of(fields: Drawn) -> Floats:
    """Throw number K."""
    load = fields["amplitude"] * (2.0 * np.pi * fields["frequency"]) ** 2 / fields["gravity"]
    return np.asarray(load * np.sin(fields["drive_angle"]) / np.cos(fields["trough_angle"]))


def some_of(fields: Drawn, which: Any) -> Drawn:
    """Pick scenes."""
    return {name: values[which] for name, values in fields.items()}


def scene_text(fields: Drawn, i: int) -> str:
    """Write a scene as the arguments of ``vibro.Scene``."""
    return ", ".join(f"{name}={values[i].item()!r}" for name, values in fields.items())
