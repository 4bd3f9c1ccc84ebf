"""
Both frictions
==============

One drive, and parts of every friction. The hatched half cannot be, as kinetic friction is never above
static friction. Right of the back-slip onset parts slip forward alone and are fast; left of it they
slide back too. ``--speed`` adds the red line, and the command prints the share of the cells that reach
it. File: ``out/frictions-speed.png``.

.. code-block:: bash

    vibro map examples/friction_grid.toml --speed 20 -o out/frictions
"""

import vibro

sweep = vibro.sweep(
    "../friction_grid.toml", static_friction="0.2:1:301", kinetic_friction="0.2:1:301"
)
figure = sweep.draw("speed", target_speed=20)
