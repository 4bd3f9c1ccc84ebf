"""
Flights and impacts
===================

At 4 mm the trough throws the same part (red), and it slides forward or back after each landing. The
lowest panel is the height above the trough; crosses in the forces mark impacts. File: ``out/hop.png``.

.. code-block:: bash

    vibro simulate examples/safety_nut.toml -A 4 --restitution .3 -o out/hop

.. image:: /gallery/images/sphx_glr_plot_flights_001.png
   :alt: Flights and impacts. At 4 mm the trough throws the same part (red), and it slides forward or
      back after each landing.
"""

# %%
# In Python:

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
