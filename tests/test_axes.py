"""The axis syntax: what it accepts, exactly which values it gives, and what it refuses."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from helpers.cases import each

from vibro.axes import MAX_VALUES, axis_of, default_count, parse_axis
from vibro.errors import InputError
from vibro.quantities import QUANTITIES


def values_of(text: str, name: str = "amplitude", count: int = 5) -> list[float]:
    return list(map(float, parse_axis(text, QUANTITIES[name]).axis(count).values))


@each(
    ("text", "expected"),
    [
        ("15", [15.0]),
        ("15,20,25", [15.0, 20.0, 25.0]),
        ("0.0,74", [0.0, 74.0]),
        ("3.97, 4.01", [3.97, 4.01]),
        ("0.1:0.5", [0.1, 0.2, 0.3, 0.4, 0.5]),
        ("0.1:0.4:4", [0.1, 0.2, 0.3, 0.4]),
        ("0.1:0.4:4.0", [0.1, 0.2, 0.3, 0.4]),
        ("0.1:0.45:step=0.1", [0.1, 0.2, 0.3, 0.4]),
        ("0.1:0.4:step=0.1", [0.1, 0.2, 0.3, 0.4]),
        ("1:1000:4:log", [1.0, 10.0, 100.0, 1000.0]),
        ("1:10000:log", [1.0, 10.0, 100.0, 1000.0, 10000.0]),
        ("5:80:step=2:log", [5.0, 10.0, 20.0, 40.0, 80.0]),
        ("5:79:step=2:LOG", [5.0, 10.0, 20.0, 40.0]),
        ("800um:1.2mm:3", [0.8, 1.0, 1.2]),
        ("0.5:1mm:step=250um", [0.5, 0.75, 1.0]),
        ("-5:5:3", [-5.0, 0.0, 5.0]),
    ],
)
def test_values_are_the_nearest_doubles(text: str, expected: list[float]) -> None:
    assert values_of(text) == expected


def test_a_fine_range_accumulates_no_error() -> None:
    assert values_of("0.001:10:10000") == [i / 1000 for i in range(1, 10001)]


@each(
    ("text", "name", "problem", "hint"),
    [
        ("3:0.1", "amplitude", "does not ascend", "write 0.1:3, or 0.1:3:step=d for a step of d"),
        ("1:1", "amplitude", "does not ascend", "write 1 for one value"),
        ("0.1:0.05:3", "amplitude", "does not ascend", "for start:step:stop write 0.1:3:step=0.05"),
        ("60:5:20", "frequency", "does not ascend", "write 5:60, or 5:60:step=d for a step of d"),
        ("0.1:1:2.5", "amplitude", "count '2.5' is not a whole", "for start:step:stop write 0.1:2.5:step=1"),
        ("0.1:3:0.5", "amplitude", "count '0.5' is not a whole", "write 0.1:3:step=0.5"),
        ("0.1:3:x", "amplitude", "count 'x' is not a whole", "write lo:hi:count, or lo:hi:step=d"),
        ("300:900rpm", "frequency", "does not ascend", "a number without a unit is in Hz"),
        ("0,74", "static_friction", "a decimal comma", "write 0.74; for the two values write 0.0,74"),
        ("0,20\u00b0", "drive_angle", "a decimal comma", "write 0.20\u00b0"),
        ("1,,2", "amplitude", "a list with an empty item", "write a list like 15,20,25"),
        ("1,2,", "amplitude", "a list with an empty item", "write a list like 15,20,25"),
        ("3,1,3", "amplitude", "must ascend and differ", "write 1,3"),
        ("12,5", "amplitude", "must ascend and differ", "write 5,12, or 12.5 if that is meant"),
        ("1,1.00000000000000000001", "amplitude", "must ascend and differ", "write 1"),
        ("1:2:1", "amplitude", "a range has at least 2 values", "write 1"),
        ("1:2:-5", "amplitude", "a range has at least 2 values", "write 1"),
        ("1::3", "amplitude", "not a range", "write lo:hi, lo:hi:count or lo:hi:step=d"),
        ("1:2:3:4", "amplitude", "not a range", "write lo:hi, lo:hi:count or lo:hi:step=d"),
        ("1:log", "amplitude", "not a number", "write it like 1.5mm"),
        ("0:3:log", "amplitude", "must start above 0", ""),
        ("1:2:step=0", "amplitude", "the step must be above 0", ""),
        ("1:2:step=-1", "amplitude", "the step must be above 0", ""),
        ("1:2:step=5", "amplitude", "the step is longer than the range", ""),
        ("1:2:step=1:log", "amplitude", "a factor above 1", ""),
        ("1:2:step=3:log", "amplitude", "the step is longer than the range", ""),
        ("1:2:step=x", "amplitude", "not a number", "write it like 1.5mm"),
        ("1:nan", "amplitude", "must be a finite number", ""),
        ("1:2:1e9", "amplitude", f"more than {MAX_VALUES} values", "ask for fewer values"),
        ("1:2:step=1e-300", "amplitude", f"more than {MAX_VALUES} values", "ask for fewer values"),
        ("1:2:step=1.0000000001:log", "amplitude", f"more than {MAX_VALUES} values", "ask for fewer values"),
        ("1:2:1" + 400 * "0", "amplitude", "is not a whole number", "write lo:hi:count"),
        ("1:2mm:5", "frequency", "'mm' is no unit of frequency", "its units are Hz, kHz, rpm, U/min"),
    ],
)
def test_a_wrong_axis_names_the_remedy(text: str, name: str, problem: str, hint: str) -> None:
    with pytest.raises(InputError) as caught:
        parse_axis(text, QUANTITIES[name])
    assert problem in str(caught.value)
    assert caught.value.hint.startswith(hint)
    assert bool(caught.value.hint) == bool(hint)


@each(
    ("text", "write"),
    [
        ("5..60", "5:60"),
        ("5...60", "5:60"),
        ("5\u202660", "5:60"),
        ("5-60", "5:60"),
        ("5 \u2013 60", "5:60"),
        ("5 to 60", "5:60"),
        (" 5to60 ", "5:60"),
        ("60-5", "5:60"),
        (".5..3", ".5:3"),
        ("0.1-1e1", "0.1:1e1"),
        ("5;60", "5:60, for two values 5,60"),
        ("-5..5", "-5:5"),
        ("0.5..6cm", "0.5cm:6cm"),
        ("5mm to 6cm", "5mm:6cm"),
        ("8mm to 6", "6:8mm"),
        ("100\u00b5m-2mm", "100\u00b5m:2mm"),
    ],
)
def test_a_range_in_another_spelling_is_hinted_in_ours(text: str, write: str) -> None:
    with pytest.raises(InputError) as caught:
        parse_axis(text, QUANTITIES["amplitude"])
    assert caught.value.hint == f"for a range write {write}"
    assert len(parse_axis(write.split(",")[0], QUANTITIES["amplitude"]).axis(3)) == 3


@each("text", ["5..", "..5", "5--", "1/2", "5..60Hz", "5 bis", "to", "5 60", "5..60" + 40 * "0"])
def test_what_is_no_range_is_not_hinted_to_be_one(text: str) -> None:
    with pytest.raises(InputError) as caught:
        parse_axis(text, QUANTITIES["amplitude"])
    assert "range" not in caught.value.hint


@each(
    ("text", "count"),
    [
        ("1:2:2", 2),
        ("1:2:step=1", 2),
        ("1:2:step=2:log", 2),
        (f"1:2:{MAX_VALUES}", MAX_VALUES),
        (f"1:2:{MAX_VALUES}:log", MAX_VALUES),
        (f"0:{MAX_VALUES - 1}:step=1", MAX_VALUES),
    ],
)
def test_the_fewest_and_the_most_values_of_a_range_are_allowed(text: str, count: int) -> None:
    assert parse_axis(text, QUANTITIES["amplitude"]).count == count


@each(
    ("text", "problem"),
    [
        ("1:2:1", "a range has at least 2 values"),
        ("1:2:step=1.000001", "the step is longer than the range"),
        ("1:2:step=2.000001:log", "the step is longer than the range"),
        (f"1:2:{MAX_VALUES + 1}", f"more than {MAX_VALUES} values"),
        (f"1:2:{MAX_VALUES + 1}:log", f"more than {MAX_VALUES} values"),
        (f"0:{MAX_VALUES}:step=1", f"more than {MAX_VALUES} values"),
    ],
)
def test_one_value_fewer_or_more_is_refused(text: str, problem: str) -> None:
    with pytest.raises(InputError, match=problem):
        parse_axis(text, QUANTITIES["amplitude"])


@each(
    ("text", "hint"),
    [
        # start:step:stop, where one step just reaches the stop, or just does not
        ("1:1:2", "for start:step:stop write 1:2:step=1"),
        ("1:1:1.9", "write 1 for one value"),
        ("1:1:0", "write 1 for one value"),
        # lo:hi:step, where one step just reaches the end
        ("0.25:1.75:1.5", "write 0.25:1.75:step=1.5"),
    ],
)
def test_hints_about_the_order_of_a_range_hold_at_their_limits(text: str, hint: str) -> None:
    with pytest.raises(InputError) as caught:
        parse_axis(text, QUANTITIES["amplitude"])
    assert caught.value.hint == hint


def test_a_step_of_0_is_never_advised() -> None:
    with pytest.raises(InputError) as caught:
        parse_axis("-1:0:1.5", QUANTITIES["amplitude"])
    assert "step=0" not in caught.value.hint


@each(
    ("text", "name", "echo"),
    [
        ("0.1:3:200", "amplitude", "amplitude: 200 values, 0.1 ... 3 mm, step 0.0146"),
        ("5:80:5:log", "frequency", "frequency: 5 values, 5 ... 80 Hz, factor 2"),
        ("10,20,30", "drive_angle", "drive angle: 3 values, 10, 20, 30 deg"),
        (
            ",".join(map(str, range(1, 12))),
            "drive_angle",
            "drive angle: 11 values, 1, 2, 3, 4, 5, 6, 7, 8, ... deg",
        ),
        ("0.2:1:81", "static_friction", "static friction: 81 values, 0.2 ... 1, step 0.01"),
    ],
)
def test_an_axis_says_what_was_understood(text: str, name: str, echo: str) -> None:
    assert str(parse_axis(text, QUANTITIES[name]).axis(7)) == echo


@pytest.mark.parametrize("text", ["1:1.0000000000000001:3", "0.1:0.10000000000000001:log"])
def test_values_that_doubles_cannot_tell_apart_are_refused(text: str) -> None:
    spec = parse_axis(text, QUANTITIES["amplitude"])
    with pytest.raises(InputError, match="too close for doubles"):
        spec.axis(5)


@each("text", ["1e-300:1e300:7:log", "1e-300:1e300:step=10:log", "-1e308:1e308:5", "1e-320:1e-310:3"])
def test_extreme_ranges_are_spelled_out(text: str) -> None:
    values = values_of(text)
    assert values[0] == float(text.split(":")[0])
    assert values[-1] == pytest.approx(float(text.split(":")[1]), rel=1e-14)
    assert values == sorted(set(values))


def test_counts_left_open_depend_on_the_number_of_axes() -> None:
    assert [default_count(n) for n in (1, 2, 3, 4)] == [200, 100, 20, 20]


def test_an_axis_knows_its_words_and_column() -> None:
    axis = parse_axis("0.1:3", QUANTITIES["amplitude"]).axis(3)
    assert (axis.name, axis.label, axis.unit, axis.column) == ("amplitude", "amplitude", "mm", "amplitude_mm")
    assert len(axis) == 3


@each(
    ("value", "expected"),
    [
        ([1, 2, 3], [1.0, 2.0, 3.0]),
        ([0.1, 0.2, 0.30000000000000004], [0.1, 0.2, 0.30000000000000004]),
        ([1, 1.5, "2mm", "0.3cm"], [1.0, 1.5, 2.0, 3.0]),
        (["800um", "900um"], [0.8, 0.9]),
        ([2**53 + 1, 2**70], [2.0**53, 2.0**70]),
        (0.1, [0.1]),
        ([5], [5.0]),
    ],
)
def test_a_list_holds_the_nearest_doubles(value: object, expected: list[float]) -> None:
    spec = axis_of(value, QUANTITIES["amplitude"])
    assert spec.axis(5).values.tolist() == expected
    assert spec.halved(QUANTITIES["amplitude"]).axis(5).values.tolist() == [v / 2 for v in expected]


@each(
    ("value", "problem"),
    [
        ([1.0, math.nan], "amplitude = nan: must be a finite number"),
        ([1.0, math.inf], "amplitude = inf: must be a finite number"),
        ([1.0, "nan"], "amplitude = nan: must be a finite number"),
        (1e400, "amplitude = inf: must be a finite number"),
        ([2.0, 1.0], "amplitude = [2.0, 1.0]: the values of a list must ascend and differ"),
        ([1, 1.0], "amplitude = [1, 1.0]: the values of a list must ascend and differ"),
        ([-0.0, 0.0], "must ascend and differ"),
        ([0.1, "100um"], "must ascend and differ"),
        ([-1e308, -1e309, 1e308], "amplitude = -inf"),
        ([1, True], "amplitude_mm = True: must be a number or an axis"),
        ([1, [2]], "must be a number or an axis"),
        ([[1, 2]], "must be a number or an axis"),
        (10**400, "amplitude_mm = a whole number of about 401 digits: must be finite"),
        ([1, 10**5000], "amplitude_mm = a whole number of about 5001 digits: must be finite"),
        (["1x"], "'1x': 'x' is no unit of amplitude"),
        (["0.1:3"], "not a number"),
    ],
)
def test_a_wrong_list_names_its_value(value: object, problem: str) -> None:
    with pytest.raises(InputError) as caught:
        axis_of(value, QUANTITIES["amplitude"])
    assert problem in str(caught.value)


def test_a_long_list_is_cut_in_messages_and_hints() -> None:
    falling: list[Any] = [list(range(100_000, 0, -1)), ",".join(map(str, range(100_000, 0, -1)))]
    for value in falling:
        with pytest.raises(InputError, match="must ascend and differ") as caught:
            axis_of(value, QUANTITIES["amplitude"])
        assert len(str(caught.value)) < 200
        assert caught.value.hint == "sort its values, and give each once"


def test_a_list_has_no_more_values_than_a_range(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(InputError, match="more than 10000000 values on one axis"):
        axis_of(range(10**30), QUANTITIES["amplitude"])
    monkeypatch.setattr("vibro.axes.MAX_VALUES", 3)
    four: list[Any] = [[1, 2, 3, 4], np.arange(1.0, 5.0), range(1, 5), "1,2,3,4", ["1", 2, 3, 4]]
    for value in four:
        with pytest.raises(InputError, match="more than 3 values on one axis"):
            axis_of(value, QUANTITIES["amplitude"])
    assert len(axis_of([1, 2, 3], QUANTITIES["amplitude"]).values) == 3


def test_numbers_of_a_list_are_not_read_as_texts(monkeypatch: pytest.MonkeyPatch) -> None:
    """Exact fractions take a hundred times as long: a list of a million numbers took a minute."""

    def read(*_: object) -> float:
        raise AssertionError

    monkeypatch.setattr("vibro.axes.exact_number", read)
    monkeypatch.setattr("vibro.axes.nearest_double", read)
    assert len(axis_of([i / 7 for i in range(1, 1000)], QUANTITIES["amplitude"]).values) == 999
    assert len(axis_of(list(range(1, 1000)), QUANTITIES["amplitude"]).values) == 999
    monkeypatch.undo()
    monkeypatch.setattr("vibro.quantities.Fraction", read)
    assert axis_of(["800um", "0.9"], QUANTITIES["amplitude"]).values == (0.8, 0.9)


DIGITS = {
    "400 digits": "9" * 400,
    "5000 digits": "9" * 5000,
    "a long fraction": "0." + "3" * 5000,
    "a long exponent": "1e" + "9" * 5000,
}


@each("digits", DIGITS.values())
@each("form", ["{}", "{}mm", "1,{}", "{0}:{0}", "1:{}", "{}:1", "1:2:{}", "1:2:step={}"])
@each("end", ["", ":log", "x"])
def test_thousands_of_digits_are_refused_in_a_line(digits: str, form: str, end: str) -> None:
    with pytest.raises(InputError) as caught:
        parse_axis(form.format(digits) + end, QUANTITIES["amplitude"]).axis(3)
    (problem,) = caught.value.problems
    assert problem.startswith(("amplitude = ", "step of a logarithmic range = "))
    assert len(problem) < 250
    assert len(caught.value.hint) < 200


def test_a_decimal_of_hundreds_of_digits_is_a_number() -> None:
    third = "0." + "3" * 400
    assert parse_axis(third, QUANTITIES["amplitude"]).value == 1 / 3
    assert values_of(f"{third}:1:3") == [1 / 3, 2 / 3, 1.0]
    assert values_of(f"{third}um,{third}") == [1 / 3000, 1 / 3]


def test_the_ends_of_a_geometric_range_are_as_given() -> None:
    text = "0.12345678901234567:1.7976931348623157e308:5:log"
    assert values_of(text)[0] == 0.12345678901234567
    assert values_of(text)[-1] == 1.7976931348623157e308


@each(
    ("text", "problem"),
    [
        ("1:2:step=1.0000000000000000000001:log", "a factor above 1"),
        ("5e-324um:1:log", "must start above 0"),
        ("1:2:step=5e-324um", "the step must be above 0"),
    ],
)
def test_what_no_double_holds_is_refused(text: str, problem: str) -> None:
    with pytest.raises(InputError, match=problem):
        parse_axis(text, QUANTITIES["amplitude"])


def test_the_widest_axis_is_echoed() -> None:
    assert str(parse_axis("5e-324:1e308:3:log", QUANTITIES["amplitude"]).axis(3)).endswith("factor inf")


@each("given", [-0.0, [-0.0, 1.0], np.array([-0.0, 1.0]), "-0.0", "-0.0,1", "-0:1:2"])
def test_zero_has_no_sign(given: object) -> None:
    spec = axis_of(given, QUANTITIES["trough_angle"])
    assert str(float(spec.values[0])) == "0.0"
    assert str(spec.axis(2).values[0] if spec.varies else spec.value) == "0.0"
