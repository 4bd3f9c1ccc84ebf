"""Make nut_trough_mv.csv: a nut on a feeder as a logger records it, with two accelerometers on the trough.

A displacement sensor follows the nut relative to the trough. The accelerometers give millivolts, 100 mV/g,
with an offset and noise; cells are empty where the logger lost samples. The nut slides forwards once in a
cycle, by the closed form of a slide; vibro has no part in it. The clock starts at a trough phase that the
file does not tell.

    python examples/data/make_nut_trough_mv.py examples/data/nut_trough_mv.csv
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

AMPLITUDE = 1.02e-3  # [m]
FREQUENCY = 15.003  # [Hz]
DRIVE_ANGLE = math.radians(20.5)
STATIC_FRICTION, KINETIC_FRICTION = 0.74, 0.57
GRAVITY = 9.81  # [m/s^2]

SAMPLE_RATE = 600.0  # [1/s]
TRIGGER_TIME = 0.0137  # [s] after the trough passed its middle upwards
ROWS = 481
SENSITIVITY = 100.0 / 9.80665  # [mV s^2/m]
OFFSETS = {"along": 31.0, "normal": -12.0}  # [mV]
NOISE = {"displacement": 3e-6, "voltage": 2.0}  # [m], [mV], one sigma
LOST = {"Weg in mm": (57, 311), "Trog normal [mV]": (200, 201)}  # rows
SEED = 15

Floats = NDArray[np.float64]


def slide() -> tuple[float, float, float, float]:
    """Start and end of the slide of a cycle [rad], its acceleration's amplitude, and friction [m/s^2]."""
    drive = AMPLITUDE * (2.0 * math.pi * FREQUENCY) ** 2
    cosine, sine = math.cos(DRIVE_ANGLE), math.sin(DRIVE_ANGLE)
    start = math.asin(STATIC_FRICTION * GRAVITY / (drive * (cosine + STATIC_FRICTION * sine)))
    pull, drag = drive * (cosine + KINETIC_FRICTION * sine), KINETIC_FRICTION * GRAVITY

    def speed(phase: float) -> float:
        return pull * (math.cos(start) - math.cos(phase)) - drag * (phase - start)

    end = brentq(speed, math.pi - start, 2.0 * math.pi)
    return start, float(end), pull, drag


def displacement(phase: Floats) -> Floats:
    """Return the nut's displacement relative to the trough [m]."""
    start, end, pull, drag = slide()

    def path(since: Floats | float) -> Floats:
        turned = np.sin(start + since) - math.sin(start)
        return np.asarray(pull * (since * math.cos(start) - turned) - 0.5 * drag * np.square(since))

    turns, since = np.divmod(phase - start, 2.0 * math.pi)
    advance = path(np.minimum(since, end - start)) + turns * path(end - start)
    return np.asarray(advance / (2.0 * math.pi * FREQUENCY) ** 2)


def table() -> dict[str, Floats]:
    """Make the columns of the file, NaN where the logger lost a sample."""
    time = np.arange(ROWS) / SAMPLE_RATE
    phase = 2.0 * math.pi * FREQUENCY * (time + TRIGGER_TIME)
    random = np.random.default_rng(SEED)
    acceleration = -AMPLITUDE * (2.0 * math.pi * FREQUENCY) ** 2 * np.sin(phase)
    along = acceleration * math.cos(DRIVE_ANGLE) * SENSITIVITY + OFFSETS["along"]
    normal = acceleration * math.sin(DRIVE_ANGLE) * SENSITIVITY + OFFSETS["normal"]
    way = displacement(phase)
    columns = {
        "Zeit in s": time,
        "Weg in mm": 1e3 * (way - way[0] + NOISE["displacement"] * random.standard_normal(ROWS)),
        "Trog längs [mV]": along + NOISE["voltage"] * random.standard_normal(ROWS),
        "Trog normal [mV]": normal + NOISE["voltage"] * random.standard_normal(ROWS),
    }
    for name, rows in LOST.items():
        columns[name][list(rows)] = np.nan
    return columns


def main(path: Path) -> None:
    columns = table()
    digits = (6, 4, 2, 2)
    rows = (
        ";".join("" if math.isnan(x) else f"{x:.{n}f}" for x, n in zip(row, digits, strict=True))
        for row in zip(*columns.values(), strict=True)
    )
    text = "\n".join([";".join(columns), *(row.replace(".", ",") for row in rows)])
    path.write_text(text + "\n", encoding="utf-8", newline="\n")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
