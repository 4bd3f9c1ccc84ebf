"""Tables in parts: a folder to which complete files are added one by one, and last a file that says so.

Only who holds the folder's claim gives files their names. Others, in this process or on another machine,
write to hidden names of their own, and tell them: what an old run's worker still writes never gets in.
"""

from __future__ import annotations

import contextlib
import errno
import os
import re
from pathlib import Path
from typing import TYPE_CHECKING, Final, Self

from vibro.errors import FileError, InputError
from vibro.files.claims import Claim
from vibro.files.placing import is_regular, reason
from vibro.files.stems import PICTURE_FORMATS, PICTURES
from vibro.interrupts import HeldOff, Undone

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from types import TracebackType

__all__ = [
    "MANIFEST",
    "MOST_PARTS",
    "SUCCESS",
    "PartSet",
    "new_part",
    "part_folder",
    "part_name",
    "sync_file",
]

MANIFEST: Final = "manifest.json"
SUCCESS: Final = "_SUCCESS"
MOST_PARTS: Final = 1_000_000  # that six digits can number

_OURS: Final = re.compile(
    rf"part-\d{{6}}\.parquet|{re.escape(MANIFEST)}|{SUCCESS}|({'|'.join(PICTURES)})\.({'|'.join(PICTURE_FORMATS)})"
)
_TEMPORARY: Final = re.compile(r"\.part-\d{6}-([0-9a-f]{16})-[0-9a-f]{16}")
_OTHER_NAME: Final = "choose another name with -o"


def part_folder(output: str | None, name: str) -> Path:
    """Find the folder of a table in parts: the one that is given, or one of the scene's name.

    Raises
    ------
    InputError
        If it can be no folder's name.
    """
    if output is None:
        return Path(name)
    if not output or "\0" in output or output == "-":
        raise InputError(f"-o {output!r}: parts go into a folder", hint="give it a name, such as -o out/wide")
    path = Path(output)
    if path.suffix.casefold() in (".csv", ".parquet", ".json"):
        raise InputError(f"-o {output}: parts go into a folder", hint=f"write -o {path.with_suffix('')}")
    return path


def part_name(number: int) -> str:
    """Name a part."""
    return f"part-{number:06d}.parquet"


def new_part(folder: Path, number: int, run: str) -> Path:
    """Return a hidden name for what a run writes of a part, which nobody else has."""
    return folder / f".part-{number:06d}-{run}-{os.urandom(8).hex()}"


