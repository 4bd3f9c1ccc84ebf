"""Are means as far off as their standard errors say? They are compared with long walks of ``vibro.simulate``.

Usage: python benchmarks/averages.py [--scenes 150] [--seed 1]

Motions of harmonics and of steps, ellipses and lines in turn, K 1.2-6, restitution 0-0.85, of which those
with status AVERAGED are taken. Each is walked for 20 000 cycles from rest, at 8 scales of the motion 1.7e-12
apart, as rounding chooses the flights; the first 5000 are left out. A walk's error is the scatter of these
bodies, with what the halves of the walk differ by.
"""

from __future__ import annotations

import argparse
import math
from typing import Any, Final

import numpy as np

import vibro

KINDS: Final = ("harmonics", "steps", "ellipse", "line")
BODIES: Final = 8
NEIGHBOUR: Final = 1.7e-12
CYCLES: Final = (5000, 12_500, 20_000)


def drawn(kind: str, rng: np.random.Generator) -> dict[str, Any]:
    """Draw the fields of a scene; ``motion_scale`` or amplitudes make its throw number."""
    frequency, static = rng.uniform(5.0, 60.0), rng.uniform(0.08, 1.2)
    fields: dict[str, Any] = {
        "frequency": frequency,
        "static_friction": static,
        "kinetic_friction": static * rng.uniform(0.3, 1.0),
        "restitution": rng.uniform(0.0, 0.85),
        "trough_angle": rng.choice([0.0, rng.uniform(-0.1, 0.1)]),
    }
    throw = rng.uniform(1.2, 6.0)
    if kind in ("harmonics", "steps"):
        make = _harmonics if kind == "harmonics" else _steps
        fields["motion"] = getattr(vibro.Motion, kind)(along=make(rng), normal=make(rng))
        unit = vibro.solve(vibro.Scene(**fields), flight=False).throw_number
        return fields | {"motion_scale": throw / float(unit)}
    normal = throw * 9.81 * math.cos(fields["trough_angle"]) / (2.0 * math.pi * frequency) ** 2
    angle = rng.uniform(0.2, 1.2)
    if kind == "line":
        return fields | {"amplitude": normal / math.sin(angle), "drive_angle": angle}
    along, phase = normal / math.tan(angle), rng.uniform(-math.pi, math.pi)
    return fields | {"along_amplitude": along, "normal_amplitude": normal, "normal_phase": phase}


def _harmonics(rng: np.random.Generator) -> list[tuple[float, float]]:
    decay = rng.uniform(1.5, 3.5)
    return [
        (1e-3 * float(rng.uniform(0.1, 1.0) * k**-decay), float(rng.uniform(-math.pi, math.pi)))
        for k in range(1, int(rng.integers(3, 10)))
    ]


def _steps(rng: np.random.Generator) -> list[tuple[float, float]]:
    shares = rng.dirichlet(np.full(int(rng.integers(2, 7)), 2.0))
    levels = rng.normal(size=shares.size)
    levels -= shares @ levels
    return [(float(share), 10.0 * float(level)) for share, level in zip(shares, levels, strict=True)]


def neighbour(fields: dict[str, Any], i: int) -> vibro.Scene:
    """Scale the motion of a scene by a little."""
    names = ("motion_scale", "amplitude", "along_amplitude", "normal_amplitude")
    scaled = {name: fields[name] * (1.0 + NEIGHBOUR * i) for name in names if name in fields}
    return vibro.Scene(**(fields | scaled))


def walked(fields: dict[str, Any]) -> tuple[float, float]:
    """Return the displacement per cycle of long walks, and its standard error [m]."""
    rates = np.empty((BODIES, 2))
    for i in range(BODIES):
        history = vibro.simulate(neighbour(fields, i), cycles=CYCLES[-1])
        times = np.minimum(np.array(CYCLES) / fields["frequency"], history.end)
        rates[i] = np.diff(history.sample(times).position) / np.diff(CYCLES)
    scatter = rates.mean(axis=1).std(ddof=1) / math.sqrt(BODIES)
    return float(rates.mean()), math.hypot(scatter, float(np.diff(rates.mean(axis=0))[0]))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--scenes", type=int, default=150)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    rng, sizes = np.random.default_rng(options.seed), []
    while len(sizes) < options.scenes:
        fields = drawn(KINDS[len(sizes) % len(KINDS)], rng)
        cycle = vibro.solve(neighbour(fields, 0))
        if cycle.status != vibro.Status.AVERAGED:
            continue
        mean, error = walked(fields)
        own = float(cycle.mean_velocity_error) / fields["frequency"]
        sizes.append(abs(float(cycle.displacement_per_cycle) - mean) / math.hypot(own, error))
    z = np.array(sizes)
    print(
        f"{z.size} means: root mean square of z {math.sqrt(np.mean(z**2)):.2f}, beyond 3: {(z > 3).sum()}, "
        f"beyond 4: {(z > 4).sum()}, beyond 10: {(z > 10).sum()}, largest {z.max():.1f}"
    )


if __name__ == "__main__":
    main()
