r"""
A measured drive
================

Two accelerometers on a trough give its motion, and a part is followed on that motion: forces and speeds
as if somebody had measured them on the part. The first command writes a scene file, the second
``out/measured.png``.

.. code-block:: bash

    vibro measure examples/data/nut_trough_mv.csv --trough-along "Trog längs" \
      --trough-normal "Trog normal" --sensitivity 100mV/g -o out/drive.toml
    vibro simulate out/drive.toml --mu-s .74 --mu-d .57 -o out/measured

.. image:: /gallery/images/sphx_glr_plot_measured_drive_001.png
   :alt: A measured drive. Two accelerometers on a trough give its motion, and a part is followed on that
      motion: forces and speeds as if somebody had measured them on the part.
"""

# %%
# In Python:

import vibro

measured = vibro.measured_motion(
    "../data/nut_trough_mv.csv",
    trough_along="Trog längs",
    trough_normal="Trog normal",
    sensitivity="100mV/g",
)
scene = vibro.Scene(**measured.drive(), static_friction=0.74, kinetic_friction=0.57)
vibro.simulate(scene, cycles=3).to_frame()[["phase", "start_s", "end_s"]]
