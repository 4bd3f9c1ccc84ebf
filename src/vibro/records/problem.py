"""The residuals of a record against the computed motion, as a function of a scene's free quantities."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from functools import lru_cache
from itertools import product
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls
from scipy.signal import lfilter
from scipy.special import fdtrc

from vibro.core.codes import Regime, is_answered
from vibro.drives import Ability
from vibro.errors import VibroError
from vibro.motion.settled import SettledMotion, settled_motion
from vibro.quantities import AMPLITUDES, ELLIPTICAL, LINEAR
from vibro.records.alignment import (
    Observation,
    computed_signals,
    detrended,
    fold,
    independent_samples,
    low_passed,
    misfits_at_shifts,
    whitening_filter,
)
from vibro.records.reading import TOL
from vibro.results.steady import SteadyCycle
from vibro.scene import Fields, Scene
from vibro.steady import slides_of, solve

if TYPE_CHECKING:
    from vibro.reals import Floats
    from vibro.records.drive_errors import DriveError
    from vibro.records.sensors import SensorErrors

# ------------------------------------------------------------------------------
# Steady motions of many scenes, sampled at the times of one record, for searches.

_Labels = NDArray[np.object_]  # of str

_REMEMBERED: Final = 256  # motions, of some kilobytes each: more than the points of a few steps

#: Label of every scene that hops: their patterns are too many, and too close to each other.
HOPS: Final = "H"


@dataclass(frozen=True, eq=False)
class _SceneCycles:
    """Steady cycles of M scenes.

    Attributes
    ----------
    labels : object array of str, shape (M,)
        Pattern of each, or ``HOPS``; empty without a steady cycle.
    fields : Drive
        Fields of the scenes, each of shape (M,).
    slides : array, shape (7, 2, M)
        Both slides of each cycle of one harmonic, with the rows of ``Slides``; 0 without a slide.
    followed : mapping of int to SettledMotion
        Motions of scenes that hop, and of all beyond one harmonic, by their place among all.
    """

    labels: _Labels
    fields: Fields
    slides: Floats
    followed: Mapping[int, SettledMotion]

    def signals(
        self, observation: Observation, time: Floats, shift: Floats, window: float
    ) -> dict[str, Floats]:
        """Sample signals as ``computed_signals`` does.

        Parameters
        ----------
        observation : Observation
            Which signals, in which frame, behind which filter.
        time : array, shape (N,)
            Times on the record's clock [s].
        shift : array, shape (M,)
            Trough time at the clock's zero, for each scene [s].
        window : float
            Width of the averages of accelerations and friction [s].

        Returns
        -------
        dict of str to array, shape (M, N)
            The signals; those of a body at rest for scenes without a steady cycle.
        """

        def sample(time: Floats, window: float) -> dict[str, Floats]:
            return self._signals(list(observation.signals), time, 0.0 * shift, window, observation.absolute)

        if math.isfinite(observation.lowpass):
            period = 1.0 / float(self.fields.frequency[0])
            return low_passed(sample, time + shift[:, None], period, observation.lowpass)
        return self._signals(list(observation.signals), time, shift, window, observation.absolute)

    def _signals(
        self, names: list[str], time: Floats, shift: Floats, window: float, absolute: bool
    ) -> dict[str, Floats]:
        if self.fields.can(Ability.ONE_HARMONIC):
            result = self._closed_forms(self.fields, names, time, shift, window)
            if absolute:
                for name, values in self._trough(time, shift).items():
                    if name in result:
                        result[name] = result[name] + values
        else:
            result = {name: np.zeros((shift.size, time.size)) for name in names}
        for scene, motion in self.followed.items():
            own = computed_signals(motion, names, time + shift[scene], window, absolute=absolute)
            for name, values in own.items():
                result[name][scene] = values
        return {name: result[name] for name in names}

    def landings(self, scene: int) -> Floats:
        """Return the phases at which flights of one scene end [drive cycles]."""
        motion = self.followed.get(scene)
        ends = [phase.end / motion.period for phase in motion.phases if phase.kind == "H"] if motion else []
        return np.array(ends)

    def edges(self, scene: int) -> Floats:
        """Return the phases at which slides of one scene begin or end [drive cycles]."""
        motion = self.followed.get(scene)
        if motion:
            return np.array([time / motion.period for _, *ends in motion.slides for time in ends])
        acting = self.slides[:, self.slides[0, :, scene] != 0.0, scene]
        return np.asarray(acting[2:4].ravel() / math.tau)

    def _closed_forms(
        self, fields: Fields, names: list[str], time: Floats, shift: Floats, window: float
    ) -> dict[str, Floats]:
        rate = math.tau * fields.frequency[:, None]
        phase = rate * (time + shift[:, None])
        result = {}
        if "displacement" in names:
            result["displacement"] = self._displacements(phase)
        if "velocity" in names:
            result["velocity"] = self._velocities(phase)
        if {"acceleration", "friction"} & set(names):
            half = 0.5 * window * rate
            gained = self._velocities(phase + half) - self._velocities(phase - half)
            result["acceleration"] = gained / window
            weight = fields.gravity * np.sin(fields.trough_angle)
            inertial = fields.along[:, None] * rate**2 * np.sin(phase) - weight[:, None]
            result["friction"] = result["acceleration"] - inertial
        return result

    def _trough(self, time: Floats, shift: Floats) -> dict[str, Floats]:
        """Return the motions of the trough along itself, of one harmonic."""
        rate = math.tau * self.fields.frequency[:, None]
        phase, along = rate * (time + shift[:, None]), self.fields.along[:, None]
        return {
            "displacement": along * np.sin(phase),
            "velocity": along * rate * np.cos(phase),
            "acceleration": -along * rate**2 * np.sin(phase),
        }

    def _velocities(self, phase: Floats) -> Floats:
        total = np.zeros_like(phase)
        for way, zero, begin, end, load, resistance, _ in self._acting():
            since, start = (phase - begin) % math.tau, begin - zero
            gained = load * (np.cos(start) - np.cos(start + since) - resistance * since)
            total += np.where(since < end - begin, way * gained, 0.0)
        return total * (math.tau * self.fields.frequency * self.fields.scale)[:, None]

    def _displacements(self, phase: Floats) -> Floats:
        total = np.zeros_like(phase)
        for way, zero, begin, end, load, resistance, displacement in self._acting():
            turns, since = np.divmod(phase - begin, math.tau)
            since, start = np.minimum(since, end - begin), begin - zero
            turned = np.sin(start + since) - np.sin(start)
            moved = load * (since * np.cos(start) - turned - 0.5 * resistance * since**2)
            total += turns * displacement + way * moved
        return total * self.fields.scale[:, None]

    def _acting(self) -> list[Floats]:
        """Return the columns of the first and of the second slides, (7, M, 1), if any scene has one."""
        return [slide for slide in self.slides.swapaxes(0, 1)[..., None] if slide[0].any()]


def labels_of(values: Mapping[str, Any]) -> _Labels:
    """Return the labels of scenes as in ``_SceneCycles``, from their fields as for ``scene_cycles``."""
    return _labels(solve(Scene.computed(**values), flight=False))


def _labels(cycle: SteadyCycle) -> _Labels:
    labels = np.where(is_answered(cycle.status), cycle.pattern, "")
    return np.where(cycle.regime == Regime.HOPPING, HOPS, labels)


def scene_cycles(values: Mapping[str, Any], *, hops: bool = True) -> _SceneCycles:
    """Solve the steady cycles of scenes.

    Parameters
    ----------
    values : mapping of str to array
        All fields of the scenes, each of shape (M,) [SI]; harmonics are pairs of numbers, the same in all.
    hops : bool
        Whether to solve scenes that hop; else they have their label, and the signals of a body at rest.
    """
    scene = Scene.computed(**values)
    cycle = solve(scene, flight=False)
    labels = _labels(cycle)
    one_harmonic = scene.arrays().can(Ability.ONE_HARMONIC)
    wanted = (labels == HOPS) if one_harmonic else (labels != "")
    followed = {}
    for place in np.flatnonzero(wanted & ((labels != HOPS) | hops)).tolist():
        motion = _followed(tuple((name, _at(value, place)) for name, value in values.items()))
        if motion is None:
            labels[place] = ""
        else:
            followed[place] = motion
    if one_harmonic:
        slides = np.nan_to_num(slides_of(scene, np.broadcast_to(cycle.pattern_code, labels.shape)))
    else:
        slides = np.zeros((7, 0, labels.size))
    return _SceneCycles(labels, scene.flat(), slides, followed)


@lru_cache(maxsize=_REMEMBERED)
def _followed(fields: tuple[tuple[str, Any], ...]) -> SettledMotion | None:
    """Return the motion of one scene; None where it repeats only every few cycles, or never, or is not known.

    A search moves the shift alone, or comes back to a point, about as often as it goes to a new scene.
    """
    try:
        return settled_motion(Scene(**dict(fields)))
    except VibroError:
        return None


def _at(values: Any, place: int) -> Any:
    """Return the field of one scene among several; harmonics are the same in all."""
    if isinstance(values, np.ndarray):
        return float(values[place])
    return tuple(values) if isinstance(values, list) else values


#: Quantities that can be estimated, of a drive along a line or along an ellipse.
FITTABLE: Final = ("static_friction", "kinetic_friction", *LINEAR, *ELLIPTICAL)

# Least and greatest value that is tried [SI]: amplitudes times the scene's, the phase plus the scene's.
_BOUNDS: Final[Mapping[str, tuple[float, float]]] = {
    "static_friction": (1e-3, 3.0),
    "kinetic_friction": (1e-3, 3.0),
    **dict.fromkeys(AMPLITUDES, (0.2, 5.0)),
    "drive_angle": (math.radians(0.5), math.radians(80.0)),
    # A search and an interval may pass the phase opposite to the scene's: one turn more to each side.
    "normal_phase": (-1.5 * math.tau, 1.5 * math.tau),
}
# Values at which the search starts besides the scene's own, in the same units; kinetic friction as minus its
# share of static friction.
_GRID: Final[Mapping[str, Sequence[float]]] = {
    "static_friction": np.geomspace(0.05, 1.5, 24).tolist(),
    "kinetic_friction": (-0.1, -0.25, -0.4, -0.5, -0.6, -0.7, -0.8, -0.85, -0.9, -0.95, -0.99),
    **dict.fromkeys(AMPLITUDES, (0.5, 0.7, 0.85, 1.0, 1.2, 1.4, 2.0)),
    "drive_angle": np.radians((6.0, 10.0, 15.0, 20.0, 27.0, 35.0, 45.0)).tolist(),
    "normal_phase": np.radians(range(-150, 181, 30)).tolist(),
}
# Number of powers of the time that a sensor may add: an offset, and for all but a displacement a slow drift.
# The slope of a displacement is the conveying speed, which no sensor of displacement adds.
_POWERS: Final = {"displacement": 1, "velocity": 2, "acceleration": 2, "friction": 2}
# Powers of 2 pi f that turn the trough's amplitude into the size of a signal.
_POWERS_OF_RATE: Final = {"displacement": 0, "velocity": 1, "acceleration": 2, "friction": 2}
_AS_IT_IS: Final[Mapping[str, Any]] = {}  # fields of a drive without errors
_JUMPING: Final = ("acceleration", "friction")  # signals that jump where a slide starts or ends


def fittable(scene: Scene) -> tuple[str, ...]:
    """Return the quantities of a scene that can be estimated: friction, and those of its kind of drive."""
    return tuple(name for name in FITTABLE if name in scene.arrays()._fields)


def _tried(name: str, values: Iterable[float], own: float) -> list[float]:
    """Turn values of ``_BOUNDS`` or ``_GRID`` into values of a quantity, by the scene's own."""
    if name == "normal_phase":
        return [own + value for value in values]
    return [own * value if name in AMPLITUDES else value for value in values]


