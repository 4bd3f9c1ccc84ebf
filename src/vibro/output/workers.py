"""Workers for the parts of a sweep: threads of this process, other processes, or a Dask cluster."""

from __future__ import annotations

import contextlib
import logging
import math
import multiprocessing
import os
import pickle
import signal
import sys
import threading
import time
from abc import ABC, abstractmethod
from concurrent.futures import BrokenExecutor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import resource_tracker
from typing import TYPE_CHECKING, Any, Final, Self

from vibro.errors import FileError, VibroError
from vibro.memory import retain_freed_memory
from vibro.parallel import cores

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

__all__ = ["Cluster", "Processes", "Threads", "Workers", "workers_of"]

_CLOSING: Final = 2.0  # [s] after which a cluster that does not answer is left alone
_KNOWN: Final = 5.0  # [s] between counts of the workers
_CONNECTING: Final = 15.0  # [s] to wait for a scheduler, or for the first of its workers
# Loggers of distributed that set levels of their own.
_LOGS: Final = ("distributed", "distributed.client", "tornado.application")


class Workers(ABC):
    """Workers that make parts; a context manager.

    Attributes
    ----------
    threads : int
        Threads that each worker may use.
    number : int
        Number of parts made at once.
    """

    threads: int = 1
    number: int = 1

    @abstractmethod
    def __enter__(self) -> Self:
        """Start the workers; also after an end."""

    @abstractmethod
    def __exit__(self, *_: object) -> None:
        """End the workers; tasks that have not begun are dropped."""

    @abstractmethod
    def submit(self, work: Callable[..., Any], *args: Any) -> Future[Any]:
        """Submit a task.

        Raises
        ------
        BrokenExecutor
            Here or by the future, if the worker was lost: another one may do the task.
        """

    def check(self) -> None:  # noqa: B027
        """Look whether anybody is left who could do the work."""


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
    """Processes of this machine, which share its cores, and end with this one.

    Parameters
    ----------
    number : int
        How many.
    """

    def __init__(self, number: int) -> None:
        self.number = number
        self.threads = max(1, cores() // number)

    def __enter__(self) -> Self:
        _start_tracker()
        # A forked process would inherit the lock of the folder, and locks held by other threads.
        context = multiprocessing.get_context("spawn")
        self._pool = ProcessPoolExecutor(self.number, context, initializer=_begin_worker)
        return self

    def __exit__(self, *_: object) -> None:
        self._pool.shutdown(cancel_futures=True)

    def submit(self, work: Callable[..., Any], *args: Any) -> Future[Any]:
        """Submit a task; processes that this starts leave interrupts to this one."""
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
    FileError
        If ``distributed`` is not installed; on entering, if no scheduler answers there, or it has no workers.
    """

    def __init__(self, address: str) -> None:
        try:
            import distributed
        except ImportError:
            hint = "pip install 'vibro[distributed]'"
            raise FileError("--scheduler needs distributed", hint=hint) from None
        self._library = distributed
        self._levels: dict[str, int] = {}
        self._address = address
        self._counted = -math.inf

    def __enter__(self) -> Self:
        # It logs lost connections; our own messages report them.
        for name in _LOGS:
            self._levels[name] = logging.getLogger(name).level
            logging.getLogger(name).setLevel(logging.CRITICAL)
        try:
            self._connect()
        except BaseException:
            self._restore_logs()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        with contextlib.suppress(Exception):  # the cluster may be gone
            self._client.close(timeout=_CLOSING)
        self._restore_logs()

    def submit(self, work: Callable[..., Any], *args: Any) -> Future[Any]:
        """Have something done."""
        # A worker without vibro cannot unpickle a task, and ends silently: send it bytes to unpickle.
        call = pickle.dumps(_Call(work, args))
        # The library's own executor leaves a future open for ever if the scheduler ends at a bad moment.
        future: Future[Any] = Future()
        try:
            task = self._client.submit(pickle.loads, call, pure=False)
            self._client.loop.add_callback(self._hand_on, task, future)
        except Exception as exc:
            raise BrokenExecutor(str(exc)) from exc
        return future

    def _connect(self) -> None:
        try:
            self._client = self._library.Client(self._address, timeout=_CONNECTING, set_as_default=False)
        except (OSError, ValueError, TypeError) as exc:
            raise FileError(
                f"no scheduler answers at {self._address}: {exc}",
                hint="start one with dask scheduler, and give its address, such as tcp://host:8786;"
                " --resume goes on with what is there",
            ) from exc
        try:
            self._client.wait_for_workers(1, timeout=_CONNECTING)
            self._client.sync(self._count)
        except OSError as exc:  # a TimeoutError is one
            self._client.close(timeout=_CLOSING)
            raise FileError(
                f"the scheduler at {self._address} has no workers",
                hint=f"start some with dask worker {self._address}, and the same vibro and files",
            ) from exc

    async def _hand_on(self, task: Any, future: Future[Any]) -> None:
        """Wait for a task of the cluster, and hand on how it ended."""
        try:
            result = await task
        except (ImportError, AttributeError) as exc:  # it could not unpickle the task
            message = f"a worker of {self._address} has another vibro, or none: {exc}"
            future.set_exception(VibroError(message))
        except BaseException as exc:
            by_task = task.status == "error" and not isinstance(exc, self._library.KilledWorker)
            future.set_exception(exc if by_task else BrokenExecutor(str(exc)))
        else:
            future.set_result(result)
            with contextlib.suppress(Exception):  # if the cluster is gone, its tasks fail
                await self._count()

    async def _count(self) -> None:
        """Count the threads of the workers now and then: workers may join or leave."""
        if time.monotonic() - self._counted > _KNOWN:
            self._counted = time.monotonic()
            self.number = max(1, sum((await self._client.nthreads()).values()))

    def _restore_logs(self) -> None:
        for name, level in self._levels.items():
            logging.getLogger(name).setLevel(level)


def workers_of(
    parts: int, processes: int | None, scheduler: str | None, tell: Callable[[str], None] = print
) -> Workers:
    """Return workers for so many parts: threads unless processes or a scheduler are asked for."""
    if scheduler is not None:
        return Cluster(scheduler)
    return Threads(parts) if processes is None else Processes(processes)


class _Call:
    """A call whose pickle, when it is read, is what the call returns."""

    def __init__(self, work: Callable[..., Any], args: tuple[Any, ...]) -> None:
        self._said = work, args

    def __reduce__(self) -> tuple[Callable[..., Any], tuple[Any, ...]]:
        return self._said


@contextlib.contextmanager
def _without_interrupts() -> Iterator[None]:
    """Block signals of the terminal; processes that are started meanwhile never receive them."""
    if sys.platform == "win32":
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGHUP})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _start_tracker() -> None:
    """Start the process that removes the locks of a killed pool, and silence its warning."""
    if sys.platform == "win32":  # Windows: the system removes them
        return
    sys.warnoptions.append("ignore:resource_tracker")
    try:
        with _without_interrupts():
            resource_tracker.ensure_running()
    finally:
        sys.warnoptions.remove("ignore:resource_tracker")


def _begin_worker() -> None:
    """Keep freed memory; leave interrupts to the parent, and end when it ends, even if it is killed.

    A process of a pool waits for work at a pipe of which it has both ends: it would wait for ever.
    """
    retain_freed_memory()
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
