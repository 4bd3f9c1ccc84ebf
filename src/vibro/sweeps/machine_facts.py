"""One machine at one operating point, in words."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.quantities import LENGTH, MACHINE, MASS, QUANTITIES, SPEED
from vibro.results.operating import WARNED_HARMONIC
from vibro.steady import solve
from vibro.sweeps.grid import scene_of
from vibro.sweeps.machines import case_of, points_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    from vibro.files.machines import GivenMachine
    from vibro.machines.operating import OperatingPoints

__all__ = ["machine_facts", "machine_warnings"]

_MOSTLY: Final = "more mass mostly means more amplitude"
_SOFT: Final = 3.0  # of the drive over the mounts' frequency: as stiff as makers have them
_ROUNDING: Final = 1e-12  # [1] share of a filling's mass
_MASSES: Final = {
    "vibrating_mass_kg": "vibrating mass", "trough_mass_kg": "trough", "counter_mass_kg": "counter mass",
}  # fmt: skip


def machine_warnings(given: GivenMachine, values: Mapping[str, Any]) -> list[str]:
    """Return what a reader of one cell's numbers must know, one sentence each."""
    return points_of(given, values).remarks()


def machine_facts(given: GivenMachine, values: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return the lines of a report on a machine at one operating point.

    Parameters
    ----------
    given : GivenMachine
        The machine.
    values : mapping of str to array
        Quantities of a single cell by name, in the units outside.

    Returns
    -------
    list of pair of str
        Names and texts.
    """
    one = {name: float(values[name].item()) for name in QUANTITIES if name in values}
    points = points_of(given, values)
    filling = one["filling"]
    facts = [("machine", _machine(given, one)), ("resonance", _resonance(points, filling))]
    facts.append(("filling", _filling(given, points, filling)))
    empty, full = (_mm(x) for x in (points.amplitude_empty, points.amplitude))
    told = f"{empty} empty"
    if filling:
        change = float(np.asarray(points.amplitude).item() / np.asarray(points.amplitude_empty).item()) - 1.0
        told += f", {full} with {MASS.text(filling)} ({100.0 * change:+.3g} %)"
        low, high = (np.asarray(x).item() for x in (points.amplitude_low, points.amplitude_high))
        if low < high:
            told += f", certainly between {_mm(low)} and {_mm(high)}"
    facts.append(("amplitude", told))
    if filling and low < high:
        facts.append(("speeds", _speeds(values, low, high)))
    if np.asarray(points.number).item() > 1:
        facts.append(("all amplitudes", _all_amplitudes(given, values)))
    if given.kind not in ("unbalance", "crank"):  # whose springs bend as the trough moves, or which have none
        facts.append(("springs bend", f"{_mm(points.relative_amplitude)} to each side"))
    second = np.asarray(points.second_harmonic).item()
    if filling and math.isfinite(second):
        told = f"{100.0 * second:.3g} % of the amplitude, from the filling"
        if second > WARNED_HARMONIC:
            speed = float(SPEED.from_si(np.asarray(points.speed_with_second_harmonic()).item()))
            told += f"; with it the mean speed is {speed:.4g} mm/s" if math.isfinite(speed) else ""
        facts.append(("second harmonic", told))
    return facts


def _mm(value: Any) -> str:
    return f"{LENGTH.from_si(float(np.asarray(value).item())):.4g} mm"


def _machine(given: GivenMachine, one: Mapping[str, float]) -> str:
    """Say what the machine is, and at which setting; of bands also which of their values that is."""
    table, said = given.table, [given.kind]
    for key, name in _MASSES.items():
        if key in table:
            said.append(f"{name} {table[key]}" + (" kg" if isinstance(table[key], int | float) else ""))
    for name in MACHINE[:2]:
        if given.takes(name):
            said.append(f"{QUANTITIES[name].label} {_of_band(given, name, one[name])}")
    if given.has_springs:
        fitted = next((f" ({shown})" for shown, f0 in given.packs.items() if f0 == one["natural"]), "")
        said.append(f"{QUANTITIES['natural'].label} {QUANTITIES['natural'].text(one['natural'])}{fitted}")
    elif given.kind == "unbalance":
        said.append(_mounts(given))
    return ", ".join(said)


def _mounts(given: GivenMachine) -> str:
    if given.machine.natural_frequency:
        return f"mounts {QUANTITIES['natural'].text(given.arguments['mount_frequency'])}"
    more = 100.0 / (_SOFT**2 - 1.0)
    return f"infinitely soft mounts, as no mount_hz is given (at f/f0 = {_SOFT:g} they add {more:.3g} %)"


def _of_band(given: GivenMachine, name: str, value: float) -> str:
    quantity = QUANTITIES[name]
    if name not in given.bands:
        return quantity.text(value)
    low, high = given.bands[name]
    return f"{quantity.text(value)} (of {low:.15g}...{quantity.text(high)})"


def _resonance(points: OperatingPoints, filling: float) -> str:
    empty, full = (
        float(np.asarray(x).item()) for x in (points.frequency_ratio, points.filled_frequency_ratio)
    )
    if not empty:
        return "none: the trough follows the crank"
    if math.isinf(empty):
        return "far below: the machine runs above resonance, where more mass means less amplitude"
    told = f"f/f0 = {empty:.4g} empty"
    if filling and math.isfinite(full):
        told += f", {full:.4g} with the filling"
    if empty == 1.0:
        return f"{told}: at resonance, where damping alone decides the amplitude"
    sides = [ratio < 1.0 for ratio in (empty, *([full] if filling and math.isfinite(full) else []))]
    if all(sides):
        # far below, near the load-proof springs, more mass means less amplitude too
        told += ": below resonance"
        return told if filling and points.amplitude < points.amplitude_empty else f"{told}, where {_MOSTLY}"
    if not any(sides):
        return f"{told}: above resonance, where more mass means less amplitude"
    return f"{told}: the filling takes the machine across resonance"


def _share(value: float) -> str:
    """Write a share in percent; 0 if it is rounding alone."""
    return f"{100.0 * value:.3g}" if abs(value) > _ROUNDING else "0"


def _filling(given: GivenMachine, points: OperatingPoints, filling: float) -> str:
    if not filling:
        told = "none: the trough is empty"
        if "filling" in given.bands:
            _, high = given.bands["filling"]
            told += f" (the file's band ends at {MASS.text(high)})"
        return told
    mass, damping = (
        float(np.asarray(x).item()) for x in (points.added_mass_share, points.added_damping_share)
    )
    if math.isnan(mass):
        return f"{MASS.text(filling)}, whose shares are not known: its motion is irregular"
    whose = "given" if given.shares else "computed"
    if any(low < high for low, high in given.shares.values()):
        whose = "the middles of given bands"
    return (
        f"{MASS.text(filling)}: {_share(mass)} % of it acts as mass, {_share(damping)} % as damping ({whose})"
    )


def _speeds(values: Mapping[str, Any], low: float, high: float) -> str:
    """Tell the speeds at both ends of the interval in which the amplitude lies."""
    ends = LENGTH.from_si(np.array([low, high]))
    cells = {name: np.asarray(x).reshape(1) for name, x in values.items()}
    speeds = SPEED.from_si(solve(scene_of({**cells, "amplitude": ends})).mean_velocity)
    return " and ".join(
        f"{speed:.4g} mm/s at {end:.4g} mm" for speed, end in zip(speeds.tolist(), ends.tolist(), strict=True)
    )


def _all_amplitudes(given: GivenMachine, values: Mapping[str, Any]) -> str:
    from vibro.machines.operating import operating_points

    case = {
        name: None if x is None else float(np.asarray(x).item()) for name, x in case_of(given, values).items()
    }
    found = operating_points(given.machine, **case)
    return f"{', '.join(map(_mm, found))}; the least is reached when the machine is switched on"
