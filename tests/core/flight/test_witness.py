"""A second witness of hopping: motion that SciPy integrates settles into the cycle."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hopping import hopping_cycles, loads_at_throw
from integrated import Body
from scenes import Groups

from vibro import Status

TURN = 2.0 * math.pi


@pytest.mark.parametrize(
    ("throw", "drive_deg", "mu_s", "mu_d", "e", "period"),
    [
        (1.6, 30.0, 0.5, 0.4, 0.0, 1),
        (2.3, 20.0, 0.74, 0.57, 0.0, 1),
        (2.9, 35.0, 0.3, 0.25, 0.0, 1),
        (4.4, 25.0, 0.6, 0.45, 0.0, 2),
        (1.3, 30.0, 0.5, 0.4, 0.3, 1),
        (1.7, 20.0, 0.74, 0.57, 0.3, 1),
        (2.2, 30.0, 0.5, 0.4, 0.3, 2),
    ],
)
def test_integrated_motion_settles_into_the_cycle(
    throw: float, drive_deg: float, mu_s: float, mu_d: float, e: float, period: int
) -> None:
    scene = loads_at_throw([throw], drive_deg, mu_s, mu_d)
    cycle = hopping_cycles(scene, np.array([e]))
    assert cycle.status[0] == Status.OK
    assert cycle.period[0] == period
    body = Body(Groups(throw / math.sin(math.radians(drive_deg)), drive_deg, mu_s, mu_d), e)
    settled = 30.0 * TURN
    body.until(settled)
    before = body.state[0]
    body.until(settled + TURN * period)
    assert (body.state[0] - before) / period == pytest.approx(
        cycle.displacement[0], rel=1e-9 if e == 0.0 else 1e-6
    )
