"""Numerical searches on functions whose answers are known in closed form."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vibro.designs.search import close_in, evolve, scatter, sobol

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]


@given(st.floats(1e-6, 1e6), st.floats(1e-3, 1e3), st.sampled_from([1, 4, 33]), st.booleans())
def test_a_change_is_found_between_neighbouring_doubles(
    at: float, width: float, sections: int, rises: bool
) -> None:
    ends = max(at - width, 0.5 * at), at + width
    inside, outside = (ends[1], ends[0]) if rises else ends
    side = 1.0 if rises else -1.0
    holding, failing = close_in(lambda x: side * (x - at), inside, outside, sections=sections)
    assert abs(holding - failing) == pytest.approx(math.ulp(at), rel=1.0)
    assert side * (holding - at) >= 0.0 > side * (failing - at)


@given(st.floats(-5.0, 5.0), st.sampled_from([1, 9]))
def test_widths_end_a_search(at: float, sections: int) -> None:
    def residual(x: Floats) -> Floats:
        return at - x

    inside, outside = np.array([-6.0, -5.5]), np.array([6.0, 7.0])
    low, high = close_in(residual, inside, outside, absolute=1e-3, sections=sections)
    assert np.all((low <= at) & (at < high))
    assert np.all(high - low <= 1e-3)
    assert np.all(high - low > 1e-3 / (4 * (sections + 1)))  # it does no more than it was asked for
    low, high = close_in(residual, inside, outside, relative=1e-3, absolute=1e-9, sections=sections)
    assert np.all(high - low <= 1e-3 * np.abs(low) + 1e-9)


@pytest.mark.parametrize("corner", [(0.0, 1.0), (1.0, 1.0), (0.3, 0.0)])
def test_minima_on_faces_are_found_exactly(corner: tuple[float, float]) -> None:
    at = np.array(corner)[:, None]

    def cost(x: Floats) -> Floats:
        return np.asarray(np.abs(x - at).sum(axis=0))

    point, least = evolve(cost, sobol(2, 5, 0), generations=300, seed=1)
    assert point[:, 0] == pytest.approx(corner, abs=1e-9)
    assert [x for x in point[:, 0] if x in (0.0, 1.0)] == [x for x in corner if x in (0.0, 1.0)]
    assert least == pytest.approx(0.0, abs=1e-9)
    around, near = scatter(cost, sobol(2, 6, 0), more=64, rounds=4, seed=1)
    assert near == pytest.approx(float(cost(around)[0]))
    assert near < 0.05


def test_points_that_do_not_count_are_no_minima() -> None:
    def cost(x: Floats) -> Floats:
        return np.where(x[0] < 0.5, np.nan, x[0])

    point, least = evolve(cost, sobol(1, 4, 0), generations=200, seed=0)
    assert least == pytest.approx(0.5, abs=1e-9) == point[0, 0]
    _, near = scatter(cost, sobol(1, 4, 0), more=32, rounds=3, seed=0)
    assert 0.5 <= near < 0.51
    assert math.isnan(
        scatter(lambda x: np.full(x.shape[1], np.nan), sobol(1, 3, 0), more=8, rounds=2, seed=0)[1]
    )


@pytest.mark.parametrize("sections", [1, 3])
def test_what_holds_by_nothing_holds(sections: int) -> None:
    inside, outside = close_in(lambda x: np.where(x <= 0.3, 0.0, -1.0), 0.0, 1.0, sections=sections)
    assert float(inside) == 0.3
    assert float(outside) == np.nextafter(0.3, 1.0)
