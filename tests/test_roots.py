"""Closing in on changes of sign: smooth ones, jumps, and roots of every order."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vibro.roots import close_in, sign_changes

EPS = float(np.finfo(np.float64).eps)


@given(st.lists(st.floats(0.01, 0.99), min_size=1, max_size=5), st.integers(0, 4))
def test_brackets_close_around_every_kind_of_change(roots: list[float], kind: int) -> None:
    at = np.array(roots)
    calls = []

    def residual(index: np.ndarray, x: np.ndarray) -> np.ndarray:
        calls.append(x.size)
        away = x - at[index]
        sign = np.where(away >= 0.0, 1.0, -1.0)
        return np.asarray(
            [away, np.expm1(20.0 * away), away**3, sign * (1.0 + np.abs(away)), sign * np.abs(away) ** 0.1][
                kind
            ]
        )

    ends = np.zeros(at.shape), np.ones(at.shape)
    index = np.arange(at.size)
    values = residual(index, ends[0]), residual(index, ends[1])
    low, high, at_low, at_high = sign_changes(residual, *ends, values)
    assert np.all((low <= at) & (at <= high))
    zero = (at_low == 0.0) | (at_high == 0.0)
    assert np.all(zero | (high - low <= 4.0 * EPS * high + 1e-300))
    assert np.all((at_low <= 0.0) & (at_high >= 0.0))
    assert len(calls) < 2 + (14 if kind < 2 else 120)
    if kind == 3:
        assert np.all(at_high - at_low >= 2.0)


@pytest.mark.parametrize("sections", [1, 3])
def test_what_holds_by_nothing_holds(sections: int) -> None:
    inside, outside = close_in(lambda x: np.where(x <= 0.3, 0.0, -1.0), 0.0, 1.0, sections=sections)
    assert float(inside) == 0.3
    assert float(outside) == np.nextafter(0.3, 1.0)


def test_brackets_do_not_depend_on_each_other() -> None:
    at = np.linspace(0.1, 0.9, 7)

    def residual(index: np.ndarray, x: np.ndarray) -> np.ndarray:
        return np.asarray(np.tanh(3.0 * (x - at[index])) + 0.1 * (x - at[index]))

    index = np.arange(7)
    ends = np.zeros(7), np.ones(7)
    found = sign_changes(residual, *ends, (residual(index, ends[0]), residual(index, ends[1])))
    for i in range(7):

        def alone(k: np.ndarray, x: np.ndarray, i: int = i) -> np.ndarray:
            return residual(k + i, x)

        low, high = (x[:1] for x in ends)
        one = sign_changes(alone, low, high, (alone(index[:1], low), alone(index[:1], high)))
        assert [x[0] for x in one] == [x[i] for x in found]


@pytest.mark.parametrize("end", [0, 1])
def test_an_end_that_is_a_root_stays(end: int) -> None:
    ends = np.zeros(1), np.ones(1)
    values = (np.array([0.0 if end == 0 else -1.0]), np.array([1.0 if end == 0 else 0.0]))

    def never(index: np.ndarray, x: np.ndarray) -> np.ndarray:
        raise AssertionError

    low, high, *_ = sign_changes(never, *ends, values)
    assert (low[0], high[0]) == (0.0, 1.0)
