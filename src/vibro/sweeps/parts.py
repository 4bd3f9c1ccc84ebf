"""Parts of a sweep, as workers make them: solved row group by row group, and written as Parquet.

A slow part, such as one with bouncing bodies, is solved in pieces by all free workers. The worker that writes
it then reads their results instead of solving, and its bytes are the same.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, Final

import numpy as np

from vibro.errors import FileError
from vibro.files.part_sets import new_part, part_name, sync_file
from vibro.results.steady import RESULTS, SteadyCycle
from vibro.results.sweep import Block
from vibro.sweeps.parquet_sink import HashedFile, open_writer, row_group, schema_of
from vibro.sweeps.plan import ROW_GROUP, versions
from vibro.sweeps.tally import Tally

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from numpy.typing import NDArray

    from vibro.sweeps.plan import Plan

__all__ = [
    "Job",
    "Piece",
    "Slow",
    "Written",
    "check_job",
    "check_part",
    "place_of",
    "read_footer",
    "solve_piece",
    "write_part",
]

_FOOTER: Final = b"vibro"  # key of our entry in a footer

# [cells] A part's time is estimated from samples of growing size. A small sample is quick, but fixed costs
# dominate it; only a larger one shows how long slow cells take.
_SAMPLES: Final = (64, 1024, 16_384)
_TOLD: Final = 0.5  # [s] duration from which a sample is large enough

_FIRST_STEP: Final = 256  # [cells] of a piece in its first step
_STEP_SECONDS: Final = (0.2, 0.8)  # [s] range of the duration of a step

# Results in a piece.
_CELL: Final = np.dtype([(result.name, result.dtype) for result in RESULTS])


@dataclass(frozen=True)
class Job:
    """Settings shared by all parts of a run, and the resources of a worker.

    Attributes
    ----------
    plan : Plan
        The sweep.
    folder : Path
        The folder of the parts.
    run : str
        Identifies the run in names of temporary files.
    wanted : Path
        A file that exists as long as the run goes on.
    threads : int
        Threads that a worker may use.
    patience : float
        Parts that take longer are cut into pieces [s].
    """

    plan: Plan
    folder: Path
    run: str
    wanted: Path
    threads: int
    patience: float

    def check_wanted(self) -> None:
        """Stop working if the run has ended."""
        if not self.wanted.exists():
            raise _UnwantedError

    def solve(self, start: int, stop: int) -> Block:
        """Solve cells in a row."""
        grid = self.plan.grid
        return Block(grid.cells(start, stop), grid.solve_cells(start, stop, self.threads), grid.length)

    @contextlib.contextmanager
    def new_file(self, part: int) -> Iterator[BinaryIO]:
        """Open a temporary file, which is kept only if it is finished while the run goes on."""
        self.check_wanted()
        path = new_part(self.folder, part, self.run)
        try:
            with path.open("xb") as file:
                yield file
            self.check_wanted()
        except BaseException:
            path.unlink(missing_ok=True)
            raise


@dataclass(frozen=True)
class Written:
    """A part that is whole, under its temporary name, with its SHA-256 and its size [B]."""

    part: int
    temporary: str
    digest: str
    size: int
    tally: Tally


@dataclass(frozen=True)
class Slow:
    """A part to be cut into pieces: it would take about so long [s]."""

    part: int
    seconds: float


@dataclass(frozen=True)
class Piece:
    """Results of the cells of a part from ``start`` to ``stop``, in a temporary; they took so long [s]."""

    part: int
    start: int
    stop: int
    temporary: str
    seconds: float
    long_patterns: dict[int, str]


def check_job(job: Job) -> None:
    """Refuse to work with other versions than the plan's, or on another folder.

    Raises
    ------
    FileError
        It names the versions, or the folder.
    """
    here = versions()
    if here != job.plan.versions:
        said = [", ".join(f"{k} {v}" for k, v in which.items()) for which in (here, job.plan.versions)]
        raise FileError(
            f"a worker has {said[0]}; this sweep is made with {said[1]}", hint="install the same everywhere"
        )
    if not job.folder.is_dir():
        raise FileError(
            f"a worker finds no folder {job.folder}",
            hint="workers and whoever starts them need the same files under the same path",
        )


def write_part(job: Job, part: int, pieces: Sequence[Piece] = ()) -> Written | Slow | None:
    """Solve a part and write it.

    Parameters
    ----------
    job : Job
        The run.
    part : int
        Number of the part.
    pieces : sequence of Piece
        Results of all its cells, in their order, if they are solved.

    Returns
    -------
    Written, Slow or None
        None if the run has ended.

    Raises
    ------
    VibroError, OSError
        If it cannot be made here.
    """
    check_job(job)
    first, end = job.plan.range_of(part)
    if not pieces and job.plan.grid.flight:
        seconds = _estimate(job, first, end)
        if seconds > job.patience:
            return Slow(part, seconds)
    solved = _Solved(job, pieces) if pieces else None
    tally, schema = Tally(), schema_of(job.plan.table.columns)

    def row_groups() -> Iterator[Any]:
        for start in range(first, end, ROW_GROUP):
            job.check_wanted()
            stop = min(start + ROW_GROUP, end)
            block = solved.block(start, stop) if solved else job.solve(start, stop)
            tally.add(block)
            yield row_group(job.plan.table, block, schema)

    try:
        with job.new_file(part) as file:
            sink = HashedFile(file)
            _write(sink, job.plan, part, row_groups(), tally)
            file.flush()
            sync_file(file.fileno())
    except _UnwantedError:
        return None
    return Written(part, Path(file.name).name, sink.digest, sink.size, tally)


def check_part(job: Job, part: int) -> Written | None:
    """Read an existing part from end to end; None if it is not whole, or not of this plan.

    It is whole if writing it again gives the same bytes. Checksums cover its pages only, not its footer with
    the names of columns.
    """
    from pyarrow import ArrowException, parquet

    check_job(job)
    path = job.folder / part_name(part)
    first, end = job.plan.range_of(part)
    try:
        with path.open("rb") as stream:
            digest = hashlib.file_digest(stream, "sha256").hexdigest()
        with (
            path.open("rb") as stream,
            parquet.ParquetFile(stream, page_checksum_verification=True) as file,
            Path(os.devnull).open("wb") as nowhere,
        ):
            tally = Tally.read(read_footer(file.metadata) or {})
            again = HashedFile(nowhere)
            row_groups = (file.read_row_group(group) for group in range(file.num_row_groups))
            _write(again, job.plan, part, row_groups, tally)
    except (ArrowException, ArithmeticError, AttributeError, LookupError, OSError, TypeError, ValueError):
        return None
    if again.digest != digest or not tally.status.total() == tally.regime.total() == end - first:
        return None
    return Written(part, path.name, digest, again.size, tally)


def solve_piece(job: Job, part: int, start: int, stop: int) -> Piece | None:
    """Solve the first of some cells, as many as patience allows; None if the run has ended."""
    check_job(job)
    began = time.monotonic()
    solved: list[NDArray[Any]] = []
    long_patterns: dict[int, str] = {}
    done, step = start, _FIRST_STEP
    short, long = _STEP_SECONDS
    try:
        while done < stop and (not solved or time.monotonic() - began < job.patience):
            job.check_wanted()
            before = time.monotonic()
            end = min(done + step, stop)
            cycle = job.solve(done, end).cycle
            solved.append(_packed(cycle))
            long_patterns |= cycle.long_patterns
            done = end
            took = time.monotonic() - before
            step = min(2 * step, ROW_GROUP) if took < short else max(step // 2, 1) if took > long else step
        with job.new_file(part) as file:
            np.save(file, np.concatenate(solved))
    except _UnwantedError:
        return None
    return Piece(part, start, done, Path(file.name).name, time.monotonic() - began, long_patterns)


def read_footer(metadata: Any) -> dict[str, Any] | None:
    """Return our entry in the footer of a part; None if it is not of a part."""
    said = (metadata.metadata or {}).get(_FOOTER)
    if said is None:
        return None
    content: dict[str, Any] = json.loads(said)
    return content


class _UnwantedError(Exception):
    """The run has ended."""


def _write(sink: HashedFile, plan: Plan, part: int, row_groups: Iterable[Any], tally: Tally) -> None:
    """Write a part; its cells are counted once the last of its row groups is there."""
    with open_writer(sink, schema_of(plan.table.columns)) as writer:
        for cells in row_groups:
            writer.write_table(cells, ROW_GROUP)
        footer = {**place_of(plan, part), **tally.told()}
        # Parquet has no checksum of its footer.
        footer["sha256"] = hashlib.sha256(json.dumps(footer).encode()).hexdigest()
        writer.add_key_value_metadata({_FOOTER: json.dumps(footer)})


class _Solved:
    """Results of the cells of a part, from its pieces."""

    def __init__(self, job: Job, pieces: Sequence[Piece]) -> None:
        self._grid = job.plan.grid
        self._pieces = [(piece.start, piece.stop, job.folder / piece.temporary) for piece in pieces]
        self._long_patterns = {code: text for p in pieces for code, text in p.long_patterns.items()}

    def block(self, start: int, stop: int) -> Block:
        """Return cells in a row."""
        # Opened anew for every block: pages read from a mapped file count as memory until it is closed.
        cells = np.concatenate(
            [
                np.load(path, mmap_mode="r")[max(start - a, 0) : stop - a]
                for a, b, path in self._pieces
                if a < stop and start < b
            ]
        )
        arrays = {result.name: np.ascontiguousarray(cells[result.name]) for result in RESULTS}
        cycle = SteadyCycle(**arrays, long_patterns=self._long_patterns)
        return Block(self._grid.cells(start, stop), cycle, self._grid.length)


def _packed(cycle: SteadyCycle) -> NDArray[Any]:
    cells = np.empty(cycle.status.shape, _CELL)
    for name, values in cycle.arrays().items():
        cells[name] = values
    return cells


def place_of(plan: Plan, part: int) -> dict[str, str | int]:
    """Return the entry for the footer of a part: its plan, and its cells."""
    first, end = plan.range_of(part)
    return {"fingerprint": plan.fingerprint, "part": part, "first_cell": first, "cells": end - first}


def _estimate(job: Job, first: int, end: int) -> float:
    """Estimate how long some cells take, from a few spread over them [s]; exact only if it is long."""
    seconds = 0.0
    for number in _SAMPLES:
        if number >= end - first:
            break
        sample = np.linspace(first, end - 1, number).astype(np.intp)
        before = time.monotonic()
        job.plan.grid.solve(job.plan.grid.picked(sample), job.threads)
        took = time.monotonic() - before
        seconds = took * (end - first) / number
        if seconds <= job.patience or took > _TOLD:
            break
    return seconds
