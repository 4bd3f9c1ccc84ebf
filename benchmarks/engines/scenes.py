"""The scenes of the benchmark, the loads on the body, and the exact histories; needs NumPy alone."""

from __future__ import annotations

import csv
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

DATA: Final = Path(__file__).parent / "data"
CYCLES: Final = 30  # of the drive, from rest at its phase 0
WINDOW: Final = 10  # last of them, over which mean speeds are taken


@dataclass(frozen=True)
class Scene:
    """A body on a trough that moves by A sin(wt) along a line; SI units and radians."""

    name: str
    amplitude: float
    frequency: float
    drive_angle: float  # above the trough
    trough_angle: float  # above the horizontal
    friction: float  # static and kinetic
    restitution: float
    gravity: float

    @property
    def duration(self) -> float:
        """Time of all cycles [s]."""
        return CYCLES / self.frequency

    def mean_loads(self, step: float) -> Floats:
        """Mean inertia and weight on a unit mass in the trough's frame, along and normal to it [m/s^2].

        Of shape (steps, 2). The mean over a step is exact: minus the change of the trough's velocity, over
        the step. So no engine errs by when it evaluates the load.
        """
        count = round(self.duration / step)
        w = 2.0 * math.pi * self.frequency
        velocity = self.amplitude * w * np.cos(w * step * np.arange(count + 1))
        inertia = -np.diff(velocity) / step
        along = math.cos(self.drive_angle) * inertia - self.gravity * math.sin(self.trough_angle)
        normal = math.sin(self.drive_angle) * inertia - self.gravity * math.cos(self.trough_angle)
        return np.column_stack((along, normal))


def scenes() -> list[Scene]:
    """Read the scenes."""
    with (DATA / "scenes.csv").open(encoding="utf-8", newline="") as file:
        return [
            Scene(
                row["scene"],
                float(row["amplitude_mm"]) / 1e3,
                float(row["frequency_hz"]),
                math.radians(float(row["drive_angle_deg"])),
                math.radians(float(row["trough_angle_deg"])),
                float(row["friction"]),
                float(row["restitution"]),
                float(row["gravity_m_s2"]),
            )
            for row in csv.DictReader(file)
        ]


def history_file(scene: Scene) -> Path:
    """Path of the CSV with a scene's exact history."""
    return DATA / f"{scene.name.replace(' ', '_')}.csv"


def exact_displacements(scene: Scene) -> tuple[float, float]:
    """Exact displacements where the window begins and where it ends [m]."""
    with history_file(scene).open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    times = np.array([float(row["time_s"]) for row in rows])
    found = [int(np.argmin(np.abs(times - cycles / scene.frequency))) for cycles in (CYCLES - WINDOW, CYCLES)]
    first, last = (float(rows[i]["displacement_mm"]) / 1e3 for i in found)
    return first, last
