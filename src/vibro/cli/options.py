"""The options that every command shares."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final, get_type_hints

import typer

from vibro.cli.outputs import SERIES
from vibro.core.codes import Output
from vibro.errors import InputError
from vibro.quantities import DRIVES, MACHINE, QUANTITIES

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from vibro.quantities import Quantity


class Flight(StrEnum):
    """Whether hopping bodies are followed through the air."""

    ON = "on"
    OFF = "off"


FlightOption = Annotated[
    Flight, typer.Option("--flight", help="Without flight, cells that hop have a regime but no numbers.")
]
RegimesOnlyOption = Annotated[
    bool, typer.Option("--regimes-only", help="Compute regimes, ratios and statuses only, no speeds.")
]
CoexistOption = Annotated[
    bool,
    typer.Option(
        "--coexist",
        help="Search for other motions in which a hopping body could settle after a push; it takes several ms"
        " per hopping cell, of tables and of pictures. In contact they are known without a search.",
    ),
]


def refuse_without_flight(option: str, flight: Flight, output: Output) -> None:
    """Refuse an option about hopping bodies if no flights are computed."""
    if flight is Flight.OFF or output is Output.REGIMES:
        raise InputError(
            f"{option}: no flight is modelled with --flight off or --regimes-only",
            hint="leave one of them out",
        )


def print_version(context: typer.Context, wanted: bool) -> None:
    """Print the version and end, if wanted by a run and not by a line that the shell completes."""
    if wanted and not context.resilient_parsing:
        from vibro import __version__
        from vibro.core.compiled import library_path

        slow = "" if library_path() else " (solver not compiled: plain Python, 10 to 30 times slower)"
        print(f"vibro {__version__}{slow}")
        raise typer.Exit


def output_option(forms: Sequence[str]) -> Any:
    """Make the option that says what is written: files with one of these endings."""
    known = " ".join(f".{form}" for form in forms)
    text = (
        f"A file to write; its ending says what: {known}. A name without an ending is that of all usual files"
    )
    text += f", - is {forms[0].upper()} on stdout. Repeatable."
    option = typer.Option("-o", "--output", metavar="PATH", help=text, show_default=False)
    return Annotated[list[str] | None, option]


ForceOption = Annotated[bool, typer.Option("--force", help="Replace existing files.")]
QuietOption = Annotated[bool, typer.Option("-q", "--quiet", help="Print no messages except errors.")]
JsonOption = Annotated[bool, typer.Option("--json", help="Print the answer as JSON.")]
DebugOption = Annotated[bool, typer.Option("--debug", help="Show the traceback of an error.")]
VersionOption = Annotated[
    bool,
    typer.Option("--version", help="Print the version and exit.", callback=print_version, is_eager=True),
]


@dataclass(frozen=True, kw_only=True)
class Options:
    """What the shared options say, as typed; ``given`` are the quantities by their names."""

    scene: Annotated[
        Path | None,
        typer.Argument(metavar="SCENE.toml", help="A scene file; options override it.", show_default=False),
    ] = None
    given: Mapping[str, str] = field(default_factory=dict)
    pack: Annotated[
        str | None,
        typer.Option(
            "--pack",
            metavar="NAME",
            help="Spring pack that is fitted: a name from [[machine.pack]] of the scene file.",
            show_default=False,
        ),
    ] = None
    output: list[str] | None = None
    json: JsonOption = False
    decimal_comma: Annotated[
        bool, typer.Option("--decimal-comma", help="Write CSV with ; and decimal commas.")
    ] = False
    force: ForceOption = False
    quiet: QuietOption = False
    debug: DebugOption = False
    version: VersionOption = False


_OF_TABLE: Final = ("json", "decimal_comma")
_OF_ANSWER: Final = ("output", *_OF_TABLE, "force")


def _parameter(name: str, default: Any, annotation: Any) -> inspect.Parameter:
    return inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=annotation)


def _quantity_parameter(quantity: Quantity) -> inspect.Parameter:
    """Make the option of a quantity."""
    unit = f" [{quantity.unit}]" if quantity.unit else ""
    text = f"{quantity.meaning[:1].upper()}{quantity.meaning[1:]}{unit}."
    option = typer.Option(*quantity.options, metavar="VALUE", help=text, show_default=False)
    return _parameter(quantity.name, None, Annotated[str | None, option])


def shares_options(
    run: Callable[..., int],
    *,
    of_scene: bool = True,
    of_drive: bool = True,
    of_answer: bool = True,
    of_table: bool = True,
    forms: Sequence[str] = SERIES,
) -> Callable[..., int]:
    """Give a command the shared options.

    Parameters
    ----------
    run : callable
        ``run(context, options, **own)``, where ``own`` are the command's own options; returns the exit code.
    of_scene : bool
        Whether it takes a scene file, and the quantities of a scene.
    of_drive : bool
        Whether it takes those of the drive too.
    of_answer : bool
        Whether it has an answer, which can be printed and written to files.
    of_table : bool
        Whether that answer is numbers, which can be written as CSV or JSON.
    forms : sequence of str
        Endings of the files that it can write.

    Returns
    -------
    callable
        Whose signature has a parameter for every shared option, as typer needs it.
    """
    annotations = get_type_hints(Options, include_extras=True)
    refused = () if of_drive else ("stroke", "frequency", *DRIVES, *MACHINE)
    quantities = [
        name for name, quantity in QUANTITIES.items() if of_scene and quantity.options and name not in refused
    ]
    left_out = {
        *([] if of_scene else ["scene"]),
        *([] if of_scene and of_drive else ["pack"]),
        *([] if of_answer else _OF_ANSWER),
        *([] if of_table else _OF_TABLE),
    }
    shared = []
    for f in fields(Options):
        if f.name == "given":
            shared += [_quantity_parameter(QUANTITIES[name]) for name in quantities]
        elif f.name not in left_out:
            is_output = f.name == "output"
            kind = output_option(forms) if is_output else annotations[f.name]
            shared.append(_parameter(f.name, f.default, kind))
    context, _, *own = inspect.signature(run, eval_str=True).parameters.values()

    @functools.wraps(run)
    def command(**values: Any) -> int:
        typed = {p.name: values.pop(p.name) for p in shared}
        texts = {name: typed.pop(name) for name in quantities}
        options = Options(**typed, given={name: text for name, text in texts.items() if text is not None})
        return run(values.pop(context.name), options, **values)

    parameters = [p.replace(kind=inspect.Parameter.KEYWORD_ONLY) for p in (context, *shared, *own)]
    command.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    command.__annotations__ = {p.name: p.annotation for p in parameters}
    return command
