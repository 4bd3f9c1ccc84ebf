"""The options that every command shares, and its arguments: files and quantities."""

from __future__ import annotations

import functools
import inspect
import re
from collections.abc import Mapping  # get_type_hints reads it
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final, get_origin, get_type_hints

import typer

from vibro.cli.console import Console
from vibro.cli.forms import SERIES
from vibro.core.codes import Output
from vibro.errors import InputError, cut, did_you_mean, shown
from vibro.quantities import QUANTITIES, RATES, find_quantity

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Sequence

    from vibro.quantities import Quantity


def option(
    name: str, text: str, metavar: str | None = None, *, short: str = "", hidden: bool = False, **more: Any
) -> Any:
    """Declare an option, whose default its text tells."""
    names = [short, f"--{name}"] if short else [f"--{name}"]
    return typer.Option(*names, metavar=metavar, help=text, show_default=False, hidden=hidden, **more)


#: Those that ``--help-all`` alone shows.
rare: Final = functools.partial(option, hidden=True)


def typed_names(**values: object) -> list[str]:
    """Name the options that were typed, by their parameters."""
    return [f"--{name.replace('_', '-')}" for name, value in values.items() if value]


RegimesOnlyOption = Annotated[bool, rare("regimes-only", "Regimes, ratios and statuses alone, no speeds.")]
StartsOption = Annotated[
    int | None,
    rare(
        "starts",
        "Lay the part down at so many moments of the drive: which share of parts moves so, and the mean speed"
        " of all; a start of a hopping cell takes up to 2 ms.",
        "N",
    ),
]


def refuse_without_flight(option: str, output: Output) -> None:
    """Refuse an option about hopping bodies if no flights are computed."""
    if output is Output.REGIMES:
        raise InputError(f"{option}: no flight is computed with --regimes-only", hint="leave one of them out")


def _print_version(context: typer.Context, wanted: bool) -> None:
    """Print the version and end, if wanted by a run and not by a line that the shell completes."""
    if wanted and not context.resilient_parsing:
        from vibro.core.compiled import library_path
        from vibro.version import __version__

        slow = "" if library_path() else " (solver not compiled: plain Python, 10 to 30 times slower)"
        print(f"vibro {__version__}{slow}")
        raise typer.Exit


def _print_all_help(context: typer.Context, wanted: bool) -> None:
    """Print the help with the options that it leaves out, and the quantities that have none."""
    if wanted and not context.resilient_parsing:
        for parameter in context.command.params:
            parameter.hidden = False  # type: ignore[attr-defined]
        named = "".join(
            f"  {quantity.typed().ljust(26)} {_text_of(quantity)}\n"
            for quantity in (*QUANTITIES.values(), *getattr(context.command.callback, "more", ()))
            if quantity.options and not quantity.is_option
        )
        if any("NAME=VALUE" in (getattr(p, "metavar", None) or "") for p in context.command.params):
            context.command.epilog = f"\b\nQuantities, as NAME=VALUE:\n{named}"
        print(context.get_help())
        raise typer.Exit


def output_option(forms: Sequence[str]) -> Any:
    """Make the option that says what is written: files with one of these endings."""
    known = " ".join(f".{form}" for form in forms)
    text = f"File to write, by its ending: {known}; - is {forms[0].upper()} on stdout. Repeatable."
    return Annotated[list[str] | None, option("output", text, "PATH", short="-o")]


ForceOption = Annotated[bool, rare("force", "Replace existing files.")]
QuietOption = Annotated[bool, rare("quiet", "Print no messages except errors.", short="-q")]
JsonOption = Annotated[bool, option("json", "Print the answer as JSON.")]
AllOption = Annotated[bool, option("all", "Print all that is known.")]
DebugOption = Annotated[bool, rare("debug", "Show the traceback of an error.")]
SHOW_VERSION: Final = {"text": "Print the version and exit.", "callback": _print_version, "is_eager": True}
VersionOption = Annotated[bool, option("version", **SHOW_VERSION, hidden=True)]
HelpAllOption = Annotated[
    bool, option("help-all", "Show all options.", callback=_print_all_help, is_eager=True)
]


