"""Make nut_smoothed_600hz.csv: the safety nut as a CAD motion study computes it, with sensor noise.

Friction is smoothed as such programs do: a cubic step from rest to mu_s at 0.1 mm/s, and another one down to
mu_d at 10.16 mm/s, the documented values for dry steel. An ODE solver steps it; the exact model of vibro has
no part in it. The clock starts at a trough phase that the file does not tell.

    python examples/data/make_nut_smoothed_600hz.py examples/data/nut_smoothed_600hz.csv
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

AMPLITUDE = 1e-3  # [m]
FREQUENCY = 15.0  # [Hz]
DRIVE_ANGLE = math.radians(20.0)
STATIC_FRICTION, KINETIC_FRICTION = 0.74, 0.57
GRAVITY = 9.81  # [m/s^2]
MASS = 0.02  # [kg]

STATIC_VELOCITY, KINETIC_VELOCITY = 0.1e-3, 10.16e-3  # [m/s] where friction reaches mu_s and mu_d

SAMPLE_RATE = 600.0  # [1/s]
TRIGGER_TIME = 0.0137  # [s] after the trough passed its middle upwards
CYCLES = 20
NOISE = {"displacement": 2e-6, "velocity": 4e-4, "acceleration": 5e-2, "force": 1e-3}  # SI, one sigma
SEED = 600

Floats = NDArray[np.float64]


def cubic_step(x: Floats) -> Floats:
    """Rise from 0 at x = 0 to 1 at x = 1, level at both ends."""
    x = np.clip(x, 0.0, 1.0)
    return x * x * (3.0 - 2.0 * x)


def friction_coefficient(velocity: Floats) -> Floats:
    """Signed coefficient of the friction that opposes a relative velocity [m/s]."""
    speed = np.abs(velocity)
    # The static step spans -0.1 to 0.1 mm/s, hence the factor that makes it odd.
    rise = 2.0 * cubic_step(0.5 + 0.5 * speed / STATIC_VELOCITY) - 1.0
    fall = cubic_step((speed - STATIC_VELOCITY) / (KINETIC_VELOCITY - STATIC_VELOCITY))
    return np.sign(velocity) * (STATIC_FRICTION * rise - (STATIC_FRICTION - KINETIC_FRICTION) * fall)


def forces(time: Floats, velocity: Floats) -> tuple[Floats, Floats]:
    """Inertial load along the trough and friction, per unit mass [m/s^2]."""
    w = 2.0 * math.pi * FREQUENCY
    load = AMPLITUDE * w * w * np.sin(w * time)
    friction = -friction_coefficient(velocity) * (GRAVITY - math.sin(DRIVE_ANGLE) * load)
    return math.cos(DRIVE_ANGLE) * load, friction


def simulate(times: Floats) -> tuple[Floats, Floats]:
    """Relative displacement [m] and velocity [m/s] at the times, from rest at time 0."""

    def derivative(time: float, state: Floats) -> list[float]:
        inertial, friction = forces(np.asarray(time), state[1])
        return [state[1], float(inertial + friction)]

    # The static step is stiff: 1e5 1/s at rest.
    solution = solve_ivp(
        derivative, (0.0, times[-1]), [0.0, 0.0], "LSODA", times, rtol=1e-9, atol=1e-12, max_step=5e-4
    )
    return solution.y[0], solution.y[1]


def table() -> dict[str, Floats]:
    """Make the columns of the file, with their noise."""
    samples = np.arange(round(CYCLES * SAMPLE_RATE / FREQUENCY) + 1) / SAMPLE_RATE
    displacement, velocity = simulate(samples + TRIGGER_TIME)
    inertial, friction = forces(samples + TRIGGER_TIME, velocity)
    random = np.random.default_rng(SEED)

    def noisy(values: Floats, name: str) -> Floats:
        return values + NOISE[name] * random.standard_normal(values.size)

    return {
        "Time [s]": samples,
        "X [mm]": 1e3 * noisy(displacement - displacement[0], "displacement"),
        "V [mm/s]": 1e3 * noisy(velocity, "velocity"),
        "A [m/s^2]": noisy(inertial + friction, "acceleration"),
        "F [N]": noisy(MASS * friction, "force"),
    }


def main(path: Path) -> None:
    columns = table()
    rows = (",".join(f"{value:.6f}" for value in row) for row in zip(*columns.values(), strict=True))
    path.write_text("\n".join([",".join(columns), *rows]) + "\n", encoding="utf-8", newline="\n")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
