"""What a shell completes: names that options take, read when somebody asks for them."""

from __future__ import annotations

import os
import sys
from typing import TYPE_CHECKING, Final

from vibro.errors import InputError
from vibro.quantities import QUANTITIES, SWEPT

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

_ASKED_BY: Final = "_VIBRO_COMPLETE"  # variable of the environment
_SHELLS: Final = ("bash", "zsh", "fish", "powershell", "pwsh")

Completion = list[tuple[str, str]]


def check_shell() -> None:
    """Refuse to install or show completion where it would be for no shell that there is.

    Raises
    ------
    InputError
        If the program was not started from one of these shells.
    """
    import shellingham  # what typer asks, and would print its answer of on stdout

    try:
        name, _ = shellingham.detect_shell()
    except shellingham.ShellDetectionFailure:
        name = ""
    if name not in _SHELLS:
        told = f"there is none for {name}" if name else "no shell has started this"
        raise InputError(f"completion: {told}", hint="run it in bash, zsh, fish or PowerShell")


def complete_in_plain_text() -> None:
    """Let help texts reach the shell as they are, where it asks for completions and not for a run.

    Typer passes them through rich, if there is one, which drops units as markup, such as [mm], and breaks
    lines, of which fish then offers each.
    """
    if _ASKED_BY in os.environ:
        sys.modules["rich"] = None  # type: ignore[assignment]


def complete_axes(incomplete: str) -> Completion:
    """Complete the name of an axis: its letter, or in full."""
    letters = [(QUANTITIES[name].letter, QUANTITIES[name].label) for name in SWEPT]
    names = [(name, QUANTITIES[name].meaning) for name in SWEPT]
    return [(name, help_) for name, help_ in [*letters, *names] if name.startswith(incomplete)]


def complete_held_axes(incomplete: str) -> Completion:
    """Complete the axis in ``AXIS=VALUE``; nobody knows the value."""
    return [(f"{name}=", help_) for name, help_ in complete_axes(incomplete)]


def listed(names: Callable[[], Iterable[str]]) -> Callable[[str], list[str]]:
    """Make what completes the last name of a list ``a,b,c``, of names that it does not hold yet."""

    def complete(incomplete: str) -> list[str]:
        before, comma, last = incomplete.rpartition(",")
        taken = before.split(",")
        return [before + comma + name for name in names() if name.startswith(last) and name not in taken]

    return complete


def _columns() -> Iterable[str]:
    from vibro.sweeps.columns import column_names

    return column_names()


def _panels() -> Iterable[str]:
    from vibro.plots.history import PANELS

    return PANELS


def _fitted() -> Iterable[str]:
    from vibro.records.fitting import FITTABLE

    return [QUANTITIES[name].letter for name in FITTABLE]


complete_columns = listed(_columns)
complete_fitted = listed(_fitted)
complete_panels = listed(_panels)
