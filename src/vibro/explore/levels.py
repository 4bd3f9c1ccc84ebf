"""The cells of a map, solved in the order in which people need them: contact at once, flights coarse to fine.

Contact takes a few milliseconds a map. A flight takes 13 to 50 us where bodies do not bounce, and a
millisecond or more where they do; on drives beyond one harmonic contact takes 10 to 500 us a cell too, the
more, the more pieces they have; and the amplitude of a machine takes 100 to 300 us where the weight of a
filling is to be found. These cells come one lattice after the other, each with half the spacing, and show a
solved neighbour meanwhile. Over amplitude and frequency everything depends on the load G alone, up to the
scales of length and time: there a line of loads shows the whole map before.
"""

from __future__ import annotations

import math
import time
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from vibro.core.codes import Regime, Status
from vibro.core.numbers import MOST_THROW
from vibro.drives import Ability
from vibro.explore.controls import is_weighed
from vibro.explore.previews import foreseen
from vibro.limits import CriticalLoads
from vibro.results.steady import RESULTS, SteadyCycle
from vibro.sweeps.grid import scene_of
from vibro.sweeps.run import limits_of

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from numpy.typing import NDArray

    from vibro.reals import Floats
    from vibro.scene import Scene
    from vibro.sweeps.grid import Grid

    Indices = NDArray[np.intp]

__all__ = ["LOADS", "MapCells", "Shown"]

#: Of a line that shows a map over amplitude and frequency. Before them all come some, which take 14 ms where
#: bodies do not bounce and .3 s where they do.
LOADS: Final = 512
_FIRST_LOADS: Final = 128
_FIRST_BOUNCING: Final = 64
_SPACINGS: Final = (16, 8, 4, 2, 1)  # of the lattices [cells]
_WEIGHED_SPACINGS: Final = (
    64,
    32,
    *_SPACINGS,
)  # between which fillings' weights are interpolated

_LIMIT_ROWS: Final = 15  # of a map whose critical loads are found at once, which takes 40 us a cell
_FIRST_CELLS: Final = 64  # solved first, to measure how long they take
_FIRST_WEIGHED: Final = 8  # which take up to 60 ms each where bodies bounce
_BATCH_TIME: Final = 0.25  # [s] that solving so many at once may take: of few, each takes ten times as long

_ANY_AMPLITUDE: Final = {"amplitude": np.ones((1, 1))}

# How results of bodies with the same load scale with amplitude and frequency; other results do not change.
_WITH_AMPLITUDE: Final = ("displacement_per_cycle",)
_WITH_SPEED: Final = ("mean_velocity", "peak_velocity", "impact_velocity", "mean_velocity_error")


class Shown(NamedTuple):
    """The state of a map, arrays of the grid's shape.

    Attributes
    ----------
    cycle : SteadyCycle
        A cell that is not ``exact`` shows the numbers of a solved one nearby, or of the nearest load.
    exact : bool array
        Whether each cell is what ``vibro.solve`` gives for it.
    known : bool array
        Whether each cell shows numbers, or has a status that says why there are none.
    limits : CriticalLoads or None
        Critical loads of the cells; of ellipses they take long and are None at first, and of drives without
        ``Ability.ONE_HARMONIC``, whose classes may end and begin again, always.
    is_done : bool
        Whether all cells are computed.
    share : float
        Exact share of the slow cells.
    text : str
        Description of the others.
    values : mapping of str to array
        Quantities of the cells, as of ``Grid.values``; an amplitude that is not found yet is the neighbour's.
    """

    cycle: SteadyCycle
    exact: NDArray[np.bool_]
    known: NDArray[np.bool_]
    limits: CriticalLoads | None
    is_done: bool
    share: float
    text: str
    values: Mapping[str, Floats]


