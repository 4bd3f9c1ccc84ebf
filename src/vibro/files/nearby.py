"""Files whose names are close to one that cannot be read."""

from __future__ import annotations

from typing import TYPE_CHECKING

from vibro.errors import did_you_mean

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["suggestion"]


def suggestion(path: Path, suffixes: tuple[str, ...], *, folders: bool = False) -> str:
    """Suggest a file beside one that cannot be read, for the hint of an error.

    Parameters
    ----------
    path : Path
        What could not be read.
    suffixes : tuple of str
        Endings of the files to suggest, in lower case: ``(".csv", ".txt")``.
    folders : bool
        Whether to suggest folders too.

    Returns
    -------
    str
        A question; empty where the folder holds nothing with such a name.
    """
    try:
        there = [*path.parent.iterdir()]
        names = [p.name for p in there if p.suffix.casefold() in suffixes or (folders and p.is_dir())]
    except OSError:
        return ""
    return did_you_mean(path.name, names, before=str(path).removesuffix(path.name))
