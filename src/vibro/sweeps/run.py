"""Sweeps: a grid of scenes to results, block by block or as a picture needs them."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.axes import Axis
from vibro.drives import Ability
from vibro.limits import critical_loads
from vibro.motion.histories import arrival_time
from vibro.quantities import QUANTITIES
from vibro.results.steady import RESULTS, SteadyCycle
from vibro.results.sweep import Block, SweepResult
from vibro.sweeps.grid import scene_of
from vibro.threads import BLOCK, cores, grid_blocks, within

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence

    from numpy.typing import NDArray

    from vibro.limits import CriticalLoads
    from vibro.reals import Floats
    from vibro.results.sweep import Peak
    from vibro.sweeps.grid import Grid


# [cells] Handed on at once: enough that a block's fixed costs vanish, few enough that its texts stay small.
_BLOCK: Final = BLOCK // 2
# for each core: few enough that memory stays small (benchmarks/sweeps.py)
_SOLVED: Final = 2 * BLOCK
# if bodies are followed to their arrival, or from many starts: a hundred times the work
_WALKED_BLOCK: Final = 8_192

# [values of an axis] Resolution of a picture of one, two or three axes, independent of the table's axes.
_RESOLVED: Final = {1: 4001, 2: 301, 3: 161}
# Of cells that are dear to solve, whose means scatter more than a finer picture would show.
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
    walked = grid.arrivals or grid.starts is not None
    for box in grid_blocks(grid.shape, _WALKED_BLOCK if walked else _SOLVED * cores()):
        values = grid.values(box)
        cycle = grid.solve(values)
        arrival = _arrival(grid, values) if grid.arrivals else None
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
    """Cells of a table that are dear to solve: its pictures show them, and solve none of their own.

    Parameters
    ----------
    grid : Grid
        Of the table.
    indices : mapping of str to int array
        Places of these cells along every axis, ascending.
    """

    def __init__(self, grid: Grid, indices: Mapping[str, NDArray[np.intp]]) -> None:
        places = np.ravel_multi_index(np.ix_(*indices.values()), grid.shape)
        self._cells = places.reshape(-1)
        self._results: dict[str, NDArray[Any]] = {r.name: np.empty(places.shape, r.dtype) for r in RESULTS}
        self._seen = 0

    @classmethod
    def of(cls, grid: Grid, drawn: Mapping[str, tuple[int, ...]]) -> DrawnCells | None:
        """Choose the cells, if pictures need any; that depends on the grid alone.

        They are needed on maps of bodies that bounce, or start many times, of tables that are fine enough;
        ``drawn`` is that of ``sweep_picture``.
        """
        ranges = [len(axis) for name, axis in grid.axes.items() if name not in drawn]
        facets = any(len(indices) > 1 for indices in drawn.values())
        if not grid.is_dear or len(ranges) != 2 or min(ranges) < (_FINE_FACET if facets else _FINE):
            return None
        return cls(grid, _solved_indices(grid, drawn))

    def add(self, block: Block) -> None:
        """Look at the next block of the table."""
        stop = self._seen + block.cycle.status.size
        first, last = np.searchsorted(self._cells, [self._seen, stop])
        here = self._cells[first:last] - self._seen
        for name, values in self._results.items():
            values.reshape(-1)[first:last] = getattr(block.cycle, name).reshape(-1)[here]
        self._seen = stop

    def results(self, names: Collection[str], indices: Sequence[NDArray[np.intp]]) -> dict[str, NDArray[Any]]:
        """Return results of the cells, all of which are added, as ``solved_picture`` takes them."""
        return {name: self._results[name] for name in names}


def sweep_picture(
    grid: Grid,
    drawn: Mapping[str, tuple[int, ...]],
    operating_point: Mapping[str, float] | None,
    title: str,
    progress: Callable[[int, int], None] | None = None,
    peaks: Mapping[str, Peak] | None = None,
) -> SweepResult:
    """Solve a grid for pictures, with a resolution of their own.

    Parameters
    ----------
    grid : Grid
        The whole grid.
    drawn : mapping of str to tuple of int
        Indices to keep of an axis, as ``View.drawn``; a single one holds the axis at that value. Every other
        axis, of at most two, is resolved evenly between its ends.
    operating_point : mapping of str to float, or None
        The scene's own values.
    title : str
        Title of the sweep.
    progress : callable, optional
        As for ``vibro.solve``.
    peaks : mapping of str to Peak, optional
        The fastest cells of the table that the picture belongs to.

    Returns
    -------
    SweepResult
        Of at most three axes.
    """
    part = _grid_at(grid, drawn)
    count = _values_solved(part, drawn)
    axes = {name: axis if name in drawn else _resolved(axis, count) for name, axis in part.axes.items()}
    part = replace(part, axes=axes)
    values = part.values()
    cycle = part.solve(values, progress=progress)
    return _result(part, cycle, values, grid.operating_point(operating_point), title, peaks)


def solved_picture(
    grid: Grid,
    drawn: Mapping[str, tuple[int, ...]],
    operating_point: Mapping[str, float] | None,
    title: str,
    pictures: Iterable[str],
    cells: Callable[[Collection[str], Sequence[NDArray[np.intp]]], Mapping[str, NDArray[Any]]],
    peaks: Mapping[str, Peak] | None = None,
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
    peaks : mapping of str to Peak, optional
        The fastest cells of the whole grid.

    Returns
    -------
    SweepResult
        Of at most three axes; results that are not drawn are unknown.
    """
    from vibro.plots import results_drawn  # imported late: tables need no pictures

    indices = _solved_indices(grid, drawn)
    part = _grid_at(grid, indices)
    values = part.values()
    names = results_drawn(
        pictures, has_limits=limits_of(values) is not None, of_starts=grid.starts is not None
    )
    found = cells(names, list(indices.values()))
    results: dict[str, Any] = {
        r.name: np.broadcast_to(np.nan if r.is_number else r.dtype(0), part.shape) for r in RESULTS
    }
    results |= {name: values.reshape(part.shape) for name, values in found.items()}
    return _result(part, SteadyCycle(**results), values, grid.operating_point(operating_point), title, peaks)


