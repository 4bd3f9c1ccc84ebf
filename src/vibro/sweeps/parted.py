"""Sweeps in parts: which worker makes which part, which parts exist already, and the summary."""

from __future__ import annotations

import hashlib
import json
import math
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, wait
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Final

from vibro.errors import FileError
from vibro.files.part_sets import MANIFEST, SUCCESS, PartSet, part_name
from vibro.sweeps.parts import Job, Piece, Slow, Written, check_job, check_part, solve_piece, write_part
from vibro.sweeps.plan import Plan, check_manifest, read_plan
from vibro.sweeps.tally import Tally

if TYPE_CHECKING:
    from collections.abc import Sequence
    from concurrent.futures import Future

    from vibro.output.workers import Workers

__all__ = ["Progress", "Summary", "agree", "make_parts"]

# [s] A worker that takes longer for a part hands it back to be cut into pieces of half of that.
_PATIENCE: Final = 20.0
_WINDOW: Final = 2  # tasks for each worker: one at work, one that waits
_LOSSES: Final = 3  # lost workers in a row, without a finished part in between, that end the run
_NOTICED: Final = 0.1  # [s] between looks for an interrupt, which an endless wait would ignore


@dataclass(frozen=True)
class Progress:
    """Progress of a run.

    Attributes
    ----------
    solved : int
        Cells that this run has solved.
    cells, all_cells : int
        Cells of finished parts, and of all parts.
    parts, all_parts : int
        Finished parts, and all parts.
    size : int
        Size of the finished parts [B].
    seconds : float
        Since the run began.
    """

    solved: int
    cells: int
    all_cells: int
    parts: int
    all_parts: int
    size: int
    seconds: float


@dataclass
class Summary:
    """Summary of a sweep in parts: size [B] and SHA-256 of each part by number, and counts of cells."""

    sizes: dict[int, int] = field(default_factory=dict)
    digests: dict[int, str] = field(default_factory=dict)
    tally: Tally = field(default_factory=Tally)

    @property
    def size(self) -> int:
        """Size of all parts [B]."""
        return sum(self.sizes.values())

    @property
    def digest(self) -> str:
        """SHA-256 of what ``sha256sum part-*.parquet`` prints."""
        lines = (f"{self.digests[part]}  {part_name(part)}\n" for part in sorted(self.digests))
        return hashlib.sha256("".join(lines).encode()).hexdigest()

    def text(self) -> str:
        """Return the content of the last file."""
        content = {
            "cells": self.tally.status.total(),
            "parts": len(self.sizes),
            "bytes": self.size,
            "digest": self.digest,
            **self.tally.told(),
        }
        return json.dumps(content, indent=1) + "\n"


def agree(files: PartSet, plan: Plan, *, resume: bool, force: bool, own_size: bool) -> Plan:
    """Decide what is to be made in a folder; nothing is changed.

    Parameters
    ----------
    files : PartSet
        The folder, entered.
    plan : Plan
        The plan that is asked for.
    resume, force : bool
        Whether to continue the sweep in the folder, or to replace it; with neither it must be empty.
    own_size : bool
        Whether the size of parts is asked for; otherwise that of existing parts is kept.

    Returns
    -------
    Plan
        The plan to be made.

    Raises
    ------
    FileError
        If the folder holds something else; of another sweep it names the differences.
    """
    plan.check()
    text = files.read(MANIFEST)
    files.check_free()
    if text is None:
        return plan
    path = files.shown / MANIFEST
    check_manifest(text, path)
    if resume:
        there = read_plan(text, path)
        return _going_on(files, plan if own_size else replace(plan, part_cells=there.part_cells), there)
    if not force:
        raise _exists(files)
    return plan


