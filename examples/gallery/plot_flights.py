"""
Flights and impacts
===================

At 4 mm the trough throws the same part (red), and it slides forward or back after each landing. The
lowest panel is the height above the trough; crosses in the forces mark impacts. File: ``out/hop.png``.

.. code-block:: bash

    vibro simulate examples/safety_nut.toml -A 4 --restitution .3 -o out/hop
"""

import math

import vibro

scene = vibro.Scene(
    amplitude=4e-3,
    frequency=15,
    drive_angle=math.radians(20),
    static_friction=0.74,
    kinetic_friction=0.57,
    restitution=0.3,
)
figure = vibro.simulate(scene, cycles=3).draw()
