"""
Settings that meet a goal
=========================

Friction is known as a band, and every part has to make 30 mm/s without slipping back. Colours are the
speed of the slowest part at each setting, the dashed frame is what the drive can do, the bold outline
what meets the goal. The circle is the safest design. File: ``out/design-speed.png``.

.. code-block:: bash

    vibro design examples/design_nut.toml -o out/design
"""

import vibro

designs = vibro.design("../design_nut.toml", only="goal")
figure = designs.draw("speed")
