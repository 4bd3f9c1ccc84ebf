"""Scene files: TOML with the table [scene] and, optionally, [map]."""

from __future__ import annotations

import difflib
import re
import tomllib
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from vibro.axes import AxisSpec, axis_of
from vibro.errors import MOST_TOLD, FileError, InputError, cut, shown
from vibro.files.nearby import suggestion
from vibro.quantities import BY_COLUMN, STANDS_FOR, SWEPT

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping
    from pathlib import Path

    from vibro.quantities import Quantity

__all__ = ["SceneFile", "read_scene_file"]

_TABLES: Final = ("scene", "map")
_DECIMAL_COMMA: Final = re.compile(
    r"^[ \t]*(\w{1,40})[ \t]*=[ \t]*([+-]?\d{1,20}),(\d{1,20})[ \t]*(#.*)?$", re.MULTILINE
)
_REASON: Final = 200  # characters of what is wrong with the TOML
# What may be a whole number too long for Python (4300 digits), and how much of it is left: more than the 309
# digits of the largest double, even if every other character were an underscore.
_LONG_NUMBER: Final = re.compile(r"\d[\d_]{4000,}")
_KEPT: Final = 1000


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
    except ValueError as exc:  # a path that no system has, with a zero character
        raise FileError(f"cannot read {path}: {exc}") from exc
    try:
        content = _parsed(text)
    except (tomllib.TOMLDecodeError, RecursionError) as exc:
        comma = _DECIMAL_COMMA.search(text)
        hint = f"write a decimal point: {comma[1]} = {comma[2]}.{comma[3]}" if comma else ""
        raise InputError(f"{path}: not valid TOML: {cut(str(exc), _REASON)}", hint=hint) from exc

    problems: list[str] = []
    hints: list[str] = []
    tables: dict[str, dict[str, AxisSpec]] = {name: {} for name in _TABLES}
    for name, table in content.items():
        if name not in tables:
            known = isinstance(table, dict)
            what = f"unknown {'table' if known else 'key'} {shown(name)}"
            problems.append(f"{path}: {what}{_suggestion(name, _TABLES, len(problems))}")
            if not known:
                hints.append("keys belong in the table [scene] or [map]")
        elif not isinstance(table, dict):
            problems.append(f"{path}: {name} must be a table, written [{name}]")
        else:
            for key, value in table.items():
                if key not in BY_COLUMN:
                    guess = _suggestion(key, BY_COLUMN, len(problems))
                    problems.append(f"{path}: [{name}] unknown key {shown(key)}{guess}")
                    continue
                try:
                    spec = _entry(name, BY_COLUMN[key], value)
                    tables[name][spec.quantity.name] = spec
                except InputError as exc:
                    problems += [f"{path}: [{name}] {problem}" for problem in exc.problems]
                    hints += [exc.hint] if exc.hint else []
    if problems:
        raise InputError(*problems, hint="\n".join(dict.fromkeys(hints)))
    return SceneFile(path.stem, tables["scene"], tables["map"])


def _parsed(text: str) -> dict[str, Any]:
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        raise
    except ValueError:
        # Python refuses to read whole numbers of thousands of digits, and does not say which. Cut to so many
        # that they are still beyond every double, they are refused by name like any other number.
        return tomllib.loads(_LONG_NUMBER.sub(lambda digits: digits[0][:_KEPT].rstrip("_"), text))


def _entry(table: str, quantity: Quantity, value: object) -> AxisSpec:
    key = quantity.column
    if table == "map":
        spec = axis_of(value, quantity)
        if spec.varies and STANDS_FOR.get(quantity.name, quantity.name) not in SWEPT:
            raise InputError(
                f"{key} = {shown(value)}: {quantity.label} cannot be an axis", hint=f"give {key} one value"
            )
        return spec
    if isinstance(value, int | float) and not isinstance(value, bool):
        return axis_of(value, quantity)
    hint = (
        "axes belong in the table [map]" if isinstance(value, str) and ":" in value else f"write {key} = 1.5"
    )
    raise InputError(f"{key} = {shown(value)}: must be a number, without quotes", hint=hint)


def _suggestion(word: str, words: Collection[str], told: int) -> str:
    """Say what may be meant; nothing in what is not told any more, as it takes a tenth of a ms a word."""
    if told >= MOST_TOLD:
        return ""
    close = difflib.get_close_matches(word.casefold(), words, n=1, cutoff=0.5)
    return f"; did you mean {close[0]!r}?" if close else f"; known are {', '.join(words)}"
