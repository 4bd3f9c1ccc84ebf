"""Estimates of a scene's friction, amplitude and drive angle from a record, and what cannot be estimated."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, Final

import numpy as np
from scipy.optimize import least_squares

from vibro.errors import InputError, SceneError, VibroError
from vibro.motion.settled import settled_motion
from vibro.quantities import QUANTITIES
from vibro.records.folding import independent_samples
from vibro.scene import Scene

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from vibro.motion.settled import SettledMotion
    from vibro.records.alignment import Observation

    Floats = NDArray[np.float64]

__all__ = ["FITTABLE", "Fit", "Parameter", "fit"]

FITTABLE: Final = ("static_friction", "kinetic_friction", "amplitude", "drive_angle")

# Allowed ranges in SI units; that of the amplitude is relative to the scene's.
_BOUNDS: Final[Mapping[str, tuple[float, float]]] = {
    "static_friction": (1e-3, 3.0),
    "kinetic_friction": (1e-3, 3.0),
    "amplitude": (0.2, 5.0),
    "drive_angle": (math.radians(0.5), math.radians(80.0)),
}
# Values at which the search starts, in addition to the scene's own; kinetic friction relative to static.
_STARTS: Final[Mapping[str, tuple[float, ...]]] = {
    "static_friction": (0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 1.0),
    "kinetic_friction": (0.25, 0.5, 0.65, 0.75, 0.85, 0.95),
    "amplitude": (0.7, 1.0, 1.4),
    "drive_angle": tuple(math.radians(a) for a in (10.0, 20.0, 35.0)),
}
_TRIED: Final = 3  # number of starts that are refined, the best ones
_ROUNDS: Final = 4  # of weighting the signals by their misfit
_STEP: Final = 1e-6  # relative step of the derivatives: the model's noise is 1e-15, its curvature of order 1
_CONFIDENCE: Final = 1.96  # sigma, for 95 %
# A combination whose relative standard error exceeds this counts as unknown.
_UNKNOWN: Final = 0.3
_SHARE: Final = 0.05  # of an unknown combination: a parameter with a smaller share is not part of it
# Signals that jump where a slide starts or ends.
_JUMPING: Final = ("acceleration", "friction")
_WINDOW: Final = 0.25  # sample times over which the model's jumps are averaged, so that derivatives exist
_LEAST_VARIANCE: Final = 1e-18  # of a misfit, relative to that of the signal, because data may be exact
_AT_LIMIT: Final = 1e-4  # relative distance
_HALVINGS: Final = 20


@dataclass(frozen=True)
class Parameter:
    """One estimate.

    Attributes
    ----------
    name : str
        A field of ``Scene``.
    value : float
        The estimate [SI].
    low, high : float
        Its interval of 95 % confidence [SI], for noise and misfit, not for what the model leaves out; NaN
        where the data cannot identify it.
    """

    name: str
    value: float
    low: float
    high: float

    @property
    def identified(self) -> bool:
        """Whether the data determine it."""
        return not math.isnan(self.low)


@dataclass(frozen=True, eq=False)
class Fit:
    """Estimates, and how far they can be trusted.

    Attributes
    ----------
    scene : Scene
        The scene with the estimates.
    parameters : tuple of Parameter
        In the order asked for.
    statements : tuple of str
        In words: what each estimate comes from, which parameters the data cannot identify, and why.
    """

    scene: Scene
    parameters: tuple[Parameter, ...]
    statements: tuple[str, ...]


class _Problem:
    """Weighted residuals as a function of the free parameters, scaled to order 1, and the shift."""

    def __init__(self, scene: Scene, observation: Observation, names: Sequence[str]) -> None:
        self.observation = observation
        self.names = tuple(names)
        self.fixed = {
            name: float(getattr(scene, name))
            for name in (*FITTABLE, "frequency", "trough_angle", "gravity", "restitution")
        }
        self.weights = {
            name: np.full(values.size, 1.0 / max(float(np.std(values)), np.finfo(float).tiny))
            for name, values in observation.signals.items()
        }
        bounds = {name: list(_BOUNDS[name]) for name in self.names}
        if "amplitude" in bounds:
            bounds["amplitude"] = [self.fixed["amplitude"] * b for b in bounds["amplitude"]]
        if "drive_angle" in bounds:
            upright = 0.5 * math.pi - self.fixed["trough_angle"]
            bounds["drive_angle"][1] = min(bounds["drive_angle"][1], upright - _BOUNDS["drive_angle"][0])
        # Kinetic friction never exceeds static friction, which bounds of each alone cannot express. Where
        # both are free, the excess of static over kinetic friction is the variable.
        self.excess = {"static_friction", "kinetic_friction"} <= bounds.keys()
        self.equality = ("kinetic_friction", "highest")
        if "static_friction" in bounds:
            self.equality = ("static_friction", "lowest")
            bounds["static_friction"][0] = 0.0 if self.excess else self.fixed["kinetic_friction"]
        elif "kinetic_friction" in bounds:
            bounds["kinetic_friction"][1] = self.fixed["static_friction"]
        self.bounds = np.array([bounds[name] for name in self.names]).T

    def encode(self, values: Mapping[str, float]) -> Floats:
        coded = dict(values)
        if self.excess:
            coded["static_friction"] -= coded["kinetic_friction"]
        return np.array([coded[name] for name in self.names])

    def decode(self, coded: Floats) -> dict[str, float]:
        values = self.fixed | dict(zip(self.names, coded.tolist(), strict=True))
        if self.excess:
            values["static_friction"] += values["kinetic_friction"]
        return values

    def motion(self, values: Mapping[str, float]) -> SettledMotion | None:
        try:
            return settled_motion(Scene(**values))
        except (SceneError, VibroError):
            return None

    def residuals(self, coded: Floats) -> dict[str, Floats]:
        motion = self.motion(self.decode(coded[:-1]))
        if motion is None:  # no steady motion there: worse than a body at rest
            return {name: 2.0 * values for name, values in self.observation.signals.items()}
        shift = float(coded[-1]) * self.observation.period
        return self.observation.residuals(motion, shift, window=_WINDOW)

    def weighted(self, coded: Floats) -> Floats:
        return np.concatenate([r * self.weights[name] for name, r in self.residuals(coded).items()])


def fit(scene: Scene, observation: Observation, names: Sequence[str]) -> Fit:
    """Estimate quantities of a scene from a record.

    Parameters
    ----------
    scene : Scene
        Of shape (); it gives the quantities that are not estimated, and one start of the search.
    observation : Observation
        The record.
    names : sequence of str
        Some of ``FITTABLE``.

    Returns
    -------
    Fit
        By least squares over all signals, each weighted by the inverse of its own misfit; the unknown trigger
        time is fitted too. Of long records the middle is used.

    Raises
    ------
    InputError
        If a name is none of ``FITTABLE``, or is given twice.

    Notes
    -----
    Identifiability comes from the singular values of the relative sensitivities, from which the effect of the
    trigger time has been removed. A combination of parameters with a standard error above 30 % is named.
    """
    for name in names:
        if name not in FITTABLE or list(names).count(name) > 1:
            raise InputError(
                f"--fit {','.join(names)}: {name!r} cannot be estimated, or is named twice",
                hint="choose from mu_s, mu_d, A and alpha",
            )
    problem = _Problem(scene, observation.middle, names)
    best = min((_refine(problem, start) for start in _starts(problem)), key=lambda found: found[0])[1]
    for _ in range(_ROUNDS - 1):
        _weigh(problem, best)
        best = _refine(problem, best)[1]
    _weigh(problem, best)
    return _judge(problem, best)


def _starts(problem: _Problem) -> list[Floats]:
    """Return the best of a grid of parameters, and the scene's own, each with its best shift."""
    grids: list[tuple[float, ...]] = []
    for name in FITTABLE:
        own = problem.fixed[name]
        if name not in problem.names:
            grids.append((own,))
        elif name == "amplitude":
            grids.append(tuple(own * factor for factor in _STARTS[name]))
        else:
            grids.append(_STARTS[name])
    candidates = [dict(zip(FITTABLE, point, strict=True)) for point in product(*grids)]
    if "kinetic_friction" in problem.names:
        for candidate in candidates:
            candidate["kinetic_friction"] *= candidate["static_friction"]
    found: list[tuple[float, Floats]] = []
    for candidate in [{name: problem.fixed[name] for name in FITTABLE}, *candidates]:
        values = problem.fixed | candidate
        motion = problem.motion(values)
        if motion is None or not motion.slides:
            continue
        shift, losses = problem.observation.rough_shift(motion)
        coded = np.clip(problem.encode(values), *problem.bounds)
        found.append((float(losses.min()), np.append(coded, shift / problem.observation.period)))
    if not found:
        return [np.append(np.clip(problem.encode(problem.fixed), *problem.bounds), 0.0)]
    scenes_own = found[0][1]
    found.sort(key=lambda pair: pair[0])
    return [scenes_own, *(start for _, start in found[:_TRIED] if start is not scenes_own)]


