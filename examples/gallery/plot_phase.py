"""
Phase of an ellipse
===================

The trough moves along an ellipse, and the phase between its two motions decides how fast parts go, and
which way. Near -80 deg the trough presses a part least while it slides forward; half a turn away parts
go back at the same speed. File: ``out/phase-speed.png``.

.. code-block:: bash

    vibro map along=.2:2 phase=-180:180 normal=.3 -f 25 --mu-s .4 --mu-d .3 -o out/phase
"""

import vibro

sweep = vibro.sweep(
    along_amplitude_mm="0.2:2:301",
    normal_phase_deg="-180:180:301",
    normal_amplitude_mm=0.3,
    frequency_hz=25,
    static_friction=0.4,
    kinetic_friction=0.3,
)
figure = sweep.draw("speed")
