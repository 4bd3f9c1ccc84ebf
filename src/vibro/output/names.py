"""Names of output files: suffixes are appended to a stem, even if it contains dots."""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["PICTURES", "PICTURE_FILES", "PICTURE_FORMATS", "file_suffix", "picture_file", "suffixed"]

#: Every picture of a map, a design or a machine that has a name of its own, and the formats of pictures.
PICTURES: Final = ("regime", "speed", "traverse", "impact", "flight", "band", "response")
PICTURE_FORMATS: Final = ("png", "svg", "pdf")


def suffixed(stem: Path, suffix: str) -> Path:
    """Append a suffix to a stem: ``run1.5`` becomes ``run1.5.csv``."""
    return stem.with_name(stem.name + suffix)


def file_suffix(name: str, form: str) -> str:
    """Return what a table or a picture appends to the stem; the only one of its kind may have no name."""
    return f"-{name}.{form}" if name else f".{form}"


def picture_file(name: str, form: str) -> str:
    """Name the file of a picture in a folder of shards, so that readers of Parquet skip it."""
    return f"_{name}.{form}"


#: Every name that a picture in such a folder may have.
PICTURE_FILES: Final = {picture_file(*which) for which in product(PICTURES, PICTURE_FORMATS)}
