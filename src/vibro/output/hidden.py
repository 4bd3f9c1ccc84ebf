"""Hidden folders: what a run has not finished yet, beside where it will be, for one run at a time.

A hidden folder is named after what is written. It holds a lock, which the system releases when the process
of its holder ends, and one folder for the files of that run. A run that gets the lock knows that the one
before has ended, and removes what that left.

Locks may not reach other machines that see the same files. So the lock's name has the name of the running
system: next to a lock of another system nothing is removed.
"""

from __future__ import annotations

import contextlib
import errno
import hashlib
import os
import platform
import shutil
import time
import unicodedata
from pathlib import Path
from typing import Final, Self

from vibro.errors import FileError
from vibro.interrupts import OnEnd

__all__ = ["PREFIX", "Hidden", "hidden_folder"]

PREFIX: Final = ".vibro-"
_LOCK: Final = "lock-"
# A run that leaves, or looks whether another has ended, holds the lock for a moment.
_ATTEMPTS: Final = 30
_PAUSE: Final = 0.01  # [s]
# How file systems say that they have no locks.
_NO_LOCKS: Final = {errno.ENOSYS, errno.ENOLCK, errno.ENOTSUP, errno.EOPNOTSUPP}


def hidden_folder(stem: Path) -> Path:
    """Return the hidden folder of a stem; its name is short, however long that of the stem is.

    Names that a file system may take for one, as they differ in case or composed characters, have the same.
    """
    name = unicodedata.normalize("NFC", stem.name.casefold()).encode(errors="surrogateescape")
    return stem.with_name(f"{PREFIX}{hashlib.sha256(name).hexdigest()[:16]}")


class Hidden:
    """A hidden folder; a context manager that holds it.

    Entering makes the folders that are missing, and removes what a killed run left in this one. Leaving, and
    a signal that ends the process, remove it, and those that were made and are empty.

    Parameters
    ----------
    folder : Path
        As ``hidden_folder`` returns it.
    what : str
        What is written, for messages.

    Attributes
    ----------
    path : Path
        Where the files of this run are, while it is held.

    Raises
    ------
    FileError
        On entering, if another run has it, or may have it.
    OSError
        On entering, if it cannot be made.
    """

    def __init__(self, folder: Path, what: str) -> None:
        from filelock import FileLock

        self._folder = folder
        self._what = what
        self.path = folder / os.urandom(8).hex()
        self._lock_path = folder / f"{_LOCK}{_system()}"
        # Without a fallback: only file locks show whether the process that holds them is alive.
        self._lock = FileLock(self._lock_path, timeout=0, thread_local=False, fallback_to_soft=False)
        self._lock_status: os.stat_result | None = None
        self._made: list[Path] = []
        self._on_end = OnEnd(self._leave)

    def __enter__(self) -> Self:
        self._on_end.__enter__()
        try:
            self._take()
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self._leave()
        self._on_end.__exit__()

    def remove_files(self) -> None:
        """Remove the files of this run: whoever still writes some stops."""
        _remove(self.path)

    def _take(self) -> None:
        for _ in range(_ATTEMPTS):
            with contextlib.suppress(FileNotFoundError, FileExistsError):  # another run has just left
                if self._get_lock(is_new=self._make_folders()):
                    break
            time.sleep(_PAUSE)
        else:
            raise FileError(
                f"another run is writing {self._what} at this moment",
                hint=f"wait until it has ended; if there is none, remove the folder {self._folder}",
            )
        self._lock_status = self._lock_path.stat()
        if any(path.name.startswith(_LOCK) for path in self._others()):
            raise FileError(
                f"another machine is writing {self._what}, or was when one of the two stopped",
                hint=f"wait until it has ended; if it has, remove the folder {self._folder}",
            )
        for path in self._others():
            _remove(path)
        self.path.mkdir()

    def _make_folders(self) -> bool:
        """Make the missing folders, and return whether the hidden one was among them."""
        missing = [path for path in (self._folder, *self._folder.parents) if not path.exists()]
        for path in (self._folder, *missing):
            if path.is_symlink():
                raise FileError(
                    f"cannot make the folder {path}: a symbolic link is in the way",
                    hint="remove it, or choose another name",
                )
        for path in missing[::-1]:
            self._made.append(path)  # before a signal can come between
            try:
                path.mkdir()
            except FileExistsError:
                self._made.remove(path)
                missing.remove(path)
        return self._folder in missing

    def _get_lock(self, *, is_new: bool) -> bool:
        """Try to get the lock; where there are no locks a folder that is new is taken."""
        from filelock import Timeout

        try:
            self._lock.acquire()
        except (Timeout, PermissionError, IsADirectoryError, NotADirectoryError):
            return False
        except OSError as exc:
            if exc.errno not in _NO_LOCKS:
                raise
            return is_new
        return True

    def _others(self) -> list[Path]:
        """Return the content of the folder, except this run's lock."""
        return [path for path in self._folder.iterdir() if path != self._lock_path]

    def _leave(self) -> None:
        self.remove_files()
        emptied = list(self._made)
        if self._lock.is_locked or self._lock_status:
            # Before the lock is released, so that the next run does not find it; Windows removes it then.
            # Where somebody has removed the folder, another run may have its lock by this name.
            with contextlib.suppress(OSError):
                if not self._lock_status or os.path.samestat(self._lock_status, self._lock_path.stat()):
                    self._lock_path.unlink()
            with contextlib.suppress(OSError, RuntimeError):  # a signal in the middle of it
                self._lock.release()
            emptied.append(self._folder)
        for path in dict.fromkeys(reversed(emptied)):
            with contextlib.suppress(OSError):
                path.rmdir()


def _remove(path: Path) -> None:
    """Remove a file or folder as well as possible, by a name at which nobody adds anything meanwhile."""
    renamed = path.with_name(f"{path.name}-")  # also when a signal has ended this half done
    with contextlib.suppress(OSError):
        path.replace(renamed)
    for left in (renamed, path):
        if left.is_dir() and not left.is_symlink():
            shutil.rmtree(left, ignore_errors=True)
        else:
            with contextlib.suppress(OSError):
                left.unlink()


def _system() -> str:
    """Name the running system, whose processes all meet at the same locks."""
    try:
        return Path("/proc/sys/kernel/random/boot_id").read_text(encoding="ascii").strip()
    except OSError:
        return platform.node()
