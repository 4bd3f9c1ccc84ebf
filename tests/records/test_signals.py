"""Units of signals, however programs spell them, and what voltages of sensors stand for."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from helpers.cases import each

from vibro.errors import InputError
from vibro.records.reading import Record, read_record
from vibro.records.signals import doubt, read_sensitivities, rounded, signal_unit


@each(
    ("text", "kind", "size"),
    [
        ("s", "time", 1.0),
        ("sec", "time", 1.0),
        ("ms", "time", 1e-3),
        ("us", "time", 1e-6),
        ("\u00b5s", "time", 1e-6),
        ("min", "time", 60.0),
        ("m", "displacement", 1.0),
        ("cm", "displacement", 1e-2),
        ("mm", "displacement", 1e-3),
        ("um", "displacement", 1e-6),
        ("\u03bcm", "displacement", 1e-6),
        ("MM", "displacement", 1e-3),
        ("in", "displacement", 0.0254),
        ("mm/sec", "velocity", 1e-3),
        ("mm_s", "velocity", 1e-3),
        ("m/s", "velocity", 1.0),
        ("mm/sec**2", "acceleration", 1e-3),
        ("mm/s\u00b2", "acceleration", 1e-3),
        ("m_s2", "acceleration", 1.0),
        ("g", "acceleration", 9.80665),
        ("newton", "force", 1.0),
        ("N", "force", 1.0),
        ("mN", "force", 1e-3),
        ("kN", "force", 1e3),
        ("mV", "voltage", 1e-3),
        ("V", "voltage", 1.0),
        ("Volt", "voltage", 1.0),
    ],
)
def test_spellings_of_units(text: str, kind: str, size: float) -> None:
    assert signal_unit(text) == (kind, size)


@each("text", ["", "deg", "1/s", "furlong", "v"])
def test_what_is_no_unit(text: str) -> None:
    assert signal_unit(text) is None


# --- voltages ----------------------------------------------------------------------------------------


def volts(folder: Path, content: list[str], *texts: str, **columns: str) -> Record:
    path = folder / "data.csv"
    path.write_text("\n".join(content) + "\n", encoding="utf-8")
    return read_record(path, columns, read_sensitivities(texts))


@each(
    ("role", "sensitivity", "expected"),
    [
        ("acceleration", "100mV/g", 9.80665),
        ("acceleration", "-100 mV/g", -9.80665),
        ("acceleration", "10.2mV/(m/s²)", 1 / 0.102),
        ("acceleration", "0.1 V per m/s^2", 1.0),
        ("acceleration", "1e2mV/m/s2", 1.0),
        ("velocity", "20mV/mm/s", 5e-3),
        ("velocity", "125mm/s/V", 12.5e-3),
        ("velocity", "125 (mm/s)/V", 12.5e-3),
        ("displacement", "2V/mm", 5e-5),
        ("displacement", "50 µm/mV", 5e-3),
        ("displacement", "-0.5mm/V", -5e-5),
        ("friction", "50mV/N", 2.0),
        ("trough_along", "100mV/g", 9.80665),
        ("trough_along", "trough-along=0.2V/g", 4.903325),
        ("trough_along", "trough-along=2V/mm", 5e-5),
    ],
)
def test_voltages_have_the_size_that_their_sensitivity_says(
    tmp_path: Path, role: str, sensitivity: str, expected: float
) -> None:
    content = ["t [s],x [mm],u [mV]", "0,1,100", "1,2,-200", "2,3,300"]
    columns = {"displacement": "x"} | {role: "u [mV]"}
    record = volts(tmp_path, content, sensitivity, **columns)
    np.testing.assert_allclose(
        {**record.signals, **record.trough}[role], np.array([1.0, -2.0, 3.0]) * expected
    )
    assert f"{role.replace('_', ' ')}: column 'u [mV]' at {sensitivity}" in record.notes


def test_each_voltage_has_its_own_sensitivity(tmp_path: Path) -> None:
    content = ["t [s],a [V],b [mV],c [mV],v [V]", "0,1,100,100,1", "1,2,200,200,2", "2,3,300,300,3"]
    record = volts(
        tmp_path, content, "100mV/g", "trough-normal=-200mV/g", "2m/s/V",
        acceleration="a", trough_along="b", trough_normal="c", velocity="v",
    )  # fmt: skip
    assert record.signals["acceleration"][0] == pytest.approx(98.0665)
    assert record.trough["trough_along"][0] == pytest.approx(9.80665)
    assert record.trough["trough_normal"][0] == pytest.approx(-4.903325)
    assert record.signals["velocity"][0] == 2.0


@each(
    ("texts", "columns", "said", "hint"),
    [
        ([], {"acceleration": "u"}, "'u [mV]' for acceleration=: the sensitivity", 'sensitivity="100mV/g"'),
        (["2V/mm"], {"acceleration": "u"}, "one of acceleration is needed", 'sensitivity="100mV/g"'),
        ([], {"velocity": "u"}, "the sensitivity of its sensor is missing", 'sensitivity="20mV/mm/s"'),
        (["100mV/g"], {}, "no column that is read as acceleration is a voltage", 'acceleration="u [mV]"'),
        (["100mV/g"], {"displacement": "x"}, "is read as acceleration", 'acceleration="u [mV]"'),
        (["100mV/g", "2V/mm"], {"acceleration": "u"}, "is read as displacement", "leave it out"),
        (["trough-along=100mV/g"], {}, "no column that is read as trough along", 'trough_along="u [mV]"'),
        ([], {"time": "u"}, "'mV' is no unit of time", "s, ms"),
        (["0mV/g"], {"acceleration": "u"}, '0mV/g": must be finite and not 0', "100mV/g"),
        (["nan mV/g"], {"acceleration": "u"}, "must be finite and not 0", "100mV/g"),
        (["-inf mV/g"], {"acceleration": "u"}, "must be finite and not 0", "100mV/g"),
        (["1e999mV/g"], {"acceleration": "u"}, "must be finite and not 0", "100mV/g"),
        (["1e-300mV/g"], {"acceleration": "u"}, "beyond any sensor", ""),
        (["10,2mV/g"], {"acceleration": "u"}, "not a number with a unit", "a decimal point: 10.2mV/g"),
        (["100"], {"acceleration": "u"}, "not a number with a unit", "100mV/g"),
        (["100mV"], {"acceleration": "u"}, "'mV' is no unit of a sensitivity", "100mV/g"),
        (["100mV/s"], {"acceleration": "u"}, "'mV/s' is no unit of a sensitivity", "100mV/g"),
        (["10pC/g"], {"acceleration": "u"}, "'pC/g' is no unit of a sensitivity", "100mV/g"),
        (["100mV/g", "50mV/g"], {"acceleration": "u"}, "each is for an acceleration", "trough-along=100mV/g"),
        (["trough=100mV/g"], {"acceleration": "u"}, "'trough' is no signal", "trough-normal"),
        (["velocity=1mV/g"], {"velocity": "u"}, "'mV/g' is no sensitivity of a velocity", "20mV/mm/s"),
        (["9" * 9999 + "mV/g"], {"acceleration": "u"}, "must be finite", ""),
        (["1" * 50000], {"acceleration": "u"}, "not a number with a unit", ""),
    ],
)  # fmt: skip
def test_wrong_sensitivities_are_told_with_what_would_do(
    tmp_path: Path, texts: list[str], columns: dict[str, str], said: str, hint: str
) -> None:
    content = ["t [s],x [mm],u [mV]", "0,1,100", "1,2,200", "2,3,300"]
    with pytest.raises(InputError) as caught:
        volts(tmp_path, content, *texts, **columns)
    assert said in str(caught.value)
    assert hint in caught.value.hint
    assert len(str(caught.value)) < len(str(tmp_path)) + 300


def test_a_voltage_alone_is_pointed_at(tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        volts(tmp_path, ["Zeit in s;Beschleunigung [mV]", "0;1", "1;2"])
    assert caught.value.hint.endswith(': acceleration="Beschleunigung [mV]" sensitivity="100mV/g"')


def test_a_sensitivity_of_another_kind_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        volts(tmp_path, ["t [s],LDV [mV]", "0,1", "1,2", "2,3"], "4mV/mm", velocity="LDV")
    assert 'sensitivity="4mV/mm" is a sensitivity of displacement, one of velocity is needed' in str(
        caught.value
    )
    assert caught.value.hint == 'give the sensor\'s sensitivity: sensitivity="20mV/mm/s"'


@pytest.mark.parametrize("other", ["trough-normal=98mV/g", "acceleration=1V/g"])
def test_a_sensitivity_of_a_column_that_is_not_named_is_told_as_such(tmp_path: Path, other: str) -> None:
    with pytest.raises(InputError) as caught:
        volts(tmp_path, ["t [s],u [mV]", "0,1", "1,2", "2,3"], other, trough_along="u")
    role = other.partition("=")[0].replace("-", "_")
    said = f'for trough_along=: sensitivity="{other}" is for {role}=, for which no column is named'
    assert said in str(caught.value)
    assert caught.value.hint == (
        f'name that column too: {role}="HEADER", and give this sensor\'s sensitivity:'
        ' sensitivity="trough-along=100mV/g"'
    )


@each(
    ("text", "kind", "size"),
    [
        ("seconds", "time", 1.0),
        ("second", "time", 1.0),
        ("cm/s", "velocity", 1e-2),
        ("in/s", "velocity", 0.0254),
        ("in_s", "velocity", 0.0254),
        ("um_s", "velocity", 1e-6),
        ("in_s2", "acceleration", 0.0254),
        ("cm/s^2", "acceleration", 1e-2),
        ("in/s²", "acceleration", 0.0254),
        ("m/second**2", "acceleration", 1.0),
        ("newtons", "force", 1.0),
        ("volts", "voltage", 1.0),
    ],
)
def test_more_spellings_of_units(text: str, kind: str, size: float) -> None:
    found = signal_unit(text)
    assert found is not None
    assert found[0] == kind
    assert found[1] == pytest.approx(size, rel=1e-15)


@each(
    ("ratio", "text"),
    [(1234.0, "1200"), (0.01256, "0.013"), (9.96, "10"), (1e5, "100000"), (7.04, "7"), (-12.4, "-12")],
)
def test_a_ratio_is_written_with_two_digits(ratio: float, text: str) -> None:
    assert rounded(ratio) == text


@each("text", ["1e20m/V", "-1e20m/V", "1e20V/m", "-1e20 V/m"])
def test_sensitivities_reach_to_the_ends_of_what_can_be_computed_with(text: str) -> None:
    (one,) = read_sensitivities([text])
    assert abs(one.per_volt) == pytest.approx(1e20 if text.endswith("m/V") else 1e-20, rel=1e-15)
    beyond = text.replace("1e20", "1.001e20")
    with pytest.raises(InputError, match="in SI units, which is beyond any sensor") as caught:
        read_sensitivities([beyond])
    sign = "-" if text.startswith("-") else ""
    size = "1.001e+20" if text.endswith("m/V") else "9.99001e-21"
    assert f'sensitivity="{beyond}": 1 V would be {sign}{size} in SI units' in str(caught.value)


@each(
    ("text", "role", "kind", "per_volt"),
    [
        ("trough-along=200mV/g", "trough_along", "acceleration", 5.0 * 9.80665),
        (" --Trough-Along = 200 mV per g ", "trough_along", "acceleration", 5.0 * 9.80665),
        ("friction=4V pro N", "friction", "force", 0.25),
        ("50 mV/[mm/s]", "", "velocity", 0.02),
        (".5mm/V", "", "displacement", 5e-4),
        ("+2.V/kN", "", "force", 500.0),
    ],
)
def test_spellings_of_sensitivities(text: str, role: str, kind: str, per_volt: float) -> None:
    (one,) = read_sensitivities([text])
    assert one[:3] == (text.strip(), role, kind)
    assert one.per_volt == pytest.approx(per_volt, rel=1e-12)


@each(
    ("texts", "said", "hint"),
    [
        (
            ["friction=1V/N", "friction=2V/N"],
            'sensitivity="friction=1V/N" and sensitivity="friction=2V/N": each is for friction=',
            'say which column each is for: sensitivity="trough-along=100mV/g"',
        ),
        (
            ["1V/N", "2V/kN"],
            'sensitivity="1V/N" and sensitivity="2V/kN": each is for a force',
            'say which column each is for: sensitivity="trough-along=100mV/g"',
        ),
        (
            ["time=1V/g"],
            "sensitivity=\"time=1V/g\": 'time' is no signal",
            "signals are displacement, velocity, acceleration, friction, trough-along, trough-normal",
        ),
        (
            ["trough-normal=1V/N"],
            "sensitivity=\"trough-normal=1V/N\": 'V/N' is no sensitivity of an acceleration or velocity or"
            " displacement",
            "write it like 100mV/g",
        ),
        (
            ["displacement=5mV/N"],
            "sensitivity=\"displacement=5mV/N\": 'mV/N' is no sensitivity of a displacement",
            "write it like 2V/mm",
        ),
    ],
)
def test_what_is_said_of_wrong_sensitivities(texts: list[str], said: str, hint: str) -> None:
    with pytest.raises(InputError) as caught:
        read_sensitivities(texts)
    assert (str(caught.value), caught.value.hint) == (said, hint)


def test_a_signal_far_off_is_doubted_by_its_sensitivity_or_else_by_its_unit() -> None:
    assert doubt("100mV/g") == "is its sensitivity 100mV/g right?"
    assert doubt("") == "is its unit right?"


@pytest.mark.parametrize(("sensitivity", "most"), [("-1V/m", "1e+20"), ("-0.1V/m", "1e+19")])
def test_a_negative_sensitivity_allows_as_large_a_voltage(
    tmp_path: Path, sensitivity: str, most: str
) -> None:
    with pytest.raises(InputError) as caught:
        volts(tmp_path, ["t [s],u [V]", "0,1", "1,1e21"], sensitivity, displacement="u")
    assert str(caught.value).endswith(f"1e21 is too large to compute with, at most {most} is allowed")