def _fields_of(scene: Scene) -> dict[str, Any]:
    """Return the fields of one scene as numbers; harmonics as pairs of such, other motions as they are."""
    pairs = {"along_harmonics": scene.along_harmonics, "normal_harmonics": scene.normal_harmonics}
    motion: dict[str, Any] = {
        name: [(float(size), float(phase)) for size, phase in value] for name, value in pairs.items() if value
    }
    if scene.motion is not None and not motion:
        motion = {"motion": scene.motion}
    fields = scene.arrays()._asdict().items()
    values = {name: float(value) for name, value in fields if isinstance(value, np.ndarray)}
    # without a clamped body its force is NaN
    return motion | {name: value for name, value in values.items() if not math.isnan(value)}


class Residuals(NamedTuple):
    """Weighted residuals of M points, (M, K), and whether each point lies in the pattern."""

    inside: NDArray[np.bool_]
    values: Floats

    @property
    def squares(self) -> Floats:
        """Sums of squares of the points; inf outside the pattern."""
        return np.where(self.inside, np.square(self.values).sum(axis=1), np.inf)


class Problem:
    """Weighted residuals of a record as a function of a point: P free quantities [SI], shift [drive cycles].

    The offset and the drift that a sensor adds are projected out of the residuals of each signal. Residuals
    count in their standard deviations, as if there were ``count`` independent samples.

    A drive is known to its errors alone, and so is what a sensor on the body makes of its motion: they move
    the motion by more than the noise leaves open. Amplitudes, angles and phases of the drive are free too,
    after the quantities that are ``asked``: the patterns change with them, and they cost their squares in
    standard errors, as residuals at the end. All other errors are small, or their effects are proportional to
    them: once weighed, sums of squares are the least over these errors, each of which costs its own square.
    The residuals are shrunk along what they do at the point that weighed them.
    """

    def __init__(
        self,
        scene: Scene,
        observation: Observation,
        names: Sequence[str],
        drive: Sequence[DriveError] = (),
        sensors: SensorErrors | None = None,
    ) -> None:
        self.observation, self.sensors = observation, sensors
        self.fittable = fittable(scene)
        self.fixed = _fields_of(scene)
        self.asked = len(names)
        moved = {name for error in drive for name in error.more}
        varied = [name for name in self.fittable if name in moved and name not in names]
        self.names = names = (*names, *varied)
        self.bounds = np.array([_tried(name, _BOUNDS[name], self.fixed[name]) for name in names]).T
        if "drive_angle" in names:
            upright = 0.5 * math.pi - self.fixed["trough_angle"] - _BOUNDS["drive_angle"][0]
            self.bounds[1, self.names.index("drive_angle")] = min(_BOUNDS["drive_angle"][1], upright)
        self.is_curved = bool({*names[: self.asked]} & {*ELLIPTICAL})  # whether valleys of the misfit bend
        self._size = float(scene.scale)
        self._phases = np.array([name == "normal_phase" for name in names])
        self.count = 0.0
        self._weights: dict[str, Floats] = {}
        self._filters: dict[str, Floats] = {}
        self._left_out: dict[str, NDArray[np.bool_]] = {}
        self._sensors: dict[str, Floats] = {}
        #: Errors of the quantities that are varied, and what each of them adds to these, (varied, errors).
        self.varying = [error for error in drive if not {*varied}.isdisjoint(error.more)]
        self.steps = (
            np.array([_steps(error, varied) for error in self.varying])
            .reshape(len(self.varying), len(varied))
            .T
        )
        self._prior = self._weights_of_varied()
        others = [e._replace(more=_without(e.more, names), less=_without(e.less, names)) for e in drive]
        self.linear = [error for error in others if error.more]
        #: What each linear error, and each of the sensors on the body, does to the weighted residuals.
        self.effects = np.empty((0, 0))
        #: Names of the errors that ``steps`` and ``effects`` are of.
        self.errors: list[str] = []
        # Directions of the weighted residuals in which these move them, and by which share.
        self._directions, self._shrunk = np.empty((0, 0)), np.empty(0)
        # What turns the residuals in these directions into the gains of the sensors on the body; the signals
        # at the point that weighed them.
        self._gains = np.empty((0, 0))
        self._weighed: dict[str, Floats] = {}
        for name, values in observation.signals.items():
            folded = observation.folded[name]
            rest = detrended(observation.time, values - folded.periodic(observation.time), folded.trends)
            self._weigh(name, np.ones(values.size), rest)

    def _weights_of_varied(self) -> Floats:
        """Return what turns deviations of the quantities that are varied into independent standard ones.

        The bounds of these quantities are moved to where none of them can be.
        """
        covariance = self.steps @ self.steps.T
        sizes = np.sqrt(covariance.diagonal())
        first, own = self.asked, np.array([self.fixed[name] for name in self.names[self.asked :]])
        for i, name in enumerate(self.names[first:], first):
            low, high = (own[i - first] + way * TOL.farthest_error * sizes[i - first] for way in (-1.0, 1.0))
            self.bounds[:, i] = (
                low if name == "normal_phase" else max(low, 0.0),
                min(high, self.bounds[1, i]) if name == "drive_angle" else high,
            )
        normed = covariance / np.outer(sizes, sizes) + TOL.step * np.eye(sizes.size)
        return np.asarray(np.linalg.inv(np.linalg.cholesky(normed)) / sizes)

    @property
    def own(self) -> Floats:
        """Values of the scene, clipped to the bounds."""
        own = np.array([self.fixed[name] for name in self.names])
        return np.asarray(np.clip(own, *self.bounds))

    def scale(self, point: Floats) -> Floats:
        """Return the size of each coordinate of a point, (P + 1,), not far below the values that are tried.

        The size of a phase is 1 rad, as its zero is arbitrary.
        """
        sizes = np.maximum(np.abs(point[:-1]), TOL.least_scale * self.bounds[1])
        return np.append(np.where(self._phases, 1.0, sizes), 1.0)

    def sides(self, point: Floats) -> tuple[bool, ...]:
        """Return whether each phase of a point is positive.

        A phase and its negative give a slide the same load, so that a record of one slide a cycle may fit
        with both: the misfit of one pattern has two minima.
        """
        return tuple((np.sin(point[: self._phases.size][self._phases]) > 0.0).tolist())

    def unwound(self, point: Floats, near: Floats) -> Floats:
        """Move phases of a point, (P + 1,), by whole turns next to those of another, (P,)."""
        moved = point.copy()
        moved[:-1] -= np.where(self._phases, math.tau * np.round((point[:-1] - near) / math.tau), 0.0)
        return moved

    def labels(self, points: Floats) -> _Labels:
        """Return the pattern at each point; empty without a steady cycle, or beyond the bounds."""
        return self._within(points, labels_of(self._fields(points)))

    def residuals(self, label: str, points: Floats) -> Residuals:
        """Evaluate the residuals of points, (M, P + 1), in one pattern."""
        cycles = scene_cycles(self._fields(points), hops=label == HOPS)
        model, signals = self._model(cycles, points), self.observation.signals
        values = self._weighted({name: measured - model[name] for name, measured in signals.items()})
        if self._shrunk.size:
            if self._gains.size:
                # A gain multiplies the motion of each point, not that of the one that weighed it.
                gains = (values @ self._directions @ self._gains).T[..., None]
                moved = [model[name] - there for name, there in self._weighed.items()]
                values -= self._weighted(dict(zip(signals, gains * moved, strict=True)))
            values -= (values @ self._directions * self._shrunk) @ self._directions.T
        own = [self.fixed[name] for name in self.names[self.asked :]]
        values = np.hstack([values, (points[:, self.asked : -1] - own) @ self._prior.T])
        return Residuals(self._within(points, cycles.labels) == label, values)

    def _weighted(self, residuals: Mapping[str, Floats]) -> Floats:
        """Weight residuals, (M, N) of each signal, without what the sensors add, (M, K)."""
        parts = []
        for name, residual in residuals.items():
            part = self._whitened(name, residual * self._weights[name])
            parts.append(part - (part @ self._sensors[name]) @ self._sensors[name].T)
        return np.concatenate(parts, axis=1)

    def rough_squares(self, points: Floats) -> tuple[Floats, Floats]:
        """Return the least sum of squares of points, (M, P), over all shifts, and that shift [drive cycles].

        The periodic parts of the signals are compared, without offsets and trends.
        """
        observation = self.observation
        cycles = scene_cycles(self._fields(points))
        grid = np.linspace(0.0, 1.0, TOL.rough_shifts + 1)
        unshifted = np.zeros(points.shape[0])
        time = grid * observation.period
        models = cycles.signals(observation, time, unshifted, observation.sample_time)
        squares = np.zeros((points.shape[0], TOL.rough_shifts))
        for name, model in models.items():
            model = (model - np.outer(model[:, -1] - model[:, 0], grid))[:, :-1]
            model -= model.mean(axis=1, keepdims=True)
            misfits, _ = misfits_at_shifts(observation.folded[name].periodic(time[:-1]), model)
            squares += float(self._weights[name] @ self._weights[name]) / TOL.rough_shifts * misfits
        # A scene that hops may turn out to have no steady cycle.
        squares[cycles.labels == ""] = np.inf
        best = np.argmin(squares, axis=1)
        return squares[np.arange(best.size), best], grid[best]

    def weigh(self, point: Floats) -> None:
        """Weight every signal by the variance of its residuals at a point and its independent samples.

        A sample that is taken early or late is off by the slope of the signal times the delay: its variance
        grows with the square of the slope.
        """
        observation = self.observation
        cycles = scene_cycles(self._fields(point[None]))
        now, after, before = (self._model(cycles, point[None], lag) for lag in (0.0, 0.5, -0.5))
        effects = self._effects(point, now)
        self.count = 0.0
        for name, measured in observation.signals.items():
            used, slopes = np.ones(measured.size), np.zeros(measured.size)
            used[_beside_a_jump(cycles, name, observation, float(point[-1]))] = 0.0
            if name not in _JUMPING:
                slopes = used * (after[name][0] - before[name][0]) / observation.sample_time
            basis = used[:, None] * np.hstack([self._basis(name), effects[name].T])
            residual = used * (measured - now[name][0])
            residual -= basis @ np.linalg.lstsq(basis, residual, rcond=None)[0]
            shape = used / np.sqrt(_variances(observation, residual, slopes**2))
            self._left_out[name] = used == 0.0
            self._filters[name] = whitening_filter(observation.time, shape * residual, observation.frequency)
            self._weigh(name, shape, residual)
        self.effects = self._weighted(effects).T
        # With effects E and errors e the least of |r - E e|^2 + |e|^2 over e is |(1 + E E')^(-1/2) r|^2.
        self._directions, sizes, errors = np.linalg.svd(self.effects, full_matrices=False)
        self._shrunk = 1.0 - 1.0 / np.sqrt(1.0 + sizes**2)
        if self.sensors is not None:
            kinds = self.errors[len(self.varying) :]
            own = [i for i, kind in enumerate(kinds) if kind == "gain" and i >= len(self.linear)]
            self._gains = self.sensors.gain * (sizes / (1.0 + sizes**2))[:, None] * errors[:, own]
            self._weighed = {name: values[0] for name, values in now.items()}

    def _effects(self, point: Floats, now: Mapping[str, Floats]) -> dict[str, Floats]:
        """Return what one standard error of each kind makes of every signal, (errors, N).

        An error that leads to another pattern on one side, next to an onset, counts by its other side.
        ``now`` are the signals at the point.
        """
        here = scene_cycles(self._fields(point[None]))
        found: dict[str, list[Floats]] = {name: [] for name in self.observation.signals}
        self.errors = [error.name for error in (*self.varying, *self.linear)]
        for error in self.linear:
            sides = [scene_cycles(self._fields(point[None], fields)) for fields in (error.more, error.less)]
            inside = [cycles.labels[0] == here.labels[0] for cycles in sides]
            kept = inside if any(inside) else [True, True]
            more, less = (
                self._model(cycles, point[None]) if keep else now
                for cycles, keep in zip(sides, kept, strict=True)
            )
            for name, rows in found.items():
                rows.append((more[name][0] - less[name][0]) / sum(kept))
        nothing = np.zeros(self.observation.time.size)
        for kind, signal, added in self._by_sensors(point, now):
            self.errors.append(kind)
            for name, rows in found.items():
                rows.append(added if name == signal else nothing)
        return {name: np.reshape(rows, (-1, nothing.size)) for name, rows in found.items()}

    def _by_sensors(self, point: Floats, now: Mapping[str, Floats]) -> Iterator[tuple[str, str, Floats]]:
        """Yield errors of the sensors on the body: their names, their signals, and what they add.

        A gain multiplies; a sensor that is turned, or sensitive across its axis, sees the normal motion too.
        """
        if self.sensors is None:
            return
        time = self.observation.time + point[-1] * self.observation.period
        across = _normal_motion(self._fields(point[None]), time)
        for name in self.observation.signals:
            yield "gain", name, self.sensors.gain * now[name][0]
            if name in across:
                yield "tilt", name, self.sensors.tilt * across[name]
            if name == "acceleration":
                yield "cross", name, self.sensors.cross * across[name]

    def unexplained(self, label: str, point: Floats) -> list[str]:
        """Return the signals whose residuals repeat in every cycle, by more than noise does by chance."""
        values, found = self.residuals(label, point[None]).values[0], []
        time, frequency = self.observation.time, self.observation.frequency
        for i, name in enumerate(self.observation.signals):
            folded = fold(time, values[i * time.size : (i + 1) * time.size], frequency, 1)
            waves, covariance = folded.coefficients[1:], folded.covariance[1:, 1:]
            statistic = float(waves @ np.linalg.pinv(covariance, hermitian=True) @ waves) / waves.size
            if fdtrc(waves.size, max(time.size - waves.size, 1), statistic) < TOL.misfit_by_chance:
                found.append(name)
        return found

    def pulled(self, point: Floats) -> Floats:
        """Return by how many standard errors a point moves the drive, in independent directions."""
        own = [self.fixed[name] for name in self.names[self.asked :]]
        return np.asarray(self._prior @ (point[self.asked : -1] - own))

    def without_errors(self) -> Problem:
        """Return the residuals of the signals alone, where the drive and the sensors are as they are."""
        plain = copy(self)
        plain._shrunk, plain._prior = np.empty(0), np.empty((0, self._prior.shape[1]))
        return plain

    def _weigh(self, name: str, shape: Floats, residual: Floats) -> None:
        observation, signal = self.observation, self.observation.signals[name]
        scaled, count = shape * residual, float(residual.size)
        if name in self._filters:
            scaled = self._whitened(name, scaled)
            count = independent_samples(observation.time, scaled, observation.frequency)
        freedom = int(np.count_nonzero(scaled)) - _POWERS[name] - len(self.names) - len(self.linear) - 1
        # Data may be exact: add the rounding of the signal, and of the trough's motion in the same unit.
        size = self._size * (math.tau * self.fixed["frequency"]) ** _POWERS_OF_RATE[name]
        variance = float(scaled @ scaled) / max(freedom, 1)
        variance += TOL.least_misfit**2 * float(np.var(shape * signal))
        variance += float(shape @ shape) / signal.size * (TOL.rounding * size) ** 2
        self._weights[name] = shape * math.sqrt(count / signal.size / variance)
        basis = self._whitened(name, (self._basis(name) * self._weights[name][:, None]).T).T
        self._sensors[name] = np.linalg.qr(basis)[0]
        self.count += count

    def _whitened(self, name: str, weighted: Floats) -> Floats:
        """Filter the last axis, so that noise that is correlated from sample to sample becomes white.

        The first samples, whose predecessors are not known, become 0; samples that do not count stay so.
        """
        own = self._filters.get(name)
        if own is None or own.size == 1 or not weighted.size:
            return weighted
        filtered = np.asarray(lfilter(own, [1.0], weighted, axis=-1))
        filtered[..., : own.size - 1] = 0.0
        filtered[..., self._left_out[name]] = 0.0
        return filtered

    def _basis(self, name: str) -> Floats:
        """Return the powers of the time that a sensor may add, shape (N, powers)."""
        time = self.observation.time - self.observation.time.mean()
        return np.vander(time / time[-1], _POWERS[name], increasing=True)

    def _model(self, cycles: _SceneCycles, points: Floats, lag: float = 0.0) -> dict[str, Floats]:
        """Compute the signals at points, delayed by a number of sample times."""
        observation, step = self.observation, self.observation.sample_time
        shift = points[:, -1] * observation.period + lag * step
        return cycles.signals(observation, observation.time, shift, TOL.jump_window * step)

    def _fields(self, points: Floats, drive: Mapping[str, Any] = _AS_IT_IS) -> dict[str, Any]:
        """Return the fields of the scenes at points, (M, P) or (M, P + 1), clipped to the bounds."""
        count = points.shape[0]
        values = {
            name: np.full(count, x) if isinstance(x, float) else x
            for name, x in (self.fixed | dict(drive)).items()
        }
        clipped = np.clip(points[:, : len(self.names)], *self.bounds)
        return values | dict(zip(self.names, clipped.T.copy(), strict=True))

    def _within(self, points: Floats, labels: _Labels) -> _Labels:
        """Empty the labels of points beyond the bounds."""
        values, (low, high) = points[:, : len(self.names)], self.bounds
        return np.where(((low <= values) & (values <= high)).all(axis=1), labels, "")


