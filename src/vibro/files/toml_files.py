"""Read TOML files, and check their tables and keys against a description."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Final

from vibro.errors import InputError, cut
from vibro.files.descriptions import DESIGN_FILE, SCENE_FILE
from vibro.files.entries import refuse_unknown
from vibro.files.reading import content_of

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
_LINES: Final = 'lines are [TABLE], KEY = 0.8 or KEY = "TEXT", and what follows # is left alone'
# Names before dots; each takes the parser the longer, the more stand before it.
_DEEPEST: Final = 100
_NO_NAMES: Final = re.compile(r"#.*|[=,{}\[\]\n]")
_REASON: Final = 200  # characters of the parser's message


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
    content = content_of(path, (".toml",), folders=True)
    try:
        text = content.decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError as exc:
        problem = f"{path}: not a text file in UTF-8"
        raise _other(path) or InputError(problem, hint="save it as UTF-8") from exc
    try:
        if any(part.count(".") > _DEEPEST for part in _NO_NAMES.split(text)):
            raise ValueError(f"more than {_DEEPEST} names between dots")
        return tomllib.loads(text)
    except (ValueError, RecursionError) as exc:  # ValueError: it is no TOML, or has thousands of digits
        comma, unit = _DECIMAL_COMMA.search(text), _UNQUOTED.search(text)
        hint = f"write a decimal point: {comma[1]} = {comma[2]}.{comma[3]}" if comma else ""
        hint = f'write a number and its unit in quotes: {unit[1]} = "{unit[2]}"' if unit else hint or _LINES
        problem = f"{path}: not valid TOML: {cut(str(exc), _REASON)}"
        raise _other(path) or InputError(problem, hint=hint) from exc


def _other(path: Path) -> InputError | None:
    """Return what is wrong with a file of another kind, if its name says so."""
    kind = _OTHER_FILES.get(path.suffix.casefold())
    problem = f"{path}: {kind}, and no scene or design file"
    return InputError(problem, hint="these are TOML: NAME.toml") if kind else None


def refuse_other_kinds(content: Mapping[str, Any], file: FileKind, path: Path) -> None:
    """Refuse a file of another kind as a whole, but not one that lacks a table.

    A question of ``vibro design`` has drives and a goal.
    """
    other = DESIGN_FILE if content.keys() >= _OF_DESIGNS else SCENE_FILE
    if other is not file and (other is DESIGN_FILE or not content.keys() & _OF_DESIGNS):
        raise InputError(
            f"{path}: this is {other.meaning}",
            hint=f"it is for vibro {_COMMANDS[other.name]}, or vibro.{other.function} in Python",
        )


def refuse_unknown_tables(content: Mapping[Any, Any], file: FileKind, problems: Problems) -> None:
    """Refuse unknown tables, and keys outside of tables."""
    kinds = file.tables.values()
    *headings, last = (kind.heading for kind in kinds)
    belong = f"keys belong in the table {', '.join(headings)} or {last}"
    for name in (name for name in content if name not in file.tables):
        tables = content[name] if isinstance(content[name], list) else [content[name]]
        is_table = all(isinstance(one, Mapping) for one in tables)
        what, hint = ("unknown table", "") if is_table else ("unknown key", belong)
        refuse_unknown(what, name, file.tables, kinds, problems, hint)