def _refine(problem: _Problem, start: Floats) -> tuple[float, Floats]:
    low = np.append(problem.bounds[0], -1.0)
    high = np.append(problem.bounds[1], 2.0)
    scale = np.append(np.maximum(np.abs(start[:-1]), 1e-3), 0.01)
    inside = np.clip(start, low + 1e-9 * (high - low), high - 1e-9 * (high - low))
    result = least_squares(
        problem.weighted,
        inside,
        "2-point",
        (low, high),
        x_scale=scale,
        diff_step=np.full(scale.size, _STEP),
        xtol=1e-8,
        ftol=1e-8,
    )
    return float(result.cost), np.asarray(result.x)


def _weigh(problem: _Problem, coded: Floats) -> None:
    """Weight every signal by its misfit and its number of independent samples."""
    observation = problem.observation
    motion = problem.motion(problem.decode(coded[:-1]))
    for name, residual in problem.residuals(coded).items():
        used = np.ones(residual.size)
        if motion is not None and name in _JUMPING:
            used[_beside_a_jump(motion, observation, float(coded[-1]) * observation.period)] = 0.0
        residual = used * residual
        variance = float(residual @ residual / max(used.sum(), 1.0))
        variance += _LEAST_VARIANCE * float(np.var(observation.signals[name])) + np.finfo(float).tiny
        count = independent_samples(observation.time, residual, observation.frequency)
        problem.weights[name] = used * math.sqrt(count / residual.size / variance)


