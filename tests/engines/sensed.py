"""Bodies that slide on a moving trough, and the sensors that record them: nothing here is the package's.

The trough moves by harmonics in two directions, and the body stays on it. Its speed in a slide is in closed
form; events are bracketed on a fine mesh of the time. Sensors see the trough's acceleration and the body's
motion as data sheets say: turned, with a wrong gain, sensitive across their axis, filtered, sampled late or
early, rounded, with noise.
"""

from __future__ import annotations

import cmath
import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.optimize import brentq

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

TURN = 2.0 * math.pi
GRAVITY = 9.81
MESH = 2048  # [points a cycle]


class Waves(NamedTuple):
    """Complex amplitudes of sines of the multiples of a frequency [Hz]."""

    frequency: float
    sizes: tuple[complex, ...]

    def at(self, time: Floats | float, derivative: int = 0, corner: float = math.inf) -> Floats:
        """Return the sum, or a derivative of it, behind a low-pass filter of the first order [Hz]."""
        total = 0.0 * np.asarray(time)
        for k, size in enumerate(self.sizes, 1):
            rate = TURN * k * self.frequency
            size *= (1j * rate) ** derivative / (1.0 + 1j * k * self.frequency / corner)
            total = total + (size * np.exp(1j * rate * np.asarray(time))).imag
        return np.asarray(total)


