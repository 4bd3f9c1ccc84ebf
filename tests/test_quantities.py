"""Numbers with units: read exactly, converted once, refused by name."""

from __future__ import annotations

import dataclasses
import inspect
import math
import re
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from helpers.cases import each
from hypothesis import example, given
from hypothesis import strategies as st

import vibro
from vibro.axes import axis_of, parse_axis
from vibro.drives import Ellipse, Line, Piecewise
from vibro.errors import InputError
from vibro.quantities import (
    DURATION,
    ELLIPTICAL,
    HARMONIC,
    LEAST_SPEED,
    LINEAR,
    MACHINE,
    MASS,
    QUANTITIES,
    STANDS_FOR,
    Quantity,
    checked_number,
    exact_number,
    find_quantity,
    kinetic_friction,
)
from vibro.records.reading import read_record
from vibro.scene import Scene


@each(
    ("quantity", "text", "expected"),
    [
        (QUANTITIES["amplitude"], "15", 15.0),
        (QUANTITIES["amplitude"], "800\u00b5m", 0.8),
        (QUANTITIES["amplitude"], "800\u03bcm", 0.8),
        (QUANTITIES["amplitude"], " .5 MM ", 0.5),
        (QUANTITIES["amplitude"], "0.05in", 1.27),
        (QUANTITIES["amplitude"], "1e-3m", 1.0),
        (QUANTITIES["frequency"], "900rpm", 15.0),
        (QUANTITIES["frequency"], "0.05kHz", 50.0),
        (QUANTITIES["drive_angle"], "20\u00b0", 20.0),
        (QUANTITIES["drive_angle"], "0.35rad", math.degrees(0.35)),
        (QUANTITIES["gravity"], "9.81 m/s\u00b2", 9.81),
        (QUANTITIES["static_friction"], "-0.74", -0.74),
        (QUANTITIES["amplitude"], "1e-99999999999", 0.0),  # tiny exponents do not explode
        (DURATION, "250ms", 0.25),
        (DURATION, "2h", 7200.0),
        (MASS, "20g", 0.02),
        (MASS, "10lb", 4.5359237),  # the international pound
        (LEAST_SPEED, "6m/min", 100.0),
        (LEAST_SPEED, "20ft/min", 101.6),
        (LEAST_SPEED, "60in/min", 25.4),
    ],
)
def test_a_number_is_read_in_the_default_unit(quantity: Quantity, text: str, expected: float) -> None:
    assert float(exact_number(text, quantity)) == pytest.approx(expected, rel=2e-16)


def test_a_scene_has_the_fields_and_defaults_of_the_description() -> None:
    parameters = inspect.signature(Scene).parameters
    lists = {"along_harmonics", "normal_harmonics"}
    assert tuple(p for p in parameters if p not in lists) == tuple(f.name for f in dataclasses.fields(Scene))
    motions = {*lists, "motion"}
    assert set(parameters) - motions | {*STANDS_FOR, "trough_length", *HARMONIC, *MACHINE} == set(QUANTITIES)
    drives = {*LINEAR, *ELLIPTICAL, *motions, "motion_scale"}
    assert {*Line._fields, *Ellipse._fields, *Piecewise._fields, *motions} == set(parameters)
    for name, parameter in parameters.items():
        default = QUANTITIES[name].default if name in QUANTITIES else None
        if name in {*drives, "normal_acceleration"}:
            assert parameter.default is None
        elif default is None:
            assert parameter.default is inspect.Parameter.empty
        else:
            assert parameter.default == QUANTITIES[name].to_si(default)


@each(
    ("called", "name"),
    [
        ("A", "amplitude"), ("-a", "drive_angle"), ("drive angle", "drive_angle"), ("alpha", "drive_angle"),
        ("--mu-ratio", "friction_ratio"), ("MU_D", "kinetic_friction"), (" f ", "frequency"),
        ("L", "trough_length"), ("speed", None), ("a", None), ("l", None), ("", None),
    ],
)  # fmt: skip
def test_a_quantity_is_found_by_any_of_its_names(called: str, name: str | None) -> None:
    found = find_quantity(called)
    assert (found and found.name) == name


@given(st.integers(1, 9999), st.integers(1, 9999))
@example(343, 3433)
def test_kinetic_friction_is_spelled_as_a_person_would(ratio: int, static: int) -> None:
    spelled = float(Fraction(ratio, 10_000) * Fraction(static, 1000))
    product = (ratio / 10_000) * (static / 1000)
    # roundings of both factors and of the product may add up to two units in the last place
    is_near = abs(spelled - product) <= np.spacing(product)
    assert kinetic_friction(ratio / 10_000, static / 1000) == (spelled if is_near else product)


@given(st.floats(0.0, 1.0), st.floats(0.0, 1e6))
def test_kinetic_friction_is_a_rounding_of_the_product_at_most_static(ratio: float, static: float) -> None:
    found = kinetic_friction(ratio, static)
    assert abs(found - ratio * static) <= np.spacing(ratio * static)
    assert found <= static
    assert kinetic_friction(1.0, static) == static


def test_a_swept_ratio_may_exceed_1() -> None:
    ratio = QUANTITIES["friction_ratio"]
    assert [bool(q.allows(1.5)) for q in (ratio, ratio.swept)] == [False, True]
    assert not ratio.swept.allows(-0.1)
    assert QUANTITIES["amplitude"].swept is QUANTITIES["amplitude"]


@each("digits", ["\u0661\u0662", "\uff11\uff12", "\u0967", "1\u0660", "1e\u0662", "1_0", "\u00b2"])
def test_the_digits_of_numbers_are_ascii(digits: str, tmp_path: Path) -> None:
    """Everywhere: in options, in texts of files, along axes, in cells of records."""
    for read in (exact_number, checked_number, parse_axis, axis_of):
        with pytest.raises(InputError):
            read(digits, QUANTITIES["amplitude"])
    for axis in (f"1:{digits}9", f"1:9:{digits}", f"1,2{digits}", f"1:9:step={digits}"):
        with pytest.raises(InputError):
            parse_axis(axis, QUANTITIES["amplitude"])
    record = tmp_path / "record.csv"
    record.write_text(f"t [s];X [mm]\n0;2\n1;{digits}\n2;2\n", encoding="utf-8")
    with pytest.raises(InputError, match="row 3"):
        read_record(record)


def test_no_pattern_of_numbers_takes_other_digits() -> None:
    r"""In Python ``\d`` is any of 700 digits; it may stand where digits are excluded alone."""
    sources = Path(vibro.__file__).parent.rglob("*.py")
    lines = [line for source in sources for line in source.read_text(encoding="utf-8").splitlines()]
    assert not [line for line in lines if r"\d" in re.sub(r"\\delta|\\W_?\\d", "", line)]


@each("quantity", QUANTITIES.values())
def test_a_range_ends_where_it_says_and_squares_within_it_are_doubles(quantity: Quantity) -> None:
    """But of what may be 0: next to it all counts as 0."""
    allowed = quantity.allowed
    for end, belongs, outward in (
        (allowed.low, allowed.with_low, -math.inf),
        (allowed.high, allowed.with_high, math.inf),
    ):
        at = quantity.to_si(end)
        assert end == 0.0 or 0.0 < at**2 < math.inf
        assert bool(quantity.allows(at)) is belongs
        assert not quantity.allows(math.nextafter(at, outward))
        assert at == 0.0 or quantity.allows(math.nextafter(at, -outward))
    for beyond in (math.nan, 1e155, *([1e-320] if allowed.low > 0.0 else [])):
        assert not quantity.allows(quantity.to_si(beyond))
