"""Files that appear whole: each is made under a temporary name beside its target, and renamed."""

from __future__ import annotations

import contextlib
import errno
import os
import shutil
import stat
import time
from typing import TYPE_CHECKING, Final

from vibro.errors import FileError
from vibro.interrupts import OnEnd

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator
    from pathlib import Path

OTHER_NAME: Final = "choose another name"
_REPLACE: Final = f"--force (force=True) replaces it, or {OTHER_NAME}"
_KINDS: Final = {stat.S_IFDIR: "a folder", stat.S_IFLNK: "a symbolic link"}
# A spreadsheet holds a file for as long as it is open, a virus scanner for a moment: outlast the scanner.
_ATTEMPTS: Final = 10
_PAUSE: Final = 0.2  # [s]


@contextlib.contextmanager
def whole_files(
    targets: Iterable[Path], *, force: bool = False, reads: Iterable[Path] = ()
) -> Iterator[dict[Path, Path]]:
    """Have temporary files beside some targets, whose names they get in this order when all are whole.

    Parameters
    ----------
    targets : iterable of Path
        The last one tells readers that the others are there: of a set that is replaced it goes first.
    force : bool
        Whether files that exist are replaced.
    reads : iterable of Path
        Files that are never replaced: the run's own input.

    Yields
    ------
    dict of Path to Path
        Where to write each; one that is not written is left out.

    Raises
    ------
    FileError
        If one exists, or is no regular file, or cannot be written.
    """
    targets = list(targets)
    if not targets:
        yield {}
        return
    own = f"{os.getpid()}-{os.urandom(4).hex()}"
    waiting = {target: target.with_name(f".{target.name}-{own}") for target in targets}
    folders = dict.fromkeys(target.parent for target in waiting)
    new = [folder for target in waiting for folder in target.parents if not folder.exists()]

    def remove() -> None:
        for path in waiting.values():
            with contextlib.suppress(OSError):  # it is not there
                path.unlink()
        for folder in new:
            with contextlib.suppress(OSError):  # it holds something
                folder.rmdir()

    with OnEnd(remove):
        try:
            for folder in folders:
                folder.mkdir(parents=True, exist_ok=True)
            _check(waiting, force, reads)
            yield waiting
            _check(waiting, force, reads)
            whole = [target for target, path in waiting.items() if path.exists()]
            if len(whole) > 1:
                whole[-1].unlink(missing_ok=True)
            for target in whole:
                _rename(waiting[target], target)
        except BrokenPipeError:  # of the stream that the body writes to
            raise
        except OSError as exc:
            raise cannot_write(exc, next(iter(folders))) from exc
        finally:
            remove()


@contextlib.contextmanager
def whole_file(target: Path) -> Iterator[Path]:
    """Have a temporary file, which replaces the target when it is whole."""
    with whole_files([target], force=True) as waiting:
        yield waiting[target]


def _check(targets: Iterable[Path], force: bool, reads: Iterable[Path]) -> None:
    """Refuse targets that exist, unless they may be replaced, and those that never may."""
    there = [target for target in targets if _is_there(target)]
    for target in there:
        if any(target.samefile(read) for read in reads):
            raise FileError(f"cannot write {target}: this run reads it", hint=OTHER_NAME)
    if there and not force:
        verb = "exists" if len(there) == 1 else "exist"
        raise FileError(f"{', '.join(map(str, there))} {verb} already", hint=_REPLACE)


def _is_there(target: Path) -> bool:
    try:
        status = target.lstat()
    except FileNotFoundError:
        return False
    except OSError as exc:
        raise FileError(f"cannot write {target}: {reason(exc)}", hint=OTHER_NAME) from exc
    if not stat.S_ISREG(status.st_mode):
        kind = _KINDS.get(stat.S_IFMT(status.st_mode), "no file")
        raise FileError(f"cannot write {target}: it is {kind}", hint=OTHER_NAME)
    return True


def _rename(path: Path, target: Path) -> None:
    """Give a file its name, again and again while another program holds the target open."""
    with contextlib.suppress(OSError):  # the rights of the file that is replaced, where there are any
        path.chmod(stat.S_IMODE(target.stat().st_mode))
    for attempt in range(_ATTEMPTS):
        try:
            path.replace(target)
        except PermissionError as exc:
            if attempt + 1 == _ATTEMPTS:
                hint = f"close it in the program that holds it open, or {OTHER_NAME}"
                raise FileError(f"cannot replace {target}: {reason(exc)}", hint=hint) from exc
            time.sleep(_PAUSE)
        else:
            return


@contextlib.contextmanager
def hidden_folder(beside: Path) -> Iterator[Path]:
    """Have a hidden folder for temporary files, which goes whatever happens but a kill."""
    path = beside / f".vibro-{os.urandom(8).hex()}"

    path.mkdir()
    with OnEnd(lambda: remove_hidden(path)):
        try:
            yield path
        finally:
            remove_hidden(path)


def remove_hidden(path: Path) -> None:
    """Remove a hidden folder, though others may begin files in it.

    A file that is begun while a folder is removed keeps it, and whoever looks for it goes on: so it loses its
    name first, in one step.
    """
    gone = path.with_name(f"{path.name}-gone")
    with contextlib.suppress(OSError):  # open files keep its name on Windows
        path.rename(gone)
    for _ in range(_ATTEMPTS):
        for name in (gone, path):
            shutil.rmtree(name, ignore_errors=True)
        if not (gone.exists() or path.exists()):
            return


def is_regular(path: Path) -> bool:
    """Whether there is a file by this name, and no link or anything else."""
    try:
        return stat.S_ISREG(path.lstat().st_mode)
    except OSError:
        return False


def reason(exc: OSError) -> str:
    """Say what the system says, without its number and the path."""
    return exc.strerror or str(exc)


def cannot_write(exc: OSError, folder: Path) -> FileError:
    """Return the error for a folder that cannot be written to."""
    in_the_way = next((path for path in (folder, *folder.parents) if is_regular(path)), None)
    hint = "choose another place"
    if in_the_way:
        hint = f"{in_the_way} is a file; {hint}"
    elif exc.errno == errno.ENOSPC:
        hint = f"free some space, or {hint}"
    return FileError(f"cannot write to {folder}: {reason(exc)}", hint=hint)
