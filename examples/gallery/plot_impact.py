"""
Impact speed
============

How fast parts land, normal to the trough: the largest speed of all landings. Delicate parts need a
setting close to the hop limit. ``--show`` asks for this picture. File: ``out/throw-impact.png``.

.. code-block:: bash

    vibro map -A 0.1:8 -f 5:30 -a 30 --mu-s .5 --mu-d .4 --show impact,flight -o out/throw
"""

import vibro

sweep = vibro.sweep(
    amplitude_mm="0.1:8:301",
    frequency_hz="5:30:301",
    drive_angle_deg=30,
    static_friction=0.5,
    kinetic_friction=0.4,
)
figure = sweep.draw("impact")
