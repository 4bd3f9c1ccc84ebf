"""The axis syntax: what it accepts, exactly which values it gives, and what it refuses."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from helpers.cases import each

from vibro.axes import MAX_VALUES, axis_of, parse_axis
from vibro.errors import InputError
from vibro.quantities import QUANTITIES


def values_of(text: str, name: str = "amplitude", count: int = 5) -> list[float]:
    return list(map(float, parse_axis(text, QUANTITIES[name]).axis(count).values))


@each(
    ("text", "expected"),
    [
        ("15,20,25", [15.0, 20.0, 25.0]),
        ("0.0,74", [0.0, 74.0]),
        ("0.1:0.5", [0.1, 0.2, 0.3, 0.4, 0.5]),
        ("0.1:0.4:4", [0.1, 0.2, 0.3, 0.4]),
        ("0.1:0.45:step=0.1", [0.1, 0.2, 0.3, 0.4]),
        ("0.1:0.4:step=0.1", [0.1, 0.2, 0.3, 0.4]),
        ("1:10000:log", [1.0, 10.0, 100.0, 1000.0, 10000.0]),
        ("5:80:step=2:log", [5.0, 10.0, 20.0, 40.0, 80.0]),
        ("5:79:step=2:LOG", [5.0, 10.0, 20.0, 40.0]),
        ("800um:1.2mm:3", [0.8, 1.0, 1.2]),
        ("-5:5:3", [-5.0, 0.0, 5.0]),
    ],
)
def test_values_are_the_nearest_doubles(text: str, expected: list[float]) -> None:
    assert values_of(text) == expected


def test_a_fine_range_accumulates_no_error() -> None:
    assert values_of("0.001:10:10000") == [i / 1000 for i in range(1, 10001)]


@each(
    ("text", "count"),
    [
        ("1:2:2", 2),
        ("1:2:step=2:log", 2),
        (f"1:2:{MAX_VALUES}", MAX_VALUES),
        (f"0:{MAX_VALUES - 1}:step=1", MAX_VALUES),
    ],
)
def test_the_fewest_and_the_most_values_of_a_range_are_allowed(text: str, count: int) -> None:
    assert parse_axis(text, QUANTITIES["amplitude"]).count == count


@each(
    "text",
    [
        "1e-300:1e300:7:log",
        "1e-300:1e300:step=10:log",
        "0.12345678901234567:1.7976931348623157e308:5:log",
        "-1e308:1e308:5",
        "1e-320:1e-310:3",
    ],
)
def test_extreme_ranges_are_spelled_out(text: str) -> None:
    values = values_of(text)
    assert values[0] == float(text.split(":")[0])
    assert values[-1] == pytest.approx(float(text.split(":")[1]), rel=1e-14)
    assert values == sorted(set(values))


@each(
    ("value", "expected"),
    [
        ([0.1, 0.2, 0.30000000000000004], [0.1, 0.2, 0.30000000000000004]),
        ([1, 1.5, "2mm", "0.3cm"], [1.0, 1.5, 2.0, 3.0]),
        ([2**53 + 1, 2**70], [2.0**53, 2.0**70]),
        (0.1, [0.1]),
    ],
)
def test_a_list_holds_the_nearest_doubles(value: object, expected: list[float]) -> None:
    spec = axis_of(value, QUANTITIES["amplitude"])
    assert spec.axis(5).values.tolist() == expected
    assert spec.halved(QUANTITIES["amplitude"]).axis(5).values.tolist() == [v / 2 for v in expected]


def test_a_list_has_no_more_values_than_a_range(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vibro.axes.MAX_VALUES", 3)
    four: list[Any] = [[1, 2, 3, 4], np.arange(1.0, 5.0), range(1, 5), "1,2,3,4", ["1", 2, 3, 4]]
    for value in four:
        with pytest.raises(InputError, match="more than 3 values"):
            axis_of(value, QUANTITIES["amplitude"])
    assert len(axis_of([1, 2, 3], QUANTITIES["amplitude"]).values) == 3


def test_numbers_of_a_list_are_not_read_as_texts(monkeypatch: pytest.MonkeyPatch) -> None:
    """Exact fractions take a hundred times as long: a list of a million numbers took a minute."""

    def read(*_: object) -> float:
        raise AssertionError

    monkeypatch.setattr("vibro.axes.exact_number", read)
    assert len(axis_of([i / 7 for i in range(1, 1000)], QUANTITIES["amplitude"]).values) == 999
    assert len(axis_of(list(range(1, 1000)), QUANTITIES["amplitude"]).values) == 999


def test_a_decimal_of_hundreds_of_digits_is_a_number() -> None:
    third = "0." + "3" * 400
    assert parse_axis(third, QUANTITIES["amplitude"]).value == 1 / 3
    assert values_of(f"{third}:1:3") == [1 / 3, 2 / 3, 1.0]
    assert values_of(f"{third}um,{third}") == [1 / 3000, 1 / 3]


@each("given", [-0.0, [-0.0, 1.0], np.array([-0.0, 1.0]), "-0.0", "-0.0,1", "-0:1:2"])
def test_zero_has_no_sign(given: object) -> None:
    spec = axis_of(given, QUANTITIES["trough_angle"])
    assert str(float(spec.values[0])) == "0.0"
    assert str(spec.axis(2).values[0] if spec.varies else spec.value) == "0.0"
