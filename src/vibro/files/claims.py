"""Claims: only one of several runs writes the files of a stem, and no run touches files of another.

A claim is a hidden folder beside the files, named after their stem, which holds them until they are complete.
It is created by renaming, at which only one run can succeed. It contains a lock that the system releases when
its process ends: a run that obtains another's lock knows that the other has ended.
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
# A run that tests whether another has ended holds the other's lock for a moment.
_ATTEMPTS: Final = 20
_PAUSE: Final = 0.005  # [s]
_REMOVALS: Final = 3  # a disk that fails once need not leave anything


class Claim:
    """The right to write the files of one stem, and the folder that holds them until they are complete.

    Parameters
    ----------
    stem : Path
        Whose folder exists.
    what : str, optional
        What is written, for messages.

    Attributes
    ----------
    folder : Path
        The place, once it is taken.
    """

    def __init__(self, stem: Path, what: str = "") -> None:
        name = os.path.normcase(stem.name).encode(errors="surrogateescape")
        self.stem = stem
        self._what = what or f"{stem}.*"
        self.folder = stem.with_name(f".vibro-{hashlib.sha256(name).hexdigest()[:16]}")
        self._lock: int | None = None
        self._paths: list[Path] = []
        self._made: list[Path] = []

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
            place = self.stem.with_name(f".vibro-{_random()}")
            place.mkdir()
            name = f"{_lock_name()}-{_random()}"
            try:
                (place / name).touch()
                place.rename(self.folder)
                self._lock = _hold(self.folder / name)
            except (FileNotFoundError, BlockingIOError):  # not held yet, it was swept as a dead run's
                pass
            except OSError as exc:
                _remove(place, [place / name])
                if exc.errno not in (errno.EEXIST, errno.ENOTEMPTY):
                    raise
                if _removed(self.folder):
                    continue
            else:
                self._paths = [self.folder / name]
                return
            time.sleep(_PAUSE)
        raise FileError(
            f"another run is writing {self._what} at this moment",
            hint=f"wait until it has ended; if there is none, remove the folder {self.folder}",
        )

    def take_in_folder(self) -> None:
        """Make the folder of the stem if it is not there, take the claim, and sweep the folder.

        Raises
        ------
        FileError, OSError
            As for ``take``; if a folder cannot be made.
        """
        folder = self.stem.parent
        for attempt in range(_ATTEMPTS):
            for path in reversed([p for p in (folder, *folder.parents) if not p.exists()]):
                with contextlib.suppress(FileExistsError):
                    path.mkdir()
                    self._made.append(path)
            try:
                self.take()
                break
            except FileNotFoundError:  # another run that had made the folder has just removed it
                if attempt + 1 == _ATTEMPTS:
                    raise
        sweep(folder)

    def remove_made(self) -> None:
        """Remove the folders that ``take_in_folder`` has made, as far as they are empty."""
        for path in reversed(self._made):
            with contextlib.suppress(OSError):
                path.rmdir()
        self._made.clear()

    def new_name(self) -> Path:
        """Return a name in the folder that nobody else has; a file by it goes with the claim."""
        path = self.folder / _random()
        self._paths.insert(0, path)
        return path

    def new_file(self) -> Path:
        """Make an empty file in the folder, with the rights that new files have."""
        path = self.new_name()
        os.close(os.open(path, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
        return path

    def give_up(self) -> None:
        """Remove the folder and all that is in it; do nothing without a claim."""
        if sys.platform == "win32" and self._lock is not None:  # what is open cannot be removed there
            os.close(self._lock)
            self._lock = None
        for _ in range(_REMOVALS if self._paths else 0):
            if _remove(self.folder, self._paths):
                break
        self._paths = []
        if self._lock is not None:
            os.close(self._lock)
            self._lock = None


def sweep(folder: Path) -> None:
    """Remove the claims that killed runs left in a folder, if it can be listed."""
    try:
        with os.scandir(folder) as entries:
            claims = [e.path for e in entries if _NAME.fullmatch(e.name) and e.is_dir(follow_symlinks=False)]
    except OSError:
        return
    for path in claims:
        _removed(Path(path))


def _random() -> str:
    return os.urandom(8).hex()


def _lock_name() -> str:
    """Name locks after the running system: file systems may hide one system's from another."""
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
        path.stat()  # it may have been removed before it was to be had
    except (FileNotFoundError, BlockingIOError):
        os.close(lock)
        raise
    except OSError:
        os.close(lock)
        return None
    return lock


def _removed(folder: Path) -> bool:
    """Remove a claim if nobody can hold it any more, and tell whether it is gone.

    What is removed are the files that were there when that was found out, whose names no other claim has:
    meanwhile somebody else may have removed them, and a third have made the claim anew.
    """
    held = None
    try:
        paths = sorted(folder.iterdir(), key=lambda path: path.name.startswith("lock-"))
        lock = next((path for path in paths if path.name.startswith(_lock_name())), None)
        if lock is None:
            # Without files it was half made or half removed, with some it is another system's.
            dead = not paths
        elif sys.platform == "win32":
            lock.unlink()
            dead = True
        else:
            held = _hold(lock)
            dead = held is not None
    except FileNotFoundError:
        return True
    except OSError:
        return False
    try:
        return (dead or _are_old(paths)) and _remove(folder, paths)
    finally:
        if held is not None:
            os.close(held)


def _are_old(paths: list[Path]) -> bool:
    """Whether files are unchanged for so long that no run can still be writing them."""
    try:
        return time.time() - max(path.lstat().st_mtime for path in paths) > _FOREIGN_AGE
    except OSError:
        return False


def _remove(folder: Path, paths: list[Path]) -> bool:
    """Remove files, the lock last, and their folder; tell whether it is gone.

    What cannot be removed keeps its lock: the next run goes on with it.
    """
    try:
        for path in paths:
            path.unlink(missing_ok=True)
        folder.rmdir()
    except FileNotFoundError:
        return True
    except OSError:
        return False
    return True
