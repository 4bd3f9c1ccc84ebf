"""Records made without the package: by another solver, and by a study with smoothed friction."""

from __future__ import annotations

import functools
import math
import runpy
from pathlib import Path
from typing import Any

import numpy as np
from engines.two_axis_walk import Body
from helpers.scenes import line_of
from numpy.typing import NDArray

import vibro
from vibro.drives import Ellipse
from vibro.records.alignment import Observation
from vibro.records.problem import HOPS
from vibro.records.reading import Record

Floats = NDArray[np.float64]

EXAMPLES = Path(__file__).parents[2] / "examples"
STUDY: dict[str, Any] = runpy.run_path(str(EXAMPLES / "data" / "make_nut_smoothed_600hz.py"))
STUDY_FILE = EXAMPLES / "data" / "nut_smoothed_600hz.csv"

FREQUENCY = 15.0
PERIOD = 1.0 / FREQUENCY
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


def bowl(phase_deg: float = -60.0, **others: Any) -> vibro.Scene:
    """Make a scene of an elliptical drive."""
    values: dict[str, Any] = {
        "along_amplitude": 1e-3,
        "normal_amplitude": 5e-4,
        "normal_phase": math.radians(phase_deg),
        "frequency": FREQUENCY,
        "static_friction": 0.4,
        "kinetic_friction": 0.3,
    }
    return vibro.Scene(**(values | others))


def on_ellipse(x: float, y: float, phase_deg: float, climb_deg: float = 0.0) -> vibro.Scene:
    """Make a scene by its amplitudes in mm."""
    climb = math.radians(climb_deg)
    return bowl(phase_deg, along_amplitude=1e-3 * x, normal_amplitude=1e-3 * y, trough_angle=climb)


#: A scene of every pattern.
ON_ELLIPSES = {
    "_": on_ellipse(0.2, 0.1, -60.0),
    "F_": on_ellipse(0.2, 0.8, -60.0),
    "B_": on_ellipse(0.2, 0.5, -150.0, 6.0),
    "F_B_": on_ellipse(0.5, 0.3, -60.0),
    "FB_": on_ellipse(1.0, 0.5, -60.0),
    "F_B": on_ellipse(0.8, 1.0, 60.0),
    "FB": on_ellipse(1.5, 1.0, -120.0),
    HOPS: on_ellipse(1.0, 1.3, -60.0),
}


class Walked:
    """The settled motion of a scene by a walk from slide to slide, over trough time."""

    def __init__(self, scene: vibro.Scene) -> None:
        gravity, beta, mu_d = (float(x) for x in (scene.gravity, scene.trough_angle, scene.kinetic_friction))
        self.rate = 2.0 * math.pi * float(scene.frequency)
        self.period = 1.0 / float(scene.frequency)
        self.pattern, advance, slides, (along, normal) = _walk(*_fields(scene))
        self.advance = advance * gravity / self.rate**2
        self.slides = [(way, start / self.rate, length / self.rate) for way, start, length in slides]
        # relative acceleration of a slide: pull sin(w t + lead) - drag
        pull = {way: (along + way * mu_d * normal) * self.rate**2 for way in (1, -1)}
        self.pull = {way: abs(value) for way, value in pull.items()}
        self.lead = {way: float(np.angle(value)) for way, value in pull.items()}
        self.drag = {way: gravity * (way * mu_d * math.cos(beta) + math.sin(beta)) for way in (1, -1)}
        self.inertia, self.weight = along * self.rate**2, gravity * math.sin(beta)

    def acceleration(self, time: Floats) -> Floats:
        """Relative acceleration [m/s^2]."""
        result = np.zeros_like(time)
        for way, start, length in self.slides:
            slides = (time - start) % self.period < length
            result[slides] = (self.pull[way] * np.sin(self.rate * time + self.lead[way]) - self.drag[way])[
                slides
            ]
        return result

    def friction(self, time: Floats) -> Floats:
        """Friction on the body per unit mass [m/s^2]."""
        return self.acceleration(time) - self.inertia * np.sin(self.rate * time) + self.weight

    def velocity(self, time: Floats) -> Floats:
        """Relative velocity [m/s]."""
        result = np.zeros_like(time)
        for way, start, length in self.slides:
            since = (time - start) % self.period
            slides = since < length
            first = self.rate * start + self.lead[way]
            turned = np.cos(first) - np.cos(first + self.rate * since)
            result[slides] = (self.pull[way] / self.rate * turned - self.drag[way] * since)[slides]
        return result

    def displacement(self, time: Floats) -> Floats:
        """Relative displacement [m]; 0 at the first time."""
        result = np.zeros_like(time)
        for way, start, length in self.slides:
            turns = np.floor((time - start) / self.period)
            since = np.minimum(time - start - turns * self.period, length)
            result += self._path(way, start, since) + turns * self._path(way, start, length)
        return np.asarray(result - result[0])

    def trough(self, time: Floats) -> dict[str, Floats]:
        """Motion of the trough along itself [m, m/s, m/s^2]."""
        size, phase = self.inertia / self.rate**2, self.rate * time
        return {
            "displacement": size * np.sin(phase),
            "velocity": size * self.rate * np.cos(phase),
            "acceleration": -self.inertia * np.sin(phase),
        }

    def _path(self, way: int, start: float, since: Any) -> Any:
        """Displacement since the start of a slide [m]."""
        first = self.rate * start + self.lead[way]
        swing = since * math.cos(first) - (np.sin(first + self.rate * since) - math.sin(first)) / self.rate
        return self.pull[way] / self.rate * swing - 0.5 * self.drag[way] * since**2

    def observe(
        self,
        *signals: str,
        noise: float = 1.0,
        trigger: float = 0.0137,
        cycles: int = 10,
        seed: int = 1,
        over_ground: bool = False,
    ) -> Observation:
        """Sample some signals at 600 1/s, with noise, from a trough time on, maybe over the ground."""
        time = np.arange(cycles * 40 + 1) / 600.0
        random = np.random.default_rng(seed)
        trough = time + trigger
        values, moved = {}, self.trough(trough) if over_ground else {}
        for name in signals:
            exact = getattr(self, name)(trough) + moved.get(name, 0.0)
            values[name] = exact + noise * NOISE[name] * random.standard_normal(time.size)
        return Observation(time, values, FREQUENCY)