def _beside_a_jump(motion: SettledMotion, observation: Observation, shift: float) -> NDArray[np.bool_]:
    """Return which samples lie next to a jump, where it is unknown what a sensor shows."""
    beside = np.zeros(observation.time.size, np.bool_)
    for phase in motion.phases if len(motion.phases) > 1 else ():
        since = (observation.time + shift - phase.start) / motion.period
        beside |= np.abs(since - np.round(since)) * motion.period <= observation.sample_time
    return beside


def _judge(problem: _Problem, best: Floats) -> Fit:
    """Confidence intervals, and what cannot be identified."""
    values = problem.decode(best[:-1])
    steps = np.append(np.maximum(np.abs(best[:-1]), 1e-3), 1.0) * _STEP
    jacobian = np.stack(
        [(problem.weighted(best + e) - problem.weighted(best - e)) / (2.0 * e.sum()) for e in np.diag(steps)],
        axis=1,
    )
    if problem.excess:  # from (excess, kinetic) to (static, kinetic)
        s, k = problem.names.index("static_friction"), problem.names.index("kinetic_friction")
        jacobian[:, k] -= jacobian[:, s]
    clock = jacobian[:, -1:]
    power = float((clock**2).sum())
    free = jacobian[:, :-1]
    if power > 0.0:
        free = free - clock @ (clock.T @ free) / power
    sizes = np.array([abs(values[name]) for name in problem.names])
    _, singular, directions = np.linalg.svd(free * sizes, full_matrices=False)
    unknown = singular * _UNKNOWN < 1.0
    groups = [
        tuple(name for name, share in zip(problem.names, direction, strict=True) if abs(share) > _SHARE)
        for direction in directions[unknown]
    ]
    # Even a combination that the data do not determine is known to a factor of about two.
    spreads = 1.0 / np.maximum(singular, 1.0)
    relative = np.sqrt(((directions * spreads[:, None]) ** 2).sum(axis=0))
    lost = {name for name, error in zip(problem.names, relative, strict=True) if error > _UNKNOWN}
    errors = sizes * relative
    parameters = []
    for name, error in zip(problem.names, errors.tolist(), strict=True):
        half = math.nan if name in lost else _CONFIDENCE * error
        parameters.append(Parameter(name, values[name], values[name] - half, values[name] + half))
    motion = problem.motion(values)
    statements = _statements(problem, best, motion.pattern if motion else "", groups, lost)
    return Fit(Scene(**values), tuple(parameters), tuple(statements))


