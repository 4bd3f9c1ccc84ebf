"""Putting files in place, a step after another, each of which can be taken back."""

from __future__ import annotations

import contextlib
import errno
import os
import stat
import sys
import time
from typing import TYPE_CHECKING, Final

from vibro.errors import FileError

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from vibro.files.claims import Claim

__all__ = [
    "NAME_HINT",
    "REPLACE_HINT",
    "Steps",
    "is_regular",
    "reason",
    "status_of_target",
    "take_over_rights",
]

NAME_HINT: Final = "choose another name with -o"
REPLACE_HINT: Final = f"replace with --force, or {NAME_HINT}"

# A spreadsheet holds a file for as long as it is open, a virus scanner for a moment: outlast the scanner.
_ATTEMPTS: Final = 10
_PAUSE: Final = 0.2  # [s]

# How file systems say that they have no links, or none between two folders.
_NO_LINKS: Final = {
    errno.EPERM, errno.EACCES, errno.ENOTSUP, errno.EOPNOTSUPP, errno.ENOSYS, errno.EXDEV, errno.EMLINK,
}  # fmt: skip


class Steps:
    """The steps of publishing a set, each of which can be taken back.

    Parameters
    ----------
    claim : Claim
        Keeps what was there before.
    last : Path
        The file that completes the set.
    """

    def __init__(self, claim: Claim, last: Path) -> None:
        self._claim = claim
        self._last = last
        # What was put there or moved away, and where is now what was there before.
        self._taken: list[tuple[Path, Path | None]] = []

    def set_aside(self, target: Path) -> bool:
        """Move a file away if it exists; return whether it did."""
        if not is_regular(target):
            return False
        old = self._claim.new_name()
        _persistently(target, lambda: target.rename(old))
        self._taken.append((target, old))
        return True

    def put(self, path: Path, target: Path, *, replace: bool) -> None:
        """Put a file in place, of another only if it may be replaced."""
        if not (replace and status_of_target(target)):
            _persistently(target, lambda: _put_new(path, target))
            self._taken.append((target, None))
            return
        # Linked, so that there is no moment without the one or the other.
        old = self._claim.new_name()
        _persistently(target, lambda: _link_or_rename(target, old))
        self._taken.append((target, old))
        _persistently(target, lambda: path.replace(target))

    def take_back(self) -> None:
        """Put everything back as it was, or as far as that can be: then the set remains incomplete."""
        whole = True
        for target, old in reversed(self._taken):
            if old is not None and target == self._last and not whole:
                return
            try:
                target.unlink() if old is None else old.replace(target)
            except OSError:
                whole = False


def _link_or_rename(path: Path, target: Path) -> None:
    """Give a file a new name that nobody else has, and leave it the old one where that can be."""
    try:
        os.link(path, target)
    except OSError as exc:
        if exc.errno not in _NO_LINKS:
            raise
        path.rename(target)


def _put_new(path: Path, target: Path) -> None:
    """Give a file a name that must be free."""
    if sys.platform == "win32":
        path.rename(target)  # which refuses a name that is not
        return
    try:
        os.link(path, target)
    except OSError as exc:
        if exc.errno not in _NO_LINKS:
            raise
        _rename_to_free_name(path, target)


def _rename_to_free_name(path: Path, target: Path) -> None:
    """Do without links, where it takes two steps: the claim keeps other runs from coming between."""
    if os.path.lexists(target):
        raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), str(target))
    path.rename(target)


def _persistently(target: Path, step: Callable[[], object]) -> None:
    """Take a step, again and again while another program holds the target open."""
    for attempt in range(_ATTEMPTS):
        try:
            step()
        except FileExistsError as exc:
            raise FileError(f"{target} exists already", hint=REPLACE_HINT) from exc
        except PermissionError as exc:
            if attempt + 1 == _ATTEMPTS:
                hint = "close it in the program that holds it open"
                raise FileError(f"cannot replace {target}: {reason(exc)}", hint=hint) from exc
            time.sleep(_PAUSE)
        except OSError as exc:
            raise FileError(f"cannot write {target}: {reason(exc)}") from exc
        else:
            return


def status_of_target(target: Path) -> os.stat_result | None:
    """Return what the system says of a file, None where there is none.

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
        raise FileError(f"cannot write {target}: {reason(exc)}", hint=NAME_HINT) from exc
    if stat.S_ISDIR(status.st_mode):
        raise FileError(f"cannot write {target}: a folder is in the way", hint=NAME_HINT)
    if not stat.S_ISREG(status.st_mode):
        kind = "a symbolic link" if stat.S_ISLNK(status.st_mode) else "not a regular file"
        raise FileError(
            f"cannot write {target}: it is {kind}",
            hint="-o - writes the table to stdout, from there to anything",
        )
    return status


def take_over_rights(path: Path, target: Path) -> None:
    """Give a file the rights of the one that it will replace, if there is one."""
    if is_regular(target):
        with contextlib.suppress(OSError):  # not all file systems have rights
            path.chmod(stat.S_IMODE(target.stat().st_mode))


def is_regular(path: Path) -> bool:
    """Whether there is a file by this name, and no link or anything else."""
    try:
        return stat.S_ISREG(path.lstat().st_mode)
    except OSError:
        return False


def reason(exc: OSError) -> str:
    """Say what the system says, without its number and the path."""
    return exc.strerror or str(exc)
