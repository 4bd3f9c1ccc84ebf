"""Folders of a sweep in shards: whole files are added one by one, and last the one that says so.

Only a run that holds the folder gives files their names. Workers, in this process or on another machine,
write to the hidden folder of their run: what an old run's worker still writes never gets in.
"""

from __future__ import annotations

import contextlib
import errno
import hashlib
import os
from typing import TYPE_CHECKING, Final, NamedTuple, Self

from vibro.errors import FileError
from vibro.interrupts import OnEnd
from vibro.output.hidden import PREFIX, Hidden, hidden_folder
from vibro.output.staging import OTHER_NAME, cannot_write, is_regular, put, reason

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Mapping
    from pathlib import Path

__all__ = ["MANIFEST", "MOST_SHARDS", "SUCCESS", "ShardFolder", "Stamp", "shard_name", "sync_file"]

# Programs that read a folder of Parquet files skip names that begin with _ or a point.
MANIFEST: Final = "_manifest.json"
SUCCESS: Final = "_SUCCESS"
MOST_SHARDS: Final = 1_000_000  # that six digits can number

_ALL: Final = "shards"


def shard_name(number: int) -> str:
    """Name the file of a shard."""
    return f"part-{number:06d}.parquet"


class Stamp(NamedTuple):
    """By which a file that somebody has changed is known: when it was [ns], and its size [B]."""

    size: int
    changed: int
    altered: int

    @classmethod
    def of(cls, path: Path) -> Self:
        """Take that of a file."""
        status = path.stat()
        return cls(status.st_size, status.st_mtime_ns, status.st_ctime_ns)


