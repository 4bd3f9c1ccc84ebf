"""Rounding of settings: to digits or decimals, never beyond a range, up or down in steps of a digit."""

from __future__ import annotations

import math

import pytest

from vibro.inverse.rounding import moved, nearest, rounded, within


@pytest.mark.parametrize(
    ("value", "digits", "expected"),
    [(1.23456, 3, 1.23), (1.99, 3, 1.99), (2.5, 3, 2.0), (0.4, 3, 1.0), (1.9996, 4, 2.0)],
)
def test_a_rounded_amplitude_stays_within_its_range(value: float, digits: int, expected: float) -> None:
    assert within(value, "amplitude", (1e-3, 2e-3), digits) == expected


def test_an_end_of_a_range_keeps_fifteen_digits() -> None:
    assert within(25.0, "frequency", (10.0, 58.0 / 3.0), 9) == 19.3333333333333
    assert within(5.0, "frequency", (58.0 / 3.0, 30.0), 9) == 19.3333333333333


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("drive_angle", 0.0123456789012, 0.0123456789),  # never negative: nine digits
        ("normal_phase", -64.1234567891, -64.123457),  # may be 0: six decimals
        ("normal_phase", 2e-9, 0.0),
    ],
)
def test_an_angle_that_may_be_zero_is_rounded_to_decimals(name: str, value: float, expected: float) -> None:
    assert within(value, name, (-0.5 * math.pi, 0.5 * math.pi), 9) == expected


@pytest.mark.parametrize(
    ("value", "below", "above"), [(1.2345, 1.23, 1.24), (1.23, 1.23, 1.23), (98765.0, 98700.0, 98800.0)]
)
def test_rounding_has_one_direction(value: float, below: float, above: float) -> None:
    assert rounded(value, 3, down=True) == below
    assert rounded(value, 3, down=False) == above
    assert nearest(1.2351, 3) == 1.24


@pytest.mark.parametrize(
    ("value", "steps", "up", "expected"),
    [
        (1.2345, 0, True, 1.24), (1.2345, 0, False, 1.23), (1.2345, 2, True, 1.26),
        (1.2345, -1, True, 1.23), (1.2345, -3, False, 1.20), (1.2345, 1, False, 1.24),
        (98765.0, 1, True, 98900.0), (0.0456789, -1, False, 0.0455), (9.996, 0, True, 10.0),
    ],
)  # fmt: skip
def test_values_move_by_steps_of_their_last_digit(
    value: float, steps: int, up: bool, expected: float
) -> None:
    assert moved(value, 3, steps, up=up) == pytest.approx(expected, rel=1e-13)


def test_zero_has_no_last_digit_to_move_by() -> None:
    assert moved(0.0, 9, 3, up=True) == 0.0
