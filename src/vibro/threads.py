"""Passes grids of scenes to the compiled solver: as buffers with strides, in ranges, on several threads."""

from __future__ import annotations

import math
import os
import threading
from collections import deque
from threading import Event, Thread
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.core import compiled
from vibro.core.numbers import (
    BODIES,
    FIELDS,
    HARMONICS,
    LONGEST_CYCLE,
    MIXES,
    MOST_BOUNCES,
    MOST_HOPS,
    PIECES,
    ROOM,
)
from vibro.errors import VibroError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from numpy.typing import NDArray

    from vibro.drives import Drive


# ------------------------------------------------------------------------------
# Work in blocks on all cores: cuts a grid into blocks, and runs them on several threads.

# [cells] Few enough that temporaries stay near a core, many enough that threads seldom wait for each other
# between two NumPy calls (benchmarks/kernel.py).
BLOCK: Final = 131_072

# [s] How long an interrupt may go unnoticed: on Windows a wait without an end ignores it.
_PATIENCE: Final = 0.1


def doors() -> compiled.Doors:
    """Load the solver.

    Raises
    ------
    VibroError
        If the compiled library is not of the source beside it.
    """
    try:
        return compiled.doors()
    except ImportError as exc:
        raise VibroError(str(exc)) from None


def cores() -> int:
    """Return how many threads share the work."""
    return os.cpu_count() or 1


