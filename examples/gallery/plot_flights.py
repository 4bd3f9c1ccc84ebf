"""
Flights and impacts
===================

At 4 mm the trough throws the same part (red), and it slides forward or back after each landing. The
lowest panel is the height above the trough. In flight no friction acts; crosses in the forces mark
impacts, at which the relative velocity jumps. The command writes ``out/hop.png``.

.. code-block:: bash

    vibro simulate examples/safety_nut.toml -A 4 --restitution .3 -o out/hop
"""

import vibro

scene = vibro.Scene(
    amplitude=4e-3,
    frequency=15,
    drive_angle=0.349,
    static_friction=0.74,
    kinetic_friction=0.57,
    restitution=0.3,
)
vibro.simulate(scene, cycles=3).to_frame()[["phase", "start_s", "end_s"]]
