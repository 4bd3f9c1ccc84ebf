"""Exceptions of vibro; their messages name the field, the value and the remedy."""

from __future__ import annotations

import math
import re
import reprlib
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Sequence

#: Largest number of problems of one input that a message lists; the others are counted.
MOST_LISTED: Final = 20
_LONGEST: Final = 60  # characters of a value in a message
_RIGHT: Final = 24  # of these, from its end
_LONGEST_LINE: Final = 500  # characters of a message; nobody reads more
# An argument within a message: its name and, if there is one, its value.
_ARGUMENT: Final = re.compile("\u27e6(\\w+)(?: (.*?))?\u27e7")


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


def did_you_mean(
    word: object, known: Iterable[str], *, most: int = 1, cutoff: float = 0.5, before: str = ""
) -> str:
    """Ask whether a known name was meant, for the hint of an error.

    Parameters
    ----------
    word : object
        What was given; case is ignored. Values that are not texts get no suggestion.
    known : iterable of str
        The known names.
    most : int
        Largest number of suggestions.
    cutoff : float
        Least similarity, as of ``difflib``.
    before : str
        Text before each name, such as the folder of a file.

    Returns
    -------
    str
        ``did you mean 'amplitude_mm'?``; empty if no name is near.
    """
    import difflib  # needed for error messages alone

    text = word.casefold() if isinstance(word, str) else ""
    names: dict[str, str] = {}
    for name in known:
        names.setdefault(name.casefold(), name)
    close = difflib.get_close_matches(text, names, n=most, cutoff=cutoff)
    meant = " or ".join(f"'{before}{printable(names[key])}'" for key in close)
    return f"did you mean {meant}?" if meant else ""


def printable(text: str) -> str:
    """Escape line ends and control characters, which a terminal would obey."""
    return text if text.isprintable() else "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text)


def argument(name: str, value: str = "") -> str:
    """Name an argument in an InputError, which Python calls ``name="value"`` and vibro ``--name "value"``."""
    return f"\u27e6{name} {value}\u27e7" if value else f"\u27e6{name}\u27e7"


def _of_calls(text: str) -> str:
    return _ARGUMENT.sub(lambda found: f'{found[1]}="{found[2]}"' if found[2] else found[1], text)


def _of_commands(text: str) -> str:
    def option(found: re.Match[str]) -> str:
        return f"--{found[1].replace('_', '-')}" + (f' "{found[2]}"' if found[2] else "")

    return _ARGUMENT.sub(option, text)


def how_to_install(extra: str) -> str:
    """Return the command that installs an extra, for the hint of an error; no registry has vibro."""
    return f"pip install '.[{extra}]' in the project's folder"


def _listed(lines: Sequence[str], what: str) -> tuple[str, ...]:
    """Keep the first lines, none too long, and count the others."""
    listed = [cut(line, _LONGEST_LINE) for line in lines[:MOST_LISTED]]
    more = len(lines) - len(listed)
    return tuple([*listed, f"{more} more such {what}"] if more else listed)


class VibroError(Exception):
    """Base class of all errors that vibro raises for wrong input, files or scenes."""


@dataclass(frozen=True)
class Problem:
    """One problem with one field of a scene.

    Attributes
    ----------
    field : str
        Name of the field as the constructor of ``Scene`` spells it.
    value : str
        The first offending value, with its unit.
    allowed : str
        Allowed values of the field, with its unit.
    """

    field: str
    value: str
    allowed: str

    def __str__(self) -> str:
        return f"{self.field} = {self.value}: must be {self.allowed}"


class SceneError(VibroError, ValueError):
    """An invalid scene; the message lists every problem with its field, value and allowed range.

    Attributes
    ----------
    problems : tuple of Problem
        Every problem, in the order of the scene's fields.
    """

    def __init__(self, problems: tuple[Problem, ...]) -> None:
        self.problems = problems
        super().__init__("; ".join(str(p) for p in problems))

    @classmethod
    def of(cls, field: str, value: str, allowed: str) -> SceneError:
        """Return an error with one problem."""
        return cls((Problem(field, value, allowed),))

    def __reduce__(self) -> tuple[type[SceneError], tuple[tuple[Problem, ...]]]:
        return type(self), (self.problems,)


class InputError(VibroError):
    """Invalid input: an option, an axis, an argument, or the content of a scene file.

    Attributes
    ----------
    problems : tuple of str
        Every problem, one sentence each. If there are more than 20, the first 20 and a count of the others.
    hint : str
        The remedy, in one or more lines; empty if the problems already say it.
    raw : tuple of tuple of str, str
        Both as they were given, for an error that holds this one.
    fields : tuple of str
        For each listed problem the name of its quantity, or an empty text if it concerns several; an empty
        tuple if no quantities are known.
    """

    def __init__(self, *problems: str, hint: str = "", fields: Sequence[str] = ()) -> None:
        self.raw = problems, hint
        self.problems, self.hint = self._spelt(_of_calls)
        self.fields = (*fields,)[:MOST_LISTED]
        super().__init__("; ".join(self.problems))
        _note(self, self.hint)

    def as_typed(self) -> tuple[tuple[str, ...], str]:
        """Return problems and hint with arguments as options of the command line."""
        return self._spelt(_of_commands)

    def _spelt(self, spell: Callable[[str], str]) -> tuple[tuple[str, ...], str]:
        problems, hint = self.raw
        hints = _listed([*map(spell, hint.splitlines())], "hints")
        return _listed([*map(spell, problems)], "problems"), "\n".join(hints)


class Problems:
    """Collects all problems of an input, to raise them together.

    Parameters
    ----------
    where : str
        Text that begins every message: the file.
    """

    def __init__(self, where: str = "") -> None:
        self._where = where
        self.found: list[tuple[str, str, str]] = []  # field, text and hint of each

    def add(self, text: str, hint: str = "", field: str = "") -> None:
        """Add a problem, with its remedy and its field."""
        self.found.append((field, self._where + text, hint))

    @contextmanager
    def taken(self, where: str = "", field: str = "") -> Iterator[None]:
        """Collect the problems of an InputError raised in this context, with its fields; suppress it."""
        try:
            yield
        except InputError as exc:
            problems, hint = exc.raw
            for i, problem in enumerate(problems):
                own = exc.fields[i] if i < len(exc.fields) else ""
                self.add(where + problem, "" if i else hint, own or field)

    def settle(self) -> None:
        """Raise all problems, if any, as one InputError; each hint appears once."""
        if self.found:
            fields, texts, hints = zip(*self.found, strict=True)
            raise InputError(*texts, hint="\n".join(dict.fromkeys(filter(None, hints))), fields=fields)


class FileError(VibroError):
    """A file that cannot be read or written.

    Attributes
    ----------
    hint : str
        The remedy; empty if the message already says it.
    """

    def __init__(self, message: str, hint: str = "") -> None:
        self.hint = hint
        super().__init__(message)
        _note(self, hint)


def _note(error: VibroError, hint: str) -> None:
    """Add the hint to the traceback."""
    for line in hint.splitlines():
        error.add_note(f"hint: {line}")
