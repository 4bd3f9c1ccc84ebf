"""Make phone_trough_200hz.csv: a telephone on the trough of a feeder, as phyphox exports its acceleration.

The feeder is that of nut_trough_mv.csv. The telephone lies on the trough with its top against the conveying
direction, but not square to it: one edge rests on a weld, and its long side points beside the trough's. Its
accelerometer is of the cheap kind: each axis has an offset, a wrong sensitivity and a part of the others.
vibro has no part in it.

    python examples/data/make_phone_trough_200hz.py examples/data/phone_trough_200hz.csv
"""

from __future__ import annotations

import math
import runpy
import sys
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

NUT: dict[str, Any] = runpy.run_path(str(Path(__file__).parent / "make_nut_trough_mv.py"))

SAMPLE_RATE = 200.3  # [1/s]
ROWS = 500
TRIGGER_TIME = 0.0291  # [s] after the trough passed its middle upwards
GRAVITY = 9.81  # [m/s^2]
# Axes of the telephone in those of the trough: along, normal (up), across.
PITCH, YAW = math.radians(3.0), math.radians(8.0)  # of the top, below the trough's surface and to the side
OFFSETS = (0.06, -0.05, 0.08)  # [m/s^2] of x, y, z
WRONG = ((0.006, 0.01, -0.004), (-0.008, -0.008, 0.006), (0.004, -0.005, 0.01))  # of each by x, y, z
NOISE, STEP = 0.012, 0.0024  # [m/s^2] one sigma, and the last bit
SEED = 16

Floats = NDArray[np.float64]


def axes() -> Floats:
    """Return the telephone's x (to its right), y (to its top) and z (out of its screen) as rows."""
    top = -np.array([math.cos(PITCH) * math.cos(YAW), math.sin(PITCH), math.cos(PITCH) * math.sin(YAW)])
    out = np.array([0.0, 1.0, 0.0]) - top[1] * top
    out /= np.linalg.norm(out)
    # Of along, up and across, with across to the right of along, the right-hand rule is turned round.
    return np.array([np.cross(out, top), top, out])


def readings(time: Floats) -> Floats:
    """Return what its axes show of gravity and of the trough's acceleration, (rows, 3) [m/s^2]."""
    rate = 2.0 * math.pi * NUT["FREQUENCY"]
    peak, angle = NUT["AMPLITUDE"] * rate**2, NUT["DRIVE_ANGLE"]
    wave = -peak * np.sin(rate * (time + TRIGGER_TIME))
    up = np.array([0.0, GRAVITY, 0.0])
    proper = np.outer(wave, [math.cos(angle), math.sin(angle), 0.0]) + up
    shown = proper @ axes().T @ (np.eye(3) + WRONG).T + OFFSETS
    shown += NOISE * np.random.default_rng(SEED).standard_normal(shown.shape)
    return np.asarray(np.round(shown / STEP) * STEP)


def main(path: Path) -> None:
    time = np.arange(ROWS) / SAMPLE_RATE
    heads = ["Time (s)", *(f"Acceleration {axis} (m/s^2)" for axis in "xyz"), "Absolute acceleration (m/s^2)"]
    lines = [",".join(f'"{head}"' for head in heads)]
    for t, row in zip(time, readings(time), strict=True):
        lines.append(",".join(f"{x:.5E}" for x in (t, *row, float(np.linalg.norm(row)))))
    path.write_text("\n".join(lines) + "\n", encoding="utf-8", newline="\n")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