class MapCells:
    """The cells of one map, as far as they are solved.

    Parameters
    ----------
    grid : Grid
        Of two axes.
    patience : float, optional
        How long a first picture may take [s]: loads that show a map over amplitude and frequency, or lattices
        beyond the widest one, on drives beyond one harmonic.
    expected : float, optional
        How long they took for the last map [s]: if longer than ``patience``, they are left to ``advance``.
        Irregular motion takes ten times as long as periodic motion, and successive maps are much alike.

    Attributes
    ----------
    shown : Shown
        The state of the map; every ``advance`` makes a new one.
    """

    def __init__(self, grid: Grid, *, patience: float = math.inf, expected: float = 0.0) -> None:
        self._grid = grid
        self._limits: CriticalLoads | None = None
        self._limit_rows: list[CriticalLoads] = []
        self._is_weighed = is_weighed(grid.machine, grid.axes, grid.fixed)
        self._given = replace(grid, machine=None).values() if self._is_weighed else grid.values()
        self._found: dict[str, NDArray[Any]] = {}  # of a machine, cell by cell
        # Critical loads do not depend on the amplitude.
        values = {**self._given, **_ANY_AMPLITUDE} if self._is_weighed else self._given
        scene = scene_of(values)
        drive = scene.arrays()
        self._is_quick = drive.can(Ability.ONE_HARMONIC) and not self._is_weighed  # where bodies do not hop
        if self._is_quick:
            self._solved = replace(grid, flight=False).solve(values)
            waiting = self._solved.status == int(Status.FLIGHT_NOT_MODELLED)
            waiting &= self._solved.throw_number <= MOST_THROW
        else:
            nothing: dict[str, Any] = {r.name: np.zeros(grid.shape, r.dtype) for r in RESULTS}
            self._solved = SteadyCycle(**nothing)
            waiting = np.ones(grid.shape, np.bool_)
        self._exact = ~waiting
        self._spacings = _WEIGHED_SPACINGS if self._is_weighed else _SPACINGS
        self._waiting = _coarse_to_fine(waiting, self._spacings[0])
        self._done = 0
        self._line = None if self._is_solved else _Line.over(grid, scene, waiting)
        if self._line is not None and not grid.fixed["restitution"] and expected <= patience:
            self._line.solve_more()
        self._has_limits = drive.can(Ability.PROOF) or not self._is_quick
        if self._has_limits:
            self._limits = limits_of(values)
        self._preview: tuple[int, dict[str, NDArray[Any]], SteadyCycle] | None = None
        self._turn = _Turn(_FIRST_WEIGHED if self._is_weighed else _FIRST_CELLS)
        if not self._is_quick:
            end = time.perf_counter() + patience
            self._solve_more(math.prod(-(-n // self._spacings[0]) for n in grid.shape))  # the widest lattice
            while not self._is_solved and time.perf_counter() < end:
                self._turn.take(self._solve_more)
        self._show()

    @property
    def took(self) -> float | None:
        """How long the first loads took [s]; None if they are not needed, or not solved yet."""
        return None if self._line is None else self._line.took

    def _progress(self) -> tuple[float, str]:
        """Return the exact share of the slow cells, and a description of the others."""
        if self.is_done:
            return 1.0, ""
        share = self._done / self._waiting.size if self._waiting.size else 1.0
        if not self._has_limits:
            return share, "boundaries of back slip: a preview"
        if self._is_weighed:
            return share, f"{share:.0%} exact, the rest interpolated"
        if self._line is None or not self._line.is_known:
            slow = "hopping: " if self._is_quick else ""
            return share, f"{slow}{share:.0%} exact, the rest from neighbours or to come"
        told = f"of loads within {math.ceil(1e4 * self._line.spread) / 100:.4g} %"
        told = told if self._line.is_done else "a preview"
        return share, f"hopping: {share:.0%} exact, the rest {told}"

    @property
    def is_done(self) -> bool:
        """Whether every cell is exact, and the critical loads are known as far as they can be."""
        return self._is_solved and self._has_limits

    @property
    def _is_solved(self) -> bool:
        return self._done == self._waiting.size

    def advance(self, seconds: float) -> None:
        """Continue for about so long, one turn at least."""
        end = time.perf_counter() + seconds
        while not self.is_done:
            if not self._has_limits:
                self._find_limits()
            elif self._line is not None and not self._line.is_done:
                self._line.solve_more()
            else:
                self._turn.take(self._solve_more)
            if time.perf_counter() >= end:
                break
        self._show()

    def _find_limits(self) -> None:
        """Find the critical loads of further rows; of one row if all are alike."""
        first = sum(part.hop.shape[0] for part in self._limit_rows)
        part = limits_of(self._grid.values((slice(first, first + _LIMIT_ROWS), slice(None))))
        assert part is not None
        self._limit_rows.append(part)
        if part.hop.shape[0] == 1 or first + _LIMIT_ROWS >= self._grid.shape[0]:
            rows = zip(*self._limit_rows, strict=True)
            self._limits = CriticalLoads(*(np.concatenate(loads) for loads in rows))
            self._has_limits = True

    def _solve_more(self, count: int) -> int:
        """Solve up to so many further cells; return the number solved."""
        cells = self._waiting[self._done : self._done + count]
        values = self._grid.picked(cells)
        found = self._grid.solve(values)
        for name in values.keys() - self._given.keys() if self._is_weighed else ():
            nothing = np.zeros(self._grid.shape, values[name].dtype)
            self._found.setdefault(name, nothing).reshape(-1)[cells] = values[name]
        for name, values in found.arrays().items():
            getattr(self._solved, name).reshape(-1)[cells] = values
        self._solved.long_patterns.update(found.long_patterns)
        self._exact.reshape(-1)[cells] = True
        self._done += cells.size
        return cells.size

    def _show(self) -> None:
        """Let cells that are not solved show the nearest solved ones."""
        cycle, exact = self._solved, self._exact.copy()
        known = np.ones(exact.shape, np.bool_)
        told = self._found
        if not self._is_solved:
            cells = {name: values.copy() for name, values in cycle.arrays().items()}
            if self._line is not None and self._line.is_known:
                self._line.show(cells, ~exact)
                cycle.long_patterns.update(self._line.long_patterns)
            else:
                source = self._neighbours()
                far = ~exact & (source >= 0)
                if self._is_weighed:
                    told, far, known = self._foresee(cells, far, source)
                else:
                    known = exact | far
                for values in cells.values():
                    values[far] = values.reshape(-1)[source[far]]
            cycle = replace(cycle, **cells)
        numbers = {**self._given, **told}
        self.shown = Shown(cycle, exact, known, self._limits, self.is_done, *self._progress(), numbers)

    def _foresee(
        self, cells: dict[str, NDArray[Any]], far: NDArray[np.bool_], source: Indices
    ) -> tuple[dict[str, NDArray[Any]], NDArray[np.bool_], NDArray[np.bool_]]:
        """Fill in cells of a machine with a filling that are not solved yet.

        Returns
        -------
        dict of str to array
            What the machine adds to all cells.
        bool array
            Which cells hop, and have no numbers but those of a solved neighbour that hops too.
        bool array
            Which cells have numbers then.
        """
        shape = self._exact.shape
        spacing = next(s for s in self._spacings[::-1] if math.prod(-(-n // s) for n in shape) <= self._done)
        if self._preview is None or self._preview[0] != spacing:
            self._preview = spacing, *foreseen(self._grid, self._given, self._found, spacing)
        _, added, cycle = self._preview
        told = {name: values.copy() for name, values in added.items()}
        for name, values in told.items():
            values[self._exact] = self._found[name][self._exact]
        near = cells["regime"].reshape(-1)[source]
        for name, values in cells.items():
            values[~self._exact] = getattr(cycle, name)[~self._exact]
        hops = far & (cycle.status == int(Status.FLIGHT_NOT_MODELLED))
        borrowed = hops & (near == Regime.HOPPING)
        return told, borrowed, ~hops | borrowed

    def _neighbours(self) -> Indices:
        """Return for every cell the solved one, of those that waited, in the corner of its square; or -1."""
        shape = self._exact.shape
        numbers = np.arange(self._exact.size).reshape(shape)
        solved = np.zeros(shape, np.bool_)
        solved.reshape(-1)[self._waiting[: self._done]] = True
        source = np.full(shape, -1, np.intp)
        for spacing in self._spacings:
            corner = np.ix_(*(np.arange(n) // spacing * spacing for n in shape))
            source = np.where(solved[corner], numbers[corner], source)
        return source


class _Turn:
    """How many cells are solved at once: as many as take a turn's time, and at least so many."""

    def __init__(self, least: int) -> None:
        self._least = self._count = least

    def take(self, work: Callable[[int], int]) -> None:
        """Do as much work as a turn has time for; ``work`` returns how much it did."""
        start = time.perf_counter()
        done = work(self._count)
        taken = time.perf_counter() - start
        if done == self._count:
            self._count = max(self._least, int(self._count * min(4.0, _BATCH_TIME / taken)))


class _Line:
    """Bodies of the same angles, frictions and restitution at loads between the ends of a map's.

    Attributes
    ----------
    took : float or None
        How long the first of them took [s].
    spread : float
        Largest relative distance of a load between the ends from the nearest of all that are solved.
    long_patterns : dict of int to str
        As in ``SteadyCycle``.
    """

    def __init__(self, grid: Grid, ends: tuple[float, float], load: Floats) -> None:
        self._loads = np.geomspace(*ends, LOADS)
        self._load = load
        self._order, self._done = _coarse_to_fine(np.ones((1, LOADS), np.bool_), LOADS), 0
        fixed = {name: np.array([value]) for name, value in grid.fixed.items()}
        values = grid.values()
        self._frequency = values["frequency"]
        self._amplitude = values["amplitude"]
        # Reference bodies may have any frequency: take the middle one.
        self._reference = float(np.median(self._frequency))
        gravity = grid.fixed["gravity"]
        w = 2.0 * math.pi * self._reference
        self._amplitudes = 1e3 * self._loads * gravity / w**2  # [mm]
        self._given = {**fixed, "frequency": np.array([self._reference])}
        self._grid = grid
        self._found: dict[str, NDArray[Any]] = {}
        self.long_patterns: dict[int, str] = {}
        self._stages = [_FIRST_BOUNCING if grid.fixed["restitution"] else _FIRST_LOADS, LOADS]
        self.took: float | None = None

    @classmethod
    def over(cls, grid: Grid, scene: Scene, waiting: NDArray[np.bool_]) -> _Line | None:
        """Make the line of a map over amplitude and frequency; None for other maps."""
        if set(grid.axes) != {"amplitude", "frequency"}:
            return None
        load = np.broadcast_to(scene.load, waiting.shape)
        ends = float(load[waiting].min()), float(load[waiting].max())
        if not 0.0 < ends[0] < ends[1] < math.inf:
            return None
        return cls(grid, ends, load)

    @property
    def is_known(self) -> bool:
        """Whether loads are solved, from end to end."""
        return self._done > 0

    @property
    def is_done(self) -> bool:
        """Whether every load is solved."""
        return self._done == LOADS

    @property
    def spread(self) -> float:
        return math.expm1(0.5 * np.diff(np.log(self._loads)).max())

    def solve_more(self) -> None:
        """Solve the loads of the next stage."""
        start = time.perf_counter()
        chosen = self._order[self._done : self._stages.pop(0)]
        found = self._grid.solve({**self._given, "amplitude": self._amplitudes[chosen]})
        for name, values in found.arrays().items():
            self._found.setdefault(name, np.zeros(LOADS, values.dtype))[chosen] = values
        self.long_patterns.update(found.long_patterns)
        self._done += chosen.size
        self.took = time.perf_counter() - start if self.took is None else self.took

    def show(self, shown: dict[str, NDArray[Any]], where: NDArray[np.bool_]) -> None:
        """Fill in cells with the numbers of the nearest load."""
        solved = np.sort(self._order[: self._done])
        middles = np.sqrt(self._loads[solved[1:]] * self._loads[solved[:-1]])
        nearest = solved[np.searchsorted(middles, self._load[where])]
        amplitude, frequency = (
            np.broadcast_to(x, self._load.shape)[where] for x in (self._amplitude, self._frequency)
        )
        longer = amplitude / self._amplitudes[nearest]
        faster = longer * (frequency / self._reference)
        for name, values in shown.items():
            numbers = self._found[name][nearest]
            if name in _WITH_AMPLITUDE:
                numbers = numbers * longer
            elif name in _WITH_SPEED:
                numbers = numbers * faster
            values[where] = numbers


def _coarse_to_fine(chosen: NDArray[np.bool_], spacing: int) -> Indices:
    """Return the flat indices of chosen cells: those of the widest lattice first, then of ever finer ones."""
    # Spacings are powers of 2: along an axis the widest lattice that holds an index is their common divisor.
    widest = np.minimum.outer(*(np.gcd(np.arange(n), spacing) for n in chosen.shape)).reshape(-1)
    cells = np.flatnonzero(chosen)
    return cells[np.argsort(-widest[cells], kind="stable")]


assert set(_WITH_AMPLITUDE + _WITH_SPEED) <= {result.name for result in RESULTS}
