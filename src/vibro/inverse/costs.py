"""Sensitivity of the mean speed to small changes of each input."""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np

from vibro.drives import Ability
from vibro.errors import Problem, SceneError
from vibro.scene import Scene
from vibro.slopes import displacement_gradient
from vibro.steady import solve

__all__ = ["speed_costs"]

_STEP: Final = 1e-5  # [1, rad] step of the finite differences
# Inputs of a scene with an elliptical drive, and whether each is an angle.
_OF_ELLIPSES: Final = {
    "along_amplitude": False, "normal_amplitude": False, "normal_phase": True, "frequency": False,
    "static_friction": False, "kinetic_friction": False, "trough_angle": True,
}  # fmt: skip


def speed_costs(scene: Scene) -> dict[str, float]:
    """Return by how many percent the mean speed changes for a small change of each input.

    Parameters
    ----------
    scene : Scene
        One operating point, of shape ().

    Returns
    -------
    dict of str to float
        ``amplitude``, ``frequency``, ``drive_angle``, ``static_friction``, ``kinetic_friction``: change for
        1 % more of it, d ln v / d ln x; elliptical drives have ``along_amplitude`` and ``normal_amplitude``
        instead of amplitude and drive angle. ``trough_angle_deg`` and ``normal_phase_deg``: change for 1 deg
        more, since 1 % of an angle near 0 is nothing. Positive values mean faster, also for a body that is
        conveyed backwards. All are NaN if the body rests, slides to and fro without being conveyed, hops, or
        has no steady cycle [%].

    Raises
    ------
    SceneError
        If the scene is more than one operating point.

    Notes
    -----
    Lines use the closed form, Eq. (51), ellipses finite differences. The values hold within the pattern of
    the scene, not across the jumps where slip begins or back slip enters.
    """
    if scene.shape:
        raise SceneError((Problem("scene", f"shape {scene.shape}", "one operating point, of shape ()"),))
    if not scene.arrays().can(Ability.PROOF):
        return _differences(scene)
    cycle = solve(scene, flight=False)
    displacement = float(cycle.displacement_per_cycle / scene.scale) or math.nan
    gradient = displacement_gradient(scene, cycle.pattern_code)
    change = {name: float(slope) / displacement for name, slope in gradient._asdict().items()}
    angles_and_frictions = ("drive_angle", "static_friction", "kinetic_friction")
    return {
        "amplitude": 1.0 + change["log_load"],
        "frequency": 1.0 + 2.0 * change["log_load"],
        **{name: change[name] * float(getattr(scene, name)) for name in angles_and_frictions},
        "trough_angle_deg": 100.0 * math.radians(change["trough_angle"]),
    }


def _differences(scene: Scene) -> dict[str, float]:
    """Return ``speed_costs`` of an elliptical drive by central differences; NaN where the pattern changes."""
    fields = {name: float(value) for name, value in scene.arrays()._asdict().items()}
    costs = {}
    for name, is_angle in _OF_ELLIPSES.items():
        step = _STEP if is_angle else _STEP * fields[name]
        values = fields[name] + step * np.array([-1.0, 0.0, 1.0])
        beside: dict[str, Any] = {**fields, name: values}
        cycle = solve(Scene.allowing_infeasible(**beside), flight=False)
        low, middle, high = cycle.mean_velocity
        is_smooth = middle != 0.0 and len(set(cycle.pattern_code.tolist())) == 1
        slope = float((high - low) / (2.0 * _STEP * middle)) if is_smooth else math.nan
        costs[name + "_deg" * is_angle] = 100.0 * math.radians(slope) if is_angle else slope
    return costs
