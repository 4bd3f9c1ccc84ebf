"""Output files of a run: tables, pictures and the JSON that records how they were made."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any, Self

from vibro import __version__
from vibro.files.outputs import OutputSet
from vibro.files.stems import file_suffix, suffixed

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from pathlib import Path
    from types import TracebackType
    from typing import TextIO

    Save = Callable[[str, Path, str, Mapping[str, str]], None]

__all__ = ["Publication", "json_text"]


def json_text(content: Mapping[str, Any]) -> str:
    """Write JSON for people; numbers that JSON does not know are refused."""
    return json.dumps(content, indent=2, allow_nan=False)


class Publication:
    """The outputs of one run at one stem, all or none: STEM.csv, STEM-regime.png, ..., and STEM.json.

    Parameters
    ----------
    stem : Path
        To which suffixes are appended.
    argv : sequence of str
        The arguments of the run, told in the JSON.
    force : bool
        Whether existing files may be replaced.
    tell : callable
        Is told of every file that is written or removed, and of an incomplete set that is replaced.
    tables, pictures : sequence of str
        Names of tables and pictures, each appended to the stem after a hyphen; the empty name stands for
        the stem itself.
    formats : sequence of str
        Of every picture.
    reads : sequence of Path or None
        Files that are never replaced: the run's own input.

    Raises
    ------
    FileError
        On entering, if the files cannot be written; on leaving, if they could not be put in place.
    """

    def __init__(
        self,
        stem: Path,
        argv: Sequence[str],
        *,
        force: bool,
        tell: Callable[[str], None],
        tables: Sequence[str] = ("",),
        pictures: Sequence[str] = (),
        formats: Sequence[str] = (),
        reads: Sequence[Path | None] = (),
    ) -> None:
        self._argv = ["vibro", *argv]
        self._tables = {name: suffixed(stem, file_suffix(name, "csv")) for name in tables}
        self._pictures = {
            (name, form): suffixed(stem, file_suffix(name, form)) for name in pictures for form in formats
        }
        self._json = suffixed(stem, ".json")
        self._targets = [*self._tables.values(), *self._pictures.values(), self._json]
        self._files = OutputSet(stem, self._targets, force=force, tell=tell, reads=reads)

    @property
    def folder(self) -> Path:
        """Where the files go."""
        return self._files.folder

    def free_space(self) -> int:
        """Return the bytes that are free where the files go."""
        return self._files.free_space()

    def table(self, name: str = "") -> TextIO:
        """Open a table for writing."""
        return self._files[self._tables[name]].open("w", encoding="utf-8", newline="")

    def finish(self, content: Mapping[str, Any], save: Save | None = None) -> dict[str, Any]:
        """Write the pictures, which carry the content of the JSON, and the JSON.

        Parameters
        ----------
        content : mapping
            What the JSON says beside version, arguments and files.
        save : callable, optional
            ``save(name, path, format, metadata)`` writes a picture. Without it there are none.

        Returns
        -------
        dict
            All that the JSON says.
        """
        for path in self._pictures.values() if save is None else ():
            self._files.leave_out(path)
            self._targets.remove(path)
        files = [target.name for target in self._targets]
        whole = {"version": __version__, "argv": self._argv, **content, "files": files}
        metadata = {"Software": f"vibro {__version__}", "Description": json.dumps(whole, allow_nan=False)}
        if save is not None:
            for (name, form), path in self._pictures.items():
                save(name, self._files[path], form, metadata)
        self._files[self._json].write_text(json_text(whole) + "\n", encoding="utf-8")
        return whole

    def __enter__(self) -> Self:
        self._files.__enter__()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, exc: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self._files.__exit__(kind, exc, traceback)
