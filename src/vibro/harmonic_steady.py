"""Steady cycles of drives with harmonics, in contact alone: blocks of scenes in NumPy arrays."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.core.harmonic.arrays import each
from vibro.core.harmonic.solver import SteadyState, harmonic_state
from vibro.drives import Harmonics
from vibro.parallel import BLOCK, grid_blocks, in_parallel, within
from vibro.results.steady import RESULTS, SteadyCycle

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.scene import Scene

    Floats = NDArray[np.float64]

__all__ = ["harmonic_cycle"]

# What the core calls its results, which are over A and A w, and how ``SteadyCycle`` calls them.
_NAMES: Final = {
    "pattern": "pattern_code",
    "model": "model_code",
    "displacement": "displacement_per_cycle",
    "peak": "peak_velocity",
}
_OF_STATE: Final = tuple(_NAMES.get(name, name) for name in SteadyState._fields)
_SAME_IN_CONTACT: Final = tuple(r.name for r in RESULTS if r.in_contact is not None)


def harmonic_cycle(scene: Scene, threads: int | None, *, classes_alone: bool) -> SteadyCycle:
    """Solve the steady contact cycles of scenes; a body that hops has no numbers."""
    shape = scene.shape
    grid = shape or (1,)
    ones = (1,) * len(grid)
    inputs: Harmonics = each(Harmonics.of(scene), lambda a: a.reshape(ones[a.ndim :] + a.shape))
    out: dict[str, NDArray[Any]] = {r.name: np.zeros(grid, r.dtype) for r in RESULTS}

    def solve(block: tuple[slice, ...]) -> None:
        part: Harmonics = each(inputs, lambda a: a[within(block, a.shape)])
        _solve_block({name: array[block] for name, array in out.items()}, part, classes_alone)

    in_parallel(solve, list(grid_blocks(grid, BLOCK)), threads)
    return SteadyCycle(**(out if shape else {name: array[0] for name, array in out.items()}))


def _solve_block(part: dict[str, NDArray[Any]], inputs: Harmonics, classes_alone: bool) -> None:
    """Solve one block in place, given as arrays of ``SteadyCycle``, and scale it to SI."""
    shape = part["status"].shape
    flat = {name: array.reshape(-1) for name, array in part.items()}  # views: blocks are contiguous
    state = SteadyState(*(flat[name] for name in _OF_STATE))
    loads = each(inputs.loads(), lambda group: np.broadcast_to(group, shape).reshape(-1))
    harmonic_state(loads, state, classes_alone=classes_alone)
    with np.errstate(over="ignore"):  # inf where the result is beyond the range of doubles
        scale = inputs.scale
        part["displacement_per_cycle"] *= scale
        np.multiply(part["displacement_per_cycle"], inputs.frequency, out=part["mean_velocity"])
        part["peak_velocity"] *= 2.0 * np.pi * inputs.frequency * scale
    flat["period_cycles"].fill(1.0)
    unanswered = np.isnan(flat["displacement_per_cycle"]).nonzero()[0]
    for name in _SAME_IN_CONTACT:
        flat[name][unanswered] = np.nan
