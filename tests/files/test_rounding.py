"""Numbers to significant digits, beside Python's own rounding."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from helpers.cases import each
from hypothesis import given
from hypothesis import strategies as st

from vibro.files.rounding import MOST_DIGITS, rounded

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

DIGITS = range(1, MOST_DIGITS + 1)


def assert_rounded(values: Floats, digits: int) -> None:
    """Compare bit by bit with what Python makes of the same numbers."""
    expected = np.array([float(format(x, f".{digits}g")) for x in values.tolist()])
    expected = np.where(np.isinf(expected), values, expected)  # beyond the range of doubles
    np.testing.assert_array_equal(rounded(values, digits).view(np.int64), expected.view(np.int64))


@each("digits", DIGITS)
def test_every_number_is_rounded_as_python_does(digits: int) -> None:
    random = np.random.default_rng(digits)
    bits = random.integers(0, 2**64, 3000, np.uint64).view(np.float64)
    usual = random.choice([-1.0, 1.0], 3000) * np.exp(random.uniform(-20.0, 20.0, 3000))
    powers = 10.0 ** np.arange(-30, 31)
    # a tie in the last digit, where it is a double, and its neighbours
    ties = random.integers(1, 10**digits, 1000) + 0.5
    ties = np.concatenate([ties, ties * powers[random.integers(0, 61, 1000)], 5.0 * powers, powers])
    assert_rounded(bits[~np.isnan(bits)], digits)
    assert_rounded(usual, digits)
    assert_rounded(np.concatenate([ties, np.nextafter(ties, 0.0), -np.nextafter(ties, np.inf)]), digits)


@given(st.lists(st.floats(allow_nan=False)), st.sampled_from(DIGITS))
def test_any_number_is(values: list[float], digits: int) -> None:
    assert_rounded(np.array(values, np.float64), digits)


def test_the_ends_of_the_range() -> None:
    most = np.finfo(np.float64).max
    np.testing.assert_array_equal(rounded(np.array([np.nan, np.inf, -np.inf]), 3), [np.nan, np.inf, -np.inf])
    np.testing.assert_array_equal(rounded(np.array([most, -most, 5e-324]), 3), [most, -most, 5e-324])
    assert np.signbit(rounded(np.array([-0.0]), 3)).all()
    assert rounded(np.array([[16.263456166287]]), 4).tolist() == [[16.26]]
