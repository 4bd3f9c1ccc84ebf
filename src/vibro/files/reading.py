"""Read a file, or suggest the one beside it that was meant."""

from __future__ import annotations

from typing import TYPE_CHECKING

from vibro.errors import FileError, did_you_mean

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
    return did_you_mean(path.name, names, before=str(path).removesuffix(path.name))
