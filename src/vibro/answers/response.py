"""The answer about measured amplitudes: natural frequency, damping and force of a machine that is fitted."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.answers.answer import Answer, Fact, Table, shown
from vibro.errors import InputError, SceneError
from vibro.files.machines import machine_of
from vibro.files.points import AMPLITUDE_ERROR, read_points
from vibro.machines.fitting import LEAST_POINTS, POINTS_FOR_ERROR, fit_response
from vibro.quantities import checked_number
from vibro.units import FREQUENCY, LENGTH, PERCENT, PURE

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from matplotlib.figure import Figure

    from vibro.files.machines import GivenMachine
    from vibro.machines.fitting import ResponseFit

_OF_LAW: Final = {
    "constant": "the force is constant",
    "square": "the force grows with the square of frequency",
}
_ESTIMATES: Final = {"natural_frequency": FREQUENCY, "damping_ratio": PURE, "static_amplitude": LENGTH}
_CURVE_POINTS: Final = 801
_CURVE_BEYOND: Final = 0.15  # of the points' span, on either side
_APART: Final = 0.05  # [1] of amplitudes of the points and of the file's machine that is reported


def fit_points(
    path: Path, given: GivenMachine | None, law: str | None, amplitude_error: str | None
) -> ResponseFit:
    """Fit a machine to the points of a file.

    Parameters
    ----------
    path : Path
        The points.
    given : GivenMachine or None
        The machine of the scene file, which has a law of its own.
    law, amplitude_error : str or None
        As typed.

    Raises
    ------
    InputError, FileError
        If the points or options are wrong, or files cannot be read.
    """
    law = _law(law, given)
    stated = None if amplitude_error is None else checked_number(amplitude_error, AMPLITUDE_ERROR)
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
    error = points.error if stated is None else PERCENT.to_si(stated)
    try:
        return fit_response(points.pairs, law=law, amplitude_error=error)  # type: ignore[arg-type]
    except SceneError as exc:
        raise InputError(*(f"{path}: {problem}" for problem in exc.problems)) from None


def _law(law: str | None, given: GivenMachine | None) -> str:
    """Return the law of the force: as typed, else that of the machine."""
    if given is None:
        if law is None:
            hint = "--law constant for a magnet, --law square for unbalance on the trough"
            raise InputError("--fit needs to know how the force depends on frequency", hint=hint)
        return law
    if given.kind == "crank":
        raise InputError(
            "--fit: the amplitude of a crank does not depend on frequency", hint="measure it once"
        )
    # that of an exciter mass grows too, but its share of the springs' force does not
    own = given.table.get("law", "square" if given.kind == "unbalance" else "constant")
    if law is not None and law != own:
        raise InputError(
            f"--law {law}: a machine of kind {given.kind} in the file has the law {own}",
            hint="leave --law out, or correct the file",
        )
    return str(own)


def fit_answer(fit: ResponseFit, path: Path, given: GivenMachine | None) -> Answer:
    """Make the answer of a fit.

    Parameters
    ----------
    fit : ResponseFit
        Its numbers.
    path : Path
        The points.
    given : GivenMachine or None
        The machine of the scene file, whose masses the new table has.
    """
    errors = np.asarray(PERCENT.from_si(fit.amplitude_error))
    between = " to ".join(dict.fromkeys(f"{error:.2g}" for error in (errors.min(), errors.max())))
    whose = "as stated" if fit.is_error_stated else "from the residuals"
    span = f"{fit.frequency.size}, {fit.frequency[0]:g} to {fit.frequency[-1]:g} Hz"
    estimates = _estimates(fit)
    facts = [
        Fact("points", span, note=str(path)),
        Fact("law", _OF_LAW[fit.law]),
        Fact("amplitude error", None if np.isnan(errors).any() else f"{between} %, {whose}"),
        *(
            fact._replace(note="" if math.isnan(low) else f"95 %: {shown(low)} to {shown(high)}")
            for fact, (low, high) in estimates.values()
        ),
    ]
    pairs = {name: column.tolist() for name, column in columns(fit).items()}
    heads = [("frequency", "Hz"), ("measured", "mm"), ("fitted", "mm"), ("difference", "%")]
    rows = [*zip(*pairs.values(), strict=True)]
    points = Table("table", heads, [(*row[:3], round(row[3], 2)) for row in rows], "Points")
    table = _machine_table(fit, given, path)
    record = {
        "points": str(path),
        "law": fit.law,
        "brackets_resonance": fit.brackets_peak,
        "amplitude_error_is": "stated" if fit.is_error_stated else "from residuals",
        **{
            key: {"estimate": fact.value, "standard_error": fact.error, "interval": interval}
            for key, (fact, interval) in estimates.items()
        },
        "damping_squared": fit.damping_squared,
        "table": pairs,
        "machine": table,
    }
    paste = "" if table is None else _toml(table)
    return Answer(facts, [points], _notes(fit, table), record, f"Machine of {path.name}", paste)


def _notes(fit: ResponseFit, table: Mapping[str, Any] | None) -> list[str]:
    notes = []
    if math.isnan(fit.amplitude_error[0]):
        notes.append(
            f"no errors and intervals: fewer than {POINTS_FOR_ERROR} points; state the error of an amplitude,"
            " such as --amplitude-error 2%"
        )
    if not fit.brackets_peak:
        end = "higher" if fit.amplitude[-1] >= fit.amplitude[0] else "lower"
        notes.append(
            "no estimate: the largest amplitude is at an end of the points; measure at"
            f" {end} frequencies too, until the amplitude has fallen again"
        )
    elif math.isnan(fit.damping_ratio):
        notes.append(
            "no damping ratio: errors are larger than the damping; measure closer to the peak, or let the"
            " empty machine ring down"
        )
    if table is not None and table["kind"] != "measured":
        # at which setting the points were measured, if the machine's force is right
        at = float(fit.frequency[np.argmin(fit.amplitude)])
        ratio = float(fit.amplitudes(at) / machine_of(table).machine.response(at).amplitude)
        if abs(ratio - 1.0) > _APART:
            notes.append(
                f"the points have {ratio:.3g} times the amplitude of this machine at a setting of 100 %: was"
                f" it {100.0 * ratio:.3g} %? the force stays as given"
            )
    return notes


def _estimates(fit: ResponseFit) -> dict[str, tuple[Fact, tuple[float, float]]]:
    """Return estimates with their errors, and their intervals, by key."""
    found = {}
    for name, kind in _ESTIMATES.items():
        value, error = (float(kind.from_si(getattr(fit, key))) for key in (name, f"{name}_sd"))
        low, high = (float(kind.from_si(end)) for end in getattr(fit, f"{name}_interval"))
        found[name + kind.suffix] = Fact(name.replace("_", " "), value, kind.unit, error), (low, high)
    return found


def _rounded(value: float, error: float) -> float:
    """Round a value to a hundredth of its error, so that the table has no meaningless digits."""
    if not (math.isfinite(error) and error > 0.0):
        return float(f"{value:.6g}")
    return round(value, max(0, 2 - math.floor(math.log10(error))))


def _machine_table(fit: ResponseFit, given: GivenMachine | None, path: Path) -> dict[str, Any] | None:
    """Return the table ``[machine]`` with what was fitted; None without an estimate.

    The force stays that of the file: at which setting the points were measured is unknown.
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
    damping = _rounded(fit.damping_ratio, fit.damping_ratio_sd)
    table = {**given.table, natural: found, "damping_ratio": damping}
    fitted = given.own.get("natural")  # the springs that were measured, which may be one of the packs
    if "pack" in table:
        packs = table["pack"] if isinstance(table["pack"], list) else [table["pack"]]
        table["pack"] = [{**p, natural: found} if given.packs[p["name"]] == fitted else p for p in packs]
    return table


