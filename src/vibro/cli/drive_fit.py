"""``vibro drive --fit``: natural frequency, damping and force of a machine from measured amplitudes."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.answers.answer import aligned
from vibro.cli.compare_report import uncertain
from vibro.cli.exit_codes import ExitCode
from vibro.cli.outputs import Outputs
from vibro.errors import InputError, SceneError, printable
from vibro.quantities import LENGTH, PERCENT, Quantity, Range, checked_number

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from vibro.cli.console import Console
    from vibro.cli.options import Options
    from vibro.files.machines import GivenMachine
    from vibro.machines.fitting import ResponseFit

__all__ = ["fit_points"]

#: Laws of the amplitudes' static limit, by the kind of machine: the force of an exciter mass grows with the
#: square of frequency, but its share of the springs' force does not.
_LAWS: Final = {"magnet": "constant", "exciter": "constant", "rod": "constant", "unbalance": "square"}
_OF_LAW: Final = {
    "constant": "force does not depend on frequency (magnet, exciter mass, rod)",
    "square": "force grows with the square of frequency (unbalance on the trough)",
}
_STATIC: Final = {"constant": "static amplitude", "square": "amplitude far above"}
_ERROR: Final = Quantity("amplitude_error", PERCENT, allowed=Range(0.0, 100.0, with_low=False))
_CURVE_POINTS: Final = 801
_CURVE_BEYOND: Final = 0.15  # of the points' span, on either side
_BOTH_SIDES: Final = (
    "no estimate: the largest amplitude is at an end of the points, so that the\n"
    "resonance may lie beyond them"
)
_APART: Final = 0.05  # [1] of amplitudes of the points and of the file's machine that is reported


def fit_points(
    path: Path,
    given: GivenMachine | None,
    *,
    law: str | None,
    amplitude_error: str | None,
    options: Options,
    argv: Sequence[str],
    console: Console,
) -> int:
    """Fit points, print the estimates and a table ``[machine]``, and write files where they are wanted.

    Parameters
    ----------
    path : Path
        The points.
    given : GivenMachine or None
        The machine of the scene file, whose masses the new table has.
    law, amplitude_error : str or None
        As typed.
    options, argv, console
        Shared options of commands that write files.

    Returns
    -------
    int
        The exit code: 3 without an estimate.

    Raises
    ------
    InputError, FileError
        If the points or options are wrong, or files cannot be written.
    """
    from vibro.files.points import read_points
    from vibro.machines.fitting import LEAST_POINTS, POINTS_FOR_ERROR, fit_response
    from vibro.tables.record import json_text

    law = _law(law, given)
    stated = None
    if amplitude_error is not None:
        stated = float(_ERROR.kind.to_si(checked_number(amplitude_error, _ERROR)))
    with Outputs(
        options, f"{path.stem}-fit", argv, console, pictures=("response",), reads=(path, options.scene)
    ) as output:
        points = read_points(path)
        if (count := np.unique(points.frequency).size) < LEAST_POINTS:
            raise InputError(
                f"{path}: {count} different frequencies: a fit needs {LEAST_POINTS} or more",
                hint="measure on both sides of the resonance",
            )
        if stated is not None and points.error is not None:
            raise InputError(
                f"--amplitude-error {amplitude_error}: {path} has a column of errors",
                hint="leave one of them out",
            )
        error = points.error if stated is None else stated
        try:
            fit = fit_response(points.pairs, law=law, amplitude_error=error)  # type: ignore[arg-type]
        except SceneError as exc:
            raise InputError(*(f"{path}: {problem}" for problem in exc.problems)) from None
        if math.isnan(fit.amplitude_error[0]):
            console.warn(
                f"no errors and intervals: the error of an amplitude is unknown, and {fit.frequency.size}"
                f" points are fewer than the {POINTS_FOR_ERROR} whose residuals tell it; state it, such as"
                " --amplitude-error 2%"
            )
        table = _machine_table(fit, given, path)
        if doubt := _doubt(fit, table):
            console.warn(doubt)
        content = _content(fit, path, table)
        output.write(lambda: {"": _columns(fit)}, lambda: {"response": _figure(fit, path)}, content)
    if output.takes_stdout:
        pass
    elif options.json:
        print(json_text(content))
    else:
        print(_report(fit, path, table))
    return ExitCode.DONE if fit.brackets_peak else ExitCode.UNRESOLVED


def _law(law: str | None, given: GivenMachine | None) -> str:
    """Return the law of the force: as given, else that of the machine."""
    if given is None:
        if law is None:
            hint = "--law constant for a magnet, --law square for unbalance on the trough"
            raise InputError("--fit needs to know how the force depends on frequency", hint=hint)
        return law
    if given.kind == "crank":
        raise InputError(
            "--fit: the amplitude of a crank does not depend on frequency", hint="measure it once"
        )
    own = given.table["law"] if given.kind == "measured" else _LAWS[given.kind]
    if law is not None and law != own:
        raise InputError(
            f"--law {law}: a machine of kind {given.kind} in the file has the law {own}",
            hint="leave --law out, or correct the file",
        )
    return str(own)


def _report(fit: ResponseFit, path: Path, table: Mapping[str, Any] | None) -> str:
    count = f"{fit.frequency.size} points, {fit.frequency[0]:g} to {fit.frequency[-1]:g} Hz"
    sizes = np.unique(fit.amplitude_error)
    told = "unknown"
    if sizes.size > 1:
        told = f"{100.0 * sizes[0]:.2g} to {100.0 * sizes[-1]:.2g} %, as stated"
    elif not math.isnan(sizes[0]):
        told = f"{100.0 * sizes[0]:.2g} %, {'as stated' if fit.is_error_stated else 'from the residuals'}"
    facts = [
        ("points", f"{printable(str(path))}: {count}"),
        ("law", _OF_LAW[fit.law]),
        ("amplitude error", told),
    ]
    rows = [("", "estimate", "95 % interval")]
    rows += [
        (f"{label} [{unit}]" if unit else label, _estimate(value, error), _interval(low, high))
        for label, unit, value, error, (low, high) in _estimates(fit)
    ]
    parts = [aligned(facts, right=False), aligned(rows)]
    if not fit.brackets_peak:
        end = "higher" if fit.amplitude[-1] >= fit.amplitude[0] else "lower"
        parts.append(
            f"{_BOTH_SIDES}.\nMeasure at {end} frequencies too, until the amplitude has fallen again."
        )
    elif math.isnan(fit.damping_ratio):
        parts.append(
            "no damping ratio: its square comes out negative, as errors are larger than the damping.\n"
            "Measure closer to the peak, or let the empty machine ring down."
        )
    head = ("frequency [Hz]", "measured [mm]", "fitted [mm]", "difference [%]")
    fitted = fit.amplitudes(fit.frequency)
    parts.append(
        aligned(
            [
                head,
                *(
                    (f"{f:g}", f"{1e3 * a:.4g}", f"{1e3 * b:.4g}", f"{100.0 * r:+z.1f}")
                    for f, a, b, r in zip(fit.frequency, fit.amplitude, fitted, fit.residual, strict=True)
                ),
            ]
        )
    )
    if table is not None:
        parts.append(_toml(table))
    return "\n\n".join(parts)


def _estimates(fit: ResponseFit) -> list[tuple[str, str, float, float, tuple[float, float]]]:
    low, high = (float(LENGTH.from_si(end)) for end in fit.static_amplitude_interval)
    static, error = (float(LENGTH.from_si(x)) for x in (fit.static_amplitude, fit.static_amplitude_sd))
    return [
        (
            "natural frequency",
            "Hz",
            fit.natural_frequency,
            fit.natural_frequency_sd,
            fit.natural_frequency_interval,
        ),
        ("damping ratio", "", fit.damping_ratio, fit.damping_ratio_sd, fit.damping_ratio_interval),
        (_STATIC[fit.law], "mm", static, error, (low, high)),
    ]


def _estimate(value: float, error: float) -> str:
    return "-" if math.isnan(value) else uncertain(value, error)


def _interval(low: float, high: float) -> str:
    if math.isnan(low):
        return "unknown"
    if low == 0.0 and math.isinf(high):
        return "not bounded"
    if math.isinf(high):
        return f"above {low:.4g}"
    if low == 0.0:
        return f"below {high:.4g}"
    digits = max(0, 1 - math.floor(math.log10(0.5 * (high - low)))) if high > low else 6
    return f"{low:.{digits}f} ... {high:.{digits}f}"


def _rounded(value: float, error: float) -> float:
    """Round a value to a hundredth of its error, so that the table has no meaningless digits."""
    if not (math.isfinite(error) and error > 0.0):
        return float(f"{value:.6g}")
    return round(value, max(0, 2 - math.floor(math.log10(error))))


def _machine_table(fit: ResponseFit, given: GivenMachine | None, path: Path) -> dict[str, Any] | None:
    """Return the table ``[machine]`` with what was fitted; None without an estimate.

    The force stays that of the file: nobody said at which setting the points were measured.
    """
    if math.isnan(fit.natural_frequency) or (given is not None and math.isnan(fit.damping_ratio)):
        return None
    if given is None:
        return {"kind": "measured", "points": str(path), "law": fit.law}
    if given.kind == "measured":
        pairs = zip(fit.frequency.tolist(), (1e3 * fit.amplitude).tolist(), strict=True)
        return {**given.table, "points": [[f, float(f"{a:.6g}")] for f, a in pairs]}
    natural = "mount_hz" if given.kind == "unbalance" else "natural_hz"
    found = _rounded(fit.natural_frequency, fit.natural_frequency_sd)
    table = {
        **given.table,
        natural: found,
        "damping_ratio": _rounded(fit.damping_ratio, fit.damping_ratio_sd),
    }
    fitted = given.own.get("natural")  # the springs that were measured, which may be one of the packs
    if "pack" in table:
        packs = table["pack"] if isinstance(table["pack"], list) else [table["pack"]]
        table["pack"] = [{**p, natural: found} if given.packs[p["name"]] == fitted else p for p in packs]
    return table


def _doubt(fit: ResponseFit, table: Mapping[str, Any] | None) -> str:
    """Say at which setting the points were measured, if the machine's force is right; empty near 100 %."""
    from vibro.files.machines import machine_of

    if table is None or table["kind"] == "measured":
        return ""
    at = float(fit.frequency[np.argmin(fit.amplitude)])
    ratio = float(fit.amplitudes(at) / machine_of(table).machine.response(at).amplitude)
    if abs(ratio - 1.0) <= _APART:
        return ""
    return (
        f"the points have {ratio:.3g} times the amplitude of this machine at a setting of 100 %: they were"
        f" measured at {100.0 * ratio:.3g} %, or the force or the moment of the file is another; it stays as"
        " given"
    )


