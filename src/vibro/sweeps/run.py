"""Sweeps: a grid of scenes to results, block by block or as a picture needs them."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from vibro.axes import Axis
from vibro.core.codes import Status
from vibro.limits import critical_loads
from vibro.motion.arrivals import arrival_time
from vibro.parallel import BLOCK, cores, grid_blocks, within
from vibro.quantities import QUANTITIES
from vibro.results.steady import SteadyCycle
from vibro.results.sweep import Block, SweepResult
from vibro.scene import HarmonicFields
from vibro.sweeps.grid import scene_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from numpy.typing import NDArray

    from vibro.core.contact.limits import CriticalLoads
    from vibro.sweeps.grid import Grid

    Floats = NDArray[np.float64]

__all__ = ["limits_of", "sweep_blocks", "sweep_picture"]

# [cells] Handed on at once: enough that a block's fixed costs vanish, few enough that its texts stay small.
_BLOCK: Final = BLOCK // 2
# for each core: few enough that memory stays small (benchmarks/faults.py memory)
_SOLVED: Final = 2 * BLOCK
# where bodies are followed to their arrival, or other motions are looked for: a hundred times the work
_WALKED_BLOCK: Final = 8_192

# [values of an axis] What a picture of one, two or three axes resolves, whatever the table's axes hold.
_RESOLVED: Final = {1: 4001, 2: 301, 3: 161}
# Means of bodies that bounce take milliseconds, and scatter more than a finer picture would show.
_COARSER: Final = 2
# A curve of several is read less closely than one alone, in a facet still less, and all have to be solved.
_CURVES_COARSER: Final = 4


def sweep_blocks(grid: Grid) -> Iterator[Block]:
    """Solve a grid block by block, in the order of its cells.

    Parameters
    ----------
    grid : Grid
        Every value within its own range; combinations may be infeasible.

    Yields
    ------
    Block
        Together the whole grid; the last axis runs fastest.
    """
    walked = grid.arrivals or grid.coexistence
    for box in grid_blocks(grid.shape, _WALKED_BLOCK if walked else _SOLVED * cores()):
        values = grid.values(box)
        cycle = grid.solve(values)
        arrival = _arrival(grid, values, cycle) if grid.arrivals else None
        # Solved together, so that all cores have work; handed on in pieces whose texts stay small.
        for piece in grid_blocks(cycle.status.shape, _BLOCK):
            yield Block(
                {name: x[within(piece, x.shape)] for name, x in values.items()},
                SteadyCycle(**{name: x[piece] for name, x in vars(cycle).items()}),
                grid.length,
                None if arrival is None else arrival[piece],
            )


def sweep_picture(
    grid: Grid, drawn: Mapping[str, tuple[int, ...]], operating_point: Mapping[str, float] | None, title: str
) -> SweepResult:
    """Solve what pictures show of a grid, with a resolution of their own.

    Parameters
    ----------
    grid : Grid
        The whole grid.
    drawn : mapping of str to tuple of int
        Indices to keep of an axis, by name; a single one holds the axis at that value. Every other axis, of
        at most two, is resolved evenly between its ends.
    operating_point : mapping of str to float, or None
        The scene's own values.
    title : str
        What the sweep is of.

    Returns
    -------
    SweepResult
        Of at most three axes.
    """
    held = {name: indices[0] for name, indices in drawn.items() if len(indices) == 1}
    fixed = {**grid.fixed, **{name: float(grid.axes[name].values[i]) for name, i in held.items()}}
    varying = [axis for name, axis in grid.axes.items() if name not in held]
    kept = sum(axis.name in drawn for axis in varying)
    count = _resolution(len(varying) - kept, kept, bounces=fixed.get("restitution", 1.0) > 0.0)
    axes = {
        axis.name: replace(axis, values=axis.values[list(drawn[axis.name])])
        if axis.name in drawn
        else _resolved(axis, count)
        for axis in varying
    }
    part = replace(grid, axes=axes, fixed=fixed)
    values = part.values()
    limits, point = limits_of(values), grid.operating_point(operating_point)
    return SweepResult(axes, fixed, part.solve(values), limits, grid.length, point, title)


def limits_of(values: Mapping[str, Floats]) -> CriticalLoads | None:
    """Find the critical loads of cells; nothing where their drives have harmonics."""
    scene = scene_of(values)
    return None if isinstance(scene.arrays(), HarmonicFields) else critical_loads(scene)


def _resolution(ranges: int, kept: int, *, bounces: bool) -> int:
    """Return the number of values of each range of a picture, beside so many axes whose values are kept."""
    intervals = _RESOLVED[ranges + kept if ranges > 1 else 1] - 1
    if ranges == 1 and kept:
        intervals //= _CURVES_COARSER * kept
    return intervals // (_COARSER if bounces else 1) + 1


def _resolved(axis: Axis, count: int) -> Axis:
    """Spread values evenly between the ends of an axis."""
    ends = float(axis.values[0]), float(axis.values[-1])
    if axis.spacing == "log":
        return Axis(axis.name, np.geomspace(*ends, count), "log")
    return Axis(axis.name, np.linspace(*ends, count), "linear")


def _arrival(grid: Grid, values: Mapping[str, Floats], cycle: SteadyCycle) -> Floats | None:
    """Follow bodies from rest; those whose flight is not modelled have no arrival."""
    if grid.length is None:
        return None
    length = QUANTITIES["trough_length"].to_si(grid.length)
    time = np.asarray(arrival_time(scene_of(values), length))
    return np.where(cycle.status == Status.FLIGHT_NOT_MODELLED, np.nan, time)
