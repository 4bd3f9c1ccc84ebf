"""Scene files, and sets of output files that appear whole or not at all."""

from __future__ import annotations

import contextlib
import difflib
import errno
import json
import os
import re
import shutil
import signal
import sys
import threading
import time
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Self

from vibro.axes import AxisSpec, parse_axis
from vibro.errors import FileError, InputError
from vibro.quantities import QUANTITIES, SWEPT

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence
    from types import TracebackType

__all__ = ["OutputSet", "SceneFile", "output_stem", "read_scene_file", "suffixed", "write_json"]

_BY_COLUMN: Final = {q.column: q for q in QUANTITIES.values()}
_TABLES: Final = ("scene", "map")

# A spreadsheet holds a file for as long as it is open, a virus scanner for a moment: outlast the scanner.
_RENAME_ATTEMPTS: Final = 10
_RENAME_PAUSE: Final = 0.2  # [s]

_TEMPORARY: Final = re.compile(r"\.vibro-(\d+)-\d+\.tmp")


@dataclass(frozen=True)
class SceneFile:
    """What a scene file says.

    Attributes
    ----------
    name : str
        The file's name without its suffix.
    scene : mapping of str to AxisSpec
        The table ``[scene]``: one value each, by the quantity's name.
    sweep : mapping of str to AxisSpec
        The table ``[map]``: values and axes, by the quantity's name.
    """

    name: str
    scene: Mapping[str, AxisSpec]
    sweep: Mapping[str, AxisSpec]


