"""Cells of sweeps whose amplitude follows from a machine and its filling."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.core.codes import Regime, Status, is_answered
from vibro.errors import InputError
from vibro.quantities import MACHINE, QUANTITIES
from vibro.results.operating import FIELDS, OPERATING
from vibro.results.steady import RESULTS
from vibro.steady import solve
from vibro.units import LENGTH

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from vibro.files.machines import GivenMachine
    from vibro.machines.operating import OperatingPoints
    from vibro.results.steady import SteadyCycle
    from vibro.scene import Scene

#: Arguments of ``vibro.operate`` that are fields of a scene.
OF_SCENE: Final = (
    "frequency", "drive_angle", "static_friction", "kinetic_friction", "trough_angle", "gravity",
    "restitution",
)  # fmt: skip
_ROOM: Final = 0.98  # [1] of the largest setting at which masses do not strike, as a filling may push it
_UNANSWERED: Final = {"regime": Regime.UNDEFINED, "coexists": -1}  # codes that are not 0


def case_of(given: GivenMachine, values: Mapping[str, Any], share: Any = None) -> dict[str, Any]:
    """Return the arguments of ``vibro.operate``, besides the machine, for cells in the units outside.

    A pair of added mass and damping shares replaces those of the machine, or what would be computed.
    """
    si = {name: QUANTITIES[name].to_si(values[name]) for name in (*OF_SCENE, *MACHINE) if name in values}
    natural = si.pop("natural", None)
    mass, damping = share or given.share or (None, None)
    return {
        **si,
        "natural_frequency": natural if given.has_springs else None,
        "added_mass_share": mass,
        "added_damping_share": damping,
    }


def points_of(given: GivenMachine, values: Mapping[str, Any], share: Any = None) -> OperatingPoints:
    """Find the operating points of cells, given by their values in the units outside; as ``case_of``."""
    from vibro.machines.operating import operate

    return operate(given.machine, **case_of(given, values, share), allow_strikes=True)


def operated(given: GivenMachine, values: Mapping[str, Any], share: Any = None) -> dict[str, NDArray[Any]]:
    """Return what a machine adds to the values of cells.

    Parameters
    ----------
    given : GivenMachine
        The machine.
    values : mapping of str to array
        Quantities of cells by name, in the units outside; those of ``MACHINE`` among them.
    share : pair of array, optional
        As for ``case_of``.

    Returns
    -------
    dict of str to array
        ``amplitude`` [mm], NaN where there is none, ``OPERATING``, an array of ``FIELDS``, and the natural
        frequency of a machine whose springs cannot be exchanged.
    """
    points = points_of(given, values, share)
    ndim = max(np.ndim(x) for x in values.values())
    amplitude = np.where(points.strikes, np.nan, points.amplitude)
    amplitude = amplitude.reshape((1,) * (ndim - amplitude.ndim) + amplitude.shape)
    found = np.empty(amplitude.shape, FIELDS)
    for name in FIELDS.names or ():
        found[name] = getattr(points, name)
    springs = (
        {} if "natural" in values else {"natural": np.full((1,) * ndim, given.machine.natural_frequency)}
    )
    return {"amplitude": np.asarray(LENGTH.from_si(amplitude)), OPERATING: found, **springs}


def bent_speed(values: Mapping[str, Any], scene: Scene) -> Any:
    """Return the speeds of cells whose troughs move with their second harmonics too [m/s]."""
    from vibro.machines.operating import with_second_harmonic

    speed = solve(with_second_harmonic(scene, values[OPERATING]["second_phasor"])).mean_velocity
    return np.where(np.isnan(values["amplitude"]), np.nan, speed)


def empty_amplitude(given: GivenMachine, values: Mapping[str, float]) -> float:
    """Return the amplitude of the empty trough [mm]."""
    case = case_of(given, values)
    supply = {name: case[name] for name in ("setting", "voltage", "natural_frequency")}
    return float(LENGTH.from_si(given.machine.response(case["frequency"], **supply).amplitude))


def check_operating(given: GivenMachine, values: Mapping[str, Any]) -> None:
    """Refuse a single cell without an operating point.

    Raises
    ------
    InputError
        It says why.
    """
    if not np.isnan(values["amplitude"]).any():
        return
    across = float(LENGTH.from_si(values[OPERATING]["relative_amplitude"].item()))
    gap = float(LENGTH.from_si(given.machine.gap))
    if np.isinf(across):
        raise InputError(
            "the amplitude is infinite: the drive is at resonance, without damping",
            hint="give a damping_ratio > 0",
        )
    if across > gap:
        least = _ROOM * values["setting"].item() * gap / across
        raise InputError(
            f"the masses strike: the relative amplitude would be {across:.4g} mm, and gap_mm allows"
            f" {gap:.4g} mm",
            hint=f"lower it, such as setting={least:.3g}, or take springs farther from resonance",
        )
    raise InputError(
        "the machine has no operating point here: no amplitude with this filling was found",
        hint="change the setting, the filling or the springs, or give added_mass_share",
    )


def withheld(cycle: SteadyCycle, values: Mapping[str, Any]) -> SteadyCycle:
    """Let no cell be surer than its operating point.

    Cells without an operating point lose their numbers and get its status. Where the filling moves
    irregularly the amplitude is known to an interval: cells are averaged, and those that would be exact have
    no standard error. Where the amplitude hovers about a threshold, cells are at a boundary.
    """
    shape = cycle.status.shape
    status = np.broadcast_to(values[OPERATING]["status"], shape)
    lost = np.broadcast_to(np.isnan(values["amplitude"]), shape) & (cycle.status != Status.INFEASIBLE)
    if not lost.any() and (status == Status.OK).all():
        return cycle
    arrays: dict[str, Any] = {}
    for result in RESULTS:
        nothing = np.nan if result.is_number else _UNANSWERED.get(result.name, 0)
        arrays[result.name] = np.where(lost, nothing, getattr(cycle, result.name)).astype(result.dtype)
    unsure = ~lost & (status == Status.AVERAGED) & is_answered(cycle.status)
    arrays["mean_velocity_error"][unsure & (cycle.status != Status.AVERAGED)] = np.nan
    hovers = ~lost & (status == Status.BOUNDARY) & (cycle.status == Status.OK)
    why = np.where(is_answered(status), Status.INFEASIBLE, status)  # of those without one, masses strike
    found = np.where(unsure, Status.AVERAGED, np.where(hovers, Status.BOUNDARY, cycle.status))
    arrays["status"] = np.where(lost, why, found).astype(np.int8)
    return replace(cycle, **arrays)
