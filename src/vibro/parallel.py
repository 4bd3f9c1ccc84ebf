"""Work in blocks on all cores: cuts a grid into blocks, and runs them on several threads."""

from __future__ import annotations

import os
from collections import deque
from threading import Thread, current_thread, main_thread
from typing import TYPE_CHECKING, Any, Final, TypeVar

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

__all__ = ["BLOCK", "cores", "grid_blocks", "heard", "in_parallel", "within"]

# [cells] Few enough that temporaries stay near a core, many enough that threads seldom wait for each other
# between two NumPy calls (benchmarks/kernel.py).
BLOCK: Final = 131_072

# [s] How long an interrupt may go unnoticed: on Windows a wait without an end ignores it.
_PATIENCE: Final = 0.1


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


_R = TypeVar("_R")


def heard(run: Callable[[], _R]) -> _R:
    """Run a call that may last in another thread, so that this one hears signals.

    A compiled function holds off the handlers of signals until it returns. After an interrupt it runs on to
    its end: what it writes to must live as long as ``run``.
    """
    if current_thread() is not main_thread():
        return run()
    found: list[_R] = []
    failures: list[BaseException] = []

    def work() -> None:
        try:
            found.append(run())
        except BaseException as exc:
            failures.append(exc)

    thread = Thread(target=work, daemon=True)
    thread.start()
    while thread.is_alive():
        thread.join(_PATIENCE)
    if failures:
        raise failures[0]
    return found[0]


def in_parallel(
    run: Callable[[Any], None],
    parts: Sequence[Any],
    threads: int | None = None,
    done: Callable[[int], None] | None = None,
    *,
    lasting: bool = False,
) -> None:
    """Run parts on several threads; after an interrupt the others end with the part they are at.

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
    lasting : bool
        Whether a part may take long: then it is ``heard``, and an interrupt does not wait for it.
    """
    given = run

    def run_heard(part: Any) -> None:
        heard(lambda: given(part))

    run = run_heard if lasting else given
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
            work()
        except BaseException as exc:
            failures.append(exc)
            left.clear()

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
        for thread in others:  # their buffers may not outlive this call, but for those of parts that last
            if thread.ident is not None:
                thread.join(_PATIENCE if lasting else None)
    if failures:
        raise failures[0]
