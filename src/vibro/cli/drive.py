"""``vibro drive``: the set-up sheet of a machine, and its fit to measured amplitudes."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

from vibro.cli.exit_codes import ExitCode
from vibro.cli.options import AllOption, Options, option, rare, typed_names
from vibro.cli.outputs import Outputs
from vibro.core.codes import Status
from vibro.errors import InputError, cut, shown
from vibro.quantities import QUANTITIES, kinetic_friction

if TYPE_CHECKING:
    from collections.abc import Mapping

    from matplotlib.figure import Figure

    from vibro.answers.set_up_sheet import SheetRequest
    from vibro.files.machines import GivenMachine
    from vibro.files.scene_files import SceneFile

_SETTINGS: Final = (25.0, 50.0, 75.0, 100.0)  # [%] of the machine's own
_MOST_SETTINGS: Final = 12
_BANDS: Final = ("voltage", "filling", "static_friction", "kinetic_friction")
_SHOWS: Final = "Amplitude and speed over the frequency of the drive"


def drive_command(
    options: Options,
    fit: Annotated[
        Path | None,
        option(
            "fit",
            "Fit natural frequency and damping to measured amplitudes: columns frequency_hz and amplitude_mm"
            " or stroke_mm.",
            "POINTS.csv",
        ),
    ] = None,
    every: AllOption = False,
    law: Annotated[
        str | None,
        rare(
            "law",
            "With --fit and without a file: the force is constant for magnets, and grows with the square of"
            " the frequency with unbalance on the trough.",
            "constant|square",
        ),
    ] = None,
    amplitude_error: Annotated[
        str | None,
        rare(
            "amplitude-error",
            "With --fit: relative standard error of an amplitude [%]; else the residuals of 5 or more points"
            " give it.",
            "X",
        ),
    ] = None,
) -> int:
    """Print a machine's set-up sheet: amplitude and speed at each setting, empty and full.

    Settings may be a list, setting=25,50,100; voltage=90:110, filling=0:2 and
    frictions may be bands, for which speeds are bounded. Several files are put side by side.
    """
    if fit is not None:
        return _fit(fit, options, law, amplitude_error)
    for typed in typed_names(law=law, amplitude_error=amplitude_error):
        raise InputError(f"{typed} belongs to --fit", hint="add --fit POINTS.csv, or leave it out")
    return _sheets(options, every=every)


def _machine_file(path: Path) -> SceneFile:
    """Read a scene file, which must have a machine."""
    from vibro.files.scene_files import read_scene_file

    file = read_scene_file(path)
    if file.machine is None:
        hint = "add [machine] with kind, masses, natural_hz and damping_ratio; see docs/guide/machines.md"
        raise InputError(f"{path}: there is no table [machine]", hint=hint)
    return file


def _sheets(options: Options, *, every: bool) -> int:
    """Print the set-up sheet of a machine, or those of several side by side, and write their files."""
    from vibro.answers.machine import cases, picture_texts, sheet_answer, sheets_answer
    from vibro.answers.set_up_sheet import make_sheet

    if not options.files:
        hint = "vibro drive feeder.toml; or vibro drive --fit POINTS.csv fits a machine to amplitudes"
        raise InputError("a scene file with a machine is missing", hint=hint)
    requests = {
        name: _request(path, options) for name, path in zip(options.names, options.files, strict=True)
    }
    one = len(requests) == 1
    settings = options.given.get("setting", "")
    if not one and any(mark in settings for mark in ",:"):
        raise InputError(
            f"setting={cut(settings)}: several machines are compared at one setting",
            hint="give one value, such as setting=50",
        )
    pictures = {name: "response" if one else f"response-{i}" for i, name in enumerate(requests, 1)}
    with Outputs(options, f"{options.files[0].stem}-drive", pictures=[*pictures.values()]) as outputs:
        is_drawn = bool(outputs.pictures or outputs.texts)
        sheets = {}
        for name, request in requests.items():
            with options.console.progress("bounding speeds", len(request.settings)) as bar:
                sheets[name] = make_sheet(request, picture=is_drawn, progress=bar)
        answer = sheet_answer(next(iter(sheets)), *sheets.values()) if one else sheets_answer(sheets)

        def draw() -> dict[str, Figure]:
            from vibro.plots.responses import drive_figure

            return {
                pictures[name]: drive_figure(sheet.picture, *picture_texts(sheet, name))
                for name, sheet in sheets.items()
                if sheet.picture is not None
            }

        shows = {key: _SHOWS if one else f"{_SHOWS}: {name}" for name, key in pictures.items()}
        outputs.write_answer(answer, lambda: {"": cases(sheets)}, draw, shows)
    outputs.print_answer(answer, every=every)
    rows = [pair[state] for sheet in sheets.values() for pair in sheet.record["settings"] for state in pair]
    unresolved = any(row and row["status"] == Status.UNRESOLVED.label for row in rows)
    return ExitCode.UNRESOLVED if unresolved else ExitCode.DONE


def _request(path: Path, options: Options) -> SheetRequest:
    """Read what a sheet is made of."""
    from vibro.answers.set_up_sheet import SheetRequest
    from vibro.cli.request import request_of

    file = _machine_file(path)
    assert file.machine is not None
    typed = dict(options.given)
    own = {name: spec.value for name, spec in file.scene.items() if not spec.varies}
    bands, settings = _bands(typed, file.machine, own), _settings(typed, file.machine)
    values = request_of(options.of(path, given=typed)).fixed
    if doubt := file.machine.doubt(max(bands.get("filling", (0.0,)))):
        options.console.warn(doubt)
    if "friction_ratio" in values:
        ratio = values.pop("friction_ratio")
        if "static_friction" in bands:
            raise InputError(
                "--mu-ratio beside a band of static friction leaves the band of kinetic friction open",
                hint="give --mu-d lo:hi instead",
            )
        values.setdefault("kinetic_friction", float(kinetic_friction(ratio, values["static_friction"])))
    values["filling"] = 0.0
    return SheetRequest(file.machine, values, settings, bands)


def _settings(typed: dict[str, str], given: GivenMachine) -> tuple[float, ...]:
    """Return the settings of the sheet, ascending, and keep the largest among the typed values."""
    import numpy as np

    from vibro.axes import parse_axis

    if "setting" in typed:
        text = typed["setting"]
        axis = parse_axis(text, QUANTITIES["setting"]).axis(len(_SETTINGS))
        settings = np.unique(axis.values).tolist()
        if len(settings) > _MOST_SETTINGS:
            hint = "setting=25,50,75,100, or setting=25:100:4"
            raise InputError(f"setting={cut(text)}: at most {_MOST_SETTINGS} settings", hint=hint)
        typed["setting"] = f"{settings[-1]:.15g}"
        return tuple(settings)
    if not given.takes("setting"):
        return (100.0,)
    if "setting" in given.bands:
        return tuple(np.linspace(*given.bands["setting"], len(_SETTINGS)).tolist())
    return tuple(given.own.get("setting", 100.0) * share / 100.0 for share in _SETTINGS)


def _bands(
    typed: dict[str, str], given: GivenMachine, own: Mapping[str, float]
) -> dict[str, tuple[float, float]]:
    """Return the bands in users' units, and leave nominal values in what was typed."""
    from vibro.files.entries import FORMS, ends_of

    bands = {name: band for name, band in given.bands.items() if name in _BANDS}
    if filling := given.own.get("filling"):
        bands["filling"] = filling, filling
    for name in _BANDS:
        if name not in typed:
            continue
        quantity, text = QUANTITIES[name], typed[name]
        if ":" not in text and name != "filling":
            bands.pop(name, None)
            continue
        try:
            FORMS["band"].read(quantity, text)  # which checks it
            ends = ends_of(quantity, text)
        except ValueError:
            raise InputError(f"{quantity.typed(cut(text))}: must be a value or lo:hi") from None
        low, high = bands[name] = ends[0], ends[-1]
        nominal = own.get(name, quantity.default)
        if nominal is None or not low <= nominal <= high:
            nominal = 0.5 * (low + high)
        typed[name] = f"{0.0 if name == 'filling' else nominal:.17g}"
    return {name: bands[name] for name in _BANDS if name in bands}


