"""Numbers with units: read exactly, converted once, refused by name."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vibro.errors import InputError
from vibro.quantities import QUANTITIES, exact_number, from_si, to_si


@pytest.mark.parametrize(
    ("name", "text", "expected"),
    [
        ("amplitude", "15", 15.0),
        ("amplitude", "1.2mm", 1.2),
        ("amplitude", "800um", 0.8),
        ("amplitude", "800\u00b5m", 0.8),
        ("amplitude", "800\u03bcm", 0.8),
        ("amplitude", " .5 MM ", 0.5),
        ("amplitude", "0.05in", 1.27),
        ("amplitude", "0.3cm", 3.0),
        ("amplitude", "1e-3m", 1.0),
        ("stroke", "2mm", 2.0),
        ("frequency", "900rpm", 15.0),
        ("frequency", "0.05kHz", 50.0),
        ("frequency", "15hz", 15.0),
        ("drive_angle", "20\u00b0", 20.0),
        ("drive_angle", "20 deg", 20.0),
        ("drive_angle", "0.35rad", math.degrees(0.35)),
        ("gravity", "9.81m/s^2", 9.81),
        ("gravity", "9.81 m/s\u00b2", 9.81),
        ("static_friction", "-0.74", -0.74),
        ("amplitude", "3.97", 3.97),
    ],
)
def test_a_number_is_read_in_the_default_unit(name: str, text: str, expected: float) -> None:
    assert float(exact_number(text, QUANTITIES[name])) == pytest.approx(expected, rel=2e-16)


@pytest.mark.parametrize(
    ("name", "text", "problem", "hint"),
    [
        ("amplitude", "3Hz", "'Hz' is no unit of amplitude", "its units are mm, um, \u00b5m, cm, m, in"),
        ("frequency", "3mm", "'mm' is no unit of frequency", "its units are Hz, kHz, rpm"),
        ("static_friction", "0.5mm", "'mm' is no unit of static friction", "it is a pure number"),
        ("drive_angle", "20grad", "'grad' is no unit of drive angle", "its units are deg, \u00b0, rad"),
        ("frequency", "nan", "frequency = nan: must be a finite number", ""),
        ("frequency", "-INF", "frequency = -INF: must be a finite number", ""),
        ("frequency", "1e999", "must be a finite number", ""),
        ("frequency", "1e99999999999", "must be a finite number", ""),
        ("amplitude", "1e308m", "must be a finite number", ""),
        ("frequency", "", "not a number", "write it like 1.5Hz"),
        ("amplitude", "1.2.3", "not a number", "write it like 1.5mm"),
        ("amplitude", "1,2", "not a number", "write a decimal point: 1.2"),
        ("static_friction", "abc", "not a number", "write it like 0.5"),
        ("amplitude", "1_000", "not a number", "write it like 1.5mm"),
    ],
)
def test_a_wrong_number_names_the_quantity_and_the_remedy(
    name: str, text: str, problem: str, hint: str
) -> None:
    with pytest.raises(InputError) as caught:
        exact_number(text, QUANTITIES[name])
    assert problem in str(caught.value)
    assert QUANTITIES[name].label in str(caught.value)
    assert caught.value.hint == hint


def test_tiny_exponents_do_not_explode() -> None:
    assert exact_number("1e-99999999999", QUANTITIES["amplitude"]) == 0


@pytest.mark.parametrize("name", QUANTITIES)
def test_conversions_are_inverse(name: str) -> None:
    values = np.array([0.1, 1.0, 44.5])
    np.testing.assert_allclose(from_si(name, to_si(name, values)), values, rtol=4e-16)


def test_si_values() -> None:
    assert to_si("amplitude", 3.97) == 3.97 / 1000
    assert to_si("drive_angle", 20.0) == math.radians(20)
    assert to_si("frequency", 15.0) == 15.0
    assert to_si("trough_length", 600.0) == 0.6
