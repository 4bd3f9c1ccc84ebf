"""
Traverse time
=============

How long the part takes over the trough, 600 mm long in this scene file: length over mean speed. Light is
fast here too. Without a length there is no such picture; ``-L 400`` gives one. File:
``out/nut-traverse.png``.

.. code-block:: bash

    vibro map examples/safety_nut.toml -o out/nut
"""

import vibro

sweep = vibro.sweep(
    "../safety_nut.toml", amplitude_mm="0.1:3:301", frequency_hz="5:60:301"
)
figure = sweep.draw("traverse")
