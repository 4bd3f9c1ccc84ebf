"""Read files and the cells of tables in them: in any encoding that spreadsheets and instruments write."""

from __future__ import annotations

import csv
import errno
import io
import os
import stat
from typing import TYPE_CHECKING, BinaryIO, Final

from vibro.errors import FileError, InputError, did_you_mean

if TYPE_CHECKING:
    from pathlib import Path


_MOST_BYTES: Final = 2**28  # of a file: its table takes ten times as much memory
_LONGEST_LINE: Final = 100_000  # characters; a table of a million columns would take minutes


def opened(path: Path) -> BinaryIO:
    """Open a regular file.

    Raises
    ------
    OSError
        If it cannot be opened, or is something else: a pipe, which gives its content once, or a device,
        which may never end.
    """
    return open(path, "rb", opener=_open)


def _open(path: str, flags: int) -> int:
    # A pipe would hold up the opening until somebody writes to it.
    number = os.open(path, flags | getattr(os, "O_NONBLOCK", 0))
    mode = os.fstat(number).st_mode
    if stat.S_ISREG(mode):
        return number
    os.close(number)
    code = errno.EISDIR if stat.S_ISDIR(mode) else errno.EINVAL
    raise OSError(code, os.strerror(code) if stat.S_ISDIR(mode) else "it is no regular file", path)


def content_of(path: Path, endings: tuple[str, ...], *, folders: bool = False) -> bytes:
    """Read a file of at most 256 MiB.

    Parameters
    ----------
    path : Path
        The file.
    endings : tuple of str
        Those of files to suggest in its place, in lower case: ``(".csv", ".txt")``.
    folders : bool
        Whether to suggest folders too.

    Raises
    ------
    FileError
        If it cannot be read.
    """
    try:
        with opened(path) as stream:
            size = os.fstat(stream.fileno()).st_size
            content = (stream.read(_MOST_BYTES + 1) or b"") if size <= _MOST_BYTES else b""
        if max(size, len(content)) > _MOST_BYTES:
            raise OSError(errno.EFBIG, f"it has more than {_MOST_BYTES >> 20} MiB")
        return content
    except (OSError, ValueError) as exc:  # ValueError: the path has a zero character
        near = f"give a file, such as NAME{endings[0]}" if _is_other(path) else _near(path, endings, folders)
        raise FileError(f"cannot read {path}: {getattr(exc, 'strerror', None) or exc}", hint=near) from exc


def _is_other(path: Path) -> bool:
    """Whether there is something that is no regular file."""
    try:
        return not stat.S_ISREG(path.stat().st_mode)
    except (OSError, ValueError):
        return False


def _near(path: Path, endings: tuple[str, ...], folders: bool) -> str:
    try:
        there = [*path.parent.iterdir()]
        names = [p.name for p in there if p.suffix.casefold() in endings or (folders and p.is_dir())]
    except (OSError, ValueError):
        return ""
    typed = path.name if path.suffix else path.name + endings[0]
    return did_you_mean(typed, names, cutoff=0.7, before=str(path).removesuffix(path.name))


def read_text(path: Path) -> tuple[str, list[str]]:
    """Return the text of a file, and a note if it is not in UTF-8.

    Raises
    ------
    FileError
        If it cannot be read.
    InputError
        If it is no text, or has a line of more than 100 000 characters.
    """
    text, notes = _decoded(path, content_of(path, (".csv", ".txt")))
    for row, line in enumerate(text.splitlines(), 1) if len(text) > _LONGEST_LINE else ():
        if len(line) > _LONGEST_LINE:
            hint = f"export the columns that you need, with at most {_LONGEST_LINE} characters a row"
            raise InputError(f"{path}: row {row} has {len(line)} characters", hint=hint)
    return text, notes


def _decoded(path: Path, data: bytes) -> tuple[str, list[str]]:
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        try:
            return data.decode("utf-16"), [f"{path.name}: UTF-16"]
        except UnicodeDecodeError as exc:
            raise InputError(f"{path}: not a text file", hint="save it as CSV") from exc
    if b"\0" in data[:4096]:
        raise InputError(f"{path}: not a text file", hint="export the table as CSV")
    try:
        return data.decode("utf-8-sig"), []
    except UnicodeDecodeError:
        # Older spreadsheets write micro and degree signs in this code page. A byte that it does not define
        # cannot be part of a unit: replace it.
        return data.decode("cp1252", errors="replace"), [f"{path.name}: not UTF-8, read as Windows-1252"]


def rows_of(path: Path, text: str, separator: str) -> list[tuple[int, list[str]]]:
    """Split lines into cells, without blank lines; number them as editors and spreadsheets do."""
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=separator)
    try:
        rows = [(reader.line_num, [cell.strip() for cell in cells]) for cells in reader]
    except csv.Error as exc:
        raise InputError(f"{path}: not a table: {exc}", hint="export the table as CSV") from exc
    return [(row, cells) for row, cells in rows if any(cells)]
