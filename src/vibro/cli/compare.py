"""``vibro compare``: a measured or simulated record beside the exact motion."""

from __future__ import annotations

import math
import shlex
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from vibro.cli.console import Console
from vibro.cli.exit_codes import ExitCode
from vibro.cli.options import Options
from vibro.cli.record_options import (
    ReverseOption,
    SensitivityOption,
    TimeOption,
    TroughAlongOption,
    TroughNormalOption,
    column_option,
    scene_and_data,
)
from vibro.errors import InputError, cut, shown
from vibro.quantities import (
    AMPLITUDES,
    ELLIPTICAL,
    LINEAR,
    QUANTITIES,
    SCALE,
    STANDS_FOR,
    scene_fields,
)

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from vibro.records.folding import Estimate
    from vibro.records.reading import Record
    from vibro.records.trough import MeasuredDrive, Trough
    from vibro.records.waveforms import HarmonicDrive, MeasuredMotion
    from vibro.sweeps.request import Request

__all__ = ["compare_command"]

_NO_MACHINE: Final = "a record is compared with the motion that the trough had"

# In place of the measured drive while the rest of a scene is read: valid with any rest [SI].
_HARMLESS: Final = {
    "amplitude": 1e-3,
    "drive_angle": 0.0,
    "along_amplitude": 1e-3,
    "normal_amplitude": 1e-3,
    "normal_phase": 0.0,
    "frequency": 1.0,
}


def compare_command(
    context: typer.Context,
    options: Options,
    time: TimeOption = None,
    displacement: Annotated[
        str | None,
        column_option("displacement", "Column of the displacement relative to the trough, or --absolute."),
    ] = None,
    velocity: Annotated[str | None, column_option("velocity", "Column of the relative velocity.")] = None,
    acceleration: Annotated[
        str | None, column_option("acceleration", "Column of the relative acceleration.")
    ] = None,
    friction: Annotated[
        str | None,
        column_option("friction", "Column of the friction force on the body; needs --mass."),
    ] = None,
    trough_along: TroughAlongOption = None,
    trough_normal: TroughNormalOption = None,
    sensitivity: SensitivityOption = None,
    mass: Annotated[
        str | None, typer.Option("--mass", metavar="VALUE", help="Mass of the body [kg].", show_default=False)
    ] = None,
    reverse: ReverseOption = False,
    absolute: Annotated[
        bool,
        typer.Option(
            "--absolute",
            help="The data are motions over the ground, as a camera on a tripod sees them: the trough's is in"
            " them.",
        ),
    ] = False,
    fit: Annotated[
        str | None,
        typer.Option(
            "--fit",
            metavar="mu_s,mu_d,A,alpha",
            help="Estimate any of these from the data; of an ellipse mu_s,mu_d,X,Y,phi.",
            show_default=False,
        ),
    ] = None,
) -> int:
    """Compare a record of a sensor, or of a CAD motion study, with the exact steady motion of a scene.

    Columns are found by their units, or named: --time "Time [s]" --displacement "X [mm]". The unknown
    trigger time is found. Measured and computed figures are printed; -o NAME writes NAME.csv (signals),
    NAME-summary.csv, NAME.json and a picture.
    """
    from vibro.cli.compare_report import comparison_report
    from vibro.cli.outputs import Outputs, scene_record
    from vibro.cli.request import question, request_of
    from vibro.quantities import DRIVES, LOAD, MASS, checked_number
    from vibro.records.alignment import Observation, check_scene
    from vibro.records.comparison import compare
    from vibro.records.comparison_tables import ComparisonTables
    from vibro.records.headers import TroughAloneError
    from vibro.records.reading import read_record
    from vibro.records.signals import read_sensitivities
    from vibro.records.trough import trough_of

    console = Console(quiet=options.quiet)
    names = _fitted_names(fit)
    options, data = scene_and_data(options, "compare")
    body = None
    if mass is not None:
        body = checked_number(mass, MASS)
    if friction is not None and body is None:
        raise InputError("a force needs the mass of the body", hint="give --mass 0.02kg")
    given = {
        "time": time,
        "displacement": displacement,
        "velocity": velocity,
        "acceleration": acceleration,
        "friction": friction,
        "trough_along": trough_along,
        "trough_normal": trough_normal,
    }
    columns = {name: text for name, text in given.items() if text is not None}
    try:
        record = read_record(data, columns, read_sensitivities(sensitivity or ()))
    except TroughAloneError as exc:
        command = _motion_command(options, data, columns, sensitivity or (), reverse=reverse)
        raise InputError(*exc.problems, hint=f"what the feeder does: {command}\n{exc.hint}") from None
    for note in record.notes:
        console.echo(note)
    if "friction" in record.signals and body is None:
        console.warn(f"column {record.headers['friction']!r} is left out: a force needs --mass")
    elliptical = _elliptical(options)
    trough = trough_of(record, reverse=reverse, down=elliptical)
    drive: MeasuredDrive | HarmonicDrive | None = None
    if trough is None:
        request = request_of(options, context.obj, without_machine=_NO_MACHINE)
    else:
        first, request = _with_measured(trough, elliptical, options, context.obj, console)
        drive, fits = first, bool(names)
        measured = _measured_motion(record, reverse, elliptical, first, request, fits=fits)
        if measured is not None:
            drive, request = _with_harmonics(
                measured, first, request, options, context.obj, console, fits=fits
            )
        if drive is first and request.is_waveform:
            # The measured fundamental must not be mixed with harmonics that the scene gives.
            raise _two_motions()
        for warning in drive.warnings:
            console.warn(warning)
    question(request, options, found=() if trough is None else (*DRIVES, "frequency", LOAD.name))
    scene = request.scene()
    check_scene(scene)
    observation = Observation.of(
        record,
        float(scene.frequency),
        mass=body,
        reverse=reverse,
        clock=drive.clock if drive else None,
        absolute=absolute,
    )
    name, kinds = f"{data.stem}-compare", ("", "summary")
    with Outputs(options, name, context.obj, console, tables=kinds, reads=(data, options.scene)) as output:
        comparison = compare(scene, observation)
        if observation.middle is not observation:
            rows = observation.middle.time.size
            console.echo(
                f"alignment{' and fit' if names else ''}: the middle {rows} of {observation.time.size} rows"
            )
        for warning in comparison.warnings:
            console.warn(warning)
        found = None
        if names:
            from vibro.records.fitting import fit as fit_scene

            with console.progress("fitting", None) as bar:

                def show(done: int, total: int, what: str) -> None:
                    bar(done, what, total)

                found = fit_scene(scene, observation, names, drive.moved if drive else (), show)

        tables = ComparisonTables(comparison, record, body, found, drive)
        content = {"scene": scene_record(request), "data": str(data), **tables.content()}
        for told in filter(None, (content, content.get("trough"))):
            told["warnings"] = list(told["warnings"])
        computed = f"computed pattern {comparison.motion.pattern}"
        title = f"{' – '.join(filter(None, (data.name, request.name)))}, {computed}"

        def draw() -> dict[str, Any]:
            from vibro.plots.comparison import comparison_figure

            return {
                "": comparison_figure(
                    comparison, title, request.told, compare(found.scene, observation) if found else None
                )
            }

        output.write(lambda: {"": tables.signals(), "summary": tables.summary()}, draw, content)
    if output.takes_stdout:
        return ExitCode.DONE
    if options.json:
        from vibro.tables.record import json_text

        print(json_text(content))
    else:
        print(comparison_report(tables, data, request))
    return ExitCode.DONE


