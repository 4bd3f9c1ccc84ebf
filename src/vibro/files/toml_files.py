"""Read TOML files, and check their tables and keys against a description."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Final

from vibro.errors import FileError, InputError, cut
from vibro.files.descriptions import DESIGN_FILE, SCENE_FILE
from vibro.files.entries import refuse_unknown
from vibro.files.nearby import suggestion

if TYPE_CHECKING:
    from pathlib import Path

    from vibro.errors import Problems
    from vibro.files.descriptions import FileKind

_DECIMAL_COMMA: Final = re.compile(
    r"^[ \t]*(\w{1,40})[ \t]*=[ \t]*([+-]?[0-9]{1,20}),([0-9]{1,20})[ \t]*(#.*)?$", re.MULTILINE
)
_UNQUOTED: Final = re.compile(
    r"^[ \t]*(\w{1,40})[ \t]*=[ \t]*([+-]?[0-9.]{1,20} ?(?:[^\W\d_][\w/^]{0,10}|[\u00b0%]))[ \t]*(#.*)?$",
    re.MULTILINE,
)
_OTHER_FILES: Final = {
    ".xlsx": "a workbook", ".xls": "a workbook", ".ods": "a workbook", ".csv": "a table", ".txt": "a table",
    ".json": "a record", ".parquet": "one file of a sweep", ".png": "a picture", ".html": "a page",
}  # fmt: skip
_COMMANDS: Final = {"scene": "solve", "design": "design"}
_OF_DESIGNS: Final = {"drive", "goal"}  # tables
_REASON: Final = 200  # characters of the parser's message
# Matches whole numbers that may be too long for Python (4300 digits), and the digits that are kept: more than
# the 309 of the largest double, even if every other character were an underscore.
_LONG_NUMBER: Final = re.compile(r"[0-9][0-9_]{4000,}")
_KEPT: Final = 1000


def read_toml(path: Path) -> dict[str, Any]:
    """Read a TOML file.

    Parameters
    ----------
    path : Path
        In UTF-8, with or without a byte order mark.

    Returns
    -------
    dict
        Its content.

    Raises
    ------
    FileError
        If the file cannot be read.
    InputError
        If it is not TOML.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")
    except OSError as exc:
        hint = (
            "give a file, such as NAME.toml" if path.is_dir() else suggestion(path, (".toml",), folders=True)
        )
        raise FileError(f"cannot read {path}: {exc.strerror or exc}", hint=hint) from exc
    except UnicodeDecodeError as exc:
        raise _other(path) or InputError(
            f"{path}: not a text file in UTF-8", hint="save it as UTF-8"
        ) from exc
    except ValueError as exc:  # the path has a zero character
        raise FileError(f"cannot read {path}: {exc}") from exc
    try:
        # Python refuses whole numbers of thousands of digits without naming them. So they are shortened, but
        # stay beyond every double, and are refused by name like any other number.
        return tomllib.loads(_LONG_NUMBER.sub(lambda digits: digits[0][:_KEPT].rstrip("_"), text))
    except (tomllib.TOMLDecodeError, RecursionError) as exc:
        comma, unit = _DECIMAL_COMMA.search(text), _UNQUOTED.search(text)
        hint = f"write a decimal point: {comma[1]} = {comma[2]}.{comma[3]}" if comma else ""
        hint = f'write a number and its unit in quotes: {unit[1]} = "{unit[2]}"' if unit else hint
        said = f"{path}: not valid TOML: {cut(str(exc), _REASON)}"
        raise _other(path) or InputError(said, hint=hint) from exc


def _other(path: Path) -> InputError | None:
    """Return what is wrong with a file of another kind, if its name says so."""
    kind = _OTHER_FILES.get(path.suffix.casefold())
    said = f"{path}: {kind}, and no scene or design file"
    return InputError(said, hint="these are TOML: NAME.toml") if kind else None


def kind_of(content: Mapping[str, Any]) -> FileKind:
    """Return the kind of a file: a question of ``vibro design`` has drives and a goal."""
    return DESIGN_FILE if content.keys() >= _OF_DESIGNS else SCENE_FILE


def refuse_other_kinds(content: Mapping[str, Any], file: FileKind, path: Path) -> None:
    """Refuse a file of another kind as a whole, but not one that lacks a table."""
    other = kind_of(content)
    if other is not file and (other is DESIGN_FILE or not content.keys() & _OF_DESIGNS):
        raise InputError(
            f"{path}: this is {other.meaning}",
            hint=f"it is for vibro {_COMMANDS[other.name]}, or vibro.{other.function} in Python",
        )


def refuse_unknown_tables(content: Mapping[Any, Any], file: FileKind, problems: Problems) -> None:
    """Refuse unknown tables, and keys outside of tables."""
    for name in (name for name in content if name not in file.tables):
        tables = content[name] if isinstance(content[name], list) else [content[name]]
        is_table = all(isinstance(one, Mapping) for one in tables)
        *headings, last = (kind.heading for kind in file.tables.values())
        hint = "" if is_table else f"keys belong in the table {', '.join(headings)} or {last}"
        kinds = file.tables.values()
        refuse_unknown(f"unknown {'table' if is_table else 'key'}", name, file.tables, kinds, problems, hint)
