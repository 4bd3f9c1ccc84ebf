"""``vibro measure``: what a trough does, and a part on it, by sensors, a video, CAD or a stopwatch."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Final

from vibro.cli.exit_codes import ExitCode
from vibro.cli.options import AllOption, Options, option, rare
from vibro.core.codes import Status
from vibro.errors import InputError, argument, cut, shown
from vibro.quantities import QUANTITIES, STANDS_FOR, scene_fields
from vibro.results.drawing import PICTURES

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from matplotlib.figure import Figure

    from vibro.answers.answer import Answer
    from vibro.axes import AxisSpec
    from vibro.cli.outputs import Outputs
    from vibro.records.measurement import Measurement
    from vibro.records.reading import Record
    from vibro.records.sensors import Mounting
    from vibro.records.trough import TroughDrive
    from vibro.sweeps.request import Request

#: Endings of what it can write.
FORMS: Final = ("csv", "json", "html", *PICTURES, "toml")
_FORMS_OF_SPEEDS: Final = ("csv", "json", "html")
_NO_MACHINE: Final = "a record is compared with the motion that the trough had"
_FRICTIONS: Final = ("static_friction", "kinetic_friction", "friction_ratio")
# In place of what a scene lacks while the rest of it is read: valid with any rest, in users' units.
_ANY_DRIVE: Final = {"amplitude": "1", "drive_angle": "0", "frequency": "1"}
_ANY_FRICTION: Final = {"static_friction": "1", "kinetic_friction": "1"}


def measure_command(
    options: Options,
    time: Annotated[str | None, rare("time", "Column of the time.", "HEADER")] = None,
    displacement: Annotated[
        str | None, option("displacement", "Column of a part's displacement on the trough.", "HEADER")
    ] = None,
    velocity: Annotated[str | None, option("velocity", "Column of its velocity.", "HEADER")] = None,
    acceleration: Annotated[str | None, rare("acceleration", "Column of its acceleration.", "HEADER")] = None,
    friction: Annotated[
        str | None, rare("friction", "Column of the friction force on it; needs --mass.", "HEADER")
    ] = None,
    trough_along: Annotated[
        str | None, option("trough-along", "Column of the trough's motion along itself, forwards.", "HEADER")
    ] = None,
    trough_normal: Annotated[
        str | None, option("trough-normal", "Column of that normal to it, upwards.", "HEADER")
    ] = None,
    trough_across: Annotated[
        str | None, rare("trough-across", "Column of the third axis of a sensor on the trough.", "HEADER")
    ] = None,
    turned: Annotated[
        str | None, rare("turned", "The sensor's axis along the trough points so far above it.", "DEG")
    ] = None,
    sensor: Annotated[
        str,
        rare("sensor", "Standard errors of the sensors, by their data sheets.", "tilt=0.2deg,gain=1%,..."),
    ] = "",
    sensitivity: Annotated[
        list[str] | None, option("sensitivity", "Of sensors in volts; of one velocity=125mm/s/V.", "100mV/g")
    ] = None,
    rate: Annotated[
        str | None, rare("rate", "Sampling rate of a record without a column of time.", "HZ")
    ] = None,
    start: Annotated[
        str | None, rare("from", "Beginning of the part that is taken, by its clock.", "S")
    ] = None,
    end: Annotated[str | None, rare("to", "End of this part.", "S")] = None,
    mass: Annotated[str | None, rare("mass", "Mass of the part [kg].", "X")] = None,
    reverse: Annotated[
        bool, option("reverse", "The data's axis points against the conveying direction.")
    ] = False,
    absolute: Annotated[
        bool, option("absolute", "The part's data are over the ground, as on video.")
    ] = False,
    fit: Annotated[str | None, option("fit", "Estimate these from the data of parts.", "mu_s,mu_d")] = None,
    every: AllOption = False,
) -> int:
    """Find what a trough does, and a part on it, from a record.

    Columns of a part are found by their units, a phone's on the trough by x, y and z. Name other sensors on
    it; -o DRIVE.toml writes its motion. From times or speeds, a row a setting, friction is fitted.
    """
    from vibro.answers.measurement import measurement_answer
    from vibro.cli.outputs import Outputs
    from vibro.cli.request import question, read_request
    from vibro.files.points import has_speeds
    from vibro.files.scene_files import read_scene_file
    from vibro.quantities import CLOCK, LOAD, MASS, checked_number
    from vibro.records.measurement import measure
    from vibro.records.reading import read_record, read_sensitivities
    from vibro.records.sensors import TURNED, Mounting, read_sensor_errors
    from vibro.records.steadiness import part_of

    console = options.console
    options, data = _scene_and_record(options)
    body = None if mass is None else checked_number(mass, MASS)
    given = {
        "time": time, "displacement": displacement, "velocity": velocity, "acceleration": acceleration,
        "friction": friction, "trough_along": trough_along, "trough_normal": trough_normal,
        "trough_across": trough_across,
    }  # fmt: skip
    columns = {name: text for name, text in given.items() if text is not None}
    if not columns and not sensitivity and rate is None and has_speeds(data):
        given_too = {
            "--mass": mass,
            "--reverse": reverse,
            "--absolute": absolute,
            "--from": start,
            "--to": end,
        }
        if which := next((name for name, value in given_too.items() if value), ""):
            raise InputError(f"{which}: {data} is a table of times or speeds", hint="leave the option out")
        return _measure_speeds(options, data, _fitted_names(fit), every=every)
    record = read_record(data, columns, read_sensitivities(sensitivity or ()), rate=rate)
    record = part_of(record, *(None if x is None else checked_number(x, CLOCK) for x in (start, end)))
    console.echo_all(record.notes)
    angle = None if turned is None else math.radians(checked_number(turned, TURNED))
    mounting = Mounting(read_sensor_errors(sensor), angle)
    if not record.trough and (turned or (sensor and fit is None and math.isinf(mounting.errors.lowpass))):
        which = "--turned" if turned else "--sensor"
        raise InputError(f"{which}: the record holds no motion of the trough", hint="name --trough-along")
    scene = read_scene_file(options.scene).scene if options.scene else {}
    has_friction = not {*options.given, *scene}.isdisjoint(_FRICTIONS)
    compares = _compares(record, options, body, columns, has_friction=has_friction, fits=fit is not None)
    tables, pictures = (("", "summary"), ("",)) if compares else (("",), ())
    outputs = Outputs(
        options, f"{data.stem}-measured", forms=FORMS, tables=tables, pictures=pictures, reads=[data]
    )
    with outputs:
        trough, found = None, set[str]()
        if record.trough:
            rest = {} if has_friction or compares else _ANY_FRICTION
            trough, request = _measured_trough(
                record, options, scene, rest, mounting, reverse=reverse, compares=compares,
                fits=fit is not None,
            )  # fmt: skip
            request = replace(request, specs={n: s for n, s in request.specs.items() if n not in rest})
            found = {*trough.drive.quantities, LOAD.name}
            console.echo_all(trough.notes)
        else:
            request = read_request(options, without_machine=_NO_MACHINE)
        question(request, console, found)
        with console.progress("fitting" if fit else "comparing", None) as bar:
            m = measure(
                record, trough, _others(request), request.scene() if compares else None, _fitted_names(fit),
                mass=body, reverse=reverse, absolute=absolute, errors=mounting.errors,
                progress=lambda done, total, what: bar(done, what, total),
            )  # fmt: skip
        for warning in m.warnings:
            console.warn(warning)
        answer = measurement_answer(m, data, request)
        _write(outputs, answer, m, data, request)
    outputs.print_answer(answer, every=every)
    is_open = m.speeds is not None and m.speeds.status is Status.UNRESOLVED
    return ExitCode.UNRESOLVED if is_open else ExitCode.DONE


def _measure_speeds(options: Options, data: Path, names: list[str], *, every: bool) -> int:
    """Fit friction and restitution to times or speeds over settings."""
    from vibro.answers.speeds import speed_tables, speeds_answer
    from vibro.cli.outputs import Outputs
    from vibro.cli.request import inputs_of, question
    from vibro.files.points import read_speeds
    from vibro.quantities import LOAD
    from vibro.records.speeds import fit_question, speed_question

    console, table = options.console, read_speeds(data)
    asked = speed_question(table, inputs_of(options), names)
    with Outputs(options, f"{data.stem}-fitted", forms=_FORMS_OF_SPEEDS, reads=[data]) as outputs:
        question(asked.request, console, {LOAD.name, "static_friction", "kinetic_friction"})
        with console.progress("fitting", None) as bar:
            found = fit_question(asked, lambda done, total, what: bar(done, what, total))
        answer = speeds_answer(found, asked)
        outputs.write_answer(answer, lambda: speed_tables(found))
    outputs.print_answer(answer, every=every)
    return ExitCode.NOT_MET if len(found.left_out) == len(table.rows) else ExitCode.DONE


def _write(outputs: Outputs, answer: Answer, m: Measurement, data: Path, request: Request) -> None:
    """Write the files of an answer."""
    from vibro.answers.measurement import scene_file, tables_of

    def draw() -> dict[str, Figure]:
        from vibro.answers.drawing import comparison_picture

        if not m.comparison:
            return {}
        return {"": comparison_picture(m.comparison, answer.title, request.given_values, m.fitted)}

    texts = {"toml": lambda _: scene_file(m, data, request)}
    shows = {"": "The part's signals, measured and computed"}
    outputs.write_answer(answer, lambda: tables_of(m), draw, shows, texts=texts)


def _compares(
    record: Record,
    options: Options,
    mass: float | None,
    columns: Mapping[str, str],
    *,
    has_friction: bool,
    fits: bool,
) -> bool:
    """Return whether a part is compared with its exact motion; refuse what the record cannot answer."""
    console = options.console
    if "friction" in record.signals and mass is None:
        if "friction" in columns:
            raise InputError("a force needs the mass of the body", hint="give its mass, such as 20g")
        header = shown(record.headers["friction"])
        console.warn(f"column {header} is left out: a force needs the mass of the part")
    has_part = bool({*record.signals} - ({"friction"} if mass is None else set()))
    if fits and not has_part:
        lacks = "--fit: the record holds no signal of a part"
        raise InputError(lacks, hint=f"name one: {argument('displacement', 'X [mm]')}")
    if not record.trough and any(text.casefold().endswith(".toml") for text in options.output or ()):
        lacks = "the record holds no motion of the trough for a scene file"
        raise InputError(lacks, hint="name --trough-along or --trough-normal, or leave NAME.toml out")
    compares = not record.trough or (has_part and (has_friction or fits))
    if has_part and not compares:
        console.echo("the part is not compared with the exact motion: that needs its friction, mu_s and mu_d")
    return compares


def _scene_and_record(options: Options) -> tuple[Options, Path]:
    """Tell scene file and record apart: the scene may be given by options alone."""
    scenes = [path for path in options.files if path.suffix.casefold() == ".toml"]
    others = [path for path in options.files if path not in scenes]
    if len(others) != 1:
        raise InputError(
            f"{len(others)} records of {len(options.files)} files: one is wanted, RECORD.csv",
            hint="for example: vibro measure scene.toml record.csv",
        )
    return options.of(*scenes), others[0]


def _measured_trough(
    record: Record,
    options: Options,
    scene: Mapping[str, AxisSpec],
    rest: Mapping[str, str],
    mounting: Mounting,
    *,
    reverse: bool,
    compares: bool,
    fits: bool,
) -> tuple[TroughDrive, Request]:
    """Measure the trough, and put its motion in the place of the drive that the scene gives.

    ``scene`` is the scene file's; ``rest`` stands for what neither that nor the options give.
    """
    from vibro.cli.request import read_request
    from vibro.quantities import checked_number
    from vibro.records.trough import MEASURED, trough_drive

    if "normal_acceleration" in {*options.given, *scene}:
        raise InputError(
            "a clamped part is not computed on a measured motion",
            hint="leave its normal force out, and give it to vibro solve beside the scene file of -o",
        )
    typed = {name: text for name, text in options.given.items() if STANDS_FOR.get(name, name) in MEASURED}
    kept = {name: text for name, text in options.given.items() if name not in typed}

    def with_drive(drive: Mapping[str, str], measured: set[str]) -> Request:
        filled = replace(options, given={**kept, **rest, **drive})
        return read_request(filled, without_machine=_NO_MACHINE, measured=measured)

    others = _others(with_drive(_ANY_DRIVE, {*MEASURED}))
    own = {name: spec.values[0] for name, spec in scene.items() if spec.quantity.name in MEASURED}
    own |= {name: checked_number(text, QUANTITIES[name]) for name, text in typed.items()}
    found = trough_drive(
        record,
        {name: float(QUANTITIES[name].to_si(value)) for name, value in own.items()},
        others if compares else None,
        mounting=mounting._replace(trough_angle=others["trough_angle"]),
        reverse=reverse,
        fits=fits,
    )
    problems = [
        f"{QUANTITIES[name].typed(cut(text))}: the {QUANTITIES[name].label} is measured already"
        for name, text in typed.items()
        if STANDS_FOR.get(name, name) not in {*found.needed, "frequency"}
    ]
    if problems:
        raise InputError(*problems, hint="leave it out, or the columns of the trough")
    needed = found.needed if found.drive is found.first else set()
    given = {name: text for name, text in typed.items() if name in needed}
    return found, with_drive({**given, **found.texts}, {*MEASURED} - needed)


def _others(request: Request) -> dict[str, float]:
    """Return the fields of a scene besides its drive [SI]."""
    from vibro.records.trough import MEASURED

    fields: dict[str, float] = scene_fields({n: x for n, x in request.fixed.items() if n not in MEASURED})
    return fields


def _fitted_names(text: str | None) -> list[str]:
    """Return the names of quantities that are given by letters; what is none is named as it is."""
    from vibro.quantities import find_quantity

    parts = text.split(",") if text is not None else []
    return [quantity.name if (quantity := find_quantity(part)) else part.strip() for part in parts]
