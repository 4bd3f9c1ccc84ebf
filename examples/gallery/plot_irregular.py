"""
Irregular motion
================

Parts that bounce hardly ever repeat their motion: their speeds are means over many flights, with a
standard error that the table has. Faint stripes mark them. Squares are cells of the table, since a finer
picture would show scatter alone. File: ``out/bounce-speed.png``.

.. code-block:: bash

    vibro map examples/safety_nut.toml -A 1:6:30 -f 15:30:30 --restitution .5 -o out/bounce
"""

import vibro

sweep = vibro.sweep(
    "../safety_nut.toml", amplitude_mm="1:6:30", frequency_hz="15:30:30", restitution=0.5
)
figure = sweep.draw("speed")
cells = sweep.to_frame(["amplitude_mm", "frequency_hz", "status", "mean_velocity_mm_s"])
cells[cells["status"] == "averaged"].tail(3)