def _toml(table: Mapping[str, Any]) -> str:
    """Write a table of a scene file, to be pasted."""
    import tomlkit

    written = tomlkit.item(dict(table))
    written.comment("with the fitted values")
    if table["kind"] == "measured" and "trough_mass_kg" not in table:
        written.add(tomlkit.comment("add trough_mass_kg = ..., that of the trough and what moves with it"))
    return tomlkit.dumps({"machine": written}).rstrip()


def columns(fit: ResponseFit) -> dict[str, Any]:
    """Return the points, measured and fitted, as the columns of a CSV."""
    return {
        "frequency_hz": fit.frequency,
        "amplitude_mm": np.asarray(LENGTH.from_si(fit.amplitude)),
        "fitted_amplitude_mm": np.asarray(LENGTH.from_si(fit.amplitudes(fit.frequency))),
        "difference_percent": np.asarray(PERCENT.from_si(fit.residual)),
        "error_percent": np.asarray(PERCENT.from_si(fit.amplitude_error)),
    }


def draw_fit(fit: ResponseFit, path: Path) -> Figure:
    """Draw the points with the fitted curve."""
    from vibro.plots.responses import fit_figure

    low, high = float(fit.frequency[0]), float(fit.frequency[-1])
    beyond, ends = _CURVE_BEYOND * (high - low), fit.natural_frequency_interval
    # Let the interval be seen, unless it is so wide that the points would be squeezed.
    low = min(low, max(ends[0], 2.0 * low - high))
    high = max(high, min(ends[1], 2.0 * high - low))
    x = np.linspace(max(low - beyond, 0.5 * low), high + beyond, _CURVE_POINTS)
    below = ", ".join(f"{fact.label} {fact.text}" for fact, _ in _estimates(fit).values())
    title = f"measured amplitudes \N{EN DASH} {path.name}"
    if not fit.brackets_peak:
        below = "no estimate: points on one side of the resonance"
    return fit_figure(fit, x, title, below)
