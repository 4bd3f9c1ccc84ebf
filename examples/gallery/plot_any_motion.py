"""
A motion that is no sine
========================

A slip-stick conveyor moves along itself alone, gently forward and sharply back, in steps that the scene
file gives. Below the lower line parts stay where they are; above the upper one they slide back too, and
stronger motion no longer helps. File: ``out/slip-speed.png``.

.. code-block:: bash

    vibro map examples/slip_stick.toml -o out/slip
"""

import vibro

sweep = vibro.sweep(
    "../slip_stick.toml", motion_scale="0.2:3:301", frequency_hz="1:5:301"
)
figure = sweep.draw("speed")
