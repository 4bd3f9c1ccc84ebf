"""A sweep's directory, read: its manifest, and of its Parquet parts what is asked for."""

from __future__ import annotations

import contextlib
import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from vibro.axes import Axis
from vibro.core.codes import Level
from vibro.errors import FileError, VibroError, cut, shown
from vibro.quantities import QUANTITIES
from vibro.sweeps.gathered import GATHERED, Flags, Numbers, Texts, kind_of
from vibro.sweeps.grid import Grid

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from vibro.sweeps.selection import Selection

__all__ = ["PartFiles", "open_parts"]

_MANIFEST: Final = "manifest.json"
_SUCCESS: Final = "_SUCCESS"
_FORMAT: Final = "vibro sweep 1"
_SUMMARY: Final = ("cells", "status", "regime")
_FOOTER: Final = b"vibro"
_REASON: Final = 200  # characters of what a library says
_WANTED: Final = "give a directory that vibro map --table parquet has written"
_AGAIN: Final = "run the command that wrote it again, with --resume"


class _Part(NamedTuple):
    """A range of cells, and what the footer of their file says of it."""

    path: Path
    footer: Mapping[str, Any]

    @property
    def first_cell(self) -> int:
        return int(self.footer["first_cell"])

    @property
    def cells(self) -> int:
        return int(self.footer["cells"])


@dataclass(frozen=True, eq=False)
class PartFiles:
    """A finished directory.

    Attributes
    ----------
    folder : Path
        The directory.
    grid : Grid
        What was solved.
    own : mapping of str to float
        The scene's own values, by name.
    name : str
        What the sweep is called.
    fingerprint : str
        Of all that its cells follow from.
    parts : tuple
        The files, in the order of their cells.
    kinds : mapping of str to str
        By column what it holds: ``number``, ``flag`` or ``text``.
    summary : mapping
        What a sidecar says of the cells: their number, and how many there are of every status and regime.
    """

    folder: Path
    grid: Grid
    own: Mapping[str, float]
    name: str
    fingerprint: str
    parts: tuple[_Part, ...]
    kinds: Mapping[str, str]
    summary: Mapping[str, Any]

    def read(self, columns: Sequence[str], cells: Selection) -> dict[str, Numbers | Flags | Texts]:
        """Read columns of some cells, from those parts and row groups alone that hold them.

        Parameters
        ----------
        columns : sequence of str
            Keys of ``kinds``.
        cells : Selection
            Which cells.

        Returns
        -------
        dict
            By column, in the order of the cells.

        Raises
        ------
        FileError
            If a part cannot be read, or is another than it was.
        """
        found = {name: GATHERED[self.kinds[name]](cells.size) for name in columns}
        for part in self.parts:
            if cells.before(part.first_cell) == cells.before(part.first_cell + part.cells):
                continue
            with _opened(part) as file:
                start = part.first_cell
                for number in range(file.num_row_groups):
                    stop = start + file.metadata.row_group(number).num_rows
                    rows = cells.within(start, stop)
                    if rows.size:
                        table = file.read_row_group(number, list(columns)).take(rows)
                        place = cells.before(start)
                        for name, column in found.items():
                            column.put(place, table[name])
                    start = stop
        return found


def open_parts(folder: Path) -> PartFiles:
    """Open a directory, and check that all of its parts are there, and belong to it.

    Parameters
    ----------
    folder : Path
        Where ``vibro map`` has written a sweep.

    Returns
    -------
    PartFiles
        Of which nothing but the footers has been read.

    Raises
    ------
    FileError
        If it is no such directory, is not finished, or something in it is missing or damaged.
    VibroError
        If pyarrow is not installed.
    """
    manifest = _manifest(folder)
    try:
        grid = _grid(manifest)
        own, name, fingerprint = dict(manifest["own"]), str(manifest["name"]), str(manifest["fingerprint"])
        parts = tuple(
            _Part(
                folder / part["file"],
                {
                    "fingerprint": fingerprint,
                    "part": number,
                    "first_cell": int(part["first_cell"]),
                    "cells": int(part["cells"]),
                },
            )
            for number, part in enumerate(manifest["parts"])
        )
        columns = list(manifest["columns"])
    except (KeyError, TypeError, ValueError, AttributeError) as exc:
        raise _damaged(folder / _MANIFEST, f"{type(exc).__name__}: {exc}") from exc
    if sum(part.cells for part in parts) != grid.size:
        raise _damaged(folder / _MANIFEST, f"its parts are not all of {grid.size} cells")
    there = [part for part in parts if part.path.is_file()]
    success = _json(folder / _SUCCESS) if (folder / _SUCCESS).exists() else None
    if success is None:
        raise FileError(
            f"{folder} is not finished: {len(there)} of {len(parts)} parts are there", hint=_AGAIN
        )
    kinds: dict[str, str] | None = None
    for part in parts:
        with _opened(part) as file:
            here = {field.name: kind_of(field.type) for field in file.schema_arrow}
        if list(here) != columns or not set(here.values()) <= set(GATHERED) or here != (kinds or here):
            raise _damaged(part.path, "its columns are not those of the sweep")
        kinds = here
    summary: dict[str, Any] = {key: success[key] for key in _SUMMARY if key in success}
    return PartFiles(folder, grid, own, name, fingerprint, parts, kinds or {}, summary)


