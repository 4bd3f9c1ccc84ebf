"""Workers for the shards of a sweep: threads of this process, other processes, or a Dask cluster."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import multiprocessing
import os
import pickle
import signal
import sys
import threading
from abc import ABC, abstractmethod
from concurrent.futures import BrokenExecutor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import resource_tracker
from typing import TYPE_CHECKING, Any, Final, Self, cast

from vibro.errors import FileError, VibroError, how_to_install
from vibro.parallel import cores

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

__all__ = ["Cluster", "Processes", "Threads", "Workers", "workers_of"]

# [s] to wait for a scheduler: one that is starting answers within that.
_CONNECTING: Final = 12.0
# [s] without any worker after which a run ends: a worker that is restarted is there again in some 10 s.
_ALONE: Final = 60.0
_LOOK: Final = 5.0  # [s] between looks at the workers, and for the answer to one
_CLOSING: Final = 2.0  # [s] after which a cluster that does not answer is left alone
# Loggers of distributed that set levels of their own.
_LOGS: Final = ("distributed", "distributed.client", "tornado.application")


class Workers(ABC):
    """Workers that make shards; a context manager, which may be entered again after its end.

    Attributes
    ----------
    threads : int
        Threads that each task may use.
    number : int
        Number of tasks at work at once; that of a cluster changes while it runs.
    """

    threads: int = 1
    number: int = 1

    @abstractmethod
    def __enter__(self) -> Self:
        """Start the workers."""

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
        """Check that there are workers; called several times a second while somebody waits for a task.

        Raises
        ------
        FileError
            If nobody is left who could do a task.
        """


class Threads(Workers):
    """Threads of this process, at most one per core.

    Parameters
    ----------
    number : int
        How many are of use.
    """

    def __init__(self, number: int) -> None:
        self.number = max(1, min(cores(), number))
        self.threads = max(1, cores() // self.number)

    def __enter__(self) -> Self:
        self._pool = ThreadPoolExecutor(self.number, "shard")
        return self

    def __exit__(self, *_: object) -> None:
        self._pool.shutdown(cancel_futures=True)

    def submit(self, work: Callable[..., Any], *args: Any) -> Future[Any]:
        """Submit a task."""
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
        """Submit a task, which starts a process while there are fewer than wanted."""
        with _safe_path(), _without_signals():
            return self._pool.submit(work, *args)


class Cluster(Workers):
    """A Dask cluster, whose workers see the same files.

    Parameters
    ----------
    address : str
        Of its scheduler.
    tell : callable, optional
        Called by ``check`` with a sentence for the user when there is no worker, and how long that may last.

    Raises
    ------
    FileError
        If ``distributed`` is not installed; on entering, if no scheduler answers at the address.
    """

    def __init__(self, address: str, tell: Callable[[str], object] | None = None) -> None:
        try:
            import distributed
        except ImportError:
            problem = f'scheduler="{address}" needs the library distributed'
            raise FileError(problem, hint=how_to_install("distributed")) from None
        self._library = distributed
        self._address = address
        self._tell = tell or (lambda sentence: None)
        self._levels: dict[str, int] = {}

    def __enter__(self) -> Self:
        # It logs lost connections; our own messages report them.
        for name in _LOGS:
            self._levels.setdefault(name, logging.getLogger(name).level)
            logging.getLogger(name).setLevel(logging.CRITICAL)
        self._stop: Callable[[], object] = lambda: None
        self._absent, self._fault, self._told = 0.0, "", False
        opened: Future[None] = Future()
        # A client in an event loop of our own ends with it, in any state. One that Dask runs in a
        # thread leaves that thread behind, and a traceback at the end of the program, if it cannot connect.
        self._thread = threading.Thread(target=self._run, args=(opened,), daemon=True)
        self._thread.start()
        try:
            opened.result()
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        with contextlib.suppress(RuntimeError):  # its loop has ended
            self._stop()
        self._thread.join(_CLOSING)
        if not self._thread.is_alive():
            while self._levels:
                name, level = self._levels.popitem()
                logging.getLogger(name).setLevel(level)

    def submit(self, work: Callable[..., Any], *args: Any) -> Future[Any]:
        """Submit a task."""
        # A worker without vibro cannot unpickle a task, and ends silently: send it bytes to unpickle.
        return asyncio.run_coroutine_threadsafe(self._do(pickle.dumps(_Call(work, args))), self._loop)

    def check(self) -> None:
        """Check that there are workers; report once if there are none.

        Raises
        ------
        FileError
            If there has been none for a minute.
        """
        if self._absent >= _ALONE:
            raise FileError(
                f"the scheduler at {self._address} {self._fault}, for {_ALONE:.0f} s now",
                hint=f"start workers with dask worker {self._address}, and the same vibro and files;"
                " resume=True goes on with what is there",
            )
        if self._absent and not self._told:
            self._told = True
            self._tell(f"the scheduler at {self._address} {self._fault}: waiting for {_ALONE:.0f} s")

    def _run(self, opened: Future[None]) -> None:
        with contextlib.suppress(asyncio.CancelledError):
            asyncio.run(self._serve(opened))

    async def _serve(self, opened: Future[None]) -> None:
        """Be a client of the cluster until ``_stop`` is called."""
        self._loop = asyncio.get_running_loop()
        task = asyncio.current_task()
        assert task is not None
        self._stop = lambda: self._loop.call_soon_threadsafe(task.cancel)
        try:
            await self._find_scheduler()
            self._client = await self._library.Client(
                self._address, timeout=_CONNECTING, asynchronous=True, set_as_default=False
            )
        except FileError as exc:
            opened.set_exception(exc)
        except Exception as exc:
            opened.set_exception(self._unreachable(exc))
        else:
            async with self._client:
                await self._look()
                opened.set_result(None)
                while True:
                    await asyncio.sleep(_LOOK)
                    await self._look()

    async def _find_scheduler(self) -> None:
        """Check that a scheduler is at the address."""
        arguments = self._library.Security().get_connection_args("client")
        if self._address.startswith("tls:") and arguments.get("ssl_context") is None:
            raise FileError(
                f"{self._address} needs certificates, and Dask's configuration names none",
                hint="set distributed.comm.tls.ca-file, client.cert and client.key there",
            )
        # A client waits without end for the first words of whoever accepts its connection
        # (github.com/dask/distributed/issues/8071).
        async with (
            asyncio.timeout(1.2 * _CONNECTING),
            self._library.rpc(self._address, timeout=_CONNECTING, connection_args=arguments) as there,
        ):
            kind = (await there.identity())["type"]
        if kind != "Scheduler":
            raise ValueError(f"it is a {kind}'s address")

    def _unreachable(self, exc: Exception) -> FileError:
        reason, cause = "no reason is given", cast("BaseException | None", exc)
        while cause is not None:
            reason, cause = str(cause) or reason, cause.__cause__
        return FileError(
            f"no Dask scheduler answers at {self._address}: {reason}",
            hint="start one with dask scheduler, and give the address that it prints, not its dashboard's:"
            ' scheduler="tcp://host:8786"; resume=True goes on with what is there',
        )

    async def _look(self) -> None:
        """Count the threads of the workers, which may join or leave, or note for how long there is none."""
        try:
            threads = sum((await asyncio.wait_for(self._client.nthreads(), _LOOK)).values())
            fault = "has no workers"
        except Exception:
            threads, fault = 0, "does not answer"
        if threads:
            self.number, self._absent, self._told = threads, 0.0, False
        else:  # not by the clock, which goes on while this process is stopped
            self._fault, self._absent = fault, self._absent + _LOOK

    async def _do(self, call: bytes) -> Any:
        """Let a worker do a task, and return the result."""
        task = None
        try:
            task = self._client.submit(pickle.loads, call, pure=False)
            return await task
        except (ImportError, AttributeError) as exc:  # it could not unpickle the task
            raise VibroError(
                f"a worker of {self._address} has another version of vibro, or none: {exc}"
            ) from exc
        except BaseException as exc:  # that a task is cancelled because its scheduler is lost is no Exception
            if task and task.status == "error" and not isinstance(exc, self._library.KilledWorker):
                raise
            raise BrokenExecutor(str(exc)) from exc


def workers_of(
    shards: int,
    processes: int | None,
    scheduler: str | None,
    tell: Callable[[str], object] | None = None,
) -> Workers:
    """Return workers for so many shards: threads unless processes or a scheduler are requested."""
    if scheduler is not None:
        return Cluster(scheduler, tell)
    return Threads(shards) if processes is None else Processes(processes)


class _Call:
    """A call whose pickle, when it is read, is what the call returns."""

    def __init__(self, work: Callable[..., Any], args: tuple[Any, ...]) -> None:
        self._said = work, args

    def __reduce__(self) -> tuple[Callable[..., Any], tuple[Any, ...]]:
        return self._said


@contextlib.contextmanager
def _safe_path() -> Iterator[None]:
    """Keep the current folder off the path of processes that are started meanwhile.

    Python starts them with ``python -c``, which imports from the current folder first: beside a file
    ``signal.py`` they would fail, and a folder that was downloaded would have its ``subprocess.py`` run
    (github.com/python/cpython/issues/157916). They then take over the path of this process as it is.
    """
    before = os.environ.get("PYTHONSAFEPATH")
    os.environ["PYTHONSAFEPATH"] = "1"
    try:
        yield
    finally:
        if before is None:
            del os.environ["PYTHONSAFEPATH"]
        else:
            os.environ["PYTHONSAFEPATH"] = before


@contextlib.contextmanager
def _without_signals() -> Iterator[None]:
    """Block signals that end a run until processes that are started meanwhile can end with this one.

    The threads of a pool, which start with the first of them, never receive signals, nor do the processes
    those of the terminal.
    """
    if sys.platform == "win32":
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGHUP, signal.SIGTERM})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _start_tracker() -> None:
    """Start the process that removes the locks of a killed pool, and silence its warning.

    It is started before the others, as Python unblocks signals after that.
    """
    if sys.platform == "win32":  # Windows: the system removes them
        return
    sys.warnoptions.append("ignore:resource_tracker")
    try:
        with _safe_path(), _without_signals():
            resource_tracker.ensure_running()
    finally:
        sys.warnoptions.remove("ignore:resource_tracker")


def _begin_worker() -> None:
    """Leave interrupts to the parent, and end when it ends, even if it is killed.

    A process of a pool waits for work at a pipe of which it has both ends: it would wait for ever.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if sys.platform != "win32":  # a pool ends its processes by this one
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGTERM})
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
