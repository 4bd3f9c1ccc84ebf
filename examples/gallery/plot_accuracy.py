"""
What other methods cost
=======================

Time for one scene against the largest error in its mean speed, both axes logarithmic: far left and low
is good. Vertical ticks are the median errors. Time steps and smoothed friction pay for every digit;
following events is accurate and slow. The command draws scenes at random and measures on this machine,
so numbers differ a little from run to run; it writes ``out/accuracy.png``. Python has no such function:
the star is ``vibro.solve``.

.. code-block:: bash

    vibro accuracy --scenes 20 -o out/accuracy
"""

import numpy as np

import vibro

scenes = vibro.Scene(
    amplitude=np.geomspace(1e-4, 1e-3, 100_000),
    frequency=20,
    drive_angle=0.3,
    static_friction=0.5,
    kinetic_friction=0.4,
)
print(np.unique(vibro.solve(scenes).regime))
