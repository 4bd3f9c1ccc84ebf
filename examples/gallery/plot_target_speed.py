"""
Where a speed is reached
========================

Which parts does one drive convey at 20 mm/s or faster? ``--speed`` adds a red line to the map, and the
command prints the share of the cells that reach it. File: ``out/which-speed.png``.

.. code-block:: bash

    vibro map examples/friction_grid.toml --speed 20 -o out/which

.. image:: /gallery/images/sphx_glr_plot_target_speed_001.png
   :alt: Where a speed is reached. Which parts does one drive convey at 20 mm/s or faster? ``--speed``
      adds a red line to the map, and the command prints the share of the cells that reach it.
"""

# %%
# In Python:

import vibro

parts = vibro.sweep("../friction_grid.toml").to_frame(
    ["static_friction", "status", "mean_velocity_mm_s"]
)
possible = parts[parts["status"] != "infeasible"]
share = (possible["mean_velocity_mm_s"] >= 20).mean()
print(f"{share:.1%} of the possible pairs reach 20 mm/s")
