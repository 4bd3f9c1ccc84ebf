"""Who makes the parts of a sweep: threads of this process, processes of this machine, or a Dask cluster."""

from __future__ import annotations

import contextlib
import logging
import math
import multiprocessing
import os
import signal
import threading
import time
from abc import ABC, abstractmethod
from concurrent.futures import BrokenExecutor, CancelledError, Future, ProcessPoolExecutor, ThreadPoolExecutor
from typing import TYPE_CHECKING, Any, Final, Self

from vibro.errors import FileError, VibroError
from vibro.parallel import cores

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

__all__ = ["Cluster", "Processes", "Threads", "Workers", "workers_of"]

_GRACE: Final = 2.0  # [s] in which a worker whose client has gone may remove what it was writing
_KNOWN: Final = 5.0  # [s] for which the number of workers is taken for unchanged
_CONNECTING: Final = 15.0  # [s] until a scheduler, or the first of its workers, is given up


class Workers(ABC):
    """Who makes parts; a context.

    Attributes
    ----------
    threads : int
        That each may use.
    number : int
        How many parts are made at once.
    lost : tuple of exception types
        With which a task ends whose worker was lost; another may do it.
    """

    threads: int = 1
    number: int = 1
    lost: tuple[type[BaseException], ...] = (BrokenExecutor,)

    @abstractmethod
    def __enter__(self) -> Self:
        """Begin; again after an end."""

    @abstractmethod
    def __exit__(self, *_: object) -> None:
        """End; what is not begun is left out."""

    @abstractmethod
    def submit(self, work: Callable[..., Any], *args: Any) -> Future[Any]:
        """Have something done."""


class Threads(Workers):
    """Threads of this process, each with its own part while there are enough.

    Parameters
    ----------
    parts : int
        How many there are.
    """

    def __init__(self, parts: int) -> None:
        self.number = max(1, min(cores(), parts))
        self.threads = max(1, cores() // self.number)

    def __enter__(self) -> Self:
        self._pool = ThreadPoolExecutor(self.number, "part")
        return self

    def __exit__(self, *_: object) -> None:
        self._pool.shutdown(cancel_futures=True)

    def submit(self, work: Callable[..., Any], *args: Any) -> Future[Any]:
        """Have something done."""
        return self._pool.submit(work, *args)


class Processes(Workers):
    """Processes of this machine, which share its cores.

    Parameters
    ----------
    number : int
        How many.
    """

    def __init__(self, number: int) -> None:
        self.number = number
        self.threads = max(1, cores() // number)

    def __enter__(self) -> Self:
        # A forked process would hold the lock of the folder, and whatever this one's threads hold.
        context = multiprocessing.get_context("spawn")
        self._pool = ProcessPoolExecutor(self.number, context, initializer=_follow_parent)
        return self

    def __exit__(self, *_: object) -> None:
        self._pool.shutdown(cancel_futures=True)

    def submit(self, work: Callable[..., Any], *args: Any) -> Future[Any]:
        """Have something done; processes that this starts leave interrupts to this one."""
        with _without_interrupts():
            return self._pool.submit(work, *args)


class Cluster(Workers):
    """A Dask cluster, whose workers see the same files.

    Parameters
    ----------
    address : str
        Of its scheduler.

    Raises
    ------
    VibroError
        If ``distributed`` is not installed.
    FileError
        On entering, if no scheduler answers there, or it has no workers.
    """

    def __init__(self, address: str) -> None:
        try:
            import distributed
        except ImportError:
            raise VibroError("--scheduler needs distributed: pip install 'vibro[distributed]'") from None
        self._library = distributed
        self.lost = (CancelledError, distributed.KilledWorker)
        self._log = logging.getLogger("distributed")
        self._level = self._log.level
        self._address = address
        self._asked = -math.inf
        self._known = 1

    def __enter__(self) -> Self:
        # It logs connections that are lost, which is told in other words.
        self._log.setLevel(logging.CRITICAL)
        try:
            self._client = self._library.Client(self._address, timeout=_CONNECTING, set_as_default=False)
        except (OSError, ValueError, TypeError) as exc:
            raise FileError(
                f"no scheduler answers at {self._address}: {exc}",
                hint="start one with dask scheduler, and give its address, such as tcp://host:8786",
            ) from exc
        try:
            self._client.wait_for_workers(1, timeout=_CONNECTING)
        except TimeoutError as exc:
            self._client.close()
            raise FileError(
                f"the scheduler at {self._address} has no workers",
                hint=f"start some with dask worker {self._address}, and the same vibro and files",
            ) from exc
        self._pool = self._client.get_executor(pure=False)
        return self

    def __exit__(self, *_: object) -> None:
        with contextlib.suppress(Exception):  # whatever a cluster that is gone says
            self._pool.shutdown(wait=False)
            self._client.close(timeout=_GRACE)
        self._log.setLevel(self._level)

    @property
    def number(self) -> int:  # type: ignore[override]
        """How many threads its workers have: some may come, and some go."""
        if time.monotonic() - self._asked > _KNOWN:
            self._known = max(1, sum(self._client.nthreads().values()))
            self._asked = time.monotonic()
        return self._known

    def submit(self, work: Callable[..., Any], *args: Any) -> Future[Any]:
        """Have something done."""
        future: Future[Any] = self._pool.submit(work, *args)
        return future


def workers_of(parts: int, processes: int | None, scheduler: str | None) -> Workers:
    """Return who makes so many parts: threads, where neither processes nor a scheduler are asked for."""
    if scheduler is not None:
        return Cluster(scheduler)
    return Threads(parts) if processes is None else Processes(processes)


@contextlib.contextmanager
def _without_interrupts() -> Iterator[None]:
    """Hold interrupts off; processes that are started meanwhile never get one."""
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _follow_parent() -> None:
    """Leave interrupts to the parent, and end with it, however it ends.

    A process of a pool waits for work at a pipe of which it has both ends: it would wait for ever.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        time.sleep(_GRACE)
        os._exit(1)
