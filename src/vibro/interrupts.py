"""How the command's process ends when it is interrupted: at once, without half-finished files.

An exception that a signal's handler raises may fall anywhere: into an import or a callback, where it is lost,
or into the tidying up of the one before. So the handler raises nothing: it does what was asked for the end,
ends the children, and ends the process. Functions of the library install no handler: there Python raises
KeyboardInterrupt. This module imports nothing that takes time: it is there before anything else of a run.
"""

from __future__ import annotations

import os
import signal
import sys

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from types import FrameType
    from typing import NoReturn


EXIT_CODE = 130

# Ctrl-C, the request to end, a terminal that closes; which of them there are depends on the system.
_NAMES = ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK")
_SIGNALS = tuple(getattr(signal, name) for name in _NAMES if hasattr(signal, name))

_acts: list[Callable[[], str | None]] = []


def end_on_signals() -> None:
    """Let signals end this process, but those that whoever started it wants ignored."""
    for number in _SIGNALS:
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _end)


def ignore_signals() -> None:
    """Ignore signals from now on: all is done, and a late one must not turn the exit code into a lie."""
    for number in _SIGNALS:
        signal.signal(number, signal.SIG_IGN)


def _end(number: int, frame: FrameType | None) -> NoReturn:
    ignore_signals()
    lines = ["error: interrupted", *tidy_up()]
    try:
        os.write(2, "".join(f"{line}\n" for line in lines).encode(errors="backslashreplace"))
    finally:
        os._exit(EXIT_CODE)


def tidy_up() -> list[str]:
    """Run the clean-up of the process, end its children, and return the hints of the clean-up."""
    lines = []
    for act in (*reversed(_acts), _kill_children):
        try:
            hint = act()
            lines += [f"hint: {hint}"] if hint else []
        except Exception:
            pass
    return lines


def _kill_children() -> None:
    if "multiprocessing" in sys.modules:
        for child in sys.modules["multiprocessing"].active_children():
            child.kill()


class OnEnd:
    """Context in which a signal that ends the process first calls ``act``, all signals being ignored.

    What that returns is a hint for the user.
    """

    def __init__(self, act: Callable[[], str | None]) -> None:
        self._act = act

    def __enter__(self) -> None:
        _acts.append(self._act)

    def __exit__(self, *_: object) -> None:
        _acts.remove(self._act)
