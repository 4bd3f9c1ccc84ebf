"""What goes to the screen beside the answer: echo, progress, warnings and errors, all on stderr."""

from __future__ import annotations

import contextlib
import io
import os
import sys
import traceback
from typing import TYPE_CHECKING

from vibro.errors import printable
from vibro.interrupts import OnEnd

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Sequence
    from typing import TextIO


def open_closed_streams() -> None:
    """Put something in the place of standard streams that are closed.

    Otherwise the next file that is opened gets the number of one, and Python's messages go elsewhere: those
    for a closed stderr to stdout. What is written to a closed stdout is lost, which is an error; messages and
    input are not missed.
    """
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        if getattr(sys, name) is None:
            writes = name == "stderr"
            nothing = os.open(os.devnull, os.O_WRONLY if writes else os.O_RDONLY)
            if nothing != number:
                os.dup2(nothing, number)
                os.close(nothing)
            setattr(sys, name, open(number, "r" if name == "stdin" else "w", closefd=False))  # noqa: SIM115


def tolerate_any_encoding() -> None:
    """Let a console that lacks a character show a substitute instead of failing."""
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(AttributeError):
            stream.reconfigure(errors="replace")  # type: ignore[union-attr]


def tell(text: str) -> None:
    """Write a line to stderr; errors of stderr are ignored."""
    try:
        print(printable(text), file=sys.stderr, flush=True)
    except (OSError, ValueError):
        silence(sys.stderr)


def silence(stream: TextIO) -> None:
    """Let what a stream cannot write, now or when the interpreter ends, go nowhere."""
    with contextlib.suppress(OSError, ValueError):
        nothing = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nothing, stream.fileno())
        os.close(nothing)


def print_error(problems: Sequence[str], hint: str = "") -> None:
    """Print problems and remedies, a line each."""
    for problem in problems:
        tell(f"error: {problem}")
    for line in hint.splitlines():
        tell(f"hint: {line}")


def print_unexpected(exc: Exception) -> None:
    """Print what nobody expected, and what to do about it."""
    print_error([f"unexpected {type(exc).__name__}: {exc}"], "please report it with the output of --debug")


def tell_traceback(exc: Exception) -> None:
    """Write where an exception comes from."""
    for line in "".join(traceback.format_exception(exc)).splitlines():
        tell(line)


class Console:
    """Messages of a run, all on stderr.

    Parameters
    ----------
    quiet : bool
        Whether only errors are shown.

    Attributes
    ----------
    warnings : list of str
        What the user was warned of, which pages repeat.
    """

    def __init__(self, *, quiet: bool) -> None:
        self.quiet = quiet
        self.warnings: list[str] = []

    @property
    def is_terminal(self) -> bool:
        """Whether a person watches."""
        return not self.quiet and sys.stderr.isatty()

    def echo(self, text: str) -> None:
        """Say what was understood or done."""
        if not self.quiet:
            tell(text)

    def echo_all(self, lines: Iterable[str]) -> None:
        """Say several things, a line each."""
        for line in lines:
            self.echo(line)

    def warn(self, text: str) -> None:
        """Say what the user should know about the answer."""
        self.warnings.append(text)
        self.echo(f"warning: {text}")

    @contextlib.contextmanager
    def progress(self, label: str, total: int | None) -> Iterator[Callable[..., None]]:
        """Show a progress bar on a terminal.

        Parameters
        ----------
        label : str
            What is being done.
        total : int or None
            Amount of work; None if it is set later.

        Yields
        ------
        callable
            To be called with the amount that has been done so far, a text to stand beside it, if any, and the
            amount of work, if it was not known.
        """
        if not self.is_terminal:
            yield lambda done, note="", total=total: None
            return
        from rich import progress as bars
        from rich.console import Console as RichConsole

        columns = [bars.TextColumn("{task.description}"), bars.BarColumn(), bars.MofNCompleteColumn()]
        columns += [bars.TextColumn("{task.fields[note]}"), bars.TimeElapsedColumn()]
        if total is not None:  # of work whose amount is known, and so its pace
            columns += [bars.TextColumn("left"), bars.TimeRemainingColumn()]
        console = RichConsole(stderr=True)

        def show_cursor() -> None:
            # The bar hides it, and is drawn again now and then. Its own way to end is not safe in the middle
            # of whatever it is doing.
            console.file = io.StringIO()
            if not console.is_dumb_terminal:
                os.write(2, b"\r\x1b[K\x1b[?25h")

        with OnEnd(show_cursor), bars.Progress(*columns, console=console, transient=True) as bar:
            task = bar.add_task(label, total=total, note="")
            yield lambda done, note="", total=total: bar.update(task, completed=done, note=note, total=total)
