"""
One curve for each value
========================

A list of up to twelve values beside a range makes a curve each: here two spring packs over what lies in
the trough. Above resonance (5 leaves, 47.6 Hz) a full feeder gets slower, below it (6 leaves, 52.6 Hz)
faster. Dots mark where a regime begins. File: ``out/full-speed.png``.

.. code-block:: bash

    vibro map examples/full_feeder.toml filling=0:4:501 -o out/full
"""

import vibro

sweep = vibro.sweep("../full_feeder.toml", filling_kg="0:4:501")
figure = sweep.draw("speed")
