"""
A record beside the model
=========================

Signals of a record (dots) beside the exact steady motion of the scene (lines). On the right all cycles
are laid on one. This record is a simulation with smoothed friction: it moves where the part should rest,
and its peak speed is too low. File: ``out/compare.png``.

.. code-block:: bash

    vibro measure examples/safety_nut.toml examples/data/nut_smoothed_600hz.csv -o out/compare

.. image:: /gallery/images/sphx_glr_plot_compare_001.png
   :alt: A record beside the model. Signals of a record (dots) beside the exact steady motion of the
      scene (lines).
"""

# %%
# In Python:

import vibro

cycle = vibro.solve(vibro.read_scene("../safety_nut.toml"))
print(
    f"pattern {cycle.pattern}, {1e3 * cycle.displacement_per_cycle:.4f} mm a cycle, "
    f"peak {1e3 * cycle.peak_velocity:.1f} mm/s"
)
