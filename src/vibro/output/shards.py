"""Sweeps in shards: cut, checked, resumed, and made by workers, wherever these are."""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import time
from collections import deque
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, wait
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Final

from vibro.errors import FileError
from vibro.output.parquet import HashedFile, Parquet, read_footer
from vibro.output.plan import ROW_GROUP, Plan, versions
from vibro.output.shard_folder import SUCCESS, ShardFolder, Stamp, shard_name, sync_file
from vibro.results.sweep import Block
from vibro.sweeps.tally import Tally

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from concurrent.futures import Future

    from vibro.output.workers import Workers
    from vibro.sweeps.grid import Grid

__all__ = [
    "Job", "Made", "Progress", "Summary", "check_job", "check_shard", "check_workers", "make_shard",
    "make_shards", "place_of",
]  # fmt: skip

_WINDOW: Final = 2  # tasks for each worker: one at work, one that waits
_LOSSES: Final = 3  # lost workers in a row, without a finished shard in between, that end the run
_NOTICED: Final = 0.1  # [s] between looks for an interrupt, which an endless wait would ignore
_KILLED: Final = (
    'a script that asks for workers needs the line if __name__ == "__main__": before that; else they are'
    " killed, or short of memory"
)
_SAME_FILES: Final = "workers and the process that starts them need the same files under the same path"


@dataclass(frozen=True)
class Job:
    """What workers need to know: the sweep, where they write, and how many threads each may use."""

    plan: Plan
    hidden: Path
    threads: int

    def look(self, *_: int) -> None:
        """Raise FileNotFoundError if the run has ended, and its hidden folder with it."""
        self.hidden.stat()


@dataclass(frozen=True)
class Made:
    """A whole shard: the name of its file, its SHA-256, its size [B] and its cells."""

    shard: int
    name: str
    digest: str
    size: int
    tally: Tally


def check_job(job: Job) -> None:
    """Refuse to work with other versions than the plan's, or where the folder is not seen.

    Raises
    ------
    FileError
        It names the versions, or the folder.
    """
    here, wanted = versions(), job.plan.content["versions"]
    if here != wanted:
        said = [", ".join(f"{k} {v}" for k, v in which.items()) for which in (here, wanted)]
        raise FileError(
            f"a worker has {said[0]}; this sweep is made with {said[1]}", hint="install the same everywhere"
        )
    if not job.hidden.parent.parent.is_dir():
        raise FileError(f"a worker finds no folder {job.hidden.parent.parent}", hint=_SAME_FILES)


def check_workers(workers: Workers, job: Job) -> None:
    """Have a worker check versions and folder, before anything is changed.

    Raises
    ------
    FileError
        If it cannot work, or there is none.
    """
    try:
        future = workers.submit(check_job, job)
        while not wait([future], _NOTICED).done:
            workers.check()
        future.result()
    except BrokenExecutor as exc:
        raise FileError("workers end as soon as they begin", hint=_KILLED) from exc


def make_shard(job: Job, shard: int) -> Made | None:
    """Solve the cells of a shard, and write them to a hidden file; None if the run has ended.

    Raises
    ------
    VibroError, OSError
        If it cannot be made here.
    """
    check_job(job)
    grid = job.plan.grid
    first, end = job.plan.range_of(shard)
    tally = Tally()
    path = job.hidden / f"{shard_name(shard)}-{os.urandom(8).hex()}"
    form = Parquet()
    try:
        with path.open("xb") as file, contextlib.closing(form):
            sink = HashedFile(file)
            form.open(sink, grid, job.plan.table)
            for start in range(first, end, ROW_GROUP):
                stop = min(start + ROW_GROUP, end)
                block = _block(grid, start, stop, job)
                tally.add(block)
                form.write(block)
            form.close({**place_of(job.plan, shard), **tally.told()})
            file.flush()
            sync_file(file.fileno())
    except FileNotFoundError:
        return None
    return Made(shard, path.name, sink.digest, sink.size, tally)


