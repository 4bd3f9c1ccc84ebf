"""
Regimes
=======

What the part does over amplitude and frequency: it rests, slips forward, slips forward and back, or hops.

.. code-block:: bash

    vibro map examples/safety_nut.toml -o out/nut
"""

import vibro

sweep = vibro.sweep("../safety_nut.toml")
sweep.draw("regime")