def grid_blocks(shape: tuple[int, ...], size: int) -> Iterator[tuple[slice, ...]]:
    """Cut a grid into slabs of at most ``size`` cells, in the order of its cells."""
    if 0 in shape:
        return
    inner = 1
    axis = len(shape)
    while axis > 0 and inner * shape[axis - 1] <= size:
        axis -= 1
        inner *= shape[axis]
    if axis == 0:
        yield (slice(None),) * len(shape)
        return
    rows = max(1, size // inner)
    rest = (slice(None),) * (len(shape) - axis)
    for outer in np.ndindex(*shape[: axis - 1]):
        fixed = tuple(slice(i, i + 1) for i in outer)
        for start in range(0, shape[axis - 1], rows):
            yield (*fixed, slice(start, start + rows), *rest)


def within(block: tuple[slice, ...], shape: tuple[int, ...]) -> tuple[slice, ...]:
    """Restrict a block of a grid to a field that broadcasts against it."""
    return tuple(slice(None) if n == 1 else part for part, n in zip(block, shape, strict=True))


def in_parallel(
    run: Callable[[Any], None],
    parts: Sequence[Any],
    threads: int | None = None,
    done: Callable[[int], None] | None = None,
) -> None:
    """Run parts on several threads; after an interrupt or an error the others end at once.

    Parameters
    ----------
    run : callable
        Called with each part; the calling thread works too.
    parts : sequence
        In the order in which they are begun.
    threads : int, optional
        How many share the work; without, one a core.
    done : callable, optional
        Called in the calling thread, after each part that it has run, with the number of parts that are done.
    """
    number = min(cores() if threads is None else threads, len(parts))
    if number < 2:
        for count, part in enumerate(parts, 1):
            run(part)
            if done:
                done(count)
        return
    left = deque(parts)
    failures: list[BaseException] = []
    finished: list[None] = []
    ended = Event()

    def look() -> None:
        if ended.is_set():
            raise _EndedError

    def work(tell: Callable[[int], None] | None = None) -> None:
        while True:
            try:
                part = left.popleft()
            except IndexError:  # none left; another thread may have taken the last
                return
            run(part)
            finished.append(None)
            if tell:
                tell(len(finished))

    def work_along() -> None:
        try:
            with compiled.asking(*asked, look):
                work()
        except _EndedError:
            pass
        except BaseException as exc:
            failures.append(exc)
            left.clear()

    asked = compiled.questions()
    others = [Thread(target=work_along, daemon=True) for _ in range(number - 1)]
    try:
        for thread in others:
            thread.start()
        work(done)
        for thread in others:
            while thread.is_alive():
                thread.join(_PATIENCE)
                if done:
                    done(len(finished))
    finally:
        left.clear()
        ended.set()
        for thread in others:  # their buffers may not outlive this call
            if thread.ident is not None:
                thread.join()
    if failures:
        raise failures[0]


class _EndedError(Exception):
    """Raised in threads whose work nobody waits for any more."""


_ONE: Final = np.ones(())


class Grid:
    """Scenes as the solver reads them.

    Parameters
    ----------
    fields : Drive
        Fields of a scene; they broadcast against each other without copies.

    Attributes
    ----------
    shape : tuple of int
        Common shape of the fields.
    size : int
        Number of cells.
    cost : int
        Number of harmonics, or of pieces, with which the time that a cell takes grows.
    """

    def __init__(self, fields: Drive) -> None:
        arrays, kind, breaks, pieces, unit = fields.columns()
        ndims = {x.ndim for x in arrays}
        count = len(arrays)
        if ndims == {0}:  # one scene: one small buffer
            self.shape: tuple[int, ...] = ()
            self.size, axes = 1, 1
            self._kept: tuple[Any, ...] = (np.array(arrays).reshape(count, 1),)
            buffers = doors().rows(self._kept[0])
            sizes, strides = _ONE_CELL, _NO_STRIDES if count == FIELDS else np.zeros(count, np.int64)
        else:
            self.shape = np.broadcast_shapes(*(x.shape for x in arrays))
            self.size, axes = math.prod(self.shape), len(self.shape)
            self._kept = tuple(np.ascontiguousarray(x, np.float64) for x in arrays)
            buffers = tuple(doors().row(x) if x.size else doors().row(_ONE) for x in self._kept)
            sizes = np.array(self.shape, np.int64)
            strides = np.array([_strides(x.shape, axes) for x in arrays], np.int64).T.copy()
        self._sizes, self._strides, self._axes, self._count = sizes, strides, axes, count
        further, starts, size, most = _NOTHING, _NO_STARTS, 0, 0.0
        self.cost = 1
        if kind == HARMONICS:
            size = (count - FIELDS) // 4
            starts = np.cumsum([0, *(x.size for x in arrays[FIELDS:-1])], dtype=np.int64)
            further = np.concatenate([np.asarray(x, np.float64).reshape(-1) for x in arrays[FIELDS:]])
        elif kind == PIECES:
            size, most = breaks.size - 1, unit
        self.hold(further, starts, breaks, pieces)
        self.scenes: Any = (
            *buffers[:FIELDS],
            *(doors().row(x) for x in (further, starts, sizes, strides)),
            axes,
            kind,
            size,
            most,
        )
        self._memory = _NO_MEMORY
        if kind in (HARMONICS, PIECES):
            self.cost = size
            part, table = (2 * size, 8 * size * size) if kind == HARMONICS else (4 * size, 5 * size + 1)
            self._memory = np.empty(ROOM * part + table), np.empty(2 * MIXES, np.int64)
            doors().prepare(self.scenes, (np.empty(0, np.int64), *self._memory), breaks, pieces)

    def hold(self, *arrays: NDArray[Any]) -> None:
        """Keep arrays alive that threads write to by their addresses, even after a second interrupt."""
        self._kept += arrays

    def place(self) -> tuple[NDArray[Any], ...]:
        """Make room for the place of a thread, and for the waves of a scene."""
        numbers, marks = self._memory
        return np.empty(self._axes + self._count, np.int64), numbers.copy(), marks.copy()


_ONE_CELL: Final = np.ones(1, np.int64)
_NO_STRIDES: Final = np.zeros(FIELDS, np.int64)
_NOTHING: Final = np.ones(1)
_NO_STARTS: Final = np.zeros(1, np.int64)
_NO_MEMORY: Final = (np.empty(1), np.empty(1, np.int64))


def _strides(shape: tuple[int, ...], axes: int) -> list[int]:
    """Strides in numbers along the axes of the grid; 0 where one value serves all."""
    strides, step = [0] * axes, 1
    for i in range(1, len(shape) + 1):
        if shape[-i] != 1:
            strides[-i] = step
        step *= shape[-i]
    return strides


class Scratch(threading.local):
    """Room for the flights of one scene, one a thread, made when it is first needed."""

    def __init__(self) -> None:
        self.flights = doors().rows(np.empty((8, MOST_BOUNCES + LONGEST_CYCLE)))
        self.hops = doors().rows(np.empty((8, BODIES * MOST_HOPS)))


def over_cells(
    run: Callable[[int, int], Any],
    size: int,
    step: int,
    threads: int | None,
    progress: Callable[[int, int], None] | None = None,
    *,
    cost: int = 1,
) -> None:
    """Run over all cells, a range at a time, on several threads if the solver is compiled.

    Parameters
    ----------
    run : callable
        Called with the begin and the end of each range.
    size, step : int
        Number of cells, and of those of a range, where they cost 1.
    threads : int, optional
        How many share the work; without, one a core.
    progress : callable, optional
        Called in this thread with the number of cells that are done, and of all.
    cost : int
        Of a cell, as that of the grid.
    """
    step = max(1, step // cost)
    if size <= step and progress is None:
        if size:
            run(0, size)
        return
    parts = [(begin, min(begin + step, size)) for begin in range(0, size, step)]

    def tell(done: int) -> None:
        if progress:
            progress(min(done * step, size), size)

    number = threads if doors().compiled else 1
    in_parallel(lambda part: run(*part), parts, number, tell)
