"""How a run ended, as whoever started it reads it."""

from __future__ import annotations

from enum import IntEnum
from typing import Self

from vibro.interrupts import EXIT_CODE


class ExitCode(IntEnum):
    """The exit codes of every command, with what each means.

    Attributes
    ----------
    meaning : str
        For ``vibro --help``.
    """

    meaning: str

    DONE = 0, "done"
    FAILED = 1, "a file or stream could not be read or written"
    WRONG_INPUT = 2, "the input is wrong"
    UNRESOLVED = 3, "done, but a cell or the requested value is unresolved"
    NOT_MET = 4, "done, but nothing meets the goal"
    INTERRUPTED = EXIT_CODE, "interrupted"

    def __new__(cls, number: int, meaning: str) -> Self:
        """Make one that is its number."""
        code = int.__new__(cls, number)
        code._value_ = number
        code.meaning = meaning
        return code
