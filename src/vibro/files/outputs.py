"""Sets of output files that appear whole or not at all."""

from __future__ import annotations

import contextlib
import errno
import os
import re
import shutil
import signal
import sys
import threading
import time
from pathlib import Path
from typing import TYPE_CHECKING, Final, Self

from vibro.errors import FileError

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from types import TracebackType

__all__ = ["OutputSet", "output_stem", "suffixed"]

# A spreadsheet holds a file for as long as it is open, a virus scanner for a moment: outlast the scanner.
_RENAME_ATTEMPTS: Final = 10
_RENAME_PAUSE: Final = 0.2  # [s]

_TEMPORARY: Final = re.compile(r"\.vibro-(\d+)-\d+\.tmp")


def output_stem(output: str | None, name: str) -> Path:
    """Find the stem of the output files.

    Parameters
    ----------
    output : str or None
        What the user gave: a stem, or a folder (it exists or ends in a separator), which takes ``name``.
    name : str
        The scene's name.

    Returns
    -------
    Path
        Suffixes are appended to it by ``suffixed``.
    """
    if output is None:
        return Path(name)
    separators = (os.sep, os.altsep or os.sep)
    if output.endswith(separators) or Path(output).is_dir():
        return Path(output) / name
    return Path(output)


def suffixed(stem: Path, suffix: str) -> Path:
    """Append a suffix to a stem, whatever dots the stem has: ``run1.5`` becomes ``run1.5.csv``."""
    return stem.with_name(stem.name + suffix)


class OutputSet:
    """Output files that are written under temporary names and renamed together at the end.

    Entering makes the folder, sweeps what killed runs left there, and refuses existing targets. Leaving
    renames the temporary files; leaving by an exception removes them, and the folders that were made.

    Parameters
    ----------
    targets : sequence of Path
        The files, in the order of renaming; all in one folder.
    force : bool
        Whether existing targets may be replaced.

    Raises
    ------
    FileError
        If the folder cannot be made or written to, or a target exists or cannot be written.
    """

    def __init__(self, targets: Sequence[Path], *, force: bool) -> None:
        self.folder = targets[0].parent
        self.force = force
        # The name says whose file it is, and is never longer than what the file system takes.
        self._temporary = {t: self.folder / f".vibro-{os.getpid()}-{i}.tmp" for i, t in enumerate(targets)}
        self._made: list[Path] = []

    def __getitem__(self, target: Path) -> Path:
        """Return the temporary name to write a target to."""
        return self._temporary[target]

    def __enter__(self) -> Self:
        try:
            self._make_folder()
            self._check_targets()
            for path in self._temporary.values():
                self._open_first(path)
        except BaseException:
            self._discard()
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, exc: BaseException | None, traceback: TracebackType | None
    ) -> None:
        if kind is None:
            with _uninterrupted():
                try:
                    for target, path in self._temporary.items():
                        _rename(path, target)
                except BaseException:
                    self._discard()
                    raise
            return
        self._discard()
        if isinstance(exc, OSError) and not isinstance(exc, BrokenPipeError):
            hint = "free some space, or choose another place with -o" if exc.errno == errno.ENOSPC else ""
            raise FileError(f"cannot write to {self.folder}: {_reason(exc)}", hint=hint) from exc

    def free_space(self) -> int:
        """Return the bytes that are free where the files go."""
        return shutil.disk_usage(self.folder).free

    def _make_folder(self) -> None:
        missing = [p for p in (self.folder, *self.folder.parents) if not p.exists()]
        try:
            for path in reversed(missing):
                path.mkdir(exist_ok=True)
                self._made.append(path)
            leftovers = list(self.folder.iterdir())
        except OSError as exc:
            in_the_way = next((p for p in (self.folder, *self.folder.parents) if p.is_file()), None)
            hint = f"{in_the_way} is a file" if in_the_way else ""
            raise FileError(f"cannot use the folder {self.folder}: {_reason(exc)}", hint=hint) from exc
        for path in leftovers:
            match = _TEMPORARY.fullmatch(path.name)
            if match and not _is_running(int(match[1])):
                with contextlib.suppress(OSError):
                    path.unlink()

    def _check_targets(self) -> None:
        for target in self._temporary:
            if target.is_dir():
                raise FileError(f"cannot write {target}: a folder is in the way")
        existing = [str(target) for target in self._temporary if target.exists()]
        if existing and not self.force:
            verb = "exists" if len(existing) == 1 else "exist"
            raise FileError(
                f"{', '.join(existing)} {verb} already",
                hint="replace with --force, or choose another name with -o",
            )

    def _open_first(self, path: Path) -> None:
        try:
            path.touch()
        except OSError as exc:
            raise FileError(
                f"cannot write to {self.folder}: {_reason(exc)}", hint="choose another place with -o"
            ) from exc

    def _discard(self) -> None:
        with _uninterrupted():
            for path in self._temporary.values():
                with contextlib.suppress(OSError):
                    path.unlink()
            for path in reversed(self._made):
                with contextlib.suppress(OSError):
                    path.rmdir()


def _rename(path: Path, target: Path) -> None:
    for attempt in range(_RENAME_ATTEMPTS):
        try:
            path.replace(target)
        except PermissionError as exc:
            if attempt + 1 == _RENAME_ATTEMPTS:
                raise FileError(
                    f"cannot replace {target}: {_reason(exc)}",
                    hint="close it in the program that holds it open",
                ) from exc
            time.sleep(_RENAME_PAUSE)
        except OSError as exc:
            raise FileError(f"cannot write {target}: {_reason(exc)}") from exc
        else:
            return


@contextlib.contextmanager
def _uninterrupted() -> Iterator[None]:
    """Hold signals off while files are renamed or removed: half of either must not remain."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = {s: signal.signal(s, signal.SIG_IGN) for s in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _is_running(pid: int) -> bool:
    if sys.platform == "win32":
        # os.kill would end the process there.
        import ctypes

        synchronize, access_denied = 0x00100000, 5
        handle = ctypes.windll.kernel32.OpenProcess(synchronize, False, pid)
        if handle:
            ctypes.windll.kernel32.CloseHandle(handle)
            return True
        return bool(ctypes.windll.kernel32.GetLastError() == access_denied)
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except (PermissionError, OverflowError):
        return True
    return True


def _reason(exc: OSError) -> str:
    return exc.strerror or str(exc)
