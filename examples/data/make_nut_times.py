"""Make nut_times.csv: a nut on a feeder of 15 Hz and 20 deg, timed with a stopwatch over 600 mm.

The nut's friction is 0.74 at rest and 0.57 while sliding. Its motion is summed up in steps of 10 us; vibro
has no part in it. At the smallest amplitude it stays where it is.

    python examples/data/make_nut_times.py examples/data/nut_times.csv
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np

AMPLITUDES = (0.6, 1.0, 1.4, 1.8, 1.8, 2.4)  # [mm]
FREQUENCY, DRIVE_ANGLE = 15.0, math.radians(20.0)  # [Hz], [rad]
STATIC_FRICTION, KINETIC_FRICTION = 0.74, 0.57
GRAVITY = 9.81  # [m/s^2]
LENGTH = 0.6  # [m]
STEP = 1e-5  # [s]
CYCLES = 8  # of which the second half counts
NOISE = 0.015  # of a time, one sigma: the thumb on the watch, and one nut and another
SEED = 15


def mean_speed(amplitude: float) -> float:
    """Follow a nut that starts from rest, and return its mean speed over the last cycles [m/s]."""
    rate = 2.0 * math.pi * FREQUENCY
    along, normal = (amplitude * rate**2 * f(DRIVE_ANGLE) for f in (math.cos, math.sin))
    velocity = path = 0.0
    steps = round(CYCLES / FREQUENCY / STEP)
    for i in range(steps):
        wave = math.sin(rate * i * STEP)
        drive, pressed = along * wave, GRAVITY - normal * wave
        if velocity == 0.0 and abs(drive) <= STATIC_FRICTION * pressed:
            continue
        way = math.copysign(1.0, velocity or drive)
        after = velocity + STEP * (drive - way * KINETIC_FRICTION * pressed)
        velocity = after if after * velocity >= 0.0 else 0.0  # it comes to rest
        path += velocity * STEP * (i >= steps // 2)
    return path / (0.5 * CYCLES / FREQUENCY)


def rows() -> list[str]:
    """Make the rows of the file."""
    random = np.random.default_rng(SEED)
    found = []
    for amplitude in AMPLITUDES:
        speed = mean_speed(1e-3 * amplitude)
        time = LENGTH / speed * (1.0 + NOISE * random.standard_normal()) if speed > 0.0 else math.inf
        found.append(f"{amplitude:g},{f'{time:.1f}' if time < math.inf else 'never'}")
    return found


def main(path: Path) -> None:
    path.write_text(
        "\n".join(["amplitude_mm,traverse_time_s", *rows()]) + "\n", encoding="utf-8", newline="\n"
    )


if __name__ == "__main__":
    main(Path(sys.argv[1]))
