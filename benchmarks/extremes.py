"""Scenes where floating point is weakest, drawn at random: what stress.py and its tests are run on."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Fields = dict[str, Floats]

EPS: Final = 2.0**-52
SMALLEST: Final = 5e-324
LARGEST: Final = 1.7e308
_RIGHT_ANGLE: Final = 0.5 * np.pi


def extreme_fields(n: int, seed: int) -> Fields:
    """Draw scenes, most of them within reach of slipping, as fields of ``vibro.Scene``."""
    rng = np.random.default_rng(seed)

    def pick(*choices: tuple[float, Callable[[], Any]]) -> Floats:
        shares = np.array([share for share, _ in choices])
        which = rng.choice(len(choices), n, p=shares / shares.sum())
        return np.array(np.choose(which, [np.broadcast_to(make(), n) for _, make in choices]), np.float64)

    def decades(low: float, high: float) -> Floats:
        return np.asarray(10.0 ** rng.uniform(low, high, n), np.float64)

    def ulps(most: int = 8) -> Floats:
        return np.asarray(rng.integers(-most, most + 1, n) * EPS, np.float64)

    sign = rng.choice((-1.0, 1.0), n)
    alpha = pick(
        (50, lambda: rng.uniform(0.0, _RIGHT_ANGLE, n)),
        (15, lambda: decades(-12, 0)),
        (8, lambda: 0.0),
        (7, lambda: 1e-300),
        (10, lambda: np.nextafter(_RIGHT_ANGLE, 0.0)),
        (10, lambda: _RIGHT_ANGLE - decades(-15.5, -1)),
    )
    mu_s = pick(
        (3, lambda: 0.0),
        (40, lambda: decades(-12, 1)),
        (50, lambda: rng.uniform(0.05, 1.5, n)),
        (3, lambda: decades(-320, -100)),
        (4, lambda: 10.0),
    )
    ratio = pick(
        (5, lambda: 0.0),
        (15, lambda: 1.0),
        (5, lambda: 1.0 - 1e-15),
        (15, lambda: decades(-15, 0)),
        (15, lambda: 1.0 - decades(-15, 0)),
        (45, lambda: rng.uniform(0.0, 1.0, n)),
    )
    mu_d = np.minimum(mu_s * ratio, mu_s)
    beta = pick(
        (50, lambda: 0.0),
        (15, lambda: rng.uniform(-1.0, 1.0, n) * np.arctan(mu_s)),
        (5, lambda: sign * np.arctan(mu_s) * (1.0 + ulps())),
        (5, lambda: sign * np.arctan(mu_d) * (1.0 + ulps())),
        (8, lambda: sign * decades(-300, -1)),
        (8, lambda: rng.uniform(-_RIGHT_ANGLE, _RIGHT_ANGLE, n)),
        (4, lambda: sign * np.nextafter(_RIGHT_ANGLE, 0.0)),
        (5, lambda: (_RIGHT_ANGLE - alpha) * (1.0 - rng.integers(0, 8, n) * EPS)),
    )
    beta = np.clip(beta, -np.nextafter(_RIGHT_ANGLE, 0.0), np.nextafter(_RIGHT_ANGLE, 0.0))
    beta = np.where(alpha + beta < _RIGHT_ANGLE, beta, -np.abs(beta))
    gravity = pick((95, lambda: 9.81), (5, lambda: decades(-20, 20)))
    frequency = pick(
        (5, lambda: 15.0),
        (80, lambda: 15.0 * decades(-12, 12)),
        (15, lambda: decades(-150, 150)),
    )
    load = _loads_near_thresholds(rng, alpha, mu_s, beta, pick, decades)
    load *= 1.0 + pick((20, lambda: 0.0), (40, ulps), (40, lambda: sign * decades(-16, -1)))
    with np.errstate(all="ignore"):
        w = 2.0 * np.pi * frequency
        amplitude = np.nan_to_num((load / w) * (gravity / w), nan=1.0, posinf=LARGEST)
    wild = rng.random(n) < 0.1
    amplitude = np.where(
        wild, pick((80, lambda: 1e-3 * decades(-12, 12)), (20, lambda: decades(-323, 308))), amplitude
    )
    frequency = np.where(
        wild, pick((80, lambda: 15.0 * decades(-12, 12)), (20, lambda: decades(-323, 308))), frequency
    )
    restitution = pick((80, lambda: 0.0), (20, lambda: rng.uniform(0.0, 1.0, n)))
    return {
        "amplitude": np.clip(amplitude, SMALLEST, LARGEST),
        "frequency": np.clip(frequency, SMALLEST, LARGEST),
        "drive_angle": alpha,
        "static_friction": mu_s,
        "kinetic_friction": mu_d,
        "trough_angle": beta,
        "gravity": gravity,
        "restitution": restitution,
    }


def _loads_near_thresholds(
    rng: np.random.Generator,
    alpha: Floats,
    mu_s: Floats,
    beta: Floats,
    pick: Callable[..., Floats],
    decades: Callable[[float, float], Floats],
) -> Floats:
    """G at a threshold, or between the first slip and the hop; any where there is none."""
    n = alpha.size
    along, across, normal, tangential = np.cos(alpha), np.sin(alpha), np.cos(beta), np.sin(beta)
    with np.errstate(all="ignore"):
        hop = normal / across
        forward = (mu_s * normal + tangential) / (along + mu_s * across)
        back = (mu_s * normal - tangential) / (along - mu_s * across)
        first = np.fmin(np.where(forward > 0.0, forward, np.inf), np.where(back > 0.0, back, np.inf))
        between = first * (np.fmin(hop, 1e6 * first) / first) ** rng.uniform(0.0, 1.0, n)
        load = pick(
            (12, lambda: hop),
            (12, lambda: forward),
            (12, lambda: back),
            (10, lambda: first * decades(-1, 2)),
            (54, lambda: between),
        )
    return np.where(np.isfinite(load) & (load > 0.0), load, decades(-3, 3))
