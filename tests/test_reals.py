"""What becomes a double, and what only looks as if it could."""

from __future__ import annotations

import datetime
import math
from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from typing import Any

import numpy as np
import pandas as pd
import pytest
from helpers.cases import each
from helpers.scenes import scene_with

import vibro
from vibro.drives import Line
from vibro.errors import InputError, SceneError, VibroError
from vibro.quantities import BY_COLUMN, QUANTITIES
from vibro.reals import NotRealError, real_array, real_number

NUMBERS: list[tuple[Any, Any]] = [
    (1, 1.0),
    (Decimal("0.1"), 0.1),
    (Fraction(1, 3), 1 / 3),
    ([1, 2.5, Fraction(1, 2), Decimal(3)], [1.0, 2.5, 0.5, 3.0]),
    (((1, 2), [3, 4]), [[1.0, 2.0], [3.0, 4.0]]),
    ([np.array([1, 2]), (3, 4)], [[1.0, 2.0], [3.0, 4.0]]),
    (np.array([1, 2], dtype=object), [1.0, 2.0]),
    (np.array([2**63], np.uint64), [2.0**63]),
    (np.ma.array([1.0, 2.0], mask=[False, False]), [1.0, 2.0]),
    (pd.Series([1, 2], dtype="Int64"), [1.0, 2.0]),
    (pd.Series([1.5, None]), [1.5, math.nan]),
    (Decimal("1e400"), math.inf),
    (np.longdouble(np.finfo(np.float64).max) * 4, math.inf),
]


@each(("value", "expected"), NUMBERS)
def test_numbers_of_every_kind_become_new_doubles(value: Any, expected: Any) -> None:
    array = real_array(value)
    assert array.dtype == np.float64
    assert array.flags.writeable
    assert array is not value
    np.testing.assert_array_equal(array, expected)


ENDLESS: list[Any] = []
ENDLESS.append(ENDLESS)
NO_NUMBERS: list[tuple[Any, str]] = [
    ("1", "'1'"),
    (bytearray(b"12"), "bytearray"),
    (np.array(["1.5"]), "'1.5'"),
    ([1.0, None], "None"),
    (True, "True"),
    (np.array([1, True], dtype=object), "True"),
    (1 + 2j, "(1+2j)"),
    ([1.0, np.ma.masked], "masked"),
    (np.ma.array([[1, 2], [3, 4]], mask=[[False, False], [True, False]]), "masked (index 1, 0)"),
    (np.array(["2020-01-01"], "M8[ns]"), "2020-01-01"),
    ([np.timedelta64(5, "D")], "timedelta64(5,'D')"),
    (datetime.timedelta(1), "datetime.timedelta"),
    (pd.Timestamp("2020"), "Timestamp"),
    (pd.Series(pd.to_datetime(["2020"], utc=True)), "Timestamp"),
    ([1.0, pd.NA], "<NA>"),
    ([1.0, -(10**5000)], "a whole number of about 5001 digits"),
    (np.array([10**400]), "a whole number of about 401 digits"),
    (Fraction(10**400), "Fraction(1000"),
    (Decimal("sNaN"), "sNaN"),
    ([1, [2]], "[1, [2]]"),
    (ENDLESS, "[[[[[[[...]]]]]]]"),
    ({}, "{}"),
    (range(10**30), "range(0, 1000"),
    (object(), "<object"),
    (np.zeros(2, "i4,f4"), "(0, 0."),
]


@each(("value", "part"), NO_NUMBERS)
def test_what_is_no_real_number_is_refused_and_shown(value: Any, part: str) -> None:
    with pytest.raises(NotRealError) as caught:
        real_array(value)
    assert part in caught.value.value
    assert len(str(caught.value)) < 200
    assert str(caught.value).isprintable()


def test_one_number_is_no_array_of_one() -> None:
    assert real_number(np.array(2)) == 2.0
    for value in ([2.0], np.array([2.0]), np.array([[2]])):
        with pytest.raises(NotRealError, match="one real number"):
            real_number(value)


def of_scene(name: str) -> Callable[[Any], Any]:
    return lambda value: scene_with(**{name: value})


def of_sweep(key: str) -> Callable[[Any], Any]:
    return lambda value: vibro.sweep(**{key: value})


#: Everything public that takes numbers, by the name in its message, and the error it raises.
SCENE = scene_with()
CYCLE = vibro.solve(SCENE)
HISTORY = vibro.simulate(SCENE, cycles=1)
SWEEP = vibro.sweep(
    amplitude_mm=[1, 1.2, 1.4], frequency_hz=[15, 16], drive_angle_deg=[20, 25], static_friction=0.7,
    kinetic_friction=0.5, output="regimes",
)  # fmt: skip
TAKERS: dict[str, tuple[Callable[[Any], Any], type[VibroError]]] = {
    **{name: (of_scene(name), SceneError) for name in Line._fields},
    "length": (lambda value: vibro.arrival_time(SCENE, value), SceneError),
    "length ": (lambda value: CYCLE.traverse_time(value), SceneError),
    "cycles": (lambda value: vibro.simulate(SCENE, cycles=value), SceneError),
    "duration": (lambda value: vibro.simulate(SCENE, duration=value), SceneError),
    "length  ": (lambda value: vibro.simulate(SCENE, length=value), SceneError),
    "start_phase": (lambda value: vibro.simulate(SCENE, cycles=1, start_phase=value), SceneError),
    "start_velocity": (lambda value: vibro.simulate(SCENE, cycles=1, start_velocity=value), SceneError),
    "time": (HISTORY.sample, VibroError),
    "drive_angle_deg": (lambda value: SWEEP.draw("regime", at={"alpha": value}), InputError),
    **{quantity.column: (of_sweep(quantity.column), InputError) for quantity in QUANTITIES.values()},
}


@each("name", TAKERS)
@each(
    "value",
    [
        np.ma.array([1.0, 2.0], mask=[False, True]),
        np.timedelta64(5, "D"),
        10**5000,
        b"1",
        [1.0, np.ma.masked],
        pd.Series([1.0, pd.NA], dtype="Float64"),
        True,
    ],
)
def test_every_function_refuses_what_is_no_number_by_name(name: str, value: Any) -> None:
    take, kind = TAKERS[name]
    with pytest.raises(kind) as caught:
        take(value)
    message = str(caught.value)
    field = name.strip()
    assert field in message or BY_COLUMN[field].label in message
    assert len(message) < 400
    assert message.isprintable()


def test_a_list_may_mix_numbers_with_texts_that_have_units() -> None:
    given: dict[str, Any] = {"frequency_hz": 15, "drive_angle_deg": 20, "static_friction": 0.7}
    for values in (
        [0.1, "200um", np.float64(0.3)],
        np.array([0.1, "200um", 0.3], dtype=object),
        pd.Series([0.1, "200um", Decimal("0.3")], dtype=object),
        np.array(["100um", "200um", "0.3"]),
        pd.Series(["0.1", "0.02cm", "300um"]),
        (Fraction(1, 10), "200um", 0.3),
    ):
        found = vibro.sweep(amplitude_mm=values, kinetic_friction=0.5, output="regimes", **given)
        assert found.axes["amplitude_mm"].tolist() == [0.1, 0.2, 0.3]
