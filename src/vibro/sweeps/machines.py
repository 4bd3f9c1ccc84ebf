"""Cells of sweeps whose amplitude follows from a machine and its filling."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.core.codes import Regime, Status, is_answered
from vibro.quantities import LENGTH, MACHINE, QUANTITIES
from vibro.results.operating import FIELDS, MACHINE_RESULTS, OPERATING
from vibro.results.steady import RESULTS, SteadyCycle

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from vibro.files.machines import GivenMachine
    from vibro.machines.operating import OperatingPoints

__all__ = ["operated", "points_of", "withheld"]

_SCENE: Final = (
    "frequency", "drive_angle", "static_friction", "kinetic_friction", "trough_angle", "gravity", "restitution",
)  # fmt: skip
_UNANSWERED: Final = {"regime": Regime.UNDEFINED, "coexists": -1}  # codes that are not 0


def points_of(given: GivenMachine, values: Mapping[str, Any], threads: int | None = None) -> OperatingPoints:
    """Find the operating points of cells, given by their values in the units outside."""
    from vibro.machines.operating import operate

    si = {name: QUANTITIES[name].to_si(values[name]) for name in (*_SCENE, *MACHINE) if name in values}
    natural = si.pop("natural", None)
    mass, damping = given.share or (None, None)
    return operate(
        given.machine,
        natural_frequency=natural if given.has_springs else None,
        added_mass_share=mass,
        added_damping_share=damping,
        threads=threads,
        **si,
    )


def operated(
    given: GivenMachine, values: Mapping[str, Any], threads: int | None = None
) -> dict[str, NDArray[Any]]:
    """Return what a machine adds to the values of cells.

    Parameters
    ----------
    given : GivenMachine
        The machine.
    values : mapping of str to array
        Quantities of cells by name, in the units outside; those of ``MACHINE`` among them.
    threads : int, optional
        For operating points with a filling.

    Returns
    -------
    dict of str to array
        ``amplitude`` [mm], NaN where there is none, and ``OPERATING``, an array of ``FIELDS``.
    """
    points = points_of(given, values, threads)
    ndim = max(np.ndim(x) for x in values.values())
    amplitude = np.asarray(points.amplitude)
    amplitude = amplitude.reshape((1,) * (ndim - amplitude.ndim) + amplitude.shape)
    found = np.empty(amplitude.shape, FIELDS)
    for name in FIELDS.names or ():
        found[name] = np.abs(getattr(points, name)) if name == "second_harmonic" else getattr(points, name)
    return {"amplitude": np.asarray(LENGTH.from_si(amplitude)), OPERATING: found}


def withheld(cycle: SteadyCycle, values: Mapping[str, Any]) -> SteadyCycle:
    """Take away the numbers of cells without an operating point, and give them its status."""
    status = values[OPERATING]["status"]
    lost = np.isnan(values["amplitude"])
    if not lost.any():
        return cycle
    lost, status = (np.broadcast_to(x, cycle.status.shape) for x in (lost, status))
    lost = lost & (cycle.status != Status.INFEASIBLE)
    arrays = {}
    for result in RESULTS:
        nothing = np.nan if result.is_number else _UNANSWERED.get(result.name, 0)
        arrays[result.name] = np.where(lost, nothing, getattr(cycle, result.name)).astype(result.dtype)
    why = np.where(is_answered(status), Status.INFEASIBLE, status)
    arrays["status"] = np.where(lost, why, cycle.status).astype(np.int8)
    return SteadyCycle(**arrays)
