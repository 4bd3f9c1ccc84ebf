"""``vibro motion``: a drive, measured by sensors on the trough."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Final

import typer

from vibro.cli.console import Console
from vibro.cli.exit_codes import ExitCode
from vibro.cli.options import ForceOption, JsonOption, Options
from vibro.cli.record_options import (
    ReverseOption,
    SensitivityOption,
    TimeOption,
    TroughAlongOption,
    TroughNormalOption,
    scene_and_data,
)
from vibro.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from vibro.sweeps.request import Request

__all__ = ["motion_command"]

# In place of the drive while the rest of a scene is read: valid with any rest, in users' units.
_HARMLESS: Final = {"amplitude": "1", "drive_angle": "0", "frequency": "1"}
_FRICTIONS: Final = ("static_friction", "kinetic_friction", "friction_ratio")


def motion_command(
    context: typer.Context,
    options: Options,
    time: TimeOption = None,
    trough_along: TroughAlongOption = None,
    trough_normal: TroughNormalOption = None,
    sensitivity: SensitivityOption = None,
    reverse: ReverseOption = False,
    drive_angle: Annotated[
        str | None,
        typer.Option(
            "-a",
            "--drive-angle",
            metavar="VALUE",
            help="Angle of the drive's line, needed with a single sensor [deg].",
            show_default=False,
        ),
    ] = None,
    output: Annotated[
        list[str] | None,
        typer.Option(
            "-o",
            "--output",
            metavar="DRIVE.toml",
            help="Scene file to write, or its folder; - for stdout.",
            show_default=False,
        ),
    ] = None,
    json: JsonOption = False,
    force: ForceOption = False,
) -> int:
    """Determine a trough's motion, with its harmonics, from a record of one or two sensors on it.

    Amplitudes and phases are printed with their standard errors, the throw number and the amplitude at which
    parts begin to hop. With the friction of a part (--mu-s, --mu-d, or SCENE.toml) its speed is printed too,
    with the effects of noise, of the last harmonic and of wrong calibration. With -o the motion goes to a
    scene file, for vibro solve, vibro map and others.
    """
    from vibro.cli.motion_report import MotionReport
    from vibro.cli.outputs import Outputs
    from vibro.cli.request import question
    from vibro.quantities import DRIVES, LOAD, QUANTITIES, checked_number, scene_fields
    from vibro.records.measured_speeds import hop_onset, speeds_of
    from vibro.records.reading import read_record
    from vibro.records.signals import read_sensitivities
    from vibro.records.waveforms import motion_of
    from vibro.tables.record import json_text

    console = Console(quiet=options.quiet)
    options, data = scene_and_data(options, "motion", "RECORD.csv")
    options = replace(options, output=output, json=json, force=force)
    files = Outputs(
        options, f"{data.stem}-drive", context.obj, console,
        forms=("toml",), pictures=(), reads=(data, options.scene),
    )  # fmt: skip
    angle = None
    if drive_angle is not None:
        quantity = QUANTITIES["drive_angle"]
        told = checked_number(drive_angle, quantity)
        if doubt := quantity.doubt(told, told):
            console.warn(doubt)
        angle = float(quantity.to_si(told))
    request, has_friction = _rest_of_scene(options, context.obj)
    given = {"time": time, "trough_along": trough_along, "trough_normal": trough_normal}
    columns = {name: text for name, text in given.items() if text is not None}
    with files:
        record = read_record(data, columns, read_sensitivities(sensitivity or ()), body=False)
        for note in record.notes:
            console.echo(note)
        measured = motion_of(record, reverse=reverse, drive_angle=angle)
        for warning in measured.warnings:
            console.warn(warning)

        question(request, options, found=(*DRIVES, "frequency", LOAD.name))
        rest = {name: value for name, value in request.fixed.items() if name not in (*DRIVES, "frequency")}
        if not has_friction:
            rest = {name: value for name, value in rest.items() if name not in _FRICTIONS}
        others = scene_fields(rest)
        speeds = speeds_of(measured, others) if has_friction else None
        onset = hop_onset(measured, others)
        lengths = {} if request.length is None else {"trough_length": request.length}
        report = MotionReport(data, measured, onset, speeds, rest | lengths)
        files.write_text(report.scene_file())
    if not files.takes_stdout:
        print(json_text(report.content()) if json else report.text())
    return ExitCode.UNRESOLVED if report.unresolved else ExitCode.DONE


def _rest_of_scene(options: Options, argv: Sequence[str]) -> tuple[Request, bool]:
    """Read the given quantities besides the drive, and whether friction is among them."""
    from vibro.cli.request import request_of
    from vibro.files.scene_files import read_scene_file

    own = read_scene_file(options.scene).scene if options.scene else {}
    if "normal_acceleration" in {*options.given, *own}:
        raise InputError(
            "vibro motion computes no speed of a clamped part",
            hint="leave its normal force out, and give it to vibro solve beside the motion that -o writes",
        )
    has_friction = not {*options.given, *own}.isdisjoint(_FRICTIONS)
    frictions = {} if has_friction else {"static_friction": "1", "kinetic_friction": "1"}
    given = {**options.given, **_HARMLESS, **frictions}
    why = "the record is what the machine does"
    return request_of(replace(options, given=given), argv, without_machine=why), has_friction
