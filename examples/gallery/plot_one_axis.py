"""
One axis
========

A feeder at mains frequency has one knob, the amplitude. The strip on top names the regimes, vertical
lines are where they begin: parts hop from 0.29 mm on. File: ``out/feeder-speed.png``.

.. code-block:: bash

    vibro map examples/mains_feeder.toml -o out/feeder
"""

import vibro

sweep = vibro.sweep("../mains_feeder.toml", amplitude_mm="0.01:0.3:4001")
figure = sweep.draw("speed")
