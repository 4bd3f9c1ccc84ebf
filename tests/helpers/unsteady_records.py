"""Records of troughs that run steadily, with all that sensors add, and of troughs that do not.

Motions are sums and integrals of sines over time, sampled with a logger's faults; nothing of vibro is used
but the container of a record.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vibro.records.reading import Record

Floats = NDArray[np.float64]
#: What sensors and loggers add to a steady motion.
GOOD = ("white", "jitter", "red", "resonant", "wander", "digits", "lost", "harmonics", "neighbour")
#: What troughs do that do not run steadily.
BAD = ("run-up", "stop", "start and stop", "drift", "beat", "sweep", "step", "slip", "pulses")


class Made(NamedTuple):
    """A record, its kind, and the amplitude in the middle of its steady running."""

    record: Record
    kind: str
    amplitude: float  # [m] of the line's motion; where it is not steady its largest


def good_record(seed: int) -> Made:
    """Draw a record of steady running: 8 to 300 cycles of 5 to 60 Hz, 5 to 60 samples each."""
    random, kind = np.random.default_rng([seed, 17]), GOOD[seed % len(GOOD)]
    return _made(random, kind, lambda time, motion: (np.ones(time.size), np.zeros(time.size)), least=8.0)


def bad_record(seed: int, kind: str) -> Made:
    """Draw a record that is not steady, by half of its amplitude, or by some turns of its phase."""
    random, size = np.random.default_rng([seed, 23]), 0.5

    def departs(time: Floats, frequency: float) -> tuple[Floats, Floats]:
        u = (time - time[0]) / float(np.ptp(time))
        one, zero = np.ones(time.size), np.zeros(time.size)
        if kind == "run-up":
            return 1.0 - size * np.exp(-u / random.uniform(0.03, 0.3)), zero
        if kind == "stop":
            return 1.0 - size * np.exp(-(1.0 - u) / random.uniform(0.03, 0.3)), zero
        if kind == "start and stop":
            start, stop = random.uniform(0.1, 0.4), random.uniform(0.6, 0.9)
            return 1.0 - size * ((u < start) | (u > stop)), zero
        if kind == "drift":
            return 1.0 - size * u, zero
        if kind == "beat":
            apart = random.uniform(2.0, 0.08 * frequency * float(np.ptp(time)) + 3.0)
            wave = 1.0 + 0.5 * size * np.exp(1j * (math.tau * apart * u + random.uniform(0.0, math.tau)))
            return abs(wave), np.angle(wave)
        if kind == "sweep":
            turns = size * 10.0  # from one end to the other: twice the least that matters, to many
            return one, math.tau * turns * u * (u - 1.0)
        if kind == "step":
            return 1.0 - size * (u > random.uniform(0.2, 0.8)), zero
        if kind == "slip":
            return one, math.tau * size * 0.5 * (u > random.uniform(0.2, 0.8))
        turns = random.uniform(1.0, 5.0)
        return 1.0 - size * (0.5 + 0.5 * np.sin(math.tau * turns * u)), zero

    return _made(random, kind, departs, least=24.0)


def _made(random: np.random.Generator, kind: str, departs: Any, least: float) -> Made:
    frequency = float(np.exp(random.uniform(math.log(5.0), math.log(60.0))))
    cycles = float(np.exp(random.uniform(math.log(least), math.log(300.0))))
    samples = float(np.exp(random.uniform(math.log(5.0), math.log(60.0))))
    rate = samples * frequency
    time = np.arange(round(cycles * samples) + 1) / rate
    w = math.tau * frequency
    amplitude = random.uniform(5.0, 40.0) / w**2
    angle = math.radians(random.uniform(10.0, 45.0))
    real = time + (random.normal(0.0, 0.02 / frequency, time.size) if kind == "jitter" else 0.0)
    size, phase = departs(real, frequency)
    wave = -amplitude * w**2 * size * np.sin(w * real + phase + random.uniform(0.0, math.tau))
    if kind == "harmonics":
        for k in (2, 3):
            wave += random.uniform(0.05, 0.3) * amplitude * w**2 * np.sin(k * w * real + k)
    noise = random.uniform(0.002, 0.1) * amplitude * w**2
    trough = {}
    for name, part in (("trough_along", math.cos(angle)), ("trough_normal", math.sin(angle))):
        values = part * wave + noise * random.standard_normal(time.size)
        if kind == "red":  # an autoregressive process of a memory of some samples
            values += _filtered(2.0 * noise * random.standard_normal(time.size), [random.uniform(0.5, 0.95)])
        if kind == "resonant":  # a spring that rings at 0.7 to 3 times the drive's frequency
            at, damping = random.uniform(0.7, 3.0) * w / rate, random.uniform(0.1, 0.4)
            radius = math.exp(-damping * at)
            poles = [2.0 * radius * math.cos(at), -(radius**2)]
            values += _filtered(0.5 * noise * random.standard_normal(time.size), poles)
        if kind == "wander":
            values += noise * np.cumsum(random.standard_normal(time.size)) / math.sqrt(samples)
        if kind == "digits":
            values = np.round(values / (3.0 * noise)) * 3.0 * noise
        if kind == "neighbour":  # another machine, at another frequency
            values += 0.05 * amplitude * w**2 * np.sin(1.43 * w * real)
        gravity = 9.81 if name == "trough_normal" else 0.0
        trough[name] = values + gravity + random.uniform(-0.1, 0.1)
    if kind == "lost":
        kept = random.uniform(size=time.size) > 0.03
        kept[[0, -1]] = True
        time, trough = time[kept], {name: values[kept] for name, values in trough.items()}
    record = Record(time + random.uniform(-5.0, 50.0), {}, trough, {name: name for name in trough})
    return Made(record, kind, amplitude)


def _filtered(values: Floats, weights: list[float]) -> Floats:
    """Filter recursively, with weights of the last outputs."""
    from scipy.signal import lfilter

    return np.asarray(lfilter([1.0], [1.0, *(-x for x in weights)], values))
