"""Dimensionless groups: the ends of their ranges."""

from __future__ import annotations

import numpy as np
import pytest
from scenes import scene_with
from vibro.core.contact.limits import critical_loads
from vibro.core.groups import cosine_of_sum

from vibro import Regime, Status, solve


@pytest.mark.parametrize(
    ("amplitude", "frequency", "regime"),
    [(5e-324, 1e-300, Regime.NO_SLIP), (1.7e308, 1e300, Regime.HOPPING)],
    ids=["1/G overflows", "1/G vanishes"],
)
def test_loads_beyond_the_range_of_doubles_still_have_a_regime(
    amplitude: float, frequency: float, regime: Regime
) -> None:
    # on an inclined trough inf - inf and 0 / 0 would appear
    cycle = solve(scene_with(amplitude=amplitude, frequency=frequency, trough_angle=-0.1), accuracy="regimes")
    assert cycle.regime == regime
    assert cycle.status == (Status.OK if regime == Regime.NO_SLIP else Status.FLIGHT_NOT_MODELLED)
    assert np.isfinite([cycle.throw_number, cycle.forward_ratio, cycle.back_ratio]).all()


def test_a_right_angle_has_no_cosine_though_its_double_has() -> None:
    drive = np.array([0.0, 0.3, 0.5, 1.2])
    right = 0.5 * np.pi - drive
    assert cosine_of_sum(drive, right).tolist() == [0.0] * 4
    assert (np.cos(drive + right) > 0.0).any()
    assert (cosine_of_sum(drive, np.nextafter(right, 0.0) - 1e-15) > 0.0).all()
    assert np.isnan(critical_loads(drive, 0.5, 0.4, right).forward_onset).all()
