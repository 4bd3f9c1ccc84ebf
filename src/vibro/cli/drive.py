"""``vibro drive``: the set-up sheet of a machine, and its fit to measured amplitudes."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from vibro.cli.console import Console
from vibro.cli.options import Options
from vibro.errors import InputError, cut, shown
from vibro.quantities import QUANTITIES, kinetic_friction, nearest_double

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from matplotlib.figure import Figure

    from vibro.files.machines import GivenMachine
    from vibro.files.scene_files import SceneFile

__all__ = ["drive_command"]

_SETTINGS: Final = (25.0, 50.0, 75.0, 100.0)  # [%] of the machine's own
_MOST_SETTINGS: Final = 12
_BANDS: Final = ("voltage", "filling", "static_friction", "kinetic_friction")


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
            help="With --fit: relative standard error of a measured amplitude [%]. Without it the residuals"
            " of 5 or more points tell it.",
            show_default=False,
        ),
    ] = None,
) -> int:
    """Print the set-up sheet of a machine and its filling, or fit the machine to measured amplitudes.

    SCENE.toml has a table [machine]. The sheet lists amplitude and speed at each setting, empty and full, the
    side of resonance on which the drive runs, the guaranteed speed, and the effect of mains, filling and
    other springs. Here --setting takes a list (25,50,100), and --voltage, --filling, --mu-s and --mu-d take
    bands, such as 90:110.
    -o NAME writes the operating points, NAME.csv, and amplitude and speed over frequency, NAME-response.png.
    """
    console = Console(quiet=options.quiet)
    if fit is None:
        for option, value in (("--law", law), ("--amplitude-error", amplitude_error)):
            if value is not None:
                raise InputError(f"{option} belongs to --fit", hint="add --fit POINTS.csv, or leave it out")
        return _sheet(options, context.obj, console)
    if law not in (None, "constant", "square"):
        raise InputError(
            f"--law {shown(law)}: must be constant or square", hint="constant is that of magnets"
        )
    from vibro.cli.drive_fit import fit_points

    unused = [QUANTITIES[name].typed() for name in options.given]
    if unused := unused + (["--pack"] if options.pack is not None else []):
        names = ", ".join(unused)
        raise InputError(f"{names}: not used by --fit", hint="leave it out, or leave out --fit")
    file = _scene_file(options.scene)
    return fit_points(
        fit,
        file.machine if file else None,
        law=law,
        amplitude_error=amplitude_error,
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
        hint = "add [machine] with kind, masses, natural_hz and damping_ratio; see docs/guide/machines.md"
        raise InputError(f"{path}: there is no table [machine]", hint=hint)
    return file


def _sheet(options: Options, argv: Sequence[str], console: Console) -> int:
    """Print the set-up sheet, and write its files where they are wanted."""
    from vibro.cli.drive_report import columns, content, picture_texts, report
    from vibro.cli.exit_codes import ExitCode
    from vibro.cli.outputs import Outputs
    from vibro.cli.request import question, request_of
    from vibro.core.codes import Status
    from vibro.reports.set_up_sheet import SheetRequest, make_sheet
    from vibro.tables.record import json_text

    if options.scene is None:
        hint = "vibro drive feeder.toml; or vibro drive --fit POINTS.csv fits a machine to amplitudes"
        raise InputError("a scene file with a machine is missing", hint=hint)
    file = _scene_file(options.scene)
    assert file is not None
    assert file.machine is not None
    given, typed = file.machine, dict(options.given)
    own = {name: spec.value for name, spec in file.scene.items() if not spec.varies}
    bands = _given_bands(typed, given, own)
    settings = _settings(typed, given)
    request = request_of(replace(options, given=typed), argv)
    question(request, options)
    values = {**request.fixed}
    if "friction_ratio" in values:
        ratio = values.pop("friction_ratio")
        if "static_friction" in bands:
            raise InputError(
                "--mu-ratio beside a band of static friction leaves the band of kinetic friction open",
                hint="give --mu-d lo:hi instead",
            )
        values.setdefault("kinetic_friction", float(kinetic_friction(ratio, values["static_friction"])))
    values["filling"] = 0.0
    with Outputs(
        options, f"{file.name}-drive", argv, console, pictures=("response",), reads=(options.scene,)
    ) as output:
        with console.progress("guaranteeing", len(settings)) as bar:
            asked = SheetRequest(given, values, settings, bands)
            sheet = make_sheet(asked, picture=bool(output.pictures), progress=bar)
        for warning in sheet.warnings:
            console.warn(warning)
        told = content(sheet)

        def draw() -> dict[str, Figure]:
            from vibro.plots.responses import drive_figure

            assert sheet.picture is not None
            return {"response": drive_figure(sheet.picture, *picture_texts(sheet, file.name))}

        output.write(lambda: {"": columns(sheet)}, draw, told)
    if options.json and not output.takes_stdout:
        print(json_text(told))
    elif not output.takes_stdout:
        print(report(sheet, file.name))
    rows = [row for pair in sheet.settings for row in pair]
    unresolved = any(row.status is Status.UNRESOLVED for row in rows)
    return ExitCode.UNRESOLVED if unresolved else ExitCode.DONE


def _settings(typed: dict[str, str], given: GivenMachine) -> tuple[float, ...]:
    """Return the settings of the sheet, ascending, and keep the largest among the typed values."""
    from vibro.axes import parse_axis

    quantity = QUANTITIES["setting"]
    if "setting" in typed:
        text = typed["setting"]
        settings = sorted({*parse_axis(text, quantity).axis(len(_SETTINGS)).values.tolist()})
        if len(settings) > _MOST_SETTINGS:
            hint = "setting=25,50,75,100, or setting=25:100:4"
            raise InputError(f"setting={cut(text)}: at most {_MOST_SETTINGS} settings are told", hint=hint)
        typed["setting"] = f"{settings[-1]:.15g}"
        return tuple(settings)
    if not given.takes("setting"):
        return (100.0,)
    if "setting" in given.bands:
        import numpy as np

        return tuple(np.linspace(*given.bands["setting"], len(_SETTINGS)).tolist())
    own = given.own.get("setting", 100.0)
    return tuple(own * share / 100.0 for share in _SETTINGS)


def _given_bands(
    typed: dict[str, str], given: GivenMachine, own: Mapping[str, float]
) -> dict[str, tuple[float, float]]:
    """Return the bands in users' units, and leave nominal values in what was typed."""
    bands = {name: band for name, band in given.bands.items() if name in _BANDS}
    if filling := given.own.get("filling"):
        bands["filling"] = filling, filling
    for name in _BANDS:
        text = typed.get(name)
        if text is None:
            continue
        quantity = QUANTITIES[name]
        if ":" not in text and name != "filling":
            bands.pop(name, None)
            continue
        ends = [nearest_double(end, quantity) for end in text.split(":")]
        if len(ends) > 2 or ends[0] > ends[-1]:
            hint = f"{quantity.typed('lo:hi')} is all between two ends"
            raise InputError(
                f"{quantity.typed(cut(text))}: must be a value or lo:hi with lo at most hi", hint=hint
            )
        for end in ends:
            if not quantity.allows(quantity.to_si(end)):
                raise InputError(
                    f"{quantity.typed(cut(text))}: must be {quantity.allowed.text(quantity.unit)}"
                )
        low, high = ends[0], ends[-1]
        bands[name] = low, high
        nominal = own.get(name, quantity.default)
        if name == "filling" or nominal is None or not low <= nominal <= high:
            nominal = 0.0 if name == "filling" else 0.5 * (low + high)
        typed[name] = f"{nominal:.17g}"
    return {name: bands[name] for name in _BANDS if name in bands}
