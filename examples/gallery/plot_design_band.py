"""
Speed of all parts
==================

At the frequency and the angle of the chosen design: the slowest and the fastest part over the amplitude,
with the nominal part (in the middle of the bands) between them. The grey window keeps the goal. File:
``out/design-band.png``.

.. code-block:: bash

    vibro design examples/design_nut.toml -o out/design
"""

import vibro

designs = vibro.design("../design_nut.toml", only="goal")
figure = designs.draw("band")