def _toml(table: Mapping[str, Any]) -> str:
    """Write a table of a scene file, to be pasted."""
    import tomlkit

    written = tomlkit.item(dict(table))
    written.comment("with the fitted values")
    if table["kind"] == "measured" and "trough_mass_kg" not in table:
        written.add(tomlkit.comment("add trough_mass_kg = ..., that of the trough and what moves with it"))
    return tomlkit.dumps({"machine": written}).rstrip()


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _content(fit: ResponseFit, path: Path, table: Mapping[str, Any] | None) -> dict[str, Any]:
    """Return the content of the JSON; null without an estimate, or for an unbounded end."""
    content: dict[str, Any] = {
        "points": str(path),
        "law": fit.law,
        "brackets_resonance": fit.brackets_peak,
        "amplitude_error_is": "stated" if fit.is_error_stated else "from residuals",
    }
    names = ("natural_frequency_hz", "damping_ratio", "static_amplitude_mm")
    for name, (_, _, value, error, interval) in zip(names, _estimates(fit), strict=True):
        content[name] = {
            "estimate": _number(value),
            "standard_error": _number(error),
            "interval": [_number(end) for end in interval],
        }
    content["damping_squared"] = _number(fit.damping_squared)
    content["table"] = {name: [_number(x) for x in column] for name, column in _columns(fit).items()}
    content["machine"] = dict(table) if table is not None else None
    return content


