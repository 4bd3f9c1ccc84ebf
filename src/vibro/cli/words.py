"""Python's words in those of the command line: arguments as options, functions as commands.

All rooms below speak to people who call them, also from Python: ``force=True``, ``vibro.solve``. To users of
a command these would mean nothing, so its messages are translated where they are printed.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

__all__ = ["in_options", "options_of", "speak_in"]

#: Functions by the commands that do the same.
COMMANDS: Final = {
    "arrival_time": "traverse-time",
    "design": "design",
    "measured_motion": "motion",
    "open_sweep": "map",
    "read_scene": "solve",
    "simulate": "simulate",
    "solve": "solve",
    "sweep": "map",
    "write_sweep": "map",
}

# A function, with one text as its argument or none.
_CALL: Final = re.compile(rf'\bvibro\.({"|".join(COMMANDS)})\b(?:\((?:"([^"]*)")?\))?')
# An argument: a switch, a text, an angle, a number that is no part of a file's name; or its name alone.
_ARGUMENT: Final = re.compile(
    r"""(?<![^\s(])([a-z]\w*)=
    (?: True\b
      | "(?P<text>[^"]*)"
      | '(?P<shown>[^']*)'
      | math\.radians\((?P<angle>[^()]*)\)
      | (?P<number>-?[0-9]+(?:\.[0-9]+)?(?:e[+-]?[0-9]+)?)(?![\w/\\-]|\.\w)
      | (?=[\s,;:.)]|$)
    )""",
    re.VERBOSE,
)
#: Arguments that options call otherwise.
_OTHERWISE: Final = {"folder": "output"}
_OPTION: Final = re.compile(r"(?<!\S)--?[A-Za-z]")
_PLAIN: Final = re.compile(r"[\w%+,./:=@^\u00b0-]+")  # what needs no quotes in any shell

_current: dict[str, str] = {}


def options_of(parameters: Iterable[Any]) -> dict[str, str]:
    """Return the first spelling of each option among the parameters of a command, by the argument's name."""
    return {p.name: p.opts[0] for p in parameters if p.param_type_name == "option"}


def speak_in(options: Mapping[str, str]) -> None:
    """Use the options of the command that runs, from now on."""
    _current.clear()
    _current.update(options)


def in_options(text: str) -> str:
    """Write a message of Python's in the words of the command that runs.

    Parameters
    ----------
    text : str
        In which arguments are written without blanks: ``force=True``, ``trough_along="ax [m/s^2]"``,
        ``mass=0.02``, ``drive_angle=math.radians(20)``, or ``frequency=`` without a value. Names that are no
        options of the command stay, and so do texts that hold options: the command line wrote those.
    """
    if _OPTION.search(text):
        return text
    return _CALL.sub(_command, _ARGUMENT.sub(_option, text))


def _command(found: re.Match[str]) -> str:
    function, argument = found.groups()
    return f"vibro {COMMANDS[function]}" + (f" {_quoted(argument)}" if argument else "")


def _option(found: re.Match[str]) -> str:
    option = _current.get(_OTHERWISE.get(found[1], found[1]))
    if option is None:
        return found[0]
    value = next((given for given in found.groups()[1:] if given is not None), None)
    if value is None:
        return option
    # Behind a blank, -60deg would be an option.
    is_negative = value.startswith("-") and value != "-" and option.startswith("--")
    return f"{option}{'=' if is_negative else ' '}{_quoted(value)}"


def _quoted(value: str) -> str:
    return value if _PLAIN.fullmatch(value) else f'"{value}"'
