"""Records of synthetic feeders: troughs with harmonics, and accelerometers with coloured noise."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vibro.records.reading import Record

GRAVITY = 9.81  # [m/s^2]
QUIET = 0.2e-3 * 9.80665  # noise of a good accelerometer, [m/s^2] a root of a hertz
_CORNER = 10.0  # [Hz] below which its power grows as 1/f

Complexes = NDArray[np.complex128]


class Feeder(NamedTuple):
    """A trough's motion: its frequency [Hz], and its displacement harmonics [m], shape (H,) each.

    It moves along itself as the sum of ``abs(x) sin(k w t + angle(x))``.
    """

    frequency: float
    along: Complexes
    normal: Complexes

    @property
    def on_its_clock(self) -> Feeder:
        """The same at times that begin where the first harmonic along the trough has the phase 0."""
        turn = np.exp(-1j * np.angle(self.along[0]) * np.arange(1, self.along.size + 1))
        return self._replace(along=self.along * turn, normal=self.normal * turn)

    def drive(self) -> dict[str, Any]:
        """Return the fields of a scene."""
        ways = {"along_harmonics": self.along, "normal_harmonics": self.normal}
        pairs = {name: [(abs(z), np.angle(z)) for z in way] for name, way in ways.items()}
        return {"frequency": self.frequency, **pairs}

    def record(
        self,
        seed: int,
        *,
        seconds: float = 2.0,
        rate: float = 1600.0,
        density: float = QUIET,
        sensors: int = 2,
        kind: str = "acceleration",
    ) -> Record:
        """Sample its accelerations, velocities or displacements, with offset, trend and noise."""
        random = np.random.default_rng([seed, 1])
        time = np.arange(round(seconds * rate) + 1) / rate
        signals = {}
        for name, way in (("trough_along", self.along), ("trough_normal", self.normal))[:sensors]:
            rates = math.tau * self.frequency * np.arange(1, way.size + 1)
            derived = way * (1j * rates) ** ("displacement", "velocity", "acceleration").index(kind)
            wave = (np.exp(1j * np.outer(time, rates)) @ derived).imag
            drift = random.uniform(-3.0, 3.0) + random.uniform(-0.1, 0.1) * time
            signals[name] = wave + drift + noise(time.size, rate, density, random)
        names = {name: name for name in signals}
        return Record(time, {}, signals, names, trough_kinds=dict.fromkeys(signals, kind))


def noise(count: int, rate: float, density: float, random: np.random.Generator) -> NDArray[np.float64]:
    """Draw noise that is white above 10 Hz, with a power that grows as 1/f below."""
    frequency = np.fft.rfftfreq(count, 1.0 / rate)
    power = density**2 * np.maximum(1.0, _CORNER / np.maximum(frequency, rate / count))
    waves = random.standard_normal((2, frequency.size)) * np.sqrt(0.25 * power * rate * count)
    waves[:, 0] = 0.0
    return np.fft.irfft(waves[0] + 1j * waves[1], count)


def feeder(seed: int) -> Feeder:
    """Draw a feeder in contact: 20 to 60 Hz, 15 to 40 deg, second and third harmonics of 5 to 30 %."""
    random = np.random.default_rng(seed)
    frequency, angle = random.uniform(20.0, 60.0), math.radians(random.uniform(15.0, 40.0))
    load = random.uniform(0.3, 0.7) * GRAVITY * np.array([1.0, *random.uniform(0.05, 0.3, 2)])
    normal = load * np.exp(1j * random.uniform(0.0, math.tau, 3))
    ahead = np.exp(1j * np.array([0.0, *random.normal(0.0, 0.3, 2)]))
    rates = math.tau * frequency * np.arange(1, 4)
    return Feeder(frequency, normal / math.tan(angle) / rates**2, normal * ahead / rates**2)
