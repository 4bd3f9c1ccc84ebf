"""Fields on a small grid: where numbers are smooth, and lines that end where something hides them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from vibro.axes import Axis
from vibro.core.codes import Regime
from vibro.plots.fields import Fields
from vibro.plots.view import Panel

if TYPE_CHECKING:
    from numpy.typing import NDArray

SIZE = 61


def fields(**cycle: NDArray[Any]) -> Fields:
    x, y = (Axis(name, np.linspace(1.0, 2.0, SIZE), "linear") for name in ("drive_angle", "trough_angle"))
    return Fields(Panel(x, y, {}, None, cycle, {}))


def rough(*points: tuple[int, int], period: float = 5.0) -> NDArray[np.bool_]:
    """Where contours are left out if the motion takes so many cycles at some points."""
    periods = np.ones((SIZE, SIZE))
    for point in points:
        periods[point] = period
    return np.asarray(fields(mean_velocity=np.ones((SIZE, SIZE)), period_cycles=periods).regular < 0.0)


def test_contours_keep_off_a_point_of_longer_period() -> None:
    expected = np.zeros((SIZE, SIZE), np.bool_)
    expected[28:33, 18:23] = True
    np.testing.assert_array_equal(rough((30, 20)), expected)
    assert not rough((30, 20), period=4.0).any()  # contours do not end in the middle of smooth numbers


@pytest.mark.parametrize(("distance", "joined"), [(20, True), (22, False)])
def test_contours_do_not_pass_between_such_points(distance: int, joined: bool) -> None:
    row = rough((30, 20), (30, 20 + distance))[30, 20 : 20 + distance]
    assert row.all() == joined


@pytest.mark.parametrize(("errors", "sure"), [(2.9, False), (3.1, True)])
def test_a_mean_is_negative_from_three_standard_errors_on(errors: float, sure: bool) -> None:
    whole = {"mean_velocity": -1.0, "mean_velocity_error": 1.0 / errors, "period_cycles": np.nan}
    hops = {"forward_ratio": 2.0, "throw_number": 2.0, "regime": Regime.HOPPING}
    cells = {name: np.full((SIZE, SIZE), value) for name, value in {**whole, **hops}.items()}
    assert fields(**cells).reverses is sure
