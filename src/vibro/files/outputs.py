"""Sets of output files that appear whole or not at all."""

from __future__ import annotations

import errno
import shutil
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Self

from vibro.errors import FileError
from vibro.files.claims import Claim
from vibro.files.placing import (
    NAME_HINT,
    REPLACE_HINT,
    Steps,
    is_regular,
    reason,
    status_of_target,
    take_over_rights,
)
from vibro.files.stems import PICTURE_FORMATS, PICTURES, file_suffix, suffixed
from vibro.interrupts import HeldOff, Undone

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from types import TracebackType

__all__ = ["OutputSet"]


class OutputSet:
    """Output files of one stem that wait in a claim and are put in place together at the end.

    Entering makes the folder, claims the stem, removes what killed runs left, and refuses existing targets.
    Leaving puts the files in place, the last one last: where that is there, the set is whole. Leaving by an
    exception, and a signal that ends the process, remove all of it, and the folders that were made.

    Parameters
    ----------
    stem : Path
        What the files' names begin with.
    targets : sequence of Path
        The files, beside the stem; the last one completes the set.
    force : bool
        Whether existing targets may be replaced. Pictures of the stem that are no targets are removed then.
    tell : callable
        Is told of an incomplete set, and of every file that is written or removed.
    reads : sequence of Path or None
        Files that are never replaced: the run's own input.

    Raises
    ------
    FileError
        If the folder cannot be made or written to, another run writes this stem, or a target exists or cannot
        be written. What was there before is there again.
    """

    def __init__(
        self,
        stem: Path,
        targets: Sequence[Path],
        *,
        force: bool,
        tell: Callable[[str], None],
        reads: Sequence[Path | None] = (),
    ) -> None:
        self.folder = stem.parent
        self._targets = tuple(targets)
        pictures = (suffixed(stem, file_suffix(*which)) for which in product(PICTURES, PICTURE_FORMATS))
        self._other_pictures = [path for path in pictures if path not in self._targets]
        self._force = force
        self._tell = tell
        self._reads = [path for path in reads if path is not None]
        self._claim = Claim(stem)
        self._undone = Undone(self._discard)
        self._waiting: dict[Path, Path] = {}
        self._removed: list[Path] = []

    def __getitem__(self, target: Path) -> Path:
        """Return where to write a target to."""
        return self._waiting[target]

    def __enter__(self) -> Self:
        self._undone.__enter__()
        try:
            with HeldOff():
                self._take()
            self._check_targets()
        except BaseException:
            self._leave()
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, exc: BaseException | None, traceback: TracebackType | None
    ) -> None:
        try:
            if kind is None:
                with HeldOff() as signals:
                    self._publish()
                    signals.done()
        finally:
            self._leave()
        if isinstance(exc, OSError):
            raise self._cannot_write(exc) from exc
        if kind is None:
            for path in self._removed:
                self._tell(f"removed {path}")
            for target in self._targets:
                self._tell(f"wrote {target}")

    def leave_out(self, target: Path) -> None:
        """Do without a target after all, not the last one; what is there goes like other pictures."""
        self._targets = tuple(path for path in self._targets if path != target)
        self._other_pictures.append(target)
        del self._waiting[target]

    def free_space(self) -> int:
        """Return the bytes that are free where the files go."""
        return shutil.disk_usage(self.folder).free

    def _leave(self) -> None:
        with HeldOff():
            self._discard()
        self._undone.__exit__()

    def _discard(self) -> None:
        self._claim.give_up()
        self._claim.remove_made()

    def _take(self) -> None:
        try:
            self._claim.take_in_folder()
            self._waiting = {target: self._claim.new_file() for target in self._targets}
        except OSError as exc:
            raise self._cannot_write(exc) from exc

    def _cannot_write(self, exc: OSError) -> FileError:
        in_the_way = next((p for p in (self.folder, *self.folder.parents) if is_regular(p)), None)
        hint = "choose another place with -o"
        if in_the_way:
            hint = f"{in_the_way} is a file"
        elif exc.errno == errno.ENOSPC:
            hint = f"free some space, or {hint}"
        return FileError(f"cannot write to {self.folder}: {reason(exc)}", hint=hint)

    def _check_targets(self) -> None:
        there = [path for path in self._targets if status_of_target(path)]
        there += [path for path in self._other_pictures if is_regular(path)]
        for path in there:
            if any(path.samefile(read) for read in self._reads):
                raise FileError(f"cannot write {path}: it is what this run reads", hint=NAME_HINT)
        last = self._targets[-1]
        cut_short = bool(there) and last not in there
        if there and not self._force:
            problem = f"{', '.join(map(str, there))} {'exists' if len(there) == 1 else 'exist'} already"
            if cut_short:
                problem += f", but no {last.name}: a run did not end there"
            raise FileError(problem, hint=REPLACE_HINT)
        if cut_short:
            self._tell(f"replacing an incomplete set: there is no {last}")

    def _publish(self) -> None:
        """Put all files in place, or none."""
        last = self._targets[-1]
        steps = Steps(self._claim, last)
        try:
            if self._force:
                for target, path in self._waiting.items():
                    take_over_rights(path, target)
                # The set that it completes is no longer whole.
                steps.set_aside(last)
                self._removed = [path for path in self._other_pictures if steps.set_aside(path)]
            for target, path in self._waiting.items():
                steps.put(path, target, replace=self._force)
        except BaseException:
            steps.take_back()
            raise
