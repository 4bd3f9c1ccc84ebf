"""How a run ends that is interrupted: at once, with nothing unfinished left behind.

An exception that a signal's handler raises may fall anywhere: into an import or a callback, where it is lost,
or into the tidying up of the one before. So the handler raises nothing: it undoes what is unfinished, says so
and ends the process. It is there before anything else of a run: this module imports nothing that takes time.
"""

from __future__ import annotations

import os
import signal

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from types import FrameType
    from typing import Any, NoReturn

__all__ = ["EXIT_CODE", "HeldOff", "Undone", "end_on_signals", "ignore_signals"]

EXIT_CODE = 130

# Ctrl-C, the request to end, a terminal that closes; which of them there are depends on the system.
_NAMES = ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK")
_SIGNALS = tuple(getattr(signal, name) for name in _NAMES if hasattr(signal, name))

_unfinished: list[Callable[[], str | None]] = []


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
    said = ["error: interrupted"]
    for undo in reversed(_unfinished):
        try:
            hint = undo()
            said += [f"hint: {hint}"] if hint else []
        except Exception:
            pass
    try:
        os.write(2, "".join(f"{line}\n" for line in said).encode(errors="backslashreplace"))
    finally:
        os._exit(EXIT_CODE)


class Undone:
    """Context in which a signal that ends the process first calls ``undo``, all signals being ignored.

    What that returns is a hint for the user.
    """

    def __init__(self, undo: Callable[[], str | None]) -> None:
        self._undo = undo

    def __enter__(self) -> None:
        _unfinished.append(self._undo)

    def __exit__(self, *_: object) -> None:
        _unfinished.remove(self._undo)


class HeldOff:
    """Context in which signals wait: files are made, renamed or removed, and half of that must not remain.

    Elsewhere than in the main thread, where signals do not arrive, it does nothing.
    """

    def __init__(self) -> None:
        self._handlers: dict[int, Any] = {}
        self._came: list[int] = []
        self._done = False

    def done(self) -> None:
        """Say that all that was asked for is there: no signal is of any account from now on."""
        self._done = True

    def __enter__(self) -> HeldOff:
        for number in _SIGNALS:
            handler = signal.getsignal(number)
            if handler not in (None, signal.SIG_IGN):  # none of Python's, or nobody's
                try:
                    signal.signal(number, lambda number, _: self._came.append(number))
                except ValueError:  # another thread
                    break
                self._handlers[number] = handler
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._handlers.items():
            signal.signal(number, signal.SIG_IGN if self._done and handler is _end else handler)
        if not self._done:
            for number in self._came:
                signal.raise_signal(number)
