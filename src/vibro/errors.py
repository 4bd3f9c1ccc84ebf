"""What goes wrong in vibro, as exceptions with the field, the value and the remedy in the message."""

from __future__ import annotations

import math
import reprlib
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

#: How many of the things that are wrong with one input are told; of the others the number.
MOST_TOLD: Final = 20
_LONGEST: Final = 60  # characters of a value in a message
_RIGHT: Final = 24  # of these, from its end
_LONGEST_LINE: Final = 500  # characters of a message: whatever a part of it holds, nobody reads on


class _Shortened(reprlib.Repr):
    """``repr`` of anything in a few characters, however large it is."""

    def __init__(self) -> None:
        super().__init__()
        self.maxstring = self.maxother = self.maxlong = _LONGEST

    def repr_int(self, x: int, level: int) -> str:
        """Write a whole number; of a long one its length, as Python takes long to spell it, or refuses."""
        digits = math.ceil(x.bit_length() * math.log10(2.0))
        return repr(x) if digits <= _LONGEST else f"a whole number of about {digits} digits"


_SHORTENED: Final = _Shortened()


def shown(value: Any) -> str:
    """Write a value for a message: as ``repr`` does, but on one line, and cut where it is long."""
    text = " ".join(_SHORTENED.repr(value).split())
    if isinstance(value, str) and len(value) > _LONGEST:
        text += f" ({len(value)} characters)"
    return printable(text)


def cut(text: str, most: int = _LONGEST) -> str:
    """Write a text for a message, without quotes: on one line, and cut where it is longer than ``most``."""
    if len(text) > most:
        text = f"{text[: most - _RIGHT]}...{text[-_RIGHT:]} ({len(text)} characters)"
    return printable(text)


def printable(text: str) -> str:
    """Spell out what would end a line, or what a terminal would obey: names are text."""
    return text if text.isprintable() else "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text)


def _told(lines: Sequence[str], what: str) -> tuple[str, ...]:
    """Keep the first lines, none too long, and count the others."""
    told = [cut(line, _LONGEST_LINE) for line in lines[:MOST_TOLD]]
    more = len(lines) - len(told)
    return tuple([*told, f"{more} more such {what}"] if more else told)


class VibroError(Exception):
    """Base class of every error that vibro raises on purpose."""


@dataclass(frozen=True)
class Problem:
    """One thing that is wrong with one field of a scene.

    Attributes
    ----------
    field : str
        Name of the field as the constructor of ``Scene`` spells it.
    value : str
        The first offending value, with its unit.
    allowed : str
        What the field may be, with its unit.
    """

    field: str
    value: str
    allowed: str

    def __str__(self) -> str:
        return f"{self.field} = {self.value}: must be {self.allowed}"


class SceneError(VibroError, ValueError):
    """A scene that cannot be: every problem found, each with field, value and allowed range.

    Attributes
    ----------
    problems : tuple of Problem
        All that is wrong, in the order of the scene's fields.
    """

    def __init__(self, problems: tuple[Problem, ...]) -> None:
        self.problems = problems
        super().__init__("; ".join(str(p) for p in problems))

    def __reduce__(self) -> tuple[type[SceneError], tuple[tuple[Problem, ...]]]:
        return type(self), (self.problems,)


class InputError(VibroError):
    """Input that cannot be used: an option, an axis, a scene file's content.

    Attributes
    ----------
    problems : tuple of str
        Everything that is wrong, one sentence each; of more than ``MOST_TOLD`` the first, and how many more
        there are.
    hint : str
        How to put it right, a line or as many; empty where the problems say it themselves.
    fields : tuple of str
        Of each problem that is told the name of the quantity that it is of, empty where it is of no single
        one; or no names at all.
    """

    def __init__(self, *problems: str, hint: str = "", fields: Sequence[str] = ()) -> None:
        self.problems = _told(problems, "problems")
        self.fields = (*fields,)[:MOST_TOLD]
        self.hint = "\n".join(_told(hint.splitlines(), "hints"))
        super().__init__("; ".join(self.problems))
        _note(self, self.hint)


class Problems:
    """Everything that is wrong with an input, to be told at once.

    Parameters
    ----------
    where : str
        What every message begins with: the file.
    """

    def __init__(self, where: str = "") -> None:
        self._where = where
        self.found: list[tuple[str, str, str]] = []  # field, text and hint of each

    def add(self, text: str, hint: str = "", field: str = "") -> None:
        """Take note of one thing, of what may be done about it, and of the field that it is of."""
        self.found.append((field, self._where + text, hint))

    @contextmanager
    def taken(self, where: str = "", field: str = "") -> Iterator[None]:
        """Take note of all that an InputError says, of its own fields if it names them, and go on behind."""
        try:
            yield
        except InputError as exc:
            for i, problem in enumerate(exc.problems):
                own = exc.fields[i] if i < len(exc.fields) else ""
                self.add(where + problem, "" if i else exc.hint, own or field)

    def settle(self) -> None:
        """Raise all of it as one InputError; each hint once."""
        if self.found:
            fields, texts, hints = zip(*self.found, strict=True)
            raise InputError(*texts, hint="\n".join(dict.fromkeys(filter(None, hints))), fields=fields)


class FileError(VibroError):
    """A file that cannot be read or written.

    Attributes
    ----------
    hint : str
        How to put it right; empty where the message says it itself.
    """

    def __init__(self, message: str, hint: str = "") -> None:
        self.hint = hint
        super().__init__(message)
        _note(self, hint)


def _note(error: VibroError, hint: str) -> None:
    """Let a traceback show the hint too."""
    for line in hint.splitlines():
        error.add_note(f"hint: {line}")
