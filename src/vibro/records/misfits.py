"""The misfit of a record as a function of a scene's free quantities: one sum of squares, by pattern."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np
from scipy.optimize import nnls

from vibro.quantities import AMPLITUDES, ELLIPTICAL, LINEAR
from vibro.records.cycles import HOPS, labels_of, steady_cycles
from vibro.records.folding import fold, independent_samples

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from vibro.records.alignment import Observation
    from vibro.records.cycles import Cycles
    from vibro.scene import Scene

    Floats = NDArray[np.float64]
    Labels = NDArray[np.str_]

__all__ = ["FITTABLE", "Misfits", "Problem", "fittable"]

#: Quantities that can be estimated, of a drive along a line or along an ellipse.
FITTABLE: Final = ("static_friction", "kinetic_friction", *LINEAR, *ELLIPTICAL)

_TURN: Final = 2.0 * math.pi
# Allowed ranges in SI units; those of amplitudes are relative to the scene's, that of the phase to its phase.
_BOUNDS: Final[Mapping[str, tuple[float, float]]] = {
    "static_friction": (1e-3, 3.0),
    "kinetic_friction": (1e-3, 3.0),
    **dict.fromkeys(AMPLITUDES, (0.2, 5.0)),
    "drive_angle": (math.radians(0.5), math.radians(80.0)),
    # A phase has no least value: one turn more to each side than it needs, so that a search and an interval
    # may pass the phase opposite to the scene's.
    "normal_phase": (-1.5 * _TURN, 1.5 * _TURN),
}
# What a sensor adds by itself, as the number of powers of the time: an offset, and for all but a displacement
# a slow drift. The slope of a displacement is the conveying speed, which no sensor of displacement invents.
_POWERS: Final = {"displacement": 1, "velocity": 2, "acceleration": 2, "friction": 2}
# Signals that jump where a slide starts or ends.
_JUMPING: Final = ("acceleration", "friction")
_WINDOW: Final = 0.25  # sample times over which the model's jumps are averaged, so that derivatives exist
_LEAST_VARIANCE: Final = 1e-18  # of a misfit, relative to that of the signal, because data may be exact
_ROUNDING: Final = (
    1e-12  # of the drive's own motion: a misfit counts as at least this, as a signal may be zero
)
_LEAST_SCALE: Final = 1e-3  # of the greatest value that is tried: a quantity counts as at least this large
_RANDOM: Final = 0.1  # share of a misfit that must differ from cycle to cycle for its slope to tell of jitter
_ROUNDS: Final = 3  # of weighting the squares that the variances are regressed on


def fittable(scene: Scene) -> tuple[str, ...]:
    """Quantities of a scene that can be estimated, those of its own drive among them."""
    return tuple(name for name in FITTABLE if name in scene.arrays()._fields)


def _bounds_of(scene: Scene, names: Sequence[str]) -> Floats:
    """Least and greatest value of each free quantity that is tried, shape (2, P) [SI]."""
    bounds = np.array([_BOUNDS[name] for name in names]).T
    for column, name in enumerate(names):
        if name in AMPLITUDES:
            bounds[:, column] *= float(getattr(scene, name))
        elif name == "normal_phase":
            bounds[:, column] += float(getattr(scene, name))
        elif name == "drive_angle":
            upright = 0.5 * math.pi - float(scene.trough_angle)
            bounds[1, column] = min(bounds[1, column], upright - _BOUNDS["drive_angle"][0])
    return bounds


class Misfits(NamedTuple):
    """Of M points: whether they have the pattern that was asked for, and weighted residuals, (M, K)."""

    inside: NDArray[np.bool_]
    residuals: Floats

    @property
    def squares(self) -> Floats:
        """Sum of squares of each point; inf outside the pattern."""
        return np.where(self.inside, np.einsum("ij,ij->i", self.residuals, self.residuals), np.inf)


class Problem:
    """Weighted residuals at points: the P free quantities [SI], then the shift in drive cycles.

    What a sensor adds by itself, its offset and its drift, is projected out of each signal's residuals. The
    unit of the sum of squares is the variance of a misfit with as many independent samples as ``count``.
    """

    def __init__(self, scene: Scene, observation: Observation, names: Sequence[str]) -> None:
        self.observation = observation
        self.names = tuple(names)
        self.fittable = fittable(scene)
        self.fixed = {name: float(value) for name, value in scene.arrays()._asdict().items()}
        self.bounds = _bounds_of(scene, names)
        self.bends = bool(set(names) & set(ELLIPTICAL))  # whether steps of a descent should
        self._size = float(scene.scale)
        self._phases = np.array([name == "normal_phase" for name in names])
        self.count = 0.0
        self._weights: dict[str, Floats] = {}
        self._sensors: dict[str, Floats] = {}
        for name, values in observation.signals.items():
            folded = observation.folded[name]
            rest = values - folded.periodic(observation.time)
            rest = rest - np.polyval(np.polyfit(observation.time, rest, folded.trends), observation.time)
            self._weigh(name, np.ones(values.size), rest, values.size)
            self.count += values.size

    @property
    def own(self) -> Floats:
        """The scene's own values, within the bounds."""
        return np.clip([self.fixed[name] for name in self.names], *self.bounds)

    def scale(self, point: Floats) -> Floats:
        """Size of each coordinate of a point, (P + 1,): its own, unless that is far below what is tried.

        That of a phase is 1 rad, wherever its zero is.
        """
        sizes = np.maximum(np.abs(point[:-1]), _LEAST_SCALE * self.bounds[1])
        return np.append(np.where(self._phases, 1.0, sizes), 1.0)

    def sides(self, point: Floats) -> tuple[bool, ...]:
        """Tell on which side of a motion along a line each phase of a point lies.

        The load of a slide is the same for a phase and its opposite, so that a record of one slide a cycle
        may fit with both: their misfits have two minima in one pattern.
        """
        return tuple((np.sin(point[: self._phases.size][self._phases]) > 0.0).tolist())

    def unwound(self, point: Floats, near: Floats) -> Floats:
        """Move phases of a point, (P + 1,), by whole turns to where they are closest to others, (P,)."""
        moved = point.copy()
        moved[:-1] -= np.where(self._phases, _TURN * np.round((point[:-1] - near) / _TURN), 0.0)
        return moved

    def values(self, points: Floats) -> dict[str, Floats]:
        """Fields of the scenes at points of shape (M, P) or (M, P + 1)."""
        values = {name: np.full(points.shape[0], value) for name, value in self.fixed.items()}
        return values | {name: points[:, column].copy() for column, name in enumerate(self.names)}

    def labels(self, points: Floats) -> Labels:
        """Pattern at each point; empty where there is no steady cycle, or beyond the bounds."""
        return self._within(points, labels_of(self.values(self._clipped(points))))

    def misfits(self, label: str, points: Floats) -> Misfits:
        """Evaluate points of shape (M, P + 1) that should have one pattern."""
        observation = self.observation
        cycles = steady_cycles(self.values(self._clipped(points)), hops=label == HOPS)
        shift = points[:, -1] * observation.period
        window = _WINDOW * observation.sample_time
        model = cycles.signals(observation.signals, observation.time, shift, window)
        parts = []
        for name, measured in observation.signals.items():
            part = (measured - model[name]) * self._weights[name]
            parts.append(part - (part @ self._sensors[name]) @ self._sensors[name].T)
        return Misfits(self._within(points, cycles.labels) == label, np.concatenate(parts, axis=1))

    def weight(self, name: str) -> float:
        """Weight of a squared residual of a signal, summed over its samples."""
        return float(self._weights[name] @ self._weights[name])

    def weigh(self, point: Floats) -> None:
        """Weight every signal by its misfit at a point, and by its number of independent samples.

        A sample that is taken early or late is off by the signal's slope times the delay: its variance grows
        with the square of the slope.
        """
        observation = self.observation
        cycles = steady_cycles(self.values(point[None]))
        shift = point[-1:] * observation.period
        step = observation.sample_time
        around = [
            cycles.signals(observation.signals, observation.time, shift + lag, _WINDOW * step)
            for lag in (0.0, 0.5 * step, -0.5 * step)
        ]
        self.count = 0.0
        for name, measured in observation.signals.items():
            now, after, before = (model[name][0] for model in around)
            used, delays = np.ones(measured.size), np.zeros(measured.size)
            if name in _JUMPING:
                used[_beside_a_jump(cycles, observation, float(shift[0]))] = 0.0
            else:
                delays = ((after - before) / step) ** 2
            basis = used[:, None] * self._basis(name)
            residual = used * (measured - now)
            residual -= basis @ np.linalg.lstsq(basis, residual, rcond=None)[0]
            shape = used / np.sqrt(_variances(observation, residual, delays))
            count = independent_samples(observation.time, shape * residual, observation.frequency)
            self._weigh(name, shape, residual, count)
            self.count += count

    def _weigh(self, name: str, shape: Floats, residual: Floats, count: float) -> None:
        signal = self.observation.signals[name]
        scaled = shape * residual
        size = int(np.count_nonzero(shape))
        variance = float(scaled @ scaled) / max(size - _POWERS[name] - len(self.names) - 1, 1)
        variance += _LEAST_VARIANCE * float(np.var(shape * signal))
        variance += float(shape @ shape) / signal.size * (_ROUNDING * self._drives(name)) ** 2
        self._weights[name] = shape * math.sqrt(count / signal.size / variance)
        self._sensors[name] = np.linalg.qr(self._basis(name) * self._weights[name][:, None])[0]

    def _drives(self, name: str) -> float:
        """Amplitude of what the drive does: the size that a signal of this kind has."""
        rate = 2.0 * math.pi * self.fixed["frequency"]
        power = {"displacement": 0, "velocity": 1}.get(name, 2)
        return self._size * rate**power

    def _basis(self, name: str) -> Floats:
        """Powers of the time that a sensor may add, shape (N, powers)."""
        time = self.observation.time - self.observation.time.mean()
        return np.vander(time / time[-1], _POWERS[name], increasing=True)

    def _clipped(self, points: Floats) -> Floats:
        return np.clip(points[:, : len(self.names)], *self.bounds)

    def _within(self, points: Floats, labels: Labels) -> Labels:
        outside = (points[:, : len(self.names)] != self._clipped(points)).any(axis=1)
        return np.where(outside, "", labels)


