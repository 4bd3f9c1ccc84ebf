"""Records of a body and of accelerometers on its trough, drawn at random and made without the package."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from engines.harmonic_flight import Body, NeverRepeatsError, Settled
from scipy.signal import lfilter

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Complexes = NDArray[np.complex128]

GRAVITY = 9.81
TURN = 2.0 * math.pi
SETTLING = 80  # [cycles]


class Drawn(NamedTuple):
    """A feeder and how it is recorded.

    Lengths are counted in g/w^2; the trough's acceleration along each axis is minus the sum of
    Im(w_n exp(i n p)), in g.
    """

    frequency: float
    drive_angle: float
    trough_angle: float
    along: Complexes
    normal: Complexes
    settled: Settled
    true: dict[str, float]
    motion: str
    signal: str
    noise: str
    cycles: int
    one_sensor: bool


def _phases(random: np.random.Generator, size: int) -> NDArray[np.float64]:
    return np.append(0.0, random.uniform(-math.pi, math.pi, size - 1))


def draw_record(random: np.random.Generator, *, harmonics: bool, hops: bool) -> Drawn:
    """Draw feeders until one moves its body, with flights or without, and repeats in every cycle."""
    cycles = int(random.integers(8, 26))
    while True:
        alpha = math.radians(random.uniform(10.0, 40.0))
        beta = math.radians(random.choice([0.0, random.uniform(0.0, 6.0)]))
        static = random.uniform(0.1, 0.9)
        kinetic = static * random.uniform(0.5, 1.0)
        throw = random.uniform(1.05, 2.2) if hops else random.uniform(0.1, 0.95)
        load = throw * math.cos(beta) / math.sin(alpha)
        second = math.exp(random.uniform(math.log(0.02), math.log(0.4)))
        shares = np.array([1.0, second, second * random.uniform(0.0, 0.5)])
        shares = shares if harmonics else shares[:1]
        ways: list[Complexes] = [
            np.asarray(load * part * shares * np.exp(1j * _phases(random, shares.size)), np.complex128)
            for part in (math.cos(alpha), math.sin(alpha))
        ]
        try:
            settled = Settled(Body(ways[0], ways[1], static, kinetic, beta), cycles + 3, SETTLING)
        except NeverRepeatsError:
            continue
        if ("H" in settled.kinds) == hops and set(settled.kinds) & set("FB"):
            break
    return Drawn(
        frequency=random.uniform(10.0, 60.0),
        drive_angle=alpha,
        trough_angle=beta,
        along=ways[0],
        normal=ways[1],
        settled=settled,
        true={"static_friction": static, "kinetic_friction": kinetic},
        motion="hops" if hops else "slides",
        signal=str(random.choice(["displacement", "velocity"])),
        noise=str(random.choice(["white", "AR(1)"])),
        cycles=cycles,
        one_sensor=not harmonics and random.random() < 0.2,
    )


def write_record(path: Path, random: np.random.Generator, drawn: Drawn) -> list[str]:
    """Sample a feeder with noise into a file; return the arguments of ``vibro measure`` to fit friction."""
    rate = TURN * drawn.frequency
    samples = random.uniform(30.0, 100.0)
    time = np.arange(int(drawn.cycles * samples)) / (samples * drawn.frequency)
    phase = rate * time + random.uniform(0.0, TURN)
    lasting = random.uniform(0.3, 0.8) if drawn.noise == "AR(1)" else 0.0

    def noise(size: float) -> Floats:
        white = random.standard_normal(time.size + 100)
        made = lfilter([math.sqrt(1.0 - lasting**2)], [1.0, -lasting], white)[100:]
        return np.asarray(size * made)

    cycle = np.linspace(0.0, TURN, 2001)
    if drawn.signal == "displacement":
        header, unit = "x [mm]", 1e3 * GRAVITY / rate**2
        exact, peak = drawn.settled.path(phase), float(np.ptp(drawn.settled.path(cycle)))
    else:
        header, unit = "v [mm/s]", 1e3 * GRAVITY / rate
        exact, peak = drawn.settled.speed(phase), float(np.abs(drawn.settled.speed(cycle)).max())
    columns = {"t [s]": time, header: unit * (exact - exact[0] + noise(random.uniform(0.005, 0.05) * peak))}
    if drawn.signal == "velocity":
        columns[header] += unit * exact[0]
    size = math.exp(random.uniform(math.log(0.002), math.log(0.05)))
    strength = size * math.hypot(abs(drawn.along[0]), abs(drawn.normal[0]))
    orders = np.arange(1, drawn.along.size + 1)
    for name, waves in (("along", drawn.along), ("normal", drawn.normal)):
        exact = -(np.exp(1j * np.outer(phase, orders)) @ waves).imag
        columns[f"{name} [m/s^2]"] = GRAVITY * (exact + noise(strength) + random.uniform(-1.0, 1.0))
    if drawn.one_sensor:
        del columns["normal [m/s^2]"]
    np.savetxt(
        path, np.stack(list(columns.values()), axis=1), "%.9g", ",", header=",".join(columns), comments=""
    )
    start = {name: value * random.uniform(0.7, 1.3) for name, value in drawn.true.items()}
    kinetic = min(start["kinetic_friction"], start["static_friction"])
    sensors = [*([] if drawn.one_sensor else ["--trough-normal", "normal"]), "--trough-along", "along"]
    angle = ["-a", f"{math.degrees(drawn.drive_angle):.12g}"] if drawn.one_sensor else []
    return [
        str(path), *sensors, *angle, "--mu-s", f"{start['static_friction']:.6g}", "--mu-d", f"{kinetic:.6g}",
        "--trough-angle", f"{math.degrees(drawn.trough_angle):.12g}", "--fit", "mu_s,mu_d",
    ]  # fmt: skip
