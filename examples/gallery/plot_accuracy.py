"""
What other methods cost
=======================

Time for one scene against the largest error in its mean speed, both axes logarithmic: far left and low
is good. Vertical ticks are the median errors. Scenes are drawn at random and timed on this machine, so
numbers differ a little from run to run. File: ``out/accuracy.png``. The star is ``vibro.solve``.

.. code-block:: bash

    vibro accuracy --scenes 20 -o out/accuracy

.. image:: /gallery/images/sphx_glr_plot_accuracy_001.png
   :alt: What other methods cost. Time for one scene against the largest error in its mean speed, both
      axes logarithmic: far left and low is good.
"""

# %%
# In Python:

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
