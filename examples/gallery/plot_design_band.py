"""
Speed of all parts
==================

At the frequency and the angle of the chosen design: the slowest and the fastest part over the amplitude,
with the nominal part (in the middle of the bands) between them. The grey window keeps the goal. File:
``out/design-band.png``. In Python ``limit`` is the largest amplitude of the drive.

.. code-block:: bash

    vibro design examples/design_nut.toml -o out/design

.. image:: /gallery/images/sphx_glr_plot_design_band_001.png
   :alt: Speed of all parts. At the frequency and the angle of the chosen design: the slowest and the
      fastest part over the amplitude, with the nominal part between them.
"""

# %%
# In Python:

import math

import vibro

scene = vibro.Scene(
    amplitude=1e-3,
    frequency=10,
    drive_angle=math.radians(45),
    static_friction=0.74,
    kinetic_friction=0.55,
)
bands = {"static_friction": (0.7, 0.78), "kinetic_friction": (0.5, 0.6)}
goal = {"highest_regime": "forward-slip", "limit": 3e-3}
for window in vibro.feasible_amplitudes(scene, 0.03, **goal, **bands):
    print(f"{1e3 * window.low:.3f} to {1e3 * window.high:.3f} mm")
