"""
Parts that move backwards
=========================

On a climbing track a part may slide back farther than forward. The scale then has two colours and its
middle at zero; hatches mark what moves backwards. This track may climb 7 deg. Triangles mark the fastest
point each way. File: ``out/climb-speed.png``.

.. code-block:: bash

    vibro map examples/climbing_track.toml -o out/climb
"""

import vibro

sweep = vibro.sweep(
    "../climbing_track.toml", amplitude_mm="0.02:0.22:301", trough_angle_deg="-5:20:301"
)
figure = sweep.draw("speed")
