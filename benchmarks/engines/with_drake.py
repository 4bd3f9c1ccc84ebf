"""Drake: a sphere on two prismatic joints over a half-space, point contact, in the trough's frame.

Its documentation (``DiscreteContactApproximation``) prefers ``lagged``, the default, and ``similar`` for
strong transients, here with a stiction tolerance of 1e-5 m/s (default 1e-4) and a Hunt-Crossley dissipation
that leaves no bounce above 1 mm/s. ``SAP`` regularises by itself, and dissipates within a step. The contact
has 1e7 N/m on 1 kg. There is no coefficient of restitution.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np
import pydrake.all as drake

if TYPE_CHECKING:
    from scenes import Floats, Scene

VARIANTS: Final = {
    "Drake, lagged": "stiction tolerance 1e-5 m/s, Hunt-Crossley dissipation 1000 s/m",
    "Drake, similar": "the same",
    "Drake, SAP": "regularised by the solver itself, relaxation within a step",
}
_STIFFNESS: Final = 1e7  # [N/m]


def _properties(scene: Scene, step: float) -> Any:
    properties = drake.ProximityProperties()
    drake.AddContactMaterial(
        1000.0, _STIFFNESS, drake.CoulombFriction(scene.friction, scene.friction), properties
    )
    properties.AddProperty("material", "relaxation_time", step)
    return properties


def follow(scene: Scene, loads: Floats, step: float, variant: str, velocity: float = 0.0) -> Floats | None:
    """Return the displacement at each step [m], from rest on the trough or from a velocity along it [m/s]."""
    if scene.restitution:
        return None
    builder = drake.DiagramBuilder()
    plant, _ = drake.AddMultibodyPlant(
        drake.MultibodyPlantConfig(
            time_step=step,
            contact_model="point",
            discrete_contact_approximation=variant.partition(", ")[2].lower(),
            stiction_tolerance=1e-5,
            use_sampled_output_ports=False,
        ),
        builder,
    )
    plant.mutable_gravity_field().set_gravity_vector([0.0, 0.0, 0.0])
    inertia = drake.SpatialInertia.SolidSphereWithMass(1.0, 0.01)
    carriage = plant.AddRigidBody("carriage", drake.SpatialInertia.SolidSphereWithMass(1e-9, 1e-3))
    body = plant.AddRigidBody("body", inertia)
    x = plant.AddJoint(drake.PrismaticJoint("x", plant.world_frame(), carriage.body_frame(), [1, 0, 0]))
    z = plant.AddJoint(drake.PrismaticJoint("z", carriage.body_frame(), body.body_frame(), [0, 0, 1]))
    for joint in (x, z):
        plant.AddJointActuator(joint.name(), joint)
    properties = _properties(scene, step)
    plant.RegisterCollisionGeometry(
        plant.world_body(), drake.RigidTransform(), drake.HalfSpace(), "plane", properties
    )
    plant.RegisterCollisionGeometry(body, drake.RigidTransform(), drake.Sphere(0.01), "ball", properties)
    plant.Finalize()
    diagram = builder.Build()
    simulator = drake.Simulator(diagram)
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    z.set_translation(context, 0.01)
    x.set_translation_rate(context, velocity)
    port = plant.get_actuation_input_port()
    positions = np.zeros(len(loads) + 1)
    for i, load in enumerate(loads):
        port.FixValue(context, load)
        simulator.AdvanceTo((i + 1) * step)
        positions[i + 1] = x.get_translation(context)
    return positions
