"""Sets of files of one stem: they wait in a hidden folder, and get their names when all are whole."""

from __future__ import annotations

import contextlib
import errno
import os
import shutil
import stat
import sys
import time
from collections.abc import Mapping
from itertools import product
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final, Self

from vibro.errors import FileError
from vibro.output.hidden import Hidden, hidden_folder
from vibro.output.names import PICTURE_FORMATS, PICTURES, file_suffix, suffixed
from vibro.output.record import json_text, picture_metadata, run_record

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from pathlib import Path

    from matplotlib.figure import Figure

__all__ = ["OTHER_NAME", "Staging", "cannot_write", "is_regular", "put", "reason", "status_of_target"]

OTHER_NAME: Final = "choose another name"
_REPLACE: Final = f"replace with force=True, or {OTHER_NAME}"
_FREE_SOME: Final = f"free some space, or {OTHER_NAME}"

_NOTHING: Final[Mapping[str, Any]] = MappingProxyType({})

# A spreadsheet holds a file for as long as it is open, a virus scanner for a moment: outlast the scanner.
_ATTEMPTS: Final = 10
_PAUSE: Final = 0.2  # [s]

# How file systems say that they have no links, or none between two folders.
_NO_LINKS: Final = {
    errno.EPERM, errno.EACCES, errno.ENOTSUP, errno.EOPNOTSUPP, errno.ENOSYS, errno.EXDEV, errno.EMLINK,
}  # fmt: skip


class Staging:
    """The files of one run at one stem: tables, pictures, and last the JSON that describes them.

    A context manager. Entering locks the stem and refuses what exists. Files wait in a hidden folder until
    ``finish`` gives them their names. Leaving removes what has not got its name.

    Parameters
    ----------
    stem : Path
        To which suffixes are appended.
    force : bool
        Whether existing files are replaced. Pictures of the stem that are not made anew are removed then.
    tables : mapping of str to str
        Forms of the tables by their names; the empty name is the stem itself.
    pictures, formats : sequence of str
        Names of the pictures, and the formats of each.
    reads : sequence of Path or None
        Files that are never replaced: the run's own input.
    described : bool
        Whether there is a JSON; a single file may do without.

    Attributes
    ----------
    told : list of str
        What ``finish`` has done, file by file.

    Raises
    ------
    FileError
        If the folder cannot be made or written to, another run writes at this stem, or a file exists or
        cannot be written.
    """

    def __init__(
        self,
        stem: Path,
        *,
        force: bool,
        tables: Mapping[str, str] = MappingProxyType({"": "csv"}),
        pictures: Sequence[str] = (),
        formats: Sequence[str] = (),
        reads: Sequence[Path | None] = (),
        described: bool = True,
    ) -> None:
        self.folder = stem.parent
        self.told: list[str] = []
        self._tables = {name: suffixed(stem, file_suffix(name, form)) for name, form in tables.items()}
        self._pictures = {which: suffixed(stem, file_suffix(*which)) for which in product(pictures, formats)}
        self._json = [suffixed(stem, ".json")] if described else []
        self._targets = [*self._tables.values(), *self._pictures.values(), *self._json]
        known = (suffixed(stem, file_suffix(*which)) for which in product(PICTURES, PICTURE_FORMATS))
        self._others = [path for path in known if path not in self._targets] if described else []
        self._force = force
        self._reads = [path for path in reads if path is not None]
        self._hidden = Hidden(hidden_folder(stem), f"{stem}.*")

    def __enter__(self) -> Self:
        try:
            self._hidden.__enter__()
        except OSError as exc:
            raise cannot_write(exc, self.folder) from exc
        try:
            self._check_targets()
        except BaseException:
            self._hidden.__exit__()
            raise
        return self

    def __exit__(self, kind: object, exc: BaseException | None, traceback: object) -> None:
        self._hidden.__exit__()
        if isinstance(exc, OSError):
            raise cannot_write(exc, self.folder) from exc

    def free_space(self) -> int:
        """Return the bytes that are free where the files go."""
        return shutil.disk_usage(self.folder).free

    def table(self, name: str = "") -> Path:
        """Return where a table is written."""
        return self._waiting(self._tables[name])

    def finish(
        self,
        argv: Sequence[str] = (),
        content: Mapping[str, Any] = _NOTHING,
        figures: Mapping[str, Figure] = _NOTHING,
    ) -> dict[str, Any]:
        """Write the pictures and the JSON, and give all files their names.

        Parameters
        ----------
        argv : sequence of str
            The arguments of the command.
        content : mapping
            What the JSON says beside version, arguments and files.
        figures : mapping
            The pictures by their names; those that are missing are not made.

        Returns
        -------
        dict
            All that the JSON says.
        """
        pictures = {which: path for which, path in self._pictures.items() if which[0] in figures}
        written = [*self._tables.values(), *pictures.values(), *self._json]
        record = {**run_record(argv, content), "files": [path.name for path in written]}
        if pictures:
            from vibro.plots import save

            for (name, form), path in pictures.items():
                save(figures[name], self._waiting(path), form, picture_metadata(record))
        for path in self._json:
            self._waiting(path).write_text(json_text(record) + "\n", encoding="utf-8")
        if self._force:
            self._remove_old(written)
        for path in written:
            self._publish(path)
            self.told.append(f"wrote {path}")
        return record

    def _waiting(self, target: Path) -> Path:
        return self._hidden.path / target.name

    def _remove_old(self, written: Sequence[Path]) -> None:
        """Remove the JSON and the pictures of the files that are about to be replaced."""
        old = [path for path in (*self._others, *self._targets) if path not in written]
        for path in filter(is_regular, (*self._json, *old)):
            _persistently(path, path.unlink)
            self.told += [f"removed {path}"] if path in old else []

    def _publish(self, target: Path) -> None:
        path = self._waiting(target)
        status = status_of_target(target)
        if status:
            with contextlib.suppress(OSError):  # not all file systems have rights
                path.chmod(stat.S_IMODE(status.st_mode))
        put(path, target, replace=self._force)

    def _check_targets(self) -> None:
        there = [path for path in self._targets if status_of_target(path)]
        there += [path for path in self._others if is_regular(path)]
        for path in there:
            if any(path.samefile(read) for read in self._reads):
                raise FileError(f"cannot write {path}: this run reads it", hint=OTHER_NAME)
        if there and not self._force:
            problem = f"{', '.join(map(str, there))} {'exists' if len(there) == 1 else 'exist'} already"
            for path in self._json:
                if path not in there:
                    problem += f", but no {path.name}: it is left from an interrupted run"
            raise FileError(problem, hint=_REPLACE)