def _variances(observation: Observation, residual: Floats, delays: Floats) -> Floats:
    """Variance of each sample, up to a factor: a constant, plus one times ``delays``, the squared slopes."""
    folded = fold(observation.time, residual, observation.frequency, 1)
    rest = residual - folded.periodic(observation.time) - folded.coefficients[0]
    flat = np.ones(residual.size)
    power = float(rest @ rest)
    if not delays.any() or power <= _RANDOM * float(residual @ residual):
        return flat
    basis = np.stack([flat, delays / delays.mean()], axis=1)
    squares = rest**2 * (residual.size / power)
    variances = flat
    for _ in range(_ROUNDS):
        parts, _ = nnls(basis / variances[:, None], squares / variances)
        variances = np.maximum(basis @ parts, 1e-3)
    gain = -float(np.log(variances).sum() + (squares / variances).sum() - squares.sum())
    return variances if gain > 6.0 else flat


def _beside_a_jump(cycles: Cycles, observation: Observation, shift: float) -> NDArray[np.bool_]:
    """Return which samples lie next to a jump of one scene, where it is unknown what a sensor shows."""
    beside = np.zeros(observation.time.size, np.bool_)
    slides = (column[:, 0] for column in (cycles.zeros, cycles.starts, cycles.lengths))
    for zero, start, length in zip(*slides, strict=True):
        if length > 0.0:
            for phase in (zero + start, zero + start + length):
                turns = (observation.time + shift) * observation.frequency - phase / (2.0 * math.pi)
                off = np.abs(turns - np.round(turns)) * observation.period
                beside |= off <= observation.sample_time
    return beside
