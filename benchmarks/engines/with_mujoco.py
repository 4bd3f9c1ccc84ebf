"""MuJoCo: a sphere on three slide joints over a plane, in the trough's frame.

Settings, as its documentation advises against slip and for hard contact (Modeling, "Solver parameters" and
"Preventing slip"): elliptic cones, Newton's solver to a tolerance of 1e-12, impratio 10, solimp 0.99, and for
solref's time constant twice the step, the least there is. ``noslip`` adds 20 iterations of the solver of that
name. With two joints, along and normal to the trough, it has no effect on elliptic cones: hence the third.

There is no coefficient of restitution. A spring and damper that push but do not pull let a body go with

    e = exp(-z / sqrt(1 - z^2) * atan2(2 z sqrt(1 - z^2), 2 z^2 - 1))

of its speed at the damping ratio z < 1: 0.731 for 0.2, over some ten steps. A restitution of 0 has the ratio
1, the default, with which drops rebound with 0.1 to 0.16; larger ratios rebound less, but the speeds of hops
are worse.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import mujoco
import numpy as np

if TYPE_CHECKING:
    from scenes import Floats, Scene

VARIANTS: Final = {
    "MuJoCo": "elliptic cones, Newton, impratio 10, time constant of two steps",
    "MuJoCo, noslip": "and 20 iterations of the noslip solver",
}
#: Damping ratio and time constant [steps] for each restitution.
_CONTACTS: Final = {0.0: (1.0, 2.0), 0.2: (0.731, 4.6)}
_MODEL: Final = """
<mujoco>
  <option timestep="{step!r}" gravity="0 0 0" cone="elliptic" solver="Newton" tolerance="1e-12" impratio="10"
          noslip_iterations="{noslip}" noslip_tolerance="1e-12"/>
  <default>
    <geom condim="3" friction="{friction!r} 0 0" solref="{constant!r} {damping!r}" solimp="0.99 0.99 0.001"/>
  </default>
  <worldbody>
    <geom type="plane" size="9 9 1"/>
    <body pos="0 0 0.01">
      <joint type="slide" axis="1 0 0"/>
      <joint type="slide" axis="0 1 0"/>
      <joint type="slide" axis="0 0 1"/>
      <geom type="sphere" size="0.01" mass="1"/>
    </body>
  </worldbody>
</mujoco>
"""


def follow(scene: Scene, loads: Floats, step: float, variant: str, velocity: float = 0.0) -> Floats:
    """Return the displacement at each step [m], from rest on the trough or from a velocity along it [m/s]."""
    damping, steps = _CONTACTS[scene.restitution]
    text = _MODEL.format(
        step=step,
        friction=scene.friction,
        noslip=20 if "noslip" in variant else 0,
        constant=steps * step,
        damping=damping,
    )
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.qvel[0] = velocity
    positions = np.zeros(len(loads) + 1)
    for i, (along, normal) in enumerate(loads.tolist()):
        model.opt.gravity[:] = along, 0.0, normal
        mujoco.mj_step(model, data)
        positions[i + 1] = data.qpos[0]
    return positions