def _block(grid: Grid, start: int, stop: int, job: Job) -> Block:
    """Solve some cells in a row; operating points of a machine are found once."""
    if grid.machine is not None:
        values = grid.cells(start, stop)
        return Block(values, grid.solve(values, job.threads, job.look), grid.length)
    return Block(grid.cells(start, stop), grid.solve_cells(start, stop, job.threads, job.look), grid.length)


def check_shard(job: Job, shard: int) -> Made | None:
    """Check a shard that is there: None unless its bytes are those that its cells give, and of this sweep."""
    from pyarrow import ArrowException, parquet

    path = job.hidden.parent.parent / shard_name(shard)
    first, end = job.plan.range_of(shard)
    try:
        with path.open("rb") as stream:
            digest = hashlib.file_digest(stream, "sha256").hexdigest()
            stream.seek(0)
            with (
                parquet.ParquetFile(stream, page_checksum_verification=True) as file,
                Path(os.devnull).open("wb") as nowhere,
                contextlib.closing(Parquet()) as form,
            ):
                again = HashedFile(nowhere)
                form.open(again, job.plan.grid, job.plan.table)
                tally = Tally.read(read_footer(file.metadata))
                for group in range(file.num_row_groups):
                    form.copy(file.read_row_group(group))
                form.close({**place_of(job.plan, shard), **tally.told()})
    except (ArrowException, ArithmeticError, AttributeError, LookupError, OSError, TypeError, ValueError):
        return None
    if again.digest != digest or not tally.status.total() == tally.regime.total() == end - first:
        return None
    return Made(shard, path.name, digest, again.size, tally)


def place_of(plan: Plan, shard: int) -> dict[str, str | int]:
    """Return what the footer of a shard says: its sweep, and its cells."""
    first, end = plan.range_of(shard)
    return {"fingerprint": plan.fingerprint, "first_cell": first, "cells": end - first}


@dataclass(frozen=True)
class Progress:
    """Progress of a run.

    Attributes
    ----------
    solved : int
        Cells that this run has solved.
    cells, all_cells : int
        Cells of finished shards, and of all requested ones.
    shards, all_shards : int
        Number of finished shards, and of all requested ones.
    size : int
        Size of the finished shards [B].
    seconds : float
        Since the run began.
    """

    solved: int
    cells: int
    all_cells: int
    shards: int
    all_shards: int
    size: int
    seconds: float


@dataclass
class Summary:
    """What is known of finished shards, by their numbers: sizes [B], SHA-256, stamps; and counts of cells."""

    sizes: dict[int, int] = field(default_factory=dict)
    digests: dict[int, str] = field(default_factory=dict)
    stamps: dict[int, Stamp] = field(default_factory=dict)
    tally: Tally = field(default_factory=Tally)

    @property
    def size(self) -> int:
        """Size of all shards [B]."""
        return sum(self.sizes.values())

    @property
    def digest(self) -> str:
        """SHA-256 of what ``sha256sum part-*.parquet`` prints."""
        lines = (f"{self.digests[shard]}  {shard_name(shard)}\n" for shard in sorted(self.digests))
        return hashlib.sha256("".join(lines).encode()).hexdigest()

    def finish(self, folder: ShardFolder, manifest: str) -> None:
        """Write the last file, if all shards are still as they were made."""
        content = {
            "cells": self.tally.status.total(),
            "shards": len(self.sizes),
            "bytes": self.size,
            "digest": self.digest,
            **self.tally.told(),
        }
        stamps = {shard_name(shard): stamp for shard, stamp in self.stamps.items()}
        digests = {shard_name(shard): digest for shard, digest in self.digests.items()}
        folder.finish(json.dumps(content, indent=1) + "\n", manifest, stamps, digests)


