"""Intervals of a scan of amplitudes whose speeds are known: ends, narrow dips and peaks, hard landings."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from helpers.scenes import scene_with

from vibro import solve
from vibro.designs.guarantees import Landings
from vibro.designs.spaces import uncertainty_set
from vibro.designs.windows import Family, _Detail, _Scan

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

FINE = _Detail(9, 2, 0.0, 33)


def family(drift: float = 0.0, landings: Landings | None = None, **bands: Any) -> Family:
    box = uncertainty_set(scene_with(), bands)
    made = Family(replace(box, factor=(1.0, 1.0)), drift)
    return made if landings is None else replace(made, landings=landings)


@dataclass(frozen=True)
class Known(_Scan):
    """A scan with a known speed of every amplitude."""

    speed: Callable[[Floats], Floats] = np.asarray
    changes: tuple[float, ...] = ()

    def _speeds(self, amplitudes: Floats) -> Floats:
        return np.asarray(self.speed(amplitudes))[:, None]

    def criticals(self) -> list[float]:
        return list(self.changes)


def scan(speed: Callable[[Floats], Floats], target: float, *changes: float) -> Known:
    return Known(family(), np.zeros((6, 1)), target, False, speed, changes)


def test_ends_of_parts_are_where_the_speed_crosses_the_target() -> None:
    """4 - (a - 3)^2 reaches 3 from 2 to 4."""
    known = scan(lambda a: 4.0 - (a - 3.0) ** 2, 3.0)
    (found,) = known.parts(1.0, 6.0, FINE)
    assert found == pytest.approx((2.0, 4.0, 2.0, 4.0), rel=1e-12)
    assert found.below < found.low < found.high < found.above
    assert 4.0 - (found.low - 3.0) ** 2 >= 3.0 <= 4.0 - (found.high - 3.0) ** 2
    (near,) = known.parts(1.0, 6.0, FINE._replace(end=0.1))
    assert 2.0 <= near.low <= 2.3
    assert 3.6 <= near.high <= 4.0


@pytest.mark.parametrize("centre", [3.3, 3.0, 2.71])
def test_a_narrow_dip_parts_an_interval(centre: float) -> None:
    """Between two amplitudes of the grid, below the target within 2 per mille of itself."""
    known = scan(lambda a: 0.999 + np.abs(a / centre - 1.0), 1.0)
    below, above = known.parts(1.0, 6.0, FINE)
    assert (below.high, above.low) == pytest.approx((0.999 * centre, 1.001 * centre), rel=1e-9)
    assert len(known.parts(1.0, 6.0, FINE._replace(rounds=0))) == 1


@pytest.mark.parametrize("centre", [3.3, 2.71, 1.61])
def test_a_narrow_peak_makes_an_interval(centre: float) -> None:
    known = scan(lambda a: 1.001 - np.abs(a / centre - 1.0), 1.0)
    (found,) = known.parts(1.0, 6.0, FINE)
    assert found[:2] == pytest.approx((0.999 * centre, 1.001 * centre), rel=1e-9)
    assert known.parts(1.0, 6.0, FINE._replace(rounds=0)) == []
    # where parts rest or run back no peak is looked at
    below = scan(lambda a: 1.001 - 30.0 * np.abs(a / centre - 1.0), 1.0)
    assert below.parts(1.0, 6.0, FINE._replace(amplitudes=5, rounds=1)) == []


def test_both_sides_of_a_change_are_looked_at() -> None:
    """From 3 on to 3.0001 the speed drops; a change outside of the range is left out."""
    known = scan(lambda a: np.where((a > 3.0) & (a < 3.0001), 0.5, 1.5), 1.0, 0.5, 3.0, 7.0)
    found = known.parts(1.0, 6.0, FINE._replace(rounds=0))
    assert [i[:2] for i in found] == [(1.0, pytest.approx(3.0)), (pytest.approx(3.0001), 6.0)]
    assert found[-1].high == 6.0


def test_bodies_that_land_too_hard_are_slowest() -> None:
    """Of two parts of the published example, thrown at 6 mm."""
    bodies = np.array([[0.0, 0.0], [0.0, 0.0], [0.0, 0.0], [0.0, 1.0], *[[0.0, 0.0]] * 2])
    hardest = float(solve(scene_with(amplitude=6e-3)).impact_velocity)
    bands: dict[str, Any] = {"static_friction": (0.6, 0.74)}
    for share, allowed in ((1.001, True), (0.999, False)):
        made = family(landings=Landings(impact_speed=share * hardest), **bands)
        speeds = _Scan(made, bodies, 0.01, True)._speeds(np.array([1e-3, 6e-3]))
        assert np.isfinite(speeds[0]).all()
        assert np.isfinite(speeds[1]).tolist() == [allowed, allowed]
    # parts in flight are not solved where none may hop
    assert np.isnan(_Scan(family(**bands), bodies, 0.01, False)._speeds(np.array([6e-3]))).all()


# Windows of designs
