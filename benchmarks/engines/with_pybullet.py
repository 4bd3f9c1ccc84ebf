"""PyBullet: a sphere without rotation over a plane, in the trough's frame.

Settings: fixed steps without substeps, 200 iterations to a residual of 0, no damping of the motion. The
inertia about all axes is 0, which Bullet takes for infinite. Friction and restitution are the products of
those of body and plane. With a restitution its threshold, 0.2 m/s, is 0, and so is the distance up to which
contacts are processed before they touch: else a body that was dropped hardly rebounds.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
import pybullet

if TYPE_CHECKING:
    from scenes import Floats, Scene

VARIANTS: Final = {"PyBullet": "200 iterations, no damping, no thresholds of restitution"}
_RADIUS: Final = 0.05  # [m]


def follow(scene: Scene, loads: Floats, step: float, variant: str, velocity: float = 0.0) -> Floats:
    """Return the displacement at each step [m], from rest on the trough or from a velocity along it [m/s]."""
    client = pybullet.connect(pybullet.DIRECT)
    try:
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=step,
            numSubSteps=0,
            numSolverIterations=200,
            solverResidualThreshold=0.0,
            restitutionVelocityThreshold=0.0,
            physicsClientId=client,
        )
        distance = {"contactProcessingThreshold": 0.0} if scene.restitution else {}
        plane = pybullet.createMultiBody(
            0.0,
            pybullet.createCollisionShape(pybullet.GEOM_PLANE, physicsClientId=client),
            physicsClientId=client,
        )
        sphere = pybullet.createCollisionShape(pybullet.GEOM_SPHERE, radius=_RADIUS, physicsClientId=client)
        body = pybullet.createMultiBody(1.0, sphere, basePosition=[0.0, 0.0, _RADIUS], physicsClientId=client)
        pybullet.changeDynamics(
            plane, -1, lateralFriction=1.0, restitution=1.0, physicsClientId=client, **distance
        )
        pybullet.changeDynamics(
            body,
            -1,
            lateralFriction=scene.friction,
            restitution=scene.restitution,
            linearDamping=0.0,
            angularDamping=0.0,
            localInertiaDiagonal=[0.0, 0.0, 0.0],
            physicsClientId=client,
            **distance,
        )
        pybullet.resetBaseVelocity(body, [velocity, 0.0, 0.0], physicsClientId=client)
        positions = np.zeros(len(loads) + 1)
        for i, (along, normal) in enumerate(loads.tolist()):
            pybullet.setGravity(along, 0.0, normal, physicsClientId=client)
            pybullet.stepSimulation(physicsClientId=client)
            positions[i + 1] = pybullet.getBasePositionAndOrientation(body, physicsClientId=client)[0][0]
        return positions
    finally:
        pybullet.disconnect(client)
