"""Claims: of several runs at one stem only one writes, and none touches what another may be writing.

A claim is a hidden folder beside the files, named after their stem, in which they wait until they are whole.
It comes into being by a renaming, which no two runs succeed in, and holds a lock that the system drops with
its holder: whoever gets the lock of another knows that the run is there no more.
"""

from __future__ import annotations

import contextlib
import errno
import hashlib
import os
import re
import sys
import time
from pathlib import Path
from typing import Final

from vibro.errors import FileError

if sys.platform != "win32":
    import fcntl

__all__ = ["Claim", "sweep"]

_NAME: Final = re.compile(r"\.vibro-[0-9a-f]{16}")
_FOREIGN_AGE: Final = 30 * 24 * 3600.0  # [s] far beyond any run, and any difference of clocks
_ATTEMPTS: Final = 100  # each costs somebody else one of theirs


class Claim:
    """The right to write the files of one stem, and the place where they wait.

    Parameters
    ----------
    stem : Path
        Whose folder exists.

    Attributes
    ----------
    folder : Path
        The place, once it is taken.
    """

    def __init__(self, stem: Path) -> None:
        name = os.path.normcase(stem.name).encode(errors="surrogateescape")
        self.stem = stem
        self.folder = stem.with_name(f".vibro-{hashlib.sha256(name).hexdigest()[:16]}")
        self._lock: int | None = None
        self._held = False

    def take(self) -> None:
        """Take it.

        Raises
        ------
        FileError
            If another run has it.
        OSError
            If the folder cannot be made.
        """
        for _ in range(_ATTEMPTS):
            place = self.stem.with_name(f".vibro-{os.urandom(8).hex()}")
            place.mkdir()
            try:
                (place / _lock_name()).touch()
                place.rename(self.folder)
                self._lock = _hold(self.folder / _lock_name())
            except (FileNotFoundError, BlockingIOError):  # not held yet, it was swept as a dead run's
                continue
            except OSError as exc:
                _remove(place)
                if exc.errno not in (errno.EEXIST, errno.ENOTEMPTY):
                    raise
                if not _removed(self.folder):
                    break
            else:
                self._held = True
                return
        raise FileError(
            f"another run is writing {self.stem}.* at this moment",
            hint=f"wait until it has ended; if there is none, remove the folder {self.folder}",
        )

    def new_name(self) -> Path:
        """Return a name in the folder that nobody else has."""
        return self.folder / os.urandom(8).hex()

    def new_file(self) -> Path:
        """Make an empty file in the folder, with the rights that new files have."""
        path = self.new_name()
        os.close(os.open(path, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
        return path

    def give_up(self) -> None:
        """Remove the folder and all that is in it; do nothing without a claim."""
        if self._held:
            self._held = False
            if sys.platform == "win32" and self._lock is not None:  # what is open cannot be removed there
                os.close(self._lock)
            _remove(self.folder)
            if sys.platform != "win32" and self._lock is not None:
                os.close(self._lock)


def sweep(folder: Path) -> None:
    """Remove the claims that killed runs left in a folder, if it can be listed."""
    try:
        with os.scandir(folder) as entries:
            claims = [e.path for e in entries if _NAME.fullmatch(e.name) and e.is_dir(follow_symlinks=False)]
    except OSError:
        return
    for path in claims:
        _removed(Path(path))


def _lock_name() -> str:
    """Name a lock after the running system: file systems may hide one system's locks from another."""
    try:
        boot = Path("/proc/sys/kernel/random/boot_id").read_text(encoding="ascii").strip()
    except OSError:
        boot = sys.platform
    return f"lock-{boot}"


def _hold(path: Path) -> int | None:
    """Get a lock; None where there are no locks.

    Raises
    ------
    BlockingIOError
        If somebody else has it.
    FileNotFoundError
        If it is there no more.
    """
    lock = os.open(path, os.O_RDWR)
    if sys.platform == "win32":
        return lock  # what is open cannot be removed there
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        # Before it was to be had its folder may have been removed, and another been made by that name.
        if not os.path.samestat(os.fstat(lock), path.stat()):
            raise BlockingIOError
    except (FileNotFoundError, BlockingIOError):
        os.close(lock)
        raise
    except OSError:
        os.close(lock)
        return None
    return lock


def _removed(folder: Path) -> bool:
    """Remove a claim if nobody can hold it any more, and tell whether."""
    path = folder / _lock_name()
    lock = None
    try:
        if sys.platform == "win32":
            path.unlink()
        else:
            lock = _hold(path)
        is_left = lock is not None or sys.platform == "win32" or _is_old(folder)
    except FileNotFoundError:  # of another system, or half made or half removed: then it is empty
        is_left = _is_empty(folder) or _is_old(folder)
    except OSError:
        is_left = False
    if is_left:
        _remove(folder)
    if lock is not None:
        os.close(lock)
    return is_left


def _is_empty(folder: Path) -> bool:
    return next(folder.iterdir(), None) is None


def _is_old(folder: Path) -> bool:
    """Whether nothing in a folder has changed for so long that no run can be behind it."""
    try:
        paths = [folder, *folder.iterdir()]
        return time.time() - max(path.lstat().st_mtime for path in paths) > _FOREIGN_AGE
    except OSError:
        return False


def _remove(folder: Path) -> None:
    """Remove a claim, its lock after all else in it: where that cannot be, the next run goes on with it."""
    with contextlib.suppress(OSError):
        for path in sorted(folder.iterdir(), key=lambda p: p.name.startswith("lock-")):
            path.unlink()
        folder.rmdir()
