"""The residuals of a record against the computed motion, as a function of a scene's free quantities."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from itertools import product
from operator import itemgetter
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

from vibro.quantities import AMPLITUDES, ELLIPTICAL, LINEAR
from vibro.records.alignment import Observation, misfits_at_shifts
from vibro.records.cycles import HOPS, Labels, SceneCycles, labels_of, scene_cycles
from vibro.records.folding import Floats, detrended, fold, independent_samples
from vibro.records.tolerances import TOL
from vibro.scene import Scene

__all__ = ["FITTABLE", "Problem", "Residuals", "fittable", "starts"]

#: Quantities that can be estimated, of a drive along a line or along an ellipse.
FITTABLE: Final = ("static_friction", "kinetic_friction", *LINEAR, *ELLIPTICAL)

# Least and greatest value that is tried [SI]; of amplitudes relative to the scene's, of the phase beside its.
_BOUNDS: Final[Mapping[str, tuple[float, float]]] = {
    "static_friction": (1e-3, 3.0),
    "kinetic_friction": (1e-3, 3.0),
    **dict.fromkeys(AMPLITUDES, (0.2, 5.0)),
    "drive_angle": (math.radians(0.5), math.radians(80.0)),
    # A phase has no least value: one turn more to each side than it needs, so that a search and an interval
    # may pass the phase opposite to the scene's.
    "normal_phase": (-1.5 * math.tau, 1.5 * math.tau),
}
# Values at which the search starts besides the scene's own, in the same way; kinetic friction relative to
# static friction, as a negative number.
_GRID: Final[Mapping[str, Sequence[float]]] = {
    "static_friction": np.geomspace(0.05, 1.5, 24).tolist(),
    "kinetic_friction": (-0.1, -0.25, -0.4, -0.5, -0.6, -0.7, -0.8, -0.85, -0.9, -0.95, -0.99),
    **dict.fromkeys(AMPLITUDES, (0.5, 0.7, 0.85, 1.0, 1.2, 1.4, 2.0)),
    "drive_angle": np.radians((6.0, 10.0, 15.0, 20.0, 27.0, 35.0, 45.0)).tolist(),
    "normal_phase": np.radians(range(-150, 181, 30)).tolist(),
}
# What a sensor adds by itself, as the number of powers of the time: an offset, and for all but a displacement
# a slow drift. The slope of a displacement is the conveying speed, which no sensor of displacement invents.
_POWERS: Final = {"displacement": 1, "velocity": 2, "acceleration": 2, "friction": 2}
# Powers of 2 pi f by which the trough's amplitude has the size of a signal.
_POWERS_OF_RATE: Final = {"displacement": 0, "velocity": 1, "acceleration": 2, "friction": 2}
_JUMPING: Final = ("acceleration", "friction")  # signals that jump where a slide starts or ends


def fittable(scene: Scene) -> tuple[str, ...]:
    """Quantities of a scene that can be estimated, those of its own drive among them."""
    return tuple(name for name in FITTABLE if name in scene.arrays()._fields)


def _tried(name: str, values: Iterable[float], own: float) -> list[float]:
    """Values of a quantity by those of ``_BOUNDS`` or ``_GRID``, and the scene's own."""
    if name == "normal_phase":
        return [own + value for value in values]
    return [own * value if name in AMPLITUDES else value for value in values]


class Residuals(NamedTuple):
    """Of M points: whether they have the pattern that was asked for, and weighted residuals, (M, K)."""

    inside: NDArray[np.bool_]
    values: Floats

    @property
    def squares(self) -> Floats:
        """Sum of squares of each point; inf outside the pattern."""
        return np.where(self.inside, np.square(self.values).sum(axis=1), np.inf)


