"""Records made without the package: by another solver, and by a study with smoothed friction."""

from __future__ import annotations

import math
import runpy
from pathlib import Path
from typing import Any

import numpy as np
from event_walk import Body
from numpy.typing import NDArray
from scenes import GRAVITY, Groups

import vibro
from vibro.records.alignment import Observation

Floats = NDArray[np.float64]

EXAMPLES = Path(__file__).parents[1] / "examples"
STUDY: dict[str, Any] = runpy.run_path(str(EXAMPLES / "data" / "make_nut_smoothed_600hz.py"))
STUDY_FILE = EXAMPLES / "data" / "nut_smoothed_600hz.csv"

FREQUENCY = 15.0
PERIOD = 1.0 / FREQUENCY
RATE = 2.0 * math.pi * FREQUENCY
NOISE = {"displacement": 2e-6, "velocity": 4e-4, "acceleration": 5e-2, "friction": 5e-2}


def nut(amplitude_mm: float = 1.0, **others: Any) -> vibro.Scene:
    values: dict[str, Any] = {
        "amplitude": 1e-3 * amplitude_mm,
        "frequency": FREQUENCY,
        "drive_angle": math.radians(20.0),
        "static_friction": 0.74,
        "kinetic_friction": 0.57,
    }
    return vibro.Scene(**(values | others))


class Walked:
    """The settled motion of a flat scene by the walk from slide to slide, over trough time."""

    def __init__(self, scene: vibro.Scene) -> None:
        self.amplitude = float(scene.amplitude)
        alpha = float(scene.drive_angle)
        load = self.amplitude * RATE**2 / GRAVITY
        mu_s, mu_d = float(scene.static_friction), float(scene.kinetic_friction)
        body = Body(Groups(load, math.degrees(alpha), mu_s, mu_d))
        self.pattern, advance = body.settle()
        unit = GRAVITY / RATE**2
        self.advance = advance * unit
        self.slides = []
        count = self.pattern.count("F") + self.pattern.count("B")
        walk = body.walk(0.0)
        settled = [next(walk) for _ in range(400)][-count:] if count else []
        for slide in settled:
            self.slides.append((slide.way, slide.start / RATE, slide.length / RATE))
        self.drag = dict.fromkeys((1, -1), mu_d)
        self.pull = {
            way: (math.cos(alpha) + way * mu_d * math.sin(alpha)) * self.amplitude * RATE**2
            for way in (1, -1)
        }
        self.inertia = self.amplitude * RATE**2 * math.cos(alpha)

    def acceleration(self, time: Floats) -> Floats:
        """Relative acceleration [m/s^2]."""
        result = np.zeros_like(time)
        for way, start, length in self.slides:
            slides = (time - start) % PERIOD < length
            value = self.pull[way] * np.sin(RATE * time) - way * self.drag[way] * GRAVITY
            result[slides] = value[slides]
        return result

    def velocity(self, time: Floats) -> Floats:
        """Relative velocity [m/s]."""
        result = np.zeros_like(time)
        for way, start, length in self.slides:
            since = (time - start) % PERIOD
            slides = since < length
            turned = self.pull[way] / RATE * (np.cos(RATE * start) - np.cos(RATE * (start + since)))
            result[slides] = (turned - way * self.drag[way] * GRAVITY * since)[slides]
        return result

    def displacement(self, time: Floats) -> Floats:
        """Relative displacement by summing up the velocity finely [m]; 0 at the first time."""
        fine = np.linspace(time[0], time[-1], 400_001)
        velocity = self.velocity(fine)
        steps = 0.5 * (velocity[1:] + velocity[:-1]) * np.diff(fine)
        return np.asarray(np.interp(time, fine, np.concatenate([[0.0], np.cumsum(steps)])))

    def observe(
        self, *signals: str, noise: float = 1.0, trigger: float = 0.0137, cycles: int = 20, seed: int = 1
    ) -> Observation:
        """Sample some signals at 600 1/s, with noise, from a trough time on."""
        time = np.arange(cycles * 40 + 1) / 600.0
        random = np.random.default_rng(seed)
        trough = time + trigger
        values = {}
        for name in signals:
            if name == "friction":
                exact = self.acceleration(trough) - self.inertia * np.sin(RATE * trough)
            else:
                exact = getattr(self, name)(trough)
            values[name] = exact + noise * NOISE[name] * random.standard_normal(time.size)
        return Observation(time, values, FREQUENCY)