def _exists(files: PartSet) -> FileError:
    if files.read(SUCCESS) is not None:
        hint = "vibro map and vibro.open_sweep read it; choose another name, or start anew with --force"
        return FileError(f"{files.shown} holds a sweep already", hint=f"{hint} (force=True)")
    hint = "--resume (resume=True) goes on with it, --force (force=True) starts anew"
    return FileError(f"{files.shown} holds a sweep that is not finished", hint=hint)


def _going_on(files: PartSet, plan: Plan, there: Plan) -> Plan:
    differences = plan.differences(there)
    if differences:
        raise FileError(
            f"{files.shown} holds another sweep: {'; '.join(differences)}",
            hint="ask for the same, choose another name with -o, or start anew with --force",
        )
    others = files.parts() - {part_name(part) for part in range(plan.parts)}
    if others:
        raise FileError(f"{files.shown} holds parts that are none of this sweep: {min(others)}")
    return plan


def make_parts(
    plan: Plan,
    files: PartSet,
    workers: Workers,
    argv: Sequence[str],
    *,
    resume: bool,
    report: Callable[[Progress], None] = lambda progress: None,
    patience: float = _PATIENCE,
) -> Summary:
    """Make the parts that are missing.

    Parameters
    ----------
    plan : Plan
        The plan, as ``agree`` returns it.
    files : PartSet
        The folder, entered.
    workers : Workers
        Entered.
    argv : sequence of str
        Command line of the sweep, for the manifest.
    resume : bool
        Whether existing parts are checked and kept; otherwise they are removed.
    report : callable
        Called with the progress several times a second.
    patience : float
        Parts that would take a worker longer are cut into pieces [s].

    Returns
    -------
    Summary
        Of all parts.

    Raises
    ------
    FileError, VibroError, OSError
        If a part cannot be made; finished parts remain.
    """
    run = _Run(plan, files, workers, report, patience)
    try:
        run.check_workers()
        if not resume:
            files.clear()
        if files.read(MANIFEST) is None:
            files.write(MANIFEST, plan.manifest(argv))
        return run.finish()
    except BaseException:
        files.stop()
        raise


@dataclass(frozen=True)
class _Task:
    """A task for a worker, and the cells that it finishes."""

    work: Callable[..., Any]
    part: int
    more: tuple[Any, ...] = ()


