"""What small changes of the inputs cost: by how much the mean speed follows each of them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from vibro.core.contact.derivatives import displacement_gradient
from vibro.core.groups import each
from vibro.errors import Problem, SceneError
from vibro.steady import solve

if TYPE_CHECKING:
    from vibro.scene import Scene

__all__ = ["speed_costs"]


def speed_costs(scene: Scene) -> dict[str, float]:
    """Tell by how many percent the mean speed changes if one input changes a little.

    Parameters
    ----------
    scene : Scene
        One operating point, of shape ().

    Returns
    -------
    dict of str to float
        ``amplitude``, ``frequency``, ``drive_angle``, ``static_friction``, ``kinetic_friction``: for 1 % more
        of it, d ln v / d ln x. ``trough_angle_deg``: for a climb steeper by 1 deg, since 1 % of an angle near
        0 is nothing. Positive is faster, and faster backwards where the body is conveyed backwards. All are
        NaN where there is no such number: the body rests, slides to and fro without being conveyed, hops, or
        has no steady cycle [%].

    Raises
    ------
    SceneError
        If the scene is more than one operating point.

    Notes
    -----
    Closed form, Eq. (51). They hold within the pattern of the scene, not across the jumps where slip begins
    or back slip enters.
    """
    if scene.shape:
        raise SceneError((Problem("scene", f"shape {scene.shape}", "one operating point, of shape ()"),))
    cycle = solve(scene, flight=False)
    groups = each(scene.arrays().loads(), lambda group: np.reshape(group, 1))
    displacement = float(cycle.displacement_per_cycle / scene.scale) or math.nan
    gradient = displacement_gradient(groups, np.reshape(cycle.pattern_code, 1))
    change = {name: float(slope[0]) / displacement for name, slope in gradient._asdict().items()}
    angles_and_frictions = ("drive_angle", "static_friction", "kinetic_friction")
    return {
        "amplitude": 1.0 + change["log_load"],
        "frequency": 1.0 + 2.0 * change["log_load"],
        **{name: change[name] * float(getattr(scene, name)) for name in angles_and_frictions},
        "trough_angle_deg": 100.0 * math.radians(change["trough_angle"]),
    }
