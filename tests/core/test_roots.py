"""Zeros by halving, by false position and by Newton's iteration, and where they give up."""

from __future__ import annotations

import math

import pytest

from vibro.core.numbers import EPS, INF, Value, bisected, illinois, newton


def cube(of: float, x: float) -> float:
    return x * x * x - of


def minus_cube(of: float, x: float) -> float:
    return of - x * x * x


def falling_square(of: float, x: float) -> Value:
    """Fall from ``of``: convex where x is negative."""
    return Value(x * x - of, 2.0 * x)


@pytest.mark.parametrize("root", [1e-3, 0.7, 1.0, 3.0])
def test_an_interval_is_halved_down_to_neighbouring_doubles(root: float) -> None:
    of = root**3
    for function, positive in ((cube, False), (minus_cube, True)):
        found = bisected(function, of, 0.0, 4.0, positive)
        assert (function(of, found) > 0.0) != positive
        before = found - max(2.0 * math.ulp(found), 4.0 * 2.0**-59)
        assert (function(of, before) > 0.0) == positive


def test_a_bracket_without_a_zero_ends_at_its_end_or_its_start() -> None:
    assert bisected(minus_cube, 100.0, 0.0, 4.0, True) == 4.0
    assert bisected(minus_cube, -1.0, 1.0, 4.0, True) == pytest.approx(1.0, rel=4.0 * EPS)


@pytest.mark.parametrize("root", [1e-3, 0.7, 1.0, 3.99])
def test_false_position_finds_a_zero_to_rounding(root: float) -> None:
    seen = []

    def watched(of: float, x: float) -> float:
        seen.append(x)
        return cube(of, x)

    of = root**3
    found = illinois(watched, of, 0.0, 4.0, cube(of, 0.0), cube(of, 4.0))
    assert found == pytest.approx(root, rel=8.0 * EPS)
    assert len(seen) < 80  # without halved weights the end at 4 stays, and thousands are needed


def test_newton_falls_to_a_zero_from_one_side() -> None:
    found = newton(falling_square, 2.0, -4.0, INF, 1e-8, 0.0)
    assert found.found
    assert found.at == pytest.approx(-math.sqrt(2.0), rel=1e-15)
    assert newton(falling_square, 2.0, -4.0, INF, 0.0, 1e-13).at == pytest.approx(found.at, rel=1e-15)


def test_newton_tells_where_there_is_no_zero() -> None:
    assert not newton(falling_square, -1.0, -4.0, INF, 0.0, 1e-13).found  # it turns round before
    assert not newton(falling_square, 2.0, -4.0, -1.5, 0.0, 1e-13).found  # not before the end
    assert newton(falling_square, 2.0, 1.0, INF, 0.0, 1e-13) == (1.0, False)  # it never falls