def read_scene_file(path: Path) -> SceneFile:
    """Read a scene file.

    Parameters
    ----------
    path : Path
        TOML with a table ``[scene]`` and, optionally, ``[map]``; the keys are names with units.

    Returns
    -------
    SceneFile
        Values are not checked against their physical ranges.

    Raises
    ------
    FileError
        If the file cannot be read.
    InputError
        If it is no TOML, or has keys or values that it may not have; all of them are named.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")
    except OSError as exc:
        raise FileError(f"cannot read {path}: {_reason(exc)}", hint=_nearby(path)) from exc
    except UnicodeDecodeError as exc:
        raise InputError(f"{path}: not a text file in UTF-8", hint="save it as UTF-8") from exc
    try:
        content = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError) as exc:
        comma = re.search(r"^\s*(\w+)\s*=\s*([+-]?\d+),(\d+)\s*(#.*)?$", text, re.MULTILINE)
        hint = f"write a decimal point: {comma[1]} = {comma[2]}.{comma[3]}" if comma else ""
        raise InputError(f"{path}: not valid TOML: {exc}", hint=hint) from exc

    problems: list[str] = []
    hints: list[str] = []
    tables: dict[str, dict[str, AxisSpec]] = {name: {} for name in _TABLES}
    for name, table in content.items():
        if name not in tables:
            known = isinstance(table, dict)
            problems.append(
                f"{path}: unknown {'table' if known else 'key'} {name!r}{_suggestion(name, _TABLES)}"
            )
            if not known:
                hints.append("keys belong in the table [scene] or [map]")
        elif not isinstance(table, dict):
            problems.append(f"{path}: {name} must be a table, written [{name}]")
        else:
            for key, value in table.items():
                try:
                    spec = _entry(name, key, value)
                    tables[name][spec.quantity.name] = spec
                except InputError as exc:
                    problems += [f"{path}: [{name}] {problem}" for problem in exc.problems]
                    hints += [exc.hint] if exc.hint else []
    if problems:
        raise InputError(*problems, hint="\n".join(dict.fromkeys(hints)))
    return SceneFile(path.stem, tables["scene"], tables["map"])


def _entry(table: str, key: str, value: object) -> AxisSpec:
    quantity = _BY_COLUMN.get(key)
    if quantity is None:
        raise InputError(f"unknown key {key!r}{_suggestion(key, _BY_COLUMN)}")
    if isinstance(value, int | float) and not isinstance(value, bool):
        return parse_axis(repr(value), quantity)
    if table == "map":
        if isinstance(value, str):
            spec = parse_axis(value, quantity)
        elif isinstance(value, list) and value and all(type(item) in (int, float) for item in value):
            # A list of two must not be taken for a decimal comma.
            spec = parse_axis(",".join(map(repr, map(float, value))), quantity)
        else:
            raise InputError(
                f"{key} = {value!r}: must be an axis", hint='write it like "0.1:3:200" or [10, 20, 30]'
            )
        if spec.varies and quantity.name not in (*SWEPT, "stroke"):
            raise InputError(
                f"{key} = {value!r}: {quantity.label} cannot be an axis", hint=f"give {key} one value"
            )
        return spec
    hint = (
        "axes belong in the table [map]" if isinstance(value, str) and ":" in value else f"write {key} = 1.5"
    )
    raise InputError(f"{key} = {value!r}: must be a number, without quotes", hint=hint)


def _suggestion(word: str, words: Any) -> str:
    close = difflib.get_close_matches(word.casefold(), list(words), n=1, cutoff=0.5)
    return f"; did you mean {close[0]!r}?" if close else f"; known are {', '.join(words)}"


def _nearby(path: Path) -> str:
    try:
        names = [p.name for p in path.parent.iterdir() if p.suffix == ".toml"]
    except OSError:
        return ""
    close = difflib.get_close_matches(path.name, names, n=1)
    return f"did you mean {path.with_name(close[0])}?" if close else ""


def _reason(exc: OSError) -> str:
    return exc.strerror or str(exc)


def output_stem(output: str | None, name: str) -> Path:
    """Find the stem of the output files.

    Parameters
    ----------
    output : str or None
        What the user gave: a stem, or a folder (it exists or ends in a separator), which takes ``name``.
    name : str
        The scene's name.

    Returns
    -------
    Path
        Suffixes are appended to it by ``suffixed``.
    """
    if output is None:
        return Path(name)
    separators = (os.sep, os.altsep or os.sep)
    if output.endswith(separators) or Path(output).is_dir():
        return Path(output) / name
    return Path(output)


def suffixed(stem: Path, suffix: str) -> Path:
    """Append a suffix to a stem, whatever dots the stem has: ``run1.5`` becomes ``run1.5.csv``."""
    return stem.with_name(stem.name + suffix)


def write_json(path: Path, content: Mapping[str, Any]) -> None:
    """Write a sidecar: UTF-8 JSON, readable by people."""
    path.write_text(json.dumps(content, indent=2, allow_nan=False) + "\n", encoding="utf-8")


class OutputSet:
    """Output files that are written under temporary names and renamed together at the end.

    Entering makes the folder, sweeps what killed runs left there, and refuses existing targets. Leaving
    renames the temporary files; leaving by an exception removes them, and the folders that were made.

    Parameters
    ----------
    targets : sequence of Path
        The files, in the order of renaming; all in one folder.
    force : bool
        Whether existing targets may be replaced.

    Raises
    ------
    FileError
        If the folder cannot be made or written to, or a target exists or cannot be written.
    """

    def __init__(self, targets: Sequence[Path], *, force: bool) -> None:
        self.folder = targets[0].parent
        self.force = force
        # The name says whose file it is, and is never longer than what the file system takes.
        self._temporary = {t: self.folder / f".vibro-{os.getpid()}-{i}.tmp" for i, t in enumerate(targets)}
        self._made: list[Path] = []

    def __getitem__(self, target: Path) -> Path:
        """Return the temporary name to write a target to."""
        return self._temporary[target]

    def __enter__(self) -> Self:
        try:
            self._make_folder()
            self._check_targets()
            for path in self._temporary.values():
                self._open_first(path)
        except BaseException:
            self._discard()
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, exc: BaseException | None, traceback: TracebackType | None
    ) -> None:
        if kind is None:
            with _uninterrupted():
                try:
                    for target, path in self._temporary.items():
                        _rename(path, target)
                except BaseException:
                    self._discard()
                    raise
            return
        self._discard()
        if isinstance(exc, OSError) and not isinstance(exc, BrokenPipeError):
            hint = "free some space, or choose another place with -o" if exc.errno == errno.ENOSPC else ""
            raise FileError(f"cannot write to {self.folder}: {_reason(exc)}", hint=hint) from exc

    def free_space(self) -> int:
        """Return the bytes that are free where the files go."""
        return shutil.disk_usage(self.folder).free

    def _make_folder(self) -> None:
        missing = [p for p in (self.folder, *self.folder.parents) if not p.exists()]
        try:
            for path in reversed(missing):
                path.mkdir(exist_ok=True)
                self._made.append(path)
            leftovers = list(self.folder.iterdir())
        except OSError as exc:
            in_the_way = next((p for p in (self.folder, *self.folder.parents) if p.is_file()), None)
            hint = f"{in_the_way} is a file" if in_the_way else ""
            raise FileError(f"cannot use the folder {self.folder}: {_reason(exc)}", hint=hint) from exc
        for path in leftovers:
            match = _TEMPORARY.fullmatch(path.name)
            if match and not _is_running(int(match[1])):
                with contextlib.suppress(OSError):
                    path.unlink()

    def _check_targets(self) -> None:
        for target in self._temporary:
            if target.is_dir():
                raise FileError(f"cannot write {target}: a folder is in the way")
        existing = [str(target) for target in self._temporary if target.exists()]
        if existing and not self.force:
            verb = "exists" if len(existing) == 1 else "exist"
            raise FileError(
                f"{', '.join(existing)} {verb} already",
                hint="replace with --force, or choose another name with -o",
            )

    def _open_first(self, path: Path) -> None:
        try:
            path.touch()
        except OSError as exc:
            raise FileError(
                f"cannot write to {self.folder}: {_reason(exc)}", hint="choose another place with -o"
            ) from exc

    def _discard(self) -> None:
        with _uninterrupted():
            for path in self._temporary.values():
                with contextlib.suppress(OSError):
                    path.unlink()
            for path in reversed(self._made):
                with contextlib.suppress(OSError):
                    path.rmdir()


def _rename(path: Path, target: Path) -> None:
    for attempt in range(_RENAME_ATTEMPTS):
        try:
            path.replace(target)
        except PermissionError as exc:
            if attempt + 1 == _RENAME_ATTEMPTS:
                raise FileError(
                    f"cannot replace {target}: {_reason(exc)}",
                    hint="close it in the program that holds it open",
                ) from exc
            time.sleep(_RENAME_PAUSE)
        except OSError as exc:
            raise FileError(f"cannot write {target}: {_reason(exc)}") from exc
        else:
            return


@contextlib.contextmanager
def _uninterrupted() -> Iterator[None]:
    """Hold signals off while files are renamed or removed: half of either must not remain."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = {s: signal.signal(s, signal.SIG_IGN) for s in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _is_running(pid: int) -> bool:
    if sys.platform == "win32":
        # os.kill would end the process there.
        import ctypes

        synchronize, access_denied = 0x00100000, 5
        handle = ctypes.windll.kernel32.OpenProcess(synchronize, False, pid)
        if handle:
            ctypes.windll.kernel32.CloseHandle(handle)
            return True
        return bool(ctypes.windll.kernel32.GetLastError() == access_denied)
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except (PermissionError, OverflowError):
        return True
    return True
