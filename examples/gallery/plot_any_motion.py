"""
A motion that is no sine
========================

A slip-stick conveyor moves along itself alone, gently forward and sharply back, as the scene file gives
it in steps. The axes are the size of that motion and its frequency. Below the lower line parts stay
where they are on the trough; above the upper one they slide back too, and stronger motion no longer
helps. The command writes ``out/slip-speed.png``.

.. code-block:: bash

    vibro map examples/slip_stick.toml -o out/slip
"""

import vibro

sweep = vibro.sweep(
    "../slip_stick.toml", motion_scale="0.2:3:301", frequency_hz="1:5:301"
)
figure = sweep.draw("speed")
