"""
Regimes of each value
=====================

The regimes of a list beside a range: a bar for each mains frequency, over the amplitude. Compare where a
regime begins: at 100 Hz parts move, slip back and hop at a quarter of the amplitudes of 50 Hz, since
loads grow with the square of the frequency. The command writes ``out/mains-regime.png``.

.. code-block:: bash

    vibro map -A 0.01:0.3 -f 50,100 -a 20 --mu-s .35 --mu-d .28 -o out/mains
"""

import vibro

sweep = vibro.sweep(
    amplitude_mm="0.01:0.3:1001",
    frequency_hz="50, 100",
    drive_angle_deg=20,
    static_friction=0.35,
    kinetic_friction=0.28,
)
figure = sweep.draw("regime")