def _motion_command(
    options: Options, data: Path, columns: Mapping[str, str], sensitivity: Sequence[str], *, reverse: bool
) -> str:
    """Write the command that measures the trough alone, with those given options that it takes."""
    from vibro.files.scene_files import read_scene_file
    from vibro.quantities import DRIVES

    own = read_scene_file(options.scene).scene if options.scene else {}
    drive = {"stroke", "frequency", "normal_acceleration", *DRIVES}
    given = {name: text for name, text in options.given.items() if name not in drive}
    if not {"trough_along", "trough_normal"} <= columns.keys():  # one sensor measures no drive angle
        line = {"drive_angle": f"{float(own['drive_angle'].values[0]):.15g}"} if "drive_angle" in own else {}
        given |= line | {name: text for name, text in options.given.items() if name == "drive_angle"}
    typed = [(f"--{name.replace('_', '-')}", text) for name, text in columns.items()]
    typed += [("--sensitivity", text) for text in sensitivity]
    words = [str(path) for path in (options.scene, data) if path]
    for option, text in typed:
        # Behind a blank, -60deg would be an option.
        words += [f"{option}={text}"] if text.startswith("-") else [option, text]
    for name, text in given.items():
        words += QUANTITIES[name].typed(text).split(" ", 1)
    words += ["--reverse"] if reverse else []
    return shlex.join(["vibro", "motion", *words, *(["--json"] if options.json else [])])


