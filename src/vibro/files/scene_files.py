"""Scene files: TOML with the table [scene] and, optionally, [map]."""

from __future__ import annotations

import difflib
import re
import tomllib
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from vibro.axes import AxisSpec, axis_of
from vibro.errors import FileError, InputError
from vibro.files.nearby import suggestion
from vibro.quantities import BY_COLUMN, STANDS_FOR, SWEPT

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

__all__ = ["SceneFile", "read_scene_file"]

_TABLES: Final = ("scene", "map")


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
        raise FileError(
            f"cannot read {path}: {exc.strerror or exc}", hint=suggestion(path, (".toml",))
        ) from exc
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
    quantity = BY_COLUMN.get(key)
    if quantity is None:
        raise InputError(f"unknown key {key!r}{_suggestion(key, BY_COLUMN)}")
    if table == "map":
        spec = axis_of(value, quantity)
        if spec.varies and STANDS_FOR.get(quantity.name, quantity.name) not in SWEPT:
            raise InputError(
                f"{key} = {value!r}: {quantity.label} cannot be an axis", hint=f"give {key} one value"
            )
        return spec
    if isinstance(value, int | float) and not isinstance(value, bool):
        return axis_of(value, quantity)
    hint = (
        "axes belong in the table [map]" if isinstance(value, str) and ":" in value else f"write {key} = 1.5"
    )
    raise InputError(f"{key} = {value!r}: must be a number, without quotes", hint=hint)


def _suggestion(word: str, words: Any) -> str:
    close = difflib.get_close_matches(word.casefold(), list(words), n=1, cutoff=0.5)
    return f"; did you mean {close[0]!r}?" if close else f"; known are {', '.join(words)}"
