"""What goes wrong in vibro, as exceptions with the field, the value and the remedy in the message."""

from __future__ import annotations

from dataclasses import dataclass


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
        Everything that is wrong, one sentence each.
    hint : str
        How to put it right; empty where the problems say it themselves.
    """

    def __init__(self, *problems: str, hint: str = "") -> None:
        self.problems = problems
        self.hint = hint
        super().__init__("; ".join(problems))
        _note(self, hint)


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