def _elliptical(options: Options) -> bool:
    """Whether the options, or the scene file, give an elliptical drive."""
    from vibro.files.scene_files import read_scene_file

    own = read_scene_file(options.scene).scene if options.scene else {}
    return not {*options.given, *own}.isdisjoint(ELLIPTICAL)


def _two_motions() -> InputError:
    return InputError(
        "the trough's measured motion replaces a line or an ellipse alone; the scene has another motion or a"
        " clamped part",
        hint="leave out --trough-along and --trough-normal, or that motion: harmonics are measured too",
    )


def _with_measured(
    trough: Trough, elliptical: bool, options: Options, argv: Sequence[str], console: Console
) -> tuple[MeasuredDrive, Request]:
    """Put what was measured of the trough in the place of what the scene file gives, and say so."""
    from dataclasses import replace

    from vibro.cli.compare_report import measured
    from vibro.cli.request import request_of
    from vibro.files.scene_files import read_scene_file
    from vibro.records.folding import Estimate
    from vibro.records.signals import doubt, rounded
    from vibro.records.tolerances import TOL
    from vibro.records.trough import spelled

    file = read_scene_file(options.scene) if options.scene else None
    beside = {*options.given, *(file.scene if file else ())} & {SCALE, "normal_acceleration"}
    if beside or (file and file.motion):
        raise _two_motions()
    on_an_ellipse = elliptical or trough.on_an_ellipse
    if on_an_ellipse:
        found = list(trough.drive_on_ellipse().quantities)
    else:
        found = ["amplitude", "frequency", *(["drive_angle"] if trough.drive_angle else [])]
    columns = " and ".join(shown(wave.header) for wave in trough.waves)
    problems = [
        f"{QUANTITIES[name].typed(cut(text))}: the {QUANTITIES[slot].label} is measured already"
        for name, text in options.given.items()
        if (slot := STANDS_FOR.get(name, name)) in found
    ]
    if on_an_ellipse:
        problems += [
            f"{QUANTITIES[name].typed(cut(text))}: the trough moves on an ellipse, which is measured"
            for name, text in options.given.items()
            if STANDS_FOR.get(name, name) in LINEAR
        ]
    if problems:
        raise InputError(*problems, hint="leave it out, or leave out --trough-along and --trough-normal")

    def request_with(values: Mapping[str, Estimate]) -> Request:
        texts = {name: spelled(*map(QUANTITIES[name].from_si, value)) for name, value in values.items()}
        given = {**options.given, **texts}
        return request_of(replace(options, given=given), argv, without_machine=_NO_MACHINE)

    # One acceleration alone gives the amplitude by the drive angle of the scene, which is read with any.
    given = request_with({name: Estimate(_HARMLESS[name], 0.0) for name in found})
    if on_an_ellipse:
        own_phase = (
            given.own.get("normal_phase", 0.0) if "normal_phase" in found else given.fixed["normal_phase"]
        )
        drive = trough.drive_on_ellipse(math.radians(own_phase) if elliptical else None)
    else:
        drive = trough.drive_on_line(scene_fields(given.fixed)["drive_angle"])
    for name, estimate in drive.quantities.items():
        own = given.own.get(name)
        instead = "" if own is None else f"; the scene gives {QUANTITIES[name].text(own)}"
        console.echo(f"{measured(name, estimate)} from column {columns}{instead}")
        if name in AMPLITUDES and own:
            ratio = QUANTITIES[name].from_si(estimate.value) / own
            if not 1.0 / TOL.far_off <= ratio <= TOL.far_off:
                texts = dict.fromkeys(wave.sensitivity for wave in trough.waves if wave.sensitivity)
                console.warn(
                    f"column {columns}: the {QUANTITIES[name].label} is about"
                    f" {rounded(float(ratio))} times the scene's: {doubt(' or '.join(texts))}"
                )
    return drive, request_with(drive.quantities)


