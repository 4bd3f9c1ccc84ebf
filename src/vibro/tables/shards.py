"""The shards of a sweep, made by any executor; each has its name only when it is whole."""

from __future__ import annotations

import contextlib
import hashlib
import logging
import multiprocessing
import os
import pickle
import signal
import sys
import threading
import time
import zlib
from concurrent import futures
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, BinaryIO, Final, NamedTuple, Self

import numpy as np

from vibro.core.compiled import asking
from vibro.errors import FileError, VibroError, cut, how_to_install
from vibro.files.reading import opened
from vibro.interrupts import OnEnd
from vibro.quantities import BY_COLUMN
from vibro.results.sweep import Block
from vibro.sweeps.columns import arrow_table
from vibro.sweeps.tally import Tally
from vibro.tables.files import hidden_folder, remove_hidden
from vibro.tables.plan import made_by, sealed, shard_name, unsealed
from vibro.threads import BLOCK, cores

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

    import pyarrow as pa
    from pyarrow import parquet

    from vibro.tables.plan import Plan

_NOTICED: Final = 0.1  # [s] between looks for an interrupt, which an endless wait would ignore
_WAITING: Final = 2  # tasks for each worker: one at work, one that waits
_CONNECTING: Final = 12  # [s] to wait for a scheduler: one that is starting answers within that
# Dask's own words about connections that are lost: ours tell of them.
_LOGS: Final = ("distributed.client", "distributed.comm", "distributed.core", "distributed.utils")
_MAIN: Final = 'a script that asks for workers needs the line if __name__ == "__main__": before that'
_SAME_FILES: Final = "workers and the process that starts them need the same files under the same path"
_FOOTER: Final = b"vibro"  # key of the record in a footer
_WHOLE: Final = b"vibro sha256"  # key of the digest of the whole file, in whose place is a blank before
_BLANK: Final = b"0" * 64
_REASON: Final = 200  # characters of a library's message
_TAIL: Final = 8  # [B] of a Parquet file: the length of its footer, and what tells the format
#: A hint for whoever has lost a run.
GO_ON: Final = "run the same again: it goes on with what is there"


class Made(NamedTuple):
    """A whole shard: SHA-256 of its file and of its footer, its size [B], its cells; whether it is new.

    ``chunks`` are the ``chunk_sum`` of all columns of its first row group, of the second, and so on.
    """

    digest: str
    footer: str
    size: int
    chunks: str
    tally: Tally = Tally()
    is_new: bool = False


@dataclass(frozen=True)
class Progress:
    """Progress of a run: cells and shards that are there, cells solved by this run, size [B], time [s]."""

    cells: int
    shards: int
    solved: int
    size: int
    seconds: float


@dataclass
class Summary:
    """What is known of whole shards, by their numbers."""

    made: dict[int, Made] = field(default_factory=dict)
    tally: Tally = field(default_factory=Tally)

    @property
    def size(self) -> int:
        """Size of all shards [B]."""
        return sum(made.size for made in self.made.values())

    @property
    def digest(self) -> str:
        """SHA-256 of what ``sha256sum part-*.parquet`` prints."""
        lines = (f"{self.made[shard].digest}  {shard_name(shard)}\n" for shard in sorted(self.made))
        return hashlib.sha256("".join(lines).encode()).hexdigest()

    def success(self, plan: Plan) -> str:
        """Return the text of the file that says that all shards are whole."""
        files = {shard_name(shard): self.made[shard][:4] for shard in sorted(self.made)}
        sweep = {"fingerprint": plan.fingerprint, "cells": self.tally.status.total()}
        counts = {"shards": len(files), "bytes": self.size, "digest": self.digest}
        return sealed({**sweep, **counts, **self.tally.record(), "files": files})

    @classmethod
    def read(cls, text: bytes, plan: Plan) -> Self:
        """Read what ``success`` wrote.

        Raises
        ------
        Exception
            Of any kind, if it was changed since, or is of another sweep.
        """
        content = unsealed(text)
        tally, files = Tally.read(content), content["files"]
        names = [shard_name(shard) for shard in range(plan.shards)]
        if content["fingerprint"] != plan.fingerprint or list(files) != names:
            raise ValueError("it is of another sweep")
        return cls({shard: Made(*made) for shard, made in enumerate(files.values())}, tally)


