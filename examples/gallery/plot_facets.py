"""
One map for each value
======================

A list beside two ranges makes a map each, up to twelve, on the same scales. As the drive angle grows,
the trough throws parts at lower amplitudes, and the region of forward slip alone widens. File:
``out/angles-regime.png``; speeds have the same layout.

.. code-block:: bash

    vibro map -A 0.2:3 -f 10:50 -a 10,20,30 --mu-s .74 --mu-d .57 -o out/angles
"""

import vibro

sweep = vibro.sweep(
    amplitude_mm="0.2:3:161",
    frequency_hz="10:50:161",
    drive_angle_deg="10,20,30",
    static_friction=0.74,
    kinetic_friction=0.57,
)
figure = sweep.draw("regime")
