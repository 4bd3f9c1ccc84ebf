"""
Amplitude and speed of a machine
================================

A magnetic feeder over the frequency of its drive, empty and with 4 kg in its trough. A filling moves the
resonance to the left and flattens it: at 50 Hz amplitude and speed of a full feeder fall. Bands are what
the mains' voltage changes. File: ``out/drive-response.png``.

.. code-block:: bash

    vibro drive examples/full_feeder.toml -o out/drive

.. image:: /gallery/images/sphx_glr_plot_response_001.png
   :alt: Amplitude and speed of a machine. A magnetic feeder over the frequency of its drive, empty and
      with 4 kg in its trough.
"""

# %%
# In Python:

import math

import vibro

feeder = vibro.Machine.magnet(
    trough_mass=6,
    counter_mass=12,
    natural_frequency=47.619,
    damping_ratio=0.015,
    calibration=vibro.Calibration(amplitude=0.35e-3, frequency=50, setting=0.8),
)
parts = {
    "drive_angle": math.radians(20),
    "static_friction": 0.35,
    "kinetic_friction": 0.28,
}
points = vibro.operate(feeder, frequency=50, setting=0.8, filling=[0, 2, 4], **parts)
print(1e3 * points.amplitude, 1e3 * vibro.solve(points.scene).mean_velocity)  # mm, mm/s