class ShardFolder:
    """The folder of a sweep in shards, held by one run; a context manager.

    Entering makes the folder, holds it and removes what killed runs left. Leaving, and a signal that ends the
    process, keep the files that are there, and remove what has no name yet.

    Parameters
    ----------
    folder : Path
        Where the shards go.
    how_to_go_on : str
        Hint for users whose run is interrupted.
    shards : str, optional
        The range of shards that this run makes, where others make other ranges at the same time.

    Attributes
    ----------
    folder : Path
        Absolute: workers may be elsewhere.
    shown : Path
        As it was given, for messages.

    Raises
    ------
    FileError
        If the folder cannot be made or written to, another run writes it, or it holds something else.
    """

    def __init__(self, folder: Path, how_to_go_on: str, shards: str = "") -> None:
        self.folder = folder.absolute()
        self.shown = folder
        self._how_to_go_on = how_to_go_on
        self._whole = hidden_folder(self.folder / _ALL)
        self._own = hidden_folder(self.folder / f"{_ALL} {shards}") if shards else self._whole
        self._hidden = Hidden(self._own, str(folder))
        self._on_end = OnEnd(lambda: how_to_go_on if (self.folder / MANIFEST).exists() else "")

    def __enter__(self) -> Self:
        try:
            self._hidden.__enter__()
        except OSError as exc:
            raise self._cannot_write(exc) from exc
        try:
            self._meet_others()
        except BaseException:
            self._hidden.__exit__()
            raise
        self._on_end.__enter__()
        return self

    def __exit__(self, kind: object, exc: BaseException | None, traceback: object) -> None:
        self._on_end.__exit__()
        self._hidden.__exit__()
        if isinstance(exc, OSError):
            raise self._cannot_write(exc) from exc
        if isinstance(exc, KeyboardInterrupt):
            exc.add_note(self._how_to_go_on)

    @property
    def hidden(self) -> Path:
        """Folder to which the workers of this run write; it is removed when the run ends."""
        return self._hidden.path

    def read(self, name: str) -> str | None:
        """Return the text of a file, None if it does not exist."""
        try:
            return (self.folder / name).read_text(encoding="utf-8")
        except FileNotFoundError:
            return None
        except (OSError, ValueError) as exc:
            why = reason(exc) if isinstance(exc, OSError) else "it is not a text in UTF-8"
            raise FileError(f"cannot read {self.shown / name}: {why}", hint=OTHER_NAME) from exc

    def check_free(self, ours: Collection[str], pictures: Collection[str]) -> None:
        """Refuse a folder that holds anything but what a sweep in shards is made of.

        Parameters
        ----------
        ours : collection of str
            The files that the manifest lists; none where there is no manifest.
        pictures : collection of str
            Those that will be written.

        Raises
        ------
        FileError
            It names what is there. Beside a manifest only tables count, which readers would take for shards,
            what would be written over, and what has the name of a file of ours and is none.
        """
        there = sorted(path.name for path in self.folder.iterdir() if not path.name.startswith("."))
        if ours:
            there = [
                name
                for name in there
                if (
                    not is_regular(self.folder / name)
                    if name in ours
                    else name.endswith(".parquet") or name in pictures
                )
            ]
        if there:
            names = ", ".join(there[:3]) + (", ..." if len(there) > 3 else "")
            raise FileError(f"{self.shown} holds something else: {names}", hint=OTHER_NAME)

    def clear(self, ours: Collection[str]) -> None:
        """Remove what says that the set is whole, then its files, and last what says that they are a set.

        Parameters
        ----------
        ours : collection of str
            The files that the manifest lists. Nothing else is removed, no link and no folder.
        """
        there = [path for path in self.folder.iterdir() if path.name in ours and is_regular(path)]
        for path in sorted(there, key=lambda path: (path.name != SUCCESS, path.name == MANIFEST, path.name)):
            path.unlink()

    def shards(self) -> set[str]:
        """Return the names of the shards that are there, whole or not."""
        return {path.name for path in self.folder.glob("part-*.parquet")}

    def write(self, name: str, text: str, *, replace: bool = True) -> None:
        """Write a small file, which appears whole."""
        with self.new(name, replace=replace) as path:
            path.write_text(text, encoding="utf-8")

    @contextlib.contextmanager
    def new(self, name: str, *, replace: bool = True) -> Iterator[Path]:
        """Give where to write a file that appears, whole, in the end."""
        path = self.hidden / name
        yield path
        with path.open("rb") as file:
            sync_file(file.fileno())
        put(path, self.folder / name, replace=replace)

    def publish(self, temporary: str, name: str) -> Stamp:
        """Give what a worker has written its name."""
        put(self.hidden / temporary, self.folder / name, replace=True)
        return Stamp.of(self.folder / name)

    def remove(self, name: str) -> None:
        """Remove a file, if it is there."""
        (self.folder / name).unlink(missing_ok=True)

    def finish(
        self, text: str, manifest: str, stamps: Mapping[str, Stamp], digests: Mapping[str, str]
    ) -> None:
        """Say that all files are there, if they are.

        Parameters
        ----------
        text : str
            Of the last file.
        manifest : str
            What the manifest says.
        stamps, digests : mapping
            By the names of all shards: their stamps since they are whole, and their SHA-256.

        Raises
        ------
        FileError
            If a file was removed, changed or added while the run went on.
        """
        self._sync_folder()
        with self.new(SUCCESS) as path:
            path.write_text(text, encoding="utf-8")
            self._check_unchanged(manifest, stamps, digests)
        self._sync_folder()

    def stop(self) -> None:
        """Stop the workers, by removing the folder to which they write."""
        self._hidden.remove_files()

    def _check_unchanged(
        self, manifest: str, stamps: Mapping[str, Stamp], digests: Mapping[str, str]
    ) -> None:
        """Refuse a folder in which somebody has removed, changed or added something that readers read."""
        during = "while this run went on"
        if self.read(MANIFEST) != manifest:
            raise FileError(
                f"{self.shown / MANIFEST} was removed or changed {during}",
                hint=f"put back what was there, or {OTHER_NAME}",
            )
        for name, stamp in stamps.items():
            if not self._is_same(name, stamp, digests[name]):
                raise FileError(
                    f"{self.shown / name} was removed or changed {during}", hint=self._how_to_go_on
                )
        added = {path.name for path in self.folder.glob("*.parquet")} - set(stamps)
        if added:
            raise FileError(
                f"{self.shown / min(added)} was added {during}, and is none of this sweep",
                hint=f"remove it; {self._how_to_go_on}",
            )

    def _is_same(self, name: str, stamp: Stamp, digest: str) -> bool:
        """Whether a file is as it was; its content is read only where it was touched."""
        path = self.folder / name
        try:
            if Stamp.of(path) == stamp:
                return True
            with path.open("rb") as file:
                return hashlib.file_digest(file, "sha256").hexdigest() == digest
        except FileNotFoundError:
            return False

    def _meet_others(self) -> None:
        """Refuse to work beside a run that may change the same files; remove what dead ones left.

        Runs of ranges work side by side; one that makes all shards works alone. Each holds its own hidden
        folder before it looks for others: of two that begin at once at least one sees the other.
        """
        others = self.folder.glob(f"{PREFIX}*") if self._own == self._whole else [self._whole]
        for folder in others:
            if folder != self._own and folder.exists():
                with Hidden(folder, str(self.shown)):
                    pass

    def _sync_folder(self) -> None:
        if os.name == "posix":  # elsewhere folders cannot be opened
            number = os.open(self.folder, os.O_RDONLY)
            try:
                sync_file(number)
            finally:
                os.close(number)

    def _cannot_write(self, exc: OSError) -> FileError:
        return cannot_write(exc, self.shown, f"free some space; {self._how_to_go_on}")


def sync_file(number: int) -> None:
    """Flush a file to disk; some file systems do not support it."""
    try:
        os.fsync(number)
    except OSError as exc:
        if exc.errno not in (errno.EINVAL, errno.ENOTSUP, errno.EROFS):
            raise