def _manifest(folder: Path) -> dict[str, Any]:
    path = folder / _MANIFEST
    if not folder.is_dir():
        what = "is no directory" if folder.exists() else "is not there"
        raise FileError(f"cannot open {folder}: it {what}", hint=_WANTED)
    if not path.is_file():
        raise FileError(f"{folder} holds no sweep: there is no {_MANIFEST} in it", hint=_WANTED)
    manifest = _json(path)
    if manifest.get("format") != _FORMAT:
        raise FileError(
            f"{path}: its format is {manifest.get('format')!r}, not {_FORMAT!r}",
            hint="open it with the version of vibro that wrote it",
        )
    return manifest


def _json(path: Path) -> dict[str, Any]:
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except OSError as exc:
        raise FileError(f"cannot read {path}: {exc.strerror or exc}") from exc
    except (ValueError, RecursionError) as exc:
        raise _damaged(path, cut(str(exc), _REASON)) from exc
    if not isinstance(content, dict):
        raise _damaged(path, "it is no JSON object")
    return content


def _grid(manifest: Mapping[str, Any]) -> Grid:
    """Make the grid that a manifest describes."""
    axes = {}
    names = {quantity.column: name for name, quantity in QUANTITIES.items()}
    for axis in manifest["axes"]:
        name = names[axis["column"]]
        axes[name] = Axis(name, np.array(axis["values"], np.float64), str(axis["spacing"]))
    scene = {names[column]: float(value) for column, value in manifest["scene"].items()}
    length = scene.pop("trough_length", None)
    level, flight = Level(manifest["accuracy"]), bool(manifest["flight"])
    return Grid(axes, scene, length, level, flight, bool(manifest["coexistence"]))


@contextlib.contextmanager
def _opened(part: _Part) -> Iterator[Any]:
    """Open the file of a part, and check what its footer says of it; what cannot be read is named."""
    pyarrow, parquet = _pyarrow()
    try:
        with parquet.ParquetFile(part.path, page_checksum_verification=True) as file:
            footer = json.loads((file.metadata.metadata or {}).get(_FOOTER, b"{}"))
            for key, value in part.footer.items():
                if footer.get(key) != value:
                    what = f"its {key.replace('_', ' ')} is {shown(footer.get(key))}, not {shown(value)}"
                    raise FileError(f"{part.path} does not belong to this sweep: {what}", hint=_AGAIN)
            if file.metadata.num_rows != part.cells:
                raise _damaged(part.path, f"it has {file.metadata.num_rows} rows, not {part.cells}")
            yield file
    except FileNotFoundError as exc:
        raise FileError(f"{part.path} is missing", hint=_AGAIN) from exc
    except MemoryError:  # one of Arrow's exceptions, too
        raise
    except (OSError, UnicodeDecodeError, json.JSONDecodeError, pyarrow.ArrowException) as exc:
        raise _damaged(part.path, cut(str(exc), _REASON)) from exc


def _damaged(path: Path, why: str) -> FileError:
    return FileError(f"{path} is damaged: {why}", hint=_AGAIN)


def _pyarrow() -> tuple[Any, Any]:
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError as exc:
        raise VibroError("Parquet files need pyarrow: pip install 'vibro[parquet]'") from exc
    return pyarrow, pyarrow.parquet