def put(path: Path, target: Path, *, replace: bool) -> None:
    """Give a file its name, which must be free unless it may replace another file.

    Raises
    ------
    FileError
        If that cannot be.
    """
    _persistently(target, lambda: path.replace(target) if replace else _put_new(path, target))


def _persistently(target: Path, step: Callable[[], object]) -> None:
    """Take a step, again and again while another program holds the target open."""
    for attempt in range(_ATTEMPTS):
        try:
            step()
        except FileExistsError as exc:
            raise FileError(f"{target} exists already", hint=_REPLACE) from exc
        except PermissionError as exc:
            if attempt + 1 == _ATTEMPTS:
                hint = f"close it in the program that holds it open, or {OTHER_NAME}"
                raise FileError(f"cannot replace {target}: {reason(exc)}", hint=hint) from exc
            time.sleep(_PAUSE)
        except OSError as exc:
            hint = _FREE_SOME if exc.errno == errno.ENOSPC else OTHER_NAME
            raise FileError(f"cannot write {target}: {reason(exc)}", hint=hint) from exc
        else:
            return


def _put_new(path: Path, target: Path) -> None:
    if sys.platform == "win32":
        path.rename(target)  # which refuses a name that is not free
        return
    try:
        os.link(path, target)  # which refuses it, too; renaming does not
    except OSError as exc:
        if exc.errno not in _NO_LINKS:
            raise
        if os.path.lexists(target):
            raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), str(target)) from exc
        path.rename(target)


def status_of_target(target: Path) -> os.stat_result | None:
    """Return the status of a file, None if it does not exist.

    Raises
    ------
    FileError
        If there is something else than a file: it is never replaced.
    """
    try:
        status = target.lstat()
    except FileNotFoundError:
        return None
    except OSError as exc:
        raise FileError(f"cannot write {target}: {reason(exc)}", hint=OTHER_NAME) from exc
    if stat.S_ISDIR(status.st_mode):
        raise FileError(f"cannot write {target}: a folder is in the way", hint=OTHER_NAME)
    if not stat.S_ISREG(status.st_mode):
        kind = "a symbolic link" if stat.S_ISLNK(status.st_mode) else "not a regular file"
        raise FileError(f"cannot write {target}: it is {kind}", hint=OTHER_NAME)
    return status


def is_regular(path: Path) -> bool:
    """Whether there is a file by this name, and no link or anything else."""
    try:
        return stat.S_ISREG(path.lstat().st_mode)
    except OSError:
        return False


def reason(exc: OSError) -> str:
    """Say what the system says, without its number and the path."""
    return exc.strerror or str(exc)


def cannot_write(exc: OSError, folder: Path, on_full_disk: str = _FREE_SOME) -> FileError:
    """Return the error for a folder that cannot be written to."""
    in_the_way = next((path for path in (folder, *folder.parents) if is_regular(path)), None)
    hint = "choose another place"
    if in_the_way:
        hint = f"{in_the_way} is a file; choose another place"
    elif exc.errno == errno.ENOSPC:
        hint = on_full_disk
    return FileError(f"cannot write to {folder}: {reason(exc)}", hint=hint)
