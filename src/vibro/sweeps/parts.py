"""Parts of a sweep, as workers make them: solved row group by row group, and written as Parquet.

A part that takes long, as bodies bounce in it, is solved in pieces by as many workers as are free; whoever
writes it then reads their results instead of solving, and its bytes are the same.
"""

from __future__ import annotations

import hashlib
import json
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.errors import FileError
from vibro.files.part_sets import new_part, part_name, sync_file
from vibro.parallel import retain_freed_memory
from vibro.results.steady import RESULTS, SteadyCycle
from vibro.results.sweep import Block
from vibro.sweeps.parquet_sink import HashedFile, open_writer, row_group
from vibro.sweeps.plan import ROW_GROUP, versions
from vibro.sweeps.tally import Tally

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

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

_FOOTER: Final = b"vibro"  # the key of what a footer says

# [cells] Samples tell how long a part takes. Few are solved in no time, even if they are the slowest; but a
# few take nearly as long as many, and more tell what is slow.
_SAMPLES: Final = (64, 1024, 16_384)
_TOLD: Final = 0.5  # [s] from which a sample tells enough

_FIRST_STEP: Final = 256  # [cells] of a piece that are solved at once
_STEP_SECONDS: Final = (0.2, 0.8)  # how long a step should take

# What a piece holds of a cell.
_CELL: Final = np.dtype([(result.name, result.dtype) for result in RESULTS])


@dataclass(frozen=True)
class Job:
    """What all parts of a run share, and what a worker may use.

    Attributes
    ----------
    plan : Plan
        What is made.
    folder : Path
        Where to.
    run : str
        In the names of temporaries.
    wanted : Path
        There as long as anybody wants the parts.
    threads : int
        That a worker may use.
    patience : float
        Parts that take longer are cut into pieces [s].
    """

    plan: Plan
    folder: Path
    run: str
    wanted: Path
    threads: int
    patience: float

    def solve(self, start: int, stop: int) -> Block:
        """Solve cells in a row."""
        grid = self.plan.grid
        return Block(grid.cells(start, stop), grid.solve_cells(start, stop, self.threads), grid.length)


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
    """A part that is better cut into pieces: it would take about so long [s]."""

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


def check_job(job: Job) -> None:
    """Refuse to work with other versions than the plan's, or elsewhere than on its files.

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
        What is made.
    part : int
        Its number.
    pieces : sequence of Piece
        Results of all its cells, in their order, where they are solved.

    Returns
    -------
    Written, Slow or None
        None if nobody wants it any more.

    Raises
    ------
    VibroError, OSError
        If it cannot be made here.
    """
    check_job(job)
    retain_freed_memory()
    first, end = job.plan.range_of(part)
    if not pieces and job.plan.grid.flight:
        seconds = _estimate(job, first, end)
        if seconds > job.patience:
            return Slow(part, seconds)
    solved = _Solved(job, pieces) if pieces else None
    table, tally = job.plan.table, Tally()
    path = new_part(job.folder, part, job.run)
    try:
        with path.open("xb") as file:
            sink = HashedFile(file)
            with open_writer(sink, table.columns) as writer:
                for start in range(first, end, ROW_GROUP):
                    if not job.wanted.exists():
                        raise _UnwantedError
                    stop = min(start + ROW_GROUP, end)
                    block = solved.block(start, stop) if solved else job.solve(start, stop)
                    writer.write_table(row_group(table, block, writer.schema), ROW_GROUP)
                    tally.add(block)
                writer.add_key_value_metadata(
                    {_FOOTER: json.dumps({**place_of(job.plan, part), **tally.told()})}
                )
            file.flush()
            sync_file(file.fileno())
    except BaseException as exc:
        path.unlink(missing_ok=True)
        if isinstance(exc, _UnwantedError):
            return None
        raise
    return Written(part, path.name, sink.digest, sink.size, tally)


def check_part(job: Job, part: int) -> Written | None:
    """Read a part that is there from end to end; None if it is not whole, or no part of this plan."""
    from pyarrow import ArrowException, parquet

    check_job(job)
    path = job.folder / part_name(part)
    first, end = job.plan.range_of(part)
    try:
        with path.open("rb") as stream:
            digest = hashlib.file_digest(stream, "sha256").hexdigest()
            size = stream.tell()
        with parquet.ParquetFile(path, page_checksum_verification=True) as file:
            said = read_footer(file.metadata)
            expected = place_of(job.plan, part)
            if said is None or not expected.items() <= said.items() or file.metadata.num_rows != end - first:
                return None
            for group in range(file.num_row_groups):
                file.read_row_group(group)
    except (ArrowException, OSError, ValueError):
        return None
    return Written(part, path.name, digest, size, Tally.read(said))


def solve_piece(job: Job, part: int, start: int, stop: int) -> Piece | None:
    """Solve the first of some cells, as many as patience allows; None if nobody wants them any more."""
    check_job(job)
    retain_freed_memory()
    began = time.monotonic()
    solved: list[NDArray[Any]] = []
    done, step = start, _FIRST_STEP
    short, long = _STEP_SECONDS
    while done < stop and (not solved or time.monotonic() - began < job.patience):
        if not job.wanted.exists():
            return None
        before = time.monotonic()
        end = min(done + step, stop)
        solved.append(_packed(job.solve(done, end).cycle))
        done = end
        took = time.monotonic() - before
        step = min(2 * step, ROW_GROUP) if took < short else max(step // 2, 1) if took > long else step
    path = new_part(job.folder, part, job.run)
    try:
        with path.open("xb") as file:
            np.save(file, np.concatenate(solved))
    except BaseException:
        path.unlink(missing_ok=True)
        raise
    return Piece(part, start, done, path.name, time.monotonic() - began)


def read_footer(metadata: Any) -> dict[str, Any] | None:
    """Return what the footer of a part says of it and its cells; None if it is no part's."""
    said = (metadata.metadata or {}).get(_FOOTER)
    if said is None:
        return None
    content: dict[str, Any] = json.loads(said)
    return content


class _UnwantedError(Exception):
    """Nobody wants the part any more."""


class _Solved:
    """Results of the cells of a part, from its pieces."""

    def __init__(self, job: Job, pieces: Sequence[Piece]) -> None:
        self._grid = job.plan.grid
        self._pieces = [
            (piece.start, piece.stop, np.load(job.folder / piece.temporary, mmap_mode="r"))
            for piece in pieces
        ]

    def block(self, start: int, stop: int) -> Block:
        """Return cells in a row."""
        cells = np.concatenate(
            [x[max(start - a, 0) : stop - a] for a, b, x in self._pieces if a < stop and start < b]
        )
        cycle = SteadyCycle(**{result.name: np.ascontiguousarray(cells[result.name]) for result in RESULTS})
        return Block(self._grid.cells(start, stop), cycle, self._grid.length)


def _packed(cycle: SteadyCycle) -> NDArray[Any]:
    cells = np.empty(cycle.status.shape, _CELL)
    for result in RESULTS:
        cells[result.name] = getattr(cycle, result.name)
    return cells


def place_of(plan: Plan, part: int) -> dict[str, str | int]:
    """Say what a part is of, and where it stands in that."""
    first, end = plan.range_of(part)
    return {"fingerprint": plan.fingerprint, "part": part, "first_cell": first, "cells": end - first}


def _estimate(job: Job, first: int, end: int) -> float:
    """Tell about how long some cells take, from a few spread over them [s]; exactly, only if it is long."""
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