# Pattern, displacement per cycle [g/w^2], way, start and length of each slide [rad], and the amplitudes of
# the trough's motion along itself and normal to it, with its phase as that of a complex number [m].
Walk = tuple[str, float, list[tuple[int, float, float]], tuple[float, complex]]


@functools.cache  # tests have few scenes
def _walk(*fields: float) -> Walk:
    along, normal, lead, *_ = fields
    cycle = Body(*fields).settle()
    ways = {"F": 1, "B": -1}
    slides = [(ways[leg.kind], leg.start, leg.length) for leg in cycle.legs if leg.kind in ways]
    return cycle.pattern, cycle.displacement, slides, (along, normal * np.exp(1j * lead))


def _fields(scene: vibro.Scene) -> list[float]:
    """Return the amplitudes, the lead, and all else but restitution, as the walk takes them."""
    fields = scene.arrays()
    if isinstance(fields, Ellipse):
        return [float(x) for x in fields[:8]]
    size, (_, frequency, alpha, *others) = float(scene.scale), (float(x) for x in line_of(scene)[:7])
    return [size * math.cos(alpha), size * math.sin(alpha), 0.0, frequency, *others]


def trough_record(
    amplitude: float = 1.02e-3,
    frequency: float = 15.003,
    angle: float = math.radians(20.5),
    *,
    trigger: float = 0.0137,
    start: float = 0.0,
    cycles: float = 12.0,
    samples: int = 40,
    noise: float = 0.0,
    offset: float = 0.0,
    ellipse: float = 0.0,
    harmonic: float = 0.0,
    columns: tuple[str, ...] = ("trough_along", "trough_normal"),
    lost: float = 0.0,
    seed: int = 1,
) -> Record:
    """Sample the accelerations of a trough that moves as a sine along a line, or nearly so.

    Noise and offset are in m/s^2; ``ellipse`` is the phase by which the normal motion runs ahead,
    ``harmonic`` the third one's share of the acceleration, ``lost`` the share of rows that are left out.
    """
    random = np.random.default_rng(seed)
    time = np.arange(round(cycles * samples) + 1) / (samples * frequency)
    time = time[random.random(time.size) >= lost]
    phase = 2.0 * math.pi * frequency * (time + trigger)
    peak = amplitude * (2.0 * math.pi * frequency) ** 2
    parts = {"trough_along": (math.cos(angle), 0.0), "trough_normal": (math.sin(angle), ellipse)}
    signals = {}
    for name in columns:
        part, ahead = parts[name]
        wave = -peak * part * (np.sin(phase + ahead) + harmonic * np.sin(3.0 * (phase + ahead)))
        signals[name] = wave + offset + noise * random.standard_normal(time.size)
    return Record(time + start, {}, signals, {name: name for name in columns})
