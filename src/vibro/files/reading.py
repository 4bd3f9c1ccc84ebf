"""Read files and the cells of tables in them: in any encoding that spreadsheets and instruments write."""

from __future__ import annotations

import csv
import io
from typing import TYPE_CHECKING

from vibro.errors import FileError, InputError, did_you_mean

if TYPE_CHECKING:
    from pathlib import Path


def content_of(path: Path, endings: tuple[str, ...], *, folders: bool = False) -> bytes:
    """Read a file.

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
        return path.read_bytes()
    except (OSError, ValueError) as exc:  # ValueError: the path has a zero character
        near = f"give a file, such as NAME{endings[0]}" if path.is_dir() else _near(path, endings, folders)
        raise FileError(f"cannot read {path}: {getattr(exc, 'strerror', None) or exc}", hint=near) from exc


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
        If it is no text.
    """
    data = content_of(path, (".csv", ".txt"))
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
