"""What goes to the screen beside the answer: echo, progress, warnings and errors, all on stderr."""

from __future__ import annotations

import contextlib
import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

__all__ = ["Console", "print_error", "tolerate_any_encoding"]


def tolerate_any_encoding() -> None:
    """Let a console that lacks a character show a substitute instead of failing."""
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(AttributeError):
            stream.reconfigure(errors="replace")  # type: ignore[union-attr]


def print_error(problems: Sequence[str], hint: str = "") -> None:
    """Print what is wrong and how to put it right, a line each."""
    for problem in problems:
        print(f"error: {problem}", file=sys.stderr)
    for line in hint.splitlines():
        print(f"hint: {line}", file=sys.stderr)


class Console:
    """Messages of a run, all on stderr.

    Parameters
    ----------
    quiet : bool
        Whether only errors are shown.
    """

    def __init__(self, *, quiet: bool) -> None:
        self.quiet = quiet

    @property
    def is_terminal(self) -> bool:
        """Whether a person watches."""
        return not self.quiet and sys.stderr.isatty()

    def echo(self, text: str) -> None:
        """Say what was understood or done."""
        if not self.quiet:
            print(text, file=sys.stderr)

    def warn(self, text: str) -> None:
        """Say what the user should know about the answer."""
        self.echo(f"warning: {text}")

    @contextlib.contextmanager
    def progress(self, label: str, total: int) -> Iterator[Callable[[int], None]]:
        """Show a progress bar on a terminal.

        Parameters
        ----------
        label : str
            What is being done.
        total : int
            Amount of work.

        Yields
        ------
        callable
            To be called with the amount that has been done so far.
        """
        if not self.is_terminal:
            yield lambda done: None
            return
        from rich.console import Console as RichConsole
        from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

        columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
        with Progress(*columns, console=RichConsole(stderr=True), transient=True) as bar:
            task = bar.add_task(label, total=total)
            yield lambda done: bar.update(task, completed=done)