class PartSet:
    """The folder of a table in parts, and the right to publish in it.

    Entering makes the folder, takes its claim and removes the temporaries of runs before. Leaving by an
    exception, and a signal that ends the process, keep the parts that are there and nothing else of this run.

    Parameters
    ----------
    folder : Path
        Where the parts go.
    how_to_go_on : str
        What to tell users whose run is cut short.

    Attributes
    ----------
    folder : Path
        Absolute: workers may be elsewhere.
    shown : Path
        As it was given, for messages.
    run : str
        In the names of this run's temporaries.
    wanted : Path
        A file that is there as long as anybody wants parts of this run.

    Raises
    ------
    FileError
        If the folder cannot be made or written to, another run writes it, or it holds something else.
    """

    def __init__(self, folder: Path, how_to_go_on: str) -> None:
        self.folder = folder.absolute()
        self.run = os.urandom(8).hex()
        self.wanted = self.folder
        self.shown = folder
        self._how_to_go_on = how_to_go_on
        self._claim = Claim(self.folder / "parts", what=str(folder))
        self._undone = Undone(self._end_early)

    def __enter__(self) -> Self:
        self._undone.__enter__()
        try:
            with HeldOff():
                self._take()
        except BaseException as exc:
            self._leave()
            if isinstance(exc, OSError):
                raise self._cannot_write(exc) from exc
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, exc: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self._leave()
        if isinstance(exc, OSError):
            raise self._cannot_write(exc) from exc
        if isinstance(exc, KeyboardInterrupt):
            exc.add_note(self._how_to_go_on)

    def read(self, name: str) -> str | None:
        """Return the text of a file, None where there is none."""
        try:
            return (self.folder / name).read_text(encoding="utf-8")
        except FileNotFoundError:
            return None
        except (OSError, ValueError) as exc:
            why = reason(exc) if isinstance(exc, OSError) else "it is no text in UTF-8"
            raise FileError(f"cannot read {self.shown / name}: {why}", hint=_OTHER_NAME) from exc

    def check_free(self) -> None:
        """Refuse a folder that holds anything but what a table in parts is made of.

        Raises
        ------
        FileError
            It names what is there. Beside a manifest only tables count, which readers would take for parts,
            and what has the name of a file of ours and is none.
        """
        there = sorted(path.name for path in self.folder.iterdir() if not path.name.startswith("."))
        if MANIFEST in there:
            there = [
                name
                for name in there
                if (
                    not is_regular(self.folder / name) if _OURS.fullmatch(name) else name.endswith(".parquet")
                )
            ]
        if there:
            names = ", ".join(there[:3]) + (", ..." if len(there) > 3 else "")
            raise FileError(f"{self.shown} holds something else: {names}", hint=_OTHER_NAME)

    def clear(self) -> None:
        """Remove what says that the set is whole, then all of its files."""
        names = {path.name for path in self.folder.iterdir() if _OURS.fullmatch(path.name)}
        with HeldOff():
            for name in sorted(names, key=lambda name: (name != SUCCESS, name == MANIFEST, name)):
                (self.folder / name).unlink()

    def parts(self) -> set[str]:
        """Return the names of the parts that are there, whole or not."""
        return {path.name for path in self.folder.glob("part-*.parquet") if _OURS.fullmatch(path.name)}

    def write(self, name: str, text: str) -> None:
        """Write a small file, which appears whole."""
        with self.new(name) as path:
            path.write_text(text, encoding="utf-8")

    @contextlib.contextmanager
    def new(self, name: str) -> Iterator[Path]:
        """Give where to write a file that appears, whole, in the end."""
        path = self._claim.new_file()
        yield path
        with path.open("rb") as file:
            sync_file(file.fileno())
        self._put(path, name)

    def publish(self, temporary: str, name: str) -> None:
        """Give what a worker has written its name."""
        self._put(self.folder / temporary, name)

    def remove(self, name: str) -> None:
        """Remove a file, if it is there."""
        (self.folder / name).unlink(missing_ok=True)

    def finish(self, text: str) -> None:
        """Say that all files are there."""
        self._remove_temporaries(lambda run, changed: True)
        self._sync_folder()
        with HeldOff() as signals:
            self.write(SUCCESS, text)
            self._sync_folder()
            signals.done()

    def stop(self) -> None:
        """Let workers know that nobody wants their parts any more."""
        self.wanted.unlink(missing_ok=True)

    def _put(self, path: Path, name: str) -> None:
        path.replace(self.folder / name)

    def _take(self) -> None:
        self._claim.take_in_folder()
        self.wanted = self._claim.new_file()
        taken = self.wanted.stat().st_mtime_ns
        self._remove_temporaries(lambda run, changed: changed <= taken)  # clocks of files tick seldom

    def _remove_temporaries(self, which: Callable[[str, int], bool]) -> None:
        """Remove temporaries by their run and when they were changed [ns]."""
        for path in self.folder.glob(".part-*"):
            match = _TEMPORARY.fullmatch(path.name)
            with contextlib.suppress(FileNotFoundError):
                if match and which(match[1], path.stat().st_mtime_ns):
                    path.unlink()

    def _leave(self) -> None:
        with HeldOff():
            self._discard()
        self._undone.__exit__()

    def _discard(self) -> None:
        # First what says that parts are wanted: whoever finishes one from now on removes it.
        self._claim.give_up()
        with contextlib.suppress(OSError):
            self._remove_temporaries(lambda run, changed: run == self.run)
        self._claim.remove_made()

    def _end_early(self) -> str:
        self._discard()
        return self._how_to_go_on if (self.folder / MANIFEST).exists() else ""

    def _sync_folder(self) -> None:
        if os.name == "posix":  # elsewhere folders cannot be opened
            number = os.open(self.folder, os.O_RDONLY)
            try:
                sync_file(number)
            finally:
                os.close(number)

    def _cannot_write(self, exc: OSError) -> FileError:
        in_the_way = next((p for p in (self.folder, *self.folder.parents) if is_regular(p)), None)
        hint = _OTHER_NAME
        if exc.errno == errno.ENOSPC:
            hint = f"free some space; {self._how_to_go_on}"
        elif in_the_way:
            hint = f"{in_the_way} is a file; {_OTHER_NAME}"
        return FileError(f"cannot write to {self.shown}: {reason(exc)}", hint=hint)


def sync_file(number: int) -> None:
    """Have the system put a file on its disk; some file systems cannot be told."""
    try:
        os.fsync(number)
    except OSError as exc:
        if exc.errno not in (errno.EINVAL, errno.ENOTSUP, errno.EROFS):
            raise