def _statements(
    problem: _Problem, best: Floats, pattern: str, groups: Sequence[tuple[str, ...]], lost: set[str]
) -> list[str]:
    """Say what the estimates come from, what cannot be identified, and what ended at a bound."""
    values = problem.decode(best[:-1])
    names = problem.names
    if "F" not in pattern and "B" not in pattern:
        said = ", ".join(QUANTITIES[name].letter for name in names if name in lost)
        return [f"the fitted body rests: beyond that, the data cannot identify {said}"] if said else []
    statements = []
    rests = "_" in pattern
    told = [name for name in ("static_friction", "kinetic_friction") if name in names and name not in lost]
    if rests and told:
        effects = {"static_friction": "mu_s sets the start of a slide", "kinetic_friction": "mu_d its end"}
        if told == ["kinetic_friction"]:
            effects["kinetic_friction"] = "mu_d sets the end of a slide"
        statements.append(f"pattern {pattern}: " + " and ".join(effects[name] for name in told))
    for group in groups:
        *first, last = (QUANTITIES[name].letter for name in group)
        symbols = f"{', '.join(first)} and {last}" if first else last
        if group == ("static_friction",) and not rests:
            highest = _highest_static_friction(problem, values, pattern)
            statements.append(
                f"the data cannot identify mu_s: in pattern {pattern} the body never rests, and mu_s has no"
                f" effect at all, from mu_d up to {highest:.4g}"
            )
        elif len(group) == 1:
            statements.append(f"the data cannot identify {symbols}: its effect is smaller than the misfit")
        else:
            statements.append(f"the data cannot tell {symbols} apart: their effects cancel; give one of them")
    for name, value, low, high in zip(names, best[:-1], *problem.bounds, strict=True):
        for distance, limit in ((value - low, "lowest"), (high - value, "highest")):
            if name not in lost and distance < _AT_LIMIT * (high - low):
                equal = (name, limit) == problem.equality
                which = "mu_d = mu_s" if equal else f"the {limit} value that is tried"
                statements.append(f"{QUANTITIES[name].letter} is at its limit, {which}")
    return statements


def _highest_static_friction(problem: _Problem, values: Mapping[str, float], pattern: str) -> float:
    """Largest static friction that gives the fitted pattern, by bisection."""
    low, high = values["static_friction"], 2.0 * _BOUNDS["static_friction"][1]
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        motion = problem.motion({**values, "static_friction": middle})
        low, high = (middle, high) if motion and motion.pattern == pattern else (low, middle)
    return low