def make_shard(
    plan: Plan,
    folder: Path,
    running: Path,
    shard: int,
    threads: int,
    tell: Callable[[int], None] = lambda cells: None,
) -> Made:
    """Make a shard, unless it is there.

    Parameters
    ----------
    plan : Plan
        The sweep.
    folder : Path
        Where the shard goes.
    running : Path
        A folder for unfinished files, which is there for as long as anybody waits for the shard.
    shard : int
        Which.
    threads : int
        How many may share the work.
    tell : callable, optional
        Called with the number of cells that have just been solved.

    Raises
    ------
    FileError, OSError
        If it cannot be made here, or nobody waits for it any more.
    """
    from pyarrow import parquet

    if made_by() != plan.content["made_by"]:
        here, there = (", ".join(map(" ".join, of.items())) for of in (made_by(), plan.content["made_by"]))
        problem = f"a worker has {here}; this sweep is made with {there}"
        raise FileError(problem, hint="install the same everywhere")
    if not running.is_dir():
        raise FileError(f"a worker finds no folder {running}", hint=_SAME_FILES)
    path = folder / shard_name(shard)
    if found := _found(plan, path, shard):
        return found
    (first, end), size = plan.range_of(shard), plan.row_group_cells
    tally, writer = Tally(), None
    waiting = running / path.name
    try:
        with waiting.open("wb") as stream:  # Arrow opens only names in UTF-8
            for start in range(first, end, size):
                block = _solved(plan, start, min(start + size, end), threads, running)
                tally.add(block)
                tell(block.cycle.status.size)
                cells = arrow_table(plan.table.columns, block)
                writer = writer or parquet.ParquetWriter(stream, cells.schema, **_encoding(cells.schema))
                writer.write_table(cells, size)
            assert writer is not None
            place = {"fingerprint": plan.fingerprint, "first_cell": first, "cells": end - first}
            writer.add_key_value_metadata({_FOOTER: sealed({**place, **tally.record()}), _WHOLE: _BLANK})
            writer.close()
    finally:
        if writer is not None:
            with contextlib.suppress(OSError, ValueError):  # of a full disk, once more; of a closed file
                writer.close()
    _sign(waiting)
    made = _made(waiting, tally, is_new=True)
    waiting.replace(path)
    return made


def _found(plan: Plan, path: Path, shard: int) -> Made | None:
    """Return a shard of this sweep that is there; a file of another one is an error."""
    from pyarrow import parquet

    first, end = plan.range_of(shard)
    try:
        with opened(path) as stream:
            metadata = parquet.read_metadata(stream)
        record = unsealed((metadata.metadata or {}).get(_FOOTER, b"{}"))
        kept = [metadata.num_rows, *(record[key] for key in ("fingerprint", "first_cell", "cells"))]
        if kept == [end - first, plan.fingerprint, first, end - first]:
            digest = metadata.metadata[_WHOLE]
            if hashlib.sha256(path.read_bytes().replace(digest, _BLANK)).hexdigest().encode() != digest:
                raise ValueError("it is not what was written")
            return _made(path, Tally.read(record))
    except FileNotFoundError:
        return None
    except MemoryError:
        raise
    except Exception as exc:  # whatever changed bytes may lead to
        raise damaged(path, str(exc)) from exc
    raise FileError(f"{path} belongs to another sweep", hint="remove it, or choose another folder")


def damaged(path: Path, why: str) -> FileError:
    """Return the error for a file of a folder that is not what was written."""
    return FileError(f"{path} is damaged: {cut(why, _REASON)}", hint=f"remove it; {GO_ON}")


def _made(path: Path, tally: Tally, *, is_new: bool = False) -> Made:
    from pyarrow import parquet

    with path.open("rb") as stream:
        digest = hashlib.file_digest(stream, "sha256").hexdigest()
        metadata = parquet.read_metadata(stream)
        places = np.ndindex(metadata.num_row_groups, metadata.num_columns)
        sums = " ".join(chunk_sum(stream, metadata, *place) for place in places)
        return Made(digest, footer_digest(stream), stream.seek(0, os.SEEK_END), sums, tally, is_new)


def _sign(path: Path) -> None:
    """Write into a shard's footer the SHA-256 that its file has with the blank there."""
    whole = path.read_bytes()
    with path.open("r+b") as stream:
        stream.seek(whole.rindex(_BLANK))
        stream.write(hashlib.sha256(whole).hexdigest().encode())


