"""Sweeps: a grid of scenes to results, block by block or as a picture needs them."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.axes import Axis
from vibro.core.codes import Regime, Status
from vibro.drives import Ability
from vibro.limits import critical_loads
from vibro.motion.arrivals import arrival_time
from vibro.parallel import BLOCK, cores, grid_blocks, within
from vibro.quantities import QUANTITIES
from vibro.results.steady import RESULTS, SteadyCycle
from vibro.results.sweep import Block, SweepResult
from vibro.sweeps.grid import scene_of

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence

    from numpy.typing import NDArray

    from vibro.limits import CriticalLoads
    from vibro.sweeps.grid import Grid

    Floats = NDArray[np.float64]

__all__ = ["DrawnCells", "limits_of", "solved_picture", "sweep_blocks", "sweep_picture"]

# [cells] Handed on at once: enough that a block's fixed costs vanish, few enough that its texts stay small.
_BLOCK: Final = BLOCK // 2
# for each core: few enough that memory stays small (benchmarks/faults.py memory)
_SOLVED: Final = 2 * BLOCK
# if bodies are followed to their arrival, or other motions are searched for: a hundred times the work
_WALKED_BLOCK: Final = 8_192

# [values of an axis] Resolution of a picture of one, two or three axes, independent of the table's axes.
_RESOLVED: Final = {1: 4001, 2: 301, 3: 161}
# Means of bodies that bounce take milliseconds, and scatter more than a finer picture would show; an
# operating point with a filling takes 0.2 to 0.3 ms.
_COARSER: Final = 2
# [values of each range] of a table that is fine enough for maps of bodies that bounce: cells of 4 % of
# the side of a map, or 5 % of that of a facet, which is smaller.
_FINE: Final = 25
_FINE_FACET: Final = 20
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
                replace(cycle, **{name: x[piece] for name, x in cycle.arrays().items()}),
                grid.length,
                None if arrival is None else arrival[piece],
                grid.in_stroke,
            )


class DrawnCells:
    """Cells of a table that its pictures show too.

    Parameters
    ----------
    grid : Grid
        Of the table.
    indices : mapping of str to int array
        Places of these cells along every axis, ascending.
    """

    def __init__(self, grid: Grid, indices: Mapping[str, NDArray[np.intp]]) -> None:
        self.axes = {name: (grid.axes[name], kept) for name, kept in indices.items()}
        places = np.ravel_multi_index(np.ix_(*indices.values()), grid.shape)
        self._cells = places.reshape(-1)
        self.results: dict[str, NDArray[Any]] = {r.name: np.empty(places.shape, r.dtype) for r in RESULTS}
        self._seen = 0

    @classmethod
    def of(cls, grid: Grid, drawn: Mapping[str, tuple[int, ...]]) -> DrawnCells | None:
        """Choose the cells, if pictures need any; that depends on the grid alone.

        They are needed on maps of bodies that bounce, or whose other motions are searched for, of tables that
        are fine enough; ``drawn`` is that of ``sweep_picture``.
        """
        drawn = _of_grid(drawn)
        ranges = [len(axis) for name, axis in grid.axes.items() if name not in drawn]
        facets = any(len(indices) > 1 for indices in drawn.values())
        costly = grid.flight and (grid.coexistence or _bounces(grid.fixed))
        if not costly or len(ranges) != 2 or min(ranges) < (_FINE_FACET if facets else _FINE):
            return None
        return cls(grid, _solved_indices(grid, drawn))

    def add(self, block: Block) -> None:
        """Look at the next block of the table."""
        stop = self._seen + block.cycle.status.size
        first, last = np.searchsorted(self._cells, [self._seen, stop])
        here = self._cells[first:last] - self._seen
        for name, values in self.results.items():
            values.reshape(-1)[first:last] = getattr(block.cycle, name).reshape(-1)[here]
        self._seen = stop


def sweep_picture(
    grid: Grid,
    drawn: Mapping[str, tuple[int, ...]],
    operating_point: Mapping[str, float] | None,
    title: str,
    cells: DrawnCells | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> SweepResult:
    """Solve a grid for pictures, with a resolution of their own.

    Parameters
    ----------
    grid : Grid
        The whole grid.
    drawn : mapping of str to tuple of int
        Indices to keep of an axis, by its name in pictures; a single one holds the axis at that value. Every
        other axis, of at most two, is resolved evenly between its ends.
    operating_point : mapping of str to float, or None
        The scene's own values.
    title : str
        Title of the sweep.
    cells : DrawnCells, optional
        Cells of the table, all added. Where some of those around move irregularly, the nearest is shown;
        everything else is solved.
    progress : callable, optional
        As for ``vibro.solve``; it may begin again.

    Returns
    -------
    SweepResult
        Of at most three axes.
    """
    drawn = _of_grid(drawn)
    part = _grid_at(grid, drawn)
    ranges = [name for name in part.axes if name not in drawn]
    count = _resolution(len(ranges), len(part.axes) - len(ranges), is_costly=_is_costly(part))
    axes = {name: _resolved(axis, count) if name in ranges else axis for name, axis in part.axes.items()}
    part = replace(part, axes=axes)
    point = grid.operating_point(operating_point)
    values = part.values()
    places: dict[str, Floats] = {}
    if cells is None:
        cycle = part.solve(values, progress=progress)
    else:
        cycle, places = _solved_around(part, values, cells, progress)
    amplitude = None if part.machine is None else values["amplitude"]
    return _result(part, cycle, limits_of(values), point, title, places, amplitude)


def _solved_around(
    part: Grid,
    values: Mapping[str, Floats],
    cells: DrawnCells,
    progress: Callable[[int, int], None] | None,
) -> tuple[SteadyCycle, dict[str, Floats]]:
    """Solve the cells of a picture, except flights next to irregular ones of the table; return where too."""
    searched, part = part.coexistence, replace(part, coexistence=False)
    contact = replace(part, flight=False).solve(values)
    found = {name: x.copy() for name, x in contact.arrays().items()}
    near, irregular = cells.results, cells.results["status"] == Status.AVERAGED
    at, place = {}, 0
    for name, (axis, kept) in cells.axes.items():
        if len(kept) == 1:
            near = {result: x.take(0, place) for result, x in near.items()}
            irregular = irregular.take(0, place)
            continue
        left, right, nearest = _neighbours(axis.on_paper[kept], part.axes[name].on_paper)
        near = {result: x.take(nearest, place) for result, x in near.items()}
        irregular = irregular.take(left, place) | irregular.take(right, place)
        across = [-1 if i == place else 1 for i in range(len(part.axes))]
        at[name] = axis.values[kept][nearest].reshape(across)
        place += 1
    hops = contact.status == Status.FLIGHT_NOT_MODELLED
    alike = hops & (near["regime"] == Regime.HOPPING)
    taken = alike & irregular
    for name, x in found.items():  # ratios of loads are known without a flight
        unknown = taken & np.isnan(x) if x.dtype.kind == "f" else taken
        x[unknown] = near[name][unknown]
    anew = np.flatnonzero(hops & ~taken)
    if anew.size:
        solved = part.solve(part.picked(anew), progress=progress)
        for name, x in solved.arrays().items():
            found[name].reshape(-1)[anew] = x
    if searched:
        found["coexists"][alike] = near["coexists"][alike]
    return SteadyCycle(**found), {name: np.where(taken, x, values[name]) for name, x in at.items()}


def _neighbours(cells: Floats, at: Floats) -> tuple[NDArray[np.intp], ...]:
    """Return which of some ascending values lie to the left and the right of others, and the nearest."""
    right = np.clip(np.searchsorted(cells, at), 1, len(cells) - 1)
    left = right - 1
    nearest = np.where(at - cells[left] < cells[right] - at, left, right)
    same = cells[nearest] == at  # it is its own neighbour
    return np.where(same, nearest, left), np.where(same, nearest, right), nearest


def solved_picture(
    grid: Grid,
    drawn: Mapping[str, tuple[int, ...]],
    operating_point: Mapping[str, float] | None,
    title: str,
    pictures: Iterable[str],
    cells: Callable[[Collection[str], Sequence[NDArray[np.intp]]], Mapping[str, NDArray[Any]]],
) -> SweepResult:
    """Take the cells of pictures from a grid that is solved already.

    Parameters
    ----------
    grid, drawn, operating_point, title
        As for ``sweep_picture``. But a range is drawn at its own values: at all of them or, if there are at
        least twice as many as a picture resolves, at every second, third, ...
    pictures : iterable of str
        Names of the pictures.
    cells : callable
        From names of results and indices along every axis to these results, by name: arrays of the shape
        that the indices span.

    Returns
    -------
    SweepResult
        Of at most three axes; results that are not drawn are unknown.
    """
    from vibro.plots import results_drawn  # imported late: tables need no pictures

    indices = _solved_indices(grid, _of_grid(drawn))
    part = _grid_at(grid, indices)
    values = part.values()
    limits, point = limits_of(values), grid.operating_point(operating_point)
    found = cells(results_drawn(pictures, has_limits=limits is not None), list(indices.values()))
    results: dict[str, Any] = {
        r.name: np.broadcast_to(np.nan if r.is_number else r.dtype(0), part.shape) for r in RESULTS
    }
    results |= {name: values.reshape(part.shape) for name, values in found.items()}
    amplitude = None if part.machine is None else values["amplitude"]
    return _result(part, SteadyCycle(**results), limits, point, title, amplitude=amplitude)


def _result(
    part: Grid,
    cycle: SteadyCycle,
    limits: CriticalLoads | None,
    point: Mapping[str, float] | None,
    title: str,
    places: Mapping[str, Floats] | None = None,
    amplitude: Floats | None = None,
) -> SweepResult:
    """Hand a solved grid to pictures, in the quantities that were given."""
    told = None if point is None else part.told(point)
    return SweepResult(
        part.told_axes,
        part.told(part.fixed),
        cycle,
        limits,
        part.length,
        told,
        title,
        part.told(places or {}),
        amplitude,
    )


def _of_grid(drawn: Mapping[str, tuple[int, ...]]) -> dict[str, tuple[int, ...]]:
    """Call the axes of a picture as the grid does."""
    return {"amplitude" if name == "stroke" else name: indices for name, indices in drawn.items()}


def _grid_at(grid: Grid, indices: Mapping[str, Sequence[int] | NDArray[np.intp]]) -> Grid:
    """Keep some values of axes, by their names; those with a single one left are fixed quantities."""
    fixed, axes = dict(grid.fixed), {}
    for name, axis in grid.axes.items():
        kept = axis.values[list(indices[name])] if name in indices else axis.values
        if len(kept) == 1:
            fixed[name] = float(kept[0])
        else:
            axes[name] = replace(axis, values=kept)
    return replace(grid, axes=axes, fixed=fixed)


def _solved_indices(grid: Grid, drawn: Mapping[str, tuple[int, ...]]) -> dict[str, NDArray[np.intp]]:
    """Choose the values of every axis that a picture shows, of ranges at least as many as it resolves."""
    kept = sum(len(indices) > 1 for indices in drawn.values())
    ranges = len(grid.axes) - len(drawn)
    resolved = _RESOLVED[ranges + kept if ranges > 1 else 1]
    indices = {}
    for name, axis in grid.axes.items():
        last = len(axis) - 1
        steps = last // max(1, last // (resolved - 1))
        indices[name] = np.array(drawn.get(name, np.round(np.linspace(0, last, steps + 1))), np.intp)
    return indices


def limits_of(values: Mapping[str, Floats]) -> CriticalLoads | None:
    """Find the critical loads of cells; None for drives whose classes may end and begin again."""
    scene = scene_of(values)
    return critical_loads(scene) if scene.arrays().can(Ability.ONE_HARMONIC) else None


def _bounces(fixed: Mapping[str, float]) -> bool:
    """Whether bodies of a sweep may bounce."""
    return fixed.get("restitution", 1.0) > 0.0


def _is_costly(grid: Grid) -> bool:
    """Whether cells take far longer than most: bodies may bounce, or a filling acts on its machine."""
    return _bounces(grid.fixed) or (grid.machine is not None and grid.fixed.get("filling", 1.0) > 0.0)


def _resolution(ranges: int, kept: int, *, is_costly: bool) -> int:
    """Return the number of values of each range of a picture, beside so many axes whose values are kept."""
    intervals = _RESOLVED[ranges + kept if ranges > 1 else 1] - 1
    if ranges == 1 and kept:
        intervals //= _CURVES_COARSER * kept
    return intervals // (_COARSER if is_costly else 1) + 1


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