class Sliding:
    """The settled motion of a body on a trough.

    Raises
    ------
    ArithmeticError
        If it hops, rests, slides away or does not settle.
    """

    def __init__(self, along: Waves, normal: Waves, mu_s: float, mu_d: float, slope: float) -> None:
        self.along, self.normal, self.period = along, normal, 1.0 / along.frequency
        self._frictions, self._slope = (mu_s, mu_d), slope
        if float(self._support(np.linspace(0.0, self.period, MESH)).min()) <= 0.0:
            raise ArithmeticError("the body hops")
        self.slides = self._settled()
        ways = [way for way, *_ in self.slides]
        rests = [
            after > end + 1e-12
            for (_, _, end), after in zip(
                self.slides, [s[1] for s in self.slides[1:]] + [self.slides[0][1] + self.period], strict=True
            )
        ]
        pieces = ["FB"[way < 0] + "_" * rest for way, rest in zip(ways, rests, strict=True)]
        first = ways.index(1) if 1 in ways else 0
        self.pattern = "".join(pieces[first:] + pieces[:first])

    def _support(self, time: Floats) -> Floats:
        return GRAVITY * math.cos(self._slope) + self.normal.at(time, 2)

    def _driving(self, time: Floats) -> Floats:
        return -self.along.at(time, 2) - GRAVITY * math.sin(self._slope)

    def _gained(self, way: int, time: Floats, power: int) -> Floats:
        """Integrate the acceleration of a slide once or twice."""
        steady = GRAVITY * (math.sin(self._slope) + way * self._frictions[1] * math.cos(self._slope))
        waves = self.along.at(time, 2 - power) + way * self._frictions[1] * self.normal.at(time, 2 - power)
        return -waves - steady * time**power / power

    def _settled(self) -> list[tuple[int, float, float]]:
        slides: list[tuple[int, float, float]] = []
        time, way = 0.0, 0
        while len(slides) < 4000:
            if not way:
                time, way = self._start(time)
            end = self._end(way, time)
            slides.append((way, time, end))
            time, way = end, self._at_once(end)
            if time > 3.0 * self.period:
                cycle = [s for s in slides if s[1] >= slides[-1][1] - self.period * (1.0 - 1e-9)]
                before = slides[-2 * len(cycle) : -len(cycle)]
                if len(before) == len(cycle) and all(
                    a[0] == b[0] and abs(b[1] - a[1] - self.period) + abs(b[2] - a[2] - self.period) < 1e-11
                    for a, b in zip(before, cycle, strict=True)
                ):
                    return cycle
        raise ArithmeticError("the motion does not settle")

    def _excess(self, way: int, time: Floats | float) -> Floats:
        time = np.asarray(time)
        return way * self._driving(time) - self._frictions[0] * self._support(time)

    def _at_once(self, time: float) -> int:
        return next((way for way in (1, -1) if self._excess(way, time + 1e-9 * self.period) > 0.0), 0)

    def _start(self, time: float) -> tuple[float, int]:
        mesh = time + self.period * np.arange(MESH + 2) / MESH
        found = []
        for way in (1, -1):
            over = np.flatnonzero(self._excess(way, mesh) > 0.0)
            if over.size and over[0]:
                begin, end = mesh[over[0] - 1], mesh[over[0]]
                found.append(
                    (brentq(lambda t, w=way: float(self._excess(w, t)), begin, end, xtol=1e-16), way)
                )
        if not found:
            raise ArithmeticError("the body rests")
        return min(found)

    def _end(self, way: int, time: float) -> float:
        def speed(at: Floats | float) -> Floats:
            at = np.asarray(at)
            return way * (self._gained(way, at, 1) - self._gained(way, np.asarray(time), 1))

        for cycle in range(8):
            mesh = time + self.period * (np.arange(MESH + 1) + 0.5) / MESH + cycle * self.period
            below = np.flatnonzero(speed(mesh) < 0.0)
            if below.size and below[0]:
                begin, end = mesh[below[0] - 1], mesh[below[0]]
                return float(brentq(lambda t: float(speed(t)), begin, end, xtol=1e-16))
            if below.size:
                return float(mesh[0])
        raise ArithmeticError("the body slides away")

    def position(self, time: Floats) -> Floats:
        """Displacement relative to the trough, 0 at the first time [m]."""
        total = np.zeros_like(time)
        for way, start, end in self.slides:
            turns = np.floor((time - start) / self.period)

            def path(stop: Floats, way: int = way, start: float = start) -> Floats:
                first = np.asarray(start)
                moved = self._gained(way, stop, 2) - self._gained(way, first, 2)
                return moved - self._gained(way, first, 1) * (stop - start)

            since = np.minimum(time - turns * self.period, end)
            total += path(since) + turns * path(np.asarray(end))
        return np.asarray(total - total[0])

    def velocity(self, time: Floats) -> Floats:
        """Speed relative to the trough [m/s]."""
        total = np.zeros_like(time)
        for way, start, end in self.slides:
            at = start + (time - start) % self.period
            total += np.where(
                at < end, self._gained(way, at, 1) - self._gained(way, np.asarray(start), 1), 0.0
            )
        return total

    def acceleration(self, time: Floats) -> Floats:
        """Acceleration relative to the trough [m/s^2]."""
        total = np.zeros_like(time)
        for way, start, end in self.slides:
            at = start + (time - start) % self.period
            slides = self._driving(at) - way * self._frictions[1] * self._support(at)
            total += np.where(at < end, slides, 0.0)
        return total

    def seen(self, kind: str, time: Floats, corner: float = math.inf) -> Floats:
        """Return a signal behind a low-pass filter of the first order."""
        if math.isinf(corner):
            signals = {"displacement": self.position, "velocity": self.velocity}
            return np.asarray(signals.get(kind, self.acceleration)(time))
        count = 4 * MESH
        cycle = self.period * np.arange(count + 1) / count
        values = self.seen(kind, cycle)
        trend = float(values[-1] - values[0]) / self.period if kind == "displacement" else 0.0
        waves = np.fft.rfft((values - trend * cycle)[:-1])
        waves /= 1.0 + 1j * np.arange(waves.size) / (self.period * corner)
        periodic = np.fft.irfft(waves, count)
        late = trend * (time - 1.0 / (TURN * corner))
        return np.asarray(late + np.interp(time % self.period, cycle, np.append(periodic, periodic[0])))


class Sensors(NamedTuple):
    """What is wrong with sensors, and with what is said of a drive.

    Attributes
    ----------
    tilt : float
        Angle by which the sensors on the trough are turned together [rad].
    gains : tuple of float
        Relative errors of gain of the sensors along the trough, normal to it, and on the body.
    crosses : tuple of float
        What each of them sees of the motion across its axis.
    corner : float
        Of a low-pass filter of the first order in all channels [Hz].
    late : float
        Standard deviation of the time of a sample [sample times].
    digits : float
        Steps of the converter over the range of each signal; 0 without one.
    noise : tuple of float
        Standard deviations on the trough, over its peak acceleration, and on the body, over A w^k.
    """

    tilt: float = 0.0
    gains: tuple[float, float, float] = (0.0, 0.0, 0.0)
    crosses: tuple[float, float, float] = (0.0, 0.0, 0.0)
    corner: float = math.inf
    late: float = 0.0
    digits: float = 0.0
    noise: tuple[float, float] = (0.05, 0.01)


