"""What the commands that read records share: the options of columns, and their two arguments."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from vibro.cli.options import Options
from vibro.errors import InputError

if TYPE_CHECKING:
    from pathlib import Path

__all__ = [
    "ReverseOption",
    "SensitivityOption",
    "TimeOption",
    "TroughAlongOption",
    "TroughNormalOption",
    "column_option",
    "scene_and_data",
]


def column_option(name: str, text: str) -> Any:
    """Make the option that names a column of a record."""
    return typer.Option(f"--{name}", metavar="HEADER", help=text, show_default=False)


TimeOption = Annotated[str | None, column_option("time", "Column of the time.")]
TroughAlongOption = Annotated[
    str | None,
    column_option(
        "trough-along",
        "Column of the trough's acceleration (or velocity, or displacement) along its surface, from which"
        " amplitude and frequency follow.",
    ),
]
TroughNormalOption = Annotated[
    str | None,
    column_option(
        "trough-normal",
        "The same normal to its surface, upwards; from both the drive angle or the ellipse follows too.",
    ),
]
SensitivityOption = Annotated[
    list[str] | None,
    typer.Option(
        "--sensitivity",
        metavar="100mV/g",
        help="Sensitivity of a sensor that gives voltages; for one of several columns: velocity=125mm/s/V.",
        show_default=False,
    ),
]
ReverseOption = Annotated[
    bool, typer.Option("--reverse", help="The data's axis points against the conveying direction.")
]


def scene_and_data(options: Options, command: str, called: str = "DATA.csv") -> tuple[Options, Path]:
    """Tell scene file and data apart: the scene may be given by options alone."""
    scenes = [path for path in options.files if path.suffix.casefold() == ".toml"]
    others = [path for path in options.files if path not in scenes]
    if len(others) != 1:
        raise InputError(
            f"{len(others)} records of {len(options.files)} files: one is wanted, {called}",
            hint=f"for example: vibro {command} scene.toml data.csv",
        )
    return options.of(*scenes), others[0]
