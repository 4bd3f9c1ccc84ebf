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
from pathlib import Path
from typing import TYPE_CHECKING, Final, Self

from vibro.errors import FileError
from vibro.interrupts import OnEnd

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = ["PREFIX", "Hidden", "hidden_folder"]

PREFIX: Final = ".vibro-"
_LOCK: Final = "lock-"
# How file systems say that they have no locks.
_NO_LOCKS: Final = {errno.ENOSYS, errno.ENOLCK, errno.ENOTSUP, errno.EOPNOTSUPP}
# A run that leaves, or looks whether another has ended, holds the lock for a moment.
_ATTEMPTS: Final = 30
_PAUSE: Final = 0.01  # [s]


def hidden_folder(stem: Path) -> Path:
    """Return the hidden folder of a stem; its name is short, however long that of the stem is."""
    name = os.path.normcase(stem.name).encode(errors="surrogateescape")
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
        # Without a fallback: locks of files alone tell by process numbers whether their holder is alive.
        self._lock = FileLock(self._lock_path, timeout=0, thread_local=False, fallback_to_soft=False)
        self._held = False
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

    def _take(self) -> None:
        from filelock import Timeout

        for _ in range(_ATTEMPTS):
            try:
                self._make_folders()
                self._lock.acquire()
            except (Timeout, FileNotFoundError, FileExistsError):  # another run has it, or has just left
                time.sleep(_PAUSE)
                continue
            except OSError as exc:
                if exc.errno not in _NO_LOCKS:
                    raise
                if self._folder not in self._made:  # the folder itself says that it is taken
                    break
            foreign = [path for path in self._others() if path.name.startswith(_LOCK)]
            if foreign:
                raise FileError(
                    f"another machine is writing {self._what}, or was when it or this one stopped",
                    hint=f"wait until it has ended; if it has, remove the folder {self._folder}",
                )
            for path in self._others():
                shutil.rmtree(path)
            self.path.mkdir()
            self._held = True
            return
        if not self._folder.parent.is_dir():  # a link to nothing: nobody can make it
            raise NotADirectoryError(errno.ENOTDIR, os.strerror(errno.ENOTDIR))
        raise FileError(
            f"another run is writing {self._what} at this moment",
            hint=f"wait until it has ended; if there is none, remove the folder {self._folder}",
        )

    def _make_folders(self) -> None:
        for path in reversed([p for p in (self._folder, *self._folder.parents) if not p.exists()]):
            with contextlib.suppress(FileExistsError):
                path.mkdir()
                self._made.append(path)

    def _others(self) -> Iterator[Path]:
        """Return what is in the folder beside this run's lock."""
        return (path for path in self._folder.iterdir() if path != self._lock_path)

    def _leave(self) -> None:
        shutil.rmtree(self.path, ignore_errors=True)
        emptied = list(self._made)
        if self._held or self._lock.is_locked:
            # Before it is released, as whoever gets it next finds that it is gone; Windows removes it then.
            with contextlib.suppress(OSError):
                self._lock_path.unlink()
            self._lock.release()
            emptied.append(self._folder)
        for path in reversed(emptied):
            with contextlib.suppress(OSError):
                path.rmdir()


def _system() -> str:
    """Name the running system, whose processes all meet at the same locks."""
    try:
        return Path("/proc/sys/kernel/random/boot_id").read_text(encoding="ascii").strip()
    except OSError:
        return platform.node()
