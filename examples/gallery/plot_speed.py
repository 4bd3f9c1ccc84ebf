"""
Mean conveying speed
====================

How fast the same part goes, on a logarithmic scale. Labelled contours join settings of equal speed:
follow one to trade amplitude for frequency. They stop where motion does not repeat with the drive. The
triangle marks the fastest cell. File: ``out/nut-speed.png``.

.. code-block:: bash

    vibro map examples/safety_nut.toml -A 0.1:3:301 -f 5:60:301 -o out/nut
"""

import vibro

sweep = vibro.sweep(
    "../safety_nut.toml", amplitude_mm="0.1:3:301", frequency_hz="5:60:301"
)
figure = sweep.draw("speed")
