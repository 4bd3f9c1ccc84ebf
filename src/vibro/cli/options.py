"""The options that every command shares."""

from __future__ import annotations

import functools
import inspect
from dataclasses import dataclass, fields
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final, get_type_hints

import typer

from vibro.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable

__all__ = [
    "Accuracy",
    "AccuracyOption",
    "Flight",
    "FlightOption",
    "Options",
    "picture_formats",
    "print_version",
    "shares_options",
]

_FORMATS: Final = ("png", "svg", "pdf")


class Flight(StrEnum):
    """Whether hopping bodies are followed through the air."""

    ON = "on"
    OFF = "off"


class Accuracy(StrEnum):
    """Whether cells are solved, or their regimes and ratios alone are found."""

    EXACT = "exact"
    REGIMES = "regimes"


FlightOption = Annotated[
    Flight, typer.Option("--flight", help="Without flight, cells that hop have a regime but no numbers.")
]
AccuracyOption = Annotated[
    Accuracy, typer.Option("--accuracy", help="With regimes alone no speeds are computed.")
]


def print_version(wanted: bool) -> None:
    """Print the version and end, if wanted."""
    if wanted:
        from vibro import __version__

        print(f"vibro {__version__}")
        raise typer.Exit


def picture_formats(text: str) -> list[str]:
    """Read the formats that pictures are to have, such as ``png,svg``."""
    names = list(dict.fromkeys(name.strip().casefold() for name in text.split(",")))
    for name in names:
        if name not in _FORMATS:
            raise InputError(
                f"--format {text}: {name!r} is not a format of pictures",
                hint=f"they are {', '.join(_FORMATS)}",
            )
    return names


def _quantity(*names: str, text: str, metavar: str = "VALUE") -> Any:
    return typer.Option(*names, metavar=metavar, help=text, show_default=False)


@dataclass(frozen=True, kw_only=True)
class Options:
    """What the shared options say, as typed."""

    scene: Annotated[
        Path | None,
        typer.Argument(metavar="SCENE.toml", help="A scene file; options override it.", show_default=False),
    ] = None
    amplitude: Annotated[str | None, _quantity("-A", "--amplitude", text="Amplitude of the drive [mm].")] = (
        None
    )
    stroke: Annotated[str | None, _quantity("--stroke", text="Peak to peak, twice the amplitude [mm].")] = (
        None
    )
    frequency: Annotated[str | None, _quantity("-f", "--frequency", text="Drive frequency [Hz].")] = None
    drive_angle: Annotated[
        str | None,
        _quantity(
            "-a", "--drive-angle", "--alpha", text="Angle of the drive above the trough's surface [deg]."
        ),
    ] = None
    static_friction: Annotated[str | None, _quantity("--mu-s", text="Static friction.")] = None
    kinetic_friction: Annotated[str | None, _quantity("--mu-d", text="Kinetic friction, at most static.")] = (
        None
    )
    friction_ratio: Annotated[
        str | None, _quantity("--mu-ratio", text="Kinetic over static friction, instead of --mu-d.")
    ] = None
    trough_angle: Annotated[
        str | None, _quantity("--trough-angle", text="Climb of the trough in the conveying direction [deg].")
    ] = None
    gravity: Annotated[str | None, _quantity("--gravity", text="Acceleration of gravity [m/s^2].")] = None
    restitution: Annotated[str | None, _quantity("--restitution", text="Of an impact on the trough.")] = None
    trough_length: Annotated[str | None, _quantity("-L", "--length", text="Length of the trough [mm].")] = (
        None
    )
    output: Annotated[
        str | None,
        typer.Option(
            "-o",
            "--output",
            metavar="STEM",
            help="Stem or folder of the files, - for stdout.",
            show_default=False,
        ),
    ] = None
    json: Annotated[bool, typer.Option("--json", help="Print the answer as JSON.")] = False
    excel: Annotated[bool, typer.Option("--excel", help="Begin CSV with a byte order mark.")] = False
    decimal_comma: Annotated[
        bool, typer.Option("--decimal-comma", help="Write CSV with ; and decimal commas.")
    ] = False
    force: Annotated[bool, typer.Option("--force", help="Replace existing files.")] = False
    quiet: Annotated[bool, typer.Option("-q", "--quiet", help="Print errors alone.")] = False
    debug: Annotated[bool, typer.Option("--debug", help="Show the traceback of an error.")] = False
    version: Annotated[
        bool,
        typer.Option("--version", help="Print the version and exit.", callback=print_version, is_eager=True),
    ] = False


def shares_options(run: Callable[..., int]) -> Callable[..., int]:
    """Give a command the shared options.

    Parameters
    ----------
    run : callable
        ``run(context, options, **own)``, where ``own`` are the command's own options; returns the exit code.

    Returns
    -------
    callable
        Whose signature has a parameter for every shared option, as typer needs it.
    """
    annotations = get_type_hints(Options, include_extras=True)
    shared = [
        inspect.Parameter(
            f.name, inspect.Parameter.KEYWORD_ONLY, default=f.default, annotation=annotations[f.name]
        )
        for f in fields(Options)
    ]
    context, _, *own = inspect.signature(run, eval_str=True).parameters.values()

    @functools.wraps(run)
    def command(**values: Any) -> int:
        options = Options(**{p.name: values.pop(p.name) for p in shared})
        return run(values.pop(context.name), options, **values)

    parameters = [p.replace(kind=inspect.Parameter.KEYWORD_ONLY) for p in (context, *shared, *own)]
    command.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    command.__annotations__ = {p.name: p.annotation for p in parameters}
    return command