def _fit(path: Path, options: Options, law: str | None, amplitude_error: str | None) -> int:
    """Fit a machine to points, print the estimates and a table ``[machine]``, and write files."""
    from vibro.answers.response import columns, draw_fit, fit_answer, fit_points

    if law not in (None, "constant", "square"):
        raise InputError(
            f"--law {shown(law)}: must be constant or square", hint="constant is that of magnets"
        )
    unused = [QUANTITIES[name].options[0] for name in options.given] + ["--pack"] * (options.pack is not None)
    if unused:
        raise InputError(f"{', '.join(unused)}: not used by --fit", hint="leave it out, or leave out --fit")
    if len(options.files) > 1:
        raise InputError("--fit takes one file", hint="leave the others out")
    given = _machine_file(options.files[0]).machine if options.files else None
    with Outputs(options, f"{path.stem}-fit", pictures=("response",), reads=[path]) as outputs:
        fit = fit_points(path, given, law, amplitude_error)
        answer = fit_answer(fit, path, given)
        outputs.write_answer(
            answer,
            lambda: {"": columns(fit)},
            lambda: {"response": draw_fit(fit, path)},
            {"response": "Measured and fitted amplitude over frequency"},
        )
    outputs.print_answer(answer, every=True)
    return ExitCode.DONE if fit.brackets_peak else ExitCode.UNRESOLVED