class Drawn(NamedTuple):
    """A body on a trough, and the signal that is recorded of it."""

    amplitude: float
    angle: float
    slope: float
    frictions: tuple[float, float]
    body: Sliding
    kind: str


PATTERNS = ("F_", "FB_", "F_B_", "FB", "F_B")
KINDS = ("displacement", "velocity", "acceleration")


def draw(random: np.random.Generator, number: int, *, harmonics: bool = False) -> Drawn:
    """Draw bodies until one slides in a pattern, on a line or on harmonics whose phases differ."""
    kind, pattern = KINDS[number % 3], PATTERNS[number % 5]
    while True:
        frequency, angle = random.uniform(10.0, 60.0), math.radians(random.uniform(10.0, 40.0))
        slope = math.radians(random.choice([0.0, random.uniform(0.0, 6.0)]))
        mu_s = random.uniform(0.1, 0.9)
        mu_d = mu_s * random.uniform(0.5, 1.0)
        amplitude = random.uniform(0.1, 0.95) * GRAVITY * math.cos(slope) / math.sin(angle)
        amplitude /= (TURN * frequency) ** 2
        second = math.exp(random.uniform(math.log(0.02), math.log(0.4))) / 4.0
        shares = (1.0, second, second * random.uniform(0.0, 0.2)) if harmonics else (1.0,)
        turns = [[0.0, *random.uniform(-math.pi, math.pi, 2)] for _ in range(2)]
        ways = [
            Waves(
                frequency,
                tuple(amplitude * part * cmath.rect(*wave) for wave in zip(shares, turn, strict=False)),
            )
            for part, turn in zip((math.cos(angle), math.sin(angle)), turns, strict=True)
        ]
        try:
            body = Sliding(ways[0], ways[1], mu_s, mu_d, slope)
        except ArithmeticError:
            continue
        if body.pattern == pattern:
            return Drawn(amplitude, angle, slope, (mu_s, mu_d), body, kind)


def record(
    random: np.random.Generator, drawn: Drawn, sensors: Sensors, *, rate: float = 2000.0, cycles: float = 60.0
) -> dict[str, Floats]:
    """Sample a body and its trough: the time, accelerations along and normal, and the body's signal [SI].

    An accelerometer on the body sees its motion over the ground.
    """
    along, normal, body = drawn.body.along, drawn.body.normal, drawn.body
    clock = np.arange(int(cycles * rate / along.frequency)) / rate
    time = clock + random.uniform(0.0, body.period)
    if sensors.late:
        time = time + sensors.late / rate * random.standard_normal(time.size)
    corner, power = sensors.corner, KINDS.index(drawn.kind)
    x, y = (way.at(time, 2, corner) for way in (along, normal))
    cosine, sine = math.cos(sensors.tilt), math.sin(sensors.tilt)
    (gx, gy, gb), (cx, cy, cb) = sensors.gains, sensors.crosses
    seen = body.seen(drawn.kind, time, corner)
    if drawn.kind == "acceleration":
        seen = seen + x
    columns = {
        "along": (1.0 + gx) * (cosine * x + sine * y) + cx * y + random.uniform(-5.0, 5.0),
        "normal": (1.0 + gy) * (cosine * y - sine * x) + cy * x + random.uniform(-5.0, 5.0),
        drawn.kind: (1.0 + gb) * seen + cb * normal.at(time, power, corner),
    }
    scale = TURN * along.frequency
    sizes = [sensors.noise[0] * drawn.amplitude * scale**2] * 2 + [
        sensors.noise[1] * drawn.amplitude * scale**power
    ]
    for (name, values), size in zip(columns.items(), sizes, strict=True):
        values = values + size * random.standard_normal(values.size)
        if sensors.digits:
            step = float(np.ptp(values)) / sensors.digits
            values = step * np.round(values / step)
        columns[name] = values
    return {"time": clock} | columns
