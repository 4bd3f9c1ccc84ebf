"""Which curve through the samples of one period? A cubic spline of the acceleration, or harmonics.

Usage: python benchmarks/samples.py [--cycles 12]

Three accelerations whose truth is known, the jumps of the last one between samples: a sine with harmonics 2,
3 and 5, a trapezoid with ramps of 5 % of the period, and two levels. Each is sampled n times a period, as
acceleration and as displacement, without noise and with it (0.1 % and 1 % of the largest value, white).
Loads: root mean square of the acceleration's error over its largest value, in per cent. Speeds: of a body on
a level trough, mu_s 0.3 and mu_d 0.25, by small time steps; their errors in per cent of the true one.

``vibro.Motion.samples`` takes the first and the last way.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import Final

import numpy as np
from scipy.interpolate import CubicSpline

import vibro

FINE: Final = 16_384  # points of a period, at which all are compared
COUNTS: Final = (8, 16, 32, 64, 128, 256, 1024)
MOST: Final = 16  # harmonics
FREQUENCY: Final = 2.5  # [Hz]
GRAVITY: Final = 9.81  # [m/s^2]
MU_S, MU_D = 0.3, 0.25
SHIFT: Final = 0.0037  # [1] of the period, by which jumps miss the samples

Floats = np.ndarray
Curve = Callable[[Floats], Floats]


def sine(s: Floats) -> Floats:
    """Return a fundamental with three harmonics [m/s^2]."""
    levels = ((1, 4.0, 0.0), (2, 2.0, -1.9), (3, 0.8, 0.7), (5, 0.3, 2.0))
    return sum(size * np.sin(2.0 * np.pi * k * s + phase) for k, size, phase in levels)


def trapezoid(s: Floats) -> Floats:
    """Return two plateaus of 4 and -8 m/s^2 with ramps between them."""
    corners = np.array([0.0, 0.05, 0.65, 0.7, 0.95, 1.0])
    values = np.interp((s - SHIFT) % 1.0, corners, np.array([0.0, 4.0, 4.0, -8.0, -8.0, 0.0]))
    return values - 0.2  # the mean


def two_levels(s: Floats) -> Floats:
    """Return a slip-stick drive: gently forward for 70 % of the period, then back."""
    return np.where((s - SHIFT) % 1.0 < 0.7, 4.0, -28.0 / 3.0)


def displacement(acceleration: Floats) -> Floats:
    """Integrate one period twice [m s^2/s^2 at 1 Hz]."""
    spectrum = np.fft.rfft(acceleration)
    k = np.arange(spectrum.size)
    k[0] = 1
    spectrum[0] = 0.0
    return np.fft.irfft(-spectrum / (2.0 * np.pi * k) ** 2, acceleration.size)


def splined(samples: Floats) -> Floats:
    """Join accelerations by a periodic cubic spline, as vibro does."""
    motion = vibro.Motion.samples(along=samples)
    return motion.accelerations(np.arange(FINE) / FINE)[0]


def heard(samples: Floats) -> Floats:
    """Sum the harmonics of displacements that stand out from their noise, as vibro does."""
    motion = vibro.Motion.samples(along=samples, of="displacement")
    angle = 2.0 * np.pi * np.arange(FINE) / FINE
    waves = enumerate(motion.along, 1)
    return sum(-((2.0 * np.pi * k) ** 2) * x * np.sin(k * angle + phase) for k, (x, phase) in waves)


def splined_twice_derived(samples: Floats) -> Floats:
    """Join displacements by a spline, and differentiate it twice."""
    n = samples.size
    curve = CubicSpline(np.arange(n + 1) / n, np.append(samples, samples[0]), bc_type="periodic")
    return curve(np.arange(FINE) / FINE, 2)


def harmonics(samples: Floats, power: int = 0) -> Floats:
    """Sum the harmonics that samples bear, up to 16; with power 2 of the second derivative."""
    n = samples.size
    most = min(MOST, (n - 1) // 2)
    spectrum = np.zeros(FINE // 2 + 1, complex)
    k = np.arange(1, most + 1)
    spectrum[1 : most + 1] = np.fft.rfft(samples)[1 : most + 1] * (2j * np.pi * k) ** power * (FINE / n)
    return np.fft.irfft(spectrum, FINE)


def speeds(accelerations: Floats, cycles: int) -> Floats:
    """Return the mean speeds of bodies on troughs (cases, FINE), by small steps from rest [m/s]."""
    step = 1.0 / FREQUENCY / FINE
    speed = np.zeros(accelerations.shape[0])
    moved = np.zeros_like(speed)
    for _ in range(cycles):
        moved[:] = 0.0
        for a in accelerations.T:
            slides = (speed != 0.0) | (np.abs(a) > MU_S * GRAVITY)
            way = np.where(speed != 0.0, np.sign(speed), -np.sign(a))
            new = np.where(slides, speed - (a + way * MU_D * GRAVITY) * step, 0.0)
            new = np.where(new * way < 0.0, 0.0, new)
            moved += 0.5 * (speed + new) * step
            speed = new
    return moved * FREQUENCY


def main() -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cycles", type=int, default=12, help="after which the body has settled")
    cycles = parser.parse_args().cycles
    s = np.arange(FINE) / FINE
    random = np.random.default_rng(7)
    ways: dict[str, tuple[str, Curve]] = {
        "acceleration: spline": ("acceleration", splined),
        "acceleration: harmonics": ("acceleration", harmonics),
        "displacement: harmonics": ("displacement", lambda x: harmonics(x, 2)),
        "displacement: spline": ("displacement", splined_twice_derived),
        "displacement: heard": ("displacement", heard),
    }
    for noise in (0.0, 0.001, 0.01):
        for wave in (sine, trapezoid, two_levels):
            truth = wave(s)
            moved = displacement(truth)
            cases = [truth]
            for of, way in ways.values():
                for n in COUNTS:
                    source = truth if of == "acceleration" else moved
                    # sampled where the function is known: FINE is a multiple of every n
                    taken = source[:: FINE // n]
                    taken = taken + noise * np.abs(source).max() * random.standard_normal(n)
                    cases.append(way(taken))
            found = speeds(np.array(cases), cycles)
            print(f"\n{wave.__name__}, noise {100 * noise:g} %; true speed {1e3 * found[0]:.3f} mm/s")
            print(f"{'n':>36}" + "".join(f"{n:>9}" for n in COUNTS))
            place = 1
            for name in ways:
                row = cases[place : place + len(COUNTS)]
                rms = [100.0 * np.sqrt(np.mean((x - truth) ** 2)) / np.abs(truth).max() for x in row]
                off = [100.0 * (v / found[0] - 1.0) for v in found[place : place + len(COUNTS)]]
                print(f"{name:<28}{'load':>8}" + "".join(f" {x:8.2g}" for x in rms))
                print(f"{'':<28}{'speed':>8}" + "".join(f" {x:8.2g}" for x in off))
                place += len(COUNTS)


if __name__ == "__main__":
    main()
