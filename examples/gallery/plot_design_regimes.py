"""
Regimes of all parts
====================

The same question by regime. Where colours are hatched, parts differ: the one with the lowest friction
slips already, the one with the highest still rests. File: ``out/design-regime.png``.

.. code-block:: bash

    vibro design examples/design_nut.toml -o out/design

.. image:: /gallery/images/sphx_glr_plot_design_regimes_001.png
   :alt: Regimes of all parts. The same question by regime.
"""

# %%
# In Python:

import math

import vibro

scene = vibro.Scene(
    amplitude=1.5e-3,
    frequency=15,
    drive_angle=math.radians(20),
    static_friction=0.74,
    kinetic_friction=0.57,
)
vibro.guarantee(scene, static_friction=(0.7, 0.78), kinetic_friction=(0.5, 0.6))
