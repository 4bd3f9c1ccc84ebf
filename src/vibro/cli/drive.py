"""``vibro drive``: the set-up sheet of a machine, and its fit to measured amplitudes."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from vibro.cli.console import Console
from vibro.cli.options import FormatOption, Options, picture_formats
from vibro.errors import InputError, shown

if TYPE_CHECKING:
    from vibro.files.scene_files import SceneFile

__all__ = ["drive_command"]


def drive_command(
    context: typer.Context,
    options: Options,
    fit: Annotated[
        Path | None,
        typer.Option(
            "--fit",
            metavar="POINTS.csv",
            help="Instead fit natural frequency and damping to measured amplitudes of the empty machine:"
            " columns frequency_hz and amplitude_mm, or stroke_mm, and if known error_percent.",
            show_default=False,
        ),
    ] = None,
    law: Annotated[
        str | None,
        typer.Option(
            "--law",
            metavar="constant|square",
            help="With --fit and without a file: how the force depends on frequency. It is constant for"
            " magnets; with unbalance on the trough it grows with the square.",
            show_default=False,
        ),
    ] = None,
    amplitude_error: Annotated[
        str | None,
        typer.Option(
            "--amplitude-error",
            metavar="VALUE",
            help="With --fit: relative standard error of a measured amplitude [%]. Without it the residuals of"
            " 5 or more points tell it.",
            show_default=False,
        ),
    ] = None,
    formats: FormatOption = "png",
) -> int:
    """Print the set-up sheet of a machine with its filling, or fit the machine to measured amplitudes.

    SCENE.toml has a table [machine].
    """
    wanted = picture_formats(formats)
    console = Console(quiet=options.quiet)
    if fit is None:
        for option, value in (("--law", law), ("--amplitude-error", amplitude_error)):
            if value is not None:
                raise InputError(f"{option} belongs to --fit", hint="add --fit POINTS.csv, or leave it out")
        raise InputError("--fit is missing")
    if law not in (None, "constant", "square"):
        raise InputError(
            f"--law {shown(law)}: must be constant or square", hint="constant is that of magnets"
        )
    from vibro.cli.drive_fit import fit_points

    if options.given:
        names = ", ".join(f"--{name.replace('_', '-')}" for name in options.given)
        raise InputError(f"{names}: not used by --fit", hint="leave it out, or leave out --fit")
    file = _scene_file(options.scene)
    frequency = file.scene["frequency"].value if file and "frequency" in file.scene else None
    return fit_points(
        fit,
        file.machine if file else None,
        frequency,
        law=law,
        amplitude_error=amplitude_error,
        formats=wanted,
        options=options,
        argv=context.obj,
        console=console,
    )


def _scene_file(path: Path | None) -> SceneFile | None:
    """Read a scene file, which must have a machine."""
    from vibro.files.scene_files import read_scene_file

    if path is None:
        return None
    file = read_scene_file(path)
    if file.machine is None:
        hint = "add [machine] with kind, masses, natural_hz and damping_ratio; docs/machines.md has examples"
        raise InputError(f"{path}: there is no table [machine]", hint=hint)
    return file
