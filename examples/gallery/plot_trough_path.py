r"""
Path of the trough
==================

Where the trough moves along an ellipse, its path is drawn below the motion, and coloured by what the
part does: it slides forward (blue) on the upper way and back (yellow) on the lower one. The limits of
friction are narrow while it slides forward, and wide while it slides back. File: ``out/ellipse.png``.

.. code-block:: bash

    vibro simulate along=1 normal=.3 phase=-60 -f 25 --mu-s .4 --mu-d .3 --cycles 4 \
      -o out/ellipse
"""

import math

import vibro

scene = vibro.Scene(
    along_amplitude=1e-3,
    normal_amplitude=0.3e-3,
    normal_phase=math.radians(-60),
    frequency=25,
    static_friction=0.4,
    kinetic_friction=0.3,
)
figure = vibro.simulate(scene, cycles=4).draw()