class Problem:
    """Weighted residuals at points: the P free quantities [SI], then the shift in drive cycles.

    What a sensor adds by itself, its offset and its drift, is projected out of each signal's residuals. The
    unit of the sum of squares is the variance of a residual with as many independent samples as ``count``.
    """

    def __init__(self, scene: Scene, observation: Observation, names: Sequence[str]) -> None:
        self.observation = observation
        self.names = tuple(names)
        self.fittable = fittable(scene)
        self.fixed = {name: float(value) for name, value in scene.arrays()._asdict().items()}
        self.bounds = np.array([_tried(name, _BOUNDS[name], self.fixed[name]) for name in names]).T
        if "drive_angle" in names:
            upright = 0.5 * math.pi - self.fixed["trough_angle"] - _BOUNDS["drive_angle"][0]
            self.bounds[1, self.names.index("drive_angle")] = min(_BOUNDS["drive_angle"][1], upright)
        self.is_curved = bool(set(names) & set(ELLIPTICAL))  # whether valleys of the misfit bend
        self._size = float(scene.scale)
        self._phases = np.array([name == "normal_phase" for name in names])
        self.count = 0.0
        self._weights: dict[str, Floats] = {}
        self._sensors: dict[str, Floats] = {}
        for name, values in observation.signals.items():
            folded = observation.folded[name]
            rest = detrended(observation.time, values - folded.periodic(observation.time), folded.trends)
            self._weigh(name, np.ones(values.size), rest, values.size)

    @property
    def own(self) -> Floats:
        """The scene's own values, within the bounds."""
        own = np.array([self.fixed[name] for name in self.names])
        return np.asarray(np.clip(own, *self.bounds))

    def scale(self, point: Floats) -> Floats:
        """Size of each coordinate of a point, (P + 1,): its own, unless that is far below what is tried.

        That of a phase is 1 rad, wherever its zero is.
        """
        sizes = np.maximum(np.abs(point[:-1]), TOL.least_scale * self.bounds[1])
        return np.append(np.where(self._phases, 1.0, sizes), 1.0)

    def sides(self, point: Floats) -> tuple[bool, ...]:
        """Return on which side of a motion along a line each phase of a point lies.

        The load of a slide is the same for a phase and its opposite, so that a record of one slide a cycle
        may fit with both: their misfits have two minima in one pattern.
        """
        return tuple((np.sin(point[: self._phases.size][self._phases]) > 0.0).tolist())

    def unwound(self, point: Floats, near: Floats) -> Floats:
        """Move phases of a point, (P + 1,), by whole turns to where they are closest to others, (P,)."""
        moved = point.copy()
        moved[:-1] -= np.where(self._phases, math.tau * np.round((point[:-1] - near) / math.tau), 0.0)
        return moved

    def labels(self, points: Floats) -> Labels:
        """Pattern at each point; empty where there is no steady cycle, or beyond the bounds."""
        return self._within(points, labels_of(self._fields(points)))

    def residuals(self, label: str, points: Floats) -> Residuals:
        """Evaluate points of shape (M, P + 1) that should have one pattern."""
        cycles = scene_cycles(self._fields(points), hops=label == HOPS)
        model = self._model(cycles, points)
        parts = []
        for name, measured in self.observation.signals.items():
            part = (measured - model[name]) * self._weights[name]
            parts.append(part - (part @ self._sensors[name]) @ self._sensors[name].T)
        return Residuals(self._within(points, cycles.labels) == label, np.concatenate(parts, axis=1))

    def rough_squares(self, points: Floats) -> tuple[Floats, Floats]:
        """Least sum of squares of points, (M, P), over all shifts, and that shift in drive cycles.

        What each signal repeats in every cycle is compared. Offsets and trends do not count.
        """
        observation = self.observation
        cycles = scene_cycles(self._fields(points))
        grid = np.linspace(0.0, 1.0, TOL.rough_shifts + 1)
        unshifted = np.zeros(points.shape[0])
        time = grid * observation.period
        models = cycles.signals(observation.signals, time, unshifted, observation.sample_time)
        squares = np.zeros((points.shape[0], TOL.rough_shifts))
        for name, model in models.items():
            model = (model - np.outer(model[:, -1] - model[:, 0], grid))[:, :-1]
            model -= model.mean(axis=1, keepdims=True)
            misfits, _ = misfits_at_shifts(observation.folded[name].periodic(time[:-1]), model)
            squares += float(self._weights[name] @ self._weights[name]) / TOL.rough_shifts * misfits
        # a body at rest, or one that does not hop, may find no steady cycle after all
        squares[cycles.labels == ""] = np.inf
        best = np.argmin(squares, axis=1)
        return squares[np.arange(best.size), best], grid[best]

    def weigh(self, point: Floats) -> None:
        """Weight every signal by its residuals at a point, and by its number of independent samples.

        A sample that is taken early or late is off by the signal's slope times the delay: its variance grows
        with the square of the slope.
        """
        observation = self.observation
        cycles = scene_cycles(self._fields(point[None]))
        now, after, before = (self._model(cycles, point[None], lag) for lag in (0.0, 0.5, -0.5))
        self.count = 0.0
        for name, measured in observation.signals.items():
            used, slopes = np.ones(measured.size), np.zeros(measured.size)
            if name in _JUMPING:
                used[_beside_a_jump(cycles, observation, float(point[-1]))] = 0.0
            else:
                slopes = (after[name][0] - before[name][0]) / observation.sample_time
            basis = used[:, None] * self._basis(name)
            residual = used * (measured - now[name][0])
            residual -= basis @ np.linalg.lstsq(basis, residual, rcond=None)[0]
            shape = used / np.sqrt(_variances(observation, residual, slopes**2))
            count = independent_samples(observation.time, shape * residual, observation.frequency)
            self._weigh(name, shape, residual, count)

    def _weigh(self, name: str, shape: Floats, residual: Floats, count: float) -> None:
        signal = self.observation.signals[name]
        scaled = shape * residual
        freedom = int(np.count_nonzero(shape)) - _POWERS[name] - len(self.names) - 1
        # Amplitude of what the drive does: the size that a signal of this kind has.
        size = self._size * (math.tau * self.fixed["frequency"]) ** _POWERS_OF_RATE[name]
        variance = float(scaled @ scaled) / max(freedom, 1)
        variance += TOL.least_misfit**2 * float(np.var(shape * signal))
        variance += float(shape @ shape) / signal.size * (TOL.rounding * size) ** 2
        self._weights[name] = shape * math.sqrt(count / signal.size / variance)
        self._sensors[name] = np.linalg.qr(self._basis(name) * self._weights[name][:, None])[0]
        self.count += count

    def _basis(self, name: str) -> Floats:
        """Powers of the time that a sensor may add, shape (N, powers)."""
        time = self.observation.time - self.observation.time.mean()
        return np.vander(time / time[-1], _POWERS[name], increasing=True)

    def _model(self, cycles: SceneCycles, points: Floats, lag: float = 0.0) -> dict[str, Floats]:
        """Signals of the model, later by some sample times, by the shifts of points."""
        observation, step = self.observation, self.observation.sample_time
        shift = points[:, -1] * observation.period + lag * step
        return cycles.signals(observation.signals, observation.time, shift, TOL.jump_window * step)

    def _fields(self, points: Floats) -> dict[str, Floats]:
        """Fields of the scenes at points of shape (M, P) or (M, P + 1), within the bounds."""
        values = {name: np.full(points.shape[0], value) for name, value in self.fixed.items()}
        clipped = np.clip(points[:, : len(self.names)], *self.bounds)
        return values | dict(zip(self.names, clipped.T.copy(), strict=True))

    def _within(self, points: Floats, labels: Labels) -> Labels:
        """Take the labels off points beyond the bounds."""
        values, (low, high) = points[:, : len(self.names)], self.bounds
        return np.where(((low <= values) & (values <= high)).all(axis=1), labels, "")


