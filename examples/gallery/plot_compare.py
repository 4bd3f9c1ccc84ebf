"""
A record beside the model
=========================

Signals of a record (dots) beside the exact steady motion of the scene (lines). On the right all cycles
are laid on one. This record is a simulation with smoothed friction: it moves where the part should rest,
and its peak speed is too low. File: ``out/compare.png``; in Python ``rows`` has the numbers, in
SI units.

.. code-block:: bash

    vibro measure examples/safety_nut.toml examples/data/nut_smoothed_600hz.csv -o out/compare
"""

import vibro

nut = vibro.read_scene("../safety_nut.toml")
comparison = vibro.compare(nut, "../data/nut_smoothed_600hz.csv")
for row in comparison.rows[:2]:
    print(f"{row.key}: {row.measured.value:.6f}, computed {row.computed:.6f}")
figure = comparison.draw()