def make_shards(
    plan: Plan,
    folder: ShardFolder,
    workers: Workers,
    shards: Sequence[int],
    report: Callable[[Progress], None] = lambda progress: None,
) -> Summary:
    """Make the shards that are missing, and check those that are there.

    Parameters
    ----------
    plan : Plan
        The sweep.
    folder : ShardFolder
        Entered; its manifest is written.
    workers : Workers
        Entered.
    shards : sequence of int
        Which.
    report : callable
        Called with the progress several times a second.

    Raises
    ------
    FileError, VibroError, OSError
        If a shard cannot be made; finished ones remain.
    """
    try:
        return _Run(plan, folder, workers, shards, report).finish()
    except BaseException:
        folder.stop()  # before workers are waited for: they end once they see it
        raise


class _Run:
    """The shards that are being made."""

    def __init__(
        self,
        plan: Plan,
        folder: ShardFolder,
        workers: Workers,
        shards: Sequence[int],
        report: Callable[[Progress], None],
    ) -> None:
        self._plan, self._folder, self._workers, self._report = plan, folder, workers, report
        self._job = Job(plan, folder.hidden, workers.threads)
        self._number = len(shards)
        self._rest = deque(shards)
        self._there = folder.shards()
        self._running: dict[Future[Made | None], tuple[int, Stamp | None]] = {}
        self._summary = Summary()
        self._all_cells = sum(end - first for first, end in map(plan.range_of, shards))
        self._solved = self._cells = 0
        self._began = time.monotonic()
        self._losses = 0

    def finish(self) -> Summary:
        """Work until all shards exist."""
        while self._rest or self._running:
            try:
                while self._rest and len(self._running) < _WINDOW * self._workers.number:
                    self._submit(self._rest[0])
                    self._rest.popleft()
                done, _ = wait(self._running, _NOTICED, FIRST_COMPLETED)
                self._workers.check()
                for future in done:
                    self._take(future)
            except BrokenExecutor as exc:
                self._renew(exc)
            self._tell()
        return self._summary

    def _submit(self, shard: int) -> None:
        name = shard_name(shard)
        stamp = None
        if name in self._there:
            with contextlib.suppress(FileNotFoundError):
                stamp = Stamp.of(self._folder.folder / name)
        if stamp is None:
            self._folder.remove(SUCCESS)
        work = make_shard if stamp is None else check_shard
        self._running[self._workers.submit(work, self._job, shard)] = shard, stamp

    def _take(self, future: Future[Made | None]) -> None:
        """Take what a worker returns."""
        made = future.result()
        shard, stamp = self._running.pop(future)
        if made is None and stamp is not None:  # the shard that is there is not whole
            self._there.discard(shard_name(shard))
            self._rest.appendleft(shard)
            return
        if made is None:
            raise FileError(
                f"a worker does not see the same files in {self._folder.folder}", hint=_SAME_FILES
            )
        cells = made.tally.status.total()
        if stamp is None:
            stamp = self._folder.publish(made.name, shard_name(shard))
            self._solved += cells
            self._losses = 0
        self._cells += cells
        self._summary.stamps[shard] = stamp
        self._summary.sizes[shard] = made.size
        self._summary.digests[shard] = made.digest
        self._summary.tally.include([made.tally])

    def _renew(self, exc: BrokenExecutor) -> None:
        """Give the shards of lost workers to new ones."""
        self._losses += 1
        if self._losses > _LOSSES:
            raise FileError(
                "workers end again and again",
                hint=f"ask for fewer workers or smaller shards, and go on with resume=True; {_KILLED}",
            ) from exc
        self._rest.extendleft(shard for shard, _ in reversed(self._running.values()))
        self._running.clear()
        self._workers.__exit__()
        self._workers.__enter__()

    def _tell(self) -> None:
        self._report(
            Progress(
                self._solved,
                self._cells,
                self._all_cells,
                len(self._summary.sizes),
                self._number,
                self._summary.size,
                time.monotonic() - self._began,
            )
        )