class _Run:
    """The parts of a sweep that are being made."""

    def __init__(
        self,
        plan: Plan,
        files: PartSet,
        workers: Workers,
        report: Callable[[Progress], None],
        patience: float,
    ) -> None:
        self._plan, self._files, self._workers, self._report = plan, files, workers, report
        self._patience = patience
        _ = plan.fingerprint  # resolved once, here: it is sent with every task
        shared = patience if workers.number > 1 else math.inf
        self._job = Job(plan, files.folder, files.run, files.wanted, workers.threads, shared)
        self._there: set[str] = set()
        self._rest = iter(range(plan.parts))
        self._first: deque[_Task] = deque()  # before the rest
        self._running: dict[Future[Any], _Task] = {}
        self._pieces: dict[int, list[Piece]] = {}
        self._summary = Summary()
        self._solved = self._checked = 0  # cells of finished parts, and of those that existed before
        self._began = time.monotonic()
        self._losses = 0

    def check_workers(self) -> None:
        """Have a worker check versions and folder before anything is changed."""
        try:
            future = self._workers.submit(check_job, self._job)
            while not wait([future], _NOTICED).done:
                self._workers.check()
            future.result()
        except BrokenExecutor as exc:
            raise FileError(
                "workers end as soon as they begin",
                hint='a script that asks for workers needs the line if __name__ == "__main__": before that;'
                " else they are killed, or short of memory",
            ) from exc

    def finish(self) -> Summary:
        """Work until all parts exist."""
        self._there = self._files.parts()
        while True:
            lost: list[_Task] = []
            while len(self._running) < _WINDOW * self._workers.number and (task := self._next()) is not None:
                if not self._submit(task):
                    lost.append(task)
                    break
            if not self._running and not lost:
                return self._summary
            done, _ = wait(self._running, _NOTICED, FIRST_COMPLETED)
            self._workers.check()
            lost += [task for future in done if (task := self._take(future)) is not None]
            if lost:
                self._renew(lost)
            self._tell()

    def _next(self) -> _Task | None:
        if self._first:
            return self._first.popleft()
        part = next(self._rest, None)
        if part is None:
            return None
        return _Task(check_part if part_name(part) in self._there else write_part, part)

    def _submit(self, task: _Task) -> bool:
        """Hand a task to a worker; return whether there was a task."""
        if task.work is not check_part:
            self._files.remove(SUCCESS)
        try:
            future = self._workers.submit(task.work, self._job, task.part, *task.more)
        except BrokenExecutor:
            return False
        self._running[future] = task
        return True

    def _take(self, future: Future[Any]) -> _Task | None:
        """Take what a worker returns; return the task if the worker was lost."""
        task = self._running.pop(future)
        try:
            found = future.result()
        except BrokenExecutor:
            return task
        if isinstance(found, Written):
            self._publish(found, made=task.work is write_part)
        elif isinstance(found, Slow):
            self._share(found.part, *self._plan.range_of(found.part), found.seconds)
        elif isinstance(found, Piece):
            self._collect(found, stop=task.more[1])
        elif task.work is check_part:  # the existing part is not whole
            self._first.append(_Task(write_part, task.part))
        else:
            raise FileError(
                f"a worker does not see the same files in {self._files.folder}",
                hint="workers and whoever starts them need the same files under the same path",
            )
        return None

    def _publish(self, found: Written, *, made: bool) -> None:
        first, end = self._plan.range_of(found.part)
        if made:
            self._files.publish(found.temporary, part_name(found.part))
            pieces = self._pieces.pop(found.part, [])
            self._solved += 0 if pieces else end - first
            for piece in pieces:
                self._files.remove(piece.temporary)
            self._losses = 0
        else:
            self._checked += end - first
        self._summary.sizes[found.part] = found.size
        self._summary.digests[found.part] = found.digest
        self._summary.tally.include([found.tally])

    def _share(self, part: int, start: int, stop: int, seconds: float) -> None:
        """Cut cells that take so long into pieces, which are done next."""
        number = min(stop - start, max(2, math.ceil(seconds / (0.5 * self._patience))))
        ends = [start + (stop - start) * i // number for i in range(number + 1)]
        self._pieces.setdefault(part, [])
        self._first.extend(_Task(solve_piece, part, ends_of) for ends_of in pairwise(ends))

    def _collect(self, piece: Piece, stop: int) -> None:
        """Take a piece; cut the rest of its cells, or have the part written once all are solved."""
        pieces = self._pieces[piece.part]
        pieces.append(piece)
        solved = piece.stop - piece.start
        self._solved += solved
        first, end = self._plan.range_of(piece.part)
        if piece.stop < stop:
            self._share(piece.part, piece.stop, stop, piece.seconds * (stop - piece.stop) / solved)
        elif sum(p.stop - p.start for p in pieces) == end - first:
            pieces.sort(key=lambda p: p.start)
            self._first.append(_Task(write_part, piece.part, (tuple(pieces),)))

    def _renew(self, lost: list[_Task]) -> None:
        """Give the tasks of lost workers to others."""
        self._losses += 1
        if self._losses > _LOSSES:
            raise FileError(
                "workers end again and again: are they killed, or short of memory?",
                hint="ask for fewer workers or smaller parts, and go on with --resume (resume=True)",
            )
        lost += self._running.values()
        self._running.clear()
        self._workers.__exit__()
        self._workers.__enter__()
        self._first.extendleft(reversed(lost))

    def _tell(self) -> None:
        self._report(
            Progress(
                self._solved,
                self._solved + self._checked,
                self._plan.grid.size,
                len(self._summary.sizes),
                self._plan.parts,
                self._summary.size,
                time.monotonic() - self._began,
            )
        )
