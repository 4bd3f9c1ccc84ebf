"""
Forces and motion over time
===========================

A part over three cycles, from the top: the trough, the forces, and the motion relative to the trough. A
slide (blue) begins where the load reaches a limit of static friction (dashed) and ends where the
relative velocity is zero again. File: ``out/history.png``.

.. code-block:: bash

    vibro simulate examples/safety_nut.toml --cycles 3 -o out/history
"""

import vibro

history = vibro.simulate(vibro.read_scene("../safety_nut.toml"), cycles=3)
figure = history.draw()
print(history.sample([0.01, 0.02]).friction)  # N/kg
history.to_frame()[["phase", "start_s", "end_s"]]