def footer_digest(stream: BinaryIO) -> str:
    """Return the SHA-256 of the end of a Parquet file, which says where its pages are and what they mean."""
    size = stream.seek(0, os.SEEK_END)
    stream.seek(max(0, size - _TAIL))
    length = int.from_bytes(stream.read(_TAIL)[:4], "little")  # of what stands before it
    stream.seek(max(0, size - _TAIL - length))
    return hashlib.sha256(stream.read()).hexdigest()


def chunk_sum(stream: BinaryIO, metadata: parquet.FileMetaData, group: int, column: int) -> str:
    """Return the CRC32 of a column in a row group, in hexadecimal digits.

    The checksums of pages leave out their headers: with another number of values there, Arrow takes a row
    group's last cells from the next one.
    """
    chunk = metadata.row_group(group).column(column)
    stream.seek(chunk.dictionary_page_offset or chunk.data_page_offset)
    return f"{zlib.crc32(stream.read(chunk.total_compressed_size)):x}"


def _solved(plan: Plan, start: int, stop: int, threads: int, running: Path) -> Block:
    """Solve some cells in a row, for as long as anybody waits for them."""

    def look(*_: int) -> None:
        running.stat()

    try:
        with asking(look):
            values, cycle = plan.grid.solve_cells(start, stop, threads, look)
        return Block(values, cycle, plan.grid.length)
    except (OSError, MemoryError):
        raise
    except Exception as exc:
        raise VibroError(f"cells {start} to {stop - 1}: {type(exc).__name__}: {exc}") from exc


def _encoding(schema: pa.Schema) -> dict[str, Any]:
    import pyarrow as pa

    numbers = [item.name for item in schema if pa.types.is_floating(item.type)]
    return {
        "compression": "lz4",
        "use_dictionary": [item.name for item in schema if item.name not in numbers] or False,
        # Values of inputs repeat: splitting their bytes takes longer and saves no space.
        "use_byte_stream_split": [name for name in numbers if name not in BY_COLUMN] or False,
        # Statistics of the inputs alone select row groups: results follow no order.
        "write_statistics": [name for name in schema.names if name in BY_COLUMN] or False,
        "write_page_checksum": True,
        "write_batch_size": BLOCK,  # of the usual 1024 cells each costs more than what is in it
    }


@dataclass(frozen=True)
class _Call:
    """A call that is made as it is read: a worker of Dask that could not read a task would end silently."""

    call: tuple[Any, ...]

    def __reduce__(self) -> tuple[Callable[..., Any], tuple[Any, ...]]:
        return self.call[0], self.call[1:]


def make_shards(
    plan: Plan,
    folder: Path,
    workers: int | str | None,
    report: Callable[[Progress], None] = lambda progress: None,
) -> Summary:
    """Make the shards that are missing.

    Parameters
    ----------
    plan : Plan
        The sweep.
    folder : Path
        Where they go, absolute.
    workers : int or str, optional
        Number of processes, or the address of a Dask scheduler; without, threads of this process.
    report : callable
        Called with the progress several times a second.

    Raises
    ------
    FileError, OSError
        If a shard cannot be made; whole ones remain.
    """
    summary, began = Summary(), time.monotonic()
    solved: list[int] = []  # numbers of cells, by the threads of this process or as shards are ready
    with (
        OnEnd(lambda: GO_ON),
        hidden_folder(folder) as running,  # without it nobody can begin a file, or go on for long
        _executor(workers, plan.shards) as (pool, number, threads),
    ):
        left: Iterator[int] = iter(range(plan.shards))
        tasks: dict[futures.Future[Made], int] = {}
        tell = (solved.append,) if workers is None else ()
        try:
            while True:
                while len(tasks) < _WAITING * number and (shard := next(left, None)) is not None:
                    call: tuple[Any, ...] = (make_shard, plan, folder, running, shard, threads, *tell)
                    if isinstance(workers, str):
                        call = pickle.loads, pickle.dumps(_Call(call))
                    tasks[pool.submit(*call)] = shard
                if not tasks:
                    return summary
                for future in futures.wait(tasks, _NOTICED, futures.FIRST_COMPLETED).done:
                    shard, made = tasks.pop(future), future.result()
                    summary.made[shard] = made
                    summary.tally.include([made.tally])
                    if made.is_new and not tell:
                        solved.append(made.tally.status.total())
                old = sum(made.tally.status.total() for made in summary.made.values() if not made.is_new)
                new, seconds = sum(solved), time.monotonic() - began
                report(Progress(old + new, len(summary.made), new, summary.size, seconds))
        except futures.BrokenExecutor as exc:
            raise FileError(f"a worker has ended: {cut(str(exc))}", hint=f"{_MAIN}; {GO_ON}") from exc
        finally:
            remove_hidden(running)  # so that workers end what they are at
            for future in tasks:
                future.cancel()
            pool.shutdown(wait=False)


