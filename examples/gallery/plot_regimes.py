"""
Regimes
=======

What a part does over amplitude and frequency: it rests, slides forward only, slides forward and back, or
hops. Every line is a critical load of the drive. Beyond continuous sliding it never rests. The circle is
the operating point of the scene file, so its distance from the next line is the margin: here the part
stays in forward slip up to 1.19 mm. The command writes ``out/nut-regime.png``.

.. code-block:: bash

    vibro map examples/safety_nut.toml -o out/nut
"""

import vibro

sweep = vibro.sweep(
    "../safety_nut.toml", amplitude_mm="0.1:3:301", frequency_hz="5:60:301"
)
figure = sweep.draw("regime")
