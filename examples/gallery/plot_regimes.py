"""
Regimes
=======

What a part does over amplitude and frequency: it rests, slides forward only, slides forward and back, or
hops. The circle is the operating point of the scene file, its distance from the next line the margin:
here forward slip lasts up to 1.19 mm. File: ``out/nut-regime.png``.

.. code-block:: bash

    vibro map examples/safety_nut.toml -o out/nut
"""

import vibro

sweep = vibro.sweep(
    "../safety_nut.toml", amplitude_mm="0.1:3:301", frequency_hz="5:60:301"
)
figure = sweep.draw("regime")
