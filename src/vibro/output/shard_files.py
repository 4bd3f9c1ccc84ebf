"""Reading a sweep's folder: its manifest, and the requested cells of its shards."""

from __future__ import annotations

import contextlib
import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from vibro.errors import FileError, cut, shown
from vibro.output.gathered import gathering
from vibro.output.parquet import read_footer
from vibro.output.plan import check_arrow, read_plan
from vibro.output.shard_folder import MANIFEST, SUCCESS, shard_name
from vibro.output.shards import place_of
from vibro.sweeps.tally import Tally

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from vibro.output.gathered import Gathered
    from vibro.output.plan import Plan
    from vibro.output.selection import Selection
    from vibro.results.sweep import Column

__all__ = ["ShardFiles", "open_shards"]

_REASON: Final = 200  # characters of a library's message
_WANTED: Final = "give a folder that a sweep was written to"
_AGAIN: Final = "run what wrote it again with resume=True"


@dataclass(frozen=True, eq=False)
class ShardFiles:
    """A finished folder.

    Attributes
    ----------
    folder : Path
        Where it is.
    plan : Plan
        The grid that was solved, and the columns written.
    tally : Tally
        Numbers of cells by status and regime.
    """

    folder: Path
    plan: Plan
    tally: Tally

    @property
    def columns(self) -> dict[str, Column]:
        """The columns of its table, by name."""
        return {column.name: column for column in self.plan.table.columns}

    def read(self, names: Sequence[str], cells: Selection) -> dict[str, Gathered]:
        """Read columns of some cells, from those shards and row groups alone that hold them.

        Parameters
        ----------
        names : sequence of str
            Keys of ``columns``.
        cells : Selection
            Which cells.

        Returns
        -------
        dict
            By name, in the order of the cells.

        Raises
        ------
        FileError
            If a shard cannot be read, or has changed.
        """
        found = {name: gathering(self.columns[name])(cells.size) for name in names}
        first, last = (cell // self.plan.shard_cells for cell in cells.ends)
        for shard in range(first, last + 1):
            start, end = self.plan.range_of(shard)
            if cells.before(start) == cells.before(end):
                continue
            with self.opened(shard) as file:
                for group in range(file.num_row_groups):
                    stop = start + file.metadata.row_group(group).num_rows
                    rows = cells.within(start, stop)
                    if rows.size:
                        table = file.read_row_group(group, list(names)).take(rows)
                        for name, column in found.items():
                            column.put(cells.before(start), table[name])
                    start = stop
        return found

    @contextlib.contextmanager
    def opened(self, shard: int) -> Iterator[Any]:
        """Open the file of a shard and check its footer; the error names a file that cannot be read."""
        from pyarrow import ArrowException, parquet

        path = self.folder / shard_name(shard)
        expected, (first, end) = place_of(self.plan, shard), self.plan.range_of(shard)
        try:
            # Opened here: Arrow gives names such as s3: or ~ a special meaning.
            with (
                path.open("rb") as stream,
                parquet.ParquetFile(stream, page_checksum_verification=True) as file,
            ):
                said = read_footer(file.metadata)
                for key, value in expected.items():
                    if said.get(key) != value:
                        what = f"its {key.replace('_', ' ')} is {shown(said.get(key))}, not {shown(value)}"
                        raise FileError(f"{path} does not belong to this sweep: {what}", hint=_AGAIN)
                if file.metadata.num_rows != end - first:
                    raise _damaged(path, f"it has {file.metadata.num_rows} rows, not {end - first}")
                yield file
        except FileNotFoundError as exc:
            raise FileError(f"{path} is missing", hint=_AGAIN) from exc
        except PermissionError as exc:
            raise FileError(f"cannot read {path}: {exc.strerror}") from exc
        except MemoryError:  # one of Arrow's exceptions, too
            raise
        except (OSError, UnicodeDecodeError, json.JSONDecodeError, ArrowException) as exc:
            raise _damaged(path, cut(str(exc), _REASON)) from exc


def open_shards(folder: Path) -> ShardFiles:
    """Open a folder, and check that all of its shards are there, and belong to it.

    Parameters
    ----------
    folder : Path
        A folder that ``vibro map`` has written.

    Returns
    -------
    ShardFiles
        With only the footers read so far.

    Raises
    ------
    FileError
        If it is no such folder, is not finished, or something in it is missing or damaged, or pyarrow
        is not installed.
    """
    if not folder.is_dir():
        what = "is no folder" if folder.exists() else "is not there"
        raise FileError(f"cannot open {folder}: it {what}", hint=_WANTED)
    path = folder / MANIFEST
    manifest = _text(path)
    if manifest is None:
        raise FileError(f"{folder} holds no sweep: there is no {path.name} in it", hint=_WANTED)
    plan = read_plan(manifest, path)
    success = _text(folder / SUCCESS)
    if success is None:
        there = sum((folder / shard_name(shard)).is_file() for shard in range(plan.shards))
        raise FileError(f"{folder} is not finished: {there} of {plan.shards} shards are there", hint=_AGAIN)
    check_arrow()
    files = ShardFiles(folder, plan, Tally())
    for shard in range(plan.shards):
        with files.opened(shard) as file:
            files.tally.include([Tally.read(read_footer(file.metadata))])
    _check_success(success, files, folder / SUCCESS)
    return files


def _text(path: Path) -> str | None:
    """Return the text of a file; None if there is no such file."""
    try:
        return path.read_text(encoding="utf-8")
    except FileNotFoundError:
        return None
    except OSError as exc:
        raise FileError(f"cannot read {path}: {exc.strerror or exc}") from exc
    except UnicodeDecodeError as exc:
        raise _damaged(path, "it is not a text in UTF-8") from exc


def _check_success(success: str, files: ShardFiles, path: Path) -> None:
    """Refuse a summary that contradicts the shards."""
    try:
        content: Mapping[str, Any] = json.loads(success)
        said = Tally.read(content)
        if content["cells"] != files.plan.grid.size:
            raise _damaged(path, f"its number of cells is not {files.plan.grid.size}")
    except (LookupError, TypeError, ValueError, AttributeError) as exc:
        raise _damaged(path, cut(str(exc), _REASON)) from exc
    if said != files.tally:
        raise _damaged(path, "its counts of cells are not those of its shards")


def _damaged(path: Path, why: str) -> FileError:
    return FileError(f"{path} is damaged: {why}", hint=_AGAIN)
