"""TOML files, and what a word in one may stand for."""

from __future__ import annotations

import difflib
import re
import tomllib
from typing import TYPE_CHECKING, Any, Final

from vibro.errors import MOST_TOLD, FileError, InputError, cut
from vibro.files.nearby import suggestion

if TYPE_CHECKING:
    from collections.abc import Collection
    from pathlib import Path

__all__ = ["did_you_mean", "read_toml"]

_DECIMAL_COMMA: Final = re.compile(
    r"^[ \t]*(\w{1,40})[ \t]*=[ \t]*([+-]?\d{1,20}),(\d{1,20})[ \t]*(#.*)?$", re.MULTILINE
)
_REASON: Final = 200  # characters of what is wrong with the TOML
# What may be a whole number too long for Python (4300 digits), and how much of it is left: more than the 309
# digits of the largest double, even if every other character were an underscore.
_LONG_NUMBER: Final = re.compile(r"\d[\d_]{4000,}")
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
        What it says.

    Raises
    ------
    FileError
        If the file cannot be read.
    InputError
        If it is no TOML.
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
        return _parsed(text)
    except (tomllib.TOMLDecodeError, RecursionError) as exc:
        comma = _DECIMAL_COMMA.search(text)
        hint = f"write a decimal point: {comma[1]} = {comma[2]}.{comma[3]}" if comma else ""
        raise InputError(f"{path}: not valid TOML: {cut(str(exc), _REASON)}", hint=hint) from exc


def _parsed(text: str) -> dict[str, Any]:
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        raise
    except ValueError:
        # Python refuses to read whole numbers of thousands of digits, and does not say which. Cut to so many
        # that they are still beyond every double, they are refused by name like any other number.
        return tomllib.loads(_LONG_NUMBER.sub(lambda digits: digits[0][:_KEPT].rstrip("_"), text))


def did_you_mean(word: str, words: Collection[str], told: int) -> str:
    """Say what may be meant, for the end of a message about an unknown word.

    Parameters
    ----------
    word : str
        What is not known.
    words : collection of str
        What is.
    told : int
        How many problems come before: for what is not told any more nothing is looked up, as that takes a
        tenth of a ms a word.
    """
    if told >= MOST_TOLD:
        return ""
    close = difflib.get_close_matches(word.casefold(), words, n=1, cutoff=0.5)
    return f"; did you mean {close[0]!r}?" if close else f"; known are {', '.join(words)}"
