"""Files whose names are close to one that cannot be read."""

from __future__ import annotations

import difflib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["suggestion"]


def suggestion(path: Path, suffixes: tuple[str, ...]) -> str:
    """Suggest a file beside one that cannot be read, for the hint of an error.

    Parameters
    ----------
    path : Path
        What could not be read.
    suffixes : tuple of str
        Endings of the files to suggest, in lower case: ``(".csv", ".txt")``.

    Returns
    -------
    str
        A question; empty where the folder holds no file with such a name.
    """
    try:
        names = [p.name for p in path.parent.iterdir() if p.suffix.casefold() in suffixes]
    except OSError:
        return ""
    close = difflib.get_close_matches(path.name, names, n=1)
    return f"did you mean {path.with_name(close[0])}?" if close else ""
