"""
A band of friction
==================

Friction is seldom known, so give it an axis of its own. A setting is a vertical line: it promises the
slowest speed on that line within the band that you expect. The circle is today's phase of 0, the
triangle the fastest cell. File: ``out/bowl-speed.png``.

.. code-block:: bash

    vibro map examples/bowl_feeder.toml -o out/bowl
"""

import vibro

sweep = vibro.sweep(
    "../bowl_feeder.toml", normal_phase_deg="-180:180:301", static_friction="0.2:0.8:301"
)
figure = sweep.draw("speed")