def _without(fields: Mapping[str, Any], names: Sequence[str]) -> dict[str, Any]:
    return {name: x for name, x in fields.items() if name not in names}


def _steps(error: DriveError, names: Sequence[str]) -> list[float]:
    """Return what a standard error adds to each quantity."""
    steps = [error.more.get(name, 0.0) - error.less.get(name, 0.0) for name in names]
    turns = [name == "normal_phase" for name in names]
    return [0.5 * (math.remainder(x, math.tau) if turn else x) for x, turn in zip(steps, turns, strict=True)]


def _normal_motion(fields: Mapping[str, Any], time: Floats) -> dict[str, Floats]:
    """Return the trough's motion normal to itself at trough times, of a scene of shape (1,)."""
    motion = settled_motion(Scene(**{name: _at(value, 0) for name, value in fields.items()}))
    count = 2 * TOL.rough_shifts
    waves = np.fft.rfft(motion.sample(np.arange(count) * motion.period / count).trough_normal) / count
    waves[1:] *= 2.0
    rates = 2j * math.pi * np.arange(waves.size) / motion.period
    turned = np.exp(np.outer(time, rates))
    powers = {"displacement": 0, "velocity": 1, "acceleration": 2}
    return {name: (turned @ (waves * rates**power)).real for name, power in powers.items()}