@dataclass(frozen=True, kw_only=True)
class Options:
    """What the shared options say, as typed, and where messages go.

    Attributes
    ----------
    console : Console
        For messages of the run.
    argv : tuple of str
        All arguments, the command first.
    files : tuple of Path
        The files among the arguments.
    given : mapping of str to str
        Quantities of the scene by their names.
    own : mapping of str to str
        Quantities of the command alone, by their names.
    """

    console: Console
    argv: tuple[str, ...] = ()
    files: tuple[Path, ...] = ()
    given: Mapping[str, str] = field(default_factory=dict)
    own: Mapping[str, str] = field(default_factory=dict)
    pack: Annotated[
        str | None,
        rare("pack", "Spring pack that is fitted: a name from [[machine.pack]] of the scene file.", "NAME"),
    ] = None
    output: list[str] | None = None
    json: JsonOption = False
    decimal_comma: Annotated[bool, rare("decimal-comma", "Write CSV with ; and decimal commas.")] = False
    force: ForceOption = False
    quiet: QuietOption = False
    debug: DebugOption = False
    version: VersionOption = False
    help_all: HelpAllOption = False

    @property
    def scene(self) -> Path | None:
        """The scene file, or None."""
        return self.files[0] if self.files else None

    @property
    def names(self) -> list[str]:
        """What tells the files apart: their names without endings, or their paths where these are alike."""
        stems = [path.stem for path in self.files]
        return stems if len({*stems}) == len(stems) else [*map(str, self.files)]

    def of(self, *files: Path, **changed: Any) -> Options:
        """Return the same with other files."""
        return replace(self, files=files, **changed)


_OF_ANSWER: Final = ("json", "decimal_comma")
#: Hint where somebody names the acceleration, or the speed, of a drive.
IN_ITS_UNIT: Final = "give the amplitude this unit: -A 4g, -A 110mm/s or -A '110mm/s rms'"
_NAMED: Final = re.compile(r"([A-Za-z_][\w -]*?)\s*=\s*(.*)", re.DOTALL)
_NUMBER: Final = re.compile(r"[+\N{MINUS SIGN}-]?\.?[0-9][0-9.,:eE+-]*\s*[\w/%\N{DEGREE SIGN}^ ]*")


def read_arguments(
    texts: Sequence[str], most: int | None, more: Mapping[str, Quantity], options: Collection[str]
) -> tuple[tuple[Path, ...], list[tuple[Quantity, str]]]:
    """Tell the files and the quantities among the arguments of a command.

    Parameters
    ----------
    texts : sequence of str
        As typed.
    most : int or None
        Largest number of files; None if there is none.
    more : mapping of str to Quantity
        By name, further quantities than those of a scene.
    options : collection of str
        Those of the command, such as ``--speed``.

    Returns
    -------
    tuple of Path, list of tuple of Quantity and str
        The files, and quantities with their values.

    Raises
    ------
    InputError
        If an argument is neither.
    """
    files: list[Path] = []
    given: list[tuple[Quantity, str]] = []
    for text in texts:
        is_there = _exists(text)
        if not is_there and (found := _NAMED.fullmatch(text)):
            quantity = _own(found[1], more) or find_quantity(found[1])
            if quantity is None or not quantity.options:
                names = [q.column for q in (*QUANTITIES.values(), *more.values()) if q.options]
                hint = did_you_mean(found[1], names) or "--help-all lists the quantities"
                hint = f"write --{found[1]} {found[2]}" if f"--{found[1]}" in options else hint
                hint = IN_ITS_UNIT if quantity and quantity.name in RATES else hint
                raise InputError(f"{cut(text)}: {shown(found[1])} is no quantity", hint=hint)
            given.append((quantity, found[2]))
        else:
            if not is_there:
                _refuse_slip(text)
            files.append(Path(text))
    if most is not None and len(files) > most:
        both = " and ".join(map(str, files[:2]))
        raise InputError(
            f"{both}: {'one file' if most == 1 else f'{most} files'} at most",
            hint="leave one out; vibro solve and vibro drive put several side by side",
        )
    return tuple(files), given


def _exists(text: str) -> bool:
    try:
        return Path(text).exists()
    except OSError:  # a long list is too long for the name of a file
        return False


def _refuse_slip(text: str) -> None:
    """Refuse what names no file that exists and is probably a slip: a value, or a quantity, alone."""
    if text.startswith(("=", "\N{EN DASH}", "\N{EM DASH}")) or text.endswith("="):
        raise InputError(
            f"{cut(text)}: neither an option nor a quantity",
            hint="write NAME=VALUE without blanks, and options with a hyphen, -A 1mm",
        )
    if text.casefold() in _UNITS or _NUMBER.fullmatch(text):
        raise InputError(
            f"{cut(text)}: a value without its option, such as -A or gravity=",
            hint="a number and its unit are one word, -A 1mm; in PowerShell quote a list, -A '1,2,3'",
        )
    if (quantity := find_quantity(text)) and quantity.options:
        raise InputError(
            f"{text}: {quantity.label} without its value",
            hint=f"write {quantity.typed()}; several names are one word, such as mu_s,mu_d",
        )
    if text == "vibro":
        raise InputError("vibro: a command within a command", hint="type one command")


def _own(called: str, more: Mapping[str, Quantity]) -> Quantity | None:
    """Find a quantity of the command alone."""
    name = called.strip().replace("-", "_").replace(" ", "_").casefold()
    return next((q for q in more.values() if name in (q.name, q.column)), None)


_UNITS: Final = {
    unit.casefold() for quantity in QUANTITIES.values() for unit in quantity.kind.sizes if unit.isalpha()
}


