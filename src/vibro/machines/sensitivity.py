"""How speeds of a machine's filling follow mains, setting, springs and the filling itself, Eq. (93)."""

from __future__ import annotations

from dataclasses import fields
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from vibro.core.codes import Status
from vibro.fillings import amplitude_exponent, filling_of
from vibro.reals import shielded
from vibro.scene import Scene
from vibro.steady import solve

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.machines.operating import OperatingPoints
    from vibro.results.steady import SteadyCycle

    Floats = NDArray[np.float64]

__all__ = ["Sensitivities", "sensitivities"]

_STEP: Final = 1e-4  # [1] of the logarithm of the amplitude, of the shares' difference


class Sensitivities(NamedTuple):
    """Percent of speed that 1 % more of a quantity brings, the others held [1].

    ``stiffness`` is that of the springs without a rod; 1 % more natural frequency is 2 % more of it.
    ``amplitude`` is that of the speed alone, whatever the machine does.
    """

    amplitude: Floats
    frequency: Floats
    setting: Floats
    voltage: Floats
    trough_mass: Floats
    filling: Floats
    stiffness: Floats
    damping: Floats


@shielded
def sensitivities(points: OperatingPoints, cycle: SteadyCycle | None = None) -> Sensitivities:
    """Differentiate the logarithm of the speed at operating points.

    Parameters
    ----------
    points : OperatingPoints
        From ``vibro.operate``.
    cycle : SteadyCycle, optional
        ``vibro.solve(points.scene)``, if it is known already.

    Returns
    -------
    Sensitivities
        Arrays of the points' shape. NaN at rest, at jumps and without a settled motion, and where the kind of
        the filling's motion changes within 0.01 % of the amplitude. Of bodies that hop, speeds are
        differences over 1 % of amplitude: prefer speeds at the ends of bands there.

    Notes
    -----
    Eq. (93): the filling's shares follow the amplitude, which takes from a sensitivity, or adds to it, what
    elasticities of the machine alone do not know. Agrees with differences of operating points
    (tests/machines/test_sensitivity.py).
    """
    scene = points.scene
    cycle = solve(scene) if cycle is None else cycle
    exponent = np.asarray(amplitude_exponent(scene, cycle))
    share = points.added_mass_share - 1j * points.added_damping_share
    added = np.where(points.filling > 0.0, points.filling * np.nan_to_num(share), 0.0)
    springs = {} if points.machine.kind == "crank" else {"natural_frequency": points.natural_frequency}
    linear = points.machine.response(
        scene.frequency, setting=points.setting, voltage=points.voltage, added_mass=added, **springs
    )
    slope = linear.elasticities
    feedback = _feedback(points, cycle, linear.compliance, added)
    known = (points.status == int(Status.OK)) & ~np.asarray(points.at_jump)
    exponent = np.where(known, exponent, np.nan)
    by_amplitude = exponent / (1.0 + feedback)
    found = {name: (by_amplitude * value)[()] for name, value in slope.items()}
    found["frequency"] = (2.0 * exponent - 1.0 + by_amplitude * (slope["frequency"] - 2.0 * feedback))[()]
    return Sensitivities(amplitude=exponent[()], **found)


def _feedback(points: OperatingPoints, cycle: SteadyCycle, compliance: Any, added: Any) -> Floats:
    """Return Re(m H (d share / d ln A) / (1 + m H share)); NaN beside a change of the motion [1]."""
    if points.shares_given or not np.any(points.filling > 0.0):
        return np.zeros(np.shape(points.amplitude))
    given = {f.name: getattr(points.scene, f.name) for f in fields(points.scene)}
    shares = []
    known = np.asarray(points.filling == 0.0) | ~np.isnan(points.added_mass_share)
    for step in (-_STEP, _STEP):
        amplitude = points.scene.amplitude * np.exp(step)
        changed = {name: x for name, x in {**given, "amplitude": amplitude}.items() if x is not None}
        scene = Scene.allowing_infeasible(**changed)
        beside = solve(scene)
        shares.append(filling_of(scene, beside).share)
        known = known & ((points.filling == 0.0) | (beside.pattern_code == cycle.pattern_code))
    slope = (shares[1] - shares[0]) / (2.0 * _STEP)
    pull = points.filling * compliance
    found = np.real(pull * slope / (1.0 + added * compliance))
    return np.where(known, np.where(points.filling > 0.0, found, 0.0), np.nan)