def _variances(observation: Observation, residual: Floats, squared_slopes: Floats) -> Floats:
    """Regress the variance of each sample, up to a factor, on a constant and the squared slopes."""
    rest = residual - fold(observation.time, residual, observation.frequency, 1).fitted(observation.time)
    flat = np.ones(residual.size)
    power = float(rest @ rest)
    if not squared_slopes.any() or power <= TOL.random_share * float(residual @ residual):
        return flat
    basis = np.stack([flat, squared_slopes / squared_slopes.mean()], axis=1)
    squares = rest**2 * (residual.size / power)
    variances = flat
    for _ in range(TOL.variance_rounds):
        parts, _ = nnls(basis / variances[:, None], squares / variances)
        variances = np.maximum(basis @ parts, TOL.least_jitter_variance)
    gain = -float(np.log(variances).sum() + (squares / variances).sum() - squares.sum())
    return variances if gain > TOL.jitter_gain else flat


def _beside_a_jump(
    cycles: _SceneCycles, name: str, observation: Observation, shift: float
) -> NDArray[np.bool_]:
    """Return which samples lie next to a jump of a signal of one scene.

    There a sensor may show any value between, and the misfit jumps with the scene. A landing is a jump of
    the velocity.
    """
    jumps = cycles.landings(0) if name != "displacement" else np.empty(0)
    if name in _JUMPING:
        jumps = np.concatenate([jumps, cycles.edges(0)])
    turns = np.subtract.outer(observation.time * observation.frequency + shift, jumps)
    off = np.abs(turns - np.round(turns)) * observation.period
    return np.asarray((off <= observation.sample_time).any(axis=1))


