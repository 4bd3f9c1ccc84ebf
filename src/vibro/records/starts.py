"""Where the search for a fit begins: the best points of each pattern on a grid."""

from __future__ import annotations

import math
from itertools import product
from typing import TYPE_CHECKING, Final

import numpy as np

from vibro.quantities import AMPLITUDES
from vibro.records.cycles import HOPS, steady_cycles

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from vibro.records.misfits import Problem

    Floats = NDArray[np.float64]

__all__ = ["starts"]

# Values at which the search starts, in addition to the scene's own; kinetic friction relative to static, an
# amplitude relative to the scene's, a phase added to the scene's.
_GRID: Final[Mapping[str, tuple[float, ...]]] = {
    "static_friction": tuple(np.geomspace(0.05, 1.5, 24).tolist()),
    "kinetic_friction": (0.1, 0.25, 0.4, 0.5, 0.6, 0.7, 0.8, 0.85, 0.9, 0.95, 0.99),
    **dict.fromkeys(AMPLITUDES, (0.5, 0.7, 0.85, 1.0, 1.2, 1.4, 2.0)),
    "drive_angle": tuple(math.radians(a) for a in (6.0, 10.0, 15.0, 20.0, 27.0, 35.0, 45.0)),
    "normal_phase": tuple(math.radians(a) for a in range(-150, 181, 30)),
}
_MOST_TRIED: Final = 20_000  # scenes of the grid; of more a random part
_MOST_HOPPING: Final = 40  # scenes with flights, each of which takes as long as a hundred others
_PHASES: Final = 128  # shifts that are compared
_TRIED: Final = 3  # starts in each pattern
_AT_ONCE: Final = 512  # scenes


def starts(problem: Problem, *, hops: bool) -> list[tuple[str, Floats]]:
    """Return the best few points of each pattern on a grid, with their labels, the most promising first.

    Parameters
    ----------
    problem : Problem
        The misfit.
    hops : bool
        Whether to return scenes that hop, instead of those in contact.
    """
    values = _candidates(problem)
    points = np.array([values[name] for name in problem.names]).T
    labels = problem.labels(points)
    kept = np.flatnonzero((labels != "") & ((labels == HOPS) == hops))
    if hops:
        kept = kept[:: max(kept.size // _MOST_HOPPING, 1)]
    points, labels = points[kept], labels[kept]
    squares, shifts = np.empty(kept.size), np.empty(kept.size)
    for first in range(0, kept.size, _AT_ONCE):
        part = slice(first, first + _AT_ONCE)
        squares[part], shifts[part] = _rough_squares(problem, points[part])
    groups: dict[tuple[str, tuple[bool, ...]], list[int]] = {}
    for cell in np.argsort(squares).tolist():
        if np.isfinite(squares[cell]):
            groups.setdefault((str(labels[cell]), problem.sides(points[cell])), []).append(cell)
    found = []
    for (label, _), cells in groups.items():
        for cell in cells[:_TRIED]:
            found.append((float(squares[cell]), label, np.append(points[cell], shifts[cell])))
    return [(label, point) for _, label, point in sorted(found, key=lambda start: start[0])]


def _candidates(problem: Problem) -> dict[str, Floats]:
    own = problem.fixed | dict(zip(problem.names, problem.own.tolist(), strict=True))
    grids = []
    for name in problem.fittable:
        grid = _GRID[name] if name in problem.names else (own[name],)
        if name in AMPLITUDES and name in problem.names:
            grid = tuple(own[name] * factor for factor in grid)
        elif name == "normal_phase" and name in problem.names:
            grid = tuple(own[name] + turn for turn in grid)
        elif name == "kinetic_friction" and name in problem.names:
            grid = tuple(-share for share in grid)  # of static friction
        grids.append(grid)
    points = np.array([[own[name] for name in problem.fittable], *product(*grids)])
    if points.shape[0] > _MOST_TRIED:
        kept = np.random.default_rng(1).choice(points.shape[0] - 1, _MOST_TRIED, replace=False)
        points = points[np.append(0, 1 + np.sort(kept))]
    share = points[:, 1] < 0.0
    points[share, 1] *= -points[share, 0]
    return dict(zip(problem.fittable, points.T, strict=True))


def _rough_squares(problem: Problem, points: Floats) -> tuple[Floats, Floats]:
    """Least sum of squares of each point over all shifts, and that shift in drive cycles.

    One correlation of what each signal repeats in every cycle gives all shifts. Offsets and trends do not
    count.
    """
    observation = problem.observation
    cycles = steady_cycles(problem.values(points))
    grid = np.arange(_PHASES + 1) * observation.period / _PHASES
    models = cycles.signals(observation.signals, grid, np.zeros(points.shape[0]), observation.sample_time)
    squares = np.zeros((points.shape[0], _PHASES))
    for name, model in models.items():
        measured = observation.folded[name].periodic(grid[:-1])
        model = model - np.outer(model[:, -1] - model[:, 0], grid / observation.period)
        model = model[:, :-1] - model[:, :-1].mean(axis=1, keepdims=True)
        both = np.fft.irfft(np.conj(np.fft.rfft(measured)) * np.fft.rfft(model), _PHASES)
        energy = float(measured @ measured) + np.einsum("ij,ij->i", model, model)
        squares += problem.weight(name) / _PHASES * (energy[:, None] - 2.0 * both)
    # a body at rest, or one that does not hop, may find no steady cycle after all
    squares[cycles.labels == ""] = np.inf
    best = np.argmin(squares, axis=1)
    return squares[np.arange(best.size), best], best / _PHASES
