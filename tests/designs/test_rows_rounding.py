"""Rounding of settings: to digits or decimals, never beyond a range, up or down in steps of a digit."""

from __future__ import annotations

import math

import pytest

from vibro.designs.questions import Drive, Input
from vibro.designs.rows import moved, roundings, setting_of
from vibro.designs.spaces import SPACES, Setting
from vibro.drives import Line


@pytest.mark.parametrize(
    ("value", "digits", "expected"),
    [(1.23456, 3, 1.23), (1.99, 3, 1.99), (2.5, 3, 2.0), (0.4, 3, 1.0), (1.9996, 4, 2.0)],
)
def test_a_rounded_amplitude_stays_within_its_range(value: float, digits: int, expected: float) -> None:
    assert Input("amplitude", ((1e-3, 2e-3),)).rounded(value, 1e-3, digits) == expected


def test_an_end_of_a_range_keeps_fifteen_digits() -> None:
    two = Input("frequency", ((10.0, 58.0 / 3.0), (28.0, 30.0)))
    assert two.rounded(25.0, 20.0, 9) == 19.3333333333333
    assert two.rounded(25.0, 26.0, 9) == 28.0


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("drive_angle", 0.0123456789012, 0.0123456789),  # never negative: nine digits
        ("normal_phase", -64.1234567891, -64.1234568),  # may be 0: seven decimals
        ("normal_phase", -1.23456789012, -1.2345679),
        ("normal_phase", 2e-9, 0.0),
    ],
)
def test_an_angle_that_may_be_zero_is_rounded_to_decimals(name: str, value: float, expected: float) -> None:
    assert Input(name, ((-0.5 * math.pi, 0.5 * math.pi),)).rounded(value, 0.0, 9) == expected


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


def drive(*, in_stroke: bool = False, **choices: tuple[float, float]) -> Drive:
    spans = {"amplitude": (0.0, 3e-3), "frequency": (10.0, 58.0 / 3.0), "drive_angle": (0.1, 0.7)} | choices
    return Drive("motor", Line, {knob: (span,) for knob, span in spans.items()}, in_stroke=in_stroke)


def line(amplitude: float, frequency: float = 15.0, drive_angle: float = 0.35) -> Setting:
    return SPACES[Line].setting(amplitude=amplitude, frequency=frequency, drive_angle=drive_angle)


@pytest.mark.parametrize("digits", [4, 6, 9])
@pytest.mark.parametrize("up", [True, False])
@pytest.mark.parametrize("in_stroke", [True, False])
def test_one_unit_of_the_last_digit_is_a_small_share_of_every_knob(
    digits: int, up: bool, in_stroke: bool
) -> None:
    own = drive(in_stroke=in_stroke)
    found = [*roundings(own, line(1.23456789e-3, 14.87654321, 0.3123456789), digits, up=up)]
    assert len(set(found)) == len(found)
    for printed in found:
        for value in printed:
            assert float(f"{value:.{digits}g}") == value
        setting = setting_of(own, printed)
        size, frequency, angle = SPACES[Line].turned(setting).values()
        near = 5 * 10.0 ** (1 - digits)
        assert size == pytest.approx(1.23456789e-3, rel=2 * near)
        assert frequency == pytest.approx(14.87654321, rel=near)
        assert angle == pytest.approx(0.3123456789, rel=near)
        load = size * frequency**2 / (1.23456789e-3 * 14.87654321**2)
        inwards = load - 1.0 if up else 1.0 - load
        assert -near < inwards < near


def test_a_stroke_has_few_digits_itself() -> None:
    """Not the amplitude: half of a stroke may have a digit more."""
    printed = next(roundings(drive(in_stroke=True), line(1.23456e-3), 4, up=False))
    assert printed == (2.47, 15.0, 20.05)
    assert SPACES[Line].amplitude(setting_of(drive(in_stroke=True), printed)) == pytest.approx(1.235e-3)


def test_what_the_user_gave_keeps_its_digits() -> None:
    """A single value, and an end of a range at which the optimum is."""
    at_end = drive(frequency=(10.0, 58.0 / 3.0))
    beside, below = (
        next(roundings(at_end, line(3e-3, 58.0 / 3.0 * (1.0 - short)), 4, up=False))
        for short in (1e-12, 1e-8)
    )
    assert beside[:2] == (3.0, 19.3333333333333)
    assert below[1] == 19.33
    fixed = drive(frequency=(58.0 / 3.0,) * 2)
    assert {printed[1] for printed in roundings(fixed, line(1e-3, 58.0 / 3.0), 4, up=True)} == {
        19.3333333333333
    }