def _result(
    part: Grid,
    cycle: SteadyCycle,
    values: Mapping[str, Floats],
    point: Mapping[str, float] | None,
    title: str,
    peaks: Mapping[str, Peak] | None,
) -> SweepResult:
    """Hand a solved grid to pictures, in the quantities that were given."""
    return SweepResult(
        part.given_axes,
        part.as_given(part.fixed),
        cycle,
        limits_of(values),
        part.length,
        None if point is None else part.as_given(point),
        title,
        None if part.machine is None else values["amplitude"],
        None if peaks is None else {k: p._replace(values=part.as_given(p.values)) for k, p in peaks.items()},
    )


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
    resolved = _values_resolved(grid, drawn)
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


def _values_resolved(grid: Grid, drawn: Mapping[str, Collection[int]]) -> int:
    """Return how many values of each range a picture resolves, beside axes of which several are kept."""
    ranges, kept = len(grid.axes.keys() - drawn.keys()), sum(len(indices) > 1 for indices in drawn.values())
    return _RESOLVED[ranges + kept if ranges > 1 else 1]


def _values_solved(grid: Grid, drawn: Mapping[str, Collection[int]]) -> int:
    """Return how many values of each range are solved for a picture of a grid whose other axes are held."""
    intervals, kept = _values_resolved(grid, drawn) - 1, len(grid.axes.keys() & drawn.keys())
    if kept == len(grid.axes) - 1 > 0:
        intervals //= _CURVES_COARSER * kept
    # an operating point with a filling takes 0.2 to 0.3 ms
    is_filled = grid.machine is not None and grid.fixed.get("filling", 1.0) > 0.0
    return intervals // (_COARSER if grid.is_dear or is_filled else 1) + 1


def _resolved(axis: Axis, count: int) -> Axis:
    """Spread values evenly between the ends of an axis."""
    is_log = axis.spacing == "log"
    values = (np.geomspace if is_log else np.linspace)(axis.values[0], axis.values[-1], count)
    return Axis(axis.name, values, "log" if is_log else "linear")


def _arrival(grid: Grid, values: Mapping[str, Floats]) -> Floats | None:
    """Follow bodies from rest."""
    if grid.length is None:
        return None
    return np.asarray(arrival_time(scene_of(values), QUANTITIES["trough_length"].to_si(grid.length)))