def _measured_motion(
    record: Record, reverse: bool, elliptical: bool, drive: MeasuredDrive, request: Request, *, fits: bool
) -> MeasuredMotion | None:
    """Measure the trough's harmonics; None if the record does not determine them.

    An estimate of friction would take the effect of harmonics for its own. It is therefore refused where
    there may be some that are not known.
    """
    from vibro.errors import VibroError
    from vibro.records.waveforms import motion_of

    angle = None if len(record.trough) == 2 else scene_fields(request.fixed).get("drive_angle")
    one_of_an_ellipse = len(record.trough) == 1 and angle is None
    if one_of_an_ellipse:  # this sensor's own harmonics, as if its motion were the only one
        angle = 0.0 if drive.trough.normal is None else 0.5 * math.pi
    try:
        measured = motion_of(record, reverse=reverse, drive_angle=angle, down=elliptical)
    except VibroError as exc:  # the record may be too short for harmonics
        if not fits:
            return None
        unknown = f"the trough's harmonics, which an estimate would depend on, cannot be measured: {exc}"
        instead = "or leave out --trough-along and --trough-normal, and give the drive if it is a sine"
        raise InputError(unknown, hint=f"{getattr(exc, 'hint', '') or 'record longer'}; {instead}") from exc
    if not one_of_an_ellipse:
        return measured
    if fits and measured.order > 1:
        raise InputError(
            f"--fit needs both motions of the trough: it moves with {measured.order} harmonics, and one"
            " accelerometer measures one direction alone",
            hint="name --trough-along and --trough-normal",
        )
    return None


def _with_harmonics(
    measured: MeasuredMotion,
    drive: MeasuredDrive,
    request: Request,
    options: Options,
    argv: Sequence[str],
    console: Console,
    *,
    fits: bool,
) -> tuple[MeasuredDrive | HarmonicDrive, Request]:
    """Put the measured harmonics in the place of the fundamental alone, where they matter.

    They do if they change the computed speed. A fit depends on them wherever they stand out of the noise: the
    speed is that of the frictions where its search begins, and its intervals may be narrower than any change.
    """
    from dataclasses import replace

    from vibro.cli.request import request_of
    from vibro.quantities import DRIVES, HARMONIC
    from vibro.records.measured_speeds import change_by_harmonics
    from vibro.records.tolerances import TOL

    if measured.order == 1:
        return (_with_errors_of(measured, drive) if fits else drive), request
    said = f"the trough moves with {measured.order} harmonics"
    if fits:
        console.echo(f"{said}: they are part of the fit")
    else:
        rest = {name: x for name, x in request.fixed.items() if name not in (*DRIVES, "frequency")}
        change = change_by_harmonics(measured, scene_fields(rest))
        if abs(change) <= TOL.harmonics_matter:
            return drive, request
        if math.isnan(change):
            console.warn(
                f"{said}, but the motion of a part that hops on it is not known: the first is taken alone"
            )
            return drive, request
        by = f"by {100.0 * change:+.2g} %" if math.isfinite(change) else "from 0"
        console.echo(f"{said}, which change the computed speed {by}: they are taken")
    for text in measured.warnings[len(measured.trough.doubts(pure=False)) :]:
        console.warn(text)
    harmonics = measured.measured_drive()
    texts = dict.fromkeys((name for name in request.own if name in HARMONIC), "0")
    texts |= {
        name: repr(float(QUANTITIES[name].from_si(estimate.value)))
        for name, estimate in harmonics.quantities.items()
    }
    # The line that one sensor needs is part of the harmonics now.
    given = {name: text for name, text in options.given.items() if name not in LINEAR}
    return harmonics, request_of(
        replace(options, given={**given, **texts}), argv, without_machine=_NO_MACHINE
    )


def _with_errors_of(measured: MeasuredMotion, drive: MeasuredDrive) -> MeasuredDrive:
    """Give a drive of one harmonic the errors of the noise at its frequency.

    Its own are those of noise with the correlation of neighbouring samples at all frequencies. Intervals
    that the drive widens would hold too much.
    """
    from vibro.records.folding import Estimate

    trough = measured.trough
    is_line = "along_amplitude" not in drive.quantities and "normal_amplitude" not in drive.quantities
    better = trough.drive_on_line(measured.drive_angle) if is_line else trough.drive_on_ellipse()
    return drive._replace(
        quantities={
            name: Estimate(estimate.value, better.quantities.get(name, estimate).error)
            for name, estimate in drive.quantities.items()
        }
    )


def _fitted_names(text: str | None) -> list[str]:
    from vibro.quantities import find_quantity
    from vibro.records.fitting import FITTABLE

    if text is None:
        return []
    names: list[str] = []
    for part in text.split(","):
        quantity = find_quantity(part)
        if quantity is None or quantity.name not in FITTABLE or quantity.name in names:
            wrong = "is given twice" if quantity and quantity.name in names else "cannot be estimated"
            known = ", ".join(QUANTITIES[name].letter for name in FITTABLE)
            raise InputError(f"--fit {cut(text)}: {shown(part.strip())} {wrong}", hint=f"choose from {known}")
        names.append(quantity.name)
    return names