@contextlib.contextmanager
def _executor(workers: int | str | None, shards: int) -> Iterator[tuple[futures.Executor, int, int]]:
    """Have an executor, the number of its workers, and that of threads for each."""
    if isinstance(workers, str):
        with _cluster(workers) as (pool, number):
            yield pool, number, 1
    elif workers is None:
        number = max(1, min(cores(), shards))
        with futures.ThreadPoolExecutor(number) as threads:
            yield threads, number, max(1, cores() // number)
    else:
        context = multiprocessing.get_context("spawn")  # a fork would inherit locks that other threads hold
        with _starting():  # the process that tracks the pool's locks
            pool = _Processes(workers, context, _begin_worker)
        with pool as processes:
            yield processes, workers, max(1, cores() // workers)


@contextlib.contextmanager
def _cluster(address: str) -> Iterator[tuple[futures.Executor, int]]:
    """Have the workers of a Dask cluster."""
    try:
        import distributed
    except ImportError:
        hint = how_to_install("distributed")
        raise FileError(f"{address} needs the library distributed", hint=hint) from None
    for name in _LOGS:
        logging.getLogger(name).setLevel(logging.CRITICAL)
    opened: futures.Future[Any] = futures.Future()
    # In a thread: a client waits without end for the first words of whoever accepts its connection
    # (github.com/dask/distributed/issues/8071).
    threading.Thread(target=_open_client, args=(distributed.Client, address, opened), daemon=True).start()
    try:
        client = opened.result(1.3 * _CONNECTING)
    except Exception as exc:
        hint = "start one with dask scheduler, and give the address that it prints, such as tcp://host:8786"
        reason = cut(str(exc)) or "it says nothing"
        raise FileError(f"no Dask scheduler answers at {address}: {reason}", hint=hint) from exc
    with client:
        try:
            with client.get_executor() as pool:
                yield pool, max(1, sum(client.nthreads().values()))
        except (ImportError, AttributeError) as exc:  # it could not read the task
            raise FileError(f"a worker of {address} has another vibro, or none: {cut(str(exc))}") from exc
        except futures.CancelledError as exc:
            raise FileError(f"the scheduler at {address} is lost", hint=GO_ON) from exc
        except (TimeoutError, distributed.KilledWorker, distributed.core.CommClosedError) as exc:
            raise FileError(f"workers of {address} are lost: {cut(str(exc))}", hint=GO_ON) from exc


def _open_client(kind: Callable[..., Any], address: str, opened: futures.Future[Any]) -> None:
    try:
        opened.set_result(kind(address, timeout=_CONNECTING, set_as_default=False))
    except Exception as exc:
        opened.set_exception(exc)


class _Processes(futures.ProcessPoolExecutor):
    """Processes, of which some are started when a task is submitted."""

    def submit(self, *call: Any, **named: Any) -> futures.Future[Any]:
        """Submit a task."""
        with _starting():
            return super().submit(*call, **named)


@contextlib.contextmanager
def _starting() -> Iterator[None]:
    """Keep the current folder off the path of processes that are started meanwhile, and interrupts from them.

    Python starts them with ``python -c``, which imports from the current folder first: beside a file
    ``signal.py`` they would fail (github.com/python/cpython/issues/157916). An interrupt of the terminal goes
    to all processes; the parent ends the others, and another process removes the locks that they leave.
    """
    path, can_block = os.environ.get("PYTHONSAFEPATH"), hasattr(signal, "pthread_sigmask")
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT}) if can_block else set()
    os.environ["PYTHONSAFEPATH"] = "1"
    sys.warnoptions.append("ignore:resource_tracker")
    try:
        yield
    finally:
        sys.warnoptions.remove("ignore:resource_tracker")
        del os.environ["PYTHONSAFEPATH"]
        if path is not None:
            os.environ["PYTHONSAFEPATH"] = path
        if can_block:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _begin_worker() -> None:
    """Leave interrupts to the parent, and end when it ends, even if it is killed.

    A process of a pool waits for work at a pipe of which it has both ends: it would wait for ever.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