def starts(problem: Problem, *, hops: bool) -> list[tuple[str, Floats]]:
    """Return the best points of each pattern on a grid, with their labels, by ascending misfit.

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
    found: list[tuple[float, float, int]] = []
    for first in range(0, kept.size, TOL.at_once):
        part = kept[first : first + TOL.at_once]
        found += zip(*problem.rough_squares(points[part]), part, strict=True)
    best, counts = [], Counter[tuple[str, tuple[bool, ...]]]()
    for square, shift, place in sorted(found):
        label = str(labels[place])
        group = label, problem.sides(points[place])
        counts[group] += 1
        if counts[group] <= TOL.starts and math.isfinite(square):
            best.append((label, np.append(points[place], shift)))
    return best


def _candidates(problem: Problem) -> Floats:
    """Return the points of the grid, shape (M, P), with the scene's own first."""
    own = problem.fixed | dict(zip(problem.names, problem.own.tolist(), strict=True))
    # Take all quantities in their order, so that static friction comes before kinetic friction.
    grids = {name: [own[name]] for name in problem.fittable}
    grids |= {name: _tried(name, _GRID[name], own[name]) for name in problem.names[: problem.asked]}
    points = np.array([[own[name] for name in grids], *product(*(grids[name] for name in grids))])
    if points.shape[0] > TOL.most_tried:
        kept = np.random.default_rng(1).choice(points.shape[0] - 1, TOL.most_tried, replace=False)
        points = points[np.append(0, 1 + np.sort(kept))]
    share = points[:, 1] < 0.0
    points[share, 1] *= -points[share, 0]
    return points[:, [problem.fittable.index(name) for name in problem.names]]