def _variances(observation: Observation, residual: Floats, delays: Floats) -> Floats:
    """Variance of each sample, up to a factor: a constant, plus one times ``delays``, the squared slopes."""
    rest = residual - fold(observation.time, residual, observation.frequency, 1).fitted(observation.time)
    flat = np.ones(residual.size)
    power = float(rest @ rest)
    if not delays.any() or power <= TOL.random_share * float(residual @ residual):
        return flat
    basis = np.stack([flat, delays / delays.mean()], axis=1)
    squares = rest**2 * (residual.size / power)
    variances = flat
    for _ in range(TOL.variance_rounds):
        parts, _ = nnls(basis / variances[:, None], squares / variances)
        variances = np.maximum(basis @ parts, TOL.least_jitter_variance)
    gain = -float(np.log(variances).sum() + (squares / variances).sum() - squares.sum())
    return variances if gain > TOL.jitter_gain else flat


def _beside_a_jump(cycles: SceneCycles, observation: Observation, shift: float) -> NDArray[np.bool_]:
    """Return which samples lie next to a jump of one scene, where it is unknown what a sensor shows."""
    way, _, begin, end, *_ = cycles.slides[:, :, 0]
    jumps = np.concatenate([begin[way != 0.0], end[way != 0.0]]) / math.tau
    turns = np.subtract.outer(observation.time * observation.frequency + shift, jumps)
    off = np.abs(turns - np.round(turns)) * observation.period
    return np.asarray((off <= observation.sample_time).any(axis=1))


def starts(problem: Problem, *, hops: bool) -> list[tuple[str, Floats]]:
    """Return the best few points of each pattern on a grid, with their labels, the most promising first.

    Parameters
    ----------
    problem : Problem
        The residuals.
    hops : bool
        Whether to return scenes that hop, instead of those in contact.
    """
    points = _candidates(problem)
    labels = problem.labels(points)
    kept = np.flatnonzero((labels != "") & ((labels == HOPS) == hops))
    if hops:
        kept = kept[:: max(kept.size // TOL.most_hopping, 1)]
    groups: dict[tuple[str, tuple[bool, ...]], list[tuple[float, str, Floats]]] = {}
    for first in range(0, kept.size, TOL.at_once):
        part = kept[first : first + TOL.at_once]
        for cell, square, shift in zip(part, *problem.rough_squares(points[part]), strict=True):
            if np.isfinite(square):
                start = float(square), str(labels[cell]), np.append(points[cell], shift)
                groups.setdefault((start[1], problem.sides(points[cell])), []).append(start)
    by_misfit = itemgetter(0)
    best = [start for group in groups.values() for start in sorted(group, key=by_misfit)[: TOL.starts]]
    return [(label, point) for _, label, point in sorted(best, key=by_misfit)]


def _candidates(problem: Problem) -> Floats:
    """Points of a grid, shape (M, P), the scene's own first."""
    own = problem.fixed | dict(zip(problem.names, problem.own.tolist(), strict=True))
    # All quantities in their order, so that static friction comes before kinetic friction.
    grids = {name: [own[name]] for name in problem.fittable}
    grids |= {name: _tried(name, _GRID[name], own[name]) for name in problem.names}
    points = np.array([[own[name] for name in grids], *product(*(grids[name] for name in grids))])
    if points.shape[0] > TOL.most_tried:
        kept = np.random.default_rng(1).choice(points.shape[0] - 1, TOL.most_tried, replace=False)
        points = points[np.append(0, 1 + np.sort(kept))]
    share = points[:, 1] < 0.0
    points[share, 1] *= -points[share, 0]
    return points[:, [problem.fittable.index(name) for name in problem.names]]
