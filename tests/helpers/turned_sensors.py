"""Records of troughs by sensors that are turned, and wrong in gain, cross-axis sensitivity, offset and delay.

From kinematics alone: a proper acceleration in the world, a rotation into the case, and what its three axes
make of it. Nothing here is vibro's but the class of a record.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vibro.records.reading import Record

G = 9.80665  # [m/s^2]
Floats = NDArray[np.float64]


class Line(NamedTuple):
    """A trough's motion along a line: amplitude [m], frequency [Hz], drive and trough angle [rad]."""

    amplitude: float = 1.0e-3
    frequency: float = 25.0
    angle: float = math.radians(25.0)
    climb: float = 0.0


class Case(NamedTuple):
    """How a sensor of three axes is turned [rad], and what is wrong with it, relative, in m/s^2 or s."""

    pitch: float = 0.0
    yaw: float = 0.0
    roll: float = 0.0
    matrix: Floats = np.zeros((3, 3))
    offsets: Floats = np.zeros(3)
    delays: Floats = np.zeros(3)

    @staticmethod
    def drawn(
        random: np.random.Generator, *, tilt: float, gain: float, cross: float, offset: float, delay: float
    ) -> Case:
        """Draw errors of given standard deviations."""
        matrix = np.where(np.eye(3), gain, cross) * random.standard_normal((3, 3))
        delays = np.array([0.0, *delay * random.standard_normal(2)])
        offsets = offset * random.standard_normal(3)
        pitch, yaw, roll = (tilt * random.standard_normal(3)).tolist()
        return Case(pitch, yaw, roll, matrix, offsets, delays)

    @property
    def axes(self) -> Floats:
        """Its axes (rows) in those of the trough: along, normal, across."""
        (cp, sp), (cy, sy), (cr, sr) = ((math.cos(x), math.sin(x)) for x in (self.pitch, self.yaw, self.roll))
        pitch = np.array([[cp, -sp, 0.0], [sp, cp, 0.0], [0.0, 0.0, 1.0]])  # about the axis across
        yaw = np.array([[cy, 0.0, sy], [0.0, 1.0, 0.0], [-sy, 0.0, cy]])  # about the normal
        roll = np.array([[1.0, 0.0, 0.0], [0.0, cr, -sr], [0.0, sr, cr]])  # about the axis along
        turned: Floats = (pitch @ yaw @ roll).T
        return turned


def record_of(
    line: Line,
    case: Case,
    roles: dict[str, int],
    *,
    gravity: bool = True,
    rate: float = 1000.0,
    seconds: float = 2.0,
    noise: float = 0.02,
    step: float = 0.0,
    lowpass: float = math.inf,
    seed: int = 1,
) -> Record:
    """Sample the readings of some axes of a case, by the names of their roles.

    Parameters
    ----------
    line, case : Line, Case
        Motion and sensor.
    roles : dict of str to int
        Axis of each role: 0 along, 1 normal, 2 across; as ``~axis`` it points the other way.
    gravity : bool
        Whether the axes show gravity and offsets; else they are coupled by capacitors.
    rate, seconds : float
        Sampling rate [Hz] and length [s].
    noise, step : float
        Noise and quantum of each sample [m/s^2].
    lowpass : float
        Corner of a first-order filter in every channel [Hz].
    """
    random = np.random.default_rng([seed, 3])
    time = np.arange(round(rate * seconds) + 1) / rate
    omega = math.tau * line.frequency
    up = np.array([math.sin(line.climb), math.cos(line.climb), 0.0])
    way = np.array([math.cos(line.angle), math.sin(line.angle), 0.0])
    trigger = random.uniform(0.0, 1.0 / line.frequency)
    signals = {}
    for role, axis in roles.items():
        place = axis if axis >= 0 else ~axis
        late = time + trigger - case.delays[place] - math.atan(line.frequency / lowpass) / omega
        size = line.amplitude * omega**2 / math.hypot(1.0, line.frequency / lowpass)
        proper = np.outer(-size * np.sin(omega * late), way) + gravity * G * up
        response = (np.eye(3) + case.matrix)[place] @ case.axes
        reading = (
            proper @ response + gravity * case.offsets[place] + noise * random.standard_normal(time.size)
        )
        reading = np.round(reading / step) * step if step else reading
        signals[role] = reading if axis >= 0 else -reading
    return Record(time, {}, signals, {role: role for role in signals})
