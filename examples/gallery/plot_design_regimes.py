"""
Regimes of all parts
====================

The same question by regime. Where colours are hatched, parts differ: the one with the lowest friction
slips already, the one with the highest still rests. File: ``out/design-regime.png``.

.. code-block:: bash

    vibro design examples/design_nut.toml -o out/design
"""

import vibro

designs = vibro.design("../design_nut.toml", only="goal")
figure = designs.draw("regime")