def _columns(fit: ResponseFit) -> dict[str, Any]:
    return {
        "frequency_hz": fit.frequency,
        "amplitude_mm": np.asarray(LENGTH.from_si(fit.amplitude)),
        "fitted_amplitude_mm": np.asarray(LENGTH.from_si(fit.amplitudes(fit.frequency))),
        "difference_percent": np.asarray(PERCENT.from_si(fit.residual)),
        "error_percent": np.asarray(PERCENT.from_si(fit.amplitude_error)),
    }


def _figure(fit: ResponseFit, path: Path) -> Any:
    from vibro.plots.responses import FitPicture, fit_figure

    low, high = float(fit.frequency[0]), float(fit.frequency[-1])
    beyond, ends = _CURVE_BEYOND * (high - low), fit.natural_frequency_interval
    # Let the interval be seen, unless it is so wide that the points would be squeezed.
    low = min(low, max(ends[0], 2.0 * low - high))
    high = max(high, min(ends[1], 2.0 * high - low))
    x = np.linspace(max(low - beyond, 0.5 * low), high + beyond, _CURVE_POINTS)
    parts = [
        f"{label} {_estimate(value, error)}{f' {unit}' if unit else ''}"
        for label, unit, value, error, _ in _estimates(fit)
        if not math.isnan(value)
    ]
    picture = FitPicture(
        fit.frequency,
        1e3 * fit.amplitude,
        1e3 * fit.amplitude * fit.amplitude_error,
        x,
        1e3 * fit.amplitudes(x),
        fit.natural_frequency,
        fit.natural_frequency_interval,
    )
    title = f"measured amplitudes – {path.name}"
    return fit_figure(picture, title, ", ".join(parts) or "no estimate: points on one side of the resonance")
