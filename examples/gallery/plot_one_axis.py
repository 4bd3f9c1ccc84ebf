"""
One axis
========

A feeder at mains frequency has one knob, the amplitude. The speed lies over bands of the regimes, which
the strip on top names. Vertical lines are critical loads, and the legend gives their amplitudes: parts
begin to hop at 0.29 mm. The command writes
``out/feeder-speed.png``.

.. code-block:: bash

    vibro map examples/mains_feeder.toml -o out/feeder
"""

import vibro

sweep = vibro.sweep("../mains_feeder.toml", amplitude_mm="0.01:0.3:4001")
figure = sweep.draw("speed")