def _parameter(name: str, default: Any, annotation: Any) -> inspect.Parameter:
    return inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=annotation)


_FIRST: Final = (
    "amplitude", "stroke", "frequency", "drive_angle", "static_friction", "kinetic_friction",
    "friction_ratio", "trough_length",
)  # fmt: skip


def _text_of(quantity: Quantity) -> str:
    """Say in a few words what a quantity is, and its unit."""
    meaning, *_ = quantity.meaning.split(", ")
    unit = f" [{quantity.unit}]" if quantity.unit else ""
    return f"{meaning[:1].upper()}{meaning[1:]}{unit}{', or 4g, 110mm/s' * (quantity.name == 'amplitude')}."


def _quantity_parameter(quantity: Quantity, *, hidden: bool) -> inspect.Parameter:
    """Make the option of a quantity."""
    own = typer.Option(
        *quantity.options, metavar="X", help=_text_of(quantity), show_default=False, hidden=hidden
    )
    return _parameter(quantity.name, None, Annotated[list[str] | None, own])


def _shared_parameters(
    files: str, forms: Sequence[str], first: Sequence[str], *, of_scene: bool, prints: bool
) -> list[inspect.Parameter]:
    """Make the parameters of a command that are shared: arguments, quantities, and fields of ``Options``."""
    text = "Files; other quantities, such as gravity=3.7." if of_scene else "Files."
    metavar = f"{files}{' [NAME=VALUE]...' if of_scene else ''}"
    argument = typer.Argument(metavar=metavar, help=text, show_default=False, hidden=True)
    left_out = {*([] if of_scene else ["pack"]), *([] if prints else _OF_ANSWER)}
    kinds = {**get_type_hints(Options, include_extras=True), "output": output_option(forms)}
    return [
        _parameter("arguments", None, Annotated[list[str] | None, argument]),
        *(
            _quantity_parameter(quantity, hidden=name not in first)
            for name, quantity in QUANTITIES.items()
            if of_scene and quantity.is_option
        ),
        *(
            _parameter(f.name, f.default, kinds[f.name])
            for f in fields(Options)
            if get_origin(kinds[f.name]) is Annotated and f.name not in left_out
        ),
    ]


def shares_options(
    run: Callable[..., int],
    *,
    files: str = "[SCENE.toml]",
    most: int | None = 1,
    of_scene: bool = True,
    prints: bool = True,
    forms: Sequence[str] = SERIES,
    more: Sequence[Quantity] = (),
    first: Sequence[str] = _FIRST,
) -> Callable[..., int]:
    """Give a command the shared options.

    Parameters
    ----------
    run : callable
        ``run(options, **own)``, where ``own`` are the command's own options; returns the exit code.
    files : str
        How help calls the files that it takes.
    most : int or None
        Largest number of these.
    of_scene : bool
        Whether it takes the quantities of a scene.
    prints : bool
        Whether it has an answer, which can be printed.
    forms : sequence of str
        Endings of the files that it can write.
    more : sequence of Quantity
        Further quantities, which are given as ``NAME=VALUE``.
    first : sequence of str
        Quantities whose options the short help has.

    Returns
    -------
    callable
        Whose signature has a parameter for every shared option, as typer needs it.
    """
    shared = _shared_parameters(files, forms, first, of_scene=of_scene, prints=prints)
    quantities = [p.name for p in shared if p.name in QUANTITIES]
    own_ones = {quantity.name: quantity for quantity in more}
    _, *own = inspect.signature(run, eval_str=True).parameters.values()

    @functools.wraps(run)
    def command(context: typer.Context, **values: Any) -> int:
        typed = {p.name: values.pop(p.name) for p in shared}
        texts = [  # of -A=0.8 without =
            (QUANTITIES[name], text.removeprefix("="))
            for name in quantities
            for text in typed.pop(name) or ()
        ]
        known = {name for parameter in context.command.params for name in parameter.opts}
        paths, named = read_arguments(typed.pop("arguments") or (), most, own_ones, known)
        given: dict[str, str] = {}
        for quantity, text in (*texts, *named):
            if quantity.name in given:
                raise InputError(f"{quantity.label} is given twice", hint="give it once")
            given[quantity.name] = text
        beside = {name: given.pop(name) for name in own_ones if name in given}
        for name in given if not of_scene else ():
            raise InputError(f"{QUANTITIES[name].label}: not used by this command", hint="leave it out")
        console = Console(quiet=typed["quiet"])
        options = Options(
            **typed, console=console, argv=tuple(context.obj), files=paths, given=given, own=beside
        )
        return run(options, **values)

    context = _parameter("context", inspect.Parameter.empty, typer.Context)
    parameters = [p.replace(kind=inspect.Parameter.KEYWORD_ONLY) for p in (context, *shared, *own)]
    command.more = more  # type: ignore[attr-defined]  # for help
    command.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    command.__annotations__ = {p.name: p.annotation for p in parameters}
    return command
