"""Exit codes of the command."""

from __future__ import annotations

from enum import IntEnum

__all__ = ["ExitCode"]


class ExitCode(IntEnum):
    """How a run ended; each has its meaning in ``--help``."""

    DONE = 0
    FAILED = 1
    WRONG_INPUT = 2
    UNRESOLVED = 3
    NO_DRIVE = 4
    INTERRUPTED = 130
